//! How a grain breaks, after Ciantia, Arroyo, Calvetti & Gens (2015): when (`criterion`, `strength`), into what
//! (`pattern`), and what becomes of the mass that the daughters do not hold (`lost_mass`).
//!
//! These are laws: they take and return plain values and know no arrays of grains, files or clocks. How daughters enter the assembly is in [`crate::dem::birth`], one breakage in [`crate::dem::event`].

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
