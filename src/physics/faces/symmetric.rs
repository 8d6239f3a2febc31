//! A plane of symmetry.
use super::condition::{FaceCondition, Image};
use crate::parameter::{Described, Parameter, Refusal, Values};

/// v · n = 0
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Symmetric;

impl Described for Symmetric {
    const NAME: &'static str = "symmetric";
    const SUMMARY: &'static str = "The face is a plane of symmetry: matter slides along it.";
    const PARAMETERS: &'static [Parameter] = &[];
    type Built = Self;
    fn build(_values: &Values) -> Result<Self, Refusal> {
        Ok(Self)
    }
}

impl FaceCondition for Symmetric {
    #[inline]
    fn image(&self) -> Option<Image> {
        Some(Image::Mirror)
    }
    #[inline]
    fn correction(&self, axis: usize, _time: f64, velocity: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| if a == axis { -velocity[a] } else { 0.0 })
    }
}
