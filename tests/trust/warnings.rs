//! What a run says against itself.
use crate::*;
use sinew::output::summary::Summary;

fn warnings(text: &str, more: &[&str]) -> (Vec<String>, String) {
    let folder = temporary();
    let [file, out] = ["scene.toml", "run"].map(|name| folder.path().join(name));
    ok(std::fs::write(&file, text));
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("sinew"));
    command.args(["run", text_of(&file), "-q", "--threads", "1", "--out", text_of(&out)]).args(more);
    let output = ok(command.output());
    completed(&output);
    let summary = ok(Summary::read(&out.join("summary.json")));
    let told = summary.more.get("warnings").and_then(|it| it.as_array().cloned()).unwrap_or_default();
    (told.iter().filter_map(|it| it.as_str().map(str::to_owned)).collect(), words(&output))
}

fn text_of(path: &Path) -> &str {
    text(path)
}

const MEET: &str = r#"
[domain]
lower = [0, 0, 0]
upper = ["16 mm", "8 mm", "8 mm"]
cell = "1 mm"
[material.one]
law = "neo-hookean"
density = 1000
bulk-modulus = "100 kPa"
shear-modulus = "50 kPa"
[material.two]
law = "neo-hookean"
density = 1000
bulk-modulus = "100 kPa"
shear-modulus = "50 kPa"
[[body]]
name = "left"
material = "one"
shape = { sphere = { center = [0.005, 0.004, 0.004], radius = 0.002 } }
velocity = [1, 0, 0]
[[body]]
name = "right"
material = "two"
shape = { sphere = { center = [0.010, 0.004, 0.004], radius = 0.002 } }
[run]
until = "3 ms"
cfl = 0.4
[output]
frames = 0
"#;

#[test]
fn materials_that_pass_through_one_another_are_named_once() {
    let (told, said) = warnings(MEET, &[]);
    assert!(
        told.len() == 1
            && told[0].contains("one and two pass through one another")
            && told[0].contains("[[contact]]"),
        "{told:?}"
    );
    assert_eq!(said.matches("warning: one and two pass through one another").count(), 1, "{said}");
    let contact =
        format!("{MEET}[[contact]]\nbetween = [\"one\", \"two\"]\nlaw = \"friction\"\nfriction = 0\n");
    assert!(warnings(&contact, &[]).0.is_empty());
    // next to one another is not in one another, in whatever cells they lie
    let near = MEET.replace("velocity = [1, 0, 0]\n", "").replace("center = [0.010,", "center = [0.00925,");
    let beside = near.replace("center = [0.005, 0.004, 0.004]", "center = [0.00525, 0.004, 0.004]");
    assert!(warnings(&beside, &[]).0.is_empty());
    // what drives hold yields to nothing, with a contact or without
    let drive = |name: &str, v: i32| format!("[[drive]]\nmaterial = \"{name}\"\nvelocity = [{v}, 0, 0]\n");
    let (told, _) = warnings(&format!("{contact}{}{}", drive("one", 1), drive("two", 0)), &[]);
    assert!(told.len() == 1 && told[0].contains("drives hold both"), "{told:?}");
}

/// What was told before a restart is in the summary, once.
#[test]
fn a_restart_remembers_what_was_told() {
    let folder = temporary();
    let [file, whole, parts] = ["scene.toml", "whole", "parts"].map(|name| folder.path().join(name));
    ok(std::fs::write(&file, MEET));
    let run = |words: &[&str], out: &Path| {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("sinew"));
        ok(command.args(["run", "-q", "--threads", "1"]).args(words).arg(out).output())
    };
    let told = |out: &Path| ok(Summary::read(&out.join("summary.json"))).more["warnings"].clone();
    completed(&run(&[text(&file), "--out"], &whole));
    let steps = ok(Summary::read(&whole.join("summary.json"))).steps - 1;
    completed(&run(&[text(&file), "--steps", &steps.to_string(), "--out"], &parts));
    let output = run(&["--until", "3 ms", "--steps", "1000", "--restart"], &parts);
    completed(&output);
    assert!(!words(&output).contains("pass through"), "{}", words(&output));
    assert_eq!(told(&parts), told(&whole));
}

#[test]
fn bodies_that_the_grid_does_not_resolve_are_named() {
    let thin = MEET.replace(
        "sphere = { center = [0.010, 0.004, 0.004], radius = 0.002 }",
        "box = { lower = [0.012, 0.002, 0.002], upper = [0.013, 0.006, 0.006] }",
    );
    let (told, _) = warnings(&thin.replace("velocity = [1, 0, 0]\n", ""), &[]);
    assert!(told.len() == 1 && told[0].contains("\"right\" is 1.00 cells thick along x"), "{told:?}");
    // at a mirror it is twice as thick; between two faces it has no end
    let at_face = thin
        .replace("velocity = [1, 0, 0]\n", "")
        .replace("[0.012, 0.002", "[0.0155, 0.002")
        .replace("[0.013,", "[0.016,");
    let (told, _) = warnings(&at_face, &["--steps", "1"]);
    assert!(told.len() == 1 && told[0].contains("\"right\" is 1.00 cells thick along x"), "{told:?}");
}

/// What a scene says with other values.
fn told(text: &str, changes: &[&str]) -> Vec<String> {
    let set = changes.iter().flat_map(|change| ["--set", change]);
    warnings(text, &["--steps", "1"].into_iter().chain(set).collect::<Vec<_>>()).0
}

#[test]
fn tools_that_the_grid_makes_blunt_are_named() {
    let text = format!("{MEET}[[contact]]\nbetween = [\"one\", \"two\"]\nlaw = \"friction\"\nfriction = 0\n");
    let tool = |shape: &str| {
        let shape = format!("body.right.shape={{ {shape} }}");
        let rigid = ["law=rigid", "motion=prescribed", "bulk-modulus=", "shear-modulus="];
        let mut changes = rigid.map(|it| format!("material.two.{it}")).to_vec();
        changes.push(shape);
        told(&text, &changes.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let needle = "cylinder = { start = [0.009, 0.002, 0.004], end = [0.009, 0.006, 0.004], radius = 0.0003 }";
    for needle in [needle, &format!("rotate = {{ axis = [0, 1, 1], angle = 0.3, shape = {{ {needle} }} }}")] {
        let found = tool(needle);
        assert!(found.len() == 1 && found[0].contains("tool \"right\" is 0.60 cells across"), "{found:?}");
    }
    let plate = "box = { lower = [0.012, 0.001, 0.001], upper = [0.0121, 0.006, 0.006] }";
    let ball = "sphere = { center = [0.01, 0.004, 0.004], radius = 0.001 }";
    assert!(tool(plate).is_empty() && tool(ball).is_empty());
}

/// λ* = 1.4, as in the paper: beyond it the fibers' stress grows slower than they get thin.
#[test]
fn tissue_beyond_its_stability_is_told() {
    let tissue = |stretch: f64| {
        let across = stretch.powf(-0.5);
        let stretch = format!("body.right.stretch=[{stretch}, {across}, {across}]");
        let law = [
            "law=tissue",
            "failure=none",
            "c1=2.1 kPa",
            "c3=0.14 kPa",
            "c4=22",
            "c5=100 kPa",
            "lambda-star=1.4",
        ];
        let mut changes = law.map(|it| format!("material.two.{it}")).to_vec();
        changes.extend(["material.two.shear-modulus=".into(), stretch]);
        told(MEET, &changes.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let found = tissue(1.45);
    let fact = "particles of two are beyond the stability of their law";
    assert_eq!(found.iter().filter(|it| it.contains(fact)).count(), 1, "{found:?}");
    assert!(tissue(1.35).is_empty());
}

#[test]
fn energy_that_the_accounts_do_not_explain_is_told() {
    // a grip that runs into a tool: no motion satisfies both
    let grip = MEET.replace(
        "[run]",
        "[material.wall]\nlaw = \"rigid\"\nmotion = \"prescribed\"\ndensity = 1000\n[[body]]\nname = \"wall\"\nmaterial = \"wall\"\n\
         shape = { box = { lower = [0.0125, 0.001, 0.001], upper = [0.015, 0.007, 0.007] } }\n[[contact]]\nbetween = [\"two\", \"wall\"]\n\
         law = \"friction\"\nfriction = 0\n[[drive]]\nmaterial = \"two\"\nvelocity = [1, 0, 0]\n[run]",
    );
    let (told, _) = warnings(&grip.replacen("velocity = [1, 0, 0]\n", "", 1), &["--until", "2 ms"]);
    assert!(told.iter().any(|it| it.contains("% of the energy turned over")), "{told:?}");
}

/// Before the first row of the history: what the run had, its last numbers say.
#[test]
fn a_run_that_fails_says_what_its_energy_says() {
    let folder = temporary();
    let out = folder.path().join("run");
    let fast =
        ["run.shape=linear", "body.0.velocity.0=8", "body.1.velocity.0=-8", "output.history-every=1000"];
    let set = fast.iter().flat_map(|change| ["--set", change]);
    let output = ok(run(&["-q"]).args(set).arg("--out").arg(&out).output());
    let said = words(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("of the energy turned over has vanished"), "{said}");
    assert!(ok(std::fs::read_to_string(out.join("summary.json"))).contains("turned over has vanished"));
}
