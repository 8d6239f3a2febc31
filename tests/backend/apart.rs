//! A backend with memory of its own: in the host's, labels of blocks hold nothing but poison, except where a stage or the host
//! asks for them.
use engine::data::fields::FieldId;
use engine::data::layout::NodeLayout;
use engine::data::nodes::NodeBlock;
use engine::data::particles::ParticleBlock;
use engine::data::spread::Spread;
use engine::data::warehouse::MaterialData;
use engine::exec::backend::Purpose;
use engine::exec::ranks::halos::{Incoming, Outgoing};
use engine::exec::work::{Blocks, Call, Which, acts};
use engine::exec::{Backend, Serial};
use engine::graph::exchange::Way;
use engine::graph::phase::{Phase, Stage};
use engine::schema::{Home, LabelId, Life};
use grid::BlockIndex;
use simd::{LANES, Wide};
use std::collections::HashMap;
use std::sync::Mutex;

/// What the host finds where it did not ask.
const POISON: Wide = Wide([f64::NAN; LANES]);

/// The material of a particle block, the field of nodes of a block, and where it is.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Owner {
    Particles(usize, BlockIndex),
    Nodes(FieldId, BlockIndex),
}

/// The labels of blocks.
#[derive(Default)]
struct Memory(HashMap<(Owner, LabelId), Vec<Wide>>);

impl Memory {
    /// Brings a column of a block to the host.
    fn bring(&self, key: (Owner, LabelId), column: &mut [Wide]) {
        if let Some(kept) = self.0.get(&key).filter(|kept| kept.len() == column.len()) {
            column.copy_from_slice(kept);
        }
    }

    /// Keeps the first `used` lines of a column, and leaves poison.
    fn keep(&mut self, key: (Owner, LabelId), column: &mut [Wide], used: usize) {
        let kept = self.0.entry(key).or_default();
        kept.resize(column.len(), POISON);
        kept[..used].copy_from_slice(&column[..used]);
        column.fill(POISON);
    }
}

/// Whether a label is meant.
type Wanted<'a> = &'a dyn Fn(LabelId) -> bool;

/// Runs what the serial backend runs.
#[derive(Default)]
pub struct Apart {
    memory: Mutex<Memory>,
    /// A label that is not brought where stages ask for it: an error that must be seen.
    withheld: Option<LabelId>,
}

impl Apart {
    /// One that lies.
    pub fn without(label: LabelId) -> Self {
        Self { withheld: Some(label), ..Self::default() }
    }
}

/// Runs `each(key, column, lines in use)` on the columns of a block of particles: its labels, and its partial sums.
fn of_particles(
    (material, data): (usize, &MaterialData),
    layout: &NodeLayout,
    block: &mut ParticleBlock,
    mut each: impl FnMut((Owner, LabelId), &mut [Wide], usize),
) {
    let (owner, tiles) = (Owner::Particles(material, block.index), block.tiles());
    let split = block.split(&data.layout);
    for (label, column) in split.columns {
        each((owner, label), column, tiles * data.layout.width(label));
    }
    for (&label, partial) in layout.partial().iter().zip(split.partials) {
        let used = partial.len();
        each((owner, label), partial, used);
    }
}

/// The same for a block of nodes.
fn of_nodes(layout: &NodeLayout, block: &mut NodeBlock, mut each: impl FnMut((Owner, LabelId), &mut [Wide])) {
    let index = block.index;
    for field in block.present.clone() {
        for &label in layout.stored() {
            if let Some(column) = block.lines_mut(layout, label, field) {
                each((Owner::Nodes(field, index), label), column);
            }
        }
    }
}

impl Apart {
    /// All labels of blocks of particles that are wanted, or all blocks of nodes: brought to the host, or kept.
    fn pass(&self, data: &mut Blocks<'_>, particles: Wanted<'_>, nodes: Wanted<'_>, bring: bool) {
        let mut memory = self.memory.lock().expect("memory");
        for homes in data.particles.iter_mut() {
            for (material, (home, data_of)) in homes.iter_mut().zip(data.materials).enumerate() {
                for block in &mut home.blocks {
                    of_particles((material, data_of), data.node_layout, block, |key, column, _| {
                        match (particles(key.1), bring) {
                            (false, _) => {}
                            (true, true) => memory.bring(key, column),
                            // the host knows what lanes without a particle hold
                            (true, false) => memory.keep(key, column, column.len()),
                        }
                    });
                }
            }
        }
        for block in data.nodes.iter_mut().flat_map(|patch| &mut patch.blocks) {
            of_nodes(data.node_layout, block, |key, column| match (nodes(key.1), bring) {
                (false, _) => {}
                (true, true) => memory.bring(key, column),
                (true, false) => {
                    let used = column.len();
                    memory.keep(key, column, used);
                }
            });
        }
    }

    /// Poison everywhere.
    fn spoil(data: &mut Blocks<'_>) {
        for homes in data.particles.iter_mut() {
            for (material, (home, data_of)) in homes.iter_mut().zip(data.materials).enumerate() {
                for block in &mut home.blocks {
                    of_particles((material, data_of), data.node_layout, block, |_, c, _| c.fill(POISON));
                }
            }
        }
        for block in data.nodes.iter_mut().flat_map(|patch| &mut patch.blocks) {
            of_nodes(data.node_layout, block, |_, column| column.fill(POISON));
        }
    }

    /// Runs `each` on the blocks on which a stage over particles runs.
    fn each_of_stage(
        stage: &Stage,
        which: Which<'_>,
        data: &mut Blocks<'_>,
        mut each: impl FnMut((Owner, LabelId), &mut [Wide], usize),
    ) {
        let Some(material) = stage.material else { return };
        for patch in data.partition.mine() {
            let layers = which.layers();
            let slab = data.particles[patch][material].slab_mut(&layers);
            for (block, _) in slab.filter(|(block, _)| which.has(|| block.rim)) {
                of_particles((material, &data.materials[material]), data.node_layout, block, &mut each);
            }
        }
    }

    fn over_particles(&self, call: &mut Call<'_>, phase: &Phase, which: Which<'_>, data: &mut Blocks<'_>) {
        let stages = || phase.stages.iter().filter(|stage| acts(stage, call.context.schedule));
        let reads = |label| stages().any(|stage| stage.reads.contains(&label));
        self.pass(data, &|_| false, &|label| reads(label) && self.withheld != Some(label), true);
        for stage in stages() {
            let memory = self.memory.lock().expect("memory");
            Self::each_of_stage(stage, which, data, |key, column, _| {
                if stage.touches(key.1, |mode| mode.reads()) && self.withheld != Some(key.1) {
                    memory.bring(key, column);
                }
            });
        }
        let stages: Vec<&Stage> = stages().collect();
        Serial.run(call, phase, which, data);
        for stage in stages {
            let mut memory = self.memory.lock().expect("memory");
            Self::each_of_stage(stage, which, data, |key, column, used| {
                if stage.touches(key.1, |mode| mode.writes()) {
                    memory.keep(key, column, used);
                }
            });
        }
    }

    fn over_nodes(&self, call: &mut Call<'_>, phase: &Phase, which: Which<'_>, data: &mut Blocks<'_>) {
        let Some(stage) = phase.stages.first() else { return };
        let given = |label| self.withheld != Some(label);
        let sums = |label| stage.sums.contains(&label) && given(label);
        let reads = |label| stage.touches(label, |mode| mode.reads()) && given(label);
        let writes = |label| stage.touches(label, |mode| mode.writes());
        // fields that wait keep what a task computes for the others
        self.pass(data, &sums, &|label| reads(label) || writes(label), true);
        Serial.run(call, phase, which, data);
        self.pass(data, &|_| false, &writes, false);
    }
}

impl Spread for Apart {
    fn spread(&self, count: usize, work: &(dyn Fn(usize) + Sync)) {
        Serial.spread(count, work);
    }
}

impl Backend for Apart {
    fn workers(&self) -> usize {
        Backend::workers(&Serial)
    }

    fn run(&self, call: &mut Call<'_>, phase: &Phase, which: Which<'_>, data: &mut Blocks<'_>) {
        match phase.is_over_nodes() {
            true => self.over_nodes(call, phase, which, data),
            false => self.over_particles(call, phase, which, data),
        }
        Self::spoil(data);
    }

    fn pack(&self, outgoing: &mut [Outgoing<'_>]) {
        Serial.pack(outgoing);
    }

    fn unpack(&self, incoming: &mut [Incoming<'_>]) {
        Serial.unpack(incoming);
    }

    fn download(&self, purpose: Purpose<'_>, data: &mut Blocks<'_>) {
        self.hand_over(purpose, data, true);
    }

    fn upload(&self, purpose: Purpose<'_>, data: &mut Blocks<'_>) {
        self.hand_over(purpose, data, false);
        Self::spoil(data);
    }
}

impl Apart {
    fn hand_over(&self, purpose: Purpose<'_>, data: &mut Blocks<'_>, bring: bool) {
        let (none, all): (Wanted<'_>, Wanted<'_>) = (&|_| false, &|_| true);
        let of_particles: Wanted<'_> = &|label| label.home() == Home::Particle;
        let carried: Wanted<'_> = &|label| label.life() == Life::Carried;
        match purpose {
            Purpose::Exchange(exchange) => {
                let labels: Wanted<'_> = &|label| exchange.labels.contains(&label);
                match exchange.way {
                    Way::Partials => self.pass(data, labels, none, bring),
                    Way::Values => self.pass(data, none, labels, bring),
                }
            }
            Purpose::Activation => self.pass(data, none, all, bring),
            Purpose::Relocation => self.pass(data, of_particles, none, bring),
            Purpose::Program if bring => self.pass(data, carried, carried, true),
            Purpose::Program => self.pass(data, all, all, false),
        }
    }
}
