use super::add_all;
use crate::labels::{Mass, MaterialEnergy, MaterialExtent, MaterialMotion, Position, Velocity};
use engine::graph::task::{At, Body};
use simd::{Simd, load, store};

engine::task! {
    /// Adds up kinetic energy, mass, momentum, center of mass, angular momentum and extent of one material.
    pub struct ReportMotion;

    Particles task {
        requires old { mass: Mass, position: Position, velocity: Velocity }
        computes { energy: MaterialEnergy, motion: MaterialMotion, extent: MaterialExtent }
    }
}

impl Body for ReportMotion {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let zero = S::splat(0.0);
        let (mut kinetic, mut motion) = (zero, [zero; 10]);
        let (mut extent, nowhere) = (load::<S, 6>(&io.extent[0]), S::splat(f64::NEG_INFINITY));
        let particles = io.mass.iter().zip(io.position.iter()).zip(io.velocity.iter());
        for (tile, ((m, x), v)) in particles.enumerate() {
            let (here, m, x, v) = (at.lanes(tile), S::load(m), load::<S, 3>(x), load::<S, 3>(v));
            kinetic = (m * S::splat(0.5)).fma(v[0].fma(v[0], v[1].fma(v[1], v[2] * v[2])), kinetic);
            motion[0] = motion[0] + m;
            for a in 0..3 {
                extent[a] = extent[a].max(S::select(here, x[a], nowhere));
                extent[3 + a] = extent[3 + a].max(S::select(here, -x[a], nowhere));
                let (b, c) = ((a + 1) % 3, (a + 2) % 3);
                motion[1 + a] = m.fma(v[a], motion[1 + a]);
                motion[4 + a] = m.fma(x[a], motion[4 + a]);
                motion[7 + a] = m.fma(x[b].fms(v[c], x[c] * v[b]), motion[7 + a]);
            }
        }
        add_all(&mut io.energy[0][..1], [kinetic]);
        add_all(&mut io.motion[0], motion);
        store(&extent, &mut io.extent[0]);
    }
}
