//! The continuum on a graphics processor (feature `gpu`), through wgpu: Vulkan, Metal or Direct3D 12.
//!
//! ```no_run
//! # fn example(mut cpu: comminute_engine::mpm::Continuum) -> comminute_engine::error::Result<()> {
//! if let Some(adapter) = comminute_engine::gpu::available() {
//!     println!("{}", adapter.name);
//!     let mut gpu = comminute_engine::gpu::DeviceContinuum::new(&cpu)?;
//!     gpu.steps(1000, 1e-6)?;
//!     gpu.read_back(&mut cpu)?;
//! }
//! # Ok(())
//! # }
//! ```
//!
//! It has three-dimensional grids with quadratic B-splines, the MUSL scheme, the blend of FLIP and PIC, walls, gravity, local damping, the laws `elastic`,
//! `drucker_prager`, `mohr_coulomb` and `cam_clay`, up to six loading plates (planes and shells) that move at a speed or hold a stress, and grains with their contacts. What it lacks (plane strain, GIMP, the affine
//! transfer) is refused with the key of the scene file.
//!
//! The shaders are the files `*.wgsl`, which `shader.rs` puts together. Each of them names its twin: Rust code that computes the same, in f32 in this folder or in
//! f64 in `mpm`, `coupling`, `contact` and `dem`, against which tests compare it.

mod blocks;
mod bounds;
mod buffers;
#[cfg(test)]
mod cam_clay;
mod clock;
mod continuum;
mod device;
mod exact;
mod grains;
#[cfg(test)]
mod law;
mod layout;
mod loading_plate;
mod memory;
#[cfg(test)]
mod mohr_coulomb;
mod passes;
mod plan;
mod rounds;
mod shader;
mod state;
mod support;
#[cfg(test)]
pub mod tests;
mod work;

pub use clock::PassTime;
pub use continuum::{DeviceContinuum, Means, Saved};
pub use device::{Adapter, available};
pub use grains::CoarseGrains;
pub use support::{Needs, fits, needs, takes};
pub use work::StepWork;
