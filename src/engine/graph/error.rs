//! What a graph refuses, by task, label and patch.
use crate::schema::LabelId;

/// A fault of a recipe: found when the graph is built, before anything runs.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GraphError {
    /// Nobody ever computes what a task requires.
    #[error("{task} requires {} on {patches}, which no task computes: add a producer before it, or drop the requirement", label.name())]
    NoProducer {
        /// The task that requires it.
        task: String,
        /// The label.
        label: LabelId,
        /// Where.
        patches: String,
    },
    /// The producer comes later in the recipe.
    #[error("{task} requires {} on {patches}, but {producer} computes it only later: list {producer} before {task}", label.name())]
    RequiresBeforeComputes {
        /// The task that requires it.
        task: String,
        /// The label.
        label: LabelId,
        /// The later producer.
        producer: String,
        /// Where.
        patches: String,
    },
    /// A task asks for the last step's value after it was overwritten.
    #[error("{task} requires the old {} on {patches}, but {writer} has overwritten it: list {task} before {writer}, or require the new value", label.name())]
    OldAfterWrite {
        /// The task that requires it.
        task: String,
        /// The label.
        label: LabelId,
        /// Who overwrote it.
        writer: String,
        /// Where.
        patches: String,
    },
    /// Two tasks compute the same label and nobody reads the first.
    #[error("{task} computes {} on {patches}, but nothing has read what {producer} computed: one of them is idle", label.name())]
    TwoProducers {
        /// The second producer.
        task: String,
        /// The label.
        label: LabelId,
        /// The first producer.
        producer: String,
        /// Where.
        patches: String,
    },
    /// A chunk label is required outside the fused stage that computes it.
    #[error("{task} requires {} on {patches}, which lives only in the chunk of {producer}: list {producer} again before {task}", label.name())]
    ChunkLabelEscapes {
        /// The task that requires it.
        task: String,
        /// The label.
        label: LabelId,
        /// Its producer.
        producer: String,
        /// Where.
        patches: String,
    },
    /// A task reads nodes as they are, though another one has adapted them for its block in another stage.
    #[error("{task} requires {}, which {adapter} adapts in the buffer of a block for its own stage alone: list {adapter} again before {task}", label.name())]
    CopyEscapes {
        /// The task that requires it.
        task: String,
        /// The label.
        label: LabelId,
        /// Who adapts it.
        adapter: String,
    },
    /// A task uses a label in a way for which there is no data where it runs.
    #[error("{task} {what} {}: {remedy}", label.name())]
    Misuse {
        /// The task.
        task: String,
        /// The label.
        label: LabelId,
        /// What it does, without the label.
        what: &'static str,
        /// What to do instead.
        remedy: &'static str,
    },
    /// A task over particles that names no ghosts of a label of nodes.
    #[error("{task} runs over particles and declares {} without ghosts, but particles reach nodes of other blocks: declare it with @ 1 to @ {most}, as far as they reach", label.name())]
    NoGhosts {
        /// The task.
        task: String,
        /// The label.
        label: LabelId,
        /// Layers that are stored.
        most: u8,
    },
    /// A label that lives for a stage is changed in one, and read in another.
    #[error("{task} requires {} on {patches} as {writer} left it, but it lives only in the stage of {writer}: let it live for a tick, or list nothing between them that needs all blocks", label.name())]
    StageLabelEscapes {
        /// The task that requires it.
        task: String,
        /// The label.
        label: LabelId,
        /// Who changed it.
        writer: String,
        /// Where.
        patches: String,
    },
    /// Partial sums that are to outlive their graph, and that nobody adds up in it.
    #[error("{task} adds to {}, which no task over nodes reads after it in the same graph, so that the parts never come together: read it there", label.name())]
    NeverSummed {
        /// The task that adds.
        task: String,
        /// The label.
        label: LabelId,
    },
    /// Particles add to a sum, move, and add again, to the same or another, before it is added up: parts are where particles are no
    /// longer.
    #[error("{task} adds to {}, and its particles have added to {} before {mover} moved them: let a task over nodes read the sum in between", label.name(), open.name())]
    AddsAfterMove {
        /// The task that adds again.
        task: String,
        /// The label.
        label: LabelId,
        /// The sum to which they have added before.
        open: LabelId,
        /// Who moved the particles.
        mover: String,
    },
    /// Ranks have brought their parts of a sum together, and another task adds to it in the same graph.
    #[error("{task} adds to {} after {reader} has read it in the same graph: what ranks have brought together would count once a rank; add to another label, or in a graph of its own", label.name())]
    AddsAfterReduction {
        /// The task that adds.
        task: String,
        /// The label.
        label: LabelId,
        /// Who has read it.
        reader: String,
    },
    /// A task moves particles, and their blocks do not hear of it.
    #[error("{task} changes {} and does not compute {}, so that nobody would see who leaves a block: compute it too, widened by each position (`data::extent::Bases`)", position.name(), extent.name())]
    MovesUnseen {
        /// The task.
        task: String,
        /// Where particles are.
        position: LabelId,
        /// How far those of a block reach.
        extent: LabelId,
    },
    /// A loop waits for a label that is not the same everywhere.
    #[error("a loop waits for {}, which is no plain number of the run: let a task that runs once compute one", label.name())]
    UntilWhat {
        /// The label.
        label: LabelId,
    },
    /// A loop that may not have a round.
    #[error("a loop until {} may have 0 rounds: let it have at least one", label.name())]
    NoRounds {
        /// What it waits for.
        label: LabelId,
    },
    /// A task names a label twice.
    #[error("{task} declares {} twice: once is enough, as what is strongest", label.name())]
    DeclaredTwice {
        /// The task.
        task: String,
        /// The label.
        label: LabelId,
    },
    /// A declaration asks for more ghost layers than are stored.
    #[error("{task} declares {} with {asked} ghost layers, but patch {patch} stores {stored}: declare at most so many, or let the row of {} say more, with partials(n) or values(n)", label.name(), label.name())]
    GhostTooWide {
        /// The task.
        task: String,
        /// The label.
        label: LabelId,
        /// Layers declared.
        asked: u8,
        /// Layers stored.
        stored: u8,
        /// The first patch where it fails.
        patch: usize,
    },
}
