//! Whole steps of Sinew, on every instruction set, against the method as a textbook writes it (`step.rs`, `laws.rs`). The two
//! share no arithmetic: plain loops over particles and nodes here, eigenvalues, functions of the standard library.
#[path = "../common/mod.rs"]
mod common;
mod compare;
mod laws;
mod scenes;
mod step;

use common::{Random, instruction_sets};
use compare::{Errors, compare};
use engine::schema::Label;
use laws::{Law, Tissue};
use scenes::{Case, each, particles, start};
use simd::Isa;
use step::{M3, Model, Particle, V3};
use tasks::labels::{Deformation, Identity, InitialVolume, Mass, Position, Velocity};

/// Most that Sinew may differ after a step, see [`Errors`].
const TOLERANCE: f64 = 1e-12;

/// Of x/h where the balls are: 2⁻⁵³ of at most 16.
const ROUNDING: f64 = 1e-15;

/// Particles that are in another cube of so many cells than before.
fn moved(model: &Model, cells: f64, before: &[Particle], after: &[Particle]) -> usize {
    let cube = |p: &Particle| ((p.x - model.lower) / (model.h * cells)).map(f64::floor);
    before.iter().zip(after).filter(|(a, b)| cube(a) != cube(b)).count()
}

/// Runs a case on all instruction sets and compares after every step; `claim` looks at the particles at the end.
///
/// With GIMP the errors are rounding, summed over the steps. Those of τ and of α are larger than the others: J and b̄ᵉ are rounded
/// at 1, whereas τ/K and α are some hundredths. With hats, a particle alone at a node where its weight is S gives the node the
/// acceleration f/m ~ 1/S with the error ε/S², ε being the rounding of x/h: that is not small for a small S. There the reference
/// is asked how well it knows its own result: Sinew may be ten times as far from it as a twin whose particles are moved by ε in
/// each step.
fn check(case: &Case, claim: impl Fn(&[Particle])) {
    for isa in instruction_sets() {
        let (mut simulation, model) = start(case, isa);
        let before = particles(&simulation);
        let (mut reference, mut twin) = (before.clone(), before.clone());
        let (mut errors, mut own, mut random) = (Errors::default(), Errors::default(), Random(5));
        for n in 1..=case.steps {
            let went_on =
                simulation.step().unwrap_or_else(|e| panic!("{}, {isa:?}, step {n}: {e}", case.name));
            assert!(went_on);
            let dt = simulation.clock().tick;
            step::step(&model, &mut reference, dt);
            errors = errors.and(compare(model.h, &particles(&simulation), &reference));
            if !model.gimp {
                twin.iter_mut().for_each(|p| p.x += ROUNDING * model.h * V3::from(random.vector()));
                step::step(&model, &mut twin, dt);
                own = own.and(compare(model.h, &twin, &reference));
            }
        }
        let [cell, block] = [1.0, 4.0].map(|cells| moved(&model, cells, &before, &reference));
        println!("{} on {isa:?}, {} steps, {} particles:", case.name, case.steps, before.len());
        println!("  {cell} have left their cell, {block} their block");
        println!("  {errors}");
        if !model.gimp {
            println!("  {own}, the reference from its twin");
        }
        claim(&reference);
        assert!(cell > before.len() / 2 && block > before.len() / 10);
        let tolerance = TOLERANCE.max(10.0 * own.worst());
        assert!(errors.worst() <= tolerance && errors.codes == 0, "{}, {isa:?}: {errors}", case.name);
    }
}

const RUBBER: Case = Case {
    name: "neo-hookean",
    laws: [Law::NeoHookean { bulk: 1.1e5, shear: 4.7e4 }, Law::NeoHookean { bulk: 3.7e5, shear: 0.9e5 }],
    densities: [1030.0, 1210.0],
    steps: 20,
    speeds: [9.0, -7.0],
    rate: 4.0,
    noise: 3.0,
    jitter: 0.2,
    overrides: &[],
};

#[test]
fn rubber() {
    check(&RUBBER, |after| {
        let strained = after.iter().filter(|p| (p.f - M3::identity()).norm() > 0.05).count();
        println!("  {strained} strained by more than 5 %");
        assert!(strained > after.len() / 2);
    });
}

/// Calmer and shorter: with hats, a particle that barely touches a node is torn by it (README.md), and turned inside out soon.
#[test]
fn rubber_with_hats() {
    let overrides = &[("run.shape", "linear"), ("run.cfl", "0.3")];
    check(&Case { name: "neo-hookean, hats", steps: 8, noise: 0.5, overrides, ..RUBBER }, |_| ());
}

/// Gravity, damping, a share of PIC, the quadratic artificial viscosity, and faces close to the balls.
#[test]
fn rubber_with_loads_and_faces() {
    let overrides = &[
        ("load.gravity", "[-60, 90, 70]"),
        ("load.damping", "7"),
        ("run.pic", "0.13"),
        ("run.viscosity.linear", "0"),
        ("run.viscosity.quadratic", "1.7"),
        ("domain.lower.0", "-0.88"),
        ("domain.upper", "[4.3, 5.38, -0.12]"),
        ("boundary.x-min", "fixed"),
        ("boundary.x-max", "symmetric"),
        ("boundary.y-max", "fixed"),
        ("boundary.z-max", "symmetric"),
    ];
    let case = Case { name: "neo-hookean, loads and faces", speeds: [0.0; 2], overrides, ..RUBBER };
    check(&case, |after| {
        let beside = |axis: usize, face: f64| after.iter().any(|p| (p.x[axis] - face).abs() < 0.37);
        assert!(beside(0, -0.88) && beside(0, 4.3) && beside(1, 5.38) && beside(2, -0.12));
    });
}

#[test]
fn metal() {
    let soft = Law::J2 { bulk: 46e9, shear: 5.6e9, yield_stress: 180e6, hardening: 400e6 };
    let perfect = Law::J2 { bulk: 61e9, shear: 9.1e9, yield_stress: 1200e6, hardening: 0.0 };
    let case = Case {
        name: "j2",
        laws: [soft, perfect],
        densities: [11340.0, 8900.0],
        steps: 20,
        speeds: [1900.0, -1400.0],
        rate: 100.0,
        noise: 100.0,
        jitter: 0.2,
        overrides: &[],
    };
    check(&case, |after| {
        let yielded = after.iter().filter(|p| p.history[6] > 1e-3).count();
        println!("  {yielded} have yielded");
        assert!(yielded > after.len() / 4 && yielded < after.len());
    });
}

const MUSCLE: Tissue = Tissue {
    c1: 2.1e3,
    c3: 140.0,
    c4: 22.0,
    c5: 1e5,
    straight: 1.12,
    bulk: 1e5,
    fiber_limit: 0.4,
    matrix_limit: 0.25,
};

const LIGAMENT: Tissue = Tissue {
    c1: 1.44e3,
    c3: 570.0,
    c4: 48.0,
    c5: 467e3,
    straight: 1.06,
    bulk: 3e5,
    fiber_limit: 0.04,
    matrix_limit: 0.4,
};

#[test]
fn tissue() {
    let case = Case {
        name: "tissue",
        laws: [Law::Tissue(MUSCLE), Law::Tissue(LIGAMENT)],
        densities: [1060.0, 1110.0],
        steps: 20,
        speeds: [14.0, -12.0],
        rate: 9.0,
        noise: 6.0,
        jitter: 0.2,
        overrides: &[],
    };
    check(&case, |after| {
        let failed = [1.0, 2.0, 3.0].map(|code| after.iter().filter(|p| p.history[3] == code).count());
        println!("  failed: matrix {}, fibers {}, both {}", failed[0], failed[1], failed[2]);
        assert!(failed.into_iter().all(|n| n > 100));
        // slack, uncrimping and straight fibers that have not failed
        let mut fibers = [0; 3];
        for p in after.iter().filter(|p| p.history[3] <= 1.0) {
            let stretch = (p.f * V3::from_row_slice(&p.history[..3])).norm() / p.f.determinant().cbrt();
            let straight = [MUSCLE, LIGAMENT][p.material].straight;
            fibers[usize::from(stretch >= 1.0) + usize::from(stretch > straight)] += 1;
        }
        println!("  fibers left: slack {}, uncrimping {}, straight {}", fibers[0], fibers[1], fibers[2]);
        assert!(fibers.into_iter().all(|n| n > 50));
    });
}

#[test]
fn the_reference_conserves_momentum() {
    let (simulation, model) = start(&RUBBER, Isa::detect());
    let before = particles(&simulation);
    let mut after = before.clone();
    (0..20).for_each(|_| step::step(&model, &mut after, 2e-3));
    let momentum = |all: &[Particle]| all.iter().map(|p| p.mass * p.v).sum::<V3>();
    let size = before.iter().map(|p| p.mass * p.v.norm()).sum::<f64>();
    let drift = (momentum(&after) - momentum(&before)).norm() / size;
    println!("momentum of the reference drifts by {drift:.1e} in 20 steps");
    assert!(drift < 1e-14);
    let speed = after.iter().zip(&before).map(|(a, b)| (a.v - b.v).norm()).fold(0.0, f64::max);
    assert!(speed > 1.0); // there was something to conserve
}

/// One number of one particle, off by 1e-9 of itself, is enough to be seen after a step.
#[test]
fn the_comparison_notices() {
    for label in [Velocity::ID, Position::ID, Mass::ID, InitialVolume::ID, Deformation::ID] {
        let (mut simulation, model) = start(&RUBBER, Isa::detect());
        // so that there is stress
        assert!(simulation.step().is_ok());
        let mut reference = particles(&simulation);
        each(&mut simulation, |_, layout, block, p| {
            if block.get(layout, Identity::ID, p, 0).to_bits() == 500 {
                block.set(layout, label, p, 0, block.get(layout, label, p, 0) * (1.0 + 1e-9));
            }
        });
        assert!(simulation.step().is_ok());
        step::step(&model, &mut reference, simulation.clock().tick);
        let errors = compare(model.h, &particles(&simulation), &reference);
        println!("{label:?} off by 1e-9: {errors}");
        assert!(errors.worst() > TOLERANCE);
    }
}
