//! Who acts in a tick. Materials take steps of their own, each a whole number of ticks; at a common rate each step is
//! one tick.
use super::labels::LabelId;
use super::shared::{Clock, MaterialStep};
use super::warehouse::Shared;

/// One material at the nodes of a block, in a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// The material.
    pub material: u8,
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

    /// Takes over what the labels `Time` and `Step` say.
    pub fn read(&mut self, shared: &Shared) {
        let clock: Clock = shared.get(LabelId::Time, 0);
        (self.tick, self.size) = (clock.number, clock.step);
        self.steps.copy_from_slice(bytemuck::cast_slice(shared.column(LabelId::Step)));
    }

    /// Whether a step of the material begins with the tick.
    pub fn begins(&self, material: usize) -> bool {
        self.steps[material].first == self.tick
    }

    /// Whether a step of the material ends with the tick.
    pub fn ends(&self, material: usize) -> bool {
        self.steps[material].last == self.tick + 1.0
    }

    /// The materials whose step ends with the tick, one bit each: only where one of them is do nodes take part.
    pub fn awake(&self) -> u64 {
        (0..self.steps.len())
            .filter(|&material| self.ends(material))
            .fold(0, |bits, material| bits | 1 << material)
    }

    /// A material at nodes that went through all ticks before number `until`.
    pub fn field(&self, material: u8, until: f64) -> Field {
        let step = &self.steps[material as usize];
        Field {
            material,
            begins: until <= step.first,
            ends: self.ends(material as usize),
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
