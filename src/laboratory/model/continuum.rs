//! What a run of a continuum knows.

use super::{GrainSpec, WallSpec};
use engine::coupling::{Rates, Rule};
use engine::mpm::law::Law;
use engine::mpm::{Points, Settings};
use engine::rigid::Block;
use std::f64::consts::{FRAC_PI_3, FRAC_PI_4};

/// Material points on a grid, and what is done with them.
#[derive(Clone, Debug)]
pub struct Continuum {
    pub settings: Settings,
    /// One a material, in the order of their numbers.
    pub laws: Vec<Law>,
    pub points: Points,
    /// Points along the edge of a cell of the first body.
    pub per_edge: u32,
    /// Where run-out is counted from: the axis of the first body (for a box its lower corner), m.
    pub axis: [f64; 3],
    pub test: Test,
    /// The grains in it; `None` in a continuum alone.
    pub coarse: Option<Coarse>,
    /// How the specimen grows before its test, instead of these points and grains.
    pub growth: Option<Growth>,
    /// Rows of history and snapshots over the run, besides the first.
    pub rows: u32,
    pub frames: u32,
}

/// Grains in a continuum.
#[derive(Clone, Debug)]
pub struct Coarse {
    pub grains: Vec<GrainSpec>,
    /// Rigid bodies that are no spheres, as they start.
    pub blocks: Vec<Block>,
    /// Walls of free scenes, which points touch as well.
    pub walls: Vec<WallSpec>,
    /// For each law of the continuum the material of the fines' grains, which says how its points touch.
    pub point_materials: Vec<u8>,
    /// Instead of the rates that the stable steps give.
    pub rates: Option<Rates>,
    /// How the mass that breakages lose becomes points, where it does.
    pub fines: Option<Rule>,
}

/// A specimen that grows (Li et al. 2023, section 4.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    pub fines: Fraction,
    pub coarse: Option<Fraction>,
    /// Whether the fines become material points.
    pub as_points: bool,
    /// Friction between grains until the walls bear the stress; the materials' if `None`.
    pub friction: Option<f64>,
    /// Isotropic stress, Pa (in an oedometer that of the top).
    pub stress: f64,
    pub steps: u64,
    pub max_steps: u64,
}

/// Grains of one material, radii, m, uniform between two, with this volume in all, m³.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fraction {
    pub material: u8,
    pub radii: [f64; 2],
    pub volume: f64,
}

impl Fraction {
    /// How many grains that are.
    pub fn count(&self) -> usize {
        let [a, b] = self.radii;
        (self.volume / (FRAC_PI_3 * (a + b) * (a * a + b * b))).round() as usize
    }

    pub fn mean_diameter(&self) -> f64 {
        self.radii[0] + self.radii[1]
    }
}

impl Growth {
    /// Points, and grains, that there will be.
    pub fn counts(&self) -> [usize; 2] {
        let (fine, coarse) = (self.fines.count(), self.coarse.map_or(0, |c| c.count()));
        if self.as_points { [fine, coarse] } else { [0, fine + coarse] }
    }
}

/// What is done with the points.
#[derive(Clone, Debug)]
pub enum Test {
    /// They move by themselves, for a time, s, or so many steps.
    Free { duration: Option<f64>, steps: Option<u64> },
    /// Smooth fixed sides and bottom, a driven top platen.
    Oedometer(Specimen),
    /// Platens on all sides: the lateral ones hold the cell pressure, the axial ones move.
    Triaxial { specimen: Specimen, cell_pressure: f64, drainage: Drainage },
}

/// What the lateral platens do while the axial ones come together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drainage {
    /// They hold the cell pressure.
    Drained,
    /// They keep the volume, as a saturated specimen does that cannot drain.
    ConstantVolume,
}

/// A box of points between platens, or a cylinder in a shell.
#[derive(Clone, Debug, PartialEq)]
pub struct Specimen {
    /// Lower corner and size at the start, m; a cylinder's are those of the box around it.
    pub lower: [f64; 3],
    pub size: [f64; 3],
    /// An upright cylinder.
    pub round: bool,
    /// Isotropic stress of the points at the start, Pa, compression positive.
    pub stress: f64,
    /// Distance of two points at the start, m.
    pub spacing: f64,
    /// Porosity at the start, and law and density, kg/m³, of the fines.
    pub porosity: f64,
    pub law: u8,
    pub density: f64,
    /// Points stand on a lattice, the outermost half a distance inside; else as grains have grown, and platens where they touch them.
    pub lattice: bool,
    /// E* of the platens' contacts, Pa.
    pub modulus: f64,
    /// Axial strain at the end.
    pub axial_strain: f64,
    /// Axial strain in the time that a compression wave takes through the specimen.
    pub strain_per_wave: f64,
    /// Share of a servo's imbalance that it removes in one step.
    pub gain: f64,
}

impl Specimen {
    /// Volume over that of the box around it.
    pub fn fullness(&self) -> f64 {
        if self.round { FRAC_PI_4 } else { 1.0 }
    }

    /// Volume of a point at the start over the cube of the distance of two: in rings they stand a little further apart along the ring.
    pub fn roominess(&self) -> f64 {
        if self.round { FRAC_PI_3 } else { 1.0 }
    }

    /// Middle of its base, m.
    pub fn base(&self) -> [f64; 3] {
        [self.lower[0] + 0.5 * self.size[0], self.lower[1] + 0.5 * self.size[1], self.lower[2]]
    }
}

impl Continuum {
    /// Points and grains at the start of the test.
    pub fn counts(&self) -> [usize; 2] {
        let listed = || [self.points.len(), self.coarse.as_ref().map_or(0, |c| c.grains.len())];
        self.growth.as_ref().map_or_else(listed, Growth::counts)
    }

    /// The box between platens, where there is one.
    pub fn specimen(&self) -> Option<&Specimen> {
        self.test.specimen()
    }

    /// Whether it is a test of points: see [`engine::dem::physics::Stepping::slow`].
    pub fn is_slow(&self) -> bool {
        let [points, _] = self.counts();
        points > 0 && self.specimen().is_some()
    }
}

impl Test {
    /// The box between platens, where there is one.
    pub fn specimen(&self) -> Option<&Specimen> {
        match self {
            Test::Free { .. } => None,
            Test::Oedometer(specimen) | Test::Triaxial { specimen, .. } => Some(specimen),
        }
    }
}
