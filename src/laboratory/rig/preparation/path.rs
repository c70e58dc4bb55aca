//! The way from the loosest to the densest specimen that the program makes, left where the porosity is the one asked for. It does not depend on where it is left, so
//! its two ends are the range that can be reached ([`super::range`]).
//!
//! Radii grow in a roomy cylinder; the specimen is compressed until its grains have jammed, that is, bear a stress at rest; it is compressed on at a steady rate, and friction between
//! grains falls just as fast as keeps the stress down; without friction it is sheared to and fro under a rising stress. Where it is left, the walls stop until grains are quiet, stress is let down to the isotropic one at final friction, and grains come to
//! rest. Stresses on the way are those of a stated overlap: rearrangement under the small isotropic stress of stiff grains takes ten times as many steps.

use super::drive::{Drive, mean_stress};
use super::{bears, porosity, scattered};
use crate::error::Error;
use crate::model::{Model, Specimen};
use crate::rig::cylinder::{BOTTOM, CYLINDER, TOP, walls};
use crate::rig::growth;
use engine::contact::ContactLaw;
use engine::dem;
use engine::dem::observables;
use engine::dem::{State, Workspace};
use serde::{Deserialize, Serialize};

/// Where on its way a specimen is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stage {
    /// Radii grow to their final size.
    Growth,
    /// Compressed until grains have jammed, then at a steady rate while friction gives way.
    Compression,
    /// Sheared to and fro without friction.
    Shearing,
    /// Walls stand until grains are quiet.
    Quiet,
    /// Stress falls to the isotropic one.
    Unloading,
    /// Rest at final friction.
    Rest,
}

impl Stage {
    pub fn name(self) -> &'static str {
        match self {
            Stage::Growth => "growth",
            Stage::Compression => "compression",
            Stage::Shearing => "shearing",
            Stage::Quiet => "quiet",
            Stage::Unloading => "unloading",
            Stage::Rest => "rest",
        }
    }
}

/// Where the way is left.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Wish {
    Loosest,
    Densest,
    Porosity(f64),
}

/// Progress on the way; with the [`State`] it is all that a restart needs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Path {
    pub stage: Stage,
    pub stage_steps: u64,
    pub steps: u64,
    wish: Wish,
    /// Final radii by id, m.
    radii: Vec<f64>,
    /// Stress of compression, Pa.
    stress: f64,
    place: Place,
    /// Porosity, as foreseen ([`Path::foreseen`]), at which the way is left: the target, less by what specimens have been seen to come to rest looser than foreseen.
    aim: f64,
    /// Porosities foreseen that were too loose and too dense, the last of each.
    known: [Option<f64>; 2],
    /// Stress asked of the walls while unloading, Pa.
    asked: f64,
    drive: Drive,
    /// Places to go on from when a specimen came to rest outside tolerance: the loosest, the last few, and where the way was left.
    marks: Vec<Mark>,
    left: Option<Mark>,
    corrections: u32,
    /// The model under which specimens are made ([`quasi_static`]).
    #[serde(skip)]
    model: Option<Box<Model>>,
}

/// How far along the way, in its stages of compression and shearing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Place {
    stage: Stage,
    /// Whether grains have borne the stress of compression at rest.
    jammed: bool,
    /// Cycles of shear, their present amplitude, and the strain of all.
    cycles: u32,
    amplitude: f64,
    sheared: f64,
}

/// A state on the way.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Mark {
    /// As foreseen ([`Path::foreseen`]).
    porosity: f64,
    place: Place,
    drive: Drive,
    state: State,
}

/// Porosity of the cylinder in which radii grow: looser than any packing that bears a stress.
const ROOM: f64 = 0.55;
/// Overlap of contacts over the radius under the stress of compression. A tenth takes three times as many steps; three times as much lets the specimen spring back by 0.01 in porosity.
const OVERLAP: f64 = 3e-3;
/// Stress of shearing over that of compression, and its rise with each cycle: densest after the fewest steps with overlaps of one per cent.
const SHEAR_STRESS: f64 = 5.0;
const SHEAR_RISE: f64 = 0.5;
/// Amplitude of a cycle (larger ones end looser), and the sum of strains after which no cycle densifies by more than 0.0001.
const AMPLITUDE: f64 = 0.01;
const SHEARED: f64 = 1.0;
/// Damping while shearing, and until grains have jammed, at most: grains that swing find denser places, and what heavy damping holds up collapses for 10^5 steps under a small stress.
const SWING: f64 = 0.1;
/// Share of friction that goes, or comes back, in a step in which the stress is wrong by its own size or more.
const VALVE: f64 = 1e-2;
/// Stress at which a specimen that has not jammed is not compressed further, over that of compression.
const PRESS: f64 = 1.1;
/// Friction below which it is zero, and the stress, over that of compression, that then ends compression.
const FRICTIONLESS: f64 = 1e-2;
const SPENT: f64 = 1.2;
/// Stress, over that of compression, at which jammed grains are not compressed further until their friction has given way.
const FULL: f64 = 2.0;
/// Steps of rest after which quiet grains are at rest: the loosest specimens of wide gradations creep on, by 0.3 % of the porosity in the next 10^5 steps.
const CREEP: u64 = 10_000;
/// Steps between looks at rest.
const LOOK: u64 = 64;
/// Unbalanced ratio of quiet grains, and the steps after which they are taken for quiet (a specimen too loose to bear anything).
const QUIET: f64 = 5e-3;
const QUIET_STEPS: u64 = 4_000;
/// Stress after a step of unloading over that before.
const UNLOAD: f64 = 0.997;
/// Fall of porosity between two marks, over the porosity, and how many are kept.
const MARK: f64 = 0.01;
const MARKS: usize = 4;
/// Rise of porosity over the overlap while stress is let down: overlaps end, in three directions. Measured: 0.8 to 1.2.
const SPRING: f64 = 1.0;
/// Specimens that came to rest outside tolerance before that is an error.
const CORRECTIONS: u32 = 12;

/// The model under which specimens are made: without breakage, with scaled inertia, hence without dashpots, where gravity allows it.
fn quasi_static(model: &Model) -> Model {
    let mut own = model.clone();
    own.physics.crush = None;
    if own.physics.gravity == [0.0; 3] {
        own.physics.stepping.inertia_scaling = true;
        if own.physics.contact.law.is_viscous() || own.physics.contact.law.table().plastic {
            own.physics.contact.law = ContactLaw::Hertz;
        }
    }
    own
}

/// Isotropic stress, Pa, under which contacts of grains of mean size overlap by [`OVERLAP`] of their radius, or the specimen's own if that is more.
fn stress(model: &Model, rig: &Specimen, radii: &[f64]) -> f64 {
    let volume: f64 = radii.iter().map(|&r| r * r * r).sum();
    let r = (volume / radii.len() as f64).cbrt();
    let pair = model.physics.contact.law.between(&model.physics.materials[0], &model.physics.materials[0]);
    let force = model.physics.contact.law.elastic(OVERLAP * r, OVERLAP * r, 0.5 * r, &pair).force;
    (force / (4.0 * r * r)).max(rig.isotropic_stress)
}

impl Path {
    /// The first state: grains at a fraction of their size, at random in a roomy cylinder.
    pub fn start(model: &Model, rig: &Specimen, wish: Wish) -> (Path, State) {
        let own = quasi_static(model);
        let (radii, mut state) = scattered(&own, rig, ROOM, friction(&own));
        let stress = stress(&own, rig, &radii);
        state.reference_stress = stress;
        let aim = match wish {
            Wish::Porosity(n) => n,
            Wish::Loosest | Wish::Densest => 0.0,
        };
        let place = Place { stage: Stage::Compression, jammed: false, cycles: 0, amplitude: AMPLITUDE, sheared: 0.0 };
        let path = Path {
            stage: Stage::Growth,
            stage_steps: 0,
            steps: 0,
            wish,
            radii,
            stress,
            place,
            aim,
            known: [None; 2],
            asked: stress,
            drive: Drive::default(),
            marks: Vec::new(),
            left: None,
            corrections: 0,
            model: Some(Box::new(own)),
        };
        (path, state)
    }

    /// One step. True when the specimen is ready.
    pub fn advance(&mut self, model: &Model, rig: &Specimen, state: &mut State, work: &mut Workspace) -> Result<bool, Error> {
        let own = self.model.take().unwrap_or_else(|| Box::new(quasi_static(model)));
        let ready = self.go(&own, rig, state, work);
        self.model = Some(own);
        ready
    }

    fn go(&mut self, model: &Model, rig: &Specimen, state: &mut State, work: &mut Workspace) -> Result<bool, Error> {
        match self.stage {
            Stage::Growth => growth::grow(&model.physics, &self.radii, self.stage_steps, rig.preparation.growth_steps, state, work),
            Stage::Compression => {
                let stress = mean_stress(state) / self.stress;
                let eased = if self.place.jammed { FULL - stress } else { 1.0 - stress / PRESS };
                Drive::strain(self.drive.rate * eased.clamp(0.0, 1.0), 0.0, state, work);
            }
            Stage::Shearing => self.shear(state, work),
            _ => {}
        }
        dem::step(&model.physics, state, work, |state, _| {
            if matches!(self.stage, Stage::Unloading | Stage::Rest) {
                self.drive.servo(self.asked, self.stage_steps, rig, state);
            }
            Ok::<(), Error>(())
        })?;
        self.stage_steps += 1;
        self.steps += 1;
        if self.steps > rig.preparation.max_steps {
            return Err(self.failure(state, "did not come to rest within preparation.max_steps; raise it"));
        }
        match self.stage {
            Stage::Growth if self.stage_steps >= rig.preparation.growth_steps => {
                growth::still(state);
                state.stability_interval = LOOK / 8;
                state.damping = state.damping.min(SWING);
                self.drive = Drive::at(state, self.stress);
                self.enter(Stage::Compression);
            }
            Stage::Compression if self.place.jammed => self.compressed(model, rig, state),
            Stage::Compression if mean_stress(state) >= self.stress && self.quiet(model, state, work) => self.jammed(rig, state),
            Stage::Shearing => self.sheared(rig, state),
            Stage::Quiet if self.stage_steps >= QUIET_STEPS || self.quiet(model, state, work) => {
                self.asked = mean_stress(state).max(rig.isotropic_stress);
                self.enter(Stage::Unloading);
            }
            Stage::Unloading if self.asked > rig.isotropic_stress => {
                self.asked = (UNLOAD * self.asked).max(rig.isotropic_stress);
            }
            Stage::Unloading => self.enter(Stage::Rest),
            Stage::Rest if self.too_dense(rig, state) || self.at_rest(model, state, work) => {
                return self.judge(model, rig, state, work);
            }
            _ => {}
        }
        Ok(false)
    }

    /// Where grains have jammed, the loosest place: the way is left there or goes on.
    fn jammed(&mut self, rig: &Specimen, state: &mut State) {
        let n = self.foreseen(state);
        self.place.jammed = true;
        state.damping = rig.preparation.damping;
        self.mark(n, state);
        if n <= self.aim || self.wish == Wish::Loosest {
            self.leave(n, rig, state);
        }
    }

    /// After a step of compression of jammed grains: friction gives way to a stress that is too high, and comes back under one that is too low.
    fn compressed(&mut self, model: &Model, rig: &Specimen, state: &mut State) {
        let (first, n, sigma) = (friction(model), self.foreseen(state), mean_stress(state));
        let excess = (sigma / self.stress - 1.0).clamp(-1.0, 1.0);
        let mu = state.friction.unwrap_or(first) * (1.0 - VALVE * excess);
        state.friction = Some(mu.clamp((0.1 * FRICTIONLESS).min(first), first));
        if self.marks.last().is_some_and(|m| n < (1.0 - MARK) * m.porosity) {
            self.mark(n, state);
        }
        if n <= self.aim {
            self.leave(n, rig, state);
        } else if mu < FRICTIONLESS && sigma > SPENT * self.stress {
            state.friction = Some(0.0);
            state.damping = state.damping.min(SWING);
            self.place.stage = Stage::Shearing;
            self.enter(Stage::Shearing);
            self.mark(n, state);
        }
    }

    /// Steps of a quarter of a cycle.
    fn quarter(&self) -> u64 {
        (self.place.amplitude / self.drive.rate).ceil() as u64
    }

    /// A step of a cycle: volume follows the stress, shear goes in, out to the other side and back.
    fn shear(&mut self, state: &mut State, work: &mut Workspace) {
        let stress = self.stress * (1.0 + SHEAR_RISE * f64::from(self.place.cycles)).min(SHEAR_STRESS);
        let volume = self.drive.rate * (1.0 - mean_stress(state) / stress).clamp(-1.0, 1.0);
        let quarter = self.quarter();
        let across = if (quarter..3 * quarter).contains(&self.stage_steps) { -self.drive.rate } else { self.drive.rate };
        self.place.sheared += self.drive.rate;
        Drive::strain(volume - 2.0 * across, across, state, work);
    }

    /// After a step of shearing: at the end of a cycle the way is left, goes on, or ends.
    fn sheared(&mut self, rig: &Specimen, state: &mut State) {
        if self.stage_steps < 4 * self.quarter() {
            return;
        }
        self.stage_steps = 0;
        self.place.cycles += 1;
        // what rounding has left of the shear
        state.walls[CYLINDER].shape = walls(rig, 0.5 * rig.diameter, 0.0, 1.0)[CYLINDER].shape;
        let n = self.foreseen(state);
        if n <= self.aim || self.exhausted() {
            self.leave(n, rig, state);
        } else {
            self.mark(n, state);
        }
    }

    /// Porosity to which a specimen that were left now would come: the overlaps of its present stress end, after Hertz.
    fn foreseen(&self, state: &State) -> f64 {
        let stress = (mean_stress(state) / self.stress).max(0.0);
        porosity(state) + SPRING * OVERLAP * stress.cbrt().powi(2)
    }

    fn exhausted(&self) -> bool {
        self.place.sheared >= SHEARED
    }

    /// Keeps this place to go on from.
    fn mark(&mut self, n: f64, state: &State) {
        if matches!(self.wish, Wish::Porosity(_)) {
            // the first is the loosest of all
            if self.marks.len() >= MARKS {
                self.marks.remove(1);
            }
            self.marks.push(self.here(n, state));
        }
    }

    fn here(&self, n: f64, state: &State) -> Mark {
        Mark { porosity: n, place: self.place, drive: self.drive, state: state.clone() }
    }

    fn leave(&mut self, n: f64, rig: &Specimen, state: &mut State) {
        self.left = matches!(self.wish, Wish::Porosity(_)).then(|| self.here(n, state));
        for wall in &mut state.walls {
            wall.speed = 0.0;
        }
        state.friction = None;
        state.damping = rig.preparation.damping;
        self.enter(Stage::Quiet);
    }

    fn enter(&mut self, stage: Stage) {
        self.stage = stage;
        self.stage_steps = 0;
    }

    fn quiet(&self, model: &Model, state: &State, work: &Workspace) -> bool {
        self.stage_steps.is_multiple_of(LOOK)
            && observables::sums(&model.physics, state, work).unbalanced_ratio(state.grains.len()) < QUIET
    }

    fn at_rest(&self, model: &Model, state: &State, work: &Workspace) -> bool {
        if !self.stage_steps.is_multiple_of(LOOK) || self.stage_steps < 4 * LOOK {
            return false;
        }
        let unbalanced = if self.stage_steps < CREEP { growth::UNBALANCED } else { QUIET };
        bears(state, &[TOP, BOTTOM, CYLINDER], self.asked)
            && observables::sums(&model.physics, state, work).unbalanced_ratio(state.grains.len()) < unbalanced
    }

    /// Whether a specimen that is still coming to rest is denser than asked already: rest makes it denser only. The loosest is let come to rest, to be told.
    fn too_dense(&self, rig: &Specimen, state: &State) -> bool {
        let Wish::Porosity(target) = self.wish else { return false };
        self.stage_steps.is_multiple_of(LOOK)
            && !self.is_loosest()
            && porosity(state) < (1.0 - rig.preparation.porosity_tolerance) * target
    }

    /// Whether the way was left at its beginning.
    fn is_loosest(&self) -> bool {
        let left = self.left.as_ref().map_or(f64::NEG_INFINITY, |m| m.porosity);
        self.marks.first().is_some_and(|m| left >= m.porosity)
    }

    /// At rest: ready, on along the way from where it was left, or back to a looser place.
    fn judge(&mut self, model: &Model, rig: &Specimen, state: &mut State, work: &mut Workspace) -> Result<bool, Error> {
        let n = porosity(state);
        let Wish::Porosity(target) = self.wish else { return Ok(true) };
        if (n - target).abs() <= rig.preparation.porosity_tolerance * target {
            return Ok(true);
        }
        let loosest = self.is_loosest();
        let Some(left) = self.left.take() else { unreachable!("a place was left before this rest") };
        self.corrections += 1;
        self.aim_again(left.porosity, n - target);
        if n > target && self.exhausted() {
            return Err(self.failure(state, &nearest("dense", "take a wider gradation or a larger diameter and more grains", n)));
        }
        if n < target && loosest {
            return Err(self.failure(state, &nearest("loose", "give the material more friction or rolling_friction", n)));
        }
        if self.corrections > CORRECTIONS {
            return Err(self.failure(state, "came to rest outside preparation.porosity_tolerance each time; raise it"));
        }
        let Mark { place, drive, state: before, .. } = if n > target { left } else { self.back() };
        *state = State { step: state.step, time: state.time, ..before };
        (self.place, self.drive) = (place, drive);
        work.restart(&model.physics, state);
        self.enter(place.stage);
        Ok(false)
    }

    /// The next aim, after a specimen left at `porosity` came to rest looser than asked by `excess`: as much denser, but between the places known as too loose and too dense.
    fn aim_again(&mut self, porosity: f64, excess: f64) {
        let side = usize::from(excess < 0.0);
        self.known[side] = Some(porosity);
        self.aim = porosity - excess;
        if let [Some(loose), Some(dense)] = self.known
            && dense < loose
            && !(dense < self.aim && self.aim < loose)
        {
            self.aim = 0.5 * (loose + dense);
        }
    }

    /// The last place on the way that is looser than the aim, or the first; those after it are forgotten, and shear goes on in smaller cycles.
    fn back(&mut self) -> Mark {
        while self.marks.len() > 1 && self.marks.last().is_some_and(|m| m.porosity <= self.aim) {
            self.marks.pop();
        }
        let amplitude = 0.5 * self.place.amplitude;
        let last = self.marks.len() - 1;
        self.marks[last].place.amplitude = amplitude;
        self.marks[last].clone()
    }

    fn failure(&self, state: &State, what: &str) -> Error {
        let target = match self.wish {
            Wish::Porosity(n) => format!(", target {n:.4} (void ratio {:.4})", n / (1.0 - n)),
            Wish::Loosest | Wish::Densest => String::new(),
        };
        let n = porosity(state);
        let what = format!("preparation ({}) {what}: porosity {n:.4} (void ratio {:.4}){target}", self.stage.name(), n / (1.0 - n));
        Error::Failed { step: self.steps, what }
    }
}

/// Friction at the beginning of the way: the material's. With 0.5 for a material of 0.2 specimens of 3000 grains end looser by 0.01 in void ratio, after a collapse, of up to 10^5 steps
/// where the gradation is wide, as soon as friction is the material's.
fn friction(model: &Model) -> f64 {
    model.physics.materials.iter().map(|m| m.friction).fold(0.0, f64::max)
}

/// What is said of a target beyond an end of the way.
fn nearest(end: &str, other: &str, n: f64) -> String {
    let e = n / (1.0 - n);
    format!(
        "cannot make this specimen so {end}; the nearest that works is specimen.porosity = {n:.4} (specimen.void_ratio = {e:.4}): ask for that, or {other}"
    )
}
