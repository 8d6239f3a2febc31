//! What a task is: a declaration, an `Io` made from it, and a body that sees only the `Io`.
use crate::data::schedule::FieldTime;
use crate::data::workspace::Workspace;
use crate::schema::{Combine, Home, LabelId};
use grid::{IndexBox, Origin};
use simd::{Isa, Job, Simd};

/// What a task runs over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// The particles of one material, chunk by chunk.
    Particles,
    /// As `Particles`, in blocks where a material with which theirs interacts may touch the same nodes.
    NearParticles,
    /// The buffer of a block of particles, once a block: what all of them have added to nodes, or what they are about to read.
    Buffers,
    /// The nodes of a block, all fields that touch it together.
    Nodes,
    /// Once a step.
    Once,
}

/// How a task uses a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Reads what the last step left (or, for shared labels, what the step began with).
    RequiresOld,
    /// Reads what an earlier task of this step computed or modified.
    RequiresNew,
    /// Reads the value as of this place in the recipe, whoever wrote it.
    Requires,
    /// Reads what nodes have, and changes the copy in the block's buffer, for the tasks after it in its stage.
    Adapts,
    /// Writes it, whatever was there. Over buffers: changes what the block's particles have added to it.
    Computes,
    /// Reads and writes it.
    Modifies,
    /// Works in it: holds nothing before and after.
    Scratch,
}

impl Mode {
    /// Whether the task sees what was there before.
    pub fn reads(self) -> bool {
        !matches!(self, Mode::Computes | Mode::Scratch)
    }
    /// Whether the task changes it.
    pub fn writes(self) -> bool {
        matches!(self, Mode::Computes | Mode::Modifies)
    }
}

/// A label that a task may work in: of home `Chunk`; another one does not compile.
pub const fn scratch(label: LabelId) -> LabelId {
    assert!(matches!(label.home(), Home::Chunk), "a task works in chunk labels");
    label
}

/// One line of a declaration. `ghost`: layers of nodes around the block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// The label.
    pub label: LabelId,
    /// How it is used.
    pub mode: Mode,
    /// Layers of nodes beyond the block's own.
    pub ghost: u8,
}

impl Access {
    /// Whether the task contributes to a label that others contribute to.
    pub fn reduces(&self) -> bool {
        self.mode == Mode::Computes && self.label.combine() != Combine::None
    }
}

/// Where a body runs.
#[derive(Clone, Copy)]
pub struct At<'a> {
    /// The block's buffer, for stencils.
    pub origin: Origin,
    /// Particles in the chunk; lanes beyond them are inert.
    pub count: usize,
    /// The block's first node, in nodes of the level.
    pub node: [i32; 3],
    /// Nodes of the block: how many tiles of each field follow one another in a column of nodes.
    pub nodes: usize,
    /// For tasks over buffers: the nodes that the block's particles may touch, in nodes of the level.
    pub touched: IndexBox,
    /// For node tasks: the fields whose nodes follow one another in each column.
    pub fields: &'a [FieldTime],
}

impl At<'_> {
    /// The lanes of tile `tile` of the chunk that hold particles.
    #[inline(always)]
    pub fn lanes(&self, tile: usize) -> u8 {
        let left = self.count.saturating_sub(8 * tile);
        if left >= 8 { u8::MAX } else { (1 << left) - 1 }
    }

    /// The block's `n`-th node, in nodes of the level.
    #[inline(always)]
    pub fn node_of(&self, n: usize) -> [i32; 3] {
        let place = self.origin.shape.place(n);
        [0, 1, 2].map(|a| self.node[a] + place[a])
    }

    /// Where a node of the level lies in the block's buffer.
    #[inline(always)]
    pub fn in_buffer(&self, node: [i32; 3]) -> usize {
        let shape = &self.origin.shape;
        let line = |a: usize| (node[a] - self.node[a] + shape.below[a]) * shape.buffer_strides[a];
        (line(0) + line(1) + line(2)) as usize
    }
}

/// Written by [`task!`](crate::task!), never by hand.
pub trait Task: Send + Sync + 'static {
    /// Name in messages and dumps.
    const NAME: &'static str;
    /// What it does: its doc comment, in one line.
    const ABOUT: &'static str;
    /// What it runs over.
    const DOMAIN: Domain;
    /// All it reads and writes.
    const ACCESS: &'static [Access];
    /// The views that the declaration grants.
    type Io<'a>;
    /// Takes the views from a workspace.
    fn bind<'a>(space: &'a mut Workspace<'_>) -> Self::Io<'a>;
}

/// Written by hand: the physics. Mark `run` `#[inline(always)]`, so that it is compiled for `S`.
pub trait Body: Task {
    /// Runs the task on one chunk of particles, the nodes of one block, or once.
    fn run<S: Simd>(&self, at: &At<'_>, io: Self::Io<'_>);
}

/// What the graph knows of a task.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Declaration {
    /// Its name.
    pub name: &'static str,
    /// What it does: the doc comment of the task, in one line.
    pub about: &'static str,
    /// What it runs over.
    pub domain: Domain,
    /// All it reads and writes.
    pub access: &'static [Access],
}

/// A body behind a pointer: one virtual call a chunk.
pub trait Runnable: Send + Sync {
    /// Its declaration.
    fn declaration(&self) -> Declaration;
    /// Runs it on the workspace's current chunk.
    fn run_on(&self, isa: Isa, at: &At<'_>, space: &mut Workspace<'_>);
}

impl<T: Body> Runnable for T {
    fn declaration(&self) -> Declaration {
        Declaration { name: T::NAME, about: T::ABOUT, domain: T::DOMAIN, access: T::ACCESS }
    }
    fn run_on(&self, isa: Isa, at: &At<'_>, space: &mut Workspace<'_>) {
        isa.dispatch(RunChunk { task: self, at, space });
    }
}

struct RunChunk<'a, 'w, T> {
    task: &'a T,
    at: &'a At<'a>,
    space: &'a mut Workspace<'w>,
}

impl<T: Body> Job for RunChunk<'_, '_, T> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        self.task.run::<S>(self.at, T::bind(self.space));
    }
}

/// Declares a task: its type, what it does, and its data. Makes the access list *and* the only views its body receives. Labels under
/// `scratch` are memory to work in: what is in them passes to nobody, and makes no edge.
///
/// The doc comment of the type says what the task does, to people who read the code and to those who look at the graph
/// ([`about`](crate::graph::task::Declaration::about)): a sentence in words first, then formulas, sources and the rest.
///
/// What is not declared does not compile:
/// ```compile_fail,E0609
/// use engine::{graph::task::{At, Body}, schema::particle};
/// use simd::{Simd, Wide};
/// engine::labels! {
///     Charge: Wide = particle("C", "q_p");
///     Potential: Wide = particle("V", "phi_p");
/// }
/// engine::task! {
///     /// Looks where it must not.
///     pub struct Peek;
///
///     Particles task {
///         requires old { charge: Charge }
///         computes { potential: Potential }
///     }
/// }
/// impl Body for Peek {
///     fn run<S: Simd>(&self, _at: &At<'_>, io: Io<'_>) {
///         let v = io.field; // error[E0609]: no field `field` on type `Io<'_>`
///     }
/// }
/// ```
/// and what is only required cannot be written:
/// ```compile_fail,E0594
/// use engine::{graph::task::{At, Body}, schema::particle};
/// use simd::{Simd, Wide};
/// engine::labels! {
///     Charge: Wide = particle("C", "q_p");
///     Potential: Wide = particle("V", "phi_p");
/// }
/// engine::task! {
///     /// Looks where it must not.
///     pub struct Peek;
///
///     Particles task {
///         requires old { charge: Charge }
///         computes { potential: Potential }
///     }
/// }
/// impl Body for Peek {
///     fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
///         io.charge[0] = Wide::default(); // error[E0594]: `Read` hands out no `&mut`
///     }
/// }
/// ```
/// A task that does not say what it does does not compile:
/// ```compile_fail
/// use engine::schema::particle;
/// use simd::Wide;
/// engine::labels! { Charge: Wide = particle("C", "q_p"); }
/// engine::task! {
///     pub struct Silent;
///
///     Particles task {
///         modifies { charge: Charge }
///     }
/// }
/// # fn main() {}
/// ```
/// Only chunk labels are memory to work in:
/// ```compile_fail,E0080
/// use engine::{graph::task::{At, Body}, schema::particle};
/// use simd::{Simd, Wide};
/// engine::labels! {
///     Charge: Wide = particle("C", "q_p");
///     Potential: Wide = particle("V", "phi_p");
/// }
/// engine::task! {
///     /// Works where it must not.
///     pub struct Spoil;
///
///     Particles task {
///         computes { potential: Potential }
///         scratch { charge: Charge }
///     }
/// }
/// impl Body for Spoil {
///     fn run<S: Simd>(&self, _at: &At<'_>, _io: Io<'_>) {}
/// }
/// fn main() { assert_eq!(<Spoil as engine::graph::task::Task>::ACCESS.len(), 2); }
/// ```
#[macro_export]
macro_rules! task {
    (
        $(#[doc = $about:literal])+
        pub struct $name:ident $(<$kind:ident: $bound:path>)? $({ $($fields:tt)* })? $($(($($tuple:tt)*))?;)?
        $domain:ident task {
            $(requires old { $($o:ident: $O:ident $(@ $old_ghost:literal)?),* $(,)? })?
            $(requires new { $($r:ident: $R:ident $(@ $ghost:literal)?),* $(,)? })?
            $(requires now { $($n:ident: $N:ident $(@ $now_ghost:literal)?),* $(,)? })?
            $(adapts { $($a:ident: $A:ident @ $copied:literal),* $(,)? })?
            $(computes { $($c:ident: $C:ident $(@ $spread:literal)?),* $(,)? })?
            $(modifies { $($m:ident: $M:ident),* $(,)? })?
            $(scratch { $($s:ident: $S:ident),* $(,)? })?
        }
    ) => {
        $(#[doc = $about])+
        pub struct $name $(<$kind: $bound>)? $({ $($fields)* })? $($(($($tuple)*))?;)?

        /// The views that the declaration grants, and nothing else.
        pub struct Io<'a> {
            $($(
                #[allow(missing_docs)]
                pub $o: $crate::data::view::Read<'a, <$O as $crate::schema::Label>::Tile>,)*)?
            $($(
                #[allow(missing_docs)]
                pub $r: $crate::data::view::Read<'a, <$R as $crate::schema::Label>::Tile>,)*)?
            $($(
                #[allow(missing_docs)]
                pub $n: $crate::data::view::Read<'a, <$N as $crate::schema::Label>::Tile>,)*)?
            $($(
                #[allow(missing_docs)]
                pub $a: $crate::data::view::Write<'a, <$A as $crate::schema::Label>::Tile>,)*)?
            $($(
                #[allow(missing_docs)]
                pub $c: $crate::data::view::Write<'a, <$C as $crate::schema::Label>::Tile>,)*)?
            $($(
                #[allow(missing_docs)]
                pub $m: $crate::data::view::Write<'a, <$M as $crate::schema::Label>::Tile>,)*)?
            $($(
                #[allow(missing_docs)]
                pub $s: $crate::data::view::Write<'a, <$S as $crate::schema::Label>::Tile>,)*)?
        }
        impl $(<$kind: $bound>)? $crate::graph::task::Task for $name $(<$kind>)? {
            const NAME: &'static str = stringify!($name);
            // lines of a doc comment begin with a space
            const ABOUT: &'static str = concat!($($about),+).trim_ascii();
            const DOMAIN: $crate::graph::task::Domain = $crate::graph::task::Domain::$domain;
            const ACCESS: &'static [$crate::graph::task::Access] = &[
                $($($crate::task!(@ $O RequiresOld $($old_ghost)?),)*)?
                $($($crate::task!(@ $R RequiresNew $($ghost)?),)*)?
                $($($crate::task!(@ $N Requires $($now_ghost)?),)*)?
                $($($crate::task!(@ $A Adapts $copied),)*)?
                $($($crate::task!(@ $C Computes $($spread)?),)*)?
                $($($crate::task!(@ $M Modifies),)*)?
                $($($crate::task!(@ $S Scratch),)*)?
            ];
            type Io<'a> = Io<'a>;
            #[inline(always)]
            fn bind<'a>(space: &'a mut $crate::data::workspace::Workspace<'_>) -> Io<'a> {
                use $crate::schema::Label;
                let window = $crate::data::workspace::Window::of(space);
                let [$($($o,)*)? $($($r,)*)? $($($n,)*)? $($($a,)*)? $($($c,)*)? $($($m,)*)? $($($s,)*)?] = space.columns
                    .get_disjoint_mut([
                        $($(const { $O::ID.index() },)*)? $($(const { $R::ID.index() },)*)? $($(const { $N::ID.index() },)*)?
                        $($(const { $A::ID.index() },)*)? $($(const { $C::ID.index() },)*)? $($(const { $M::ID.index() },)*)?
                        $($(const { $S::ID.index() },)*)?
                    ])
                    .expect("a declaration names each label once");
                Io {
                    $($($o: window.read::<$O>($o),)*)?
                    $($($r: window.read::<$R>($r),)*)?
                    $($($n: window.read::<$N>($n),)*)?
                    $($($a: window.write::<$A>($a),)*)?
                    $($($c: window.write::<$C>($c),)*)?
                    $($($m: window.write::<$M>($m),)*)?
                    $($($s: window.write::<$S>($s),)*)?
                }
            }
        }
    };
    (pub struct $name:ident $($rest:tt)*) => {
        compile_error!(concat!("task ", stringify!($name), " does not say what it does: give it a doc comment"));
    };
    (@ $label:ident Scratch) => {
        $crate::graph::task::Access {
            label: $crate::graph::task::scratch(<$label as $crate::schema::Label>::ID),
            mode: $crate::graph::task::Mode::Scratch,
            ghost: 0,
        }
    };
    (@ $label:ident $mode:ident) => { $crate::task!(@ $label $mode 0) };
    (@ $label:ident $mode:ident $ghost:literal) => {
        $crate::graph::task::Access {
            label: <$label as $crate::schema::Label>::ID,
            mode: $crate::graph::task::Mode::$mode,
            ghost: $ghost,
        }
    };
}
