//! The lattice of a body, box by box: which of its points are particles, and which number each has.
use super::{cells, inside};
use crate::geometry::{Bounds, Solid, overlap};
use crate::{Body, Domain, Scene};
use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Points of a lattice along each axis, counted from the lower corner of the domain.
pub type Span = [Range<i64>; 3];

/// Points of a box that are looked at one by one; of larger ones that a surface cuts, halves are looked at.
const FEW: i64 = 8;

/// The lattice around a solid. Its points in the solid are particles. What lies wholly inside or outside is not looked at point
/// by point, so that counting takes as long as the surface is large.
#[derive(Debug)]
pub struct Filling {
    domain: Domain,
    /// Points along each axis of a cell.
    n: [i64; 3],
    solid: Solid,
    span: Span,
    visited: AtomicU64,
}

/// Points of a box of the lattice.
pub fn size(span: &Span) -> u64 {
    span.iter().map(|range| (range.end - range.start).max(0) as u64).product()
}

/// What two boxes of a lattice share.
pub fn common(a: &Span, b: &Span) -> Span {
    std::array::from_fn(|i| a[i].start.max(b[i].start)..a[i].end.min(b[i].end))
}

impl Filling {
    /// That of a body: its particles are those of [`super::sample`].
    pub fn of(scene: &Scene, body: &Body) -> Self {
        Self::new(&scene.domain, body.particles_per_cell, body.solid.clone(), inside(&scene.domain))
    }

    /// The particles of a body that lie in a solid besides.
    pub fn within(scene: &Scene, body: &Body, solid: &Solid) -> Self {
        Self::of(scene, body).and_in(solid)
    }

    /// The same lattice, of which what lies in another solid as well are particles.
    pub(super) fn and_in(self, solid: &Solid) -> Self {
        Self { solid: Solid::Intersection(vec![self.solid, solid.clone()]), ..self }
    }

    /// `n` points along each axis of each cell that the solid touches within `limits`: those of [`super::points`].
    pub fn new(domain: &Domain, n: [usize; 3], solid: Solid, limits: Bounds) -> Self {
        let (touched, n) = (cells(domain, overlap(solid.bounds(), limits)), n.map(|n| n as i64));
        let span = std::array::from_fn(|a| {
            let end = touched[a].end.max(touched[a].start);
            touched[a].start.saturating_mul(n[a])..end.saturating_mul(n[a])
        });
        Self { domain: *domain, n, solid, span, visited: AtomicU64::new(0) }
    }

    /// All points, inside or not.
    pub fn span(&self) -> &Span {
        &self.span
    }

    /// The points of some cells.
    pub fn of_cells(&self, cells: &Span) -> Span {
        std::array::from_fn(|a| cells[a].start * self.n[a]..cells[a].end * self.n[a])
    }

    /// The cells of some points.
    pub fn cells_of(&self, points: &Span) -> Span {
        std::array::from_fn(|a| {
            let of = |j: i64| j.div_euclid(self.n[a]);
            of(points[a].start)..of(points[a].end - 1) + 1
        })
    }

    /// How many points and boxes were looked at so far.
    pub fn visited(&self) -> u64 {
        self.visited.load(Relaxed)
    }

    /// Notes that so many points were looked at.
    pub fn visit(&self, points: u64) {
        self.visited.fetch_add(points, Relaxed);
    }

    /// A coordinate of the points `j` along an axis [m]: as [`super::points`] has it.
    pub fn at(&self, axis: usize, j: i64) -> f64 {
        let (c, i) = (j.div_euclid(self.n[axis]), j.rem_euclid(self.n[axis]));
        let Domain { lower, cell, .. } = self.domain;
        lower[axis] + (c as f64 + (i as f64 + 0.5) / self.n[axis] as f64) * cell
    }

    /// The place of a point [m].
    pub fn place(&self, point: [i64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| self.at(a, point[a]))
    }

    /// The box around some points [m].
    pub fn bounds(&self, span: &Span) -> Bounds {
        (
            std::array::from_fn(|a| self.at(a, span[a].start)),
            std::array::from_fn(|a| self.at(a, span[a].end - 1)),
        )
    }

    /// Whether all of some points are particles, or none; `None` if that is not known without looking at them.
    pub fn holds(&self, span: &Span) -> Option<bool> {
        self.visit(1);
        self.solid.holds(self.bounds(span))
    }

    /// Whether a point is a particle.
    pub fn contains(&self, point: [i64; 3]) -> bool {
        self.visit(1);
        self.solid.contains(self.place(point))
    }

    /// Number of particles in a box of points.
    pub fn count(&self, span: &Span) -> u64 {
        let mut count = 0;
        let _ = self.pieces(span, &mut |piece| {
            count += size(piece);
            ControlFlow::<()>::Continue(())
        });
        count
    }

    /// Boxes of particles alone that make up all particles in a box of points, in an order that depends on that box alone.
    pub fn pieces<B>(&self, span: &Span, each: &mut impl FnMut(&Span) -> ControlFlow<B>) -> ControlFlow<B> {
        if size(span) == 0 {
            return ControlFlow::Continue(());
        }
        match self.holds(span) {
            Some(true) => each(span),
            Some(false) => ControlFlow::Continue(()),
            None if size(span) <= FEW as u64 => {
                for point in points_of(span).filter(|point| self.contains(*point)) {
                    each(&point.map(|j| j..j + 1))?;
                }
                ControlFlow::Continue(())
            }
            None => halves(span, longest(span)).iter().try_for_each(|half| self.pieces(half, each)),
        }
    }

    /// Looks at the particles in a box of points, but for boxes that `skip` says are of no interest: what `test` breaks with first.
    pub fn search<B>(
        &self,
        span: &Span,
        skip: &impl Fn(Bounds) -> bool,
        test: &mut impl FnMut([i64; 3], [f64; 3]) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        if size(span) == 0 || self.holds(span) == Some(false) || skip(self.bounds(span)) {
            return ControlFlow::Continue(());
        }
        if size(span) > FEW as u64 {
            return halves(span, longest(span)).iter().try_for_each(|half| self.search(half, skip, test));
        }
        points_of(span)
            .filter(|point| self.contains(*point))
            .try_for_each(|point| test(point, self.place(point)))
    }

    /// Some particle, if there is one [m].
    pub fn any(&self) -> Option<[f64; 3]> {
        let first = |piece: &Span| ControlFlow::Break(self.place([0, 1, 2].map(|a| piece[a].start)));
        self.pieces(&self.span, &mut { first }).break_value()
    }

    /// The points of a cell in the order of [`super::sample`].
    pub fn of_cell(&self, cell: [i64; 3]) -> impl Iterator<Item = [i64; 3]> + use<> {
        points_of(&self.of_cells(&cell.map(|c| c..c + 1)))
    }

    /// What orders points as [`super::sample`] does: the cell, and the place in it.
    pub fn order(&self, point: [i64; 3]) -> [[i64; 3]; 2] {
        [
            std::array::from_fn(|a| point[a].div_euclid(self.n[a])),
            std::array::from_fn(|a| point[a].rem_euclid(self.n[a])),
        ]
    }
}

/// The points of a box, the last axis fastest.
pub fn points_of(span: &Span) -> impl Iterator<Item = [i64; 3]> + use<> {
    let [xs, ys, zs] = span.clone();
    xs.flat_map(move |x| {
        let zs = zs.clone();
        ys.clone().flat_map(move |y| zs.clone().map(move |z| [x, y, z]))
    })
}

/// The axis along which a box has most points: the first of several.
fn longest(span: &Span) -> usize {
    let length = |a: usize| span[a].end - span[a].start;
    (1..3).fold(0, |most, a| if length(a) > length(most) { a } else { most })
}

/// A box in two along an axis.
pub(super) fn halves(span: &Span, axis: usize) -> [Span; 2] {
    let middle = span[axis].start + (span[axis].end - span[axis].start) / 2;
    let (mut first, mut second) = (span.clone(), span.clone());
    (first[axis].end, second[axis].start) = (middle, middle);
    [first, second]
}
