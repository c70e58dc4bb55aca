//! Contacts: the laws, the geometry and force of one contact, and the sweep over all of them.

pub mod chunk;
pub mod fabric;
pub mod force;
pub mod law;
mod model;
pub mod pair;
pub mod pairs;
pub mod registry;
pub mod sweep;
mod unloading;
pub mod wall_sweep;

pub use model::ContactModel;
pub use registry::ContactLaw;
pub use unloading::TangentialUnloading;
