//! A plate along which matter slides, and from which it parts.
use super::condition::{FaceCondition, Wall};
use crate::contact::friction::{Criterion, Friction};
use crate::motion::Course;
use crate::parameter::{Described, Dimension, Parameter, Refusal, Values};
use crate::table::Table;

/// A plane with Coulomb friction that moves as given in time, from the face on.
#[derive(Clone, Debug, PartialEq)]
pub struct Plate {
    /// The velocity [m/s] in time.
    pub table: Table,
    /// Coefficient of friction.
    pub friction: f64,
}

impl Described for Plate {
    const NAME: &'static str = "plate";
    const SUMMARY: &'static str = "The face is a plate, which may move from its place on: it pushes, matter slides along it with friction and parts from it.";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::at_least("friction", Dimension::One, 0.0, None, "Coefficient of friction."),
        Parameter::motion_or_rest("velocity", "Velocity in time."),
    ];
    type Built = Self;
    fn build(values: &Values) -> Result<Self, Refusal> {
        Ok(Self { table: values.motion("velocity").clone(), friction: values.number("friction") })
    }
}

impl FaceCondition for Plate {
    fn acts(&self) -> bool {
        false
    }
    fn wall(&self) -> Option<Wall> {
        let law = Friction { coefficient: self.friction, criterion: Criterion::Approach }.into();
        Some(Wall { course: Course::Velocity(self.table.clone()), law })
    }
    fn correction(&self, _axis: usize, _time: f64, _velocity: [f64; 3]) -> [f64; 3] {
        [0.0; 3]
    }
}
