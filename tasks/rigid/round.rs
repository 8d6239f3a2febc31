use crate::labels::{NodeMotion, OwnStep, RigidBalance, RigidMotion, RigidSite, RigidTrial};
use crate::node::{Impulse, Motion, Site};
use crate::rigid::bodies::Bodies;
use crate::rigid::newton::{BALANCE, Balance, turn};
use crate::rigid::state::{RigidState, RigidTrial as Trial};
use engine::data::exact_sum::ExactSum;
use engine::graph::task::{At, Body};
use physics::contact::ContactLaw;
use simd::Simd;

engine::task! {
    /// What free rigid bodies would give to the matter if they moved as sought: Σ J_sᵀ P_s(U), and its derivative.
    pub struct RigidRound(pub Bodies);

    Nodes task {
        requires now { step: OwnStep, site: RigidSite, motion: NodeMotion, bodies: RigidMotion, trial: RigidTrial }
        computes { balance: RigidBalance }
    }
}

impl Body for RigidRound {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let moving = (&*io.bodies, &*io.trial);
        self.0.balance(at, (&io.site, &io.motion), moving, &[], &mut io.balance);
    }
}

pub use bonded::BondedRound;

mod bonded {
    use super::*;
    use crate::labels::ContactImpulse;

    engine::task! {
        /// As `RigidRound`, where bonds make one of several materials.
        pub struct BondedRound(pub Bodies);

        Nodes task {
            requires now {
                step: OwnStep, site: RigidSite, motion: NodeMotion, bodies: RigidMotion, trial: RigidTrial, one: ContactImpulse,
            }
            computes { balance: RigidBalance }
        }
    }

    impl Body for BondedRound {
        #[inline(always)]
        fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
            let moving = (&*io.bodies, &*io.trial);
            self.0.balance(at, (&io.site, &io.motion), moving, &io.one, &mut io.balance);
        }
    }
}

impl Bodies {
    /// Adds to the balance of each body what it would give at the nodes of a block.
    fn balance(
        &self,
        at: &At<'_>,
        nodes: (&[Site], &[Motion]),
        (states, trials): (&[RigidState], &[Trial]),
        one: &[Impulse],
        into: &mut [[ExactSum; BALANCE]],
    ) {
        let mut sums = vec![Balance::default(); self.tools.len()];
        self.each_push(at, nodes, (states, trials), one, |push| {
            let (law, pair) = (&push.meeting.law, &push.pair);
            let stiffness =
                if turn(trials[push.body].rounds).secant { law.secant(pair) } else { law.stiffness(pair) };
            sums[push.number].add(push.arm, push.impulse(), &stiffness, push.momentum());
        });
        for (tool, sum) in self.tools.iter().zip(sums).filter(|(_, sum)| *sum != Balance::default()) {
            let into = tool.body().map(|body| &mut into[body]);
            into.into_iter().flatten().zip(sum.0).for_each(|(into, x)| into.add(x));
        }
    }
}
