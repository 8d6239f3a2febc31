//! Matter that sticks to a moving face.
use super::condition::{FaceCondition, Wall};
use crate::contact::bonded::Bonded;
use crate::motion::Course;
use crate::parameter::{Described, Parameter, Refusal, Values};
use crate::table::Table;

/// A plane that moves as given in time, from the face on, and takes along what touches it.
#[derive(Clone, Debug, PartialEq)]
pub struct Velocity {
    /// The velocity [m/s] in time.
    pub table: Table,
}

impl Described for Velocity {
    const NAME: &'static str = "velocity";
    const SUMMARY: &'static str = "The face is a plane that moves like this from its place on, and matter that it touches sticks to it.";
    const PARAMETERS: &'static [Parameter] = &[Parameter::motion("velocity", "Velocity in time.")];
    type Built = Self;
    fn build(values: &Values) -> Result<Self, Refusal> {
        Ok(Self { table: values.motion("velocity").clone() })
    }
}

impl FaceCondition for Velocity {
    fn acts(&self) -> bool {
        false
    }
    fn wall(&self) -> Option<Wall> {
        Some(Wall { course: Course::Velocity(self.table.clone()), law: Bonded::FOREVER.into() })
    }
    fn correction(&self, _axis: usize, _time: f64, _velocity: [f64; 3]) -> [f64; 3] {
        [0.0; 3]
    }
}
