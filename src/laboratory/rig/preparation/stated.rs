//! Preparation with a stated friction during growth (Ciantia et al. 2015, "Model application"): radii grow; the specimen is
//! compressed by the platen under servo while friction is lowered until the target porosity is reached; then the specimen comes
//! to rest with the friction of its material, platen and cylinder under servo.

use super::{bears, check_growth, check_state, porosity, scattered};
use crate::error::Error;
use crate::model::{Model, Specimen};
use crate::rig::cylinder::{BOTTOM, CYLINDER, Stresses, TOP, inertial_time, space};
use crate::rig::growth;
use engine::boundary::servo_speed;
use engine::check::{self, Checked};
use engine::dem;
use engine::dem::observables;
use engine::dem::{State, Workspace};
use serde::{Deserialize, Serialize};

/// The stage of a preparation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Stage {
    /// Radii grow to their final size.
    Growth,
    /// The platen holds the isotropic stress, with the friction of growth, until the grains are at rest.
    Compaction,
    /// Friction falls until the target porosity is reached.
    Densification,
    /// The specimen is looser than the target even without friction: the platen presses with a higher stress.
    Pressing,
    /// The stress is let down after [`Stage::Pressing`]. Both stages repeat, with a higher stress each time.
    Release,
    /// The specimen comes to rest with the friction of its material.
    Rest,
}

impl Stage {
    /// Name for messages and the progress bar.
    pub fn name(&self) -> &'static str {
        match self {
            Stage::Growth => "growth",
            Stage::Compaction => "compaction",
            Stage::Densification => "densification",
            Stage::Pressing => "pressing",
            Stage::Release => "release",
            Stage::Rest => "rest",
        }
    }
}

/// The state of a preparation; with the [`State`] of the grains it is all that a restart needs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Stated {
    /// The present stage.
    pub stage: Stage,
    /// Steps in the present stage.
    pub stage_steps: u64,
    /// Steps done.
    pub steps: u64,
    /// Final radii by id, m.
    radii: Vec<f64>,
    /// Largest speed of a wall, m/s.
    limit: f64,
    press: Press,
    /// Porosity at which densification ends: the target, corrected by the change of porosity in earlier rests.
    aim: f64,
    /// Number of specimens that came to rest outside the tolerance.
    corrections: u32,
    /// The grains before densification: the preparation returns to this state from a specimen that is too dense.
    compacted: Option<Box<State>>,
}

/// The search for the stress with which a specimen must be pressed. All stresses are multiples of the isotropic stress.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Press {
    /// The present stress.
    stress: f64,
    /// The largest stress after which the specimen was still too loose.
    weak: f64,
    /// The smallest stress after which the specimen was too dense.
    strong: Option<f64>,
    /// The grains before they were last pressed.
    before: Option<Box<State>>,
}

/// The grown grains have a porosity larger than the target by this.
const ROOM: f64 = 0.01;
/// Steps between two checks of equilibrium.
const LOOK: u64 = 64;
/// Friction after a step of densification over that before.
const FADE: f64 = 0.9995;
/// Friction coefficient below which friction is set to zero.
const FRICTIONLESS: f64 = 1e-3;
/// Stress of the first pressing over the isotropic stress. The stress is doubled until the specimen is dense enough; after a
/// stress that was too strong, the geometric mean of the bounds is tried.
const PRESS_FIRST: f64 = 4.0;
/// Largest stress of pressing over the isotropic stress.
const PRESS_LAST: f64 = 512.0;
/// Ratio of two stresses that are no longer told apart: the search ends.
const PRESS_SAME: f64 = 1.02;
/// Specimens that may come to rest outside the tolerance before the preparation fails.
const CORRECTIONS: u32 = 10;

impl Stated {
    /// The first state: small grains at random places in a cylinder that is a little larger than the specimen.
    pub fn start(model: &Model, rig: &Specimen, growth_friction: f64) -> (Stated, State) {
        let (radii, mut state) = scattered(model, rig, rig.porosity + ROOM, growth_friction);
        state.reference_stress = growth::STRESS * rig.isotropic_stress;
        let press = Press { stress: PRESS_FIRST, weak: 1.0, strong: None, before: None };
        let preparation = Stated {
            stage: Stage::Growth,
            stage_steps: 0,
            steps: 0,
            radii,
            limit: 0.0,
            press,
            aim: rig.porosity,
            corrections: 0,
            compacted: None,
        };
        (preparation, state)
    }

    /// Checks a preparation from a checkpoint, with its grains and the states that it goes back to.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, model: &Model, rig: &Specimen, state: &State) -> Checked {
        let Press { stress, weak, strong, before } = &self.press;
        check::counters("steps", &[self.steps, self.stage_steps])?;
        check_growth(model, rig, &self.radii, (self.stage == Stage::Growth).then_some(self.stage_steps))?;
        check::not_negative("speed of walls", [self.limit])?;
        check::numbers("porosity", [self.aim])?;
        let stresses = [stress, weak].into_iter().chain(strong);
        check::all("stresses of pressing", stresses, "not possible", |x| (1.0..=PRESS_LAST).contains(&x))?;
        let states = [Some(state), self.compacted.as_deref(), before.as_deref()];
        states.into_iter().flatten().try_for_each(|state| check_state(&model.physics, rig, &self.radii, state))
    }

    /// One step. True when the specimen is ready.
    ///
    /// # Errors
    /// [`Error::Stalled`]: the porosity cannot be reached, or the specimen does not come to rest.
    pub fn advance(&mut self, model: &Model, rig: &Specimen, state: &mut State, work: &mut Workspace) -> Result<bool, Error> {
        if self.stage == Stage::Growth {
            growth::grow(&model.physics, &self.radii, self.stage_steps, rig.preparation.growth_steps, state, work);
        }
        dem::step(&model.physics, state, work, |state, _| {
            if self.stage != Stage::Growth {
                self.servo(rig, state);
            }
            Ok::<(), Error>(())
        })?;
        self.stage_steps += 1;
        self.steps += 1;
        if self.steps > rig.preparation.max_steps {
            let n = porosity(state);
            let advice = if n > rig.porosity && self.stage != Stage::Growth {
                format!(
                    "; the densest specimen that it reaches has about {n:.3} (void ratio {:.3}): ask for a looser specimen, more grains or a wider gradation",
                    n / (1.0 - n)
                )
            } else {
                String::new()
            };
            return Err(self.failure(rig, state, &format!("did not come to rest within preparation.max_steps{advice}")));
        }
        match self.stage {
            Stage::Growth if self.stage_steps >= rig.preparation.growth_steps => {
                growth::still(state);
                state.reference_stress = rig.isotropic_stress;
                state.stability_interval = LOOK / 8;
                self.enter(Stage::Compaction);
            }
            Stage::Compaction if self.at_rest(model, rig, state, work) => {
                let n = porosity(state);
                if n < rig.porosity * (1.0 - rig.preparation.porosity_tolerance) {
                    return Err(self.failure(
                        rig,
                        state,
                        "the loosest packing is already denser; raise preparation.growth_friction",
                    ));
                }
                self.compacted = Some(Box::new(state.clone()));
                self.enter(Stage::Densification);
            }
            Stage::Densification => {
                let mu = state.friction.unwrap_or(0.0);
                if self.dense_enough(rig, state) {
                    self.finish(state);
                } else if mu > FRICTIONLESS {
                    state.friction = Some(mu * FADE);
                } else if mu > 0.0 {
                    state.friction = Some(0.0);
                    self.stage_steps = 0;
                } else if self.at_rest(model, rig, state, work) {
                    self.press(state);
                }
            }
            Stage::Pressing if self.at_rest(model, rig, state, work) => self.enter(Stage::Release),
            Stage::Release if self.at_rest(model, rig, state, work) => {
                if self.dense_enough(rig, state) {
                    self.finish(state);
                } else if self.press.in_vain(porosity(state), rig) {
                    return Err(self.failure(
                        rig,
                        state,
                        "cannot make so few grains as dense as asked, even pressed without friction; raise specimen.porosity or specimen.grains",
                    ));
                } else {
                    self.press.harder();
                    self.press(state);
                }
            }
            Stage::Rest if self.at_rest(model, rig, state, work) => {
                let (n, tolerance) = (porosity(state), rig.preparation.porosity_tolerance * rig.porosity);
                if (n - rig.porosity).abs() <= tolerance {
                    return Ok(true);
                }
                let before = if n < rig.porosity && self.press.softer() { self.press.before.take() } else { None };
                if let Some(before) = before {
                    *state = State { step: state.step, time: state.time, ..*before };
                    work.restart(&model.physics, state);
                    self.press(state);
                } else if !self.correct(n, model, rig, state, work) {
                    return Err(self.failure(rig, state, "came to rest outside preparation.porosity_tolerance"));
                }
            }
            _ => {}
        }
        Ok(false)
    }

    /// After a rest at a porosity `n` outside the tolerance: begins densification again, with a corrected aim. A specimen that is
    /// too loose goes on from where it is, one that is too dense from the state before densification. False after [`CORRECTIONS`]
    /// attempts.
    fn correct(&mut self, n: f64, model: &Model, rig: &Specimen, state: &mut State, work: &mut Workspace) -> bool {
        self.corrections += 1;
        let dense = n < rig.porosity;
        let (true, Some(compacted)) = (self.corrections <= CORRECTIONS, &self.compacted) else { return false };
        if dense {
            let (step, time) = (state.step, state.time);
            *state = State { step, time, ..(**compacted).clone() };
            work.restart(&model.physics, state);
        } else {
            state.friction = Some(model.physics.materials.iter().map(|m| m.friction).fold(0.0, f64::max));
        }
        self.aim -= n - rig.porosity;
        self.press = Press { stress: PRESS_FIRST, weak: 1.0, strong: None, before: None };
        self.enter(Stage::Densification);
        true
    }

    /// Whether the specimen is dense enough. A porosity a little above the target serves: the rest that follows changes it
    /// little.
    fn dense_enough(&self, rig: &Specimen, state: &State) -> bool {
        porosity(state) <= self.aim * (1.0 + 0.7 * rig.preparation.porosity_tolerance)
    }

    /// Ends densification: from here on friction is that of the material.
    fn finish(&mut self, state: &mut State) {
        state.friction = None;
        self.enter(Stage::Rest);
    }

    /// Isotropic stress of the present stage, Pa.
    fn stress(&self, rig: &Specimen) -> f64 {
        match self.stage {
            Stage::Pressing => rig.isotropic_stress * self.press.stress,
            _ => rig.isotropic_stress,
        }
    }

    fn press(&mut self, state: &State) {
        self.press.before = Some(Box::new(state.clone()));
        self.enter(Stage::Pressing);
    }

    fn enter(&mut self, stage: Stage) {
        self.stage = stage;
        self.stage_steps = 0;
    }

    fn servo(&mut self, rig: &Specimen, state: &mut State) {
        let size = space(state);
        if self.stage_steps.is_multiple_of(LOOK / 4) {
            // the speed follows the present stress, not the target: a soft specimen is pressed slowly at first
            let now = Stresses::of(state).top.clamp(rig.isotropic_stress, self.stress(rig));
            state.reference_stress = now;
            self.limit = growth::INERTIAL * size.height / inertial_time(state, now);
        }
        let stress = self.stress(rig);
        // the cylinder keeps its radius until the porosity is reached; then it is under servo as well
        let shell_limit = if self.stage == Stage::Rest { self.limit * size.radius / size.height } else { 0.0 };
        for (k, area, limit) in [(TOP, size.platen_area(), self.limit), (CYLINDER, size.shell_area(), shell_limit)] {
            let w = &mut state.walls[k];
            w.speed = servo_speed(stress * area, w.reaction, w.stiffness, rig.servo_gain, state.dt, limit);
        }
    }

    fn at_rest(&self, model: &Model, rig: &Specimen, state: &State, work: &Workspace) -> bool {
        if !self.stage_steps.is_multiple_of(LOOK) || self.stage_steps < 4 * LOOK {
            return false;
        }
        let held: &[usize] = if self.stage == Stage::Rest { &[TOP, BOTTOM, CYLINDER] } else { &[TOP, BOTTOM] };
        bears(state, held, self.stress(rig))
            && observables::sums(&model.physics, state, work).unbalanced_ratio(state.grains.len()) < growth::UNBALANCED
    }

    fn failure(&self, rig: &Specimen, state: &State, what: &str) -> Error {
        Error::Stalled {
            step: self.steps,
            what: format!(
                "preparation ({}) {what}: porosity {:.4}, target {:.4} (specimen.porosity)",
                self.stage.name(),
                porosity(state),
                rig.porosity
            ),
        }
    }
}

impl Press {
    /// Chooses the next stress after one that was too weak.
    fn harder(&mut self) {
        self.weak = self.stress;
        self.stress = self.strong.map_or((2.0 * self.stress).min(PRESS_LAST), |strong| (self.weak * strong).sqrt());
    }

    /// Whether pressing has reached its largest stress and this brought less than a twentieth of the tolerance.
    fn in_vain(&self, n: f64, rig: &Specimen) -> bool {
        let least = 0.05 * rig.preparation.porosity_tolerance * rig.porosity;
        self.stress >= PRESS_LAST && self.before.as_ref().is_some_and(|before| porosity(before) - n < least)
    }

    /// Chooses the next stress after one that was too strong; false if no stress is left between the bounds.
    fn softer(&mut self) -> bool {
        self.strong = Some(self.stress);
        let between = self.stress > PRESS_SAME * self.weak;
        self.stress = (self.weak * self.stress).sqrt();
        between
    }
}
