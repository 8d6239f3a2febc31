//! Labels, the columns behind them, and the views of them that tasks receive.
pub mod activate;
pub mod exact_sum;
pub mod extent;
pub mod label;
pub mod labels;
pub mod nodes;
pub mod particles;
pub mod reduction;
pub mod schedule;
pub mod shared;
pub mod view;
pub mod warehouse;
pub mod workspace;
