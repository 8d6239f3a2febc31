//! The stages of the method, one task a file, and the recipe that orders them.
//!
//! Tasks know labels, laws and numbers; they know no warehouse, no thread, no rank and no other task.
#![allow(missing_docs)] // each module is documented by its task

pub mod advance;
pub mod bond_flow;
pub mod bonds;
pub mod boundary;
pub mod break_bond;
pub mod clock;
pub mod contact;
pub mod contact_begin;
pub mod contact_flow;
pub mod contact_power;
pub mod contact_scatter;
pub mod drive;
pub mod drive_bonds;
pub mod drive_nodes;
pub mod drive_scatter;
pub mod drive_sum;
pub mod drives;
pub mod fault;
pub mod fold;
pub mod fold_surfaces;
pub mod fold_tools;
pub mod force_power;
pub mod force_scatter;
pub mod forces;
pub mod gather;
pub mod grid_power;
pub mod hold_bonds;
pub mod images;
pub mod integrate;
pub mod labels;
pub mod load_power;
pub mod loads;
pub mod mass_flow;
pub mod mirror;
pub mod nodal_velocity;
pub mod node;
pub mod pic;
pub mod reactions;
pub mod recipes;
pub mod reflection;
pub mod report;
pub mod rest;
pub mod rigid;
pub mod scatter;
pub mod signal_speed;
pub mod stress;
pub mod stress_flow;
pub mod timestep_size;
pub mod tool;
pub mod tool_scatter;
pub mod tools;
pub mod viscosity;
pub mod weights;
