//! Artificial viscosity, which spreads a shock over a few cells.
use simd::Simd;

/// Pressure of von Neumann & Richtmyer (1950, quadratic) and Landshoff (1955, linear).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viscosity {
    /// c₁ of the linear term, which damps the ringing behind a shock.
    pub linear: f64,
    /// c₂ of the quadratic term, which spreads a strong shock.
    pub quadratic: f64,
}

impl Viscosity {
    /// q = ρ l (c₁ c |tr D| + c₂ l (tr D)²) where tr D < 0, else 0 [Pa]: a pressure to subtract from the
    /// Cauchy stress.
    ///
    /// `density` ρ [kg/m³] and `speed` c [m/s] are those of the present state, `rate` is tr D [1/s],
    /// `length` l [m] is the cell size.
    #[inline(always)]
    pub fn pressure<S: Simd>(&self, density: S, speed: S, rate: S, length: S) -> S {
        let compression = (-rate).max(S::splat(0.0));
        let width = length * compression;
        density * width * S::splat(self.linear).fma(speed, S::splat(self.quadratic) * width)
    }

    /// By what viscosity multiplies the speed that limits the step where matter is compressed: √(1 + ξ²) + ξ, with
    /// ξ = c₁ + 2 c₂ l |tr D|/c the damping of the shortest wave (T. Belytschko et al., *Nonlinear Finite Elements*, 2014, eq. 6.2.13).
    #[inline(always)]
    pub fn hurry<S: Simd>(&self, speed: S, rate: S, length: S) -> S {
        let (zero, one) = (S::splat(0.0), S::splat(1.0));
        let compression = (-rate).max(zero);
        let width = length * compression / speed.max(S::splat(f64::MIN_POSITIVE));
        let xi = S::splat(2.0 * self.quadratic).fma(width, S::splat(self.linear));
        S::select(zero.lt(compression), xi.fma(xi, one).sqrt() + xi, one)
    }
}
