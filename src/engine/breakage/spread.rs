//! Quantiles of the distribution that [`super::strength`] draws from: of the ratio of a grain's strength to the mean strength at its size.

use super::strength::{Distribution, StrengthModel, Truncation};
use statrs::distribution::{ContinuousCDF, Normal, Weibull};

impl StrengthModel {
    /// Share of all grains, 0..1, with a ratio of at most `ratio`.
    pub fn share_weaker(&self, ratio: f64) -> f64 {
        let ratio = ratio * self.divisor();
        if ratio < self.min_ratio {
            return 0.0;
        }
        let Some(whole) = self.untruncated() else {
            return if ratio < 1.0 { 0.0 } else { 1.0 };
        };
        match self.truncation {
            Truncation::Clamp => whole.cdf(ratio),
            Truncation::Absolute => self.share_mirrored(&*whole, ratio),
            Truncation::Redraw | Truncation::Symmetric | Truncation::MeanPreserving { .. } => {
                let (below, admitted) = self.admitted(&*whole);
                ((whole.cdf(ratio) - below) / admitted).min(1.0)
            }
        }
    }

    /// Ratio, -, that the share `p` of all grains does not exceed; 0 < `p` < 1.
    pub fn ratio_of_share(&self, p: f64) -> f64 {
        let Some(whole) = self.untruncated() else { return 1.0 };
        let p = match self.truncation {
            Truncation::Clamp => p,
            Truncation::Absolute => return self.mirrored_of_share(&*whole, p),
            Truncation::Redraw | Truncation::Symmetric | Truncation::MeanPreserving { .. } => {
                let (below, admitted) = self.admitted(&*whole);
                below + p * admitted
            }
        };
        whole.inverse_cdf(p).max(self.min_ratio) / self.divisor()
    }

    /// Share of the ratios, with those below `min_ratio` mirrored there, of at most `ratio`.
    fn share_mirrored(&self, whole: &dyn ContinuousCDF<f64, f64>, ratio: f64) -> f64 {
        whole.cdf(ratio) - whole.cdf(2.0 * self.min_ratio - ratio)
    }

    /// The inverse of [`StrengthModel::share_mirrored`], by bisection from the quantile of the distribution before truncation on, which is never larger.
    fn mirrored_of_share(&self, whole: &dyn ContinuousCDF<f64, f64>, p: f64) -> f64 {
        let (mut a, mut b) = (self.min_ratio, whole.inverse_cdf(p).max(self.min_ratio));
        while self.share_mirrored(whole, b) < p {
            (a, b) = (b, 2.0 * b + 1.0);
        }
        for _ in 0..100 {
            let middle = 0.5 * (a + b);
            if self.share_mirrored(whole, middle) < p { a = middle } else { b = middle }
        }
        0.5 * (a + b)
    }

    /// Share of the distribution before truncation below the smallest admitted ratio, and share that is admitted.
    fn admitted(&self, whole: &dyn ContinuousCDF<f64, f64>) -> (f64, f64) {
        let below = whole.cdf(self.min_ratio);
        (below, whole.cdf(self.max_ratio()) - below)
    }

    /// The distribution before truncation; `None` where it has no spread.
    fn untruncated(&self) -> Option<Box<dyn ContinuousCDF<f64, f64>>> {
        if self.var <= 0.0 {
            return None;
        }
        Some(match self.distribution {
            Distribution::Normal => Box::new(Normal::new(1.0, self.var).ok()?),
            Distribution::Weibull => Box::new(Weibull::new(self.m, self.weibull_scale()).ok()?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::lineage_root;

    fn law(var: f64, truncation: Truncation) -> StrengthModel {
        StrengthModel { sigma_lim0: 1.0, d0: 1.0, m: 3.0, distribution: Distribution::Normal, var, truncation, min_ratio: 0.0 }
    }

    /// Stands for the truncation whose mean is found for each distribution.
    const KEPT: Truncation = Truncation::MeanPreserving { mean: 1.0 };

    fn with_its_mean(law: StrengthModel) -> StrengthModel {
        if law.truncation == KEPT { law.preserving_mean() } else { law }
    }

    /// The share of 20 000 draws below each quantile; its standard error is at most 0.0036.
    #[test]
    fn draws_follow_the_distribution() {
        for (var, truncation, min_ratio) in [
            (1.0, Truncation::Redraw, 0.0),
            (1.0, Truncation::Clamp, 0.0),
            (0.48, Truncation::Redraw, 0.0),
            (1.0, Truncation::Symmetric, 0.0),
            (1.0, KEPT, 0.0),
            (0.7, KEPT, 0.4),
            (1.0, Truncation::Absolute, 0.0),
            (0.7, Truncation::Absolute, 0.4),
        ] {
            let normal = StrengthModel { min_ratio, ..law(var, truncation) };
            let weibull = StrengthModel { distribution: Distribution::Weibull, min_ratio: min_ratio.max(0.1), ..normal };
            for law in [normal, weibull].map(with_its_mean) {
                let mut draws: Vec<f64> = (0..20_000).map(|i| law.draw(5, lineage_root(i), 1.0)).collect();
                draws.sort_by(f64::total_cmp);
                for p in [0.05, 0.2, 0.5, 0.8, 0.95] {
                    let ratio = law.ratio_of_share(p);
                    let share = draws.partition_point(|x| *x <= ratio) as f64 / draws.len() as f64;
                    if ratio > law.least_ratio() {
                        assert!((share - p).abs() < 0.013, "{var}, {truncation:?}, {p}: {share}");
                    }
                    assert!((share - law.share_weaker(ratio)).abs() < 0.013, "{var}, {truncation:?}, {p}: {share}");
                }
            }
        }
    }

    /// Share and quantile are each other's inverse, whatever is cut off; no grain is below the smallest ratio, and with `Clamp` many have just that.
    #[test]
    fn share_and_ratio_are_inverse() {
        for truncation in [Truncation::Redraw, Truncation::Clamp, Truncation::Symmetric, KEPT, Truncation::Absolute] {
            let normal = StrengthModel { min_ratio: 0.6, ..law(0.5, truncation) };
            for law in [normal, StrengthModel { distribution: Distribution::Weibull, ..normal }].map(with_its_mean) {
                // divided by the mean of the draws, all ratios are smaller
                let scale = law.divisor();
                assert_eq!(scale > 1.05, truncation == KEPT);
                let smallest = 0.6 / scale;
                let least = law.share_weaker(smallest * (1.0 + 1e-15));
                for p in [0.01, 0.3, 0.5, 0.7, 0.99] {
                    let ratio = law.ratio_of_share(p);
                    assert!(ratio >= smallest && ratio <= law.max_ratio());
                    assert!((law.share_weaker(ratio) - p.max(least)).abs() < 1e-8, "{law:?} {p}");
                }
                assert_eq!(law.share_weaker(0.999 * smallest), 0.0);
                assert_eq!(least > 0.1, truncation == Truncation::Clamp);
                assert!(law.share_weaker(1.4001) <= 1.0);
                assert_eq!(law.share_weaker(1.4001) == 1.0, truncation == Truncation::Symmetric);
            }
        }
        // mirrored at 0 with var 1: the share Φ(0) − Φ(−2) is below 1
        let folded = law(1.0, Truncation::Absolute);
        assert!((folded.share_weaker(1.0) - 0.477_249_868).abs() < 1e-8);
        assert!((folded.ratio_of_share(0.477_249_868) - 1.0).abs() < 1e-7);
        // closed forms without truncation: Φ(1) of the normal distribution, and 1 - 1/e at the scale of Weibull's
        let normal = StrengthModel { min_ratio: -9.0, ..law(0.5, Truncation::Redraw) };
        assert!((normal.share_weaker(1.5) - 0.841_344_746).abs() < 1e-8);
        let weibull = StrengthModel { distribution: Distribution::Weibull, min_ratio: 0.0, ..normal };
        assert!((weibull.share_weaker(weibull.weibull_scale()) - 1.0 + (-1.0_f64).exp()).abs() < 1e-12);
    }

    #[test]
    fn without_spread_all_have_the_mean() {
        let law = law(0.0, Truncation::Redraw);
        assert_eq!((law.share_weaker(0.999), law.share_weaker(1.0), law.ratio_of_share(0.05)), (0.0, 1.0, 1.0));
    }
}
