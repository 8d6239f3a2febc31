//! The scenes of `problems/` can be read, and what a run writes beside its results is the same scene.
use scene::Scene;
use scene::sampling;
use sinew::input::{read, read_text};
use std::path::Path;

/// Problems, and the scenes of tests.
fn scenes() -> impl Iterator<Item = std::path::PathBuf> {
    let entries = |folder: &str| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let entries = std::fs::read_dir(folder).expect("a folder of scenes");
        entries.map(|entry| entry.expect("an entry").path())
    };
    let problems = entries("problems").filter(|path| path.join("scene.toml").exists());
    problems.chain(entries("tests/scenes"))
}

/// A scene without where it was read from.
fn meaning(scene: &Scene) -> String {
    let mut scene = scene.clone();
    scene.name.clear();
    scene.lines.clear();
    format!("{scene:#?}")
}

#[test]
fn scenes_are_read_and_read_again_from_what_they_resolve_to() {
    for path in scenes() {
        let scene = read(&path, &[]).unwrap_or_else(|e| panic!("{:?}", miette::Report::new(e)));
        assert_eq!(Some(scene.name.as_str()), path.file_stem().and_then(|name| name.to_str()));
        let again = read_text("resolved", &scene.resolved, &[], None)
            .unwrap_or_else(|e| panic!("{:?}", miette::Report::new(e)));
        assert_eq!(meaning(&scene), meaning(&again));
    }
}

#[test]
fn the_slab_of_the_paper_has_as_many_particles() {
    let scene =
        read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/slab"), &[]).expect("a good scene");
    let slab = &scene.bodies[0];
    assert_eq!(sampling::count(&scene, slab), 1_600_000);
    let lead: f64 = 4.0 / 3.0 * std::f64::consts::PI * 4.5e-3f64.powi(3);
    let sampled = sampling::count(&scene, &scene.bodies[1]) as f64
        * sampling::particle_volume(&scene, &scene.bodies[1]);
    assert!((sampled / lead - 1.0).abs() < 0.01, "{sampled} m³, not {lead} m³");
}
