//! A task that adds a label gets all that follows from its row: sums over blocks and ranks, checkpoints, dumps, counts. A toy
//! physics has a label of every combination, life and crossing; it runs on any patches, threads and ranks, and once more
//! without the engine.
mod again;
mod checkpoint;
mod conducted;
mod crowd;
mod layouts;
mod many;
mod reference;
mod refusals;
mod run;
mod state;
#[path = "../common/times.rs"]
mod times;
mod toy;
mod traffic;
