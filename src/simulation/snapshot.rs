//! The particles of a running simulation, as output sees them.
use crate::output::frame::{Columns, Field, Piece};
use crate::output::vtkhdf::CHUNK;
use engine::data::layout::ParticleLayout;
use engine::data::particles::ParticleBlock;
use engine::data::warehouse::Warehouse;
use engine::schema::{Label, LabelId};
use physics::quantities::{Particle, Shown};
use scene::Scene;
use scene::shown::Source;
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
        let columns = vec![Vec::new(); self.scene.output.fields.len()];
        Piece { columns, ..Piece::default() }
    }

    fn add(&self, piece: &mut Piece, material: usize, block: &ParticleBlock, rows: Range<usize>) {
        let state = State::new(self.scene, self.warehouse, material, block);
        let mut history = Vec::new();
        for p in rows {
            let particle = state.particle(p, &mut history);
            piece.identities.push(state.identity(p));
            // a scene has no more materials than fit
            piece.materials.push(material as u16);
            piece.positions.push(particle.position.map(|x| x as f32));
            for (column, &(source, width)) in piece.columns.iter_mut().zip(&self.sources[material]) {
                let value = source.of(&particle);
                column.extend(value[..width].iter().map(|&x| x as f32));
            }
        }
    }
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

    pub fn identity(&self, p: usize) -> u64 {
        self.block.get(self.layout, labels::Identity::ID, p, 0).to_bits()
    }

    /// Numbers that the material does not have are none.
    fn numbers<const N: usize>(&self, label: LabelId, p: usize) -> [f64; N] {
        match self.layout.width(label) {
            0 => [f64::NAN; N],
            _ => std::array::from_fn(|c| self.block.get(self.layout, label, p, c)),
        }
    }

    pub fn particle<'b>(&self, p: usize, history: &'b mut Vec<f64>) -> Particle<'b> {
        let [mass] = self.numbers(labels::Mass::ID, p);
        let ([volume], [at_first]) =
            (self.numbers(labels::Volume::ID, p), self.numbers(labels::InitialVolume::ID, p));
        history.clear();
        let kept = self.layout.width(labels::History::ID);
        history.extend((0..kept).map(|c| self.block.get(self.layout, labels::History::ID, p, c)));
        Particle {
            position: self.numbers(labels::Position::ID, p),
            start: self.numbers(labels::InitialPosition::ID, p),
            velocity: self.numbers(labels::Velocity::ID, p),
            mass,
            volume: if volume.is_nan() { mass / self.density } else { volume },
            j: volume / at_first,
            f: self.numbers(labels::Deformation::ID, p),
            kirchhoff: self.numbers(labels::KirchhoffStress::ID, p),
            history,
        }
    }
}
