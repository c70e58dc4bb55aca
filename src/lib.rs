//! Crushable-grain discrete element method for geotechnical research.

pub mod bench;
pub mod calibrate;
pub mod campaign;
pub mod error;
pub mod figure;
pub mod gradation;
pub mod interrupt;
pub mod model;
pub mod packing;
pub mod point_test;
pub mod record;
pub mod reproduce;
pub mod rig;
pub mod run;
pub mod scene;
pub mod verify;

#[cfg(feature = "gpu")]
pub use engine::gpu;
pub use engine::{
    boundary, breakage, contact, coupling, dem, grains, material, math, mpm, neighbours, point_contacts, rigid, shape,
};
