//! Young's modulus and Poisson's ratio in place of bulk and shear modulus; patches in all in place of those along the axes.

use crate::common::{Overrides, scene, start};
use physics::materials::AnyLaw;
use scene::{Behavior, Patches};
use sinew::input::read_text;

const BAR: &str = r#"
[domain]
lower = [0, 0, 0]
upper = ["16 mm", "16 mm", "16 mm"]
cell = "1 mm"
[material.steel]
law = "neo-hookean"
density = 7850
young-modulus = "210 GPa"
poisson-ratio = 0.3
[[body]]
name = "bar"
material = "steel"
shape = { box = { lower = [0, 0, 0], upper = ["16 mm", "2 mm", "2 mm"] } }
[run]
until = "1 us"
steps = 2
"#;

const PAIR: Overrides<'_> = &[
    ("material.steel.young-modulus", ""),
    ("material.steel.poisson-ratio", ""),
    ("material.steel.bulk-modulus", "175 GPa"),
    ("material.steel.shear-modulus", "80769230769.23077"),
];

#[test]
fn e_and_nu_are_k_and_mu() {
    let moduli = |overrides: Overrides<'_>| match scene(BAR, overrides).materials[0].behavior {
        Behavior::Deformable(AnyLaw::NeoHookean(law)) => [law.bulk, law.shear],
        ref other => panic!("{other:?}"),
    };
    let (found, expected) = (moduli(&[]), moduli(PAIR));
    for (x, y) in found.iter().zip(expected) {
        assert!((x / y - 1.0).abs() < 1e-15, "{found:?} {expected:?}");
    }
    // a restart reads what was resolved
    let resolved = scene(BAR, &[]).resolved;
    assert!(resolved.contains("bulk-modulus") && !resolved.contains("young"), "{resolved}");
    assert_eq!(read_text("again", &resolved, &[], None).expect("it is a scene").resolved, resolved);
    // stretched by ε along x alone it stores ½ (K + 4/3 μ) ε² in each volume
    let stretched = scene(BAR, &[("body.bar.stretch", "[1.001, 1, 1]")]);
    let report = start(stretched).report().expect("one rank");
    let wave: f64 = 210e9 * 0.7 / (1.3 * 0.4);
    let density = report.energy().strain / (2.0 * 2.0 * 16.0 * 1e-9);
    assert!((density / (0.5 * wave * 1e-6) - 1.0).abs() < 5e-3, "{density}");
}

#[test]
fn what_does_not_go_together_is_told() {
    let tissue: Overrides<'_> = &[
        ("material.steel.law", "tissue"),
        ("material.steel.c1", "2 kPa"),
        ("material.steel.c3", "1 kPa"),
        ("material.steel.c4", "10"),
        ("material.steel.c5", "10 kPa"),
        ("material.steel.lambda-star", "1.4"),
        ("material.steel.bulk-modulus", "1 MPa"),
    ];
    let wrong: [(Overrides<'_>, &str); 6] = [
        (
            &[("material.steel.poisson-ratio", "")],
            "`material.steel.poisson-ratio` is missing: it goes with `young-modulus`",
        ),
        (&[("material.steel.young-modulus", "")], "`material.steel.young-modulus` is missing"),
        (&[("material.steel.bulk-modulus", "1 GPa")], "`material.steel.bulk-modulus` is given beside"),
        (
            &[("material.steel.poisson-ratio", "0.5")],
            "`material.steel.poisson-ratio` is 0.5, but must be above -1 and at most 0.4999999",
        ),
        (&[("material.steel.young-modulus", "2 mm")], "material.steel.young-modulus"),
        (tissue, "the law \"tissue\" has no `young-modulus`"),
    ];
    for (overrides, expected) in wrong {
        let overrides: Vec<_> =
            overrides.iter().map(|&(key, value)| (key.to_owned(), value.to_owned())).collect();
        let error = read_text("test", BAR, &overrides, None).expect_err(expected);
        let words = format!("{:?}", miette::Report::new(error)).replace('│', " ");
        let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains(expected), "{expected}: {words}");
        assert!(
            !words.contains("shear-modulus` is missing") && !words.contains("unknown key"),
            "one fault: {words}"
        );
    }
}

#[test]
fn patches_in_all_are_cut_where_the_particles_are() {
    assert_eq!(scene(BAR, &[("run.patches", "4")]).run.patches, Some(Patches::Total(4)));
    assert_eq!(scene(BAR, &[("run.patches", "[4, 1, 2]")]).run.patches, Some(Patches::Grid([4, 1, 2])));
    let counts = start(scene(BAR, &[("run.patches", "4")])).warehouse.decomposition.counts;
    assert_eq!(counts.iter().product::<usize>(), 4);
    assert_eq!(counts[0], 4, "the bar lies along x");
}
