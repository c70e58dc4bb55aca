//! Crushable-grain discrete element method for geotechnical research.

pub mod bench;
pub mod boundary;
pub mod calibrate;
pub mod campaign;
pub mod contact;
pub mod coupling;
pub mod crush;
pub mod error;
pub mod figure;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod gradation;
pub mod grains;
pub mod model;
pub mod mpm;
pub mod neighbours;
pub mod packing;
pub mod point_test;
mod portable;
pub mod real;
pub mod record;
pub mod reproduce;
pub mod rig;
pub mod rigid;
pub mod run;
pub mod scene;
pub mod shape;
pub mod step;
pub mod verify;
