use crate::labels::{ContactWork, NodeMotion, NodeSums, Reactions, RigidMotion, Time, ToolSums};
use crate::node::{Motion, Site, Sums, Surface};
use crate::reactions::Reaction;
use crate::tool::{Meeting, Placed, Tool};
use engine::data::schedule::FieldTime;
use engine::graph::task::{At, Body};
use grid::{Lattice, NODES};
use physics::contact::surface::SurfaceTable;
use physics::contact::{ContactLaw, dot};
use simd::Simd;

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

engine::task! { Nodes task Tools {
    requires new { time: Time, sums: NodeSums }
    requires now { bodies: RigidMotion, surfaces: ToolSums }
    computes { reactions: Reactions, work: ContactWork }
    modifies { motion: NodeMotion }
}}

impl Body for Tools {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let clock = &io.time[0];
        for tool in &self.tools {
            let placed = tool.place(clock.time, clock.tick, &io.bodies);
            for meeting in &tool.meets {
                let fields = at.fields.iter().enumerate().filter(|(_, f)| f.material == meeting.material);
                for (slot, field) in fields {
                    let lines = NODES * slot..NODES * (slot + 1);
                    let nodes = Nodes {
                        sums: &io.sums[lines.clone()],
                        surfaces: &io.surfaces[lines.clone()],
                        motions: &mut io.motion[lines],
                    };
                    let given = self.meet(at, field, (tool, &placed, meeting), nodes);
                    given.by_holder.store(&mut io.reactions[tool.tile]);
                    if let Some((tile, sign)) = meeting.tile {
                        given.by_holder.without_work().times(sign).store(&mut io.reactions[tile]);
                    }
                    io.work[0][0].add(given.friction);
                    io.work[0][1].add(given.impact);
                }
            }
        }
    }
}

/// The nodes of one field.
struct Nodes<'a> {
    sums: &'a [Sums],
    surfaces: &'a [Surface],
    motions: &'a mut [Motion],
}

/// What a tool gives to some nodes.
#[derive(Default)]
struct Given {
    by_holder: Reaction,
    friction: f64,
    impact: f64,
}

impl Tools {
    /// Exchanges impulses at all nodes of a field.
    #[inline(never)]
    fn meet(
        &self,
        at: &At<'_>,
        field: &FieldTime,
        (tool, placed, meeting): (&Tool, &Placed, &Meeting),
        nodes: Nodes<'_>,
    ) -> Given {
        let mut given = Given::default();
        for (n, motion) in nodes.motions.iter_mut().enumerate() {
            let (sum, surface) = (&nodes.sums[n], &nodes.surfaces[n]);
            let m = sum.mass();
            if m <= self.least_mass || surface.mass() <= 0.0 {
                continue;
            }
            let (x, v) = (self.lattice.position(at.node_of(n)), motion.velocity());
            let site = Site::of(sum, surface, field.elapsed, v);
            let where_from = (&self.surfaces[meeting.material], self.lattice.cell);
            let Some(normal) = meeting.touch((&tool.shape, placed), &site, x, where_from) else { continue };
            let moving = placed.state.velocity_at(x);
            let pair = meeting.pair(&site, normal, std::array::from_fn(|a| v[a] - moving[a]));
            let exchange = meeting.law.exchange(&pair);
            let impulse = std::array::from_fn(|a| exchange.normal[a] + exchange.friction[a]);
            motion.add(impulse.map(|p| p / m));
            given.by_holder.add(x, impulse, moving);
            let slip: [f64; 3] = std::array::from_fn(|a| motion.mean()[a] - moving[a]);
            given.friction -= dot(exchange.friction, slip);
            given.impact -= dot(exchange.normal, slip);
        }
        given
    }
}
