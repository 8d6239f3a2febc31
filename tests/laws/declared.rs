//! A law of which no source of Sinew knows anything: what it declares arrives.
use crate::harness::*;
use engine::data::exact_sum::ExactSum;
use engine::data::rates::MaterialStep;
use engine::data::reduction::clear;
use engine::data::workspace::{Workspace, no_columns};
use engine::graph::task::{At, Runnable};
use engine::schema::{Home, Label, LabelId};
use grid::{IndexBox, Level, NODES};
use physics::law::{
    Declared, Energies, Kinematics, Law, MAX_COUNTS, MAX_EVENTS, Reference, Response, Variable, fits,
};
use physics::materials::neo_hookean::NeoHookean;
use simd::{LANES, Mask, Simd, Wide};
use tasks::labels::*;
use tasks::report::ReportLaw;
use tasks::stress::Stress;

/// Rubber that notes when it has swollen beyond a volume ratio.
#[derive(Clone, Copy)]
struct Swelling {
    elastic: NeoHookean,
    limit: f64,
}

impl Law for Swelling {
    const HISTORY: &'static [Variable] = &[
        Variable::new("fiber_y", "1", "y of the fibers"),
        Variable::new("swollen", "1", "whether it swelled").usual(),
    ];
    const EVENTS: &'static [&'static str] = &["swells"];
    const COUNTS: &'static [&'static str] = &["sound", "swollen"];

    fn initial(&self, reference: &Reference, history: &mut [f64]) {
        history[0] = reference.fiber[1];
    }

    #[inline(always)]
    fn update<S: Simd>(&self, k: &Kinematics<S>, history: &mut [S]) -> Response<S> {
        let was = history[1].ge(S::splat(1.0));
        let now = was | S::splat(self.limit).lt(k.j);
        history[1] = S::select(now, S::splat(1.0), S::splat(0.0));
        let mut response = self.elastic.update(k, &mut []);
        response.events.own[0] = now & !was;
        response
    }

    #[inline(always)]
    fn counts<S: Simd>(&self, _: &Kinematics<S>, history: &[S]) -> [Mask; MAX_COUNTS] {
        let swollen = history[1].ge(S::splat(1.0));
        let mut counts = [0; MAX_COUNTS];
        counts[0] = !swollen;
        counts[1] = swollen;
        counts
    }

    #[inline(always)]
    fn energies<S: Simd>(&self, k: &Kinematics<S>, _: &[S]) -> Energies<S> {
        self.elastic.energies(k, &[])
    }

    fn moduli(&self) -> (f64, f64) {
        self.elastic.moduli()
    }
}

const LAW: Swelling = Swelling { elastic: RUBBER, limit: 1.1 };
/// Not a whole number of tiles.
const PARTICLES: usize = 13;
const TILES: usize = PARTICLES.div_ceil(LANES);
const STEP: f64 = 1e-3;

/// A chunk of particles: columns by label.
struct Chunk(Vec<(LabelId, Vec<Wide>)>);

impl Chunk {
    fn new() -> Self {
        let lines = |label: LabelId| match label.home() {
            Home::Particle | Home::Chunk if label.by_material() => Swelling::HISTORY.len() * TILES,
            Home::Particle | Home::Chunk => label.width() * TILES,
            _ => label.width(),
        };
        let labels = [
            Position::ID,
            InitialVolume::ID,
            Identity::ID,
            VelocityGradient::ID,
            OwnStep::ID,
            KirchhoffStress::ID,
            StiffnessBound::ID,
            StressWork::ID,
            Fault::ID,
            FirstEvent::ID,
            Deformation::ID,
            History::ID,
            Volume::ID,
            MaterialEnergy::ID,
            StateCount::ID,
            LargestHistory::ID,
        ];
        let mut chunk = Self(labels.map(|label| (label, vec![Wide::default(); lines(label)])).into());
        let mut history = [0.0; 2];
        LAW.initial(&Reference { fiber: [0.6, 0.8, 0.0], stretch: [1.0; 3] }, &mut history);
        // lanes without a particle hold numbers, too
        for p in 0..TILES * LANES {
            // identities fall, so that the first particle is not the first lane
            chunk.set(Identity::ID, p, 0, f64::from_bits(100 - p as u64));
            (0..3).for_each(|a| chunk.set(Position::ID, p, a, (10 * a + p) as f64));
            (0..3).for_each(|a| chunk.set(Deformation::ID, p, 4 * a, 1.0));
            chunk.set(InitialVolume::ID, p, 0, 1e-6);
            (0..2).for_each(|h| chunk.set(History::ID, p, h, history[h]));
        }
        let step = MaterialStep { time: 0.25, size: STEP, first: 0.0, last: 1.0, unused: [0.0; 4] };
        chunk.column(OwnStep::ID).copy_from_slice(bytemuck::cast_slice(&[step]));
        chunk
    }

    fn column(&mut self, label: LabelId) -> &mut [Wide] {
        &mut self.0.iter_mut().find(|(id, _)| *id == label).unwrap().1
    }

    fn set(&mut self, label: LabelId, particle: usize, component: usize, value: f64) {
        let width = self.column(label).len() / TILES;
        self.column(label)[particle / LANES * width + component].0[particle % LANES] = value;
    }

    /// Sets the rate at which a particle swells, so that a step takes its volume ratio from J to J (1 + `growth`)³.
    fn swell(&mut self, particle: usize, growth: f64) {
        (0..3).for_each(|a| self.set(VelocityGradient::ID, particle, 4 * a, growth / STEP));
    }

    fn run(&mut self, task: &impl Runnable, isa: simd::Isa) {
        for label in [
            Fault::ID,
            FirstEvent::ID,
            MaterialEnergy::ID,
            StateCount::ID,
            LargestHistory::ID,
            StressWork::ID,
        ] {
            clear(label.combine(), self.column(label));
        }
        let origin = Level { lower: [0.0; 3], cell: 1.0, cells: [4; 3] }.origin([0; 3]);
        let (node, touched) = ([0; 3], IndexBox { lower: [0; 3], upper: [0; 3] });
        let at = At { origin, count: PARTICLES, node, nodes: NODES, touched, fields: &[] };
        let mut widths = vec![0; SCHEMA.len()];
        widths[History::ID.index()] = Swelling::HISTORY.len();
        let columns = no_columns(Vec::new(), SCHEMA.len());
        let mut space = Workspace { columns, chunk: 0..TILES, ahead: 0, widths: &widths };
        for (label, column) in &mut self.0 {
            space.columns[label.index()] = column;
        }
        task.run_on(isa, &at, &mut space);
    }

    fn counts(&mut self) -> Vec<f64> {
        bytemuck::cast_slice::<Wide, ExactSum>(self.column(StateCount::ID))
            .iter()
            .map(ExactSum::value)
            .collect()
    }
}

#[test]
fn what_a_law_declares_fits() {
    const { assert!(fits::<Swelling>()) };
    let declared = Declared::by::<Swelling>();
    assert_eq!((declared.history.len(), declared.events, declared.counts.len()), (2, &["swells"][..], 2));
    let Declared { history, shown, events, counts } = Declared::by::<NeoHookean>();
    assert!(history.is_empty() && shown.is_empty() && events.is_empty() && counts.is_empty());
}

/// Through the tasks that run it: the first event of a step by time and identity, and the particles in each state.
#[test]
fn events_and_states_of_any_law_are_told_and_counted() {
    for isa in instruction_sets() {
        let mut chunk = Chunk::new();
        chunk.run(&ReportLaw(LAW), isa);
        assert_eq!(chunk.counts(), [13.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], "{isa:?}");

        // in both tiles, and in a lane that holds no particle
        [3, 6, 11, 14].into_iter().for_each(|p| chunk.swell(p, 0.04));
        chunk.run(&Stress(LAW), isa);
        let first = chunk.column(FirstEvent::ID);
        assert_eq!(first[0].0[..5], [0.25, 89.0, 11.0, 21.0, 31.0], "{isa:?}");
        assert_eq!(first[1..], [Wide([f64::INFINITY; 8]); MAX_EVENTS - 1]);
        assert!(chunk.column(Fault::ID)[0].0[0].is_infinite());
        chunk.run(&ReportLaw(LAW), isa);
        assert_eq!(chunk.counts()[..2], [10.0, 3.0], "{isa:?}");
        let energies: Vec<_> = bytemuck::cast_slice::<Wide, ExactSum>(chunk.column(MaterialEnergy::ID))
            .iter()
            .map(ExactSum::value)
            .collect();
        let alone = step(&RUBBER, &Point::virgin(&RUBBER, M3::identity() * 1.04, V3::x())).strain;
        close(energies[1], 3.0 * 1e-6 * alone, 1e-12, energies[1]);

        // what has happened does not happen again; another particle is the first of its own step
        chunk.swell(2, 0.04);
        chunk.run(&Stress(LAW), isa);
        assert_eq!(chunk.column(FirstEvent::ID)[0].0[..2], [0.25, 98.0], "{isa:?}");
        chunk.run(&ReportLaw(LAW), isa);
        assert_eq!(chunk.counts()[..2], [9.0, 4.0], "{isa:?}");
    }
}

#[test]
fn each_answer_names_what_happened() {
    let swollen = Point::virgin(&LAW, M3::identity() * 1.2, V3::y());
    assert_eq!(swollen.history, [1.0, 0.0]);
    let answer = step(&LAW, &swollen);
    assert_eq!((answer.events.as_slice(), answer.counted.as_slice()), (&["swells"][..], &["swollen"][..]));
    let again = step(&LAW, &swollen.then(&answer, M3::identity()));
    assert_eq!((again.events.as_slice(), again.counted.as_slice()), (&[][..], &["swollen"][..]));
}
