//! Means of several runs: every column of their histories at common vertical stresses.

use super::error::{FigureError, Result};
use super::group::{edges, interpolate, rising};
use super::run::{Branch, Run};
use super::{canvas::Point, table::Table};
use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Stresses per decade at which means are taken: the same for every ensemble, so that two ensembles
/// can be compared row by row.
const PER_DECADE: f64 = 40.0;
/// Columns of a history that are not averaged.
const NOT_AVERAGED: [&str; 4] = ["step", "stage", "target_kPa", "sigma_v_kPa"];

/// Writes `mean.csv` into `out`: for each branch that all runs have, and at each stress, the mean,
/// the standard deviation (of the sample) and the lower and upper edge of the band (as figures draw
/// it) of each column that all histories have, with the number of runs. Writes nothing and returns
/// `None` unless every run has a history against stress.
pub fn write(dirs: &[PathBuf], out: &Path) -> Result<Option<PathBuf>> {
    let runs: Vec<History> = dirs.iter().map(|d| History::read(d)).collect::<Result<Vec<_>>>()?.into_iter().flatten().collect();
    let Some(first) = runs.first().filter(|_| runs.len() == dirs.len()) else {
        return Ok(None);
    };
    let averaged = |c: &&String| !NOT_AVERAGED.contains(&c.as_str()) && runs.iter().all(|r| r.table.has(c));
    let columns: Vec<&String> = first.table.headers().iter().filter(averaged).collect();
    let mut text = String::from("stage,sigma_v_kPa,runs");
    for c in &columns {
        let _ = write!(text, ",{c}_mean,{c}_sd,{c}_low,{c}_high");
    }
    text.push('\n');
    let common = runs.iter().map(|r| r.branches.len()).min().unwrap_or(0);
    for i in (0..common).take_while(|&i| runs.iter().all(|r| r.branches[i].stage == first.branches[i].stage)) {
        let curves = |column: &str| -> Result<Vec<Vec<Point>>> { runs.iter().map(|r| r.curve(i, column)).collect() };
        let at = stresses(&curves("sigma_v_kPa")?);
        let mut cells = Vec::new();
        for column in &columns {
            cells.push(statistics(&curves(column)?, &at));
        }
        for (k, x) in at.iter().enumerate() {
            let _ = write!(text, "{},{},{}", first.branches[i].stage, number(x.exp()), runs.len());
            for cells in &cells {
                let _ = write!(text, ",{}", cells[k].map(number).join(","));
            }
            text.push('\n');
        }
    }
    table::folder(out).map_err(|e| FigureError::io(out, e))?;
    let path = out.join("mean.csv");
    table::write(&path, text).map_err(|e| FigureError::io(&path, e))?;
    Ok(Some(path))
}

/// A history and the rows of its branches.
struct History {
    table: Table,
    /// Branches as points (vertical stress in kPa, step).
    branches: Vec<Branch>,
    /// Row of the table for each step; the last row where a step has two.
    rows: HashMap<u64, usize>,
}

impl History {
    /// The history of a run if it has one against stress.
    fn read(dir: &Path) -> Result<Option<History>> {
        let run = Run::read(dir)?;
        let branches = run.branches(("sigma_v_kPa", 1.0), ("step", 1.0))?;
        let Some(table) = run.history.filter(|_| !branches.is_empty()) else {
            return Ok(None);
        };
        let rows = table.numbers("step")?.iter().enumerate().map(|(row, step)| (*step as u64, row)).collect();
        Ok(Some(History { table, branches, rows }))
    }

    /// Points (ln σ_v, value of the column) along a branch, in rising order of σ_v.
    fn curve(&self, branch: usize, column: &str) -> Result<Vec<Point>> {
        let values = self.table.numbers(column)?;
        let points = self.branches[branch].points.iter();
        let points: Vec<Point> =
            points.filter_map(|(sigma, step)| Some((*sigma, values[*self.rows.get(&(*step as u64))?]))).collect();
        Ok(rising(&points, true))
    }
}

/// ln of the stresses at which means are taken: both ends of the range that all curves cover, and
/// the levels of [`PER_DECADE`] between them.
fn stresses(curves: &[Vec<Point>]) -> Vec<f64> {
    let Some((lo, hi)) = common(curves) else { return Vec::new() };
    let level = std::f64::consts::LN_10 / PER_DECADE;
    let (from, to) = ((lo / level).ceil() as i64, (hi / level).floor() as i64);
    let inner = (from..=to).map(|k| k as f64 * level).filter(|x| x - lo > 1e-6 && hi - x > 1e-6);
    std::iter::once(lo).chain(inner).chain((hi > lo).then_some(hi)).collect()
}

/// The range of abscissae that all curves cover; `None` if there is none.
fn common(curves: &[Vec<Point>]) -> Option<(f64, f64)> {
    let lo = curves.iter().map(|c| c.first().map_or(f64::INFINITY, |p| p.0)).fold(f64::NEG_INFINITY, f64::max);
    let hi = curves.iter().map(|c| c.last().map_or(f64::NEG_INFINITY, |p| p.0)).fold(f64::INFINITY, f64::min);
    (lo.is_finite() && hi.is_finite() && lo <= hi).then_some((lo, hi))
}

/// Mean, standard deviation, lower and upper edge of the band at each stress; NaN outside the range
/// that all curves cover.
fn statistics(curves: &[Vec<Point>], at: &[f64]) -> Vec<[f64; 4]> {
    let span = common(curves);
    at.iter()
        .map(|&x| {
            if span.is_none_or(|(lo, hi)| x < lo - 1e-6 || x > hi + 1e-6) {
                return [f64::NAN; 4];
            }
            let values: Vec<f64> = curves.iter().map(|c| interpolate(c, x)).collect();
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
            let [low, _, high] = edges(values);
            [mean, (squares / (n - 1.0)).sqrt(), low, high]
        })
        .collect()
}

fn number(x: f64) -> String {
    ::table::number(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(rows: &str) -> tempfile::TempDir {
        let dir = tempfile::tempdir().expect("folder");
        std::fs::write(dir.path().join("history.csv"), format!("step,stage,sigma_v_kPa,porosity,rare\n{rows}")).expect("history");
        dir
    }

    #[test]
    fn means_stand_at_common_stresses_branch_by_branch() {
        let a = run("1,settle,10,0.5,\n2,load,1000,0.3,1\n3,unload,100,0.4,1\n");
        let b = run("1,settle,10,0.7,\n2,load,2000,0.3,3\n3,unload,100,0.6,3\n");
        let dirs = [a.path().to_path_buf(), b.path().to_path_buf()];
        let path = write(&dirs, a.path()).expect("written").expect("a table");
        let table = Table::read(&path).expect("table");
        let (stage, sigma) = (table.texts("stage").expect("stage"), table.numbers("sigma_v_kPa").expect("stress"));
        let mean = table.numbers("porosity_mean").expect("mean");
        let sd = table.numbers("porosity_sd").expect("sd");
        assert_eq!((stage[0], sigma[0]), ("load", 10.0));
        assert!((mean[0] - 0.6).abs() < 1e-9 && (sd[0] - 0.02_f64.sqrt()).abs() < 1e-8);
        let last = stage.iter().rposition(|s| *s == "load").expect("load");
        assert!((sigma[last] - 1000.0).abs() < 1e-6, "the smaller of the two largest");
        // b at 1000 kPa, linear in the logarithm of stress
        let at = 0.7 - 0.4 * 100f64.log10() / 200f64.log10();
        assert!((mean[last] - 0.5 * (0.3 + at)).abs() < 1e-8);
        assert_eq!(table.numbers("porosity_low").expect("low")[0], 0.5);
        assert_eq!(table.numbers("runs").expect("runs")[0], 2.0);
        assert_eq!(stage.last(), Some(&"unload"));
        assert!((mean[stage.len() - 1] - mean[last]).abs() > 1e-3);
        // where a run's column has no value, the mean has none
        assert!(table.numbers("rare_mean").expect("rare")[0].is_nan());
    }

    #[test]
    fn one_run_has_no_spread_and_no_history_no_table() {
        let a = run("1,load,10,0.5,\n2,load,1000,0.3,1\n");
        let path = write(&[a.path().to_path_buf()], a.path()).expect("written").expect("a table");
        let table = Table::read(&path).expect("table");
        assert!(table.numbers("porosity_sd").expect("sd")[0].is_nan());
        let bare = tempfile::tempdir().expect("folder");
        assert_eq!(write(&[bare.path().to_path_buf()], bare.path()).expect("nothing"), None);
        assert_eq!(write(&[], bare.path()).expect("nothing"), None);
    }
}
