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
            Truncation::Absolute => {
                let mirrored = |power| self.integral_mirrored(low, self.farthest(), power);
                (powers + mirrored(power)) / (admitted + mirrored(0))
            }
            Truncation::Redraw | Truncation::Symmetric => powers / admitted,
            Truncation::MeanPreserving { .. } => powers / admitted / whole_power(self.divisor(), power),
        }
    }

    /// Mean of the ratios before truncation that are not below `least`; `least` itself where there are none.
    pub(super) fn mean_above(&self, least: f64) -> f64 {
        let (low, high) = self.widest();
        let low = low.max(least);
        let above = self.integral(low, high, 0);
        if above > 0.0 { self.integral(low, high, 1) / above } else { least }
    }

    /// Ratio that the share `p` of all grains exceeds, by bisection.
    fn ratio_survived(&self, p: f64) -> f64 {
        let (low, high) = self.ends();
        let above = |ratio: f64| match self.truncation {
            Truncation::Absolute => self.integral(ratio, high, 0) + self.integral_mirrored(ratio, self.farthest(), 0),
            _ => self.integral(ratio, high, 0),
        };
        let all = match self.truncation {
            Truncation::Clamp => self.integral(self.widest().0, high, 0),
            _ => above(low),
        };
        let (mut a, mut b) = (low, high);
        for _ in 0..60 {
            let middle = 0.5 * (a + b);
            if above(middle) > p * all { a = middle } else { b = middle }
        }
        0.5 * (a + b) / self.divisor()
    }

    /// The smallest ratio of the distribution before truncation, mirrored at `min_ratio`.
    fn farthest(&self) -> f64 {
        2.0 * self.min_ratio - self.widest().0
    }

    /// As [`StrengthModel::integral`], of the density of the draws below `min_ratio`, mirrored there.
    fn integral_mirrored(&self, low: f64, high: f64, power: u32) -> f64 {
        self.simpson(low, high, |ratio| whole_power(ratio, power) * self.density(2.0 * self.min_ratio - ratio))
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

    /// Integral of the ratio to a power times [`StrengthModel::density`] from `low` to `high`.
    fn integral(&self, low: f64, high: f64, power: u32) -> f64 {
        self.simpson(low, high, |ratio| whole_power(ratio, power) * self.density(ratio))
    }

    /// Integral of a function from `low` to `high`, by Simpson's rule; 0 where `low` is not below `high`.
    fn simpson(&self, low: f64, high: f64, of: impl Fn(f64) -> f64) -> f64 {
        if high <= low {
            return 0.0;
        }
        let h = (high - low) / INTERVALS as f64;
        let at = |i: usize| of(low + i as f64 * h);
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

    const E_EFF: f64 = 50e9;
    /// Stands for the truncation whose mean is found for each distribution.
    const KEPT: Truncation = Truncation::MeanPreserving { mean: 1.0 };

    fn angle() -> Criterion {
        Criterion::FixedAngle(FixedAngle { theta0: 0.35 })
    }

    fn hertz() -> Criterion {
        Criterion::HertzArea(HertzArea::default())
    }

    fn law(var: f64, truncation: Truncation, min_ratio: f64) -> StrengthModel {
        StrengthModel { sigma_lim0: 1.0, d0: 2e-3, m: 3.0, distribution: Distribution::Normal, var, truncation, min_ratio }
    }

    /// The mean over all shares of the grains, and the strength that 37 % exceed, are those of the distribution that strengths are drawn from.
    #[test]
    fn crushing_stresses_are_those_of_the_distribution_of_strengths() {
        for (var, truncation, min_ratio) in [
            (0.48, Truncation::Redraw, 0.0),
            (0.48, Truncation::Clamp, 0.3),
            (1.0, Truncation::Redraw, 0.0),
            (0.3, Truncation::Symmetric, 0.1),
            (1.0, KEPT, 0.0),
            (0.48, KEPT, 0.3),
            (1.0, Truncation::Absolute, 0.0),
            (0.48, Truncation::Absolute, 0.3),
            (0.0, Truncation::Redraw, 0.0),
        ] {
            let normal = law(var, truncation, min_ratio);
            let weibull = StrengthModel { distribution: Distribution::Weibull, var: weibull_variation(normal.m), ..normal };
            for mut law in [Some(normal), (var > 0.0).then_some(weibull)].into_iter().flatten() {
                if truncation == KEPT {
                    law = law.preserving_mean();
                }
                const SHARES: u32 = 2000;
                let ratios: Vec<f64> = (0..SHARES).map(|i| law.ratio_of_share((f64::from(i) + 0.5) / f64::from(SHARES))).collect();
                for area in [angle(), hertz()] {
                    for quoted in [Quoted::Mean, Quoted::Survival37] {
                        law.sigma_lim0 = law.sigma_lim0_from(100e6, area, E_EFF, quoted);
                        let d = law.d0;
                        assert!((law.crushing_stress(area, E_EFF, d, quoted) / 100e6 - 1.0).abs() < 1e-12);
                        let stress = |ratio: &f64| area.limit_force(law.sigma_lim0 * ratio, d, 0.5 * d, E_EFF) / (d * d);
                        let (found, most) = match quoted {
                            Quoted::Mean => (ratios.iter().map(stress).sum::<f64>() / f64::from(SHARES), 1e-3),
                            Quoted::Survival37 => (stress(&law.ratio_of_share(1.0 - (-1.0_f64).exp())), 1e-6),
                        };
                        assert!((found / 100e6 - 1.0).abs() < most, "{area:?} {law:?} {quoted:?}: {found}");
                    }
                }
            }
        }
    }

    /// Integrals reach eight standard deviations to both sides, or as far as Weibull's share beyond is 1e-14.
    #[test]
    fn integrals_reach_as_far_as_there_are_grains() {
        let normal = law(0.5, Truncation::Redraw, 0.25);
        assert_eq!((normal.widest(), normal.ends()), ((-3.0, 5.0), (0.25, 5.0)));
        assert_eq!(law(0.5, Truncation::Symmetric, 0.25).ends(), (0.25, 1.75));
        let weibull = StrengthModel { distribution: Distribution::Weibull, ..normal };
        let (low, high) = weibull.widest();
        let power = |x: f64| (x / weibull.weibull_scale()).powf(weibull.m);
        assert!((power(low) / 1e-14 - 1.0).abs() < 1e-12 && (power(high) / 32.0 - 1.0).abs() < 1e-12);
        // nothing is between ends that are exchanged; mean square of the normal distribution: 1 + var²
        assert_eq!((normal.integral(2.0, 1.0, 0), normal.integral(1.0, 1.0, 1)), (0.0, 0.0));
        let whole = normal.integral(-3.0, 5.0, 0);
        assert!((whole / (0.5 * (2.0 * std::f64::consts::PI).sqrt()) - 1.0).abs() < 1e-12);
        assert!((normal.integral(-3.0, 5.0, 2) / whole - 1.25).abs() < 1e-11);
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
