//! Contact of two materials at one node: laws, one file each, and their registry.
pub mod bonded;
pub mod friction;
mod held;
mod pair;
pub mod surface;

pub use held::{HeldPair, Seen};
pub use pair::{ContactLaw, Exchange, Pair, Strength, cross, dot};

use super::parameter::Entry;

/// How two materials touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Indices of the two materials, ascending.
    pub between: [usize; 2],
    /// The law.
    pub law: AnyContactLaw,
    /// Contact acts only while the gap between the surfaces is below this many cells.
    pub gap: f64,
}

/// One line a law, which is a word of the scene.
macro_rules! registry {
    ($($variant:ident($law:ty),)*) => {
        /// A contact law chosen by a scene.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[allow(missing_docs)]
        pub enum AnyContactLaw { $($variant($law)),* }

        impl ContactLaw for AnyContactLaw {
            #[inline]
            fn exchange(&self, pair: &Pair) -> Exchange {
                match self { $(AnyContactLaw::$variant(law) => law.exchange(pair)),* }
            }
            #[inline]
            fn exchange_held(&self, pair: &HeldPair) -> Exchange {
                match self { $(AnyContactLaw::$variant(law) => law.exchange_held(pair)),* }
            }
            #[inline]
            fn stiffness(&self, pair: &Pair) -> [[f64; 3]; 3] {
                match self { $(AnyContactLaw::$variant(law) => law.stiffness(pair)),* }
            }
            #[inline]
            fn secant(&self, pair: &Pair) -> [[f64; 3]; 3] {
                match self { $(AnyContactLaw::$variant(law) => law.secant(pair)),* }
            }
            fn asks_traction(&self) -> bool {
                match self { $(AnyContactLaw::$variant(law) => law.asks_traction()),* }
            }
            #[inline]
            fn bond(&self) -> Option<Strength> {
                match self { $(AnyContactLaw::$variant(law) => law.bond()),* }
            }
            #[inline]
            fn broken(&self, pair: &Pair) -> Exchange {
                match self { $(AnyContactLaw::$variant(law) => law.broken(pair)),* }
            }
            #[inline]
            fn broken_held(&self, pair: &HeldPair) -> Exchange {
                match self { $(AnyContactLaw::$variant(law) => law.broken_held(pair)),* }
            }
        }
        $(impl From<$law> for AnyContactLaw {
            fn from(law: $law) -> Self { AnyContactLaw::$variant(law) }
        })*

        /// All contact laws that a scene can name.
        pub const LAWS: &[Entry<AnyContactLaw>] = &[$(Entry::of::<$law>()),*];
    };
}

registry! {
    Friction(friction::Friction),
    Bonded(bonded::Bonded),
}
