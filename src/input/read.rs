//! Reads scene files.
use super::document::{self, Data, Entry, Node, parse};
use super::error::{Outcome, SceneError};
use super::fields::SCENE;
use super::form::Form;
use super::source::Source;
use super::{build, check, meshes, validate};
use scene::Scene;
use std::path::Path;

/// Name of the file in a scene's folder.
const FILE: &str = "scene.toml";

/// The scene of a folder with a `scene.toml`, or of a TOML file. `overrides` are pairs of a dotted key and a value as TOML
/// (quotes around strings can be left out): `run.cfl` and `0.2`; `contact.0.friction` and `0.1`;
/// `material.tissue.bulk-modulus` and `50 kPa`; `body.bullet.velocity.1` and `-150 m/s`. No value removes the key.
///
/// # Errors
/// Whatever keeps the scene from being run: a file that cannot be read, a value that is unknown, missing, of another type
/// or out of range, and bodies that lie outside of the domain, in each other, or have more particles than memory.
pub fn read(path: &Path, overrides: &[(String, String)]) -> Result<Scene, SceneError> {
    let file = if path.is_dir() { path.join(FILE) } else { path.to_owned() };
    let text = std::fs::read_to_string(&file).map_err(|error| {
        let help = format!("a scene is a folder with a `{FILE}`, or a TOML file");
        SceneError::elsewhere(format!("cannot read {}: {error}", file.display()), help)
    })?;
    let from = From { file: &file.display().to_string(), folder: file.parent() };
    let mut scene = read_from(from, &text, overrides, validate::available_memory())?;
    scene.name = name(&file);
    Ok(scene)
}

/// The name of the folder that holds a `scene.toml`; the stem of another file.
fn name(file: &Path) -> String {
    let folder = || file.canonicalize().ok()?.parent()?.file_name().map(ToOwned::to_owned);
    let stem = file.file_stem().map(ToOwned::to_owned);
    let name = if file.ends_with(FILE) { folder().or(stem) } else { stem };
    name.unwrap_or_default().to_string_lossy().into_owned()
}

/// As [`read`], from a text; `file` names it in errors and is the scene's name, `memory` are the bytes that particles
/// may take, if limited.
///
/// # Errors
/// As [`read`].
pub fn read_text(
    file: &str,
    text: &str,
    overrides: &[(String, String)],
    memory: Option<usize>,
) -> Result<Scene, SceneError> {
    read_from(From { file, folder: None }, text, overrides, memory)
}

/// Where a text comes from: its name, and the folder of the files that it names.
struct From<'a> {
    file: &'a str,
    folder: Option<&'a Path>,
}

fn read_from(
    From { file, folder }: From<'_>,
    text: &str,
    overrides: &[(String, String)],
    memory: Option<usize>,
) -> Result<Scene, SceneError> {
    let mut sources = vec![Source { name: file.to_owned(), text: text.to_owned() }];
    for (key, value) in overrides {
        sources.push(Source { name: "--set".into(), text: format!("{key}={value}") });
    }
    let scene = || -> Outcome<Scene> {
        let mut root = parse(&sources[0])?;
        for (index, (key, value)) in overrides.iter().enumerate() {
            document::set(&mut root, key.trim(), value.trim(), index + 1)?;
        }
        let mut root = check::complete(&root, &Form::Table(SCENE), "")?;
        meshes::locate(&mut root, folder)?;
        let mut scene = build::scene(&root)?;
        validate::scene(&scene, &root, memory)?;
        scene.name = file.to_owned();
        scene.lines = root.lines(&sources[0]);
        scene.resolved = resolved(&root);
        Ok(scene)
    };
    scene().map_err(|fault| fault.in_sources(&sources))
}

/// The completed document as TOML.
fn resolved(root: &Node) -> String {
    let empty = |entry: &&Entry| !matches!(&entry.node.data, Data::List(items) if items.is_empty());
    let entries = root.entries().iter().filter(empty).cloned().collect();
    let text = toml::to_string(&Node { data: Data::Table(entries), ..*root }.to_toml()).unwrap_or_default();
    format!("# The scene as it was run: SI units, defaults filled in.\n{text}")
}
