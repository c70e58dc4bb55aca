//! The engine's speed: a dense frictional Hertz–Mindlin oedometer at real inertia, the case with
//! which other codes are measured (E 0.8 GPa, ν 0.12, μ 0.35, r 0.95–1.05 mm, porosity 0.40, about
//! 90 kPa, frictionless walls, top platen at 5 mm/s).
//!
//! Clocks are read here, in `verify`, by the runner of a campaign and its progress line, in
//! `laboratory::run` and, if asked to, by the step of the engine.

mod burst;
mod features;
mod machine;
mod mixture;
mod mpm;
#[cfg(feature = "gpu")]
mod mpm_gpu;
mod packing;
mod speed;
mod yardstick;

pub use burst::{Burst, burst};
pub use features::{FeatureCost, feature_costs};
pub use machine::{Demand, Machine};
#[cfg(feature = "gpu")]
pub use mixture::{MixtureGpuSpeed, mixture_gpu_speed};
pub use mixture::{MixtureSpeed, mixture_speed};
pub use mpm::{MpmSpeed, mpm_case, mpm_speed};
#[cfg(feature = "gpu")]
pub use mpm_gpu::{GpuSpeed, mpm_gpu_speed};
pub use packing::{Packing, packing};
pub use speed::{Plan, Speed, load_average, measure, pool};
pub use yardstick::yardstick;

use engine::boundary::Wall;
use engine::breakage::Criterion;
use engine::breakage::criterion::FixedAngle;
use engine::breakage::lost_mass::Fines;
use engine::breakage::pattern::{Azimuth, Pattern};
use engine::breakage::strength::{Distribution, StrengthModel, Truncation};
use engine::breakage::{Birth, CrushModel};
use engine::contact::{ContactLaw, ContactModel, TangentialUnloading};
use engine::dem::physics::Physics;
use engine::dem::physics::Stepping;
use engine::dem::{State, Workspace};
use engine::material::Material;
use laboratory::error::{Error, Result};
use laboratory::gradation::mean_cubed_diameter;
use laboratory::model::{Compression, Loading, Model, Preparation, Records, Rig, Seeds, Specimen, WallFriction};
use laboratory::rig::cylinder::{TOP, walls};
use std::f64::consts::PI;

/// Time step of the uniform packing, s: 15 % of the Rayleigh step.
const TIME_STEP: f64 = 1.4e-6;
/// Speed of the top platen, m/s.
pub const PLATEN_SPEED: f64 = 5e-3;
/// Porosity of the packing.
pub const POROSITY: f64 = 0.40;
/// Isotropic stress of the packing, Pa.
pub const STRESS: f64 = 90e3;
/// Restitution with viscous contact laws.
pub const RESTITUTION: f64 = 0.3;
/// Neighbour skin over radius: surfaces up to a tenth of a radius apart are listed, as in the other codes.
pub const SKIN: f64 = 0.05;
/// Radii, m, uniform by number.
const RADII: (f64, f64) = (0.95e-3, 1.05e-3);
/// Height over diameter of the packing.
const SLENDERNESS: f64 = 1.15;
/// Points of the gradation, mass finer against diameter.
const GRADATION_POINTS: usize = 21;

/// Grains of the packing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Case {
    /// Of about one size.
    Uniform,
    /// A tenth of the mass in grains thirty times smaller.
    Wide,
}

impl Case {
    /// In the wide case: size of the small grains over that of the large ones, and the share of the
    /// mass in small grains.
    const FINES: (f64, f64) = (1.0 / 30.0, 0.1);

    /// Name in options and tables.
    pub fn name(self) -> &'static str {
        match self {
            Case::Uniform => "uniform",
            Case::Wide => "wide",
        }
    }

    /// Fewest grains that make a specimen; in the wide case some thirty of them are large.
    pub fn least(self) -> usize {
        match self {
            Case::Uniform => 500,
            Case::Wide => 100_000,
        }
    }

    /// Stem of the packing's file.
    fn stem(self) -> &'static str {
        match self {
            Case::Uniform => "oedometer",
            Case::Wide => "wide",
        }
    }

    /// Smallest and largest radius, m.
    fn radii(self) -> (f64, f64) {
        let (low, high) = RADII;
        match self {
            Case::Uniform => (low, high),
            Case::Wide => (Self::FINES.0 * low, high),
        }
    }

    /// Points of the gradation: diameter, m, and share of mass finer.
    fn gradation(self) -> Vec<(f64, f64)> {
        let (low, high) = RADII;
        match self {
            Case::Uniform => (0..GRADATION_POINTS)
                .map(|k| {
                    let r = low + (high - low) * k as f64 / (GRADATION_POINTS - 1) as f64;
                    (2.0 * r, (r.powi(4) - low.powi(4)) / (high.powi(4) - low.powi(4)))
                })
                .collect(),
            Case::Wide => {
                let (small, share) = Self::FINES;
                vec![(2.0 * small * low, 0.0), (2.0 * small * high, share), (2.0 * low, share), (2.0 * high, 1.0)]
            }
        }
    }

    /// Whether a grain of radius `r`, m, is a large one (in the wide case, not one of the fines).
    fn is_large(self, r: f64) -> bool {
        r > 0.5 * RADII.0
    }

    /// Time step, s, in proportion to the smallest radius.
    pub fn time_step(self) -> f64 {
        TIME_STEP * self.radii().0 / RADII.0
    }

    /// Porosity of the packing; in the wide case the fines are placed in the pores between the
    /// large grains.
    fn porosity(self) -> f64 {
        match self {
            Case::Uniform => POROSITY,
            Case::Wide => 1.0 - (1.0 - POROSITY) / (1.0 - Self::FINES.1),
        }
    }
}

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // `pad` keeps the width that a table asks for
        f.pad(self.name())
    }
}

/// The model of the case with `grains` grains, for steps at real inertia.
pub fn model(case: Case, grains: usize, law: ContactLaw, skin: f64) -> Model {
    let material = Material {
        name: "bench".into(),
        density: 2600.0,
        internal_porosity: 0.0,
        young: 0.8e9,
        poisson: 0.12,
        friction: 0.35,
        rolling_friction: 0.0,
        interface_friction: None,
        contact: if law.is_hertzian() { [RESTITUTION, 0.0, 0.0, 0.0] } else { [0.8e9, 0.25, 0.0, 0.0] },
    };
    Model {
        name: format!("bench-{}-{grains}", case.name()),
        seeds: Seeds { packing: 1, strength: 1 },
        physics: Physics {
            materials: vec![material],
            contact: ContactModel { law, unloading: TangentialUnloading::Keep, rolling: false, turning: true },
            crush: None,
            damping: 0.0,
            gravity: [0.0; 3],
            stepping: Stepping { safety: 0.8, inertia_scaling: false, dt: Some(case.time_step()), slow: false, skin },
        },
        fines: Fines { alpha: 2.6, d_min: 1e-5 },
        scale: 1.0,
        rig: Rig::Oedometer(rig(case, grains)),
        records: Records {
            per_decade: 1,
            at: Vec::new(),
            least_void_ratio: 0.0,
            end_below_least: false,
            stop_without_voids: false,
            stop_at_overlap: 2.0,
            account: false,
            stop_at_step: 0.0,
            energy: false,
            snapshots: false,
            contacts: false,
            figures: false,
            report: false,
            checkpoint_seconds: f64::INFINITY,
        },
        accuracy: None,
    }
}

/// The same model with grains that may break, but are so strong that none breaks by itself.
///
/// # Errors
/// None: the pattern exists.
pub fn breakable(model: &Model) -> Result<Model> {
    let pattern = Pattern::new(14).map_err(|what| Error::Failed { step: 0, what })?;
    let strength = StrengthModel {
        sigma_lim0: 1e15,
        d0: 2e-3,
        m: 10.0,
        distribution: Distribution::Normal,
        var: 0.0,
        truncation: Truncation::Redraw,
        min_ratio: 0.0,
    };
    let crush = CrushModel {
        criterion: Criterion::FixedAngle(FixedAngle { theta0: PI / 9.0 }),
        strength,
        seed: model.seeds.strength,
        cells: Vec::new(),
        pattern,
        azimuth: Azimuth::Random,
        d_limit: 1e-3,
        birth: Birth::Overlapping,
        keeps_mass: false,
        interval: 1,
    };
    Ok(Model { physics: Physics { crush: Some(crush), ..model.physics.clone() }, ..model.clone() })
}

/// Model of the large grains of a wide packing alone: they are so few that the walls keep their
/// packing looser.
fn skeleton(grains: usize) -> Model {
    let mut model = model(Case::Uniform, grains, ContactLaw::Hertz, SKIN);
    if let Rig::Oedometer(rig) = &mut model.rig {
        rig.specimen.porosity = 0.48;
        rig.specimen.preparation.porosity_tolerance = 0.1;
    }
    model
}

fn rig(case: Case, grains: usize) -> Compression {
    let gradation = case.gradation();
    let solid = grains as f64 * PI / 6.0 * mean_cubed_diameter(&gradation);
    let diameter = (solid / ((1.0 - case.porosity()) * 0.25 * PI * SLENDERNESS)).cbrt();
    let specimen = Specimen {
        diameter,
        grains,
        porosity: case.porosity(),
        relative_density: None,
        range: None,
        gradation,
        wall_friction: WallFriction { bottom: 0.0, top: 0.0, cylinder: 0.0 },
        isotropic_stress: STRESS,
        preparation: Preparation {
            growth_friction: Some(0.13),
            growth_steps: 1500,
            damping: 0.7,
            porosity_tolerance: 0.02,
            max_steps: 100_000,
        },
        servo_gain: 0.2,
        settle_steps: 0,
    };
    Compression {
        all_sides: false,
        specimen,
        loading: Loading {
            stages: vec![2.0 * STRESS],
            rate: 0.01,
            sigma_ref: 1e3,
            load_increment: None,
            max_inertial_number: 1e-3,
            max_lag: 0.02,
            max_wait: u64::MAX,
            strain_controlled: None,
            row_strain: None,
            row_events: None,
        },
        fines: None,
    }
}

/// State from which steps are measured: the packing at rest, walls of the grains' own material
/// without friction (as the other codes have them), a moving top wall, and grains sorted in memory
/// by their place. `energy`: whether contacts keep account of their work.
pub fn start(model: &Model, packing: &Packing, energy: bool) -> (State, Workspace) {
    let size = packing.walls;
    let mut around: Vec<Wall> = walls(&rig(packing.case, packing.grains.len()).specimen, size.radius, size.bottom, size.height);
    for wall in &mut around {
        wall.material = Some(0);
    }
    around[TOP].speed = PLATEN_SPEED;
    let mut state = State::new(&model.physics, packing.grains.clone(), around, energy);
    let work = Workspace::sorted(&model.physics, &mut state);
    (state, work)
}
