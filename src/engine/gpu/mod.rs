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
//! Space with quadratic B-splines, MUSL, a FLIP/PIC blend, walls, gravity, local damping; both laws; up to six loading plates that move at a speed or
//! towards a stress; grains in it, with their contacts. What it lacks (plane strain, GIMP, affine transfer) is refused by name. Each `x.wgsl` stands beside its f32 twin or names the f64 code of `mpm` that states the same.
//!
//! Tested on software Vulkan only; on graphics hardware it has not been run.

mod continuum;
mod device;
mod exact;
mod grains;
#[cfg(test)]
mod law;
mod layout;
mod loading_plate;
mod memory;
mod passes;
mod shader;
mod state;
mod support;
#[cfg(test)]
pub mod tests;

pub use continuum::{DeviceContinuum, Means, Saved};
pub use device::{Adapter, available};
pub use grains::CoarseGrains;
pub use support::{fits, needs, takes};
