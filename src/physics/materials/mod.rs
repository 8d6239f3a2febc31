//! Constitutive laws, one file each, and their registry.
pub mod j2;
pub mod neo_hookean;
pub mod tissue;

use super::law::{Declared, Law};
use super::parameter::{Described, Entry};

/// Work that is generic over the law: turns the scene's choice into a type, once.
pub trait WithLaw {
    /// What it returns.
    type Output;
    /// The work.
    fn with<L: Law>(self, law: L) -> Self::Output;
}

/// `laws`: one line a type (a variant of [`AnyLaw`]), and whose word chooses it. `described`: one line a word of the scene; its
/// parameters may choose among several of the types.
macro_rules! registry {
    (laws { $($variant:ident($law:ty) by $word:ty,)* } described { $($described:ty,)* }) => {
        /// A law chosen by a scene.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[allow(missing_docs)]
        pub enum AnyLaw { $($variant($law)),* }

        impl AnyLaw {
            /// Runs `work` with the law as a type.
            pub fn visit<W: WithLaw>(&self, work: W) -> W::Output {
                match *self { $(AnyLaw::$variant(law) => work.with(law)),* }
            }
        }
        $(impl From<$law> for AnyLaw {
            fn from(law: $law) -> Self { AnyLaw::$variant(law) }
        })*

        /// What each of the types declares, and the word that chooses it.
        pub const DECLARED: &[(&str, Declared)] = &[$((<$word as Described>::NAME, Declared::by::<$law>())),*];

        /// All laws that a scene can name.
        pub const LAWS: &[Entry<AnyLaw>] = &[$(Entry::of::<$described>()),*];
    };
}

impl AnyLaw {
    /// What the law declares.
    pub fn declared(&self) -> Declared {
        self.visit(DeclaredBy)
    }
}

struct DeclaredBy;
impl WithLaw for DeclaredBy {
    type Output = Declared;
    fn with<L: Law>(self, _law: L) -> Declared {
        Declared::by::<L>()
    }
}

registry! {
    laws {
        NeoHookean(neo_hookean::NeoHookean) by neo_hookean::NeoHookean,
        J2(j2::J2) by j2::J2,
        Tissue(tissue::Tissue<tissue::NoFailure>) by tissue::Family,
        FailingTissue(tissue::Tissue<tissue::TwoSurface>) by tissue::Family,
    }
    described {
        neo_hookean::NeoHookean,
        j2::J2,
        tissue::Family,
    }
}
