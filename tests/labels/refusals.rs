//! What rows and graphs refuse: all that would be wrong in silence.
use crate::toy::*;
use engine::graph::build::TaskGraph;
use engine::graph::task::Runnable;
use engine::prelude::*;
use engine::program::{RoundHazard, Site, hazards};
use engine::schema::{LabelId, Row};

/// Tasks without a body.
macro_rules! idle {
    ($($domain:ident $module:ident $task:ident { $($declared:tt)* })*) => { $(
        mod $module {
            use super::*;
            engine::task! {
                /// Declares, and does nothing.
                pub struct $task;
                $domain task { $($declared)* }
            }
            impl Body for $task {
                fn run<S: Simd>(&self, _at: &At<'_>, _io: Io<'_>) {}
            }
        }
        use $module::$task;
    )* };
}

idle! {
    Particles add Add { requires old { charge: Charge } computes { sum: StageSum @ 3 } }
    Particles add_step AddStep { requires old { charge: Charge } computes { sum: StepSum @ 3 } }
    Particles add_here AddHere { requires old { charge: Charge } computes { sum: StageSum } }
    Particles add_far AddFar { requires old { charge: Charge } computes { sum: TickSum @ 3 } }
    Particles add_value AddValue { requires old { charge: Charge } computes { value: TickValue @ 3 } }
    Particles change_sum ChangeSum { requires old { charge: Charge } modifies { sum: StageSum } }
    Particles read_sum ReadSum { requires new { sum: StepSum @ 3 } modifies { seen: Seen } }
    Particles read_here ReadHere { requires new { value: TickValue } modifies { seen: Seen } }
    Particles read_far ReadFar { requires now { total: Total @ 3 } modifies { seen: Seen } }
    Particles read_own ReadOwn { requires now { own: KeptOwn } modifies { seen: Seen } }
    Particles read_value ReadValue { requires new { value: TickValue @ 3 } modifies { seen: Seen } }
    Particles read_step ReadStep { requires now { value: StepValue @ 3 } modifies { seen: Seen } }
    Particles overwrite Overwrite { requires old { charge: Charge } modifies { steps: Steps } }
    Nodes solve Solve { requires new { sum: StageSum } computes { value: TickValue } }
    Nodes solve_step SolveStep { requires new { sum: StepSum } computes { value: TickValue } }
    Nodes alter Alter { computes { change: Change } modifies { sum: StageSum } }
    Nodes solve_after SolveAfter { requires new { sum: StageSum } requires now { change: Change } computes { value: TickValue } }
    Nodes see_far SeeFar { requires new { sum: StageSum @ 1 } computes { value: TickValue } }
    Nodes set_sum SetSum { computes { sum: StageSum } }
    Nodes see_particles SeeParticles { requires old { charge: Charge } computes { value: TickValue } }
    Nodes overwrite_steps OverwriteSteps { requires new { sum: StageSum } modifies { steps: Steps } }
    Once see_nodes SeeNodes { requires now { total: Total } modifies { steps: Steps } }
}

type Line = (Option<usize>, Box<dyn Runnable>);

fn of(task: impl Runnable + 'static) -> Line {
    (Some(0), Box::new(task))
}

fn all(task: impl Runnable + 'static) -> Line {
    (None, Box::new(task))
}

const OUTPUTS: [LabelId; 3] = [Seen::ID, Steps::ID, TickValue::ID];

fn recipe(lines: impl IntoIterator<Item = Line>) -> Recipe {
    let mut recipe = Recipe::new(&SCHEMA, vec!["matter".to_owned()]);
    recipe.entries.extend(lines.into_iter().map(|(material, task)| engine::graph::recipe::RecipeLine {
        task,
        material,
        because: String::new(),
    }));
    recipe
}

/// Whether the graph of some lines is refused in these words.
#[track_caller]
fn refused<const N: usize>(lines: [Line; N], words: &[&str]) {
    let Err(error) = TaskGraph::build(recipe(lines), &OUTPUTS, 2) else {
        panic!("nothing refused: {words:?}")
    };
    let error = error.to_string();
    assert!(words.iter().all(|word| error.contains(word)), "{words:?}: {error}");
}

#[track_caller]
fn accepted<const N: usize>(lines: [Line; N]) {
    assert!(TaskGraph::build(recipe(lines), &OUTPUTS, 2).is_ok());
}

#[test]
fn a_cycle_is_accepted() {
    accepted([of(Add), all(Solve), of(ReadValue)]);
    accepted([of(AddStep), all(SolveStep), of(ReadValue)]);
    accepted([of(Add), all(Alter), all(Solve), of(ReadValue)]);
}

#[test]
fn particles_say_how_far_they_reach() {
    refused(
        [of(AddHere), all(Solve), of(ReadValue)],
        &["AddHere[matter]", "StageSum", "without ghosts", "@ 3"],
    );
    refused(
        [of(Add), all(Solve), of(ReadHere)],
        &["ReadHere[matter]", "TickValue", "without ghosts", "@ 1 to @ 3"],
    );
    refused([of(ReadOwn)], &["ReadOwn[matter] runs over particles and reads KeptOwn", "values(n)"]);
}

#[test]
fn nobody_reads_farther_than_a_row_allows() {
    refused([of(ReadFar)], &["ReadFar[matter] declares Total with 3 ghost layers", "stores 2"]);
    refused([of(AddFar)], &["AddFar[matter] declares TickSum with 3 ghost layers", "stores 2"]);
    refused([of(Add), all(SeeFar)], &["SeeFar", "StageSum", "ghost"]);
}

#[test]
fn partial_sums_are_added_up_before_they_are_read() {
    refused(
        [of(AddStep), of(ReadSum)],
        &["ReadSum[matter] runs over particles and reads StepSum", "values(n)"],
    );
    let wanted = [Seen::ID, StepSum::ID];
    let error =
        TaskGraph::build(recipe([of(AddStep)]), &wanted, 2).err().expect("nobody adds up").to_string();
    assert!(error.contains("AddStep[matter] adds to StepSum") && error.contains("same graph"), "{error}");
}

idle! {
    Buffers change_added ChangeAdded { computes { sum: StageSum @ 3 } }
    Buffers change_here ChangeHere { computes { sum: StageSum } }
    Buffers adapt Adapt { adapts { value: TickValue @ 3 } }
    Buffers adapt_sum AdaptSum { adapts { sum: StageSum @ 3 } }
    Buffers adapt_and_change AdaptAndChange { adapts { value: TickValue @ 3 } computes { sum: StageSum @ 3 } }
    Buffers see_charge SeeCharge { requires old { charge: Charge } computes { sum: StageSum @ 3 } }
    Particles adapt_one AdaptOne { adapts { value: TickValue @ 3 } modifies { seen: Seen } }
    Nodes adapt_nodes AdaptNodes { adapts { value: TickValue @ 0 } modifies { total: Total } }
}

#[test]
fn buffers_hold_the_nodes_around_a_block() {
    accepted([of(Add), of(ChangeAdded), all(Solve), of(Adapt), of(ReadValue)]);
    refused([of(Add), of(ChangeHere), all(Solve), of(ReadValue)], &["ChangeHere[matter]", "without ghosts"]);
    refused(
        [of(Add), of(AdaptSum), all(Solve), of(ReadValue)],
        &["AdaptSum[matter]", "give its row values(n)"],
    );
    refused(
        [of(Add), of(SeeCharge), all(Solve), of(ReadValue)],
        &["SeeCharge[matter] runs over buffers and declares Charge", "no particles"],
    );
    refused([of(Add), all(Solve), of(AdaptOne)], &["AdaptOne[matter] runs over particles and adapts"]);
    refused(
        [of(Add), all(Solve), all(AdaptNodes), of(ReadValue)],
        &["AdaptNodes runs over nodes and adapts"],
    );
    refused(
        [of(Add), all(Solve), of(AdaptAndChange), all(SolveStep)],
        &["AdaptAndChange[matter] changes what particles have added and adapts TickValue", "two tasks"],
    );
}

idle! {
    Particles drift Drift { computes { extent: Extent } modifies { x: Position } }
    Particles count Count { requires old { whole: Whole } computes { exact: RunExact } }
    Particles count_on CountOn { requires old { whole: Whole } computes { exact: RunExact } }
    Particles rank Rank { requires old { charge: Charge } computes { most: RunMost } }
    Particles rank_on RankOn { requires old { charge: Charge } computes { most: RunMost } }
    Once see_count SeeCount { requires new { exact: RunExact } modifies { steps: Steps } }
    Once see_again SeeAgain { requires new { exact: RunExact } modifies { steps: Steps } }
    Once see_rank_again SeeRankAgain { requires new { most: RunMost } modifies { steps: Steps } }
    Once see_rank SeeRank { requires new { most: RunMost } modifies { steps: Steps } }
    Particles add_on AddOn { requires old { charge: Charge } computes { sum: StepSum @ 3 } }
}

#[test]
fn nobody_adds_on_where_particles_have_moved() {
    let moved = [&OUTPUTS[..], &[Position::ID]].concat();
    let build = |lines: Vec<Line>| TaskGraph::build(recipe(lines), &moved, 2);
    let twice = vec![of(AddStep), of(Drift), of(AddOn), all(SolveStep), of(ReadValue)];
    let error = build(twice).err().expect("a sum of two places").to_string();
    for word in
        ["AddOn[matter] adds to StepSum", "before Drift[matter] moved them", "read the sum in between"]
    {
        assert!(error.contains(word), "{error}");
    }
    accepted([of(AddStep), of(AddOn), all(SolveStep), of(ReadValue)]);
    // who adds after particles have moved does not share their stage: it would add around the place where they were
    let graph = build(vec![of(Drift), of(AddStep), all(SolveStep), of(ReadValue)]).expect("a graph");
    let stages = graph.phases.iter().flat_map(|phase| &phase.stages).filter(|stage| stage.material.is_some());
    assert_eq!(stages.map(|stage| stage.nodes.len()).collect::<Vec<_>>(), [1, 1, 1]);
}

#[test]
fn nobody_adds_to_what_ranks_have_brought_together() {
    refused(
        [of(Count), all(SeeCount), of(CountOn), all(SeeAgain)],
        &["CountOn[matter] adds to RunExact after SeeCount has read it", "once a rank", "another label"],
    );
    accepted([of(Count), of(CountOn), all(SeeCount)]);
    // the largest of all stays the largest
    accepted([of(Rank), all(SeeRank), of(RankOn), all(SeeRankAgain)]);
}

#[test]
fn a_graph_reads_no_sum_that_another_graph_has_left_in_parts() {
    let script = vec![
        Script::Graph("first", recipe([of(AddStep)])),
        Script::Graph("second", recipe([all(SolveReadsNow), of(ReadValue)])),
    ];
    let error = Program::build("two", script, &OUTPUTS, 2).err().expect("a sum in parts").to_string();
    assert!(error.contains("AddStep[matter] adds to StepSum"), "{error}");
}

idle! {
    Nodes now SolveReadsNow { requires now { sum: StepSum } computes { value: TickValue } }
}

#[test]
fn what_lives_for_a_stage_does_not_leave_it_changed() {
    // `SolveAfter` reads what all blocks have added to `Change`, so that it cannot run with `Alter`, block by block
    refused(
        [of(Add), all(Alter), all(SolveAfter), of(ReadValue)],
        &["SolveAfter requires StageSum", "as Alter left it", "let it live for a tick"],
    );
}

#[test]
fn who_writes_what_is_as_rows_say() {
    refused(
        [of(AddValue), of(ReadValue)],
        &["AddValue[matter] runs over particles and computes TickValue", "partials(n)"],
    );
    refused(
        [of(Add), of(ChangeSum), all(Solve)],
        &["ChangeSum[matter] runs over particles and modifies StageSum"],
    );
    refused(
        [all(SetSum), all(Solve)],
        &["SetSum runs over nodes and computes StageSum", "particles add to it"],
    );
    refused([of(Overwrite)], &["Overwrite[matter] runs over blocks and overwrites Steps", "runs once"]);
    refused([of(Add), all(OverwriteSteps)], &["OverwriteSteps runs over blocks and overwrites Steps"]);
}

#[test]
fn tasks_declare_what_is_where_they_run() {
    refused([all(SeeParticles)], &["SeeParticles runs over nodes and declares Charge"]);
    refused([all(SeeNodes)], &["SeeNodes runs once and declares Total"]);
}

#[test]
fn what_a_tick_or_step_leaves_is_not_read_before_it_is_there() {
    let program = |script| Program::build("parts", script, &OUTPUTS, 2).expect("a program");
    let late = program(vec![Script::Graph("early", recipe([of(ReadStep)]))]);
    let task = "ReadStep[matter]".to_owned();
    let missing = RoundHazard::NotLeft(Site { graph: "early".into(), task, label: StepValue::ID });
    assert_eq!(hazards(&late), [missing]);
}

/// Whether a row is refused, with these words.
#[track_caller]
fn row(row: Row, lines: usize, words: &str) {
    let declare = || row.declare(0, "Bad", lines * size_of::<Wide>());
    let panic = std::panic::catch_unwind(declare).expect_err(words);
    let said = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    let said = said.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
    assert!(said.contains(words), "{words}: {said}");
}

#[test]
fn rows_that_make_no_sense_do_not_compile() {
    row(node("1", "too far").values(4), 1, "more layers of ghosts than are stored");
    row(run("1", "nowhere").values(1), 1, "only labels of nodes cross blocks");
    row(node("1", "not partial").largest(), 1, "what combines on nodes is partial");
    row(node("1", "not partial").exact(), 9, "what combines on nodes is partial");
    row(node("1", "no sum").exact().partials(3), 8, "nine lines");
    row(run("1", "no sum").exact(), 10, "nine lines");
    row(particle("1", "no node").where_fields_meet(), 1, "fields meet on nodes");
    row(node("1", "not partial").values(3).lives(Life::Stage), 1, "only partial sums live for a stage");
    row(particle("1", "gone").lives(Life::Step), 1, "are carried");
    row(chunk("1", "kept").lives(Life::Tick), 1, "a chunk label lives in a chunk");
    row(node("1", "whose").by_material(), 1, "materials decide about particles");
    row(node("1", "no lines"), 0, "a number of lines");
}
