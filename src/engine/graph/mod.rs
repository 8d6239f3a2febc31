//! From a recipe of declared tasks to a graph that runs: edges derived, idle tasks pruned, chains fused.
pub mod adders;
pub mod build;
pub mod check;
pub mod error;
pub mod exchange;
pub mod fuse;
pub mod kernel;
pub mod phase;
pub mod prune;
pub mod recipe;
pub mod task;
pub mod traffic;
pub(crate) mod usage;
pub mod why;
