//! Checkpoints with a good seal whose numbers no run would write.
use crate::*;
use hdf5::types::{IntSize, TypeDescriptor};
use hdf5::{File, H5Type};

fn cloud() -> Scene {
    laid_out(scene(CLOUD, &[]), LAYOUTS[0])
}

/// A checkpoint of the cloud after two steps, without its seal.
fn unsealed() -> Vec<u8> {
    let folder = folder();
    let mut bytes = ok(std::fs::read(stopped(cloud(), LAYOUTS[0], 2, folder.path())));
    bytes.truncate(bytes.len() - sinew::output::seal::LENGTH as usize);
    bytes
}

/// Restores the cloud from a checkpoint that `change` has changed, and takes a step.
fn restored_from(unsealed: &[u8], change: impl Fn(&File)) -> Result<bool, RunError> {
    let folder = folder();
    let path = checkpoint::path(folder.path(), 2);
    ok(std::fs::write(&path, unsealed));
    let file = ok(unlocked().open_rw(&path));
    change(&file);
    ok(file.close());
    ok(sinew::output::seal::seal(&path));
    Simulation::restore(Box::new(Alone), cloud(), Isa::detect(), &Reader::open(&path)?)?.step()
}

#[track_caller]
fn refused(change: impl Fn(&File), facts: &[&str]) {
    let error = restored_from(&unsealed(), change).map(drop).expect_err("it is refused").to_string();
    assert!(facts.iter().all(|fact| error.contains(fact)), "{error}");
}

/// Changes all numbers of a dataset.
fn numbers<T: H5Type + Copy>(file: &File, name: &str, change: impl Fn(&mut [T])) {
    let dataset = ok(file.dataset(name));
    let mut values = ok(dataset.read_raw::<T>());
    change(&mut values);
    ok(dataset.write_raw(&values));
}

#[test]
fn what_claims_to_be_larger_than_the_file_is_not_read() {
    for name in ["ledger", "shared/Time", "materials/0/block_index", "materials/0/particles/Position"] {
        for shape in [[1 << 40, 3], [1 << 60, 1]] {
            refused(
                |file| {
                    ok(file.unlink(name));
                    ok(file.new_dataset::<f64>().chunk((1024, 1)).shape(shape).create(name));
                },
                &["checkpoint-00000002.h5"],
            );
        }
    }
}

#[test]
fn a_block_that_is_there_twice_is_refused() {
    let twice = |values: &mut [i32]| values.copy_within(0..3, 3);
    refused(|file| numbers(file, "materials/0/block_index", twice), &["its blocks of a do not fit"]);
}

/// A byte that is neither true nor false.
#[test]
fn a_flag_may_have_any_byte() {
    let folder = folder();
    let mut simulation = ok(Simulation::new(cloud(), Isa::detect()));
    let mut bytes = |last| {
        let recorded = Recorded { last: [last, false], ..Recorded::default() };
        ok(simulation.write_checkpoint(folder.path(), recorded));
        ok(std::fs::read(checkpoint::path(folder.path(), 0)))
    };
    let [mut one, other] = [true, false].map(&mut bytes);
    one.truncate(one.len() - sinew::output::seal::LENGTH as usize);
    let differ: Vec<usize> = (0..one.len()).filter(|&at| one[at] != other[at]).collect();
    let [at] = differ[..] else { panic!("{differ:?} differ") };
    one[at] = 2;
    let path = checkpoint::path(folder.path(), 0);
    ok(std::fs::write(&path, &one));
    ok(sinew::output::seal::seal(&path));
    assert_eq!(ok(Reader::open(&path)).head.recorded.last, [true, false]);
}

/// Tasks find nodes by where a particle is in its block.
#[test]
fn particles_that_are_not_near_their_block_are_refused() {
    let facts = &["has particles that are not near it"];
    refused(|file| numbers(file, "materials/0/block_index", |all: &mut [i32]| all.rotate_left(3)), facts);
    refused(|file| numbers(file, "materials/0/block_extent", |all: &mut [f64]| all.fill(-1e300)), facts);
    refused(|file| numbers(file, "materials/1/particles/Position", |all: &mut [f64]| all[0] += 7.0), facts);
}

/// Whatever numbers a checkpoint has, a restart tells what is wrong or goes on.
#[test]
fn no_number_of_a_checkpoint_makes_a_restart_panic() {
    let bytes = unsealed();
    let folder = folder();
    let path = folder.path().join("unsealed.h5");
    ok(std::fs::write(&path, &bytes));
    let mut names = Vec::new();
    let file = ok(unlocked().open(&path));
    datasets(&file, "", &mut names);
    drop(file);
    let bits = [f64::NAN, f64::INFINITY, -1e300, 0.0].map(f64::to_bits);
    for name in names.iter().filter(|name| !["scene", "warnings"].contains(&name.as_str())) {
        for bits in bits.into_iter().chain([u64::MAX, 1 << 31]) {
            for all in [true, false] {
                let result = restored_from(&bytes, |file| overwrite(file, name, bits, all));
                println!(
                    "{name} {bits:x} {all}: {}",
                    result.map_or_else(|error| error.to_string(), |_| "goes on".into())
                );
            }
        }
    }
}

/// Sets all numbers of a dataset, or the first.
fn overwrite(file: &File, name: &str, bits: u64, all: bool) {
    fn fill<T: H5Type + Copy>(file: &File, name: &str, value: T, all: bool) {
        let count = if all { usize::MAX } else { 1 };
        numbers(file, name, |values: &mut [T]| values.iter_mut().take(count).for_each(|it| *it = value));
    }
    match ok(ok(ok(file.dataset(name)).dtype()).to_descriptor()) {
        TypeDescriptor::Float(_) => fill(file, name, f64::from_bits(bits), all),
        TypeDescriptor::Integer(_) => fill(file, name, bits as i32, all),
        TypeDescriptor::Unsigned(IntSize::U4) => fill(file, name, bits as u32, all),
        _ => fill(file, name, bits, all),
    }
}

/// Whatever a header says, `sinew run --restart` ends in good order.
#[test]
fn no_header_makes_a_restart_panic() {
    let folder = folder();
    let [good, again] = ["good", "again"].map(|name| folder.path().join(name));
    let set = ["--set", "domain.cell=4 mm", "--set", "output.frames=200", "--threads", "1", "-q"];
    let begin = ["run", "problems/two-spheres", "--steps", "2", "--out", text(&good)];
    let output = sinew(&[&begin[..], &set].concat());
    assert!(output.status.success(), "{}", words(&output));
    let path = checkpoint::path(&again, 2);
    let sealed = ok(std::fs::read(checkpoint::path(&good, 2)));
    let content = &sealed[..sealed.len() - sinew::output::seal::LENGTH as usize];
    for name in ["time", "steps", "updates", "frames", "next_frame", "wall_s", "output_s", "format"] {
        for bits in [f64::NAN.to_bits(), (-1e300_f64).to_bits(), u64::MAX, (1 << 60) - 1, 0] {
            let _ = std::fs::remove_dir_all(&again);
            assert!(ok(Command::new("cp").arg("-r").args([&good, &again]).status()).success());
            ok(std::fs::write(&path, content));
            let file = ok(unlocked().open_rw(&path));
            let attribute = ok(file.attr(name));
            match ok(ok(attribute.dtype()).to_descriptor()) {
                TypeDescriptor::Float(_) => ok(attribute.write_scalar(&f64::from_bits(bits))),
                TypeDescriptor::Unsigned(IntSize::U4) => ok(attribute.write_scalar(&(bits as u32))),
                _ => ok(attribute.write_scalar(&bits)),
            }
            drop(attribute); // which keeps the file open
            ok(file.close());
            ok(sinew::output::seal::seal(&path));
            let output = sinew(&["run", "-q", "--restart", text(&again), "--steps", "4", "--threads", "1"]);
            let said = words(&output);
            println!(
                "{name} {bits:x}: {:?} {}",
                output.status.code(),
                &said[..said.floor_char_boundary(160)]
            );
            assert!(
                matches!(output.status.code(), Some(0..=2)) && !said.contains("panicked"),
                "{name} {bits:x}: {said}"
            );
        }
    }
}
