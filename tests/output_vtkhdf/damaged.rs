//! Frames and an index that are damaged, lost, another run's, or made by somebody else.
use crate::unlocked::unlocked;
use crate::*;

#[test]
fn a_damaged_a_missing_and_a_foreign_frame_are_one_frame_each() {
    let folder = tempfile::tempdir().unwrap();
    let [path, other] = ["one/particles.vtkhdf", "other/particles.vtkhdf"].map(|p| folder.path().join(p));
    [&path, &other].iter().for_each(|path| std::fs::create_dir(path.parent().unwrap()).unwrap());
    let frames = write(&path, &[7, 6, 5, 4, 3]);
    write_as(RunId::new(), &other, &[2, 3]);
    let damaged = frame_file(&path, 3);
    let mut bytes = std::fs::read(&damaged).unwrap();
    bytes[2000] ^= 1;
    std::fs::write(&damaged, bytes).unwrap();
    std::fs::remove_file(frame_file(&path, 2)).unwrap();
    std::fs::copy(frame_file(&other, 1), frame_file(&path, 1)).unwrap();
    let reader = Reader::open(&path).unwrap();
    for (k, fact) in [(1, "another run"), (2, "000002.h5"), (3, "damaged")] {
        let said = reader.frame(k).unwrap_err().to_string();
        assert!(said.contains(fact), "{said}");
    }
    assert_eq!((reader.frame(0).unwrap(), reader.frame(4).unwrap()), (frames[0].clone(), frames[4].clone()));
    // a restart leaves out what cannot be one of its frames; what it does not read it need not check
    let (mut writer, warnings) = resume(&path, 5).unwrap();
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(frame_file(&path, 1).with_added_extension("damaged").exists());
    writer.append(&snapshot(9, 4)).unwrap();
    let reader = Reader::open(&path).unwrap();
    assert_eq!(reader.times(), [0, 3, 4, 9].map(|k| snapshot(k, 1).time));
    assert_eq!(reader.frame(3).unwrap(), snapshot(9, 4));
}

#[test]
fn an_index_that_is_lost_is_made_anew_of_the_frames() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    for lost in [true, false] {
        let frames = write(&path, &[7, 6, 5]);
        if lost {
            std::fs::remove_file(&path).unwrap();
        } else {
            std::fs::write(&path, b"nothing").unwrap();
        }
        assert!(Reader::open(&path).is_err());
        let (_, warnings) = resume(&path, 3).unwrap();
        assert!(warnings.len() == 1 && warnings[0].contains("made anew of its frames"), "{warnings:?}");
        let reader = Reader::open(&path).unwrap();
        assert!((0..3).all(|k| reader.frame(k).unwrap() == frames[k]));
        check_with_vtk(&path);
    }
}

/// Files of two runs in one folder: a copy that went wrong, a backup that was put back.
#[test]
fn what_another_run_wrote_is_not_taken_for_a_frame_of_this_one() {
    let folder = tempfile::tempdir().unwrap();
    let [path, other] = ["one/particles.vtkhdf", "other/particles.vtkhdf"].map(|p| folder.path().join(p));
    [&path, &other].iter().for_each(|path| std::fs::create_dir(path.parent().unwrap()).unwrap());
    write_as(RunId::new(), &other, &[3, 3, 3]);
    let names = |frames: &Reader| frames.times().iter().map(|t| (1e3 * t).round() as u64).collect::<Vec<_>>();
    // their index, over frames of this run: those are whole, and stay
    let frames = write(&path, &[7, 6, 5]);
    std::fs::copy(&other, &path).unwrap();
    assert!(Reader::open(&path).unwrap().frame(1).is_err());
    let (_, warnings) = resume(&path, 3).unwrap();
    assert!(warnings.len() == 1 && warnings[0].contains("index of another run"), "{warnings:?}");
    let reader = Reader::open(&path).unwrap();
    assert!(names(&reader) == [0, 1, 2] && (0..3).all(|k| reader.frame(k).unwrap() == frames[k]));
    // their index and a frame that goes with it
    std::fs::copy(&other, &path).unwrap();
    std::fs::copy(frame_file(&other, 1), frame_file(&path, 1)).unwrap();
    let (_, warnings) = resume(&path, 3).unwrap();
    assert!(warnings.len() == 2 && warnings[1].contains("frame of another run"), "{warnings:?}");
    assert_eq!(names(&Reader::open(&path).unwrap()), [0, 2]);
    assert!(frame_file(&path, 1).with_added_extension("damaged").exists());
    // a frame of this run that the index does not know
    write(&path, &[7, 6, 5]);
    let old = std::fs::read(frame_file(&path, 1)).unwrap();
    let mut writer = Writer::create(&path, run()).unwrap();
    (0..3).for_each(|k| writer.append(&snapshot(10 * k, 4)).unwrap());
    std::fs::write(frame_file(&path, 1), old).unwrap();
    let (_, warnings) = resume(&path, 3).unwrap();
    assert!(warnings.len() == 1 && warnings[0].contains("is of this run"), "{warnings:?}");
    assert_eq!(names(&Reader::open(&path).unwrap()), [0, 1, 20]);
    // one that is not later than the frame before it
    std::fs::copy(frame_file(&path, 0), frame_file(&path, 2)).unwrap();
    std::fs::remove_file(&path).unwrap();
    let (_, warnings) = resume(&path, 3).unwrap();
    assert!(warnings.len() == 2 && warnings[1].contains("not later"), "{warnings:?}");
    // and one that is nowhere
    std::fs::remove_file(&path).unwrap();
    std::fs::remove_file(frame_file(&path, 1)).unwrap();
    let (_, warnings) = resume(&path, 3).unwrap();
    assert!(warnings.len() == 2 && warnings[1].contains("2 of its 3 frames are missing"), "{warnings:?}");
}

/// HDF5 may crash on a file of which a byte is not what it was: no such file reaches it.
#[test]
fn no_byte_can_change_unnoticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    write(&path, &[3, 2]);
    for file in [path.clone(), frame_file(&path, 1)] {
        let whole = std::fs::read(&file).unwrap();
        for at in (0..whole.len()).step_by(7).chain(whole.len() - 40..whole.len()) {
            let mut bytes = whole.clone();
            bytes[at] ^= 1 << (at % 8);
            std::fs::write(&file, &bytes).unwrap();
            let read = Reader::open(&path).and_then(|reader| reader.frame(1));
            assert!(read.is_err(), "byte {at} of {}", file.display());
        }
        for length in [0, 1, 31, 32, whole.len() / 2, whole.len() - 1] {
            std::fs::write(&file, &whole[..length]).unwrap();
            assert!(Reader::open(&path).and_then(|reader| reader.frame(1)).is_err(), "{length} bytes");
        }
        std::fs::write(&file, whole).unwrap();
        assert!(Reader::open(&path).unwrap().frame(1).is_ok());
    }
}

/// Files with a good seal that Sinew has not written: others know how to seal, too.
#[test]
fn crafted_frames_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    write(&path, &[4, 4]);
    let secret = folder.path().join("secret");
    std::fs::write(&secret, [0u8; 64]).unwrap();
    let good = frame_file(&path, 0);
    type Craft = fn(&hdf5::File, &Path) -> hdf5::Result<()>;
    let crafts: [(Craft, &str); 6] = [
        (|file, _| file.unlink("Points"), "Points"),
        (
            |file, _| file.unlink("Points").and_then(|()| file.link_soft("PointData/id", "Points")),
            "another place",
        ),
        (
            |file, _| {
                let good = file.filename().replace("000000.h5", "000001.h5");
                file.unlink("Points").and_then(|()| file.link_external(&good, "Points", "Points"))
            },
            "another place",
        ),
        (
            |file, secret| {
                file.unlink("Points")?;
                let made = file.new_dataset::<f32>().external(secret.to_str().unwrap(), 0, 48);
                made.shape((4, 3)).create("Points").map(drop)
            },
            "another place",
        ),
        (
            |file, _| {
                file.unlink("Points")?;
                file.new_dataset::<f32>().shape((5, 3)).create("Points").map(drop)
            },
            "shape",
        ),
        (
            |file, _| {
                file.unlink("PointData/id")?;
                let text = file.new_dataset::<hdf5::types::FixedAscii<8>>();
                text.shape(4).create("PointData/id").map(drop)
            },
            "not a frame",
        ),
    ];
    for (craft, fact) in crafts {
        write(&path, &[4, 4]);
        let bytes = std::fs::read(&good).unwrap();
        std::fs::write(&good, &bytes[..bytes.len() - 32]).unwrap();
        let file = unlocked().open_rw(&good).unwrap();
        craft(&file, &secret).unwrap();
        file.close().unwrap();
        sinew::output::seal::seal(&good).unwrap();
        // the index does not name it
        let said = Reader::open(&path).and_then(|reader| reader.frame(0)).unwrap_err().to_string();
        assert!(said.contains("another run"), "{said}");
        // one that is made of the frames leaves it out, or it cannot be read
        std::fs::remove_file(&path).unwrap();
        let (_, warnings) = resume(&path, 2).unwrap();
        let reader = Reader::open(&path).unwrap();
        let said = match reader.frames() {
            1 => warnings.join(" "),
            _ => reader.frame(0).unwrap_err().to_string(),
        };
        assert!(said.contains(fact), "{fact}: {said}");
        assert_eq!(reader.frame(reader.frames() - 1).unwrap(), snapshot(1, 4));
    }
}
