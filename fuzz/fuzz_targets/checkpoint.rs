//! Checkpoints with unbroken seals whose content is not what Sinew writes: the bytes decide which parts are missing, resized, of
//! other types or with other values. HDF5 reads them, so that what is under test is Sinew and not that library.
#![no_main]
use arbitrary::{Result, Unstructured};
use engine::exec::ranks::Alone;
use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, File, Group, H5Type};
use libfuzzer_sys::fuzz_target;
use simd::Isa;
use sinew::input::identity::first_difference;
use sinew::input::read_text;
use sinew::output::checkpoint::{Reader, Recorded, path};
use sinew::output::seal;
use sinew::simulation::Simulation;
use std::path::PathBuf;
use std::sync::LazyLock;

/// A small scene with a free rigid body and particles that leave.
const SCENE: &str = include_str!("../../tests/scenes/cloud.toml");
const MEMORY: usize = 64 << 20;

struct Valid {
    bytes: Vec<u8>,
    /// Groups, datasets and attributes: with a `@` before their name.
    parts: Vec<String>,
    file: PathBuf,
    folder: tempfile::TempDir,
}

static VALID: LazyLock<Valid> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a folder");
    let mut scene = read_text("cloud", SCENE, &[], Some(MEMORY)).expect("a scene");
    scene.run.threads = Some(1);
    let mut simulation = Simulation::on(Box::new(Alone), scene, Isa::detect()).expect("a simulation");
    assert!(simulation.step().expect("a step"));
    simulation.write_checkpoint(folder.path(), Recorded::default()).expect("a checkpoint");
    let sealed = path(folder.path(), 1);
    let mut parts = Vec::new();
    list(&File::open(&sealed).expect("an HDF5 file"), "", &mut parts);
    let mut bytes = std::fs::read(&sealed).expect("a file");
    bytes.truncate(bytes.len() - seal::LENGTH as usize);
    let file = folder.path().join("fuzzed.h5");
    Valid { bytes, parts, file, folder }
});

fn list(group: &Group, before: &str, parts: &mut Vec<String>) {
    parts.extend(group.attr_names().expect("names").into_iter().map(|name| format!("{before}@{name}")));
    for name in group.member_names().expect("names") {
        let path = format!("{before}{name}");
        if let Ok(inner) = group.group(&name) {
            list(&inner, &format!("{path}/"), parts);
        }
        parts.push(path);
    }
}

/// Changes a part of the file, if HDF5 lets it.
fn change(file: &File, parts: &[String], data: &mut Unstructured<'_>) -> Result<()> {
    let part = data.choose(parts)?;
    if let Some((group, name)) = part.split_once('@') {
        let group = if group.is_empty() { "/" } else { group.trim_end_matches('/') };
        if let Ok(group) = file.group(group) {
            attribute(&group, name, data)?;
        }
        return Ok(());
    }
    match data.int_in_range(0..=9)? {
        0 => drop(file.unlink(part)),
        1 => {
            let other = data.choose(parts)?;
            let _ = file.unlink(part);
            let _ = file.link_hard(other, part);
        }
        2 => {
            let (rows, columns) = (data.int_in_range(0..=70)?, data.int_in_range(0..=9)?);
            let _ = file.unlink(part);
            match data.int_in_range(0..=4)? {
                0 => made::<f64>(file, part, (rows, columns), data.arbitrary()?),
                1 => made::<i32>(file, part, (rows, columns), data.arbitrary()?),
                2 => made::<u32>(file, part, (rows, columns), data.arbitrary()?),
                3 => made::<u64>(file, part, (rows, columns), data.arbitrary()?),
                _ => drop(file.create_group(part)),
            }
        }
        3 => {
            // more than there is
            let (rows, columns) = (1 << data.int_in_range(20..=60)?, data.int_in_range(1..=8)?);
            let _ = file.unlink(part);
            let chunked = file.new_dataset::<f64>().chunk((1 << 10, 1)).shape((rows, columns));
            let _ = chunked.create(part.as_str());
        }
        4 => {
            let text: &str = data.arbitrary()?;
            let _ = file.unlink(part);
            if let (Ok(dataset), Ok(word)) =
                (file.new_dataset::<VarLenUnicode>().create(part.as_str()), text.parse::<VarLenUnicode>())
            {
                let _ = dataset.write_scalar(&word);
            }
        }
        _ => {
            if let Ok(dataset) = file.dataset(part) {
                numbers(&dataset, data)?;
            }
        }
    }
    Ok(())
}

fn attribute(group: &Group, name: &str, data: &mut Unstructured<'_>) -> Result<()> {
    let kind = data.int_in_range(0..=6)?;
    if kind > 0 && group.attr(name).is_ok() {
        let _ = group.delete_attr(name);
    }
    match kind {
        0 => drop(group.delete_attr(name)),
        1 => {
            let text: &str = data.arbitrary()?;
            if let (Ok(attribute), Ok(word)) =
                (group.new_attr::<VarLenUnicode>().create(name), text.parse::<VarLenUnicode>())
            {
                let _ = attribute.write_scalar(&word);
            }
        }
        2 => number(group, name, data.arbitrary::<f64>()?),
        3 => number(group, name, data.arbitrary::<u64>()?),
        4 => number(group, name, data.arbitrary::<u32>()?),
        5 => number(group, name, data.arbitrary::<bool>()?),
        _ => drop(group.new_attr::<u64>().shape(data.int_in_range(0..=5)?).create(name)),
    }
    Ok(())
}

fn number<T: H5Type>(group: &Group, name: &str, value: T) {
    if let Ok(attribute) = group.new_attr::<T>().create(name) {
        let _ = attribute.write_scalar(&value);
    }
}

fn made<T: H5Type + Copy>(file: &File, part: &str, (rows, columns): (usize, usize), value: T) {
    let values = vec![value; rows * columns.max(1)];
    let created = match columns {
        0 => file.new_dataset::<T>().shape(rows).create(part),
        _ => file.new_dataset::<T>().shape((rows, columns)).create(part),
    };
    if let Ok(dataset) = created {
        let _ = dataset.write_raw(&values);
    }
}

/// What becomes of a number.
#[derive(Clone, Copy)]
enum New {
    Bits(u64),
    Small(i8),
    /// That of another place.
    Of(usize),
}

/// Changes some numbers of a dataset.
fn numbers(dataset: &Dataset, data: &mut Unstructured<'_>) -> Result<()> {
    let size = dataset.size();
    if size == 0 || size > 1 << 20 {
        return Ok(());
    }
    let mut some = Vec::new();
    for _ in 0..data.int_in_range(1..=4)? {
        let at = data.int_in_range(0..=size - 1)?;
        let new = match data.int_in_range(0..=2)? {
            0 => New::Bits(data.arbitrary()?),
            1 => New::Small(data.arbitrary()?),
            _ => New::Of(data.int_in_range(0..=size - 1)?),
        };
        some.push((at, new));
    }
    let _ = changed::<f64>(dataset, &some, f64::from_bits, f64::from)
        || changed::<i32>(dataset, &some, |bits| bits as i32, i32::from)
        || changed::<u32>(dataset, &some, |bits| bits as u32, |small| small as u32)
        || changed::<u64>(dataset, &some, |bits| bits, |small| small as u64);
    Ok(())
}

fn changed<T: H5Type + Copy>(
    dataset: &Dataset,
    some: &[(usize, New)],
    of_bits: impl Fn(u64) -> T,
    of_small: impl Fn(i8) -> T,
) -> bool {
    if !dataset.dtype().is_ok_and(|found| found == hdf5::Datatype::from_type::<T>().expect("a type")) {
        return false;
    }
    if let Ok(mut values) = dataset.read_raw::<T>() {
        for &(at, new) in some {
            values[at] = match new {
                New::Bits(bits) => of_bits(bits),
                New::Small(small) => of_small(small),
                New::Of(other) => values[other],
            };
        }
        let _ = dataset.write_raw(&values);
    }
    true
}

/// What a restart does.
fn go_on(valid: &Valid) {
    let Ok(reader) = Reader::open(&valid.file) else { return };
    let Ok(mut scene) = read_text("checkpoint", &reader.head.scene, &[], Some(MEMORY)) else { return };
    if first_difference(&reader.head.scene, &scene.resolved).is_some() {
        return;
    }
    (scene.run.threads, scene.run.patches) = (Some(1), scene.run.patches.or(Some([1; 3])));
    let Ok(mut simulation) = Simulation::restore(Box::new(Alone), scene, Isa::detect(), &reader) else {
        return;
    };
    for _ in 0..2 {
        if !simulation.step().unwrap_or(false) {
            return;
        }
    }
    if simulation.report().is_ok() {
        let _ = simulation.write_checkpoint(valid.folder.path(), reader.head.recorded);
    }
}

fuzz_target!(|bytes: &[u8]| {
    let valid = &*VALID;
    let mut data = Unstructured::new(bytes);
    std::fs::write(&valid.file, &valid.bytes).expect("a file");
    let Ok(file) = File::open_rw(&valid.file) else { return };
    let changes = data.int_in_range(1..=3).unwrap_or(1);
    for _ in 0..changes {
        if change(&file, &valid.parts, &mut data).is_err() {
            break;
        }
    }
    file.close().expect("it closes");
    seal::seal(&valid.file).expect("a seal");
    go_on(valid);
});
