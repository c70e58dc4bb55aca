//! What is recorded of a run: measures of the state, the energy ledger, tables, snapshots, checkpoints. The physics compiles without
//! it, but for the ledger's counters.

pub(crate) mod ancestors;
pub(crate) mod assembly;
pub(crate) mod blocks;
pub(crate) mod breakages;
pub(crate) mod checkpoint;
pub(crate) mod contacts;
pub(crate) mod continuum;
pub(crate) mod crushed;
pub(crate) mod cylinder;
pub mod dictionary;
pub(crate) mod gradations;
pub(crate) mod platen;
pub(crate) mod quasi_static;
pub mod specimen;
pub(crate) mod vtk;
pub(crate) mod walls;
