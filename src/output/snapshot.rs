//! A frame in memory: read from a file, or made by hand.
use super::frame::{Field, Frame};

/// Particles at one time, with some of their fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// Simulated time [s].
    pub time: f64,
    /// Steps taken.
    pub step: u64,
    /// Identity of each particle.
    pub identities: Vec<u64>,
    /// Index of each particle's material.
    pub materials: Vec<u16>,
    /// Positions [m].
    pub positions: Vec<[f32; 3]>,
    /// Fields and their values, particle by particle, component fastest.
    pub columns: Vec<(Field, Vec<f32>)>,
}

impl Frame for Snapshot {
    fn time(&self) -> f64 {
        self.time
    }

    fn step(&self) -> u64 {
        self.step
    }

    fn particles(&self) -> usize {
        self.positions.len()
    }

    fn identities(&self) -> Vec<u64> {
        self.identities.clone()
    }

    fn materials(&self) -> Vec<u16> {
        self.materials.clone()
    }

    fn positions(&self) -> Vec<[f32; 3]> {
        self.positions.clone()
    }

    fn fields(&self) -> Vec<Field> {
        self.columns.iter().map(|(field, _)| field.clone()).collect()
    }

    /// Empty for a field that was not read.
    fn column(&self, field: &Field) -> Vec<f32> {
        self.columns
            .iter()
            .find(|(f, _)| f.name == field.name)
            .map_or(Vec::new(), |(_, values)| values.clone())
    }
}
