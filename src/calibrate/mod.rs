//! Strength parameters from laboratory data.

pub mod grains;
