//! Frames that several ranks have written, a file each.
use crate::unlocked::unlocked;
use crate::*;

/// Frames in parts: of three ranks, of two after a restart on fewer, of one of which the others have nothing, of one alone.
const ROWS: [&[usize]; 4] = [&[4, 2, 7], &[6, 5], &[3], &[70_000, 1]];

fn write_parts(path: &Path) -> Vec<Snapshot> {
    let mut writer = Writer::create(path, run()).unwrap();
    let rows = |rows: &[usize]| rows.iter().sum();
    let frames: Vec<_> = (0..).zip(ROWS).map(|(k, parts)| snapshot(k, rows(parts))).collect();
    frames.iter().zip(ROWS).for_each(|(frame, parts)| writer.append_as(parts, Vec::new(), frame).unwrap());
    writer.sync().unwrap();
    frames
}

fn part(index: &Path, number: u64, part: usize, parts: usize) -> PathBuf {
    FileId { number, parts, part }.path(index)
}

fn copy(from: &Path, to: &Path) {
    std::fs::copy(from, to).unwrap();
}

fn set_aside(file: &Path) -> bool {
    !file.exists() && file.with_added_extension("damaged").exists()
}

#[test]
fn parts_are_read_as_one_frame_also_where_their_number_changes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    let frames = write_parts(&path);
    let reader = Reader::open(&path).unwrap();
    assert_eq!(reader.frames(), 4);
    assert!(
        (0..4).all(|k| reader.frame(k).unwrap() == frames[k] && reader.particles(k) == frames[k].particles())
    );
    let only = reader.frame_with(0, &["velocity"]).unwrap();
    assert_eq!(only.columns, frames[0].columns[2..]);
    check_with_vtk(&path);
    // a restart on another number of ranks drops what is later, whoever wrote it, and goes on
    std::fs::write(part(&path, 3, 1, 2).with_added_extension("part"), b"half").unwrap();
    std::fs::write(part(&path, 9, 4, 7), b"of long ago").unwrap();
    std::fs::write(folder.path().join("particles/00.token"), b"").unwrap();
    let (mut writer, warnings) = resume(&path, 2).unwrap();
    assert_eq!(warnings, Vec::<String>::new());
    let left = std::fs::read_dir(folder.path().join("particles")).unwrap();
    let mut left: Vec<_> = left.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    left.sort();
    let parts = ["000000-1of3.h5", "000000-2of3.h5", "000000-3of3.h5", "000001-1of2.h5", "000001-2of2.h5"];
    assert_eq!(left, [&parts[..], &["cells.h5"]].concat());
    writer.append(&snapshot(5, 9)).unwrap();
    writer.append_as(&[1, 1, 1, 1, 5], Vec::new(), &snapshot(6, 9)).unwrap();
    let reader = Reader::open(&path).unwrap();
    let all = [frames[0].clone(), frames[1].clone(), snapshot(5, 9), snapshot(6, 9)];
    assert!((0..4).all(|k| reader.frame(k).unwrap() == all[k]));
    check_with_vtk(&path);
}

#[test]
fn a_part_that_is_damaged_missing_or_another_run_s_is_told_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let [path, other] = ["one/particles.vtkhdf", "other/particles.vtkhdf"].map(|p| folder.path().join(p));
    [&path, &other].iter().for_each(|path| std::fs::create_dir(path.parent().unwrap()).unwrap());
    let mut theirs = Writer::create(&other, RunId::new()).unwrap();
    theirs.append_as(ROWS[0], Vec::new(), &snapshot(0, 13)).unwrap();
    type Harm<'a> = (&'a dyn Fn(&Path), &'a str, bool);
    let harms: [Harm; 4] = [
        (
            &|file| {
                let mut bytes = std::fs::read(file).unwrap();
                bytes[3000] ^= 4;
                std::fs::write(file, bytes).unwrap();
            },
            "it is damaged",
            true,
        ),
        (&|file| std::fs::remove_file(file).unwrap(), "No such file", false),
        (&|file| copy(&part(&other, 0, 1, 3), file), "another run", true),
        (&|file| copy(&part(&path, 0, 0, 3), file), "another", true),
    ];
    for (harm, fact, aside) in harms {
        let frames = write_parts(&path);
        let file = part(&path, 0, 1, 3);
        harm(&file);
        let said = Reader::open(&path).unwrap().frame(0).unwrap_err().to_string();
        assert!(said.contains("000000-2of3.h5") && said.contains(fact), "{said}");
        assert_eq!(Reader::open(&path).unwrap().frame(1).unwrap(), frames[1], "the others stay");
        // a flipped byte that a restart does not read it need not find: the index goes, so that it looks
        std::fs::remove_file(&path).unwrap();
        let (_, warnings) = resume(&path, 4).unwrap();
        let words = warnings.join(" ");
        if aside {
            assert!(words.contains("000000-2of3.h5") && words.contains(fact) && set_aside(&file), "{words}");
        } else {
            assert!(words.contains("1 of its 4 frames are missing"), "{words}");
        }
        let reader = Reader::open(&path).unwrap();
        assert!(reader.frames() == 3 && (0..3).all(|k| reader.frame(k).unwrap() == frames[k + 1]));
        check_with_vtk(&path);
        // it was told, and is not told again
        assert_eq!(resume(&path, 4).unwrap().1, Vec::<String>::new(), "{fact}");
        let _ = std::fs::remove_file(file.with_added_extension("damaged"));
    }
    // of a frame that the index names it is told at once
    let frames = write_parts(&path);
    std::fs::remove_file(part(&path, 1, 1, 2)).unwrap();
    let (_, warnings) = resume(&path, 4).unwrap();
    assert!(warnings.len() == 1 && warnings[0].contains("000001-2of2.h5"), "{warnings:?}");
    let reader = Reader::open(&path).unwrap();
    assert!([0, 2, 3].iter().enumerate().all(|(k, &of)| reader.frame(k).unwrap() == frames[of]));
}

/// Files of one run that were written at other times: a backup that was put back in part.
#[test]
fn parts_that_were_not_written_together_make_no_frame() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    let old = folder.path().join("old");
    write_parts(&path);
    std::fs::copy(part(&path, 0, 1, 3), &old).unwrap();
    // the same particles in the same places, by another start of the run
    let frames = write_parts(&path);
    std::fs::copy(&old, part(&path, 0, 1, 3)).unwrap();
    assert!(Reader::open(&path).unwrap().frame(0).is_err());
    let (_, warnings) = resume(&path, 4).unwrap();
    let said = warnings.join(" ");
    assert!(said.contains("000000-2of3.h5: it is no part of the frame that 000000-1of3.h5 is of"), "{said}");
    let reader = Reader::open(&path).unwrap();
    assert!(reader.frames() == 3 && (0..3).all(|k| reader.frame(k).unwrap() == frames[k + 1]));
}

/// No byte of a part can change unnoticed, nor where it ends.
#[test]
fn no_byte_of_a_part_can_change_unnoticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    write_parts(&path);
    let file = part(&path, 1, 1, 2);
    let whole = std::fs::read(&file).unwrap();
    for at in (0..whole.len()).step_by(23).chain(whole.len() - 40..whole.len()) {
        let mut bytes = whole.clone();
        bytes[at] ^= 1 << (at % 8);
        std::fs::write(&file, &bytes).unwrap();
        let said = Reader::open(&path).and_then(|reader| reader.frame(1)).unwrap_err().to_string();
        assert!(said.contains("000001-2of2.h5"), "byte {at}: {said}");
    }
}

/// Runs that began before frames could have parts go on.
#[test]
fn an_index_of_old_says_nothing_of_parts() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    let frames = write(&path, &[3, 5]);
    let craft = |act: &dyn Fn(&hdf5::File)| {
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 32]).unwrap();
        let file = unlocked().open_rw(&path).unwrap();
        act(&file);
        file.close().unwrap();
        sinew::output::seal::seal(&path).unwrap();
    };
    craft(&|file| {
        ["FileParts", "FileParticles"]
            .iter()
            .for_each(|n| file.unlink(&format!("VTKHDF/Steps/{n}")).unwrap());
    });
    let reader = Reader::open(&path).unwrap();
    assert!((0..2).all(|k| reader.frame(k).unwrap() == frames[k]));
    assert_eq!(resume(&path, 2).unwrap().1, Vec::<String>::new());
    // files that do not fit their frames
    for parts in [[1u64, 2], [0, 2], [2, 0], [1, u64::MAX], [1, 0]] {
        write(&path, &[3, 5]);
        craft(&|file| file.dataset("VTKHDF/Steps/FileParts").unwrap().write(&parts).unwrap());
        let said = Reader::open(&path).unwrap_err().to_string();
        assert!(said.contains("do not fit"), "{parts:?}: {said}");
    }
}
