//! What a laboratory does: preparation of a specimen, the oedometer, single grains between platens, free assemblies.

pub mod assembly;
pub mod oedometer;
pub mod platen;
pub mod preparation;
