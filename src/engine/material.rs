//! Constants of a grain material.

use crate::math::portable::exp;
use crate::parameter::Values;
use serde::Serialize;

/// Constants of a grain material. Equation numbers are those of Ciantia et al. (2015).
#[derive(Clone, Debug)]
pub struct Material {
    /// Name, for messages and records.
    pub name: String,
    /// Density of the grain including its internal pores, kg/m³.
    pub density: f64,
    /// Volume of the pores inside of a grain over the grain's volume, n_int (eq. 19).
    pub internal_porosity: f64,
    /// Young's modulus, Pa; used by the contact laws after Hertz and by Hertz's contact area.
    pub young: f64,
    /// Poisson ratio; used with `young`.
    pub poisson: f64,
    /// Coefficient of sliding friction, µ = tan φ, between grains of this material.
    pub friction: f64,
    /// Values of the parameters that the run's contact law declares ([`crate::contact::law::Law::PARAMETERS`]), SI units.
    pub contact: Values,
    /// Coefficient of rolling friction µ_r: the rolling moment of a contact is at most µ_r R* F_n; 0: none.
    pub rolling_friction: f64,
    /// Coefficient of friction of this material as a continuum on grains and rigid bodies; `None`: that between its grains. The points of a continuum have no
    /// spin, so all of their contacts slide where grains would roll: what grains pass on along a large body is a third of their own coefficient.
    pub interface_friction: Option<InterfaceFriction>,
}

/// Coefficient of friction of a continuum on bodies in it against the plastic strain e of the point that touches, μ = μ_r + (μ_0 − μ_r) exp(−H e): the form in which
/// eq. 43 of Li et al. (2023) softens.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct InterfaceFriction {
    /// μ_0, without plastic strain, -.
    pub initial: f64,
    /// μ_r, towards which it goes, -.
    pub residual: f64,
    /// H, -; 0: it stays.
    pub decay: f64,
}

impl InterfaceFriction {
    /// One that stays.
    pub fn constant(friction: f64) -> InterfaceFriction {
        InterfaceFriction { initial: friction, residual: friction, decay: 0.0 }
    }

    /// The coefficient at the plastic strain `e`.
    #[inline]
    pub fn at(&self, e: f64) -> f64 {
        self.residual + (self.initial - self.residual) * exp(-self.decay * e)
    }
}

/// Effective modulus E' of a contact, Pa: 1/E' = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂ (Ciantia et al. 2015, eq. 11). Each body is given by its Young's
/// modulus, Pa, and its Poisson ratio; an infinite modulus is a rigid body.
pub fn effective_modulus((e1, nu1): (f64, f64), (e2, nu2): (f64, f64)) -> f64 {
    1.0 / ((1.0 - nu1 * nu1) / e1 + (1.0 - nu2 * nu2) / e2)
}
