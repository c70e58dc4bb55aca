//! What a measured curve says about the parameters, given an emulator of the runs: Bayes' rule, sampled by an ensemble of walkers
//! (Goodman & Weare 2010, Comm. App. Math. Comp. Sci. 5, 65).

use super::emulator::Emulator;
use super::parameter::Parameter;
use nalgebra::{DMatrix, DVector};
use rand::{Rng, RngExt};
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Stretch of a move: a in g(z) ∝ 1/√z on 1/a … a.
const STRETCH: f64 = 2.0;
/// Below this probability the curve is said not to be one that the runs can give.
const DOUBT: f64 = 0.05;

/// A measured curve with what it may be off.
#[derive(Clone, Debug)]
pub struct Measured {
    pub values: Vec<f64>,
    /// Standard deviation of each value as measured.
    pub sd: Vec<f64>,
    /// Specimens whose mean the curve is.
    pub specimens: f64,
}

/// The density of the parameters given a curve.
pub struct Posterior<'a> {
    parameters: &'a [Parameter],
    emulator: &'a Emulator,
    scores: DVector<f64>,
    /// Covariance of the scores for given parameters: seeds' scatter and measurement.
    noise: DMatrix<f64>,
}

impl<'a> Posterior<'a> {
    /// `inflation` multiplies the covariance of scatter and measurement.
    pub fn new(parameters: &'a [Parameter], emulator: &'a Emulator, curve: &Measured, inflation: f64) -> Posterior<'a> {
        let variance: Vec<f64> = curve.sd.iter().map(|s| s * s).collect();
        let noise = (&emulator.scatter / curve.specimens + emulator.covariance(&variance)) * inflation;
        Posterior { parameters, emulator, scores: emulator.project(&curve.values), noise }
    }

    /// Logarithm of the density at unit coordinates, up to a constant; the likelihood to the power `heat`.
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

    /// Draws from the density: `walkers` that take `steps` steps each after `burn` others.
    pub fn sample(&self, walkers: usize, burn: usize, steps: usize, heat: f64, rng: &mut impl Rng) -> Chain {
        let d = self.parameters.len();
        let half = (walkers / 2).max(d + 1);
        let density = |u: &Vec<f64>| self.log_density(u, heat);
        // from the best of a spread over the whole cube: a far start costs steps
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
                // all that is random first, so that the densities may be computed in any order
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

/// A walker moved along the line through it and one of the others (Goodman & Weare 2010, eq. 7), and the logarithm of the factor of its
/// acceptance.
fn stretched(x: &[f64], others: &[Vec<f64>], rng: &mut impl Rng) -> (Vec<f64>, f64) {
    let partner = &others[rng.random_range(0..others.len())];
    let root: f64 = 1.0 + (STRETCH - 1.0) * rng.random::<f64>();
    let z = root * root / STRETCH;
    (x.iter().zip(partner).map(|(x, p)| p + z * (x - p)).collect(), (x.len() as f64 - 1.0) * z.ln())
}

/// A walker moved by the difference of two others, now and then by all of it, which takes it from one hill to the next (ter Braak
/// 2006, Stat. Comput. 16, 239).
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

/// Draws in unit coordinates.
#[derive(Clone, Debug, Default)]
pub struct Chain {
    pub u: Vec<Vec<f64>>,
    pub log: Vec<f64>,
    /// Share of the moves that were taken.
    pub accepted: f64,
}

impl Chain {
    /// The draw of the largest density.
    pub fn mode(&self) -> &[f64] {
        let best = (0..self.log.len()).max_by(|a, b| self.log[*a].total_cmp(&self.log[*b]));
        best.map_or(&[], |i| &self.u[i])
    }

    /// `count` of the draws, spread evenly over steps and walkers.
    pub fn thinned(&self, count: usize) -> Vec<Vec<f64>> {
        // multiples of the golden ratio fall into no step with the walkers
        const GOLDEN: f64 = 0.618_033_988_749_895;
        let n = self.u.len();
        (0..count.min(n)).map(|i| self.u[((i as f64 * GOLDEN).fract() * n as f64) as usize].clone()).collect()
    }

    /// Quantiles of one coordinate.
    pub fn quantiles<const N: usize>(&self, k: usize, q: [f64; N]) -> [f64; N] {
        let mut values: Vec<f64> = self.u.iter().map(|u| u[k]).collect();
        values.sort_by(f64::total_cmp);
        q.map(|q| table::quantile(&values, q))
    }
}

/// How the curve compares with the emulator's at given parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    /// Mean square of the differences over their expected variances: 1 is as expected.
    pub ratio: f64,
    /// Probability of a ratio as large as this.
    pub probability: f64,
}

impl Misfit {
    /// Compares a curve with the one at `u`. Neighbouring points are off together; the ratio is taken as χ²/ν with the number
    /// of independent points that their correlations leave (Satterthwaite).
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

    /// What the covariance is multiplied by so that the curve is an expected one; 1 where there is no doubt about it.
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

    /// Targets with parameters from the prior and scatter of their own: their 95 % intervals hold the truth in about 95 of 100.
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

    /// Without a curve that says anything the draws are those of the prior.
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
