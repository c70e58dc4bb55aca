//! What is done to a specimen: a scene as the user wrote it becomes a model, a run drives it through a laboratory test step by step, and records say what was found.

pub mod error;
pub mod gradation;
pub mod interrupt;
pub mod model;
pub mod packing;
pub mod record;
pub mod rig;
pub mod run;
pub mod scene;
pub mod testing;
