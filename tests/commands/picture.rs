//! Pictures of a made wound. `SINEW_PICTURES=DIR cargo test --test commands picture` keeps them to be looked at.
use physics::faces::free::Free;
use physics::motion::Course;
use scene::geometry::Solid;
use scene::*;
use sinew::lab::figure::{Figure, Format, Raster, colors};
use sinew::lab::picture::{Coloring, Cut, Part, Request, Sight, Subject, Survey, View, draw, draw_with};
use sinew::lab::wound;
use sinew::output::frame::Field;
use sinew::output::frame::Frame;
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
        output: Output {
            frames: 1,
            fields: vec![],
            history_every: 1,
            periods: vec![],
            checkpoint,
            wound: Some(wound),
        },
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

fn keep(figure: &Figure, name: &str) {
    if let Ok(folder) = std::env::var("SINEW_PICTURES") {
        figure.write(&Path::new(&folder).join(name), Format::Png, 160.0).unwrap();
    }
}

fn picture(request: &Request, frame: &Snapshot, first: Option<&Snapshot>, scene: &Scene) -> Figure {
    let first = first.map(|first| first as &dyn Frame);
    draw(request, &[Subject { frame, first, scene }]).unwrap()
}

fn section(frame: &Snapshot, scene: &Scene, coloring: Coloring) -> Figure {
    picture(&Request::section(scene, coloring), frame, None, scene)
}

fn speed() -> Coloring {
    Coloring::Field("velocity".into(), Part::Length)
}

fn pixels(figure: &Figure) -> Raster {
    figure.rasterize(160.0).unwrap()
}

/// The share of a picture that has a color, lit one way or another.
fn share(figure: &Figure, color: [u8; 3]) -> f64 {
    let raster = pixels(figure);
    let direction = |c: [u8; 3]| {
        let length = c.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt().max(1.0);
        c.map(|x| f64::from(x) / length)
    };
    let wanted = direction(color);
    let like = |p: &&[u8; 3]| {
        let dark = f64::from(p[0].max(p[1]).max(p[2])) / f64::from(color[0].max(color[1]).max(color[2]));
        let cosine: f64 = direction(**p).iter().zip(wanted).map(|(a, b)| a * b).sum();
        cosine > 0.998 && (0.2..=1.05).contains(&dark)
    };
    raster.pixels.iter().filter(like).count() as f64 / raster.pixels.len() as f64
}

#[test]
fn the_section_shows_slab_and_wound() {
    let scene = scene();
    let before = section(&snapshot(false), &scene, Coloring::Failure);
    let after = section(&snapshot(true), &scene, Coloring::Failure);
    keep(&before, "section-before.png");
    keep(&after, "section.png");
    let [intact, _, _, both] = colors::FAILURE;
    println!(
        "intact {} {}, both {} {}",
        share(&before, intact),
        share(&after, intact),
        share(&before, both),
        share(&after, both)
    );
    assert!(share(&before, intact) > 0.15 && share(&before, both) < 0.001);
    assert!(share(&after, intact) > 0.06 && share(&after, both) > 0.01);
}

#[test]
fn the_exit_face_has_a_hole_without_spray() {
    let (scene, first, last) = (scene(), snapshot(false), snapshot(true));
    let request = Request::exit(&scene, Coloring::Failure).unwrap();
    let face = picture(&request, &last, Some(&first), &scene);
    keep(&face, "exit.png");
    assert!(share(&face, colors::FAILURE[0]) > 0.3);
    // one looks through the hole in the middle of the slab
    let sinew::lab::figure::Mark::Image { raster, .. } =
        face.marks.iter().find(|m| matches!(m, sinew::lab::figure::Mark::Image { .. })).unwrap()
    else {
        unreachable!()
    };
    let [width, height] = raster.size;
    assert_eq!(raster.pixels[width / 2 + width * (height / 2)], [255; 3]);
    picture(&request, &last, None, &scene);
}

#[test]
fn other_scenes_have_a_middle_section() {
    let mut scene = scene();
    scene.output.wound = None;
    let last = snapshot(true);
    let by_speed = section(&last, &scene, speed());
    keep(&by_speed, "speed.png");
    let by_material = section(&last, &scene, Coloring::Material);
    keep(&by_material, "material.png");
    assert_ne!(pixels(&by_speed), pixels(&by_material));
    assert!(Request::exit(&scene, speed()).is_none());

    let bare = Snapshot { columns: vec![], ..last.clone() };
    assert_eq!((Coloring::of(&last), Coloring::of(&bare)), (Coloring::Failure, Coloring::Material));
    for coloring in [Coloring::Failure, speed()] {
        section(&bare, &scene, coloring);
    }
    section(&Snapshot::default(), &scene, Coloring::Failure);
}

#[test]
fn fields_sides_and_cuts_are_what_was_asked_for() {
    let (scene, last) = (scene(), snapshot(true));
    let corner = Request {
        view: View::corner(),
        cut: Cut::Behind(2, 25.0 * MM),
        colorings: vec![Coloring::Failure, speed()],
        ..Request::section(&scene, Coloring::Failure)
    };
    let (first, scene_) = (snapshot(false), &scene);
    let subjects = [&first, &last].map(|frame| Subject { frame, first: None, scene: scene_ });
    let figure = draw(&corner, &subjects).unwrap();
    keep(&figure, "panels.png");
    let images = figure.marks.iter().filter(|m| matches!(m, sinew::lab::figure::Mark::Image { .. })).count();
    assert_eq!(images, 4, "a row for each field, a column for each frame");
    let texts = |figure: &Figure| {
        let text = |mark: &sinew::lab::figure::Mark| match mark {
            sinew::lab::figure::Mark::Text { text, .. } => Some(text.clone()),
            _ => None,
        };
        figure.marks.iter().filter_map(text).collect::<Vec<_>>()
    };
    for words in ["0 µs", "420 µs", "speed [m/s]", "intact", "lead", "cut at z = 25 mm"] {
        assert!(texts(&figure).iter().any(|text| text == words), "{words}: {:?}", texts(&figure));
    }
    // a title is never cut
    let long = "a title that goes on and on ".repeat(12);
    let titled = Scene { title: long.clone(), ..scene.clone() };
    let figure = section(&last, &titled, Coloring::Material);
    let said = texts(&figure).join(" ");
    assert_eq!(
        long.split_whitespace().filter(|word| said.contains(word)).count(),
        long.split_whitespace().count()
    );
    assert!(said.contains(long.trim()), "{said}");
}

#[test]
fn a_tool_without_particles_is_seen_where_it_is() {
    let (mut scene, mut frame) = (scene(), snapshot(true));
    let spin = scene::Table(vec![(0.0, [0.0; 3])]);
    // 10 mm down in a millisecond
    let course = Course::Displacement(scene::Table(vec![(0.0, [0.0; 3]), (1e-3, [0.0, -10.0 * MM, 0.0])]));
    scene.materials[1].behavior =
        Behavior::Rigid(RigidMotion::Prescribed { course, spin, center: None, visible: false });
    scene.bodies[1].solid = Solid::Sphere { center: [25.0 * MM, 36.0 * MM, 25.0 * MM], radius: 4.0 * MM };
    let count = frame.materials.iter().filter(|m| **m == 0).count();
    frame.materials.truncate(count);
    frame.identities.truncate(count);
    frame.positions.truncate(count);
    frame.columns.iter_mut().for_each(|(field, values)| values.truncate(count * field.components));
    let at = |z: f64| {
        let request =
            Request { cut: Cut::Slice(2, z * MM, H), ..Request::section(&scene, Coloring::Failure) };
        picture(&request, &frame, None, &scene)
    };
    let seen = at(25.0);
    keep(&seen, "tool.png");
    // gray is also in text, in the legend and in shadows: the section beside it tells how much
    let [with, without] = [seen, at(5.0)].map(|figure| share(&figure, colors::TOOL));
    println!("{with} of the picture is gray, {without} beside the tool");
    assert!(with > 1.5 * without, "{with} {without}");
    // its lowest point is at 36 - 4.2 - 4 mm: a millimeter and a half below the surface of entry
    let points = |time: f64| {
        let moved = Snapshot { time, ..frame.clone() };
        pixels(&picture(
            &Request { cut: Cut::Slice(2, 25.0 * MM, H), ..Request::section(&scene, Coloring::Failure) },
            &moved,
            None,
            &scene,
        ))
    };
    assert_ne!(points(0.0), points(0.42e-3));
}

#[test]
fn a_film_keeps_its_window_and_its_colors() {
    let (scene, first, last) = (scene(), snapshot(false), snapshot(true));
    let request = Request::section(&scene, speed());
    let subject = |frame| Subject { frame, first: None, scene: &scene };
    let mut survey = Survey::new(&request);
    [&first, &last]
        .into_iter()
        .for_each(|frame| survey.add(&request, &Sight::of(&request, &[subject(frame)])));
    let frames = [&first, &last]
        .map(|frame| pixels(&draw_with(&request, &survey, &Sight::of(&request, &[subject(frame)])).unwrap()));
    assert_eq!(frames[0].size, frames[1].size);
    assert_ne!(frames[0], frames[1]);
    // alone, the first frame is drawn in a smaller window
    assert_ne!(pixels(&section(&first, &scene, speed())).size, frames[0].size);
}

#[test]
fn a_few_numbers_far_out_do_not_hide_the_others() {
    let mut frame = snapshot(false);
    let count = frame.identities.len();
    let mut values: Vec<f32> = (0..count).map(|i| 1e3 * (i % 100) as f32 / 100.0).collect();
    values[7] = 558e9;
    frame.columns = vec![(
        Field { name: "von_mises".into(), unit: "Pa".into(), components: 1, ..Field::default() },
        values,
    )];
    let coloring = Coloring::named("von_mises", &frame.fields()).unwrap();
    let span = coloring.span(&frame, 0..count);
    assert_eq!((span.low, span.beyond), (0.0, [false, true]));
    assert!((900.0..=1000.0).contains(&span.high), "{span:?}");
    let refused = |name: &str| Coloring::named(name, &frame.fields()).unwrap_err();
    assert!(refused("stress").contains("they have material, von_mises"), "{}", refused("stress"));
    assert!(refused("von_mises.xx").contains("one number"));
}

#[test]
fn a_picture_that_cannot_be_written_names_the_file() {
    let figure = section(&Snapshot::default(), &scene(), Coloring::Material);
    let path = Path::new("/no/picture.png");
    let message = figure.write(path, Format::Png, 100.0).unwrap_err().to_string();
    assert!(message.contains("/no/picture.png"), "{message}");
    let huge = Figure { size: [1e6, 1e6], ..figure };
    assert!(huge.rasterize(1000.0).unwrap_err().contains("too many"));
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
    let plot = report.plot("a wound");
    keep(&plot.draw(120.0), "profile.png");
    assert!(plot.lines.iter().all(|line| line.points.len() == report.layers.len()));
    assert!(wound::measure(&scene, None, &first).unwrap().to_string().contains("has not reached"));
    scene.output.wound = None;
    let message = wound::measure(&scene, Some(&first), &last).unwrap_err().to_string();
    assert!(message.contains("[output.wound]"));
}
