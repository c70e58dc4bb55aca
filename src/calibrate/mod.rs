//! Parameters from laboratory data.

pub mod curve;
pub mod grains;
