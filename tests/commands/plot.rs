//! Plots of histories.
use crate::common::command::{sinew, words};

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
