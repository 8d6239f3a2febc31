//! A face without a condition.
use super::condition::FaceCondition;
use crate::parameter::{Described, Parameter, Refusal, Values};

/// Nothing holds the matter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free;

impl Described for Free {
    const NAME: &'static str = "free";
    const SUMMARY: &'static str = "Nothing holds the matter.";
    const PARAMETERS: &'static [Parameter] = &[];
    type Built = Self;
    fn build(_values: &Values) -> Result<Self, Refusal> {
        Ok(Self)
    }
}

impl FaceCondition for Free {
    #[inline]
    fn acts(&self) -> bool {
        false
    }
    #[inline]
    fn correction(&self, _axis: usize, _time: f64, _velocity: [f64; 3]) -> [f64; 3] {
        [0.0; 3]
    }
}
