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

#[test]
fn physics_knows_no_patch_no_task_and_no_engine() {
    let engine =
        ["patch", "patches", "task", "tasks", "warehouse", "rayon", "petgraph", "mpi", "graph", "exec"];
    without(&["src/physics"], &engine);
}

#[test]
fn tasks_know_no_threads_no_ranks_no_graph_library_and_no_warehouse() {
    let forbidden = ["mpi", "rayon", "crossbeam", "petgraph", "warehouse", "exec", "thread", "threads"];
    without(&["tasks"], &forbidden);
}

/// Tasks see numbers and laws; what a scene says reaches them through the recipe.
#[test]
fn only_the_recipe_among_the_tasks_reads_scenes() {
    without_text(&["tasks"], &["crate::input"], "tasks/timestep.rs");
}

/// Laws, contact laws and conditions on faces are known by their registries alone. (Other fields use some of the words.)
#[test]
fn the_reader_of_scenes_names_nothing_that_has_a_registry() {
    use sinew::physics::{contact, faces, materials};
    let laws = materials::LAWS.iter().map(|law| law.name);
    let names =
        laws.chain(contact::LAWS.iter().map(|law| law.name)).chain(faces::CONDITIONS.iter().map(|c| c.name));
    let quoted: Vec<_> =
        names.filter(|name| !["free", "velocity"].contains(name)).map(|name| format!("\"{name}\"")).collect();
    without_text(&["src/input"], &quoted.iter().map(String::as_str).collect::<Vec<_>>(), "-");
}

#[test]
fn only_the_recipe_among_the_tasks_knows_a_recipe() {
    for (file, text) in sources(&["tasks"]).iter().filter(|(file, _)| file != "tasks/timestep.rs") {
        let found = code(text).find(|(_, line)| words(line).any(|word| word == "recipe"));
        assert_eq!(found, None, "{file}");
    }
}

/// What one law alone means by its history, events and counts is in that law's files, and where files name it.
#[test]
fn what_runs_a_law_knows_no_law() {
    let tissue = ["tissue", "fiber", "fibers", "failed", "failure", "failures", "fails", "crushed"];
    without(&["tasks", "src/data", "src/graph"], &tissue);
}

/// Of the physics, graph and executor use the extent of stencils alone: how far a particle reaches is what decides about
/// ghosts, buffers and relocation.
#[test]
fn graph_and_executor_know_no_physics() {
    const EXTENT: [&str; 8] = ["Origin", "REACH", "BELOW", "BASES", "BUFFER", "STRIDE", "GROUP", "shape"];
    for (file, text) in sources(&["src/graph", "src/exec"]) {
        for (number, line) in code(&text).filter(|(_, line)| line.contains("physics")) {
            let (_, imported) = line.split_once("physics::").expect("an import");
            let names = imported.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|n| !n.is_empty());
            let stranger = names.filter(|name| *name != "crate").find(|name| !EXTENT.contains(name));
            assert_eq!(stranger, None, "{file}:{number}: {line}");
        }
    }
    let laws =
        ["stress", "law", "laws", "contact", "friction", "viscosity", "failure", "strain", "cfl", "modulus"];
    without(&["src/graph", "src/exec"], &laws);
    without_text(&["src/graph", "src/exec"], &["crate::tasks", "crate::simulation", "crate::output"], "-");
}

#[test]
fn data_and_grid_know_no_one_above_them() {
    let above = ["crate::exec", "crate::tasks", "crate::simulation", "crate::output", "crate::input"];
    without_text(&["src/data", "src/grid", "src/simd"], &above, "-");
}

#[test]
fn unsafe_code_lives_in_the_simd_and_mpi_layers_alone() {
    for (file, text) in sources(&["src", "tasks", "tools"]) {
        let found = code(&text).find(|(_, line)| words(line).any(|word| word == "unsafe"));
        let allowed = file.starts_with("src/simd/") || file == "src/exec/ranks/mpi.rs";
        assert!(allowed || found.is_none(), "{file}: {found:?}");
    }
}

#[test]
fn no_file_is_longer_than_400_lines() {
    let long =
        sources(&["src", "tasks", "tools"]).into_iter().map(|(file, text)| (text.lines().count(), file));
    assert_eq!(long.filter(|(lines, _)| *lines > 400).collect::<Vec<_>>(), []);
}

#[test]
fn nothing_but_tests_panics_on_purpose() {
    let panics = [".unwrap()", "panic!(", "todo!(", "unimplemented!(", "dbg!("];
    without_text(&["src", "tasks", "tools"], &panics, "-");
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
