//! Common parts of `ensemble`, `sweep` and `reproduce`: options, running or listing of jobs, and
//! the closing lines.

use comminute::campaign::{self, Hold, Job, Outcome, Program, Vary};
use comminute::error::{Error, Result};
use std::path::{Path, PathBuf};

/// Options of the verbs that make many runs.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// Runs at a time; one for each core if not given, and with a scheduler as many as it starts
    #[arg(long, value_name = "N", value_parser = super::threads())]
    jobs: Option<u16>,

    /// Threads of each run; the cores shared out if not given, and 1 in a list and with another executor than local
    #[arg(long, value_name = "N", value_parser = super::threads())]
    threads: Option<u16>,

    /// Backend that computes the steps of a continuum
    #[arg(long, value_enum, default_value = "cpu")]
    backend: super::Backend,

    /// Begin every run with a prepared specimen (specimen.csv of another run) instead of making one; seeds then choose strengths only
    #[arg(long, value_name = "FILE")]
    specimen: Option<PathBuf>,

    #[command(flatten)]
    executor: super::executor::Args,

    /// Print a shell command for each run, one a line, instead of running them; a command skips
    /// what is done already
    #[arg(long)]
    list: bool,

    /// Measurements to overlay, drawn as symbols (CSV)
    #[arg(long, value_name = "CSV")]
    pub data: Vec<PathBuf>,

    /// Overwrite runs of other scenes
    #[arg(long)]
    force: bool,

    /// No progress and no closing lines
    #[arg(long)]
    quiet: bool,

    /// Print the outcome of each run as JSON to standard output
    #[arg(long)]
    json: bool,
}

/// Folders of the verbs that read a plan.
#[derive(Debug, clap::Args)]
pub struct Folders {
    /// Folder of the runs; runs/ and the name of the plan if not given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Folder of tables, figures and report; report/ in the folder of the runs if not given
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

impl Folders {
    /// The folder of the runs of the plan `name`, a file or a name.
    pub fn runs(&self, name: &Path) -> PathBuf {
        let stem = name.file_stem().unwrap_or(name.as_os_str());
        self.out.clone().unwrap_or_else(|| Path::new("runs").join(stem))
    }

    /// The folder of the report of runs in `out`.
    pub fn report(&self, out: &Path) -> PathBuf {
        self.report.clone().unwrap_or_else(|| out.join("report"))
    }
}

impl Options {
    /// Refuses seeds that vary specimens only, if all runs begin with the same specimen.
    ///
    /// # Errors
    /// `--vary packing` beside `--specimen`.
    pub fn may_vary(&self, vary: Vary) -> Result<()> {
        if self.specimen.is_some() && vary == Vary::Packing {
            let message = "has no effect beside --specimen, because every run begins with that specimen; use --vary strength";
            return Err(Error::input("--vary packing", "", None, message));
        }
        Ok(())
    }

    /// Whether all runs begin with a specimen from the command line.
    pub fn gives_specimen(&self) -> bool {
        self.specimen.is_some()
    }

    /// Lists or runs the jobs of a campaign in the folder `out`; `None` when they were listed.
    pub fn run(&self, jobs: &mut [Job], out: &Path) -> Result<Option<Vec<Outcome>>> {
        let executor = self.executor.of(out)?;
        for file in self.data.iter().chain(&self.specimen) {
            std::fs::File::open(file).map_err(Error::read(file))?;
        }
        let threads = self.executor.threads(self.threads);
        for job in &mut *jobs {
            job.threads = threads.or(self.list.then_some(1));
            job.backend = self.backend.into();
            if self.specimen.is_some() {
                job.specimen.clone_from(&self.specimen);
            }
        }
        if self.list {
            super::print(&list(jobs, self.force)?)?;
            return Ok(None);
        }
        let parallel = self.jobs.map_or(0, usize::from);
        let options = campaign::Options { parallel, quiet: self.quiet, force: self.force, program: None, executor };
        campaign::run(jobs, &options).map(Some)
    }

    /// Writes a report into the folder `report`, prints the first `shown` of its tables and pages, and ends as [`Self::close`].
    pub fn close_with_report(
        &self,
        (jobs, outcomes): (&[Job], &[Outcome]),
        report: &Path,
        shown: usize,
        write: impl FnOnce() -> Result<Vec<PathBuf>>,
    ) -> Result<()> {
        // tables and figures of two campaigns at once would be written into each other
        let _alone = Hold::wait_for(report)?;
        let mut files = write()?;
        files.retain(|f| f.extension().is_none_or(|e| e != "svg" && e != "png"));
        files.truncate(shown);
        self.close(jobs, outcomes, &files)
    }

    /// Prints the results and the files, and returns an error if a run failed or was stopped.
    pub fn close(&self, jobs: &[Job], outcomes: &[Outcome], files: &[PathBuf]) -> Result<()> {
        if self.json {
            let runs: Vec<serde_json::Value> = jobs
                .iter()
                .zip(outcomes)
                .map(|(job, outcome)| {
                    let (status, reason) = status(outcome);
                    serde_json::json!({ "folder": job.out, "status": status, "reason": reason, "summary": outcome.summary() })
                })
                .collect();
            super::print(&serde_json::json!({ "runs": runs, "files": files }).to_string())?;
        }
        if !self.quiet {
            let done = outcomes.iter().filter(|o| o.summary().is_some()).count();
            let before = outcomes.iter().filter(|o| matches!(o, Outcome::Done { before: true, .. })).count();
            let note = if before > 0 { format!(", {before} of them before") } else { String::new() };
            eprintln!("{done} of {} runs done{note}", jobs.len());
            let summaries: Vec<&serde_json::Value> = outcomes.iter().filter_map(Outcome::summary).collect();
            for line in spread(&summaries) {
                eprintln!("  {line}");
            }
            let (drawn, tables): (Vec<_>, Vec<_>) = files.iter().partition(|f| f.parent().is_some_and(|p| p.ends_with("figures")));
            if let Some(folder) = drawn.first().and_then(|f| f.parent()) {
                eprintln!("  {} files in {}", drawn.len(), folder.display());
            }
            super::list_files(&tables.into_iter().cloned().collect::<Vec<_>>());
        }
        campaign::close(jobs, outcomes)
    }
}

/// Results in the closing lines: name, place (JSON pointer) in a summary, factor, decimals, unit.
const FOUND: [(&str, &str, f64, usize, &str); 9] = [
    ("largest stress", "/max_measured_stress_kPa", 1.0, 0, " kPa"),
    ("peak σ1/σ3", "/peak_stress_ratio", 1.0, 3, ""),
    ("void ratio at the end", "/void_ratio_final", 1.0, 3, ""),
    ("axial strain at the end", "/axial_strain_final", 100.0, 2, " %"),
    ("k0 at the end", "/k0_final", 1.0, 3, ""),
    ("breakages", "/crush_events", 1.0, 0, ""),
    ("grains at the end", "/grains_final", 1.0, 0, ""),
    ("B_r (Hardin)", "/hardin_br", 1.0, 3, ""),
    ("B_r (Einav)", "/einav_br", 1.0, 3, ""),
];

/// A line for each quantity that the runs have: mean, standard deviation, least and largest.
fn spread(summaries: &[&serde_json::Value]) -> Vec<String> {
    let line = |(name, at, factor, decimals, unit): (&str, &str, f64, usize, &str)| {
        let all: Vec<f64> = summaries.iter().filter_map(|s| Some(factor * s.pointer(at)?.as_f64()?)).collect();
        let n = all.len() as f64;
        let mean = all.iter().sum::<f64>() / n;
        let (least, most) = all.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
        match all.len() {
            0 => None,
            1 => Some(format!("{name}: {mean:.decimals$}{unit}")),
            runs => {
                let sd = (all.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1.0)).sqrt();
                Some(format!(
                    "{name}: {mean:.decimals$} ± {sd:.decimals$}{unit} (mean and standard deviation of {runs} runs; {least:.decimals$} to {most:.decimals$})"
                ))
            }
        }
    };
    FOUND.into_iter().filter_map(line).collect()
}

/// Outcome of a run in one word, and the reason if the run failed.
pub fn status(outcome: &Outcome) -> (&'static str, Option<&str>) {
    match outcome {
        Outcome::Done { .. } => ("done", None),
        Outcome::Failed { reason, .. } => ("failed", Some(reason)),
        Outcome::Stopped => ("stopped", None),
    }
}

/// Folders of the runs that are done.
pub fn done(jobs: &[Job], outcomes: &[Outcome]) -> Vec<PathBuf> {
    jobs.iter().zip(outcomes).filter(|(_, o)| o.summary().is_some()).map(|(job, _)| job.out.clone()).collect()
}

/// Shell commands of the jobs, one a line. Each scene is checked before it is listed.
fn list(jobs: &[Job], force: bool) -> Result<String> {
    // the name by which this program was called, so that the commands work in the same folder
    let program = Program::given().map_or_else(
        || vec![std::env::args().next().unwrap_or_else(|| "comminute".into())],
        |program| program.words().map(|word| word.to_string_lossy().into_owned()).collect(),
    );
    let mut lines = Vec::new();
    for job in jobs {
        job.load()?;
        let more = if force { " --force" } else { "" };
        lines.push(job.command_line(&program) + more);
    }
    Ok(lines.join("\n"))
}

/// `runs/NAME-KIND` for a scene file.
pub fn default_out(scene: &Path, kind: &str) -> PathBuf {
    let stem = scene.file_stem().map_or_else(|| "scene".into(), |s| s.to_string_lossy());
    Path::new("runs").join(format!("{stem}-{kind}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_runs_found_is_told_with_its_spread() {
        let [a, b] = [0.3, 0.4].map(|e| serde_json::json!({"void_ratio_final": e, "crush_events": 1000.0 * e, "hardin_br": null}));
        let told = spread(&[&a, &b]);
        assert_eq!(told[0], "void ratio at the end: 0.350 ± 0.071 (mean and standard deviation of 2 runs; 0.300 to 0.400)");
        assert_eq!((told.len(), spread(&[&a])[1].as_str()), (2, "breakages: 300"));
    }
}
