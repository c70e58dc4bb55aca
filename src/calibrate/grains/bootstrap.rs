//! Confidence limits by bootstrap: grains are drawn with replacement within their size class, the
//! law is fitted again, and the 2.5 and 97.5 % quantiles of these fits are the limits. Each
//! resample has its own random stream, so that results do not depend on the number of threads.

use super::likelihood::{Held, Params, Sample};
use super::profile::{Limits, Which};
use super::simulate::{below, generator};
use super::spread::Spread;
use rayon::prelude::*;

/// 95 % limits of ln sigma_lim0, slope and ln shape. `groups`: number of the size class of each
/// grain.
pub fn limits(sample: &Sample, spread: Spread, at: &Params, groups: &[usize], resamples: usize, seed: u64) -> [Limits; 3] {
    let members: Vec<Vec<usize>> =
        (0..=groups.iter().copied().max().unwrap_or(0)).map(|g| (0..groups.len()).filter(|i| groups[*i] == g).collect()).collect();
    let (_, step) = sample.start(spread);
    let fits: Vec<Params> = (0..resamples as u64)
        .into_par_iter()
        .map(|index| {
            let mut rng = generator(seed, index);
            let drawn: Vec<usize> =
                members.iter().flat_map(|m| m.iter().map(|_| m[below(&mut rng, m.len())]).collect::<Vec<_>>()).collect();
            let pick = |values: &[f64]| drawn.iter().map(|&i| values[i]).collect::<Vec<f64>>();
            let censored = drawn.iter().map(|&i| sample.censored[i]).collect();
            let again = Sample { x: pick(&sample.x), ..sample.with(pick(&sample.ln_strength), censored) };
            again.maximise(spread, Held::Nothing, at, &step).0
        })
        .collect();
    let (low, high) = spread.limits();
    [Which::Sigma, Which::Slope, Which::Shape].map(|which| {
        let mut values: Vec<f64> = fits.iter().map(|p| which.of(p, sample)).collect();
        values.sort_by(f64::total_cmp);
        let open = |v: f64| which == Which::Shape && (v < low + 0.02 || v > high - 0.02);
        let limit = |share: f64| Some(table::quantile(&values, share)).filter(|v| v.is_finite() && !open(*v));
        (limit(0.025), limit(0.975))
    })
}
