//! Every wrong scene is refused with an error that says what is wrong and points at the line.
mod all_at_once;
mod borders;

#[path = "../common/told.rs"]
mod told;

use sinew::input::read_text;

const GOOD: &str = r#"title = "two blocks"
[domain]
lower = [0, 0, 0]
upper = ["80 mm", "40 mm", "40 mm"]
cell = "10 mm"
[material.soft]
law = "neo-hookean"
density = 1000
bulk-modulus = "100 kPa"
shear-modulus = "50 kPa"
[material.hard]
law = "rigid"
density = 8000
motion = "free"
[[body]]
name = "block"
material = "soft"
shape = { box = { lower = [0, 0, 0], upper = ["20 mm", "20 mm", "20 mm"] } }
fibers = { uniform = [0, 2, 0] }
[[body]]
name = "tool"
material = "hard"
shape = { sphere = { center = ["50 mm", "20 mm", "20 mm"], radius = "15 mm" } }
velocity = ["-1 m/s", 0, 0]
[[contact]]
between = ["soft", "hard"]
law = "friction"
friction = 0.1
[boundary]
x-min = "fixed"
[run]
until = "1 ms"
"#;

/// What the good scene does not use.
const MORE: &str = r#"
patches = 2
steps = 9
viscosity = {}
[output.wound]
target = "soft"
projectile = "hard"
axis = "+x"
entry = 0
exit = 0.1
center = [0, 0]
[load]
gravity = [0, 0, 0]
[[drive]]
material = "soft"
velocity = [[0, 0, 0, 0], [1, 0, 0, 0]]
[drive.region.rotate]
axis = [1, 0, 0]
angle = 1
shape = { cone = { start = [0, 0, 0], end = [1, 0, 0], start-radius = 1, end-radius = 2 } }
"#;

/// The error of a scene, as people see it, and its line.
fn refused(text: &str, overrides: &[(String, String)]) -> (String, Option<usize>) {
    match read_text("scene.toml", text, overrides, Some(1 << 30)) {
        Ok(_) => panic!("accepted:\n{text}"),
        Err(error) => {
            let line = error.line();
            let mut report = String::new();
            miette::GraphicalReportHandler::new_themed(miette::GraphicalTheme::unicode_nocolor())
                .with_width(400)
                .render_report(&mut report, &error)
                .expect("a report can be written");
            (report, line)
        }
    }
}

/// The good scene with `from` replaced by `to` is refused; the error has all `facts` and points at the line `at`.
#[track_caller]
fn check(from: &str, to: &str, at: &str, facts: &[&str]) {
    assert!(GOOD.contains(from), "{from:?} is not in the good scene");
    let text = GOOD.replacen(from, to, 1);
    let (report, line) = refused(&text, &[]);
    for fact in facts {
        assert!(report.contains(fact), "{fact:?} is not in\n{report}");
    }
    let expected = text.lines().position(|line| line.contains(at)).map(|index| index + 1);
    assert!(expected.is_some(), "{at:?} is not in the scene");
    assert_eq!(line, expected, "{report}");
    let place = format!("scene.toml:{}:", line.unwrap_or_default());
    assert!(report.contains(&place), "{place:?} is not in\n{report}");
}

#[test]
fn the_good_scene_is_good() {
    let scene = read_text("good", GOOD, &[], None).expect("a good scene");
    assert_eq!(scene.domain.cells, [8, 4, 4]);
    assert_eq!(scene.lines["contact.0.friction"], 28);
    assert_eq!(scene.lines["boundary.x-min"], 30);
    assert!(!scene.lines.contains_key("run.cfl"));
}

#[test]
fn syntax() {
    check("cell = ", "cell ", "cell", &["not TOML"]);
    let (report, line) = refused(&GOOD.replace("[material.hard]", "[material.soft]"), &[]);
    assert!(report.contains("duplicate key") && line == Some(11), "{report}");
}

#[test]
fn keys() {
    check("until", "utnil", "utnil", &["unknown key `run.utnil`", "did you mean `until`"]);
    check("[boundary]", "[bondary]", "[bondary]", &["`bondary`", "did you mean `boundary`"]);
    check("shear-modulus", "shear-modulsu", "modulsu", &["material.soft.shear-modulsu", "`shear-modulus`"]);
    check("sphere", "spheer", "spheer", &["spheer", "did you mean `sphere`"]);
    check("until = \"1 ms\"", "", "[run]", &["`run.until` is missing", "End of the simulated time"]);
    check("law = \"rigid\"", "", "[material.hard]", &["`material.hard.law` is missing", "`neo-hookean`"]);
    check(
        "law = \"friction\"",
        "law = \"bonded\"",
        "friction = 0.1",
        &["`contact.0.friction`", "without a strength"],
    );
}

#[test]
fn types_and_ranges() {
    check(
        "density = 1000",
        "density = -1000",
        "-1000",
        &["material.soft.density", "-1000 kg/m^3", "above 0"],
    );
    check("density = 1000", "density = true", "true", &["must be a density, not a boolean"]);
    check("density = 1000", "density = inf", "inf", &["material.soft.density"]);
    check("density = 1000", "density = nan", "nan", &["material.soft.density"]);
    check("cell = \"10 mm\"", "cell = 0", "cell", &["domain.cell", "is 0", "above 0"]);
    check("lower = [0, 0, 0]", "lower = [0, 0]", "lower", &["array of 3 numbers", "array of 2"]);
    check("\"1 ms\"", "\"1 ms\"\ncfl = 1.5", "cfl", &["run.cfl", "1.5", "at most 1"]);
    check("\"1 ms\"", "\"1 ms\"\nthreads = 0", "threads", &["run.threads", "at least 1"]);
    for many in ["1000000", "-3", "99999999999999999999"] {
        let cores = format!("may use {} core", sinew::simulation::available_threads());
        let facts = ["run.threads", many, &cores, "at most"];
        check("\"1 ms\"", &format!("\"1 ms\"\nthreads = {many}"), "threads", &facts);
    }
    check("\"1 ms\"", "\"1 ms\"\nsteps = 1.5", "steps", &["must be an integer, not a number"]);
    check("\"1 ms\"", "\"1 ms\"\nshape = \"gipm\"", "gipm", &["gipm", "did you mean `gimp`"]);
    check("\"fixed\"", "\"fixt\"", "fixt", &["boundary.x-min", "did you mean `fixed`"]);
    check("\"fixed\"", "3", "x-min = 3", &["a word or a table", "symmetric"]);
    let cells = "material = \"soft\"\nparticles-per-cell = 9";
    check("material = \"soft\"", cells, "per-cell", &["body.0.particles-per-cell", "1 to 8"]);
    check("[[contact]]", "[contact]", "[contact]", &["`contact` must be an array, not a table"]);
}

#[test]
fn units() {
    check("\"10 mm\"", "\"10\"", "cell", &["domain.cell", "without a unit", "mm", "bare number"]);
    check("\"10 mm\"", "\"10 kPa\"", "cell", &["domain.cell", "is a length", "unit of a stress"]);
    check("\"10 mm\"", "\"10 parsec\"", "cell", &["domain.cell", "parsec", "cm, mm"]);
    check("\"100 kPa\"", "\"big\"", "bulk", &["bulk-modulus", "does not start with a number"]);
}

#[test]
fn domains() {
    check(
        "\"80 mm\", \"40 mm\"",
        "\"85 mm\", \"40 mm\"",
        "85 mm",
        &["8.5", "along x", "8.000000e-2", "9.000000e-2"],
    );
    check("\"80 mm\", \"40 mm\"", "\"-80 mm\", \"40 mm\"", "-80 mm", &["the domain is empty", "along x"]);
    check("\"10 mm\"", "\"1 nm\"", "1 nm", &["cells along x", "unit"]);
}

#[test]
fn bodies() {
    let half_out = "[\"70 mm\", \"20 mm\", \"20 mm\"]";
    check(
        "[\"50 mm\", \"20 mm\", \"20 mm\"]",
        half_out,
        half_out,
        &["\"tool\"", "outside of the domain", "0.08"],
    );
    let far = "[50, \"20 mm\", \"20 mm\"]";
    check("[\"50 mm\", \"20 mm\", \"20 mm\"]", far, far, &["\"tool\"", "outside of the domain"]);
    check("\"15 mm\"", "15", "radius = 15", &["\"tool\"", "outside of the domain"]);
    check("\"15 mm\"", "\"1 mm\"", "1 mm\" } }", &["\"tool\" has no particles", "0.01 m"]);
    let meeting = "[\"20 mm\", \"20 mm\", \"20 mm\"]";
    check("[\"50 mm\", \"20 mm\", \"20 mm\"]", meeting, "sphere", &["\"block\" and \"tool\" overlap at"]);
    let text = GOOD.replace("name = \"tool\"", "name = \"block\"");
    let (report, line) = refused(&text, &[]);
    assert!(report.contains("two bodies named \"block\"") && line == Some(21), "{report}");
    let unbounded = "shape = { half-space = { point = [0, 0, 0], normal = [0, 1, 0] } }";
    let ball = "shape = { sphere = { center = [\"50 mm\", \"20 mm\", \"20 mm\"], radius = \"15 mm\" } }";
    check(ball, unbounded, "half-space", &["\"tool\" is unbounded", "intersect"]);
    check(ball, "shape = { difference = [] }", "difference", &["no shapes"]);
    check(ball, "shape = {}", "shape = {}", &["exactly one key", "`sphere`"]);
    check("upper = [\"20 mm\"", "upper = [\"-20 mm\"", "box", &["box is empty", "along x"]);
    check("[0, 2, 0]", "[0, 0, 0]", "fibers", &["zero vector"]);
}

#[test]
fn fibers() {
    let turning = |start: &str, to: &str| {
        format!(
            "{{ turning = {{ start = {start}, axis = [0, 1, 0], from = 0, to = {to}, angle = \"180 deg\" }} }}"
        )
    };
    let uniform = "{ uniform = [0, 2, 0] }";
    check(uniform, &turning("[1, 1, 0]", "1"), "turning", &["perpendicular", "45.000 degrees"]);
    check(uniform, &turning("[1, 0, 0]", "0"), "turning", &["`from` and `to`"]);
    check(uniform, &turning("[1, 0, 0]", "\"1 s\""), "turning", &["body.0.fibers.turning.to", "a time"]);
    check(uniform, "{}", "fibers", &["exactly one key", "`uniform`"]);
}

#[test]
fn memory() {
    let fine = GOOD.replace("cell = \"10 mm\"", "cell = \"1 mm\"");
    let error = |text: &str, bytes| {
        told::faults(&read_text("scene.toml", text, &[], Some(bytes)).expect_err("too many particles"))
    };
    let [(line, message)] = &error(&fine, 700 * 70_000)[..] else { panic!("one body is too many") };
    // the block has 64 000, the ball 113 000
    assert!(message.contains("do not fit into memory") && message.contains("70000"), "{message}");
    assert_eq!(*line, Some(23));
    // must not be walked
    let found = error(&GOOD.replace("10 mm\"\n[m", "1 um\"\n[m"), 1 << 34);
    assert!(found.iter().all(|(_, message)| message.contains("not fit into memory")), "{found:?}");
    assert_eq!(found.iter().map(|(line, _)| *line).collect::<Vec<_>>(), [Some(18), Some(23)]);
    // a domain takes none, however large it is
    let wide = GOOD.replace("[\"80 mm\", \"40 mm\", \"40 mm\"]", "[8000, 4000, 4000]");
    read_text("scene.toml", &wide, &[], Some(1 << 20)).expect("a domain of empty cells");
}

#[test]
fn materials_and_contacts() {
    check(
        "material = \"soft\"",
        "material = \"sotf\"",
        "sotf",
        &["no material \"sotf\"", "did you mean `soft`"],
    );
    check("[\"soft\", \"hard\"]", "[\"soft\", \"hrad\"]", "hrad", &["no material \"hrad\"", "`hard`"]);
    check("[\"soft\", \"hard\"]", "[\"soft\", \"soft\"]", "[\"soft\", \"soft\"]", &["contact with itself"]);
    let twice =
        "[boundary]\n[[contact]]\nbetween = [\"hard\", \"soft\"]\nlaw = \"bonded\"\n[x]".replace("[x]", "");
    let text = GOOD.replace("[boundary]\nx-min = \"fixed\"", &twice);
    let (report, line) = refused(&text, &[]);
    assert!(report.contains("described twice") && line == Some(31), "{report}");
    check("\"neo-hookean\"", "\"neo-hokean\"", "hokean", &["did you mean `neo-hookean`", "`rigid`"]);
    check("\"free\"", "\"free\"\nvelocity = [1, 0, 0]", "[1, 0, 0]", &["no meaning for a free motion"]);
    check("\"free\"", "\"prescribed\"", "-1 m/s", &["is prescribed", "material.hard.velocity"]);
    check("friction = 0.1", "friction = -0.1", "-0.1", &["contact.0.friction", "at least 0"]);
}

#[test]
fn materials_that_frames_cannot_tell_apart() {
    let more = |count: usize| {
        let material = |i: usize| {
            format!("m{i} = {{ law = \"neo-hookean\", density = 1, bulk-modulus = 1, shear-modulus = 1 }}\n")
        };
        let more: String = (2..count).map(material).collect();
        GOOD.replace("[material.soft]", &format!("[material]\n{more}[material.soft]"))
    };
    let many = read_text("many", &more(300), &[], None).expect("as many as fit");
    assert_eq!(many.materials.len(), 300);
    let (report, line) = refused(&more((1 << 16) + 1), &[]);
    assert!(report.contains("65537 materials") && report.contains("at most 65536"), "{report}");
    assert!(line.is_some(), "{report}");
}

#[test]
fn laws_state_the_ranges_of_their_parameters() {
    let tissue =
        "law = \"tissue\"\nc1 = \"2.1 kPa\"\nc3 = \"0.14 kPa\"\nc4 = 22\nc5 = \"100 kPa\"\nlambda-star = 0.9";
    let text = GOOD.replace("law = \"neo-hookean\"", tissue).replace("shear-modulus = \"50 kPa\"", "");
    let (report, line) = refused(&text, &[]);
    assert!(report.contains("`material.soft.lambda-star` is 0.9, but must be at least 1"), "{report}");
    assert_eq!(line, Some(12));
    check("[material.soft]", "[material.\"so/ft\"]", "so/ft", &["cannot name a material"]);
}

/// Whatever stands at a key, the scene is read or refused, at once and without a panic.
#[test]
fn nothing_panics() {
    let values = [
        "-1",
        "0",
        "1e-9",
        "1e300",
        "-1e308",
        "inf",
        "nan",
        "9223372036854775807",
        "x",
        "\"\"",
        "\"1 mm\"",
        "[]",
        "[[]]",
        "[1, 2, 3]",
        "[[0, 1, 2, 3]]",
        "[1e300, 1e300, 1e300]",
        "{}",
        "{ a = 1 }",
        "1979-05-27",
        "true",
        "",
    ];
    let everything = &format!("{GOOD}{MORE}");
    let scene =
        read_text("all", everything, &[], None).unwrap_or_else(|e| panic!("{:?}", miette::Report::new(e)));
    for key in scene.lines.keys() {
        for value in values {
            let _ = read_text("all", everything, &[(key.clone(), value.to_owned())], Some(1 << 30));
        }
    }
}

#[test]
fn tables_in_time() {
    let table = |rows: &str| format!("{{ velocity = {rows} }}");
    check(
        "\"fixed\"",
        &table("[[0, 0, 0, 0], [\"2 ms\", 1, 0, 0], [\"1 ms\", 0, 0, 0]]"),
        "x-min",
        &["times must ascend", "0.001 s after 0.002 s"],
    );
    check("\"fixed\"", &table("[[0, 0, 0]]"), "x-min", &["a row [time, x, y, z], not 3 values"]);
    check("\"fixed\"", &table("[]"), "x-min", &["boundary.x-min.velocity"]);
}

#[test]
fn wounds() {
    let output = |entry: &str, exit: &str| {
        format!(
            "\"1 ms\"\n[output.wound]\ntarget = \"soft\"\nprojectile = \"hard\"\naxis = \"-y\"\n\
             entry = {entry}\nexit = {exit}\ncenter = [0, 0]"
        )
    };
    check("\"1 ms\"", &output("0", "\"20 mm\""), "exit", &["along -y", "swap"]);
    // a layer of the table for every two particles of these would be more than memory
    check("\"1 ms\"", &output("0", "-1e300"), "exit", &["1.0e302 cells", "at most 1048576", "unit"]);
    let same = output("\"20 mm\"", "0").replace("\"hard\"", "\"soft\"");
    check("\"1 ms\"", &same, "projectile", &["the same material"]);
}

#[test]
fn overrides() {
    let set = |key: &str, value: &str| vec![(key.to_owned(), value.to_owned())];
    let read =
        |key: &str, value: &str| read_text("good", GOOD, &set(key, value), None).expect("a good scene");
    assert_eq!(read("run.cfl", "0.25").run.cfl, 0.25);
    assert_eq!(read("run.until", "2 ms").run.until, 2e-3);
    assert_eq!(read("run.viscosity.linear", "0.1").run.viscosity.map(|v| v.quadratic), Some(2.0));
    assert_eq!(read("body.tool.velocity.1", "3 m/s").bodies[1].velocity, [-1.0, 3.0, 0.0]);
    assert_eq!(read("body.1.velocity", "").bodies[1].velocity, [0.0; 3]);
    assert!(!read("boundary.x-min", "").lines.contains_key("boundary.x-min"));
    let refused = |key: &str, value: &str| refused(GOOD, &set(key, value));
    let (report, line) = refused("contact.0.friction", "-1");
    assert!(
        report.contains("--set:1:") && report.contains("contact.0.friction") && line.is_none(),
        "{report}"
    );
    assert!(refused("run.threads", "1000000").0.contains("`run.threads` is 1000000"));
    assert_eq!(read("run.threads", "1024").run.threads, Some(1024));
    assert!(refused("contact.3.friction", "1").0.contains("`3` is no element"));
    assert!(refused("run.clf", "1").0.contains("did you mean `cfl`"));
    assert!(refused("title.x", "1").0.contains("cannot be set inside a string"));
}

#[test]
fn files() {
    let error = sinew::input::read(std::path::Path::new("no/such/scene"), &[]).expect_err("there is no file");
    assert!(error.to_string().contains("no/such/scene"));
}
