//! J2 plasticity against closed forms.
use crate::harness::*;
use physics::materials::j2::J2;
use physics::materials::neo_hookean::NeoHookean;

const ELASTIC: NeoHookean = NeoHookean { bulk: 46e9, shear: 5.6e9 };
const LEAD: J2 = J2 { elastic: ELASTIC, yield_stress: 18e6, hardening: 0.0 };
const HARDENING: J2 = J2 { hardening: 400e6, ..LEAD };

fn deviator(t: &M3) -> M3 {
    t - M3::identity() * (t.trace() / 3.0)
}

/// √(2/3) (σ₀ + H α)
fn radius(law: &J2, alpha: f64) -> f64 {
    (2.0_f64 / 3.0).sqrt() * (law.yield_stress + law.hardening * alpha)
}

#[test]
fn below_yield_it_is_neo_hookean() {
    let mut random = Random(71);
    let law = J2 { yield_stress: 1e15, ..LEAD };
    for _ in 0..200 {
        let (first, second) = (random.deformation([0.7, 1.3], 1.3), random.deformation([0.9, 1.1], 1.1));
        let point = Point::virgin(&law, first, V3::x());
        let next = point.then(&step(&law, &point), second);
        let metal = step(&law, &next);
        let elastic = step(&ELASTIC, &Point::virgin(&ELASTIC, next.f, V3::x()));
        close((metal.kirchhoff - elastic.kirchhoff).norm(), 0.0, 1e-13, elastic.modulus);
        close(metal.modulus, elastic.modulus, 1e-13, elastic.modulus);
        close(metal.strain, elastic.strain, 1e-13, elastic.modulus);
        assert_eq!((metal.history[6], metal.plastic), (0.0, 0.0));
    }
}

/// Box 9.1 of Simo & Hughes, in plain matrices, for one step from the undeformed state.
#[test]
fn the_return_is_radial() {
    let mut random = Random(72);
    for law in [LEAD, HARDENING] {
        for _ in 0..500 {
            let f = random.deformation([0.9, 1.1], 1.2);
            let answer = step(&law, &Point::virgin(&law, f, V3::x()));
            let b = f * f.transpose() * f.determinant().powf(-2.0 / 3.0);
            let trial = deviator(&b) * ELASTIC.shear;
            let effective = ELASTIC.shear * b.trace() / 3.0;
            let excess = (trial.norm() - radius(&law, 0.0)).max(0.0);
            let flow = excess / (2.0 * effective) / (1.0 + law.hardening / (3.0 * effective));
            let expected = trial * (1.0 - 2.0 * effective * flow / trial.norm());
            let s = deviator(&answer.kirchhoff);
            // the pressure, removed here, is far above the deviator
            let scale = answer.kirchhoff.norm() + trial.norm();
            close((s - expected).norm(), 0.0, 1e-13, scale);
            let alpha = answer.history[6];
            close(alpha, (2.0_f64 / 3.0).sqrt() * flow, 1e-12, 1e-3);
            if excess > 0.0 {
                close(s.norm(), radius(&law, alpha), 1e-13, scale);
            }
            let [xx, xy, xz, yy, yz, zz] = std::array::from_fn(|i| answer.history[i]);
            close(M3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).determinant(), 1.0, 1e-14, 1.0);
        }
    }
}

/// Uniaxial strain in small steps: elastic slope K + 4/3 μ, then K, and σ₁ − σ₂ = σy.
#[test]
fn uniaxial_strain_yields_where_it_should() {
    let stretch = M3::from_diagonal(&V3::new(1.0 + 1e-5, 1.0, 1.0));
    let mut point = Point::virgin(&LEAD, stretch, V3::x());
    let mut answer = step(&LEAD, &point);
    let mut stresses = vec![answer.kirchhoff];
    for _ in 1..400 {
        point = point.then(&answer, stretch);
        answer = step(&LEAD, &point);
        stresses.push(answer.kirchhoff);
    }
    let slope = |i: usize| (stresses[i + 1][(0, 0)] - stresses[i][(0, 0)]) / 1e-5;
    close(slope(10), ELASTIC.bulk + 4.0 / 3.0 * ELASTIC.shear, 5e-3, ELASTIC.bulk);
    close(slope(398), ELASTIC.bulk, 1e-2, ELASTIC.bulk);
    // yield strain σy / 2μ = 1.607e-3
    let yields = |t: &M3| t[(0, 0)] - t[(1, 1)] > LEAD.yield_stress * (1.0 - 1e-9);
    let first = stresses.iter().position(yields).unwrap();
    assert!((160..=163).contains(&first), "{first}");
    let last = &stresses[399];
    close(last[(0, 0)] - last[(1, 1)], LEAD.yield_stress, 1e-9, LEAD.yield_stress);
}

/// Simple shear to γ = 2: the plateau σ₀/√3, and the work is stored or spent.
#[test]
fn shear_reaches_a_plateau_and_the_books_balance() {
    for law in [LEAD, HARDENING] {
        let steps = 20_000;
        let mut increment = M3::identity();
        increment[(0, 1)] = 2.0 / steps as f64;
        let mut point = Point::virgin(&law, increment, V3::x());
        let mut answer = step(&law, &point);
        let mut work = 0.5 * answer.kirchhoff[(0, 1)] * increment[(0, 1)];
        for _ in 1..steps {
            let before = answer.kirchhoff[(0, 1)];
            point = point.then(&answer, increment);
            answer = step(&law, &point);
            work += 0.5 * (before + answer.kirchhoff[(0, 1)]) * increment[(0, 1)];
        }
        let alpha = answer.history[6];
        let strength = law.yield_stress + law.hardening * alpha;
        let elastic = answer.kirchhoff[(0, 1)] / ELASTIC.shear;
        close(alpha, (2.0 - elastic) / 3.0_f64.sqrt(), 2e-3, 1.0);
        close(deviator(&answer.kirchhoff).norm(), radius(&law, alpha), 1e-12, strength);
        close(answer.kirchhoff[(0, 1)], strength / 3.0_f64.sqrt(), 1e-2, strength);
        close(answer.strain + answer.plastic, work, 1e-3, work);
        println!("shear: booked {:e} of work {work:e}", answer.strain + answer.plastic);
    }
}

/// A pull far past yield and the way back: elastic unloading leaves the deviator inside the surface.
#[test]
fn unloading_is_elastic() {
    let stretch = V3::new(1.01, 0.995, 0.995);
    let pull = M3::from_diagonal(&stretch);
    let point = Point::virgin(&HARDENING, pull, V3::x());
    let loaded = step(&HARDENING, &point);
    let back = point.then(&loaded, M3::from_diagonal(&V3::new(0.999, 1.0005, 1.0005)));
    let unloaded = step(&HARDENING, &back);
    assert_eq!(unloaded.history[6], loaded.history[6]);
    let relief = loaded.kirchhoff[(0, 0)]
        - loaded.kirchhoff[(1, 1)]
        - (unloaded.kirchhoff[(0, 0)] - unloaded.kirchhoff[(1, 1)]);
    close(relief, 2.0 * ELASTIC.shear * 1.5e-3, 1e-2, relief);
}
