//! What a quantity is. An application declares each in one row; buffers, columns, messages, migration, checkpoints, byte
//! counts and dumps follow from it.
mod label;
mod row;
mod tiles;

pub use label::{Label, LabelId};
pub use row::{Combine, Crossing, Home, Inert, Life, Row, block, chunk, material, node, particle, run};
pub use tiles::Tiles;

/// All quantities of an application.
#[derive(Debug)]
pub struct Schema {
    rows: &'static [Row],
    /// The labels that the engine itself reads.
    pub roles: Roles,
}

/// Labels that the engine reads, whatever they are called.
#[derive(Clone, Copy, Debug)]
pub struct Roles {
    /// Where particles are [m]: three numbers. It decides about their blocks.
    pub position: LabelId,
    /// Who they are: one number, the bits of an integer.
    pub identity: LabelId,
    /// The bounds of a block's particles (see `data::extent`).
    pub extent: LabelId,
    /// The time, and the steps of the materials, if the application has them.
    pub rates: Option<Rates>,
}

/// The labels of time and of the steps of materials.
#[derive(Clone, Copy, Debug)]
pub struct Rates {
    /// One [`Clock`](crate::data::rates::Clock).
    pub clock: LabelId,
    /// A [`MaterialStep`](crate::data::rates::MaterialStep) a material.
    pub steps: LabelId,
}

impl Schema {
    /// A row a label, in the order of their indices, and the labels that the engine itself reads.
    ///
    /// # Panics
    /// Where a role goes to a label of another home, or a label of blocks has no role: while it is compiled.
    pub const fn new(rows: &'static [Row], roles: Roles) -> Self {
        assert!(matches!(roles.position.home(), Home::Particle) && roles.position.width() == 3);
        assert!(matches!(roles.identity.home(), Home::Particle) && roles.identity.width() == 1);
        assert!(matches!(roles.extent.home(), Home::Block) && roles.extent.width() == 6);
        if let Some(rates) = roles.rates {
            assert!(matches!(rates.clock.home(), Home::Run) && matches!(rates.steps.home(), Home::Material));
        }
        let mut index = 0;
        while index < rows.len() {
            let other = matches!(rows[index].home, Home::Block) && index != roles.extent.index();
            assert!(!other, "blocks have one label: the extent of their particles");
            index += 1;
        }
        Self { rows, roles }
    }

    /// All labels, in order.
    pub fn labels(&'static self) -> impl Iterator<Item = LabelId> + Clone {
        self.rows.iter().map(LabelId::new)
    }

    /// Number of labels.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is no label.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The label called `name`, in any case of letters.
    pub fn find(&'static self, name: &str) -> Option<LabelId> {
        self.labels().find(|label| label.name().eq_ignore_ascii_case(name))
    }

    /// The label of the steps of materials, if the application has it.
    pub fn steps(&self) -> Option<LabelId> {
        self.roles.rates.map(|rates| rates.steps)
    }
}

/// Declares labels: a zero-sized type each, and the table `ROWS` of their rows. To the right of the tile stands the row: a
/// function of its home ([`particle`], [`chunk`], [`node`], [`block`], [`material`], [`run`]) with unit and meaning, and what
/// differs from the usual of such labels.
///
/// ```
/// use engine::schema::{Combine, Home, Label, Life, chunk, node, particle};
/// use simd::Wide;
/// engine::labels! {
///     Place: [Wide; 3] = particle("m", "x_p").in_the_middle();
///     Heat: Wide = node("J/K, J", "c_I, c_I T_I").partials(3);
///     Temperature: Wide = node("K", "T_I").values(3).lives(Life::Carried);
/// }
/// assert_eq!(Heat::ID.name(), "Heat");
/// assert_eq!((Heat::ID.home(), Heat::ID.combine()), (Home::Node, Combine::Sum));
/// assert_eq!((ROWS.len(), Place::ID.width()), (3, 3));
/// ```
#[macro_export]
macro_rules! labels {
    ($($(#[$doc:meta])* $name:ident: $tile:ty = $row:expr;)*) => {
        #[allow(non_camel_case_types, dead_code)]
        enum Index { $($name),* }

        /// A row a label.
        pub static ROWS: [$crate::schema::Row; [$(stringify!($name)),*].len()] =
            [$($row.declare(Index::$name as usize, stringify!($name), size_of::<$tile>())),*];

        $(
            $(#[$doc])*
            #[doc = concat!("The label `", stringify!($name), "`: see its row.")]
            pub struct $name;
            impl $crate::schema::Label for $name {
                const ID: $crate::schema::LabelId = $crate::schema::LabelId::new(&ROWS[Index::$name as usize]);
                type Tile = $tile;
            }
        )*
    };
}
