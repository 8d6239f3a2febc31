use super::{Combine, Crossing, Home, Inert, Life, Row};
use bytemuck::Pod;
use std::cmp::Ordering;
use std::fmt;
use std::hash::{Hash, Hasher};

/// A quantity, known to the compiler as a zero-sized type: made by [`labels!`](crate::labels!).
pub trait Label {
    /// Its row in the schema.
    const ID: LabelId;
    /// Eight particles of the quantity, one node, or one material.
    type Tile: Pod;
}

/// A quantity, at run time.
#[derive(Clone, Copy)]
pub struct LabelId(&'static Row);

impl LabelId {
    /// The label of a row.
    pub const fn new(row: &'static Row) -> Self {
        Self(row)
    }
    /// Its place in the schema.
    #[inline(always)]
    pub const fn index(self) -> usize {
        self.0.index
    }
    /// Name in messages and dumps.
    pub const fn name(self) -> &'static str {
        self.0.name
    }
    /// SI unit.
    pub const fn unit(self) -> &'static str {
        self.0.unit
    }
    /// Symbol and meaning.
    pub const fn meaning(self) -> &'static str {
        self.0.meaning
    }
    /// Where it lives.
    #[inline(always)]
    pub const fn home(self) -> Home {
        self.0.home
    }
    /// Cache lines a tile (of those whose tiles materials decide: of one element).
    #[inline(always)]
    pub const fn width(self) -> usize {
        self.0.width
    }
    /// Whether each material decides how many elements a tile has.
    #[inline(always)]
    pub const fn by_material(self) -> bool {
        self.0.by_material
    }
    /// What lanes without a particle hold.
    pub const fn inert(self) -> Inert {
        self.0.inert
    }
    /// Whether it is known from the start, and so no part of the state.
    pub const fn is_known(self) -> bool {
        self.0.known
    }
    /// How contributions combine.
    #[inline(always)]
    pub const fn combine(self) -> Combine {
        self.0.combine
    }
    /// How long it lives.
    pub const fn life(self) -> Life {
        self.0.life
    }
    /// How it crosses blocks and ranks.
    #[inline(always)]
    pub const fn crossing(self) -> Crossing {
        self.0.crossing
    }
    /// Whether only blocks add to it whose particles are near something.
    #[inline(always)]
    pub const fn added_where_near(self) -> bool {
        self.0.where_fields_meet || self.0.where_near
    }
    /// Whether it has as many tiles as the recipe says.
    pub const fn is_several(self) -> bool {
        self.0.several
    }
    /// Whether it is there only where velocity fields meet that interact.
    #[inline(always)]
    pub const fn where_fields_meet(self) -> bool {
        self.0.where_fields_meet
    }
    /// The most layers of ghosts with which it may be declared.
    pub const fn ghosts(self) -> u8 {
        match self.0.crossing {
            Crossing::Partials(ghosts) | Crossing::Values(ghosts) => ghosts,
            Crossing::None => 0,
        }
    }
    /// Whether particles add to it, each block to a buffer of its own.
    #[inline(always)]
    pub const fn is_partial(self) -> bool {
        matches!(self.0.crossing, Crossing::Partials(_))
    }
    /// Whether contributions of blocks, threads and ranks come together in it, and nowhere else: of material or run.
    pub const fn is_reduced(self) -> bool {
        self.is_shared() && !matches!(self.0.combine, Combine::None)
    }
    /// Whether it is the same everywhere: of home `Material` or `Run`.
    #[inline(always)]
    pub const fn is_shared(self) -> bool {
        matches!(self.0.home, Home::Material | Home::Run)
    }
    /// Whether node blocks keep it from stage to stage.
    pub const fn is_stored_on_nodes(self) -> bool {
        matches!(self.0.home, Home::Node) && !matches!(self.0.life, Life::Stage)
    }
}

impl PartialEq for LabelId {
    fn eq(&self, other: &Self) -> bool {
        self.index() == other.index()
    }
}
impl Eq for LabelId {}
impl PartialOrd for LabelId {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for LabelId {
    fn cmp(&self, other: &Self) -> Ordering {
        self.index().cmp(&other.index())
    }
}
impl Hash for LabelId {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.index().hash(state);
    }
}
impl fmt::Debug for LabelId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
