//! Preparation of a specimen on the way from the loosest to the densest packing that the program can make. The specimen leaves
//! the way where it has the porosity asked for. The way itself does not depend on this porosity, so its two ends are the range of
//! porosities that can be made ([`super::range`]).
//!
//! 1. Radii grow in a cylinder that is much larger than the specimen.
//! 2. The specimen is compressed until its grains have jammed: they bear a stress at rest. This is the loosest specimen.
//! 3. Compression goes on at a steady rate, while the friction between grains is lowered just enough to keep the stress constant.
//! 4. When no friction is left, the specimen is sheared to and fro under a rising stress. This ends with the densest specimen.
//!
//! Where the specimen leaves the way, the walls stop until the grains are quiet; friction becomes that of the material; the
//! stress is let down to the isotropic one; and the grains come to rest. On the way the stress is the one under which contacts
//! overlap by a given share of the radius ([`OVERLAP`]): under the small isotropic stress of stiff grains the way would take ten
//! times as many steps.

use super::drive::{Drive, mean_stress};
use super::{bears, check_growth, check_state, porosity, scattered};
use crate::error::Error;
use crate::model::{Model, Specimen};
use crate::rig::cylinder::{BOTTOM, CYLINDER, TOP, walls};
use crate::rig::growth;
use engine::check::{self, Checked, ensure};
use engine::contact::ContactLaw;
use engine::dem;
use engine::dem::observables;
use engine::dem::{State, Workspace};
use serde::{Deserialize, Serialize};

/// The stage of a preparation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stage {
    /// Radii grow to their final size.
    Growth,
    /// The specimen is compressed until its grains have jammed, then at a steady rate while friction is lowered.
    Compression,
    /// The specimen is sheared to and fro without friction.
    Shearing,
    /// The specimen has left the way: the walls stand still until the grains are quiet.
    Quiet,
    /// The stress falls to the isotropic one.
    Unloading,
    /// The specimen comes to rest with the friction of its material.
    Rest,
}

impl Stage {
    /// Name for messages and the progress bar.
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

/// Where the specimen leaves the way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Wish {
    /// At the first jammed state.
    Loosest,
    /// At the end of shearing.
    Densest,
    /// At this porosity.
    Porosity(f64),
}

/// The state of a preparation; with the [`State`] of the grains it is all that a restart needs.
///
/// The expected porosity of a state on the way is the one that the specimen would have at rest under the isotropic stress
/// ([`Path::foreseen`]).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Path {
    /// The present stage.
    pub stage: Stage,
    /// Steps in the present stage.
    pub stage_steps: u64,
    /// Steps done.
    pub steps: u64,
    wish: Wish,
    /// Final radii by id, m.
    radii: Vec<f64>,
    /// Stress of compression, Pa.
    stress: f64,
    place: Place,
    /// Expected porosity at which the specimen leaves the way: the target, corrected by the difference between expected porosity
    /// and porosity at rest of earlier attempts.
    aim: f64,
    /// Expected porosities of the last attempt that came to rest too loose, and of the last that came to rest too dense.
    known: [Option<f64>; 2],
    /// Target stress of the walls during unloading, Pa.
    asked: f64,
    drive: Drive,
    /// Saved states on the way, from which the preparation goes on after a specimen that came to rest too dense: the loosest, and
    /// the last few.
    marks: Vec<Mark>,
    /// The state in which the specimen left the way.
    left: Option<Mark>,
    /// Number of specimens that came to rest outside the tolerance.
    corrections: u32,
    /// The model with which specimens are made ([`quasi_static`]).
    #[serde(skip)]
    model: Option<Box<Model>>,
}

/// A place on the way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Place {
    /// [`Stage::Compression`] or [`Stage::Shearing`].
    stage: Stage,
    /// Whether the grains have borne the stress of compression at rest.
    jammed: bool,
    /// Cycles of shear done.
    cycles: u32,
    /// Radial strain amplitude of a cycle.
    amplitude: f64,
    /// Sum of the radial strains of all cycles, in either direction.
    sheared: f64,
}

impl Place {
    fn check(&self) -> Checked {
        ensure(matches!(self.stage, Stage::Compression | Stage::Shearing), || "a place that is not on the way".into())?;
        check::positive("amplitude of shear", [self.amplitude])?;
        check::not_negative("shear", [self.sheared])
    }
}

/// A saved state on the way.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Mark {
    /// Expected porosity.
    porosity: f64,
    place: Place,
    drive: Drive,
    state: State,
}

/// Porosity of the cylinder in which radii grow: looser than any packing that bears a stress.
const ROOM: f64 = 0.55;
/// Overlap of contacts over the radius under the stress of compression. With a tenth of this the way takes three times as many
/// steps; with three times this the porosity rises by 0.01 when the stress is let down.
const OVERLAP: f64 = 3e-3;
/// Largest stress of shearing over the stress of compression. With this and the next value the densest specimen was reached in
/// the fewest steps with overlaps of 1 % of the radius.
const SHEAR_STRESS: f64 = 5.0;
/// Rise of the stress of shearing with each cycle, over the stress of compression.
const SHEAR_RISE: f64 = 0.5;
/// Radial strain amplitude of a cycle; with larger ones the specimen ends looser.
const AMPLITUDE: f64 = 0.01;
/// Sum of the radial strains of all cycles at which shearing ends: no further cycle lowers the porosity by more than 0.0001.
const SHEARED: f64 = 1.0;
/// Largest local damping before grains have jammed and while they are sheared. Oscillating grains find denser places; a packing
/// held up by strong damping would collapse slowly, over 10^5 steps, under a small stress.
const SWING: f64 = 0.1;
/// Relative change of friction in one step when the stress differs from its target by the target itself or more.
const VALVE: f64 = 1e-2;
/// Stress, over the stress of compression, at which the strain rate of a specimen that has not jammed becomes zero.
const PRESS: f64 = 1.1;
/// Friction coefficient below which friction counts as none.
const FRICTIONLESS: f64 = 1e-2;
/// Stress, over the stress of compression, at which compression ends when no friction is left.
const SPENT: f64 = 1.2;
/// Stress, over the stress of compression, at which the strain rate of jammed grains becomes zero until friction has fallen.
const FULL: f64 = 2.0;
/// Steps in [`Stage::Rest`] after which quiet grains count as at rest. The loosest specimens of wide gradations creep on: by 0.3
/// % of the porosity in the next 10^5 steps.
const CREEP: u64 = 10_000;
/// Steps between two checks of equilibrium.
const LOOK: u64 = 64;
/// Unbalanced ratio below which grains are quiet.
const QUIET: f64 = 5e-3;
/// Steps after which grains count as quiet in any case: a specimen that is too loose to bear a stress has no meaningful ratio.
const QUIET_STEPS: u64 = 4_000;
/// Target stress after a step of unloading over that before.
const UNLOAD: f64 = 0.997;
/// Relative fall of the expected porosity from one saved state to the next.
const MARK: f64 = 0.01;
/// Number of saved states that are kept.
const MARKS: usize = 4;
/// Rise of the porosity, when the stress is let down, over the relative overlap that ends. Measured: 0.8 to 1.2.
const SPRING: f64 = 1.0;
/// Specimens that may come to rest outside the tolerance before the preparation fails.
const CORRECTIONS: u32 = 12;

/// The model with which specimens are made: without breakage, and, where there is no gravity, with scaled inertia and therefore
/// without viscous or plastic contacts.
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

/// Stress of compression, Pa: the isotropic stress under which contacts between grains of mean volume overlap by [`OVERLAP`] of
/// their radius, at least that of the specimen.
fn stress(model: &Model, rig: &Specimen, radii: &[f64]) -> f64 {
    let volume: f64 = radii.iter().map(|&r| r * r * r).sum();
    let r = (volume / radii.len() as f64).cbrt();
    let pair = model.physics.contact.law.between(&model.physics.materials[0], &model.physics.materials[0]);
    let force = model.physics.contact.law.elastic(OVERLAP * r, OVERLAP * r, 0.5 * r, &pair).force;
    (force / (4.0 * r * r)).max(rig.isotropic_stress)
}

impl Path {
    /// The first state: small grains at random places in a cylinder of porosity [`ROOM`].
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

    /// Checks a preparation from a checkpoint, with its grains and the saved states on the way.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, model: &Model, rig: &Specimen, state: &State) -> Checked {
        let own = quasi_static(model);
        check::counters("steps", &[self.steps, self.stage_steps])?;
        check_growth(model, rig, &self.radii, (self.stage == Stage::Growth).then_some(self.stage_steps))?;
        let porosity = if let Wish::Porosity(n) = self.wish { n } else { f64::NAN };
        ensure(porosity > 0.0 && porosity < 1.0, || format!("a specimen of porosity {porosity} is asked for"))?;
        ensure(self.stress == stress(&own, rig, &self.radii), || "another stress is asked for".into())?;
        check::numbers("porosities", self.known.iter().flatten().chain([&self.aim]))?;
        check::positive("stress of unloading", [self.asked])?;
        let jammed = self.place.jammed;
        ensure(jammed || matches!(self.stage, Stage::Growth | Stage::Compression), || {
            "loose grains are sheared or at rest".into()
        })?;
        ensure(jammed != self.marks.is_empty() && self.marks.len() <= MARKS, || format!("{} saved states", self.marks.len()))?;
        let at_rest = matches!(self.stage, Stage::Quiet | Stage::Unloading | Stage::Rest);
        ensure(at_rest == self.left.is_some(), || "it is not known where the specimen has left the way".into())?;
        let marks = || self.marks.iter().chain(&self.left);
        let here = (&self.place, &self.drive, state);
        for (place, drive, state) in marks().map(|m| (&m.place, &m.drive, &m.state)).chain([here]) {
            place.check()?;
            check::not_negative("strain rate", [drive.rate])?;
            check_state(&own.physics, rig, &self.radii, state)?;
        }
        ensure(marks().all(|m| m.place.jammed), || "a loose state is saved".into())?;
        check::numbers("porosities", marks().map(|m| m.porosity))
    }

    /// One step. True when the specimen is ready.
    ///
    /// # Errors
    /// [`Error::Stalled`]: the porosity cannot be reached, or the specimen does not come to rest.
    pub fn advance(&mut self, model: &Model, rig: &Specimen, state: &mut State, work: &mut Workspace) -> Result<bool, Error> {
        let own = self.model.take().unwrap_or_else(|| Box::new(quasi_static(model)));
        let ready = self.advance_stage(&own, rig, state, work);
        self.model = Some(own);
        ready
    }

    fn advance_stage(&mut self, model: &Model, rig: &Specimen, state: &mut State, work: &mut Workspace) -> Result<bool, Error> {
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

    /// After the grains have jammed: saves this state, the loosest of all. The specimen leaves the way here or is compressed on.
    fn jammed(&mut self, rig: &Specimen, state: &mut State) {
        let n = self.foreseen(state);
        self.place.jammed = true;
        state.damping = rig.preparation.damping;
        self.mark(n, state);
        if n <= self.aim || self.wish == Wish::Loosest {
            self.leave(n, rig, state);
        }
    }

    /// After a step of compression of jammed grains: friction falls where the stress is above that of compression, and rises
    /// where it is below.
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

    /// One step of a shear cycle: the radius shrinks, grows to the other side and comes back, while the volume follows the
    /// stress.
    fn shear(&mut self, state: &mut State, work: &mut Workspace) {
        let stress = self.stress * (1.0 + SHEAR_RISE * f64::from(self.place.cycles)).min(SHEAR_STRESS);
        let volume = self.drive.rate * (1.0 - mean_stress(state) / stress).clamp(-1.0, 1.0);
        let quarter = self.quarter();
        let across = if (quarter..3 * quarter).contains(&self.stage_steps) { -self.drive.rate } else { self.drive.rate };
        self.place.sheared += self.drive.rate;
        Drive::strain(volume - 2.0 * across, across, state, work);
    }

    /// After a step of shearing: at the end of a cycle the specimen leaves the way, or the next cycle begins.
    fn sheared(&mut self, rig: &Specimen, state: &mut State) {
        if self.stage_steps < 4 * self.quarter() {
            return;
        }
        self.stage_steps = 0;
        self.place.cycles += 1;
        // sets the radius back to its exact value, against rounding
        state.walls[CYLINDER].shape = walls(rig, 0.5 * rig.diameter, 0.0, 1.0)[CYLINDER].shape;
        let n = self.foreseen(state);
        if n <= self.aim || self.exhausted() {
            self.leave(n, rig, state);
        } else {
            self.mark(n, state);
        }
    }

    /// Expected porosity: the one that the specimen would have at rest if it left the way now. The overlaps under the present
    /// stress disappear; by Hertz' law they go with stress^(2/3).
    fn foreseen(&self, state: &State) -> f64 {
        let stress = (mean_stress(state) / self.stress).max(0.0);
        porosity(state) + SPRING * OVERLAP * stress.cbrt().powi(2)
    }

    fn exhausted(&self) -> bool {
        self.place.sheared >= SHEARED
    }

    /// Saves the present state to go on from.
    fn mark(&mut self, n: f64, state: &State) {
        if matches!(self.wish, Wish::Porosity(_)) {
            // the first one is the loosest of all and is kept
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

    /// Whether a specimen that is still coming to rest is already too dense: rest only makes it denser. The loosest specimen
    /// comes to rest in any case, for the error message names its porosity.
    fn too_dense(&self, rig: &Specimen, state: &State) -> bool {
        let Wish::Porosity(target) = self.wish else { return false };
        self.stage_steps.is_multiple_of(LOOK)
            && !self.is_loosest()
            && porosity(state) < (1.0 - rig.preparation.porosity_tolerance) * target
    }

    /// Whether the specimen left the way at its loosest state.
    fn is_loosest(&self) -> bool {
        let left = self.left.as_ref().map_or(f64::NEG_INFINITY, |m| m.porosity);
        self.marks.first().is_some_and(|m| left >= m.porosity)
    }

    /// Judges a specimen at rest: true when its porosity is right. Else it goes on along the way from where it left (too loose),
    /// or from a looser saved state (too dense).
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

    /// Sets the next aim after a specimen that left the way at the expected porosity `porosity` and came to rest at a porosity
    /// larger than the target by `excess`: denser by this, but within the bounds of what is known to be too loose and too dense.
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

    /// The last saved state that is looser than the aim, or the first one. Later states are dropped, and shear goes on with half
    /// the amplitude.
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
        Error::Stalled { step: self.steps, what }
    }
}

/// Friction coefficient at the beginning of the way: the largest one of the materials. A higher one does not help: with 0.5 for a
/// material of 0.2, specimens of 3000 grains ended looser by only 0.01 in void ratio; and when friction was set to that of the
/// material they collapsed, where the gradation is wide for up to 10^5 steps.
fn friction(model: &Model) -> f64 {
    model.physics.materials.iter().map(|m| m.friction).fold(0.0, f64::max)
}

/// Message for a target beyond an end of the way: `end` names the end, `n` is its porosity, `other` a second remedy.
fn nearest(end: &str, other: &str, n: f64) -> String {
    let e = n / (1.0 - n);
    format!(
        "cannot make this specimen so {end}; the nearest that works is specimen.porosity = {n:.4} (specimen.void_ratio = {e:.4}): ask for that, or {other}"
    )
}
