//! Which laws act at every contact of a run.

use serde::{Deserialize, Serialize};

/// The law of every contact of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactModel {
    pub law: ContactLaw,
    pub unloading: TangentialUnloading,
    /// Whether any material has rolling friction.
    pub rolling: bool,
    /// Whether grains turn. Grains kept from turning stand for angular ones.
    pub turning: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ContactLaw {
    /// Ciantia et al. 2015 eq. (13).
    Linear,
    /// As `Linear`, but fragments keep the stiffness of the initial grain they come from: D1, D2 of eq. (13) are its diameter. A reading of the paper
    /// (daughters "assume the … material parameters of the mother", and its code sets stiffness ball by ball), here to be compared with the other.
    LinearInherited,
    /// Ciantia et al. 2015 eq. (14); Li et al. 2023 eqs (20), (21) for pairs of different materials.
    Hertz,
    /// Li et al. 2023 eqs (18)-(21): Hertz-Mindlin with viscous damping.
    HertzViscous,
    /// As `HertzViscous`, but the normal force ends where it would turn tensile, with the damping that gives the same restitution.
    HertzViscousNoTension,
}

impl ContactLaw {
    /// Whether dashpots add to the springs, which then keep a column of their own.
    pub fn is_viscous(self) -> bool {
        matches!(self, ContactLaw::HertzViscous | ContactLaw::HertzViscousNoTension)
    }

    /// Whether the normal force is in proportion to the overlap.
    pub fn is_linear(self) -> bool {
        matches!(self, ContactLaw::Linear | ContactLaw::LinearInherited)
    }
}

/// What the tangential force does when the normal force falls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TangentialUnloading {
    /// The tangential force stays (the paper).
    Keep,
    /// The tangential force falls in proportion to k_S.
    Rescale,
}
