//! Contact laws at one node: Coulomb, bonds, and what Newton's method asks of them.
mod common;

use common::{Random, norm};
use physics::contact::bonded::Bonded;
use physics::contact::friction::{Criterion, Friction};
use physics::contact::{AnyContactLaw, ContactLaw, Pair, dot};
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
