//! The model of a run: everything that the run needs to know and never changes. Only [`crate::scene::model`] makes a [`Model`],
//! from a [`crate::scene::Scene`]; it refuses values that are not finite or do not agree, so a run need not check them again.

pub mod continuum;
pub mod inertial;
pub mod validity;

use crate::error::{Error, Result};
use crate::rig::preparation::range::Range;
use crate::scene::Level;
use engine::boundary::WallSpec;
use engine::breakage::lost_mass::Fines;
use engine::coupling::Embedding;
use engine::dem::physics::Physics;
use serde::{Deserialize, Serialize};

/// Everything immutable about one run. Lengths m, masses kg, stresses Pa, angles rad. Equation numbers are those of Ciantia et
/// al. (2015).
#[derive(Clone, Debug)]
pub struct Model {
    /// Name of the scene, used for the run folder and legends.
    pub name: String,
    /// Seeds of the random numbers.
    pub seeds: Seeds,
    /// What a time step needs: materials, laws, gravity, damping, stepping.
    pub physics: Physics,
    /// How the mass that breakages lose is spread over sizes in the reconstructed gradation (eq. 12).
    pub fines: Fines,
    /// Scale N (eqs 13 to 15): grain diameters of the run are N times those of the sand; gradations are divided by N before they
    /// are reported.
    pub scale: f64,
    /// The laboratory test, with the specimen it starts from.
    pub rig: Rig,
    /// What is recorded, and when.
    pub records: Records,
    /// The level of accuracy that the scene asks for.
    pub accuracy: Option<&'static Level>,
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

/// Seeds of the two independent streams of random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Seeds {
    /// Seed of the specimen: sizes and first places of the grains.
    pub packing: u64,
    /// Seed of the grains' strengths.
    pub strength: u64,
}

/// The laboratory test that a scene describes.
#[derive(Clone, Debug)]
pub enum Rig {
    /// One-dimensional compression of a cylinder of grains.
    Oedometer(Compression),
    /// Drained triaxial compression of a cylinder of grains.
    Triaxial(Triaxial),
    /// Isotropic compression of a cylinder of grains.
    Isotropic(Compression),
    /// A free scene: listed grains and walls.
    Assembly(Assembly),
    /// Single grains crushed between two platens.
    GrainCrushing(GrainCrushing),
    /// A continuum of material points, with grains in it or without. Boxed, for it holds its points.
    Continuum(Box<continuum::MpmTest>),
}

/// Single grains, each crushed by itself between two platens.
#[derive(Clone, Debug)]
pub struct GrainCrushing {
    /// Diameter of each grain, m, in the order of their numbers.
    pub diameters: Vec<f64>,
    /// True: the diameters were drawn from a gradation. False: the scene lists them.
    pub graded: bool,
    /// Material of the grains, by its index in [`Physics::materials`].
    pub grain: u8,
    /// Material of the platens; `None`: rigid, a grain then meets its mirror image.
    pub platen: Option<u8>,
    /// Displacement of the upper platen in one step over its displacement so far, -.
    pub step: f64,
    /// Displacement over the grain's diameter at which a test ends unbroken, -.
    pub max_displacement: f64,
    /// Force at which a test ends unbroken, N; `None`: no limit.
    pub max_force: Option<f64>,
    /// Numbers of the grains whose force-displacement curves are written.
    pub curves: Vec<u32>,
}

impl Rig {
    /// The test as a compression by stages of stress; `None` for other tests.
    pub fn compression(&self) -> Option<&Compression> {
        match self {
            Rig::Oedometer(rig) | Rig::Isotropic(rig) => Some(rig),
            Rig::Triaxial(_) | Rig::Assembly(_) | Rig::GrainCrushing(_) | Rig::Continuum(_) => None,
        }
    }
}

/// What a rig works on.
#[derive(Clone, Copy, Debug)]
pub enum Subject<'a> {
    /// A specimen of grains under one of the tests of [`crate::testing`].
    Specimen(&'a Specimen),
    /// A free scene.
    Assembly(&'a Assembly),
    /// Single grains between platens.
    GrainCrushing(&'a GrainCrushing),
    /// A continuum, with grains in it or without.
    Continuum(&'a continuum::MpmTest),
}

/// Compression of a specimen by stages of stress: one-dimensional in a ring of fixed radius, or from all sides.
#[derive(Clone, Debug)]
pub struct Compression {
    /// The specimen.
    pub specimen: Specimen,
    /// The load programme.
    pub loading: Loading,
    /// True: the cylinder bears the stress of the platens too (isotropic compression). False: its radius is fixed (oedometer).
    pub all_sides: bool,
    /// How the mass that breakages lose becomes material points between the grains; `None`: lost mass takes no part in the test.
    pub fines: Option<Box<Embedding>>,
}

/// Drained shear of a specimen at constant cell pressure, which is the specimen's isotropic stress.
#[derive(Clone, Debug)]
pub struct Triaxial {
    /// The specimen.
    pub specimen: Specimen,
    /// The shear programme.
    pub shear: Shear,
}

/// A cylinder of grains and how it is made.
#[derive(Clone, Debug)]
pub struct Specimen {
    /// Diameter at the start, m.
    pub diameter: f64,
    /// Number of grains.
    pub grains: usize,
    /// Target porosity at the isotropic stress. Where the scene states a relative density, this is an estimate until
    /// [`crate::rig::preparation::range::settle`] has turned the relative density into a porosity.
    pub porosity: f64,
    /// Target as a relative density, 0 (the loosest specimen that can be made) to 1 (the densest); `None`: the porosity is the
    /// target.
    pub relative_density: Option<f64>,
    /// Porosities of the loosest and the densest specimen that can be made, where they have been measured.
    pub range: Option<Range>,
    /// Initial gradation, diameters in m already multiplied by N: points (diameter, mass fraction finer), increasing, 0 to 1;
    /// mass is uniform in diameter between two points.
    pub gradation: Vec<(f64, f64)>,
    /// Friction coefficients of the walls.
    pub wall_friction: WallFriction,
    /// Isotropic stress of the prepared specimen, Pa, compression positive.
    pub isotropic_stress: f64,
    /// How the specimen is made.
    pub preparation: Preparation,
    /// Servo gain of platens and cylinder: fraction of the imbalance removed per step by the wall's own contacts.
    pub servo_gain: f64,
    /// Steps of rest at the isotropic stress before loading.
    pub settle_steps: u64,
}

/// Friction coefficients, -, between grains and the walls of a cylindrical specimen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallFriction {
    /// Of the bottom platen.
    pub bottom: f64,
    /// Of the top platen.
    pub top: f64,
    /// Of the cylinder.
    pub cylinder: f64,
}

/// How a cylindrical specimen is made ([`crate::rig::preparation`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preparation {
    /// Friction coefficient between grains while their radii grow; `None`: the preparation finds the friction with which the
    /// specimen reaches its target.
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

/// The load programme of a compression. Stresses are vertical (in isotropic compression on all sides), compression positive.
#[derive(Clone, Debug)]
pub struct Loading {
    /// Target stress of each stage in order, Pa. The first stage starts from the isotropic stress; a stage with a lower target than
    /// the one before unloads, one with a higher target reloads.
    pub stages: Vec<f64>,
    /// L_C of eq. (18), -: the target rises in one step by L_C (sigma_ref + sigma_ref ln(target/sigma_ref)).
    pub rate: f64,
    /// sigma_ref of eq. (18), Pa.
    pub sigma_ref: f64,
    /// Rise of the target in one step over the target, while the platens are in balance (adaptive programme); `None`: eq. (18).
    pub load_increment: Option<f64>,
    /// Largest inertial number that the platen's motion may give the specimen, -.
    pub max_inertial_number: f64,
    /// The programme waits while a platen's stress differs from the target by more than this share of the target
    /// ([`crate::rig::cylinder::Stresses::target_error`]).
    pub max_lag: f64,
    /// Largest number of steps for which the programme may wait before the run stops itself.
    pub max_wait: u64,
    /// Inertial number at which the platen moves in first loading, which is then strain controlled: the stress is a result. `None`:
    /// first loading is stress controlled. Unloading, and reloading up to the largest stress so far, are always stress controlled.
    pub strain_controlled: Option<f64>,
    /// Axial strain after which a row of the history is due, besides the rows at given stresses.
    pub row_strain: Option<f64>,
    /// Number of breakages after which a row of the history is due, besides the rows at given stresses.
    pub row_events: Option<u64>,
}

impl Loading {
    /// Largest target stress of the stages before stage `k`, Pa; 0 for the first stage.
    pub fn before(&self, k: usize) -> f64 {
        self.stages[..k].iter().copied().fold(0.0, f64::max)
    }
}

/// The shear programme of a triaxial test.
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

/// A free scene: grains and walls as listed, without a laboratory test. It ends after `steps` or `duration`; one of them is given.
#[derive(Clone, Debug)]
pub struct Assembly {
    /// The grains at the start.
    pub grains: Vec<GrainSpec>,
    /// The walls.
    pub walls: Vec<WallSpec>,
    /// Number of steps.
    pub steps: Option<u64>,
    /// Time, s.
    pub duration: Option<f64>,
    /// Grains whose tracks are written, by their index in `grains`.
    pub tracks: Vec<u32>,
    /// Whether a fixed time step may be above the largest stable one.
    pub above_bound: bool,
    /// Record every this many steps.
    pub record_every: u64,
}

/// A grain at the start of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrainSpec {
    /// Centre, m.
    pub position: [f64; 3],
    /// Radius, m.
    pub radius: f64,
    /// Velocity, m/s.
    pub velocity: [f64; 3],
    /// Angular velocity, rad/s.
    pub spin: [f64; 3],
    /// Material, by its index in [`Physics::materials`].
    pub material: u8,
}

/// What a run records, and which records end the run.
#[derive(Clone, Debug)]
pub struct Records {
    /// Rows of the history per decade of vertical stress.
    pub per_decade: u32,
    /// Vertical stresses, Pa, at which a gradation and a snapshot are recorded besides the first and the last.
    pub at: Vec<f64>,
    /// Void ratio of all dry mass below which real fines could not pack, -: the run warns when it falls below.
    pub least_void_ratio: f64,
    /// Whether the run ends where the void ratio falls below `least_void_ratio`.
    pub end_below_least: bool,
    /// Whether the run ends where the solids would fill more than the whole volume.
    pub stop_without_voids: bool,
    /// Overlap of two grains over the radius of the smaller, -, at which the run ends.
    pub stop_at_overlap: f64,
    /// Time step over the stable one at the start, -, below which the run ends.
    pub stop_at_step: f64,
    /// Whether the energy ledger is kept.
    pub energy: bool,
    /// Whether the energy account of a continuum or mixture is kept.
    pub account: bool,
    /// Whether ParaView snapshots are written with every gradation.
    pub snapshots: bool,
    /// Whether the contacts of grains are written with every gradation.
    pub contacts: bool,
    /// Whether figures are drawn at the end.
    pub figures: bool,
    /// Whether a page that shows the run is written at the end.
    pub report: bool,
    /// Seconds of wall-clock time between checkpoints.
    pub checkpoint_seconds: f64,
}
