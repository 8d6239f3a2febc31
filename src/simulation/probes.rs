//! What a scene wants to be followed in time.
use super::snapshot::State;
use super::start::Roll;
use bytemuck::{Zeroable, cast_slice, cast_slice_mut};
use engine::data::exact_sum::ExactSum;
use engine::data::warehouse::Warehouse;
use engine::exec::ranks::{Network, NetworkError, collective};
use scene::Scene;
use scene::shown::{Probe, ProbeOf};
use simd::LANES;
use std::cell::Cell;
use std::ops::{ControlFlow, Range};

/// Particles by their identities: ranges, ascending.
#[derive(Clone, Debug, Default)]
struct Members(Vec<Range<u64>>);

impl Members {
    fn has(&self, identity: u64) -> bool {
        let next = self.0.partition_point(|range| range.end <= identity);
        self.0.get(next).is_some_and(|range| range.contains(&identity))
    }
}

/// The particles of each probe.
#[derive(Clone, Debug, Default)]
pub struct Probes(Vec<Members>);

/// What one component of a probe has come to on a rank: mass, mass times value, largest, smallest.
#[derive(Clone, Copy)]
struct Tally {
    mass: ExactSum,
    sum: ExactSum,
    largest: f64,
    smallest: f64,
}

impl Probes {
    /// Those of a scene: who is where at the start follows from it alone. All ranks call it.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn of(scene: &Scene, roll: &Roll, network: &mut dyn Network) -> Result<Self, NetworkError> {
        let mut members = |probe: &Probe| {
            let members = match &probe.of {
                ProbeOf::Nearest(point) => nearest(scene, roll, probe.material, *point),
                ProbeOf::Mean(region) | ProbeOf::Largest(region) | ProbeOf::Smallest(region) => {
                    roll.members(scene, probe.material, region, network)?
                }
            };
            Ok(Members(members))
        };
        Ok(Self(scene.probes.iter().map(&mut members).collect::<Result<_, NetworkError>>()?))
    }

    /// The value of each component of each probe now, the same on all ranks; not a number where nobody has one.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn measure(
        &self,
        scene: &Scene,
        warehouse: &Warehouse,
        network: &mut dyn Network,
    ) -> Result<Vec<f64>, NetworkError> {
        let mut values = Vec::new();
        for (probe, members) in scene.probes.iter().zip(&self.0) {
            let mut tallies = tally(scene, warehouse, probe, members);
            merge(&mut tallies, network)?;
            values.extend(tallies.iter().map(|tally| tally.value(&probe.of)));
        }
        Ok(values)
    }
}

/// The particle of a material that is nearest to a point: of several the first. Boxes that lie farther away than one that is known
/// are not looked at, so that each rank finds it by itself.
fn nearest(scene: &Scene, roll: &Roll, material: usize, point: [f64; 3]) -> Vec<Range<u64>> {
    let square = |x: [f64; 3]| -> f64 { (0..3).map(|a| (x[a] - point[a]).powi(2)).sum() };
    let (least, mut found) = (Cell::new(f64::INFINITY), None);
    for body in (0..scene.bodies.len()).filter(|&body| scene.bodies[body].material == material) {
        let Some(numbering) = roll.of(body) else { continue };
        let filling = numbering.filling();
        let far = |(lower, upper): ([f64; 3], [f64; 3])| {
            square(std::array::from_fn(|a| point[a].clamp(lower[a], upper[a]))) > least.get()
        };
        let _ = filling.search(filling.span(), &far, &mut |at, x| {
            let key = (body, filling.order(at));
            if square(x) < least.get()
                || square(x) == least.get() && found.is_none_or(|(other, _)| key < other)
            {
                least.set(square(x));
                found = Some((key, at));
            }
            ControlFlow::<()>::Continue(())
        });
    }
    let identity = |((body, _), at): ((usize, _), _)| {
        roll.of(body).map(|numbering| roll.identities(body).start + numbering.number_of(at))
    };
    found.and_then(identity).map(|identity| identity..identity + 1).into_iter().collect()
}

fn tally(scene: &Scene, warehouse: &Warehouse, probe: &Probe, members: &Members) -> Vec<Tally> {
    let mut tallies = vec![Tally::nothing(); probe.shown.components];
    let source = scene.source(probe.material, probe.shown.name);
    for (_, block) in warehouse.blocks().filter(|(material, _)| *material == probe.material) {
        let state = State::new(scene, warehouse, probe.material, block);
        for number in 0..block.tiles() {
            let (identities, count) = (state.identities(number), block.count - number * LANES);
            let mut lanes = (0..LANES.min(count)).filter(|&lane| members.has(identities[lane])).peekable();
            if lanes.peek().is_none() {
                continue;
            }
            let tile = state.tile(number);
            let numbers = source.of(&tile);
            for lane in lanes {
                let value = numbers.iter().map(|line| line.0[lane]);
                for (tally, x) in tallies.iter_mut().zip(value).filter(|(_, x)| x.is_finite()) {
                    tally.add(tile.mass.0[lane], x);
                }
            }
        }
    }
    tallies
}

impl Tally {
    fn nothing() -> Self {
        let (mass, sum) = (ExactSum::zeroed(), ExactSum::zeroed());
        Self { mass, sum, largest: f64::NEG_INFINITY, smallest: f64::INFINITY }
    }

    fn add(&mut self, mass: f64, x: f64) {
        self.mass.add(mass);
        self.sum.add(mass * x);
        self.largest = self.largest.max(x);
        self.smallest = self.smallest.min(x);
    }

    fn value(&self, of: &ProbeOf) -> f64 {
        let number = match of {
            // of one particle any of them is its value
            ProbeOf::Nearest(_) | ProbeOf::Largest(_) => self.largest,
            ProbeOf::Smallest(_) => self.smallest,
            ProbeOf::Mean(_) => self.sum.value() / self.mass.value(),
        };
        if number.is_finite() { number } else { f64::NAN }
    }
}

/// Adds up the tallies of all ranks; exact sums and maxima have no order.
fn merge(tallies: &mut [Tally], network: &mut dyn Network) -> Result<(), NetworkError> {
    let mut words: Vec<u64> = Vec::new();
    for tally in tallies.iter() {
        words.extend(cast_slice::<ExactSum, u64>(&[tally.mass, tally.sum]));
        words.extend([tally.largest.to_bits(), tally.smallest.to_bits()]);
    }
    let each = words.len() / tallies.len().max(1);
    let all = collective::share(network, &words)?;
    for (i, tally) in tallies.iter_mut().enumerate() {
        *tally = Tally::nothing();
        for rank in &all {
            let words = &rank[i * each..(i + 1) * each];
            let mut sums = [ExactSum::zeroed(); 2];
            cast_slice_mut::<ExactSum, u64>(&mut sums).copy_from_slice(&words[..each - 2]);
            tally.mass.merge(&sums[0]);
            tally.sum.merge(&sums[1]);
            tally.largest = tally.largest.max(f64::from_bits(words[each - 2]));
            tally.smallest = tally.smallest.min(f64::from_bits(words[each - 1]));
        }
    }
    Ok(())
}
