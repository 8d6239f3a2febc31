//! The particles of a running simulation, as output sees them.
use super::populate::declared;
use crate::output::frame::{Field, Piece};
use crate::output::vtkhdf::CHUNK;
use engine::data::layout::ParticleLayout;
use engine::data::particles::ParticleBlock;
use engine::data::warehouse::Warehouse;
use engine::schema::{Label, LabelId};
use scene::Scene;
use simd::LANES;
use std::ops::Range;
use tasks::labels;

/// A borrowed view of this rank's particles: patch by patch, material by material, block by block.
pub struct Snapshot<'a> {
    warehouse: &'a Warehouse,
    fields: Vec<Field>,
    /// Where the numbers of each field are, material by material.
    sources: Vec<Vec<Source>>,
}

/// What a field shows of a material.
#[derive(Clone, Copy)]
enum Source {
    Nothing,
    Velocity,
    VolumeRatio,
    Pressure,
    VonMises,
    /// A number of the law's history.
    History(usize),
}

impl<'a> Snapshot<'a> {
    /// The present state of a simulation of `scene`.
    pub fn new(scene: &Scene, warehouse: &'a Warehouse) -> Self {
        let fields = fields(scene);
        let of_material = |m: usize| {
            let deformable = warehouse.materials[m].layout.width(labels::KirchhoffStress::ID) > 0;
            let history = declared(&scene.materials[m].behavior).history;
            let source = |field: &Field| match field.name.as_str() {
                "velocity" => Source::Velocity,
                "volume_ratio" if deformable => Source::VolumeRatio,
                "pressure" if deformable => Source::Pressure,
                "von_mises" if deformable => Source::VonMises,
                name => history.iter().position(|v| v.name == name).map_or(Source::Nothing, Source::History),
            };
            fields.iter().map(source).collect()
        };
        let sources = (0..scene.materials.len()).map(of_material).collect();
        Self { warehouse, fields, sources }
    }

    /// Number of particles.
    pub fn particles(&self) -> usize {
        self.warehouse.particle_count()
    }

    /// The fields of every piece.
    pub fn fields(&self) -> &[Field] {
        &self.fields
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
        let columns = vec![Vec::new(); self.fields.len()];
        Piece { columns, ..Piece::default() }
    }

    fn add(&self, piece: &mut Piece, material: usize, block: &ParticleBlock, rows: Range<usize>) {
        let layout = &self.warehouse.materials[material].layout;
        let get = |label, component| numbers(layout, block, label, component, rows.clone());
        piece.identities.extend(get(labels::Identity::ID, 0).map(f64::to_bits));
        // a scene has no more materials than fit
        piece.materials.resize(piece.materials.len() + rows.len(), material as u16);
        let [x, y, z] = [0, 1, 2].map(|a| get(labels::Position::ID, a));
        piece.positions.extend(x.zip(y).zip(z).map(|((x, y), z)| [x, y, z].map(|x| x as f32)));
        for (i, (column, source)) in piece.columns.iter_mut().zip(&self.sources[material]).enumerate() {
            let ratio = || {
                get(labels::Volume::ID, 0)
                    .zip(get(labels::InitialVolume::ID, 0))
                    .map(|(now, then)| now / then)
            };
            let stress = || rows.clone().zip(ratio()).map(|(p, j)| pressure_and_mises(layout, block, p, j));
            match *source {
                Source::Nothing => column.extend(vec![f32::NAN; rows.len() * self.fields[i].components]),
                Source::Velocity => {
                    let [x, y, z] = [0, 1, 2].map(|a| get(labels::Velocity::ID, a));
                    column.extend(x.zip(y).zip(z).flat_map(|((x, y), z)| [x, y, z].map(|x| x as f32)));
                }
                Source::VolumeRatio => column.extend(ratio().map(|x| x as f32)),
                Source::Pressure => column.extend(stress().map(|[pressure, _]| pressure as f32)),
                Source::VonMises => column.extend(stress().map(|[_, mises]| mises as f32)),
                Source::History(number) => {
                    column.extend(get(labels::History::ID, number).map(|x| x as f32));
                }
            }
        }
    }
}

/// What every frame shows, and the histories of the laws.
fn fields(scene: &Scene) -> Vec<Field> {
    let field =
        |name: &str, unit: &str, components| Field { name: name.into(), unit: unit.into(), components };
    let mut fields = vec![
        field("velocity", "m/s", 3),
        field("volume_ratio", "1", 1),
        field("pressure", "Pa", 1),
        field("von_mises", "Pa", 1),
    ];
    for variable in scene.materials.iter().flat_map(|m| declared(&m.behavior).history) {
        if !fields.iter().any(|f| f.name == variable.name) {
            fields.push(field(variable.name, variable.unit, 1));
        }
    }
    fields
}

/// One number of some particles of a block.
fn numbers<'a>(
    layout: &ParticleLayout,
    block: &'a ParticleBlock,
    label: LabelId,
    component: usize,
    rows: Range<usize>,
) -> impl Iterator<Item = f64> + 'a {
    let (column, width) = (block.column(layout, label), layout.width(label));
    rows.map(move |p| column[p / LANES * width + component].0[p % LANES])
}

/// Mean Cauchy stress with the sign of a pressure, and von Mises stress [Pa], at a volume ratio `j`.
fn pressure_and_mises(layout: &ParticleLayout, block: &ParticleBlock, p: usize, j: f64) -> [f64; 2] {
    let s: [f64; 6] = std::array::from_fn(|c| block.get(layout, labels::KirchhoffStress::ID, p, c) / j);
    let mean = (s[0] + s[3] + s[5]) / 3.0;
    let normal = [0, 3, 5].map(|c| (s[c] - mean).powi(2)).iter().sum::<f64>();
    let shear = [1, 2, 4].map(|c| s[c] * s[c]).iter().sum::<f64>();
    [-mean, (1.5 * normal + 3.0 * shear).sqrt()]
}
