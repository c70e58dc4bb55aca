//! How grains break in a run.

use super::pattern::Pattern;
use super::registry::Criterion;
use super::strength::StrengthModel;

#[derive(Clone, Debug)]
pub struct CrushModel {
    /// When a grain fails.
    pub criterion: Criterion,
    /// Strength of each grain.
    pub strength: StrengthModel,
    /// Seed of strengths and of the azimuths of splitting.
    pub seed: u64,
    pub pattern: Pattern,
    /// Comminution limit, m, already multiplied by the scale N: only grains with a diameter above it break.
    pub d_limit: f64,
    pub birth: Birth,
    /// Daughters grow until they have their mother's mass; otherwise what they do not hold leaves the mechanics.
    pub keeps_mass: bool,
    /// Steps between two judgements of all grains.
    pub interval: u64,
}

/// How daughters enter the assembly ([`crate::dem::birth`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Birth {
    /// Where their mother was, with her overlaps, at once (Ciantia et al. 2015).
    Overlapping,
    /// Without overlap: the mother's hold on her neighbours fades over `release` steps, and daughters grow to their size in no less than `growth`.
    Gradual { release: u32, growth: u32 },
}
