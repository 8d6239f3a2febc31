use crate::labels::{InitialVolume, KirchhoffStress, StressFlow as StressFlowLabel, Volume};
use engine::graph::task::{At, Body};
use simd::Simd;

engine::task! {
    /// What particles give to grid nodes by their stress and volume: internal forces f_I = − Σ_p V⁰_p τ_p ∇S_Ip, and volumes
    /// V_I = Σ_p S_Ip V_p. These are the factors of ∇S_Ip and S_Ip.
    pub struct StressFlow;

    Particles task {
        requires old { stress: KirchhoffStress, initial_volume: InitialVolume, volume: Volume }
        computes { flow: StressFlowLabel }
    }
}

impl Body for StressFlow {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let volumes = io.initial_volume.iter().zip(io.volume.iter());
        for ((tau, (v0, volume)), flow) in io.stress.iter().zip(volumes).zip(io.flow.iter_mut()) {
            let minus_v0 = -S::load(v0);
            for c in 0..6 {
                (minus_v0 * S::load(&tau[c])).store(&mut flow[c]);
            }
            flow[6] = *volume;
        }
    }
}
