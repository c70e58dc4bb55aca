//! Crushing stress of single grains, as laboratories measure it: the force F that breaks a grain of the diameter d between two flat rigid platens, over d^2.
//!
//! It differs from the limit strength sigma_lim of Ciantia et al. (2015) eq. (5), which is F over the area of the contact:
//!
//! - fixed angle (eq. 16): F/d^2 = pi/4 sin^2(theta0) sigma_lim, at theta0 <= 0.38 rad at most a ninth of it;
//! - Hertz's area (eq. 17, r' = d/2): F/d^2 = 9/64 pi^3 sigma_lim^3 / E'^2. The mean force is then not the force at the mean strength.
//!
//! Platens are rigid: E' = E/(1 - nu^2) of the grain. With platens of steel (200 GPa, nu 0.3) the force of eq. (17) would be larger by (E'_rigid/E'_steel)^2, for
//! grains of E = 70 GPa 1.8 times.
//!
//! The strengths of a run are computed here, so only functions are used that give the same bits on every machine.

use super::Criterion;
use super::criterion::size_factor;
use super::strength::{Distribution, StrengthModel, Truncation};
use crate::math::portable;

/// Which statistic of the crushing stresses of many grains of one size is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quoted {
    /// The mean.
    Mean,
    /// The stress that the share 1/e = 37 % of the grains survives; the characteristic strength of Weibull plots.
    Survival37,
}

/// Half the range of integration, in standard deviations about the mean; the share beyond is 1e-14.
const REACH: f64 = 8.0;
/// Number of intervals of Simpson's rule over the distribution.
const INTERVALS: usize = 2000;

impl StrengthModel {
    /// Crushing stress F/d^2, Pa, of grains of the diameter `d`, m, between rigid platens; `e_eff` is E', Pa.
    pub fn crushing_stress(&self, criterion: Criterion, e_eff: f64, d: f64, quoted: Quoted) -> f64 {
        let strength = self.sigma_lim0 * size_factor(d, self.d0, self.m);
        let (factor, power) = stress_per_strength(criterion, e_eff, d);
        factor * whole_power(strength, power) * self.statistic(power, quoted)
    }

    /// The `sigma_lim0`, Pa, for which grains of the reference diameter have this crushing stress, Pa, between rigid platens; the inverse of
    /// [`StrengthModel::crushing_stress`].
    pub fn sigma_lim0_from(&self, crushing_stress: f64, criterion: Criterion, e_eff: f64, quoted: Quoted) -> f64 {
        let (factor, power) = stress_per_strength(criterion, e_eff, self.d0);
        let powered = crushing_stress / (factor * self.statistic(power, quoted));
        if power == 1 { powered } else { portable::pow(powered, 1.0 / f64::from(power)) }
    }

    /// The mean of the ratios to a power, or the value that 37 % of them exceed.
    fn statistic(&self, power: u32, quoted: Quoted) -> f64 {
        if self.var == 0.0 {
            return 1.0;
        }
        match quoted {
            Quoted::Mean => self.mean_power(power),
            Quoted::Survival37 => whole_power(self.ratio_survived(portable::exp(-1.0)), power),
        }
    }

    /// Mean of the ratios to a power.
    fn mean_power(&self, power: u32) -> f64 {
        let (low, high) = self.ends();
        let admitted = self.integral(low, high, 0);
        let powers = self.integral(low, high, power);
        match self.truncation {
            Truncation::Clamp => {
                let below = self.integral(self.widest().0, low, 0);
                (powers + below * whole_power(self.min_ratio, power)) / (admitted + below)
            }
            Truncation::Redraw | Truncation::Symmetric => powers / admitted,
        }
    }

    /// Ratio that the share `p` of all grains exceeds, by bisection.
    fn ratio_survived(&self, p: f64) -> f64 {
        let (low, high) = self.ends();
        let all = match self.truncation {
            Truncation::Clamp => self.integral(self.widest().0, high, 0),
            Truncation::Redraw | Truncation::Symmetric => self.integral(low, high, 0),
        };
        let (mut a, mut b) = (low, high);
        for _ in 0..60 {
            let middle = 0.5 * (a + b);
            if self.integral(middle, high, 0) > p * all { a = middle } else { b = middle }
        }
        0.5 * (a + b)
    }

    /// Smallest and largest ratio of the integration.
    fn ends(&self) -> (f64, f64) {
        let (low, high) = self.widest();
        (self.min_ratio.max(low), self.max_ratio().min(high))
    }

    /// Smallest and largest ratio of the integration for the distribution before truncation.
    fn widest(&self) -> (f64, f64) {
        match self.distribution {
            Distribution::Normal => (1.0 - REACH * self.var, 1.0 + REACH * self.var),
            // the share below the first and the share above the second are 1e-14 each
            Distribution::Weibull => {
                let at = |x: f64| self.weibull_scale() * portable::pow(x, 1.0 / self.m);
                (at(1e-14), at(0.5 * REACH * REACH))
            }
        }
    }

    /// Density of the ratios before truncation, up to a constant factor.
    fn density(&self, ratio: f64) -> f64 {
        match self.distribution {
            Distribution::Normal => {
                let deviate = (ratio - 1.0) / self.var;
                portable::exp(-0.5 * deviate * deviate)
            }
            Distribution::Weibull => {
                let x = ratio / self.weibull_scale();
                portable::pow(x, self.m - 1.0) * portable::exp(-portable::pow(x, self.m))
            }
        }
    }

    /// Integral of the ratio to a power times [`StrengthModel::density`] from `low` to `high`, by Simpson's rule.
    fn integral(&self, low: f64, high: f64, power: u32) -> f64 {
        if high <= low {
            return 0.0;
        }
        let h = (high - low) / INTERVALS as f64;
        let at = |i: usize| {
            let ratio = low + i as f64 * h;
            whole_power(ratio, power) * self.density(ratio)
        };
        let inner: f64 = (1..INTERVALS).map(|i| at(i) * if i % 2 == 1 { 4.0 } else { 2.0 }).sum();
        (at(0) + inner + at(INTERVALS)) * h / 3.0
    }
}

/// The factor and the power in F/d^2 = factor sigma_lim^power (eqs 16, 17).
fn stress_per_strength(criterion: Criterion, e_eff: f64, d: f64) -> (f64, u32) {
    (criterion.limit_force(1.0, d, 0.5 * d, e_eff) / (d * d), criterion.power())
}

/// `x` to a whole power.
fn whole_power(x: f64, power: u32) -> f64 {
    (0..power).fold(1.0, |product, _| product * x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::breakage::criterion::{FixedAngle, HertzArea};
    use crate::breakage::strength::weibull_variation;
    use crate::math::random::lineage_root;

    const E_EFF: f64 = 50e9;

    fn angle() -> Criterion {
        Criterion::FixedAngle(FixedAngle { theta0: 0.35 })
    }

    fn hertz() -> Criterion {
        Criterion::HertzArea(HertzArea)
    }

    fn law(var: f64, truncation: Truncation, min_ratio: f64) -> StrengthModel {
        StrengthModel { sigma_lim0: 1.0, d0: 2e-3, m: 3.0, distribution: Distribution::Normal, var, truncation, min_ratio }
    }

    /// 2·10^5 grains drawn and pressed give the stress that was asked for; standard errors are below 0.4 % at the widest.
    #[test]
    fn grains_that_are_drawn_have_the_crushing_stress_that_was_given() {
        for area in [angle(), hertz()] {
            for (var, truncation, min_ratio) in [
                (0.48, Truncation::Redraw, 0.0),
                (0.48, Truncation::Clamp, 0.3),
                (1.0, Truncation::Redraw, 0.0),
                (0.3, Truncation::Symmetric, 0.1),
                (0.0, Truncation::Redraw, 0.0),
            ] {
                for quoted in [Quoted::Mean, Quoted::Survival37] {
                    for distribution in [Distribution::Normal, Distribution::Weibull] {
                        if var == 0.0 && distribution == Distribution::Weibull {
                            continue;
                        }
                        let mut law = law(var, truncation, min_ratio);
                        if distribution == Distribution::Weibull {
                            (law.distribution, law.var) = (distribution, weibull_variation(law.m));
                        }
                        law.sigma_lim0 = law.sigma_lim0_from(100e6, area, E_EFF, quoted);
                        assert!((law.crushing_stress(area, E_EFF, law.d0, quoted) / 100e6 - 1.0).abs() < 1e-12);
                        let d = law.d0;
                        let force = |i| area.limit_force(law.draw(3, lineage_root(i), d), d, 0.5 * d, E_EFF);
                        let mut stresses: Vec<f64> = (0..200_000).map(|i| force(i) / (d * d)).collect();
                        let found = match quoted {
                            Quoted::Mean => stresses.iter().sum::<f64>() / 2e5,
                            Quoted::Survival37 => {
                                stresses.sort_by(f64::total_cmp);
                                stresses[(2e5 * (1.0 - (-1.0_f64).exp())) as usize]
                            }
                        };
                        assert!((found / 100e6 - 1.0).abs() < 0.015, "{area:?} {law:?} {quoted:?}: {found}");
                    }
                }
            }
        }
    }

    /// The power of size of F/d^2 is -3/m under a fixed angle, and three times that with Hertz's area.
    #[test]
    fn smaller_grains_bear_more_stress() {
        let law = law(0.4, Truncation::Redraw, 0.0);
        for (area, power) in [(angle(), 1.0), (hertz(), 3.0)] {
            let at = |d: f64| law.crushing_stress(area, E_EFF, d, Quoted::Mean);
            assert!((at(0.5e-3) / at(2e-3) / 4.0_f64.powf(power) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_limit_strength_is_many_times_the_crushing_stress() {
        let sharp = law(0.0, Truncation::Redraw, 0.0);
        let sigma = sharp.sigma_lim0_from(100e6, angle(), E_EFF, Quoted::Mean);
        assert!((sigma / 100e6 - 10.83).abs() < 0.01, "{sigma}");
    }
}
