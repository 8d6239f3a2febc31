//! From which number to which colors go.
use crate::lab::figure::colors::Map;

/// From which number to which colors go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// The number of the first color.
    pub low: f64,
    /// The number of the last color.
    pub high: f64,
    /// Whether there are numbers below, and above.
    pub beyond: [bool; 2],
}

/// Numbers beyond this share at either end do not stretch the colors, if they lie far out: one particle would hide all others.
const FEW: f64 = 0.005;

impl Span {
    /// Of nothing.
    pub const NOTHING: Self = Self { low: f64::INFINITY, high: f64::NEG_INFINITY, beyond: [false; 2] };

    /// Of the numbers of a frame that are shown.
    pub fn of(mut numbers: Vec<f64>) -> Self {
        numbers.sort_by(f64::total_cmp);
        let (Some(&least), Some(&most)) = (numbers.first(), numbers.last()) else { return Self::NOTHING };
        let few = (FEW * numbers.len() as f64) as usize;
        let [low, high] = [numbers[few], numbers[numbers.len() - 1 - few]];
        let far = |beyond: f64| beyond > high - low;
        let beyond = [far(low - least), far(most - high)];
        Self { low: if beyond[0] { low } else { least }, high: if beyond[1] { high } else { most }, beyond }
    }

    /// Of both.
    pub fn with(self, other: Self) -> Self {
        let beyond = [0, 1].map(|i| self.beyond[i] || other.beyond[i]);
        Self { low: self.low.min(other.low), high: self.high.max(other.high), beyond }
    }

    /// With ends that people like, and the map for it: white is zero where there are numbers on both sides of it.
    pub fn rounded(self) -> (Self, Map) {
        let Self { low, high, beyond } = self;
        if low > high {
            return (Self { low: 0.0, high: 1.0, beyond }, Map::Rising);
        }
        let most = low.abs().max(high.abs());
        if low < -0.05 * most && high > 0.05 * most {
            return (Self { low: -most, high: most, beyond }, Map::Balanced);
        }
        let low =
            if low.abs() < 0.3 * high.abs() || low >= 0.0 && low < 0.3 * high { low.min(0.0) } else { low };
        let high = if high.abs() < 0.3 * low.abs() { high.max(0.0) } else { high };
        let least = 1e-12 * most.max(f64::MIN_POSITIVE);
        (
            Self { low, high: if high - low > least { high } else { low + most.max(1e-30) }, beyond },
            Map::Rising,
        )
    }
}
