//! Vectors in time.

/// A vector that is constant or piecewise linear in time: (time [s], value), times ascending, at least one row.
/// Before the first and after the last row the value is that of the row.
#[derive(Clone, Debug, PartialEq)]
pub struct Table(pub Vec<(f64, [f64; 3])>);

impl Table {
    /// Zero at all times.
    pub fn zero() -> Self {
        Self(vec![(0.0, [0.0; 3])])
    }

    /// Whether it is ever other than zero.
    pub fn acts(&self) -> bool {
        self.0.iter().any(|(_, value)| *value != [0.0; 3])
    }

    /// The mean value from a time on, over a time `span` [s]; with no span, the value.
    pub fn mean(&self, from: f64, span: f64) -> [f64; 3] {
        match (&self.0[..], span > 0.0) {
            ([(_, value)], _) => *value,
            (_, true) => self.integral(from, from + span).map(|sum| sum / span),
            (_, false) => self.at(from),
        }
    }

    /// The value at time `t` [s].
    pub fn at(&self, t: f64) -> [f64; 3] {
        let rows = &self.0;
        let next = rows.partition_point(|row| row.0 <= t);
        if next == 0 || next == rows.len() {
            return rows[next.saturating_sub(1)].1;
        }
        let ((t0, a), (t1, b)) = (rows[next - 1], rows[next]);
        let s = (t - t0) / (t1 - t0);
        std::array::from_fn(|i| a[i] + s * (b[i] - a[i]))
    }

    /// The values at times `from` and `to` [s], and those of the rows between them: linear in between.
    pub fn within(&self, from: f64, to: f64) -> impl Iterator<Item = (f64, [f64; 3])> {
        let first = self.0.partition_point(|row| row.0 <= from);
        let between = self.0[first..].iter().take_while(move |row| row.0 < to).copied();
        [(from, self.at(from))].into_iter().chain(between).chain([(to, self.at(to))])
    }

    /// ∫ value dt from time `from` to time `to` [s].
    pub fn integral(&self, from: f64, to: f64) -> [f64; 3] {
        let (mut sum, mut last) = ([0.0; 3], None);
        for (t, value) in self.within(from, to) {
            if let Some((before, old)) = last.replace((t, value)) {
                let old: [f64; 3] = old;
                (0..3).for_each(|a| sum[a] += 0.5 * (t - before) * (old[a] + value[a]));
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::Table;

    #[test]
    fn integrals_are_exact_across_rows_and_beyond_them() {
        let table = Table(vec![(1.0, [2.0, 0.0, 1.0]), (3.0, [4.0, -2.0, 1.0]), (4.0, [0.0, 0.0, 1.0])]);
        assert_eq!(table.integral(0.0, 6.0), [2.0 + 6.0 + 2.0, -2.0 - 1.0, 6.0]);
        assert_eq!(table.integral(2.0, 2.5), [0.5 * 0.5 * (3.0 + 3.5), -0.5 * 0.5 * (1.0 + 1.5), 0.5]);
        assert_eq!(table.integral(5.0, 5.5), [0.0, 0.0, 0.5]);
        assert_eq!(Table(vec![(0.0, [3.0, 0.0, 0.0])]).integral(1.0, 3.0), [6.0, 0.0, 0.0]);
    }
}
