//! Numbers that summarise the posterior of a calibration: estimates with intervals and remarks,
//! correlations, bands of the curve.

use super::emulator::Emulator;
use super::left_out::LeftOut;
use super::parameter::Parameter;
use super::posterior::{Chain, Measured, Misfit};
use super::sensitivity::Share;
use nalgebra::DVector;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use table::quantile;

/// Number of draws of the posterior from which the bands are made.
const BAND: usize = 1000;
/// Limits of the width of the 95 % interval over that of the prior: below the first a parameter is
/// called found, below the second narrowed, above it not found.
const FOUND: f64 = 0.35;
const NARROWED: f64 = 0.75;
/// A distance to a bound in unit coordinates, and the share of the draws within this distance above
/// which the value may lie beyond the bound.
const EDGE: (f64, f64) = (0.02, 0.10);
/// Absolute rank correlation above which two parameters are said to be found only together.
const TOGETHER: f64 = 0.8;

/// Estimate of one parameter, in the unit of its key.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Median of the draws.
    pub estimate: f64,
    pub mean: f64,
    pub sd: f64,
    /// 95 % interval.
    pub lower: f64,
    pub upper: f64,
    /// Value of the likeliest draw.
    pub mode: f64,
    /// Smallest and largest value of the parameter in the finished runs.
    pub finished: [f64; 2],
    /// Whether the estimate, an end of its interval or the likeliest value lies outside of the
    /// range of the finished runs.
    pub extrapolated: bool,
    /// Width of the interval over that of the prior.
    pub width_over_prior: f64,
    pub remark: String,
}

/// Median and 95 % bands of the curve at each point of the target; a band has its lower and its
/// upper end.
#[derive(Clone, Debug, Default)]
pub struct Bands {
    pub median: Vec<f64>,
    /// Band of the mean curve of many seeds.
    pub mean: [Vec<f64>; 2],
    /// Band of the curve of a single specimen.
    pub specimen: [Vec<f64>; 2],
}

/// Results of a calibration.
#[derive(Clone, Debug)]
pub struct Findings {
    pub estimates: Vec<Estimate>,
    /// Rank correlations of the draws.
    pub correlations: Vec<Vec<f64>>,
    /// Draws of the posterior, in the units of the keys.
    pub draws: Vec<Vec<f64>>,
    pub bands: Bands,
    pub misfit: Misfit,
    pub inflation: f64,
    pub shares: Vec<Share>,
    /// Share of the scatter between seeds in the variance of single runs over the prior.
    pub seeds_share: f64,
    pub components: usize,
    /// Share of the runs' variance that the components of the emulator hold.
    pub held: f64,
    /// Root mean square scatter between seeds of each block of outputs.
    pub scatter: Vec<f64>,
    /// Test of the intervals with curves whose parameters are known; `None` with too few runs.
    pub left_out: Option<LeftOut>,
}

/// Estimates, intervals and remarks from the draws of `chain`. `finished`: smallest and largest
/// unit coordinate of the finished runs, for each parameter.
pub fn estimates(parameters: &[Parameter], chain: &Chain, correlations: &[Vec<f64>], finished: &[[f64; 2]]) -> Vec<Estimate> {
    parameters
        .iter()
        .enumerate()
        .map(|(k, p)| {
            let values: Vec<f64> = chain.u.iter().map(|u| p.value(u[k])).collect();
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let sd = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
            let [low, middle, high] = chain.quantiles(k, [0.025, 0.5, 0.975]);
            let [prior_low, prior_high] = prior_interval(p);
            let width = (high - low) / (prior_high - prior_low);
            let ends = finished[k];
            let beyond = |u: f64| u < ends[0] || u > ends[1];
            let extrapolated = [low, middle, high, chain.mode()[k]].into_iter().any(beyond);
            let mut remark = remark(parameters, k, width, chain, correlations);
            let runs = format!("runs finished from {} to {} only", p.rounded(ends[0]), p.rounded(ends[1]));
            if beyond(middle) {
                remark = format!("extrapolated, not found: {runs}");
            } else if extrapolated {
                remark += &format!("; the interval is extrapolated in part: {runs}");
            }
            Estimate {
                estimate: p.value(middle),
                mean,
                sd,
                lower: p.value(low),
                upper: p.value(high),
                mode: p.value(chain.mode()[k]),
                finished: ends.map(|u| p.value(u)),
                extrapolated,
                width_over_prior: width,
                remark,
            }
        })
        .collect()
}

/// 95 % interval of a prior in unit coordinates.
fn prior_interval(p: &Parameter) -> [f64; 2] {
    const CELLS: usize = 4000;
    let middles = (0..CELLS).map(|i| (i as f64 + 0.5) / CELLS as f64);
    let weights: Vec<f64> = middles.map(|u| p.log_prior(u).exp()).collect();
    let total: f64 = weights.iter().sum();
    [0.025, 0.975].map(|q| {
        let mut sum = 0.0;
        let at = weights.iter().position(|w| {
            sum += w;
            sum >= q * total
        });
        (at.unwrap_or(CELLS - 1) as f64 + 0.5) / CELLS as f64
    })
}

fn remark(parameters: &[Parameter], k: usize, width: f64, chain: &Chain, correlations: &[Vec<f64>]) -> String {
    let mut text = match width {
        w if w < FOUND => "found".to_string(),
        w if w < NARROWED => "narrowed".to_string(),
        _ => "not found: the curve says hardly more than the prior".to_string(),
    };
    let share = |near: &dyn Fn(f64) -> bool| chain.u.iter().filter(|u| near(u[k])).count() as f64 / chain.u.len() as f64;
    if share(&|u| u < EDGE.0) > EDGE.1 {
        text += "; may lie below the lower bound";
    }
    if share(&|u| u > 1.0 - EDGE.0) > EDGE.1 {
        text += "; may lie above the upper bound";
    }
    for (l, other) in parameters.iter().enumerate() {
        if l != k && correlations[k][l].abs() > TOGETHER {
            let sign = if correlations[k][l] > 0.0 { "the larger" } else { "the smaller" };
            text += &format!("; only together with {}: the larger one, {sign} the other", other.short());
        }
    }
    text
}

/// Rank correlations (Spearman) of the coordinates.
pub fn correlations(chain: &Chain) -> Vec<Vec<f64>> {
    let d = chain.u.first().map_or(0, Vec::len);
    let n = chain.u.len();
    let ranks: Vec<Vec<f64>> = (0..d)
        .map(|k| {
            let mut order: Vec<usize> = (0..n).collect();
            order.sort_by(|a, b| chain.u[*a][k].total_cmp(&chain.u[*b][k]));
            let mut rank = vec![0.0; n];
            for (r, i) in order.into_iter().enumerate() {
                rank[i] = r as f64 - 0.5 * (n as f64 - 1.0);
            }
            rank
        })
        .collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let one = |a: &[f64], b: &[f64]| dot(a, b) / (dot(a, a) * dot(b, b)).sqrt();
    ranks.iter().map(|a| ranks.iter().map(|b| one(a, b)).collect()).collect()
}

/// Median and bands of the curve over draws of the posterior.
pub fn bands(emulator: &Emulator, chain: &Chain, curve: &Measured, rng: &mut impl Rng) -> Bands {
    let m = curve.values.len();
    let lower = emulator.scatter.clone().cholesky().map(|c| c.l());
    let mut normal = |n: usize| DVector::from_fn(n, |_, _| -> f64 { StandardNormal.sample(&mut *rng) });
    let (mut means, mut specimens) = (vec![Vec::new(); m], vec![Vec::new(); m]);
    for u in chain.thinned(BAND) {
        let (mean, variance) = emulator.predict(&u);
        let scores = &mean + variance.map(f64::sqrt).component_mul(&normal(mean.len()));
        let of_seed = match &lower {
            Some(l) => &scores + l * normal(mean.len()),
            None => scores.clone(),
        };
        let rest = normal(m);
        for (j, y) in emulator.curve(&scores).into_iter().enumerate() {
            means[j].push(y);
        }
        for (j, y) in emulator.curve(&of_seed).into_iter().enumerate() {
            specimens[j].push(y + rest[j] * emulator.rest[j].sqrt() * emulator.scale()[j]);
        }
    }
    let at = |all: &mut Vec<Vec<f64>>, q: f64| -> Vec<f64> {
        all.iter_mut()
            .map(|v| {
                v.sort_by(f64::total_cmp);
                quantile(v, q)
            })
            .collect()
    };
    Bands {
        median: at(&mut means, 0.5),
        mean: [at(&mut means, 0.025), at(&mut means, 0.975)],
        specimen: [at(&mut specimens, 0.025), at(&mut specimens, 0.975)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::stand_in;
    use laboratory::scene::Prior;

    #[test]
    fn remarks_tell_found_narrowed_bounded_and_tied() {
        let mut parameters = stand_in::parameters();
        let chain = |f: &dyn Fn(f64) -> [f64; 2]| Chain {
            u: (0..1000).map(|i| f(i as f64 / 999.0).to_vec()).collect(),
            log: vec![0.0; 1000],
            accepted: 0.5,
        };
        let all = |c: &Chain, p: &[Parameter]| estimates(p, c, &correlations(c), &[[0.0, 1.0]; 2]);
        let tied = all(&chain(&|t| [0.5 + 0.1 * t, 1.0 - t]), &parameters);
        assert!(
            tied[0].remark.starts_with("found; only together with stiffness: the larger one, the smaller"),
            "{}",
            tied[0].remark
        );
        assert!(tied[1].remark.starts_with("not found"));
        let edge = all(&chain(&|t| [0.1 * t * t, (37.0 * t).fract() * 0.5 + 0.3]), &parameters);
        assert!(edge[0].remark.contains("below the lower bound"), "{}", edge[0].remark);
        assert!(edge[1].remark.starts_with("narrowed") && (edge[1].estimate - 0.55).abs() < 0.02, "{:?}", edge[1]);
        // no run finished where the draws of the first parameter lie, nor at the upper end of the
        // draws of the second
        let stiff = chain(&|t| [0.6 + 0.1 * t, 0.4 + 0.2 * t]);
        let beyond = estimates(&parameters, &stiff, &correlations(&stiff), &[[0.0, 0.3], [0.1, 0.55]]);
        assert!(beyond[0].extrapolated && beyond[0].remark.starts_with("extrapolated, not found: runs finished from 0 to 0.3"));
        assert!(
            beyond[1].extrapolated && beyond[1].remark.contains("in part: runs finished from 0.1 to 0.55"),
            "{}",
            beyond[1].remark
        );
        assert!(tied.iter().all(|e| !e.extrapolated && !e.remark.contains("extrapolated")));
        // the interval is as wide as that of the narrow prior: the curve has added nothing
        parameters[1].prior = Prior::Normal { mean: 0.5, sd: 0.05 };
        assert!((prior_interval(&parameters[1])[0] - 0.402).abs() < 0.002);
        let same = all(&chain(&|t| [(37.0 * t).fract(), 0.4 + 0.2 * t]), &parameters);
        assert!(same[1].remark.starts_with("not found"), "{:?}", same[1]);
    }
}
