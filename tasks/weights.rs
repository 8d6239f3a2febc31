use crate::labels::{Position, Weights as WeightsLabel};
use engine::graph::task::{At, Body};
use shapes::ShapeFunction;
use simd::Simd;

engine::task! {
    /// The weights of the grid nodes around each particle: S_Ip and ∇S_Ip at its present position.
    pub struct Weights<F: ShapeFunction> {
        /// The shape function.
        pub shape: F,
        /// 1/h [1/m]
        pub inverse_cell: f64,
    }

    Particles task {
        requires old { position: Position }
        computes { weights: WeightsLabel }
    }
}

impl<F: ShapeFunction> Body for Weights<F> {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        for (x, stencil) in io.position.iter().zip(io.weights.iter_mut()) {
            stencil.fill::<S, F>(&self.shape, x, &at.origin, self.inverse_cell);
        }
    }
}
