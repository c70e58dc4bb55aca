//! What is recorded of a run: measures of the state, the energy ledger, tables, snapshots, checkpoints. The physics compiles without
//! it, but for the ledger's counters.

pub mod ancestors;
pub mod assembly;
pub mod blocks;
pub mod breakages;
pub mod checkpoint;
pub mod contacts;
pub mod continuum;
pub mod crushed;
pub mod cylinder;
pub mod dictionary;
pub mod gradations;
pub mod platen;
pub mod quasi_static;
pub mod specimen;
pub mod vtk;
pub mod walls;
