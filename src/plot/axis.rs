//! One axis: its range, ticks and labels, linear or logarithmic.

/// Largest magnitude that an axis shows; on a logarithmic axis its inverse is the smallest value.
/// Values beyond these limits are no measurements.
const FAR: f64 = 1e60;

/// How values are spread along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    Linear,
    Log,
}

/// An axis without its range; the range follows from the data and `include`.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Quantity and unit, as printed.
    pub label: String,
    /// Quantity and unit, as the column of the CSV beside the figure.
    pub column: String,
    pub scale: Scale,
    /// Values that the range must contain.
    pub include: Vec<f64>,
    /// Whether values grow downwards (strains).
    pub downwards: bool,
}

impl Axis {
    pub fn linear(label: &str, column: &str) -> Self {
        Self { label: label.into(), column: column.into(), scale: Scale::Linear, include: Vec::new(), downwards: false }
    }

    pub fn log(label: &str, column: &str) -> Self {
        Self { scale: Scale::Log, ..Self::linear(label, column) }
    }

    /// The axis with values that its range must contain.
    pub fn including(mut self, values: &[f64]) -> Self {
        self.include.extend_from_slice(values);
        self
    }

    pub fn downwards(mut self) -> Self {
        self.downwards = true;
        self
    }

    /// Whether a value has a place on this axis.
    pub fn shows(&self, v: f64) -> bool {
        v.abs() < FAR && (self.scale == Scale::Linear || v > 1.0 / FAR)
    }

    /// The range that contains the given values and `include`, with a margin and with limits on
    /// ticks; `None` if there is no value to show.
    pub fn range(&self, values: impl Iterator<Item = f64>) -> Option<Range> {
        let values = values.chain(self.include.iter().copied()).filter(|v| self.shows(*v));
        let (lo, hi) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)));
        if lo > hi {
            return None;
        }
        Some(match self.scale {
            Scale::Linear => self.linear_range(lo, hi),
            Scale::Log => log_range(lo, hi),
        })
    }

    fn linear_range(&self, lo: f64, hi: f64) -> Range {
        let span = hi - lo;
        let span = if span > 1e-9 * hi.abs().max(lo.abs()) && span > 0.0 { span } else { (0.2 * hi.abs()).max(1e-6) };
        let step = minor(nice_step(span / 5.0)).0;
        // A limit in `include` is kept without a margin (up to rounding); at any other limit a
        // margin keeps curves off the frame.
        let asked = |v: f64| self.include.iter().any(|limit| (limit - v).abs() <= 1e-9 * span);
        // where the axis must contain zero, negative values smaller than 1 % of the largest value
        // are left over from settling and do not extend the axis
        let lo = if self.include.contains(&0.0) && lo < 0.0 && lo > -0.01 * hi { 0.0 } else { lo };
        let low = if asked(lo) { lo } else { lo - 0.03 * span };
        let high = if asked(hi) { hi } else { hi + 0.03 * span };
        Range { scale: Scale::Linear, lo: (low / step + 1e-9).floor() * step, hi: (high / step - 1e-9).ceil() * step }
    }
}

/// The limits of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    pub scale: Scale,
    pub lo: f64,
    pub hi: f64,
}

/// A mark on an axis; minor ticks have no label.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    pub value: f64,
    pub label: Option<String>,
}

impl Range {
    /// Place of a value, 0 at `lo` and 1 at `hi`.
    pub fn place(&self, v: f64) -> f64 {
        match self.scale {
            Scale::Linear => (v - self.lo) / (self.hi - self.lo),
            Scale::Log => (v / self.lo).ln() / (self.hi / self.lo).ln(),
        }
    }

    pub fn ticks(&self) -> Vec<Tick> {
        match self.scale {
            Scale::Linear => self.linear_ticks(),
            Scale::Log => self.log_ticks(),
        }
    }

    fn linear_ticks(&self) -> Vec<Tick> {
        let step = nice_step((self.hi - self.lo) / 5.5);
        let (minor, parts) = minor(step);
        let first = (self.lo / minor - 1e-6).ceil() as i64;
        let last = (self.hi / minor + 1e-6).floor() as i64;
        (first..=last)
            .map(|i| {
                let value = i as f64 * minor;
                let label = (i % parts == 0).then(|| decimal(value, step));
                Tick { value, label }
            })
            .collect()
    }

    fn log_ticks(&self) -> Vec<Tick> {
        let first = self.lo.log10().floor() as i32;
        let last = self.hi.log10().ceil() as i32;
        let inside = |v: f64| v >= self.lo * (1.0 - 1e-9) && v <= self.hi * (1.0 + 1e-9);
        let decades = (first..=last).filter(|k| inside(10f64.powi(*k))).count();
        let every = (decades / 7) as i32 + 1;
        let labelled: &[i32] = match decades {
            0 | 1 => &[1, 2, 5],
            _ => &[1],
        };
        let mut out = Vec::new();
        for k in first..=last {
            for m in 1..10 {
                let value = f64::from(m) * 10f64.powi(k);
                if inside(value) {
                    let named = labelled.contains(&m) && (m != 1 || k.rem_euclid(every) == 0);
                    let label = named.then(|| power(m, k));
                    out.push(Tick { value, label });
                }
            }
        }
        out
    }
}

/// Limits at whole multiples of a power of ten, a little outside the data.
fn log_range(lo: f64, hi: f64) -> Range {
    let whole = |v: f64, up: bool| {
        let unit = 10f64.powf(v.log10().floor());
        let multiple = v / unit;
        unit * if up { (multiple - 1e-9).ceil() } else { (multiple + 1e-9).floor() }
    };
    let hi = if hi / lo < 1.5 { lo * 1.5 } else { hi };
    let top = whole(hi * 1.08, true);
    let decade = 10f64.powf((top.log10() - 1e-9).ceil());
    Range {
        scale: Scale::Log,
        lo: whole(lo / 1.08, false),
        // If more than 0.45 of the last decade is in use, the axis ends at the end of this decade,
        // which has a label.
        hi: if top > 0.45 * decade { decade } else { top },
    }
}

/// Distance of minor ticks, and their number in a `step` between labelled ticks.
fn minor(step: f64) -> (f64, i64) {
    let leading = (step / 10f64.powf((step.log10() + 1e-9).floor())).round();
    let parts = if leading == 2.0 { 4 } else { 5 };
    (step / parts as f64, parts)
}

/// The smallest of 1, 2 and 5 times a power of ten that is not below `rough`.
fn nice_step(rough: f64) -> f64 {
    let unit = 10f64.powf(rough.log10().floor());
    let multiple = rough / unit;
    unit * [1.0, 2.0, 5.0].into_iter().find(|m| *m >= multiple * (1.0 - 1e-9)).unwrap_or(10.0)
}

/// A tick value with the decimals that its step needs.
fn decimal(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
    let value = if value.abs() < step * 1e-6 { 0.0 } else { value };
    minus(&format!("{value:.decimals$}"))
}

/// m·10^k as text: a plain number for k from −3 to 3, else with a power of ten.
fn power(m: i32, k: i32) -> String {
    let value = f64::from(m) * 10f64.powi(k);
    match (k, m) {
        (-3..=3, _) => format!("{value:.*}", (-k).max(0) as usize),
        (_, 1) => minus(&format!("10^{{{k}}}")),
        _ => minus(&format!("{m}×10^{{{k}}}")),
    }
}

/// The text with true minus signs in place of hyphens.
fn minus(text: &str) -> String {
    text.replace('-', "−")
}

/// A value with at most `digits` significant digits and no needless zeros, as in legends (5, 0.05, 1.88).
pub fn significant(value: f64, digits: i32) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let whole = value.abs().log10().floor() as i32;
    let decimals = (digits - 1 - whole).clamp(0, 9) as usize;
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    minus(text)
}

/// A count as text; thousands are set apart in counts of more than four digits.
pub fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) && digits.len() > 4 {
            out.push('\u{a0}');
        }
        out.push(c);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(range: &Range) -> Vec<String> {
        range.ticks().into_iter().filter_map(|t| t.label).collect()
    }

    #[test]
    fn stress_decades_are_labelled_in_plain_numbers() {
        let range = Axis::log("", "").range([0.005, 5.02].into_iter()).expect("range");
        assert_eq!(labels(&range), ["0.01", "0.1", "1", "10"]);
        assert!(range.lo < 0.005 && range.hi > 5.02, "{range:?}");
        assert!((range.place(0.1) - range.place(0.01)) - (range.place(1.0) - range.place(0.1)) < 1e-12);
    }

    #[test]
    fn a_short_log_axis_gets_more_labels_and_a_long_one_fewer() {
        let short = Axis::log("", "").range([2.5, 12.0].into_iter()).expect("range");
        assert_eq!(labels(&short), ["2", "5", "10", "20"]);
        let long = Axis::log("", "").range([1e-9, 1e6].into_iter()).expect("range");
        assert!(labels(&long).len() <= 8, "{:?}", labels(&long));
        assert!(labels(&long).contains(&"10^{−6}".to_string()));
    }

    #[test]
    fn linear_limits_hold_the_data_and_are_ticked() {
        for (lo, hi) in [(0.271, 0.42), (-0.13, 0.42), (0.0, 1408.0), (7.0, 7.0), (0.0, 0.0)] {
            let range = Axis::linear("", "").range([lo, hi].into_iter()).expect("range");
            assert!(range.lo <= lo && range.hi >= hi && range.lo < range.hi);
            let n = labels(&range).len();
            assert!((3..=9).contains(&n), "{range:?} {:?}", labels(&range));
        }
        let zero = Axis::linear("", "").including(&[0.0, 100.0]).range([3.0].into_iter());
        assert_eq!(zero.map(|r| (r.lo, r.hi)), Some((0.0, 100.0)));
    }

    #[test]
    fn nothing_to_show_has_no_range() {
        assert!(Axis::log("", "").range([0.0, -1.0, f64::NAN, 1e-300, 1e300].into_iter()).is_none());
        assert!(Axis::linear("", "").range([f64::INFINITY].into_iter()).is_none());
    }

    #[test]
    fn numbers_are_printed_short() {
        assert_eq!(significant(5.0, 3), "5");
        assert_eq!(significant(1.8765, 3), "1.88");
        assert_eq!(significant(0.0050123, 2), "0.005");
        assert_eq!(significant(-1200.0, 3), "−1200");
        assert_eq!(count(680), "680");
        assert_eq!(count(18984), "18\u{a0}984");
        assert_eq!(count(1234567), "1\u{a0}234\u{a0}567");
    }
}
