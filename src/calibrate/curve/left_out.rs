//! Test of a calibration with its own runs: runs are left out of the emulator, the curve of each is
//! calibrated as if it had been measured, and the intervals are compared with the known parameters
//! of the run.

use super::emulator::Emulator;
use super::parameter::Parameter;
use super::posterior::{Measured, Posterior};
use laboratory::scene::Prior;
use rand::Rng;
use statrs::distribution::{Binomial, DiscreteCDF};

/// Parts into which the runs are divided; one is left out at a time.
const PARTS: usize = 6;
/// Walkers of a chain, steps of each that are discarded at the start, and steps that are kept.
const CHAIN: (usize, usize, usize) = (24, 150, 200);
/// Share of the intervals that should hold the known value, and the probability of the number that
/// do, below which the intervals are taken for too narrow.
const LEVEL: f64 = 0.95;
const DOUBT: f64 = 0.01;

/// Finished run that the emulator of the calibration was fitted to.
pub struct Run {
    /// Unit coordinates of the parameters.
    pub u: Vec<f64>,
    pub outputs: Vec<f64>,
    /// Whether the run belongs to the design that fills the space between the bounds.
    pub design: bool,
}

/// Number of 95 % intervals that held the known parameters, and their widths.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Number of curves that were calibrated.
    pub curves: usize,
    /// Number of these curves whose interval held the known value, for each parameter.
    pub held: Vec<usize>,
    /// Mean width of the intervals in unit coordinates (1: from bound to bound), for each
    /// parameter.
    pub width: Vec<f64>,
}

impl LeftOut {
    /// Whether the intervals of parameter `k` must be taken for too narrow: if 95 % of them held
    /// the known value, so few would do so with a probability below 1 % (binomial).
    pub fn doubtful(&self, k: usize) -> bool {
        let law = Binomial::new(LEVEL, self.curves as u64).ok();
        law.is_some_and(|law| law.cdf(self.held[k] as u64) < DOUBT)
    }
}

/// Leaves out the runs of the design, a sixth at a time, fits an emulator to the other runs, and
/// calibrates the curve of each run that was left out. The priors are uniform in unit coordinates,
/// as the design was drawn. `None` if too few runs remain for an emulator or no run belongs to the
/// design.
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
