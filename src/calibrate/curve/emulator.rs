//! Emulator: a statistical model of the curves of runs, fast enough to be sampled. The curves are
//! decomposed into a few principal components. The score of each component is a Gaussian process
//! over the parameters (Higdon et al. 2008, J. Am. Stat. Assoc. 103, 570), whose noise is the
//! scatter between seeds.

use super::gp::Gp;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rayon::prelude::*;

/// Share of the runs' variance up to which components are considered, and their largest number.
const SHARE: f64 = 0.9995;
const MOST: usize = 8;
/// Mean square error of predicting runs that are left out, over the variance of the component, from
/// which on the component is dropped: the parameters then hardly influence it. If that holds for
/// all, the first component is kept.
const UNTOLD: f64 = 0.8;
/// Factor on the correlations between the scatter of components. It draws them towards zero,
/// because few runs show them only roughly.
const CORRELATED: f64 = 0.8;

/// Model of the curve as a function of the parameters, in unit coordinates.
#[derive(Clone, Debug)]
pub struct Emulator {
    /// Mean of each output over the runs, and in `scale` the number that it is divided by.
    centre: Vec<f64>,
    scale: Vec<f64>,
    /// Principal components as columns (outputs × components), orthonormal.
    basis: DMatrix<f64>,
    gps: Vec<Gp>,
    /// Covariance of the scores between seeds.
    pub scatter: DMatrix<f64>,
    /// Variance of each scaled output that the components do not hold.
    pub rest: Vec<f64>,
    /// Share of the runs' variance that the components hold.
    pub share: f64,
}

impl Emulator {
    /// Fits an emulator to runs with outputs `y` at the unit coordinates `x`. `scale`: number by
    /// which each output is divided so that outputs are comparable, at best its scatter between
    /// seeds. `None` if the runs do not differ or a process cannot be fitted.
    pub fn fit(x: &[Vec<f64>], y: &[Vec<f64>], scale: &[f64]) -> Option<Emulator> {
        let (n, m) = (y.len(), scale.len());
        let centre: Vec<f64> = (0..m).map(|j| y.iter().map(|run| run[j]).sum::<f64>() / n as f64).collect();
        let scaled = DMatrix::from_fn(n, m, |i, j| (y[i][j] - centre[j]) / scale[j]);
        let eigen = SymmetricEigen::new(scaled.tr_mul(&scaled) / n as f64);
        let mut order: Vec<usize> = (0..m).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let total: f64 = eigen.eigenvalues.iter().filter(|v| **v > 0.0).sum();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let (mut held, mut components) = (0.0, 0);
        while components < MOST.min(m).min(n - 1) && held < SHARE * total {
            held += eigen.eigenvalues[order[components]];
            components += 1;
        }
        let basis = DMatrix::from_fn(m, components, |j, k| eigen.eigenvectors[(j, order[k])]);
        let scores = &scaled * &basis;
        let gps: Option<Vec<Gp>> =
            (0..components).into_par_iter().map(|k| Gp::fit(x, scores.column(k).clone_owned().as_slice())).collect();
        let gps = gps?;
        let told = |k: usize| {
            let square: f64 = gps[k].left_out().iter().map(|v| v * v).sum();
            square < UNTOLD * n as f64 * eigen.eigenvalues[order[k]]
        };
        let mut kept: Vec<usize> = (0..components).filter(|k| told(*k)).collect();
        if kept.is_empty() {
            kept.push(0);
        }
        let (basis, scores) = (basis.select_columns(&kept), scores.select_columns(&kept));
        let gps: Vec<Gp> = kept.iter().map(|k| gps[*k].clone()).collect();
        let held: f64 = kept.iter().map(|k| eigen.eigenvalues[order[*k]]).sum();
        let rest = scaled - &scores * basis.transpose();
        let rest = (0..m).map(|j| rest.column(j).norm_squared() / n as f64).collect();
        Some(Emulator { scatter: scatter(&gps), centre, scale: scale.to_vec(), basis, gps, rest, share: held / total })
    }

    pub fn components(&self) -> usize {
        self.gps.len()
    }

    /// Number by which each output is divided.
    pub fn scale(&self) -> &[f64] {
        &self.scale
    }

    /// Scores of a curve `y` on the components.
    pub fn project(&self, y: &[f64]) -> DVector<f64> {
        self.basis.tr_mul(&DVector::from_vec(self.scaled(y)))
    }

    /// A curve `y` less the mean of the runs, over the scales.
    pub fn scaled(&self, y: &[f64]) -> Vec<f64> {
        y.iter().zip(&self.centre).zip(&self.scale).map(|((y, c), s)| (y - c) / s).collect()
    }

    /// The curve with these scores.
    pub fn curve(&self, scores: &DVector<f64>) -> Vec<f64> {
        let scaled = &self.basis * scores;
        scaled.iter().zip(&self.centre).zip(&self.scale).map(|((v, c), s)| c + s * v).collect()
    }

    /// Covariance of the scores if the outputs have these variances and no correlations.
    pub fn covariance(&self, variance: &[f64]) -> DMatrix<f64> {
        let scaled = DMatrix::from_diagonal(&DVector::from_iterator(
            variance.len(),
            variance.iter().zip(&self.scale).map(|(v, s)| v / (s * s)),
        ));
        self.basis.tr_mul(&(scaled * &self.basis))
    }

    /// Covariance of the scaled outputs from the covariance of the scores.
    pub fn outputs(&self, scores: &DMatrix<f64>) -> DMatrix<f64> {
        &self.basis * scores * self.basis.transpose()
    }

    /// Mean scores at the unit coordinates `u`.
    pub fn mean(&self, u: &[f64]) -> DVector<f64> {
        DVector::from_iterator(self.gps.len(), self.gps.iter().map(|gp| gp.mean(u)))
    }

    /// Mean scores at the unit coordinates `u`, and the variance of each as an error of the
    /// emulator (without the scatter between seeds).
    pub fn predict(&self, u: &[f64]) -> (DVector<f64>, DVector<f64>) {
        let both: Vec<(f64, f64)> = self.gps.iter().map(|gp| gp.predict(u)).collect();
        let n = both.len();
        (DVector::from_iterator(n, both.iter().map(|b| b.0)), DVector::from_iterator(n, both.iter().map(|b| b.1)))
    }

    /// Chooses the next runs: of `candidates`, the `count` after which the curves at the points
    /// `reference` are most certain. They are chosen one by one. Each is the candidate that reduces
    /// the variance at these points most, over the variance of the scatter, given the finished runs
    /// and those chosen before (Cohn 1996, Neural Netw. 9, 1071).
    pub fn choose(&self, candidates: &[Vec<f64>], reference: &[Vec<f64>], count: usize) -> Vec<Vec<f64>> {
        let mut gps = self.gps.clone();
        let mut chosen: Vec<Vec<f64>> = Vec::new();
        for _ in 0..count.min(candidates.len()) {
            let whitened: Vec<Vec<DVector<f64>>> =
                gps.iter().map(|gp| reference.par_iter().map(|r| gp.whitened(r)).collect()).collect();
            let gain = |u: &Vec<f64>| -> f64 { gps.iter().zip(&whitened).map(|(gp, w)| gp.gain(u, reference, w)).sum() };
            let gains: Vec<f64> = candidates.par_iter().map(gain).collect();
            let open = (0..candidates.len()).filter(|i| !chosen.contains(&candidates[*i]));
            let Some(best) = open.max_by(|a, b| gains[*a].total_cmp(&gains[*b]).then(b.cmp(a))) else { break };
            let at = candidates[best].clone();
            gps = gps.iter().map(|gp| gp.with_pending(&at)).collect();
            chosen.push(at);
        }
        chosen
    }
}

/// Covariance of the scores between seeds: variances from the noise of each process, correlations
/// from the differences of left-out runs ([`Gp::left_out`]), times [`CORRELATED`].
fn scatter(gps: &[Gp]) -> DMatrix<f64> {
    let left: Vec<Vec<f64>> = gps.iter().map(Gp::left_out).collect();
    let size = |k: usize| left[k].iter().map(|v| v * v).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    DMatrix::from_fn(gps.len(), gps.len(), |k, l| {
        let together = left[k].iter().zip(&left[l]).map(|(a, b)| a * b).sum::<f64>() / (size(k) * size(l));
        let correlation = if k == l { 1.0 } else { CORRELATED * together };
        correlation * (gps[k].noise() * gps[l].noise()).sqrt()
    })
}
