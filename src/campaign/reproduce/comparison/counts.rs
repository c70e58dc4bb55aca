//! The published counts beside the counts of the runs.

use crate::reproduce::plan::Published;
use crate::reproduce::results::{Done, Spread};
use laboratory::error::{Error, Result};
use std::path::{Path, PathBuf};
use table::number;

/// One published row with the results of the seeds.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of the run in the plan.
    pub id: String,
    /// The published numbers.
    pub published: Published,
    /// Breakages, over the seeds.
    pub events: Option<Spread>,
    /// Grains, over the seeds.
    pub grains: Option<Spread>,
    /// Additional grains that keeping all lost mass would have needed, over the seeds.
    pub excluded: Option<Spread>,
    /// Run time of the whole run, min; given only in the last published row of the run.
    pub minutes: Option<Spread>,
    /// Vertical stress at which the published number of events is reached, kPa, over the seeds that reach it.
    pub reached: Option<Spread>,
    /// How many seeds are done.
    pub seeds: usize,
}

impl Row {
    /// Mean number of events over the published one, less 1.
    pub fn difference(&self) -> Option<f64> {
        self.events.map(|e| e.mean / self.published.events - 1.0)
    }
}

/// A row for each published row of the runs.
pub fn rows(done: &[Done]) -> Vec<Row> {
    done.iter().flat_map(|d| d.published.iter().map(|p| row(d, p))).collect()
}

fn row(done: &Done, published: &Published) -> Row {
    let at = published.stress_kPa;
    let last = done.published.last() == Some(published);
    Row {
        id: done.id.clone(),
        published: *published,
        events: done.spread(|s| s.events(at)),
        // in proportion to the events, as if each event added the same number of grains
        grains: done.spread(|s| {
            let first = s.number("grains_initial")?;
            Some(first + s.share(at)? * (s.number("grains_final")? - first))
        }),
        excluded: done.spread(|s| Some(s.share(at)? * s.number("excluded_grains")?)),
        minutes: done.spread(|s| s.number("wall_seconds").filter(|_| last)).map(|t| Spread {
            mean: t.mean / 60.0,
            sd: t.sd / 60.0,
            least: t.least / 60.0,
            most: t.most / 60.0,
            of: t.of,
        }),
        reached: done.spread(|s| s.stress(published.events)),
        seeds: done.seeds.len(),
    }
}

/// Writes the rows as CSV.
///
/// # Errors
/// A file that cannot be written.
pub fn write(rows: &[Row], path: &Path) -> Result<PathBuf> {
    let failed = |e: csv::Error| Error::Write { path: path.into(), source: e.into() };
    let mut file = csv::Writer::from_path(path).map_err(failed)?;
    file.write_record([
        "run",
        "stress_kPa",
        "seeds",
        "events_paper",
        "events_mean",
        "events_sd",
        "events_least",
        "events_most",
        "difference_percent",
        "grains_paper",
        "grains_mean",
        "excluded_paper",
        "excluded_mean",
        "minutes_paper",
        "minutes_mean",
        "reached_seeds",
        "reached_kPa_mean",
        "reached_kPa_least",
        "reached_kPa_most",
    ])
    .map_err(failed)?;
    for row in rows {
        let p = &row.published;
        let maybe = |x: Option<f64>| x.map_or(String::new(), number);
        let mean = |s: Option<Spread>| maybe(s.map(|s| s.mean));
        let events = |f: fn(&Spread) -> f64| maybe(row.events.as_ref().map(f));
        let reached = |f: fn(&Spread) -> f64| maybe(row.reached.as_ref().map(f));
        file.write_record([
            row.id.clone(),
            maybe(p.stress_kPa),
            row.seeds.to_string(),
            number(p.events),
            events(|e| e.mean),
            events(|e| e.sd),
            events(|e| e.least),
            events(|e| e.most),
            maybe(row.difference().map(|d| 100.0 * d)),
            number(p.grains),
            mean(row.grains),
            number(p.excluded),
            mean(row.excluded),
            maybe(p.minutes),
            mean(row.minutes),
            row.reached.map_or(0, |r| r.of).to_string(),
            reached(|r| r.mean),
            reached(|r| r.least),
            reached(|r| r.most),
        ])
        .map_err(failed)?;
    }
    file.flush().map_err(Error::write(path))?;
    Ok(path.into())
}
