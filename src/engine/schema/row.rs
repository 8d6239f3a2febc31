use grid::REACH;
use simd::Wide;

/// Where a label lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Home {
    /// A particle column: moves with the particle.
    Particle,
    /// Scratch of one thread: exists only inside one fused chunk of particles.
    Chunk,
    /// Some lines a node and velocity field.
    Node,
    /// Some lines a block of particles.
    Block,
    /// Some lines a material.
    Material,
    /// Some lines, the same everywhere.
    Run,
}

/// How contributions to a label combine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Combine {
    /// Written once.
    None,
    /// Floating-point sums, in the order of blocks.
    Sum,
    /// Exact sums, in any order (`data::exact_sum`).
    Exact,
    /// Lane by lane the largest, in any order.
    Max,
    /// Each line: the one with the smallest (lane 0, lane 1), in any order.
    First,
}

impl Combine {
    /// Whether a part that comes twice counts twice.
    pub fn is_sum(self) -> bool {
        matches!(self, Self::Sum | Self::Exact)
    }
}

/// How long a label lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Life {
    /// While a chunk of particles is worked on.
    Chunk,
    /// While a stage works on a block.
    Stage,
    /// From its producer to the end of the graph.
    Tick,
    /// From graph to graph of a step: it is gone when the step is over.
    Step,
    /// From step to step: in checkpoints, and with patches that change their rank.
    Carried,
}

/// How a label of nodes crosses blocks and ranks, and with how many layers of ghosts it may be declared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crossing {
    /// Not at all.
    None,
    /// Each block of particles has partial sums for the nodes that it touches; neighbors get theirs.
    Partials(u8),
    /// Blocks of particles read the values of the nodes around them.
    Values(u8),
}

/// What lanes of a particle column hold that have no particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Inert {
    /// Zeros.
    Zero,
    /// These numbers, one a line of the tile.
    Numbers(&'static [f64]),
    /// The middle of their block [m].
    Middle,
    /// What the material says.
    OfMaterial,
}

/// All that there is to say about a label.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    pub(super) index: usize,
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) meaning: &'static str,
    pub(super) home: Home,
    pub(super) width: usize,
    pub(super) by_material: bool,
    pub(super) inert: Inert,
    pub(super) combine: Combine,
    pub(super) life: Life,
    pub(super) crossing: Crossing,
    pub(super) where_fields_meet: bool,
    pub(super) several: bool,
    pub(super) where_near: bool,
    pub(super) known: bool,
}

const fn row(home: Home, life: Life, unit: &'static str, meaning: &'static str) -> Row {
    Row {
        index: 0,
        name: "",
        unit,
        meaning,
        home,
        width: 0,
        by_material: false,
        inert: Inert::Zero,
        combine: Combine::None,
        life,
        crossing: Crossing::None,
        where_fields_meet: false,
        several: false,
        where_near: false,
        known: false,
    }
}

/// A label of particles: carried from step to step.
pub const fn particle(unit: &'static str, meaning: &'static str) -> Row {
    row(Home::Particle, Life::Carried, unit, meaning)
}

/// A label of a chunk of particles.
pub const fn chunk(unit: &'static str, meaning: &'static str) -> Row {
    row(Home::Chunk, Life::Chunk, unit, meaning)
}

/// A label of nodes: written by tasks over nodes, gone after the tick.
pub const fn node(unit: &'static str, meaning: &'static str) -> Row {
    row(Home::Node, Life::Tick, unit, meaning)
}

/// A label of blocks of particles: carried.
pub const fn block(unit: &'static str, meaning: &'static str) -> Row {
    row(Home::Block, Life::Carried, unit, meaning)
}

/// A label of materials: gone after the tick.
pub const fn material(unit: &'static str, meaning: &'static str) -> Row {
    row(Home::Material, Life::Tick, unit, meaning)
}

/// A label of the run: gone after the tick.
pub const fn run(unit: &'static str, meaning: &'static str) -> Row {
    row(Home::Run, Life::Tick, unit, meaning)
}

impl Row {
    /// Lanes without a particle hold `numbers`, one a line of the tile.
    pub const fn inert(self, numbers: &'static [f64]) -> Self {
        Self { inert: Inert::Numbers(numbers), ..self }
    }

    /// Lanes without a particle lie in the middle of their block.
    pub const fn in_the_middle(self) -> Self {
        Self { inert: Inert::Middle, ..self }
    }

    /// Each material decides how many elements a tile has, and what lanes without a particle hold.
    pub const fn by_material(self) -> Self {
        Self { by_material: true, inert: Inert::OfMaterial, ..self }
    }

    /// What it holds is known from the start of a run: it is there for those who look, no part of the state, and in no checkpoint.
    pub const fn known(self) -> Self {
        Self { known: true, ..self }
    }

    /// Contributions add up exactly.
    pub const fn exact(self) -> Self {
        Self { combine: Combine::Exact, ..self }
    }

    /// The largest of each number counts.
    pub const fn largest(self) -> Self {
        Self { combine: Combine::Max, ..self }
    }

    /// The first of a key counts (see [`Combine::First`]).
    pub const fn first(self) -> Self {
        Self { combine: Combine::First, ..self }
    }

    /// It lives so long.
    pub const fn lives(self, life: Life) -> Self {
        Self { life, ..self }
    }

    /// Particles add to it, up to so many layers of nodes beyond their block; it lives for a stage over nodes, unless
    /// [`Row::lives`] says otherwise. Contributions are sums in the order of blocks, unless something else is said.
    pub const fn partials(self, ghosts: u8) -> Self {
        let combine = if matches!(self.combine, Combine::None) { Combine::Sum } else { self.combine };
        let life = if matches!(self.life, Life::Tick) { Life::Stage } else { self.life };
        Self { crossing: Crossing::Partials(ghosts), combine, life, ..self }
    }

    /// Particles read it, up to so many layers of nodes beyond their block.
    pub const fn values(self, ghosts: u8) -> Self {
        Self { crossing: Crossing::Values(ghosts), ..self }
    }

    /// It is there only where velocity fields meet that interact.
    pub const fn where_fields_meet(self) -> Self {
        Self { where_fields_meet: true, ..self }
    }

    /// Only particles add to it that are near others, or near what the application says (`Warehouse::nearby`).
    pub const fn where_near(self) -> Self {
        Self { where_near: true, ..self }
    }

    /// It has as many tiles as the recipe says (`Recipe::tiles`).
    pub const fn several(self) -> Self {
        Self { several: true, ..self }
    }

    /// Completes the row: for [`labels!`](crate::labels!).
    ///
    /// # Panics
    /// Where a row makes no sense: while it is compiled.
    #[doc(hidden)]
    pub const fn declare(self, index: usize, name: &'static str, bytes: usize) -> Self {
        let width = bytes / size_of::<Wide>();
        assert!(
            bytes.is_multiple_of(size_of::<Wide>()) && width > 0,
            "a tile is a number of lines of eight doubles, as [Wide; 3] or a struct of such"
        );
        let on_nodes = matches!(self.home, Home::Node);
        match self.crossing {
            Crossing::Partials(ghosts) | Crossing::Values(ghosts) => {
                assert!(on_nodes, "only labels of nodes cross blocks");
                assert!(ghosts <= REACH, "more layers of ghosts than are stored");
            }
            Crossing::None => {}
        }
        let partial = matches!(self.crossing, Crossing::Partials(_));
        assert!(
            !on_nodes || partial == !matches!(self.combine, Combine::None),
            "what combines on nodes is partial"
        );
        assert!(
            on_nodes || !matches!(self.combine, Combine::Sum),
            "only nodes are summed in the order of blocks"
        );
        assert!(!self.where_fields_meet || on_nodes, "fields meet on nodes");
        assert!(!self.where_near || partial, "particles add to partial sums alone");
        let run = matches!(self.home, Home::Run);
        assert!(
            !self.several || run,
            "the number of tiles is that of materials, blocks or particles elsewhere"
        );
        assert!(
            matches!(self.home, Home::Chunk) == matches!(self.life, Life::Chunk),
            "a chunk label lives in a chunk"
        );
        assert!(partial || !matches!(self.life, Life::Stage), "only partial sums live for a stage");
        let kept = matches!(self.home, Home::Particle | Home::Block);
        assert!(!kept || matches!(self.life, Life::Carried), "labels of particles and blocks are carried");
        assert!(!self.by_material || matches!(self.home, Home::Particle), "materials decide about particles");
        assert!(
            !matches!(self.combine, Combine::Exact) || width.is_multiple_of(9),
            "an exact sum takes nine lines: let the tile be an ExactSum, or an array of them"
        );
        Self { index, name, width, ..self }
    }
}
