//! What constitutive laws are made from.

use super::{Cone, Elastic, Evolution};
use serde::{Deserialize, Serialize};

/// The parameters of a constitutive law; a law reads those of its keys ([`super::ConstitutiveLaw::KEYS`]).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// Elastic moduli.
    pub elastic: Elastic,
    /// Where the cone of failure touches the Mohr-Coulomb pyramid.
    pub cone: Cone,
    /// Friction angle, rad.
    pub friction: Evolution,
    /// Cohesion, Pa.
    pub cohesion: Evolution,
    /// Dilation angle, rad; with [`Dilation::Mobilised`] that at the largest friction angle.
    pub dilation: f64,
    /// How the dilation angle follows the friction angle.
    pub dilation_rule: Dilation,
    /// Largest mean tension, Pa; infinite: only the apex limits it.
    pub tension: f64,
    /// Compression lines of Modified Cam-clay; other laws do not read them.
    pub clay: Clay,
}

impl Parameters {
    /// These moduli, and no strength, no dilation and no limit of tension: what a law needs besides is written over it.
    pub fn of_elastic(elastic: Elastic) -> Parameters {
        Parameters {
            elastic,
            cone: Cone::Outer,
            friction: Evolution::Constant(0.0),
            cohesion: Evolution::Constant(0.0),
            dilation: 0.0,
            dilation_rule: Dilation::Constant,
            tension: f64::INFINITY,
            clay: Clay::default(),
        }
    }
}

/// How the dilation angle follows the friction angle ([`super::dilatancy`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Dilation {
    /// It stays, so that volume grows as long as the material yields.
    #[default]
    Constant,
    /// It is the stated one at the largest friction angle, falls with the friction angle and ends with it: at the final, critical-state friction angle, and below, volume
    /// stays.
    Mobilised,
}

/// Compression lines and elasticity of Modified Cam-clay ([`super::CamClay`]). v = 1 + e: specific volume, e: void ratio.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Clay {
    /// λ, slope of the virgin line of isotropic compression in (ln p, v), -.
    pub virgin_slope: f64,
    /// κ, slope of the lines of unloading and reloading in (ln p, v), -; above 0 and below λ.
    pub swelling_slope: f64,
    /// Preconsolidation pressure p_c at the start, Pa: the largest isotropic pressure that is elastic.
    pub preconsolidation: f64,
    /// Specific volume on the virgin line at that pressure, -.
    pub virgin_volume: f64,
    /// What the shear modulus follows.
    pub shear: Shear,
}

/// The shear modulus of Modified Cam-clay.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Shear {
    /// A Poisson ratio, -, that stays: the shear modulus goes with the bulk modulus, so that the elastic part stores no energy function (Zytynski et al. 1978).
    Poisson(f64),
    /// A shear modulus, Pa, that stays.
    Modulus(f64),
}

impl Default for Shear {
    fn default() -> Shear {
        Shear::Poisson(0.0)
    }
}
