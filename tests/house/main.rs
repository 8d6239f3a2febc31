//! What the sources, the registries and the pages made from them keep.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "../common/mod.rs"]
mod common;
mod layering;
mod pages;
mod registries;
mod scene_docs;
mod scenes;
mod simd_lanes;
mod simd_math;
