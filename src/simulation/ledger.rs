//! Accounts of energy and momentum over a run.
use super::half_step::HalfStep;
use super::report::{Energies, FirstEvent, GiverReport, MaterialReport, Report, as_one};
use engine::data::exact_sum::ExactSum;
use engine::data::rates::Clock;
use engine::data::shared::Shared;
use engine::data::warehouse::{MaterialData, Warehouse};
use engine::exec::traveler::Traveler;
use engine::graph::build::TaskGraph;
use engine::schema::{Label, LabelId};
use physics::law::{MAX_COUNTS, MAX_EVENTS, MAX_HISTORY};
use scene::Scene;
use simd::Wide;
use tasks::labels;
use tasks::reactions::NUMBERS;
use tasks::recipes::{Giver, Givers};
use tasks::rigid::state::RigidState;

/// What the report graph computes.
pub const REPORTED: &[LabelId] = &[
    labels::MaterialEnergy::ID,
    labels::MaterialMotion::ID,
    labels::MaterialExtent::ID,
    labels::StateCount::ID,
    labels::LargestHistory::ID,
];

/// Running totals of what particles do not remember.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    initial_energy: f64,
    /// About the origin [N m s].
    initial_spin: [f64; 3],
    friction: f64,
    impact: f64,
    transfer: f64,
    half_step: HalfStep,
    /// What each giver has given: the numbers of its tile of `Reactions`.
    given: Vec<[f64; NUMBERS]>,
    /// Σ |work| of what gives from outside, step by step [J].
    turned: f64,
    /// The most energy that there was at a report [J].
    most: f64,
    /// `given` at the last row of the history, and when that was [s].
    row: (f64, Vec<[f64; NUMBERS]>),
    deleted: u64,
    deleted_energy: f64,
    reflected: u64,
    /// The first of each event, by material.
    first: Vec<[Option<FirstEvent>; MAX_EVENTS]>,
}

impl Ledger {
    /// Remembers the energy at the start.
    pub fn begin(&mut self, report: &Report, givers: usize) {
        self.given = vec![[0.0; NUMBERS]; givers];
        self.row = (report.time, self.given.clone());
        self.initial_energy = report.energy().total();
        self.most = self.initial_energy;
        self.initial_spin = report.angular_momentum();
        self.first = vec![[None; MAX_EVENTS]; report.materials.len()];
        self.half_step = HalfStep::new(report.materials.len());
    }

    /// The totals as numbers, for a checkpoint.
    pub fn numbers(&self) -> Vec<f64> {
        let mut numbers = vec![self.initial_energy, self.friction, self.impact, self.transfer];
        numbers.extend([f64::from_bits(self.deleted), self.deleted_energy, f64::from_bits(self.reflected)]);
        numbers.extend([self.row.0, self.turned, self.most]);
        numbers.extend(self.initial_spin);
        numbers.extend(self.half_step.numbers());
        numbers.extend(self.given.iter().chain(&self.row.1).flatten());
        for first in self.first.iter().flatten() {
            numbers.extend(first.map_or([f64::NAN; 5], |f| {
                [f.time, f64::from_bits(f.particle), f.position[0], f.position[1], f.position[2]]
            }));
        }
        numbers
    }

    /// From its numbers; `None` if they are not those of a ledger of so many materials and givers.
    pub fn from_numbers(numbers: &[f64], materials: usize, givers: usize) -> Option<Self> {
        let (totals, rest) = numbers.split_first_chunk::<13>()?;
        let [initial_energy, friction, impact, transfer, deleted, deleted_energy, reflected, rest_of @ ..] =
            *totals;
        let [row, turned, most, initial_spin @ ..] = rest_of;
        let (half_step, rest) = rest.split_at_checked(3 + materials)?;
        let (given, events) = rest.split_at_checked(2 * givers * NUMBERS)?;
        let (given, at_row) = given.as_chunks::<NUMBERS>().0.split_at(givers);
        let first = |&[time, particle, x, y, z]: &[f64; 5]| {
            let particle = particle.to_bits();
            (!time.is_nan()).then_some(FirstEvent { time, particle, position: [x, y, z] })
        };
        let (events, left) = events.as_chunks::<5>();
        let (events, more) = events.as_chunks::<MAX_EVENTS>();
        let whole = left.is_empty() && more.is_empty() && events.len() == materials;
        let half_step = HalfStep::from_numbers(half_step)?;
        whole.then(|| Self {
            half_step,
            initial_energy,
            initial_spin,
            friction,
            impact,
            transfer,
            given: given.to_vec(),
            turned,
            most,
            row: (row, at_row.to_vec()),
            deleted: deleted.to_bits(),
            deleted_energy,
            reflected: reflected.to_bits(),
            first: events.iter().map(|all| all.each_ref().map(first)).collect(),
        })
    }

    /// Adds what a graph has just summed up.
    pub fn add(&mut self, graph: &TaskGraph, shared: &Shared) {
        if graph.computes(labels::ContactWork::ID) {
            let work: [ExactSum; 2] = shared.get(labels::ContactWork::ID, 0);
            self.friction += work[0].value();
            self.impact += work[1].value();
        }
        if graph.computes(labels::TransferLoss::ID) {
            self.transfer += shared.get::<ExactSum>(labels::TransferLoss::ID, 0).value();
        }
        self.half_step.add(graph, shared);
        if graph.computes(labels::Reactions::ID) {
            self.add_reactions(shared);
        }
        if graph.computes(labels::FirstEvent::ID) {
            self.add_events(shared);
        }
    }

    fn add_reactions(&mut self, shared: &Shared) {
        let tiles: &[[ExactSum; NUMBERS]] = bytemuck::cast_slice(shared.column(labels::Reactions::ID));
        for (given, tile) in self.given.iter_mut().zip(tiles) {
            let before = given[NUMBERS - 1];
            given.iter_mut().zip(tile).for_each(|(total, sum)| *total += sum.value());
            self.turned += (given[NUMBERS - 1] - before).abs();
        }
    }

    fn add_events(&mut self, shared: &Shared) {
        for (material, known) in self.first.iter_mut().enumerate() {
            let lines: [Wide; MAX_EVENTS] = shared.get(labels::FirstEvent::ID, material);
            for (known, line) in
                known.iter_mut().zip(lines).filter(|(k, line)| k.is_none() && line.0[0].is_finite())
            {
                let [time, particle, x, y, z, ..] = line.0;
                *known = Some(FirstEvent { time, particle: particle as u64, position: [x, y, z] });
            }
        }
    }

    /// Keeps the most energy that there was.
    pub fn note(&mut self, report: &Report) {
        self.most = self.most.max(report.energy().total());
    }

    /// A row of the history has been written: mean forces are taken from here on.
    pub fn mark(&mut self, time: f64) {
        self.row = (time, self.given.clone());
    }

    /// What givers have given until a time [s].
    fn givers(&self, scene: &Scene, time: f64) -> Vec<GiverReport> {
        let (since, before) = &self.row;
        let all = Givers::of(scene).0.into_iter().zip(self.given.iter().zip(before));
        let one = |(giver, (now, before)): (Giver, (&[f64; NUMBERS], &[f64; NUMBERS]))| {
            let vector = |first: usize| [now[first], now[first + 1], now[first + 2]];
            let duration = time - since;
            let rate = |n: usize| if duration > 0.0 { (now[n] - before[n]) / duration } else { 0.0 };
            GiverReport {
                giver,
                name: giver.name(scene),
                impulse: vector(0),
                torque_impulse: vector(3),
                work: now[6],
                displacement: match giver {
                    Giver::Drive(drive) => Some(scene.drives[drive].motion.course.way(0.0, time)),
                    _ => None,
                },
                force: [0, 1, 2].map(rate),
                torque: [3, 4, 5].map(rate),
            }
        };
        all.map(one).collect()
    }

    /// Counts particles that came back into the domain.
    pub fn reflect(&mut self, particles: u64) {
        self.reflected += particles;
    }

    /// Counts a particle that left the domain.
    pub fn delete(&mut self, left: &Traveler, materials: &[MaterialData]) {
        let (mass, velocity) =
            (left.numbers(materials, labels::Mass::ID)[0], left.numbers(materials, labels::Velocity::ID));
        self.deleted += 1;
        self.deleted_energy += 0.5 * mass * velocity.iter().map(|v| v * v).sum::<f64>();
    }

    /// The accounts, from what the report graph has just summed.
    pub fn report(&self, scene: &Scene, warehouse: &Warehouse, steps: u64) -> Report {
        let clock: Clock = warehouse.shared.get(labels::Time::ID, 0);
        let limit = scene.materials.get(clock.limited_by as usize).filter(|_| clock.limited_by >= 0.0);
        let givers = self.givers(scene, clock.time);
        let outside = || givers.iter().filter(|it| it.giver.is_outside());
        let boundary_impulse = [0, 1, 2].map(|a| outside().map(|it| it.impulse[a]).sum());
        let boundary_work = outside().map(|it| it.work).sum();
        let mut report = Report {
            // measured by themselves
            probes: Vec::new(),
            time: clock.time,
            steps,
            step: clock.tick,
            limited_by: limit.map_or("end", |m| &m.name).to_owned(),
            materials: (0..scene.materials.len()).map(|m| self.material(scene, warehouse, m)).collect(),
            friction: self.friction,
            impact: self.impact,
            transfer: self.transfer + self.half_step.transfer(),
            half_step: self.half_step.ahead(),
            boundary_work,
            boundary_impulse,
            givers,
            deleted_energy: self.deleted_energy,
            deleted: self.deleted,
            reflected: self.reflected,
            residual: 0.0,
            spin_lost: [0.0; 3],
            turnover: 0.0,
        };
        let lost = report.friction + report.impact + report.transfer + report.deleted_energy;
        let now = report.energy().total() + report.half_step + lost;
        report.residual = self.initial_energy + boundary_work - now;
        let given = |a: usize| {
            let outside = report.givers.iter().filter(|it| it.giver.is_outside());
            outside.map(|it| it.torque_impulse[a]).sum::<f64>()
        };
        let spin = report.angular_momentum();
        report.spin_lost = [0, 1, 2].map(|a| self.initial_spin[a] + given(a) - spin[a]);
        report.turnover = self.most.max(report.energy().total()) + self.turned;
        report
    }

    fn material(&self, scene: &Scene, warehouse: &Warehouse, material: usize) -> MaterialReport {
        let shared = &warehouse.shared;
        let values = |label, range: std::ops::Range<usize>| -> Vec<f64> {
            let lines = shared.column(label);
            let sums: &[ExactSum] = bytemuck::cast_slice(lines);
            let width = sums.len() / warehouse.materials.len();
            sums[material * width..][range].iter().map(ExactSum::value).collect()
        };
        let energy = values(labels::MaterialEnergy::ID, 0..5);
        let motion = values(labels::MaterialMotion::ID, 0..10);
        let counts = values(labels::StateCount::ID, 0..MAX_COUNTS + 1);
        let most = |line: &Wide| line.0.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let [x, y, z, left, front, below] =
            shared.get::<[Wide; 6]>(labels::MaterialExtent::ID, material).each_ref().map(most);
        let extent = [[-left, -front, -below], [x, y, z]];
        let largest = shared.get::<[Wide; MAX_HISTORY]>(labels::LargestHistory::ID, material);
        let law = scene.materials[material].declared();
        let first = self.first.get(material).copied().unwrap_or_default();
        let vector = |first: usize| [motion[first], motion[first + 1], motion[first + 2]];
        let center = vector(4).map(|c| if motion[0] > 0.0 { c / motion[0] } else { 0.0 });
        let it = &scene.materials[material];
        let rigid = it.is_rigid().then(|| shared.get::<RigidState>(labels::RigidMotion::ID, material));
        let tool = rigid.filter(|_| it.is_tool());
        let gone = |state: &RigidState| [0, 1, 2].map(|a| state.center[a] - state.origin[a]);
        let blocks = warehouse.blocks().filter(|(m, _)| *m == material);
        let report = MaterialReport {
            energies: Energies {
                kinetic: energy[0],
                strain: energy[1],
                plastic: energy[2],
                fracture: energy[3],
                viscous: energy[4],
            },
            mass: motion[0],
            momentum: vector(1),
            tool: tool.map(|state| state.velocity),
            rigid: rigid.map(|state| [gone(&state), state.angular]),
            center: tool.map_or(center, |state| state.center),
            extent: extent.as_flattened().iter().all(|x| x.is_finite()).then_some(extent),
            largest: law.history.iter().zip(&largest).map(|(it, line)| (it.name, most(line))).collect(),
            angular_momentum: vector(7),
            counts: it.counted().map(|(name, place)| (name, counts[place] as u64)).collect(),
            particles: blocks.map(|(_, b)| b.count as u64).sum(),
            first: law.events.iter().copied().zip(first).collect(),
        };
        match rigid.filter(|_| it.is_free()) {
            Some(body) => as_one(report, &body),
            None => report,
        }
    }
}
