//! The cones of Drucker and Prager, J + alpha I1 = k c (tension positive, J = sqrt(J2)), that touch the Mohr-Coulomb pyramid of the friction angle phi and the
//! cohesion c. sin, cos and tan are those of phi.
//!
//! - outer, through the edges of triaxial compression: alpha = 2 sin / (sqrt3 (3 - sin)), k = 6 cos / (sqrt3 (3 - sin)). The cone of Li et al. (2023), Computers
//!   and Geotechnics 160, 105508 (section 4.1).
//! - inner, through the edges of triaxial extension: the same with 3 + sin.
//! - plane strain, with the same collapse load in plane strain for associated flow: alpha = tan / sqrt(9 + 12 tan²), k = 3 / sqrt(9 + 12 tan²); Jiang et al.
//!   (2020), eq. 35 (q_phi there is 3 alpha), and Zhang et al., eq. 6.

use crate::math::portable::sin;
use serde::{Deserialize, Serialize};

/// Where a cone touches the Mohr-Coulomb pyramid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cone {
    /// At the edges of triaxial compression, outside of the pyramid.
    Outer,
    /// At the edges of triaxial extension.
    Inner,
    /// Inside of the pyramid, on all of its planes: the same collapse load in plane strain.
    PlaneStrain,
}

/// alpha and k of a cone, -, with their first and second derivatives with respect to the angle, 1/rad and 1/rad².
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Constants {
    /// alpha, the slope of the cone.
    pub alpha: f64,
    /// k, the factor of the cohesion.
    pub k: f64,
    /// First derivative of alpha.
    pub dalpha: f64,
    /// First derivative of k.
    pub dk: f64,
    /// Second derivative of alpha.
    pub d2alpha: f64,
    /// Second derivative of k.
    pub d2k: f64,
}

impl Cone {
    /// The constants for a friction or dilation angle, rad, in 0..pi/2.
    pub fn at(self, angle: f64) -> Constants {
        let s = sin(angle);
        let c = (1.0 - s * s).max(0.0).sqrt();
        match self {
            Cone::Outer => edge(s, c, -1.0),
            Cone::Inner => edge(s, c, 1.0),
            Cone::PlaneStrain => {
                // tan / sqrt(9 + 12 tan²) = sin / sqrt(9 cos² + 12 sin²)
                let below = 1.0 / (9.0 + 3.0 * s * s).sqrt();
                let (square, cube) = (below * below, below * below * below);
                Constants {
                    alpha: s * below,
                    k: 3.0 * c * below,
                    dalpha: 9.0 * c * cube,
                    dk: -3.0 * s * below - 9.0 * s * c * c * cube,
                    d2alpha: -9.0 * s * cube * (1.0 + 9.0 * (c * c) * square),
                    d2k: c * (-3.0 * below + cube * (27.0 * (s * s) - 9.0 * (c * c) + 81.0 * (s * s) * (c * c) * square)),
                }
            }
        }
    }

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Cone::Outer => "outer",
            Cone::Inner => "inner",
            Cone::PlaneStrain => "plane_strain",
        }
    }
}

/// The constants of a cone through edges of the pyramid, for the sine `s` and cosine `c` of the angle; `sign` is -1 for the outer cone and 1 for the inner one.
fn edge(s: f64, c: f64, sign: f64) -> Constants {
    const ROOT: f64 = 1.154_700_538_379_251_7; // 2 / sqrt(3)
    let below = 1.0 / (3.0 + sign * s);
    Constants {
        alpha: ROOT * s * below,
        k: 3.0 * ROOT * c * below,
        dalpha: 3.0 * ROOT * c * (below * below),
        dk: 3.0 * ROOT * (-s * below - sign * (c * c) * (below * below)),
        d2alpha: -3.0 * ROOT * (below * below) * (s + sign * 2.0 * (c * c) * below),
        d2k: 3.0 * ROOT * (c * below) * (-1.0 + below * (sign * 3.0 * s + 2.0 * (c * c) * below)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONES: [Cone; 3] = [Cone::Outer, Cone::Inner, Cone::PlaneStrain];

    #[test]
    fn slopes_are_those_of_the_constants() {
        let h = 1e-6;
        for cone in CONES {
            for i in 0..=14 {
                let angle = 0.1 * f64::from(i);
                let (low, at, high) = (cone.at(angle - h), cone.at(angle), cone.at(angle + h));
                let slope = |a: f64, b: f64| (b - a) / (2.0 * h);
                assert!((slope(low.alpha, high.alpha) - at.dalpha).abs() < 1e-9, "{cone:?} {angle}");
                assert!((slope(low.k, high.k) - at.dk).abs() < 1e-9, "{cone:?} {angle}");
                assert!((slope(low.dalpha, high.dalpha) - at.d2alpha).abs() < 1e-8, "{cone:?} {angle}");
                assert!((slope(low.dk, high.dk) - at.d2k).abs() < 1e-8, "{cone:?} {angle}");
            }
        }
    }

    /// At 30° the sine is a half: the constants of the table above as numbers.
    #[test]
    fn constants_are_those_of_their_sources() {
        let (s, c) = (0.5, 0.75f64.sqrt());
        let (root, t) = (3f64.sqrt(), s / c);
        for (cone, alpha, k) in [
            (Cone::Outer, 2.0 * s / (root * (3.0 - s)), 6.0 * c / (root * (3.0 - s))),
            (Cone::Inner, 2.0 * s / (root * (3.0 + s)), 6.0 * c / (root * (3.0 + s))),
            (Cone::PlaneStrain, t / (9.0 + 12.0 * t * t).sqrt(), 3.0 / (9.0 + 12.0 * t * t).sqrt()),
        ] {
            let at = cone.at(std::f64::consts::FRAC_PI_6);
            assert!((at.alpha / alpha - 1.0).abs() < 1e-14 && (at.k / k - 1.0).abs() < 1e-14, "{cone:?}: {at:?}");
        }
        assert_eq!(CONES.map(Cone::name), ["outer", "inner", "plane_strain"]);
    }

    #[test]
    fn without_friction_only_cohesion_is_left() {
        for (cone, k) in CONES.into_iter().zip([1.154_700_538, 1.154_700_538, 1.0]) {
            let at = cone.at(0.0);
            assert_eq!(at.alpha, 0.0);
            assert!((at.k - k).abs() < 1e-9);
        }
    }
}
