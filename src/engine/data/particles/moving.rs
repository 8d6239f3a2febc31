//! Particles that change their block: who may have left it, how they leave, and how they come.
use super::ParticleBlock;
use crate::data::extent::{self, MARGIN};
use crate::data::layout::ParticleLayout;
use grid::Level;
use simd::{Isa, Job, LANES, Mask, Simd, Wide};
use std::ops::Range;

impl ParticleBlock {
    /// Particles, of half-size `half_size` [cells], that may be out of reach of the block or outside of the level: all that are, and some
    /// near that.
    pub fn strays(
        &self,
        isa: Isa,
        layout: &ParticleLayout,
        level: &Level,
        half_size: [f64; 3],
    ) -> impl Iterator<Item = usize> + use<> {
        let (shape, count) = (level.shape(), self.count);
        let first = shape.first_of_buffer(self.index);
        let within = |axis: usize| {
            let half = half_size[axis];
            let (begin, end) = (f64::from(first[axis]), f64::from(first[axis] + shape.bases(axis)));
            let bounds = [begin.max(-half) + NEAR, end.min(level.cells[axis] as f64 - half) - NEAR];
            if shape.is_collapsed(axis) { [f64::NEG_INFINITY, f64::INFINITY] } else { bounds }
        };
        let shift = [0, 1, 2].map(|axis| level.lower[axis] / level.cell + half_size[axis]);
        let positions = &self.column(layout, layout.position)[..3 * self.tiles()];
        let within = [within(0), within(1), within(2)];
        let masks = isa.dispatch(Strays { positions, inverse_cell: 1.0 / level.cell, shift, within });
        let lanes = move |(tile, mask): (usize, Mask)| {
            (0..LANES).filter(move |lane| mask >> lane & 1 == 1).map(move |lane| tile * LANES + lane)
        };
        masks
            .into_iter()
            .enumerate()
            .filter(|(_, mask)| *mask != 0)
            .flat_map(lanes)
            .filter(move |p| *p < count)
    }

    /// Copies a particle's numbers to the end of `record`.
    pub fn read(&self, layout: &ParticleLayout, particle: usize, record: &mut Vec<f64>) {
        for label in layout.labels() {
            for component in 0..layout.width(label) {
                record.push(self.get(layout, label, particle, component));
            }
        }
    }

    /// Adds a particle whose numbers are `record`, label after label in the layout's order; `base` is its base node
    /// before rounding down.
    pub fn push(&mut self, layout: &ParticleLayout, rest: [f64; 3], base: [f64; 3], record: &[f64]) {
        extent::include(&mut self.extent, base);
        self.leaving = true;
        if self.count == self.capacity * LANES {
            self.grow(layout, rest);
        }
        let particle = self.count;
        self.count += 1;
        let mut numbers = record.iter();
        for label in layout.labels() {
            for (component, &value) in (0..layout.width(label)).zip(&mut numbers) {
                self.put(layout, label, particle, component, value);
            }
        }
    }

    /// Removes the particles at `leaving` (ascending). Others keep their places, but for the last ones: they take those that are left
    /// empty, one after the other.
    pub fn remove(&mut self, layout: &ParticleLayout, rest: [f64; 3], leaving: &[usize]) {
        let kept = self.count - leaving.len();
        let holes = leaving.iter().copied().take_while(|&particle| particle < kept);
        let last = (kept..self.count).filter(|particle| leaving.binary_search(particle).is_err());
        let moves: Vec<(usize, usize)> = last.zip(holes).collect();
        for label in layout.labels() {
            for &(from, to) in &moves {
                for component in 0..layout.width(label) {
                    let number = self.get(layout, label, from, component);
                    self.put(layout, label, to, component, number);
                }
            }
        }
        let end = self.tiles() * LANES;
        self.count = kept;
        self.make_inert(layout, rest, kept..end);
    }

    /// Makes room for at least one more tile; grows by an eighth, small blocks twofold, so that arrivals rarely copy.
    fn grow(&mut self, layout: &ParticleLayout, rest: [f64; 3]) {
        let old = self.capacity;
        self.reserve(layout, rest, old + old.clamp(1, 8).max(old / 8));
    }

    /// Puts into some lanes what is there without a particle.
    pub(super) fn make_inert(&mut self, layout: &ParticleLayout, rest: [f64; 3], lanes: Range<usize>) {
        for label in layout.labels() {
            for component in 0..layout.width(label) {
                let value = layout.inert(label, component, rest);
                lanes.clone().for_each(|lane| self.put(layout, label, lane, component, value));
            }
        }
    }
}

/// Twice the margin at which particles move: whoever looks closely rounds a little differently.
const NEAR: f64 = 2.0 * MARGIN;

/// Lanes of tiles whose base nodes, before rounding down, are not within bounds along each axis.
struct Strays<'a> {
    positions: &'a [Wide],
    inverse_cell: f64,
    shift: [f64; 3],
    within: [[f64; 2]; 3],
}

impl Job for Strays<'_> {
    type Output = Vec<Mask>;
    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<Mask> {
        let Self { positions, inverse_cell, shift, within } = self;
        let mut masks = Vec::with_capacity(positions.len() / 3);
        for tile in positions.as_chunks::<3>().0 {
            let mut inside = Mask::MAX;
            for axis in 0..3 {
                let y = S::load(&tile[axis]).fms(S::splat(inverse_cell), S::splat(shift[axis]));
                let [lower, upper] = within[axis].map(S::splat);
                inside &= y.ge(lower) & y.lt(upper);
            }
            masks.push(!inside);
        }
        masks
    }
}
