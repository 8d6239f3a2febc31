//! What things are made of.
use physics::law::{Declared, MAX_COUNTS};
use physics::materials::AnyLaw;
use physics::motion::Course;
use physics::table::Table;

/// A material: a law and a velocity field.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name in the scene, in tables and in files.
    pub name: String,
    /// Density ρ₀ [kg/m³].
    pub density: f64,
    /// How it deforms.
    pub behavior: Behavior,
}

/// How a material deforms, or that it does not.
#[derive(Clone, Debug)]
pub enum Behavior {
    /// By a constitutive law.
    Deformable(AnyLaw),
    /// Not at all.
    Rigid(RigidMotion),
}

/// What moves a rigid body. All bodies of a rigid material form one rigid body.
#[derive(Clone, Debug)]
pub enum RigidMotion {
    /// Six degrees of freedom: contact and gravity move it. Initial angular velocity [rad/s].
    Free {
        /// ω at the start [rad/s], about the center of mass.
        angular_velocity: [f64; 3],
        /// Axes along which it does not move.
        locked: [bool; 3],
        /// Axes about which it does not turn.
        locked_turns: [bool; 3],
        /// A force at its center in time [N].
        force: Table,
    },
    /// It moves as prescribed, whatever meets it: a tool. It is its shape, and has no particles but to be seen.
    Prescribed {
        /// How its center moves.
        course: Course,
        /// Angular velocity in time [rad/s].
        spin: Table,
        /// Its center at the start [m]; `None`: that of its shape.
        center: Option<[f64; 3]>,
        /// Whether particles show where it is.
        visible: bool,
    },
}

impl Material {
    /// What its law declares; that of a rigid one declares nothing.
    pub fn declared(&self) -> Declared {
        match &self.behavior {
            Behavior::Deformable(law) => law.declared(),
            Behavior::Rigid(_) => Declared::default(),
        }
    }

    /// The states whose particles a run counts, with the place of each: those of its law, and `collapsed` ([`COLLAPSED`]).
    ///
    /// [`COLLAPSED`]: physics::quantities::COLLAPSED
    pub fn counted(&self) -> impl Iterator<Item = (&'static str, usize)> {
        let collapsed = (!self.is_rigid()).then_some(("collapsed", MAX_COUNTS));
        self.declared().counts.iter().copied().enumerate().map(|(place, name)| (name, place)).chain(collapsed)
    }

    /// Whether it does not deform.
    pub fn is_rigid(&self) -> bool {
        matches!(self.behavior, Behavior::Rigid(_))
    }

    /// Whether it is a rigid body that contact and loads move.
    pub fn is_free(&self) -> bool {
        matches!(self.behavior, Behavior::Rigid(RigidMotion::Free { .. }))
    }

    /// Whether it is a tool: rigid, with a motion that is prescribed.
    pub fn is_tool(&self) -> bool {
        matches!(self.behavior, Behavior::Rigid(RigidMotion::Prescribed { .. }))
    }

    /// Whether its bodies are filled with particles: those of a tool are only to be seen.
    pub fn has_particles(&self) -> bool {
        !matches!(self.behavior, Behavior::Rigid(RigidMotion::Prescribed { visible: false, .. }))
    }
}
