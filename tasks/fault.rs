//! The first particle whose state is inadmissible, and the first event of each kind: who, when and where.
use engine::data::reduction::earlier;
use simd::{LANES, Mask, Wide};

// kinds of faults, lane 1 of label `Fault`
/// J ≤ 0 or not a number.
pub const INVERTED: f64 = 1.0;
/// A velocity, stress or wave speed that is not a finite number.
pub const NOT_FINITE: f64 = 2.0;
/// A free rigid body that meets something rigid: not a particle, but a number of `obstacles` as value.
pub const MEETS: f64 = 3.0;

/// Particles that something happened to: the rare branch.
pub struct Who<'a> {
    /// Their identities, as bits.
    pub identity: &'a Wide,
    /// Where they are [m].
    pub x: &'a [Wide; 3],
    /// When [s].
    pub time: f64,
}

impl Who<'_> {
    fn lanes(mask: Mask) -> impl Iterator<Item = usize> {
        (0..LANES).filter(move |&i| mask >> i & 1 == 1)
    }

    fn identity(&self, lane: usize) -> f64 {
        self.identity.0[lane].to_bits() as f64
    }

    /// Notes the first of them, if nothing earlier is known.
    #[inline(never)]
    pub fn meet(&self, mask: Mask, first: &mut Wide) {
        for lane in Self::lanes(mask) {
            let [x, y, z] = self.x.map(|x| x.0[lane]);
            let line = Wide([self.time, self.identity(lane), x, y, z, 0.0, 0.0, 0.0]);
            if earlier(&line, first) {
                *first = line;
            }
        }
    }

    /// Reports the particle with the smallest identity.
    #[inline(never)]
    pub fn is_at_fault(&self, mask: Mask, kind: f64, values: [f64; LANES], fault: &mut Wide) {
        for lane in Self::lanes(mask) {
            let [x, y, z] = self.x.map(|x| x.0[lane]);
            let line = Wide([self.identity(lane), kind, values[lane], x, y, z, 0.0, 0.0]);
            if earlier(&line, fault) {
                *fault = line;
            }
        }
    }
}
