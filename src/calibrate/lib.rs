//! Calibration: finds parameters of scenes and materials from laboratory data, with intervals, and
//! says which ones the data do not determine.

#![deny(missing_docs)]

mod columns;
pub mod compression;
pub mod curve;
pub mod fines;
pub mod grains;
pub mod interface;

/// A result as indented JSON that ends with a new line.
pub fn json_text(found: &impl serde::Serialize) -> String {
    serde_json::to_string_pretty(found).unwrap_or_default() + "\n"
}
