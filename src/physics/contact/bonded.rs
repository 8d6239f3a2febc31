//! One velocity for both materials.
use super::pair::{ContactLaw, Exchange, Pair, dot};
use crate::parameter::{Described, Parameter, Refusal, Values};

/// Takes away all relative velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bonded;

impl Described for Bonded {
    const NAME: &'static str = "bonded";
    const SUMMARY: &'static str = "One velocity for both materials.";
    const PARAMETERS: &'static [Parameter] = &[];
    type Built = Self;
    fn build(_values: &Values) -> Result<Self, Refusal> {
        Ok(Self)
    }
}

impl ContactLaw for Bonded {
    #[inline]
    fn is_bond(&self) -> bool {
        true
    }
    #[inline]
    fn exchange(&self, pair: &Pair) -> Exchange {
        let along = dot(pair.relative, pair.normal);
        pair.exchange(along, std::array::from_fn(|a| pair.relative[a] - along * pair.normal[a]))
    }
}
