//! Programs as they run: their graphs one after the other, loops until they are done.
use super::Engine;
use super::backend::Purpose;
use super::meter::What;
use super::order::{self, Op};
use super::ranks::{Network, NetworkError};
use super::relocate::Relocation;
use super::trace::{Event, Kind};
use super::traveler::Traveler;
use super::work::Blocks;
use crate::data::shared::Shared;
use crate::data::warehouse::{MaterialData, Warehouse};
use crate::graph::build::TaskGraph;
use crate::program::{Loop, Program, ProgramNode};
use crate::schema::Home;

/// What an application decides while a program runs.
pub trait Conductor {
    /// Why it stops a program.
    type Error: From<NetworkError>;

    /// Whether a particle outside of the level is put back into it, at its position then; it may contribute to shared labels.
    fn puts_back(
        &mut self,
        _particle: &mut Traveler,
        _materials: &[MaterialData],
        _shared: &mut Shared,
    ) -> bool {
        false
    }

    /// Asked on each rank before the end of a graph after which particles may move: whether the program is to stop with it,
    /// for a reason that this rank may know alone. All learn it of [`Relocation::stopped`].
    fn wants_to_stop(&mut self) -> bool {
        false
    }

    /// A graph has run, and its reductions are complete; particles that change their block have not moved yet, and those
    /// outside of the level are still there.
    ///
    /// # Errors
    /// What stops the program.
    fn ran(
        &mut self,
        _graph: &TaskGraph,
        _warehouse: &Warehouse,
        _relocation: &Relocation,
    ) -> Result<(), Self::Error> {
        Ok(())
    }

    /// A loop has ended after some rounds: because its label said so, or because there were too many.
    ///
    /// # Errors
    /// What stops the program.
    fn looped(
        &mut self,
        _loop: &Loop,
        _rounds: u64,
        _enough: bool,
        _warehouse: &Warehouse,
    ) -> Result<(), Self::Error> {
        Ok(())
    }
}

/// Lets everything happen, but a loop that does not end as its label says, and particles that leave the level.
#[derive(Clone, Copy, Debug, Default)]
pub struct Undirected;

/// Why a program that nobody conducts stopped.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Stopped {
    /// Ranks that cannot go on together.
    #[error("{0}")]
    Network(#[from] NetworkError),
    /// A loop that had as many rounds as it may have.
    #[error("{label} did not hold after {rounds} rounds")]
    Rounds {
        /// The label that the loop waits for.
        label: &'static str,
        /// How many rounds.
        rounds: u64,
    },
    /// Particles outside of the level.
    #[error(
        "{count} particles left the level, the first, {identity}, of {material} at {position:?}: a `Conductor` may put them back or let them go"
    )]
    Left {
        /// How many.
        count: usize,
        /// The first of them.
        identity: u64,
        /// Its material.
        material: String,
        /// Where it is [m].
        position: [f64; 3],
    },
}

impl Conductor for Undirected {
    type Error = Stopped;

    fn ran(
        &mut self,
        _graph: &TaskGraph,
        warehouse: &Warehouse,
        relocation: &Relocation,
    ) -> Result<(), Stopped> {
        let left = relocation.left();
        let Some(&Traveler { identity, material, position, .. }) = left.first() else { return Ok(()) };
        let material = warehouse.materials[material].name.clone();
        Err(Stopped::Left { count: left.len(), identity, material, position })
    }

    fn looped(
        &mut self,
        it: &Loop,
        rounds: u64,
        enough: bool,
        _warehouse: &Warehouse,
    ) -> Result<(), Stopped> {
        if enough { Ok(()) } else { Err(Stopped::Rounds { label: it.until.name(), rounds }) }
    }
}

impl Engine {
    /// Runs a program once.
    ///
    /// # Errors
    /// What the conductor says, or a rank that is gone.
    ///
    /// # Panics
    /// If a material of the warehouse lacks a label that its tasks use.
    pub fn execute<C: Conductor>(
        &mut self,
        program: &Program,
        warehouse: &mut Warehouse,
        network: &mut dyn Network,
        conductor: &mut C,
    ) -> Result<(), C::Error> {
        self.begin_program();
        self.backend.upload(Purpose::Program, &mut Blocks::of(warehouse));
        let done = self.nodes(&program.nodes, warehouse, network, conductor);
        self.backend.download(Purpose::Program, &mut Blocks::of(warehouse));
        done
    }

    fn nodes<C: Conductor>(
        &mut self,
        nodes: &[ProgramNode],
        warehouse: &mut Warehouse,
        network: &mut dyn Network,
        conductor: &mut C,
    ) -> Result<(), C::Error> {
        for node in nodes {
            match node {
                ProgramNode::Graph(graph) => self.graph(graph, warehouse, network, conductor)?,
                ProgramNode::Loop(it) => {
                    let (mut rounds, mut enough) = (0, false);
                    while !enough && rounds < it.most {
                        self.nodes(&it.body, warehouse, network, conductor)?;
                        rounds += 1;
                        enough = warehouse.shared.column(it.until)[0].0[0] != 0.0;
                    }
                    conductor.looped(it, rounds, enough, warehouse)?;
                }
            }
        }
        Ok(())
    }

    fn graph<C: Conductor>(
        &mut self,
        graph: &TaskGraph,
        warehouse: &mut Warehouse,
        network: &mut dyn Network,
        conductor: &mut C,
    ) -> Result<(), C::Error> {
        has_labels(graph, warehouse);
        self.trace.set_graph(graph.number);
        self.run(graph, warehouse, network)?;
        if order::end(graph) == [Op::ReduceAtEnd] {
            self.reduce(graph, None, &mut warehouse.shared, network)?;
            return conductor.ran(graph, warehouse, &Relocation::default());
        }
        let stop = conductor.wants_to_stop();
        let mut puts_back = |particle: &mut Traveler, materials: &[MaterialData], shared: &mut Shared| {
            conductor.puts_back(particle, materials, shared)
        };
        self.backend.download(Purpose::Relocation, &mut Blocks::of(warehouse));
        let relocation = self.relocate(graph, warehouse, network, &mut puts_back, stop)?;
        conductor.ran(graph, warehouse, &relocation)?;
        let began = self.trace.now();
        self.metered(What::Relocation, || relocation.carry_out(warehouse, &*self.backend));
        self.backend.upload(Purpose::Relocation, &mut Blocks::of(warehouse));
        self.trace.record(0, began, Event::other(Kind::Arrange));
        Ok(())
    }
}

/// Materials have what their tasks use: their blocks were laid out by somebody who may not know the program.
fn has_labels(graph: &TaskGraph, warehouse: &Warehouse) {
    for stage in graph.phases.iter().flat_map(|phase| &phase.stages) {
        let Some(material) = stage.material.map(|material| &warehouse.materials[material]) else { continue };
        let labels = stage.touched.iter().map(|access| access.label);
        for label in labels.filter(|label| label.home() == Home::Particle && !label.by_material()) {
            assert!(
                material.layout.width(label) > 0,
                "material {} has no {}, which a task of graph {:?} uses: give it to `MaterialData::new`; \
                 `Program::particle_labels` says which there are",
                material.name,
                label.name(),
                graph.name
            );
        }
    }
}
