//! Crushable-grain discrete element method for geotechnical research, with a continuum of material points.

pub use calibrate;
pub use campaign;
pub use campaign::{bench, point_test, reproduce, verify};
#[cfg(feature = "gpu")]
pub use engine::gpu;
pub use engine::{
    boundary, breakage, contact, coupling, dem, grains, material, math, mpm, neighbours, point_contacts, rigid, shape,
};
pub use laboratory::{error, gradation, interrupt, model, packing, record, rig, run, scene, testing};
pub use plot as figure;
pub use table;
