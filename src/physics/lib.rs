//! The physics: pure functions of numbers. Nothing here knows a patch, a task or a file.
pub mod acoustic;
pub mod contact;
pub mod faces;
pub mod law;
pub mod materials;
pub mod motion;
pub mod parameter;
pub mod quantities;
pub mod solid;
pub mod table;
pub mod tensor;
pub mod viscosity;
