//! Results of the runs of a plan, read from the folders of the runs.

use super::plan::{Plan, Published, PublishedTest, Run};
use laboratory::error::{Error, Result};
use laboratory::run::Found;
use serde_json::Value;
use statrs::statistics::Statistics;
use std::path::{Path, PathBuf};

/// The finished runs of one entry of the plan.
#[derive(Clone, Debug)]
pub struct Done {
    /// Name of the run in the plan.
    pub id: String,
    /// The published numbers.
    pub published: Vec<Published>,
    /// The published numbers of a triaxial test.
    pub published_test: Option<PublishedTest>,
    /// The finished runs, one for each seed.
    pub seeds: Vec<Seed>,
}

/// The finished run of one seed.
#[derive(Clone, Debug)]
pub struct Seed {
    /// Folder of the run.
    pub folder: PathBuf,
    /// Content of its `summary.json`.
    pub summary: Value,
    /// Points (vertical stress in kPa, number of crush events up to that stress) of first loading,
    /// with rising stress.
    counts: Vec<(f64, f64)>,
}

/// Mean, standard deviation (of the sample), smallest and largest value over the seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Standard deviation of the sample; NaN for one value.
    pub sd: f64,
    /// Smallest value.
    pub least: f64,
    /// Largest value.
    pub most: f64,
    /// Number of values.
    pub of: usize,
}

impl Spread {
    /// Statistics of the values; `None` if there are no values.
    pub fn of(values: &[f64]) -> Option<Spread> {
        if values.is_empty() {
            return None;
        }
        let sd = if values.len() > 1 { values.std_dev() } else { f64::NAN };
        Some(Spread { mean: values.mean(), sd, least: Statistics::min(values), most: Statistics::max(values), of: values.len() })
    }
}

/// For every run of the plan, the seeds that are finished in `out`.
///
/// # Errors
/// Scenes that are not valid and files that cannot be read.
pub fn gather(plan: &Plan, out: &Path) -> Result<Vec<Done>> {
    plan.runs.iter().map(|run| done(plan, run, out)).collect()
}

fn done(plan: &Plan, run: &Run, out: &Path) -> Result<Done> {
    let mut seeds = Vec::new();
    for job in plan.jobs(run, out)? {
        if let Found::Finished(summary) = job.found()? {
            let counts = counts(&job.out.join("history.csv"))?;
            seeds.push(Seed { folder: job.out, summary, counts });
        }
    }
    Ok(Done { id: run.id.clone(), published: run.published.clone(), published_test: run.published_test, seeds })
}

/// Points (stress, events) of first loading from a history; none if the history lacks a column.
fn counts(path: &Path) -> Result<Vec<(f64, f64)>> {
    let mut out: Vec<(f64, f64)> = Vec::new();
    for [sigma, n] in loading(path, ["sigma_v_kPa", "crush_events"])? {
        if out.last().is_none_or(|last| sigma > last.0) {
            out.push((sigma, n));
        }
    }
    Ok(out)
}

/// The numbers in the columns `names` of a history, in its rows of loading in which all of them are numbers; none if the history lacks a column.
///
/// # Errors
/// A file that cannot be read.
pub fn loading<const N: usize>(path: &Path, names: [&str; N]) -> Result<Vec<[f64; N]>> {
    rows(path, |stage| stage == "load", names)
}

/// The same of the rows whose stage is to be kept.
///
/// # Errors
/// A file that cannot be read.
pub fn rows<const N: usize>(path: &Path, keeps: impl Fn(&str) -> bool, names: [&str; N]) -> Result<Vec<[f64; N]>> {
    let wrong = |e: csv::Error| Error::Read { path: path.into(), source: e.into() };
    let mut reader = csv::Reader::from_path(path).map_err(wrong)?;
    let headers = reader.headers().map_err(wrong)?.clone();
    let at = |name: &str| headers.iter().position(|h| h == name);
    let places: Vec<usize> = names.into_iter().filter_map(at).collect();
    let (Some(stage), Ok(places)) = (at("stage"), <[usize; N]>::try_from(places)) else { return Ok(Vec::new()) };
    let mut out = Vec::new();
    for row in reader.records() {
        let row = row.map_err(wrong)?;
        let numbers = places.map(|k| row.get(k).and_then(|cell| cell.parse::<f64>().ok()));
        if row.get(stage).is_some_and(&keeps) && numbers.iter().all(Option::is_some) {
            out.push(numbers.map(Option::unwrap_or_default));
        }
    }
    Ok(out)
}

impl Seed {
    /// A number of the summary.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.summary.get(key).and_then(Value::as_f64)
    }

    /// Number of crush events up to a vertical stress, kPa, interpolated between records (linear in
    /// the logarithm of stress). Without a stress, or at the stress at which the run was to end:
    /// the events of the whole run. `None` if the run did not reach the stress.
    pub fn events(&self, stress: Option<f64>) -> Option<f64> {
        let end = self.number("max_stress_kPa");
        match stress.filter(|s| Some(*s) != end) {
            None => self.number("crush_events"),
            Some(stress) => between(&self.counts, |p| p.0.ln(), |p| p.1, stress.ln()),
        }
    }

    /// Crush events up to a vertical stress, kPa, over those of the whole run.
    pub fn share(&self, stress: Option<f64>) -> Option<f64> {
        let all = self.number("crush_events")?;
        if all == 0.0 { Some(0.0) } else { Some(self.events(stress)? / all) }
    }

    /// The vertical stress, kPa, at which the number of crush events reaches `events`; `None` if it
    /// never does.
    pub fn stress(&self, events: f64) -> Option<f64> {
        between(&self.counts, |p| p.1, |p| p.0.ln(), events).map(f64::exp)
    }
}

/// The value of y where x first reaches `at`, interpolated linearly between points; x must not fall
/// along the points. `None` if x never reaches `at`.
fn between(points: &[(f64, f64)], x: impl Fn(&(f64, f64)) -> f64, y: impl Fn(&(f64, f64)) -> f64, at: f64) -> Option<f64> {
    let i = points.iter().position(|p| x(p) >= at)?;
    let Some(before) = i.checked_sub(1).map(|j| &points[j]) else { return Some(y(&points[0])) };
    let (a, b) = (before, &points[i]);
    Some(y(a) + (y(b) - y(a)) * (at - x(a)) / (x(b) - x(a)))
}

impl Done {
    /// Statistics of `of(seed)` over the seeds for which `of` has a value.
    pub fn spread(&self, of: impl Fn(&Seed) -> Option<f64>) -> Option<Spread> {
        let values: Vec<f64> = self.seeds.iter().filter_map(of).collect();
        Spread::of(&values)
    }

    /// Folders of the finished runs.
    pub fn folders(&self) -> Vec<PathBuf> {
        self.seeds.iter().map(|seed| seed.folder.clone()).collect()
    }

    /// Sum of the run times, min.
    pub fn minutes(&self) -> f64 {
        self.seeds.iter().filter_map(|seed| seed.number("wall_seconds")).sum::<f64>() / 60.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seed(rows: &str) -> Seed {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("history.csv");
        std::fs::write(&path, format!("stage,sigma_v_kPa,crush_events\n{rows}")).expect("written");
        Seed {
            folder: dir.path().into(),
            summary: serde_json::json!({ "crush_events": 20, "max_stress_kPa": 1000.7 }),
            counts: counts(&path).expect("counts"),
        }
    }

    #[test]
    fn counts_are_those_of_first_loading_between_records() {
        let s = seed("settle,5,0\nload,10,0\nload,100,8\nload,1000,10\nunload,100,10\nload,1000.5,20\n");
        assert!((s.events(Some(10f64.powf(1.5))).expect("between") - 4.0).abs() < 1e-9);
        assert_eq!((s.events(None), s.events(Some(1000.7))), (Some(20.0), Some(20.0)));
        assert_eq!(s.events(Some(2000.0)), None, "never got there");
        assert!((s.stress(9.0).expect("between") / 10f64.powf(2.5) - 1.0).abs() < 1e-9);
        assert_eq!(s.stress(21.0), None);
        assert_eq!(seed("").events(Some(1.0)), None);
    }

    #[test]
    fn a_spread_needs_values_and_a_deviation_needs_two() {
        assert_eq!(Spread::of(&[]), None);
        let one = Spread::of(&[3.0]).expect("one");
        assert!(one.mean == 3.0 && one.sd.is_nan() && one.of == 1);
        let two = Spread::of(&[1.0, 3.0]).expect("two");
        assert!((two.sd - 2f64.sqrt()).abs() < 1e-12 && two.least == 1.0 && two.most == 3.0);
    }
}
