//! Which number each particle of a body has, without a look at all those before it.
use super::filling::{Filling, Span, common, halves, size};
use std::ops::{ControlFlow, Range};

/// The particles of a body by their numbers in the order of [`super::sample`]. Counted are rows of cells, each through the whole
/// body along z; whoever knows how many particles each row has knows the first number of each.
#[derive(Debug)]
pub struct Numbering {
    filling: Filling,
    cells: Span,
    /// Cells of a row along y.
    width: i64,
    /// Rows beside each other along y.
    across: i64,
    /// The first number of each row, and the end.
    starts: Vec<u64>,
}

impl Numbering {
    /// Rows of a lattice: about as many as `most`, unless that takes more than one a layer of cells.
    pub fn new(filling: Filling, most: usize) -> Self {
        let cells = match size(filling.span()) {
            0 => [0..0, 0..0, 0..0],
            _ => filling.cells_of(filling.span()),
        };
        let [nx, ny, _] = cells.each_ref().map(|range| range.end - range.start);
        let a_layer = (most as i64 / nx.max(1)).max(1);
        let width = (ny.max(1) as u64).div_ceil(a_layer as u64) as i64;
        let across = (ny.max(0) as u64).div_ceil(width as u64) as i64;
        Self { filling, cells, width, across, starts: vec![0] }
    }

    /// The lattice.
    pub fn filling(&self) -> &Filling {
        &self.filling
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        ((self.cells[0].end - self.cells[0].start) * self.across) as usize
    }

    /// The cells of a row.
    fn row_cells(&self, row: usize) -> Span {
        let [x, y] = [row as i64 / self.across, row as i64 % self.across];
        let (x, y) = (self.cells[0].start + x, self.cells[1].start + y * self.width);
        [x..x + 1, y..(y + self.width).min(self.cells[1].end), self.cells[2].clone()]
    }

    /// The points of a row.
    pub fn row(&self, row: usize) -> Span {
        self.filling.of_cells(&self.row_cells(row))
    }

    /// Tells how many particles each row has.
    pub fn number(&mut self, counts: impl Iterator<Item = u64>) {
        self.starts.truncate(1);
        let mut sum = 0;
        self.starts.extend(counts.map(|count| {
            sum += count;
            sum
        }));
    }

    /// Number of particles.
    pub fn count(&self) -> u64 {
        self.starts.last().copied().unwrap_or(0)
    }

    /// Particles before those of the cells at x, y.
    fn before(&self, x: i64, y: i64) -> u64 {
        let [i, j] = [x - self.cells[0].start, y - self.cells[1].start];
        let (row, first) = ((i * self.across + j / self.width) as usize, y - j % self.width);
        self.starts[row] + self.count_cells(&[x..x + 1, first..y, self.cells[2].clone()])
    }

    fn count_cells(&self, cells: &Span) -> u64 {
        if size(cells) == 0 { 0 } else { self.filling.count(&self.filling.of_cells(cells)) }
    }

    /// The number of a particle.
    pub fn number_of(&self, point: [i64; 3]) -> u64 {
        let [[x, y, z], _] = self.filling.order(point);
        let below = [x..x + 1, y..y + 1, self.cells[2].start..z];
        let earlier = self.filling.of_cell([x, y, z]).take_while(|other| *other != point);
        let earlier = earlier.filter(|other| self.filling.contains(*other)).count() as u64;
        self.before(x, y) + self.count_cells(&below) + earlier
    }

    /// Hands out the particles among some points, with their numbers, in the order of these.
    pub fn fill(&self, points: &Span, pencils: &mut Pencils, each: &mut impl FnMut(u64, [f64; 3])) {
        let points = common(points, self.filling.span());
        if size(&points) == 0 {
            return;
        }
        let cells = self.filling.cells_of(&points);
        let [xs, ys, zs] = cells.clone();
        pencils.turn_to(&cells);
        for (place, [x, y]) in xs.flat_map(|x| ys.clone().map(move |y| [x, y])).enumerate() {
            let known = pencils.known[place].filter(|(z, _)| *z <= zs.start);
            let (from, before) = known.unwrap_or_else(|| (self.cells[2].start, self.before(x, y)));
            let mut number = before + self.count_cells(&[x..x + 1, y..y + 1, from..zs.start]);
            pencils.known[place] = Some((zs.start, number));
            let whole = self.filling.holds(&self.filling.of_cells(&[x..x + 1, y..y + 1, zs.clone()]));
            if whole == Some(false) {
                continue;
            }
            for z in zs.clone() {
                pencils.known[place] = Some((z, number));
                let all = whole
                    .or_else(|| self.filling.holds(&self.filling.of_cells(&[x..x + 1, y..y + 1, z..z + 1])));
                if all == Some(false) {
                    continue;
                }
                for point in self.filling.of_cell([x, y, z]) {
                    let wanted = (0..3).all(|a| points[a].contains(&point[a]));
                    if all.is_some() {
                        self.filling.visit(u64::from(wanted));
                    } else if !self.filling.contains(point) {
                        continue;
                    }
                    if wanted {
                        each(number, self.filling.place(point));
                    }
                    number += 1;
                }
            }
        }
    }

    /// The numbers of the particles of a row that are in `region` as well: ranges, ascending.
    pub fn members(&self, row: usize, region: &Filling) -> Vec<Range<u64>> {
        let (mut number, mut members) = (self.starts[row], Vec::new());
        self.add_members(&self.row_cells(row), region, &mut number, &mut members);
        members
    }

    fn add_members(&self, cells: &Span, region: &Filling, number: &mut u64, members: &mut Vec<Range<u64>>) {
        let points = self.filling.of_cells(cells);
        if size(cells) == 0 || self.filling.holds(&points) == Some(false) {
            return;
        }
        let mut add = |count: u64, are: bool| {
            if are {
                match members.last_mut() {
                    Some(last) if last.end == *number => last.end += count,
                    _ => members.push(*number..*number + count),
                }
            }
            *number += count;
        };
        match region.holds(&points) {
            Some(true) => add(size(&points), true),
            Some(false) => add(self.filling.count(&points), false),
            None if size(cells) == 1 => {
                let cell = cells.each_ref().map(|range| range.start);
                for point in self.filling.of_cell(cell).filter(|point| self.filling.contains(*point)) {
                    add(1, region.contains(point));
                }
            }
            None => {
                for half in in_order(cells) {
                    self.add_members(&half, region, number, members);
                }
            }
        }
    }

    /// Where the particles with some numbers are [m]. `wanted` are numbers, ascending, with something to know each by.
    pub fn places(&self, wanted: &[(u64, usize)], each: &mut impl FnMut(usize, [f64; 3])) {
        let mut rest = wanted;
        while let Some(&(number, _)) = rest.first() {
            if number >= self.count() {
                return;
            }
            let row = self.starts.partition_point(|start| *start <= number) - 1;
            let here = rest.partition_point(|(number, _)| *number < self.starts[row + 1]);
            self.find(&self.row_cells(row), self.starts[row], &rest[..here], each);
            rest = &rest[here..];
        }
    }

    /// Those among some cells, whose first particle has the number `first`.
    fn find(
        &self,
        cells: &Span,
        first: u64,
        wanted: &[(u64, usize)],
        each: &mut impl FnMut(usize, [f64; 3]),
    ) {
        if wanted.is_empty() {
            return;
        }
        if size(cells) == 1 {
            let cell = cells.each_ref().map(|range| range.start);
            let inside = self.filling.of_cell(cell).filter(|point| self.filling.contains(*point));
            let (mut numbered, mut rest) = ((first..).zip(inside), wanted);
            while let (Some(&(number, name)), Some((found, point))) = (rest.first(), numbered.next()) {
                if found == number {
                    each(name, self.filling.place(point));
                    rest = &rest[1..];
                }
            }
            return;
        }
        let [former, latter] = in_order(cells);
        let end = first + self.count_cells(&former);
        let (below, above) = wanted.split_at(wanted.partition_point(|(number, _)| *number < end));
        self.find(&former, first, below, each);
        self.find(&latter, end, above, each);
    }

    /// Visits the boxes of particles of a row: as [`Filling::pieces`].
    pub fn pieces(&self, row: usize, each: &mut impl FnMut(&Span)) {
        let _ = self.filling.pieces(&self.row(row), &mut |piece: &Span| {
            each(piece);
            ControlFlow::<()>::Continue(())
        });
    }
}

/// Cells in two, such that all of the first come before those of the second.
fn in_order(cells: &Span) -> [Span; 2] {
    let axis = (0..3).find(|&a| cells[a].end - cells[a].start > 1).unwrap_or(2);
    halves(cells, axis)
}

/// How far the pencils of cells along z are counted above which blocks are filled one after the other.
#[derive(Debug, Default)]
pub struct Pencils {
    /// The cells along x and y.
    cells: [Range<i64>; 2],
    /// The cell of each up to which its particles are counted, and the number of the first one in it.
    known: Vec<Option<(i64, u64)>>,
}

impl Pencils {
    fn turn_to(&mut self, [x, y, _]: &Span) {
        if self.cells != [x.clone(), y.clone()] {
            self.cells = [x.clone(), y.clone()];
            self.known.clear();
            self.known.resize(((x.end - x.start) * (y.end - y.start)) as usize, None);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{inside, points};
    use super::*;
    use crate::Domain;
    use crate::geometry::{Solid, rotation};

    const DOMAIN: Domain = Domain { lower: [-1.0, 0.5, 2.0], cells: [24, 20, 28], cell: 0.25 };

    fn solids() -> Vec<Solid> {
        let slab = Solid::Box { lower: [0.0, 1.0, 2.5], upper: [4.1, 4.0, 8.0] };
        let ball = Solid::Sphere { center: [2.0, 3.0, 5.5], radius: 2.3 };
        let rod = Solid::Capsule { ends: [[-0.5, 1.0, 2.5], [4.5, 5.0, 8.5]], radius: 0.4 };
        let turned = Solid::Rotate {
            rotation: rotation([0.6, 0.0, 0.8], 0.5),
            about: [2.0, 3.0, 5.0],
            solid: Box::new(slab.clone()),
        };
        let shell = Solid::Difference(
            Box::new(ball.clone()),
            vec![Solid::Sphere { center: [2.0, 3.0, 5.5], radius: 2.1 }],
        );
        let both = Solid::Union(vec![slab.clone(), rod.clone()]);
        let empty = Solid::Box { lower: [0.0; 3], upper: [1e-3; 3] };
        vec![slab, ball, rod, turned, shell, both, empty]
    }

    /// The lattices of all solids, with their rows counted, and their particles as they are numbered.
    fn all(n: [usize; 3], most: usize) -> Vec<(Numbering, Vec<[f64; 3]>)> {
        let one = |solid: Solid| {
            let plain = points(&DOMAIN, n, &solid, inside(&DOMAIN)).collect();
            let mut numbering = Numbering::new(Filling::new(&DOMAIN, n, solid, inside(&DOMAIN)), most);
            let counts: Vec<u64> =
                (0..numbering.rows()).map(|row| numbering.filling.count(&numbering.row(row))).collect();
            numbering.number(counts.into_iter());
            (numbering, plain)
        };
        solids().into_iter().map(one).collect()
    }

    /// Boxes of points that make up the lattice, in columns along z: some end in the middle of a cell.
    fn blocks(span: &Span, side: i64) -> Vec<Span> {
        let cut = |range: &Range<i64>| -> Vec<Range<i64>> {
            let (start, end) = (range.start - 1, range.end);
            (0..=(end - start) / side).map(|i| start + i * side..(start + (i + 1) * side).min(end)).collect()
        };
        let [xs, ys, zs] = span.each_ref().map(cut);
        let columns = xs.iter().flat_map(|x| ys.iter().map(move |y| [x, y]));
        columns.flat_map(|[x, y]| zs.iter().map(move |z| [x.clone(), y.clone(), z.clone()])).collect()
    }

    #[test]
    fn numbers_are_those_of_the_plain_order_whatever_box_is_asked_for() {
        for (n, most, side) in [([2; 3], 1 << 20, 8), ([1, 2, 3], 100, 5), ([3, 1, 2], 1, 7)] {
            for (numbering, plain) in all(n, most) {
                assert_eq!(numbering.count(), plain.len() as u64);
                assert_eq!(numbering.filling.count(numbering.filling.span()), plain.len() as u64);
                assert_eq!(numbering.filling.any().is_some(), !plain.is_empty());
                let (mut pencils, mut seen) = (Pencils::default(), vec![false; plain.len()]);
                for block in blocks(numbering.filling.span(), side) {
                    let mut last = None;
                    let each = &mut |number: u64, x| {
                        assert!(last < Some(number), "in their order");
                        assert!(x == plain[number as usize] && !seen[number as usize], "{number}: {x:?}");
                        (last, seen[number as usize]) = (Some(number), true);
                    };
                    numbering.fill(&block, &mut pencils, each);
                }
                assert!(seen.iter().all(|seen| *seen));
                for point in super::super::points_of(numbering.filling.span()).step_by(37) {
                    if numbering.filling.contains(point) {
                        let number = numbering.number_of(point) as usize;
                        assert_eq!(plain[number], numbering.filling.place(point));
                    }
                }
            }
        }
    }

    #[test]
    fn particles_are_found_by_their_numbers() {
        for (numbering, plain) in all([2, 1, 3], 50) {
            let wanted: Vec<(u64, usize)> = (0..plain.len() as u64 + 9).step_by(7).zip(0..).collect();
            let mut found = vec![None; wanted.len()];
            numbering.places(&wanted, &mut |name, x| found[name] = Some(x));
            for ((number, _), found) in wanted.iter().zip(found) {
                assert_eq!(found, plain.get(*number as usize).copied(), "{number}");
            }
        }
    }

    #[test]
    fn members_are_those_that_lie_in_the_region_too() {
        let region = Solid::Sphere { center: [2.5, 2.5, 6.0], radius: 1.4 };
        let n = [2, 3, 1];
        for ((numbering, plain), solid) in all(n, 60).into_iter().zip(solids()) {
            let both = Filling::new(&DOMAIN, n, solid, inside(&DOMAIN)).and_in(&region);
            let members = (0..numbering.rows()).flat_map(|row| numbering.members(row, &both)).flatten();
            let wanted = (0..).zip(&plain).filter(|(_, x)| region.contains(**x)).map(|(number, _)| number);
            assert!(members.eq(wanted));
        }
    }

    #[test]
    fn what_is_counted_is_not_walked() {
        let domain = Domain { lower: [0.0; 3], cells: [4096; 3], cell: 1.0 };
        let count = |solid: Solid| {
            let filling = Filling::new(&domain, [2; 3], solid, inside(&domain));
            (filling.count(filling.span()), filling.visited())
        };
        let (all, visited) = count(Solid::Box { lower: [0.0; 3], upper: [4096.0; 3] });
        assert_eq!((all, visited), (1 << 39, 1));
        let (all, visited) = count(Solid::Box { lower: [1.0; 3], upper: [300.0, 400.0, 500.0] });
        assert!(all == 8 * 299 * 399 * 499 && visited < 200, "{visited}");
        let (all, visited) = count(Solid::Sphere { center: [2000.0; 3], radius: 120.0 });
        let volume = 4.0 / 3.0 * std::f64::consts::PI * 240.0f64.powi(3);
        assert!((all as f64 / volume - 1.0).abs() < 1e-3);
        assert!(visited * 8 < all, "{visited} of {all}");
    }
}
