//! Programs on particles of two materials, on any patches and ranks.
use crate::physics::*;
use engine::exec::ranks::local::Local;
use engine::exec::ranks::{Network, NetworkError};
use engine::exec::{Conductor, Engine, Serial};
use engine::prelude::*;
use engine::program::hazards;
use engine::schema::LabelId;
use engine::simd::Isa;
use std::collections::BTreeMap;

/// Lets particles leave, and loops end.
struct Anything;

impl Conductor for Anything {
    type Error = NetworkError;
}

/// Material, position, charge, and how far it goes.
pub type Particle = (usize, f64, f64, f64);

/// Cells along the line, six blocks of them.
pub const CELLS: usize = 24;
const OUTPUTS: [LabelId; 8] =
    [Seen::ID, Position::ID, Extent::ID, Kept::ID, Counted::ID, Most::ID, OwnMost::ID, NodeMost::ID];

/// A recipe of two materials.
pub fn recipe(add: impl FnOnce(&mut Recipe)) -> Recipe {
    let mut recipe = Recipe::new(&SCHEMA, vec!["a".to_owned(), "b".to_owned()]);
    add(&mut recipe);
    recipe
}

/// A program, unless something is to be refused.
pub fn build(script: Vec<Script>, patches: usize) -> Result<Program, GraphError> {
    Program::build("program", script, &OUTPUTS, patches)
}

/// Whether nobody warns of a program.
pub fn is_clean(program: &Program) -> bool {
    use engine::graph::check::{Hazard, hazards as of_graph};
    let harmless = |hazard: &Hazard| matches!(hazard, Hazard::OneMaterial { .. } | Hazard::Idle { .. });
    let graphs = program.graphs();
    graphs.iter().all(|graph| of_graph(graph, 4, &[]).iter().all(harmless)) && hazards(program).is_empty()
}

/// Bits of what there is after some steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// By identity: position, and what was read.
    pub particles: BTreeMap<u64, [f64; 3]>,
    /// By node and field, where anything is kept.
    pub nodes: BTreeMap<(i32, usize), [f64; 2]>,
    /// Largest charge, largest sum of a node, what was counted, and what each material had.
    pub shared: Vec<f64>,
}

/// The state after some steps; `of` says on which rank each patch is.
pub fn after(
    script: &(impl Fn() -> Vec<Script> + Sync),
    particles: &[Particle],
    of: &[u32],
    steps: usize,
) -> State {
    let ranks = of.iter().max().map_or(1, |&rank| rank as usize + 1);
    let work = |mut network: Local| {
        let program = build(script(), of.len()).expect("a program");
        let place = Partition::new(of.to_vec(), network.rank(), ranks);
        let mut warehouse = warehouse(&program, particles, (of.len(), place));
        let mut engine = Engine::new(Box::new(Serial), Isa::detect(), &warehouse);
        for _ in 0..steps {
            engine.execute(&program, &mut warehouse, &mut network, &mut Anything).expect("a step");
        }
        state(&warehouse)
    };
    let states: Vec<State> = std::thread::scope(|scope| {
        let ranks: Vec<_> = Local::crew(ranks).into_iter().map(|rank| scope.spawn(|| work(rank))).collect();
        ranks.into_iter().map(|rank| rank.join().expect("a rank")).collect()
    });
    let mut all = State { shared: states[0].shared.clone(), ..State::default() };
    for state in states {
        assert_eq!(state.shared, all.shared, "ranks differ in what is the same everywhere");
        all.particles.extend(state.particles);
        all.nodes.extend(state.nodes);
    }
    all
}

fn warehouse(
    program: &Program,
    particles: &[Particle],
    (patches, partition): (usize, Partition),
) -> Warehouse {
    let level = Level { lower: [0.0; 3], cell: 1.0, cells: [CELLS, 0, 0] };
    let cut = Decomposition::new(&level, [patches, 1, 1]).expect("patches that fit");
    let labels = [Position::ID, Identity::ID, Charge::ID, Way::ID, Seen::ID];
    let matter = ["a", "b"]
        .map(|name| MaterialData { interacts: vec![false; 2], ..MaterialData::new(&SCHEMA, name, labels) });
    let mut warehouse = Warehouse::new(&SCHEMA, level, (cut, partition), matter.into(), program.labels());
    for (identity, &(material, x, charge, way)) in (0..).zip(particles) {
        let (_, patch) = warehouse.home(material, [x, 0.0, 0.0]).expect("in the level");
        if warehouse.partition.is_mine(patch) {
            let record = [x, 0.0, 0.0, f64::from_bits(identity), charge, way, 0.0, 0.0];
            warehouse.insert(material, [x, 0.0, 0.0], &record).expect("in the level");
        }
    }
    warehouse
}

fn state(warehouse: &Warehouse) -> State {
    let mut state = State::default();
    for (material, block) in warehouse.blocks() {
        let layout = &warehouse.materials[material].layout;
        for p in 0..block.count {
            let get = |(label, component)| block.get(layout, label, p, component);
            let numbers = [(Position::ID, 0), (Seen::ID, 0), (Seen::ID, 1)].map(get);
            state.particles.insert(get((Identity::ID, 0)).to_bits(), numbers);
        }
    }
    let shape = warehouse.level.shape();
    for block in warehouse.partition.mine().flat_map(|patch| &warehouse.nodes[patch].blocks) {
        for &field in &block.present {
            let lines = block.lines(&warehouse.node_layout, Kept::ID, field).unwrap_or_default();
            for (n, kept) in lines.as_chunks::<2>().0.iter().enumerate() {
                let kept = [0, 1].map(|i| kept[i].0[0]);
                if kept != [0.0; 2] {
                    let node = shape.first_node(block.index)[0] + shape.place(n)[0];
                    state.nodes.insert((node, field.index()), kept);
                }
            }
        }
    }
    let of_run = [Most::ID, NodeMost::ID, Counted::ID, OwnMost::ID];
    state.shared =
        of_run.iter().flat_map(|&label| warehouse.shared.column(label)).map(|line| line.0[0]).collect();
    state
}
