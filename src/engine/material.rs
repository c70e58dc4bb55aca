//! What is true of a grain material.

use crate::parameter::Values;

/// What is true of a grain material.
#[derive(Clone, Debug)]
pub struct Material {
    pub name: String,
    /// Density of the grain including its internal pores, kg/m^3.
    pub density: f64,
    /// Internal porosity n_int (eq. 19).
    pub internal_porosity: f64,
    /// Young's modulus, Pa, and Poisson ratio. Used by the Hertzian laws and the Hertzian contact area.
    pub young: f64,
    pub poisson: f64,
    /// Sliding friction mu = tan(phi) between grains of this material.
    pub friction: f64,
    /// What the run's contact law asks of the material ([`crate::contact::law::Law::PARAMETERS`]).
    pub contact: Values,
    /// Rolling friction (torque limit mu_r R* F_n); 0 = none.
    pub rolling_friction: f64,
}

/// E' of a contact of two bodies, each given by Young's modulus, Pa, and Poisson ratio, Pa (eq. 11).
pub fn effective_modulus((e1, nu1): (f64, f64), (e2, nu2): (f64, f64)) -> f64 {
    1.0 / ((1.0 - nu1 * nu1) / e1 + (1.0 - nu2 * nu2) / e2)
}
