//! The task graph: what it holds, what is refused, what it costs, and how it is shown.
#![allow(clippy::unwrap_used, missing_docs)]

mod check;
#[path = "../common/mod.rs"]
mod common;
mod cycle;
mod export;
mod guard;
mod passes;
mod program;
mod recipe;
#[path = "../common/shown.rs"]
mod shown;
#[path = "../common/toy.rs"]
mod toy;
mod trace;
mod traffic;
