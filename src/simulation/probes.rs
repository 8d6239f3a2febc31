//! What a scene wants to be followed in time.
use super::snapshot::State;
use bytemuck::{Zeroable, cast_slice, cast_slice_mut};
use engine::data::exact_sum::ExactSum;
use engine::data::warehouse::Warehouse;
use engine::exec::ranks::{Network, NetworkError, collective};
use scene::shown::{Probe, ProbeOf};
use scene::{Scene, sampling};
use simd::LANES;

/// Particles by their identities, a bit each.
#[derive(Clone, Debug, Default)]
struct Members(Vec<u64>);

impl Members {
    fn add(&mut self, identity: u64) {
        let (word, bit) = ((identity / 64) as usize, identity % 64);
        if self.0.len() <= word {
            self.0.resize(word + 1, 0);
        }
        self.0[word] |= 1 << bit;
    }

    fn has(&self, identity: u64) -> bool {
        self.0.get((identity / 64) as usize).is_some_and(|word| word >> (identity % 64) & 1 == 1)
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
    /// Those of a scene: who is where at the start follows from it alone.
    pub fn of(scene: &Scene) -> Self {
        Self(scene.probes.iter().map(|probe| members(scene, probe)).collect())
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

/// The particles of a probe.
fn members(scene: &Scene, probe: &Probe) -> Members {
    let (mut members, mut nearest) = (Members::default(), None);
    let all = (0..).zip(sampling::all(scene));
    for (identity, (body, x)) in all.filter(|(_, (body, _))| scene.bodies[*body].material == probe.material) {
        match &probe.of {
            ProbeOf::Nearest(point) => {
                let distance: f64 = (0..3).map(|a| (x[a] - point[a]).powi(2)).sum();
                if nearest.is_none_or(|(least, _)| distance < least) {
                    nearest = Some((distance, identity));
                }
            }
            ProbeOf::Mean(region) | ProbeOf::Largest(region) | ProbeOf::Smallest(region) => {
                if region.contains(body, x) {
                    members.add(identity);
                }
            }
        }
    }
    nearest.into_iter().for_each(|(_, identity)| members.add(identity));
    members
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
