//! The report: tables and figures; beside each figure, what the paper says and what the runs show.

use super::compare::Row;
use super::plan::Plan;
use super::results::{Done, Spread};
use laboratory::error::{Error, Result};
use plot::significant;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Writes `README.md`, the file that hosts of repositories show for a folder, and returns its path.
///
/// # Errors
/// A file that cannot be written.
pub fn write(plan: &Plan, done: &[Done], rows: &[Row], drawn: &[Vec<PathBuf>], dir: &Path) -> Result<PathBuf> {
    let mut text = format!("# {}\n\n{}\n\n", plan.title, plan.source);
    text += &table(rows);
    text += &reached(rows);
    text += &times(plan, done);
    for note in &plan.notes {
        let _ = writeln!(text, "- {note}");
    }
    text += "\nThe same numbers with spread: [comparison.csv](comparison.csv); every run: [runs.csv](runs.csv). Each figure has the CSV of what it shows beside it.\n";
    for (figure, files) in plan.figures.iter().zip(drawn) {
        let _ = write!(text, "\n## {}\n\n| in the paper | here |\n|---|---|\n", figure.title);
        let images: Vec<&PathBuf> = files.iter().filter(|f| f.extension().is_some_and(|e| e == "svg")).collect();
        let first = if images.is_empty() { "its runs are not done".into() } else { figure.here.clone() };
        let _ = writeln!(text, "| {} | {} |", cell(&figure.paper), cell(&first));
        text.push('\n');
        for image in images {
            let path = image.strip_prefix(dir).unwrap_or(image).display().to_string();
            let name = image.file_stem().map_or_else(String::new, |s| s.to_string_lossy().replace('_', " "));
            let _ = writeln!(text, "<img src=\"{path}\" alt=\"{}: {name}\" width=\"430\">", figure.title);
        }
    }
    let path = dir.join("README.md");
    std::fs::write(&path, text).map_err(Error::write(&path))?;
    Ok(path)
}

/// Text made fit for a cell of a Markdown table.
fn cell(text: &str) -> String {
    text.trim().replace('|', "\\|").replace('\n', " ")
}

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
    let mut out = format!(
        "- The first seeds of {} of the {of} published runs took {} min, one after the other",
        published.len(),
        significant(first, 3)
    );
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
        assert_eq!(cell("a|b\nc "), "a\\|b c");
    }
}
