//! The oedometer: a cylinder of fixed radius, a fixed bottom platen, a top platen that follows the load programme of
//! Ciantia et al. 2015 eq. (18) under stress servo.

use crate::boundary::{Wall, servo_speed};
use crate::error::Error;
use crate::grains::Grains;
use crate::model::{Drive, Model, Oedometer, WallShape, WallSpec};
use crate::step::{self, State, Work};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Indices of the walls.
pub const BOTTOM: usize = 0;
pub const TOP: usize = 1;
pub const CYLINDER: usize = 2;

/// The three walls, with the material's or the scene's friction.
pub fn walls(rig: &Oedometer, radius: f64, bottom: f64, height: f64) -> Vec<Wall> {
    let wall = |shape, friction| Wall::new(&WallSpec { shape, friction, drive: Drive::Fixed, material: None });
    vec![
        wall(WallShape::Plane { point: [0.0, 0.0, bottom], normal: [0.0, 0.0, 1.0] }, rig.wall_friction.bottom),
        wall(WallShape::Plane { point: [0.0, 0.0, bottom + height], normal: [0.0, 0.0, -1.0] }, rig.wall_friction.top),
        wall(WallShape::Cylinder { centre: [0.0, 0.0], radius }, rig.wall_friction.cylinder),
    ]
}

/// The space between the walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walls {
    pub bottom: f64,
    pub height: f64,
    pub radius: f64,
}

impl Walls {
    pub fn of(state: &State) -> Walls {
        let z = |k: usize| match state.walls[k].shape {
            WallShape::Plane { point, .. } => point[2],
            WallShape::Cylinder { radius, .. } => radius,
        };
        Walls { bottom: z(BOTTOM), height: z(TOP) - z(BOTTOM), radius: z(CYLINDER) }
    }

    pub fn platen_area(&self) -> f64 {
        PI * self.radius * self.radius
    }

    pub fn shell_area(&self) -> f64 {
        crate::boundary::shell_area(self.radius, self.height)
    }

    pub fn volume(&self) -> f64 {
        self.platen_area() * self.height
    }
}

/// Stresses at the walls, Pa, compression positive (NOTES.md: decisions).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stresses {
    pub top: f64,
    pub bottom: f64,
    /// Radial force over the shell's current area.
    pub horizontal: f64,
}

impl Stresses {
    pub fn of(state: &State) -> Stresses {
        let size = Walls::of(state);
        Stresses {
            top: state.walls[TOP].reaction / size.platen_area(),
            bottom: state.walls[BOTTOM].reaction / size.platen_area(),
            horizontal: state.walls[CYLINDER].reaction / size.shell_area(),
        }
    }

    /// Mean platen force over area.
    pub fn vertical(&self) -> f64 {
        0.5 * (self.top + self.bottom)
    }

    /// How far the platens are from the target, over the target: both of them, but the driven one alone where friction on the shell carries a part.
    pub fn lag(&self, target: f64, rig: &Oedometer) -> f64 {
        let of = |stress: f64| (stress / target - 1.0).abs();
        if rig.wall_friction.cylinder > 0.0 { of(self.top) } else { of(self.top).max(of(self.bottom)) }
    }

    /// How far the specimen is from balance: the lag, or where it is larger the platens' difference (if the cylinder carries nothing).
    fn imbalance(&self, target: f64, rig: &Oedometer) -> f64 {
        let difference = if rig.wall_friction.cylinder > 0.0 { 0.0 } else { self.platen_difference() };
        self.lag(target, rig).max(difference)
    }

    /// Difference of the platens over their mean.
    pub fn platen_difference(&self) -> f64 {
        let v = self.vertical();
        if v > 0.0 { (self.top - self.bottom).abs() / v } else { 0.0 }
    }
}

/// Time scale of grain rearrangement d √(ρ/p) with the inertia actually used: I = strain rate × this. `d` is the mass-weighted mean
/// diameter and ρ the inertial mass over the grains' volume.
pub fn inertial_time(state: &State, pressure: f64) -> f64 {
    let g = &state.grains;
    let (mut inertia, mut volume, mut weighted) = (0.0, 0.0, 0.0);
    for &i in &g.by_id() {
        let i = i as usize;
        let v = crate::grains::sphere_volume(g.pos[i][3]);
        inertia += g.inertia(i);
        volume += v;
        weighted += 2.0 * g.pos[i][3] * v;
    }
    weighted / volume * (inertia / volume / pressure).sqrt()
}

/// Where loading is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Phase {
    /// Rest at the isotropic stress with the cylinder fixed.
    Settle,
    /// On the way to stage `k`'s stress.
    Load(usize),
    /// At stage `k`'s stress until the specimen is at rest.
    Hold(usize),
    Done,
}

/// The loading programme's state.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Loading {
    pub phase: Phase,
    pub phase_steps: u64,
    /// Target vertical stress, Pa.
    pub target: f64,
    /// Height and radius at the start of loading, m.
    pub start: (f64, f64),
    /// Largest platen speed, m per unit time.
    limit: f64,
}

/// Steps between two looks at the platen's speed limit.
const LOOK: u64 = 64;
/// A stage ends when the platens are this close to their target ...
const CLOSE: f64 = 0.005;
/// ... or after this many steps.
const HOLD_AT_MOST: u64 = 4000;

impl Loading {
    /// Starts from a specimen: strengths drawn, no history, at rest.
    pub fn start(model: &Model, rig: &Oedometer, grains: Grains, size: Walls) -> (Loading, State) {
        let walls = walls(rig, size.radius, size.bottom, size.height);
        let mut state = State::new(model, grains, walls, model.records.energy);
        state.reference_stress = rig.isotropic_stress;
        state.damping = rig.preparation.damping;
        if let Some(crush) = &model.crush {
            for i in 0..state.grains.len() {
                crate::crush::event::arm_grain(model, crush, &mut state, i);
            }
        }
        let loading = Loading {
            phase: Phase::Settle,
            phase_steps: 0,
            target: rig.isotropic_stress,
            start: (size.height, size.radius),
            limit: 0.0,
        };
        (loading, state)
    }

    /// One step; `observe` sees the state when its forces are known.
    pub fn advance(
        &mut self,
        model: &Model,
        rig: &Oedometer,
        state: &mut State,
        work: &mut Work,
        observe: impl FnOnce(&Loading, &State, &Work) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let this = &mut *self;
        step::step(model, state, work, |state, work| {
            this.programme(model, rig, state, work);
            observe(this, state, work)?;
            this.servo(rig, state);
            Ok::<(), Error>(())
        })?;
        self.phase_steps += 1;
        Ok(())
    }

    /// Next target (eq. 18) and phase.
    fn programme(&mut self, model: &Model, rig: &Oedometer, state: &mut State, work: &Work) {
        let stages = &rig.loading.stages;
        match self.phase {
            Phase::Settle if self.phase_steps >= rig.loading.settle_steps => {
                state.damping = model.damping;
                state.crushing = model.crush.is_some();
                let State { ledger, grains, walls, .. } = state;
                ledger.open(grains, walls);
                let sums = crate::record::measure::sums(model, state, work);
                state.ledger.start = [sums.stored, sums.kinetic, sums.potential];
                // the sweep of this instant belongs to what was before
                for w in state.pairs.work.iter_mut().chain(state.wall_pairs.work.iter_mut()) {
                    *w = [0.0; 4];
                }
                self.start = (Walls::of(state).height, Walls::of(state).radius);
                self.enter(Phase::Load(0));
            }
            Phase::Load(k) => {
                let stresses = Stresses::of(state);
                if stresses.lag(self.target, rig) > rig.loading.max_lag {
                    return;
                }
                let (increment, end) = (self.increment(&stresses, rig), stages[k]);
                if self.rising(k, rig) {
                    self.target = (self.target + increment).min(end);
                } else {
                    self.target = (self.target - increment).max(end);
                }
                state.reference_stress = state.reference_stress.max(self.target);
                if self.target == end {
                    self.enter(Phase::Hold(k));
                }
            }
            Phase::Hold(k) => {
                let close = Stresses::of(state).lag(self.target, rig) < CLOSE;
                if (close && self.phase_steps > LOOK) || self.phase_steps > HOLD_AT_MOST {
                    self.enter(if k + 1 < stages.len() { Phase::Load(k + 1) } else { Phase::Done });
                }
            }
            _ => {}
        }
    }

    /// What the target changes by in one step, Pa: by eq. (18), or the faster the nearer the specimen is to balance, so that a run with a
    /// given error takes few steps: quick while it is elastic, slow while grains break.
    fn increment(&self, stresses: &Stresses, rig: &Oedometer) -> f64 {
        let asked = &rig.loading;
        match asked.pace {
            None => asked.rate * asked.sigma_ref * (1.0 + (self.target / asked.sigma_ref).max(1.0).ln()),
            Some(pace) => pace * self.target * (1.0 - stresses.imbalance(self.target, rig) / asked.max_lag).max(0.0),
        }
    }

    fn enter(&mut self, phase: Phase) {
        self.phase = phase;
        self.phase_steps = 0;
    }

    /// Whether stage `k` raises the stress.
    pub fn rising(&self, k: usize, rig: &Oedometer) -> bool {
        let before = if k == 0 { rig.isotropic_stress } else { rig.loading.stages[k - 1] };
        rig.loading.stages[k] > before
    }

    fn servo(&mut self, rig: &Oedometer, state: &mut State) {
        let size = Walls::of(state);
        if state.step.is_multiple_of(LOOK) || self.limit == 0.0 {
            self.limit = rig.loading.max_inertial_number * size.height / inertial_time(state, self.target);
        }
        let force = self.target * size.platen_area();
        let w = &mut state.walls[TOP];
        w.speed = servo_speed(force, w.reaction, w.stiffness, rig.loading.servo_gain, state.dt, self.limit);
    }
}
