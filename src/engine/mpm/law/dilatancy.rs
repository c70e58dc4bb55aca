//! Dilation that ends with softening: at the critical state soil flows at constant volume (Roscoe, Schofield & Wroth 1958; Bolton 1986, Géotechnique 36, 65-78).
//!
//! The slope of the plastic potential falls in proportion to how far the slope of the cone is above that of the critical state:
//!
//! alpha_psi = alpha_psi,peak (alpha - alpha_cs) / (alpha_peak - alpha_cs), not below 0
//!
//! - alpha, alpha_peak, alpha_cs: the slope of the cone at the present, the largest and the final friction angle
//! - alpha_psi,peak: that of the stated dilation angle
//!
//! Without cohesion and at failure, q/p = 3 sqrt3 alpha and d(eps_v)/d(eps_q) = -3 sqrt3 alpha_psi (compression positive): this is the stress dilatancy of Taylor (1948),
//! d(eps_v)/d(eps_q) = A (M_cs - q/p), with a factor A as Nova & Wood (1979, Int. J. Numer. Anal. Methods Geomech. 3, 255-278) have it, so that the dilation at the peak is the
//! one that was measured. The rule of Rowe (1962), sin psi = (sin phi - sin phi_cs)/(1 - sin phi sin phi_cs), scaled to the same peak, lies within 6 % of the peak's dilation of it
//! for angles of soils; it is not taken since in terms of cones it needs angles, and their sines, at every yielding point.
//!
//! Dissipation is not negative where the stated dilation angle is at most the largest friction angle: as alpha <= alpha_peak, alpha_psi <= alpha_psi,peak alpha/alpha_peak <= alpha.
//! Below the final friction angle, as on the way to the peak, soil would contract; here volume stays.

use super::{Cone, Dilation, Evolution, Parameters};

/// The slope of the plastic potential as a function of the slope of the cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dilatancy {
    /// Slope of the cone at the critical state, -.
    pub(crate) critical: f64,
    /// alpha_psi,peak / (alpha_peak - alpha_cs), -.
    pub(crate) factor: f64,
}

impl Dilatancy {
    /// That of these parameters on this cone; `None` where the dilation angle stays.
    pub fn of(parameters: &Parameters, cone: Cone) -> Option<Dilatancy> {
        if parameters.dilation_rule == Dilation::Constant {
            return None;
        }
        let critical = cone.at(parameters.friction.last()).alpha;
        let above = cone.at(parameters.friction.range().1).alpha - critical;
        let factor = if above > 0.0 { cone.at(parameters.dilation).alpha / above } else { 0.0 };
        Some(Dilatancy { critical, factor })
    }

    /// Slope of the potential at this slope of the cone, and its derivative.
    #[inline]
    pub fn at(&self, alpha: f64) -> (f64, f64) {
        let above = alpha - self.critical;
        if above > 0.0 { (self.factor * above, self.factor) } else { (0.0, 0.0) }
    }
}

/// Whether a friction angle rises above its final value, as dilation that ends with softening needs.
pub fn softens(friction: &Evolution) -> bool {
    friction.range().1 > friction.last()
}

#[cfg(test)]
mod tests {
    use super::super::Elastic;
    use super::*;

    const DEGREE: f64 = std::f64::consts::PI / 180.0;

    fn sand(initial: f64, last: f64, dilation: f64) -> Parameters {
        Parameters {
            friction: Evolution::Linear { initial: initial * DEGREE, last: last * DEGREE, strain: 0.1 },
            dilation: dilation * DEGREE,
            dilation_rule: Dilation::Mobilised,
            ..Parameters::of_elastic(Elastic::of_young(2e7, 0.3))
        }
    }

    /// The stated angle at the peak, none at the critical state and below, and in between close to Rowe's rule scaled to the same peak.
    #[test]
    fn it_is_the_stated_one_at_the_peak_and_ends() {
        for (peak, last, psi) in [(45.0, 32.0, 14.0), (38.0, 30.0, 8.0), (28.6, 18.6, 16.0)] {
            for cone in [Cone::Outer, Cone::Inner, Cone::PlaneStrain] {
                let rule = Dilatancy::of(&sand(peak, last, psi), cone).expect("mobilised");
                let at = |phi: f64| rule.at(cone.at(phi * DEGREE).alpha).0;
                let stated = cone.at(psi * DEGREE).alpha;
                assert!((at(peak) / stated - 1.0).abs() < 1e-12);
                assert_eq!((at(last), at(last - 5.0)), (0.0, 0.0));
                let rowe = |phi: f64| {
                    let (s, c) = ((phi * DEGREE).sin(), (last * DEGREE).sin());
                    (s - c) / (1.0 - s * c)
                };
                for k in 0..=20 {
                    let phi = last + (peak - last) * f64::from(k) / 20.0;
                    let scaled = ((psi * DEGREE).sin() * rowe(phi) / rowe(peak)).asin();
                    assert!(
                        (at(phi) - cone.at(scaled).alpha).abs() < 0.06 * stated,
                        "{cone:?} {phi}: {} {}",
                        at(phi),
                        cone.at(scaled).alpha
                    );
                }
            }
        }
        assert_eq!(Dilatancy::of(&Parameters { dilation_rule: Dilation::Constant, ..sand(30.0, 20.0, 5.0) }, Cone::Outer), None);
        assert!(softens(&sand(30.0, 20.0, 5.0).friction) && !softens(&sand(20.0, 30.0, 5.0).friction));
    }
}
