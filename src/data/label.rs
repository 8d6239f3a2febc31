//! What a label is: a named quantity with a home, a tile type and a unit.
/// Where a label lives, and for how long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Home {
    /// A particle column: survives the step, moves with the particle.
    Particle,
    /// Scratch of one thread: exists only inside one fused chunk of particles.
    Chunk,
    /// A node field, one line a node and material.
    Node,
    /// A few lines a block and material.
    Block,
    /// A few lines a material.
    Material,
    /// A few lines, the same everywhere.
    Global,
}

/// How contributions to a label of home `Block`, `Material` or `Global` combine. All are exact, so no order of
/// contributions can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reduce {
    /// Written once.
    No,
    /// Lane by lane, the largest.
    Max,
    /// Exact sums.
    Sum,
    /// Each line: the one with the smallest (lane 0, lane 1).
    First,
}

/// Makes the table: an enum of identities with their properties, and a zero-sized type a label.
macro_rules! labels {
    ($($name:ident: $home:ident $($reduce:ident)?, $tile:ty, $unit:literal, $what:literal;)*) => {
        /// Index of a label in the table.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(usize)]
        pub enum LabelId { $(#[doc = $what] $name),* }

        /// Number of labels.
        pub const LABELS: usize = LabelId::ALL.len();

        impl LabelId {
            /// The whole table.
            pub const ALL: &[LabelId] = &[$(LabelId::$name),*];
            /// Where it lives.
            #[inline(always)]
            pub const fn home(self) -> Home { match self { $(LabelId::$name => Home::$home),* } }
            /// How contributions combine.
            pub const fn reduce(self) -> Reduce {
                match self { $(LabelId::$name => labels!(@ $($reduce)?)),* }
            }
            /// Name in messages and dumps.
            pub const fn name(self) -> &'static str { match self { $(LabelId::$name => stringify!($name)),* } }
            /// SI unit.
            pub const fn unit(self) -> &'static str { match self { $(LabelId::$name => $unit),* } }
            /// Symbol and meaning.
            pub const fn meaning(self) -> &'static str { match self { $(LabelId::$name => $what),* } }
            /// Cache lines a tile (0: the material decides, see `Layout`).
            #[inline(always)]
            pub const fn width(self) -> usize {
                match self { $(LabelId::$name => size_of::<$tile>() / 64),* }
            }
        }
        $(#[doc = concat!($what, " [", $unit, "]")]
        pub struct $name;
        impl Label for $name {
            const ID: LabelId = LabelId::$name;
            type Tile = $tile;
        })*
    };
    (@) => { Reduce::No };
    (@ $reduce:ident) => { Reduce::$reduce };
}
pub(crate) use labels;
