//! Triaxial tests: peak, end, volume and run time, and what the paper says of them.

use super::plastic_zone::around_grains;
use super::{Comparison, runs};
use crate::reproduce::plan::{Measure, Order, Plan, Statement};
use crate::reproduce::report::cell;
use crate::reproduce::results::{Done, Seed, Spread, loading};
use laboratory::error::{Error, Result};
use plot::significant;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use table::number;

/// Axial strain at the end of a test over which the residual stress ratio is averaged.
const RESIDUAL: f64 = 0.01;

/// Columns of `runs.csv`, and where their values stand in a summary.
const RUNS: [(&str, &str); 12] = [
    ("seed", "/seed/packing"),
    ("points", "/points"),
    ("grains", "/grains"),
    ("coarse_mass_fraction", "/coarse_mass_fraction"),
    ("steps", "/steps"),
    ("time_s", "/time_s"),
    ("peak_stress_ratio", "/peak_stress_ratio"),
    ("peak_axial_strain", "/peak_axial_strain"),
    ("void_ratio_final", "/void_ratio_final"),
    ("dissipated_share", "/dissipated_share"),
    ("largest_platen_difference", "/quasi_static/largest_platen_difference"),
    ("wall_seconds", "/wall_seconds"),
];

/// Compares triaxial tests.
pub struct Triaxial;

impl Comparison for Triaxial {
    fn compare(&self, plan: &Plan, done: &[Done], dir: &Path) -> Result<(Vec<PathBuf>, String)> {
        let around = plan.statements.iter().any(|s| s.of == Measure::PlasticStrainAroundGrains);
        let tests = all(done, around)?;
        let tables = vec![write(&tests, &dir.join("comparison.csv"))?, runs::write(done, &RUNS, &dir.join("runs.csv"))?];
        Ok((tables, overview(&tests) + &statements(&plan.statements, &tests)))
    }
}

/// What one run shows. Strains are those since the start of loading, compression positive.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shown {
    /// Largest σ₁/σ₃, and the axial strain at it.
    peak: [f64; 2],
    /// Mean σ₁/σ₃ over the last percent of axial strain.
    residual: f64,
    /// Volumetric strain at the end.
    volume: f64,
    /// Plastic strain next to coarse grains over that of all points.
    around: Option<f64>,
}

impl Shown {
    /// From the rows (axial strain, volumetric strain, σ₁/σ₃) of loading, and the plastic strain around grains; `None` without rows.
    fn of(rows: &[[f64; 3]], around: Option<f64>) -> Option<Shown> {
        let [end, volume, _] = *rows.last()?;
        let peak = rows.iter().fold([f64::NEG_INFINITY, 0.0], |most, r| if r[2] > most[0] { [r[2], r[0]] } else { most });
        let late: Vec<f64> = rows.iter().filter(|r| r[0] >= end - RESIDUAL * (1.0 + 1e-9)).map(|r| r[2]).collect();
        Some(Shown { peak, residual: late.iter().sum::<f64>() / late.len() as f64, volume, around })
    }

    /// Value of a measure; run times stand in the summary, not here.
    fn measure(&self, of: Measure) -> Option<f64> {
        match of {
            Measure::Peak => Some(self.peak[0]),
            Measure::PeakStrain => Some(self.peak[1]),
            Measure::Residual => Some(self.residual),
            Measure::VolumetricStrain => Some(self.volume),
            Measure::PlasticStrainAroundGrains => self.around,
            Measure::WallTime => None,
        }
    }
}

/// One entry of the plan with what its runs show.
struct Test<'a> {
    done: &'a Done,
    shown: Vec<Shown>,
}

impl Test<'_> {
    /// The measure over the seeds; of run times min.
    fn spread(&self, of: Measure) -> Option<Spread> {
        match of {
            Measure::WallTime => self.done.spread(|s| s.number("wall_seconds").map(|t| t / 60.0)),
            _ => Spread::of(&self.shown.iter().filter_map(|s| s.measure(of)).collect::<Vec<_>>()),
        }
    }

    /// Published run time for as much simulated time as here, min.
    fn paper_minutes_for_this(&self) -> Option<f64> {
        let published = self.done.published_test?;
        let here = self.done.spread(|s| s.number("time_s"))?.mean;
        Some(published.seconds? / 60.0 * here / published.simulated_s?)
    }
}

/// All entries of the plan; `around`: with the plastic strain around coarse grains, for which tables of all points are read.
fn all(done: &[Done], around: bool) -> Result<Vec<Test<'_>>> {
    fn test(done: &Done, around: bool) -> Result<Test<'_>> {
        let shown = done.seeds.iter().map(|seed| shown(seed, around)).collect::<Result<Vec<_>>>()?;
        Ok(Test { done, shown: shown.into_iter().flatten().collect() })
    }
    done.iter().map(|done| test(done, around)).collect()
}

/// What a run shows; `None` if it is no triaxial test. `around`: as in [`all`].
fn shown(seed: &Seed, around: bool) -> Result<Option<Shown>> {
    let columns = ["axial_strain", "volumetric_strain", "principal_ratio"];
    let around = if around { around_grains(&seed.folder)? } else { None };
    Ok(Shown::of(&loading(&seed.folder.join("history.csv"), columns)?, around))
}

/// Writes a line for every entry of the plan.
fn write(tests: &[Test<'_>], path: &Path) -> Result<PathBuf> {
    let failed = |e: csv::Error| Error::Write { path: path.into(), source: e.into() };
    let mut file = csv::Writer::from_path(path).map_err(failed)?;
    let measured = [
        ("peak_stress_ratio", Measure::Peak),
        ("peak_axial_strain", Measure::PeakStrain),
        ("residual_stress_ratio", Measure::Residual),
        ("volumetric_strain_end", Measure::VolumetricStrain),
        ("minutes", Measure::WallTime),
    ];
    let mut header = vec!["run".to_string(), "seeds".into(), "coarse_percent_paper".into()];
    for what in ["points", "grains"] {
        header.extend([format!("{what}_paper"), format!("{what}_mean")]);
    }
    for (name, _) in measured {
        header.extend(["mean", "least", "most"].map(|of| format!("{name}_{of}")));
    }
    header.extend(["simulated_s_mean", "minutes_paper", "simulated_s_paper", "minutes_paper_for_this_time"].map(String::from));
    file.write_record(&header).map_err(failed)?;
    let maybe = |x: Option<f64>| x.map_or(String::new(), number);
    for test in tests {
        let (done, published) = (test.done, test.done.published_test);
        let mean = |key: &str| maybe(done.spread(|s| s.number(key)).map(|s| s.mean));
        let mut row = vec![done.id.clone(), done.seeds.len().to_string(), maybe(published.map(|p| p.coarse_percent))];
        row.extend([maybe(published.and_then(|p| p.points)), mean("points")]);
        row.extend([maybe(published.and_then(|p| p.grains)), mean("grains")]);
        for (_, of) in measured {
            let spread = test.spread(of);
            row.extend([spread.map(|s| s.mean), spread.map(|s| s.least), spread.map(|s| s.most)].map(maybe));
        }
        row.extend([mean("time_s"), maybe(published.and_then(|p| p.seconds).map(|t| t / 60.0))]);
        row.extend([maybe(published.and_then(|p| p.simulated_s)), maybe(test.paper_minutes_for_this())]);
        file.write_record(&row).map_err(failed)?;
    }
    file.flush().map_err(Error::write(path))?;
    Ok(path.into())
}

/// A measure as text: strains in %, times in min.
fn text(of: Measure, s: Option<Spread>) -> String {
    let one = |x: f64| match of {
        Measure::Peak | Measure::Residual => format!("{x:.3}"),
        Measure::PlasticStrainAroundGrains => format!("{x:.2}"),
        Measure::PeakStrain | Measure::VolumetricStrain => format!("{:.2} %", 100.0 * x),
        Measure::WallTime => format!("{} min", significant(x, 3)),
    };
    match s {
        None => "–".into(),
        Some(s) if s.of == 1 => one(s.mean),
        Some(s) => format!("{} ({} to {})", one(s.mean), one(s.least), one(s.most)),
    }
}

/// Table of all entries of the plan.
fn overview(tests: &[Test<'_>]) -> String {
    let mut out = String::from(
        "Peak: largest σ₁/σ₃; residual: its mean over the last percent of axial strain; volumetric strain at the end, compression positive.\n\n\
         | run | coarse, paper | here | points, paper | here | grains, paper | here | seeds | peak | at strain | residual | volumetric strain | time | the paper's | for as much simulated time |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for test in tests {
        let (done, published) = (test.done, test.done.published_test);
        let count = |x: Option<f64>| x.map_or("–".into(), |x| format!("{x:.0}"));
        let mean = |key: &str| done.spread(|s| s.number(key)).map(|s| s.mean);
        let minutes = |m: Option<f64>| m.map_or("–".into(), |m| format!("{} min", significant(m, 3)));
        let [peak, at, residual, volume, time] =
            [Measure::Peak, Measure::PeakStrain, Measure::Residual, Measure::VolumetricStrain, Measure::WallTime]
                .map(|of| text(of, test.spread(of)));
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {peak} | {at} | {residual} | {volume} | {time} | {} | {} |",
            done.id,
            published.map_or("–".into(), |p| format!("{} %", p.coarse_percent)),
            mean("coarse_mass_fraction").map_or("–".into(), |x| format!("{:.1} %", 100.0 * x)),
            count(published.and_then(|p| p.points)),
            count(mean("points")),
            count(published.and_then(|p| p.grains)),
            count(mean("grains")),
            done.seeds.len(),
            minutes(published.and_then(|p| p.seconds).map(|s| s / 60.0)),
            minutes(test.paper_minutes_for_this()),
        );
    }
    out + "\n"
}

/// Table of what the paper says beside what the runs show.
fn statements(statements: &[Statement], tests: &[Test<'_>]) -> String {
    let mut out = String::from("| in the paper | measured | so |\n|---|---|---|\n");
    for statement in statements {
        let of = |id: &String| tests.iter().find(|t| t.done.id == *id).filter(|t| t.spread(statement.of).is_some());
        let those: Vec<&Test<'_>> = statement.runs.iter().filter_map(of).collect();
        let each = those.iter().map(|t| {
            let paper = match (statement.of, t.done.published_test.and_then(|p| p.seconds), t.paper_minutes_for_this()) {
                (Measure::WallTime, Some(whole), Some(this)) => {
                    format!(
                        " (paper {} min, {} min for as much simulated time)",
                        significant(whole / 60.0, 3),
                        significant(this, 3)
                    )
                }
                _ => String::new(),
            };
            format!("{} {}{paper}", t.done.id, text(statement.of, t.spread(statement.of)))
        });
        let each: Vec<String> = each.collect();
        let means: Vec<f64> = those.iter().filter_map(|t| t.spread(statement.of)).map(|s| s.mean).collect();
        let missing = statement.runs.len() - those.len();
        let so = match (statement.expect, missing) {
            _ if means.len() < 2 => "not enough runs are done".into(),
            (None, _) => String::new(),
            (Some(order), 0) => verdict(order, &means),
            (Some(order), _) => format!("{}; {missing} of {} runs are not done", verdict(order, &means), statement.runs.len()),
        };
        let _ = writeln!(out, "| {} | {} | {so} |", cell(&statement.paper), cell(&each.join(", ")));
    }
    out + "\n"
}

/// How the means go, in words.
fn verdict(order: Order, means: &[f64]) -> String {
    let all = |holds: fn(f64, f64) -> bool| means.windows(2).all(|w| holds(w[0], w[1]));
    let (least, most) = means.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    let mean = means.iter().sum::<f64>() / means.len() as f64;
    match order {
        Order::Rises if all(|a, b| a < b) => "rises".into(),
        Order::Rises => "does not rise throughout".into(),
        Order::Falls if all(|a, b| a > b) => "falls".into(),
        Order::Falls => "does not fall throughout".into(),
        Order::Equal => format!("within {:.1} % of the mean", 100.0 * (most - least) / mean.abs()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_test_shows_its_peak_its_end_and_its_volume() {
        assert_eq!(Shown::of(&[], None), None);
        let rows = [[0.0, 0.0, 1.0], [0.02, 0.001, 3.0], [0.09, -0.02, 2.2], [0.095, -0.03, 2.1], [0.1, -0.04, 1.9]];
        let shown = Shown::of(&rows, Some(1.2)).expect("rows");
        assert_eq!((shown.peak, shown.volume), ([3.0, 0.02], -0.04));
        assert!((shown.residual - (2.2 + 2.1 + 1.9) / 3.0).abs() < 1e-12, "the last percent: {shown:?}");
    }

    #[test]
    fn orders_are_told_as_they_are() {
        assert_eq!(verdict(Order::Rises, &[1.0, 2.0, 3.0]), "rises");
        assert_eq!(verdict(Order::Rises, &[1.0, 1.0]), "does not rise throughout");
        assert_eq!(verdict(Order::Falls, &[3.0, 2.0]), "falls");
        assert_eq!(verdict(Order::Falls, &[2.0, 3.0]), "does not fall throughout");
        assert_eq!(verdict(Order::Equal, &[1.9, 2.1]), "within 10.0 % of the mean");
    }
}
