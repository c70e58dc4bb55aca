//! Radius expansion: the first stage of every preparation. Grains start small at random places and grow to their size. Used for
//! cylinders ([`super::preparation`]) and for boxes (`super::continuum`).

use engine::dem::physics::Physics;
use engine::dem::{State, Workspace};
use engine::grains::sphere_volume;

/// Radii at the start of growth over final radii.
pub const START: f64 = 0.35;
/// Scaled inertia during growth is chosen for this many times the stress that the specimen will have: large overlaps come and go
/// during growth.
pub const STRESS: f64 = 100.0;
/// Inertial number of the walls' motion during compaction: fast, yet without disturbing the packing.
pub const INERTIAL: f64 = 3e-3;
/// Unbalanced ratio below which grains count as at rest.
pub const UNBALANCED: f64 = 2e-3;
/// Largest difference of a stress from its target, over the target, at rest.
pub const STRESS_AT_REST: f64 = 0.01;

/// Sets the radii of step `step` (from 0) of `steps`, and the masses that go with them; `radii` are the final radii by id, m. The
/// radii grow fast at first and slowly at the end.
pub fn grow(physics: &Physics, radii: &[f64], step: u64, steps: u64, state: &mut State, work: &mut Workspace) {
    let left = 1.0 - (step + 1) as f64 / steps as f64;
    let scale = START + (1.0 - START) * (1.0 - left * left);
    let g = &mut state.grains;
    for i in 0..g.len() {
        let r = scale * radii[g.id[i] as usize];
        g.pos[i][3] = r;
        g.mass[i] = physics.materials[g.material[i] as usize].density * sphere_volume(r);
    }
    work.grown(g);
}

/// Sets all velocities and spins to zero.
pub fn still(state: &mut State) {
    let g = &mut state.grains;
    for i in 0..g.len() {
        g.vel[i] = [0.0, 0.0, 0.0, g.vel[i][3]];
        g.spin[i] = [0.0; 4];
    }
}
