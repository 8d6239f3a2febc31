//! The constitutive laws against their definitions: energies, closed forms, eigenvalues.
#![allow(clippy::unwrap_used)]
mod declared;
mod harness;
mod metal;
mod registry;
#[path = "../common/splitmix.rs"]
mod splitmix;
mod stress;
mod tissue_failure;
mod viscosity;
mod waves;
