//! Contacts: the laws, the geometry and force of one contact, and the sweep over all of them.

pub mod fabric;
pub mod force;
pub mod law;
mod model;
pub mod pairs;
pub mod part;
pub mod sweep;
pub mod wall_sweep;

pub use model::{ContactLaw, ContactModel, TangentialUnloading};
