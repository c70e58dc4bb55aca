//! Confidence limits by profile likelihood. A value of a parameter lies within the limits if
//! holding the parameter there, with the others at their best, lowers ln L by less than 1.92: half
//! of the 95 % point of chi-squared with one degree of freedom.

use super::likelihood::{Held, Params, STEEPEST, Sample};
use super::spread::Spread;
use argmin::core::{CostFunction, Error, Executor, State};
use argmin::solver::brent::BrentRoot;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::cell::RefCell;

/// Parameter whose interval is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// ln sigma_lim0
    Sigma,
    Slope,
    /// ln of the spread's shape
    Shape,
}

impl Which {
    pub fn of(self, p: &Params, sample: &Sample) -> f64 {
        match self {
            Which::Sigma => p.ln_sigma(sample),
            Which::Slope => p.s,
            Which::Shape => p.t,
        }
    }

    fn held(self, value: f64) -> Held {
        match self {
            Which::Sigma => Held::Sigma(value),
            Which::Slope => Held::Slope(value),
            Which::Shape => Held::Shape(value),
        }
    }

    fn width(self, step: &Params, sample: &Sample) -> f64 {
        match self {
            Which::Sigma => step.a.hypot(step.s * sample.x_mean),
            Which::Slope => step.s,
            Which::Shape => step.t,
        }
    }

    /// Values beyond which a limit counts as open.
    fn range(self, at: f64, spread: Spread) -> (f64, f64) {
        match self {
            Which::Sigma => (at - 25.0, at + 25.0),
            Which::Slope => (-STEEPEST, STEEPEST),
            Which::Shape => spread.limits(),
        }
    }
}

/// Lower and upper limit of ln sigma_lim0, the slope or ln shape; `None` (open) if ln L does not
/// fall far enough within the range of the parameter, or only with the shape at an end of its
/// range.
pub type Limits = (Option<f64>, Option<f64>);

/// 95 % limits of the parameter `which`, or, as the error, parameters with a larger ln L than `top`
/// that the search has come upon, and that ln L. `at` are the fitted parameters, `top` their ln L.
pub fn limits(sample: &Sample, spread: Spread, at: &Params, top: f64, which: Which) -> Result<Limits, (Params, f64)> {
    let loss = ChiSquared::new(1.0).map_or(3.841_459, |c| c.inverse_cdf(0.95)) / 2.0;
    let (_, step) = sample.start(spread);
    let search = Search { sample, spread, which, top, loss, step };
    Ok((search.side(at, -1.0)?, search.side(at, 1.0)?))
}

struct Search<'a> {
    sample: &'a Sample,
    spread: Spread,
    which: Which,
    top: f64,
    loss: f64,
    step: Params,
}

impl Search<'_> {
    fn side(&self, at: &Params, side: f64) -> Result<Option<f64>, (Params, f64)> {
        let centre = self.which.of(at, self.sample);
        let width = self.which.width(&self.step, self.sample).max(1e-6);
        let (low, high) = self.which.range(centre, self.spread);
        let (mut inside, mut near, mut reach) = (centre, *at, 2.0 * width);
        loop {
            let value = (inside + side * reach).clamp(low, high);
            if value == inside {
                return Ok(None);
            }
            let (p, l) = self.profile(value, &near);
            if l > self.top + 1e-3 {
                return Err((p, l));
            }
            if self.top - l > self.loss {
                let root = self.root(inside, value, near, 2e-3 * width);
                let (p, _) = self.profile(root, &near);
                return Ok(Some(root).filter(|_| self.which == Which::Shape || self.free(&p)));
            }
            (inside, near) = (value, p);
            reach *= 1.5;
        }
    }

    /// Whether the shape is away from the ends of its range. At an end, the range and not the data
    /// would bound the other parameters.
    fn free(&self, p: &Params) -> bool {
        let (low, high) = self.spread.limits();
        p.t > low + 0.02 && p.t < high - 0.02
    }

    fn profile(&self, value: f64, near: &Params) -> (Params, f64) {
        self.sample.maximise(self.spread, self.which.held(value), near, &self.step)
    }

    /// Value at which ln L has fallen by `loss`, between a value inside of the limits and one
    /// outside.
    fn root(&self, inside: f64, outside: f64, near: Params, tolerance: f64) -> f64 {
        let problem = Crossing { search: self, near: RefCell::new(near) };
        let solver = BrentRoot::new(inside.min(outside), inside.max(outside), tolerance);
        let run = Executor::new(problem, solver).configure(|state| state.max_iters(60).param(inside)).timer(false).run();
        run.ok().and_then(|r| r.state().get_best_param().copied()).unwrap_or(outside)
    }
}

struct Crossing<'a, 'b> {
    search: &'a Search<'b>,
    near: RefCell<Params>,
}

impl CostFunction for Crossing<'_, '_> {
    type Param = f64;
    type Output = f64;

    fn cost(&self, value: &f64) -> Result<f64, Error> {
        let near = *self.near.borrow();
        let (p, l) = self.search.profile(*value, &near);
        let loss = self.search.top - l;
        // the next maximisation starts from these parameters, unless their likelihood is far too
        // small
        if loss < 10.0 * self.search.loss {
            *self.near.borrow_mut() = p;
        }
        Ok(loss - self.search.loss)
    }
}
