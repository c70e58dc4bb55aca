//! Sources of curves for a calibration: runs of the scene, or a replacement in tests.

use super::log::{Evaluation, Stage};
use super::outputs;
use super::parameter::Parameter;
use super::target::Target;
use campaign::{self, Job, Outcome, Vary};
use laboratory::error::Result;
use std::path::PathBuf;

/// Outcome of an evaluation.
#[derive(Clone, Debug, PartialEq)]
pub enum Ran {
    /// A value for each point of the target.
    Done(Vec<f64>),
    /// Failed at these parameters, and would again.
    Failed(String),
    /// Ended by something that has nothing to do with the parameters, such as a signal or a full disk; the evaluation continues when it is
    /// asked for again.
    Broken(String),
    /// Interrupted; the evaluation continues when it is asked for again.
    Stopped,
}

/// Gives curves for parameters and seeds.
pub trait Simulator: Sync {
    /// Evaluates all of `wanted`. The same evaluation always has the same outcome, unless it is
    /// interrupted or broken.
    ///
    /// # Errors
    /// Errors that concern the calibration as a whole. An evaluation that fails is [`Ran::Failed`].
    fn run(&self, wanted: &[&Evaluation]) -> Result<Vec<Ran>>;
}

/// Runs of a scene, each a process in a folder of its own.
pub struct Runs<'a> {
    pub scene: PathBuf,
    pub sets: Vec<String>,
    pub parameters: &'a [Parameter],
    pub target: &'a Target,
    /// Folder of the calibration.
    pub dir: PathBuf,
    pub parallel: usize,
    pub threads: Option<usize>,
    pub executor: campaign::Executor,
    pub quiet: bool,
}

impl Runs<'_> {
    fn job(&self, e: &Evaluation) -> Job {
        let values = self.parameters.iter().zip(&e.values).map(|(p, v)| format!("{}={v:?}", p.key));
        let values: Vec<String> = values.collect();
        let job = Job::new(&self.scene, self.dir.join(e.folder())).with(&self.sets).with(&values);
        Job { threads: self.threads, ..job.seeded(Vary::Both, e.seed) }
    }
}

impl Simulator for Runs<'_> {
    fn run(&self, wanted: &[&Evaluation]) -> Result<Vec<Ran>> {
        let jobs: Vec<Job> = wanted.iter().map(|e| self.job(e)).collect();
        let options = campaign::Options {
            parallel: self.parallel,
            quiet: self.quiet,
            // after a larger budget the check runs have other parameters but the folders of the
            // earlier check
            force: wanted.iter().all(|e| e.stage == Stage::Check),
            program: None,
            executor: self.executor.clone(),
        };
        let outcomes = campaign::run(&jobs, &options)?;
        Ok(jobs
            .iter()
            .zip(outcomes)
            .map(|(job, outcome)| match outcome {
                Outcome::Stopped => Ran::Stopped,
                Outcome::Failed { reason, log, outside: true } => Ran::Broken(format!("{reason} ({})", log.display())),
                Outcome::Failed { reason, .. } => Ran::Failed(reason),
                Outcome::Done { .. } => outputs::of_run(&job.out, self.target).map_or_else(Ran::Failed, Ran::Done),
            })
            .collect())
    }
}
