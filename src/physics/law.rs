//! What a constitutive law is to the rest of Sinew: a pure function of one particle's deformation and
//! history, written once for eight particles at a time.
use crate::quantities::Quantity;
use simd::{Mask, Simd};

/// The most numbers of history that a law may keep per particle.
pub const MAX_HISTORY: usize = 12;
/// The most kinds of events that a law may tell.
pub const MAX_EVENTS: usize = 4;
/// The most counts of particles that a law may report.
pub const MAX_COUNTS: usize = 8;

/// One number that a particle carries for its law; it is stored, moved, written and restarted by name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variable {
    /// Name in output files, for example `failure`.
    pub name: &'static str,
    /// Unit in output files.
    pub unit: &'static str,
    /// What it is, in a line.
    pub meaning: &'static str,
    /// What its values mean, from 0 on, if they are codes.
    pub codes: &'static [&'static str],
    /// Whether frames show it if a scene does not say what to show.
    pub usual: bool,
}

impl Variable {
    /// A number that frames show if a scene asks for it.
    pub const fn new(name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        Self { name, unit, meaning, codes: &[], usual: false }
    }

    /// The same, shown if a scene does not say what to show.
    pub const fn usual(self) -> Self {
        Self { usual: true, ..self }
    }

    /// The same, with values that mean something each.
    pub const fn codes(self, codes: &'static [&'static str]) -> Self {
        Self { codes, ..self }
    }
}

/// What a scene says of a particle of the undeformed body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// Unit vector along its fibers.
    pub fiber: [f64; 3],
    /// How far the body is stretched along x, y and z at the start.
    pub stretch: [f64; 3],
}

/// Deformation of eight particles after a step.
#[derive(Clone, Copy)]
pub struct Kinematics<S> {
    /// Deformation gradient F, row by row.
    pub f: [S; 9],
    /// J = det F
    pub j: S,
    /// Relative deformation gradient of the step, F_new = f F_old, row by row.
    pub increment: [S; 9],
}

/// What a law answers.
#[derive(Clone, Copy)]
pub struct Response<S> {
    /// Kirchhoff stress τ = J σ [Pa]: xx, xy, xz, yy, yz, zz.
    pub kirchhoff: [S; 6],
    /// Upper bound of ρ₀ c² over all directions and polarizations [Pa].
    pub modulus: S,
    /// What happened to whom.
    pub events: Events,
}

/// What happened in a step, one bit a particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Events {
    /// The law's own, in the order of [`Law::EVENTS`]: set in the step in which it happens only.
    pub own: [Mask; MAX_EVENTS],
    /// The deformation is not admissible (J ≤ 0 or not a number) and the law has no policy for it: the run stops.
    pub inverted: Mask,
    /// The particle keeps the F that it had before the step (it carries no stress any more).
    pub frozen: Mask,
}

/// Lanes whose volume ratio is not positive and finite.
#[inline(always)]
pub fn inadmissible<S: Simd>(j: S) -> Mask {
    !(S::splat(0.0).lt(j) & j.lt(S::splat(f64::INFINITY)))
}

/// Energy densities of eight particles, per reference volume [J/m³].
#[derive(Clone, Copy)]
pub struct Energies<S> {
    /// Stored elastically.
    pub strain: S,
    /// Spent on plastic flow so far.
    pub plastic: S,
    /// Stored energy that failure has released so far.
    pub fracture: S,
}

/// The state of [`Law::COUNTS`] in which a particle has lost its stability: a plane wave has no real speed, strain gathers in
/// single cells, and what comes out depends on their size. A run warns of it.
pub const UNSTABLE: &str = "unstable";

/// A constitutive law. Its parameters are its fields; `S` is the vector type of an instruction set.
///
/// A new law is one file with an implementation of this trait and of
/// [`Described`](super::parameter::Described), and one line in [`materials`](super::materials). What it declares here is
/// stored, moved, counted and written by name.
pub trait Law: Copy + Send + Sync + 'static {
    /// The numbers that a particle carries besides F; at most [`MAX_HISTORY`].
    const HISTORY: &'static [Variable];

    /// What can be shown of its particles beside that and what all particles have.
    const SHOWN: &'static [Quantity] = &[];

    /// Names of what can happen to a particle of this law; at most [`MAX_EVENTS`]. A run tells when and where each happened
    /// first.
    const EVENTS: &'static [&'static str] = &[];

    /// Names of the states whose particles a run counts; at most [`MAX_COUNTS`].
    const COUNTS: &'static [&'static str] = &[];

    /// History of a particle at the start, which may be stretched elastically. `history` has `HISTORY.len()` entries, all zero.
    fn initial(&self, reference: &Reference, history: &mut [f64]);

    /// Stress and new history after a step. `history` has `HISTORY.len()` entries.
    fn update<S: Simd>(&self, kinematics: &Kinematics<S>, history: &mut [S]) -> Response<S>;

    /// Which particles are in each state of [`Law::COUNTS`], in its order; of the kinematics F and J alone count.
    #[inline(always)]
    fn counts<S: Simd>(&self, _kinematics: &Kinematics<S>, _history: &[S]) -> [Mask; MAX_COUNTS] {
        [0; MAX_COUNTS]
    }

    /// Energies in the present state.
    fn energies<S: Simd>(&self, kinematics: &Kinematics<S>, history: &[S]) -> Energies<S>;

    /// Small-strain bulk and shear modulus [Pa]: for estimates before a run.
    fn moduli(&self) -> (f64, f64);
}

/// What a law declares, as values.
#[derive(Clone, Copy, Debug, Default)]
pub struct Declared {
    /// [`Law::HISTORY`]
    pub history: &'static [Variable],
    /// [`Law::SHOWN`]
    pub shown: &'static [Quantity],
    /// [`Law::EVENTS`]
    pub events: &'static [&'static str],
    /// [`Law::COUNTS`]
    pub counts: &'static [&'static str],
}

impl Declared {
    /// What `L` declares.
    pub const fn by<L: Law>() -> Self {
        Self { history: L::HISTORY, shown: L::SHOWN, events: L::EVENTS, counts: L::COUNTS }
    }
}

/// Whether a law declares no more than there is room for.
pub const fn fits<L: Law>() -> bool {
    L::HISTORY.len() <= MAX_HISTORY && L::EVENTS.len() <= MAX_EVENTS && L::COUNTS.len() <= MAX_COUNTS
}
