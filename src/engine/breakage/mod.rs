//! How a grain breaks, after Ciantia, Arroyo, Calvetti & Gens (2015): when ([`criterion`], [`strength`]), into which daughters ([`pattern`]), and what sizes the
//! mass has that the daughters do not hold ([`lost_mass`]).
//!
//! These are laws: functions of plain values, without arrays of grains and files. How daughters enter the assembly is in [`crate::dem::birth`], the breakage of one
//! grain in [`crate::dem::event`].

pub mod criterion;
pub mod crushing_stress;
pub mod lost_mass;
mod model;
pub mod pattern;
pub mod registry;
pub mod spread;
pub mod strength;

pub use model::{Birth, CrushModel};
pub use registry::Criterion;
