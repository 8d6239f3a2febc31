//! Matter that sticks to a face at rest.
use super::condition::{FaceCondition, Image};
use crate::parameter::{Described, Parameter, Refusal, Values};

/// v = 0
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fixed;

impl Described for Fixed {
    const NAME: &'static str = "fixed";
    const SUMMARY: &'static str = "Matter at the face rests.";
    const PARAMETERS: &'static [Parameter] = &[];
    type Built = Self;
    fn build(_values: &Values) -> Result<Self, Refusal> {
        Ok(Self)
    }
}

impl FaceCondition for Fixed {
    #[inline]
    fn image(&self) -> Option<Image> {
        Some(Image::Odd)
    }
    #[inline]
    fn correction(&self, _axis: usize, _time: f64, velocity: [f64; 3]) -> [f64; 3] {
        velocity.map(|v| -v)
    }
}
