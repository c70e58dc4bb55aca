//! When a grain fails. To add a criterion, write a type that implements [`FailureCriterion`] in a file of its own, and a line in [`super::registry`].
//!
//! Some criteria judge the contacts of a grain one by one: the grain fails where the force of one contact exceeds the grain's strength times an area. Others judge
//! the mean stress of the grain (Love–Weber: the sum over its contacts of force times arm, over its volume): the grain fails where an equivalent stress exceeds its
//! strength. In uniaxial compression every equivalent stress equals the axial stress, so that one strength from tests of single grains calibrates all of them.
//!
//! Stresses are compression positive, Pa.

mod christensen;
mod fixed_angle;
mod hertz_area;
pub mod limit_strength;
mod mohr_coulomb;
mod von_mises;

pub use christensen::Christensen;
pub use fixed_angle::FixedAngle;
pub use hertz_area::HertzArea;
pub use mohr_coulomb::MohrCoulomb;
pub use von_mises::VonMises;

use crate::math::eigen::principal;
use crate::math::portable;
use crate::parameter::{Parameter, Values};
use std::f64::consts::PI;

/// What a criterion judges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judges {
    /// The normal force of each contact.
    Contacts,
    /// The grain's mean stress.
    MeanStress,
}

/// A failure criterion of grains.
///
/// # Example
/// Table 1 of Ciantia et al. (2015): a grain of 2 mm with the strength 300 MPa and the contact angle π/9 breaks between two
/// platens at 110 N, whatever they are made of. The grain's mean stress is then 6 F/(π d²): von Mises breaks a grain of that
/// strength at the same force.
///
/// ```
/// use comminute_engine::breakage::criterion::{FailureCriterion, FixedAngle, MeanStress, VonMises};
/// use std::f64::consts::PI;
///
/// let (d, strength) = (2e-3, 300e6);
/// let criterion = FixedAngle { theta0: PI / 9.0 };
/// // R* and E' of the contact do not matter to this criterion
/// let force = criterion.limit_force(strength, d, 0.5 * d, 1e9);
/// assert!((force - 110.25).abs() < 0.01);
/// assert!((force / criterion.area(force, d, 0.5 * d, 1e9) / strength - 1.0).abs() < 1e-12);
///
/// let stress = 6.0 * force / (PI * d * d);
/// assert!((VonMises.limit_force(stress, d, 0.5 * d, 1e9) / force - 1.0).abs() < 1e-12);
/// // the same from all sides breaks nothing
/// assert!(VonMises.equivalent_stress(&MeanStress([stress, stress, stress, 0.0, 0.0, 0.0])) < 1.0);
/// ```
pub trait FailureCriterion: Copy {
    /// The parameters that the criterion needs of a material besides the limit strength and its spread.
    const PARAMETERS: &'static [Parameter] = &[];
    /// What it judges: contacts one by one, or the mean stress.
    const JUDGES: Judges;
    /// Whether [`FailureCriterion::load_weight`] differs from 1: contacts then keep their normal force times this weight.
    const WEIGHTED: bool = false;
    /// The power of the strength in the force that breaks a grain between two platens.
    const POWER: u32 = 1;

    /// The criterion with the values of [`FailureCriterion::PARAMETERS`].
    fn of(values: &Values) -> Self;

    /// Whether [`FailureCriterion::load_weight`] depends on R* of the contact: (E'/R*)² where it does and E'² where it does not, if the load is weighted at all.
    fn weighs_radius(&self) -> bool {
        true
    }

    /// Threshold of a grain with the strength `sigma_lim`, Pa, and the diameter `d`, m: for criteria on contacts that of the normal force, N, times its weight;
    /// otherwise that of the equivalent stress, Pa.
    fn threshold(&self, sigma_lim: f64, d: f64) -> f64;

    /// Factor on the normal force of a contact before it is compared with the threshold; `r_eff`: R* of the contact, m; `e_eff`: its E', Pa.
    fn load_weight(&self, _r_eff: f64, _e_eff: f64) -> f64 {
        1.0
    }

    /// Equivalent stress, Pa, of a mean stress; 0 for criteria on contacts.
    fn equivalent_stress(&self, _stress: &MeanStress) -> f64 {
        0.0
    }

    /// Normal force, N, at which a grain with the strength `sigma_lim`, Pa, and the diameter `d`, m, breaks between two platens; `r_eff`, m, and `e_eff`, Pa: R* and E'
    /// of its contacts with them.
    fn limit_force(&self, sigma_lim: f64, d: f64, r_eff: f64, e_eff: f64) -> f64;

    /// Area, m², over which the force `force`, N, of a contact makes the stress that is compared with the strength.
    fn area(&self, force: f64, d: f64, r_eff: f64, e_eff: f64) -> f64;

    /// The same in plane strain, where forces count per metre of depth, for a body whose disc of the same area has the diameter `d`, m; `None` where the criterion judges no contacts
    /// of such bodies.
    fn plane_area(&self, _d: f64) -> Option<f64> {
        None
    }
}

/// Size hardening (d / d0)^(-3/m), - (Ciantia et al. 2015, eqs 7, 15). `d0_scaled` is the reference diameter times the scale N, m.
pub fn size_factor(d: f64, d0_scaled: f64, m: f64) -> f64 {
    portable::pow(d / d0_scaled, -3.0 / m)
}

/// Mean stress of one grain, Pa, compression positive: `[xx, yy, zz, xy, yz, zx]`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanStress(pub [f64; 6]);

impl MeanStress {
    /// Mean of the normal stresses, Pa.
    pub fn p(&self) -> f64 {
        let [xx, yy, zz, ..] = self.0;
        (xx + yy + zz) / 3.0
    }

    /// Second invariant of the deviator, Pa²: half the sum of its squares; q = √(3 J2).
    pub fn j2(&self) -> f64 {
        let [xx, yy, zz, xy, yz, zx] = self.0;
        let (a, b, c) = (xx - yy, yy - zz, zz - xx);
        (a * a + b * b + c * c) / 6.0 + (xy * xy + yz * yz + zx * zx)
    }

    /// Principal stresses, Pa, the most compressive first.
    pub fn principal(&self) -> [f64; 3] {
        principal(self.0).0
    }
}

/// Area, m², over which the force F of two opposite contacts makes the uniaxial mean stress of a sphere: σ = 2 r F/V = F / (π d²/6).
fn sphere_area(d: f64) -> f64 {
    PI / 6.0 * d * d
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::breakage::Criterion;

    fn close(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() <= relative, "{value} instead of {expected}");
    }

    #[test]
    fn smaller_grains_are_stronger_by_the_power_of_size() {
        assert_eq!(size_factor(2e-3, 2e-3, 2.0), 1.0);
        close(size_factor(8e-3, 2e-3, 2.0), 0.125, 1e-14);
        close(size_factor(0.5e-3, 2e-3, 3.0), 4.0, 1e-14);
        // scale N moves the reference diameter only (eq. 15)
        assert_eq!(size_factor(15e-3, 4e-3, 2.0), size_factor(7.5e-3, 2e-3, 2.0));
    }

    /// Of every criterion: at the limit force the stress is the strength, and the load is at its threshold.
    #[test]
    fn at_the_limit_force_stress_is_strength() {
        for criterion in Criterion::examples() {
            for (d, r_eff, e_eff) in [(7.5e-3, 3.75e-3, 1e9), (2e-3, 0.4e-3, 3e10)] {
                let force = criterion.limit_force(3e8, d, r_eff, e_eff);
                close(force / criterion.area(force, d, r_eff, e_eff), 3e8, 1e-13);
                let load = match criterion.judges() {
                    Judges::Contacts => force * criterion.load_weight(r_eff, e_eff),
                    Judges::MeanStress => {
                        // two opposite forces on a sphere: σ = 3/(4 π r²) Σ n F n
                        let stress = 2.0 * force * 3.0 / (PI * d * d);
                        criterion.equivalent_stress(&MeanStress([0.0, 0.0, stress, 0.0, 0.0, 0.0]))
                    }
                };
                close(load, criterion.threshold(3e8, d), 1e-13);
                let twice = criterion.limit_force(6e8, d, r_eff, e_eff) / force;
                close(twice, 2f64.powi(criterion.power() as i32), 1e-13);
            }
            assert!(criterion.area(0.0, 1e-3, 1e-3, 1e9).is_finite());
        }
    }

    /// What every criterion of the mean stress shares: a stress on all sides breaks nothing, turned axes change nothing, and a support from the sides helps or, for von Mises, only
    /// less difference counts.
    #[test]
    fn pressure_on_all_sides_breaks_nothing() {
        for criterion in Criterion::examples().filter(|c| c.judges() == Judges::MeanStress) {
            let of = |t: [f64; 6]| criterion.equivalent_stress(&MeanStress(t));
            assert!(of([1e8, 1e8, 1e8, 0.0, 0.0, 0.0]) <= 1.0, "{criterion:?}");
            close(of([5e7, 5e7, 0.0, 5e7, 0.0, 0.0]), of([1e8, 0.0, 0.0, 0.0, 0.0, 0.0]), 1e-12);
            let [free, held] = [0.0, 2e7].map(|side| of([1e8, side, side, 0.0, 0.0, 0.0]));
            close(free, 1e8, 1e-13);
            assert!(held < free - 2e7 + 1.0, "{criterion:?}: {held}");
        }
    }
}
