//! What the ranks of the model have to do and to send.
use super::model::Costs;

/// The work of a rank in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Tasks on the rim [ns on one worker]: particles to nodes, nodes, nodes to particles.
    pub rim: [f64; 3],
    /// The same in the interior.
    pub inner: [f64; 3],
    /// Blocks of particles on the rim and in the interior.
    pub blocks: [f64; 2],
    /// What the engine does before the first task [ns].
    pub lists: f64,
    /// Looking for particles that leave [ns].
    pub relocate: f64,
    /// Slabs that the interior is worked on in.
    pub slabs: f64,
}

/// What a rank sends to another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Edge {
    /// To whom.
    pub to: u32,
    /// Partial node sums [B]; 0: no message.
    pub sums: f32,
    /// Motion of nodes [B]; 0: no message.
    pub motion: f32,
}

/// The ranks and who is beside whom.
pub trait Ranks {
    /// How many.
    fn count(&self) -> usize;

    /// The work of one of them.
    fn load(&self, rank: usize) -> Load;

    /// What it sends to those beside it; each of them gets travelers too.
    fn edges(&self, rank: usize, edges: &mut Vec<Edge>);
}

/// Blocks that a slab has at least, for each worker: see `exec::wave`.
const GRAIN: f64 = 48.0;

/// A rank's counts, before they are costs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counts {
    /// Particles by material, on the rim and in the interior.
    pub particles: Vec<[f64; 2]>,
    /// Blocks of nodes, once for each material, on the rim and in the interior.
    pub nodes: [f64; 2],
    /// Blocks of particles, on the rim and in the interior.
    pub blocks: [f64; 2],
    /// Patches.
    pub patches: f64,
}

impl Counts {
    /// All particles.
    pub fn all(&self) -> f64 {
        self.particles.iter().flatten().sum()
    }

    /// What it costs, on ranks of `threads` workers.
    pub fn load(&self, costs: &Costs, threads: usize) -> Load {
        let part = |part: usize| {
            let sum = |price: &[f64]| -> f64 {
                self.particles.iter().zip(price).map(|(count, price)| count[part] * price).sum()
            };
            [sum(&costs.give), self.nodes[part] * costs.node, sum(&costs.take)]
        };
        let blocks = self.blocks[0] + self.blocks[1];
        Load {
            rim: part(0),
            inner: part(1),
            blocks: self.blocks,
            lists: costs.step + costs.block * blocks + costs.patch * self.patches,
            relocate: costs.relocate * blocks,
            slabs: (blocks / (GRAIN * threads as f64)).floor().max(1.0),
        }
    }
}

/// Ranks that are listed one by one.
#[derive(Clone, Debug, Default)]
pub struct Listed {
    /// Their work.
    pub loads: Vec<Load>,
    /// What they send.
    pub edges: Vec<Vec<Edge>>,
}

impl Ranks for Listed {
    fn count(&self) -> usize {
        self.loads.len()
    }

    fn load(&self, rank: usize) -> Load {
        self.loads[rank]
    }

    fn edges(&self, rank: usize, edges: &mut Vec<Edge>) {
        edges.clear();
        edges.extend_from_slice(&self.edges[rank]);
    }
}
