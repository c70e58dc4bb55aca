//! Radius expansion: grains grow where they stand until they have their size. What preparations of cylinders and of boxes share.

use engine::dem::physics::Physics;
use engine::dem::{State, Workspace};
use engine::grains::sphere_volume;

/// Radii at the start of growth over final radii.
pub const START: f64 = 0.35;
/// Inertia during growth is that of grains under this many times the stress to come: overlaps come and go fast.
pub const STRESS: f64 = 100.0;
/// Inertial number of wall motion during compaction: a fast but orderly preparation.
pub const INERTIAL: f64 = 3e-3;
/// Unbalanced ratio at rest.
pub const UNBALANCED: f64 = 2e-3;
/// At rest: stresses within this share of the target.
pub const STRESS_AT_REST: f64 = 0.01;

/// Radii by id, m, of step `step` (from 0) of so many: fast at first, gently at the end.
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

/// All velocities to zero.
pub fn still(state: &mut State) {
    let g = &mut state.grains;
    for i in 0..g.len() {
        g.vel[i] = [0.0, 0.0, 0.0, g.vel[i][3]];
        g.spin[i] = [0.0; 4];
    }
}
