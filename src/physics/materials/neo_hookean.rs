//! Compressible neo-Hookean elasticity.
use crate::physics::law::{Energies, Events, Kinematics, Law, Response, Variable};
use crate::physics::parameter::{Described, Dimension, Parameter, Values};
use crate::physics::tensor::{times_transpose, trace};
use crate::simd::{Simd, math};

/// Placeholder-free first form; see `Described::SUMMARY`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    /// Bulk modulus K [Pa].
    pub bulk: f64,
    /// Shear modulus μ [Pa].
    pub shear: f64,
}

impl Described for NeoHookean {
    const NAME: &'static str = "neo-hookean";
    const SUMMARY: &'static str = "W = μ/2 (Ĩ₁ − 3) + K/2 (½(J² − 1) − ln J) (Simo & Hughes 1998, eq. 9.2.3)";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::positive("bulk-modulus", Dimension::Stress, "K"),
        Parameter::positive("shear-modulus", Dimension::Stress, "μ"),
    ];
    fn build(values: &Values) -> Result<Self, (&'static str, String)> {
        Ok(Self { bulk: values.number("bulk-modulus"), shear: values.number("shear-modulus") })
    }
}

impl Law for NeoHookean {
    const HISTORY: &'static [Variable] = &[];

    fn initial(&self, _fiber: [f64; 3], _history: &mut [f64]) {}

    #[inline(always)]
    fn update<S: Simd>(&self, k: &Kinematics<S>, _history: &mut [S]) -> Response<S> {
        let b = times_transpose(&k.f);
        let scale = math::exp(math::ln(k.j) * S::splat(-2.0 / 3.0)) * S::splat(self.shear);
        let mean = trace(&b) * S::splat(1.0 / 3.0);
        let half = S::splat(0.5 * self.bulk);
        let pressure = half * k.j.fms(k.j, S::splat(1.0));
        let normal = |i: usize| scale.fma(b[i] - mean, pressure);
        let kirchhoff = [normal(0), scale * b[1], scale * b[2], normal(3), scale * b[4], normal(5)];
        let modulus = half * k.j.fma(k.j, S::splat(1.0)) + scale * trace(&b);
        let inverted = !S::splat(0.0).lt(k.j);
        Response { kirchhoff, modulus, events: Events { inverted, ..Events::default() } }
    }

    #[inline(always)]
    fn energies<S: Simd>(&self, k: &Kinematics<S>, _history: &[S]) -> Energies<S> {
        let zero = S::splat(0.0);
        let ln_j = math::ln(k.j);
        let i1 = trace(&times_transpose(&k.f)) * math::exp(ln_j * S::splat(-2.0 / 3.0));
        let volumetric =
            S::splat(0.5).fma(k.j.fms(k.j, S::splat(1.0)), zero - ln_j) * S::splat(0.5 * self.bulk);
        let strain = S::splat(0.5 * self.shear).fma(i1 - S::splat(3.0), volumetric);
        Energies { strain, plastic: zero, fracture: zero }
    }

    fn moduli(&self) -> (f64, f64) {
        (self.bulk, self.shear)
    }
}
