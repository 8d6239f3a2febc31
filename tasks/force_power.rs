use crate::forces::Forces;
use crate::integrate::count;
use crate::labels::{
    Deformation, ForceIndex, ForceWork, GridVelocity, OwnStep, Position, Reactions, SurfaceArea,
    VelocityChange,
};
use crate::reactions::Reaction;
use engine::graph::task::{At, Body};
use physics::contact::dot;
use simd::{LANES, Simd};

engine::task! {
    /// Counts impulse, torque and work of the forces on particles, with the mean velocity of the nodes around each. They are no internal forces,
    /// among which `Integrate` has counted them.
    pub struct ForcePower {
        /// The forces.
        pub forces: Forces,
        /// The tile of `Reactions` of the first of them.
        pub first: usize,
    }

    Particles task {
        requires old { index: ForceIndex, area: SurfaceArea, deformation: Deformation, position: Position }
        requires new { velocity: GridVelocity, change: VelocityChange }
        requires now { step: OwnStep }
        computes { reactions: Reactions, work: ForceWork }
    }
}

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
                let began = [0, 1, 2].map(|a| v[a].0[lane] - dv[a].0[lane]);
                let mut reaction = Reaction::default();
                let impulse = force.map(|force| io.step[0].size * force);
                reaction.add(io.position[tile].map(|x| x.0[lane]), impulse, mean);
                count(&mut io.work[0], io.step[0].first, -dot(impulse, began));
                reaction.store(&mut io.reactions[self.first + index.0[lane] as usize - 1]);
            }
        }
    }
}
