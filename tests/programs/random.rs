//! Random programs.
use crate::physics::*;
use crate::run::*;
use crate::runner::runner;
use engine::prelude::*;
use proptest::prelude::*;

/// Tasks of each graph, with a material; and whether the last graph is a loop.
#[derive(Clone, Debug)]
struct Draft {
    graphs: Vec<Vec<(Task, usize)>>,
    is_loop: bool,
}

const NAMES: [&str; 3] = ["one", "two", "three"];

impl Draft {
    fn script(&self) -> Vec<Script> {
        let graphs = NAMES.into_iter().zip(&self.graphs);
        let graph = |(name, tasks): (&'static str, &Vec<(Task, usize)>)| {
            let add = |recipe: &mut Recipe| {
                tasks.iter().for_each(|&(task, material)| task.add_to(recipe, material));
                if self.is_loop {
                    judge(recipe);
                }
            };
            Script::Graph(name, recipe(add))
        };
        let mut script: Vec<Script> = graphs.map(graph).collect();
        if let Some(last) = script.pop_if(|_| self.is_loop) {
            script.push(Script::Loop { body: vec![last], until: Done::ID, most: 4 });
        }
        script
    }
}

fn draft() -> impl Strategy<Value = Draft> {
    let tasks = prop::collection::vec((prop::sample::select(TASKS), 0..2usize), 2..10);
    let graphs = prop::collection::vec(tasks, 1..=3);
    (graphs, prop::bool::weighted(0.3)).prop_map(|(graphs, is_loop)| Draft { graphs, is_loop })
}

fn particles() -> impl Strategy<Value = Vec<Particle>> {
    let particle = (0..2usize, 50..190u8, 1..20u8, 0..9u8);
    let particle = particle.prop_map(|(material, x, charge, way)| {
        (material, 0.1 * f64::from(x) + 0.013, f64::from(charge), 0.1 * (f64::from(way) - 4.0))
    });
    prop::collection::vec(particle, 1..16)
}

/// Patches of up to four ranks.
fn layout() -> impl Strategy<Value = Vec<u32>> {
    let of = |patches| prop::collection::vec(0..4u32, patches);
    prop_oneof![of(2), of(3), of(6)]
}

#[test]
fn what_is_built_and_clean_has_the_same_bits_on_any_patches_and_ranks() {
    let input = (draft(), particles(), layout());
    let run = runner(3_000).run(&input, |(draft, particles, of)| {
        let script = || draft.script();
        let program = build(script(), of.len());
        let works = |program: &Program| program.graphs().iter().any(|graph| graph.graph.node_count() > 0);
        prop_assume!(program.is_ok_and(|program| works(&program) && is_clean(&program)));
        prop_assert_eq!(after(&script, &particles, &of, 3), after(&script, &particles, &[0], 3));
        Ok(())
    });
    run.unwrap_or_else(|error| panic!("{error}"));
}
