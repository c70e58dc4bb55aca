//! Breakages of an oedometer's grains: counts, grains and run times beside the published ones.

use super::counts::{self, Row};
use super::{Comparison, runs};
use crate::reproduce::plan::Plan;
use crate::reproduce::results::{Done, Spread};
use laboratory::error::Result;
use plot::significant;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Compares counts of breakages.
pub struct Crushing;

impl Comparison for Crushing {
    fn compare(&self, plan: &Plan, done: &[Done], dir: &Path) -> Result<(Vec<PathBuf>, String)> {
        let rows = counts::rows(done);
        let tables = vec![counts::write(&rows, &dir.join("comparison.csv"))?, runs::write(done, &RUNS, &dir.join("runs.csv"))?];
        Ok((tables, table(&rows) + &reached(&rows) + &times(plan, done)))
    }
}

/// Columns of `runs.csv`, and where their values stand in a summary.
const RUNS: [(&str, &str); 16] = [
    ("seed", "/seed/packing"),
    ("scale", "/scale"),
    ("height_mm", "/height_mm"),
    ("max_stress_kPa", "/max_stress_kPa"),
    ("grains_initial", "/grains_initial"),
    ("crush_events", "/crush_events"),
    ("grains_final", "/grains_final"),
    ("void_ratio_final", "/void_ratio_final"),
    ("porosity_final", "/porosity_final"),
    ("k0_final", "/k0_final"),
    ("mass_error", "/mass_error"),
    ("energy_error", "/energy_error"),
    ("largest_platen_difference", "/quasi_static/largest_platen_difference"),
    ("largest_distance_from_target", "/quasi_static/largest_distance_from_target"),
    ("largest_inertial_number", "/quasi_static/largest_inertial_number"),
    ("wall_seconds", "/wall_seconds"),
];

/// A count as text: rounded to a whole number; thousands are set apart in counts of more than four
/// digits.
fn count(x: f64) -> String {
    let digits = format!("{:.0}", x.abs());
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) && digits.len() > 4 {
            out.push(' ');
        }
        out.push(c);
    }
    out
}

/// The number rounded to two significant digits, and at least to a whole number, as the paper gives
/// its excluded grains.
fn two_digits(x: f64) -> f64 {
    let unit = 10f64.powf(x.abs().max(1.0).log10().floor() - 1.0).max(1.0);
    (x / unit).round() * unit
}

fn spread(s: Option<Spread>) -> String {
    match s {
        None => "–".into(),
        Some(s) if s.of == 1 => count(s.mean),
        Some(s) => format!("{} ({} – {})", count(s.mean), count(s.least), count(s.most)),
    }
}

fn mpa(kpa: f64) -> String {
    format!("{} MPa", significant(1e-3 * kpa, 3))
}

/// Table of the counts of the runs beside the published ones.
fn table(rows: &[Row]) -> String {
    let mut out = String::from(
        "| run | at | events, paper | here: mean (range) | seeds | difference | final grains, paper | here | excluded, paper | here | min, paper | here |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let p = &row.published;
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            row.id,
            p.stress_kPa.map_or("end".into(), mpa),
            count(p.events),
            spread(row.events),
            row.seeds,
            row.difference().map_or("–".into(), |d| format!("{:+.0} %", 100.0 * d)),
            count(p.grains),
            row.grains.map_or("–".into(), |s| count(s.mean)),
            count(p.excluded),
            row.excluded.map_or("–".into(), |s| count(two_digits(s.mean))),
            p.minutes.map_or("–".into(), count),
            row.minutes.map_or("–".into(), |s| significant(s.mean, 2)),
        );
    }
    out + "\n"
}

/// Table of the stresses at which the published counts are reached.
fn reached(rows: &[Row]) -> String {
    let mut out = String::from(
        "Vertical stress at which the published number of events is reached:\n\n| run | events, paper | at a mean of (range) | seeds that reach it |\n|---|---|---|---|\n",
    );
    for row in rows.iter().filter(|r| r.seeds > 0) {
        let at = row.reached.map_or("not reached".into(), |r| {
            if r.of == 1 { mpa(r.mean) } else { format!("{} ({} – {})", mpa(r.mean), mpa(r.least), mpa(r.most)) }
        });
        let of = row.reached.map_or(0, |r| r.of);
        let _ = writeln!(out, "| {} | {} | {at} | {of} of {} |", row.id, count(row.published.events), row.seeds);
    }
    out + "\n"
}

/// Lines on the run times of the published runs and of the whole plan.
fn times(plan: &Plan, done: &[Done]) -> String {
    let published: Vec<&Done> = done.iter().filter(|d| !d.published.is_empty() && !d.seeds.is_empty()).collect();
    let of = done.iter().filter(|d| !d.published.is_empty()).count();
    let first: f64 = published.iter().filter_map(|d| d.seeds.first()?.number("wall_seconds")).sum::<f64>() / 60.0;
    let all: f64 = done.iter().map(Done::minutes).sum();
    let runs: usize = done.iter().map(|d| d.seeds.len()).sum();
    let mut out =
        format!("- The first seeds of {} of the {of} published runs took {} min, added up", published.len(), significant(first, 3));
    if let Some(minutes) = plan.published_minutes {
        let _ = write!(out, "; the paper's took {} min", count(minutes));
    }
    let _ = writeln!(out, ". All {runs} runs of the plan (seeds, twins) took {} min.", significant(all, 3));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_people_read_them() {
        assert_eq!(count(1408.4), "1408");
        assert_eq!(count(171918.0), "171 918");
        assert_eq!(count(1_600_000.0), "1 600 000");
        assert_eq!(two_digits(1_116_587.0), 1_100_000.0);
        assert_eq!((two_digits(0.0), two_digits(7.4)), (0.0, 7.0));
        assert_eq!(mpa(5000.0), "5 MPa");
        assert_eq!(spread(None), "–");
        assert_eq!(spread(Spread::of(&[3.0])), "3");
        assert_eq!(spread(Spread::of(&[1000.0, 3000.0])), "2000 (1000 – 3000)");
    }
}
