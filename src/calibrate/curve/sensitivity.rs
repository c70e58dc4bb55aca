//! Sensitivity of the curve to each parameter: first-order and total Sobol' indices over the prior,
//! of the emulated curve as a whole (Saltelli et al. 2010, Comput. Phys. Commun. 181, 259; for
//! several outputs Gamboa et al. 2014, Electron. J. Stat. 8, 575).

use super::emulator::Emulator;
use super::parameter::Parameter;
use nalgebra::DVector;
use rand::{Rng, RngExt};
use rayon::prelude::*;

/// Points of each of the two samples of the prior.
const POINTS: usize = 2000;

/// Indices of one parameter, as shares of the curve's variance over the prior.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// Share of this parameter alone (first-order index).
    pub first: f64,
    /// Share of this parameter and of all its interactions (total index).
    pub total: f64,
}

/// The indices of every parameter, and the share of the seeds in the variance of a single run.
pub fn sobol(parameters: &[Parameter], emulator: &Emulator, rng: &mut impl Rng) -> (Vec<Share>, f64) {
    let d = parameters.len();
    let mut sample = || -> Vec<Vec<f64>> { (0..POINTS).map(|_| parameters.iter().map(|p| draw(p, rng)).collect()).collect() };
    let (a, b) = (sample(), sample());
    let scores = |points: &[Vec<f64>]| -> Vec<DVector<f64>> { points.par_iter().map(|u| emulator.mean(u)).collect() };
    let (ya, yb) = (scores(&a), scores(&b));
    let n = POINTS as f64;
    let mean = ya.iter().chain(&yb).fold(DVector::zeros(emulator.components()), |s, y| s + y) / (2.0 * n);
    let variance = ya.iter().chain(&yb).map(|y| (y - &mean).norm_squared()).sum::<f64>() / (2.0 * n);
    let shares = (0..d)
        .map(|k| {
            let swapped: Vec<Vec<f64>> = a
                .iter()
                .zip(&b)
                .map(|(a, b)| {
                    let mut u = a.clone();
                    u[k] = b[k];
                    u
                })
                .collect();
            let ys = scores(&swapped);
            let first: f64 = (0..POINTS).map(|i| (&yb[i] - &mean).dot(&(&ys[i] - &ya[i]))).sum::<f64>() / n;
            let total: f64 = (0..POINTS).map(|i| (&ya[i] - &ys[i]).norm_squared()).sum::<f64>() / (2.0 * n);
            let share = |v: f64| if variance > 0.0 { (v / variance).clamp(0.0, 1.0) } else { 0.0 };
            Share { first: share(first), total: share(total) }
        })
        .collect();
    let noise = emulator.scatter.trace();
    (shares, noise / (noise + variance))
}

/// A draw from the prior of one parameter.
fn draw(p: &Parameter, rng: &mut impl Rng) -> f64 {
    // rejection: a uniform draw is accepted with its prior density over the largest one within the
    // bounds
    let highest = match p.prior {
        laboratory::scene::Prior::Normal { mean, .. } => p.log_prior(p.unit(mean.clamp(p.lower, p.upper))),
        _ => 0.0,
    };
    loop {
        let u = rng.random::<f64>();
        if rng.random::<f64>().ln() < p.log_prior(u) - highest {
            return u;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::stand_in::{self, StandIn};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_parameter_without_influence_has_no_share() {
        let stand_in = StandIn::default();
        let (x, mut y) = stand_in.runs(40, 4);
        for (i, u) in x.iter().enumerate() {
            y[i] = stand_in.curve(&[u[0], 0.5], i as u64);
        }
        let emulator = Emulator::fit(&x, &y, &stand_in.scale()).expect("emulator");
        let (shares, seeds) = sobol(&stand_in::parameters(), &emulator, &mut ChaCha8Rng::seed_from_u64(1));
        assert!(shares[0].first > 0.9 && shares[0].total > 0.95, "{shares:?}");
        assert!(shares[1].first < 0.05 && shares[1].total < 0.05, "{shares:?}");
        assert!((0.0..0.3).contains(&seeds), "{seeds}");
    }
}
