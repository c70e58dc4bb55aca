//! Preparation with a stated friction while growing (Ciantia et al. 2015, Model application; NOTES.md): radius expansion, isotropic
//! compression under the platen's servo with friction lowered until the target porosity is reached, rest at final friction with platen and
//! cylinder under servo.

use super::{bears, porosity, scattered};
use crate::error::Error;
use crate::model::{Model, Specimen};
use crate::rig::cylinder::{BOTTOM, CYLINDER, Stresses, TOP, inertial_time, space};
use crate::rig::growth;
use engine::boundary::servo_speed;
use engine::dem;
use engine::dem::observables;
use engine::dem::{State, Workspace};
use serde::{Deserialize, Serialize};

/// Where preparation is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Stage {
    /// Radii grow to their final size.
    Growth,
    /// Isotropic servo at growth friction until at rest.
    Compaction,
    /// Friction falls until the porosity is reached.
    Densification,
    /// Still looser without friction: pressed by the platen and let go, again and again, each time harder.
    Pressing,
    Release,
    /// Rest at final friction.
    Rest,
}

impl Stage {
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

/// Progress of a preparation; with the [`State`] it is all that a restart needs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Stated {
    pub stage: Stage,
    /// Steps done in this stage, and in all.
    pub stage_steps: u64,
    pub steps: u64,
    /// Final radii by id, m.
    radii: Vec<f64>,
    /// Largest wall speed, m per unit time.
    limit: f64,
    /// What pressing has been tried.
    press: Press,
    /// Porosity at which densification ends: the target, less what rest has been seen to change.
    aim: f64,
    /// Specimens that came to rest outside tolerance, and the assembly before densification to return to.
    corrections: u32,
    compacted: Option<Box<State>>,
}

/// Pressing: by which stress, over that of the specimen, and what is known of the stress that it takes.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Press {
    stress: f64,
    /// Left the specimen too loose; made it too dense.
    weak: f64,
    strong: Option<f64>,
    /// The assembly before it was last pressed.
    before: Option<Box<State>>,
}

/// Porosity above the target in which grains grow.
const ROOM: f64 = 0.01;
/// Steps between looks at equilibrium.
const LOOK: u64 = 64;
/// Friction factor per step during densification, and the friction below which it is zero.
const FADE: f64 = 0.9995;
const FRICTIONLESS: f64 = 1e-3;
/// Stress of the first pressing over that of the specimen; doubled each time up to the last. One that was too strong is taken back
/// for one in between, until what is known is within the last factor.
const PRESS_FIRST: f64 = 4.0;
const PRESS_LAST: f64 = 512.0;
const PRESS_SAME: f64 = 1.02;
/// Corrections of the porosity at which densification ends, after a rest outside tolerance.
const CORRECTIONS: u32 = 10;

impl Stated {
    /// The first state: grains at a fraction of their size, at random in a cylinder with some room.
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

    /// One step. True when the specimen is ready.
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
                    "; {n:.3} (void ratio {:.3}) is about the densest that it reaches: ask for a looser specimen, more grains or a wider gradation",
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

    /// After a rest at porosity `n`, outside tolerance: densification again to another porosity, on from here if too loose, from its
    /// beginning if too dense. False when that has been tried often enough.
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

    /// Slightly above the target still serves: rest at final friction changes porosity little.
    fn dense_enough(&self, rig: &Specimen, state: &State) -> bool {
        porosity(state) <= self.aim * (1.0 + 0.7 * rig.preparation.porosity_tolerance)
    }

    /// Final friction from here on.
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
            // by the stress there is, not the one to come: a pressing starts as gently as the specimen is soft
            let now = Stresses::of(state).top.clamp(rig.isotropic_stress, self.stress(rig));
            state.reference_stress = now;
            self.limit = growth::INERTIAL * size.height / inertial_time(state, now);
        }
        let stress = self.stress(rig);
        // the cylinder keeps its radius until the porosity is reached, then joins in
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
        Error::Failed {
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
    /// The present stress was too weak.
    fn harder(&mut self) {
        self.weak = self.stress;
        self.stress = self.strong.map_or((2.0 * self.stress).min(PRESS_LAST), |strong| (self.weak * strong).sqrt());
    }

    /// Whether the last stress of all brought less than a twentieth of the tolerance.
    fn in_vain(&self, n: f64, rig: &Specimen) -> bool {
        let least = 0.05 * rig.preparation.porosity_tolerance * rig.porosity;
        self.stress >= PRESS_LAST && self.before.as_ref().is_some_and(|before| porosity(before) - n < least)
    }

    /// The present stress was too strong; false if there is none in between.
    fn softer(&mut self) -> bool {
        self.strong = Some(self.stress);
        let between = self.stress > PRESS_SAME * self.weak;
        self.stress = (self.weak * self.stress).sqrt();
        between
    }
}
