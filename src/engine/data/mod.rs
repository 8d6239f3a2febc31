//! Where data live: columns of particles, lines of nodes, values of materials and the run, and the views that tasks receive.
pub mod activate;
pub mod exact_sum;
pub mod extent;
pub mod fields;
pub mod layers;
pub mod layout;
mod map;
pub mod nearby;
pub mod nodes;
pub mod particles;
pub mod rates;
pub mod reduction;
pub mod schedule;
pub mod shared;
pub mod spread;
pub mod view;
pub mod warehouse;
pub mod workspace;
