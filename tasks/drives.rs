//! What drives prescribe.
use engine::data::rates::MaterialStep;
use physics::motion::{Chord, Motion};

/// The drives of a scene; particles have their numbers (label `DriveIndex`: 1 + the index in this list).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drives(pub Vec<DriveMotion>);

/// How the matter of one of them moves.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveMotion {
    /// Its motion.
    pub motion: Motion,
    /// Along which axes it is prescribed.
    pub components: [bool; 3],
    /// When the matter is released [s].
    pub until: f64,
}

/// What moves a driven particle.
#[derive(Clone, Copy, Debug)]
pub struct Driven {
    /// Its way through the step.
    pub chord: Chord,
    /// Along which axes.
    pub components: [bool; 3],
    /// The gradient of the velocity that it has had so far, row by row [1/s].
    pub gradient: [f64; 9],
}

/// What drives do in one step of a material: neighbors among particles mostly have the same.
pub struct DriveStep<'a> {
    drives: &'a Drives,
    step: &'a MaterialStep,
    last: Option<(f64, Option<Driven>)>,
}

impl Drives {
    /// What they do in a step.
    pub fn during<'a>(&'a self, step: &'a MaterialStep) -> DriveStep<'a> {
        DriveStep { drives: self, step, last: None }
    }
}

impl DriveStep<'_> {
    /// What moves a particle with this `DriveIndex`; `None`: it is free.
    pub fn of(&mut self, index: f64) -> Option<Driven> {
        if let Some((known, found)) = self.last
            && known == index
        {
            return found;
        }
        let (from, to) = (self.step.time, self.step.time + self.step.size);
        let drive = (index as usize).checked_sub(1).and_then(|index| self.drives.0.get(index));
        let found = drive.filter(|it| from < it.until).map(|it| Driven {
            chord: it.motion.chord(from, to),
            components: it.components,
            gradient: it.motion.gradient_before(from, self.step.size),
        });
        self.last = Some((index, found));
        found
    }
}
