//! What is done to the grains: making a specimen and testing it, or a free scene.

pub mod assembly;
pub mod cylinder;
pub mod oedometer;
pub mod preparation;
pub mod triaxial;
