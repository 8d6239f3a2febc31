use crate::labels::{LoadChange, NodeMotion, NodeSums, OwnStep, Time};
use crate::node::{Change, Motion, Sums};
use engine::graph::task::{At, Body};
use grid::NODES;
use physics::table::Table;
use simd::Simd;

engine::task! {
    /// Gravity and damping on the nodes: v_I ← v_I + Δv(s + Δt) − Δv(s), with s the part of a material's step that has passed and
    ///
    /// Δv(s) = (e^(−αs) − 1) v⁰ + (ψ(s) − s) f/m + ψ(s) ḡ, ψ(s) = (1 − e^(−αs))/α,
    ///
    /// which solves v̇ = f/m + g − α v exactly over a step, however large α s is.
    pub struct Loads {
        /// What acts.
        pub field: LoadField,
        /// Mass below which a node carries nothing [kg].
        pub least_mass: f64,
    }

    Nodes task {
        requires new { time: Time, step: OwnStep, sums: NodeSums }
        computes { change: LoadChange }
        modifies { motion: NodeMotion }
    }
}

/// Accelerations that act everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadField {
    /// g [m/s²] in time.
    pub gravity: Table,
    /// α [1/s]
    pub damping: f64,
}

impl LoadField {
    /// (1 − e^(−αs))/α, the time that a damped motion is worth.
    pub fn worth(&self, s: f64) -> f64 {
        if self.damping > 0.0 { -(-self.damping * s).exp_m1() / self.damping } else { s }
    }

    /// ḡ from time `from` over a time `s` [m/s²].
    pub fn mean_gravity(&self, from: f64, s: f64) -> [f64; 3] {
        self.gravity.mean(from, s)
    }

    /// Δv of a node a time `s` after its step began at a time `from`.
    #[inline(always)]
    pub fn change(&self, sum: &Sums, motion: &Motion, from: f64, s: f64) -> [f64; 3] {
        let (start, f, g) = (motion.start(), sum.force(), self.mean_gravity(from, s));
        let (worth, faded) = (self.worth(s), (-self.damping * s).exp_m1());
        std::array::from_fn(|a| faded * start[a] + (worth - s) * f[a] / sum.mass() + worth * g[a])
    }
}

impl Body for Loads {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let now = io.time[0].time;
        let motions = io.motion.chunks_exact_mut(NODES).zip(io.change.chunks_exact_mut(NODES));
        for ((sums, (motions, changes)), field) in io.sums.chunks_exact(NODES).zip(motions).zip(at.fields) {
            let (from, until) = (now - field.elapsed, field.elapsed + field.tick);
            let before = field.elapsed - field.missed;
            let nodes = sums.iter().zip(motions.iter_mut().zip(changes));
            for (sum, (motion, whole)) in nodes {
                if sum.mass() <= self.least_mass {
                    *whole = Change::default();
                    continue;
                }
                let change = |s| self.field.change(sum, motion, from, s);
                let (old, new) = (if before > 0.0 { change(before) } else { [0.0; 3] }, change(until));
                motion.add([0, 1, 2].map(|a| new[a] - old[a]));
                *whole = Change::new(new);
            }
        }
    }
}
