//! Coulomb friction with free separation, after S. G. Bardenhagen et al., CMES 2(4), 2001, 509–522
//! (doi:10.3970/cmes.2001.002.509), made pairwise: each impulse has its opposite, so momentum is conserved for any
//! number of materials at a node.
use super::held::HeldPair;
use super::pair::{ContactLaw, Exchange, Pair, dot};
use crate::parameter::{Described, Dimension, Parameter, Refusal, Values};

/// Stops approach along the normal, and slip as far as friction allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Coefficient μ.
    pub coefficient: f64,
    /// When it acts.
    pub criterion: Criterion,
}

/// When frictional contact acts, besides the gap test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Criterion {
    /// While the surfaces approach.
    Approach,
    /// While the surfaces approach or the normal traction between them is compressive.
    ApproachOrCompression,
    /// While the surfaces approach and the normal traction is compressive.
    ApproachAndCompression,
}

impl Described for Friction {
    const NAME: &'static str = "friction";
    const SUMMARY: &'static str = "Coulomb friction with free separation.";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::at_least("friction", Dimension::One, 0.0, None, "Coefficient of friction."),
        Parameter::choice(
            "criterion",
            &["approach", "approach-or-compression", "approach-and-compression"],
            "When contact acts: while the surfaces approach, or only if the normal traction is compressive, too. Contact never pulls: \
             \"approach-or-compression\" is another word for \"approach\".",
        ),
    ];
    type Built = Self;
    fn build(values: &Values) -> Result<Self, Refusal> {
        let criterion = match values.choice("criterion") {
            "approach" => Criterion::Approach,
            "approach-or-compression" => Criterion::ApproachOrCompression,
            _ => Criterion::ApproachAndCompression,
        };
        Ok(Self { coefficient: values.number("friction"), criterion })
    }
}

impl Friction {
    /// How fast surfaces approach, if contact acts; those that part are never pulled [m/s].
    #[inline]
    fn approach(&self, pair: &Pair) -> Option<f64> {
        self.acts(dot(pair.relative, pair.normal), pair.traction)
    }

    /// The same of a velocity [m/s] along the normal, with the normal traction [Pa].
    #[inline]
    fn acts(&self, approach: f64, traction: f64) -> Option<f64> {
        let compressed = traction < 0.0;
        let acts = match self.criterion {
            Criterion::Approach => approach > 0.0,
            Criterion::ApproachOrCompression => approach > 0.0 || compressed,
            Criterion::ApproachAndCompression => approach > 0.0 && compressed,
        };
        acts.then_some(approach.max(0.0))
    }

    /// The slip of surfaces that are pressed together, how fast it is [m/s], and the share of it that friction takes.
    #[inline]
    fn touching(&self, pair: &Pair) -> Option<([f64; 3], f64, f64)> {
        let approach = self.approach(pair).filter(|approach| *approach > 0.0)?;
        let slip: [f64; 3] = std::array::from_fn(|a| pair.relative[a] - approach * pair.normal[a]);
        let (speed, limit) = (dot(slip, slip).sqrt(), self.coefficient * approach);
        Some((slip, speed, if speed > limit { limit / speed } else { 1.0 }))
    }
}

impl ContactLaw for Friction {
    #[inline]
    fn exchange(&self, pair: &Pair) -> Exchange {
        let Some(approach) = self.approach(pair) else { return Exchange::default() };
        let along = dot(pair.relative, pair.normal);
        let slip: [f64; 3] = std::array::from_fn(|a| pair.relative[a] - along * pair.normal[a]);
        let speed = dot(slip, slip).sqrt();
        let limit = self.coefficient * approach;
        let share = if speed > limit { limit / speed } else { 1.0 };
        pair.exchange(approach, slip.map(|s| share * s))
    }

    #[inline]
    fn exchange_held(&self, pair: &HeldPair) -> Exchange {
        let approach = self.acts(dot(pair.relative, pair.normal), pair.traction);
        let approach = approach.filter(|approach| *approach > 0.0);
        approach.map_or(Exchange::default(), |approach| pair.rub(approach, self.coefficient))
    }

    fn asks_traction(&self) -> bool {
        self.criterion == Criterion::ApproachAndCompression
    }

    #[inline]
    fn secant(&self, pair: &Pair) -> [[f64; 3]; 3] {
        self.touching(pair).map_or([[0.0; 3]; 3], |(_, _, share)| pair.takes(1.0, share))
    }

    #[inline]
    fn stiffness(&self, pair: &Pair) -> [[f64; 3]; 3] {
        let Some((slip, speed, share)) = self.touching(pair) else { return [[0.0; 3]; 3] };
        let (mut all, n, m) = (pair.takes(1.0, share), pair.normal, pair.reduced_mass);
        if share == 1.0 {
            return all;
        }
        // friction is m μ (u·n) t, with the direction t of the slip
        let t = slip.map(|s| s / speed);
        for i in 0..3 {
            for j in 0..3 {
                all[i][j] += m * (self.coefficient * t[i] * n[j] - share * t[i] * t[j]);
            }
        }
        all
    }
}
