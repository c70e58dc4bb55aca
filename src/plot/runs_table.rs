//! A table with one row for each run, from its `summary.json`, written beside figures of several
//! runs.

use super::error::{FigureError, Result};
use super::run::{folders_apart, read_summary};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Each column, and the JSON pointer to its value in `summary.json`.
const COLUMNS: [(&str, &str); 35] = [
    ("scene", "/scene"),
    ("seed_packing", "/seed/packing"),
    ("seed_strength", "/seed/strength"),
    ("scale", "/scale"),
    ("height_mm", "/height_mm"),
    ("max_stress_kPa", "/max_stress_kPa"),
    ("points", "/points"),
    ("grains", "/grains"),
    ("coarse_mass_fraction", "/coarse_mass_fraction"),
    ("grains_initial", "/grains_initial"),
    ("crush_events", "/crush_events"),
    ("grains_final", "/grains_final"),
    ("excluded_grains", "/excluded_grains"),
    ("void_ratio_final", "/void_ratio_final"),
    ("porosity_final", "/porosity_final"),
    ("below_least_void_ratio_kPa", "/below_least_void_ratio/sigma_v_kPa"),
    ("hardin_br", "/hardin_br"),
    ("einav_br", "/einav_br"),
    ("k0_final", "/k0_final"),
    ("cell_pressure_kPa", "/cell_pressure_kPa"),
    ("peak_stress_ratio", "/peak_stress_ratio"),
    ("peak_axial_strain", "/peak_axial_strain"),
    ("residual_stress_ratio", "/residual_stress_ratio"),
    ("mass_error", "/mass_error"),
    ("dissipated_share", "/dissipated_share"),
    ("energy_error", "/energy_error"),
    ("energy_nonconservative", "/energy_nonconservative"),
    ("largest_platen_difference", "/quasi_static/largest_platen_difference"),
    ("largest_distance_from_target", "/quasi_static/largest_distance_from_target"),
    ("largest_inertial_number", "/quasi_static/largest_inertial_number"),
    ("steps", "/steps"),
    ("grain_steps", "/grain_steps"),
    ("continuum_steps", "/continuum_steps"),
    ("user_seconds", "/user_seconds"),
    ("wall_seconds", "/wall_seconds"),
];

/// Writes `runs.csv` with a row for each run that has a summary, named by the run's folder (and as much of its path as tells it from the others), and
/// with the columns that at least one run fills. Returns the path, or `None` if no run has a
/// summary.
pub fn write(dirs: &[PathBuf], out: &Path) -> Result<Option<PathBuf>> {
    let mut rows = Vec::new();
    for (dir, name) in dirs.iter().zip(folders_apart(dirs)) {
        let summary = read_summary(&dir.join("summary.json"))?;
        if summary.is_object() {
            rows.push((name, COLUMNS.map(|(_, at)| text(summary.pointer(at)))));
        }
    }
    if rows.is_empty() {
        return Ok(None);
    }
    let filled: Vec<usize> = (0..COLUMNS.len()).filter(|&k| rows.iter().any(|(_, row)| !row[k].is_empty())).collect();
    let line = |name: &str, of: &dyn Fn(usize) -> String| {
        let cells: Vec<String> = std::iter::once(name.to_string()).chain(filled.iter().map(|&k| of(k))).collect();
        cells.join(",") + "\n"
    };
    let mut body = line("run", &|k| COLUMNS[k].0.to_string());
    rows.iter().for_each(|(name, row)| body += &line(name, &|k| row[k].clone()));
    let path = out.join("runs.csv");
    table::write(&path, body).map_err(|e| FigureError::io(&path, e))?;
    Ok(Some(path))
}

/// A value as text: whole numbers unchanged, others rounded to six decimals or, if smaller than
/// 0.001, written with three significant digits and a power of ten; empty for a missing value.
fn text(value: Option<&Value>) -> String {
    match value {
        Some(Value::String(s)) => s.clone(),
        Some(Value::Number(n)) if n.is_f64() => {
            let x = n.as_f64().unwrap_or(f64::NAN);
            if x != 0.0 && x.abs() < 1e-3 { format!("{x:.2e}") } else { format!("{}", (x * 1e6).round() / 1e6) }
        }
        Some(Value::Number(n)) => n.to_string(),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_a_line_and_a_folder_without_summary_is_none() {
        let dir = tempfile::tempdir().expect("folder");
        let run = dir.path().join("a");
        std::fs::create_dir(&run).expect("folder");
        std::fs::write(run.join("summary.json"), r#"{"scene":"H-C-2","crush_events":3,"k0_final":0.5,"mass_error":1e-15}"#)
            .expect("file");
        let path = write(&[run, dir.path().join("b")], dir.path()).expect("table").expect("one run");
        let text = std::fs::read_to_string(path).expect("text");
        assert_eq!(text.lines().count(), 2);
        assert!(text.lines().nth(1).expect("row").starts_with("a,H-C-2,3,0.5,1.00e-15"));
        assert!(text.starts_with("run,scene,crush_events,k0_final,mass_error\n"));
        assert!(write(&[dir.path().join("b")], dir.path()).expect("none").is_none());
    }
}
