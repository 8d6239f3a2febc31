//! Metal plasticity: neo-Hookean elasticity with a von Mises yield surface.
use super::neo_hookean::NeoHookean;
use crate::law::{Energies, Kinematics, Law, Reference, Response, Variable};
use crate::parameter::{Described, Dimension, Parameter, Refusal, Values};
use crate::tensor::{determinant, deviator_invariants, push_forward, scaled};
use simd::{Simd, math};

/// √(2/3)
const ROOT: f64 = 0.816_496_580_927_726;

/// Multiplicative J₂ plasticity with linear isotropic hardening: yield at ‖dev τ‖ = √(2/3) (σ₀ + H α), return
/// along the deviator (Simo & Hughes, *Computational Inelasticity*, 1998, box 9.1).
///
/// One departure: the box keeps tr b̄ᵉ in the return, so that det b̄ᵉ drifts from 1 and plastic work is
/// booked as elastic energy. Here the trace is the one that makes det b̄ᵉ = 1 again. The stress of the step
/// is the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct J2 {
    /// Elasticity.
    pub elastic: NeoHookean,
    /// Yield stress in tension σ₀ [Pa].
    pub yield_stress: f64,
    /// Hardening modulus H = dσy/dα [Pa].
    pub hardening: f64,
}

impl Described for J2 {
    const NAME: &'static str = "j2";
    const SUMMARY: &'static str = "Neo-Hookean elasticity with a von Mises yield surface \
        and linear isotropic hardening (Simo & Hughes 1998, box 9.1)";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::positive("bulk-modulus", Dimension::Stress, "bulk modulus K"),
        Parameter::positive("shear-modulus", Dimension::Stress, "shear modulus μ"),
        Parameter::positive("yield-stress", Dimension::Stress, "yield stress in tension σ₀"),
        Parameter::at_least(
            "hardening",
            Dimension::Stress,
            0.0,
            Some(0.0),
            "isotropic hardening modulus H: the yield stress is σ₀ + H α",
        ),
    ];
    type Built = Self;
    fn build(values: &Values) -> Result<Self, Refusal> {
        let elastic =
            NeoHookean { bulk: values.number("bulk-modulus"), shear: values.number("shear-modulus") };
        let (yield_stress, hardening) = (values.number("yield-stress"), values.number("hardening"));
        Ok(Self { elastic, yield_stress, hardening })
    }
}

impl Law for J2 {
    const HISTORY: &'static [Variable] = &[
        Variable::new("elastic_xx", "1", "xx of the isochoric elastic left Cauchy-Green tensor"),
        Variable::new("elastic_xy", "1", "xy of the isochoric elastic left Cauchy-Green tensor"),
        Variable::new("elastic_xz", "1", "xz of the isochoric elastic left Cauchy-Green tensor"),
        Variable::new("elastic_yy", "1", "yy of the isochoric elastic left Cauchy-Green tensor"),
        Variable::new("elastic_yz", "1", "yz of the isochoric elastic left Cauchy-Green tensor"),
        Variable::new("elastic_zz", "1", "zz of the isochoric elastic left Cauchy-Green tensor"),
        Variable::new("plastic_strain", "1", "equivalent plastic strain").usual(),
    ];

    fn initial(&self, reference: &Reference, history: &mut [f64]) {
        let j: f64 = reference.stretch.iter().product();
        let [x, y, z] = reference.stretch.map(|stretch| stretch * stretch / j.powf(2.0 / 3.0));
        history.copy_from_slice(&[x, 0.0, 0.0, y, 0.0, z, 0.0]);
    }

    #[inline(always)]
    fn update<S: Simd>(&self, k: &Kinematics<S>, history: &mut [S]) -> Response<S> {
        let root = math::inverse_cube_root(determinant(&k.increment));
        let trial = scaled(root * root, push_forward(&k.increment, &elastic(history)));
        let alpha = history[6];

        // f = ‖s‖ − √(2/3) σy of the trial state; only its positive part flows
        let (mean, j2, j3) = deviator_invariants(&trial);
        let shear = S::splat(self.elastic.shear);
        let norm = shear * (j2 + j2).sqrt();
        let strength = S::splat(ROOT) * S::splat(self.hardening).fma(alpha, S::splat(self.yield_stress));
        let excess = (norm - strength).max(S::splat(0.0));
        let yields = S::splat(0.0).lt(excess);
        let mut b = trial;
        if yields != 0 {
            // f = 2 μ̄ Δγ (1 + H / 3μ̄) with μ̄ = μ tr b̄ᵉ / 3
            let effective = shear * mean;
            let flow = excess / S::splat(2.0).fma(effective, S::splat(2.0 / 3.0 * self.hardening));
            let kept = (norm - (effective + effective) * flow) / norm;
            let kept = S::select(yields, kept, S::splat(1.0));
            let center = unimodular(mean, kept * kept * j2, kept * kept * kept * j3);
            let center = S::select(yields, center, mean);
            for (i, entry) in b.iter_mut().enumerate() {
                let diagonal = i == 0 || i == 3 || i == 5;
                *entry = if diagonal { kept.fma(*entry - mean, center) } else { kept * *entry };
            }
            history[6] = S::splat(ROOT).fma(flow, alpha);
        }
        history[..6].copy_from_slice(&b);
        self.elastic.respond(&b, k.j)
    }

    #[inline(always)]
    fn energies<S: Simd>(&self, k: &Kinematics<S>, history: &[S]) -> Energies<S> {
        let alpha = history[6];
        let mean_strength = S::splat(0.5 * self.hardening).fma(alpha, S::splat(self.yield_stress));
        let strain = self.elastic.energy(&elastic(history), k.j);
        Energies { strain, plastic: mean_strength * alpha, fracture: S::splat(0.0) }
    }

    fn moduli(&self) -> (f64, f64) {
        self.elastic.moduli()
    }
}

/// b̄ᵉ
#[inline(always)]
fn elastic<S: Simd>(history: &[S]) -> [S; 6] {
    [history[0], history[1], history[2], history[3], history[4], history[5]]
}

/// The p with det(s + p I) = p³ − J₂ p + J₃ = 1, from above: p ≤ `start`.
///
/// The cubic is convex there, so that Newton's iteration falls monotonically; five steps reach rounding for
/// elastic shears up to about one half.
#[inline(always)]
fn unimodular<S: Simd>(start: S, j2: S, j3: S) -> S {
    let rest = S::splat(1.0) - j3;
    let mut p = start;
    for _ in 0..5 {
        let square = p * p;
        p = (square + square).fma(p, rest) / S::splat(3.0).fma(square, -j2);
    }
    p
}
