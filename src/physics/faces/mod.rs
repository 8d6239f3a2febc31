//! Conditions on the faces of the domain, one file each, and their registry.
mod condition;
pub mod fixed;
pub mod free;
pub mod plate;
pub mod symmetric;
pub mod velocity;

pub use condition::{FaceCondition, Image, Wall};

use super::parameter::Entry;

/// One line a condition, which is a word of the scene, or a key of a table if it has parameters.
macro_rules! registry {
    ($($variant:ident($condition:ty),)*) => {
        /// A condition chosen by a scene.
        #[derive(Clone, Debug, PartialEq)]
        #[allow(missing_docs)]
        pub enum AnyFaceCondition { $($variant($condition)),* }

        impl FaceCondition for AnyFaceCondition {
            #[inline]
            fn acts(&self) -> bool {
                match self { $(AnyFaceCondition::$variant(condition) => condition.acts()),* }
            }
            #[inline]
            fn image(&self) -> Option<Image> {
                match self { $(AnyFaceCondition::$variant(condition) => condition.image()),* }
            }
            fn wall(&self) -> Option<Wall> {
                match self { $(AnyFaceCondition::$variant(condition) => condition.wall()),* }
            }
            #[inline]
            fn correction(&self, axis: usize, time: f64, velocity: [f64; 3]) -> [f64; 3] {
                match self {
                    $(AnyFaceCondition::$variant(condition) => condition.correction(axis, time, velocity)),*
                }
            }
        }
        $(impl From<$condition> for AnyFaceCondition {
            fn from(condition: $condition) -> Self { AnyFaceCondition::$variant(condition) }
        })*

        /// All conditions that a scene can name. The first, without parameters, holds where the scene names none.
        pub const CONDITIONS: &[Entry<AnyFaceCondition>] = &[$(Entry::of::<$condition>()),*];
    };
}

registry! {
    Free(free::Free),
    Fixed(fixed::Fixed),
    Symmetric(symmetric::Symmetric),
    Velocity(velocity::Velocity),
    Plate(plate::Plate),
}
