//! A task that adds a label gets all that follows from its row: sums over blocks and ranks, checkpoints, dumps, counts. A toy
//! physics has a label of every combination, life and crossing; it runs on any patches, threads and ranks, and once more
//! without the engine.
mod again;
mod checkpoint;
mod conducted;
mod crowd;
mod layouts;
mod many;
mod moving;
mod ready;
mod reference;
mod refusals;
mod run;
#[path = "../common/random.rs"]
mod runner;
mod state;
mod toy;
mod traffic;
