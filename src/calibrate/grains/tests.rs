//! Tests of the fits on data drawn from known laws.

use super::area::{Area, Model};
use super::data::{Data, Grain};
use super::fit::{Fit, Intervals, preferred};
use super::fragment::fragment;
use super::inputs::Given;
use super::likelihood::{Held, Sample};
use super::report::{self, json};
use super::simulate::{generator, tests as simulated, unit};
use super::spread::{Law, Spread};
use super::study::Case;
use super::{Calibration, Settings, calibrate, goodness};
use engine::breakage::strength::{Distribution, StrengthModel, Truncation};
use std::path::{Path, PathBuf};

const SETTINGS: Settings = Settings { intervals: Intervals::Profile, samples: 0, seed: 1 };

fn data(grains: Vec<Grain>) -> Data {
    Data { path: PathBuf::from("tests.csv"), grains, series: vec![String::new()], notes: Vec::new() }
}

fn angle() -> Area {
    Area::fixed_angle(Some(0.35))
}

/// Crushing tests, `each` of every size, whose strengths are 100 MPa (d/2 mm)^(-3/m) times random
/// numbers that follow `law`.
fn drawn(law: &Law, m: f64, sizes: &[f64], each: usize, seed: u64) -> Data {
    let mut rng = generator(seed, 0);
    let mut grains = Vec::new();
    for &diameter in sizes {
        for _ in 0..each {
            let strength = 100e6 * (diameter / 2e-3).powf(-3.0 / m) * law.quantile(unit(&mut rng));
            grains.push(Grain { diameter, force: angle().force(strength, diameter), censored: false, series: 0 });
        }
    }
    data(grains)
}

fn given() -> Given {
    Given { theta0: Some(0.35), platen_e_gpa: 200.0, platen_nu: 0.3, ..Given::default() }
}

fn calibrated(data: Data, given: &Given) -> Calibration {
    calibrate(data, given.resolve().expect("inputs"), SETTINGS, || ())
}

const SIZES: [f64; 3] = [1e-3, 2e-3, 5e-3];

#[test]
fn the_log_normal_fit_is_least_squares_of_logarithms() {
    let data = drawn(&Law::new(Spread::LogNormal, 0.4_f64.ln()), 3.0, &SIZES, 40, 3);
    let fit = Fit::new(&data, angle(), Spread::LogNormal, 2e-3);
    let points: Vec<(f64, f64)> =
        data.grains.iter().map(|g| ((g.diameter / 2e-3).ln(), angle().ln_strength(g.diameter, g.force))).collect();
    let (slope, sd) = super::data::line(&points);
    assert!((fit.at.s + slope).abs() < 1e-4, "{} {slope}", fit.at.s);
    assert!((fit.at.t.exp() - sd).abs() < 1e-4);
    // ln L of the forces: that of ln F, which is normal with this sd, less the sum of ln F
    let n = data.grains.len() as f64;
    let logs: f64 = data.grains.iter().map(|g| g.force.ln()).sum();
    let exact = -0.5 * n * (1.0 + (std::f64::consts::TAU * sd * sd).ln()) - logs;
    assert!((fit.ln_likelihood - exact).abs() < 1e-5, "{} {exact}", fit.ln_likelihood);
}

#[test]
fn profile_limits_of_a_regression_are_the_closed_ones() {
    let data = drawn(&Law::new(Spread::LogNormal, 0.3_f64.ln()), 2.5, &SIZES, 60, 4);
    let fit = Fit::new(&data, angle(), Spread::LogNormal, 2e-3).with_intervals(&data, Intervals::Profile);
    // 2 (ln L_max - ln L(s)) = n ln(1 + (s - ŝ)² S_xx / (n sd²))
    let n = data.grains.len() as f64;
    let sxx: f64 = fit.sample.x.iter().map(|x| x * x).sum();
    let half = fit.at.t.exp() * (n * (3.841_459_f64 / n).exp_m1() / sxx).sqrt();
    let slope = fit.slope();
    for (found, exact) in [(slope.lower, fit.at.s - half), (slope.upper, fit.at.s + half)] {
        assert!((found.expect("closed") - exact).abs() < 0.01 * half, "{found:?} {exact}");
    }
    assert!((fit.m().lower.expect("closed") - 3.0 / slope.upper.expect("closed")).abs() < 1e-12);
}

#[test]
fn power_laws_of_one_another_have_one_likelihood() {
    // a power of a log-normal (Weibull) variable is log-normal (Weibull), too: with these spreads
    // the area models fit equally well
    let data = drawn(&Law::new(Spread::Weibull, 0.3_f64.ln()), 3.0, &SIZES, 50, 5);
    for (spread, same) in [(Spread::LogNormal, true), (Spread::Weibull, true), (Spread::Normal, false)] {
        let fits = [angle(), Area::hertz(Some(5e9))].map(|a| Fit::new(&data, a, spread, 2e-3));
        let gap = (fits[0].ln_likelihood - fits[1].ln_likelihood).abs();
        assert_eq!(gap < 1e-5, same, "{spread:?}: {gap}");
        if same {
            assert!((fits[0].at.s / fits[1].at.s - 3.0).abs() < 1e-3);
        }
    }
}

#[test]
fn the_law_that_drew_the_tests_is_preferred() {
    for (spread, shape) in [(Spread::LogNormal, 0.5_f64), (Spread::Weibull, 0.8), (Spread::TruncatedNormal, 0.9)] {
        let law = Law::new(spread, shape.ln());
        let data = drawn(&law, 3.0, &SIZES, 200, 6);
        let fits: Vec<Fit> = Spread::ALL.iter().map(|s| Fit::new(&data, angle(), *s, 2e-3)).collect();
        let (best, _) = preferred(&fits).expect("one");
        assert_eq!(fits[best].spread, spread);
        let fit = fits[best].clone().with_intervals(&data, Intervals::Profile);
        assert!(fit.sigma_lim0_mpa().holds(100.0) && fit.m().holds(3.0) && fit.var().holds(law.var()), "{:?}", fit.at);
        // the goodness of fit accepts this law and rejects another one
        assert!(goodness::judge(&fit, 99, 1).p_value.expect("drawn") > 0.05);
        let wrong = if spread == Spread::LogNormal { 0 } else { 2 };
        assert!(goodness::judge(&fits[wrong], 99, 1).p_value.expect("drawn") < 0.05, "{spread:?}");
    }
}

#[test]
fn the_shape_at_its_limit_gives_no_numbers() {
    // strengths with a coefficient of variation of 1.5: no truncated normal is so wide
    let data = drawn(&Law::new(Spread::LogNormal, 1.1_f64.ln()), 3.0, &SIZES, 60, 7);
    let fit = Fit::new(&data, angle(), Spread::TruncatedNormal, 2e-3).with_intervals(&data, Intervals::Profile);
    assert!(fit.at_limit() && fit.sigma_lim0_mpa().estimate.is_none() && fit.var().estimate.is_none());
    assert!(fit.notes()[0].contains("spread more (or less) than a truncated-normal spread can"));
    let all = calibrated(data, &given());
    assert_eq!(all.best().spread, Spread::LogNormal);
    assert!(fragment(&all, Path::new(".")).is_none(), "nothing that a scene could draw");
}

#[test]
fn grains_that_did_not_break_are_lower_bounds() {
    let law = StrengthModel {
        sigma_lim0: 100e6,
        d0: 2e-3,
        m: 3.0,
        distribution: Distribution::Normal,
        var: 0.4,
        truncation: Truncation::Redraw,
        min_ratio: 0.0,
    };
    let whole = simulated(&law, &angle(), &SIZES, 200, 11);
    let mut ended = whole.clone();
    let most = angle().force(110e6, 2e-3);
    for g in ended.grains.iter_mut().filter(|g| g.force > most) {
        (g.force, g.censored) = (most, true);
    }
    assert!(ended.broken() < 500);
    let fit = |d: &Data| Fit::new(d, angle(), Spread::TruncatedNormal, 2e-3).with_intervals(d, Intervals::Profile);
    let with = fit(&ended);
    assert!(with.sigma_lim0_mpa().holds(100.0) && with.m().holds(3.0) && with.var().holds(0.4), "{:?}", with.at);
    // if they counted as broken, the estimates would be wrong
    for g in &mut ended.grains {
        g.censored = false;
    }
    let without = fit(&ended);
    assert!(!without.m().holds(3.0) || !without.var().holds(0.4));
}

#[test]
fn one_size_gives_no_m_and_no_strength_elsewhere() {
    let law = Law::new(Spread::TruncatedNormal, 0.4_f64.ln());
    let data = drawn(&law, 3.0, &[4e-3], 80, 8);
    let there = calibrated(data.clone(), &Given { d0_mm: Some(4.0), ..given() });
    let best = there.best();
    assert_eq!(best.parameters(), 2);
    assert!(best.m().estimate.is_none() && best.var().holds(0.4));
    assert!(best.sigma_lim0_mpa().holds(50.0), "{:?}", best.sigma_lim0_mpa());
    let elsewhere = calibrated(data, &given());
    let best = elsewhere.best();
    assert_eq!(best.sigma_lim0_mpa().estimate, None);
    assert!(best.sigma_at_size_mpa().expect("one size").holds(50.0));
    assert!(elsewhere.notes().iter().any(|n| n.contains("only the strength at that size")));
    assert!(fragment(&elsewhere, Path::new(".")).is_none());
    for c in [&there, &elsewhere] {
        let object = json(c);
        assert!(object["best"]["m"]["estimate"].is_null() && object["best"]["m"]["upper"].is_null());
        assert!(object["best"]["var"]["lower"].is_f64());
    }
}

#[test]
fn no_hardening_leaves_m_open_and_softening_gives_none() {
    let law = Law::new(Spread::LogNormal, 0.3_f64.ln());
    let fit = |m: f64| {
        let data = drawn(&law, m, &SIZES, 60, 9);
        Fit::new(&data, angle(), Spread::LogNormal, 2e-3).with_intervals(&data, Intervals::Profile)
    };
    let flat = fit(1e6);
    assert!(flat.m().upper.is_none() && flat.m().lower.is_some_and(|m| m > 10.0));
    let soft = fit(-3.0);
    assert!(soft.m().estimate.is_none() && soft.m().lower.is_none() && soft.slope().holds(-1.0));
    assert!(soft.notes().iter().any(|n| n.contains("no size hardening")));
}

#[test]
fn without_angle_or_moduli_the_product_is_told_and_no_strength() {
    let data = drawn(&Law::new(Spread::TruncatedNormal, 0.4_f64.ln()), 3.0, &SIZES, 60, 10);
    let (bare, with) =
        (Given { theta0: None, ..given() }, Given { models: Some(vec![Model::FixedAngle, Model::Hertz]), ..given() });
    let (bare, with) = (calibrated(data.clone(), &bare), calibrated(data, &with));
    for (a, b) in bare.fits.iter().zip(&with.fits) {
        assert!(a.sigma_lim0_mpa().estimate.is_none());
        let product = |f: &Fit| f.identified_mpa().estimate.unwrap_or(0.0);
        assert!(a.at_limit() || (product(a) / product(b) - 1.0).abs() < 1e-3, "{:?} {:?}", a.identified_mpa(), b.identified_mpa());
        assert!((a.ln_likelihood - b.ln_likelihood).abs() < 1e-4);
    }
    assert!(bare.notes().iter().any(|n| n.contains("forces alone identify")));
    assert!(json(&bare)["best"]["sigma_lim0_MPa"]["estimate"].is_null());
    let angle = with.fits[0].sigma_lim0_mpa().estimate.expect("known");
    assert!((with.fits[0].identified_mpa().estimate.expect("product") / (angle * 0.35_f64.sin().powi(2)) - 1.0).abs() < 1e-9);
}

#[test]
fn bootstrap_limits_lie_about_those_of_the_profile() {
    let case = &Case::all()[0];
    let data = case.simulate(400, 12);
    let fit = Fit::new(&data, case.area, Spread::TruncatedNormal, 2e-3);
    let how = Intervals::Bootstrap { resamples: 400, seed: 2 };
    let (profile, boot) = (fit.clone().with_intervals(&data, Intervals::Profile), fit.clone().with_intervals(&data, how));
    for (a, b) in [(profile.sigma_lim0_mpa(), boot.sigma_lim0_mpa()), (profile.m(), boot.m()), (profile.var(), boot.var())] {
        let ratio = b.width().expect("closed") / a.width().expect("closed");
        assert!((0.8..1.25).contains(&ratio), "{a:?} {b:?}");
    }
    assert_eq!(
        format!("{:?}", boot.m()),
        format!("{:?}", fit.with_intervals(&data, how).m()),
        "the same seed gives the same limits"
    );
}

#[test]
fn few_grains_leave_limits_open_rather_than_wrong() {
    let law = Law::new(Spread::TruncatedNormal, 0.0);
    for seed in 0..20 {
        let all = calibrated(drawn(&law, 2.0, &[1e-3, 2e-3], 3, 100 + seed), &given());
        // a number that is not finite would be written as null
        for model in json(&all)["models"].as_array().expect("models") {
            assert!(["aic", "bic", "ln_likelihood"].iter().all(|k| model[*k].is_f64()), "{model}");
            assert!(model["goodness"]["anderson_darling"].is_f64());
        }
        for fit in &all.fits {
            for e in [fit.sigma_lim0_mpa(), fit.m(), fit.var(), fit.identified_mpa()] {
                let values = [e.lower, e.estimate, e.upper];
                assert!(values.iter().flatten().all(|v| v.is_finite() && *v > 0.0), "{e:?}");
                let known: Vec<f64> = values.into_iter().flatten().collect();
                assert!(known.windows(2).all(|w| w[0] <= w[1]), "{e:?}");
            }
        }
    }
}

#[test]
fn the_likelihood_is_largest_where_the_fit_is() {
    let case = &Case::all()[2];
    let data = case.simulate(300, 3);
    for spread in Spread::ALL {
        let fit = Fit::new(&data, case.area, spread, 2e-3);
        let sample = Sample::new(&data, &case.area, 2e-3);
        let (_, step) = sample.start(spread);
        for held in [Held::Sigma(fit.at.ln_sigma(&sample) + 0.03), Held::Slope(fit.at.s - 0.02), Held::Shape(fit.at.t + 0.02)] {
            let (_, l) = sample.maximise(spread, held, &fit.at, &step);
            assert!(sample.ln_likelihood(l, &data) < fit.ln_likelihood, "{spread:?} {held:?}");
        }
    }
}

#[test]
fn everything_is_written_and_a_second_calibration_asks_before_it_overwrites() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let all = calibrated(Case::all()[0].simulate(60, 1), &given());
    report::claim(&out, false).expect("made");
    let files = report::write(&all, &out).expect("written");
    assert!(files.iter().all(|f| f.is_file()));
    assert!(report::claim(&out, false).is_err());
    std::fs::write(out.join("mine.txt"), "kept").expect("written");
    report::claim(&out, true).expect("forced");
    let left: Vec<_> = std::fs::read_dir(&out).expect("folder").flatten().map(|e| e.file_name()).collect();
    assert_eq!(left, ["mine.txt"]);
}

#[test]
fn series_of_two_materials_are_told_apart() {
    let law = Law::new(Spread::TruncatedNormal, 0.4_f64.ln());
    let two = |factor: f64| {
        let mut data = drawn(&law, 3.0, &SIZES, 40, 13);
        data.series = vec!["dry".into(), "wet".into()];
        for (i, g) in data.grains.iter_mut().enumerate().filter(|(i, _)| i % 2 == 1) {
            (g.series, g.force) = (i % 2, g.force * factor);
        }
        calibrated(data, &given())
    };
    let (same, other) = (two(1.0), two(0.6));
    assert!(same.series_p_value.expect("two series") > 0.05);
    assert!(other.series_p_value.expect("two series") < 1e-3);
    assert!(other.notes().iter().any(|n| n.contains("do not have one law")));
    let one = calibrated(drawn(&law, 3.0, &SIZES, 40, 13), &given());
    assert_eq!(one.series_p_value, None);
}
