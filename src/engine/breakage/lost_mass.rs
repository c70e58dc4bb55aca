//! The mass of a broken grain that its daughters do not hold: which sizes it has (Ciantia et al. 2015, eq. 12, after Einav 2007 and Turcotte 1986), and how many
//! grains it would have been (Table 4).

use super::pattern::Pattern;

/// Fractal distribution of the mass lost in one breakage over the diameters from `d_min` to `d_max`, that of the smallest daughter:
///
/// ```text
/// M(L < d) / M_T = (d^(3-alpha) - d_min^(3-alpha)) / (d_max^(3-alpha) - d_min^(3-alpha))      (eq. 12)
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fines {
    /// Fractal dimension, -; 2.6 in the paper. With 3 the mass is uniform in ln d, which is the limit of eq. (12).
    pub alpha: f64,
    /// Smallest diameter, m, multiplied by the scale N like all lengths of a run.
    pub d_min: f64,
}

impl Fines {
    /// Share of the mass lost in one breakage, 0..1, that is finer than `d`, m; `d_max`, m: diameter of the smallest daughter (eq. 12). Where `d_max` is not above
    /// `d_min` all of the lost mass has the diameter `d_max`.
    pub fn finer(&self, d: f64, d_max: f64) -> f64 {
        if d >= d_max {
            1.0
        } else if d <= self.d_min || d_max <= self.d_min {
            0.0
        } else {
            (self.rise(d) / self.rise(d_max)).clamp(0.0, 1.0)
        }
    }

    /// Numerator of eq. (12) at `d`, m, or its denominator at `d_max`, both over the same factor: ((d/d_min)^(3-alpha) - 1)/(3-alpha), and ln(d/d_min) for
    /// alpha = 3.
    pub fn rise(&self, d: f64) -> f64 {
        let log = (d / self.d_min).ln();
        let exponent = 3.0 - self.alpha;
        if exponent == 0.0 { log } else { (exponent * log).exp_m1() / exponent }
    }

    /// ln(d/d_min) of the diameter d at which [`Self::rise`] is `rise`.
    fn log_of(&self, rise: f64) -> f64 {
        let exponent = 3.0 - self.alpha;
        if exponent == 0.0 { rise } else { (exponent * rise).ln_1p() / exponent }
    }

    /// Integral of a + b [`Self::rise`] over ln d, between the diameters at which `rise` has the values `from` and `to`.
    pub fn area(&self, (a, b): (f64, f64), [from, to]: [f64; 2]) -> f64 {
        let (lower, upper) = (self.log_of(from), self.log_of(to));
        let span = upper - lower;
        let exponent = 3.0 - self.alpha;
        let risen = if exponent == 0.0 { 0.5 * span * (upper + lower) } else { ((to - from) - span) / exponent };
        a * span + b * risen
    }

    /// Mean of max(0, ln(d/`size`)) over the mass lost in one breakage; `d_max`, m: diameter of the smallest daughter. It is the integral of 1 - F over ln d from
    /// `size` up, with F of eq. (12), in closed form.
    pub fn mean_log_above(&self, size: f64, d_max: f64) -> f64 {
        if d_max <= size {
            return 0.0;
        }
        let whole = (d_max / size).ln();
        if d_max <= self.d_min {
            return whole;
        }
        // F = 0 below `d_min`.
        let from = size.max(self.d_min);
        let span = (d_max / from).ln();
        let exponent = 3.0 - self.alpha;
        let area = if exponent == 0.0 {
            let (upper, lower) = ((d_max / self.d_min).ln(), (from / self.d_min).ln());
            0.5 * (upper * upper - lower * lower)
        } else {
            ((self.rise(d_max) - self.rise(from)) - span) / exponent
        };
        (whole - area / self.rise(d_max)).max(0.0)
    }
}

/// Number of grains that the lost mass would have been (Table 4, "Excluded particles"): for mothers of one size, all in grains of half the diameter of one class of
/// daughters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExcludedGrains {
    /// With the class that gives the numbers of the paper: the next to smallest (radius 0.2573 in the pattern of 14; the only class in the pattern of 2).
    pub paper: f64,
    /// With the class that the text of the paper names: the smallest (radius 0.2240 in the pattern of 14).
    pub smallest: f64,
}

/// Excluded grains after `events` breakages. One breakage into 14 daughters has 218.95 or 331.74 of them (218.96 or 331.85 from the rounded radii of Table 5).
pub fn excluded_grains(events: u64, pattern: &Pattern) -> ExcludedGrains {
    let classes = pattern.classes();
    let next = classes.iter().rev().nth(1).map_or(pattern.smallest(), |c| c.0);
    let per_event = |radius: f64| {
        let half = 0.5 * radius;
        (1.0 - pattern.volume_kept()) / (half * half * half)
    };
    ExcludedGrains { paper: events as f64 * per_event(next), smallest: events as f64 * per_event(pattern.smallest()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIG_2: Fines = Fines { alpha: 2.6, d_min: 0.1e-3 };

    #[test]
    fn fractal_part_of_fig_2() {
        assert!((FIG_2.finer(0.2e-3, 0.5e-3) - 0.353573).abs() < 5e-7);
        assert_eq!(FIG_2.finer(0.1e-3, 0.5e-3), 0.0);
        assert_eq!(FIG_2.finer(0.05e-3, 0.5e-3), 0.0);
        assert_eq!(FIG_2.finer(0.5e-3, 0.5e-3), 1.0);
        assert_eq!(FIG_2.finer(0.7e-3, 0.5e-3), 1.0);
    }

    /// The area under a + b rise over ln d is that of small trapezia, for every kind of exponent.
    #[test]
    fn area_is_an_integral_over_the_logarithm() {
        for alpha in [0.0, 1.5, 2.6, 3.0, 3.4] {
            let fines = Fines { alpha, ..FIG_2 };
            let (low, high): (f64, f64) = (0.13e-3, 0.7e-3);
            let steps = 2000;
            let h = (high / low).ln() / f64::from(steps);
            let at = |k: f64| 0.7 - 0.2 * fines.rise(low * (k * h).exp());
            let sum: f64 = (0..steps).map(|k| 0.5 * h * (at(f64::from(k)) + at(f64::from(k) + 1.0))).sum();
            let area = fines.area((0.7, -0.2), [fines.rise(low), fines.rise(high)]);
            assert!((area / sum - 1.0).abs() < 1e-5, "{alpha}: {area} {sum}");
        }
    }

    #[test]
    fn fraction_is_eq_12_as_printed() {
        for alpha in [0.0, 1.5, 2.6, 2.9, 3.4] {
            let fines = Fines { alpha, ..FIG_2 };
            let e = 3.0 - alpha;
            for d in [0.12e-3_f64, 0.3e-3, 0.44e-3] {
                let low = 0.1e-3_f64.powf(e);
                let expected = (d.powf(e) - low) / (0.5e-3_f64.powf(e) - low);
                assert!((fines.finer(d, 0.5e-3) - expected).abs() < 1e-12);
            }
        }
        // The limit at 3.
        let (near, at) = (Fines { alpha: 3.0 + 1e-9, ..FIG_2 }, Fines { alpha: 3.0, ..FIG_2 });
        assert!((near.finer(0.2e-3, 0.5e-3) - at.finer(0.2e-3, 0.5e-3)).abs() < 1e-8);
        assert!((at.finer(0.2e-3, 0.5e-3) - 2.0_f64.ln() / 5.0_f64.ln()).abs() < 1e-14);
    }

    #[test]
    fn an_event_below_the_smallest_size_is_one_size() {
        for d_max in [0.1e-3, 0.04e-3] {
            assert_eq!(FIG_2.finer(0.9 * d_max, d_max), 0.0);
            assert_eq!(FIG_2.finer(d_max, d_max), 1.0);
            assert!((FIG_2.mean_log_above(0.01e-3, d_max) - (d_max / 0.01e-3).ln()).abs() < 1e-15);
        }
    }

    #[test]
    fn mean_logarithm_is_the_integral_over_the_curve() {
        for alpha in [2.6, 3.0, 1.0] {
            let fines = Fines { alpha, ..FIG_2 };
            for size in [0.03e-3_f64, 0.1e-3, 0.2e-3, 0.6e-3] {
                let steps = 5000;
                let step = (0.5e-3 / size).ln() / f64::from(steps);
                let sum: f64 = (0..steps).map(|i| 1.0 - fines.finer(size * ((f64::from(i) + 0.5) * step).exp(), 0.5e-3)).sum();
                let expected = (sum * step).max(0.0);
                let found = fines.mean_log_above(size, 0.5e-3);
                assert!((found - expected).abs() < 1e-6, "{alpha} {size}: {found} {expected}");
            }
        }
    }

    /// Table 4: initial grains, final grains, crush events, excluded grains in two figures.
    const TABLE_4: [(u64, u64, u64, f64); 18] = [
        (5388, 90525, 6549, 1.4e6),
        (791, 19004, 1401, 3.1e5),
        (5388, 99209, 7217, 1.6e6),
        (680, 18984, 1408, 3.1e5),
        (5388, 171918, 12810, 2.8e6),
        (680, 22988, 1716, 3.8e5),
        (5388, 231809, 17417, 3.8e6),
        (680, 34415, 2595, 5.7e5),
        (8932, 20060, 856, 1.9e5),
        (1122, 2734, 124, 2.7e4),
        (8932, 31448, 1732, 3.8e5),
        (1122, 4502, 260, 5.7e4),
        (8932, 24116, 1168, 2.6e5),
        (1122, 3137, 155, 3.4e4),
        (13849, 138935, 9622, 2.1e6),
        (1736, 18779, 1311, 2.9e5),
        (13849, 102522, 6821, 1.5e6),
        (1736, 13995, 943, 2.1e5),
    ];

    #[test]
    fn identities_of_table_4() {
        let pattern = Pattern::new(14).unwrap();
        for (initial, last, events, excluded) in TABLE_4 {
            assert_eq!(initial + (pattern.count() as u64 - 1) * events, last);
            let found = excluded_grains(events, &pattern).paper;
            let digit = 10.0_f64.powf(found.log10().floor() - 1.0);
            assert!(((found / digit).round() * digit / excluded - 1.0).abs() < 1e-9, "{found} {excluded}");
        }
        let one = excluded_grains(1, &pattern);
        // From the radii of Table 5, rounded to four digits, they would be 218.96 and 331.85.
        assert!((one.paper - 218.955).abs() < 1e-3, "{one:?}");
        assert!((one.smallest - 331.739).abs() < 1e-3, "{one:?}");
    }

    #[test]
    fn two_balls_lose_three_quarters() {
        let pattern = Pattern::new(2).unwrap();
        assert_eq!(excluded_grains(2, &pattern).paper, 96.0);
        assert_eq!(excluded_grains(2, &pattern).smallest, 96.0);
        // Fig. 2: one of two equal grains breaks.
        assert_eq!((1.0 - pattern.volume_kept()) / 2.0, 0.375);
    }
}
