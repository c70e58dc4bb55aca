//! Crushing tests of single grains between two platens (Ciantia et al. 2015, eqs 16 and 17; Figs 7 and 8).
//!
//! Each grain has a state of its own: one grain and two planes. The lower platen is fixed, the upper one comes down, and the
//! grain moves under the forces of its two contacts; its inertia is scaled. The displacement δ of the upper platen grows by the
//! same share of itself in every step, so the force at breakage has the same relative error whatever the size and strength of the
//! grain. δ is the sum of both overlaps. By Hertz' theory each contact bears F = 4/3 E* √r (δ/2)^{3/2}.

use crate::error::Error;
use crate::model::{GrainCrushing, Model};
use engine::boundary::Wall;
use engine::boundary::{Drive, WallShape, WallSpec};
use engine::contact::pair::Pair;
use engine::dem;
use engine::dem::event::arm_grain;
use engine::dem::{State, Workspace};
use engine::grains::Grains;
use std::f64::consts::PI;

/// Displacement of the upper platen at the first step, over the diameter: the grain then touches both platens.
pub const SEATING: f64 = 1e-8;
/// Steps in which the platen takes up its speed: many times the period of the grain between its contacts, so that the grain
/// follows without oscillating. Local damping opposes the velocity and does not end an oscillation about a steady motion.
const START: u64 = 1000;
/// Points of a force-displacement curve per decade of displacement.
const PER_DECADE: f64 = 60.0;
/// Inertia is scaled for at least this share of the contact force at the first step.
const FLOOR: f64 = 0.1;

/// The result of one grain's test.
#[derive(Clone, Debug, PartialEq)]
pub struct Test {
    /// Number in the batch, from 0; the strength is drawn for this number.
    pub grain: u32,
    /// Diameter, m.
    pub diameter: f64,
    /// Limit strength as drawn, Pa.
    pub strength: f64,
    /// Force at which the grain breaks, N (eqs 16 and 17); `None` where it cannot break.
    pub limit_force: Option<f64>,
    /// Force at breakage, or at the end of the test, N.
    pub force: f64,
    /// Displacement at breakage, or at the end of the test, m.
    pub displacement: f64,
    /// Whether the grain broke.
    pub broken: bool,
    /// Steps of the test. A grain that broke in the first step broke as soon as it touched the platens.
    pub steps: u64,
    /// Largest relative difference of a platen's force from Hertz' force at any step.
    pub deviation: f64,
    /// Largest relative difference of the two platens' forces at any step.
    pub difference: f64,
    /// Points of the force-displacement curve, where the model asks for it.
    pub curve: Vec<Point>,
}

/// One point of a force-displacement curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Displacement of the upper platen, m.
    pub displacement: f64,
    /// Force on the lower platen, N.
    pub bottom: f64,
    /// Force on the upper platen, N.
    pub top: f64,
}

/// Contact parameters of a grain with a platen.
pub fn pair(model: &Model, rig: &GrainCrushing) -> Pair {
    let m = &model.physics.materials;
    let grain = &m[usize::from(rig.grain)];
    match rig.platen {
        Some(k) => model.physics.contact.law.between(grain, &m[usize::from(k)]),
        None => model.physics.contact.law.on_wall(grain, 0.0),
    }
}

/// Hertz' force, N, on a sphere of radius `r`, m, between two platens whose displacement is `delta`, m: each contact has half of
/// it. `e_eff` is E*, Pa.
pub fn hertz(e_eff: f64, r: f64, delta: f64) -> f64 {
    let overlap = 0.5 * delta;
    4.0 / 3.0 * e_eff * (r * overlap).sqrt() * overlap
}

/// Displacement of the platens, m, at which [`hertz`] is `force`, N.
pub fn hertz_displacement(e_eff: f64, r: f64, force: f64) -> f64 {
    2.0 * (0.75 * force / (e_eff * r.sqrt())).cbrt().powi(2)
}

/// Steps from the first contact to the largest displacement.
pub fn most_steps(rig: &GrainCrushing) -> f64 {
    ((rig.max_displacement / SEATING).ln() / rig.step.ln_1p() + 0.5 * START as f64).ceil()
}

/// The first state of a test: the grain touches both platens.
fn seated(model: &Model, rig: &GrainCrushing, number: u32) -> State {
    let d = rig.diameters[number as usize];
    let r = 0.5 * d;
    // the grain's id is its number in the batch: the strength is drawn for the id
    let mut grains = Grains { next_id: number, ..Grains::default() };
    grains.add([0.0; 3], r, rig.grain, &model.physics.materials);
    let at = r - 0.5 * SEATING * d;
    let platen = |side: f64| {
        let shape = WallShape::Plane { point: [0.0, 0.0, side * at], normal: [0.0, 0.0, -side] };
        Wall::new(&WallSpec { shape, friction: 0.0, drive: Drive::Fixed, material: rig.platen })
    };
    let mut state = State::new(&model.physics, grains, vec![platen(-1.0), platen(1.0)], false);
    state.reference_stress = FLOOR * hertz(pair(model, rig).e_eff, r, SEATING * d) / (PI * r * r);
    if let Some(crush) = &model.physics.crush {
        state.crushing = true;
        arm_grain(crush, &mut state, 0);
    }
    state
}

fn height(wall: &Wall) -> f64 {
    match wall.shape {
        WallShape::Plane { point, .. } => point[2],
        WallShape::Cylinder { .. } => f64::NAN,
    }
}

/// Tests grain `number` until it breaks or its test ends. `stop` is called every 256 steps; `None` is returned when it is true.
///
/// # Errors
/// [`Error::Unstable`]: the force on a platen is not finite.
pub fn press(model: &Model, rig: &GrainCrushing, number: u32, stop: impl Fn() -> bool) -> Result<Option<Test>, Error> {
    let d = rig.diameters[number as usize];
    let e_eff = pair(model, rig).e_eff;
    let mut state = seated(model, rig, number);
    let mut work = Workspace::new(&model.physics, &mut state);
    let limit_force = model.physics.crush.as_ref().filter(|c| d > c.d_limit);
    let mut test = Test {
        grain: number,
        diameter: d,
        strength: state.grains.strength[0],
        limit_force: limit_force.map(|c| c.criterion.limit_force(state.grains.strength[0], d, 0.5 * d, e_eff)),
        force: 0.0,
        displacement: 0.0,
        broken: false,
        steps: 0,
        deviation: 0.0,
        difference: 0.0,
        curve: Vec::new(),
    };
    let wanted = rig.curves.binary_search(&number).is_ok();
    let mut next = 0.0;
    let mut over = false;
    loop {
        dem::step(&model.physics, &mut state, &mut work, |state, _| {
            let delta = d - (height(&state.walls[1]) - height(&state.walls[0]));
            let point = Point { displacement: delta, bottom: state.walls[0].reaction, top: state.walls[1].reaction };
            observe(&mut test, &point, hertz(e_eff, 0.5 * d, delta), state.step)?;
            over = delta >= rig.max_displacement * d || rig.max_force.is_some_and(|most| test.force >= most);
            if wanted && (delta >= next || over) {
                test.curve.push(point);
                next = delta * 10f64.powf(1.0 / PER_DECADE);
            }
            let increment = rig.step * (state.step.min(START) as f64 / START as f64);
            state.walls[1].speed = increment * delta / state.dt;
            Ok::<(), Error>(())
        })?;
        test.steps = state.step;
        if let Some(event) = work.breakages.first() {
            (test.broken, test.force) = (true, event.force);
            let last = Point { displacement: test.displacement, bottom: state.walls[0].reaction, top: state.walls[1].reaction };
            if wanted && test.curve.last() != Some(&last) {
                test.curve.push(last);
            }
            return Ok(Some(test));
        }
        if over {
            return Ok(Some(test));
        }
        if state.step.is_multiple_of(256) && stop() {
            return Ok(None);
        }
    }
}

/// Adds one step to the result.
fn observe(test: &mut Test, now: &Point, hertz: f64, step: u64) -> Result<(), Error> {
    let (low, high) = (now.bottom.min(now.top), now.bottom.max(now.top));
    let deviation = (low / hertz - 1.0).abs().max((high / hertz - 1.0).abs());
    if !deviation.is_finite() {
        let what = "the force on a platen is not finite: lower stepping.safety".into();
        return Err(Error::Unstable { step, what, grain: Some(u64::from(test.grain)) });
    }
    test.deviation = test.deviation.max(deviation);
    test.difference = test.difference.max(high / low - 1.0);
    (test.force, test.displacement) = (high, now.displacement);
    Ok(())
}
