//! Calibration: parameters of scenes and materials from laboratory data, with what the data leave open.

#![deny(missing_docs)]

mod columns;
pub mod curve;
pub mod fines;
pub mod grains;
