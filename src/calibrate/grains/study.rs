//! Recovery study: crushing tests drawn from known parameters by the engine's strength law are
//! calibrated many times. The study counts how often the intervals hold the truth, and compares
//! their width with the width that the Fisher information allows an unbiased estimate (1.96
//! standard errors of Cramér and Rao to either side).

use super::area::Area;
use super::data::Data;
use super::fit::{Estimate, Fit, Intervals, preferred};
use super::simulate::tests;
use super::spread::{Law, Spread};
use engine::breakage::strength::{Distribution, StrengthModel, Truncation};
use engine::material::effective_modulus;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Parameters whose recovery is studied.
pub const PARAMETERS: [&str; 3] = ["sigma_lim0_MPa", "m", "var"];

/// A material whose tests are simulated.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name in tables.
    pub name: &'static str,
    /// Area model.
    pub area: Area,
    /// Distribution of strength from which tests are drawn.
    pub law: StrengthModel,
    /// Diameters of the grains, m.
    pub sizes: Vec<f64>,
}

impl Case {
    fn new(name: &'static str, area: Area, sigma_mpa: f64, m: f64, var: f64) -> Case {
        let law = StrengthModel {
            sigma_lim0: 1e6 * sigma_mpa,
            d0: 2e-3,
            m,
            distribution: Distribution::Normal,
            var,
            truncation: Truncation::Redraw,
            min_ratio: 0.0,
        };
        Case { name, area, law, sizes: [1e-3, 2e-3, 4e-3, 8e-3].to_vec() }
    }

    /// Parameters of Table 3 of Ciantia et al. (2015), platens of steel, at four sizes.
    pub fn all() -> Vec<Case> {
        let hertz = |young: f64| Area::hertz(Some(effective_modulus((young, 0.3), (200e9, 0.3))));
        let (coke, silica) = (0.858e9, 46.8e9);
        vec![
            Case::new("silica, fixed angle", Area::fixed_angle(Some(PI / 24.0)), 5000.0, 3.0, 0.48),
            Case::new("silica, Hertz", hertz(silica), 5000.0, 10.0, 0.48),
            Case::new("coke, fixed angle", Area::fixed_angle(Some(PI / 9.0)), 300.0, 2.0, 1.0),
            Case::new("coke, Hertz", hertz(coke), 200.0, 10.0, 1.0),
        ]
    }

    /// The truth, in the order of [`PARAMETERS`].
    pub fn truth(&self) -> [f64; 3] {
        [1e-6 * self.law.sigma_lim0, self.law.m, self.law.var]
    }

    /// Simulates tests of `grains` grains, shared out evenly over the sizes.
    pub fn simulate(&self, grains: usize, seed: u64) -> Data {
        tests(&self.law, &self.area, &self.sizes, grains / self.sizes.len(), seed)
    }

    /// Widths of 95 % intervals from the Fisher information at the truth, in the order of [`PARAMETERS`].
    pub fn fisher_widths(&self, grains: usize) -> [f64; 3] {
        let data = self.simulate(grains, 0);
        let x = |d: f64| (d / self.law.d0).ln();
        let information = information(Spread::TruncatedNormal, self.law.var.ln(), data.grains.iter().map(|g| x(g.diameter)));
        let variance = inverse_diagonal(information);
        let [sigma, m, var] = self.truth();
        // d sigma = sigma d ln sigma, dm = -m²/3 ds, d var = var d ln var
        let slopes = [sigma, m * m / 3.0, var];
        [0, 1, 2].map(|i| 2.0 * 1.959_964 * slopes[i] * variance[i].sqrt())
    }
}

/// Fisher information of (ln sigma_lim0, s, ln shape) for uncensored grains with the given x = ln(d/d0).
fn information(spread: Spread, ln_shape: f64, x: impl Iterator<Item = f64>) -> [[f64; 3]; 3] {
    // scores of one grain with respect to ln sigma_lim0 and ln shape, by central differences at even quantiles
    const POINTS: u32 = 20_000;
    const H: f64 = 1e-5;
    let law = Law::new(spread, ln_shape);
    let (above, below) = (Law::new(spread, ln_shape + H), Law::new(spread, ln_shape - H));
    let (mut aa, mut at, mut tt) = (0.0, 0.0, 0.0);
    for i in 0..POINTS {
        let z = law.quantile((f64::from(i) + 0.5) / f64::from(POINTS)).ln();
        let a = (law.ln_density(z - H) - law.ln_density(z + H)) / (2.0 * H);
        let t = (above.ln_density(z) - below.ln_density(z)) / (2.0 * H);
        aa += a * a / f64::from(POINTS);
        at += a * t / f64::from(POINTS);
        tt += t * t / f64::from(POINTS);
    }
    let mut sum = [[0.0; 3]; 3];
    for x in x {
        // d ln L / ds = -x d ln L / d ln sigma_lim0
        let one = [[aa, -x * aa, at], [-x * aa, x * x * aa, -x * at], [at, -x * at, tt]];
        for (row, add) in sum.iter_mut().zip(one) {
            for (v, w) in row.iter_mut().zip(add) {
                *v += w;
            }
        }
    }
    sum
}

/// Diagonal of the inverse of a symmetric matrix.
fn inverse_diagonal(m: [[f64; 3]; 3]) -> [f64; 3] {
    let minor = |i: usize, j: usize| m[i][i] * m[j][j] - m[i][j] * m[j][i];
    let det = m[0][0] * minor(1, 2) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    [minor(1, 2) / det, minor(0, 2) / det, minor(0, 1) / det]
}

/// One repeat: the calibration of one simulated set of tests.
#[derive(Clone, Debug)]
pub struct Repeat {
    /// Seed of the simulated tests.
    pub seed: u64,
    /// Estimates with the spread from which the tests were drawn, in the order of [`PARAMETERS`].
    pub estimates: [Estimate; 3],
    /// Estimates with the preferred spread, in the same order.
    pub preferred: [Estimate; 3],
    /// The preferred spread.
    pub preferred_spread: Spread,
}

/// Calibrates one simulated set of tests.
pub fn repeat(case: &Case, grains: usize, seed: u64) -> Repeat {
    let data = case.simulate(grains, seed);
    let mut fits: Vec<Fit> = Spread::ALL.iter().map(|s| Fit::new(&data, case.area, *s, case.law.d0)).collect();
    let best = preferred(&fits).map_or(0, |(i, _)| i);
    let drawn = fits[0].clone().with_intervals(&data, Intervals::Profile);
    let three = |f: &Fit| [f.sigma_lim0_mpa(), f.m(), f.var()];
    let estimates = three(&drawn);
    let preferred_spread = fits[best].spread;
    let preferred = if best == 0 { estimates } else { three(&fits.swap_remove(best).with_intervals(&data, Intervals::Profile)) };
    Repeat { seed, estimates, preferred, preferred_spread }
}

/// Results of all repeats of one case for one parameter.
#[derive(Clone, Debug)]
pub struct Recovery {
    /// Name of the case.
    pub case: &'static str,
    /// Name of the parameter, one of [`PARAMETERS`].
    pub parameter: &'static str,
    /// Value with which the tests were simulated.
    pub truth: f64,
    /// Number of repeats.
    pub repeats: usize,
    /// Repeats whose interval holds the truth.
    pub held: usize,
    /// Repeats whose interval with the preferred spread, whichever it was, holds the truth.
    pub held_preferred: usize,
    /// Repeats with an open limit. They may count as holding the truth, but not towards the mean
    /// width.
    pub open: usize,
    /// Mean of the estimates.
    pub mean: f64,
    /// Mean width of the closed intervals.
    pub width: f64,
    /// Width of the 95 % interval that the Fisher information allows.
    pub fisher_width: f64,
}

/// Makes the repeats of one case, with seeds from `seed` on. `done` is called after each.
pub fn recover(case: &Case, grains: usize, repeats: usize, seed: u64, done: impl Fn() + Sync) -> (Vec<Recovery>, Vec<Repeat>) {
    let all: Vec<Repeat> = (0..repeats as u64)
        .into_par_iter()
        .map(|i| {
            let one = repeat(case, grains, seed + i);
            done();
            one
        })
        .collect();
    let fisher = case.fisher_widths(grains);
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
    let rows = (0..3)
        .map(|k| {
            let truth = case.truth()[k];
            let widths: Vec<f64> = all.iter().filter_map(|r| r.estimates[k].width()).collect();
            Recovery {
                case: case.name,
                parameter: PARAMETERS[k],
                truth,
                repeats,
                held: all.iter().filter(|r| r.estimates[k].estimate.is_some() && r.estimates[k].holds(truth)).count(),
                held_preferred: all.iter().filter(|r| r.preferred[k].estimate.is_some() && r.preferred[k].holds(truth)).count(),
                open: repeats - widths.len(),
                mean: mean(all.iter().filter_map(|r| r.estimates[k].estimate).collect()),
                width: mean(widths),
                fisher_width: fisher[k],
            }
        })
        .collect();
    (rows, all)
}

#[cfg(test)]
mod tests_of_study {
    use super::*;

    #[test]
    fn the_information_of_a_normal_is_known() {
        // mean mu and sd of a normal: n/sd², 2n/sd²; here ln mu (sd = mu var.) and ln var.
        let var: f64 = 0.05;
        let n = 10;
        let found = information(Spread::Normal, var.ln(), std::iter::repeat_n(0.3, n));
        let n = n as f64;
        assert!((found[0][0] / (n * (1.0 / (var * var) + 2.0)) - 1.0).abs() < 3e-3, "{found:?}");
        assert!((found[2][2] / (2.0 * n) - 1.0).abs() < 3e-3);
        assert!((found[0][2] / (2.0 * n) - 1.0).abs() < 3e-2);
        assert!((found[0][1] / found[0][0] + 0.3).abs() < 1e-12);
        assert_eq!(inverse_diagonal([[2.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 5.0]]), [0.5, 0.25, 0.2]);
    }

    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say_and_are_no_wider_than_they_must_be() {
        // 60 repeats: 57 expected inside, standard deviation 1.7; seeds are fixed, so this is no matter of luck
        for (case, seed) in Case::all().iter().zip([10_001, 20_001, 30_001, 40_001]) {
            let (rows, repeats) = recover(case, 500, 60, seed, || ());
            for r in rows {
                assert!((53..=60).contains(&r.held), "{r:?}");
                assert!((0.9..1.3).contains(&(r.width / r.fisher_width)), "{r:?}");
                assert!((r.mean / r.truth - 1.0).abs() < 0.05, "{r:?}");
                assert!(r.open == 0, "{r:?}");
            }
            let right = repeats.iter().filter(|r| r.preferred_spread == Spread::TruncatedNormal).count();
            assert!(right >= 54, "the spread that drew the tests is preferred in {right} of 60");
        }
    }

    #[test]
    fn results_do_not_depend_on_the_number_of_threads() {
        let case = &Case::all()[0];
        let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("pool");
        let [one, three] = [1, 3].map(|n| pool(n).install(|| recover(case, 100, 4, 7, || ())));
        assert_eq!(format!("{one:?}"), format!("{three:?}"));
    }
}
