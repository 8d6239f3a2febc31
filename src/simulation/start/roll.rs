//! How many particles bodies have, and which identities.
use super::share;
use engine::exec::ranks::{Network, NetworkError, collective};
use scene::sampling::{Filling, Numbering};
use scene::{Body, Region, Scene};
use std::ops::Range;

/// Rows of cells that are counted, of all bodies together, about: a rank keeps eight bytes of each.
const MOST_ROWS: usize = 1 << 20;

/// The rows of a body's lattice.
pub(super) fn rows(scene: &Scene, body: &Body) -> Numbering {
    Numbering::new(Filling::of(scene, body), MOST_ROWS / scene.bodies.len().max(1))
}

/// The particles of a scene at its start: 0, 1, 2, …, body by body in the order of the scene.
#[derive(Debug)]
pub struct Roll {
    /// The first identity of each body that has particles, and the others.
    bodies: Vec<Option<(u64, Numbering)>>,
}

impl Roll {
    /// Counts the particles. All ranks call it, and each counts its share of rows.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn call(scene: &Scene, network: &mut dyn Network) -> Result<Self, NetworkError> {
        let filled = |body: &&Body| scene.materials[body.material].has_particles();
        let mut bodies: Vec<Option<(u64, Numbering)>> = scene
            .bodies
            .iter()
            .map(|body| Some(body).filter(filled).map(|body| (0, rows(scene, body))))
            .collect();
        let mut words = Vec::new();
        for (_, numbering) in bodies.iter().flatten() {
            let first = words.len();
            words.resize(first + numbering.rows(), 0);
            for row in share(network, numbering.rows()) {
                words[first + row] = numbering.filling().count(&numbering.row(row));
            }
        }
        collective::sum(network, &mut words)?;
        let (mut counts, mut first) = (words.into_iter(), 0);
        for (identity, numbering) in bodies.iter_mut().flatten() {
            let rows = numbering.rows();
            numbering.number(counts.by_ref().take(rows));
            *identity = first;
            first += numbering.count();
        }
        Ok(Self { bodies })
    }

    /// The rows of a body, if it has particles.
    pub fn of(&self, body: usize) -> Option<&Numbering> {
        self.bodies[body].as_ref().map(|(_, numbering)| numbering)
    }

    /// The identities of a body's particles.
    pub fn identities(&self, body: usize) -> Range<u64> {
        self.bodies[body].as_ref().map_or(0..0, |(first, numbering)| *first..first + numbering.count())
    }

    /// Points and boxes of lattices that this rank has looked at.
    pub fn visited(&self) -> u64 {
        self.bodies.iter().flatten().map(|(_, numbering)| numbering.filling().visited()).sum()
    }

    /// The identities of the particles of a material that lie in a region at the start: ranges, ascending. All ranks call it, and
    /// each looks at its share of rows.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn members(
        &self,
        scene: &Scene,
        material: usize,
        region: &Region,
        network: &mut dyn Network,
    ) -> Result<Vec<Range<u64>>, NetworkError> {
        let bodies = (0..scene.bodies.len()).filter(|&body| scene.bodies[body].material == material);
        let solid = match region {
            Region::Solid(solid) => solid,
            _ => {
                let of = |&body: &usize| {
                    matches!(region, Region::All) || matches!(region, Region::Body(it) if *it == body)
                };
                return Ok(joined(bodies.filter(of).map(|body| self.identities(body)).collect()));
            }
        };
        let mut words = Vec::new();
        for body in bodies {
            let (first, Some(numbering)) = (self.identities(body).start, self.of(body)) else { continue };
            let both = Filling::within(scene, &scene.bodies[body], solid);
            for row in share(network, numbering.rows()) {
                let here = numbering.members(row, &both);
                words.extend(here.into_iter().flat_map(|range| [first + range.start, first + range.end]));
            }
        }
        let all = collective::share(network, &words)?;
        let pairs = all.iter().flat_map(|words| words.as_chunks().0);
        Ok(joined(pairs.map(|&[start, end]| start..end).collect()))
    }
}

/// Ranges in their order, of which no two touch.
fn joined(mut ranges: Vec<Range<u64>>) -> Vec<Range<u64>> {
    ranges.retain(|range| !range.is_empty());
    ranges.sort_unstable_by_key(|range| range.start);
    ranges.dedup_by(|next, last| {
        let touch = last.end == next.start;
        if touch {
            last.end = next.end;
        }
        touch
    });
    ranges
}
