//! Mathematics with the same bits on every machine: SIMD arithmetic, vectors, principal values of tensors, functions, random draws.

pub mod eigen;
pub mod portable;
pub mod random;
pub mod real;
pub mod vector;
