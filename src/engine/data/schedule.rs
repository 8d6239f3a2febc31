//! Who acts in a tick. Materials take steps of their own, each a whole number of ticks; at a common rate each step is
//! one tick.
use super::fields::{FieldId, Fields};
use super::rates::{Clock, MaterialStep};
use super::shared::Shared;
use crate::schema::Rates;

/// One velocity field at the nodes of a block, in a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldTime {
    /// The field.
    pub field: FieldId,
    /// Its material.
    pub material: usize,
    /// Whether nothing of its present step has happened here yet.
    pub begins: bool,
    /// Whether its step ends with the tick.
    pub ends: bool,
    /// The part of its step that had passed when the tick began [s].
    pub elapsed: f64,
    /// The part of its step before the tick that these nodes have not gone through, because nobody asked [s].
    pub missed: f64,
    /// Size of the tick [s].
    pub tick: f64,
    /// Size of its step [s].
    pub step: f64,
}

/// The steps that materials are in, and the present tick.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// Number of the tick.
    tick: f64,
    /// Its size [s].
    size: f64,
    steps: Vec<MaterialStep>,
}

impl Schedule {
    /// A tick in which each of `materials` materials begins and ends a step of no size.
    pub fn everyone(materials: usize) -> Self {
        let mut schedule =
            Self { tick: 0.0, size: 0.0, steps: vec![bytemuck::Zeroable::zeroed(); materials] };
        schedule.reset();
        schedule
    }

    /// Makes it a tick in which everyone acts.
    pub fn reset(&mut self) {
        (self.tick, self.size) = (0.0, 0.0);
        self.steps.fill(MaterialStep { last: 1.0, ..bytemuck::Zeroable::zeroed() });
    }

    /// The tick that a clock is at, in steps of materials.
    pub fn at(clock: &Clock, steps: &[MaterialStep]) -> Self {
        Self { tick: clock.number, size: clock.tick, steps: steps.to_vec() }
    }

    /// Takes over what the labels of clock and steps say.
    pub fn read(&mut self, rates: Rates, shared: &Shared) {
        let clock: Clock = shared.get(rates.clock, 0);
        (self.tick, self.size) = (clock.number, clock.tick);
        self.steps.copy_from_slice(bytemuck::cast_slice(shared.column(rates.steps)));
    }

    /// Whether a step of the material begins with the tick.
    pub fn begins(&self, material: usize) -> bool {
        self.steps[material].first == self.tick
    }

    /// Whether a step of the material ends with the tick.
    pub fn ends(&self, material: usize) -> bool {
        self.steps[material].last == self.tick + 1.0
    }

    /// Whether the steps of all materials end with the tick.
    pub fn all_end(&self) -> bool {
        (0..self.steps.len()).all(|material| self.ends(material))
    }

    /// A field at nodes that went through all ticks before number `until`.
    pub fn field(&self, fields: &Fields, field: FieldId, until: f64) -> FieldTime {
        let material = fields.material(field);
        let step = &self.steps[material];
        FieldTime {
            field,
            material,
            begins: until <= step.first,
            ends: self.ends(material),
            elapsed: (self.tick - step.first) * self.size,
            missed: (self.tick - until.max(step.first)) * self.size,
            tick: self.size,
            step: step.size,
        }
    }

    /// Number of the tick after this one.
    pub fn next(&self) -> f64 {
        self.tick + 1.0
    }
}
