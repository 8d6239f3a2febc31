//! A law as plain functions of `f64` matrices, on every instruction set, and random states.
use nalgebra::{Matrix3, SymmetricEigen, Unit, UnitQuaternion, Vector3};
use physics::law::{Kinematics, Law, MAX_HISTORY, Reference};
use physics::materials::neo_hookean::NeoHookean;
use physics::materials::tissue::{NoFailure, Tissue, TwoSurface};
use simd::{Isa, Job, LANES, Mask, Simd, Wide};
use std::array::from_fn;

pub use crate::splitmix::Random;

pub type M3 = Matrix3<f64>;
pub type V3 = Vector3<f64>;

impl Answer {
    pub fn tells(&self, event: &str) -> bool {
        self.events.contains(&event)
    }
}

pub fn instruction_sets() -> Vec<Isa> {
    Isa::available()
}

/// A particle before a step ends: its new F, the step's relative deformation, the old history.
#[derive(Clone, Debug)]
pub struct Point {
    pub f: M3,
    pub increment: M3,
    pub history: Vec<f64>,
}

impl Point {
    /// From the undeformed state to F in one step.
    pub fn virgin<L: Law>(law: &L, f: M3, fiber: V3) -> Self {
        let mut history = vec![0.0; L::HISTORY.len()];
        law.initial(&Reference { fiber: fiber.into(), stretch: [1.0; 3] }, &mut history);
        Self { f, increment: f, history }
    }
    /// The next step of a particle.
    pub fn then(&self, answer: &Answer, increment: M3) -> Self {
        let f = if answer.frozen { self.increment.try_inverse().unwrap() * self.f } else { self.f };
        Self { f: increment * f, increment, history: answer.history.clone() }
    }
}

#[derive(Clone, Debug)]
pub struct Answer {
    pub kirchhoff: M3,
    pub modulus: f64,
    /// Names of what happened in the step.
    pub events: Vec<&'static str>,
    /// Names of the states that the particle is in.
    pub counted: Vec<&'static str>,
    pub inverted: bool,
    pub frozen: bool,
    pub strain: f64,
    pub plastic: f64,
    pub fracture: f64,
    pub history: Vec<f64>,
}

struct Step<'a, L>(&'a L, &'a [Point]);

impl<L: Law> Job for Step<'_, L> {
    type Output = Vec<Answer>;
    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<Answer> {
        let Step(law, points) = self;
        let n = points.len();
        let load = |at: &dyn Fn(usize) -> f64| S::load(&Wide(from_fn(|lane| at(lane % n))));
        let f = from_fn(|e| load(&|i| points[i].f[(e / 3, e % 3)]));
        let increment = from_fn(|e| load(&|i| points[i].increment[(e / 3, e % 3)]));
        let j = physics::tensor::determinant(&f);
        let k = Kinematics { f, j, increment };
        let mut history = [S::splat(0.0); MAX_HISTORY];
        let history = &mut history[..L::HISTORY.len()];
        for (v, slot) in history.iter_mut().enumerate() {
            *slot = load(&|i| points[i].history[v]);
        }
        let response = law.update(&k, history);
        let energies = law.energies(&k, history);
        let counts = law.counts(&k, history);
        let t = response.kirchhoff.map(S::lanes);
        let [modulus, strain, plastic, fracture] =
            [response.modulus, energies.strain, energies.plastic, energies.fracture].map(S::lanes);
        let e = response.events;
        let bit = |mask: Mask, i: usize| mask >> i & 1 == 1;
        let answer = |i: usize| Answer {
            kirchhoff: M3::new(
                t[0][i], t[1][i], t[2][i], t[1][i], t[3][i], t[4][i], t[2][i], t[4][i], t[5][i],
            ),
            modulus: modulus[i],
            events: L::EVENTS
                .iter()
                .zip(e.own)
                .filter(|&(_, mask)| bit(mask, i))
                .map(|(&name, _)| name)
                .collect(),
            counted: L::COUNTS
                .iter()
                .zip(counts)
                .filter(|&(_, mask)| bit(mask, i))
                .map(|(&name, _)| name)
                .collect(),
            inverted: bit(e.inverted, i),
            frozen: bit(e.frozen, i),
            strain: strain[i],
            plastic: plastic[i],
            fracture: fracture[i],
            history: history.iter().map(|v| v.lanes()[i]).collect(),
        };
        (0..n).map(answer).collect()
    }
}

/// All points, eight at a time.
pub fn run<L: Law>(isa: Isa, law: &L, points: &[Point]) -> Vec<Answer> {
    points.chunks(LANES).flat_map(|chunk| isa.dispatch(Step(law, chunk))).collect()
}

/// One point, on the best instruction set.
pub fn step<L: Law>(law: &L, point: &Point) -> Answer {
    run(Isa::detect(), law, std::slice::from_ref(point)).remove(0)
}

/// Largest minus smallest principal value of C = FᵀF.
pub fn span(f: &M3) -> f64 {
    let values = SymmetricEigen::new(f.transpose() * f).eigenvalues;
    values.max() - values.min()
}

pub const RUBBER: NeoHookean = NeoHookean { bulk: 1.0e5, shear: 4.2e3 };

/// The paper's myocardium with λ* of its slab (1.4) or of its other tests (1.3).
pub fn myocardium<F>(straight: f64, failure: F) -> Tissue<F> {
    Tissue { c1: 2.1e3, c3: 140.0, c4: 22.0, c5: 1e5, straight, bulk: 1e5, failure }
}

/// The paper's ligament.
pub fn ligament<F>(failure: F) -> Tissue<F> {
    Tissue { c1: 1.44e3, c3: 570.0, c4: 48.0, c5: 467e3, straight: 1.06, bulk: 3e5, failure }
}

/// All tissues of the paper, intact for ever.
pub fn tissues() -> [Tissue<NoFailure>; 3] {
    [myocardium(1.4, NoFailure), myocardium(1.3, NoFailure), ligament(NoFailure)]
}

/// The paper's criterion in the slab.
pub const PAPER: TwoSurface = TwoSurface { stretch: 1.4, span: 1.0, keeps_pressure: 0, crushes: 0 };

/// A criterion that no state meets.
pub const NEVER: TwoSurface = TwoSurface { stretch: 1e9, span: 1e9, ..PAPER };

/// Asserts |a − b| ≤ tolerance · scale.
#[track_caller]
pub fn close(a: f64, b: f64, tolerance: f64, scale: f64) {
    assert!(
        (a - b).abs() <= tolerance * scale.abs(),
        "{a} is not {b} (scale {scale}, tolerance {tolerance})"
    );
}

impl Random {
    pub fn direction(&mut self) -> V3 {
        let z = self.within(-1.0, 1.0);
        let (sin, cos) = self.within(0.0, std::f64::consts::TAU).sin_cos();
        let r = (1.0 - z * z).sqrt();
        V3::new(r * cos, r * sin, z)
    }
    pub fn rotation(&mut self) -> M3 {
        let axis = Unit::new_normalize(self.direction());
        *UnitQuaternion::from_axis_angle(&axis, self.within(0.0, 3.1)).to_rotation_matrix().matrix()
    }
    /// F with random axes, given principal stretches.
    pub fn with_stretches(&mut self, stretches: [f64; 3]) -> M3 {
        self.rotation() * M3::from_diagonal(&V3::from(stretches)) * self.rotation()
    }
    /// F with J in `j`, evenly in its logarithm, and isochoric stretches from 1/`most` to `most`.
    pub fn deformation(&mut self, j: [f64; 2], most: f64) -> M3 {
        let root = (self.within(j[0].ln(), j[1].ln()) / 3.0).exp();
        let bound = most.ln();
        loop {
            let (x, y) = (self.within(-bound, bound), self.within(-bound, bound));
            if (x + y).abs() <= bound {
                return self.with_stretches([x, y, -x - y].map(|x: f64| root * x.exp()));
            }
        }
    }
}
