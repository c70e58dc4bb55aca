//! Records of crushing tests of single grains between platens: the tables `platen.csv`, `force_displacement.csv`, `survival.csv`
//! and `limit_force.csv`.

use crate::error::Result;
use crate::model::{GrainCrushing, Model};
use crate::rig::grain_crushing::{Test, hertz, pair};
use engine::breakage::CrushModel;
use engine::breakage::criterion::size_factor;
use std::path::Path;
use table::{Row, Table, Value};

/// Result of each test.
pub const TESTS: &str = "platen.csv";
/// Force-displacement curves.
pub const CURVES: &str = "force_displacement.csv";
/// Share of grains that survive a force.
pub const SURVIVAL: &str = "survival.csv";
/// Limit force against diameter.
pub const LIMITS: &str = "limit_force.csv";

/// Quantiles of the limit force in `limit_force.csv`: the band of the figures.
const BAND: [f64; 3] = [0.05, 0.5, 0.95];
/// Number of diameters in `limit_force.csv`.
const SIZES: usize = 33;
/// Largest diameter in `limit_force.csv` over the largest tested one; the smallest is smaller by the same factor.
const BEYOND: f64 = 1.25;
/// Number of classes, with about equal numbers of grains, into which a gradation is divided for `survival.csv`.
const CLASSES: usize = 4;

/// Writes all tables into the folder `out`.
///
/// # Errors
/// A file that cannot be written.
pub fn write(out: &Path, model: &Model, rig: &GrainCrushing, tests: &[Test]) -> Result<()> {
    save(out, TESTS, tests.iter().map(|t| test_row(t)))?;
    let e_eff = pair(model, rig).e_eff;
    save(out, CURVES, tests.iter().flat_map(|t| curve_rows(t, e_eff)))?;
    save(out, SURVIVAL, classes(rig, tests).iter().flat_map(|class| survival_rows(model, rig, class)))?;
    let Some(crush) = &model.physics.crush else { return Ok(()) };
    save(out, LIMITS, limit_rows(crush, rig, e_eff).into_iter())
}

fn save(out: &Path, name: &'static str, rows: impl Iterator<Item = Row>) -> Result<()> {
    let mut table = Table::new(name);
    for row in rows {
        table.push(out, &row)?;
    }
    Ok(table.flush(out)?)
}

fn flag(yes: bool) -> Value {
    Value::Count(u64::from(yes))
}

fn test_row(t: &Test) -> Row {
    let limit = t.limit_force.unwrap_or(f64::NAN);
    vec![
        ("grain", u64::from(t.grain).into()),
        ("diameter_mm", (1e3 * t.diameter).into()),
        ("force_N", t.force.into()),
        ("censored", flag(!t.broken)),
        ("displacement_mm", (1e3 * t.displacement).into()),
        ("strength_MPa", (1e-6 * t.strength).into()),
        ("limit_force_N", limit.into()),
        ("overshoot", if t.broken { t.force / limit - 1.0 } else { f64::NAN }.into()),
        ("largest_hertz_deviation", t.deviation.into()),
        ("largest_platen_difference", t.difference.into()),
        ("steps", t.steps.into()),
    ]
}

fn curve_rows(t: &Test, e_eff: f64) -> Vec<Row> {
    let row = |p: &crate::rig::grain_crushing::Point| -> Row {
        let expected = hertz(e_eff, 0.5 * t.diameter, p.displacement);
        vec![
            ("grain", u64::from(t.grain).into()),
            ("diameter_mm", (1e3 * t.diameter).into()),
            ("displacement_mm", (1e3 * p.displacement).into()),
            ("force_bottom_N", p.bottom.into()),
            ("force_top_N", p.top.into()),
            ("force_hertz_N", expected.into()),
        ]
    };
    t.curve.iter().map(row).collect()
}

/// Tests of one diameter, or of a class of a gradation.
struct Class<'a> {
    from: f64,
    to: f64,
    tests: Vec<&'a Test>,
}

fn classes<'a>(rig: &GrainCrushing, tests: &'a [Test]) -> Vec<Class<'a>> {
    let mut sorted: Vec<&Test> = tests.iter().collect();
    sorted.sort_by(|a, b| a.diameter.total_cmp(&b.diameter).then(a.grain.cmp(&b.grain)));
    let parts: Vec<Vec<&Test>> = if rig.graded {
        sorted.chunks(sorted.len().div_ceil(CLASSES)).map(<[_]>::to_vec).collect()
    } else {
        sorted.chunk_by(|a, b| a.diameter == b.diameter).map(<[_]>::to_vec).collect()
    };
    let class = |tests: Vec<&'a Test>| Class {
        from: tests.first().map_or(f64::NAN, |t| t.diameter),
        to: tests.last().map_or(f64::NAN, |t| t.diameter),
        tests,
    };
    parts.into_iter().map(class).collect()
}

/// Rows of `survival.csv`: for each force at which a grain of the class broke the share of grains that bear more. This is the
/// product-limit estimate (Kaplan & Meier 1958), in which an unbroken grain counts up to its largest force. Beside it stands the
/// share by the strength distribution of the model, for a class of one diameter.
fn survival_rows(model: &Model, rig: &GrainCrushing, class: &Class) -> Vec<Row> {
    let mut tests = class.tests.clone();
    // at the same force the broken ones come first
    tests.sort_by(|a, b| a.force.total_cmp(&b.force).then(b.broken.cmp(&a.broken)));
    let mut survival = 1.0;
    let mut rows = Vec::new();
    for (i, t) in tests.iter().enumerate().filter(|(_, t)| t.broken) {
        survival *= 1.0 - 1.0 / (tests.len() - i) as f64;
        let law =
            model.physics.crush.as_ref().filter(|_| class.from == class.to).map_or(f64::NAN, |c| survival_of_law(c, model, rig, t));
        rows.push(vec![
            ("diameter_from_mm", (1e3 * class.from).into()),
            ("diameter_to_mm", (1e3 * class.to).into()),
            ("force_N", t.force.into()),
            ("survival", survival.into()),
            ("survival_law", law.into()),
        ]);
    }
    rows
}

/// Share of grains of the diameter of `t` whose limit force is larger than the force at which `t` broke, by the model's
/// distribution.
fn survival_of_law(crush: &CrushModel, model: &Model, rig: &GrainCrushing, t: &Test) -> f64 {
    let mean = mean_limit(crush, t.diameter, pair(model, rig).e_eff);
    // the force goes with the strength or with its cube
    let ratio = if crush.criterion.power() == 3 { (t.force / mean).cbrt() } else { t.force / mean };
    1.0 - crush.strength.share_weaker(ratio)
}

/// Limit force, N, of a grain of diameter `d`, m, with the mean strength of its size (Ciantia et al. 2015, eqs 16 and 17).
fn mean_limit(crush: &CrushModel, d: f64, e_eff: f64) -> f64 {
    let s = &crush.strength;
    crush.criterion.limit_force(s.sigma_lim0 * size_factor(d, s.d0, s.m), d, 0.5 * d, e_eff)
}

/// Rows of `limit_force.csv`: limit force against diameter, for the mean strength and for the quantiles [`BAND`] of strength.
fn limit_rows(crush: &CrushModel, rig: &GrainCrushing, e_eff: f64) -> Vec<Row> {
    let (low, high) = rig.diameters.iter().fold((f64::INFINITY, 0.0f64), |(low, high), d| (low.min(*d), high.max(*d)));
    let (low, high) = ((low / BEYOND).max(crush.d_limit), high * BEYOND);
    if low >= high {
        return Vec::new();
    }
    let [a, b, c] = BAND.map(|p| crush.strength.ratio_of_share(p));
    let row = |i: usize| -> Row {
        let d = low * (high / low).powf(i as f64 / (SIZES - 1) as f64);
        let mean = mean_limit(crush, d, e_eff);
        let at = |ratio: f64| (0..crush.criterion.power()).fold(mean, |force, _| force * ratio);
        vec![
            ("diameter_mm", (1e3 * d).into()),
            ("at_mean_strength_N", mean.into()),
            ("weakest_5_percent_N", at(a).into()),
            ("median_N", at(b).into()),
            ("strongest_5_percent_N", at(c).into()),
        ]
    };
    (0..SIZES).map(row).collect()
}
