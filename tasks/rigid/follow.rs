use crate::labels::{BlockExtent, Position, ReferencePosition, RigidMotion, SignalSpeed, Velocity};
use engine::data::extent::Bases;
use engine::graph::task::{At, Body};
use simd::{LANES, Simd};

engine::task! {
    /// Particles of a rigid body go with it: x_p = X_c + R X_p, v_p = V + ω × (x_p − X_c).
    pub struct Follow {
        /// Where particles are, for the extent of their block.
        pub bases: Bases,
    }

    Particles task {
        requires old { reference: ReferencePosition }
        requires now { bodies: RigidMotion }
        computes { extent: BlockExtent, speed: SignalSpeed }
        modifies { position: Position, velocity: Velocity }
    }
}

impl Body for Follow {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let body = &io.bodies[0];
        let tiles = io.reference.iter().zip(io.position.iter_mut()).zip(io.velocity.iter_mut());
        for (tile, ((reference, x), v)) in tiles.enumerate() {
            let here = at.lanes(tile);
            for lane in (0..LANES).filter(|lane| here >> lane & 1 == 1) {
                let r = reference.map(|r| r.0[lane]);
                let turn = |a: usize| (0..3).map(|b| body.rotation[3 * a + b] * r[b]).sum::<f64>();
                let place: [f64; 3] = std::array::from_fn(|a| body.center[a] + turn(a));
                let velocity = body.velocity_at(place);
                for a in 0..3 {
                    (x[a].0[lane], v[a].0[lane]) = (place[a], velocity[a]);
                }
                self.bases.include_one(&mut io.extent[0], &at.origin, lane, place);
                let speed = velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
                for (largest, speed) in io.speed[0].iter_mut().zip([speed, 0.0, speed]) {
                    largest.0[lane] = largest.0[lane].max(speed);
                }
            }
        }
    }
}
