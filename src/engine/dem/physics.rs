//! What the time step needs and a run never changes: materials, laws of contact and breakage, gravity, damping, choice of the time step.

use crate::breakage::CrushModel;
use crate::contact::ContactModel;
use crate::material::Material;

/// Laws and constants of a run that the time step needs, SI units.
#[derive(Clone, Debug)]
pub struct Physics {
    /// All materials; index 0 is that of generated grains.
    pub materials: Vec<Material>,
    /// Contact law, unloading of tangential springs, rolling, rotation.
    pub contact: ContactModel,
    /// Laws of breakage; `None`: grains do not break.
    pub crush: Option<CrushModel>,
    /// Coefficient α of local non-viscous damping (Cundall 1987), 0 to 1.
    pub damping: f64,
    /// Gravity, m/s².
    pub gravity: [f64; 3],
    /// Choice of the time step.
    pub stepping: Stepping,
}

/// Choice of the time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepping {
    /// Time step over the largest stable one (a sufficient bound, see [`crate::dem::stability`]), 0 to 1.
    pub safety: f64,
    /// Inertia scaling for quasi-static tests: every grain gets the inertial mass for which one step is stable; time is counted in steps.
    pub inertia_scaling: bool,
    /// A fixed time step, s; `None`: computed from contact stiffnesses and masses.
    pub dt: Option<f64>,
    /// Whether grains and material points come into contact slowly, as in a test of a mixture: contacts then have to be stable, but need not be
    /// resolved in time as in an impact.
    pub slow: bool,
    /// Skin of the neighbour lists over the radius of a grain.
    pub skin: f64,
}

impl Stepping {
    /// Time step over the Rayleigh step before any contact is known: 0.1, or 0.4 where grains and points come into contact slowly.
    pub fn rayleigh(&self) -> f64 {
        if self.slow { 0.4 } else { 0.1 }
    }
}
