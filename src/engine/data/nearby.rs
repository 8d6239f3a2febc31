//! What particles may be near that is not made of particles.
use super::shared::Shared;
use std::fmt;
use std::sync::Arc;

type Beside = dyn Fn(&Shared, usize, [f64; 3]) -> bool + Send + Sync;

/// Whether particles of a material, in the block around a middle [m], may be near something that the application knows, by shared
/// labels as they are when a graph begins. Tasks over near particles run there, too. It is the same on all ranks.
#[derive(Clone)]
pub struct Nearby(Arc<Beside>);

impl Nearby {
    /// As a function says.
    pub fn new(beside: impl Fn(&Shared, usize, [f64; 3]) -> bool + Send + Sync + 'static) -> Self {
        Self(Arc::new(beside))
    }

    /// Whether particles of a material in a block may be near.
    pub fn is_beside(&self, shared: &Shared, material: usize, middle: [f64; 3]) -> bool {
        (self.0)(shared, material, middle)
    }
}

impl fmt::Debug for Nearby {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Nearby")
    }
}
