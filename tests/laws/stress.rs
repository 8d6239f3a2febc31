//! Stress and energy belong together, and do not depend on the observer.
use crate::harness::*;
use physics::law::Law;
use physics::materials::j2::J2;
use physics::materials::tissue::NoFailure;
use simd::Isa;

/// τ m·n = dW/dε along F → (I + ε m⊗n) F, by differences of fourth order.
fn stress_from_energy<L: Law>(law: &L, f: &M3, fiber: V3, history: Option<&[f64]>) -> M3 {
    let h = 2e-4;
    let energy = |row: usize, column: usize, epsilon: f64| {
        let mut map = M3::identity();
        map[(row, column)] += epsilon;
        let mut point = Point::virgin(law, map * f, fiber);
        if let Some(history) = history {
            point.history = history.to_vec();
        }
        step(law, &point).strain
    };
    M3::from_fn(|i, k| {
        let slope = |h: f64| (energy(i, k, h) - energy(i, k, -h)) / (2.0 * h);
        (4.0 * slope(h) - slope(2.0 * h)) / 3.0
    })
}

fn stress_is_the_energy_s_slope<L: Law>(law: &L, seed: u64, history: Option<f64>) {
    let mut random = Random(seed);
    for _ in 0..300 {
        let (f, fiber) = (random.deformation([0.3, 2.0], 1.7), random.direction());
        let mut point = Point::virgin(law, f, fiber);
        if let Some(code) = history {
            point.history[3] = code;
        }
        let answer = step(law, &point);
        // a kink within reach of the differences is no place to compare
        let stretch = (f * fiber).norm() / f.determinant().cbrt();
        if [1.0, 1.06, 1.3, 1.4].iter().any(|kink| (stretch - kink).abs() < 2e-3) {
            continue;
        }
        let expected = stress_from_energy(law, &f, fiber, history.map(|_| &*point.history));
        let error = (answer.kirchhoff - expected).norm();
        assert!(error <= 1e-6 * expected.norm(), "{error} of {expected} at {f}, stretch {stretch}");
    }
}

#[test]
fn stress_is_the_slope_of_the_energy() {
    stress_is_the_energy_s_slope(&RUBBER, 1, None);
    stress_is_the_energy_s_slope(&J2 { elastic: RUBBER, yield_stress: 1e12, hardening: 0.0 }, 2, None);
    for (seed, law) in tissues().iter().enumerate() {
        stress_is_the_energy_s_slope(law, 3 + seed as u64, None);
    }
    for code in [0.0, 1.0, 2.0] {
        stress_is_the_energy_s_slope(&myocardium(1.3, NEVER), 7, Some(code));
    }
}

fn objective<L: Law>(law: &L, seed: u64) {
    let mut random = Random(seed);
    for _ in 0..500 {
        let (f, fiber, q) = (random.deformation([0.3, 2.0], 1.7), random.direction(), random.rotation());
        let (plain, turned) = (Point::virgin(law, f, fiber), Point::virgin(law, q * f, fiber));
        let (a, b) = (step(law, &plain), step(law, &turned));
        let scale = a.kirchhoff.norm() + a.modulus;
        close((q * a.kirchhoff * q.transpose() - b.kirchhoff).norm(), 0.0, 1e-12, scale);
        close(a.modulus, b.modulus, 1e-12, scale);
        close(a.strain, b.strain, 1e-12, scale);
        // a rotation as a step of its own
        let c = step(law, &plain.then(&a, q));
        close((c.kirchhoff - b.kirchhoff).norm(), 0.0, 1e-12, scale);
    }
}

#[test]
fn rotations_turn_the_stress_and_nothing_else() {
    objective(&RUBBER, 21);
    objective(&J2 { elastic: RUBBER, yield_stress: 3e3, hardening: 1e3 }, 22);
    tissues().iter().for_each(|law| objective(law, 23));
}

#[test]
fn instruction_sets_agree() {
    let mut random = Random(31);
    let law = myocardium(1.3, PAPER);
    let points: Vec<_> = (0..1003)
        .map(|_| Point::virgin(&law, random.deformation([0.5, 1.5], 1.3), random.direction()))
        .collect();
    let baseline = run(Isa::BASELINE, &law, &points);
    for isa in instruction_sets() {
        for (a, b) in run(isa, &law, &points).iter().zip(&baseline) {
            let scale = a.kirchhoff.norm() + a.modulus;
            close((a.kirchhoff - b.kirchhoff).norm(), 0.0, 1e-12, scale);
            assert_eq!(a.history[3], b.history[3]);
        }
    }
}

#[test]
fn small_strains_show_the_moduli() {
    fn check<L: Law>(law: &L) {
        let (bulk, shear) = law.moduli();
        let e = 1e-6;
        // fibers are slack in compression
        let squeeze = step(law, &Point::virgin(law, M3::identity() * (1.0 - e), V3::x()));
        close(squeeze.kirchhoff.trace() / 3.0, -3.0 * bulk * e, 1e-5, bulk * e);
        let mut slide = M3::identity();
        slide[(1, 2)] = e;
        let slide = step(law, &Point::virgin(law, slide, V3::x()));
        close(slide.kirchhoff[(1, 2)], shear * e, 1e-5, shear * e);
        let rest = step(law, &Point::virgin(law, M3::identity(), V3::x()));
        close(rest.modulus, bulk + 4.0 / 3.0 * shear, 1e-12, bulk);
        assert_eq!((rest.kirchhoff.norm(), rest.strain), (0.0, 0.0));
    }
    check(&RUBBER);
    check(&J2 { elastic: RUBBER, yield_stress: 1e3, hardening: 0.0 });
    tissues().iter().for_each(check);
}

/// The fiber stress of eq. 5 as corrected, at λ̃ = λ: stretch along x with J = 1.
#[test]
fn fiber_stress_follows_eq_5() {
    for law in [myocardium(1.3, NoFailure), ligament(NoFailure)] {
        let at_star = law.c3 * ((law.c4 * (law.straight - 1.0)).exp() - 1.0);
        for i in 0..200 {
            let stretch = 0.8 + 0.005 * i as f64;
            let side = stretch.powf(-0.5);
            let f = M3::from_diagonal(&V3::new(stretch, side, side));
            let expected = match stretch {
                s if s < 1.0 => 0.0,
                s if s <= law.straight => law.c3 * ((law.c4 * (s - 1.0)).exp() - 1.0),
                s => law.c5 * s + at_star - law.c5 * law.straight,
            };
            let t = step(&law, &Point::virgin(&law, f, V3::x())).kirchhoff;
            let matrix = 2.0 * law.c1 * (stretch * stretch - side * side);
            close(t[(0, 0)] - t[(1, 1)], matrix + expected, 1e-10, matrix.abs() + expected);
        }
    }
}

/// The toe's energy ∫ h(x)/x dx against Simpson's rule, up to the C₄ (λ* − 1) = 20 that the law promises.
#[test]
fn toe_energy_is_the_integral_of_the_toe() {
    for (c4, straight) in [(22.0, 1.4), (48.0, 1.06), (50.0, 1.4)] {
        let law = physics::materials::tissue::Tissue { c4, ..myocardium(straight, NoFailure) };
        let side = straight.powf(-0.5);
        let f = M3::from_diagonal(&V3::new(straight, side, side));
        let matrix = law.c1 * (straight * straight + 2.0 * side * side - 3.0);
        let n = 20_000;
        let width = (straight - 1.0) / n as f64;
        let at = |i: usize| {
            let strain = width * i as f64;
            let weight = if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
            weight * law.c3 * (c4 * strain).exp_m1() / (1.0 + strain)
        };
        let exact = (0..=n).map(at).sum::<f64>() * width / 3.0;
        let strain = step(&law, &Point::virgin(&law, f, V3::x())).strain;
        close(strain - matrix, exact, 2e-12, exact + matrix);
    }
}
