//! A calibration's test of itself: runs are left out and their curves taken for the measured one, as their parameters are known.

use super::emulator::Emulator;
use super::parameter::Parameter;
use super::posterior::{Measured, Posterior};
use laboratory::scene::Prior;
use rand::Rng;
use statrs::distribution::{Binomial, DiscreteCDF};

/// Parts into which the runs are divided; one is left out at a time.
const PARTS: usize = 6;
/// Walkers, steps before and steps of a chain.
const CHAIN: (usize, usize, usize) = (24, 150, 200);
/// Share of the intervals that should hold, and probability of so few that makes one doubt it.
const LEVEL: f64 = 0.95;
const DOUBT: f64 = 0.01;

/// A run that the emulator saw.
pub struct Run {
    /// Unit coordinates of its parameters.
    pub u: Vec<f64>,
    pub outputs: Vec<f64>,
    /// Whether it is one of those that fill the space between the bounds.
    pub design: bool,
}

/// How often the 95 % intervals held the values that curves were made with.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    pub curves: usize,
    /// Of them, for each parameter.
    pub held: Vec<usize>,
    /// Mean width of the intervals over the bounds, unit coordinates.
    pub width: Vec<f64>,
}

impl LeftOut {
    /// Whether so few intervals hold that they must be taken for too narrow.
    pub fn doubtful(&self, k: usize) -> bool {
        let law = Binomial::new(LEVEL, self.curves as u64).ok();
        law.is_some_and(|law| law.cdf(self.held[k] as u64) < DOUBT)
    }
}

/// Leaves out the runs of the design, a sixth at a time, and finds the parameters of each from its curve and all other runs, with flat
/// priors between the bounds, which is how the design was drawn. `None` where too few runs are left.
pub fn left_out(parameters: &[Parameter], runs: &[Run], scale: &[f64], rng: &mut impl Rng) -> Option<LeftOut> {
    let d = parameters.len();
    let flat: Vec<Parameter> =
        parameters.iter().map(|p| Parameter { key: p.key.clone(), lower: 0.0, upper: 1.0, prior: Prior::Uniform }).collect();
    let targets: Vec<usize> = (0..runs.len()).filter(|i| runs[*i].design).collect();
    let mut found = LeftOut { curves: 0, held: vec![0; d], width: vec![0.0; d] };
    for part in 0..PARTS {
        let out: Vec<usize> = targets.iter().copied().skip(part).step_by(PARTS).collect();
        let kept = (0..runs.len()).filter(|i| !out.contains(i));
        let (x, y): (Vec<_>, Vec<_>) = kept.map(|i| (runs[i].u.clone(), runs[i].outputs.clone())).unzip();
        if x.len() < 3 * d + 2 {
            return None;
        }
        let emulator = Emulator::fit(&x, &y, scale)?;
        for i in out {
            let curve = Measured { sd: vec![0.0; scale.len()], values: runs[i].outputs.clone(), specimens: 1.0 };
            let chain = Posterior::new(&flat, &emulator, &curve, 1.0).sample(CHAIN.0, CHAIN.1, CHAIN.2, 1.0, rng);
            found.curves += 1;
            for k in 0..d {
                let [low, high] = chain.quantiles(k, [0.025, 0.975]);
                found.held[k] += usize::from(low <= runs[i].u[k] && runs[i].u[k] <= high);
                found.width[k] += high - low;
            }
        }
    }
    found.width.iter_mut().for_each(|w| *w /= found.curves as f64);
    (found.curves > 0).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::stand_in::{self, StandIn};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn runs(stand_in: &StandIn, n: usize) -> Vec<Run> {
        let (x, y) = stand_in.runs(n, 5);
        x.into_iter().zip(y).map(|(u, outputs)| Run { u, outputs, design: true }).collect()
    }

    #[test]
    fn intervals_of_runs_that_were_left_out_hold_and_tell_something() {
        let stand_in = StandIn::default();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let all = runs(&stand_in, 40);
        let found = left_out(&stand_in::parameters(), &all, &stand_in.scale(), &mut rng).expect("enough runs");
        assert_eq!(found.curves, 40);
        // 95 % of 40 is 38 ± 1.4
        assert!(found.held.iter().all(|h| *h >= 34), "{found:?}");
        assert!(found.width.iter().all(|w| *w < 0.7), "{found:?}");
        assert!(left_out(&stand_in::parameters(), &all[..8], &stand_in.scale(), &mut rng).is_none());
    }

    #[test]
    fn too_few_that_hold_are_doubted() {
        let found = |held| LeftOut { curves: 40, held: vec![held], width: vec![0.5] };
        assert!(found(33).doubtful(0) && !found(36).doubtful(0) && !found(40).doubtful(0));
    }
}
