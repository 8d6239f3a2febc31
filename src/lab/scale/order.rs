//! The engine's order of a tick, as ranks of the model go through it.
use engine::exec::order::{self, Cursor, Op, Segment, Wave};
use engine::graph::build::TaskGraph;

/// The order of a tick for ranks with so many slabs.
pub struct Order(Vec<Piece>);

enum Piece {
    One(Op),
    Wave(Wave),
}

impl Order {
    /// The order of a graph in so many slabs; on one rank, or on several.
    pub fn new(graph: &TaskGraph, slabs: usize, alone: bool) -> Self {
        let pieces = order::segments(graph).map(|segment| match segment {
            Segment::One(op) => Piece::One(op),
            Segment::Wave(phases) => {
                let mut wave = Wave::default();
                wave.fill(graph, phases, slabs, alone);
                Piece::Wave(wave)
            }
        });
        Self(pieces.chain(order::end(graph).iter().copied().map(Piece::One)).collect())
    }
}

/// How far a rank is in a tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct Place {
    piece: usize,
    cursor: Cursor,
}

impl Place {
    /// What to do next; `None` at the end. See [`Cursor::next`].
    ///
    /// # Errors
    /// Those of `here`; then the rank is where it was.
    pub fn next<E>(
        &mut self,
        order: &Order,
        mut here: impl FnMut(usize) -> Result<bool, E>,
    ) -> Result<Option<Op>, E> {
        while let Some(piece) = order.0.get(self.piece) {
            let (op, over) = match piece {
                Piece::One(op) => (Some(*op), true),
                Piece::Wave(wave) => {
                    let op = self.cursor.next(wave, &mut here)?;
                    (op, op.is_none())
                }
            };
            if over {
                *self = Self { piece: self.piece + 1, ..Self::default() };
            }
            if op.is_some() {
                return Ok(op);
            }
        }
        Ok(None)
    }
}
