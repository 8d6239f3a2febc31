//! Instruments: they may use all of Sinew, and nothing of Sinew but the command uses them.
pub mod bench;
pub mod diagram;
pub mod export;
pub mod figure;
pub mod overview;
pub mod picture;
pub mod plan;
pub mod plot;
pub mod scale;
pub mod wound;
