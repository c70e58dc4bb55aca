//! What the time step needs and a run never changes: materials, laws of contact and breakage, gravity, damping, choice of the time step.

use crate::breakage::CrushModel;
use crate::contact::{ContactLaw, ContactModel, TangentialUnloading};
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

impl Physics {
    /// Grains of these materials under a contact law and nothing else: no breakage, no damping, no gravity; grains turn, the
    /// tangential force stays when the normal force falls, and the time step is the automatic one.
    pub fn of(materials: Vec<Material>, law: ContactLaw) -> Physics {
        let rolling = materials.iter().any(|m| m.rolling_friction > 0.0);
        Physics {
            materials,
            contact: ContactModel { law, unloading: TangentialUnloading::Keep, rolling, turning: true },
            crush: None,
            damping: 0.0,
            gravity: [0.0; 3],
            stepping: Stepping::default(),
        }
    }
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
    /// Skin of the neighbour lists of a grain at rest, over its radius; that of a fast grain is up to four times as wide.
    pub skin: f64,
}

impl Default for Stepping {
    /// The automatic step with real inertia: 0.8 of the stable one, lists with a skin of 0.2.
    fn default() -> Stepping {
        Stepping { safety: 0.8, inertia_scaling: false, dt: None, slow: false, skin: 0.2 }
    }
}

impl Stepping {
    /// Time step over the Rayleigh step before any contact is known: 0.1, or 0.4 where grains and points come into contact slowly.
    pub fn rayleigh(&self) -> f64 {
        if self.slow { 0.4 } else { 0.1 }
    }
}
