//! `particles.vtkhdf`: what is written is read back, by us and by VTK.
#![allow(clippy::unwrap_used, missing_docs)]

mod damaged;
mod parts;
#[path = "../common/unlocked.rs"]
mod unlocked;

use sinew::output::compare::frame_particles;
use sinew::output::frame::{Columns, Field, Frame, Head, Piece};
use sinew::output::run_id::RunId;
use sinew::output::snapshot::Snapshot;
use sinew::output::vtkhdf;
use sinew::output::vtkhdf::{FileId, Found, PartFile, Reader};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Whose frames most of these are.
fn run() -> RunId {
    RunId::default()
}

fn resume(path: &Path, frames: u64) -> sinew::output::Result<(Writer, Vec<String>)> {
    let (index, warnings) = vtkhdf::Writer::resume(path, Found::look(path, run(), frames)?)?;
    Ok((Writer { path: path.into(), run: run(), writing: RunId::new(), index, next: frames }, warnings))
}

/// Writes frames as the ranks of a run do, one after the other.
#[derive(Debug)]
struct Writer {
    path: PathBuf,
    run: RunId,
    writing: RunId,
    index: vtkhdf::Writer,
    next: u64,
}

impl Writer {
    fn create(path: &Path, run: RunId) -> sinew::output::Result<Self> {
        let index = vtkhdf::Writer::create(path, run)?;
        Ok(Self { path: path.into(), run, writing: RunId::new(), index, next: 0 })
    }

    fn append(&mut self, frame: &Snapshot) -> sinew::output::Result<()> {
        self.append_as(&[frame.particles()], Vec::new(), frame)
    }

    /// A frame in parts of so many rows.
    fn append_as(
        &mut self,
        rows: &[usize],
        materials: Vec<String>,
        frame: &Snapshot,
    ) -> sinew::output::Result<()> {
        assert_eq!(rows.iter().sum::<usize>(), frame.particles());
        let (fields, number) = (frame.fields(), self.next);
        self.next += 1;
        let columns = Columns { fields, materials };
        self.index.admits(&columns)?;
        let head = Head { time: frame.time, step: frame.step, particles: frame.particles(), columns };
        let (mut parts, mut first) = (Vec::new(), 0);
        for (id, &count) in FileId::of_frame(number, rows.len()).zip(rows) {
            let head = Head { particles: count, ..head.clone() };
            let mut file = PartFile::create(&self.path, id, [self.run, self.writing], head)?;
            file.piece(&piece(frame, first..first + count))?;
            parts.push(file.finish()?);
            first += count;
        }
        self.index.add(number, head, parts);
        self.index.name_soon()
    }

    fn sync(&mut self) -> sinew::output::Result<()> {
        self.index.sync()
    }

    fn frames(&self) -> u64 {
        self.next
    }
}

/// Rows of a frame.
fn piece(frame: &Snapshot, rows: std::ops::Range<usize>) -> Piece {
    let of = |(field, values): &(Field, Vec<f32>)| {
        values[rows.start * field.components..rows.end * field.components].to_vec()
    };
    Piece {
        identities: frame.identities[rows.clone()].to_vec(),
        materials: frame.materials[rows.clone()].to_vec(),
        positions: frame.positions[rows.clone()].to_vec(),
        columns: frame.columns.iter().map(of).collect(),
    }
}

fn field(name: &str, unit: &str, components: usize) -> Field {
    Field { name: name.into(), unit: unit.into(), components, ..Field::default() }
}

/// `n` particles whose numbers tell frame, particle and component.
fn snapshot(k: u64, n: usize) -> Snapshot {
    let value = |i: usize, c: usize| (k as f32) + 0.001 * i as f32 + 0.1 * c as f32;
    let column = |components: usize| {
        (0..n * components).map(|j| value(j / components, j % components)).collect::<Vec<_>>()
    };
    Snapshot {
        time: 1e-3 * k as f64,
        step: 10 * k,
        identities: (0..n as u64).map(|i| (1 << 40) + 7 * i).collect(),
        materials: (0..n).map(|i| [0, 255, 256, 300, u16::MAX][i % 5]).collect(),
        positions: (0..n).map(|i| [value(i, 0), value(i, 1), value(i, 2)]).collect(),
        columns: vec![
            (field("failure", "1", 1), column(1)),
            (field("stress", "Pa", 6), column(6)),
            (field("velocity", "m/s", 3), column(3)),
        ],
    }
}

fn write(path: &Path, counts: &[usize]) -> Vec<Snapshot> {
    write_as(run(), path, counts)
}

fn write_as(run: RunId, path: &Path, counts: &[usize]) -> Vec<Snapshot> {
    let frames: Vec<_> = counts.iter().enumerate().map(|(k, &n)| snapshot(k as u64, n)).collect();
    let mut writer = Writer::create(path, run).unwrap();
    for frame in &frames {
        writer.append(frame).unwrap();
    }
    frames
}

fn check_with_vtk(path: &Path) {
    let has_vtk = Command::new("python3").args(["-c", "import vtk, h5py"]).output();
    if !has_vtk.is_ok_and(|o| o.status.success()) {
        eprintln!("skipped: needs python3 with vtk and h5py");
        return;
    }
    let out = Command::new("python3").arg("tests/python/check_vtkhdf.py").arg(path).output().unwrap();
    assert!(out.status.success(), "{}{}", text(&out.stdout), text(&out.stderr));
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into()
}

#[test]
fn frames_come_back_also_when_particles_vanish_or_come() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    let frames = write(&path, &[7, 5, 5, 9]);
    let reader = Reader::open(&path).unwrap();
    assert_eq!(reader.frames(), 4);
    for (k, frame) in frames.iter().enumerate() {
        assert_eq!(&reader.frame(k).unwrap(), frame);
    }
    let only = reader.frame_with(3, &["velocity", "no such field"]).unwrap();
    assert_eq!(only.columns, frames[3].columns[2..]);
    assert!(reader.frame(4).unwrap_err().to_string().contains("no frame 4"));
    check_with_vtk(&path);
}

#[test]
fn frames_longer_than_a_chunk_and_a_single_particle() {
    let folder = tempfile::tempdir().unwrap();
    for counts in [&[150_000, 149_999][..], &[1, 1], &[0, 0]] {
        let path = folder.path().join(format!("{}.vtkhdf", counts[0]));
        let frames = write(&path, counts);
        let reader = Reader::open(&path).unwrap();
        assert!((0..2).all(|k| reader.frame(k).unwrap() == frames[k]));
        check_with_vtk(&path);
    }
}

#[test]
fn the_file_is_readable_after_every_append() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    let mut writer = Writer::create(&path, run()).unwrap();
    assert_eq!(Reader::open(&path).unwrap().frames(), 0);
    for k in 0..3 {
        let frame = snapshot(k, 6 - k as usize);
        writer.append(&frame).unwrap();
        let reader = Reader::open(&path).unwrap();
        assert_eq!(reader.frames(), k as usize + 1);
        assert_eq!(reader.frame(k as usize).unwrap(), frame);
        check_with_vtk(&path);
    }
}

/// The index of many frames is long: it is not written after each of them, and has all when the disk is to have them.
#[test]
fn many_frames_are_named_when_the_disk_has_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    let mut writer = Writer::create(&path, run()).unwrap();
    (0..200).for_each(|k| writer.append(&snapshot(k, 3)).unwrap());
    let named = Reader::open(&path).unwrap().frames();
    assert!((64..=200).contains(&named), "{named}");
    writer.sync().unwrap();
    let reader = Reader::open(&path).unwrap();
    assert_eq!((reader.frames(), reader.frame(199).unwrap()), (200, snapshot(199, 3)));
    // a run that was killed has named too few: the frames that a checkpoint counts are named by then
    writer.append(&snapshot(200, 3)).unwrap();
    drop(writer);
    let (writer, warnings) = resume(&path, 200).unwrap();
    assert_eq!((writer.frames(), warnings), (200, Vec::new()));
    assert_eq!(Reader::open(&path).unwrap().frames(), 200);
}

#[test]
fn a_restart_goes_on_after_the_frames_it_knows() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    write(&path, &[7, 6, 5]);
    let (mut writer, warnings) = resume(&path, 2).unwrap();
    assert_eq!((writer.frames(), warnings), (2, Vec::new()));
    assert!(!frame_file(&path, 2).exists());
    writer.append(&snapshot(8, 4)).unwrap();
    let reader = Reader::open(&path).unwrap();
    assert_eq!(reader.times(), [0.0, 1e-3, 8e-3]);
    assert_eq!(reader.frame(1).unwrap(), snapshot(1, 6));
    assert_eq!(reader.frame(2).unwrap(), snapshot(8, 4));
    check_with_vtk(&path);
}

#[test]
fn any_material_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    write(&path, &[9, 9]);
    let frame = Reader::open(&path).unwrap().frame(1).unwrap();
    assert_eq!(frame.materials[..5], [0, 255, 256, 300, 65_535]);
    assert_eq!(frame_particles(frame).materials[3], 300);
    check_with_vtk(&path);
}

/// As many names as a scene can have, and what fields are, are in the index and in each frame.
#[test]
fn what_columns_are_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    for count in [0, 1, 4000, 4001, 65_536] {
        let materials: Vec<String> = (0..count).map(|i| format!("material-{i}")).collect();
        let (meaning, codes) =
            ("what has failed, λ".into(), vec!["intact".into(), "both failed, or not".into()]);
        let fields = vec![Field { meaning, codes, ..field("failure", "1", 1) }, field("a", "m/s", 3)];
        let columns = Columns { fields, materials: materials.clone() };
        let mut writer = Writer::create(&path, run()).unwrap();
        let values = columns.fields.iter().cloned().zip([vec![1.0], vec![2.0; 3]]).collect();
        let one = Snapshot { columns: values, ..snapshot(0, 1) };
        writer.append_as(&[1], materials.clone(), &one).unwrap();
        let reader = Reader::open(&path).unwrap();
        assert_eq!((reader.fields(), reader.materials()), (&*columns.sorted().fields, &*materials));
        // made anew of the frames
        std::fs::remove_file(&path).unwrap();
        drop(resume(&path, 1).unwrap());
        assert_eq!(Reader::open(&path).unwrap().materials(), materials);
    }
}

/// What a frame of one file is called.
fn frame_file(index: &Path, number: u64) -> PathBuf {
    index.with_file_name("particles").join(format!("{number:06}.h5"))
}

#[test]
fn errors_name_the_file_and_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("no/particles.vtkhdf");
    let message = Writer::create(&missing, run()).unwrap_err().to_string();
    assert!(message.contains("cannot create") && message.contains("no/particles"), "{message}");
    assert!(Reader::open(&missing).unwrap_err().to_string().contains("is not there"));

    let other = folder.path().join("other.vtkhdf");
    std::fs::write(&other, "not HDF5").unwrap();
    assert!(Reader::open(&other).unwrap_err().to_string().contains("other.vtkhdf"));

    let mut writer = Writer::create(&other, run()).unwrap();
    writer.append(&snapshot(0, 3)).unwrap();
    let mut changed = snapshot(1, 3);
    changed.columns.pop();
    assert!(writer.append(&changed).unwrap_err().to_string().contains("[failure, stress]"));
    assert_eq!(Reader::open(&other).unwrap().frames(), 1);
}

/// Runs itself once more under a shell that lets no file grow beyond 400 kB.
#[test]
fn a_full_disk_is_an_error_and_earlier_frames_stay() {
    if let Ok(path) = std::env::var("SINEW_TEST_FULL_DISK") {
        let mut writer = Writer::create(Path::new(&path), run()).unwrap();
        let failure = (0..1000).find_map(|k| writer.append(&snapshot(k, 2_000 + 1_000 * k as usize)).err());
        println!("error: {}", failure.unwrap());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    let name = "a_full_disk_is_an_error_and_earlier_frames_stay";
    let out = Command::new("bash")
        .args(["-c", "ulimit -f 400; trap '' XFSZ; exec \"$0\" --exact \"$1\" --nocapture"])
        .arg(std::env::current_exe().unwrap())
        .arg(name)
        .env("SINEW_TEST_FULL_DISK", &path)
        .output()
        .unwrap();
    let said = text(&out.stdout) + &text(&out.stderr);
    assert!(out.status.success(), "{said}");
    assert!(said.contains("error: cannot write"), "{said}");
    assert!(said.contains("free some space"), "{said}");
    let reader = Reader::open(&path).unwrap();
    assert!(reader.frames() > 0);
    let last = reader.frames() - 1;
    assert_eq!(reader.frame(last).unwrap(), snapshot(last as u64, 2_000 + 1_000 * last));
}

/// `cargo test --release --test output_vtkhdf -- --ignored --nocapture` prints what a frame of the slab costs.
#[test]
#[ignore = "measures"]
fn cost_of_a_large_frame() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    let mut frame = snapshot(1, 1_600_000);
    // Noise in the low bits, as real columns have.
    let mut noise = 1u32;
    let numbers = frame.columns.iter_mut().flat_map(|c| &mut c.1);
    for x in numbers.chain(frame.positions.as_flattened_mut()) {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *x *= 1.0 + noise as f32 / u32::MAX as f32;
    }
    let mut writer = Writer::create(&path, run()).unwrap();
    for k in 0..3 {
        let start = std::time::Instant::now();
        writer.append(&frame).unwrap();
        let size = std::fs::metadata(frame_file(&path, k)).unwrap().len();
        println!("frame {k}: {:.2} s, file {:.0} MB", start.elapsed().as_secs_f64(), size as f64 * 1e-6);
    }
}
