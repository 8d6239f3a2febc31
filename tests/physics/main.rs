//! What a scene computes: bodies, loads, faces, contact, drives and tools, against closed forms and conservation; with the same
//! bits on any layout.
#![allow(clippy::unwrap_used, missing_docs)]

mod beginnings;
mod bodies;
mod bonds;
#[path = "../common/mod.rs"]
mod common;
mod contact;
mod contact_laws;
mod drives;
mod energy;
mod faces;
mod forces;
mod held;
mod leaving;
mod ledger;
mod loads;
mod meshes;
mod moduli;
mod parity;
mod probes;
mod ranks;
mod rates;
mod rigid;
#[path = "../common/random.rs"]
mod runner;
mod startup;
mod tools;
mod transfer;
mod wide;
