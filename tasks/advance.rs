use crate::labels::{
    BlockExtent, GridVelocity, Mass, OwnStep, Position, TransferLoss, Velocity, VelocityChange,
};
use crate::pic::Pic;
use engine::data::extent::Bases;
use engine::graph::task::{At, Body};
use simd::{Simd, load, store};

engine::task! {
    /// Particles take their new velocity, and move: v_p ← (1 − β)(v_p + Σ S Δv) + β Σ S v, x_p ← x_p + Δt Σ S v. This is FLIP with a fraction β
    /// of PIC. The kinetic energy that particles gain is taken from `TransferLoss`.
    /// J. U. Brackbill, H. M. Ruppel, JCP 65, 1986, 314–343 (doi:10.1016/0021-9991(86)90211-1).
    pub struct Advance {
        /// Says β.
        pub pic: Pic,
        /// Where particles are, for the extent of their block.
        pub bases: Bases,
    }

    Particles task {
        requires old { mass: Mass }
        requires new { grid_velocity: GridVelocity, change: VelocityChange }
        requires now { step: OwnStep }
        computes { extent: BlockExtent, loss: TransferLoss }
        modifies { position: Position, velocity: Velocity }
    }
}

impl Body for Advance {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let dt = S::splat(io.step[0].size);
        let pic = self.pic.of(io.step[0].size);
        let (flip, pic) = (S::splat(1.0 - pic), S::splat(pic));
        let mut extent = load(&io.extent[0]);
        let grid = io.grid_velocity.iter().zip(io.change.iter()).zip(io.mass.iter());
        let mut gain = S::splat(0.0);
        for (((v_grid, dv), m), (x, v)) in grid.zip(io.position.iter_mut().zip(io.velocity.iter_mut())) {
            let half_mass = S::splat(0.5) * S::load(m);
            for a in 0..3 {
                let on_grid = S::load(&v_grid[a]);
                let moved = dt.fma(on_grid, S::load(&x[a]));
                moved.store(&mut x[a]);
                let old = S::load(&v[a]);
                let new = flip.fma(old + S::load(&dv[a]), pic * on_grid);
                new.store(&mut v[a]);
                gain = half_mass.fma((new - old) * (new + old), gain);
                self.bases.include(&mut extent, &at.origin, a, moved);
            }
        }
        store(&extent, &mut io.extent[0]);
        io.loss[0].add(-gain.lanes().iter().sum::<f64>());
    }
}
