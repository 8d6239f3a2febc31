use crate::drives::{Driven, Drives};
use crate::images::Images;
use crate::labels::{
    DriveGift, DriveIndex, GridVelocity, Mass, OwnStep, Position, Reactions, TransferLoss, Velocity,
    VelocityChange, Weights,
};
use crate::reactions::Reaction;
use engine::graph::task::{At, Body};
use grid::Lattice;
use simd::{LANES, Simd};

engine::task! {
    /// Particles of a driven region go where their drive takes them, whatever the nodes say. What the drive gives is what it gave to
    /// their nodes, shared by mass, and what the particles take beyond that.
    pub struct Drive {
        /// The drives.
        pub drives: Drives,
        /// The tile of `Reactions` of the first of them.
        pub first: usize,
        /// Faces: nodes beyond them have what their images have.
        pub images: Images,
        /// Where nodes are.
        pub lattice: Lattice,
    }

    Particles task {
        requires old { index: DriveIndex, mass: Mass, position: Position, velocity: Velocity }
        requires new { weights: Weights, gift: DriveGift @ 3 }
        requires now { step: OwnStep }
        computes { reactions: Reactions, loss: TransferLoss }
        modifies { grid_velocity: GridVelocity, change: VelocityChange }
    }
}

impl Body for Drive {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let mut drives = self.drives.during(&io.step[0]);
        for (tile, index) in io.index.iter().enumerate() {
            for lane in (0..LANES).filter(|&lane| index.0[lane] > 0.0) {
                let Some(Driven { chord, components, .. }) = drives.of(index.0[lane]) else { continue };
                let (x, v) = (io.position[tile].map(|x| x.0[lane]), io.velocity[tile].map(|v| v.0[lane]));
                let (m, wanted) = (io.mass[tile].0[lane], chord.velocity(x));
                let (on_grid, dv) = (&mut io.grid_velocity[tile], &mut io.change[tile]);
                let (mut mean, mut given) = ([0.0; 3], [0.0; 3]);
                for a in (0..3).filter(|&a| components[a]) {
                    (mean[a], given[a]) = (0.5 * (v[a] + wanted[a]), m * (wanted[a] - v[a] - dv[a].0[lane]));
                    (on_grid[a].0[lane], dv[a].0[lane]) = (wanted[a], wanted[a] - v[a]);
                }
                let mut reaction = Reaction::default();
                reaction.add(x, given, mean);
                // what particles take from the drive and not from nodes is no gain of the transfer
                io.loss[0].add(reaction.work);
                for (line, s, _) in io.weights[tile].nodes(lane, &at.origin) {
                    let node = at.origin.node_at(line);
                    let (image, signs) = self.images.within(node);
                    let gift = &io.gift[at.in_buffer(image)];
                    let (share, mean) = (gift.share(), gift.mean());
                    let of = |a: usize| if components[a] { signs[a] * s * m * share[a] } else { 0.0 };
                    let mean = [0, 1, 2].map(|a| signs[a] * mean[a]);
                    reaction.add(self.lattice.position(node), [0, 1, 2].map(of), mean);
                }
                reaction.store(&mut io.reactions[self.first + index.0[lane] as usize - 1]);
            }
        }
    }
}
