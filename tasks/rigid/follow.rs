use crate::data::labels::{BlockExtent, Position, ReferencePosition, RigidMotion, SignalSpeed, Velocity};
use crate::graph::task::{At, Body};
use crate::simd::{LANES, Simd};

/// x_p = X_c + R X_p ;  v_p = V + ω × (x_p − X_c).
pub struct Follow {
    /// 1/h [1/m]
    pub inverse_cell: f64,
    /// Half-size of a particle in cells.
    pub half_size: [f64; 3],
}

crate::task! { Particles task Follow {
    requires old { reference: ReferencePosition }
    requires now { bodies: RigidMotion }
    computes { extent: BlockExtent, speed: SignalSpeed }
    modifies { position: Position, velocity: Velocity }
}}

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
                    let y = place[a] * self.inverse_cell - (at.origin.lower[a] + self.half_size[a]);
                    let extent = &mut io.extent[0];
                    extent[a].0[lane] = extent[a].0[lane].max(y);
                    extent[a + 3].0[lane] = extent[a + 3].0[lane].max(-y);
                }
                let speed = velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
                for (largest, speed) in io.speed[0].iter_mut().zip([speed, 0.0, speed]) {
                    largest.0[lane] = largest.0[lane].max(speed);
                }
            }
        }
    }
}
