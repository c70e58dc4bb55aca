//! Free scenes: listed or imported grains move between walls, under gravity, for a time or a number of steps.

use crate::error::Error;
use crate::model::{Assembly, Model};
use engine::boundary::{Drive, WallShape};
use engine::boundary::{Wall, servo_speed};
use engine::dem;
use engine::dem::observables;
use engine::dem::{State, Workspace};
use engine::grains::{Grains, sphere_volume};

/// The first state of a free scene.
pub fn start(model: &Model, rig: &Assembly) -> State {
    let mut grains = Grains::default();
    for s in &rig.grains {
        let i = grains.add(s.position, s.radius, s.material, &model.physics.materials);
        let m = grains.vel[i][3];
        grains.vel[i] = [s.velocity[0], s.velocity[1], s.velocity[2], m];
        grains.spin[i] = [s.spin[0], s.spin[1], s.spin[2], 0.0];
    }
    let mut state = State::new(&model.physics, grains, rig.walls.iter().map(Wall::new).collect(), model.records.energy);
    state.reference_stress = least_stress(rig.walls.iter().map(|w| w.drive));
    if let Some(crush) = &model.physics.crush {
        state.crushing = true;
        for i in 0..state.grains.len() {
            engine::dem::event::arm_grain(crush, &mut state, i);
        }
    }
    state
}

/// Whether the steps or the duration of the scene are over.
pub fn done(rig: &Assembly, state: &State) -> bool {
    rig.steps.is_some_and(|n| state.step >= n) || rig.duration.is_some_and(|t| state.time >= t - 0.5 * state.dt)
}

/// One step. `observe` is called when the forces of the step are known and before grains move.
///
/// # Errors
/// A step that cannot be made; the errors of `observe`.
pub fn advance(
    model: &Model,
    state: &mut State,
    work: &mut Workspace,
    observe: impl FnOnce(&State, &Workspace) -> Result<(), Error>,
) -> Result<(), Error> {
    compute_forces(model, state, work);
    observe(state, work)?;
    drive(model, state, work, area);
    dem::integrate(&model.physics, state, work);
    Ok(())
}

/// First part of a step: computes the forces of this instant, and opens the energy ledger in the first step.
pub fn compute_forces(model: &Model, state: &mut State, work: &mut Workspace) {
    dem::compute_forces(&model.physics, state, work);
    if state.step == 0 {
        open(model, state, work);
    }
}

/// Opens the energy ledger with the energies at the start.
fn open(model: &Model, state: &mut State, work: &Workspace) {
    let State { ledger, grains, walls, .. } = state;
    ledger.open(grains, walls);
    for w in state.pairs.work.iter_mut().chain(state.wall_pairs.work.iter_mut()) {
        *w = [0.0; 4];
    }
    let sums = observables::sums(&model.physics, state, work);
    state.ledger.start = [sums.stored, sums.kinetic, sums.potential];
}

/// Largest way of a wall under servo in one step, over the largest radius, which does not depend on the order of grains.
const SERVO_STRIDE: f64 = 1e-3;
/// Least stress for which inertia is scaled, Pa: grains may bear no load at the start.
const LEAST_STRESS: f64 = 1e3;
/// Least stress for which inertia is scaled, Pa: the largest that a wall under servo will put on a grain, which comes within a few
/// steps.
fn least_stress(drives: impl Iterator<Item = Drive>) -> f64 {
    let of = |drive| if let Drive::Stress { stress, .. } = drive { stress } else { 0.0 };
    drives.map(of).fold(LEAST_STRESS, f64::max)
}

/// Steps between two updates of the stress for which inertia is scaled.
const LOOK: u64 = 32;

/// Area on which the stress of a wall acts, m²: of a plane under servo that of the scene, else 0; of a cylinder its shell over the height
/// of the grains.
pub fn area(state: &State, wall: &Wall) -> f64 {
    match (wall.shape, wall.drive) {
        (WallShape::Cylinder { radius, .. }, _) => engine::boundary::shell_area(radius, extent_z(state)),
        (WallShape::Plane { .. }, Drive::Stress { area, .. }) => area,
        _ => 0.0,
    }
}

/// Middle part of a step: sets the speed of every wall as its [`Drive`] says. `area` gives the area on which the stress of a wall acts, m².
pub fn drive(model: &Model, state: &mut State, work: &Workspace, area: impl Fn(&State, &Wall) -> f64) {
    if model.physics.stepping.inertia_scaling && state.step.is_multiple_of(LOOK) {
        state.reference_stress = contact_pressure(state, work).max(least_stress(state.walls.iter().map(|w| w.drive)));
    }
    let limit = SERVO_STRIDE * state.grains.pos.iter().map(|p| p[3]).fold(0.0, f64::max) / state.dt;
    for k in 0..state.walls.len() {
        let w = &state.walls[k];
        let speed = match w.drive {
            Drive::Fixed | Drive::Programme => 0.0,
            Drive::Velocity(v) => v,
            Drive::Stress { stress, gain, fastest, .. } => servo_speed(
                stress * area(state, w),
                w.reaction,
                w.stiffness,
                gain,
                state.dt,
                fastest.map_or(limit, |v| limit.min(v)),
            ),
        };
        state.walls[k].speed = speed;
    }
}

/// Height from the lowest to the highest point of all grains, m. The stress on a cylinder counts on its shell over this height.
fn extent_z(state: &State) -> f64 {
    let (low, high) = state
        .grains
        .pos
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[2] - p[3]), high.max(p[2] + p[3])));
    (high - low).max(0.0)
}

/// Mean stress from the contact forces, Pa: Σ F_n (r_1 + r_2) / (3 V) with V the volume of the grains.
fn contact_pressure(state: &State, work: &Workspace) -> f64 {
    let g = &state.grains;
    let (mut sum, mut volume) = (0.0, 0.0);
    for &i in &g.by_id() {
        let i = i as usize;
        volume += sphere_volume(g.radius(i));
        for e in work.neighbours.contacts.of(i).filter(|e| !e.second_end()) {
            let slot = e.slot();
            let (pool, length) = if e.is_wall() {
                (&state.wall_pairs, g.radius(i))
            } else {
                (&state.pairs, g.radius(i) + g.radius(state.pairs.ends[slot][1] as usize))
            };
            if pool.touch[slot].overlap > 0.0 {
                sum += observables::normal_force(state, slot, e.is_wall()) * length;
            }
        }
    }
    sum / (3.0 * volume)
}
