use crate::labels::{NodeMotion, OwnStep, RigidBalance, RigidMotion, RigidSite, RigidTrial};
use crate::rigid::bodies::Bodies;
use crate::rigid::newton::{Balance, turn};
use engine::graph::task::{At, Body};
use physics::contact::ContactLaw;
use simd::Simd;

/// What free rigid bodies would give to the matter if they moved as sought: Σ J_sᵀ P_s(U), and its derivative.
pub struct RigidRound(pub Bodies);

engine::task! { Nodes task RigidRound {
    requires now { step: OwnStep, site: RigidSite, motion: NodeMotion, bodies: RigidMotion, trial: RigidTrial }
    computes { balance: RigidBalance }
}}

impl Body for RigidRound {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let mut sums = vec![Balance::default(); self.0.tools.len()];
        self.0.each_push(at, (&io.site, &io.motion), (&io.bodies, &io.trial), |push| {
            let (law, pair) = (&push.meeting.law, &push.pair);
            let stiffness =
                if turn(io.trial[push.body].rounds).secant { law.secant(pair) } else { law.stiffness(pair) };
            sums[push.number].add(push.arm, push.impulse(), &stiffness, push.momentum());
        });
        for (tool, sum) in self.0.tools.iter().zip(sums).filter(|(_, sum)| *sum != Balance::default()) {
            let into = tool.body().map(|body| &mut io.balance[body]);
            into.into_iter().flatten().zip(sum.0).for_each(|(into, x)| into.add(x));
        }
    }
}
