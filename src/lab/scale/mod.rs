//! How a scene scales: measured on this machine over patches, threads and ranks, and predicted beyond it.
//!
//! [`measure`] runs `sinew run` and reads its traces; [`calibrate`] makes [`model::Costs`] of traces; [`footprint`] and
//! [`torus`] say what ranks do and send in the ticks of a [`step`], from the scene or for ranks that all look the same;
//! `replay` goes through the engine's [`order`] of these ticks on a [`model::Cluster`], and [`predict`] says what came out.
pub mod calibrate;
pub mod footprint;
pub mod list;
pub mod load;
mod mail;
pub mod measure;
pub mod model;
pub mod order;
pub mod ping;
pub mod predict;
mod replay;
pub mod report;
pub mod row;
pub mod series;
pub mod step;
pub mod table;
pub mod tally;
pub mod torus;
pub mod validate;
mod wires;
