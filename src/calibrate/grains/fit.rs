//! One law of strength fitted to the tests: its likelihood, criteria, parameters and their intervals.

use super::area::Area;
use super::bootstrap;
use super::classes;
use super::data::Data;
use super::likelihood::{Held, Params, Sample};
use super::profile::{self, Limits, Which};
use super::spread::{Law, Spread};
use serde::Serialize;

/// A value with its 95 % limits; `None` for what the data do not determine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Estimate {
    /// The value.
    pub estimate: Option<f64>,
    /// Lower 95 % limit.
    pub lower: Option<f64>,
    /// Upper 95 % limit.
    pub upper: Option<f64>,
}

impl Estimate {
    fn new(at: f64, (lower, upper): Limits, map: impl Fn(f64) -> f64) -> Estimate {
        let map = |v: f64| Some(map(v)).filter(|v| v.is_finite());
        Estimate { estimate: map(at), lower: lower.and_then(map), upper: upper.and_then(map) }
    }

    /// Whether the limits enclose a value; an open limit encloses everything on its side.
    pub fn holds(&self, value: f64) -> bool {
        self.lower.is_none_or(|l| l <= value) && self.upper.is_none_or(|u| u >= value)
    }

    /// Upper less lower limit.
    pub fn width(&self) -> Option<f64> {
        Some(self.upper? - self.lower?)
    }
}

/// Method by which intervals are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Intervals {
    /// By the profile likelihood.
    Profile,
    /// By resampling the tests.
    Bootstrap {
        /// Number of resamples.
        resamples: usize,
        /// Seed of the resampling.
        seed: u64,
    },
}

/// A fitted law.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The area model.
    pub area: Area,
    /// The kind of spread.
    pub spread: Spread,
    /// The parameters of largest likelihood.
    pub at: Params,
    /// The tests in the form that the likelihood needs.
    pub sample: Sample,
    /// ln of the likelihood of the forces, N
    pub ln_likelihood: f64,
    /// 95 % limits of ln sigma_lim0, s and ln shape.
    limits: [Limits; 3],
}

/// Akaike's and Schwarz's criteria: the smaller, the better.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Criteria {
    /// Akaike's criterion.
    pub aic: f64,
    /// AIC corrected for few grains.
    pub aicc: Option<f64>,
    /// Schwarz's criterion.
    pub bic: f64,
}

impl Fit {
    /// Fits one law by maximum likelihood, without intervals.
    pub fn new(data: &Data, area: Area, spread: Spread, d0: f64) -> Fit {
        let sample = Sample::new(data, &area, d0);
        let (start, step) = sample.start(spread);
        let (at, core) = sample.maximise(spread, Held::Nothing, &start, &step);
        let ln_likelihood = sample.ln_likelihood(core, data);
        Fit { area, spread, at, sample, ln_likelihood, limits: [(None, None); 3] }
    }

    /// The fit with 95 % intervals. If the profile comes upon parameters of a larger likelihood,
    /// the fit moves there.
    pub fn with_intervals(mut self, data: &Data, how: Intervals) -> Fit {
        if let Intervals::Bootstrap { resamples, seed } = how {
            let groups = classes::numbers(data);
            self.limits = bootstrap::limits(&self.sample, self.spread, &self.at, &groups, resamples, seed);
            if !self.sample.sized {
                self.limits[1] = (None, None);
            }
            return self;
        }
        for _ in 0..4 {
            match self.profile(data) {
                Ok(limits) => {
                    self.limits = limits;
                    break;
                }
                Err((near, _)) => {
                    let (_, step) = self.sample.start(self.spread);
                    let (at, core) = self.sample.maximise(self.spread, Held::Nothing, &near, &step);
                    (self.at, self.ln_likelihood) = (at, self.sample.ln_likelihood(core, data));
                }
            }
        }
        self
    }

    fn profile(&self, data: &Data) -> Result<[Limits; 3], (Params, f64)> {
        let top = self.ln_likelihood - self.sample.ln_likelihood(0.0, data);
        let limits = |which| profile::limits(&self.sample, self.spread, &self.at, top, which);
        let slope = if self.sample.sized { limits(Which::Slope)? } else { (None, None) };
        Ok([limits(Which::Sigma)?, slope, limits(Which::Shape)?])
    }

    /// The number of parameters fitted.
    pub fn parameters(&self) -> usize {
        if self.sample.sized { 3 } else { 2 }
    }

    /// The criteria for the choice among fits.
    pub fn criteria(&self) -> Criteria {
        let (k, n) = (self.parameters() as f64, self.sample.len() as f64);
        let aic = 2.0 * k - 2.0 * self.ln_likelihood;
        let left = n - k - 1.0;
        let aicc = (left > 0.0).then(|| aic + 2.0 * k * (k + 1.0) / left);
        Criteria { aic, aicc, bic: k * n.ln() - 2.0 * self.ln_likelihood }
    }

    /// Whether the fit ends at a limit of its shape: the data spread more (or less) than this law
    /// can.
    pub fn at_limit(&self) -> bool {
        let (low, high) = self.spread.limits();
        self.at.t > high - 0.02 || self.at.t < low + 0.02
    }

    /// The fitted distribution of strength.
    pub fn law(&self) -> Law {
        Law::new(self.spread, self.at.t)
    }

    /// Strength by the law of size, Pa, at the size `x`, ln(d/d0) less the mean of the data.
    pub fn size_law(&self, x: f64) -> f64 {
        (self.at.a - self.at.s * x).exp()
    }

    /// Whether the strength at d0 can be given: with several sizes always, by the law of size; with
    /// one size only if it is d0.
    fn reaches_d0(&self) -> bool {
        self.sample.sized || self.sample.x_mean.abs() < 1e-3
    }

    fn sigma(&self, map: impl Fn(f64) -> f64) -> Estimate {
        if self.at_limit() {
            return Estimate::default();
        }
        Estimate::new(self.at.ln_sigma(&self.sample), self.limits[0], |v| map(v.exp()))
    }

    /// Mean strength at d0, MPa; empty if theta0 or E' is not known, or if there is only one size
    /// and it is not d0.
    pub fn sigma_lim0_mpa(&self) -> Estimate {
        if self.area.known && self.reaches_d0() { self.sigma(|pa| 1e-6 * pa) } else { Estimate::default() }
    }

    /// Mean strength at the mean size of the data, MPa, where there is one size only.
    pub fn sigma_at_size_mpa(&self) -> Option<Estimate> {
        (!self.sample.sized && self.area.known).then(|| self.sigma(|pa| 1e-6 * pa))
    }

    /// Quantity, MPa, that forces determine without theta0 or E': sigma_lim0 sin² theta0 or
    /// sigma_lim0³ / E'² (at the one size, if there is only one).
    pub fn identified_mpa(&self) -> Estimate {
        self.sigma(|pa| self.area.identified_mpa(pa))
    }

    /// s = 3/m.
    pub fn slope(&self) -> Estimate {
        if self.sample.sized { Estimate::new(self.at.s, self.limits[1], |v| v) } else { Estimate::default() }
    }

    /// m = 3/s, for positive slopes. If the slope may be zero, m has no upper limit.
    pub fn m(&self) -> Estimate {
        let slope = self.slope();
        let positive = |s: f64| Some(3.0 / s).filter(|m| s > 0.0 && m.is_finite());
        Estimate {
            estimate: slope.estimate.and_then(positive),
            lower: slope.upper.and_then(positive),
            upper: slope.lower.and_then(positive),
        }
    }

    /// Coefficient of variation of strength, -; empty if the fit ends at a limit of its shape.
    pub fn var(&self) -> Estimate {
        if self.at_limit() {
            return Estimate::default();
        }
        Estimate::new(self.at.t, self.limits[2], |t| Law::new(self.spread, t).var())
    }

    /// Remarks without which the numbers would mislead.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.at_limit() {
            notes.push(format!(
                "the strengths spread more (or less) than a {} spread can: sigma_lim0 and var. cannot be estimated with it",
                self.spread.name()
            ));
            return notes;
        }
        if !self.sample.sized {
            notes.push("one size: m cannot be estimated".into());
            if !self.reaches_d0() {
                notes.push("one size that is not d0: sigma_lim0 cannot be estimated, only the strength at that size".into());
            }
        } else if self.at.s <= 0.0 {
            notes.push("larger grains are not weaker: there is no size hardening, and m has no value".into());
        } else if self.limits[1].0.is_none_or(|s| s <= 0.0) {
            notes.push("no size hardening (m infinite) is not excluded: m has no upper limit".into());
        }
        if self.sample.sized && self.limits[1].1.is_none() {
            notes.push("the lower limit of m is open".into());
        }
        let (low, high) = self.limits[2];
        if low.is_none() || high.is_none() {
            notes.push("the data leave var. open on one side".into());
        }
        if self.limits[0].0.is_none() || self.limits[0].1.is_none() {
            notes.push("the data leave sigma_lim0 open on one side".into());
        }
        if !self.area.known {
            let (what, needs) = match self.area.model {
                super::area::Model::FixedAngle => ("sigma_lim0 sin²(theta0)", "--theta0"),
                super::area::Model::Hertz => ("sigma_lim0³/E'²", "--grain-E-GPa and --grain-nu"),
            };
            notes.push(format!("forces alone identify {what}: sigma_lim0 needs {needs}, or --material"));
        }
        notes
    }
}

/// Differences of AIC below this do not speak for a law (Burnham & Anderson 2002, section 2.6).
pub const NO_DIFFERENCE: f64 = 2.0;

/// Index of the preferred fit, and the reason: the smallest AIC, except that a truncated normal,
/// which scenes draw, is preferred if no other fit is better by [`NO_DIFFERENCE`]. Fits at a limit
/// of their shape are preferred only if all are.
pub fn preferred(fits: &[Fit]) -> Option<(usize, String)> {
    let aic: Vec<f64> = fits.iter().map(|f| f.criteria().aic).collect();
    let smallest = |among: &dyn Fn(&Fit) -> bool| {
        let mut best: Option<usize> = None;
        for i in (0..fits.len()).filter(|&i| among(&fits[i])) {
            if best.is_none_or(|b| aic[i] < aic[b] - 1e-6) {
                best = Some(i);
            }
        }
        best
    };
    let sound = |f: &Fit| !f.at_limit();
    let best = smallest(&sound).or_else(|| smallest(&|_| true))?;
    let drawn = smallest(&|f| sound(f) && f.spread == Spread::TruncatedNormal);
    let name = |i: usize| format!("{} with a {} spread", fits[i].area.model.name(), fits[i].spread.name());
    match drawn {
        Some(d) if d == best => Some((best, "smallest AIC".into())),
        Some(d) if aic[d] - aic[best] < NO_DIFFERENCE => Some((
            d,
            format!(
                "a spread that scenes draw; the smallest AIC ({}) is only {:.1} smaller, and differences below {NO_DIFFERENCE} do not tell models apart",
                name(best),
                aic[d] - aic[best]
            ),
        )),
        _ => Some((best, "smallest AIC".into())),
    }
}
