//! Rigid bodies: those that move as prescribed are tools, and contact and loads move the others; particles follow.
#![allow(missing_docs)] // each module is documented by its task

pub mod apart;
pub mod bodies;
pub mod carry;
pub mod follow;
pub mod motion;
pub mod newton;
pub mod plan;
pub mod predict;
pub mod push;
pub mod rotation;
pub mod round;
pub mod sites;
pub mod solve;
pub mod state;
