//! The model of a continuum of material points, with grains in it or without, and of the test that is made with it.

use super::{GrainSpec, WallSpec};
use engine::coupling::{Rates, Rule};
use engine::mpm::law::Law;
use engine::mpm::{Points, Settings};
use engine::point_contacts::ActsOn;
use engine::rigid::{Block, Joint, Programme};
use std::f64::consts::{FRAC_PI_3, FRAC_PI_4};

/// A continuum of material points on a background grid, the grains in it, and the test.
#[derive(Clone, Debug)]
pub struct MpmTest {
    /// Grid, shape functions, transfer, gravity and damping of the material point method.
    pub settings: Settings,
    /// Constitutive law of each material of the points, in the order of their numbers.
    pub laws: Vec<Law>,
    /// The points at the start.
    pub points: Points,
    /// Points, and grains at random places, that the scene asks for and that were not made: 0, but for the outline of a model
    /// ([`crate::scene::outline`]).
    pub left_out: [usize; 2],
    /// Points along the edge of a cell at the start.
    pub per_edge: u32,
    /// Origin of the run-out distance, m: the axis of the first body (of a box its lower corner).
    pub axis: [f64; 3],
    /// The test.
    pub test: Test,
    /// The grains among the points; `None`: there are none.
    pub coarse: Option<CoarseGrains>,
    /// How the specimen is grown before the test. The grown points and grains then replace `points` and `coarse`, which only
    /// serve to size the grid and to estimate the run. `None`: the test starts from `points` and `coarse`.
    pub growth: Option<Growth>,
    /// Inertia of the points over that of their mass, 1 or more; 1 in a free scene. In a quasi-static test stresses hardly depend on inertia, and heavier points
    /// allow longer steps. [`Self::points`] have their real mass.
    pub points_inertia: f64,
    /// Whether a fixed time step may be above the largest stable one.
    pub above_bound: bool,
    /// Rows of the history over the test, besides the first.
    pub rows: u32,
    /// Snapshots over the test, besides the first.
    pub frames: u32,
    /// The plane behind which the mass is recorded, if there is one.
    pub gate: Option<Gate>,
}

/// A plane through which material passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gate {
    /// A point of it, m.
    pub at: [f64; 3],
    /// Vector of any length across it; what has passed is beyond the plane to this side.
    pub direction: [f64; 3],
}

impl Gate {
    /// Whether a position is beyond the plane.
    pub fn has_passed(&self, position: [f64; 3]) -> bool {
        (0..3).map(|a| self.direction[a] * (position[a] - self.at[a])).sum::<f64>() > 0.0
    }
}

/// The grains of a mixture, and how they touch its points.
#[derive(Clone, Debug)]
pub struct CoarseGrains {
    /// The spheres at the start.
    pub grains: Vec<GrainSpec>,
    /// The rigid bodies that are no spheres, at the start.
    pub blocks: Vec<Block>,
    /// Volume of those that have a mass, m³ (m² in plane strain); breakages keep it as they keep the mass.
    pub block_volume: f64,
    /// What is done to each of these bodies from outside.
    pub programmes: Vec<Programme>,
    /// The joints between them.
    pub joints: Vec<Joint>,
    /// The walls of a free scene; grains and points touch them.
    pub walls: Vec<WallSpec>,
    /// For each law of the continuum, in its order: the material whose contact parameters its points have.
    pub point_materials: Vec<u8>,
    /// Steps of grains and continuum in one cycle, where the scene prescribes them; `None`: they follow from the stable steps.
    pub rates: Option<Rates>,
    /// How the mass that breakages lose becomes points; `None`: it does not.
    pub fines: Option<Rule>,
    /// Where the forces of contacts with points act.
    pub acts_on: ActsOn,
    /// Radius with which points touch rigid bodies that are no spheres, m; `None`: that of their ghosts.
    pub point_radius: Option<f64>,
}

/// A specimen grown by volume expansion (Li et al. 2023, section 4.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// The fine grains.
    pub fines: Fraction,
    /// The coarse grains, where there are some.
    pub coarse: Option<Fraction>,
    /// True: material points replace the fine grains before the test. False: the fine grains stay grains.
    pub as_points: bool,
    /// Friction coefficient between grains until the walls bear the stress; `None`: that of the materials.
    pub friction: Option<f64>,
    /// Isotropic stress at the end of growth, Pa, compression positive (in an oedometer the stress of the top platen).
    pub stress: f64,
    /// Steps in which the radii grow.
    pub steps: u64,
    /// Steps of the whole preparation after which it is given up.
    pub max_steps: u64,
}

/// Grains of one material whose radii are spread uniformly between two bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fraction {
    /// Material, by its index in the physics' materials.
    pub material: u8,
    /// Smallest and largest radius, m.
    pub radii: [f64; 2],
    /// Volume of all grains together, m³.
    pub volume: f64,
}

impl Fraction {
    /// Expected number of grains: the volume over the mean volume π/3 (a + b)(a² + b²) of a sphere with a radius uniform between
    /// a and b.
    pub fn count(&self) -> usize {
        let [a, b] = self.radii;
        (self.volume / (FRAC_PI_3 * (a + b) * (a * a + b * b))).round() as usize
    }

    /// Mean diameter, m.
    pub fn mean_diameter(&self) -> f64 {
        self.radii[0] + self.radii[1]
    }
}

impl Growth {
    /// Expected numbers of points and of grains at the start of the test.
    pub fn counts(&self) -> [usize; 2] {
        let (fine, coarse) = (self.fines.count(), self.coarse.map_or(0, |c| c.count()));
        if self.as_points { [fine, coarse] } else { [0, fine + coarse] }
    }
}

/// The test that is made with a continuum.
#[derive(Clone, Debug)]
pub enum Test {
    /// No test: points move under gravity and the walls of the grid, for a time or a number of steps; one of them is given.
    Free {
        /// Time, s.
        duration: Option<f64>,
        /// Steps of the continuum.
        steps: Option<u64>,
    },
    /// One-dimensional compression: sides and bottom are smooth and fixed, the top platen moves.
    Oedometer(MpmSpecimen),
    /// Triaxial compression between platens: the axial ones come together.
    Triaxial {
        /// The specimen.
        specimen: MpmSpecimen,
        /// Cell pressure, Pa, compression positive.
        cell_pressure: f64,
        /// What the lateral platens do.
        drainage: Drainage,
    },
}

/// What the lateral platens of a triaxial test do while the axial ones come together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drainage {
    /// They hold the cell pressure.
    Drained,
    /// They move so that the volume stays constant, as in a saturated specimen that cannot drain.
    ConstantVolume,
}

/// The specimen of a continuum's test: a box of points between plane platens, or an upright cylinder of points in a shell.
#[derive(Clone, Debug, PartialEq)]
pub struct MpmSpecimen {
    /// Lower corner at the start, m; of a cylinder that of the box around it.
    pub lower: [f64; 3],
    /// Size at the start, m; of a cylinder that of the box around it.
    pub size: [f64; 3],
    /// True: an upright cylinder. False: a box.
    pub round: bool,
    /// Isotropic stress of the points at the start, Pa, compression positive.
    pub stress: f64,
    /// Distance of neighbouring points at the start, m.
    pub spacing: f64,
    /// Porosity of the points at the start.
    pub porosity: f64,
    /// Constitutive law of the points, by its index in [`MpmTest::laws`].
    pub law: u8,
    /// Bulk density of the points at the start, kg/m³.
    pub density: f64,
    /// True: the points stand on a lattice, the outermost half a spacing inside the specimen's faces. False: they stand where
    /// grains have grown, and the platens stand where the grains touched them.
    pub lattice: bool,
    /// Effective modulus E* of the contacts between points and platens, Pa.
    pub modulus: f64,
    /// Axial strain at the end, compression positive.
    pub axial_strain: f64,
    /// Axial strain in the time that a compression wave takes through the height of the specimen, by its real density: sets the speed of the test.
    pub strain_per_wave: f64,
    /// Share of the difference between force and target that a platen under servo removes in one step.
    pub gain: f64,
    /// How rigid bodies without points are prepared, where the specimen is made of them.
    pub bed: Option<Bed>,
}

/// A specimen of rigid bodies without points, which are packed without contact: platens press them until they are at rest under a stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bed {
    /// The stress, Pa: the cell pressure, or in an oedometer that of the top platen.
    pub stress: f64,
    /// Friction coefficient between bodies until they bear it; `None`: that of the materials.
    pub friction: Option<f64>,
    /// Mean diameter of the spheres of the bodies' volumes, weighted by volume, m.
    pub diameter: f64,
    /// Estimate of the oedometric modulus under this stress, Pa: that of a cubic lattice of equal spheres. With it [`MpmSpecimen::strain_per_wave`] gives the speed of the test.
    pub modulus: f64,
}

impl MpmSpecimen {
    /// Inertial number of rigid bodies alone at the strain rate `rate`, 1/s, and the mean stress `pressure`, Pa: rate times d √(ρ/p) with the density ρ of the bodies (Li et al. 2023, eq. 42). `None` for
    /// points.
    pub fn inertial_number(&self, rate: f64, pressure: f64) -> Option<f64> {
        let solid = self.density / (1.0 - self.porosity);
        Some(rate * self.bed?.diameter * (solid / pressure).sqrt())
    }

    /// Volume of the specimen over that of the box around it: 1, or π/4 for a cylinder.
    pub fn fullness(&self) -> f64 {
        if self.round { FRAC_PI_4 } else { 1.0 }
    }

    /// Volume of a point at the start over `spacing`³: 1 on a lattice, π/3 in the rings of a cylinder, whose points stand a
    /// little further apart along the ring.
    pub fn roominess(&self) -> f64 {
        if self.round { FRAC_PI_3 } else { 1.0 }
    }

    /// Middle of the base, m.
    pub fn base(&self) -> [f64; 3] {
        [self.lower[0] + 0.5 * self.size[0], self.lower[1] + 0.5 * self.size[1], self.lower[2]]
    }
}

impl MpmTest {
    /// Numbers of points and of grains at the start of the test; estimates where the specimen grows.
    pub fn counts(&self) -> [usize; 2] {
        let [points, grains] = self.left_out;
        let listed = || [self.points.len() + points, self.coarse.as_ref().map_or(0, |c| c.grains.len()) + grains];
        self.growth.as_ref().map_or_else(listed, Growth::counts)
    }

    /// The specimen; `None` in a free scene.
    pub fn specimen(&self) -> Option<&MpmSpecimen> {
        self.test.specimen()
    }

    /// Oedometric modulus of a specimen at the start, Pa, by which waves run through it.
    pub fn oedometric(&self, specimen: &MpmSpecimen) -> f64 {
        match specimen.bed {
            Some(bed) => bed.modulus,
            None => self.laws[usize::from(specimen.law)].under(specimen.stress).oedometric(),
        }
    }

    /// Whether the specimen comes to rest under a stress before it is loaded.
    pub fn settles(&self) -> bool {
        matches!(self.test, Test::Triaxial { .. }) || self.specimen().is_some_and(|s| s.bed.is_some())
    }

    /// The points at the start with the inertia that they move with.
    pub fn moving_points(&self) -> Points {
        let mut points = self.points.clone();
        points.velocity.iter_mut().for_each(|v| v[3] *= self.points_inertia);
        points
    }

    /// Real mass, kg, of grains and points together, whose inertia is `inertia`, kg; `of_points` is that of the points.
    pub fn real_mass(&self, inertia: f64, of_points: f64) -> f64 {
        inertia - of_points * (1.0 - 1.0 / self.points_inertia)
    }

    /// Whether this is a quasi-static test of points between platens; see [`engine::dem::physics::Stepping::slow`].
    pub fn is_slow(&self) -> bool {
        let [points, _] = self.counts();
        points > 0 && self.specimen().is_some()
    }
}

impl Test {
    /// The specimen; `None` in a free scene.
    pub fn specimen_mut(&mut self) -> Option<&mut MpmSpecimen> {
        match self {
            Test::Free { .. } => None,
            Test::Oedometer(specimen) | Test::Triaxial { specimen, .. } => Some(specimen),
        }
    }

    /// The specimen; `None` in a free scene.
    pub fn specimen(&self) -> Option<&MpmSpecimen> {
        match self {
            Test::Free { .. } => None,
            Test::Oedometer(specimen) | Test::Triaxial { specimen, .. } => Some(specimen),
        }
    }
}
