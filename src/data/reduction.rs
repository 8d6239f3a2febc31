//! How contributions of blocks, threads and ranks to a label combine, exactly and in any order.
use super::exact_sum::{ExactSum, LINES};
use super::label::Reduce;
use crate::simd::Wide;

/// Sets `lines` to what adds nothing.
pub fn clear(reduce: Reduce, lines: &mut [Wide]) {
    let value = match reduce {
        Reduce::No | Reduce::Sum => 0.0,
        Reduce::Max => f64::NEG_INFINITY,
        Reduce::First => f64::INFINITY,
    };
    lines.fill(Wide([value; 8]));
}

/// Adds `from` to `into`.
pub fn merge(reduce: Reduce, into: &mut [Wide], from: &[Wide]) {
    match reduce {
        Reduce::No => into.copy_from_slice(from),
        Reduce::Sum => {
            let sums = into.chunks_exact_mut(LINES).zip(from.chunks_exact(LINES));
            for (a, b) in sums {
                let [a]: &mut [ExactSum] = bytemuck::cast_slice_mut(a) else { continue };
                let [b]: &[ExactSum] = bytemuck::cast_slice(b) else { continue };
                a.merge(b);
            }
        }
        Reduce::Max => {
            for (a, b) in into.iter_mut().zip(from) {
                // NaN wins: it must not be lost
                for (a, &b) in a.0.iter_mut().zip(&b.0) {
                    if b > *a || b.is_nan() {
                        *a = b;
                    }
                }
            }
        }
        Reduce::First => {
            for (a, b) in into.iter_mut().zip(from) {
                if earlier(b, a) {
                    *a = *b;
                }
            }
        }
    }
}

/// Whether line `a` comes before `b`: by lane 0, then by lane 1 (both count up).
pub fn earlier(a: &Wide, b: &Wide) -> bool {
    (a.0[0], a.0[1]) < (b.0[0], b.0[1])
}
