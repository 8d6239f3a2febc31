//! How fast waves can travel: a bound of the acoustic tensor that needs no eigenvalues.
use super::tensor::principal_bounds;
use simd::Simd;

/// What resists a plane wave in the present state, per reference volume [Pa].
///
/// The energy is U(J) + μ/2 (tr b̃ − 3) + F₂(λ̃), with b̃ = J^(−2/3) b and λ̃ = J^(−1/3) λ.
#[derive(Clone, Copy)]
pub struct Stiffness<S> {
    /// κ = J² U″(J); it may be negative.
    pub volumetric: S,
    /// μ
    pub shear: S,
    /// tr b̃ / 3
    pub mean: S,
    /// J₂ = ½ s:s of the deviator s of b̃.
    pub j2: S,
    /// h = λ̃ F₂′(λ̃) ≥ 0, the Kirchhoff fiber stress.
    pub fiber_stress: S,
    /// h′ = λ̃ dh/dλ̃ ≥ 0
    pub fiber_slope: S,
}

impl<S: Simd> Stiffness<S> {
    /// Upper bound of ρ₀ c² over all directions n and polarizations m of a plane wave in the *present*
    /// configuration, the one that the step limit of a spatial grid needs:
    /// ρ₀ c² = d²W/dε² along F → (I + ε m⊗n) F. With s = m·n, p = m·a, q = n·a (a: fiber direction) it is
    ///
    /// - κ s² for the volume, because J → J (1 + ε s) is linear;
    /// - μ (n·b̃n − 4/3 s m·b̃n + 5/9 s² tr b̃) for the matrix. That is
    ///   μ (|b̃^½ (n − ⅔ s m)|² + s² (5/9 tr b̃ − 4/9 m·b̃m)), and |n − ⅔ s m|² = 1 − 8/9 s²: at most
    ///   μ (b₁ + s² (5 tr b̃ − 8 b₁ − 4 b₃)/9) with the principal values b₁ ≥ b₂ ≥ b₃;
    /// - h′ (pq − s/3)² + h (q² − 2p²q² + s²/3) for the fibers, which is
    ///   (h′ − 3h) (pq − s/3)² + h ((s − pq)² + q² − s²/3). Here |pq − s/3| ≤ 2/3, and (s − pq)² ≤
    ///   (1 − p²)(1 − q²), the product of the parts of m and n across a: at most
    ///   4/9 max(h′ − 3h, 0) + h (1 − s²/3).
    ///
    /// What remains is linear in s², so that its maximum is at s² = 0 or 1.
    /// The bound is exact in the undeformed state (κ + 4/3 μ), and never negative.
    #[inline(always)]
    pub fn bound(&self) -> S {
        let Self { volumetric, shear, mean, j2, fiber_stress: h, fiber_slope } = *self;
        let (b3, b1) = principal_bounds(mean, j2);
        let excess = S::splat(5.0 / 3.0).fma(mean, -S::splat(8.0 / 9.0).fma(b1, S::splat(4.0 / 9.0) * b3));
        let longitudinal = S::splat(2.0 / 3.0).fma(h, shear.fma(excess, volumetric));
        let stretching = S::splat(3.0).fnma(h, fiber_slope).max(S::splat(0.0));
        S::splat(4.0 / 9.0).fma(stretching, shear.fma(b1, longitudinal.max(h)))
    }

    /// ρ₀ c² of the longitudinal wave along the fibers, with `along` = a·b̃a: the terms above at m = n = a. Where it is
    /// negative, the material bears less the further it is pulled.
    #[inline(always)]
    pub fn along_fibers(&self, along: S) -> S {
        let Self { volumetric, shear, mean, fiber_stress: h, fiber_slope, .. } = *self;
        let matrix = S::splat(5.0 / 3.0).fma(mean, S::splat(-1.0 / 3.0) * along);
        let fibers = S::splat(4.0 / 9.0).fma(fiber_slope, S::splat(-2.0 / 3.0) * h);
        shear.fma(matrix, volumetric + fibers)
    }
}
