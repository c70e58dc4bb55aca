//! Single numbers: each that a paper states beside the one that a run shows, and power laws fitted through several.

use super::{Comparison, runs};
use crate::reproduce::plan::{Fit, Number, Plan};
use crate::reproduce::report::cell;
use crate::reproduce::results::{Done, Spread};
use laboratory::error::{Error, Result};
use plot::significant;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use table::number;

/// Columns of `runs.csv`, and where their values stand in a summary.
const RUNS: [(&str, &str); 7] = [
    ("seed", "/seed/packing"),
    ("points", "/points"),
    ("grains", "/grains"),
    ("blocks", "/blocks"),
    ("steps", "/steps"),
    ("time_s", "/time_s"),
    ("wall_seconds", "/wall_seconds"),
];

/// Compares single numbers.
pub struct Numbers;

impl Comparison for Numbers {
    fn compare(&self, plan: &Plan, done: &[Done], dir: &Path) -> Result<(Vec<PathBuf>, String)> {
        let found = plan.numbers.iter().map(|n| Ok((n, n.found(done)?))).collect::<Result<Vec<_>>>()?;
        let tables = vec![write(&found, &dir.join("comparison.csv"))?, runs::write(done, &RUNS, &dir.join("runs.csv"))?];
        Ok((tables, text(&found) + &fits(&plan.fits, &found)))
    }
}

/// A number of the plan with what its run shows, over the seeds.
type Found<'a> = (&'a Number, Option<Spread>);

impl Number {
    /// What the run shows, over its seeds; `None` if it is not done.
    ///
    /// # Errors
    /// A table that cannot be read or lacks a column.
    pub fn found(&self, done: &[Done]) -> Result<Option<Spread>> {
        let folders = done.iter().find(|d| d.id == self.run).map(Done::folders).unwrap_or_default();
        let of = |folder: &PathBuf| Ok(self.take.of(&self.from.read(folder, [&self.value])?));
        let values = folders.iter().map(of).collect::<Result<Vec<_>>>()?;
        Ok(Spread::of(&values.into_iter().flatten().collect::<Vec<_>>()))
    }
}

/// Writes a line for every number.
fn write(found: &[Found<'_>], path: &Path) -> Result<PathBuf> {
    let failed = |e: csv::Error| Error::Write { path: path.into(), source: e.into() };
    let mut file = csv::Writer::from_path(path).map_err(failed)?;
    file.write_record(["number", "unit", "run", "series", "at", "paper", "here", "sd", "least", "most", "seeds"])
        .map_err(failed)?;
    for (n, here) in found {
        let maybe = |x: Option<f64>| x.filter(|x| x.is_finite()).map_or(String::new(), number);
        let of = |part: fn(&Spread) -> f64| maybe(here.as_ref().map(part));
        let seeds = here.map_or(0, |s| s.of).to_string();
        let [mean, sd, least, most] = [of(|s| s.mean), of(|s| s.sd), of(|s| s.least), of(|s| s.most)];
        let series = n.series.clone().unwrap_or_default();
        let row =
            [n.what.clone(), n.unit.clone(), n.run.clone(), series, maybe(n.at), maybe(n.paper), mean, sd, least, most, seeds];
        file.write_record(row).map_err(failed)?;
    }
    file.flush().map_err(Error::write(path))?;
    Ok(path.into())
}

/// Table of all numbers.
fn text(found: &[Found<'_>]) -> String {
    let mut out = String::from("| number | paper | here | here over paper |\n|---|---|---|---|\n");
    for (n, here) in found {
        let with_unit = |x: String| if n.unit.is_empty() { x } else { format!("{x} {}", n.unit) };
        let few = |x: f64| significant(x, 4);
        let shown = match here {
            None => "not done".into(),
            Some(s) if s.of == 1 => with_unit(few(s.mean)),
            Some(s) => with_unit(format!("{} ({} to {})", few(s.mean), few(s.least), few(s.most))),
        };
        let ratio =
            n.paper.zip(*here).filter(|(paper, _)| *paper != 0.0).map_or("–".into(), |(paper, s)| significant(s.mean / paper, 3));
        let paper = n.paper.map_or("–".into(), |x| with_unit(few(x)));
        let _ = writeln!(out, "| {} | {paper} | {shown} | {ratio} |", cell(&n.what));
    }
    out + "\n"
}

/// Table of the power laws.
fn fits(fits: &[Fit], found: &[Found<'_>]) -> String {
    if fits.is_empty() {
        return String::new();
    }
    let mut out = String::from(
        "| power law | exponent, paper | fitted | factor, paper | fitted | scatter about the fit |\n|---|---|---|---|---|---|\n",
    );
    for fit in fits {
        let few = |x: Option<f64>| x.map_or("–".into(), |x| significant(x, 3));
        let [exponent, factor, scatter] = fit.through(found).map_or([None; 3], |found| found.map(Some));
        let scatter = scatter.map_or("–".into(), |x| format!("{} %", significant(100.0 * x, 2)));
        let [of_paper, factor_of_paper] = [fit.exponent, fit.factor].map(few);
        let _ = writeln!(
            out,
            "| {} | {of_paper} | {} | {factor_of_paper} | {} | {scatter} |",
            cell(&fit.what),
            few(exponent),
            few(factor)
        );
    }
    out + "\n"
}

impl Fit {
    /// Exponent and factor of the power law through the numbers of the series, by least squares in logarithms, and the standard deviation of the
    /// logarithms about it; `None` with less than three numbers.
    fn through(&self, found: &[Found<'_>]) -> Option<[f64; 3]> {
        let of = found.iter().filter(|(n, _)| n.series.as_ref() == Some(&self.series));
        let (at, values): (Vec<f64>, Vec<f64>) = of.filter_map(|(n, here)| Some((n.at?, here.as_ref()?.mean))).unzip();
        let base = self.base.along("x", at.into_iter()).ok()?;
        power(&base.iter().map(|(_, u)| *u).zip(values).collect::<Vec<_>>())
    }
}

/// n, c and the scatter of y = c u^n through the pairs (u, y); `None` with less than three, or where one is not positive.
fn power(pairs: &[(f64, f64)]) -> Option<[f64; 3]> {
    if pairs.len() < 3 || pairs.iter().any(|&(u, y)| !(u > 0.0 && y > 0.0)) {
        return None;
    }
    let logs: Vec<(f64, f64)> = pairs.iter().map(|&(u, y)| (u.ln(), y.ln())).collect();
    let n = logs.len() as f64;
    let (mx, my) = logs.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (xy, xx) = logs.iter().fold((0.0, 0.0), |(xy, xx), (x, y)| (xy + (x - mx) * (y - my), xx + (x - mx) * (x - mx)));
    let slope = xy / xx;
    let square: f64 = logs.iter().map(|(x, y)| (y - my - slope * (x - mx)).powi(2)).sum();
    Some([slope, (my - slope * mx).exp(), (square / (n - 2.0)).sqrt()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_found_again() {
        let exact: Vec<(f64, f64)> = [0.5, 1.0, 2.0, 4.0].map(|u: f64| (u, 3.0 * u.powf(1.5))).into();
        let [n, c, scatter] = power(&exact).expect("a law");
        assert!((n - 1.5).abs() < 1e-12 && (c - 3.0).abs() < 1e-12 && scatter < 1e-12);
        assert_eq!(power(&exact[..2]), None);
        assert_eq!(power(&[(1.0, 1.0), (2.0, -1.0), (3.0, 1.0)]), None);
    }
}
