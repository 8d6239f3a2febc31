//! Programs that once were wrong, against what their recipes say.
use crate::physics::*;
use crate::run::*;
use engine::prelude::*;

/// One rank, and two or three.
const LAYOUTS: [&[u32]; 5] = [&[0], &[0, 1], &[0, 1, 0], &[0, 1, 1, 0], &[0, 2, 0, 1, 0, 2]];

#[track_caller]
fn everywhere(tasks: &[(Task, usize)], particles: &[Particle], steps: usize, check: impl Fn(&State)) {
    let script = || vec![Script::Graph("graph", of(tasks))];
    let states = LAYOUTS.map(|of| after(&script, particles, of, steps));
    check(&states[0]);
    states.iter().for_each(|state| assert_eq!(state, &states[0]));
}

fn of(tasks: &[(Task, usize)]) -> Recipe {
    recipe(|recipe| tasks.iter().for_each(|&(task, material)| task.add_to(recipe, material)))
}

fn refused(tasks: &[(Task, usize)], words: &[&str]) {
    let error = build(vec![Script::Graph("graph", of(tasks))], 2).err().expect("a refusal").to_string();
    assert!(words.iter().all(|word| error.contains(word)), "{error}");
}

/// Particles of both materials at all places, which move.
fn crowd() -> Vec<Particle> {
    let x = |i: usize| 5.013 + 0.97 * i as f64;
    (0..14).map(|i| (i % 2, x(i), 1.0 + i as f64, 0.1 * ((i % 9) as f64 - 4.0))).collect()
}

#[test]
fn what_blocks_have_added_is_changed_once_and_before_others_see_it() {
    // half a charge at 7 and at 8
    let add = [(AddTick, 0), (AddTick, 1), (RaiseTick, 0), (KeepTick, 0)];
    everywhere(&add, &[(0, 7.5, 4.0, 0.0), (0, 8.5, 4.0, 0.0), (1, 7.5, 8.0, 0.0)], 1, |state| {
        let kept = |node, field| state.nodes[&(node, field)][0];
        let wanted = [0.3 * (2.0 * 1.07), 0.3 * (2.0 * 1.08 + 2.0 * 1.08), 0.3 * 4.0];
        let near =
            [kept(7, 0), kept(8, 0), kept(7, 1)].iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-14);
        assert!(near, "{:?}", state.nodes);
    });
}

#[test]
fn nodes_are_adapted_for_the_tasks_after_that_alone() {
    let add = [(Add, 0), (Solve, 0), (Tilt, 0), (See, 0), (Count, 0), (SeeLater, 1)];
    everywhere(&add, &[(0, 7.5, 4.0, 0.0), (1, 7.5, 8.0, 0.0)], 1, |state| {
        // 2 C, 10 and the number of the node at 7 and at 8; a tenth of the number more
        let near = |found: f64, wanted: f64| (found - wanted).abs() < 1e-12;
        assert!(near(state.particles[&0][1], 19.5 + 0.75), "{:?}", state.particles);
        assert!(near(state.particles[&1][2], 17.5), "{:?}", state.particles);
    });
    let apart = [(Add, 0), (Solve, 0), (Tilt, 0), (See, 0), (Drift, 0), (SeeLater, 0)];
    refused(&apart, &["SeeLater[a] requires Value, which Tilt[a] adapts", "list Tilt[a] again"]);
}

#[test]
fn materials_may_come_in_any_order() {
    let add = [(AddTick, 1), (AddTick, 0), (KeepTick, 0)];
    everywhere(&add, &[(0, 7.5, 4.0, 0.0), (1, 7.5, 8.0, 0.0)], 1, |state| {
        let kept = |field| state.nodes[&(7, field)][0];
        assert_eq!([kept(0), kept(1)], [0.3 * 2.0, 0.3 * 4.0]);
    });
}

#[test]
fn what_nodes_reduce_comes_together_before_other_phases_read_it() {
    let add = [(Add, 1), (Reduce, 0), (Count, 0), (AddTick, 1), (SolveStep, 0), (Spread, 0)];
    everywhere(&add, &crowd(), 3, |state| assert!(!state.nodes.is_empty()));
}

#[test]
fn sums_of_one_material_do_not_change_what_others_touch() {
    let add = [(AddTick, 1), (Count, 0), (AddOther, 0), (KeepTick, 0), (KeepOther, 0)];
    let beside = [(0, 7.5, 1.0, 0.0), (0, 8.5, 1.0, 0.0), (1, 7.5, 1.0, 0.0), (1, 8.5, 1.0, 0.0)];
    everywhere(&add, &beside, 3, |state| assert!(!state.nodes.is_empty()));
    everywhere(&add, &crowd(), 3, |state| assert!(!state.nodes.is_empty()));
}

#[test]
fn what_is_read_as_it_was_is_not_what_is_made_of_it() {
    let add = [(SeeMost, 0), (FindMost, 0)];
    everywhere(&add, &[(0, 5.5, 5.0, 0.0), (0, 17.5, 7.0, 0.0)], 3, |state| {
        assert_eq!([state.shared[0], state.particles[&0][1], state.particles[&1][1]], [7.0; 3]);
    });
    let own = [(FindOwn, 0), (SeeOwn, 1), (FindOwn, 1)];
    everywhere(&own, &[(0, 5.5, 5.0, 0.0), (1, 17.5, 7.0, 0.0)], 2, |state| {
        assert_eq!(state.shared[state.shared.len() - 2..], [5.0, 7.0]);
        assert_eq!(state.particles[&1][1], 7.0);
    });
}

#[test]
fn a_material_keeps_what_another_computes_alone() {
    let script = || {
        let graph = |name, m| Script::Graph(name, of(&[(FindOwn, m)]));
        vec![graph("first", 0), graph("second", 1)]
    };
    for of in LAYOUTS {
        let state = after(&script, &[(0, 5.5, 5.0, 0.0), (1, 17.5, 7.0, 0.0)], of, 2);
        assert_eq!(state.shared[state.shared.len() - 2..], [5.0, 7.0], "{of:?}");
    }
}

#[test]
fn who_reads_later_or_has_moved_reads_the_same_values() {
    let add = [(Add, 0), (Solve, 0), (See, 0), (Drift, 0), (SeeLater, 0), (Count, 0), (See, 1)];
    let particles = [(0, 6.5, 1.0, 1.9), (0, 9.5, 1.0, -1.9), (1, 7.5, 1.0, 0.0), (1, 10.75, 1.0, 0.0)];
    everywhere(&add, &particles, 1, |state| {
        // half a charge of the first material at 6, 7, 9 and 10
        let expected = [[8.4, 17.0, 18.6], [7.6, 20.0, 17.8], [7.5, 17.5, 0.0], [10.75, 20.75, 0.0]];
        for (numbers, wanted) in state.particles.values().zip(expected) {
            let near = numbers.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-12);
            assert!(near, "{numbers:?} instead of {wanted:?}");
        }
    });
}

#[test]
fn values_travel_for_those_who_read_them() {
    let add = [
        (AddTick, 1),
        (SolveStep, 0),
        (AddOther, 0),
        (Count, 0),
        (ChangeValue, 0),
        (SeeStep, 1),
        (KeepOther, 0),
    ];
    everywhere(&add, &crowd(), 3, |state| assert!(!state.nodes.is_empty()));
}

#[test]
fn a_sum_that_was_changed_is_not_added_up_again_for_the_sake_of_another_material() {
    let add = [(AddTick, 0), (Halve, 0), (AddTick, 1), (KeepTick, 0)];
    everywhere(&add, &[(0, 7.5, 4.0, 0.0), (1, 7.5, 8.0, 0.0)], 1, |state| {
        assert_eq!([0, 1].map(|field| state.nodes[&(8, field)][0]), [0.3 * 1.0, 0.3 * 4.0]);
    });
}

#[test]
fn particles_do_not_add_around_two_places_before_anybody_adds_up() {
    let add = [(Add, 0), (Drift, 0), (AddOther, 0), (Solve, 0), (KeepOther, 0), (See, 0)];
    refused(&add, &["AddOther[a] adds to Other", "added to Sum before Drift[a] moved them"]);
}

#[test]
fn loops_wait_for_plain_numbers_and_have_rounds() {
    let script = |until, most| {
        let count = recipe(judge);
        vec![Script::Loop { body: vec![Script::Graph("round", count)], until, most }]
    };
    let refused = |script, word: &str| {
        let error = build(script, 1).err().expect("a refusal").to_string();
        assert!(error.contains(word), "{error}");
    };
    refused(script(Total::ID, 5), "Total, which is no plain number of the run");
    refused(script(Done::ID, 0), "a loop until Done may have 0 rounds");
    assert!(build(script(Done::ID, 1), 1).is_ok());
}
