//! What runs: stages of fused tasks, and phases of stages that may run at the same time.
use super::adders::Adders;
use super::recipe::TaskNode;
use super::task::{Access, Declaration, Domain, Mode};
use crate::schema::{Home, LabelId, Life, Schema};
use petgraph::stable_graph::NodeIndex;
use std::collections::BTreeSet;

/// Tasks that run together.
#[derive(Clone, Debug)]
pub struct Stage {
    /// What they run over (`Particles` also for tasks on near particles only).
    pub domain: Domain,
    /// The material of particle stages.
    pub material: Option<usize>,
    /// Their lines of the recipe, in order.
    pub entries: Vec<usize>,
    /// Of them, those that adapt the buffer before its particles read it.
    pub before: Vec<Line>,
    /// Those that run chunk by chunk of particles, or on nodes, or once.
    pub chunks: Vec<Line>,
    /// Those that change what all particles of the block have added.
    pub after: Vec<Line>,
    /// Their nodes in the graph, in the order of `entries`.
    pub nodes: Vec<NodeIndex>,
    /// Labels touched, each once, with the strongest access.
    pub touched: Vec<Access>,
    /// At which end of a material's own step they run (particle stages).
    pub when: When,
    /// Labels of nodes that particles add to.
    pub adds: Vec<LabelId>,
    /// Those of them to which no stage of the material has added since they were added up last.
    pub begins: Vec<LabelId>,
    /// Labels of nodes that particles read.
    pub reads: Vec<LabelId>,
    /// Labels of nodes whose partial sums a stage over nodes adds up.
    pub sums: Vec<LabelId>,
    /// Who has added to them since they were added up last.
    pub adders: Adders,
    /// Who has added to them in this graph, but not since then: what they have stays. Of others there is nothing.
    pub kept: Adders,
    /// Materials that have added to nodes in this graph, and other ranks do not know yet to which: whether a block of nodes is touched
    /// does not depend on them.
    pub unknown: BTreeSet<usize>,
    /// Labels of nodes to which particles added before, and whose partial sums nobody needs any more.
    pub releases: Vec<LabelId>,
    /// Whether it is over nodes and touches what they keep from step to step: it runs also where no particle touches them.
    pub everywhere: bool,
}

/// A line of the recipe in a stage over particles.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Which one.
    pub entry: usize,
    /// Whether it runs only where particles are near others.
    pub near: bool,
}

/// When in the step of a material a stage runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// When it begins: particles add to nodes.
    Begin,
    /// When it ends: particles read nodes.
    End,
}

impl Stage {
    /// A stage without tasks.
    pub(super) fn new(domain: Domain, material: Option<usize>) -> Self {
        let (entries, nodes, touched, when) = (Vec::new(), Vec::new(), Vec::new(), When::End);
        let [before, chunks, after] = [const { Vec::new() }; 3];
        let [adds, begins, reads, sums, releases] = [const { Vec::new() }; 5];
        let ([adders, kept], everywhere) = ([const { Adders::new() }; 2], false);
        Self {
            domain,
            material,
            entries,
            before,
            chunks,
            after,
            nodes,
            touched,
            when,
            adds,
            begins,
            reads,
            sums,
            adders,
            kept,
            unknown: BTreeSet::new(),
            releases,
            everywhere,
        }
    }

    /// One more task, of a line of the recipe.
    pub(super) fn push(&mut self, node: NodeIndex, task: &TaskNode) {
        let Declaration { domain, access, .. } = task.declaration;
        self.entries.push(task.entry);
        self.nodes.push(node);
        let order = match domain {
            Domain::Buffers if access.iter().any(|a| a.mode.writes()) => &mut self.after,
            Domain::Buffers => &mut self.before,
            _ => &mut self.chunks,
        };
        order.push(Line { entry: task.entry, near: domain == Domain::NearParticles });
        access.iter().for_each(|&access| merge(&mut self.touched, access));
        let adds = access.iter().any(|a| a.label.home() == Home::Node && a.mode.writes());
        if self.domain == Domain::Particles && adds {
            self.when = When::Begin;
        }
    }

    /// Fills in what particles add to and read of nodes.
    fn complete(&mut self) {
        let of_nodes = |a: &&Access| a.label.home() == Home::Node && self.domain == Domain::Particles;
        let labels = |wanted: fn(Mode) -> bool| {
            let mine = self.touched.iter().filter(of_nodes).filter(move |a| wanted(a.mode));
            mine.map(|a| a.label).collect()
        };
        (self.adds, self.reads) = (labels(Mode::writes), labels(Mode::reads));
        let keeps = |a: &Access| a.label.home() == Home::Node && a.label.life() == Life::Carried;
        self.everywhere = self.domain == Domain::Nodes && self.touched.iter().any(keeps);
    }

    /// Whether some task of the stage touches `label` in a way that `test` accepts.
    pub fn touches(&self, label: LabelId, test: impl Fn(Mode) -> bool) -> bool {
        self.touched.iter().any(|a| a.label == label && test(a.mode))
    }
}

/// Stages without edges between them.
#[derive(Clone, Debug, Default)]
pub struct Phase {
    /// The stages: several only if all run over particles, of different materials, in their order.
    pub stages: Vec<Stage>,
    /// Labels of home `Material` and `Run` that they touch, and whether they reduce them.
    pub shared: Vec<(LabelId, bool)>,
    /// Those that no earlier phase reduces: labels, and the materials for which it does (0 for labels of the run).
    pub afresh: Vec<(LabelId, usize)>,
    /// Whether it decides which materials act in the phases that follow.
    pub decides: bool,
    /// Whether it is the last one over nodes: they have gone through the tick then.
    pub settles: bool,
    /// Labels of nodes that it reads beyond the faces of patches: other ranks must have sent theirs.
    pub halos: Vec<LabelId>,
    /// The exchanges that bring them (indices of the graph's).
    pub receives: Vec<usize>,
    /// The exchanges that send what it is the last to write.
    pub sends: Vec<usize>,
    /// Labels that earlier phases reduced and that it reads: the parts of all ranks must be together.
    pub reductions: Vec<LabelId>,
}

impl Phase {
    /// Whether it runs over nodes.
    pub fn is_over_nodes(&self) -> bool {
        self.stages.first().is_some_and(|stage| stage.domain == Domain::Nodes)
    }

    /// Fills in what follows from the stages; `begun` are the labels that earlier phases reduce, for which of so many materials.
    pub(super) fn complete(
        &mut self,
        schema: &Schema,
        materials: usize,
        begun: &mut BTreeSet<(LabelId, usize)>,
    ) {
        self.stages.iter_mut().for_each(Stage::complete);
        let touched = self.stages.iter().flat_map(|s| &s.touched);
        let shared: BTreeSet<_> =
            touched.filter(|a| a.label.is_shared()).map(|a| (a.label, a.reduces())).collect();
        self.shared = shared.into_iter().collect();
        let reduced = self.stages.iter().flat_map(|stage| {
            let reduced = stage.touched.iter().filter(|a| a.label.is_shared() && a.reduces());
            reduced.flat_map(move |a| {
                let of = match (a.label.home(), stage.material) {
                    (Home::Material, Some(material)) => material..material + 1,
                    (Home::Material, None) => 0..materials,
                    _ => 0..1,
                };
                of.map(|material| (a.label, material))
            })
        });
        self.afresh = reduced.filter(|&key| begun.insert(key)).collect();
        let writes_steps = |steps| self.stages.iter().any(|s| s.touches(steps, Mode::writes));
        self.decides = schema.steps().is_some_and(writes_steps);
    }
}

fn merge(touched: &mut Vec<Access>, access: Access) {
    match touched.iter_mut().find(|a| a.label == access.label) {
        Some(known) if !known.mode.writes() && access.mode.writes() => known.mode = Mode::Modifies,
        Some(known) => known.ghost = known.ghost.max(access.ghost),
        None => touched.push(access),
    }
}
