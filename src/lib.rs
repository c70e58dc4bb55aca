//! Discrete element method with crushable grains for geotechnical research, coupled with a continuum of material points.
//!
//! This crate gathers the crates of the workspace under one name: the engine's modules (physics), the laboratory's (scenes, runs,
//! records), `figure` (drawings from records), `campaign` (many runs) and `calibrate` (parameters from laboratory data).

#![deny(missing_docs)]

pub use calibrate;
pub use campaign;
pub use campaign::{bench, point_test, reproduce, verify};
#[cfg(feature = "gpu")]
pub use engine::gpu;
pub use engine::{
    boundary, breakage, contact, coupling, dem, grains, material, math, mpm, neighbours, parameter, point_contacts, rigid, shape,
};
pub use laboratory::{error, gradation, interrupt, model, packing, record, rig, run, scene, testing};
pub use plot as figure;
pub use table;
