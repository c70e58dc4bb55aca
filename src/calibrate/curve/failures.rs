//! Tests whether runs fail at large, or at small, values of a parameter, by the rank-sum test of
//! Mann & Whitney (1947, Ann. Math. Stat. 18, 50) of failed against finished runs. If they do, the
//! estimate of that parameter rests on a part of its range only.

use super::parameter::Parameter;
use statrs::distribution::{ContinuousCDF, Normal};

/// Level of significance, for the tests of all parameters together.
const CHANCE: f64 = 0.01;

/// A parameter whose values differ between failed and finished runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Tied {
    /// Index of the parameter.
    pub parameter: usize,
    /// Whether the failed runs have the larger values.
    pub large: bool,
    /// Probability of a difference at least as clear by chance.
    pub probability: f64,
}

/// Parameters whose values differ significantly between failed and finished runs. `runs`: unit
/// coordinates of each run, and whether it finished.
pub fn tied(parameters: usize, runs: &[(Vec<f64>, bool)]) -> Vec<Tied> {
    let told = |t: &Tied| t.probability < CHANCE / parameters as f64;
    (0..parameters).filter_map(|k| rank_sum(k, runs)).filter(told).collect()
}

/// Smallest and largest unit coordinate of each parameter in the finished runs.
pub fn finished(parameters: usize, runs: &[(Vec<f64>, bool)]) -> Vec<[f64; 2]> {
    let ends = |k: usize| {
        let values = runs.iter().filter(|r| r.1).map(|r| r.0[k]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], u| [low.min(u), high.max(u)])
    };
    (0..parameters).map(ends).collect()
}

/// Warning for the user about one such parameter.
pub fn sentence(t: &Tied, parameters: &[Parameter], runs: &[(Vec<f64>, bool)]) -> String {
    let p = &parameters[t.parameter];
    let failed = runs.iter().filter(|r| !r.1).count();
    let [low, high] = finished(parameters.len(), runs)[t.parameter].map(|u| p.rounded(u));
    let side = if t.large { "large" } else { "small" };
    format!(
        "{failed} of {} runs failed, those with {side} {} (chance {:.0e}): finished runs have {low} to {high} of {} to {}; see why they failed in evaluations.csv, \
         and set the bounds where the scene can be run, or change the scene so that it can",
        runs.len(),
        p.key,
        t.probability,
        p.lower,
        p.upper
    )
}

/// The test for one parameter; `None` where all or none failed.
fn rank_sum(k: usize, runs: &[(Vec<f64>, bool)]) -> Option<Tied> {
    let (mut pairs, mut larger) = (0.0, 0.0);
    for (failed, _) in runs.iter().filter(|r| !r.1) {
        for (done, _) in runs.iter().filter(|r| r.1) {
            pairs += 1.0;
            larger += if failed[k] > done[k] {
                1.0
            } else if failed[k] == done[k] {
                0.5
            } else {
                0.0
            };
        }
    }
    if pairs == 0.0 {
        return None;
    }
    // `larger` is nearly normally distributed; ties (between the repeats in the middle) lower its
    // variance, so that the test finds too few differences rather than too many
    let n = runs.len() as f64;
    let deviation = (larger - 0.5 * pairs) / (pairs * (n + 1.0) / 12.0).sqrt();
    let probability = 2.0 * Normal::new(0.0, 1.0).ok()?.cdf(-deviation.abs());
    Some(Tied { parameter: k, large: deviation > 0.0, probability })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::design::latin;
    use crate::curve::stand_in;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn log(finishes: impl Fn(&[f64], f64) -> bool, seed: u64) -> Vec<(Vec<f64>, bool)> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let all = latin(53, 2, &mut rng);
        all.into_iter().map(|u| (finishes(&u, rng.random()), u)).map(|(done, u)| (u, done)).collect()
    }

    #[test]
    fn failures_of_stiff_runs_are_told_with_key_and_side() {
        let runs = log(|u, _| u[1] < 0.3, 1);
        let found = tied(2, &runs);
        assert_eq!(found.iter().map(|t| (t.parameter, t.large)).collect::<Vec<_>>(), [(1, true)]);
        let text = sentence(&found[0], &stand_in::parameters(), &runs);
        assert!(text.contains("large stiffness") && text.contains("37 of 53") || text.contains("38 of 53"), "{text}");
        let [low, high] = finished(2, &runs)[1];
        assert!(low < 0.05 && (0.25..0.3).contains(&high));
        assert!(!tied(2, &log(|u, _| u[0] > 0.2, 2))[0].large);
    }

    /// If runs fail at random, a parameter is named in about one of a hundred calibrations.
    #[test]
    fn failures_by_chance_go_with_nothing() {
        let named = (0..100).filter(|seed| !tied(2, &log(|_, lot| lot < 0.3, 100 + seed)).is_empty()).count();
        assert!(named <= 5, "{named}");
        assert!(tied(2, &log(|_, _| true, 1)).is_empty() && tied(2, &log(|_, _| false, 1)).is_empty());
    }
}
