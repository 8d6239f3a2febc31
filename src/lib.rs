//! Sinew: coupled solids by the material point method, as declared tasks on the patches of a grid.
//!
//! This library reads scenes ([`input`]), runs them ([`simulation`]), writes folders of results ([`output`]), and looks at all
//! of it ([`lab`]). The method is the crate `tasks`, what runs it the crate `engine`.
pub mod input;
pub mod lab;
pub mod output;
pub mod simulation;
