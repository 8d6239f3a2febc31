use crate::labels::RigidMotion as RigidMotionLabel;
use crate::labels::Time;
use engine::graph::task::{At, Body};
use physics::motion::Course;
use physics::table::Table;
use simd::Simd;

engine::task! {
    /// Plans V and ω of prescribed rigid bodies for the tick that begins: means over it, so that they go exactly where they should.
    pub struct RigidPlan {
        /// For each material: how it moves and turns, if it is a prescribed rigid body.
        pub prescribed: Vec<Option<(Course, Table)>>,
    }

    Once task {
        requires new { time: Time }
        modifies { bodies: RigidMotionLabel }
    }
}

impl Body for RigidPlan {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let (from, dt) = (io.time[0].time, io.time[0].tick);
        for (body, prescribed) in io.bodies.iter_mut().zip(&self.prescribed) {
            if let Some((course, spin)) = prescribed {
                body.velocity = course.way(from, from + dt).map(|way| way / dt);
                body.angular = spin.integral(from, from + dt).map(|angle| angle / dt);
            }
        }
    }
}
