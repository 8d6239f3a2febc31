//! The particles of a running simulation, as output sees them.
use crate::output::frame::{Columns, Field, Piece};
use crate::output::vtkhdf::CHUNK;
use engine::data::layout::ParticleLayout;
use engine::data::particles::ParticleBlock;
use engine::data::warehouse::Warehouse;
use engine::schema::{Label, LabelId};
use physics::quantities::{NONE, Shown, Tile};
use scene::Scene;
use scene::shown::Source;
use simd::{LANES, Wide};
use std::array::from_fn;
use std::ops::Range;
use tasks::labels;

/// A borrowed view of this rank's particles: patch by patch, material by material, block by block.
pub struct Snapshot<'a> {
    scene: &'a Scene,
    warehouse: &'a Warehouse,
    /// Where the numbers of each field are, and how many, material by material.
    sources: Vec<Vec<(Source, usize)>>,
}

impl<'a> Snapshot<'a> {
    /// The present state of a simulation of `scene`.
    pub fn new(scene: &'a Scene, warehouse: &'a Warehouse) -> Self {
        let fields = || scene.output.fields.iter();
        let of_material = |m| fields().map(|shown| (scene.source(m, shown.name), shown.components)).collect();
        Self { scene, warehouse, sources: (0..scene.materials.len()).map(of_material).collect() }
    }

    /// Number of particles.
    pub fn particles(&self) -> usize {
        self.warehouse.particle_count()
    }

    /// What every piece has.
    pub fn columns(&self) -> Columns {
        let materials = self.scene.materials.iter().map(|material| material.name.clone()).collect();
        Columns { fields: self.scene.output.fields.iter().map(field).collect(), materials }
    }

    /// Gives all particles to `take`, piece by piece. The first of them is row `row` of the frame; pieces end where
    /// chunks of the file do.
    pub fn pieces(&self, mut row: usize, mut take: impl FnMut(Piece)) {
        let mut piece = self.piece();
        for (material, block) in self.warehouse.blocks() {
            let mut begin = 0;
            while begin < block.count {
                let end = block.count.min(begin + CHUNK - row % CHUNK);
                self.add(&mut piece, material, block, begin..end);
                row += end - begin;
                begin = end;
                if row.is_multiple_of(CHUNK) {
                    take(std::mem::replace(&mut piece, self.piece()));
                }
            }
        }
        if !piece.positions.is_empty() {
            take(piece);
        }
    }

    fn piece(&self) -> Piece {
        let fields = &self.scene.output.fields;
        Piece::with_room(CHUNK.min(self.particles()), fields.iter().map(|shown| shown.components))
    }

    fn add(&self, piece: &mut Piece, material: usize, block: &ParticleBlock, rows: Range<usize>) {
        let state = State::new(self.scene, self.warehouse, material, block);
        // a scene has no more materials than fit
        piece.materials.resize(piece.materials.len() + rows.len(), material as u16);
        let mut numbers = NONE;
        for number in rows.start / LANES..rows.end.div_ceil(LANES) {
            let first = number * LANES;
            let lanes = rows.start.max(first) - first..rows.end.min(first + LANES) - first;
            let tile = state.tile(number);
            piece.identities.extend(&state.identities(number)[lanes.clone()]);
            piece.positions.extend_from_slice(&rows_of(tile.position)[lanes.clone()]);
            for (column, &(source, width)) in piece.columns.iter_mut().zip(&self.sources[material]) {
                source.put(&tile, &mut numbers);
                let append = match width {
                    1 => append::<1>,
                    3 => append::<3>,
                    6 => append::<6>,
                    9 => append::<9>,
                    _ => append_some,
                };
                append(column, &numbers[..width], lanes.clone());
            }
        }
    }
}

/// The numbers of eight particles, particle by particle.
#[inline(always)]
fn rows_of<const N: usize>(numbers: &[Wide; N]) -> [[f32; N]; LANES] {
    let mut rows = [[0.0; N]; LANES];
    for (component, line) in numbers.iter().enumerate() {
        for (row, x) in rows.iter_mut().zip(line.0) {
            row[component] = x as f32;
        }
    }
    rows
}

/// Appends those of some lanes to a column.
fn append<const N: usize>(column: &mut Vec<f32>, numbers: &[Wide], lanes: Range<usize>) {
    if let Some(numbers) = numbers.first_chunk::<N>() {
        column.extend_from_slice(rows_of(numbers)[lanes].as_flattened());
    }
}

/// The same of any number of numbers.
fn append_some(column: &mut Vec<f32>, numbers: &[Wide], lanes: Range<usize>) {
    lanes.for_each(|lane| column.extend(numbers.iter().map(|line| line.0[lane] as f32)));
}

fn field(shown: &Shown) -> Field {
    Field {
        name: shown.name.into(),
        unit: shown.unit.into(),
        components: shown.components,
        meaning: shown.meaning.into(),
        codes: shown.codes.iter().map(|&code| code.into()).collect(),
    }
}

/// The particles of a block, as what is shown sees them.
pub(super) struct State<'a> {
    layout: &'a ParticleLayout,
    block: &'a ParticleBlock,
    /// ρ₀ [kg/m³]: the volume of what has mass alone.
    density: f64,
}

impl<'a> State<'a> {
    pub fn new(scene: &Scene, warehouse: &'a Warehouse, material: usize, block: &'a ParticleBlock) -> Self {
        let layout = &warehouse.materials[material].layout;
        Self { layout, block, density: scene.materials[material].density }
    }

    /// The identities of the particles in a tile.
    pub fn identities(&self, tile: usize) -> [u64; LANES] {
        self.numbers::<1>(labels::Identity::ID, tile)[0].0.map(f64::to_bits)
    }

    /// The numbers of a tile. A material that does not have the label has none.
    fn numbers<const N: usize>(&self, label: LabelId, tile: usize) -> &'a [Wide; N] {
        self.lines(label, tile).first_chunk().unwrap_or(const { &[Wide([f64::NAN; LANES]); N] })
    }

    fn lines(&self, label: LabelId, tile: usize) -> &'a [Wide] {
        let width = self.layout.width(label);
        &self.block.column(self.layout, label)[tile * width..(tile + 1) * width]
    }

    /// The particles of a tile.
    pub fn tile(&self, tile: usize) -> Tile<'a> {
        let mass = &self.numbers::<1>(labels::Mass::ID, tile)[0];
        let of = |label| self.lines(label, tile).first();
        let volume = of(labels::Volume::ID);
        let ratio = |volume: &Wide, at_first: &Wide| from_fn(|l| volume.0[l] / at_first.0[l]);
        let j = volume.zip(of(labels::InitialVolume::ID)).map_or([f64::NAN; LANES], |(v, v0)| ratio(v, v0));
        Tile {
            position: self.numbers(labels::Position::ID, tile),
            start: self.numbers(labels::InitialPosition::ID, tile),
            velocity: self.numbers(labels::Velocity::ID, tile),
            mass,
            volume: volume.copied().unwrap_or_else(|| Wide(mass.0.map(|m| m / self.density))),
            j: Wide(j),
            f: self.numbers(labels::Deformation::ID, tile),
            kirchhoff: self.numbers(labels::KirchhoffStress::ID, tile),
            history: self.lines(labels::History::ID, tile),
        }
    }
}
