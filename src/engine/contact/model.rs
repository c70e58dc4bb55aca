//! Which laws act at the contacts of a run.

use super::registry::ContactLaw;
use super::unloading::TangentialUnloading;

/// The laws of all contacts of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactModel {
    /// Normal force and tangential stiffness.
    pub law: ContactLaw,
    /// What happens to the tangential force when the normal force falls.
    pub unloading: TangentialUnloading,
    /// Whether any material has rolling friction.
    pub rolling: bool,
    /// Whether grains rotate. Grains without rotation are a crude model of angular grains, which interlock.
    pub turning: bool,
}
