//! Programs that nobody has thought of: what is built and not warned of has the same bits on any patches and ranks, and means what
//! its recipes say.
mod cases;
mod physics;
mod random;
mod run;
#[path = "../common/random.rs"]
mod runner;
