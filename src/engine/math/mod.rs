//! Numbers: one or several side by side, vectors, functions and random draws that are the same bytes on every machine.

pub mod eigen;
pub mod portable;
pub mod random;
pub mod real;
pub mod vector;
