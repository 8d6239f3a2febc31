//! The commands, and what they write.
#![allow(clippy::unwrap_used, missing_docs)]

mod bench;
mod cli;
#[path = "../common/mod.rs"]
mod common;
mod compare;
mod drawn;
mod export;
mod fields;
mod picture;
mod scale;
mod scale_trace;
mod tables;
mod wide;
mod wound;
