//! The physics of crushable grains, of a continuum of material points, and of both together: no files, clocks, printing, signals or thread pools.
//!
//! Rooms, each of which uses only those above it:
//!
//! | room | what it holds |
//! |---|---|
//! | [`math`] | numbers side by side, vectors, portable functions, keyed random draws |
//! | [`error`], [`parameter`], [`material`], [`boundary`], [`grains`], [`shape`] | failures, what laws ask of materials, constants of a material, walls, the grains' arrays, shapes of rigid bodies |
//! | [`contact`], [`breakage`] | the laws of contact with their sweeps, the laws of breakage |
//! | [`neighbours`] | lists of near pairs |
//! | [`dem`] | one time step of grains, breakages in it, what is observed of it |
//! | [`mpm`] | one time step of material points |
//! | [`point_contacts`], [`rigid`], [`coupling`] | contacts of points, rigid bodies that are no spheres, grains in a continuum |
//! | `gpu` | the continuum and grains in it on a graphics device (feature `gpu`) |

pub mod boundary;
pub mod breakage;
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
pub mod parameter;
pub mod point_contacts;
pub mod rigid;
pub mod shape;
