//! Sums over ranks.
use super::report::Report;
use engine::exec::ranks::{Network, NetworkError, collective};

/// Counts the particles of all ranks in a report, of which the rest is the same on all of them.
///
/// # Errors
/// If a rank is gone.
pub fn count_particles(network: &mut dyn Network, report: &mut Report) -> Result<(), NetworkError> {
    let mut counts: Vec<u64> = report.materials.iter().map(|material| material.particles).collect();
    collective::sum(network, &mut counts)?;
    report.materials.iter_mut().zip(counts).for_each(|(material, count)| material.particles = count);
    Ok(())
}
