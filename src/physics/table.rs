//! Vectors in time.

/// A vector that is constant or piecewise linear in time: (time [s], value), times ascending, at least one row.
/// Before the first and after the last row the value is that of the row.
#[derive(Clone, Debug, PartialEq)]
pub struct Table(pub Vec<(f64, [f64; 3])>);

impl Table {
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
}
