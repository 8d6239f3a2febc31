//! What history and summary report: sums over the particles of a material, in any order the same.
mod law;
mod motion;
mod viscosity;

pub use law::ReportLaw;
pub use motion::ReportMotion;
pub use viscosity::ReportViscosity;

use engine::data::exact_sum::ExactSum;
use simd::Simd;

/// Adds the lanes of each vector, in order, to its exact sum.
#[inline(always)]
fn add_all<S: Simd>(sums: &mut [ExactSum], vectors: impl IntoIterator<Item = S>) {
    for (sum, vector) in sums.iter_mut().zip(vectors) {
        sum.add(vector.lanes().iter().sum());
    }
}
