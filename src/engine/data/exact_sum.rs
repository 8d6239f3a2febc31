//! Sums of floating-point numbers that do not depend on the order of the summands.
use bytemuck::{Pod, Zeroable};
use simd::Wide;

/// 32-bit digits of a fixed-point number that spans all of `f64`, with carries deferred.
const DIGITS: usize = 72;
/// Exponent of the lowest digit's lowest bit.
const LOWEST: i32 = -1088;

/// An exact sum of `f64`: integer digits, so that additions commute and associate, and the same particles
/// give the same bits on any number of patches, threads and ranks.
///
/// Up to 2³⁰ numbers may be added before the value is read. Infinities and NaNs poison the sum.
/// After Neal, "Fast exact summation using small and large superaccumulators" (2015, arXiv:1505.05571).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct ExactSum {
    digits: [i64; DIGITS],
}

/// Cache lines of an [`ExactSum`].
pub const LINES: usize = size_of::<ExactSum>() / size_of::<Wide>();

impl Default for ExactSum {
    fn default() -> Self {
        Self { digits: [0; DIGITS] }
    }
}

impl ExactSum {
    /// The digit whose low bit says that something not finite was added.
    const POISON: usize = DIGITS - 1;

    /// Adds `x`.
    pub fn add(&mut self, x: f64) {
        if x == 0.0 {
            return;
        }
        if !x.is_finite() {
            self.digits[Self::POISON] = 1;
            return;
        }
        let bits = x.to_bits();
        let raw = (bits >> 52 & 0x7FF) as i32;
        let mantissa = (bits & ((1 << 52) - 1)) | if raw > 0 { 1 << 52 } else { 0 };
        let position = (raw.max(1) - 1075 - LOWEST) as usize;
        let (digit, shift) = (position / 32, position % 32);
        let wide = (mantissa as u128) << shift;
        let sign = if x < 0.0 { -1 } else { 1 };
        for i in 0..3 {
            self.digits[digit + i] += sign * (wide >> (32 * i) & 0xFFFF_FFFF) as i64;
        }
    }

    /// Adds another sum.
    pub fn merge(&mut self, other: &Self) {
        for (a, b) in self.digits.iter_mut().zip(&other.digits) {
            *a += b;
        }
    }

    /// The sum, rounded once or at most twice.
    pub fn value(&self) -> f64 {
        if self.digits[Self::POISON] != 0 {
            return f64::NAN;
        }
        let mut digits = self.digits;
        for i in 0..DIGITS - 2 {
            let carry = digits[i] >> 32;
            digits[i] -= carry << 32;
            digits[i + 1] += carry;
        }
        // all digits but the top are now in 0..2³², the top carries the sign
        let top = digits.iter().rposition(|&d| d != 0).unwrap_or(0);
        if digits[top] < 0 {
            let mut opposite = Self::default();
            for (a, b) in opposite.digits.iter_mut().zip(&digits) {
                *a = -b;
            }
            return -opposite.value();
        }
        let low = top.saturating_sub(3);
        let scale = |digit: usize| LOWEST + 32 * digit as i32;
        // the leading 96 to 128 bits; what lies below is far under the last bit of a double
        let head = (low..=top).rev().fold(0u128, |n, i| n << 32 | digits[i] as u128);
        scale_by_power_of_two(head as f64, scale(low))
    }
}

/// x · 2ᵉ in steps that neither overflow nor underflow early.
fn scale_by_power_of_two(mut x: f64, mut exponent: i32) -> f64 {
    while exponent != 0 && x != 0.0 && x.is_finite() {
        let step = exponent.clamp(-1000, 1000);
        x *= f64::from_bits(((1023 + step) as u64) << 52);
        exponent -= step;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(numbers: impl IntoIterator<Item = f64>) -> f64 {
        let mut s = ExactSum::default();
        numbers.into_iter().for_each(|x| s.add(x));
        s.value()
    }

    #[test]
    fn is_exact_where_a_plain_sum_is_not() {
        assert_eq!(sum([1e100, 1.0, -1e100]), 1.0);
        assert_eq!(sum([0.1; 10]), 1.0);
        assert_eq!(sum([-3.5, 1.25]), -2.25);
        assert_eq!(sum([f64::MIN_POSITIVE / 4.0, f64::MIN_POSITIVE / 4.0]), f64::MIN_POSITIVE / 2.0);
        assert_eq!(sum([1e308, -1e308]), 0.0);
        assert!(sum([1.0, f64::NAN]).is_nan());
    }

    #[test]
    fn does_not_depend_on_order_or_grouping() {
        let numbers: Vec<f64> =
            (1..2000).map(|i| (i as f64 * 0.7371).sin() * 10f64.powi(i % 61 - 30)).collect();
        let forward = sum(numbers.iter().copied());
        assert_eq!(forward.to_bits(), sum(numbers.iter().rev().copied()).to_bits());
        let mut halves = [ExactSum::default(); 2];
        numbers.iter().enumerate().for_each(|(i, &x)| halves[i % 2].add(x));
        let [mut a, b] = halves;
        a.merge(&b);
        assert_eq!(forward.to_bits(), a.value().to_bits());
    }
}
