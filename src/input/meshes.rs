//! Meshes in files of their own.
use super::document::{Data, Entry, Node};
use super::error::{Fault, Outcome};
use scene::geometry::mesh::Mesh;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use twox_hash::XxHash3_128;

/// Gives all files of meshes their whole path, as seen from `folder`, and a digest; refuses those that have another one.
pub(super) fn locate(node: &mut Node, folder: Option<&Path>) -> Outcome<()> {
    match &mut node.data {
        Data::List(items) => items.iter_mut().try_for_each(|item| locate(item, folder)),
        Data::Table(entries) => entries.iter_mut().try_for_each(|entry| {
            let is_mesh = entry.key == "mesh" && entry.node.find("unit").is_some();
            if is_mesh { fix(&mut entry.node, folder) } else { locate(&mut entry.node, folder) }
        }),
        _ => Ok(()),
    }
}

fn fix(mesh: &mut Node, folder: Option<&Path>) -> Outcome<()> {
    let file = mesh.get("file").clone();
    let path = folder.unwrap_or(Path::new("")).join(file.word());
    let path = std::path::absolute(&path).unwrap_or(path);
    let bytes = std::fs::read(&path).map_err(|error| unreadable(&file, &path, &error.to_string()))?;
    let digest = format!("{:032x}", XxHash3_128::oneshot(&bytes));
    if let Some(wanted) = mesh.find("digest").filter(|wanted| wanted.word() != digest) {
        let message = format!("{} has the digest {digest}: it is not the file that is meant", path.display());
        return Err(Fault::new(wanted.place, message).help("give the old file, or leave out `digest`"));
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

fn unreadable(file: &Node, path: &Path, why: &str) -> Fault {
    Fault::new(file.place, format!("cannot read {}: {why}", path.display()))
        .help("give an STL file; its path counts from the folder of the scene")
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
    let triangles = || -> std::io::Result<Vec<[[f64; 3]; 3]>> {
        let mut file = BufReader::new(File::open(&path)?);
        let corner = |x: stl_io::Vertex| x.0.map(|x| unit * f64::from(x));
        let all = stl_io::create_stl_reader(&mut file).map_err(other)?;
        all.map(|triangle| Ok(triangle.map_err(other)?.vertices.map(corner))).collect()
    };
    let triangles = triangles().map_err(|error| unreadable(file, &path, &error.to_string()))?;
    Mesh::new(&triangles).map_err(|error| {
        Fault::new(file.place, format!("{} bounds no solid: {error}", path.display()))
            .help("repair the mesh: it must be closed, and turn counterclockwise as seen from outside")
    })
}

fn other(error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> std::io::Error {
    std::io::Error::other(error)
}
