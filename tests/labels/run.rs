//! The toy on the engine: on any patches, threads and ranks.
use crate::state::{Start, State};
use crate::toy::*;
use engine::data::exact_sum::ExactSum;
use engine::data::layout::ParticleLayout;
use engine::exec::ranks::Network;
use engine::exec::ranks::local::Local;
use engine::exec::{Engine, Undirected};
use engine::prelude::*;
use engine::schema::LabelId;
use engine::simd::Isa;

/// Patches, their ranks, and when they change them.
#[derive(Clone, Debug)]
pub struct Layout {
    pub patches: [usize; 3],
    pub ranks: usize,
    /// The ranks of the patches at the start, and those after the `moves`-th step.
    pub of: [Vec<u32>; 2],
    pub moves: usize,
    pub threads: usize,
}

impl Layout {
    /// One patch and one rank.
    pub fn alone() -> Self {
        Self { patches: [1; 3], ranks: 1, of: [vec![0], vec![0]], moves: 0, threads: 1 }
    }
}

pub fn level(cells: [usize; 3]) -> Level {
    Level { lower: [0.0; 3], cell: 1.0, cells }
}

/// The materials of a start.
fn materials(start: &Start) -> Vec<MaterialData> {
    let all = [Position::ID, Identity::ID, Velocity::ID, Charge::ID, Whole::ID, Seen::ID, Memory::ID];
    let of = |m: usize| MaterialData {
        layout: ParticleLayout::new(&SCHEMA, all, [(Memory::ID, vec![0.5; start.memory[m]])].into()),
        fields: start.fields[m],
        interacts: start.interacts[m].clone(),
        ..MaterialData::new(&SCHEMA, &format!("matter {m}"), [])
    };
    (0..start.fields.len()).map(of).collect()
}

/// A warehouse without particles.
pub fn empty(start: &Start, layout: &Layout, program: &Program, (of, rank): (&[u32], usize)) -> Warehouse {
    let level = level(start.cells);
    let cut = Decomposition::new(&level, layout.patches).expect("patches that fit");
    let partition = Partition::new(of.to_vec(), rank, layout.ranks);
    Warehouse::new(&SCHEMA, level, (cut, partition), materials(start), program.labels())
}

/// One with this rank's particles.
pub fn warehouse(start: &Start, layout: &Layout, program: &Program, rank: usize) -> Warehouse {
    let mut warehouse = empty(start, layout, program, (&layout.of[0], rank));
    for (identity, p) in (0..).zip(&start.particles) {
        let (_, patch) = warehouse.home(p.material, p.x).expect("in the level");
        if warehouse.partition.is_mine(patch) {
            let mut record =
                [&p.x[..], &[f64::from_bits(identity)], &p.velocity, &[p.charge, p.whole]].concat();
            record.resize(record.len() + 4 + start.memory[p.material], 0.0);
            warehouse.insert(p.material, p.x, &record).expect("in the level");
        }
    }
    warehouse
}

/// Runs some steps; patches change their ranks among them.
pub fn steps(
    (engine, warehouse, network): (&mut Engine, &mut Warehouse, &mut dyn Network),
    program: &Program,
    layout: &Layout,
    steps: usize,
) {
    for step in 0..steps {
        engine.execute(program, warehouse, network, &mut Undirected).expect("a step");
        if step + 1 == layout.moves && layout.ranks > 1 {
            let partition = Partition::new(layout.of[1].clone(), network.rank(), layout.ranks);
            engine.migrate(partition, warehouse, network).expect("a move");
        }
    }
}

/// Runs `work` on as many ranks as the layout has, each a thread, and joins what they have.
pub fn together(layout: &Layout, work: impl Fn(Local) -> State + Sync) -> State {
    let ranks: Vec<State> = std::thread::scope(|scope| {
        let threads: Vec<_> =
            Local::crew(layout.ranks).into_iter().map(|rank| scope.spawn(|| work(rank))).collect();
        threads.into_iter().map(|rank| rank.join().expect("a rank")).collect()
    });
    let mut all = State::default();
    ranks.into_iter().for_each(|state| all.join(state));
    all
}

/// The state after some steps.
pub fn run(start: &Start, layout: &Layout, count: usize) -> State {
    use engine::exec::{Serial, Threads};
    together(layout, |mut network| {
        let program =
            program(&start.fields, start.cells, layout.patches.iter().product()).expect("a program");
        let mut warehouse = warehouse(start, layout, &program, network.rank());
        if layout.threads == 1 {
            let mut engine = Engine::new(Box::new(Serial), Isa::detect(), &warehouse);
            steps((&mut engine, &mut warehouse, &mut network), &program, layout, count);
        } else {
            let threads = Threads::new(layout.threads).expect("threads");
            let mut engine = Engine::new(Box::new(threads), Isa::detect(), &warehouse);
            steps((&mut engine, &mut warehouse, &mut network), &program, layout, count);
        }
        state(&warehouse)
    })
}

/// What a rank has.
pub fn state(warehouse: &Warehouse) -> State {
    let mut state = State::default();
    for (material, block) in warehouse.blocks() {
        let layout = &warehouse.materials[material].layout;
        for p in block.count..8 * block.tiles() {
            // lanes without a particle hold what the rows say
            assert_eq!(block.get(layout, Charge::ID, p, 0), 7.0);
            (0..layout.width(Memory::ID)).for_each(|c| assert_eq!(block.get(layout, Memory::ID, p, c), 0.5));
            let middle = warehouse.level.middle(block.index);
            (0..3).for_each(|a| assert_eq!(block.get(layout, Position::ID, p, a), middle[a]));
        }
        for p in 0..block.count {
            let numbers =
                |label: LabelId| (0..layout.width(label)).map(move |c| block.get(layout, label, p, c));
            let all = numbers(Position::ID).chain(numbers(Seen::ID)).chain(numbers(Memory::ID));
            let identity = block.get(layout, Identity::ID, p, 0).to_bits();
            let before = state.particles.insert(identity, all.map(f64::to_bits).collect());
            assert_eq!(before, None, "particle {identity} is there twice");
        }
    }
    for block in warehouse.partition.mine().flat_map(|patch| &warehouse.nodes[patch].blocks) {
        let (shape, layout) = (warehouse.level.shape(), &warehouse.node_layout);
        for (label, &field) in
            layout.carried().flat_map(|label| block.present.iter().map(move |f| (label, f)))
        {
            let lines = block.lines(layout, label, field).unwrap_or_default();
            for (n, node) in lines.chunks_exact(label.width()).enumerate() {
                let (first, place) = (shape.first_node(block.index), shape.place(n));
                state.node(label.name(), field.index(), [0, 1, 2].map(|a| first[a] + place[a]), node);
            }
        }
    }
    shared(warehouse, &mut state);
    state
}

fn shared(warehouse: &Warehouse, state: &mut State) {
    for label in [RunMost::ID, RunFirst::ID, Steps::ID, Rounds::ID, OwnMost::ID, OwnFirst::ID, OwnSteps::ID] {
        state.line(label.name(), warehouse.shared.column(label));
    }
    for label in [RunExact::ID, OwnExact::ID] {
        let sums: &[ExactSum] = engine::bytemuck::cast_slice(warehouse.shared.column(label));
        state.value(label.name(), &sums.iter().map(ExactSum::value).collect::<Vec<_>>());
    }
}
