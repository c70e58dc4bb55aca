//! Free assemblies: listed or imported grains, walls, gravity, a duration or a number of steps.

use crate::boundary::{Wall, servo_speed};
use crate::error::Error;
use crate::grains::Grains;
use crate::model::{Assembly, Drive, Model, WallShape};
use crate::step::{self, State, Work};

/// The first state of a free scene.
pub fn start(model: &Model, rig: &Assembly) -> State {
    let mut grains = Grains::default();
    for s in &rig.grains {
        let i = grains.add(s.position, s.radius, s.material, &model.materials);
        let m = grains.vel[i][3];
        grains.vel[i] = [s.velocity[0], s.velocity[1], s.velocity[2], m];
        grains.spin[i] = [s.spin[0], s.spin[1], s.spin[2], 0.0];
    }
    let mut state = State::new(model, grains, rig.walls.iter().map(Wall::new).collect(), model.records.energy);
    // without a load there is no stress to scale inertia by: weight of nothing, so a stiffness at 1 kPa
    state.reference_stress = 1e3;
    if let Some(crush) = &model.crush {
        state.crushing = true;
        for i in 0..state.grains.len() {
            crate::crush::event::arm_grain(model, crush, &mut state, i);
        }
    }
    state
}

/// Whether the scene's steps or duration are over.
pub fn done(rig: &Assembly, state: &State) -> bool {
    rig.steps.is_some_and(|n| state.step >= n) || rig.duration.is_some_and(|t| state.time >= t - 0.5 * state.dt)
}

/// One step; `observe` sees the state when its forces are known.
pub fn advance(
    model: &Model,
    state: &mut State,
    work: &mut Work,
    observe: impl FnOnce(&State, &Work) -> Result<(), Error>,
) -> Result<(), Error> {
    step::step(model, state, work, |state, work| {
        if state.step == 0 {
            open(model, state, work);
        }
        observe(state, work)?;
        drive(state);
        Ok(())
    })
}

/// Opens the ledger with the energies of the first instant.
fn open(model: &Model, state: &mut State, work: &Work) {
    let State { ledger, grains, walls, .. } = state;
    ledger.open(grains, walls);
    for w in state.pairs.work.iter_mut().chain(&mut state.wall_pairs.work) {
        *w = [0.0; 3];
    }
    let sums = crate::record::measure::sums(model, state, work);
    state.ledger.start = [sums.stored, sums.kinetic, sums.potential];
}

/// Largest servo speed: this share of the mean radius per step.
const SERVO_STRIDE: f64 = 1e-3;

fn drive(state: &mut State) {
    let mean_radius = state.grains.pos.iter().map(|p| p[3]).sum::<f64>() / state.grains.len().max(1) as f64;
    let limit = SERVO_STRIDE * mean_radius / state.dt;
    for w in &mut state.walls {
        w.speed = match w.drive {
            Drive::Fixed => 0.0,
            Drive::Velocity(v) => v,
            Drive::Stress { stress, area, gain } => {
                let area = match w.shape {
                    WallShape::Plane { .. } => area,
                    WallShape::Cylinder { radius, .. } => 2.0 * std::f64::consts::PI * radius * area,
                };
                servo_speed(stress * area, w.reaction, w.stiffness, gain, state.dt, limit)
            }
        };
    }
}
