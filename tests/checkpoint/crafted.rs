//! Checkpoints with a good seal whose numbers no run would write.
use crate::*;
use hdf5::{File, H5Type};

/// Restores the cloud after two steps from a checkpoint that `change` has changed, and takes a step.
fn restored_after(change: impl Fn(&File)) -> Result<bool, RunError> {
    let folder = folder();
    let scene = || laid_out(scene(CLOUD, &[]), LAYOUTS[0]);
    let path = stopped(scene(), LAYOUTS[0], 2, folder.path());
    let bytes = ok(std::fs::read(&path));
    ok(std::fs::write(&path, &bytes[..bytes.len() - sinew::output::seal::LENGTH as usize]));
    let file = ok(File::open_rw(&path));
    change(&file);
    ok(file.close());
    ok(sinew::output::seal::seal(&path));
    Simulation::restore(Box::new(Alone), scene(), Isa::detect(), &Reader::open(&path)?)?.step()
}

#[track_caller]
fn refused(change: impl Fn(&File), facts: &[&str]) {
    let error = restored_after(change).map(drop).expect_err("it is refused").to_string();
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
