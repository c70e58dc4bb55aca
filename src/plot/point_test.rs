//! Figures of a point test: stress against strain, volumetric strain, and the path in p and q with the yield line.

use super::axis::{Axis, significant};
use super::colour;
use super::error::{FigureError, Result};
use super::plot::{Mark, Plot, Series};
use super::table::Table;
use std::path::{Path, PathBuf};

/// Names of the figures of all paths.
const NAMES: [&str; 6] = ["deviatoric_stress", "volumetric_strain", "stress_path", "axial_stress", "shear_stress", "mean_stress"];
/// End of a yield line over the largest mean stress: above 1, so that the line can be seen beyond
/// the paths.
const BEYOND: f64 = 1.05;

/// Every file that figures of point tests may have in `dir`.
pub fn files(dir: &Path) -> Vec<PathBuf> {
    NAMES.iter().flat_map(|n| ["svg", "png", "csv"].map(|e| dir.join(format!("{n}.{e}")))).collect()
}

/// One test: the rows `first..end` of the table, and its legend entry.
struct Test {
    label: String,
    first: usize,
    end: usize,
}

struct Records {
    table: Table,
    tests: Vec<Test>,
    title: Vec<String>,
    path: String,
}

/// Draws `dir/figures` from `history.csv` and `summary.json` of a point test.
pub fn draw(dir: &Path) -> Result<Vec<PathBuf>> {
    let records = read(dir)?;
    let axial = || Axis::linear("axial strain ε_{a} (%)", "axial_strain_percent").including(&[0.0]);
    let gamma = || Axis::linear("shear strain γ (%)", "shear_strain_percent").including(&[0.0]);
    let stress = |label: &str, column: &str| Axis::linear(label, column).including(&[0.0]);
    let mut plots = match records.path.as_str() {
        "oedometer" => {
            let axes = (stress("axial stress σ_{a} (kPa)", "sigma_axial_kPa"), axial().downwards());
            vec![records.curves("axial_stress", ("sigma_axial_kPa", "axial_strain"), axes)?]
        }
        "simple_shear" => {
            let tau = (gamma(), stress("shear stress τ (kPa)", "tau_kPa"));
            let mean = (gamma(), stress("mean stress p (kPa)", "p_kPa"));
            vec![
                records.curves("shear_stress", ("shear_strain", "tau_kPa"), tau)?,
                records.curves("mean_stress", ("shear_strain", "p_kPa"), mean)?,
            ]
        }
        _ => {
            let q = (axial(), stress("deviatoric stress q (kPa)", "q_kPa"));
            let volume = Axis::linear("volumetric strain ε_{v} (%)", "volumetric_strain_percent").including(&[0.0]).downwards();
            vec![
                records.curves("deviatoric_stress", ("axial_strain", "q_kPa"), q)?,
                records.curves("volumetric_strain", ("axial_strain", "volumetric_strain"), (axial(), volume))?,
            ]
        }
    };
    plots.push(records.stress_path()?);
    let mut files = Vec::new();
    for plot in plots {
        files.extend(plot.draw(&dir.join("figures"))?);
    }
    Ok(files)
}

fn read(dir: &Path) -> Result<Records> {
    let path = dir.join("summary.json");
    let text = std::fs::read_to_string(&path).map_err(|e| FigureError::io(&path, e))?;
    let summary: serde_json::Value = serde_json::from_str(&text).map_err(|e| FigureError::io(&path, e))?;
    let table = Table::read(&dir.join("history.csv"))?;
    let confining = table.numbers("confining_kPa")?;
    let mut tests: Vec<Test> = Vec::new();
    for (i, stress) in confining.iter().enumerate() {
        if i == 0 || *stress != confining[i - 1] {
            tests.push(Test { label: format!("{} kPa", significant(*stress, 6)), first: i, end: i });
        }
        if let Some(test) = tests.last_mut() {
            test.end = i + 1;
        }
    }
    let path = summary["path"].as_str().unwrap_or("").to_string();
    let what = match (path.as_str(), summary["strain"].as_f64().unwrap_or(0.0) < 0.0) {
        ("triaxial", false) => "drained triaxial compression",
        ("triaxial", true) => "drained triaxial extension",
        ("simple_shear", _) => "simple shear at constant volume",
        (path, _) => path,
    };
    let title = vec![summary["material"].as_str().unwrap_or("").to_string(), what.to_string(), "one point".to_string()];
    Ok(Records { table, tests, title, path })
}

impl Records {
    /// One curve of each test; strains in per cent.
    fn curves(&self, name: &str, (x, y): (&str, &str), (x_axis, y_axis): (Axis, Axis)) -> Result<Plot> {
        let column = |name: &str| -> Result<Vec<f64>> {
            let factor = if name.ends_with("strain") { 100.0 } else { 1.0 };
            Ok(self.table.numbers(name)?.into_iter().map(|v| factor * v).collect())
        };
        let (xs, ys) = (column(x)?, column(y)?);
        let series = self.tests.iter().enumerate().map(|(i, t)| self.series(i, t, &xs, &ys)).collect();
        let legend_title = Some(if self.path == "triaxial" { "cell pressure" } else { "initial stress" }.into());
        Ok(Plot { name: name.into(), title: self.title.clone(), legend_title, x: x_axis, y: y_axis, series, equal: false })
    }

    fn series(&self, i: usize, test: &Test, xs: &[f64], ys: &[f64]) -> Series {
        let points = (test.first..test.end).map(|k| (xs[k], ys[k])).collect();
        Series::line(&test.label, colour::kind(i), colour::dash(i), points)
    }

    /// q against p, with the yield line at the largest and at the last strength.
    fn stress_path(&self) -> Result<Plot> {
        let (p, q) = (self.table.numbers("p_kPa")?, self.table.numbers("q_kPa")?);
        let mut series = Vec::new();
        let end = BEYOND * p.iter().copied().filter(|p| p.is_finite()).fold(0.0, f64::max);
        let sign = if q.iter().sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
        for (i, (name, slope, intercept)) in self.yield_lines()?.into_iter().enumerate() {
            let lowest = p.iter().copied().fold(0.0, f64::min);
            let from = if slope > 0.0 { (-intercept / slope).max(BEYOND * lowest) } else { lowest };
            series.push(Series {
                label: Some(name.clone()),
                name,
                colour: if i == 0 { colour::INK } else { colour::GREY },
                mark: Mark::Guide(&[]),
                x: vec![from, end],
                y: vec![sign * (slope * from + intercept), sign * (slope * end + intercept)],
            });
        }
        series.extend(self.tests.iter().enumerate().map(|(i, t)| self.series(i, t, &p, &q)));
        let q = if self.path == "simple_shear" { "q = √(3 J_{2}) (kPa)" } else { "q = σ_{a} − σ_{l} (kPa)" };
        Ok(Plot {
            name: "stress_path".into(),
            title: self.title.clone(),
            legend_title: None,
            x: Axis::linear("mean stress p (kPa)", "p_kPa").including(&[0.0]),
            y: Axis::linear(q, "q_kPa").including(&[0.0]),
            series,
            equal: false,
        })
    }

    /// Name, slope and intercept, kPa, of the yield lines to draw: the line of the row with the
    /// largest strength (compared at p = 100 kPa), and the line of the last row if its strength
    /// differs.
    fn yield_lines(&self) -> Result<Vec<(String, f64, f64)>> {
        let (slopes, intercepts) = (self.table.numbers("yield_slope")?, self.table.numbers("yield_intercept_kPa")?);
        let (angles, cohesions) = (self.table.numbers("friction_angle_deg")?, self.table.numbers("cohesion_kPa")?);
        let strength = |i: usize| slopes[i] * 100.0 + intercepts[i];
        let all = (0..slopes.len()).filter(|i| slopes[*i].is_finite());
        let Some(strongest) = all.clone().max_by(|a, b| strength(*a).total_cmp(&strength(*b)).then(b.cmp(a))) else {
            return Ok(Vec::new());
        };
        let last = slopes.len() - 1;
        let line = |what: &str, i: usize| {
            let mut name = format!("{what}: φ = {}°", significant(angles[i], 3));
            if cohesions[i] > 0.0 {
                name += &format!(", c = {} kPa", significant(cohesions[i], 3));
            }
            (name, slopes[i], intercepts[i])
        };
        let same = |i: usize| (strength(i) - strength(strongest)).abs() < 1e-3 * strength(strongest);
        if same(last) && same(0) {
            return Ok(vec![line("yield", strongest)]);
        }
        let mut out = vec![line("yield, strongest", strongest)];
        if !same(last) {
            out.push(line("yield, at the end", last));
        }
        Ok(out)
    }
}
