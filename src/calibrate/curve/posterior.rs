//! Posterior of the parameters given a measured curve and an emulator of the runs: Bayes' rule,
//! sampled by an ensemble of random walkers (Goodman & Weare 2010, Comm. App. Math. Comp. Sci. 5,
//! 65).

use super::emulator::Emulator;
use super::parameter::Parameter;
use nalgebra::{DMatrix, DVector};
use rand::{Rng, RngExt};
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Largest factor a of a stretch move: the factor z has the density g(z) ∝ 1/√z on 1/a … a.
const STRETCH: f64 = 2.0;
/// Probability of the misfit below which the scene is said not to be able to give the curve.
const DOUBT: f64 = 0.05;

/// Measured curve with its errors.
#[derive(Clone, Debug)]
pub struct Measured {
    pub values: Vec<f64>,
    /// Standard deviation of each value as measured.
    pub sd: Vec<f64>,
    /// Number of specimens over which the curve is averaged.
    pub specimens: f64,
}

/// Posterior density of the parameters given a measured curve.
pub struct Posterior<'a> {
    parameters: &'a [Parameter],
    emulator: &'a Emulator,
    /// Scores of the measured curve.
    scores: DVector<f64>,
    /// Covariance of the scores at given parameters, from the scatter between seeds and the error
    /// of measurement.
    noise: DMatrix<f64>,
}

impl<'a> Posterior<'a> {
    /// `inflation` multiplies the covariance of scatter and measurement.
    pub fn new(parameters: &'a [Parameter], emulator: &'a Emulator, curve: &Measured, inflation: f64) -> Posterior<'a> {
        let variance: Vec<f64> = curve.sd.iter().map(|s| s * s).collect();
        let noise = (&emulator.scatter / curve.specimens + emulator.covariance(&variance)) * inflation;
        Posterior { parameters, emulator, scores: emulator.project(&curve.values), noise }
    }

    /// Logarithm of the density at unit coordinates `u`, up to a constant; the likelihood counts to
    /// the power `heat`.
    pub fn log_density(&self, u: &[f64], heat: f64) -> f64 {
        let prior: f64 = self.parameters.iter().zip(u).map(|(p, u)| p.log_prior(*u)).sum();
        if prior == f64::NEG_INFINITY {
            return prior;
        }
        let (mean, variance) = self.emulator.predict(u);
        let covariance = &self.noise + DMatrix::from_diagonal(&variance);
        let Some(chol) = covariance.cholesky() else { return f64::NEG_INFINITY };
        let off = &self.scores - mean;
        let half_log: f64 = chol.l_dirty().diagonal().iter().map(|d| d.ln()).sum();
        prior - heat * (0.5 * off.dot(&chol.solve(&off)) + half_log)
    }

    /// Samples the density with about `walkers` walkers, an even number and at least 2 (d + 1) for
    /// d parameters. The first `burn` steps of each are discarded, the next `steps` are kept.
    pub fn sample(&self, walkers: usize, burn: usize, steps: usize, heat: f64, rng: &mut impl Rng) -> Chain {
        let d = self.parameters.len();
        let half = (walkers / 2).max(d + 1);
        let density = |u: &Vec<f64>| self.log_density(u, heat);
        // the walkers start at the likeliest of many points in the cube: from improbable places
        // they would need more steps
        let mut start = super::design::latin(16 * half, d, rng);
        let logs: Vec<f64> = start.par_iter().map(density).collect();
        let mut order: Vec<usize> = (0..start.len()).collect();
        order.sort_by(|a, b| logs[*b].total_cmp(&logs[*a]));
        let mut at: Vec<Vec<f64>> = order[..2 * half].iter().map(|i| std::mem::take(&mut start[*i])).collect();
        let mut log: Vec<f64> = at.par_iter().map(density).collect();
        let mut chain = Chain::default();
        let (mut taken, mut moves) = (0_usize, 0_usize);
        for step in 0..burn + steps {
            for side in 0..2 {
                let (own, other) = (side * half, (1 - side) * half);
                // all random numbers are drawn before the densities, which can then be computed in
                // any order
                let drawn: Vec<(Vec<f64>, f64, f64)> = (0..half)
                    .map(|i| {
                        let x = &at[own + i];
                        let (u, factor) = if rng.random::<f64>() < 0.5 {
                            stretched(x, &at[other..other + half], rng)
                        } else {
                            shifted(x, &at[other..other + half], rng)
                        };
                        (u, factor, rng.random::<f64>().ln())
                    })
                    .collect();
                let logs: Vec<f64> = drawn.par_iter().map(|(u, ..)| density(u)).collect();
                for (i, ((u, factor, threshold), new)) in drawn.into_iter().zip(logs).enumerate() {
                    moves += 1;
                    if threshold < factor + new - log[own + i] {
                        taken += 1;
                        at[own + i] = u;
                        log[own + i] = new;
                    }
                }
            }
            if step >= burn {
                chain.u.extend(at.iter().cloned());
                chain.log.extend_from_slice(&log);
            }
        }
        chain.accepted = taken as f64 / moves.max(1) as f64;
        chain
    }
}

/// Stretch move: proposes a place for walker `x` on the line through `x` and one of the other
/// walkers (Goodman & Weare 2010, eq. 7). Returns the place and the logarithm of the factor in the
/// probability of acceptance.
fn stretched(x: &[f64], others: &[Vec<f64>], rng: &mut impl Rng) -> (Vec<f64>, f64) {
    let partner = &others[rng.random_range(0..others.len())];
    let root: f64 = 1.0 + (STRETCH - 1.0) * rng.random::<f64>();
    let z = root * root / STRETCH;
    (x.iter().zip(partner).map(|(x, p)| p + z * (x - p)).collect(), (x.len() as f64 - 1.0) * z.ln())
}

/// Difference move: proposes a place for walker `x`, shifted by a fraction of the difference of two
/// other walkers (ter Braak 2006, Stat. Comput. 16, 239). One move in ten takes the whole
/// difference, so that walkers can change between separate maxima of the density. The logarithm of
/// the factor in the probability of acceptance is 0.
fn shifted(x: &[f64], others: &[Vec<f64>], rng: &mut impl Rng) -> (Vec<f64>, f64) {
    let a = rng.random_range(0..others.len());
    let b = (a + rng.random_range(1..others.len())) % others.len();
    let gamma = if rng.random::<f64>() < 0.1 { 1.0 } else { 2.38 / (2.0 * x.len() as f64).sqrt() };
    let jitter = 1e-4;
    let moved = x
        .iter()
        .zip(others[a].iter().zip(&others[b]))
        .map(|(x, (a, b))| x + gamma * (a - b) + jitter * (rng.random::<f64>() - 0.5));
    (moved.collect(), 0.0)
}

/// Draws `u` in unit coordinates, each with the logarithm `log` of its density.
#[derive(Clone, Debug, Default)]
pub struct Chain {
    pub u: Vec<Vec<f64>>,
    pub log: Vec<f64>,
    /// Share of the proposed moves that were accepted.
    pub accepted: f64,
}

impl Chain {
    /// The draw with the largest density.
    pub fn mode(&self) -> &[f64] {
        let best = (0..self.log.len()).max_by(|a, b| self.log[*a].total_cmp(&self.log[*b]));
        best.map_or(&[], |i| &self.u[i])
    }

    /// `count` of the draws, spread evenly over steps and walkers.
    pub fn thinned(&self, count: usize) -> Vec<Vec<f64>> {
        // with a constant stride the same walkers could recur; multiples of the golden ratio avoid
        // that
        const GOLDEN: f64 = 0.618_033_988_749_895;
        let n = self.u.len();
        (0..count.min(n)).map(|i| self.u[((i as f64 * GOLDEN).fract() * n as f64) as usize].clone()).collect()
    }

    /// Quantiles `q` of coordinate `k`.
    pub fn quantiles<const N: usize>(&self, k: usize, q: [f64; N]) -> [f64; N] {
        let mut values: Vec<f64> = self.u.iter().map(|u| u[k]).collect();
        values.sort_by(f64::total_cmp);
        q.map(|q| table::quantile(&values, q))
    }
}

/// Difference between the measured curve and that of the emulator at given parameters, beside the
/// expected difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    /// Mean over the points of the squared difference over its expected variance: 1 is as expected.
    pub ratio: f64,
    /// Probability of a ratio at least as large if the scene is right.
    pub probability: f64,
}

impl Misfit {
    /// Compares the measured curve with that of the emulator at unit coordinates `u`. The errors of
    /// neighbouring points are correlated. Therefore the ratio is compared with the distribution
    /// χ²/ν whose degrees of freedom ν follow from the correlations and are fewer than the points
    /// (Satterthwaite).
    pub fn at(u: &[f64], emulator: &Emulator, curve: &Measured) -> Misfit {
        let (mean, variance) = emulator.predict(u);
        let scores = &emulator.scatter / curve.specimens + DMatrix::from_diagonal(&variance);
        let mut covariance = emulator.outputs(&scores);
        let measured = emulator.scaled(&curve.values);
        let size: Vec<f64> = curve.sd.iter().zip(emulator.scale()).map(|(sd, s)| sd / s).collect();
        for j in 0..size.len() {
            covariance[(j, j)] += emulator.rest[j] / curve.specimens + size[j] * size[j];
        }
        let predicted = emulator.scaled(&emulator.curve(&mean));
        let m = size.len();
        let mut square = 0.0;
        let mut correlations = 0.0;
        for j in 0..m {
            square += (measured[j] - predicted[j]).powi(2) / covariance[(j, j)] / m as f64;
            for l in 0..m {
                correlations += covariance[(j, l)].powi(2) / (covariance[(j, j)] * covariance[(l, l)]);
            }
        }
        let freedom = (m * m) as f64 / correlations;
        let probability = ChiSquared::new(freedom).map_or(1.0, |c| c.sf(square * freedom));
        Misfit { ratio: square, probability }
    }

    /// Factor on the covariance of scatter and measurement: the ratio if [`DOUBT`] says that the
    /// scene cannot give the curve, else 1.
    pub fn inflation(&self) -> f64 {
        if self.probability < DOUBT { self.ratio.max(1.0) } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::stand_in::{self, StandIn};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// For targets with parameters from the prior and their own scatter, about 95 of 100 intervals
    /// hold the truth.
    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        let stand_in = StandIn::default();
        let parameters = stand_in::parameters();
        let (x, y) = stand_in.runs(60, 1);
        let emulator = Emulator::fit(&x, &y, &stand_in.scale()).expect("emulator");
        let (mut held, mut width) = ([0; 2], [0.0; 2]);
        const TARGETS: usize = 80;
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        for k in 0..TARGETS {
            let truth = [rng.random::<f64>(), rng.random::<f64>()];
            let values = stand_in.curve(&truth, 1000 + k as u64);
            let curve = Measured { sd: vec![0.0; values.len()], values, specimens: 1.0 };
            let chain = Posterior::new(&parameters, &emulator, &curve, 1.0).sample(20, 60, 60, 1.0, &mut rng);
            for p in 0..2 {
                let [low, high] = chain.quantiles(p, [0.025, 0.975]);
                held[p] += usize::from(low <= truth[p] && truth[p] <= high);
                width[p] += (high - low) / TARGETS as f64;
            }
        }
        // 95 % of 80 is 76 ± 2
        assert!(held.iter().all(|h| (70..=80).contains(h)), "{held:?}");
        assert!(width.iter().all(|w| *w < 0.6), "the curve tells something: {width:?}");
    }

    #[test]
    fn a_curve_that_no_parameters_give_is_told_and_one_that_they_give_is_not() {
        let stand_in = StandIn::default();
        let (x, y) = stand_in.runs(40, 2);
        let emulator = Emulator::fit(&x, &y, &stand_in.scale()).expect("emulator");
        let truth = [0.4, 0.6];
        let measured = |values: Vec<f64>| Measured { sd: vec![0.0; values.len()], values, specimens: 1.0 };
        let doubted = (0..40)
            .filter(|k| Misfit::at(&truth, &emulator, &measured(stand_in.curve(&truth, 500 + k))).probability < DOUBT)
            .count();
        assert!(doubted <= 6, "{doubted} of 40 true curves doubted");
        let bent: Vec<f64> = stand_in.curve(&truth, 7).iter().enumerate().map(|(j, y)| y + 0.05 * (j as f64).sin()).collect();
        let misfit = Misfit::at(&truth, &emulator, &measured(bent));
        assert!(misfit.probability < 1e-6 && misfit.inflation() > 3.0, "{misfit:?}");
    }

    /// With a very large error of measurement the draws are those of the prior.
    #[test]
    fn the_walkers_draw_from_the_prior_when_the_curve_says_nothing() {
        let stand_in = StandIn::default();
        let (x, y) = stand_in.runs(20, 3);
        let emulator = Emulator::fit(&x, &y, &stand_in.scale()).expect("emulator");
        let mut parameters = stand_in::parameters();
        parameters[1].prior = laboratory::scene::Prior::Normal { mean: 0.5, sd: 0.1 };
        let values = stand_in.curve(&[0.5, 0.5], 9);
        let curve = Measured { sd: vec![1e4; values.len()], values, specimens: 1.0 };
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let chain = Posterior::new(&parameters, &emulator, &curve, 1.0).sample(40, 100, 2000, 1.0, &mut rng);
        let flat = chain.quantiles(0, [0.1, 0.5, 0.9]);
        let normal = chain.quantiles(1, [0.1587, 0.5, 0.8413]);
        for (found, wanted) in flat.into_iter().chain(normal).zip([0.1, 0.5, 0.9, 0.4, 0.5, 0.6]) {
            assert!((found - wanted).abs() < 0.03, "{flat:?} {normal:?}");
        }
        assert!((0.2..0.95).contains(&chain.accepted));
    }
}
