//! Parameters from laboratory data.

pub mod curve;
pub mod fines;
pub mod grains;
