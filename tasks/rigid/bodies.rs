//! Where free rigid bodies meet matter.
use super::state::{RigidState, RigidTrial};
use crate::bonds::bonded_to;
use crate::node::{Impulse, Motion, Site};
use crate::tool::{Meeting, Placed, Tool};
use engine::graph::task::At;
use grid::{Lattice, NODES};
use physics::contact::surface::SurfaceTable;
use physics::contact::{ContactLaw, Exchange, Pair, dot};

/// The free rigid bodies of a scene, with all that is needed to know whom they push.
#[derive(Clone, Debug)]
pub struct Bodies {
    /// Their shapes, and whom they meet, in the order of the scene.
    pub tools: Vec<Tool>,
    /// Where nodes are.
    pub lattice: Lattice,
    /// Where surfaces lie, for each material.
    pub surfaces: Vec<SurfaceTable>,
}

/// What a body gives to the matter at a node.
#[derive(Clone, Copy, Debug)]
pub struct Push<'a> {
    /// Its number in the list.
    pub number: usize,
    /// Its material.
    pub body: usize,
    /// Whom it meets.
    pub meeting: &'a Meeting,
    /// The line of the node among those of the block.
    pub line: usize,
    /// Where the node is [m].
    pub x: [f64; 3],
    /// From the center of the body [m].
    pub arm: [f64; 3],
    /// How the matter moves [m/s].
    pub velocity: [f64; 3],
    /// The matter that it moves there [kg].
    pub mass: f64,
    /// What the law sees.
    pub pair: Pair,
    /// And says.
    pub exchange: Exchange,
}

impl Push<'_> {
    /// m |v| of the matter [N s].
    pub fn momentum(&self) -> f64 {
        self.pair.reduced_mass * dot(self.velocity, self.velocity).sqrt()
    }

    /// On the matter [N s].
    pub fn impulse(&self) -> [f64; 3] {
        self.exchange.all()
    }
}

/// What drives hold has no end of mass; so many times that of the body is enough that it is stopped to as many digits in each tick, and not so
/// much that the search for its motion rounds it away.
const IMMOVABLE: f64 = 1e3;

/// How drives move what bonds make one at a node [m/s], if they hold any of it: along all axes, or scenes are refused.
pub fn held(sites: &[Site], mut lines: impl Iterator<Item = usize>) -> Option<[f64; 3]> {
    lines.find_map(|line| sites[line].held())
}

/// A block of nodes, with what is around its middle [cells].
const REACH: f64 = 6.0;

impl Bodies {
    /// Goes through all nodes of a block where bodies touch matter; `one` says what bonds make one. Where several touch one node they do so
    /// one after the other, in the order of the scene, each with what the one before has left.
    #[inline(never)]
    pub fn each_push<'a>(
        &'a self,
        at: &At<'_>,
        (sites, motions): (&[Site], &[Motion]),
        (states, trials): (&[RigidState], &[RigidTrial]),
        one: &[Impulse],
        mut push: impl FnMut(Push<'a>),
    ) {
        let near = self.near(at, states);
        if near.is_empty() {
            return;
        }
        for (slot, field) in at.fields.iter().enumerate() {
            let met = |(number, tool, placed)| {
                let tool: &'a Tool = tool;
                let meeting = tool.meets.iter().find(|meeting| meeting.material == field.material)?;
                Some((number, tool, placed, meeting))
            };
            let here: Vec<(usize, &'a Tool, &Placed, &'a Meeting)> =
                near.iter().map(|(number, tool, placed)| (*number, *tool, placed)).filter_map(met).collect();
            if here.is_empty() {
                continue;
            }
            let where_from = (&self.surfaces[field.material], self.lattice.cell);
            for n in 0..NODES {
                let line = NODES * slot + n;
                let site = &sites[line];
                if site.mass() <= 0.0 {
                    continue;
                }
                let (x, mut v) = (self.lattice.position(at.node_of(n)), motions[line].velocity());
                let held = held(sites, bonded_to(one, at.fields.len(), line).chain([line]));
                v = held.unwrap_or(v);
                for &(number, tool, placed, meeting) in &here {
                    let Some(body) = tool.body() else { continue };
                    let Some(normal) = meeting.touch((&tool.shape, placed), site, x, where_from) else {
                        continue;
                    };
                    // what bonds make one is pushed once
                    let before = || bonded_to(one, at.fields.len(), line).filter(|other| *other < line);
                    let touched = |other: usize| {
                        let material = at.fields[other / NODES].material;
                        let meeting = tool.meets.iter().find(|meeting| meeting.material == material);
                        let where_from = (&self.surfaces[material], self.lattice.cell);
                        let touch =
                            |it: &Meeting| it.touch((&tool.shape, placed), &sites[other], x, where_from);
                        sites[other].mass() > 0.0 && meeting.and_then(touch).is_some()
                    };
                    if before().any(touched) {
                        continue;
                    }
                    let arm: [f64; 3] = std::array::from_fn(|a| x[a] - placed.state.center[a]);
                    let moving = trials[body].velocity_at(arm);
                    let mut pair = meeting.pair(site, normal, std::array::from_fn(|a| v[a] - moving[a]));
                    let others = bonded_to(one, at.fields.len(), line);
                    pair.reduced_mass += others.map(|other| motions[other].mass()).sum::<f64>();
                    let mass = pair.reduced_mass;
                    if held.is_some() {
                        pair.reduced_mass = IMMOVABLE * states[body].mass;
                    }
                    let exchange = meeting.law.exchange(&pair);
                    let given =
                        Push { number, body, meeting, line, x, arm, velocity: v, mass, pair, exchange };
                    let impulse = given.impulse();
                    push(given);
                    (0..3).for_each(|a| v[a] += impulse[a] / pair.reduced_mass);
                }
            }
        }
    }

    /// The bodies that may touch nodes of a block.
    fn near<'a>(&'a self, at: &At<'_>, states: &[RigidState]) -> Vec<(usize, &'a Tool, Placed)> {
        let middle = self.lattice.position(at.node).map(|x| x + 1.5 * self.lattice.cell);
        let all =
            self.tools.iter().enumerate().map(|(number, tool)| (number, tool, tool.place(0.0, 0.0, states)));
        let reach = REACH * self.lattice.cell;
        all.filter(|(_, tool, placed)| placed.distance(&tool.shape, middle).0 < reach).collect()
    }
}
