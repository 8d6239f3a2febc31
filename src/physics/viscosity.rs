//! Artificial viscosity (first form).
use crate::simd::Simd;

/// c₁, c₂
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viscosity {
    /// c₁
    pub linear: f64,
    /// c₂
    pub quadratic: f64,
}

impl Viscosity {
    /// q = ρ l (c₁ c |tr D| + c₂ l (tr D)²) for tr D < 0, else 0 [Pa]
    #[inline(always)]
    pub fn pressure<S: Simd>(&self, density: S, c: S, rate: S, l: S) -> S {
        let closing = (-rate).max(S::splat(0.0));
        density * l * closing * (c * S::splat(self.linear) + l * closing * S::splat(self.quadratic))
    }
}
