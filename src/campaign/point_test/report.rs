//! Files of a point test: `history.csv`, `summary.json`, the material with its defaults, figures.

use super::{Path as Way, Row, Settings, Test};
use engine::mpm::law::Law;
use laboratory::error::{Error, Result};
use laboratory::scene::ContinuumMaterial;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use table::{Row as Record, Table};

/// Table of all tests.
pub const HISTORY: &str = "history.csv";
/// Results of the tests.
pub const SUMMARY: &str = "summary.json";
/// The material with all overrides and defaults: a point test of this file gives the same results.
pub const MATERIAL: &str = "material.resolved.toml";
/// Folder of the figures.
pub const FIGURES: &str = "figures";

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Makes the folder `out`, without files of an older test. A folder that is not empty is refused
/// unless `force` is given.
///
/// # Errors
/// [`Error::Exists`], a file in the place of the folder, or a folder that cannot be made.
pub fn claim(out: &Path, force: bool) -> Result<()> {
    if out.is_file() {
        return Err(Error::input(out.display(), "", None, "is a file, not a folder"));
    }
    let occupied = out.read_dir().is_ok_and(|mut entries| entries.next().is_some());
    if occupied && !force {
        return Err(Error::Exists { path: out.into() });
    }
    for name in [HISTORY, SUMMARY, MATERIAL] {
        let path = out.join(name);
        if path.is_file() {
            fs::remove_file(&path).map_err(Error::write(&path))?;
        }
    }
    for path in plot::point_test_files(&out.join(FIGURES)) {
        if path.is_file() {
            fs::remove_file(&path).map_err(Error::write(&path))?;
        }
    }
    fs::create_dir_all(out).map_err(Error::write(out))
}

/// Writes all files into `out`; returns the figures.
///
/// # Errors
/// Files that cannot be written.
pub fn write(material: &ContinuumMaterial, settings: &Settings, tests: &[Test], out: &Path) -> Result<Vec<PathBuf>> {
    let mut history = Table::new(HISTORY);
    for test in tests {
        for row in &test.rows {
            history.push(out, &record(&material.law, test, row))?;
        }
    }
    history.flush(out)?;
    let put = |name: &str, text: String| {
        let path = out.join(name);
        fs::write(&path, text).map_err(Error::write(&path))
    };
    put(MATERIAL, material.resolved.clone())?;
    put(SUMMARY, format!("{:#}\n", summary(material, settings, tests)))?;
    Ok(plot::draw_point_test(out)?)
}

fn record(law: &Law, test: &Test, row: &Row) -> Record {
    let kpa = |x: f64| (1e-3 * x).into();
    let or_none = |x: Option<f64>| x.unwrap_or(f64::NAN).into();
    let strength = law.shear_strength(row.plastic_strain);
    let (angle, cohesion) = (strength.map(|[angle, _]| angle / DEGREE), strength.map(|[_, cohesion]| 1e-3 * cohesion));
    vec![
        ("confining_kPa", kpa(test.confining)),
        ("step", u64::from(row.step).into()),
        ("axial_strain", row.axial_strain.into()),
        ("lateral_strain", row.lateral_strain.into()),
        ("shear_strain", row.shear_strain.into()),
        ("volumetric_strain", row.volumetric_strain.into()),
        ("sigma_axial_kPa", kpa(row.axial)),
        ("sigma_lateral_kPa", kpa(row.lateral)),
        ("tau_kPa", kpa(row.shear)),
        ("p_kPa", kpa(row.p)),
        ("q_kPa", kpa(row.q)),
        ("stress_ratio", or_none(row.stress_ratio)),
        ("plastic_strain", row.plastic_strain.into()),
        ("friction_angle_deg", or_none(angle)),
        ("cohesion_kPa", or_none(cohesion)),
        // sqrt(3 J2) at yield = slope p + intercept
        ("yield_slope", or_none(row.strength.map(|s| 3.0 * 3f64.sqrt() * s.alpha))),
        ("yield_intercept_kPa", or_none(row.strength.map(|s| 1e-3 * s.q_at(0.0)))),
    ]
}

/// Results of the tests as one JSON object; a result without a value is null.
pub fn summary(material: &ContinuumMaterial, settings: &Settings, tests: &[Test]) -> Value {
    let each: Vec<Value> = tests.iter().map(|t| one(&material.law, settings, t)).collect();
    let largest = |key: &str| each.iter().filter_map(|t| t[key].as_f64()).reduce(f64::max);
    json!({
        "material": material.name,
        "law": material.law.word(),
        "cone": material.law.cone().map(|cone| cone.name()),
        "path": settings.path.name(),
        "strain": settings.strain,
        "steps": settings.steps,
        "peak_stress_ratio": largest("peak_stress_ratio"),
        "tests": each,
    })
}

fn one(law: &Law, settings: &Settings, test: &Test) -> Value {
    let last = test.rows[test.rows.len() - 1];
    let strain = |row: &Row| if settings.path == Way::SimpleShear { row.shear_strain } else { row.axial_strain };
    let by_ratio = test.rows.iter().filter(|r| r.stress_ratio.is_some());
    let peak = by_ratio.max_by(|a, b| a.stress_ratio.unwrap_or(0.0).total_cmp(&b.stress_ratio.unwrap_or(0.0)));
    let furthest = test.rows.iter().fold(last, |a, b| if b.q.abs() > a.q.abs() { *b } else { a });
    let angle = |row: &Row| law.shear_strength(row.plastic_strain).map(|[angle, _]| angle / DEGREE);
    let mut out = json!({
        "confining_kPa": 1e-3 * test.confining,
        "peak_stress_ratio": peak.and_then(|r| r.stress_ratio),
        "strain_at_peak": peak.map(strain),
        "friction_angle_at_peak_deg": peak.and_then(angle),
        "final_stress_ratio": last.stress_ratio,
        "peak_q_kPa": 1e-3 * furthest.q,
        "final_q_kPa": 1e-3 * last.q,
        "final_p_kPa": 1e-3 * last.p,
        "final_volumetric_strain": last.volumetric_strain,
        "final_plastic_strain": last.plastic_strain,
    });
    match settings.path {
        Way::Triaxial => {
            out["largest_cell_pressure_error_kPa"] = json!(1e-3 * test.cell_pressure_error);
            out["closed_form_peak_stress_ratio"] = json!(closed_form(law, test.confining, settings.strain));
        }
        Way::Oedometer => {
            out["final_k0"] = json!((last.axial > 0.0).then(|| last.lateral / last.axial));
            let first = test.rows[1];
            out["initial_modulus_MPa"] = json!(1e-6 * (first.axial - test.confining) / first.axial_strain);
        }
        Way::Isotropic | Way::Undrained => {}
        Way::SimpleShear => {
            let largest = test.rows.iter().map(|r| r.shear.abs()).fold(0.0, f64::max);
            out["largest_tau_kPa"] = json!(1e-3 * largest);
        }
    }
    out
}

/// Largest over smallest principal stress at failure, computed from the largest strength that the
/// law reaches; `None` unless the smallest stress is compressive.
fn closed_form(law: &Law, cell: f64, strain: f64) -> Option<f64> {
    let q = law.peak_q(cell, strain > 0.0)?;
    let (high, low) = if strain > 0.0 { (cell + q, cell) } else { (cell, cell - q) };
    (low > 0.0).then(|| high / low)
}
