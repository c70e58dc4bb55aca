//! The records of a run: rows of tables, gradations, breakages, snapshots for ParaView, specimen files and checkpoints. The
//! engine knows nothing of them.

pub(crate) mod account;
pub(crate) mod ancestors;
pub(crate) mod assembly;
pub(crate) mod block_breakages;
pub(crate) mod blocks;
pub(crate) mod breakages;
pub(crate) mod checkpoint;
pub(crate) mod compact;
pub mod contacts;
pub(crate) mod continuum;
pub(crate) mod crushed;
pub(crate) mod cylinder;
pub mod dictionary;
pub(crate) mod gradations;
pub(crate) mod grain_crushing;
pub(crate) mod joints;
pub(crate) mod quasi_static;
pub mod snapshot;
pub mod specimen;
pub(crate) mod vtk;
pub(crate) mod wall_rows;
pub(crate) mod walls;
