//! What is carried is in the checkpoint, what is not is not, and a run goes on from it on other patches and ranks.
use crate::layouts::{cases, expected, layout, random};
use crate::run::{Layout, empty, state, steps, together, warehouse};
use crate::state::{Start, State, same, start};
use crate::toy::program;
use engine::exec::ranks::Network;
use engine::exec::{Engine, Serial};
use engine::simd::Isa;
use sinew::output::checkpoint::{self, Head, Reader, Table};
use std::path::Path;

/// Takes some steps, and writes a checkpoint.
fn write(start: &Start, layout: &Layout, count: usize, path: &Path) -> State {
    together(layout, |mut network| {
        let program =
            program(&start.fields, start.cells, layout.patches.iter().product()).expect("a program");
        let mut warehouse = warehouse(start, layout, &program, network.rank());
        let mut engine = Engine::new(Box::new(Serial), Isa::detect(), &warehouse);
        steps((&mut engine, &mut warehouse, &mut network), &program, layout, count);
        let mut head = Head::default();
        head.describe(&mut network, &warehouse).expect("tables");
        checkpoint::write(&mut network, |give| checkpoint::parts(&warehouse, give), path, &head)
            .expect("a checkpoint");
        state(&warehouse)
    })
}

/// Goes on from it.
fn restart(start: &Start, layout: &Layout, count: usize, path: &Path) -> State {
    together(layout, |mut network| {
        let program =
            program(&start.fields, start.cells, layout.patches.iter().product()).expect("a program");
        let mut warehouse = empty(start, layout, &program, (&layout.of[0], network.rank()));
        checkpoint::fill(&mut warehouse, &Reader::open(path).expect("a whole file"))
            .expect("what was written");
        let mut engine = Engine::new(Box::new(Serial), Isa::detect(), &warehouse);
        steps((&mut engine, &mut warehouse, &mut network), &program, layout, count);
        state(&warehouse)
    })
}

#[test]
fn a_run_goes_on_from_a_checkpoint_on_other_patches_and_ranks_with_the_same_bits() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = (start(), 1..=4usize, random(), 1..=4usize, random());
    cases(12, input, |(start, ranks, random, ranks_after, random_after)| {
        let before = layout(&start, ranks, 1, &random);
        let after = layout(&start, ranks_after, 1, &random_after);
        let path = folder.path().join("checkpoint.h5");
        let written = write(&start, &before, 2, &path);
        let mut read = restart(&start, &after, 0, &path);
        // what only a step reduces is not carried
        read.shared.retain(|label, _| CARRIED.contains(&label.as_str()));
        let mut kept = written;
        kept.shared.retain(|label, _| CARRIED.contains(&label.as_str()));
        same(&format!("read back, {before:?} {after:?}"), &read, &kept);
        let found = restart(&start, &after, 2, &path);
        same(&format!("{before:?} {after:?}"), &found, &expected(&start, 4));
    });
}

/// Shared labels of the toy that live from step to step.
const CARRIED: [&str; 4] = ["OwnMost", "OwnSteps", "RunFirst", "Steps"];

#[test]
fn what_is_carried_is_in_the_file_and_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("checkpoint.h5");
    cases(1, start(), |start| {
        write(&start, &Layout::alone(), 1, &path);
        let Head { materials, nodes, mut shared, .. } = Reader::open(&path).expect("a whole file").head;
        shared.sort();
        assert_eq!(shared.iter().map(|(label, _)| label.as_str()).collect::<Vec<_>>(), CARRIED);
        let widths = |table: &Table| table.labels.clone();
        let list =
            |list: &[(&str, usize)]| list.iter().map(|(l, w)| ((*l).to_owned(), *w)).collect::<Vec<_>>();
        // eight numbers a line of a node
        let kept = list(&[("KeptSum", 8), ("Total", 24), ("KeptOwn", 24), ("MeetKept", 16)]);
        assert_eq!(nodes.iter().map(widths).collect::<Vec<_>>(), vec![kept; 4]);
        let particles =
            [("Position", 3), ("Identity", 1), ("Velocity", 3), ("Charge", 1), ("Whole", 1), ("Seen", 4)];
        let with = |memory: usize| [&particles[..], &[("Memory", memory)]].concat();
        let all = [list(&particles), list(&with(3)), list(&with(1))];
        assert_eq!(materials.iter().map(widths).collect::<Vec<_>>(), all);
    });
}
