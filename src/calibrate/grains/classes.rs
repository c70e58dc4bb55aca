//! Strengths for each size, in the usual form of the field (McDowell & Amon 2000; McDowell 2002):
//! sigma = F/d², Weibull's modulus and the stress that 37 % of the grains survive, survival
//! probabilities by mean rank.

use super::data::{Data, line};
use super::fit::Estimate;
use argmin::core::{CostFunction, Error, Executor, State};
use argmin::solver::brent::BrentRoot;
use serde::Serialize;

/// Grains of about one size.
#[derive(Clone, Debug, Serialize)]
pub struct Class {
    /// Geometric mean, mm.
    pub diameter_mm: f64,
    pub smallest_mm: f64,
    pub largest_mm: f64,
    pub grains: usize,
    pub censored: usize,
    /// Mean of the forces of the broken grains, N.
    pub mean_force_n: Option<f64>,
    /// Stress F/d², MPa, that exp(-1) = 37 % survive, by maximum likelihood.
    pub sigma_37_mpa: Estimate,
    /// Weibull's modulus, by maximum likelihood.
    pub modulus: Estimate,
    /// Modulus as read from the straight line of ln ln(1/P_s) against ln sigma.
    pub modulus_line: Option<f64>,
    #[serde(skip)]
    pub members: Vec<usize>,
}

/// Number of the size class of each grain. Where few diameters occur, each is a class. Otherwise
/// the classes are sieve classes whose bounds are a factor √2 apart, shifted so that the sum of the
/// squared counts is largest.
pub fn numbers(data: &Data) -> Vec<usize> {
    const PHASES: u32 = 16;
    let mut sizes: Vec<f64> = data.grains.iter().map(|g| g.diameter).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.dedup_by(|a, b| *a / *b < 1.001);
    if sizes.len() <= 1.max(data.grains.len() / 5) {
        let nth = |d: f64| sizes.partition_point(|s| s * 1.001 <= d).min(sizes.len() - 1);
        return data.grains.iter().map(|g| nth(g.diameter)).collect();
    }
    let steps: Vec<f64> = data.grains.iter().map(|g| 2.0 * (g.diameter / sizes[0]).log2()).collect();
    let mut best = (0, Vec::new());
    for phase in 0..PHASES {
        let numbers = dense(steps.iter().map(|s| (s + f64::from(phase) / f64::from(PHASES)) as usize).collect());
        let full = fullness(&numbers);
        if full > best.0 {
            best = (full, numbers);
        }
    }
    best.1
}

/// Renumbers the classes without gaps.
fn dense(raw: Vec<usize>) -> Vec<usize> {
    let mut used = raw.clone();
    used.sort_unstable();
    used.dedup();
    raw.iter().map(|n| used.partition_point(|u| u < n)).collect()
}

/// Sum of the squared numbers of grains in the classes.
fn fullness(numbers: &[usize]) -> usize {
    let mut counts = vec![0; numbers.iter().max().map_or(0, |n| n + 1)];
    for n in numbers {
        counts[*n] += 1;
    }
    counts.iter().map(|n| n * n).sum()
}

/// The classes of a file, small sizes first.
pub fn classes(data: &Data) -> Vec<Class> {
    let numbers = numbers(data);
    let count = numbers.iter().max().map_or(0, |n| n + 1);
    (0..count).map(|n| class(data, (0..numbers.len()).filter(|i| numbers[*i] == n).collect())).collect()
}

fn class(data: &Data, members: Vec<usize>) -> Class {
    let grains: Vec<_> = members.iter().map(|&i| data.grains[i]).collect();
    let tests: Vec<(f64, bool)> = grains.iter().map(|g| ((1e-6 * g.force / (g.diameter * g.diameter)).ln(), g.censored)).collect();
    let broken: Vec<f64> = grains.iter().filter(|g| !g.censored).map(|g| g.force).collect();
    let n = grains.len() as f64;
    let (sigma_37_mpa, modulus) = weibull(&tests);
    let sizes = grains.iter().map(|g| 1e3 * g.diameter);
    Class {
        diameter_mm: (sizes.clone().map(f64::ln).sum::<f64>() / n).exp(),
        smallest_mm: sizes.clone().fold(f64::INFINITY, f64::min),
        largest_mm: sizes.fold(0.0, f64::max),
        grains: grains.len(),
        censored: grains.len() - broken.len(),
        mean_force_n: (!broken.is_empty()).then(|| broken.iter().sum::<f64>() / broken.len() as f64),
        sigma_37_mpa,
        modulus,
        modulus_line: line_modulus(&tests),
        members,
    }
}

/// Survival probabilities of the broken tests, by mean rank, 1 - i/(n + 1). Tests that ended
/// without breaking raise the ranks after them (Johnson 1964). Input: value, and whether the grain
/// did not break; output: value and probability, sorted by value.
pub fn survival(tests: &[(f64, bool)]) -> Vec<(f64, f64)> {
    let mut sorted = tests.to_vec();
    // at equal values those that broke come first
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let n = sorted.len() as f64;
    let mut rank = 0.0;
    let mut out = Vec::new();
    for (i, &(value, censored)) in sorted.iter().enumerate() {
        if !censored {
            rank += (n + 1.0 - rank) / (1.0 + n - i as f64);
            out.push((value, 1.0 - rank / (n + 1.0)));
        }
    }
    out
}

/// Weibull's modulus as the slope of the line through ln ln(1/P_s); `None` for fewer than three
/// points or a slope that is not positive.
fn line_modulus(tests: &[(f64, bool)]) -> Option<f64> {
    let points: Vec<(f64, f64)> = survival(tests).iter().map(|(x, p)| (*x, (-p.ln()).ln())).collect();
    let (slope, _) = line(&points);
    (points.len() >= 3 && slope > 0.0).then_some(slope)
}

/// Scale and modulus by maximum likelihood, from ln sigma, with limits from the observed information of their logarithms.
fn weibull(tests: &[(f64, bool)]) -> (Estimate, Estimate) {
    let none = (Estimate::default(), Estimate::default());
    let broken: Vec<f64> = tests.iter().filter(|t| !t.1).map(|t| t.0).collect();
    let (low, high) = broken.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    if broken.len() < 3 || high - low < 1e-9 {
        return none;
    }
    let score = Score { tests, broken: &broken };
    let (from, to) = (1e-3 / (high - low), 1e3 / (high - low));
    let solver = BrentRoot::new(from, to, 1e-9 * from);
    let Some(k) = Executor::new(score, solver)
        .configure(|state| state.max_iters(200).param(from))
        .timer(false)
        .run()
        .ok()
        .and_then(|r| r.state().get_best_param().copied())
    else {
        return none;
    };
    let top = tests.iter().fold(f64::NEG_INFINITY, |a, t| a.max(t.0));
    let sum: f64 = tests.iter().map(|t| (k * (t.0 - top)).exp()).sum();
    let ln_scale = top + (sum / broken.len() as f64).ln() / k;
    // second derivatives of -ln L with respect to ln scale and ln k
    let (mut aa, mut ak, mut kk) = (0.0, 0.0, 0.0);
    for t in tests {
        let u = k * (t.0 - ln_scale);
        let w = u.exp();
        aa += k * k * w;
        ak -= k * w * (1.0 + u);
        kk += w * (u + u * u);
        if !t.1 {
            kk -= u;
            ak += k;
        }
    }
    let det = aa * kk - ak * ak;
    if !(det > 0.0 && aa > 0.0) {
        return none;
    }
    let around = |value: f64, variance: f64| {
        let factor = (1.959_964 * variance.sqrt()).exp();
        Estimate { estimate: Some(value), lower: Some(value / factor), upper: Some(value * factor) }
    };
    (around(ln_scale.exp(), kk / det), around(k, aa / det))
}

/// Score equation of Weibull's modulus k: -d ln L / dk per broken grain, with the best scale for
/// each k. Its root is the estimate.
struct Score<'a> {
    tests: &'a [(f64, bool)],
    broken: &'a [f64],
}

impl CostFunction for Score<'_> {
    type Param = f64;
    type Output = f64;

    fn cost(&self, k: &f64) -> Result<f64, Error> {
        let top = self.tests.iter().fold(f64::NEG_INFINITY, |a, t| a.max(t.0));
        let (mut weight, mut first) = (0.0, 0.0);
        for t in self.tests {
            let w = (k * (t.0 - top)).exp();
            weight += w;
            first += w * t.0;
        }
        let mean = self.broken.iter().sum::<f64>() / self.broken.len() as f64;
        Ok(first / weight - mean - 1.0 / k)
    }
}

/// Exponent b of sigma_37 ∝ d^b over the sizes, and the modulus -3/b that follows from it by
/// Weibull's theory of the weakest link; no modulus if larger grains are not weaker.
pub fn size_effect(classes: &[Class]) -> Option<(f64, Option<f64>)> {
    let points: Vec<(f64, f64)> =
        classes.iter().filter_map(|c| Some((c.diameter_mm.ln(), c.sigma_37_mpa.estimate?.ln()))).collect();
    if points.len() < 2 {
        return None;
    }
    let (slope, _) = line(&points);
    Some((slope, (slope < 0.0).then(|| -3.0 / slope)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grains::data::Grain;
    use std::path::PathBuf;

    fn data(grains: Vec<Grain>) -> Data {
        Data { path: PathBuf::new(), grains, series: vec![String::new()], notes: Vec::new() }
    }

    fn grain(diameter: f64, force: f64) -> Grain {
        Grain { diameter, force, censored: false, series: 0 }
    }

    #[test]
    fn modulus_and_37_percent_strength_are_recovered() {
        // quantiles of Weibull with modulus 3.1 and 37 % strength 20 MPa, d = 2 mm
        let n = 400;
        let force = |i: u32| 20e6 * 4e-6 * (-((f64::from(i) + 0.5) / f64::from(n)).ln()).powf(1.0 / 3.1);
        let all = data((0..n).map(|i| grain(2e-3, force(i))).collect());
        let one = &classes(&all)[0];
        assert!((one.sigma_37_mpa.estimate.expect("fitted") / 20.0 - 1.0).abs() < 0.005, "{one:?}");
        assert!((one.modulus.estimate.expect("fitted") / 3.1 - 1.0).abs() < 0.02, "{one:?}");
        assert!((one.modulus_line.expect("line") / 3.1 - 1.0).abs() < 0.05);
        // large-sample standard errors: 0.78 / sqrt(n) of ln modulus, 1.053 / (k sqrt(n)) of ln scale
        let width = |e: Estimate| (e.upper.expect("upper") / e.lower.expect("lower")).ln() / (2.0 * 1.96) * 20.0;
        assert!((width(one.modulus) - 0.78).abs() < 0.03, "{}", width(one.modulus));
        assert!((width(one.sigma_37_mpa) - 1.053 / 3.1).abs() < 0.02);
    }

    #[test]
    fn grains_that_bore_their_force_count() {
        let mut grains: Vec<Grain> = (0..200).map(|i| grain(1e-3, (-((f64::from(i) + 0.5) / 200.0).ln()).powf(0.5))).collect();
        for g in &mut grains {
            if g.force > 1.0 {
                (g.force, g.censored) = (1.0, true);
            }
        }
        let one = &classes(&data(grains))[0];
        assert_eq!(one.censored, 74);
        assert!((one.sigma_37_mpa.estimate.expect("fitted") - 1.0).abs() < 0.02, "{one:?}");
        assert!((one.modulus.estimate.expect("fitted") - 2.0).abs() < 0.05);
    }

    #[test]
    fn ranks_are_means_and_skip_what_did_not_break() {
        let plain = survival(&[(3.0, false), (1.0, false), (2.0, false)]);
        assert_eq!(plain, [(1.0, 0.75), (2.0, 0.5), (3.0, 0.25)]);
        let some = survival(&[(1.0, false), (2.0, true), (3.0, false)]);
        assert_eq!(some.len(), 2);
        assert!((some[1].1 - 0.375).abs() < 1e-12, "{some:?}");
    }

    #[test]
    fn sizes_are_told_apart_or_sieved() {
        let few = data([1e-3, 1e-3, 2e-3, 2.0001e-3, 1e-3, 2e-3, 2e-3, 1e-3, 1e-3, 4e-3].map(|d| grain(d, d)).to_vec());
        // three sizes among ten grains are too many for a class each; sieve classes without grains
        // get no number
        assert_eq!(numbers(&few)[..4], [0, 0, 1, 1]);
        assert_eq!(numbers(&few)[9], 2);
        let more = data([[1e-3; 5], [2e-3; 5], [4e-3; 5]].concat().iter().map(|d| grain(*d, *d)).collect());
        assert_eq!(numbers(&more)[4..6], [0, 1]);
        let spread = data((0..40).map(|i| grain(1e-3 * 1.03_f64.powi(i), 1.0)).collect());
        let n = numbers(&spread);
        assert!(n.windows(2).all(|w| w[1] == w[0] || w[1] == w[0] + 1) && n[39] == 3, "{n:?}");
    }
}
