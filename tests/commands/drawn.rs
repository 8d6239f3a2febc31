//! Plots and pictures that commands draw.
use crate::common::command::{ok, sinew, text, words};
use std::collections::BTreeSet;
use std::path::Path;

/// Force over displacement of a strip between grips, as its README draws it.
#[test]
fn a_plot_shows_columns_of_the_history() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().to_str().expect("a plain path");
    let short = ["--steps", "200", "--out", out, "--force", "--quiet", "--set", "output.frames=0"];
    let run = sinew(&[&["run", "problems/tension"][..], &short].concat());
    assert!(run.status.success(), "{}", words(&run));
    let names = words(&sinew(&["plot", out, "--list"]));
    assert!(
        names.contains("drive.right.force_x_n") && names.contains("drive.right.displacement_x_m"),
        "{names}"
    );
    let x = ["--x", "drive.right.displacement_x_m"];
    let plot = sinew(
        &[&["plot", out][..], &x, &["--y", "drive.right.force_x_n", "--minus", "drive.left.force_x_n"]]
            .concat(),
    );
    assert!(plot.status.success(), "{}", words(&plot));
    let svg = || std::fs::read_to_string(folder.path().join("plot.svg")).expect("a plot");
    // two lines and their samples in the legend; names and units as text
    assert_eq!(svg().matches("stroke-width=\"0.45\"").count(), 4, "{}", svg());
    for words in ["drive.right.displacement x [", "m]", "force [", "N]", "−drive.left.force x"] {
        assert!(svg().contains(words), "{words}: {}", svg());
    }
    // without columns: energies, and forces over displacements
    let all = sinew(&["plot", out]);
    assert!(all.status.success(), "{}", words(&all));
    for words in [
        "energy [",
        "kinetic",
        "residual",
        "time [",
        "displacement [",
        "force on the matter [",
        "drive.right along x",
    ] {
        assert!(svg().contains(words), "{words}: {}", svg());
    }
    let png = folder.path().join("plot.png");
    let drawn = sinew(&[
        "plot",
        out,
        "--width",
        "85 mm",
        "--dpi",
        "100",
        "--out",
        png.to_str().expect("a plain path"),
    ]);
    assert!(drawn.status.success(), "{}", words(&drawn));
    let head = std::fs::read(&png).expect("a picture");
    assert_eq!(u32::from_be_bytes(head[16..20].try_into().expect("four bytes")), 335, "pixels across");
    let wrong = sinew(&["plot", out, "--y", "force"]);
    assert!(wrong.status.code() == Some(2) && words(&wrong).contains("prints their names"));
}

/// Two frames of a short flight.
fn flight(out: &Path) {
    let run = [
        "run",
        "problems/two-spheres",
        "--steps",
        "6",
        "-q",
        "--set",
        "output.period=[{ frames-every = 1e-6 }]",
    ];
    let output = sinew(&[&run[..], &["--out", text(out)]].concat());
    assert!(output.status.success(), "{}", words(&output));
}

#[test]
fn pictures_and_films_are_drawn_as_asked() {
    let folder = ok(tempfile::tempdir());
    let (out, file) = (folder.path().join("run"), |name: &str| folder.path().join(name));
    flight(&out);
    let draw = |more: &[&str], name: &str| {
        let path = file(name);
        let option = if name.starts_with("film") { "--movie" } else { "--out" };
        let output =
            sinew(&[&["picture", text(&out)][..], more, &["--dpi", "60", option, text(&path)]].concat());
        assert!(output.status.success(), "{more:?}: {}", words(&output));
        assert!(words(&output).contains(name));
        ok(std::fs::read(path))
    };
    let width = |png: &[u8]| u32::from_be_bytes([png[16], png[17], png[18], png[19]]);
    let png = draw(
        &["--field", "von_mises", "--field", "velocity.x", "--plane", "z", "--frame", "0,last"],
        "picture.png",
    );
    assert_eq!((&png[1..4], width(&png)), (&b"PNG"[..], 378), "160 mm at 60 dpi");
    let png = draw(&["--field", "speed", "--view", "corner", "--width", "80 mm"], "corner.png");
    assert_eq!(width(&png), 189);
    let svg = String::from_utf8_lossy(&draw(
        &["--field", "material", "--plane", "y=1 mm", "--view", "-y"],
        "cut.svg",
    ))
    .into_owned();
    for words in ["<text", "cut at y = 1 mm", "data:image/png;base64"] {
        assert!(svg.contains(words), "{words}");
    }
    draw(&["--field", "von_mises", "--range", "0:2 kPa", "--material", "left", "--view", "+x"], "one.png");
    // many frames go on in rows below, all of them on the page
    let many = ["--field", "speed", "--view", "+z", "--width", "90 mm", "--frame", "0-6"];
    let svg = String::from_utf8_lossy(&draw(&many, "rows.svg")).into_owned();
    let images: Vec<&str> = svg.lines().filter(|line| line.starts_with("<image")).collect();
    let number = |line: &str, key: &str| -> f64 {
        let (_, rest) = line.split_once(&format!(" {key}=\"")).expect("the key");
        rest.split('"').next().and_then(|x| x.parse().ok()).expect("a number")
    };
    let rows: BTreeSet<String> = images.iter().map(|line| number(line, "y").to_string()).collect();
    assert_eq!((images.len(), rows.len()), (7, 3));
    assert!(images.iter().all(|line| number(line, "x") + number(line, "width") < 90.0));
    // a film is of one size, however narrow; nothing is left of its draft
    draw(&["--field", "speed", "--width", "60 mm"], "film-narrow.png");
    let drafts = ok(std::fs::read_dir(folder.path()))
        .filter(|it| it.as_ref().is_ok_and(|it| it.file_name().to_string_lossy().contains("part")));
    assert_eq!(drafts.count(), 0);
    // a film: acTL says how many pictures it has
    let film = draw(&["--field", "speed", "--rate", "5"], "film.png");
    let at = film.windows(4).position(|word| word == b"acTL").expect("an animated PNG");
    let frames = u32::from_be_bytes([film[at + 4], film[at + 5], film[at + 6], film[at + 7]]);
    assert!(frames >= 3, "{frames}");
    assert_eq!(film.windows(4).filter(|word| *word == b"fcTL").count() as u32, frames);
}

#[test]
fn pictures_that_cannot_be_drawn_are_refused_in_words() {
    let folder = ok(tempfile::tempdir());
    let out = folder.path().join("run");
    flight(&out);
    for (more, expected) in [
        (&["--field", "temperature"][..], "the frames have no field \"temperature\""),
        (&["--field", "von_mises.xx"], "one number"),
        (&["--field", "velocity.q"], "velocity.x, velocity.y, velocity.z"),
        (&["--plane", "w=1"], "name an axis and a place on it"),
        (&["--plane", "x=1 kg"], "85 mm"),
        (&["--view", "above"], "look from +x"),
        (&["--plane", "x", "--view", "+z"], "looks along the plane"),
        (&["--frame", "99", "--field", "speed"], "frames 99"),
        (&["--width", "3 m", "--field", "speed"], "30 mm to 2 m"),
        (&["--dpi", "1", "--field", "speed"], "20 to 2400"),
        (&["--range", "2:1", "--field", "speed"], "LOW:HIGH"),
        (&["--out", "picture.bmp"], "a .png or a .svg"),
        (&["--movie", "film.gif"], "an animated one"),
    ] {
        let output = sinew(&[&["picture", text(&out)][..], more].concat());
        let said = words(&output);
        assert!(output.status.code() == Some(2) && said.contains(expected), "{more:?}: {said}");
    }
    for (more, expected) in [
        (&["picture", "--width", "2 m", "--dpi", "2400"][..], "ask for fewer dpi"),
        (&["picture", "--width", "30 mm", "--field", "von_mises"], "mm wide"),
        (&["picture", "--plane", "x=1 m"], "there is nothing to draw"),
        (&["picture", "--field", "speed", "--material", "wood"], "there is no material \"wood\""),
        (&["picture", "--field", "speed", "--field", "von_mises", "--range", "0:1"], "of one field"),
        (&["picture", "--field", "von_mises", "--range", "0:1 kg"], "a unit of the field (Pa)"),
        (&["plot", "--log", "y"], "name some with --y or --minus"),
        (&["plot", "--y", "right.mean_velocity_x_m_s", "--log", "y"], "no number above zero"),
    ] {
        let output = sinew(&[&more[..1], &[text(&out)], &more[1..]].concat());
        let said = words(&output);
        assert!(output.status.code() == Some(2) && said.contains(expected), "{more:?}: {said}");
    }
    let history = text(&out.join("history.csv")).to_owned();
    let kept = sinew(&["picture", text(&out), "--field", "speed", "--out", &history]);
    assert!(kept.status.code() == Some(2) && words(&kept).contains("a file of a run"), "{}", words(&kept));
}

#[test]
fn programs_read_how_far_a_run_is() {
    let folder = ok(tempfile::tempdir());
    let out = folder.path().join("run");
    let output =
        sinew(&["run", "problems/two-spheres", "--steps", "6", "--log", "json", "--out", text(&out)]);
    assert!(output.status.success(), "{}", words(&output));
    let lines: Vec<serde_json::Value> =
        ok(String::from_utf8(output.stdout)).lines().map(|line| ok(serde_json::from_str(line))).collect();
    let events: Vec<&str> = lines.iter().filter_map(|line| line["event"].as_str()).collect();
    assert_eq!(
        (events.first(), events.contains(&"progress"), lines.len()),
        (Some(&"begin"), true, events.len())
    );
    let end = lines.iter().find(|line| line["event"] == "end").expect("an end");
    assert_eq!((end["status"].as_str(), end["summary"]["steps"].as_u64()), (Some("completed"), Some(6)));
    // the parts of the time are all of it
    let timing = end["summary"]["timing"].as_array().expect("a table");
    let sum: f64 = timing.iter().filter_map(|row| row["share"].as_f64()).sum();
    assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    for part in ["output", "other"] {
        assert!(timing.iter().any(|row| row["what"] == part), "{part}: {timing:?}");
    }
    assert!(
        timing.iter().any(|row| row["what"].as_str().is_some_and(|what| what.contains('…'))),
        "stages: {timing:?}"
    );
    let both = sinew(&["run", "problems/two-spheres", "-q", "-v"]);
    assert_eq!(both.status.code(), Some(2));
}
