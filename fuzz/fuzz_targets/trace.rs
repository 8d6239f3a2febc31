//! Bytes as `trace.json`: what `sinew graph --trace` and `sinew scale` do with them.
#![no_main]
use libfuzzer_sys::fuzz_target;
use scene::Scene;
use sinew::input::read_text;
use sinew::lab::diagram::Chart;
use sinew::lab::plan::{Plan, plan};
use sinew::lab::scale::tally;
use sinew::output::trace::read;
use sinew::simulation::rates::{Cycle, at_rest};
use sinew::simulation::step_program;
use std::path::PathBuf;
use std::sync::LazyLock;

struct Shown {
    scene: Scene,
    cycle: Cycle,
    plan: Plan,
    file: PathBuf,
}

static SHOWN: LazyLock<Shown> = LazyLock::new(|| {
    let text = include_str!("../../problems/two-spheres/scene.toml");
    let set = [("domain.cell", "4 mm"), ("run.patches", "[2, 1, 1]")];
    let set = set.map(|(key, value)| (key.to_owned(), value.to_owned()));
    let scene = read_text("two-spheres", text, &set, None).expect("a scene");
    let (cycle, plan) = (at_rest(&scene), plan(&scene, 2, 2).expect("a plan"));
    let file = std::env::temp_dir().join(format!("sinew-fuzz-{}.json", std::process::id()));
    Shown { scene, cycle, plan, file }
});

fuzz_target!(|bytes: &[u8]| {
    let Shown { scene, cycle, plan, file } = &*SHOWN;
    std::fs::write(file, bytes).expect("a file");
    for first in [0, 2] {
        let _ = tally::read(file, first);
    }
    let Ok(measured) = read(file) else { return };
    let _ = measured.table();
    let program = step_program(scene, plan.decomposition.patches.len()).expect("a program");
    for expanded in [false, true] {
        let chart = Chart::new(&program, cycle, &plan.traffic, Some(&measured), expanded);
        let _ = (chart.to_text(), chart.to_json(), chart.to_svg(), chart.to_dot());
    }
});
