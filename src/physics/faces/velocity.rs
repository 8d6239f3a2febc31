//! Matter that sticks to a moving face.
use super::condition::FaceCondition;
use crate::parameter::{Described, Parameter, Refusal, Values};
use crate::table::Table;

/// v as given in time.
#[derive(Clone, Debug, PartialEq)]
pub struct Velocity {
    /// The velocity [m/s] in time.
    pub table: Table,
}

impl Described for Velocity {
    const NAME: &'static str = "velocity";
    const SUMMARY: &'static str = "Matter at the face moves like this.";
    const PARAMETERS: &'static [Parameter] = &[Parameter::motion("velocity", "Velocity in time.")];
    type Built = Self;
    fn build(values: &Values) -> Result<Self, Refusal> {
        Ok(Self { table: values.motion("velocity").clone() })
    }
}

impl FaceCondition for Velocity {
    #[inline]
    fn correction(&self, _axis: usize, time: f64, velocity: [f64; 3]) -> [f64; 3] {
        let wanted = self.table.at(time);
        std::array::from_fn(|a| wanted[a] - velocity[a])
    }
}
