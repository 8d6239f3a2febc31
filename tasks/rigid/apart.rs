use crate::fault::MEETS;
use crate::labels::{Fault, RigidMotion, Time};
use crate::tool::{Placed, Pose, Tool};
use engine::data::reduction::earlier;
use engine::graph::task::{At, Body};
use physics::solid::Solid;
use simd::{Simd, Wide};

engine::task! {
    /// Rigid bodies do not push one another, which is not modelled: a free one that gets into another one, a tool or a face ends the run.
    pub struct RigidApart {
        /// The free bodies.
        pub bodies: Vec<Free>,
        /// All that is rigid.
        pub obstacles: Vec<Tool>,
    }

    Once task {
        requires now { time: Time, bodies: RigidMotion }
        computes { fault: Fault }
    }
}

/// A free rigid body.
#[derive(Clone, Debug)]
pub struct Free {
    /// Its material.
    pub material: usize,
    /// Points near its surface at time 0 [m].
    pub points: Vec<[f64; 3]>,
    /// The ball around them: a center [m] and a radius [m].
    pub ball: ([f64; 3], f64),
}

impl Body for RigidApart {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let now = io.time[0].time + io.time[0].tick;
        for body in &self.bodies {
            let here = Placed { state: io.bodies[body.material] };
            for (number, other) in self.obstacles.iter().enumerate() {
                if matches!(other.pose, Pose::Body(material) if material == body.material) {
                    continue;
                }
                let there = other.place(now, 0.0, &io.bodies);
                if let Some([x, y, z]) = body.within((&other.shape, &there), &here) {
                    let line = Wide([0.0, MEETS, number as f64, x, y, z, 0.0, 0.0]);
                    if earlier(&line, &io.fault[body.material]) {
                        io.fault[body.material] = line;
                    }
                }
            }
        }
    }
}

impl Free {
    /// A body of a material from the points near its surface [m].
    pub fn new(material: usize, points: Vec<[f64; 3]>) -> Self {
        let count = points.len().max(1) as f64;
        let middle = [0, 1, 2].map(|a| points.iter().map(|x| x[a]).sum::<f64>() / count);
        let distance = |x: &[f64; 3]| (0..3).map(|a| (x[a] - middle[a]).powi(2)).sum::<f64>().sqrt();
        let radius = points.iter().map(distance).fold(0.0, f64::max);
        Self { material, points, ball: (middle, radius) }
    }

    /// A point of the body that is within a shape, if there is one.
    fn within(&self, (shape, there): (&Solid, &Placed), here: &Placed) -> Option<[f64; 3]> {
        let (middle, radius) = self.ball;
        if there.distance(shape, here.from_reference(middle)).0 > radius {
            return None;
        }
        let mut points = self.points.iter().map(|x| here.from_reference(*x));
        points.find(|x| there.distance(shape, *x).0 < 0.0)
    }
}
