//! The borders between the parts of Sinew, and rules that all sources keep.
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All Rust files below some folders: path from the root, and text.
fn sources(folders: &[&str]) -> Vec<(String, String)> {
    let mut files = Vec::new();
    let mut folders: Vec<PathBuf> = folders.iter().map(|folder| root().join(folder)).collect();
    while let Some(folder) = folders.pop() {
        if folder.is_file() {
            let name = folder.strip_prefix(root()).expect("below the root").display().to_string();
            files.push((name, fs::read_to_string(folder).expect("a source")));
            continue;
        }
        for entry in fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let name = path.strip_prefix(root()).expect("below the root").display().to_string();
                files.push((name, fs::read_to_string(path).expect("a source")));
            }
        }
    }
    assert!(!files.is_empty());
    files.sort();
    files
}

/// A file's lines of code with their numbers: no comments, and nothing from its test module on.
fn code(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let program = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines =
        program.lines().enumerate().map(|(n, line)| (n + 1, line.split("//").next().unwrap_or_default()));
    lines.filter(|(_, line)| !line.trim().is_empty())
}

/// Words of a line, in lower case: `NodeBlock` is one word, `node_block` is two.
fn words(line: &str) -> impl Iterator<Item = String> {
    line.split(|c: char| !c.is_alphanumeric()).map(str::to_lowercase)
}

/// No line of code below `folders` uses one of `forbidden`.
fn without(folders: &[&str], forbidden: &[&str]) {
    let mut found = Vec::new();
    for (file, text) in sources(folders) {
        for (number, line) in code(&text) {
            if let Some(word) = words(line).find(|word| forbidden.contains(&word.as_str())) {
                found.push(format!("{file}:{number} knows {word:?}: {}", line.trim()));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// No line of code below `folders` contains one of `forbidden`, but for the files whose path starts with `allowed`.
fn without_text(folders: &[&str], forbidden: &[&str], allowed: &str) {
    let mut found = Vec::new();
    for (file, text) in sources(folders).iter().filter(|(file, _)| !file.starts_with(allowed)) {
        for (number, line) in code(text) {
            if let Some(bad) = forbidden.iter().find(|bad| line.contains(*bad)) {
                found.push(format!("{file}:{number} has {bad:?}: {}", line.trim()));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// The dependencies that the manifest of a crate names, but for its dev-dependencies.
fn dependencies(folder: &str) -> Vec<String> {
    let manifest = fs::read_to_string(root().join(folder).join("Cargo.toml")).expect("a manifest");
    let manifest: toml::Table = manifest.parse().expect("TOML");
    manifest["dependencies"].as_table().map_or_else(Vec::new, |it| it.keys().cloned().collect())
}

/// The borders are kept by the compiler: a crate cannot name what its manifest does not.
#[test]
fn each_crate_depends_on_what_it_may_know_alone() {
    let ours = ["simd", "grid", "shapes", "physics", "scene", "engine", "tasks", "sinew", "heat"];
    for (folder, allowed) in [
        ("src/simd", &[][..]),
        ("src/grid", &[]),
        ("src/shapes", &["simd", "grid"]),
        ("src/physics", &["simd"]),
        ("src/scene", &["physics"]),
        ("src/engine", &["simd", "grid"]),
        ("tasks", &["simd", "grid", "shapes", "physics", "scene", "engine"]),
        ("examples/heat", &["engine", "shapes"]),
    ] {
        let all = dependencies(folder);
        let named: Vec<&String> = all.iter().filter(|name| ours.contains(&name.as_str())).collect();
        assert!(named.iter().all(|name| allowed.contains(&name.as_str())), "{folder} knows {named:?}");
    }
    let threads = ["mpi", "rayon", "crossbeam", "petgraph"];
    for folder in ["src/physics", "src/scene", "src/shapes", "tasks", "examples/heat"] {
        assert!(dependencies(folder).iter().all(|name| !threads.contains(&name.as_str())), "{folder}");
    }
}

/// Tasks see numbers and laws; what a scene says reaches them through the recipe.
#[test]
fn only_recipes_among_the_tasks_read_scenes() {
    for (file, text) in sources(&["tasks"]).iter().filter(|(file, _)| !file.starts_with("tasks/recipes/")) {
        let found = code(text).find(|(_, line)| words(line).any(|word| word == "scene"));
        assert_eq!(found, None, "{file}");
    }
}

/// Laws, contact laws and conditions on faces are known by their registries alone. (Other fields use some of the words.)
#[test]
fn the_reader_of_scenes_names_nothing_that_has_a_registry() {
    use physics::{contact, faces, materials};
    let laws = materials::LAWS.iter().map(|law| law.name);
    let names =
        laws.chain(contact::LAWS.iter().map(|law| law.name)).chain(faces::CONDITIONS.iter().map(|c| c.name));
    let quoted: Vec<_> =
        names.filter(|name| !["free", "velocity"].contains(name)).map(|name| format!("\"{name}\"")).collect();
    without_text(&["src/input"], &quoted.iter().map(String::as_str).collect::<Vec<_>>(), "-");
}

#[test]
fn the_engine_knows_no_label_no_law_and_no_material_by_name() {
    let labels = tasks::labels::SCHEMA.labels().map(|label| label.name());
    let laws = physics::materials::LAWS.iter().map(|law| law.name);
    let words = [
        "tissue",
        "stress",
        "law",
        "laws",
        "contact",
        "friction",
        "viscosity",
        "strain",
        "cfl",
        "modulus",
        "rigid",
    ];
    let names: Vec<&str> = labels.chain(laws).chain(words).collect();
    for (file, text) in sources(&["src/engine"]) {
        for (number, line) in text.lines().enumerate() {
            let mut found = line.split(|c: char| !c.is_alphanumeric() && c != '_' && c != '-');
            let found = found.find(|word| names.contains(word));
            assert_eq!(found, None, "{file}:{}: {line}", number + 1);
        }
    }
}

/// What one law alone means by its history, events and counts is in that law's files, and where files name it.
#[test]
fn what_runs_a_law_knows_no_law() {
    let tissue = ["tissue", "fiber", "fibers", "failed", "failure", "failures", "fails", "crushed"];
    without(&["tasks", "src/engine/data", "src/engine/graph", "src/engine/schema"], &tissue);
}

/// What the engine offers and a task may not use: a body has its `Io` alone.
#[test]
fn tasks_know_no_warehouse_and_no_ranks() {
    without(&["tasks", "examples/heat/lib.rs"], &["mpi", "exec", "thread", "threads"]);
    without(&["tasks"], &["warehouse"]);
}

#[test]
fn only_recipes_among_the_tasks_know_a_recipe() {
    for (file, text) in sources(&["tasks"]).iter().filter(|(file, _)| !file.starts_with("tasks/recipes/")) {
        let found = code(text).find(|(_, line)| words(line).any(|word| word == "recipe"));
        assert!(found.is_none() || file == "tasks/lib.rs", "{file}: {found:?}");
    }
}

#[test]
fn nobody_but_the_command_uses_the_lab() {
    without_text(&["src/input", "src/simulation", "src/output"], &["crate::lab"], "-");
    without_text(&["src/input", "src/output"], &["crate::simulation"], "-");
}

#[test]
fn unsafe_code_lives_in_the_simd_and_mpi_layers_alone() {
    for (file, text) in sources(&["src", "tasks", "tools", "examples"]) {
        let found = code(&text).find(|(_, line)| words(line).any(|word| word == "unsafe"));
        let allowed = file.starts_with("src/simd/") || file == "src/engine/exec/ranks/mpi.rs";
        assert!(allowed || found.is_none(), "{file}: {found:?}");
    }
}

#[test]
fn no_file_is_longer_than_400_lines() {
    let long = sources(&["src", "tasks", "tools", "examples", "tests"])
        .into_iter()
        .map(|(file, text)| (text.lines().count(), file));
    assert_eq!(long.filter(|(lines, _)| *lines > 400).collect::<Vec<_>>(), []);
}

#[test]
fn nothing_but_tests_panics_on_purpose() {
    let panics = [".unwrap()", "panic!(", "todo!(", "unimplemented!(", "dbg!("];
    without_text(&["src", "tasks", "tools", "examples"], &panics, "-");
}

/// What `git` tracks, or nothing where there is no repository.
fn tracked() -> Vec<String> {
    let list = std::process::Command::new("git").arg("-C").arg(root()).args(["ls-files", "-z"]).output();
    let list = list.map(|output| output.stdout).unwrap_or_default();
    String::from_utf8_lossy(&list).split('\0').filter(|name| !name.is_empty()).map(str::to_owned).collect()
}

#[test]
fn no_file_names_a_place_on_somebodys_machine() {
    let places = ["work", "root", "tmp", "home"].map(|place| format!("/{place}/"));
    for file in tracked() {
        let Ok(text) = fs::read_to_string(root().join(&file)) else { continue }; // pictures, or gone
        for place in &places {
            let mut ends = text.match_indices(place.as_str()).map(|(at, _)| &text[..at]);
            let path = ends.find(|before| before.ends_with([' ', '"', '\'', '`', '(', '=', ':', '\n']));
            let line = path.map(|before| before.lines().count());
            assert_eq!(line, None, "{file} names {place}");
        }
    }
}
