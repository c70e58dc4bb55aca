//! The likelihood of crushing forces, and its maximum, with all parameters free or one held.
//!
//! Parameters: the logarithm a of the strength at the (geometric) mean size, the slope s = 3/m of strength against size,
//! and the logarithm t of the spread's shape. Sizes are taken relative to the mean size instead of
//! d0, because a and s are then nearly independent; ln sigma_lim0 = a + s x̄, x = ln(d / d0).

use super::area::Area;
use super::data::{Data, line};
use super::spread::{Law, Spread};
use argmin::core::{CostFunction, Error, Executor, State};
use argmin::solver::neldermead::NelderMead;

/// Largest absolute slope that is tried; steeper slopes would not be an effect of size.
pub const STEEPEST: f64 = 60.0;
/// Standard deviation of the costs, -ln L, over the simplex at which a search ends; small beside
/// the 1.92 that bounds an interval.
const TOLERANCE: f64 = 1e-9;
const OUTSIDE: f64 = 1e12;

/// Strengths and sizes in the form that the likelihood needs.
#[derive(Clone, Debug)]
pub struct Sample {
    /// ln sigma, Pa
    pub ln_strength: Vec<f64>,
    /// ln(d/d0) less its mean
    pub x: Vec<f64>,
    pub censored: Vec<bool>,
    /// Mean of ln(d/d0)
    pub x_mean: f64,
    /// Whether there are several sizes, so that s can be found.
    pub sized: bool,
    /// d ln F / d ln sigma
    pub power: f64,
}

impl Sample {
    pub fn new(data: &Data, area: &Area, d0: f64) -> Sample {
        let x: Vec<f64> = data.grains.iter().map(|g| (g.diameter / d0).ln()).collect();
        let x_mean = x.iter().sum::<f64>() / x.len() as f64;
        Sample {
            ln_strength: data.grains.iter().map(|g| area.ln_strength(g.diameter, g.force)).collect(),
            x: x.iter().map(|v| v - x_mean).collect(),
            censored: data.grains.iter().map(|g| g.censored).collect(),
            x_mean,
            sized: !data.one_size(),
            power: area.power(),
        }
    }

    pub fn len(&self) -> usize {
        self.x.len()
    }

    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// The same sizes with other strengths and censoring.
    pub fn with(&self, ln_strength: Vec<f64>, censored: Vec<bool>) -> Sample {
        Sample { ln_strength, censored, ..self.clone() }
    }

    /// ln y of grain `i`: logarithm of its strength over the strength by the law of size.
    pub fn ratio(&self, i: usize, p: &Params) -> f64 {
        self.ln_strength[i] - p.a + p.s * self.x[i]
    }

    /// ln L of ln sigma, which differs from that of the forces by a constant.
    fn core(&self, spread: Spread, p: &Params) -> f64 {
        let law = Law::new(spread, p.t);
        let mut sum = 0.0;
        for i in 0..self.len() {
            let z = self.ratio(i, p);
            sum += if self.censored[i] { law.ln_survival(z) } else { law.ln_density(z) };
        }
        sum
    }

    /// ln L of the forces, N, from `core`, that of ln sigma: the density of each broken grain is
    /// divided by its force and by d ln F / d ln sigma.
    pub fn ln_likelihood(&self, core: f64, data: &Data) -> f64 {
        let jacobian: f64 = data.grains.iter().filter(|g| !g.censored).map(|g| g.force.ln() + self.power.ln()).sum();
        core - jacobian
    }

    /// Start of a search, from least squares of the logarithms, and the size of its first steps
    /// (standard errors).
    pub fn start(&self, spread: Spread) -> (Params, Params) {
        let points: Vec<(f64, f64)> =
            (0..self.len()).filter(|&i| !self.censored[i]).map(|i| (self.x[i], self.ln_strength[i])).collect();
        let n = points.len() as f64;
        let (slope, rest) = line(&points);
        let slope = if self.sized { slope } else { 0.0 };
        let (x, y) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
        let xx = (points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>() / n).sqrt();
        let var = rest.clamp(1e-3, 0.8);
        let at = Params { a: y - slope * x + 0.5 * rest.min(1.0).powi(2), s: -slope, t: spread.near(var) };
        let step = Params { a: rest / n.sqrt(), s: rest / (n.sqrt() * xx.max(1e-3)), t: (0.5 / n).sqrt() };
        (at, step)
    }

    /// Parameters of the largest likelihood with the parameter `held`, and their ln L (of ln
    /// sigma). `step`: size of the first simplex.
    pub fn maximise(&self, spread: Spread, held: Held, from: &Params, step: &Params) -> (Params, f64) {
        let problem = Problem { sample: self, spread, held };
        let mut best = problem.pack(from);
        let step = problem.pack(step);
        let mut cost = problem.value(&best);
        // restarted with a new simplex until a restart gains nothing
        for round in 0..8 {
            let size = if round == 0 { 1.0 } else { 0.3 };
            let mut simplex = vec![best.clone()];
            for (i, width) in step.iter().enumerate() {
                let mut corner = best.clone();
                corner[i] += size * width * if round % 2 == 0 { 1.0 } else { -1.0 };
                simplex.push(corner);
            }
            let before = cost;
            if let Some((at, value)) = search(&problem, simplex)
                && value <= cost
            {
                (best, cost) = (at, value);
            }
            if before - cost < 1e-6 && round > 0 {
                break;
            }
        }
        (problem.unpack(&best), -cost)
    }
}

fn search(problem: &Problem, simplex: Vec<Vec<f64>>) -> Option<(Vec<f64>, f64)> {
    let solver = NelderMead::new(simplex).with_sd_tolerance(TOLERANCE).ok()?;
    let run = Executor::new(problem, solver).configure(|state| state.max_iters(600)).timer(false).run().ok()?;
    let best = run.state().get_best_param()?.clone();
    Some((best, run.state().get_best_cost()))
}

/// Parameters of the likelihood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    /// ln of the strength at the mean size, Pa
    pub a: f64,
    /// 3/m
    pub s: f64,
    /// ln of the spread's shape
    pub t: f64,
}

impl Params {
    /// ln sigma_lim0, Pa
    pub fn ln_sigma(&self, sample: &Sample) -> f64 {
        self.a + self.s * sample.x_mean
    }
}

/// The parameter that a search holds fixed, with its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Held {
    Nothing,
    /// ln sigma_lim0
    Sigma(f64),
    Slope(f64),
    Shape(f64),
}

struct Problem<'a> {
    sample: &'a Sample,
    spread: Spread,
    held: Held,
}

impl Problem<'_> {
    fn pack(&self, p: &Params) -> Vec<f64> {
        let free = match self.held {
            Held::Nothing => vec![p.a, p.s, p.t],
            Held::Sigma(_) => vec![p.s, p.t],
            Held::Slope(_) => vec![p.a, p.t],
            Held::Shape(_) => vec![p.a, p.s],
        };
        if self.sample.sized {
            return free;
        }
        match self.held {
            Held::Nothing => vec![p.a, p.t],
            Held::Sigma(_) => vec![p.t],
            Held::Slope(_) => free,
            Held::Shape(_) => vec![p.a],
        }
    }

    fn unpack(&self, v: &[f64]) -> Params {
        let sized = self.sample.sized;
        let slope = |i: usize| if sized { v[i] } else { 0.0 };
        match self.held {
            Held::Nothing => Params { a: v[0], s: slope(1), t: v[v.len() - 1] },
            Held::Sigma(sigma) => {
                let s = slope(0);
                Params { a: sigma - s * self.sample.x_mean, s, t: v[v.len() - 1] }
            }
            Held::Slope(s) => Params { a: v[0], s, t: v[1] },
            Held::Shape(t) => Params { a: v[0], s: slope(1), t },
        }
    }

    fn value(&self, v: &[f64]) -> f64 {
        let p = self.unpack(v);
        let (low, high) = self.spread.limits();
        if !(p.t >= low && p.t <= high && p.s.abs() <= STEEPEST && p.a.abs() < 200.0) {
            return OUTSIDE;
        }
        let value = -self.sample.core(self.spread, &p);
        if value.is_finite() { value } else { OUTSIDE }
    }
}

impl CostFunction for &Problem<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, v: &Vec<f64>) -> Result<f64, Error> {
        Ok(self.value(v))
    }
}
