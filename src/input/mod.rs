//! Scene files: TOML as written, read into a validated [`Scene`](scene::Scene) in SI units.
pub mod geometry;
pub mod scene;
