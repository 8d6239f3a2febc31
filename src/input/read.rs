//! Reads scene files.
use super::document::{self, Data, Entry, Node, parse};
use super::error::{Outcome, SceneError, all, both};
use super::fields::SCENE;
use super::form::Form;
use super::source::Source;
use super::{blame, build, check, meshes, moduli, references, validate};
use scene::Scene;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::string::FromUtf8Error;

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
    Written::read(path)?.scene(overrides)
}

/// A scene as it is written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// The file.
    pub file: PathBuf,
    /// What it holds.
    pub text: String,
}

impl Written {
    /// The scene of a folder with a `scene.toml`, or of a TOML file.
    ///
    /// # Errors
    /// If it cannot be read, or is no text.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let file = if path.is_dir() { path.join(FILE) } else { path.to_owned() };
        let help = format!("a scene is a folder with a `{FILE}`, or a TOML file");
        let wrong = |why: &dyn Display| {
            SceneError::elsewhere(format!("cannot read {}: {why}", file.display()), help.clone())
        };
        if std::fs::metadata(&file).map_err(|error| wrong(&error))?.is_dir() {
            return Err(wrong(&"it is a folder"));
        }
        let bytes = std::fs::read(&file).map_err(|error| wrong(&error))?;
        let text = String::from_utf8(bytes).map_err(|error| no_text(&file, &error))?;
        Ok(Self { file, text })
    }

    /// The scene, with overrides as in [`read`].
    ///
    /// # Errors
    /// As [`read`].
    pub fn scene(&self, overrides: &[(String, String)]) -> Result<Scene, SceneError> {
        self.scene_in(overrides, validate::available_memory())
    }

    /// The same, with so much memory for its particles [B], if it is limited: that of all machines of a run.
    ///
    /// # Errors
    /// As [`read`].
    pub fn scene_in(
        &self,
        overrides: &[(String, String)],
        memory: Option<usize>,
    ) -> Result<Scene, SceneError> {
        let from = From { file: &self.file.display().to_string(), folder: self.file.parent() };
        let mut scene = read_from(from, &self.text, overrides, memory)?;
        scene.name = name(&self.file);
        Ok(scene)
    }
}

/// A file in another encoding.
fn no_text(file: &Path, error: &FromUtf8Error) -> SceneError {
    let (bytes, at) = (error.as_bytes(), error.utf8_error().valid_up_to());
    let begin = bytes[..at].iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    let line = 1 + bytes[..at].iter().filter(|byte| **byte == b'\n').count();
    let byte = bytes.get(at).copied().unwrap_or_default();
    let message = format!(
        "{}:{line}: byte {} of the line is 0x{byte:02x}, which is no UTF-8 text",
        file.display(),
        at - begin + 1
    );
    let help = "save the file as UTF-8; for a file in Latin-1: iconv -f latin1 -t utf8";
    SceneError::elsewhere(message, help.to_owned())
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
    let mut sources = vec![Source::new(file, text)];
    sources.extend(overrides.iter().map(|(key, value)| Source::new("--set", format!("{key}={value}"))));
    // a scene in its parts, with all overrides but one
    let parts = |left_out: Option<usize>| -> Outcome<(Scene, Node)> {
        let mut root = parse(&sources[0])?;
        let used = overrides.iter().enumerate().filter(|(index, _)| Some(*index) != left_out);
        all(used.map(|(index, (key, value))| document::set(&mut root, key.trim(), value.trim(), index + 1)))?;
        let converted = moduli::convert(&mut root);
        let completed = both(converted, check::complete(&root, &Form::Table(SCENE), ""));
        let ((), mut root) = completed.map_err(|fault| fault.and(references::check(&root)))?;
        meshes::locate(&mut root, folder)?;
        Ok((build::scene(&root)?, root))
    };
    let whole = |(scene, root): &(Scene, Node)| validate::scene(scene, root, memory);
    let read = || -> Outcome<(Scene, Node)> {
        let found =
            parts(None).map_err(|fault| blame::overrides(fault, overrides, |it| parts(Some(it)).err()))?;
        let without = |it| parts(Some(it)).and_then(|found| whole(&found)).err();
        whole(&found).map_err(|fault| blame::overrides(fault, overrides, without))?;
        Ok(found)
    };
    let (mut scene, root) = read().map_err(|fault| fault.in_sources(&sources))?;
    scene.name = file.to_owned();
    scene.lines = root.lines(&sources[0]);
    scene.resolved = resolved(&root);
    Ok(scene)
}

/// The completed document as TOML.
fn resolved(root: &Node) -> String {
    let empty = |entry: &&Entry| !matches!(&entry.node.data, Data::List(items) if items.is_empty());
    let entries = root.entries().iter().filter(empty).cloned().collect();
    let text = toml::to_string(&Node { data: Data::Table(entries), ..*root }.to_toml()).unwrap_or_default();
    format!("# The scene as it was run: SI units, defaults filled in.\n{text}")
}
