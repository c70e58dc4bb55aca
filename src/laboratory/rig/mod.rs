//! The laboratory tests: a specimen is made and tested, single grains are crushed between platens, or a free scene is moved on.
//! A test changes the engine's state step by step; it writes no files.

pub mod assembly;
pub mod continuum;
pub mod cylinder;
pub mod grain_crushing;
mod growth;
pub mod preparation;
