use crate::bonds::Bonds;
use crate::labels::{ContactImpulse, DriveGift, DriveSums, NodeMotion, OwnStep, Reactions};
use crate::node::Motion;
use engine::graph::task::{At, Body};
use grid::NODES;
use simd::Simd;

engine::task! {
    /// What is bonded to driven matter goes with it at its nodes; the drive gives what that takes.
    pub struct DriveBonds(pub Bonds);

    Nodes task {
        requires now { step: OwnStep, driven: DriveSums }
        computes { reactions: Reactions }
        modifies { motion: NodeMotion, impulse: ContactImpulse, gift: DriveGift }
    }
}

impl Body for DriveBonds {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let Io { driven, motion, impulse, gift, reactions, .. } = &mut io;
        self.0.each_group(at, impulse, |n, members, exchange| {
            let holds = |slot: usize, a: usize, motion: &[Motion]| {
                let line = NODES * slot + n;
                at.fields[slot].ends && driven[line].velocity(a, motion[line].mass()).is_some()
            };
            let driver = [0, 1, 2].map(|a| members.iter().copied().find(|&slot| holds(slot, a, motion)));
            for &slot in members {
                let line = NODES * slot + n;
                let (m, v) = (motion[line].mass(), motion[line].velocity());
                let to = |a: usize| driver[a].filter(|_| !holds(slot, a, motion));
                let dv = [0, 1, 2]
                    .map(|a| to(a).map_or(0.0, |driver| motion[NODES * driver + n].velocity()[a] - v[a]));
                for (a, driver) in [0, 1, 2].map(|a| (a, to(a))) {
                    let Some(driver) = driver else { continue };
                    let (line, given) = (NODES * driver + n, m * dv[a]);
                    gift[line].give(a, given / driven[line].mass()[a]);
                    exchange(driver, [0, 1, 2].map(|b| if a == b { -given } else { 0.0 }), reactions);
                }
                motion[line].add(dv);
                exchange(slot, dv.map(|dv| m * dv), reactions);
            }
        });
    }
}
