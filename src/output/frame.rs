//! What a writer of particle files sees of a running simulation.

/// A named array over all particles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field {
    /// Name in files, for example `velocity`.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Numbers a particle: 1, 3, 6 or 9.
    pub components: usize,
    /// What it is, in a line.
    pub meaning: String,
    /// What its values mean, from 0 on, if they are codes.
    pub codes: Vec<String>,
}

/// What all frames of a run show beside positions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// The fields.
    pub fields: Vec<Field>,
    /// Names of the materials, in the order of their indices.
    pub materials: Vec<String>,
}

impl Columns {
    /// The same with its fields by name, as HDF5 lists them.
    pub fn sorted(mut self) -> Self {
        self.fields.sort_by(|a, b| a.name.cmp(&b.name));
        self
    }
}

/// What the numbers of a field are called: nothing where there is one, and where nobody knows.
pub fn part_names(components: usize) -> &'static [&'static str] {
    match components {
        1 => &[""],
        3 => &["x", "y", "z"],
        6 => &["xx", "yy", "zz", "xy", "yz", "xz"],
        9 => &["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"],
        _ => &[],
    }
}

/// What a frame says about all its particles together.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// Simulated time [s].
    pub time: f64,
    /// Steps taken.
    pub step: u64,
    /// Number of particles, of all pieces together.
    pub particles: usize,
    /// What every piece has.
    pub columns: Columns,
}

/// Some particles of a frame: it is written piece by piece, so that nobody has to hold them all.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piece {
    /// Identity of each particle: constant over the run, unique over all materials.
    pub identities: Vec<u64>,
    /// Index of each particle's material.
    pub materials: Vec<u16>,
    /// Positions [m].
    pub positions: Vec<[f32; 3]>,
    /// The values of each field, particle by particle, component fastest.
    pub columns: Vec<Vec<f32>>,
}

impl Piece {
    /// An empty one with room for `rows` particles, and so many numbers of each in its columns.
    pub fn with_room(rows: usize, columns: impl Iterator<Item = usize>) -> Self {
        Self {
            identities: Vec::with_capacity(rows),
            materials: Vec::with_capacity(rows),
            positions: Vec::with_capacity(rows),
            columns: columns.map(|components| Vec::with_capacity(rows * components)).collect(),
        }
    }
}

/// The particles at one time, in memory. All arrays have the same order of particles; the order may differ between frames.
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
    fn materials(&self) -> Vec<u16>;
    /// Positions [m].
    fn positions(&self) -> Vec<[f32; 3]>;
    /// The fields that can be asked for; a particle whose material lacks a field has NaN there.
    fn fields(&self) -> Vec<Field>;
    /// The values of a field, particle by particle, component fastest.
    fn column(&self, field: &Field) -> Vec<f32>;
}
