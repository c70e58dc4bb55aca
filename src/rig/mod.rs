//! What a laboratory does: preparation of a specimen, the oedometer, free assemblies.

pub mod assembly;
pub mod oedometer;
pub mod preparation;
