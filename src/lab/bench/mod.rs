//! How fast steps are, task by task, against what the machine can do.
//!
//! Operations are counted by running the tasks on [`simd::Isa::COUNTING`], bytes come from the declarations, time
//! from the [meter](engine::exec::meter), and the ceilings are measured in the same run: shares of them can be compared
//! between machines and days, seconds cannot.
pub mod ceilings;
pub mod compare;
pub mod measure;
pub mod order;
pub mod report;
pub mod rows;
mod table;
pub mod traffic;

pub use ceilings::Ceiling;
pub use compare::{Comparison, compare};
pub use measure::{BenchError, Plan, bench};
pub use report::Report;
