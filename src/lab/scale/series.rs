//! Predictions for growing numbers of ranks.
use super::footprint::Footprint;
use super::model::Setup;
use super::predict::{Outcome, Shares, simulate};
use super::torus::{Brick, Torus};
use super::wires::Cause;
use serde::Serialize;

/// The prediction for a number of ranks.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Point {
    /// Ranks.
    pub ranks: usize,
    /// Threads of all ranks.
    pub workers: usize,
    /// Patches of all ranks.
    pub patches: usize,
    /// Particles of all ranks.
    pub particles: f64,
    /// A step [ms].
    pub step_ms: f64,
    /// Strong: T(1) / (P T(P)). Weak: T(1) / T(P).
    pub efficiency: f64,
    /// Shares of a mean rank.
    pub shares: Shares,
    /// Work of the rank that has most, over the mean.
    pub imbalance: f64,
    /// What most time on the critical path beyond evenly shared tasks goes into.
    pub limited_by: String,
    /// Shares of the critical path by cause.
    pub path: [f64; Cause::COUNT],
}

impl Point {
    fn of(ranks: usize, threads: usize, outcome: &Outcome) -> Self {
        Self {
            ranks,
            workers: ranks * threads,
            step_ms: 1e3 * outcome.step,
            shares: outcome.shares,
            imbalance: outcome.imbalance,
            limited_by: limit(outcome).to_owned(),
            path: outcome.path,
            ..Self::default()
        }
    }
}

/// Losses below this share of the critical path are not worth a name.
const SMALL: f64 = 0.05;

/// What to work on first.
fn limit(outcome: &Outcome) -> &'static str {
    let uneven = outcome.path[Cause::Compute as usize] * (1.0 - 1.0 / outcome.imbalance.max(1.0));
    let others = Cause::NAMES.into_iter().zip(outcome.path).skip(1);
    let losses = others.chain([("load imbalance", uneven)]);
    let worst = losses.filter(|(_, share)| *share > SMALL).max_by(|a, b| a.1.total_cmp(&b.1));
    worst.map_or(Cause::NAMES[0], |(name, _)| name)
}

/// The scene on 1, 2, 4, … ranks up to `most`, as far as there is a patch with particles for each: on the patches that a run
/// would cut, or on one block a patch where that is quicker.
///
/// # Errors
/// A scene that cannot be cut.
pub fn strong(footprint: &Footprint, setup: &Setup<'_>, most: usize) -> Result<Vec<Point>, String> {
    let finest = footprint.finest();
    let possible = finest.as_ref().map_or(footprint.occupied_blocks(), |it| footprint.occupied(it)).min(most);
    let mut points: Vec<Point> = Vec::new();
    let mut ranks = 1;
    while ranks <= possible {
        let mut best: Option<(Outcome, usize)> = None;
        for patches in std::iter::once(&footprint.usual(ranks, setup.threads)).chain(&finest) {
            if patches.patches.len() < ranks {
                continue;
            }
            let listed = footprint.ranks(patches, ranks, setup)?;
            let outcome = simulate(&listed, setup);
            if best.as_ref().is_none_or(|(other, _)| outcome.step < other.step) {
                best = Some((outcome, patches.patches.len()));
            }
        }
        let Some((outcome, patches)) = best else { break };
        let mut point = Point::of(ranks, setup.threads, &outcome);
        (point.patches, point.particles) = (patches, footprint.particles().iter().sum());
        let first = points.first().map_or(point.step_ms, |first: &Point| first.step_ms);
        point.efficiency = first / (ranks as f64 * point.step_ms);
        points.push(point);
        ranks *= 2;
    }
    Ok(points)
}

/// Ranks that all look like `brick`, which is what one worker has, on growing numbers up to `most`.
pub fn weak(brick: &Brick, setup: &Setup<'_>, most: usize) -> Vec<Point> {
    let brick = brick.times(setup.threads);
    let mut points: Vec<Point> = Vec::new();
    for ranks in ladder(most) {
        let torus = Torus::new(&brick, setup, ranks);
        let mut point = Point::of(ranks, setup.threads, &simulate(&torus, setup));
        point.patches = (ranks as f64 * brick.patches) as usize;
        point.particles = ranks as f64 * brick.particles.iter().sum::<f64>();
        let first = points.first().map_or(point.step_ms, |first: &Point| first.step_ms);
        point.efficiency = first / point.step_ms;
        points.push(point);
    }
    points
}

/// 1, 2, 4, 8, then cubes of even numbers and powers of ten, and `most` itself.
fn ladder(most: usize) -> Vec<usize> {
    const STEPS: [usize; 13] = [1, 2, 4, 8, 27, 64, 216, 512, 1000, 4096, 10_000, 32_768, 100_000];
    let more = std::iter::successors(Some(1_000_000), |n: &usize| n.checked_mul(10));
    let below = STEPS.into_iter().chain(more).take_while(|&n| n < most);
    below.chain([most.max(1)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ladders_end_where_they_should() {
        assert_eq!(ladder(1), [1]);
        assert_eq!(ladder(8), [1, 2, 4, 8]);
        assert_eq!(ladder(30), [1, 2, 4, 8, 27, 30]);
        assert_eq!(ladder(100_000).last(), Some(&100_000));
    }
}
