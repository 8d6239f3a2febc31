//! How bodies begin: stretched, turning; and how what particles do not share with nodes fades.

use crate::common;
use crate::common::rubber::{MIRRORS, RUBBER};
use crate::common::{Overrides, finish, numbers, scene, set_velocity, start};
use engine::schema::Label;
use tasks::labels;

/// W = μ/2 (λ^(4/3) + 2 λ^(−2/3) − 3) + K/2 (½ (λ² − 1) − ln λ) and its slope.
fn closed_form(l: f64) -> (f64, f64) {
    let (bulk, shear) = (1e6, 0.5e6);
    let energy = 0.5 * shear * (l.powf(4.0 / 3.0) + 2.0 * l.powf(-2.0 / 3.0) - 3.0)
        + 0.5 * bulk * (0.5 * (l * l - 1.0) - l.ln());
    let slope =
        0.5 * shear * (4.0 / 3.0) * (l.powf(1.0 / 3.0) - l.powf(-5.0 / 3.0)) + 0.5 * bulk * (l - 1.0 / l);
    (energy, slope)
}

#[test]
fn a_body_that_begins_stretched_bears_the_stress_of_its_stretch() {
    let metal: Overrides<'_> = &[("material.rubber.law", "j2"), ("material.rubber.yield-stress", "1 GPa")];
    for law in [&[][..], metal] {
        let stretched = [MIRRORS, &[("body.block.stretch", "[1.2, 1, 1]")], law].concat();
        let mut simulation = start(scene(RUBBER, &stretched));
        let before = simulation.report().expect("one rank");
        let (energy, slope) = closed_form(1.2);
        let volume = 12e-3 * 16e-6 / 1.2;
        assert!((before.materials[0].mass / (1e3 * volume) - 1.0).abs() < 1e-12);
        assert!((before.energy().strain / (energy * volume) - 1.0).abs() < 1e-12);
        let after = finish(&mut simulation).expect("runs");
        assert!((after.energy().strain / before.energy().strain - 1.0).abs() < 1e-9, "it is in balance");
        for (tau, f) in numbers(&simulation, labels::KirchhoffStress::ID)
            .iter()
            .zip(numbers(&simulation, labels::Deformation::ID))
        {
            assert!((tau[0] / f[0] / slope - 1.0).abs() < 1e-9);
        }
        // and the mirrors hold it
        let force = common::giver(&after, "face.x-min").force[0];
        assert!((force / (-slope * 16e-6) - 1.0).abs() < 1e-9, "{force}");
    }
}

#[test]
fn a_body_that_begins_turning_has_its_angular_momentum() {
    let spin: Overrides<'_> = &[
        ("domain.lower", "[-0.02, -0.02, -0.02]"),
        ("domain.upper", "[0.02, 0.02, 0.02]"),
        ("body.block.angular-velocity", "[0, 0, 30]"),
        ("body.block.velocity", "[0, 0.1, 0]"),
    ];
    let report = start(scene(RUBBER, spin)).report().expect("one rank");
    let m = &report.materials[0];
    // particles are points, 24 and 8 of them along the edges
    let inertia =
        m.mass / 12.0 * (12e-3f64.powi(2) * (1.0 - 1.0 / 576.0) + 4e-3f64.powi(2) * (1.0 - 1.0 / 64.0));
    let exact = 30.0 * inertia + m.mass * 6e-3 * 0.1;
    assert!((m.angular_momentum[2] / exact - 1.0).abs() < 1e-12);
    assert!((m.velocity()[1] - 0.1).abs() < 1e-12);
}

/// Neighbors that move against one another: nodes between them rest, and what they do not share decays at the rate.
#[test]
fn a_rate_of_pic_does_not_depend_on_the_step() {
    for cfl in ["0.4", "0.1"] {
        let rate: Overrides<'_> = &[
            ("run.shape", "linear"),
            ("run.pic-rate", "1e4"),
            ("run.cfl", cfl),
            ("run.until", "0.1 ms"),
            ("material.rubber.bulk-modulus", "1e6"),
        ];
        let mut simulation = start(scene(RUBBER, rate));
        let sign = |x: f64| if (x / 0.5e-3) as i64 % 2 == 0 { 1e-9 } else { -1e-9 };
        set_velocity(&mut simulation, |x| [0.0, sign(x[0]), 0.0]);
        finish(&mut simulation).expect("runs");
        let (x, v) = (numbers(&simulation, labels::Position::ID), numbers(&simulation, labels::Velocity::ID));
        let inner =
            x.iter().zip(&v).filter(|(x, _)| (x[0] - 6e-3).abs() < 0.6e-3 && (x[1] - 2e-3).abs() < 0.6e-3);
        for (x, v) in inner {
            let part = v[1] / sign(x[0]) / f64::exp(-1.0);
            assert!((part - 1.0).abs() < 1e-3, "CFL {cfl}: {part}");
        }
    }
}
