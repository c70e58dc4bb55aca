//! What grains do in a run and never changes: materials, laws of contact and breakage, gravity, damping and the choice of time steps.

use crate::breakage::CrushModel;
use crate::contact::ContactModel;
use crate::material::Material;

/// The laws and constants of a run that the time step needs. SI units.
#[derive(Clone, Debug)]
pub struct Physics {
    /// Index 0 is the material of generated grains.
    pub materials: Vec<Material>,
    pub contact: ContactModel,
    /// `None`: grains do not break, and nothing is tracked for it.
    pub crush: Option<CrushModel>,
    /// Cundall's local non-viscous damping coefficient, 0..1.
    pub damping: f64,
    /// Gravity, m/s^2.
    pub gravity: [f64; 3],
    pub stepping: Stepping,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepping {
    /// Fraction of the stable step (sufficient bound, see [`crate::dem::stability`]), 0..1.
    pub safety: f64,
    /// Quasi-static inertia scaling: every grain gets the inertia for which the step is stable; time is counted in steps.
    pub inertia_scaling: bool,
    /// A fixed time step, s (free scenes); `None`: computed from contact stiffness and inertia.
    pub dt: Option<f64>,
    /// Grains and points come upon each other slowly: contacts have to be stable, and need not be resolved as in an impact.
    pub slow: bool,
    /// Neighbour skin of a grain over its radius.
    pub skin: f64,
}

impl Stepping {
    /// Share of the Rayleigh step that grains may go before any contact is known. Slow ones need no more steps than the points.
    pub fn rayleigh(&self) -> f64 {
        if self.slow { 0.4 } else { 0.1 }
    }
}
