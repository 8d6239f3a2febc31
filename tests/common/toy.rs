//! A toy method: a nonlinear equation, solved by loops in a loop; and tasks that are wrong between graphs.
use crate::common::tasks;
use engine::graph::error::GraphError;
use engine::program::{Program, Script};
use engine::schema::{Label, LabelId, Life::Step, Roles, Schema, block, material, node, particle, run};
use simd::Wide;

engine::labels! {
    Position: [Wide; 3] = particle("m", "x_p").in_the_middle();
    Identity: Wide = particle("1", "identity of p");
    Load: Wide = particle("N", "f_p");
    Extent: [Wide; 6] = block("cells", "where the particles of a block are").largest();
    Sums: Wide = node("N", "f_I").partials(3);
    Kept: Wide = node("N", "f_I that lives for a step").partials(3).lives(Step);
    Field: Wide = node("m", "u_I").values(3).lives(Step);
    Brief: Wide = node("m", "u_I that lives for a graph").values(3);
    Speed: Wide = material("m/s", "of each material").largest().lives(Step);
    Residual: Wide = run("N", "max |r_I|").largest().lives(Step);
    Glance: Wide = run("N", "what lives for a graph");
    Close: Wide = run("1", "1 where the inner loop is done").lives(Step);
    Done: Wide = run("1", "1 where the outer loop is done").lives(Step);
}

pub static SCHEMA: Schema = Schema::new(
    &ROWS,
    Roles { position: Position::ID, identity: Identity::ID, extent: Extent::ID, rates: None },
);

tasks! {
    Particles scatter Scatter { requires old { load: Load } computes { sums: Sums @ 3 } }
    Nodes solve Solve { requires new { sums: Sums } computes { field: Field, residual: Residual } }
    Particles push Push { requires now { field: Field @ 3 } computes { sums: Sums @ 3 } }
    Nodes correct Correct { requires new { sums: Sums } computes { residual: Residual } modifies { field: Field } }
    Once judge Judge { requires new { residual: Residual } computes { close: Close } }
    Once finish Finish { requires now { residual: Residual } computes { done: Done } }
    Particles collect Collect { requires now { field: Field @ 3 } modifies { load: Load } }
    Particles advance Advance { computes { extent: Extent } modifies { position: Position } }
    Particles keep Keep { requires old { load: Load } computes { kept: Kept @ 3 } }
    Nodes use_kept UseKept { requires now { kept: Kept } computes { field: Field } }
    Nodes show Show { requires new { sums: Sums } computes { brief: Brief } }
    Particles see See { requires now { brief: Brief @ 3 } modifies { load: Load } }
    Particles fast Fast { requires old { load: Load } computes { speed: Speed } }
    Particles heed Heed { requires now { speed: Speed } modifies { load: Load } }
    Once look Look { requires now { residual: Residual } computes { close: Close } }
    Once glance TakeGlance { requires now { residual: Residual } computes { glance: Glance } }
    Once again GlanceAgain { requires old { glance: Glance } computes { close: Close } }
}

pub const WOOD: usize = 0;
pub const IRON: usize = 1;

/// A graph of some tasks, each with its material or `None`.
macro_rules! graph {
    ($name:literal: $($material:expr => $task:expr),* $(,)?) => {{
        let mut recipe = engine::graph::recipe::Recipe::new(
            &crate::toy::SCHEMA, vec!["wood".into(), "iron".into()]);
        $(match Option::<usize>::from($material) {
            Some(material) => recipe.add(material, "", $task),
            None => recipe.all("", $task),
        })*
        engine::program::Script::Graph($name, recipe)
    }};
}
#[allow(unused_imports)] // each test takes what it needs
pub(crate) use graph;

pub fn repeat(until: LabelId, most: u64, body: Vec<Script>) -> Script {
    Script::Loop { body, until, most }
}

pub fn build(script: Vec<Script>) -> Result<Program, GraphError> {
    Program::build("toy", script, &[Load::ID, Position::ID, Extent::ID], 4)
}

/// What begins: loads become a field, with its residual.
pub fn start() -> Script {
    graph!("start": WOOD => Scatter, IRON => Scatter, None => Solve)
}

/// A loop in a loop between two graphs.
pub fn nested() -> Program {
    let inner = graph!("iterate": WOOD => Push, IRON => Push, None => Correct, None => Judge);
    let outer = vec![repeat(Close::ID, 20, vec![inner]), graph!("update": None => Finish)];
    let end = graph!("collect": WOOD => Collect, IRON => Collect);
    build(vec![start(), repeat(Done::ID, 5, outer), end]).unwrap_or_else(|e| panic!("{e}"))
}
