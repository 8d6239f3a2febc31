//! The bound of ρ₀ c² against the acoustic tensor by differences of the stress.
use crate::harness::*;
use nalgebra::SymmetricEigen;
use physics::law::Law;
use physics::materials::j2::J2;
use physics::materials::neo_hookean::NeoHookean;
use physics::materials::tissue::Tissue;
use simd::Isa;

/// Largest eigenvalue of the acoustic tensor A_ik(n) = d/dε [τ(ε) n]_i / (1 + ε n_k) along F → (I + ε e_k⊗n) F.
fn largest<L: Law>(law: &L, from: &Point, n: &V3) -> f64 {
    let a = acoustic(law, from, n);
    SymmetricEigen::new((a + a.transpose()) / 2.0).eigenvalues.max()
}

/// A(n) itself.
fn acoustic<L: Law>(law: &L, from: &Point, n: &V3) -> M3 {
    let h = 1e-6;
    let mut points = Vec::with_capacity(6);
    for k in 0..3 {
        for epsilon in [h, -h] {
            let mut map = M3::identity();
            (0..3).for_each(|c| map[(k, c)] += epsilon * n[c]);
            points.push(Point {
                f: map * from.f,
                increment: map * from.increment,
                history: from.history.clone(),
            });
        }
    }
    let answers = run(Isa::detect(), law, &points);
    let traction = |i: usize, factor: f64| answers[i].kirchhoff * n / factor;
    let column = |k: usize| {
        let (up, down) = (traction(2 * k, 1.0 + h * n[k]), traction(2 * k + 1, 1.0 - h * n[k]));
        (up - down) / (2.0 * h)
    };
    M3::from_columns(&[column(0), column(1), column(2)])
}

/// The maximum over directions: many at random, then a walk uphill.
fn maximum<L: Law>(law: &L, from: &Point, random: &mut Random) -> f64 {
    let (mut best, mut at) = (f64::NEG_INFINITY, V3::x());
    for _ in 0..60 {
        let n = random.direction();
        let value = largest(law, from, &n);
        if value > best {
            (best, at) = (value, n);
        }
    }
    let mut radius = 0.3;
    for _ in 0..60 {
        let n = (at + radius * random.direction()).normalize();
        let value = largest(law, from, &n);
        if value > best {
            (best, at) = (value, n);
        } else {
            radius *= 0.9;
        }
    }
    best
}

struct Range {
    j: [f64; 2],
    stretch: f64,
}

const WIDE: Range = Range { j: [0.2, 2.0], stretch: 2.0 };
const TYPICAL: Range = Range { j: [0.7, 1.1], stretch: 1.25 };

/// Mean and largest ratio bound / truth over random states.
fn tightness<L: Law>(law: &L, range: &Range, code: Option<f64>, kinks: &[f64]) -> (f64, f64) {
    let mut random = Random(51);
    let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0.0);
    while count < 300.0 {
        let (f, fiber) = (random.deformation(range.j, range.stretch), random.direction());
        let stretch = (f * fiber).norm() / f.determinant().cbrt();
        if kinks.iter().any(|kink| (stretch - kink).abs() < 1e-4) {
            continue;
        }
        let mut point = Point::virgin(law, f, fiber);
        if let Some(code) = code {
            point.history[3] = code;
        }
        let bound = step(law, &point).modulus;
        let truth = maximum(law, &point, &mut random);
        assert!(
            bound >= truth - 1e-6 * bound.max(1.0),
            "bound {bound} below {truth} at {f}, stretch {stretch}"
        );
        // fibers alone carry no wave while slack
        if truth > 1.0 {
            (sum, worst, count) = (sum + bound / truth, worst.max(bound / truth), count + 1.0);
        }
    }
    (sum / count, worst)
}

fn report<L: Law>(name: &str, law: &L, code: Option<f64>, kinks: &[f64]) {
    let (mean, worst) = tightness(law, &WIDE, code, kinks);
    let (typical_mean, typical) = tightness(law, &TYPICAL, code, kinks);
    println!(
        "{name:24} wide: mean {mean:.3} worst {worst:.3}  typical: mean {typical_mean:.3} worst {typical:.3}"
    );
    assert!(worst < 1.7 && typical < 1.25);
}

#[test]
fn no_wave_outruns_the_bound() {
    report("neo-hookean", &RUBBER, None, &[]);
    report("neo-hookean K = μ", &NeoHookean { bulk: 1e3, shear: 1e3 }, None, &[]);
    report("j2 below yield", &J2 { elastic: RUBBER, yield_stress: 1e12, hardening: 0.0 }, None, &[]);
    for law in tissues() {
        let Tissue { c1, c3, c4, c5, straight, bulk, .. } = law;
        let failing = Tissue { c1, c3, c4, c5, straight, bulk, failure: NEVER };
        let keeping = Tissue {
            failure: physics::materials::tissue::TwoSurface { keeps_pressure: 0xFF, ..NEVER },
            ..failing
        };
        let kinks = [1.0, straight];
        report(&format!("tissue {straight}"), &law, None, &kinks);
        report(&format!("tissue {straight} matrix"), &failing, Some(1.0), &kinks);
        report(&format!("tissue {straight} squeezed"), &keeping, Some(1.0), &[1.0, straight]);
        report(&format!("tissue {straight} fibers"), &failing, Some(2.0), &kinks);
    }
}

/// Counted as unstable is whoever has no wave along the fibers: where n·A(n) n < 0, and nobody who has.
#[test]
fn tissue_that_lost_its_stability_is_counted() {
    let mut random = Random(52);
    for law in tissues() {
        let mut found = [0, 0];
        while found.iter().sum::<usize>() < 400 {
            let (f, fiber) = (random.deformation([0.5, 6.0], 1.8), random.direction());
            let point = Point::virgin(&law, f, fiber);
            let answer = step(&law, &point);
            let n = (f * fiber).normalize();
            let (along, h) = (n.dot(&(acoustic(&law, &point, &n) * n)), 1e-4 * answer.modulus);
            if along.abs() > h {
                let unstable = answer.counted == ["unstable"];
                assert_eq!(unstable, along < 0.0, "{along} of {} at {f}", answer.modulus);
                found[usize::from(unstable)] += 1;
            }
        }
        println!("lambda* {}: {found:?} stable and not", law.straight);
        assert!(found.iter().all(|n| *n > 30), "{found:?}");
    }
}

/// Past yield too, in any direction of loading or unloading.
#[test]
fn plastic_flow_does_not_outrun_the_bound() {
    let law = J2 { elastic: NeoHookean { bulk: 46e9, shear: 5.6e9 }, yield_stress: 18e6, hardening: 50e6 };
    let mut random = Random(61);
    for _ in 0..100 {
        let point = Point::virgin(&law, random.deformation([0.95, 1.05], 1.1), V3::x());
        let answer = step(&law, &point);
        let next = point.then(&answer, M3::identity());
        let truth = maximum(&law, &next, &mut random);
        assert!(answer.modulus >= truth * (1.0 - 1e-6), "{} below {truth}", answer.modulus);
    }
}

/// λ* = 1.4: the slope falls from 20.4 MPa to 100 kPa, the stress there is 929 kPa (PAPER.md).
#[test]
fn the_bound_follows_the_kink() {
    let law = myocardium(1.4, physics::materials::tissue::NoFailure);
    let at = |stretch: f64| {
        let side = stretch.powf(-0.5);
        let f = M3::from_diagonal(&V3::new(stretch, side, side));
        step(&law, &Point::virgin(&law, f, V3::x())).modulus
    };
    let (before, after) = (at(1.4 - 1e-9), at(1.4 + 1e-9));
    assert!(before > 12e6 && before < 14e6, "{before}");
    assert!(after > 0.929e6 && after < 1.1e6, "{after}");
}

#[test]
fn the_bound_is_a_number_in_extreme_states() {
    let mut random = Random(62);
    for _ in 0..2000 {
        let (f, fiber) = (random.deformation([1e-9, 1e9], 1e3), random.direction());
        for code in [0.0, 1.0, 2.0, 3.0] {
            let law = myocardium(1.4, NEVER);
            let mut point = Point::virgin(&law, f, fiber);
            point.history[3] = code;
            let answer = step(&law, &point);
            assert!(answer.modulus.is_finite() && answer.modulus >= 0.0, "{code}: {}", answer.modulus);
            assert!(answer.kirchhoff.iter().all(|t| t.is_finite()));
        }
    }
}
