//! Parameters from laboratory data.

mod columns;
pub mod curve;
pub mod fines;
pub mod grains;
