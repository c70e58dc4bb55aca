//! Settings against the reference, seed by seed.

use super::Measure;
use super::measure::RunData;
use statrs::distribution::{ContinuousCDF, StudentsT};
use statrs::statistics::Statistics;

/// Confidence of intervals.
const CONFIDENCE: f64 = 0.95;

/// One measure of all runs of a study: for each setting, the reference first, and each seed its components.
#[derive(Clone, Debug)]
pub struct Sample {
    runs: Vec<Vec<Option<Vec<f64>>>>,
    /// Whether seeds change the runs; without them a difference is exact.
    seeded: bool,
}

/// The mean over seeds of a difference, with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// The mean difference with its sign; of a curve, the root of the mean square along it.
    pub mean: f64,
    /// Half the width of the interval of 95 % about it (Student's t); not a number with a single seed.
    pub half_width: f64,
    /// Seeds in the mean.
    pub seeds: usize,
}

/// What an interval says of a tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The whole interval is within the tolerance.
    Within,
    /// The whole interval is outside.
    Outside,
    /// The interval goes across the tolerance: more seeds are needed.
    Open,
}

impl Verdict {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Within => "within",
            Verdict::Outside => "outside",
            Verdict::Open => "open",
        }
    }
}

impl Difference {
    /// From the difference of each seed, all of the same length; `None` without seeds.
    fn of(differences: &[Vec<f64>], seeded: bool) -> Option<Difference> {
        let n = differences.len();
        let length = differences.first()?.len();
        let mean = |k: usize| component(differences, k).mean();
        let size = if length == 1 { mean(0) } else { mean_over(length, |k| mean(k) * mean(k)).sqrt() };
        let half_width = match (n, seeded) {
            (1, true) => f64::NAN,
            (1, false) => 0.0,
            _ => quantile(n - 1) * (mean_over(length, |k| component(differences, k).variance()) / n as f64).sqrt(),
        };
        Some(Difference { mean: size, half_width, seeds: n })
    }

    /// What the interval says of a tolerance.
    pub fn verdict(&self, tolerance: f64) -> Verdict {
        let size = self.mean.abs();
        if size + self.half_width <= tolerance {
            Verdict::Within
        } else if size - self.half_width > tolerance {
            Verdict::Outside
        } else {
            Verdict::Open
        }
    }
}

/// The quantile of Student's t for an interval on both sides.
fn quantile(freedom: usize) -> f64 {
    StudentsT::new(0.0, 1.0, freedom as f64).map_or(f64::NAN, |t| t.inverse_cdf(0.5 + 0.5 * CONFIDENCE))
}

impl Sample {
    /// The measure of all runs, those of the reference first; `None` if no run of the reference has it.
    pub fn of(measure: Measure, runs: &[Vec<Option<RunData>>], seeded: bool) -> Option<Sample> {
        let runs = measure.of(runs);
        let has = runs.first()?.iter().any(Option::is_some);
        has.then_some(Sample { runs, seeded })
    }

    /// The components of the mean over `settings` for each seed that all of them have; `None` for other seeds.
    fn mean_of(&self, settings: &[usize]) -> Vec<Option<Vec<f64>>> {
        let seeds = self.runs[0].len();
        let of_seed = |seed: usize| {
            let mut sum: Option<Vec<f64>> = None;
            for &k in settings {
                let own = self.runs[k][seed].as_ref()?;
                match &mut sum {
                    None => sum = Some(own.clone()),
                    Some(sum) => sum.iter_mut().zip(own).for_each(|(s, x)| *s += x),
                }
            }
            let count = settings.len() as f64;
            sum.map(|sum| sum.into_iter().map(|s| s / count).collect())
        };
        (0..seeds).map(of_seed).collect()
    }

    /// The difference between two means, seed by seed: weights of sets of settings, which sum up to zero.
    pub(super) fn contrast(&self, terms: &[(f64, Vec<usize>)]) -> Option<Difference> {
        let means: Vec<_> = terms.iter().map(|(weight, settings)| (*weight, self.mean_of(settings))).collect();
        let seeds = self.runs[0].len();
        let of_seed = |seed: usize| {
            let mut sum: Vec<f64> = Vec::new();
            for (weight, mean) in &means {
                let own = mean[seed].as_ref()?;
                sum.resize(own.len(), 0.0);
                sum.iter_mut().zip(own).for_each(|(s, x)| *s += weight * x);
            }
            Some(sum)
        };
        let differences: Vec<Vec<f64>> = (0..seeds).filter_map(of_seed).collect();
        Difference::of(&differences, self.seeded)
    }

    /// The difference of a setting from the reference.
    pub fn difference(&self, setting: usize) -> Option<Difference> {
        self.contrast(&[(1.0, vec![setting]), (-1.0, vec![0])])
    }

    /// Standard deviation of the reference over its seeds; of a curve the root of the mean square along it. `None` with a single seed.
    pub fn deviation(&self) -> Option<f64> {
        let values: Vec<Vec<f64>> = self.runs[0].iter().flatten().cloned().collect();
        let length = values.first()?.len();
        (values.len() > 1).then(|| mean_over(length, |k| component(&values, k).variance()).sqrt())
    }
}

/// Component `k` of each.
fn component(all: &[Vec<f64>], k: usize) -> impl Iterator<Item = f64> {
    all.iter().map(move |one| one[k])
}

/// Mean of a number over so many components.
fn mean_over(length: usize, of: impl Fn(usize) -> f64) -> f64 {
    (0..length).map(of).mean()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(runs: Vec<Vec<Option<Vec<f64>>>>) -> Sample {
        Sample { runs, seeded: true }
    }

    #[test]
    fn differences_are_taken_seed_by_seed() {
        // seeds differ by ten times what the setting changes
        let values = [1.0, 2.0, 3.0];
        let of = |shift: [f64; 3]| (0..3).map(|k| Some(vec![values[k] + shift[k]])).collect();
        let both = sample(vec![of([0.0; 3]), of([0.1, 0.11, 0.09])]);
        let found = both.difference(1).expect("seeds");
        // 0.1 ± t(2; 0.975) 0.01/√3
        assert!(
            (found.mean - 0.1).abs() < 1e-12 && (found.half_width - 4.302_652_7 * 0.01 / 3f64.sqrt()).abs() < 1e-6,
            "{found:?}"
        );
        assert!((both.deviation().expect("three") - 1.0).abs() < 1e-12);
        let says = [0.2, 0.1, 0.05].map(|tolerance| found.verdict(tolerance));
        assert_eq!(says, [Verdict::Within, Verdict::Open, Verdict::Outside]);
    }

    #[test]
    fn a_curve_has_the_root_mean_square_of_its_mean_difference() {
        let zero = || Some(vec![0.0, 0.0]);
        let found =
            sample(vec![vec![zero(), zero()], vec![Some(vec![3.0, 5.0]), Some(vec![3.0, -5.0])]]).difference(1).expect("seeds");
        // noise of the second component has no mean, but an interval
        assert!((found.mean - 4.5f64.sqrt()).abs() < 1e-12 && found.half_width > found.mean);
    }

    #[test]
    fn a_seed_that_failed_does_not_count_and_one_seed_has_no_interval() {
        let runs = vec![vec![Some(vec![1.0]), Some(vec![2.0])], vec![Some(vec![1.5]), None]];
        let found = sample(runs.clone()).difference(1).expect("a seed");
        assert!(found.mean == 0.5 && found.half_width.is_nan() && found.seeds == 1);
        assert_eq!(found.verdict(10.0), Verdict::Open);
        let exact = Sample { seeded: false, ..sample(runs) }.difference(1).expect("a run");
        assert_eq!(exact.half_width, 0.0);
        assert!(sample(vec![vec![Some(vec![1.0])], vec![None]]).difference(1).is_none());
    }
}
