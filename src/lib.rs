//! Sinew: coupled solids by the material point method, as declared tasks on the patches of a grid.
pub mod bench;
pub mod data;
pub mod exec;
pub mod graph;
pub mod grid;
pub mod input;
pub mod output;
pub mod physics;
pub mod plan;
pub mod scale;
pub mod simd;
pub mod simulation;
#[path = "../tasks/mod.rs"]
pub mod tasks;
