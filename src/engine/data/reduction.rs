//! How contributions of blocks, threads and ranks to a label combine.
use super::exact_sum::{ExactSum, LINES};
use crate::schema::Combine;
use simd::Wide;

/// What adds nothing.
pub fn nothing(combine: Combine) -> f64 {
    match combine {
        Combine::None | Combine::Sum | Combine::Exact => 0.0,
        Combine::Max => f64::NEG_INFINITY,
        Combine::First => f64::INFINITY,
    }
}

/// Sets `lines` to what adds nothing.
pub fn clear(combine: Combine, lines: &mut [Wide]) {
    lines.fill(Wide([nothing(combine); 8]));
}

/// Adds `from` to `into`.
pub fn merge(combine: Combine, into: &mut [Wide], from: &[Wide]) {
    match combine {
        Combine::None => into.copy_from_slice(from),
        Combine::Sum => {
            for (a, b) in into.iter_mut().zip(from) {
                a.0.iter_mut().zip(b.0).for_each(|(a, b)| *a += b);
            }
        }
        Combine::Exact => {
            let sums = into.chunks_exact_mut(LINES).zip(from.chunks_exact(LINES));
            for (a, b) in sums {
                let [a]: &mut [ExactSum] = bytemuck::cast_slice_mut(a) else { continue };
                let [b]: &[ExactSum] = bytemuck::cast_slice(b) else { continue };
                a.merge(b);
            }
        }
        Combine::Max => {
            for (a, b) in into.iter_mut().zip(from) {
                // NaN wins: it must not be lost
                for (a, &b) in a.0.iter_mut().zip(&b.0) {
                    if b > *a || b.is_nan() {
                        *a = b;
                    }
                }
            }
        }
        Combine::First => {
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
