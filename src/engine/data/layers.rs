//! Which blocks of a list lie in which layers along x.
use std::ops::Range;

/// Where the layers of a list begin whose blocks are in x-major order.
#[derive(Clone, Debug, Default)]
pub struct Layers {
    /// The first layer.
    first: i32,
    /// The position of the first block of each layer, and the end.
    starts: Vec<u32>,
}

impl Layers {
    /// Notes the layers of all blocks.
    pub fn fill(&mut self, layers: impl Iterator<Item = i32>) {
        self.starts.clear();
        let mut count = 0;
        for layer in layers {
            if self.starts.is_empty() {
                self.first = layer;
            }
            // those between that have no block begin where this one does
            self.starts.resize((layer - self.first) as usize + 1, count);
            count += 1;
        }
        self.starts.push(count);
    }

    /// Positions of the blocks in some layers.
    pub fn positions(&self, wanted: &Range<i32>) -> Range<usize> {
        let last = self.starts.len().saturating_sub(1);
        let at = |layer: i32| self.starts.get(((layer - self.first).max(0) as usize).min(last));
        let at = |layer| at(layer).map_or(0, |start| *start as usize);
        at(wanted.start)..at(wanted.end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_are_where_their_blocks_are() {
        let blocks = [-3, -3, 0, 1, 1, 1, 5];
        let mut layers = Layers::default();
        assert_eq!(layers.positions(&(-9..9)), 0..0);
        layers.fill(blocks.into_iter());
        for (from, to) in (-6..9).flat_map(|from| (from..9).map(move |to| (from, to))) {
            let wanted = blocks.iter().filter(|layer| (from..to).contains(*layer));
            let found = &blocks[layers.positions(&(from..to))];
            assert!(found.iter().eq(wanted), "{from}..{to}: {found:?}");
        }
        layers.fill(std::iter::empty());
        assert_eq!(layers.positions(&(-9..9)), 0..0);
    }
}
