//! A body of 2 mm in a domain of 1 m at cells of 0.25 mm: 4096³ of them, of which the body has 512.
use crate::common::command::{sinew, text, words};

const SCENE: &str = r#"
[domain]
lower = [0, 0, 0]
upper = [1.024, 1.024, 1.024]
cell = "0.25 mm"
[material.soft]
law = "neo-hookean"
density = 1000
bulk-modulus = "10 MPa"
shear-modulus = "1 MPa"
[[body]]
name = "cube"
material = "soft"
shape = { box = { lower = ["500 mm", "500 mm", "500 mm"], upper = ["502 mm", "502 mm", "502 mm"] } }
velocity = [10, 5, -3]
[run]
until = "1 ms"
steps = 20
[output]
frames = 1
[output.checkpoint]
final = true
"#;

/// Most memory that a run of it may ever have had [B].
const MOST: u64 = 200 << 20;

#[test]
fn a_small_body_in_a_wide_domain_is_small() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("cube.toml");
    std::fs::write(&file, SCENE).expect("a file");
    let (file, out) = (text(&file), folder.path().join("out"));
    let checked = sinew(&["check", file]);
    assert!(checked.status.success(), "{}", words(&checked));
    assert!(words(&checked).contains("4096 x 4096 x 4096") && words(&checked).contains("4096 particles"));
    let runs: [&[&str]; 2] = [
        &["run", file, "-q", "--out", text(&out)],
        &["run", "-q", "--restart", text(&out), "--steps", "30", "--patches", "3x4x2"],
    ];
    for arguments in runs {
        let output = sinew(arguments);
        assert!(output.status.success(), "{}", words(&output));
        let summary = std::fs::read_to_string(out.join("summary.json")).expect("a summary");
        let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
        let peak = summary["peak_bytes"].as_u64().expect("Linux tells it");
        assert!(peak < MOST, "{peak} bytes");
    }
    // what looks at scenes alone
    for arguments in
        [&["graph", file, "--ranks", "2", "--patches", "4"][..], &["check", file, "--validate-only"]]
    {
        let output = sinew(arguments);
        assert!(output.status.success(), "{}", words(&output));
    }
}
