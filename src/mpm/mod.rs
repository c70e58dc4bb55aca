//! The continuum: material that is too fine to be followed grain by grain.

pub mod law;
