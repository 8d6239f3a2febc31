use crate::bonds::bonded_to;
use crate::labels::{ContactWork, NodeMotion, NodeSums, Reactions, RigidMotion, Time, ToolSums};
use crate::node::{Impulse, Motion, Site, Sums, Surface};
use crate::reactions::{NUMBERS, Reaction};
use crate::rigid::state::RigidState;
use crate::tool::{Meeting, Placed, Tool};
use engine::data::exact_sum::ExactSum;
use engine::data::rates::Clock;
use engine::data::schedule::FieldTime;
use engine::graph::task::{At, Body};
use grid::{Lattice, NODES};
use physics::contact::surface::SurfaceTable;
use physics::contact::{ContactLaw, Exchange, dot};
use simd::Simd;

engine::task! {
    /// Contact with tools that move as prescribed, and with moving faces: the law takes u = v_I − V(x_I) wherever matter touches them.
    pub struct Tools {
        /// The tools, in the order of the scene.
        pub tools: Vec<Tool>,
        /// Where nodes are.
        pub lattice: Lattice,
        /// Mass below which a node carries nothing [kg].
        pub least_mass: f64,
        /// Where surfaces lie, for each material.
        pub surfaces: Vec<SurfaceTable>,
    }

    Nodes task {
        requires new { time: Time, sums: NodeSums }
        requires now { bodies: RigidMotion, surfaces: ToolSums }
        computes { reactions: Reactions, work: ContactWork }
        modifies { motion: NodeMotion }
    }
}

impl Body for Tools {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let Io { time, sums, bodies, surfaces, reactions, work, motion } = &mut io;
        let nodes = Nodes { sums, surfaces, motions: motion, one: &[] };
        self.act(at, (&time[0], bodies), nodes, (reactions, &mut work[0]));
    }
}

/// The nodes of a block, and what bonds make one there.
pub(crate) struct Nodes<'a> {
    pub sums: &'a [Sums],
    pub surfaces: &'a [Surface],
    pub motions: &'a mut [Motion],
    /// Nothing, where there are no bonds.
    pub one: &'a [Impulse],
}

/// What a tool that moves with a velocity exchanged with a node, whose loss is known when all have.
struct Loss {
    line: usize,
    exchange: Exchange,
    moving: [f64; 3],
}

impl Tools {
    /// All tools, one after the other.
    pub(crate) fn act(
        &self,
        at: &At<'_>,
        (clock, bodies): (&Clock, &[RigidState]),
        mut nodes: Nodes<'_>,
        (reactions, work): (&mut [[ExactSum; NUMBERS]], &mut [ExactSum; 2]),
    ) {
        let mut losses = Vec::new();
        for tool in &self.tools {
            let placed = tool.place(clock.time, clock.tick, bodies);
            for meeting in &tool.meets {
                let fields = at.fields.iter().enumerate().filter(|(_, f)| f.material == meeting.material);
                for (slot, field) in fields {
                    let given =
                        self.meet(at, (slot, field), (tool, &placed, meeting), &mut nodes, &mut losses);
                    given.store(&mut reactions[tool.tile]);
                    if let Some((tile, sign)) = meeting.tile {
                        given.without_work().times(sign).store(&mut reactions[tile]);
                    }
                }
            }
        }
        // with the motion that all tools make
        let (mut friction, mut impact) = (0.0, 0.0);
        for loss in &losses {
            let mean = nodes.motions[loss.line].mean();
            let slip: [f64; 3] = std::array::from_fn(|a| mean[a] - loss.moving[a]);
            friction -= dot(loss.exchange.friction, slip);
            impact -= dot(loss.exchange.normal, slip);
        }
        work[0].add(friction);
        work[1].add(impact);
    }

    /// Exchanges impulses at all nodes of a field. What bonds make one with it moves along.
    #[inline(never)]
    fn meet(
        &self,
        at: &At<'_>,
        (slot, field): (usize, &FieldTime),
        (tool, placed, meeting): (&Tool, &Placed, &Meeting),
        nodes: &mut Nodes<'_>,
        losses: &mut Vec<Loss>,
    ) -> Reaction {
        let mut given = Reaction::default();
        for n in 0..NODES {
            let line = NODES * slot + n;
            let (sum, surface) = (&nodes.sums[line], &nodes.surfaces[line]);
            let m = sum.mass();
            if m <= self.least_mass || surface.mass() <= 0.0 {
                continue;
            }
            let (x, v) = (self.lattice.position(at.node_of(n)), nodes.motions[line].velocity());
            let site = Site::of(sum, surface, field.elapsed, v, [None; 3]);
            let where_from = (&self.surfaces[meeting.material], self.lattice.cell);
            let Some(normal) = meeting.touch((&tool.shape, placed), &site, x, where_from) else { continue };
            let moving = placed.state.velocity_at(x);
            let mut pair = meeting.pair(&site, normal, std::array::from_fn(|a| v[a] - moving[a]));
            let others = || bonded_to(nodes.one, at.fields.len(), line);
            pair.reduced_mass += others().map(|other| nodes.motions[other].mass()).sum::<f64>();
            let exchange = meeting.law.exchange(&pair);
            let impulse: [f64; 3] = std::array::from_fn(|a| exchange.normal[a] + exchange.friction[a]);
            let dv = impulse.map(|p| p / pair.reduced_mass);
            bonded_to(nodes.one, at.fields.len(), line).for_each(|other| nodes.motions[other].add(dv));
            nodes.motions[line].add(dv);
            given.add(x, impulse, moving);
            losses.push(Loss { line, exchange, moving });
        }
        given
    }
}

pub use bonded::BondedTools;

mod bonded {
    use super::*;
    use crate::labels::ContactImpulse;

    engine::task! {
        /// As `Tools`, where bonds make one of several materials.
        pub struct BondedTools(pub Tools);

        Nodes task {
            requires new { time: Time, sums: NodeSums }
            requires now { bodies: RigidMotion, surfaces: ToolSums, one: ContactImpulse }
            computes { reactions: Reactions, work: ContactWork }
            modifies { motion: NodeMotion }
        }
    }

    impl Body for BondedTools {
        #[inline(always)]
        fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
            let Io { time, sums, bodies, surfaces, one, reactions, work, motion } = &mut io;
            let nodes = Nodes { sums, surfaces, motions: motion, one };
            self.0.act(at, (&time[0], bodies), nodes, (reactions, &mut work[0]));
        }
    }
}
