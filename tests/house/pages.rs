//! What pages say holds: links lead somewhere, and scenes that they show are scenes.
use crate::common::{finish, giver, start, until};
use sinew::input::read_text;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All pages with their texts.
fn pages() -> Vec<(PathBuf, String)> {
    let mut pages = Vec::new();
    let mut folders = vec![root().join("docs"), root().join("problems")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            match path.is_dir() {
                true => folders.push(path),
                false if path.extension().is_some_and(|end| end == "md") => pages.push(path),
                false => {}
            }
        }
    }
    let others = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"];
    pages.extend(others.map(|page| root().join(page)));
    pages.into_iter().map(|page| (page.clone(), std::fs::read_to_string(page).expect("a page"))).collect()
}

/// The blocks of a page in a language.
fn blocks<'a>(text: &'a str, language: &str) -> Vec<&'a str> {
    let begin = format!("```{language}\n");
    text.split(&begin).skip(1).filter_map(|rest| rest.split("\n```").next()).collect()
}

#[test]
fn links_lead_to_files_of_the_repository() {
    let mut count = 0;
    for (page, text) in pages() {
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = link.split('#').next().unwrap_or_default();
            if file.is_empty() || link.contains("://") || link.contains(' ') {
                continue;
            }
            let target = page.parent().expect("a folder").join(file);
            assert!(target.exists(), "{}: {link}", page.display());
            count += 1;
        }
    }
    assert!(count > 100, "{count} links");
}

#[test]
fn whole_scenes_of_pages_are_scenes() {
    let mut count = 0;
    for (page, text) in pages() {
        for block in blocks(&text, "toml").into_iter().filter(|block| block.contains("[domain]")) {
            let read = read_text(&page.display().to_string(), block, &[], None);
            read.unwrap_or_else(|error| panic!("{}: {:?}", page.display(), miette::Report::new(error)));
            count += 1;
        }
    }
    assert!(count >= 1, "{count} scenes");
}

#[test]
fn the_scene_of_the_readme_runs_to_its_end() {
    let (_, text) = pages()
        .into_iter()
        .find(|(page, _)| page.ends_with("README.md") && page.parent() == Some(root()))
        .expect("a README");
    let block = blocks(&text, "toml")[0];
    let mut simulation = start(read_text("README.md", block, &[], None).expect("a scene"));
    until(&mut simulation, 18e-3);
    // forces are means from here on
    simulation.mark_row();
    let report = finish(&mut simulation).expect("it runs");
    let force = giver(&report, "drive.right").force[0];
    let (stretch, area) = (1.0 + 0.3 * 19e-3 / 20e-3, 4e-3f64.powi(2));
    let (nominal, free) = (force / area, nominal_stress(stretch, 1e6, 0.4e6));
    println!(
        "nominal stress {nominal:.4e} Pa at a stretch of {stretch}, of a free cross-section {free:.4e} Pa"
    );
    // the grips, which hold all axes, stiffen the ends
    assert!((1.0..1.03).contains(&(nominal / free)), "{nominal}");
}

/// P = τ / λ of a bar of the neo-Hookean law at a stretch λ with free sides [Pa]: τ = K/2 (J² − 1) + μ J^(−2/3) dev b is zero across.
fn nominal_stress(l: f64, bulk: f64, shear: f64) -> f64 {
    let kirchhoff = |across: f64, square: f64| {
        let volume = l * across * across;
        let mean = (l * l + 2.0 * across * across) / 3.0;
        0.5 * bulk * (volume * volume - 1.0) + shear * volume.powf(-2.0 / 3.0) * (square - mean)
    };
    let (mut thin, mut thick) = (0.5, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (thin + thick);
        if kirchhoff(middle, middle * middle) > 0.0 { thick = middle } else { thin = middle }
    }
    kirchhoff(thin, l * l) / l
}
