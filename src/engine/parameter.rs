//! Parameters that contact laws and failure criteria need of a material: numbers that users write in the material's file, with their units, limits and defaults.

/// Limits of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Lower end.
    pub low: f64,
    /// Whether the lower end itself is excluded.
    pub low_open: bool,
    /// Upper end.
    pub high: f64,
    /// Whether the upper end itself is excluded.
    pub high_open: bool,
}

impl Range {
    /// Every number.
    pub const ANY: Range = Range::closed(f64::NEG_INFINITY, f64::INFINITY);
    /// Above zero.
    pub const POSITIVE: Range = Range::above(0.0, f64::INFINITY);
    /// Zero and above.
    pub const NOT_NEGATIVE: Range = Range::closed(0.0, f64::INFINITY);

    /// From `low` to `high`, both included.
    pub const fn closed(low: f64, high: f64) -> Range {
        Range { low, low_open: false, high, high_open: false }
    }

    /// Above `low`, up to and including `high`.
    pub const fn above(low: f64, high: f64) -> Range {
        Range { low_open: true, ..Range::closed(low, high) }
    }

    /// From `low`, included, up to but without `high`.
    pub const fn below(low: f64, high: f64) -> Range {
        Range { high_open: true, ..Range::closed(low, high) }
    }

    /// Strictly between `low` and `high`.
    pub const fn between(low: f64, high: f64) -> Range {
        Range { low_open: true, ..Range::below(low, high) }
    }

    /// Whether `x` lies inside.
    pub fn holds(&self, x: f64) -> bool {
        let above = if self.low_open { x > self.low } else { x >= self.low };
        let below = if self.high_open { x < self.high } else { x <= self.high };
        above && below
    }

    /// The limits in words, `> 0 and <= 1`; empty where every number is allowed.
    pub fn text(&self) -> String {
        let mut parts = Vec::new();
        if self.low.is_finite() {
            let sign = if self.low_open { ">" } else { ">=" };
            parts.push(format!("{sign} {}", self.low));
        }
        if self.high.is_finite() {
            let sign = if self.high_open { "<" } else { "<=" };
            parts.push(format!("{sign} {}", self.high));
        }
        parts.join(" and ")
    }
}

/// A parameter that a law needs of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Key in the material's file: table and name, which ends with the unit in the file (`contact.yield_pressure_MPa`). Laws get values in SI units.
    pub key: &'static str,
    /// Limits, in the unit of the file.
    pub range: Range,
    /// Default, written as in a file, in its unit; `None`: the file must have the key.
    pub default: Option<&'static str>,
    /// Description for users.
    pub meaning: &'static str,
}

/// Largest number of parameters of a law.
pub const MOST_PARAMETERS: usize = 4;

/// Values of the parameters of a law, in SI units, in the order in which the law declares them; the remaining entries are zero.
pub type Values = [f64; MOST_PARAMETERS];
