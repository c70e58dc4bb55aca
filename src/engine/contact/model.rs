//! Which laws act at every contact of a run.

use super::registry::ContactLaw;
use super::unloading::TangentialUnloading;

/// The laws of every contact of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactModel {
    /// Normal force and tangential stiffness.
    pub law: ContactLaw,
    /// What the tangential force does when the normal force falls.
    pub unloading: TangentialUnloading,
    /// Whether any material has rolling friction.
    pub rolling: bool,
    /// Whether grains turn. Grains kept from turning stand for angular ones.
    pub turning: bool,
}
