//! Calibration: finds parameters of scenes and materials from laboratory data, with intervals, and
//! says which ones the data do not determine.

#![deny(missing_docs)]

mod columns;
pub mod compression;
pub mod curve;
pub mod fines;
pub mod grains;
