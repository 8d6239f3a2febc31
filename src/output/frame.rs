//! What a writer of particle files sees of a running simulation.

/// A named array over all particles.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name in files, for example `velocity`.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Numbers a particle: 1, 3, 6 or 9.
    pub components: usize,
}

/// The particles at one time. All arrays have the same order of particles; the order may differ between frames.
pub trait Frame {
    /// Simulated time [s].
    fn time(&self) -> f64;
    /// Steps taken.
    fn step(&self) -> u64;
    /// Number of particles.
    fn particles(&self) -> usize;
    /// Identity of each particle: constant over the run, unique over all materials.
    fn identities(&self) -> Vec<u64>;
    /// Index of each particle's material.
    fn materials(&self) -> Vec<u8>;
    /// Positions [m].
    fn positions(&self) -> Vec<[f32; 3]>;
    /// The fields that can be asked for; a particle whose material lacks a field has NaN there.
    fn fields(&self) -> Vec<Field>;
    /// The values of a field, particle by particle, component fastest.
    fn column(&self, field: &Field) -> Vec<f32>;
}
