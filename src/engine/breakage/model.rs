//! How grains break in a run.

use super::pattern::{Azimuth, Pattern};
use super::registry::Criterion;
use super::strength::StrengthModel;

/// How the grains of a run break.
#[derive(Clone, Debug)]
pub struct CrushModel {
    /// When a grain fails.
    pub criterion: Criterion,
    /// Distribution of the grains' strengths.
    pub strength: StrengthModel,
    /// Seed of the random numbers: of strengths, and of the direction in which a pattern is turned about its axis.
    pub seed: u64,
    /// Into which daughters a grain breaks.
    pub pattern: Pattern,
    /// Around which seeds bodies that are no spheres break into cells ([`crate::shape::Shape::cells`]); none: in two. Compounds break into their parts ([`crate::rigid::parts_of`]).
    pub cells: Vec<[f64; 3]>,
    /// How the pattern is turned about its axis.
    pub azimuth: Azimuth,
    /// Comminution limit, m: only grains with a larger diameter break. Like all lengths of a run it is already multiplied by the scale N.
    pub d_limit: f64,
    /// How daughters enter the assembly.
    pub birth: Birth,
    /// Whether daughters grow until they together have the mass of their mother. Otherwise the mass they do not hold is lost to the simulation, and only counted.
    pub keeps_mass: bool,
    /// Number of steps between two tests of all grains against the criterion.
    pub interval: u64,
}

/// How daughters enter the assembly ([`crate::dem::birth`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Birth {
    /// At once and with their full size in the sphere of their mother, with whatever overlap she had with her neighbours (Ciantia et al. 2015).
    Overlapping,
    /// Small enough that they overlap nothing, to grow afterwards.
    Gradual {
        /// Number of steps over which the forces fade that the mother exerted on her neighbours.
        release: u32,
        /// Number of steps that a daughter takes at least to grow to its size.
        growth: u32,
    },
}
