//! Contacts between spheres, and between spheres and walls.
//!
//! - [`law`], [`registry`]: the contact laws, and the list of them
//! - [`force`]: the force of one contact from its geometry, its relative motion and its history
//! - [`pair`]: the parameters of a contact, from the materials of its two ends
//! - [`pairs`]: where the contacts of a run and their histories are stored
//! - [`sweep`], [`wall_sweep`], [`chunk`]: the loops over all contacts, in parallel and with SIMD
//! - [`fabric`]: the fabric tensor of the contacts' normals

pub mod chunk;
pub mod fabric;
pub mod force;
pub mod law;
mod model;
pub mod pair;
pub mod pairs;
pub mod registry;
pub mod sweep;
#[cfg(test)]
mod tests;
mod unloading;
pub mod wall_sweep;

pub use model::ContactModel;
pub use registry::ContactLaw;
pub use unloading::TangentialUnloading;
