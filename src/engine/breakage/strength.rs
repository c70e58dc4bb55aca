//! Strength of one grain: sigma_lim = sigma_lim0 (d / d0)^(-3/m) * ratio (Ciantia et al. 2015, eqs 6, 7, 15). The ratio of a grain is random. Before truncation
//! its mean is 1 and its distribution is
//!
//! - normal with the standard deviation `var` (the paper), or
//! - Weibull's with the modulus m of the size hardening: ratio = (−ln U)^(1/m) / Γ(1 + 1/m), with U uniform in 0..1. The share exp(−(Γ(1 + 1/m) x)^m) of all
//!   grains is stronger than x times the mean.
//!
//! Every grain has a random generator of its own ([`crate::math::random`]), so that its strength does not depend on the order in which grains break.

use super::criterion::size_factor;
use crate::math::portable;
use crate::math::random::{STRENGTH, generator, positive_unit};
use rand_distr::{Distribution as _, StandardNormal};

/// Number of draws after which a grain takes the ratio `min_ratio`; only reached where that is far above 1.
const MAX_REDRAWS: u32 = 4096;

/// What happens to a draw below the smallest admitted ratio, `min_ratio`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Truncation {
    /// It is drawn again. With `min_ratio` 0 and `var` 1 the mean becomes 1.288, the coefficient of variation 0.616.
    Redraw,
    /// It becomes `min_ratio`. With `min_ratio` 0 and `var` 1 the mean becomes 1.083; 15.9 % have no strength at all.
    Clamp,
    /// It is drawn again, and so is a draw above 2 − `min_ratio`: a normal distribution keeps its mean. With `min_ratio` 0 and `var` 1 the coefficient of
    /// variation becomes 0.540.
    Symmetric,
    /// It is drawn again, and what is drawn at last is divided by the mean of such draws: the mean stays the stated one, whatever is cut off. (A shift would
    /// keep the mean as well, but with `min_ratio` 0 it would make negative strengths.) `min_ratio` counts before the division. With `min_ratio` 0 and `var` 1
    /// the coefficient of variation is 0.616, as with `Redraw`.
    MeanPreserving {
        /// Mean of the draws that are not below `min_ratio`, -, as [`StrengthModel::preserving_mean`] finds it.
        mean: f64,
    },
    /// It becomes as far above `min_ratio` as it was below, with `min_ratio` 0 its absolute value. With `min_ratio` 0 and `var` 1 the mean becomes 1.167, the
    /// coefficient of variation 0.685.
    Absolute,
}

/// How the strengths of grains of one size are distributed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    /// Normal with the coefficient of variation `var`.
    Normal,
    /// Weibull's with the modulus `m`.
    Weibull,
}

/// Coefficient of variation of Weibull's distribution of modulus `m`: √(Γ(1 + 2/m)/Γ(1 + 1/m)² − 1).
pub fn weibull_variation(m: f64) -> f64 {
    let ln_gamma = |k: f64| portable::ln_gamma(1.0 + k / m);
    (portable::exp(ln_gamma(2.0) - 2.0 * ln_gamma(1.0)) - 1.0).max(0.0).sqrt()
}

/// Distribution of the limit strengths of grains. `sigma_lim0` and `var` are those before truncation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrengthModel {
    /// Mean limit strength at the reference diameter, Pa.
    pub sigma_lim0: f64,
    /// Reference diameter, multiplied by the scale N, m (eq. 15).
    pub d0: f64,
    /// Modulus of the size hardening, -: the strength goes with d^(-3/m) (eq. 7).
    pub m: f64,
    /// How strengths are distributed.
    pub distribution: Distribution,
    /// Coefficient of variation, -; for Weibull's distribution it must be the one that follows from `m` ([`weibull_variation`]). 0: no spread.
    pub var: f64,
    /// What happens to draws below the smallest admitted ratio.
    pub truncation: Truncation,
    /// Smallest admitted ratio of a strength to the mean at its size, -.
    pub min_ratio: f64,
}

impl StrengthModel {
    /// Limit strength, Pa, of a grain with the diameter `d`, m. `lineage` is the number of the grain that names its random generator
    /// ([`crate::math::random::lineage_child`]).
    pub fn draw(&self, seed: u64, lineage: u64, d: f64) -> f64 {
        self.sigma_lim0 * size_factor(d, self.d0, self.m) * self.ratio(seed, lineage)
    }

    /// Ratio of the grain's strength to the mean strength at its size, -.
    fn ratio(&self, seed: u64, lineage: u64) -> f64 {
        let mut rng = generator(seed, lineage, STRENGTH);
        for _ in 0..MAX_REDRAWS {
            let ratio = match self.distribution {
                Distribution::Normal => {
                    let deviate: f64 = StandardNormal.sample(&mut rng);
                    1.0 + self.var * deviate
                }
                Distribution::Weibull => self.weibull_scale() * portable::pow(-portable::ln(positive_unit(&mut rng)), 1.0 / self.m),
            };
            if ratio >= self.min_ratio && ratio <= self.max_ratio() {
                return ratio / self.divisor();
            }
            match self.truncation {
                Truncation::Clamp => break,
                Truncation::Absolute => return 2.0 * self.min_ratio - ratio,
                Truncation::Redraw | Truncation::Symmetric | Truncation::MeanPreserving { .. } => {}
            }
        }
        self.min_ratio / self.divisor()
    }

    /// Scale of Weibull's distribution with the mean 1: 1/Γ(1 + 1/m). The share 1/e of all grains is stronger.
    pub(super) fn weibull_scale(&self) -> f64 {
        portable::exp(-portable::ln_gamma(1.0 + 1.0 / self.m))
    }

    /// Largest admitted ratio of a strength to the mean at its size, -.
    pub fn max_ratio(&self) -> f64 {
        match self.truncation {
            Truncation::Symmetric => 2.0 - self.min_ratio,
            Truncation::Redraw | Truncation::Clamp | Truncation::MeanPreserving { .. } | Truncation::Absolute => f64::INFINITY,
        }
    }

    /// Smallest ratio that a grain can have, -.
    pub fn least_ratio(&self) -> f64 {
        self.min_ratio / self.divisor()
    }

    /// The same with the truncation [`Truncation::MeanPreserving`].
    pub fn preserving_mean(self) -> Self {
        let mean = if self.var > 0.0 { self.mean_above(self.min_ratio) } else { 1.0 };
        Self { truncation: Truncation::MeanPreserving { mean }, ..self }
    }

    /// The `min_ratio` with which [`StrengthModel::least_ratio`] is `least`, below 1. With [`Truncation::MeanPreserving`] the mean of the draws grows with what is
    /// cut off, but less than that, so that the iteration converges.
    pub fn min_ratio_for(&self, least: f64) -> f64 {
        let again = |min_ratio: f64| least * Self { min_ratio, ..*self }.preserving_mean().divisor();
        match self.truncation {
            Truncation::MeanPreserving { .. } => (0..30).fold(least, |min_ratio, _| again(min_ratio)),
            _ => least,
        }
    }

    /// What admitted draws are divided by, -.
    pub(super) fn divisor(&self) -> f64 {
        match self.truncation {
            Truncation::MeanPreserving { mean } => mean,
            _ => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::{lineage_child, lineage_root, random_perpendicular};

    fn model(var: f64, truncation: Truncation) -> StrengthModel {
        StrengthModel { sigma_lim0: 300e6, d0: 2e-3, m: 2.0, distribution: Distribution::Normal, var, truncation, min_ratio: 0.0 }
    }

    /// Mean and coefficient of variation of 10^5 strengths over the mean strength of their size, and the share of zeros.
    fn statistics(model: StrengthModel) -> (f64, f64, f64) {
        let n = 100_000;
        let d = 5e-3;
        let scale = model.sigma_lim0 * size_factor(d, model.d0, model.m);
        let (mut sum, mut squares, mut zeros) = (0.0, 0.0, 0.0);
        for i in 0..n {
            let ratio = model.draw(7, lineage_root(i), d) / scale;
            assert!(ratio >= 0.0);
            sum += ratio;
            squares += ratio * ratio;
            zeros += f64::from(u8::from(ratio == 0.0));
        }
        let n = f64::from(n);
        let mean = sum / n;
        (mean, (squares / n - mean * mean).sqrt() / mean, zeros / n)
    }

    #[test]
    fn strengths_have_the_moments_of_the_truncated_normal() {
        // Standard error of a mean is below 0.003, of a spread below 0.002.
        for (var, truncation, mean, spread, zeros) in [
            (1.0, Truncation::Redraw, 1.288, 0.616, 0.0),
            (0.48, Truncation::Redraw, 1.022, 0.446, 0.0),
            (1.0, Truncation::Clamp, 1.0833, 0.8004, 0.1587),
            (1.0, Truncation::Symmetric, 1.0, 0.5396, 0.0),
            // folded normal: mean var √(2/π) exp(−1/(2 var²)) + 1 − 2 Φ(−1/var), mean square 1 + var²
            (1.0, Truncation::Absolute, 1.1666, 0.6852, 0.0),
            (0.48, Truncation::Absolute, 1.0065, 0.4632, 0.0),
        ] {
            let found = statistics(model(var, truncation));
            if truncation == Truncation::Redraw {
                // scaled to the stated mean, of the same variation
                let scaled = statistics(model(var, truncation).preserving_mean());
                assert!((scaled.0 - 1.0).abs() < 0.009 && (scaled.1 - found.1).abs() < 1e-9, "{scaled:?}");
            }
            assert!((found.0 - mean).abs() < 0.011, "{found:?}");
            assert!((found.1 - spread).abs() < 0.006, "{found:?}");
            assert!((found.2 - zeros).abs() < 0.006, "{found:?}");
        }
    }

    /// Both ends of a symmetric truncation are as far from the mean, and are reached by no draw.
    #[test]
    fn a_symmetric_truncation_has_the_mean_in_its_middle() {
        let law = StrengthModel { min_ratio: 0.7, ..model(1.0, Truncation::Symmetric) };
        assert!((law.max_ratio() - 1.3).abs() < 1e-15);
        assert_eq!(model(1.0, Truncation::Redraw).max_ratio(), f64::INFINITY);
        let ratios: Vec<f64> = (0..400).map(|i| law.ratio(3, lineage_root(i))).collect();
        assert!(ratios.iter().all(|r| (0.7..=1.3).contains(r)));
        assert!(ratios.iter().any(|r| *r > 1.25) && ratios.iter().any(|r| *r < 0.75));
    }

    /// The mean is the stated one whatever is cut off, and of both distributions. The mean of a normal distribution above a is 1 + var φ(a)/Q(a): for var 0.5 and
    /// ratios above 1 it is 1 + 0.5·√(2/π).
    #[test]
    fn a_scaled_truncation_keeps_the_mean() {
        for min_ratio in [0.0, 0.9] {
            let normal = StrengthModel { min_ratio, ..model(0.7, Truncation::Redraw) };
            let weibull = StrengthModel { distribution: Distribution::Weibull, m: 3.0, var: weibull_variation(3.0), ..normal };
            for law in [normal, weibull] {
                let scaled = law.preserving_mean();
                let [(mean, spread, _), again] = [scaled, law].map(statistics);
                assert!((mean - 1.0).abs() < 0.009, "{scaled:?}: {mean}");
                assert!((spread - again.1).abs() < 1e-9 && (again.0 - scaled.divisor()).abs() < 0.009, "{scaled:?}: {again:?}");
                assert!((scaled.least_ratio() * scaled.divisor() - min_ratio).abs() < 1e-15 && law.least_ratio() == min_ratio);
            }
        }
        let asked = model(1.0, Truncation::Redraw).preserving_mean();
        let given = StrengthModel { min_ratio: asked.min_ratio_for(0.4), ..asked }.preserving_mean();
        assert!((given.least_ratio() - 0.4).abs() < 1e-9 && given.min_ratio > 0.5, "{given:?}");
        assert_eq!(model(1.0, Truncation::Redraw).min_ratio_for(0.4), 0.4);
        let half = StrengthModel { min_ratio: 1.0, ..model(0.5, Truncation::Redraw) }.preserving_mean();
        assert!((half.divisor() - 1.0 - 0.5 * (2.0 / std::f64::consts::PI).sqrt()).abs() < 1e-9, "{half:?}");
        assert_eq!(model(0.0, Truncation::Redraw).preserving_mean().draw(5, 1, 2e-3), 300e6);
    }

    /// Draws below `min_ratio` are mirrored there; the others are those of any other truncation.
    #[test]
    fn an_absolute_truncation_mirrors_what_is_below() {
        let [absolute, clamp] =
            [Truncation::Absolute, Truncation::Clamp].map(|t| StrengthModel { min_ratio: 0.25, ..model(1.0, t) });
        let whole = StrengthModel { min_ratio: -9.0, ..absolute };
        let mut mirrored = 0;
        for i in 0..2000 {
            let [x, c, draw] = [absolute, clamp, whole].map(|law| law.ratio(3, lineage_root(i)));
            assert!((x - 0.25 - (draw - 0.25).abs()).abs() < 1e-14);
            assert_eq!(x == c, draw >= 0.25);
            mirrored += u32::from(draw < 0.25);
        }
        // Φ(−0.75) = 0.2266; standard error 0.0094
        assert!((f64::from(mirrored) / 2000.0 - 0.2266).abs() < 0.03, "{mirrored}");
    }

    /// Mean 1, the variation of the closed form, and 1/e of the draws above the scale.
    #[test]
    fn weibull_draws_have_the_moments_and_quantiles_of_weibull() {
        for m in [1.5, 3.0, 8.0] {
            let law = StrengthModel {
                distribution: Distribution::Weibull,
                m,
                var: weibull_variation(m),
                ..model(1.0, Truncation::Redraw)
            };
            let (mean, spread, _) = statistics(law);
            assert!((mean - 1.0).abs() < 0.009 && (spread - law.var).abs() < 0.009, "{m}: {mean} {spread}");
            let stronger = (0..20_000).filter(|&i| law.ratio(7, lineage_root(i)) > law.weibull_scale()).count();
            assert!((stronger as f64 / 2e4 - (-1.0f64).exp()).abs() < 0.014, "{m}: {stronger}");
        }
        // Rayleigh's distribution: √(4/π − 1)
        assert!((weibull_variation(2.0) - (4.0 / std::f64::consts::PI - 1.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_draw_depends_on_seed_and_lineage_only() {
        let law = model(1.0, Truncation::Redraw);
        let (a, b) = (lineage_root(3), lineage_root(4));
        let before = law.draw(1, lineage_child(a, 5), 5e-3);
        // An unrelated grain breaks first.
        let _ = (0..14).map(|k| law.draw(1, lineage_child(b, k), 3e-3)).collect::<Vec<_>>();
        assert_eq!(before.to_bits(), law.draw(1, lineage_child(a, 5), 5e-3).to_bits());
        assert_ne!(before, law.draw(2, lineage_child(a, 5), 5e-3));
        assert_ne!(before, law.draw(1, lineage_child(a, 6), 5e-3));
    }

    #[test]
    fn without_spread_every_grain_has_the_mean_of_its_size() {
        let law = model(0.0, Truncation::Redraw);
        for d in [1e-3, 2e-3, 9e-3] {
            assert_eq!(law.draw(5, lineage_root(1), d), 300e6 * size_factor(d, 2e-3, 2.0));
        }
        // The mean at four times the reference diameter is an eighth (m = 2).
        assert!((law.draw(5, 1, 8e-3) / 37.5e6 - 1.0).abs() < 1e-13);
    }

    #[test]
    fn a_floor_that_no_draw_reaches_still_ends() {
        // the mean of no draws is not a number to divide by
        let scaled = StrengthModel { min_ratio: 1e6, ..model(1.0, Truncation::Redraw) }.preserving_mean();
        assert_eq!(scaled.draw(1, 1, 2e-3), 300e6);
        let law = StrengthModel { min_ratio: 1e6, ..model(1.0, Truncation::Redraw) };
        assert!((law.draw(1, 1, 2e-3) / (300e6 * 1e6) - 1.0).abs() < 1e-12);
        assert!(model(f64::NAN, Truncation::Redraw).draw(1, 1, 2e-3).is_finite());
    }

    /// Golden values: a change of hash, generator or normal changes every run and must be noticed.
    #[test]
    fn streams_are_frozen() {
        let law = model(1.0, Truncation::Redraw);
        assert_eq!(lineage_root(0), GOLDEN_ROOT);
        assert_eq!(lineage_child(lineage_root(0), 0), GOLDEN_CHILD);
        let drawn = law.draw(1, lineage_root(0), 2e-3);
        let [x, y, z] = random_perpendicular(1, lineage_root(0), [0.0, 0.0, 1.0]);
        assert!((x - 0.883_596_541).abs() < 1e-9 && (y + 0.468_249_028).abs() < 1e-9 && z == 0.0);
        assert!((drawn - GOLDEN_STRENGTH).abs() < 1e-3, "{drawn:.6}");
    }
    const GOLDEN_ROOT: u64 = 0xf755_8d6a_d099_f3e8;
    const GOLDEN_CHILD: u64 = 0xf98f_013a_c9ff_fae1;
    const GOLDEN_STRENGTH: f64 = 245_250_200.592_023;
}
