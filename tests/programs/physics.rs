//! Tasks of all kinds on a line of nodes, to be put together in any order.
use engine::data::extent::Bases;
use engine::grid::Origin;
use engine::prelude::{Life::*, *};

engine::labels! {
    Position: [Wide; 3] = particle("cells", "x_p").in_the_middle();
    Identity: Wide      = particle("1", "identity of p, as the bits of an integer");
    Charge: Wide        = particle("C", "q_p");
    Way: Wide           = particle("cells", "how far p goes");
    Seen: [Wide; 2]     = particle("C", "what p has read");
    Extent: [Wide; 6]   = block("cells", "where the particles of a block are").largest();

    Sum: Wide           = node("C", "sum S q").partials(3);
    Other: Wide         = node("C", "another").partials(3);
    TickSum: Wide       = node("C", "one that stays for a graph").partials(3).lives(Tick);
    Value: Wide         = node("C", "what p reads in the same graph").values(3);
    StepValue: Wide     = node("C", "what p reads in any graph of a step").values(3).lives(Step);
    Kept: [Wide; 2]     = node("C", "for ever").lives(Carried);

    Most: Wide          = run("C", "largest q").largest().lives(Carried);
    NodeMost: Wide      = run("C", "largest sum of a node").largest().lives(Carried);
    Exact: ExactSum     = run("C", "sum over nodes").exact().lives(Carried);
    Counted: [Wide; 2]  = run("1", "what runs once has counted, and read").lives(Carried);
    Done: Wide          = run("1", "whether rounds are enough").lives(Step);
    Total: ExactSum     = run("1", "no plain number").exact().lives(Step);
    OwnMost: Wide       = material("C", "largest q").largest().lives(Carried);
}
const ROLES: Roles =
    Roles { position: Position::ID, identity: Identity::ID, extent: Extent::ID, rates: None };
/// All labels.
pub static SCHEMA: Schema = Schema::new(&ROWS, ROLES);

/// Lines of a buffer, with the weights of a hat at x.
fn hat(x: f64, origin: &Origin) -> [(usize, f64); 2] {
    let (base, stride) = (x.floor(), origin.shape.buffer_strides[0] as usize);
    let first = (base - origin.node[0]) as usize;
    [(first * stride, 1.0 - (x - base)), ((first + 1) * stride, x - base)]
}

/// Runs `each(tile, lane)` for all particles.
fn all(at: &At<'_>, mut each: impl FnMut(usize, usize)) {
    (0..at.count).for_each(|p| each(p / 8, p % 8));
}

macro_rules! add {
    ($task:ident in $module:ident: $label:ident) => {
        kernel! { /// Particles add their charge.
            $task() in $module: Particles {
                requires old { charge: Charge } requires now { x: Position } computes { sum: $label @ 3 }
            }
            |_it, at, io| all(at, |t, l| for (line, s) in hat(io.x[t][0].0[l], &at.origin) {
                io.sum[line].0[0] += s * io.charge[t].0[l];
            })
        }
    };
}
add! { Add in add: Sum }
add! { AddOther in add_other: Other }
add! { AddTick in add_tick: TickSum }

kernel! { /// Particles add what they read.
    AddRead() in add_read: Particles {
        requires now { x: Position, value: StepValue @ 3 } computes { sum: Other @ 3 }
    }
    |_it, at, io| all(at, |t, l| for (line, s) in hat(io.x[t][0].0[l], &at.origin) {
        io.sum[line].0[0] += s * io.value[line].0[0];
    })
}
macro_rules! raise {
    ($task:ident in $module:ident: $label:ident) => {
        kernel! { /// What a block has added grows with the place.
            $task() in $module: Buffers { computes { sum: $label @ 3 } }
            |_it, at, io| for node in at.touched.iter() {
                io.sum[at.in_buffer(node)].0[0] *= 1.0 + 0.01 * f64::from(node[0]);
            }
        }
    };
}
raise! { Raise in raise: Sum }
raise! { RaiseTick in raise_tick: TickSum }
macro_rules! tilt {
    ($task:ident in $module:ident: $label:ident) => {
        kernel! { /// The nodes that a block reads are raised with the place.
            $task() in $module: Buffers { adapts { value: $label @ 3 } }
            |_it, at, io| for node in at.touched.iter() {
                io.value[at.in_buffer(node)].0[0] += 0.1 * f64::from(node[0]);
            }
        }
    };
}
tilt! { Tilt in tilt: Value }
tilt! { TiltStep in tilt_step: StepValue }
kernel! { /// Particles move.
    Drift() in drift: Particles { requires old { way: Way } computes { extent: Extent } modifies { x: Position } }
    |_it, at, io| all(at, |t, l| {
        io.x[t][0].0[l] += io.way[t].0[l];
        let x = [0, 1, 2].map(|a| io.x[t][a].0[l]);
        Bases { inverse_cell: 1.0, half_size: [0.0; 3] }.include_one(&mut io.extent[0], &at.origin, l, x);
    })
}
macro_rules! see {
    ($task:ident in $module:ident: $label:ident, $place:literal) => {
        kernel! { /// Particles read nodes.
            $task() in $module: Particles {
                requires now { x: Position, value: $label @ 3 } modifies { seen: Seen }
            }
            |_it, at, io| all(at, |t, l| {
                let read = hat(io.x[t][0].0[l], &at.origin).map(|(line, s)| s * io.value[line].0[0]);
                io.seen[t][$place].0[l] = read[0] + read[1];
            })
        }
    };
}
see! { See in see: Value, 0 }
see! { SeeLater in see_later: Value, 1 }
see! { SeeStep in see_step: StepValue, 1 }

kernel! { /// Particles read what all nodes have.
    SeeExact() in see_exact: Particles { requires now { exact: Exact } modifies { seen: Seen } }
    |_it, at, io| all(at, |t, l| io.seen[t][1].0[l] = 0.5 * io.seen[t][1].0[l] + io.exact[0].value())
}
kernel! { /// Particles read the largest charge of the last step.
    SeeMost() in see_most: Particles { requires old { most: Most } modifies { seen: Seen } }
    |_it, at, io| all(at, |t, l| io.seen[t][0].0[l] = io.most[0].0[0])
}
kernel! { /// The largest charge.
    FindMost() in find_most: Particles { requires old { charge: Charge } computes { most: Most } }
    |_it, at, io| all(at, |t, l| io.most[0].0[0] = io.most[0].0[0].max(io.charge[t].0[l]))
}
kernel! { /// Particles read what their material had.
    SeeOwn() in see_own: Particles { requires old { most: OwnMost } modifies { seen: Seen } }
    |_it, at, io| all(at, |t, l| io.seen[t][0].0[l] = io.most[0].0[0])
}
kernel! { /// The largest charge of a material.
    FindOwn() in find_own: Particles { requires old { charge: Charge } computes { most: OwnMost } }
    |_it, at, io| all(at, |t, l| io.most[0].0[0] = io.most[0].0[0].max(io.charge[t].0[l]))
}

/// The number of a node along the line.
fn number(at: &At<'_>, n: usize) -> f64 {
    f64::from(at.node_of(n % at.nodes)[0])
}
kernel! { /// Sums become values.
    Solve() in solve: Nodes { requires new { sum: Sum } computes { value: Value } }
    |_it, at, io| for n in 0..io.sum.len() { io.value[n].0[0] = io.sum[n].0[0] + 10.0 + number(at, n); }
}
kernel! { /// The other sum is kept.
    KeepOther() in keep_other: Nodes { requires now { sum: Other } modifies { kept: Kept } }
    |_it, _at, io| for n in 0..io.sum.len() { io.kept[n][0].0[0] = 0.5 * io.kept[n][0].0[0] + io.sum[n].0[0]; }
}
kernel! { /// Sums of the graph become values of the step.
    SolveStep() in solve_step: Nodes { requires now { sum: TickSum } computes { value: StepValue } }
    |_it, at, io| for n in 0..io.sum.len() { io.value[n].0[0] = io.sum[n].0[0] + 0.1 * number(at, n); }
}
kernel! { /// Values of the step are kept.
    KeepValue() in keep_value: Nodes { requires now { value: StepValue } modifies { kept: Kept } }
    |_it, _at, io| for n in 0..io.value.len() {
        io.kept[n][1].0[0] = 0.5 * io.kept[n][1].0[0] + io.value[n].0[0];
    }
}
kernel! { /// Values of the step change.
    ChangeValue() in change_value: Nodes { modifies { value: StepValue } }
    |_it, _at, io| io.value.iter_mut().for_each(|v| v.0[0] = 0.75 * v.0[0] + 1.0)
}
kernel! { /// Sums of the graph are kept.
    KeepTick() in keep_tick: Nodes { requires now { sum: TickSum } modifies { kept: Kept } }
    |_it, _at, io| for n in 0..io.sum.len() { io.kept[n][0].0[0] += 0.3 * io.sum[n].0[0]; }
}
kernel! { /// Sums of the graph are halved.
    Halve() in halve: Nodes { modifies { sum: TickSum } }
    |_it, _at, io| io.sum.iter_mut().for_each(|sum| sum.0[0] *= 0.5)
}
kernel! { /// What all nodes have.
    Reduce() in reduce: Nodes { requires now { sum: Sum } computes { most: NodeMost, exact: Exact } }
    |_it, _at, io| for sum in io.sum.iter() {
        io.most[0].0[0] = io.most[0].0[0].max(sum.0[0]);
        io.exact[0].add(sum.0[0]);
    }
}
kernel! { /// Nodes read what all nodes have.
    Spread() in spread: Nodes { requires now { exact: Exact, value: StepValue } modifies { kept: Kept } }
    |_it, _at, io| for n in 0..io.value.len() {
        io.kept[n][0].0[0] += io.exact[0].value() * io.value[n].0[0];
    }
}
kernel! { /// Something that has no place.
    Count() in count: Once { modifies { counted: Counted } }
    |_it, _at, io| io.counted[0][0].0[0] += 1.0
}
kernel! { /// What has no place reads what all nodes have.
    CountExact() in count_exact: Once { requires now { exact: Exact, most: NodeMost } modifies { counted: Counted } }
    |_it, _at, io| {
        let read = io.exact[0].value() + io.most[0].0[0];
        io.counted[0][1].0[0] = 0.5 * io.counted[0][1].0[0] + read;
    }
}
kernel! { /// Rounds are enough every second time.
    Judge() in judge: Once { computes { done: Done } modifies { counted: Counted } }
    |_it, _at, io| {
        io.counted[0][0].0[0] += 1.0;
        io.done[0].0[0] = f64::from(u8::from(io.counted[0][0].0[0] % 2.0 == 0.0));
    }
}

macro_rules! tasks {
    (particles: $($p:ident in $pm:ident),*; others: $($n:ident in $nm:ident),*;) => {
        /// A task: what it is called above.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Task { $($p,)* $($n,)* }
        pub use Task::*;

        /// All tasks.
        pub const TASKS: &[Task] = &[$($p,)* $($n,)*];

        impl Task {
            /// Adds it to a recipe, of a material if it runs over particles.
            pub fn add_to(self, recipe: &mut Recipe, m: usize) {
                match self {
                    $($p => recipe.add(m, "", $pm::$p()),)*
                    $($n => recipe.all("", $nm::$n()),)*
                }
            }
        }
    };
}
tasks! {
    particles: Add in add, AddOther in add_other, AddTick in add_tick, Raise in raise, RaiseTick in raise_tick, Tilt in tilt, TiltStep in tilt_step, AddRead in add_read, Drift in drift, See in see, SeeLater in see_later, SeeStep in see_step, SeeExact in see_exact, SeeMost in see_most, FindMost in find_most, SeeOwn in see_own, FindOwn in find_own;
    others: Solve in solve, KeepOther in keep_other, SolveStep in solve_step, KeepValue in keep_value, ChangeValue in change_value, KeepTick in keep_tick, Halve in halve, Reduce in reduce, Spread in spread, Count in count, CountExact in count_exact;
}

/// Lets rounds end.
pub fn judge(recipe: &mut Recipe) {
    recipe.all("", judge::Judge());
}
