//! The recipes: ordered lists of tasks. The list is the algorithm; the graph derives the edges, drops what nobody needs and fuses
//! neighbors, and what the scene does not ask for is not in the list.
mod bodies;
mod builder;
mod contacts;
mod explicit;
mod givers;
mod report;
mod start;
mod tools;

pub use builder::{fields, half_size, tiles};
pub use explicit::{step, timestep_size};
pub use givers::{Giver, Givers};
pub use report::report;
pub use start::start;
pub use tools::{middle, obstacles, tools};
