//! Scenes that are wrong are told all that is wrong with them, in words that fit a screen.
use crate::*;
use sinew::input::{read, read_text};

const GOOD: &str = "[domain]\nlower = [0, 0, 0]\nupper = [\"8 mm\", \"8 mm\", \"8 mm\"]\ncell = \"1 mm\"\n\
    [material.soft]\nlaw = \"neo-hookean\"\ndensity = 1000\nbulk-modulus = \"1 MPa\"\nshear-modulus = \"0.5 MPa\"\n\
    [[body]]\nname = \"ball\"\nmaterial = \"soft\"\nshape = { sphere = { center = [0.004, 0.004, 0.004], radius = 0.003 } }\n\
    [run]\nuntil = \"1 ms\"\n";

fn errors(text: &str) -> Vec<(Option<usize>, String)> {
    told::faults(&read_text("scene.toml", text, &[], None).expect_err("it is wrong"))
}

#[test]
fn all_that_is_wrong_is_told_at_once_in_the_order_of_lines() {
    let bad = GOOD
        .replace("cell = ", "cel = ")
        .replace("density = 1000", "density = -5")
        .replace("\"0.5 MPa\"", "\"0.5 mm\"")
        .replace("radius = 0.003", "radius = \"wide\"")
        .replace("until = \"1 ms\"", "cfl = 7");
    let found = errors(&bad);
    let lines: Vec<_> = found.iter().map(|(line, _)| line.unwrap_or(0)).collect();
    assert_eq!(lines, [4, 7, 9, 13, 14, 15], "{found:?}");
    for (fact, (_, message)) in
        ["cel", "density", "shear-modulus", "radius", "until", "cfl"].iter().zip(&found)
    {
        assert!(message.contains(fact), "{fact}: {message}");
    }
    // what is asked of the whole is asked when its parts are right: all of that at once, too
    let far = GOOD.replace("[run]", "[[body]]\nname = \"ball\"\nmaterial = \"soft\"\nshape = { sphere = { center = [1, 1, 1], radius = 0.001 } }\n\
        [[body]]\nname = \"other\"\nmaterial = \"sof\"\nshape = { sphere = { center = [1, 1, 1], radius = 0.001 } }\n[run]");
    let found = errors(&far);
    assert!(found.len() == 1 && found[0].1.contains("sof"), "{found:?}");
    let far = far.replace("\"sof\"", "\"soft\"");
    let found = errors(&far);
    assert!(found.iter().any(|(_, m)| m.contains("two bodies named")), "{found:?}");
    assert!(found.iter().any(|(_, m)| m.contains("\"other\" is outside")), "{found:?}");
    // on the screen, and only so many
    let folder = temporary();
    let file = folder.path().join("scene.toml");
    let many: String = (0..50).map(|n| format!("wrong-{n} = 1\n")).collect();
    ok(std::fs::write(&file, GOOD.replace("[run]\n", &format!("[run]\n{many}"))));
    let output = sinew(&["check", text(&file)]);
    refused(&output, &["unknown key `run.wrong-0`", "unknown key `run.wrong-19`", "and 30 more"]);
    assert!(!words(&output).contains("wrong-20`"), "{}", words(&output));
}

/// What is seen only where particles are is bad input all the same.
#[test]
fn two_drives_of_one_particle_are_bad_input() {
    let folder = temporary();
    let file = folder.path().join("scene.toml");
    for twice in ["[[drive]]\nmaterial = \"soft\"\n", "[[force]]\nmaterial = \"soft\"\ntotal = [1, 0, 0]\n"] {
        ok(std::fs::write(&file, format!("{GOOD}{twice}{twice}")));
        for words in [["check", text(&file)], ["run", text(&file)]] {
            let mut command = Command::new(assert_cmd::cargo::cargo_bin!("sinew"));
            refused(&ok(command.args(words).current_dir(folder.path()).output()), &["0 and 1 both"]);
        }
    }
}

#[test]
fn a_file_that_is_no_text_is_told_with_line_and_byte() {
    let folder = temporary();
    let file = folder.path().join("scene.toml");
    let mut bytes = GOOD.as_bytes().to_vec();
    let at = GOOD.find("soft").expect("a name");
    bytes[at + 1] = 0xf6; // ö in Latin-1
    ok(std::fs::write(&file, bytes));
    refused(
        &sinew(&["check", text(&file)]),
        &["scene.toml:5:", "byte 12 of the line is 0xf6", "iconv -f latin1"],
    );
}

#[test]
fn words_without_end_and_control_characters_do_not_reach_the_screen() {
    let long = "x".repeat(1 << 20);
    for bad in [
        GOOD.replace("\"soft\"\nshape", &format!("\"{long}\"\nshape")),
        GOOD.replace("cell =", &format!("{long} = 1\ncell =")),
        GOOD.replace("\"1 MPa\"", &format!("\"1 {long}\"")),
        GOOD.replace("law = \"neo-hookean\"", &format!("law = \"{long}\"")),
    ] {
        let error = read_text("scene.toml", &bad, &[], None).expect_err("it is wrong");
        let shown = format!("{:?}", miette::Report::new(error));
        assert!(shown.len() < 20_000, "{} bytes", shown.len());
        assert!(shown.contains("scene.toml:"), "{shown}");
    }
    for title in ["\\u001b[2J", "two\\nlines", "\\u0007"] {
        let found = errors(&format!("title = \"{title}\"\n{GOOD}"));
        assert!(found[0].1.contains("control character"), "{found:?}");
    }
    // a title is a title, whatever it says
    let folder = temporary();
    let file = folder.path().join("scene.toml");
    ok(std::fs::write(&file, format!("title = \"@DATA@ @PICTURES@ @TITLE@\"\n{GOOD}")));
    let output = sinew(&["graph", text(&file), "--format", "html"]);
    let page = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success() && page.contains("<title>@DATA@ @PICTURES@ @TITLE@: a step</title>"),
        "{}",
        &page[..200]
    );
}

/// Counted in allocations; where lines begin is looked up, and not counted anew for every key.
#[test]
fn reading_takes_work_linear_in_the_size_of_a_scene() {
    let balls = |n: usize| {
        let member = |i: usize| {
            format!(
                "{{ sphere = {{ center = [0.004, 0.004, {}], radius = 0.001 }} }},",
                0.004 + 1e-9 * i as f64
            )
        };
        let members: String = (0..n).map(member).collect();
        let shape = format!("shape = {{ union = [{members}] }}");
        GOOD.replace("shape = { sphere = { center = [0.004, 0.004, 0.004], radius = 0.003 } }", &shape)
            .replace("cell = \"1 mm\"", "cell = \"2 mm\"")
    };
    let materials = |n: usize| {
        let one = |i: usize| {
            format!(
                "[material.m{i}]\nlaw = \"neo-hookean\"\ndensity = 1\nbulk-modulus = 1\nshear-modulus = 1\n"
            )
        };
        format!("{GOOD}{}", (0..n).map(one).collect::<String>())
    };
    let allocations = |text: &str| {
        let mut read = None;
        let counted = allocation_counter::measure(|| read = Some(read_text("scene.toml", text, &[], None)));
        ok(read.expect("it is read").map_err(|error| format!("{:?}", miette::Report::new(error))));
        counted.count_total
    };
    for (small, large) in [(balls(2_000), balls(20_000)), (materials(300), materials(3_000))] {
        let [few, many] = [allocations(&small), allocations(&large)];
        println!("{few} allocations, of ten times as much: {many}");
        assert!(many < 12 * few, "{few}, {many}");
    }
}

#[test]
fn numbers_at_the_ends_of_their_range_are_told_or_run() {
    let folder = temporary();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems");
    for (problem, key) in [
        ("two-spheres", "run.cfl=5e-324"),
        ("two-spheres", "run.cfl=1e-300"),
        ("two-spheres", "run.until=5e-324"),
        ("two-spheres", "run.until=1e308"),
        ("two-spheres", "run.smallest-step=5e-324"),
        ("two-spheres", "body.0.angular-velocity=[1e300, 0, 0]"),
        ("two-spheres", "body.0.velocity=[1e300, 0, 0]"),
        ("two-spheres", "load.gravity=[0, 0, 1e300]"),
        ("two-spheres", "material.left.density=1e-300"),
        ("two-spheres", "material.left.density=1e300"),
        ("two-spheres", "domain.upper.0=1e6"),
        ("slab-rigid", "material.lead.angular-velocity=[1e300, 0, 0]"),
        ("slab-rigid", "material.lead.angular-velocity=[0, 1e150, 0]"),
        ("slab-rigid", "run.cfl=5e-324"),
    ] {
        let out = folder.path().join("run");
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("sinew"));
        command.arg("run").arg(scene.join(problem)).args(["-q", "--force", "--steps", "2", "--threads", "1"]);
        command.args(["--set", "output.frames=0", "--set", key, "--out"]).arg(&out);
        let output = ok(command.output());
        let said = words(&output);
        println!("{problem} {key}: {:?} {}", output.status.code(), &said[..said.floor_char_boundary(160)]);
        assert!(matches!(output.status.code(), Some(0..=2)) && !said.contains("panicked"), "{key}: {said}");
    }
    assert!(read(Path::new("/no/such/scene"), &[]).is_err());
}
