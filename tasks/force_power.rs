use crate::forces::Forces;
use crate::labels::{
    Deformation, ForceIndex, GridVelocity, OwnStep, Position, Reactions, SurfaceArea, VelocityChange,
};
use crate::reactions::Reaction;
use engine::graph::task::{At, Body};
use simd::{LANES, Simd};

/// Impulse, torque and work of the forces on particles, with the mean velocity of the nodes around each.
pub struct ForcePower {
    /// The forces.
    pub forces: Forces,
    /// The tile of `Reactions` of the first of them.
    pub first: usize,
}

engine::task! { Particles task ForcePower {
    requires old { index: ForceIndex, area: SurfaceArea, deformation: Deformation, position: Position }
    requires new { step: OwnStep, velocity: GridVelocity, change: VelocityChange }
    computes { reactions: Reactions }
}}

impl Body for ForcePower {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        for (tile, index) in io.index.iter().enumerate() {
            for lane in (0..LANES).filter(|&lane| index.0[lane] > 0.0) {
                let area = io.area[tile].map(|n| n.0[lane]);
                let f = io.deformation[tile].map(|f| f.0[lane]);
                let force = self.forces.of(index.0[lane], &io.step[0], area, &f);
                let (v, dv) = (&io.velocity[tile], &io.change[tile]);
                let mean = [0, 1, 2].map(|a| v[a].0[lane] - 0.5 * dv[a].0[lane]);
                let mut reaction = Reaction::default();
                let impulse = force.map(|force| io.step[0].size * force);
                reaction.add(io.position[tile].map(|x| x.0[lane]), impulse, mean);
                reaction.store(&mut io.reactions[self.first + index.0[lane] as usize - 1]);
            }
        }
    }
}
