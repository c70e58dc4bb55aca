//! The values of a run at the points of a target.

use super::target::{Block, Kind, Target};
use crate::columns::Columns;
use std::path::Path;

/// Largest distance, as a share of the stress of a point, by which a run may end below the point
/// and still have a value there.
const SHORT: f64 = 0.03;

/// Reads the value of the run in the folder `dir` for each point of the target; the error names the
/// value that is missing.
pub fn of_run(dir: &Path, target: &Target) -> Result<Vec<f64>, String> {
    let mut out = Vec::new();
    let history = Columns::read(&dir.join("history.csv")).map_err(|e| e.to_string())?;
    for block in &target.blocks {
        match block.kind {
            Kind::History(column) => out.extend(against_stress(&history, column, &block.at)?),
            Kind::Gradation(sigma) => out.extend(gradation(dir, sigma, block)?),
        }
    }
    Ok(out)
}

/// Values of a column at the stresses `at`, kPa, on first loading (from the last row of settling
/// on), interpolated linearly in the logarithm of stress.
fn against_stress(history: &Columns, column: &str, at: &[f64]) -> Result<Vec<f64>, String> {
    let numbers = |name: &str| history.numbers(name, 1.0).map_err(|e| e.to_string());
    let (stress, values) = (numbers("sigma_v_kPa")?, numbers(column)?);
    let stage = history.texts("stage");
    let start = stage.iter().rposition(|s| *s == "settle").unwrap_or(0);
    let mut points: Vec<(f64, f64)> = (start..stage.len())
        .filter(|&i| i == start || stage[i] == "load")
        .filter_map(|i| Some((stress[i].filter(|s| *s > 0.0)?.ln(), values[i]?)))
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.dedup_by(|b, a| a.0 == b.0);
    let last = points.last().map_or(0.0, |p| p.0.exp());
    at.iter()
        .map(|&sigma| {
            if last < sigma * (1.0 - SHORT) {
                return Err(format!("the run ended at {last:.0} kPa, before {sigma} kPa"));
            }
            interpolate(&points, sigma.ln()).ok_or_else(|| format!("no {column} at {sigma} kPa"))
        })
        .collect()
}

/// Per cent passing at the sizes of `block`, interpolated linearly in the logarithm of size, from
/// the recorded gradation whose stress is nearest to `sigma`, kPa, and within about 10 % of it.
fn gradation(dir: &Path, sigma: f64, block: &Block) -> Result<Vec<f64>, String> {
    let table = Columns::read(&dir.join("gsd.csv")).map_err(|e| e.to_string())?;
    let numbers = |name: &str| table.numbers(name, 1.0).map_err(|e| e.to_string());
    let (stress, size, passing) = (numbers("sigma_v_kPa")?, numbers("diameter_mm")?, numbers("passing_percent")?);
    let rows: Vec<(f64, f64, f64)> = (0..stress.len()).filter_map(|i| Some((stress[i]?, size[i]?, passing[i]?))).collect();
    let near = |s: f64| (s / sigma).ln().abs();
    let record = rows.iter().map(|r| r.0).min_by(|a, b| near(*a).total_cmp(&near(*b)));
    let record = record.filter(|s| near(*s) < 0.1).ok_or_else(|| format!("no gradation near {sigma} kPa"))?;
    let mut points: Vec<(f64, f64)> = rows.iter().filter(|r| r.0 == record).map(|r| (r.1.ln(), r.2)).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    block.at.iter().map(|d| interpolate(&points, d.ln()).ok_or_else(|| "an empty gradation".to_string())).collect()
}

/// Diameter of the largest grain of any record, mm.
pub fn largest_grain(dir: &Path) -> Result<f64, String> {
    let table = Columns::read(&dir.join("gsd.csv")).map_err(|e| e.to_string())?;
    let sizes = table.numbers("diameter_mm", 1.0).map_err(|e| e.to_string())?;
    Ok(sizes.into_iter().flatten().fold(0.0, f64::max))
}

/// Linear interpolation between points with rising x; beyond the ends the value of the end; `None`
/// without points.
fn interpolate(points: &[(f64, f64)], x: f64) -> Option<f64> {
    let i = points.partition_point(|p| p.0 < x);
    match (i.checked_sub(1).and_then(|j| points.get(j)), points.get(i)) {
        (Some(a), Some(b)) => Some(a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0)),
        (Some(p), None) | (None, Some(p)) => Some(p.1),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::target::from_text;

    #[test]
    fn a_run_is_read_at_the_points_of_the_curve() {
        let dir = tempfile::tempdir().expect("folder");
        let history = "stage,sigma_v_kPa,void_ratio,k0\nsettle,4,0.9,1\nsettle,10,0.8,1\nload,1000,0.6,0.5\nload,10000,0.4,0.6\nunload,10,0.5,2\n";
        std::fs::write(dir.path().join("history.csv"), history).expect("history");
        let target = |text: &str| from_text(text, 5.0).expect("target");
        let t = target("sigma_v_kPa,void_ratio\n10,0.8\n100,0.7\n1000,0.6\n10100,0.5\n");
        let values = of_run(dir.path(), &t).expect("values");
        for (value, wanted) in values.iter().zip([0.8, 0.7, 0.6, 0.4]) {
            assert!((value - wanted).abs() < 1e-12, "{values:?}");
        }
        let t = target("sigma_v_kPa,void_ratio\n10,0.8\n100,0.7\n1000,0.6\n20000,0.5\n");
        assert!(of_run(dir.path(), &t).expect_err("short").contains("ended at 10000 kPa"));
        assert!(of_run(&dir.path().join("none"), &t).is_err());
    }
}
