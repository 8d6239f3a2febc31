//! Frames in the formats of other programs hold what the frames hold. (What other programs make of them: `tests/python/check_export.py`.)

use crate::common::command::{ok, sinew, text, words};
use netcdf3::FileReader;
use sinew::output::snapshot::Snapshot;
use sinew::output::vtkhdf::Reader;
use std::path::{Path, PathBuf};

/// A short run of the quick slab, with tensors of 6 and 9 numbers and particles that have no stress.
fn run(folder: &Path) -> PathBuf {
    let out = folder.join("run");
    let fields = "output.fields=[\"velocity\", \"stress\", \"deformation_gradient\", \"failure\"]";
    let command =
        ["run", "problems/slab-rigid", "-q", "--steps", "4", "--set", "domain.cell=2.5 mm", "--set", fields];
    let output = sinew(&[&command[..], &["--set", "output.frames=2", "--out", text(&out)]].concat());
    assert!(output.status.success(), "{}", words(&output));
    out
}

/// The last frame, in the order of identities.
fn last(run: &Path) -> (usize, Snapshot) {
    let reader = ok(Reader::open(&run.join("particles.vtkhdf")));
    let number = reader.frames() - 1;
    let frame = ok(reader.frame(number));
    let mut order: Vec<usize> = (0..frame.identities.len()).collect();
    order.sort_by_key(|&row| frame.identities[row]);
    let pick = |width: usize, values: &[f32]| -> Vec<f32> {
        order.iter().flat_map(|&row| values[width * row..width * (row + 1)].to_vec()).collect()
    };
    let columns = frame.columns.iter().map(|(f, values)| (f.clone(), pick(f.components, values))).collect();
    let sorted = Snapshot {
        identities: order.iter().map(|&row| frame.identities[row]).collect(),
        materials: order.iter().map(|&row| frame.materials[row]).collect(),
        positions: order.iter().map(|&row| frame.positions[row]).collect(),
        columns,
        ..frame
    };
    (number, sorted)
}

#[track_caller]
fn export(run: &Path, arguments: &[&str]) -> PathBuf {
    let output = sinew(&[&["export", text(run)], arguments].concat());
    assert!(output.status.success(), "{}", words(&output));
    PathBuf::from(String::from_utf8_lossy(&output.stdout).trim())
}

/// The numbers of a text, row by row.
fn table(text: &str, separator: char) -> Vec<Vec<f32>> {
    text.lines().map(|line| line.split(separator).map(|cell| ok(cell.parse())).collect()).collect()
}

/// Rows as the text formats have them: identity, material, position, fields.
fn rows(frame: &Snapshot) -> Vec<Vec<f32>> {
    let row = |i: usize| {
        let head = [frame.identities[i] as f32, frame.materials[i].into()];
        let fields =
            frame.columns.iter().flat_map(|(f, values)| &values[f.components * i..f.components * (i + 1)]);
        head.iter().chain(&frame.positions[i]).chain(fields).copied().collect()
    };
    (0..frame.identities.len()).map(row).collect()
}

/// Bit for bit, but any NaN is like any other.
#[track_caller]
fn same(one: &[Vec<f32>], other: &[Vec<f32>]) {
    assert_eq!(one.len(), other.len());
    for (a, b) in one.iter().zip(other) {
        assert!(
            a.len() == b.len() && a.iter().zip(b).all(|(x, y)| x == y || x.is_nan() && y.is_nan()),
            "{a:?} {b:?}"
        );
    }
}

#[test]
fn text_formats_hold_every_number() {
    let folder = ok(tempfile::tempdir());
    let run = run(folder.path());
    let (number, frame) = last(&run);
    assert!(
        frame.columns.iter().any(|(_, values)| values.iter().any(|x| x.is_nan())),
        "the ball has no stress"
    );

    let list = export(&run, &["--format", "csv", "--frames", "last"]);
    assert_eq!(list, run.join("csv/frames.csv"));
    let times = ok(std::fs::read_to_string(&list));
    assert_eq!(
        times,
        format!("frame,time_s,step,file\n{number},{},{},frame-{number:06}.csv\n", frame.time, frame.step)
    );
    let csv = run.join(format!("csv/frame-{number:06}.csv"));
    let written = ok(std::fs::read_to_string(&csv));
    let (header, body) = written.split_once('\n').expect("a header");
    let tensor = "deformation_gradient_xx,deformation_gradient_xy";
    assert!(
        header.starts_with(&format!("id,material,x,y,z,{tensor}"))
            && header.contains("failure,stress_xx,stress_yy,")
    );
    same(&table(body, ','), &rows(&frame));

    // fields stand as they were asked for, not as the file has them
    let asked = ["--fields", "velocity,failure,deformation_gradient", "--frames", "last"];
    let mut turned = frame.clone();
    let place = |name: &str| asked[1].split(',').position(|field| field == name);
    turned.columns.retain(|(field, _)| place(&field.name).is_some());
    turned.columns.sort_by_key(|(field, _)| place(&field.name));
    assert_ne!(turned.columns[0].0, frame.columns[0].0);
    let here = |name: &str| folder.path().join(name).display().to_string();
    let list = export(&run, &[&["--format", "csv", "--out", &here("turned")], &asked[..]].concat());
    let written = ok(std::fs::read_to_string(list.with_file_name(format!("frame-{number:06}.csv"))));
    let (header, body) = written.split_once('\n').expect("a header");
    assert!(header.starts_with("id,material,x,y,z,velocity_x,velocity_y,velocity_z,failure"), "{header}");
    same(&table(body, ','), &rows(&turned));
    let dump = export(&run, &[&["--format", "lammps", "--out", &here("turned-too")], &asked[..]].concat());
    let written = ok(std::fs::read_to_string(dump));
    let body = written.lines().skip_while(|line| !line.starts_with("ITEM: ATOMS")).skip(1);
    let numbers = |line: &str| line.split(' ').skip(5).map(|cell| ok(cell.parse())).collect();
    same(
        &body.map(numbers).collect::<Vec<Vec<f32>>>(),
        &rows(&turned).into_iter().map(|row| row[5..].to_vec()).collect::<Vec<_>>(),
    );

    let dump = export(&run, &["--format", "lammps", "--out", text(&folder.path().join("elsewhere"))]);
    let written = ok(std::fs::read_to_string(&dump));
    assert!(written.starts_with("ITEM: UNITS\nsi\nITEM: TIME\n"));
    let parts: Vec<&str> = written.split("ITEM: TIME\n").skip(1).collect();
    assert_eq!(parts.len(), number + 1, "all frames");
    let (head, body) = parts[number].split_once("ITEM: ATOMS ").expect("atoms");
    assert!(head.starts_with(&format!("{}\nITEM: TIMESTEP\n{}\n", frame.time, frame.step)), "{head}");
    assert!(head.contains(&format!("ITEM: NUMBER OF ATOMS\n{}\n", frame.identities.len())), "{head}");
    let (names, body) = body.split_once('\n').expect("names");
    assert!(names.starts_with("id type x y z ") && names.ends_with(" vx vy vz"), "{names}");
    same(&table(body, ' '), &rows(&frame));
}

#[test]
fn netcdf_holds_every_number() {
    let folder = ok(tempfile::tempdir());
    let run = run(folder.path());
    let (number, frame) = last(&run);
    let file =
        export(&run, &["--format", "netcdf", "--fields", "velocity,stress,failure", "--frames", "0,last"]);
    let mut reader = FileReader::open(&file).expect("it is NetCDF");
    let conventions = reader.data_set().get_global_attr_as_string("Conventions");
    assert_eq!(conventions.as_deref(), Some("AMBER"));
    let n = frame.identities.len();
    assert_eq!(reader.data_set().dim_size("atom"), Some(n));
    assert_eq!(reader.read_var_f64("time").expect("times")[1], frame.time);
    let record = |reader: &mut FileReader, name: &str| reader.read_record_f32(name, 1).expect("a record");
    assert_eq!(record(&mut reader, "coordinates"), frame.positions.as_flattened());
    let ids: Vec<u64> =
        reader.read_record_i32("id", 1).expect("ids").into_iter().map(|id| id as u64).collect();
    assert_eq!(ids, frame.identities);
    for (field, values) in &frame.columns {
        let name = if field.name == "velocity" { "velocities" } else { &field.name };
        if field.name == "deformation_gradient" {
            assert!(reader.data_set().var_len(name).is_none(), "nobody asked for it");
            continue;
        }
        same(&[record(&mut reader, name)], std::slice::from_ref(values));
    }
    assert!(number > 0);
}

#[test]
fn vtp_refers_to_bytes_that_are_there() {
    let folder = ok(tempfile::tempdir());
    let run = run(folder.path());
    let (number, frame) = last(&run);
    let collection = export(&run, &["--format", "vtp"]);
    let list = ok(std::fs::read_to_string(&collection));
    let list = ok(roxmltree::Document::parse(&list));
    let sets: Vec<_> = list.descendants().filter(|node| node.has_tag_name("DataSet")).collect();
    assert_eq!(sets.len(), number + 1);
    assert_eq!(sets[number].attribute("timestep"), Some(&*frame.time.to_string()));
    let file = collection.with_file_name(sets[number].attribute("file").expect("a file"));
    let bytes = ok(std::fs::read(&file));
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let at = bytes.windows(mark.len()).position(|window| window == mark).expect("bytes") + mark.len();
    let head = format!("{}</AppendedData></VTKFile>", String::from_utf8_lossy(&bytes[..at]));
    let head = ok(roxmltree::Document::parse(&head));
    for (field, values) in &frame.columns {
        let array =
            head.descendants().find(|node| node.attribute("Name") == Some(&field.name)).expect("an array");
        assert_eq!(array.attribute("NumberOfComponents"), Some(&*field.components.to_string()));
        let start = at + ok(array.attribute("offset").expect("a place").parse::<usize>());
        let size = u64::from_le_bytes(bytes[start..start + 8].try_into().expect("eight bytes")) as usize;
        let read: &[u8] = &bytes[start + 8..start + 8 + size];
        assert_eq!(read, bytemuck::cast_slice::<f32, u8>(values), "{}", field.name);
    }
}

#[test]
fn what_cannot_be_exported_is_told() {
    let folder = ok(tempfile::tempdir());
    let run = run(folder.path());
    for (arguments, expected) in [
        (
            &["--format", "vtp", "--fields", "fiber"][..],
            "the frames have no field \"fiber\": they have deformation_gradient",
        ),
        (&["--format", "vtp", "--frames", "7"], "write numbers from 0 to"),
        (&["--format", "ply"], "possible values: vtp, netcdf, lammps, csv"),
        (&["--format", "csv", "--out", text(&run.join("history.csv"))], "history.csv"),
    ] {
        let output = sinew(&[&["export", text(&run)], arguments].concat());
        let said = words(&output);
        assert!(output.status.code() == Some(2) || output.status.code() == Some(1), "{said}");
        assert!(said.contains(expected), "{said}");
    }
    // a frame that is missing is named, with how to go on without it
    ok(std::fs::write(run.join("particles/000001.h5"), "nothing"));
    let output = sinew(&["export", text(&run), "--format", "vtp"]);
    let said = words(&output);
    assert!(
        output.status.code() == Some(1) && said.contains("000001.h5") && said.contains("--frames"),
        "{said}"
    );
    export(&run, &["--format", "vtp", "--frames", "0"]);
    let output = sinew(&["export", text(folder.path()), "--format", "vtp"]);
    assert!(
        output.status.code() == Some(2) && words(&output).contains("holds no particles.vtkhdf"),
        "{}",
        words(&output)
    );
}
