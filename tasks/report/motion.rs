use super::add_all;
use crate::labels::{Mass, MaterialEnergy, MaterialMotion, Position, Velocity};
use engine::graph::task::{At, Body};
use simd::{Simd, load};

/// Kinetic energy, mass, momentum, center of mass and angular momentum of one material.
pub struct ReportMotion;

engine::task! { Particles task ReportMotion {
    requires old { mass: Mass, position: Position, velocity: Velocity }
    computes { energy: MaterialEnergy, motion: MaterialMotion }
}}

impl Body for ReportMotion {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let zero = S::splat(0.0);
        let (mut kinetic, mut motion) = (zero, [zero; 10]);
        for ((m, x), v) in io.mass.iter().zip(io.position.iter()).zip(io.velocity.iter()) {
            let (m, x, v) = (S::load(m), load::<S, 3>(x), load::<S, 3>(v));
            kinetic = (m * S::splat(0.5)).fma(v[0].fma(v[0], v[1].fma(v[1], v[2] * v[2])), kinetic);
            motion[0] = motion[0] + m;
            for a in 0..3 {
                let (b, c) = ((a + 1) % 3, (a + 2) % 3);
                motion[1 + a] = m.fma(v[a], motion[1 + a]);
                motion[4 + a] = m.fma(x[a], motion[4 + a]);
                motion[7 + a] = m.fma(x[b].fms(v[c], x[c] * v[b]), motion[7 + a]);
            }
        }
        add_all(&mut io.energy[0][..1], [kinetic]);
        add_all(&mut io.motion[0], motion);
    }
}
