//! The distribution of strength at one size: the ratio of a grain's strength to the mean at its size, normal with mean 1 and
//! standard deviation `var`, truncated ([`super::strength`] draws from it).

use super::strength::{StrengthModel, Truncation};
use statrs::distribution::{ContinuousCDF, Normal};

impl StrengthModel {
    /// Share of all grains, 0..1, whose ratio is at most `ratio`.
    pub fn share_weaker(&self, ratio: f64) -> f64 {
        if ratio < self.min_ratio {
            return 0.0;
        }
        let Some(normal) = self.normal() else {
            return if ratio < 1.0 { 0.0 } else { 1.0 };
        };
        match self.truncation {
            Truncation::Clamp => normal.cdf(ratio),
            Truncation::Redraw | Truncation::Symmetric => {
                let (below, admitted) = self.admitted(&normal);
                ((normal.cdf(ratio) - below) / admitted).min(1.0)
            }
        }
    }

    /// Ratio, -, below which the share 0 < `p` < 1 of all grains lies.
    pub fn ratio_of_share(&self, p: f64) -> f64 {
        let Some(normal) = self.normal() else { return 1.0 };
        let p = match self.truncation {
            Truncation::Clamp => p,
            Truncation::Redraw | Truncation::Symmetric => {
                let (below, admitted) = self.admitted(&normal);
                below + p * admitted
            }
        };
        normal.inverse_cdf(p).max(self.min_ratio)
    }

    /// Shares of draws that lie below the smallest admitted ratio, and that are admitted.
    fn admitted(&self, normal: &Normal) -> (f64, f64) {
        let below = normal.cdf(self.min_ratio);
        (below, normal.cdf(self.max_ratio()) - below)
    }

    /// `None` without spread.
    fn normal(&self) -> Option<Normal> {
        (self.var > 0.0).then(|| Normal::new(1.0, self.var).ok()).flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::lineage_root;

    fn law(var: f64, truncation: Truncation) -> StrengthModel {
        StrengthModel { sigma_lim0: 1.0, d0: 1.0, m: 3.0, var, truncation, min_ratio: 0.0 }
    }

    /// The share of 10^5 draws below each quantile; its standard error is at most 0.0016.
    #[test]
    fn draws_follow_the_distribution() {
        for (var, truncation) in
            [(1.0, Truncation::Redraw), (1.0, Truncation::Clamp), (0.48, Truncation::Redraw), (1.0, Truncation::Symmetric)]
        {
            let law = law(var, truncation);
            let mut draws: Vec<f64> = (0..100_000).map(|i| law.draw(5, lineage_root(i), 1.0)).collect();
            draws.sort_by(f64::total_cmp);
            for p in [0.05, 0.2, 0.5, 0.8, 0.95] {
                let ratio = law.ratio_of_share(p);
                let share = draws.partition_point(|x| *x <= ratio) as f64 / draws.len() as f64;
                if ratio > 0.0 {
                    assert!((share - p).abs() < 0.006, "{var}, {truncation:?}, {p}: {share}");
                }
                assert!((share - law.share_weaker(ratio)).abs() < 0.006, "{var}, {truncation:?}, {p}: {share}");
            }
        }
    }

    #[test]
    fn without_spread_all_have_the_mean() {
        let law = law(0.0, Truncation::Redraw);
        assert_eq!((law.share_weaker(0.999), law.share_weaker(1.0), law.ratio_of_share(0.05)), (0.0, 1.0, 1.0));
    }
}
