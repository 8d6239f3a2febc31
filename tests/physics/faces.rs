//! Faces of the domain: models cut by mirrors are the whole models, and what sticks to a face is one body with it.

use crate::common::{Overrides, finish, norm, numbers, scene, set_velocity, start};
use engine::schema::Label;
use sinew::simulation::Simulation;
use std::collections::{HashMap, HashSet};
use tasks::labels;

/// Two halves of one elastic bar that run into each other.
const BAR: &str = r#"
[domain]
lower = LOWER
upper = ["24 mm", "8 mm", "8 mm"]
cell = "1 mm"
[material.rubber]
law = "neo-hookean"
density = 1000
bulk-modulus = "1 MPa"
shear-modulus = "0.5 MPa"
[[body]]
name = "right"
material = "rubber"
particles-per-cell = 2
shape = { intersection = [{ box = { lower = [0, "-3.5 mm", "-2.5 mm"], upper = ["15.5 mm", "3.5 mm", "2.5 mm"] } }, { box = { lower = LOWER, upper = ["24 mm", "8 mm", "8 mm"] } }] }
velocity = ["-1 m/s", 0, 0]
[[body]]
name = "left"
material = "rubber"
particles-per-cell = 2
shape = { intersection = [{ box = { lower = ["-15.5 mm", "-3.5 mm", "-2.5 mm"], upper = [0, "3.5 mm", "2.5 mm"] } }, { box = { lower = LOWER, upper = ["24 mm", "8 mm", "8 mm"] } }] }
velocity = ["1 m/s", 0, 0]
[run]
until = 1
cfl = 0.4
steps = 300
"#;

/// The same of a metal that flows.
const ROD: &[(&str, &str)] = &[
    ("material.rubber.law", "j2"),
    ("material.rubber.yield-stress", "30 kPa"),
    ("material.rubber.hardening", "50 kPa"),
];

/// Two balls of two materials that hit each other and rub, in the planes y = 0 and z = 0.
const BALLS: &str = r#"
[domain]
lower = LOWER
upper = ["24 mm", "8 mm", "8 mm"]
cell = "1 mm"
[material.hard]
law = "neo-hookean"
density = 1200
bulk-modulus = "1 MPa"
shear-modulus = "0.5 MPa"
[material.soft]
law = "neo-hookean"
density = 1000
bulk-modulus = "0.3 MPa"
shear-modulus = "0.1 MPa"
[[body]]
name = "hard"
material = "hard"
particles-per-cell = 2
shape = { intersection = [{ union = [
    { box = { lower = ["-7.5 mm", "-2.5 mm", "-1.5 mm"], upper = ["-0.5 mm", "2.5 mm", "1.5 mm"] } },
    { box = { lower = ["-6.5 mm", "-3.5 mm", "-1.5 mm"], upper = ["-1.5 mm", "3.5 mm", "1.5 mm"] } },
    { box = { lower = ["-7.5 mm", "-1.5 mm", "-2.5 mm"], upper = ["-0.5 mm", "1.5 mm", "2.5 mm"] } },
    { box = { lower = ["-6.5 mm", "-1.5 mm", "-3.5 mm"], upper = ["-1.5 mm", "1.5 mm", "3.5 mm"] } },
    { box = { lower = ["-5.5 mm", "-3.5 mm", "-2.5 mm"], upper = ["-2.5 mm", "3.5 mm", "2.5 mm"] } },
    { box = { lower = ["-5.5 mm", "-2.5 mm", "-3.5 mm"], upper = ["-2.5 mm", "2.5 mm", "3.5 mm"] } },
] }, { box = { lower = LOWER, upper = ["24 mm", "8 mm", "8 mm"] } }] }
velocity = ["1 m/s", 0, 0]
[[body]]
name = "soft"
material = "soft"
particles-per-cell = 2
shape = { intersection = [{ union = [
    { box = { lower = ["0.5 mm", "-2.5 mm", "-1.5 mm"], upper = ["7.5 mm", "2.5 mm", "1.5 mm"] } },
    { box = { lower = ["1.5 mm", "-3.5 mm", "-1.5 mm"], upper = ["6.5 mm", "3.5 mm", "1.5 mm"] } },
    { box = { lower = ["0.5 mm", "-1.5 mm", "-2.5 mm"], upper = ["7.5 mm", "1.5 mm", "2.5 mm"] } },
    { box = { lower = ["1.5 mm", "-1.5 mm", "-3.5 mm"], upper = ["6.5 mm", "1.5 mm", "3.5 mm"] } },
    { box = { lower = ["2.5 mm", "-3.5 mm", "-2.5 mm"], upper = ["5.5 mm", "3.5 mm", "2.5 mm"] } },
    { box = { lower = ["2.5 mm", "-2.5 mm", "-3.5 mm"], upper = ["5.5 mm", "2.5 mm", "3.5 mm"] } },
] }, { box = { lower = LOWER, upper = ["24 mm", "8 mm", "8 mm"] } }] }
velocity = ["-1 m/s", 0, 0]
[[contact]]
between = ["hard", "soft"]
law = "friction"
friction = 0.3
[run]
until = 1
cfl = 0.4
steps = 300
"#;

/// A block that a ball presses and rubs, on a layer that a drive turns about z = 0, under pressure from its sides and a pull.
const HELD: &str = r#"
[domain]
lower = LOWER
upper = ["24 mm", "8 mm", "8 mm"]
cell = "1 mm"
[material.soft]
law = "neo-hookean"
density = 1000
bulk-modulus = "0.3 MPa"
shear-modulus = "0.1 MPa"
[material.ball]
law = "rigid"
motion = "prescribed"
density = 1000
velocity = [-2, 0, 0]
[[body]]
name = "block"
material = "soft"
shape = { intersection = [{ box = { lower = ["2 mm", "-4.5 mm", "-3.5 mm"], upper = ["8.5 mm", "4.5 mm", "3.5 mm"] } }, { box = { lower = LOWER, upper = ["24 mm", "8 mm", "8 mm"] } }] }
[[body]]
name = "ball"
material = "ball"
shape = { sphere = { center = ["14.6 mm", 0, 0], radius = "5 mm" } }
[[contact]]
between = ["soft", "ball"]
law = "friction"
friction = 0.3
[[drive]]
material = "soft"
region = { box = { lower = ["2 mm", "-9 mm", "-9 mm"], upper = ["4 mm", "9 mm", "9 mm"] } }
velocity = [0.5, 0, 0]
components = "x"
[[force]]
material = "soft"
region = { box = { lower = ["4 mm", "-9 mm", "-9 mm"], upper = ["7 mm", "9 mm", "9 mm"] } }
pressure = "2 kPa"
[boundary]
x-max = { plate = { friction = 0.1, velocity = [-1, 0, 0] } }
[run]
until = 1
cfl = 0.4
steps = 200
"#;

/// Where particles are now, by where they began [µm].
fn places(begun: &Simulation, now: &Simulation) -> HashMap<[i64; 3], [f64; 3]> {
    let by_identity = |simulation: &Simulation| -> HashMap<u64, [f64; 3]> {
        let identities = numbers(simulation, labels::Identity::ID);
        let places = numbers(simulation, labels::Position::ID);
        identities.iter().zip(places).map(|(i, x)| (i[0].to_bits(), [x[0], x[1], x[2]])).collect()
    };
    let now = by_identity(now);
    let begun = by_identity(begun).into_iter();
    begun.map(|(who, x)| (x.map(|x| (x * 1e6).round() as i64), now[&who])).collect()
}

/// The largest distance [cells] between particles of the whole model and of the one that mirrors cut at 0 on some axes.
fn difference(text: &str, overrides: Overrides<'_>, axes: &[usize]) -> f64 {
    let lower = |cut: &[usize]| {
        let of = |a: usize| if cut.contains(&a) { 0.0 } else { [-24e-3, -8e-3, -8e-3][a] };
        text.replace("LOWER", &format!("{:?}", [0, 1, 2].map(of)))
    };
    let (all, mut half, mut cut) = (lower(&[]), lower(axes), overrides.to_vec());
    cut.extend(
        axes.iter().map(|&a| (["boundary.x-min", "boundary.y-min", "boundary.z-min"][a], "symmetric")),
    );
    if axes.contains(&0) {
        let (from, to) =
            (half.find("[[body]]\nname = \"left\"").expect("a part"), half.find("[run]").expect("a part"));
        half.replace_range(from..to, "");
        cut.retain(|(key, _)| !key.starts_with("body.1."));
    }
    let [whole, part] = [(&all, overrides), (&half, &cut)].map(|(text, overrides)| {
        let begun = start(scene(text, overrides));
        let mut now = start(scene(text, overrides));
        let report = finish(&mut now).expect("runs");
        assert!(report.materials.len() == 1 || report.friction > 0.0, "the balls do not rub each other");
        places(&begun, &now)
    });
    assert!(part.len() > 100 && part.len() << axes.len() == whole.len(), "{} of {}", part.len(), whole.len());
    let cell = 1e-3;
    let apart = |(begun, x): (&[i64; 3], &[f64; 3])| {
        let other = whole[begun];
        norm([0, 1, 2].map(|a| x[a] - other[a])) / cell
    };
    part.iter().map(apart).fold(0.0, f64::max)
}

#[test]
fn a_part_between_mirrors_moves_as_the_whole() {
    let variants: [Overrides<'_>; 3] = [
        // hats tear and crush what moves far: in short steps
        &[("run.shape", "linear"), ("run.cfl", "0.2")],
        &[("run.pic", "0.02")],
        &[("run.rates", "per-material")],
    ];
    for variant in variants {
        for axes in [&[0][..], &[1, 2], &[0, 1, 2]] {
            let models =
                [("bar", BAR, &[][..]), ("rod", BAR, ROD), ("balls", BALLS, &[]), ("held", HELD, &[])];
            for (name, text, overrides) in models {
                // the balls are two, of two materials; hats are torn where the ball rubs
                let torn = text == HELD && variant[0].0 == "run.shape";
                if text == BAR || !axes.contains(&0) && !torn {
                    let apart = difference(text, &[variant, overrides].concat(), axes);
                    assert!(apart < 1e-9, "{name} {axes:?} {variant:?}: {apart} cells");
                }
            }
        }
    }
}

/// A block of next to no stiffness on a face: it goes on as it was set in motion.
const DUST: &str = r#"
[domain]
lower = [0, 0, 0]
upper = ["24 mm", "28 mm", "4 mm"]
cell = "1 mm"
[material.dust]
law = "neo-hookean"
density = 1000
bulk-modulus = "1 Pa"
shear-modulus = "1 Pa"
[[body]]
name = "block"
material = "dust"
particles-per-cell = 2
shape = { box = { lower = [0, "1.5 mm", 0], upper = ["20 mm", "16.5 mm", "4 mm"] } }
[run]
until = 0.05
cfl = 0.2
[boundary]
z-min = "symmetric"
z-max = "symmetric"
"#;

/// The largest and smallest of a component of F in the foot of the block, after it was set in motion by L x. Nodes at free surfaces
/// see only what moves there: so the foot is far from its head and from its sides.
fn deformed(face: &str, gradient: [f64; 3], component: usize, overrides: Overrides<'_>) -> [f64; 2] {
    let mut simulation = start(scene(DUST, &[&[("boundary.x-min", face)], overrides].concat()));
    let of_foot: HashSet<u64> = {
        let all = numbers(&simulation, labels::Identity::ID).into_iter();
        let places = numbers(&simulation, labels::Position::ID);
        all.zip(places)
            .filter(|(_, x)| x[0] < 4e-3 && (x[1] - 9e-3).abs() < 2e-3)
            .map(|(who, _)| who[0].to_bits())
            .collect()
    };
    set_velocity(&mut simulation, |x| gradient.map(|rate| rate * x[0]));
    finish(&mut simulation).expect("runs");
    let all = numbers(&simulation, labels::Deformation::ID).into_iter();
    let all = all.zip(numbers(&simulation, labels::Identity::ID));
    let foot: Vec<f64> =
        all.filter(|(_, who)| of_foot.contains(&who[0].to_bits())).map(|(f, _)| f[component]).collect();
    let of = |pick: fn(f64, f64) -> f64| foot.iter().copied().reduce(pick).expect("layers");
    [of(f64::min), of(f64::max)]
}

#[test]
fn layers_at_a_face_are_compressed_and_sheared_like_all_others() {
    // where particles cross cells, hats sum up to no affine field, with faces or without
    for (shape, tolerance) in [("linear", 1e-2), ("gimp", 1e-3)] {
        let overrides: Overrides<'_> = &[("run.shape", shape)];
        let half = deformed("symmetric", [-10.0, 0.0, 0.0], 0, overrides);
        let stuck = deformed("fixed", [-8.0, 8.0, 0.0], 0, overrides);
        let sheared = deformed("fixed", [-8.0, 8.0, 0.0], 3, overrides);
        eprintln!("{shape}: {half:?} {stuck:?} {sheared:?}");
        for (found, wanted) in [(half, 0.5), (stuck, 0.6), (sheared, 0.4)] {
            assert!(found.iter().all(|f| (f - wanted).abs() < tolerance), "{shape}: {found:?}, not {wanted}");
        }
    }
}
