//! One velocity for both materials, as long as the bond holds.
use super::friction::{Criterion, Friction};
use super::held::HeldPair;
use super::pair::{ContactLaw, Exchange, Pair, Strength, dot};
use crate::parameter::{Described, Dimension, Parameter, Refusal, Values};

/// Takes away all relative velocity, until the traction is too large; then the surfaces rub and part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bonded {
    /// What the bond bears.
    pub strength: Strength,
    /// Coefficient of friction where it is broken.
    pub friction: f64,
}

impl Bonded {
    /// A bond that never breaks.
    pub const FOREVER: Self =
        Self { strength: Strength { normal: f64::INFINITY, shear: f64::INFINITY }, friction: 0.0 };

    /// What is left of it where it is broken.
    fn rubs(&self) -> Friction {
        Friction { coefficient: self.friction, criterion: Criterion::Approach }
    }
}

impl Described for Bonded {
    const NAME: &'static str = "bonded";
    const SUMMARY: &'static str = "One velocity for both materials wherever particles of both reach a node, whatever the gap; \
        with a strength, until the traction between them exceeds it, and friction from then on.";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::positive_or(
            "normal-strength",
            Dimension::Stress,
            f64::INFINITY,
            "Tension at which the bond breaks, of two materials that deform; absent: never.",
        ),
        Parameter::positive_or(
            "shear-strength",
            Dimension::Stress,
            f64::INFINITY,
            "Shear at which the bond breaks, of two materials that deform; absent: never.",
        ),
        Parameter::at_least(
            "friction",
            Dimension::One,
            0.0,
            Some(0.0),
            "Coefficient of friction where it is broken.",
        ),
    ];
    type Built = Self;
    fn build(values: &Values) -> Result<Self, Refusal> {
        let [normal, shear] = ["normal-strength", "shear-strength"].map(|key| values.number(key));
        let (strength, friction) = (Strength { normal, shear }, values.number("friction"));
        if friction > 0.0 && !strength.is_finite() {
            return Err(("friction", "a bond without a strength never breaks, and so never rubs".into()));
        }
        Ok(Self { strength, friction })
    }
}

impl ContactLaw for Bonded {
    #[inline]
    fn bond(&self) -> Option<Strength> {
        Some(self.strength)
    }
    #[inline]
    fn exchange(&self, pair: &Pair) -> Exchange {
        let along = dot(pair.relative, pair.normal);
        pair.exchange(along, std::array::from_fn(|a| pair.relative[a] - along * pair.normal[a]))
    }
    #[inline]
    fn exchange_held(&self, pair: &HeldPair) -> Exchange {
        pair.hold()
    }
    #[inline]
    fn stiffness(&self, pair: &Pair) -> [[f64; 3]; 3] {
        pair.takes(1.0, 1.0)
    }
    #[inline]
    fn broken(&self, pair: &Pair) -> Exchange {
        self.rubs().exchange(pair)
    }
    #[inline]
    fn broken_held(&self, pair: &HeldPair) -> Exchange {
        self.rubs().exchange_held(pair)
    }
}
