//! How a scene scales: measured on this machine over patches, threads and ranks, and predicted beyond it.
//!
//! [`measure`] runs `sinew run` and reads its traces; [`calibrate`] makes [`model::Costs`] of traces; [`field`] and
//! [`torus`] say what ranks do and send, from the scene or for ranks that all look the same; [`predict`] simulates ticks
//! of them on a [`model::Cluster`].
pub mod calibrate;
pub mod field;
pub mod list;
pub mod load;
pub mod measure;
pub mod model;
pub mod ping;
pub mod plot;
pub mod predict;
mod reduce;
pub mod report;
pub mod row;
pub mod series;
pub mod table;
pub mod tally;
mod tick;
pub mod torus;
pub mod validate;
pub mod wires;
