//! The steps that materials would take if the run began now: an estimate from the scene alone.
use bytemuck::Zeroable;
use engine::data::rates::{Clock, MaterialStep};
use engine::data::schedule::Schedule;
use physics::law::Law;
use physics::materials::WithLaw;
use scene::{Behavior, Rates, RigidMotion, Scene};
use simd::{LANES, Wide};
use tasks::recipes;

/// How the steps of materials nest, as plain numbers from who knows the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// The most ticks in a step, if materials take steps of their own.
    pub most: Option<u32>,
    /// Estimated size of a tick [s].
    pub tick: f64,
    /// The material that the tick suits.
    pub fastest: usize,
    /// What each material would take now.
    pub own: Vec<StepAtRest>,
}

/// An estimated step of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepAtRest {
    /// Its size [s].
    pub size: f64,
    /// Its size in ticks.
    pub ticks: u64,
}

/// Steps at rest: undeformed, c² = (K + 4/3 μ)/ρ₀, with the velocities of the bodies. A run decides anew each step.
pub fn at_rest(scene: &Scene) -> Cycle {
    let (speeds, lines) = signals(scene);
    let mut clock = Clock { until: scene.run.until, ..Clock::zeroed() };
    let mut steps = vec![MaterialStep::zeroed(); speeds.len()];
    recipes::timestep_size(scene).decide(&mut clock, &mut steps, &lines);
    let signal = |m: &usize| speeds[*m].iter().sum::<f64>();
    let fastest = (0..speeds.len()).max_by(|a, b| signal(a).total_cmp(&signal(b))).unwrap_or(0);
    let own = steps.iter().map(|step| StepAtRest { size: step.size, ticks: (step.last - step.first) as u64 });
    let most = match scene.run.rates {
        Rates::Common => None,
        Rates::PerMaterial { most } => Some(most),
    };
    Cycle { most, tick: clock.tick, fastest, own: own.collect() }
}

/// The ticks of a step at rest, in order: who acts in each.
pub fn ticks_at_rest(scene: &Scene) -> Vec<Schedule> {
    let (_, lines) = signals(scene);
    let (size, mut ticks) = (recipes::timestep_size(scene), Vec::new());
    let mut clock = Clock { until: scene.run.until, ..Clock::zeroed() };
    let mut steps = vec![MaterialStep::zeroed(); lines.len()];
    loop {
        size.decide(&mut clock, &mut steps, &lines);
        ticks.push(Schedule::at(&clock, &steps));
        clock.number += 1.0;
        if clock.number >= clock.last {
            return ticks;
        }
    }
}

/// Speeds of all materials at rest, and as [`recipes::timestep_size`] wants them.
fn signals(scene: &Scene) -> (Vec<[f64; 2]>, Vec<[Wide; 3]>) {
    let speeds: Vec<[f64; 2]> = (0..scene.materials.len()).map(|m| speeds(scene, m)).collect();
    let line = |[c, v]: &[f64; 2]| [c + v, *c, *v].map(|speed| Wide([speed; LANES]));
    let lines = speeds.iter().map(line).collect();
    (speeds, lines)
}

/// The speed of sound at rest, and of the fastest body [m/s].
fn speeds(scene: &Scene, material: usize) -> [f64; 2] {
    let it = &scene.materials[material];
    let size = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let bodies = scene.bodies.iter().filter(|body| body.material == material);
    let bodies = bodies.map(|body| size(body.velocity)).fold(0.0, f64::max);
    match &it.behavior {
        Behavior::Deformable(law) => [(law.visit(WaveModulus) / it.density).sqrt(), bodies],
        Behavior::Rigid(RigidMotion::Free { .. }) => [0.0, bodies],
        // tools are heeded by those whom they meet
        Behavior::Rigid(RigidMotion::Prescribed { .. }) => [0.0; 2],
    }
}

/// K + 4/3 μ [Pa]
struct WaveModulus;

impl WithLaw for WaveModulus {
    type Output = f64;
    fn with<L: Law>(self, law: L) -> f64 {
        let (bulk, shear) = law.moduli();
        bulk + 4.0 / 3.0 * shear
    }
}
