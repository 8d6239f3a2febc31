//! All that is wrong is told at once, at the place that is at fault, and does nothing to a terminal.
use super::{GOOD, refused, told};
use sinew::input::read_text;

fn set(key: &str, value: &str) -> (String, String) {
    (key.to_owned(), value.to_owned())
}

/// All faults with their lines.
fn faults(text: &str, overrides: &[(String, String)]) -> Vec<(Option<usize>, String)> {
    told::faults(&read_text("scene.toml", text, overrides, None).expect_err("it is wrong"))
}

#[test]
fn an_unknown_law_hides_nothing() {
    let bad = GOOD
        .replace("law = \"neo-hookean\"", "law = \"neo-hokean\"\nsher-modulus = 1")
        .replace("density = 1000", "density = -1")
        .replace("\"100 kPa\"", "\"100 mm\"")
        .replace("material = \"soft\"", "material = \"sotf\"")
        .replace("[\"soft\", \"hard\"]", "[\"soft\", \"hrad\"]");
    let found = faults(&bad, &[]);
    for fact in
        ["\"neo-hokean\"", "sher-modulus", "material.soft.density", "bulk-modulus", "\"sotf\"", "\"hrad\""]
    {
        assert!(found.iter().any(|(_, message)| message.contains(fact)), "{fact}: {found:?}");
    }
    assert_eq!(found.len(), 6, "{found:?}");
    // what any law has is right
    let found = faults(&GOOD.replace("law = \"neo-hookean\"", "law = \"x\"\nlambda-star = 1.1"), &[]);
    assert_eq!(found.len(), 1, "{found:?}");
}

#[test]
fn a_material_that_cannot_be_built_hides_nothing() {
    let bad = GOOD
        .replace("upper = [\"80 mm\", \"40 mm\"", "upper = [\"85 mm\", \"40 mm\"")
        .replace("material = \"soft\"", "material = \"sotf\"")
        .replace("upper = [\"20 mm\"", "upper = [\"-20 mm\"");
    let found = faults(&bad, &[]);
    for fact in ["whole number of cells", "\"sotf\"", "box is empty"] {
        assert!(found.iter().any(|(_, message)| message.contains(fact)), "{fact}: {found:?}");
    }
}

#[test]
fn what_an_override_breaks_is_the_overrides() {
    for (key, value, facts) in [
        ("domain.cell", "15 mm", ["whole number of cells", "scene.toml:4"]),
        ("run.until", "", ["`run.until` is missing", "scene.toml:"]),
        ("body.tool.shape.sphere.radius", "15", ["outside of the domain", "scene.toml:"]),
        ("material.hard.motion", "prescribed", ["no `velocity`", "scene.toml:"]),
    ] {
        for before in [vec![], vec![set("run.cfl", "0.3")]] {
            let overrides = [before, vec![set(key, value)]].concat();
            let (report, line) = refused(GOOD, &overrides);
            assert!(line.is_none() && report.contains("--set:1:1"), "{key}: {report}");
            assert!(report.contains(&format!("{key}={value}")), "{key}: {report}");
            assert!(facts.iter().all(|fact| report.contains(fact)), "{key}: {report}");
        }
    }
    // what the file has without it is the file's, whatever else is set
    let bad = GOOD.replace("\"1 ms\"", "\"1 mm\"");
    assert!(refused(&bad, &[set("run.cfl", "0.3")]).1.is_some());
    // one override mends what would hide the fault of the other
    let missing = GOOD.replace("until = \"1 ms\"", "");
    let (report, line) = refused(&missing, &[set("run.until", "1 ms"), set("domain.cell", "15 mm")]);
    assert!(line.is_none() && report.contains("domain.cell=15 mm"), "{report}");
}

#[test]
fn integers_of_more_than_64_bits_are_integers() {
    let (huge, least) = ("99999999999999999999", "-99999999999999999999");
    let with = |line: &str| GOOD.replace("\"1 ms\"", &format!("\"1 ms\"\n{line}"));
    for (line, facts) in [
        (format!("steps = {huge}"), ["`run.steps` is 99999999999999999999", "1 to 9223372036854775807"]),
        (format!("steps = {least}"), ["`run.steps` is -99999999999999999999", "1 to 9223372036854775807"]),
        (format!("patches = [1, 1, {huge}]"), ["`run.patches.2` is 9999999", "1 to 1048576"]),
        ("steps = 0xffffffffffffffffffff".into(), ["`run.steps` is 0xffffffffffffffffffff", "1 to 9"]),
        (format!("shape = {huge}"), ["must be a string", "an integer of more than 64 bits"]),
    ] {
        let (report, _) = refused(&with(&line), &[]);
        assert!(facts.iter().all(|fact| report.contains(fact)), "{line}: {report}");
    }
    let read = |value: &str| read_text("test", &with(&format!("smallest-step = {value}")), &[], None);
    assert_eq!(read(huge).expect("a number").run.smallest_step, 1e20);
    assert_eq!(
        read("0x99999999999999999").expect("a number").run.smallest_step,
        0x9_9999_9999_9999_9999_u128 as f64
    );
}

#[test]
fn control_characters_do_not_reach_the_terminal() {
    for bad in [
        GOOD.replace("until", "\"un\\u001b[2Jtil\""),
        GOOD.replace("[run]", "[\"r\\u0007un\"]"),
        GOOD.replace("\"1 ms\"", "\"1 \u{1b}[2Jms\""),
        GOOD.replace("\"1 ms\"", "\"1 ms\" \u{85} # \u{202e}"),
        GOOD.replace("\"1 ms\"", "\"1 ms\r\"\r"),
        GOOD.replace("until", "untl").replace('\n', "\r\n"),
    ] {
        let error = read_text("scene.toml", &bad, &[], None).expect_err("it is wrong");
        told::told(&error).unwrap_or_else(|why| panic!("{why}"));
    }
}

#[test]
fn many_long_faults_fit_a_screen() {
    let long = "x".repeat(900);
    let many: String = (0..50).map(|n| format!("wrong-{n} = \"{long}\"\n")).collect();
    let error = read_text("scene.toml", &GOOD.replace("[run]\n", &format!("[run]\n{many}")), &[], None);
    let error = error.expect_err("it is wrong");
    let report = told::told(&error).unwrap_or_else(|why| panic!("{why}"));
    assert!(report.contains("more"), "{report}");
}

/// Tools without end in a domain with many cells: nobody looks for particles that they do not have.
#[test]
fn tools_are_not_walked() {
    let tool = |name: &str, z: u32, normal: i32| {
        format!(
            "[material.{name}]\nlaw = \"rigid\"\ndensity = 1\nmotion = \"prescribed\"\n[[body]]\nname = \"{name}\"\nmaterial = \"{name}\"\n\
             shape = {{ half-space = {{ point = [0, 0, {z}], normal = [0, 0, {normal}] }} }}\n"
        )
    };
    let far = "upper = [8000, 4000, 4000]\ncell = 4";
    let text = GOOD.replace("upper = [\"80 mm\", \"40 mm\", \"40 mm\"]\ncell = \"10 mm\"", far);
    let text = text.replace("[\"20 mm\", \"20 mm\", \"20 mm\"]", "[20, 20, 20]");
    let text =
        text.replace("[\"50 mm\", \"20 mm\", \"20 mm\"], radius = \"15 mm\"", "[50, 20, 20], radius = 15");
    let text =
        text.replace("[boundary]", &format!("{}{}[boundary]", tool("under", 0, 1), tool("over", 4000, -1)));
    read_text("tools", &text, &[], None).unwrap_or_else(|e| panic!("{:?}", miette::Report::new(e)));
}

#[test]
fn keys_of_overrides_are_not_endless() {
    let deep = vec!["a"; 100_000].join(".");
    let (report, _) = refused(GOOD, &[set(&deep, "1")]);
    assert!(report.contains("deeper"), "{report}");
}
