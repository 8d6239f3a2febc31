//! The word `tissue` in a scene, and the laws that its parameters choose among.
use super::super::AnyLaw;
use super::{NoFailure, Tissue, TwoSurface};
use crate::parameter::{Described, Dimension, Parameter, Refusal, Values};
use simd::Mask;

/// All monomorphisations of [`Tissue`], as one described law.
#[derive(Clone, Copy, Debug)]
pub struct Family;

impl Described for Family {
    const NAME: &'static str = "tissue";
    const SUMMARY: &'static str = "Soft tissue: matrix with one family of fibers, \
        W = C1 (Ĩ₁ − 3) + F₂(λ̃) + K/2 (ln J)² (Weiss et al. 1996), \
        with two-surface failure (Ionescu et al. 2006, eqs. 2–8)";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::positive("c1", Dimension::Stress, "C1 of the matrix, half its shear modulus"),
        Parameter::at_least("c3", Dimension::Stress, 0.0, None, "C3, scale of the fibers' exponential toe"),
        Parameter::at_least("c4", Dimension::One, 0.0, None, "C4, rate at which fibers uncrimp"),
        Parameter::at_least("c5", Dimension::Stress, 0.0, None, "C5, modulus of straight fibers"),
        Parameter::at_least("lambda-star", Dimension::One, 1.0, None, "stretch at which fibers are straight"),
        Parameter::positive("bulk-modulus", Dimension::Stress, "bulk modulus K"),
        Parameter::choice(
            "failure",
            &["two-surface", "none"],
            "failure criterion: one surface for the matrix and one for the fibers, or none",
        ),
        Parameter::positive_or(
            "fiber-limit",
            Dimension::One,
            0.40,
            "fibers fail at this fiber strain λ − 1 (total stretch; eq. 8)",
        ),
        Parameter::positive_or(
            "matrix-limit",
            Dimension::One,
            0.25,
            "the matrix fails at this shear strain, half the span of the principal values (eq. 6)",
        ),
        Parameter::choice(
            "strain",
            &["green-lagrange", "right-cauchy-green"],
            "tensor of the principal values; right-cauchy-green gives twice the measure, as in Uintah",
        ),
        Parameter::flag(
            "keep-compression",
            false,
            "whether failed matrix still resists compression (the paper: no)",
        ),
        Parameter::choice(
            "inversion",
            &["error", "fail"],
            "what J ≤ 0 means: the run stops, or the particle fails totally (code 4)",
        ),
    ];

    type Built = AnyLaw;

    fn build(values: &Values) -> Result<AnyLaw, Refusal> {
        let fails = values.choice("inversion") == "fail";
        if values.choice("failure") == "none" {
            if fails {
                let message = "inversion = \"fail\" needs failure = \"two-surface\"";
                return Err(("inversion", message.into()));
            }
            return Ok(tissue(values, NoFailure).into());
        }
        let all = |yes: bool| if yes { Mask::MAX } else { 0 };
        // c₁ − c₃ = 2 (E₁ − E₃)
        let halves = if values.choice("strain") == "green-lagrange" { 4.0 } else { 2.0 };
        let failure = TwoSurface {
            stretch: 1.0 + values.number("fiber-limit"),
            span: halves * values.number("matrix-limit"),
            keeps_pressure: all(values.flag("keep-compression")),
            crushes: all(fails),
        };
        Ok(tissue(values, failure).into())
    }
}

fn tissue<F>(values: &Values, failure: F) -> Tissue<F> {
    Tissue {
        c1: values.number("c1"),
        c3: values.number("c3"),
        c4: values.number("c4"),
        c5: values.number("c5"),
        straight: values.number("lambda-star"),
        bulk: values.number("bulk-modulus"),
        failure,
    }
}
