//! The particles of a running simulation, as output sees them.
use super::Simulation;
use super::populate::history_of;
use crate::data::labels::LabelId;
use crate::data::particles::{Layout, ParticleBlock};
use crate::output::frame::{Field, Frame};

/// A borrowed view of all particles: patch by patch, material by material, block by block.
pub struct Snapshot<'a> {
    simulation: &'a Simulation,
}

impl<'a> Snapshot<'a> {
    /// The present state of `simulation`.
    pub fn new(simulation: &'a Simulation) -> Self {
        Self { simulation }
    }

    /// Runs `visit` on every particle: material, layout, block, position in the block.
    fn each(&self, mut visit: impl FnMut(usize, &Layout, &ParticleBlock, usize)) {
        for (material, block) in self.simulation.warehouse.blocks() {
            let layout = &self.simulation.warehouse.materials[material].layout;
            (0..block.count).for_each(|particle| visit(material, layout, block, particle));
        }
    }

    fn collect<T>(&self, mut value: impl FnMut(usize, &Layout, &ParticleBlock, usize) -> T) -> Vec<T> {
        let mut values = Vec::with_capacity(self.particles());
        self.each(|m, layout, block, p| values.push(value(m, layout, block, p)));
        values
    }
}

/// Mean Cauchy stress with the sign of a pressure, and von Mises stress [Pa].
fn pressure_and_mises(layout: &Layout, block: &ParticleBlock, p: usize) -> [f64; 2] {
    let j = block.get(layout, LabelId::Volume, p, 0) / block.get(layout, LabelId::InitialVolume, p, 0);
    let s: [f64; 6] = std::array::from_fn(|c| block.get(layout, LabelId::KirchhoffStress, p, c) / j);
    let mean = (s[0] + s[3] + s[5]) / 3.0;
    let normal = [0, 3, 5].map(|c| (s[c] - mean).powi(2)).iter().sum::<f64>();
    let shear = [1, 2, 4].map(|c| s[c] * s[c]).iter().sum::<f64>();
    [-mean, (1.5 * normal + 3.0 * shear).sqrt()]
}

impl Frame for Snapshot<'_> {
    fn time(&self) -> f64 {
        self.simulation.clock().time
    }

    fn step(&self) -> u64 {
        self.simulation.steps()
    }

    fn particles(&self) -> usize {
        self.simulation.warehouse.particle_count()
    }

    fn identities(&self) -> Vec<u64> {
        self.collect(|_, layout, block, p| block.get(layout, LabelId::Identity, p, 0).to_bits())
    }

    fn materials(&self) -> Vec<u8> {
        self.collect(|m, _, _, _| m as u8)
    }

    fn positions(&self) -> Vec<[f32; 3]> {
        self.collect(|_, layout, block, p| {
            [0, 1, 2].map(|a| block.get(layout, LabelId::Position, p, a) as f32)
        })
    }

    fn fields(&self) -> Vec<Field> {
        let field =
            |name: &str, unit: &str, components| Field { name: name.into(), unit: unit.into(), components };
        let mut fields = vec![
            field("velocity", "m/s", 3),
            field("volume_ratio", "1", 1),
            field("pressure", "Pa", 1),
            field("von_mises", "Pa", 1),
        ];
        for variable in self.simulation.scene.materials.iter().flat_map(|m| history_of(&m.behavior)) {
            if !fields.iter().any(|f| f.name == variable.name) {
                fields.push(field(variable.name, variable.unit, 1));
            }
        }
        fields
    }

    fn column(&self, field: &Field) -> Vec<f32> {
        let histories: Vec<Option<usize>> = self
            .simulation
            .scene
            .materials
            .iter()
            .map(|m| history_of(&m.behavior).iter().position(|v| v.name == field.name))
            .collect();
        let mut values = Vec::with_capacity(self.particles() * field.components);
        self.each(|m, layout, block, p| {
            let get = |label, c| block.get(layout, label, p, c);
            let deformable = layout.widths[LabelId::KirchhoffStress as usize] > 0;
            match field.name.as_str() {
                "velocity" => values.extend([0, 1, 2].map(|a| get(LabelId::Velocity, a) as f32)),
                "volume_ratio" | "pressure" | "von_mises" if !deformable => values.push(f32::NAN),
                "volume_ratio" => {
                    values.push((get(LabelId::Volume, 0) / get(LabelId::InitialVolume, 0)) as f32);
                }
                "pressure" => values.push(pressure_and_mises(layout, block, p)[0] as f32),
                "von_mises" => values.push(pressure_and_mises(layout, block, p)[1] as f32),
                _ => values.push(histories[m].map_or(f32::NAN, |c| get(LabelId::History, c) as f32)),
            }
        });
        values
    }
}
