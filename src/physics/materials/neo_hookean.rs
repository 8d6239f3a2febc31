//! Compressible neo-Hookean elasticity.
use crate::acoustic::Stiffness;
use crate::law::{Energies, Events, Kinematics, Law, Reference, Response, Variable, inadmissible};
use crate::parameter::{Described, Dimension, Parameter, Refusal, Values};
use crate::tensor::{deviator_invariants, scaled, times_transpose, trace};
use simd::{Simd, math};

/// W = μ/2 (tr b̃ − 3) + K/2 (½ (J² − 1) − ln J), b̃ = J^(−2/3) F Fᵀ
/// (Simo & Hughes, *Computational Inelasticity*, 1998, section 9.2). [`J2`](super::j2::J2) adds yielding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    /// Bulk modulus K [Pa].
    pub bulk: f64,
    /// Shear modulus μ [Pa].
    pub shear: f64,
}

impl NeoHookean {
    /// Response to an isochoric elastic deformation b̃ and the volume ratio J.
    #[inline(always)]
    pub(super) fn respond<S: Simd>(&self, b: &[S; 6], j: S) -> Response<S> {
        let (mean, j2, _) = deviator_invariants(b);
        let (shear, half) = (S::splat(self.shear), S::splat(0.5 * self.bulk));
        let pressure = half * j.fms(j, S::splat(1.0));
        let normal = |i: usize| shear.fma(b[i] - mean, pressure);
        let kirchhoff = [normal(0), shear * b[1], shear * b[2], normal(3), shear * b[4], normal(5)];
        let volumetric = half * j.fma(j, S::splat(1.0));
        let zero = S::splat(0.0);
        let stiffness = Stiffness { volumetric, shear, mean, j2, fiber_stress: zero, fiber_slope: zero };
        let events = Events { inverted: inadmissible(j), ..Events::default() };
        Response { kirchhoff, modulus: stiffness.bound(), events }
    }

    /// W [J/m³] of b̃ and J.
    #[inline(always)]
    pub(super) fn energy<S: Simd>(&self, b: &[S; 6], j: S) -> S {
        let volumetric = S::splat(0.5).fma(j.fms(j, S::splat(1.0)), -math::ln(j));
        let isochoric = S::splat(0.5 * self.shear) * (trace(b) - S::splat(3.0));
        S::splat(0.5 * self.bulk).fma(volumetric, isochoric)
    }
}

/// b̃ = J^(−2/3) F Fᵀ
#[inline(always)]
fn isochoric<S: Simd>(k: &Kinematics<S>) -> [S; 6] {
    let root = math::inverse_cube_root(k.j);
    scaled(root * root, times_transpose(&k.f))
}

impl Described for NeoHookean {
    const NAME: &'static str = "neo-hookean";
    const SUMMARY: &'static str = "Compressible neo-Hookean elasticity, \
        W = μ/2 (Ĩ₁ − 3) + K/2 (½ (J² − 1) − ln J) (Simo & Hughes 1998, section 9.2)";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::positive("bulk-modulus", Dimension::Stress, "bulk modulus K"),
        Parameter::positive("shear-modulus", Dimension::Stress, "shear modulus μ"),
    ];
    type Built = Self;
    fn build(values: &Values) -> Result<Self, Refusal> {
        Ok(Self { bulk: values.number("bulk-modulus"), shear: values.number("shear-modulus") })
    }
}

impl Law for NeoHookean {
    const HISTORY: &'static [Variable] = &[];

    fn initial(&self, _reference: &Reference, _history: &mut [f64]) {}

    #[inline(always)]
    fn update<S: Simd>(&self, k: &Kinematics<S>, _history: &mut [S]) -> Response<S> {
        self.respond(&isochoric(k), k.j)
    }

    #[inline(always)]
    fn energies<S: Simd>(&self, k: &Kinematics<S>, _history: &[S]) -> Energies<S> {
        let zero = S::splat(0.0);
        Energies { strain: self.energy(&isochoric(k), k.j), plastic: zero, fracture: zero }
    }

    fn moduli(&self) -> (f64, f64) {
        (self.bulk, self.shear)
    }
}
