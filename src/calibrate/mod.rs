//! Parameters from laboratory data.

pub mod curve;
