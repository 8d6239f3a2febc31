//! Pictures of a made wound. `SINEW_PICTURES=DIR cargo test --test commands picture` keeps them to be looked at.
use physics::faces::free::Free;
use scene::geometry::Solid;
use scene::*;
use sinew::lab::picture::{Canvas, Coloring, exit_face, section};
use sinew::lab::wound;
use sinew::output::frame::Field;
use sinew::output::snapshot::Snapshot;
use std::path::Path;

const MM: f64 = 1e-3;
const H: f64 = 0.5 * MM;
/// The shot flies down the y axis through a slab from y = 30 mm to y = 20 mm.
const SURFACES: [f64; 2] = [30.0 * MM, 20.0 * MM];

fn scene() -> Scene {
    let rigid = |name: &str| Material {
        name: name.into(),
        density: 1000.0,
        behavior: Behavior::Rigid(RigidMotion::Free {
            angular_velocity: [0.0; 3],
            locked: [false; 3],
            locked_turns: [false; 3],
            force: scene::Table(vec![(0.0, [0.0; 3])]),
        }),
    };
    let body = |material: usize| Body {
        name: "body".into(),
        material,
        solid: Solid::Sphere { center: [0.0; 3], radius: 1.0 },
        particles_per_cell: [2; 3],
        velocity: [0.0; 3],
        angular_velocity: [0.0; 3],
        stretch: [1.0; 3],
        fibers: FiberField::Uniform([1.0, 0.0, 0.0]),
    };
    let wound = Wound {
        target: 0,
        projectile: 1,
        axis: 1,
        direction: -1.0,
        surfaces: SURFACES,
        center: [25.0 * MM, 25.0 * MM],
    };
    let checkpoint = Checkpoint { steps: None, time: None, wall: 0.0, at_end: true, kept: 1 };
    Scene {
        probes: vec![],
        name: "slab".into(),
        title: "A fragment through a slab of heart muscle, 50 m/s".into(),
        domain: Domain { lower: [0.0; 3], cells: [50, 42, 50], cell: 2.0 * H },
        materials: vec![rigid("myocardium"), rigid("lead")],
        bodies: vec![body(0), body(1)],
        contacts: vec![],
        faces: std::array::from_fn(|_| Free.into()),
        drives: vec![],
        forces: vec![],
        loads: Loads { gravity: Table(vec![(0.0, [0.0; 3])]), damping: 0.0, local_damping: 0.0 },
        run: Run {
            until: 1.0,
            steps: None,
            cfl: 0.4,
            rates: Rates::Common,
            smallest_step: 0.0,
            shape: ShapeFunction::Gimp,
            pic: 0.0,
            pic_rate: 0.0,
            viscosity: None,
            leaving: Leaving::Error,
            rebalance_every: 0,
            patches: None,
            threads: None,
        },
        output: Output { frames: 1, fields: vec![], history_every: 1, checkpoint, wound: Some(wound) },
        lines: Default::default(),
        resolved: String::new(),
    }
}

/// The slab before (`hole` 0) or after: hole opening downwards, bulge, colored shells, spray, a dented bullet.
fn snapshot(shot: bool) -> Snapshot {
    let mut s = Snapshot { time: if shot { 0.42e-3 } else { 0.0 }, ..Snapshot::default() };
    let (mut failure, mut plastic, mut velocity) = (Vec::new(), Vec::new(), Vec::new());
    let mut add = |material: u16, x: [f64; 3], f: f32, p: f32, v: f32| {
        s.identities.push(s.identities.len() as u64);
        s.materials.push(material);
        s.positions.push(x.map(|x| x as f32));
        failure.push(f);
        plastic.push(p);
        velocity.extend([0.0, -v, 0.0]);
    };
    let at = |i: i32| (f64::from(i) + 0.5) * H;
    for (i, j, k) in (0..100).flat_map(|i| (40..60).flat_map(move |j| (0..100).map(move |k| (i, j, k)))) {
        let mut x = [at(i), at(j), at(k)];
        let [u, v] = [x[0] - 25.0 * MM, x[2] - 25.0 * MM];
        let depth = SURFACES[0] - x[1];
        let radius = u.hypot(v / (1.0 + 30.0 * depth));
        let noise = f64::from((i * 7919 + j * 104_729 + k * 1_299_709).rem_euclid(1000)) / 1000.0;
        let kind = match radius / MM - 0.3 * depth / MM + noise - 0.5 {
            r if r < 6.6 => 3.0,
            r if r < 7.6 => 2.0,
            r if r < 8.2 => 0.0,
            r if r < 9.2 => 1.0,
            _ => 0.0,
        };
        if shot {
            let hole = 5.0 * MM + 0.35 * depth;
            if radius < 4.5 * MM {
                // Spray: what lay in the way.
                x = [
                    x[0] + u * (1.5 * noise),
                    x[1] - (14.0 + 6.0 * noise) * MM + depth,
                    x[2] + v * (1.5 * noise),
                ];
            } else {
                let pushed =
                    (radius.powi(2) + 0.7 * hole.powi(2) * (-(radius / (9.0 * MM)).powi(2)).exp()).sqrt();
                x[0] += u * (pushed / radius - 1.0);
                x[2] += v * (pushed / radius - 1.0);
                x[1] -= 4.0 * MM * (-(radius / (8.0 * MM)).powi(2)).exp() * depth / (10.0 * MM);
            }
        }
        let speed = if shot { (50.0 * (-radius / (8.0 * MM)).exp()) as f32 } else { 0.0 };
        add(0, x, if shot { kind } else { 0.0 }, f32::NAN, speed);
    }
    let middle = if shot { 8.0 * MM } else { 36.0 * MM };
    for (i, j, k) in (-9..9).flat_map(|i| (-9..9).flat_map(move |j| (-9..9).map(move |k| (i, j, k)))) {
        let [a, b, c] = [at(i), at(j), at(k)];
        if (a * a + b * b + c * c).sqrt() < 4.5 * MM {
            let tip = if shot { (-b / (4.5 * MM)).max(0.0).powi(3) * 0.16 } else { 0.0 };
            add(1, [25.0 * MM + a, middle + b, 25.0 * MM + c], f32::NAN, tip as f32, 50.0);
        }
    }
    let field = |name: &str, unit: &str, components| Field {
        name: name.into(),
        unit: unit.into(),
        components,
        ..Field::default()
    };
    s.columns = vec![
        (field("failure", "1", 1), failure),
        (field("plastic_strain", "1", 1), plastic),
        (field("velocity", "m/s", 3), velocity),
    ];
    s
}

fn keep(canvas: &Canvas, name: &str) {
    if let Ok(folder) = std::env::var("SINEW_PICTURES") {
        canvas.write(&Path::new(&folder).join(name)).unwrap();
    }
}

fn share(canvas: &Canvas, is: impl Fn([u8; 3]) -> bool) -> f64 {
    let [width, height] = canvas.size();
    let inside = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    inside.filter(|&(x, y)| is(canvas.pixel(x, y))).count() as f64 / (width * height) as f64
}

fn blue([r, _, b]: [u8; 3]) -> bool {
    b > 100 && f64::from(b) > 1.5 * f64::from(r)
}

fn red([r, g, _]: [u8; 3]) -> bool {
    r > 100 && f64::from(r) > 2.0 * f64::from(g)
}

#[test]
fn the_section_shows_slab_and_wound() {
    let scene = scene();
    let before = section(&snapshot(false), &scene, Coloring::Failure);
    let after = section(&snapshot(true), &scene, Coloring::Failure);
    keep(&before, "section-before.png");
    keep(&after, "section.png");
    assert_eq!(before.size(), after.size(), "frames of a film fit");
    assert!(share(&before, blue) > 0.15 && share(&before, red) < 0.001);
    assert!(share(&after, blue) > 0.08 && share(&after, red) > 0.01);
}

#[test]
fn the_exit_face_has_a_dark_hole_without_spray() {
    let (scene, first, last) = (scene(), snapshot(false), snapshot(true));
    let face = exit_face(&last, Some(&first), &scene, Coloring::Failure).unwrap();
    keep(&face, "exit.png");
    assert!(share(&face, blue) > 0.4);
    let [width, height] = face.size();
    assert_eq!(face.pixel(width / 2, height / 2 - 13), [255; 3], "one looks through the hole");
    assert!(exit_face(&last, None, &scene, Coloring::Failure).is_some());
}

#[test]
fn other_scenes_have_a_middle_section() {
    let mut scene = scene();
    scene.output.wound = None;
    let last = snapshot(true);
    let speed = section(&last, &scene, Coloring::Speed);
    keep(&speed, "speed.png");
    let material = section(&last, &scene, Coloring::Material);
    keep(&material, "material.png");
    assert_ne!(speed, material);
    assert!(exit_face(&last, None, &scene, Coloring::Speed).is_none());

    let bare = Snapshot { columns: vec![], ..last.clone() };
    assert_eq!((Coloring::of(&last), Coloring::of(&bare)), (Coloring::Failure, Coloring::Material));
    for coloring in [Coloring::Failure, Coloring::Speed] {
        section(&bare, &scene, coloring);
    }
    section(&Snapshot::default(), &scene, Coloring::Failure);
}

#[test]
fn a_picture_that_cannot_be_written_names_the_file() {
    let canvas = section(&Snapshot::default(), &scene(), Coloring::Material);
    for path in ["/no/picture.png", "/dev/full"].map(Path::new) {
        if path.parent().unwrap().exists() && !path.exists() {
            continue;
        }
        let message = canvas.write(path).unwrap_err().to_string();
        assert!(message.contains(path.to_str().unwrap()), "{message}");
    }
}

#[test]
fn frames_are_measured_with_the_scene() {
    let (mut scene, first, last) = (scene(), snapshot(false), snapshot(true));
    let report = wound::measure(&scene, Some(&first), &last).unwrap();
    println!("{report}");
    assert!(matches!(report.passage, wound::Passage::Out { .. }));
    assert!((report.caliber_m - 9.0 * MM).abs() < 0.6 * MM);
    assert!(report.taper > 0.1 && report.exit_m > report.entry_m && report.entry_m > 9.0 * MM, "{report}");
    assert!(report.loose_fraction > 0.01);
    assert!(wound::measure(&scene, None, &first).unwrap().to_string().contains("has not reached"));
    scene.output.wound = None;
    let message = wound::measure(&scene, Some(&first), &last).unwrap_err().to_string();
    assert!(message.contains("[output.wound]"));
}
