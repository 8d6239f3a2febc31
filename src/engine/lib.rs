//! Declared tasks on the patches of a grid: what a quantity is ([`schema`]), what a task is and what follows from its
//! declaration ([`graph`]), what runs in which order ([`program`]), where data live ([`data`]), and how all of it runs on threads and ranks ([`exec`]).
//!
//! The engine knows no quantity by name: an application declares its labels, its tasks and its recipes.
pub mod data;
pub mod exec;
pub mod graph;
pub mod program;
pub mod schema;

// what an application needs besides, so that it depends on the engine alone
pub use {bytemuck, grid, simd};

/// What the file of a physics begins with.
pub mod prelude {
    pub use crate::data::exact_sum::ExactSum;
    pub use crate::data::warehouse::{MaterialData, Warehouse};
    pub use crate::graph::error::GraphError;
    pub use crate::graph::recipe::Recipe;
    pub use crate::graph::task::{At, Body};
    pub use crate::program::{Program, Script};
    pub use crate::schema::{Label, Life, Roles, Schema, block, chunk, material, node, particle, run};
    pub use crate::{kernel, labels, task};
    pub use grid::{Decomposition, Level, Partition};
    pub use simd::{Simd, Wide};
}
