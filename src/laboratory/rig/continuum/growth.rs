//! Specimens by volume expansion (Li et al. 2023, section 4.1). Coarse and fine grains grow together in a box, and its walls
//! press them until they bear the isotropic stress. Then each fine grain is replaced by a material point at the same place, so
//! that overlaps with coarse grains and loading plates stay; or the fine grains stay grains, for the same test without a
//! continuum.

use super::grains::side as wall_of;
use crate::error::{Error, Result};
use crate::model::continuum::{CoarseGrains, Growth, MpmSpecimen, MpmTest, Test};
use crate::model::{GrainSpec, Model};
use crate::packing;
use crate::rig::cylinder::inertial_time;
use crate::rig::growth::{self, INERTIAL, STRESS_AT_REST, UNBALANCED};
use ::engine::boundary::WallShape;
use ::engine::boundary::{Wall, servo_speed};
use ::engine::check::{self, Checked, ensure};
use ::engine::dem;
use ::engine::dem::observables;
use ::engine::dem::physics::Physics;
use ::engine::dem::physics::Stepping;
use ::engine::dem::{State, Workspace};
use ::engine::grains::{Grains, sphere_volume};
use ::engine::mpm::{Point, Points};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Local damping during growth.
const DAMPING: f64 = 0.7;
/// Share of the difference between force and target that a wall under servo removes in one step.
const GAIN: f64 = 0.5;
/// Unbalanced ratio at which pressing ends, over that of rest. Grains with little friction creep for long, so pressing does not
/// wait for rest.
const NEARLY: f64 = 10.0;
/// Steps between two checks of equilibrium.
const LOOK: u64 = 64;

/// The stage of growth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Stage {
    Growth,
    /// The walls press, with the friction of growth.
    Pressing,
    /// The walls press, with the friction of the materials.
    Rest,
    Done,
}

/// A specimen while it grows: everything that a restart needs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Growing {
    state: State,
    /// Final radii by id, m; those of the coarse grains come first.
    radii: Vec<f64>,
    /// Number of coarse grains.
    coarse: usize,
    stage: Stage,
    /// Steps done.
    steps: u64,
    /// Steps done when the present stage began.
    from: u64,
}

/// A grown specimen. A checkpoint keeps it, so that a restart need not grow it again.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Grown {
    /// Lower corner of the box, m.
    pub lower: [f64; 3],
    /// Size of the box, m.
    pub size: [f64; 3],
    /// Centre and radius of every grain, m; the coarse grains come first.
    pub grains: Vec<[f64; 4]>,
    /// Number of coarse grains.
    pub coarse: usize,
    /// Steps of the growth.
    pub steps: u64,
}

/// The physics of growth: as `physics`, but with scaled inertia, without gravity and without breakage.
pub fn growing(physics: &Physics) -> Physics {
    Physics {
        stepping: Stepping { inertia_scaling: true, dt: None, ..physics.stepping },
        crush: None,
        gravity: [0.0; 3],
        ..physics.clone()
    }
}

impl Growing {
    /// The first state: small grains at random places in the box of the specimen.
    ///
    /// # Errors
    /// [`Error::Failed`] for a free scene, which has no specimen.
    pub fn start(model: &Model, rig: &MpmTest, growth: &Growth) -> Result<Growing> {
        let Some(specimen) = rig.specimen() else {
            return Err(Error::Failed { step: 0, what: "a free scene has no specimen that can grow".into() });
        };
        let mut rng = ChaCha8Rng::seed_from_u64(model.seeds.packing);
        let mut radii = growth.coarse.map_or(Vec::new(), |c| packing::sizes(c.radii, c.volume, &mut rng));
        let coarse = radii.len();
        radii.extend(packing::sizes(growth.fines.radii, growth.fines.volume, &mut rng));
        let mut grains = Grains::default();
        for (k, r) in radii.iter().enumerate() {
            let at = std::array::from_fn(|a| {
                let room = (specimen.size[a] - 2.0 * r).max(0.0);
                specimen.lower[a] + 0.5 * (specimen.size[a] - room) + room * rng.random::<f64>()
            });
            let material = if k < coarse { growth.coarse.map_or(0, |c| c.material) } else { growth.fines.material };
            grains.add(at, growth::START * r, material, &model.physics.materials);
        }
        let mut state =
            State::new(&growing(&model.physics), grains, (0..6).map(|k| Wall::new(&wall_of(specimen, k))).collect(), false);
        state.friction = growth.friction;
        state.damping = DAMPING;
        state.reference_stress = growth::STRESS * growth.stress;
        state.stability_interval = 1;
        Ok(Growing { state, radii, coarse, stage: Stage::Growth, steps: 0, from: 0 })
    }

    /// Checks a growing specimen from a checkpoint against that with which growth starts.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, model: &Model, rig: &MpmTest, growth: &Growth) -> Checked {
        let made = Growing::start(model, rig, growth).map_err(|e| e.to_string())?;
        ensure(self.radii == made.radii && self.coarse == made.coarse, || "the grains are not those of the scene".into())?;
        self.state.check(&growing(&model.physics), &made.state)?;
        check::lengths("grains that grow", made.radii.len(), [self.state.grains.len(), self.state.grains.next_id as usize])?;
        check::positive("size of the growing specimen", extent(&self.state)[1])?;
        check::counters("steps", &[self.steps])?;
        let last = if self.stage == Stage::Growth { growth.steps.saturating_sub(1) } else { u64::MAX };
        ensure(self.from <= self.steps && self.steps <= last, || {
            format!("a stage of growth goes from {} to {}", self.from, self.steps)
        })
    }

    /// Working memory for steps; `physics` from [`growing`].
    pub fn work(&mut self, physics: &Physics) -> Workspace {
        Workspace::sorted(physics, &mut self.state)
    }

    /// Steps done.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Name of the present stage, for the progress bar.
    pub fn doing(&self) -> &'static str {
        match self.stage {
            Stage::Growth => "grains grow",
            Stage::Pressing => "walls press",
            Stage::Rest | Stage::Done => "at rest",
        }
    }

    /// One step. True when the specimen is at rest under its stress.
    ///
    /// # Errors
    /// [`Error::Stalled`]: the specimen does not come to rest within `growth.max_steps`.
    pub fn advance(&mut self, physics: &Physics, rig: &MpmTest, growth: &Growth, work: &mut Workspace) -> Result<bool> {
        let (stage, state) = (self.stage, &mut self.state);
        if stage == Stage::Growth {
            growth::grow(physics, &self.radii, self.steps, growth.steps, state, work);
        }
        dem::step(physics, state, work, |state, _| {
            if stage != Stage::Growth {
                servo(rig, growth.stress, state);
            }
            Ok::<(), Error>(())
        })?;
        self.steps += 1;
        if self.steps > growth.max_steps {
            return Err(self.restless(growth));
        }
        match stage {
            Stage::Growth if self.steps == growth.steps => {
                growth::still(&mut self.state);
                self.state.stability_interval = LOOK / 8;
                self.enter(Stage::Pressing);
            }
            Stage::Pressing if self.at_rest(physics, rig, growth.stress, work, NEARLY * UNBALANCED) => {
                self.state.friction = None;
                self.enter(Stage::Rest);
            }
            Stage::Rest if self.at_rest(physics, rig, growth.stress, work, UNBALANCED) => self.enter(Stage::Done),
            _ => {}
        }
        Ok(self.stage == Stage::Done)
    }

    fn enter(&mut self, stage: Stage) {
        (self.stage, self.from) = (stage, self.steps);
    }

    /// Whether all walls that move bear `stress`, Pa, and the unbalanced ratio is below `unbalanced`. Checked every [`LOOK`]
    /// steps, not in the first steps of a stage.
    fn at_rest(&self, physics: &Physics, rig: &MpmTest, stress: f64, work: &Workspace, unbalanced: f64) -> bool {
        if self.steps < self.from + 4 * LOOK || !self.steps.is_multiple_of(LOOK) {
            return false;
        }
        let [_, size] = extent(&self.state);
        let close = |k: usize| (side(&self.state, size, k) / stress - 1.0).abs() < STRESS_AT_REST;
        (0..6).filter(|k| moves(rig, *k)).all(close)
            && observables::sums(physics, &self.state, work).unbalanced_ratio(self.state.grains.len()) < unbalanced
    }

    fn restless(&self, growth: &Growth) -> Error {
        let [_, size] = extent(&self.state);
        let sides: Vec<String> = (0..6).map(|k| format!("{:.2}", 1e-3 * side(&self.state, size, k))).collect();
        let what = format!(
            "the growing specimen did not come to rest at {:.2} kPa within growth.max_steps = {}: its sides bear {} kPa",
            1e-3 * growth.stress,
            growth.max_steps,
            sides.join(", ")
        );
        Error::Stalled { step: self.steps, what }
    }

    /// The grown specimen.
    pub fn grown(&self) -> Grown {
        let ([lower, size], g) = (extent(&self.state), &self.state.grains);
        let grains = g.by_id().into_iter().map(|i| g.pos[i as usize]).collect();
        Grown { lower, size, grains, coarse: self.coarse, steps: self.steps }
    }
}

/// Lower corner and size of the space between the walls, m.
fn extent(state: &State) -> [[f64; 3]; 2] {
    let at = |k: usize| match state.walls[k].shape {
        WallShape::Plane { point, .. } => point[k / 2],
        WallShape::Cylinder { radius, .. } => radius,
    };
    [std::array::from_fn(|a| at(2 * a)), std::array::from_fn(|a| at(2 * a + 1) - at(2 * a))]
}

/// Stress on side `k` of a box of extents `size`, Pa.
fn side(state: &State, size: [f64; 3], k: usize) -> f64 {
    state.walls[k].reaction / ::engine::mpm::area(size, k / 2)
}

/// Whether wall `k` moves: in a triaxial test all of them, in an oedometer the top.
fn moves(rig: &MpmTest, k: usize) -> bool {
    matches!(rig.test, Test::Triaxial { .. }) || k == 5
}

fn servo(rig: &MpmTest, stress: f64, state: &mut State) {
    let [_, size] = extent(state);
    let least = size.into_iter().fold(f64::INFINITY, f64::min);
    let now = (0..6).filter(|k| moves(rig, *k)).map(|k| side(state, size, k)).fold(stress, f64::max);
    state.reference_stress = stress;
    let limit = 0.5 * INERTIAL * least / inertial_time(state, now);
    for k in (0..6).filter(|k| moves(rig, *k)) {
        let force = stress * ::engine::mpm::area(size, k / 2);
        let (dt, w) = (state.dt, &mut state.walls[k]);
        w.speed = servo_speed(force, w.reaction, w.stiffness, GAIN, dt, limit);
    }
}

impl Grown {
    /// Checks a grown specimen from a checkpoint.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self) -> Checked {
        check::numbers("lower corner", self.lower)?;
        check::positive("size of the specimen", self.size)?;
        check::numbers("places of grown grains", self.grains.as_flattened())?;
        check::positive("radii of grown grains", self.grains.iter().map(|p| p[3]))?;
        check::below("coarse grains", self.coarse as u64, self.grains.len() + 1)?;
        check::counters("steps", &[self.steps])?;
        let coarse: f64 = self.grains[..self.coarse].iter().map(|p| sphere_volume(p[3])).sum();
        ensure(coarse < self.size.iter().product(), || "the coarse grains do not fit into the specimen".into())
    }

    /// The rig of the test with this specimen: `rig` with the grown points, grains and box.
    pub fn rig(&self, model: &Model, rig: &MpmTest, growth: &Growth) -> MpmTest {
        let (coarse, fine) = self.grains.split_at(self.coarse);
        let solid = |grains: &[[f64; 4]]| grains.iter().map(|p| sphere_volume(p[3])).sum::<f64>();
        let whole = self.size.iter().product::<f64>() - solid(coarse);
        // without fine grains the porosity of the scene is kept: it gives the wave speed, and with it the speed of the test
        let porosity = match rig.specimen() {
            Some(s) if fine.is_empty() => s.porosity,
            _ => 1.0 - solid(fine) / whole,
        };
        let density = model.physics.materials[usize::from(growth.fines.material)].density;
        let mut rig = rig.clone();
        if let Some(s) = rig.test.specimen_mut() {
            *s = MpmSpecimen {
                lower: self.lower,
                size: self.size,
                spacing: (whole / fine.len().max(1) as f64).cbrt(),
                porosity,
                density: (1.0 - porosity) * density,
                lattice: false,
                ..s.clone()
            };
        }
        let law = rig.specimen().map_or(0, |s| s.law);
        rig.points = Points::default();
        if growth.as_points {
            for p in fine {
                let (solid, s) = (sphere_volume(p[3]), -growth.stress);
                rig.points.add(&Point {
                    position: [p[0], p[1], p[2]],
                    velocity: [0.0; 3],
                    mass: density * solid,
                    volume: solid / (1.0 - porosity),
                    stress: [s, s, s, 0.0, 0.0, 0.0],
                    porosity,
                    law,
                });
            }
        }
        let spec = |p: &[f64; 4], material: u8| GrainSpec {
            position: [p[0], p[1], p[2]],
            radius: p[3],
            velocity: [0.0; 3],
            spin: [0.0; 3],
            material,
        };
        let mut grains: Vec<GrainSpec> = coarse.iter().map(|p| spec(p, growth.coarse.map_or(0, |c| c.material))).collect();
        if !growth.as_points {
            grains.extend(fine.iter().map(|p| spec(p, growth.fines.material)));
        }
        rig.coarse = rig.coarse.map(|c| CoarseGrains { grains, ..c });
        rig
    }
}
