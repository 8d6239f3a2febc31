//! Rigid bodies: the nodes they fill move with them, contact moves them, their particles follow.
#![allow(missing_docs)] // each module is documented by its task

pub mod contact;
pub mod flow;
pub mod follow;
pub mod motion;
pub mod plan;
pub mod rotation;
pub mod state;
pub mod velocity;
