//! Contact laws at one node: Coulomb, bonds, and what Newton's method asks of them.

use crate::common::{Random, norm};
use physics::contact::bonded::Bonded;
use physics::contact::friction::{Criterion, Friction};
use physics::contact::{AnyContactLaw, ContactLaw, Exchange, HeldPair, Pair, dot};
use std::array::from_fn;

const CRITERIA: [Criterion; 3] =
    [Criterion::Approach, Criterion::ApproachOrCompression, Criterion::ApproachAndCompression];

fn pair(random: &mut Random) -> Pair {
    let n = random.vector();
    Pair {
        relative: random.vector(),
        reduced_mass: 10f64.powf(6.0 * random.sign()),
        normal: n.map(|x| x / norm(n)),
        traction: random.sign(),
    }
}

/// Relative velocity after an exchange.
fn after(pair: &Pair, exchange: &physics::contact::Exchange) -> [f64; 3] {
    from_fn(|a| pair.relative[a] + (exchange.normal[a] + exchange.friction[a]) / pair.reduced_mass)
}

#[test]
fn bonded_materials_move_as_one() {
    let mut random = Random(1);
    for _ in 0..1000 {
        let pair = pair(&mut random);
        assert!(norm(after(&pair, &Bonded::FOREVER.exchange(&pair))) < 1e-15);
    }
}

/// The motion of free rigid bodies is found by Newton's method: −∂P/∂u against central differences.
#[test]
fn the_stiffness_of_a_contact_law_is_its_derivative() {
    let mut random = Random(3);
    for round in 0..3000 {
        let mut pair = pair(&mut random);
        pair.reduced_mass = 0.5 + random.unit();
        let law = match CRITERIA.get(round % 4) {
            Some(&criterion) => AnyContactLaw::from(Friction { coefficient: 1.5 * random.unit(), criterion }),
            None => Bonded::FOREVER.into(),
        };
        let impulse = |u: [f64; 3]| {
            let exchange = law.exchange(&Pair { relative: u, ..pair });
            from_fn::<f64, 3, _>(|a| exchange.normal[a] + exchange.friction[a])
        };
        let (stiffness, d) = (law.stiffness(&pair), 1e-6);
        for j in 0..3 {
            let moved = |by: f64| from_fn(|a| pair.relative[a] + if a == j { by } else { 0.0 });
            let [ahead, behind] = [impulse(moved(d)), impulse(moved(-d))];
            for i in 0..3 {
                let found = -(ahead[i] - behind[i]) / (2.0 * d);
                // where it jumps (few of these pairs do), any value between serves
                assert!(
                    (stiffness[i][j] - found).abs() < 1e-4,
                    "{law:?} {pair:?}: {found} {}",
                    stiffness[i][j]
                );
            }
        }
    }
}

/// Where drives hold some axes, the normal and the slip are coupled: approach ends, friction stays in its cone and goes against the slip, and
/// all impulses together take energy.
#[test]
fn what_is_held_is_met_without_a_gain_of_energy() {
    let mut random = Random(5);
    let (mut sticks, mut slides) = (0, 0);
    for round in 0..20_000 {
        let pair = pair(&mut random);
        let mut mobility = [0, 1, 2].map(|_| 0.1 + random.unit());
        (0..3).filter(|a| (round >> a) % 2 == 1).for_each(|a| mobility[a] = 0.0);
        let Pair { relative, normal, .. } = pair;
        let held = HeldPair { relative, mobility, least: 0.01, normal, traction: -1.0 };
        let mu = 1.5 * random.unit();
        let law = Friction { coefficient: mu, criterion: Criterion::Approach };
        let given = law.exchange_held(&held);
        let (p, phi) = (-dot(given.normal, normal), norm(given.friction));
        let after: [f64; 3] = from_fn(|a| relative[a] + mobility[a] * given.all()[a]);
        let mobile = (0..3).map(|a| mobility[a] * normal[a].powi(2)).sum::<f64>();
        if dot(relative, normal) <= 0.0 || mobile <= 0.01 {
            assert_eq!(given, Exchange::default());
            continue;
        }
        let jams = (0..3).map(|a| normal[a] * mobility[a] * -given.friction[a]).sum::<f64>() + p * mobile
            < (1.0 - 1e-9) * dot(relative, normal);
        assert!(jams || dot(after, normal).abs() < 1e-12 * (1.0 + p), "{held:?} {given:?}");
        assert!(p > 0.0 && phi <= mu * p * (1.0 + 1e-12), "{held:?} {given:?}");
        let mean: [f64; 3] = from_fn(|a| 0.5 * (relative[a] + after[a]));
        assert!(jams || dot(given.all(), mean) <= 1e-12, "{held:?} gains {}", dot(given.all(), mean));
        let goes_on = -dot(given.friction, after);
        assert!(jams || goes_on >= -1e-12 * (1.0 + p * p), "friction turns the slip: {held:?} {given:?}");
        if phi > 0.0 && phi < 0.999 * mu * p {
            sticks += 1
        } else {
            slides += 1
        }
        // what moves alike along all axes is met as ever
        let free = HeldPair { mobility: [1.0 / pair.reduced_mass; 3], least: 0.0, ..held };
        let [one, other] = [law.exchange_held(&free), law.exchange(&Pair { traction: -1.0, ..pair })];
        let difference: [f64; 3] = from_fn(|a| one.all()[a] - other.all()[a]);
        assert!(norm(difference) <= 1e-12 * norm(other.all()), "{one:?} {other:?}");
        let bonded = Bonded::FOREVER.exchange_held(&held).all();
        let rest =
            (0..3).map(|a| if mobility[a] > 0.0 { relative[a] + mobility[a] * bonded[a] } else { bonded[a] });
        assert!(rest.into_iter().all(|x| x.abs() < 1e-12), "{held:?} {bonded:?}");
    }
    assert!(sticks > 1000 && slides > 1000, "{sticks} {slides}");
}

#[test]
fn friction_follows_coulomb_and_its_criterion() {
    let mut random = Random(2);
    for criterion in CRITERIA {
        for _ in 0..1000 {
            let (pair, mu) = (pair(&mut random), 2.0 * random.unit());
            let exchange = Friction { coefficient: mu, criterion }.exchange(&pair);
            let (approach, compressed) = (dot(pair.relative, pair.normal), pair.traction < 0.0);
            let acts = match criterion {
                Criterion::Approach => approach > 0.0,
                // contact never pulls
                Criterion::ApproachOrCompression => approach > 0.0,
                Criterion::ApproachAndCompression => approach > 0.0 && compressed,
            };
            if !acts {
                assert_eq!(after(&pair, &exchange), pair.relative);
                continue;
            }
            let (normal, across) = (norm(exchange.normal), norm(exchange.friction));
            assert!(across <= mu * normal * (1.0 + 1e-14), "friction is at most mu times the normal impulse");
            let left = after(&pair, &exchange);
            assert!(dot(left, pair.normal).abs() < 1e-15, "nothing is left along the normal");
            assert!(dot(exchange.friction, pair.normal).abs() < 1e-15 * pair.reduced_mass);
            let sticks = norm(left) < 1e-14;
            assert!(
                sticks || across > mu * normal * (1.0 - 1e-14),
                "what slips is held as far as friction goes"
            );
            let smooth = Friction { coefficient: 0.0, criterion }.exchange(&pair);
            assert_eq!(
                smooth.friction.map(f64::abs),
                [0.0; 3],
                "without friction there is no impulse across"
            );
        }
    }
}
