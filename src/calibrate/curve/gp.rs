//! Gaussian process regression of one noisy output over the unit cube: a linear trend, a Matérn 5/2
//! kernel with a length for each input, and noise. Lengths, signal variance and noise variance are
//! fitted to the data (Rasmussen & Williams 2006, eqs 2.25, 2.26, 4.17, 5.8, 5.12).

use argmin::core::{CostFunction, Executor};
use argmin::solver::neldermead::NelderMead;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Variance of the trend's constant and slopes, over that of the outputs.
const TREND: f64 = 4.0;
/// Normal priors of the logarithms of the lengths (the cube counts as −1 … 1), of the signal
/// variance and of the noise variance: mean and standard deviation.
const LENGTH: (f64, f64) = (0.4, 0.8);
const SIGNAL: (f64, f64) = (-0.5, 1.5);
const NOISE: (f64, f64) = (-3.0, 2.5);
const NOISE_FLOOR: f64 = 1e-6;

/// Logarithms of the kernel's lengths, of the signal variance and of the noise variance, in this
/// order, for standardised outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Hyper(Vec<f64>);

impl Hyper {
    /// Starting points of the fit: long lengths with some noise, and shorter lengths with little
    /// noise.
    fn starts(inputs: usize) -> [Hyper; 2] {
        let start = |length: f64, signal: f64, noise: f64| {
            let mut h = vec![length; inputs];
            h.extend([signal, noise]);
            Hyper(h)
        };
        [start(LENGTH.0, SIGNAL.0, NOISE.0), start(LENGTH.0 - 1.0, SIGNAL.0 + 0.5, NOISE.0 - 2.0)]
    }

    fn signal(&self) -> f64 {
        self.0[self.0.len() - 2].exp()
    }

    fn noise(&self) -> f64 {
        self.0[self.0.len() - 1].exp() + NOISE_FLOOR
    }

    /// Covariance of the outputs at two points of the unit cube, with the trend and without noise.
    fn kernel(&self, a: &[f64], b: &[f64]) -> f64 {
        let (mut square, mut trend) = (0.0, 1.0);
        for (k, (x, y)) in a.iter().zip(b).enumerate() {
            let d = 2.0 * (x - y) * (-self.0[k]).exp();
            square += d * d;
            trend += (2.0 * x - 1.0) * (2.0 * y - 1.0);
        }
        let r = (5.0 * square).sqrt();
        self.signal() * (1.0 + r + r * r / 3.0) * (-r).exp() + TREND * trend
    }

    fn log_prior(&self) -> f64 {
        let n = self.0.len();
        let one = |x: f64, (mean, sd): (f64, f64)| -0.5 * ((x - mean) / sd).powi(2);
        let lengths: f64 = self.0[..n - 2].iter().map(|&x| one(x, LENGTH)).sum();
        lengths + one(self.0[n - 2], SIGNAL) + one(self.0[n - 1], NOISE)
    }
}

/// A fitted process.
#[derive(Clone, Debug)]
pub struct Gp {
    x: Vec<Vec<f64>>,
    hyper: Hyper,
    chol: Cholesky<f64, Dyn>,
    /// K⁻¹ y, with K the covariance of the runs, noise included, and y the standardised outputs.
    weights: DVector<f64>,
    mean: f64,
    scale: f64,
}

fn factor(x: &[Vec<f64>], hyper: &Hyper) -> Option<Cholesky<f64, Dyn>> {
    let n = x.len();
    let mut k = DMatrix::zeros(n, n);
    for i in 0..n {
        for j in 0..=i {
            let v = hyper.kernel(&x[i], &x[j]);
            k[(i, j)] = v;
            k[(j, i)] = v;
        }
        k[(i, i)] += hyper.noise();
    }
    Cholesky::new(k)
}

/// Cost function of the fit: minus the logarithm of the posterior density of the hyperparameters,
/// up to a constant.
struct Cost<'a> {
    x: &'a [Vec<f64>],
    y: &'a DVector<f64>,
}

impl CostFunction for Cost<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, p: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        const WORST: f64 = 1e12;
        if p.iter().any(|v| !v.is_finite() || v.abs() > 20.0) {
            return Ok(WORST);
        }
        let hyper = Hyper(p.clone());
        let Some(chol) = factor(self.x, &hyper) else { return Ok(WORST) };
        let half_log: f64 = chol.l_dirty().diagonal().iter().map(|d| d.ln()).sum();
        let fit = self.y.dot(&chol.solve(self.y));
        Ok(0.5 * fit + half_log - hyper.log_prior())
    }
}

impl Gp {
    /// Fits a process to outputs `y` at points `x` of the unit cube. `None` if the covariance of
    /// the points cannot be factorised.
    pub fn fit(x: &[Vec<f64>], y: &[f64]) -> Option<Gp> {
        let n = y.len() as f64;
        let mean = y.iter().sum::<f64>() / n;
        let sd = (y.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        let scale = if sd > 0.0 { sd } else { 1.0 };
        let standard = DVector::from_iterator(y.len(), y.iter().map(|v| (v - mean) / scale));
        let inputs = x.first().map_or(0, Vec::len);
        let starts = Hyper::starts(inputs);
        let mut best: Option<(f64, Hyper)> = None;
        for start in &starts {
            if let Some((cost, p)) = minimum(Cost { x, y: &standard }, &start.0)
                && best.as_ref().is_none_or(|(c, _)| cost < *c)
            {
                best = Some((cost, Hyper(p)));
            }
        }
        let [smooth, _] = starts;
        let hyper = best.map_or(smooth, |b| b.1);
        let chol = factor(x, &hyper)?;
        let weights = chol.solve(&standard);
        Some(Gp { x: x.to_vec(), hyper, chol, weights, mean, scale })
    }

    /// Variance of the noise, in the unit of the output squared.
    pub fn noise(&self) -> f64 {
        self.hyper.noise() * self.scale * self.scale
    }

    fn cross(&self, at: &[f64]) -> DVector<f64> {
        DVector::from_iterator(self.x.len(), self.x.iter().map(|x| self.hyper.kernel(x, at)))
    }

    /// Mean of the output at a point.
    pub fn mean(&self, at: &[f64]) -> f64 {
        self.mean + self.scale * self.cross(at).dot(&self.weights)
    }

    /// Mean of the output at a point and the variance of that mean (noise not counted).
    pub fn predict(&self, at: &[f64]) -> (f64, f64) {
        let cross = self.cross(at);
        let mean = self.mean + self.scale * cross.dot(&self.weights);
        (mean, self.reduced(at, cross))
    }

    /// Variance of the mean at `at`: the prior variance less what the runs explain; `cross`:
    /// covariances of the point with the runs.
    fn reduced(&self, at: &[f64], cross: DVector<f64>) -> f64 {
        let known = self.solved(cross).norm_squared();
        (self.hyper.kernel(at, at) - known).max(0.0) * self.scale * self.scale
    }

    /// L⁻¹ v, with L Lᵀ the covariance of the runs.
    fn solved(&self, mut v: DVector<f64>) -> DVector<f64> {
        // the solver returns false only for a zero on the diagonal, which a Cholesky factor does
        // not have
        self.chol.l_dirty().solve_lower_triangular_mut(&mut v);
        v
    }

    /// L⁻¹ k, with k the covariances of the point `at` with the runs. [`Gp::gain`] needs this
    /// vector of each reference point.
    pub fn whitened(&self, at: &[f64]) -> DVector<f64> {
        self.solved(self.cross(at))
    }

    /// Reduction of variance at the `reference` points by one more run at `at`, summed over the
    /// points and divided by the variance of the noise. `whitened`: [`Gp::whitened`] of each
    /// reference point.
    pub fn gain(&self, at: &[f64], reference: &[Vec<f64>], whitened: &[DVector<f64>]) -> f64 {
        let own = self.whitened(at);
        let variance = (self.hyper.kernel(at, at) - own.norm_squared()).max(0.0) + self.hyper.noise();
        let taken = reference.iter().zip(whitened).map(|(r, w)| (self.hyper.kernel(at, r) - own.dot(w)).powi(2) / variance);
        taken.sum::<f64>() / self.hyper.noise()
    }

    /// Process with one more run at `at` whose output is not known yet: its variances are valid,
    /// its means are not.
    pub fn with_pending(&self, at: &[f64]) -> Gp {
        let mut x = self.x.clone();
        x.push(at.to_vec());
        match factor(&x, &self.hyper) {
            Some(chol) => Gp { weights: DVector::zeros(x.len()), x, chol, ..self.clone() },
            None => self.clone(),
        }
    }

    /// Difference of each output from its prediction by all other runs, with the same
    /// hyperparameters (eq. 5.12).
    pub fn left_out(&self) -> Vec<f64> {
        let inverse = self.chol.inverse();
        (0..self.x.len()).map(|i| self.scale * self.weights[i] / inverse[(i, i)]).collect()
    }
}

/// Smallest cost and its place, found by Nelder–Mead from a simplex at `start`; `None` if the
/// search fails.
fn minimum(cost: Cost<'_>, start: &[f64]) -> Option<(f64, Vec<f64>)> {
    let mut simplex = vec![start.to_vec()];
    for k in 0..start.len() {
        let mut corner = start.to_vec();
        corner[k] += 1.0;
        simplex.push(corner);
    }
    let solver = NelderMead::new(simplex).with_sd_tolerance(1e-3).ok()?;
    let done = Executor::new(cost, solver).configure(|state| state.max_iters(60 * start.len() as u64)).run().ok()?;
    Some((done.state.best_cost, done.state.best_param?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::design::latin;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn truth(u: &[f64]) -> f64 {
        10.0 + 3.0 * (2.5 * u[0]).sin() + 2.0 * u[1]
    }

    /// A noisy smooth function: the process finds the function, the noise, and says how well it knows the function.
    #[test]
    fn function_noise_and_error_are_found() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let x = latin(60, 3, &mut rng);
        let sd = 0.2;
        let y: Vec<f64> = x
            .iter()
            .map(|u| {
                truth(u)
                    + sd * {
                        let z: f64 = StandardNormal.sample(&mut rng);
                        z
                    }
            })
            .collect();
        let gp = Gp::fit(&x, &y).expect("fit");
        let ratio = gp.noise().sqrt() / sd;
        assert!((0.75..1.3).contains(&ratio), "{ratio}");
        let (mut square, mut inside) = (0.0, 0);
        let test = latin(200, 3, &mut rng);
        for u in &test {
            let (mean, variance) = gp.predict(u);
            square += (mean - truth(u)).powi(2) / 200.0;
            inside += usize::from((mean - truth(u)).abs() < 2.0 * variance.sqrt());
        }
        // the error is well below the noise of one run; about 190 of 200 points lie within two
        // standard deviations
        assert!(square.sqrt() < 0.7 * sd && (176..=200).contains(&inside), "{} {inside}", square.sqrt());
        // the third input has no influence and gets a longer length than the first
        assert!(gp.hyper.0[2] > gp.hyper.0[0]);
    }

    #[test]
    fn left_out_differences_are_those_of_a_process_without_the_point() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let x = latin(12, 2, &mut rng);
        let y: Vec<f64> = x.iter().map(|u| truth(u)).collect();
        let gp = Gp::fit(&x, &y).expect("fit");
        let left = gp.left_out();
        let (k, keep) = (4, |i: &usize| *i != 4);
        let others: Vec<Vec<f64>> = (0..12).filter(keep).map(|i| x[i].clone()).collect();
        let values: Vec<f64> = (0..12).filter(keep).map(|i| (y[i] - gp.mean) / gp.scale).collect();
        let chol = factor(&others, &gp.hyper).expect("factor");
        let weights = chol.solve(&DVector::from_vec(values));
        let cross = DVector::from_iterator(11, others.iter().map(|o| gp.hyper.kernel(o, &x[k])));
        let predicted = gp.mean + gp.scale * cross.dot(&weights);
        assert!((left[k] - (y[k] - predicted)).abs() < 1e-6 * gp.scale, "{} {}", left[k], y[k] - predicted);
    }

    #[test]
    fn a_pending_point_takes_away_the_variance_around_it() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let x = latin(10, 2, &mut rng);
        let y: Vec<f64> = x.iter().map(|u| truth(u)).collect();
        let gp = Gp::fit(&x, &y).expect("fit");
        let at = [0.99, 0.01];
        let (before, after) = (gp.predict(&at).1, gp.with_pending(&at).predict(&at).1);
        assert!(after < 0.5 * before);
        // `gain` equals the variance lost at the point over the variance of the noise
        let gain = gp.gain(&at, &[at.to_vec()], &[gp.whitened(&at)]);
        assert!(((before - after) / gp.noise() / gain - 1.0).abs() < 1e-6, "{before} {after} {gain}");
        // a process can be fitted to constant outputs
        let flat = Gp::fit(&x, &[2.0; 10]).expect("fit");
        assert!((flat.mean(&at) - 2.0).abs() < 1e-9);
    }
}
