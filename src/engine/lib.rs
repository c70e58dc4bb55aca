//! The physics: crushable grains by the discrete element method (DEM), a continuum by the material point method (MPM), and both coupled.
//!
//! The crate reads and writes no files, prints nothing, reads no clock unless a bench asks for times, installs no signal handler and owns no
//! thread pool (it uses rayon's current one). All values are in SI units. Papers are cited by authors, year and equation.
//!
//! Modules, each of which uses only those above it:
//!
//! | module | content |
//! |---|---|
//! | [`math`] | vectors, functions and random draws with the same bits on every machine, SIMD arithmetic |
//! | [`parallel`] | parts of a step on several threads |
//! | [`check`] | checks that a state from outside holds only what a run can have made |
//! | [`error`], [`parameter`], [`material`], [`boundary`], [`grains`], [`shape`] | errors, parameters that laws ask of materials, material constants, walls, the arrays of grains, shapes of rigid bodies |
//! | [`contact`], [`breakage`] | contact laws and the loop over all contacts; laws of breakage |
//! | [`neighbours`] | lists of pairs of grains that are close enough to touch soon |
//! | [`dem`] | one time step of the grains, with their breakages; sums over grains and contacts |
//! | [`mpm`] | one time step of the material points; constitutive laws |
//! | [`point_contacts`], [`rigid`], [`coupling`] | contacts of material points; rigid bodies that are not spheres; grains inside a continuum |
//! | `gpu` | the continuum, with or without grains in it, on a graphics processor (feature `gpu`) |

#![deny(missing_docs)]

pub mod boundary;
pub mod breakage;
pub mod check;
pub mod contact;
pub mod coupling;
pub mod dem;
pub mod error;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod grains;
pub mod material;
pub mod math;
pub mod mpm;
pub mod neighbours;
pub mod parallel;
pub mod parameter;
pub mod point_contacts;
pub mod rigid;
pub mod shape;
