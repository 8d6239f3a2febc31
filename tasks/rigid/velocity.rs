use crate::labels::{NodeMotion, RigidMotion};
use crate::node::Motion;
use engine::graph::task::{At, Body};
use grid::Lattice;
use grid::NODES;
use simd::Simd;

/// v_I = V + ω × (x_I − X_c) on the nodes of rigid materials.
pub struct RigidVelocity {
    /// Where nodes are.
    pub lattice: Lattice,
    /// Which materials are rigid.
    pub rigid: Vec<bool>,
}

engine::task! { Nodes task RigidVelocity {
    requires now { bodies: RigidMotion }
    modifies { motion: NodeMotion }
}}

impl Body for RigidVelocity {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let fields = io.motion.chunks_exact_mut(NODES).zip(at.fields);
        for (motions, field) in fields.filter(|(_, f)| self.rigid[f.material]) {
            let body = &io.bodies[field.material];
            for (n, motion) in motions.iter_mut().enumerate() {
                *motion = Motion::at(body.velocity_at(self.lattice.position(at.node_of(n))));
            }
        }
    }
}
