//! Shapes from STL files: they do what the same shapes in closed form do, and what is no solid is refused.

use crate::common;
use crate::common::Overrides;
use sinew::input::read;
use sinew::simulation::Report;
use std::fmt::Write as _;
use std::path::Path;

/// A block that slides on a tool.
const SLIDE: &str = r#"
[domain]
lower = [0, 0, 0]
upper = ["24 mm", "8 mm", "10 mm"]
cell = "1 mm"
[material.soft]
law = "neo-hookean"
density = 1000
bulk-modulus = "100 kPa"
shear-modulus = "50 kPa"
[material.plate]
law = "rigid"
motion = "prescribed"
density = 1000
[[body]]
name = "block"
material = "soft"
shape = { box = { lower = ["2 mm", "2 mm", "3 mm"], upper = ["6 mm", "6 mm", "6 mm"] } }
velocity = [5, 0, 0]
[[body]]
name = "plate"
material = "plate"
shape = { mesh = { file = "plate.stl", unit = "mm" } }
[[contact]]
between = ["soft", "plate"]
law = "friction"
friction = 0.3
[load]
gravity = [0, 0, -1000]
[run]
until = "1 ms"
cfl = 0.4
"#;

/// The faces of a box [mm] as a text, counterclockwise from outside.
fn stl(lower: [f64; 3], upper: [f64; 3]) -> String {
    let mut text = String::from("solid box\n");
    for (a, end) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
        let at = |u: usize, v: usize| {
            let (mut x, sides) = ([0.0; 3], [lower, upper]);
            for (axis, side) in [(a, end), ((a + 1) % 3, u), ((a + 2) % 3, v)] {
                x[axis] = sides[side][axis];
            }
            x
        };
        let (p, q, r, s) = (at(0, 0), at(1, 0), at(1, 1), at(0, 1));
        let (q, s) = if end == 1 { (q, s) } else { (s, q) };
        for triangle in [[p, q, r], [p, r, s]] {
            text.push_str("facet normal 0 0 0\nouter loop\n");
            for [x, y, z] in triangle {
                let _ = writeln!(text, "vertex {x} {y} {z}");
            }
            text.push_str("endloop\nendfacet\n");
        }
    }
    text + "endsolid box\n"
}

fn folder(scene: &str, mesh: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("scene.toml"), scene).expect("written");
    std::fs::write(folder.path().join("plate.stl"), mesh).expect("written");
    folder
}

fn run(folder: &Path, overrides: Overrides<'_>) -> Report {
    let overrides: Vec<_> = overrides.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    common::run(read(folder, &overrides).unwrap_or_else(|e| panic!("{:?}", miette::Report::new(e))))
}

#[test]
fn a_tool_of_triangles_pushes_and_rubs_as_its_box_does() {
    let (lower, upper) = ([-4.0, -4.0, 1.0], [28.0, 12.0, 2.9375]);
    let folder = folder(SLIDE, &stl(lower, upper));
    let triangles = run(folder.path(), &[]);
    let exact = run(
        folder.path(),
        &[(
            "body.plate.shape",
            "{ box = { lower = [-0.004, -0.004, 0.001], upper = [0.028, 0.012, 0.0029375] } }",
        )],
    );
    let [fast, slow] = [&triangles, &exact].map(|report| report.materials[0].velocity()[0]);
    println!("{fast} m/s on triangles, {slow} m/s on a box");
    assert!(slow < 4.8 && (fast / slow - 1.0).abs() < 1e-9);
    // turned by a quarter and moved, it is a box again
    let turned = "{ rotate = { axis = [0, 0, 1], angle = \"90 deg\", about = [0.012, 0.004, 0], \
                  shape = { mesh = { file = \"plate.stl\", unit = \"mm\" } } } }";
    let square = stl([-4.0, -12.0, 1.0], [28.0, 20.0, 2.9375]);
    std::fs::write(folder.path().join("plate.stl"), square).expect("written");
    let again = run(folder.path(), &[("body.plate.shape", turned)]).materials[0].velocity()[0];
    assert!((again / slow - 1.0).abs() < 1e-9);
}

/// A rigid body of triangles has their volume and inertia; a soft one their particles.
#[test]
fn bodies_of_triangles_have_their_mass() {
    let scene =
        SLIDE.replace("motion = \"prescribed\"", "motion = \"free\"").replace("[[contact]]", "[[never]]");
    let scene = scene.split("[[never]]").next().unwrap_or_default().to_owned() + "[run]\nuntil = \"1 us\"\n";
    let folder = folder(&scene, &stl([8.0, 1.0, 1.0], [20.0, 7.0, 4.0]));
    let report = run(folder.path(), &[]);
    let mass = 1000.0 * 12e-3 * 6e-3 * 3e-3;
    assert!((report.materials[1].mass / mass - 1.0).abs() < 1e-12, "{}", report.materials[1].mass);
    let soft = run(folder.path(), &[("body.plate.material", "soft"), ("material.plate", "")]);
    assert!((soft.materials[0].mass / (mass + 1000.0 * 4e-3 * 4e-3 * 3e-3) - 1.0).abs() < 1e-12);
}

#[test]
fn what_is_no_mesh_is_refused_with_its_reason() {
    let good = stl([-4.0, -4.0, 1.0], [28.0, 12.0, 2.9375]);
    let refused = |mesh: &str, overrides: Overrides<'_>| -> String {
        let folder = folder(SLIDE, mesh);
        let overrides: Vec<_> = overrides.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
        let error = read(folder.path(), &overrides).expect_err("refused");
        format!("{:?}", miette::Report::new(error))
            .replace(['\n', '│'], " ")
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ")
    };
    let open = good
        .replacen("facet normal", "facet", 1)
        .split("facet normal")
        .skip(2)
        .map(|f| format!("facet normal{f}"))
        .collect::<String>();
    let open = format!("solid box\n{open}");
    let inside_out = good.lines().collect::<Vec<_>>();
    // the second and third corner of each triangle change places
    let mut swapped = inside_out.clone();
    for n in (3..inside_out.len())
        .filter(|n| inside_out[n - 1].starts_with("vertex") && inside_out[n - 2] == "outer loop")
    {
        swapped.swap(n, n + 1);
    }
    let swapped = swapped.join("\n");
    for (mesh, overrides, fact) in [
        (open.as_str(), &[][..], "not closed"),
        (&swapped, &[], "inside out"),
        ("solid nothing\nendsolid nothing\n", &[], "no triangles"),
        ("what?", &[], "cannot read"),
        (&good, &[("body.plate.shape.mesh.file", "other.stl")], "cannot read"),
        (&good, &[("body.plate.shape.mesh.unit", "")], "`body.1.shape.mesh.unit` is missing"),
        (&good, &[("body.plate.shape.mesh.unit", "parsec")], "parsec"),
        (&good, &[("body.plate.shape.mesh.digest", "00")], "not the file that is meant"),
    ] {
        let error = refused(mesh, overrides);
        assert!(error.contains(fact), "{fact}: {error}");
    }
}

/// Texts in any case and alphabet, and binary files whatever their head says; a count that the length does not explain is told.
#[test]
fn stl_files_are_read_as_others_write_them() {
    let good = stl([-4.0, -4.0, 1.0], [28.0, 12.0, 2.9375]);
    let mut binary = b"solid that is none\nfacet".to_vec();
    binary.resize(80, b' ');
    let corners: Vec<f32> = good
        .lines()
        .filter_map(|line| line.strip_prefix("vertex "))
        .flat_map(|line| line.split(' ').map(|x| x.parse().expect("a number")))
        .collect();
    binary.extend((corners.len() as u32 / 9).to_le_bytes());
    for triangle in corners.chunks(9) {
        binary.extend([0; 12]);
        triangle.iter().for_each(|x| binary.extend(x.to_le_bytes()));
        binary.extend([0; 2]);
    }
    let latin = [b"\xEF\xBB\xBF \n".to_vec(), good.replacen("box", "K\u{00fc}be", 1).into_bytes()].concat();
    let folder = folder(SLIDE, &good);
    let path = folder.path().join("plate.stl");
    let shape = |bytes: &[u8]| {
        std::fs::write(&path, bytes).expect("written");
        read(folder.path(), &[]).map(|scene| scene.bodies[1].solid.clone())
    };
    let wanted = shape(good.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
    for bytes in [good.to_uppercase().as_bytes(), good.replace('\n', "\r\n").as_bytes(), &latin, &binary] {
        assert_eq!(shape(bytes).unwrap_or_else(|e| panic!("{:?}", miette::Report::new(e))), wanted);
    }
    let short = shape(&[&binary[..80], &[99, 0, 0, 0], &binary[84..]].concat()).expect_err("a wrong count");
    let said = format!("{:?}", miette::Report::new(short));
    assert!(said.contains("99 triangles"), "{said}");
    std::fs::remove_file(&path).expect("removed");
    std::fs::create_dir(&path).expect("a folder");
    let said = format!("{:?}", miette::Report::new(read(folder.path(), &[]).expect_err("no file")));
    assert!(said.contains("no ordinary file"), "{said}");
}

/// The scene that a run writes down finds its mesh from anywhere, and only that one.
#[test]
fn a_resolved_scene_knows_its_mesh() {
    let good = stl([-4.0, -4.0, 1.0], [28.0, 12.0, 2.9375]);
    let folder = folder(SLIDE, &good);
    let scene = read(folder.path(), &[]).unwrap_or_else(|e| panic!("{e}"));
    let elsewhere = tempfile::tempdir().expect("a folder");
    let file = elsewhere.path().join("resolved.toml");
    std::fs::write(&file, &scene.resolved).expect("written");
    let again = read(&file, &[]).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(again.resolved, scene.resolved);
    // a folder that was moved whole has it beside the scene
    let beside = tempfile::tempdir().expect("a folder");
    let lost = scene.resolved.replace(&folder.path().display().to_string(), "/nowhere");
    std::fs::write(beside.path().join("scene.toml"), lost).expect("written");
    std::fs::write(beside.path().join("plate.stl"), &good).expect("written");
    assert!(read(beside.path(), &[]).is_ok());
    // it is the same physics, wherever the file lies
    let moved = self::folder(SLIDE, &good);
    let moved = read(moved.path(), &[]).unwrap_or_else(|e| panic!("{e}"));
    let identity = |scene: &scene::Scene| sinew::input::identity::fingerprint(&scene.resolved);
    assert_eq!(identity(&moved), identity(&scene));
    std::fs::write(folder.path().join("plate.stl"), stl([-4.0, -4.0, 1.0], [28.0, 12.0, 2.0]))
        .expect("written");
    assert!(read(&file, &[]).is_err());
    let changed = read(folder.path(), &[]).unwrap_or_else(|e| panic!("{e}"));
    assert_ne!(identity(&changed), identity(&scene));
}
