//! Files for people and for other programs.
pub mod frame;
