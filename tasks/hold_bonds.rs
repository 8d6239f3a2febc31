use crate::bonds::{Bonds, common_velocity};
use crate::labels::{ContactImpulse, NodeMotion, Reactions};
use engine::graph::task::{At, Body};
use grid::NODES;
use simd::Simd;

engine::task! {
    /// Gives what bonds make one a single velocity at a node at the end of a tick, too, whatever has moved one side of it alone:
    /// v_I = Σ m v / Σ m over its fields. Otherwise particles would keep a difference that the next step takes from nodes, and never from them.
    pub struct HoldBonds(pub Bonds);

    Nodes task {
        computes { reactions: Reactions }
        modifies { motion: NodeMotion, impulse: ContactImpulse }
    }
}

impl Body for HoldBonds {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        self.0.each_group(at, &mut io.impulse, |n, members, exchange| {
            let velocity = common_velocity(members.iter().map(|slot| &io.motion[NODES * slot + n]));
            for &slot in members {
                let motion = &mut io.motion[NODES * slot + n];
                let (m, v) = (motion.mass(), motion.velocity());
                let dv = [0, 1, 2].map(|a| velocity[a] - v[a]);
                motion.add(dv);
                exchange(slot, dv.map(|dv| m * dv), &mut io.reactions);
            }
        });
    }
}
