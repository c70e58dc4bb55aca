//! What a run needs to know and never changes: a [`Model`] is made from a [`crate::scene::Scene`] by
//! [`crate::scene::model`], the only gate, and is in SI units, finite and consistent by construction.

pub mod continuum;
pub mod validity;

use crate::error::{Error, Result};
use crate::rig::preparation::range::Range;
use engine::boundary::WallSpec;
use engine::breakage::lost_mass::Fines;
use engine::coupling::Embedding;
use engine::dem::physics::Physics;
use serde::{Deserialize, Serialize};

/// Everything immutable about one run. Lengths m, masses kg, stresses Pa, angles rad.
#[derive(Clone, Debug)]
pub struct Model {
    /// Name of the scene, used for the run folder and legends.
    pub name: String,
    pub seeds: Seeds,
    /// What the time step needs.
    pub physics: Physics,
    /// How lost mass is distributed over sizes in the reconstructed gradation (eq. 12).
    pub fines: Fines,
    /// Scale N (eqs 13-15): gradations are divided by it before they are reported.
    pub scale: f64,
    pub rig: Rig,
    /// Records and outputs.
    pub records: Records,
}

impl Model {
    /// Checks that no body of a mixture is other than a sphere: only the CPU computes those.
    ///
    /// # Errors
    /// A scene with `[[block]]`.
    pub fn spheres_only(&self) -> Result<()> {
        match &self.rig {
            Rig::Continuum(rig) if rig.coarse.as_ref().is_some_and(|c| !c.blocks.is_empty()) => {
                Err(Error::input("gpu", "", None, "does not compute rigid bodies that are no spheres ([[block]])"))
            }
            _ => Ok(()),
        }
    }
}

/// Seeds of the two independent random streams.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Seeds {
    pub packing: u64,
    pub strength: u64,
}

/// The laboratory.
#[derive(Clone, Debug)]
pub enum Rig {
    Oedometer(Compression),
    Triaxial(Triaxial),
    Isotropic(Compression),
    Assembly(Assembly),
    Platen(Platen),
    /// Boxed: it holds its points.
    Continuum(Box<continuum::Continuum>),
}

/// Single grains, each pressed by itself between two platens.
#[derive(Clone, Debug)]
pub struct Platen {
    /// Diameter of each grain, m, in the order of their numbers.
    pub diameters: Vec<f64>,
    /// Whether the diameters were given, or drawn from a gradation.
    pub graded: bool,
    /// Material of the grains.
    pub grain: u8,
    /// Material of the platens; `None`: rigid (NOTES.md).
    pub platen: Option<u8>,
    /// Displacement of the platen in one step over its displacement so far.
    pub step: f64,
    /// Displacement over the grain's diameter, and force, N, at which a test stops unbroken.
    pub max_displacement: f64,
    pub max_force: Option<f64>,
    /// Grains whose force-displacement curves are written, by number.
    pub curves: Vec<u32>,
}

impl Rig {
    /// Compression of a specimen by stages of stress, if it is that.
    pub fn compression(&self) -> Option<&Compression> {
        match self {
            Rig::Oedometer(rig) | Rig::Isotropic(rig) => Some(rig),
            Rig::Triaxial(_) | Rig::Assembly(_) | Rig::Platen(_) | Rig::Continuum(_) => None,
        }
    }

    /// As [`Rig::specimen`], to be changed.
    pub fn specimen_mut(&mut self) -> Option<&mut Specimen> {
        match self {
            Rig::Oedometer(rig) | Rig::Isotropic(rig) => Some(&mut rig.specimen),
            Rig::Triaxial(rig) => Some(&mut rig.specimen),
            Rig::Assembly(_) | Rig::Platen(_) | Rig::Continuum(_) => None,
        }
    }
}

/// Compression of a specimen by stages of stress: one-dimensional in a ring of fixed radius, or from all sides.
#[derive(Clone, Debug)]
pub struct Compression {
    /// The specimen.
    pub specimen: Specimen,
    /// The stages and how they are gone through.
    pub loading: Loading,
    /// Whether the shell bears the stress of the platens, too (isotropic compression), or is fixed (oedometer).
    pub all_sides: bool,
    /// Where the mass that breakages lose becomes material points.
    pub fines: Option<Box<Embedding>>,
}

/// Drained shear of a specimen at constant cell pressure, which is the specimen's isotropic stress.
#[derive(Clone, Debug)]
pub struct Triaxial {
    pub specimen: Specimen,
    pub shear: Shear,
}

/// A cylinder of grains and how it is made.
#[derive(Clone, Debug)]
pub struct Specimen {
    /// Diameter at the start, m.
    pub diameter: f64,
    pub grains: usize,
    /// Target porosity at the isotropic stress; with a relative density an estimate until the range is known ([`crate::rig::preparation::range::settle`]).
    pub porosity: f64,
    /// Target between the loosest and the densest specimen that the program makes, 0 to 1, instead of a porosity.
    pub relative_density: Option<f64>,
    /// The porosities between which the target lies, where they have been measured for the run.
    pub range: Option<Range>,
    /// Initial gradation, diameters in m already multiplied by N: points (diameter, mass fraction finer), increasing, 0 to 1;
    /// mass is uniform in diameter between two points.
    pub gradation: Vec<(f64, f64)>,
    /// Wall friction coefficients: platens (bottom, top) and cylinder.
    pub wall_friction: WallFriction,
    /// Isotropic stress of the prepared specimen, Pa (5 kPa).
    pub isotropic_stress: f64,
    pub preparation: Preparation,
    /// Servo gain of platens and cylinder: fraction of the imbalance removed per step by the wall's own contacts.
    pub servo_gain: f64,
    /// Steps of rest at the isotropic stress before loading.
    pub settle_steps: u64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallFriction {
    pub bottom: f64,
    pub top: f64,
    pub cylinder: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preparation {
    /// Friction coefficient between grains during radius expansion; `None`: as the target needs it.
    pub growth_friction: Option<f64>,
    /// Steps of radius expansion.
    pub growth_steps: u64,
    /// Local damping during preparation.
    pub damping: f64,
    /// Relative tolerance on the target porosity.
    pub porosity_tolerance: f64,
    /// Give up after this many steps.
    pub max_steps: u64,
}

#[derive(Clone, Debug)]
pub struct Loading {
    /// Stages in order: (target vertical stress, Pa). The first rises from the isotropic stress; a lower value unloads, a higher reloads.
    pub stages: Vec<f64>,
    /// L_C of eq. (18), natural logarithm, sigma_ref 1 kPa.
    pub rate: f64,
    pub sigma_ref: f64,
    /// Rise of the target in one step over the target while the platens are in balance (adaptive programme); `None`: eq. (18).
    pub pace: Option<f64>,
    /// Largest inertial number the platen may impose.
    pub max_inertial_number: f64,
    /// The programme waits while a platen's stress differs from the target by more than this share (`Stresses::lag`).
    pub max_lag: f64,
    /// First loading at this inertial number of the platen, the stress is what comes out; `None`: by stress. What lies below the largest stress so far is
    /// unloaded and reloaded by stress in both.
    pub strain_controlled: Option<f64>,
    /// A row of the history after so much axial strain, and so many breakages, besides those by stress.
    pub row_strain: Option<f64>,
    pub row_events: Option<u64>,
}

impl Loading {
    /// Largest stress asked for before stage `k`, Pa; 0 before the first.
    pub fn before(&self, k: usize) -> f64 {
        self.stages[..k].iter().copied().fold(0.0, f64::max)
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Shear {
    /// Axial strain at the end, compression positive.
    pub axial_strain: f64,
    /// Inertial number at which the top platen moves.
    pub inertial_number: f64,
    /// Axial strain between two rows of the history.
    pub record_every: f64,
    /// Axial strains at which a gradation and a snapshot are recorded besides the first and the last.
    pub record_at: Vec<f64>,
}

/// A free scene.
#[derive(Clone, Debug)]
pub struct Assembly {
    pub grains: Vec<GrainSpec>,
    pub walls: Vec<WallSpec>,
    pub steps: Option<u64>,
    pub duration: Option<f64>,
    /// Grains whose tracks are written, by position in `grains`.
    pub tracks: Vec<u32>,
    /// Record every this many steps.
    pub record_every: u64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrainSpec {
    pub position: [f64; 3],
    pub radius: f64,
    pub velocity: [f64; 3],
    pub spin: [f64; 3],
    pub material: u8,
}

#[derive(Clone, Debug)]
pub struct Records {
    /// Records per decade of vertical stress.
    pub per_decade: u32,
    /// Vertical stresses, Pa, at which a gradation and a snapshot are recorded besides the first and the last.
    pub at: Vec<f64>,
    /// Void ratio of all dry mass below which fines cannot pack: the run says so there.
    pub least_void_ratio: f64,
    /// Whether the run ends there.
    pub end_below_least: bool,
    /// Whether the run stops where solids would fill more than the whole volume.
    pub stop_without_voids: bool,
    /// Overlap of two grains over the radius of the smaller at which the run stops.
    pub stop_at_overlap: f64,
    /// Whether the energy ledger is kept.
    pub energy: bool,
    /// Whether ParaView snapshots are written at `at`.
    pub snapshots: bool,
    /// Whether the contacts of grains are written at the same instants.
    pub contacts: bool,
    /// Whether figures are drawn at the end.
    pub figures: bool,
    /// Seconds of wall-clock time between checkpoints.
    pub checkpoint_seconds: f64,
}
