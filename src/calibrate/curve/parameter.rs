//! Parameters of a calibration: bounds, priors, and the map to the unit cube, in whose coordinates
//! designs, emulators and chains work.

use laboratory::error::{Error, Result};
use laboratory::scene::{self, Calibrated, Prior};
use std::path::Path;

/// Largest number of parameters of a calibration. One curve cannot determine more, and the number
/// of corners of the bounds, at which the scene is checked, doubles with each.
pub const MOST: usize = 6;

/// One parameter. Its unit coordinate u runs from 0 at the lower bound to 1 at the upper, in the logarithm for a log-uniform prior.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Dotted key of the scene.
    pub key: String,
    /// Lower bound, in the unit of the key.
    pub lower: f64,
    /// Upper bound, in the unit of the key.
    pub upper: f64,
    /// Prior distribution.
    pub prior: Prior,
}

impl Parameter {
    /// Reads `KEY=LOW..HIGH`, `KEY=LOW..HIGH:log` or `KEY=LOW..HIGH:normal(MEAN,SD)`.
    ///
    /// # Errors
    /// Text of another form.
    pub fn parse(text: &str) -> Result<Calibrated> {
        let place = format!("--parameter {text}");
        let fail = || {
            let message = "must be KEY=LOW..HIGH, with :log or :normal(MEAN,SD) after it for another prior than a uniform one";
            Error::input(&place, "", None, message)
        };
        let (key, rest) = text.split_once('=').ok_or_else(fail)?;
        let (range, prior) = rest.split_once(':').unwrap_or((rest, "uniform"));
        let (lower, upper) = range.split_once("..").ok_or_else(fail)?;
        let number = |s: &str| s.trim().parse::<f64>().map_err(|_| fail());
        let prior = match prior.trim() {
            "uniform" => Prior::Uniform,
            "log" | "log_uniform" => Prior::LogUniform,
            other => {
                let inner = other.strip_prefix("normal(").and_then(|s| s.strip_suffix(')')).ok_or_else(fail)?;
                let (mean, sd) = inner.split_once(',').ok_or_else(fail)?;
                Prior::Normal { mean: number(mean)?, sd: number(sd)? }
            }
        };
        Ok(Calibrated { key: key.trim().into(), lower: number(lower)?, upper: number(upper)?, prior, place })
    }

    /// Checks key, bounds and prior, and returns the parameter.
    ///
    /// # Errors
    /// A key that is no parameter of a material or a test; bounds or a prior that are invalid, with
    /// what is allowed.
    pub fn new(c: &Calibrated) -> Result<Parameter> {
        let fail = |message: &str| Err(Error::input(format!("{}: {}", c.place, c.key), "", None, message));
        if c.key.is_empty() || ["seed.", "records.", "calibrate"].iter().any(|k| c.key.starts_with(k)) {
            return fail("is no parameter of a material or a test");
        }
        if !(c.lower.is_finite() && c.upper.is_finite() && c.lower < c.upper) {
            return fail("the lower bound must be below the upper one");
        }
        match c.prior {
            Prior::LogUniform if c.lower <= 0.0 => return fail("a log-uniform prior needs bounds above 0"),
            Prior::Normal { mean, sd } if !(mean.is_finite() && sd.is_finite() && sd > 0.0) => {
                return fail("a normal prior needs a mean and a standard deviation above 0");
            }
            Prior::Normal { mean, sd } if mean + 4.0 * sd < c.lower || mean - 4.0 * sd > c.upper => {
                return fail("the normal prior lies outside of the bounds");
            }
            _ => {}
        }
        Ok(Parameter { key: c.key.clone(), lower: c.lower, upper: c.upper, prior: c.prior })
    }

    fn log(&self) -> bool {
        self.prior == Prior::LogUniform
    }

    /// The value at a unit coordinate.
    pub fn value(&self, u: f64) -> f64 {
        if self.log() { self.lower * (self.upper / self.lower).powf(u) } else { self.lower + (self.upper - self.lower) * u }
    }

    /// The value at a unit coordinate, rounded to six digits and kept within the bounds. Runs get
    /// this value.
    pub fn rounded(&self, u: f64) -> f64 {
        let value: f64 = format!("{:.5e}", self.value(u)).parse().unwrap_or(f64::NAN);
        value.clamp(self.lower, self.upper)
    }

    /// The unit coordinate of a value.
    pub fn unit(&self, value: f64) -> f64 {
        if self.log() {
            (value / self.lower).ln() / (self.upper / self.lower).ln()
        } else {
            (value - self.lower) / (self.upper - self.lower)
        }
    }

    /// Logarithm of the prior density in the unit coordinate, up to a constant; −∞ outside of the bounds.
    pub fn log_prior(&self, u: f64) -> f64 {
        if !(0.0..=1.0).contains(&u) {
            return f64::NEG_INFINITY;
        }
        match self.prior {
            Prior::Normal { mean, sd } => -0.5 * ((self.value(u) - mean) / sd).powi(2),
            _ => 0.0,
        }
    }

    /// Short name for legends: the last word of the key, with the word before it if the last one
    /// has fewer than four letters (`fixed_angle.m`).
    pub fn short(&self) -> String {
        let words: Vec<&str> = self.key.split('.').collect();
        match words.as_slice() {
            [.., table, name] if name.len() < 4 => format!("{table}.{name}"),
            [.., name] => (*name).to_string(),
            [] => self.key.clone(),
        }
    }
}

/// Checks that the scene is valid at every corner of the bounds, where each parameter is at its
/// lower or its upper bound.
///
/// # Errors
/// No parameters, too many, or a key given twice; the scene's own message for the first value that
/// the scene does not allow.
pub fn check(parameters: &[Parameter], scene: &Path, sets: &[String]) -> Result<()> {
    if parameters.is_empty() {
        let message = "there is nothing to calibrate: give --parameter KEY=LOW..HIGH, or [[calibrate]] tables in the scene";
        return Err(Error::input(scene.display(), "", None, message));
    }
    if parameters.len() > MOST {
        return Err(Error::input("--parameter", "", None, format!("at most {MOST} can be calibrated at once")));
    }
    for (i, p) in parameters.iter().enumerate() {
        if parameters[..i].iter().any(|q| q.key == p.key) {
            return Err(Error::input(format!("--parameter {}", p.key), "", None, "is given twice"));
        }
    }
    for corner in 0..1u32 << parameters.len() {
        let mut sets = sets.to_vec();
        for (k, p) in parameters.iter().enumerate() {
            let value = if corner >> k & 1 == 0 { p.lower } else { p.upper };
            sets.push(format!("{}={value:?}", p.key));
        }
        scene::outline(&scene::load(scene, &sets)?)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Parameter> {
        Parameter::new(&Parameter::parse(text)?)
    }

    #[test]
    fn parameters_are_read_with_their_priors() {
        let p = parse("material.strength.m=2..8").expect("uniform");
        assert_eq!((p.lower, p.upper, p.prior), (2.0, 8.0, Prior::Uniform));
        assert_eq!(p.short(), "strength.m");
        assert_eq!(parse("a=1..100:log").expect("log").value(0.5), 10.0);
        assert_eq!(parse("a=-1..1:normal(0,0.5)").expect("normal").prior, Prior::Normal { mean: 0.0, sd: 0.5 });
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        for (text, says) in [
            ("a", "must be KEY"),
            ("a=1", "must be KEY"),
            ("a=1..x", "must be KEY"),
            ("a=1..2:flat", "must be KEY"),
            ("a=2..1", "lower bound"),
            ("a=nan..1", "lower bound"),
            ("a=0..1:log", "above 0"),
            ("a=0..1:normal(0,0)", "standard deviation"),
            ("a=0..1:normal(9,1)", "outside of the bounds"),
            ("seed.packing=1..5", "no parameter"),
        ] {
            let error = parse(text).expect_err(text).to_string();
            assert!(error.contains(says) && error.contains("--parameter"), "{text}: {error}");
        }
    }

    #[test]
    fn unit_coordinates_go_there_and_back() {
        for text in ["a=3..7", "a=0.01..1000:log"] {
            let p = parse(text).expect("parameter");
            for u in [0.0, 0.123, 0.5, 1.0] {
                assert!((p.unit(p.value(u)) - u).abs() < 1e-12);
                assert!((p.unit(p.rounded(u)) - u).abs() < 1e-4);
                assert!((p.lower..=p.upper).contains(&p.rounded(u)));
            }
            assert_eq!(p.log_prior(1.01), f64::NEG_INFINITY);
            assert_eq!(p.log_prior(0.3), 0.0);
        }
    }
}
