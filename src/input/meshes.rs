//! Meshes in files of their own.
use super::document::{Data, Entry, Node};
use super::error::{Fault, Outcome, all};
use scene::geometry::mesh::Mesh;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use twox_hash::XxHash3_128;

/// Gives all files of meshes their whole path, as seen from `folder`, and a digest; refuses those that have another one.
pub(super) fn locate(node: &mut Node, folder: Option<&Path>) -> Outcome<()> {
    match &mut node.data {
        Data::List(items) => all(items.iter_mut().map(|item| locate(item, folder))).map(drop),
        Data::Table(entries) => all(entries.iter_mut().map(|entry| {
            let is_mesh = entry.key == "mesh" && entry.node.find("unit").is_some();
            if is_mesh { fix(&mut entry.node, folder) } else { locate(&mut entry.node, folder) }
        }))
        .map(drop),
        _ => Ok(()),
    }
}

fn fix(mesh: &mut Node, folder: Option<&Path>) -> Outcome<()> {
    let (file, folder) = (mesh.get("file").clone(), folder.unwrap_or(Path::new("")));
    let wanted = mesh.find("digest").map(|digest| (digest.word().to_owned(), digest.place));
    let mut path = folder.join(file.word());
    // a folder that was moved, with its scene and its meshes
    let beside = Path::new(file.word()).file_name().map(|name| folder.join(name));
    if let (false, Some(beside), Some(_)) = (path.exists(), beside, &wanted) {
        path = beside;
    }
    let path = std::path::absolute(&path).unwrap_or(path);
    let bytes = bytes(&path).map_err(|error| unreadable(&file, &path, &error.to_string()))?;
    let digest = format!("{:032x}", XxHash3_128::oneshot(&bytes));
    if let Some((_, place)) = wanted.filter(|(wanted, _)| *wanted != digest) {
        let message = format!("{} has the digest {digest}: it is not the file that is meant", path.display());
        return Err(Fault::new(place, message).help("give the old file, or leave out `digest`"));
    }
    let Some(path) = path.to_str().map(str::to_owned) else {
        let message = "the whole path of this file is no Unicode text";
        return Err(Fault::new(file.place, message).help("put it into another folder"));
    };
    if let Data::Table(entries) = &mut mesh.data {
        entries.retain(|entry| !["file", "digest"].contains(&entry.key.as_str()));
        for (key, text) in [("file", path), ("digest", digest)] {
            let node = Node { data: Data::Text(text), ..file };
            entries.push(Entry { key: key.to_owned(), place: file.place, node });
        }
    }
    Ok(())
}

/// What an ordinary file holds.
fn bytes(path: &Path) -> std::io::Result<Vec<u8>> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(std::io::Error::other("it is no ordinary file"));
    }
    std::fs::read(path)
}

fn unreadable(file: &Node, path: &Path, why: &str) -> Fault {
    Fault::new(file.place, format!("cannot read {}: {why}", path.display()))
        .help("give an STL file; its path counts from the folder of the scene, and all hosts that run ranks must see it there")
}

/// The mesh of a table whose file is located.
pub(super) fn read(given: &Node) -> Outcome<Mesh> {
    let (file, path) = (given.get("file"), PathBuf::from(given.get("file").word()));
    let unit = match given.get("unit").word() {
        "cm" => 1e-2,
        "mm" => 1e-3,
        "um" => 1e-6,
        "in" => 25.4e-3,
        _ => 1.0,
    };
    let triangles = bytes(&path)
        .and_then(|bytes| triangles(&bytes, unit))
        .map_err(|error| unreadable(file, &path, &error.to_string()))?;
    Mesh::new(&triangles).map_err(|error| {
        Fault::new(file.place, format!("{} bounds no solid: {error}", path.display()))
            .help("repair the mesh: it must be closed, and turn counterclockwise as seen from outside")
    })
}

/// Bytes before the triangles of a binary file, and of each triangle.
const HEAD: usize = 84;
const TRIANGLE: usize = 50;

/// The corners of all triangles [m]: of a binary file, whose length its count explains, or of a text.
fn triangles(bytes: &[u8], unit: f64) -> std::io::Result<Vec<[[f64; 3]; 3]>> {
    let counted = bytes.get(HEAD - 4..HEAD).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes);
    let is_binary = counted.is_some_and(|count| bytes.len() == HEAD + TRIANGLE * count as usize);
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).trim_ascii_start();
    let is_text =
        !is_binary && text.len() >= 5 && text[..5].eq_ignore_ascii_case(b"solid") && !bytes.contains(&0);
    if !is_binary && !is_text {
        let length = match counted {
            Some(count) => format!(
                "its head counts {count} triangles, for which its {} bytes are too few or too many",
                bytes.len()
            ),
            None => "it is too short".to_owned(),
        };
        return Err(std::io::Error::other(format!(
            "it is no STL file: it is no text that begins with `solid`, and {length}"
        )));
    }
    // words in upper case, and names in other alphabets
    let mut plain: Vec<u8> = match is_text {
        true => {
            text.iter().map(|byte| if byte.is_ascii() { byte.to_ascii_lowercase() } else { b'?' }).collect()
        }
        false => bytes.to_vec(),
    };
    if is_binary {
        // whatever its head says, it is no text
        plain[..HEAD - 4].fill(0);
    }
    let mut reader = Cursor::new(plain);
    let all = stl_io::create_stl_reader(&mut reader).map_err(other)?;
    let corner = |x: stl_io::Vertex| x.0.map(|x| unit * f64::from(x));
    all.map(|triangle| Ok(triangle.map_err(other)?.vertices.map(corner))).collect()
}

fn other(error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> std::io::Error {
    std::io::Error::other(error)
}
