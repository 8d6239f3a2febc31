//! exp, ln and the inverse cube root of the vector layer keep the errors that they state, on every instruction set.
use simd::{Isa, Job, Simd, Wide, math};

#[derive(Clone, Copy)]
enum Function {
    Exp,
    Ln,
    InverseCubeRoot,
}

struct Evaluate<'a>(Function, &'a [f64]);

impl Job for Evaluate<'_> {
    type Output = Vec<f64>;
    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<f64> {
        let eight = |x: &[f64]| {
            let x = S::load(&Wide(std::array::from_fn(|i| x[i % x.len()])));
            match self.0 {
                Function::Exp => math::exp(x),
                Function::Ln => math::ln(x),
                Function::InverseCubeRoot => math::inverse_cube_root(x),
            }
        };
        self.1.chunks(8).flat_map(|x| eight(x).lanes().into_iter().take(x.len())).collect()
    }
}

fn both(function: Function, x: &[f64], check: impl Fn(f64, f64)) {
    for isa in Isa::available() {
        let y = isa.dispatch(Evaluate(function, x));
        x.iter().zip(&y).for_each(|(&x, &y)| check(x, y));
    }
}

/// n numbers spread evenly, with ends that are no round numbers.
fn range(low: f64, high: f64, n: usize) -> Vec<f64> {
    (0..n).map(|i| low + (high - low) * (i as f64 + 0.381_966) / n as f64).collect()
}

// std errs by half an ulp itself (1.1e-16)
const SLACK: f64 = 1.2e-16;

#[test]
fn exp_keeps_its_error() {
    for x in [range(-700.0, 700.0, 400_000), range(-1.0, 1.0, 400_000), range(-1e-8, 1e-8, 1000)] {
        both(Function::Exp, &x, |x, y| {
            let error = (y / x.exp() - 1.0).abs();
            assert!(error < 4e-16 + SLACK, "exp {x}: {error:e}");
        });
    }
    both(Function::Exp, &[0.0, 1e4, -1e4], |x, y| match x {
        0.0 => assert_eq!(y, 1.0),
        x => assert!((y / (700.0 * x.signum()).exp() - 1.0).abs() < 6e-16),
    });
}

#[test]
fn ln_keeps_its_error() {
    let wide: Vec<f64> = range(-700.0, 700.0, 400_000).into_iter().map(f64::exp).collect();
    for x in [wide, range(0.01, 10.0, 400_000)] {
        both(Function::Ln, &x, |x, y| {
            let exact = x.ln();
            let error = (y - exact).abs();
            assert!(error < (4e-16 + SLACK) * exact.abs().max(1.0 / 32.0), "ln {x}: {error:e}");
        });
    }
    // near 1, where ln x ≈ x − 1, std is right to half an ulp of the value
    let near: Vec<f64> = range(-1e-3, 1e-3, 100_000).into_iter().map(|x| 1.0 + x).collect();
    both(Function::Ln, &near, |x, y| {
        let error = (y - x.ln()).abs();
        assert!(error < 1e-17 + SLACK * x.ln().abs(), "ln {x}: {error:e}");
    });
    both(Function::Ln, &[1.0], |_, y| assert_eq!(y, 0.0));
}

#[test]
fn the_inverse_cube_root_keeps_its_error() {
    let wide: Vec<f64> = range(-700.0, 700.0, 400_000).into_iter().map(f64::exp).collect();
    for x in [wide, range(0.01, 10.0, 400_000)] {
        both(Function::InverseCubeRoot, &x, |x, y| {
            let error = (y * x.cbrt() - 1.0).abs();
            assert!(error < 4e-16 + 2.0 * SLACK, "{x}: {error:e}");
        });
    }
    both(Function::InverseCubeRoot, &[1.0], |_, y| assert_eq!(y, 1.0));
}
