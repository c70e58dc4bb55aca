//! The laboratory: a scene that a user wrote becomes a model ([`scene`], [`model`]), a run drives the model through a laboratory test step
//! by step ([`run`], [`rig`], [`testing`]), and records keep what was found ([`record`]).

#![deny(missing_docs)]

mod cache;
pub mod columns;
pub mod error;
pub mod exchange;
pub mod expression;
pub mod gradation;
pub mod host;
pub mod interrupt;
pub mod machine;
pub mod model;
pub mod packing;
pub mod record;
pub mod rig;
pub mod run;
pub mod scene;
pub mod testing;
