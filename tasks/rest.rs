use crate::labels::{Mass, VelocityGradient};
use engine::graph::task::{At, Body};
use simd::{Simd, Wide};

engine::task! {
    /// No velocity gradient, L_p = 0: before the first step, to evaluate laws in the state that the scene gave.
    pub struct Rest;

    Particles task {
        requires old { mass: Mass }
        computes { gradient: VelocityGradient }
    }
}

impl Body for Rest {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        for (_, l) in io.mass.iter().zip(io.gradient.iter_mut()) {
            *l = [Wide::default(); 9];
        }
    }
}
