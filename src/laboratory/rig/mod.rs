//! What is done to the grains: making a specimen and testing it, single grains between platens, or a free scene.

pub mod assembly;
pub mod continuum;
pub mod cylinder;
mod growth;
pub mod platen;
pub mod preparation;
