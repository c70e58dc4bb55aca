//! Course of a calibration: runs that fill the space between the bounds, repeats in its middle,
//! then batches of runs at parameters that agree with the curve, chosen where a run makes the
//! predictions of the emulator most certain.

use super::design::latin;
use super::emulator::Emulator;
use super::left_out;
use super::log::{self, Evaluation, Stage, Status};
use super::parameter::Parameter;
use super::posterior::{Chain, Measured, Posterior};
use super::simulator::{Ran, Simulator};
use crate::columns::Columns;
use laboratory::error::{Error, Result};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::path::{Path, PathBuf};

/// Settings of a calibration: numbers of runs for each purpose, seed, and number of specimens.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Number of runs for the emulator, failed ones included.
    pub budget: usize,
    /// Runs that fill the space between the bounds.
    pub design: usize,
    /// Runs in the middle of that space that differ only in their seeds.
    pub centre: usize,
    /// Runs between two updates of the emulator.
    pub batch: usize,
    /// Runs at the parameters found, besides the budget.
    pub check: usize,
    /// Seed of everything that is random; the runs' own seeds follow from it.
    pub seed: u64,
    /// Number of specimens over which the measured curve is averaged.
    pub specimens: f64,
}

impl Settings {
    /// Default numbers for this many parameters.
    pub fn usual(parameters: usize) -> Settings {
        let (design, centre) = ((14 * parameters).max(16), 4);
        Settings { budget: design + centre + 10 * parameters, design, centre, batch: 5, check: 4, seed: 1, specimens: 1.0 }
    }
}

/// Walkers of a chain, steps of each that are discarded at the start, and steps that are kept: of
/// the chains that choose runs, and of the final one.
const QUICK: (usize, usize, usize) = (24, 100, 200);
pub const LONG: (usize, usize, usize) = (40, 500, 2000);
/// Power of the likelihood in the density from which candidates for runs are drawn. A power below 1
/// widens the posterior, so that runs are also made at its edges.
const SEARCH_HEAT: f64 = 0.5;
const CANDIDATES: usize = 400;
/// Number of draws of the posterior at which the next runs shall make the predictions of the
/// emulator certain.
const REFERENCE: usize = 150;
/// Scale of a block over the range of its values, used if neither the repeats scatter nor an error
/// of measurement is given.
const NO_SCATTER: f64 = 0.01;

/// Quantiles of the parameters after a number of runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    pub evaluations: usize,
    /// 2.5 %, 50 % and 97.5 % quantile of each parameter, in the unit of its key.
    pub quantiles: Vec<[f64; 3]>,
}

/// A calibration under way.
pub struct Search<'a> {
    pub parameters: &'a [Parameter],
    pub curve: &'a Measured,
    /// Number of outputs in each block; the outputs of a block have one scale.
    pub blocks: Vec<usize>,
    pub settings: &'a Settings,
    pub simulator: &'a dyn Simulator,
    pub dir: PathBuf,
    /// Receives messages about the progress.
    pub tell: &'a dyn Fn(&str),
    evaluations: Vec<Evaluation>,
    outputs: Vec<Option<Vec<f64>>>,
    pub trace: Vec<Trace>,
}

impl<'a> Search<'a> {
    /// Starts a calibration with the runs in the log of the folder `dir`, if there is one.
    ///
    /// # Errors
    /// A log or a trace that cannot be read, or that belongs to other parameters.
    pub fn new(
        parameters: &'a [Parameter],
        curve: &'a Measured,
        blocks: Vec<usize>,
        settings: &'a Settings,
        simulator: &'a dyn Simulator,
        dir: &Path,
        tell: &'a dyn Fn(&str),
    ) -> Result<Search<'a>> {
        let evaluations = log::read(dir, parameters)?.into_iter().filter(|e| e.stage != Stage::Check).collect::<Vec<_>>();
        let outputs = vec![None; evaluations.len()];
        let mut trace = read_trace(dir, parameters)?;
        trace.retain(|t| t.evaluations <= evaluations.len());
        Ok(Search { parameters, curve, blocks, settings, simulator, dir: dir.into(), tell, evaluations, outputs, trace })
    }

    /// Makes the runs up to the budget and returns the emulator fitted to them. Ends earlier if
    /// every candidate for a run lies nearest to a run that failed.
    ///
    /// # Errors
    /// [`Error::Stopped`] after an interrupt; [`Error::Campaign`] if runs were killed or the machine had no room for them, or if so many
    /// failed that too few are left for an emulator; [`Error::Input`] if the curves of the runs do not differ.
    pub fn run(&mut self) -> Result<Emulator> {
        let s = self.settings;
        if self.evaluations.is_empty() {
            let d = self.parameters.len();
            for u in latin(s.design, d, &mut self.rng(0)) {
                self.plan(Stage::Design, &u);
            }
            for _ in 0..s.centre {
                self.plan(Stage::Centre, &vec![0.5; d]);
            }
        }
        self.evaluate()?;
        loop {
            let n = self.evaluations.len();
            let emulator = self.emulator()?;
            if n >= s.budget {
                return Ok(emulator);
            }
            let mut rng = self.rng(n as u64);
            let posterior = Posterior::new(self.parameters, &emulator, self.curve, 1.0);
            let chain = posterior.sample(QUICK.0, QUICK.1, QUICK.2, 1.0, &mut rng);
            let wide = posterior.sample(QUICK.0, QUICK.1, QUICK.2, SEARCH_HEAT, &mut rng);
            self.note(&chain)?;
            let candidates: Vec<Vec<f64>> = wide.thinned(CANDIDATES).into_iter().filter(|u| !self.near_failure(u)).collect();
            for u in emulator.choose(&candidates, &chain.thinned(REFERENCE), s.batch.min(s.budget - n)) {
                self.plan(Stage::Search, &u);
            }
            if self.evaluations.len() == n {
                return Ok(emulator);
            }
            self.evaluate()?;
        }
    }

    /// Random stream number `n` of the seed. A batch uses the number of runs made before it, so
    /// that a calibration that was stopped draws the same numbers when it continues.
    pub fn rng(&self, n: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.settings.seed);
        rng.set_stream(n);
        rng
    }

    /// Finished runs that the emulator is fitted to, with their outputs.
    pub fn done(&self) -> impl Iterator<Item = (&Evaluation, &Vec<f64>)> {
        self.evaluations.iter().zip(&self.outputs).filter_map(|(e, y)| Some((e, y.as_ref()?)))
    }

    /// The runs of [`Search::done`] in the form that [`left_out::left_out`] needs.
    pub fn runs(&self) -> Vec<left_out::Run> {
        let run = |(e, y): (&Evaluation, &Vec<f64>)| left_out::Run {
            u: self.unit(e),
            outputs: y.clone(),
            design: e.stage == Stage::Design,
        };
        self.done().map(run).collect()
    }

    /// Unit coordinates of the runs that have ended, and whether they finished.
    pub fn ended(&self) -> Vec<(Vec<f64>, bool)> {
        let ended = |(e, y): (&Evaluation, &Option<Vec<f64>>)| match (&e.status, y) {
            (Status::Failed(_), _) => Some((self.unit(e), false)),
            (_, Some(_)) => Some((self.unit(e), true)),
            _ => None,
        };
        self.evaluations.iter().zip(&self.outputs).filter_map(ended).collect()
    }

    pub fn failed(&self) -> usize {
        self.evaluations.iter().filter(|e| matches!(e.status, Status::Failed(_))).count()
    }

    /// Adds the quantiles of `chain` to the trace and writes the trace to `convergence.csv`.
    /// Entries for as many or more runs are replaced.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn note(&mut self, chain: &Chain) -> Result<()> {
        let evaluations = self.evaluations.len();
        let quantiles =
            self.parameters.iter().enumerate().map(|(k, p)| chain.quantiles(k, [0.025, 0.5, 0.975]).map(|u| p.value(u)));
        let trace = Trace { evaluations, quantiles: quantiles.collect() };
        self.trace.retain(|t| t.evaluations < evaluations);
        self.trace.push(trace);
        let columns = self.parameters.iter().map(|p| format!(",{0}_lower,{0}_median,{0}_upper", p.key));
        let mut text = format!("evaluations{}\n", columns.collect::<String>());
        for t in &self.trace {
            let cells = t.quantiles.iter().flatten().map(|q| format!(",{q:?}"));
            text += &format!("{}{}\n", t.evaluations, cells.collect::<String>());
        }
        log::replace(&self.dir.join(TRACE), text.as_bytes())
    }

    /// Makes the check runs at the unit coordinates `u` and returns the curves of those that
    /// finished. The emulator is never fitted to these runs.
    ///
    /// # Errors
    /// [`Error::Stopped`] after an interrupt; [`Error::Campaign`] if runs were killed or the machine had no room for them; files that
    /// cannot be written.
    pub fn check(&mut self, u: &[f64]) -> Result<Vec<Vec<f64>>> {
        let values: Vec<f64> = self.parameters.iter().zip(u).map(|(p, u)| p.rounded(*u)).collect();
        let first = 10_000 * self.settings.seed + 9_000;
        let mut checks: Vec<Evaluation> = (1..=self.settings.check)
            .map(|number| Evaluation {
                number,
                stage: Stage::Check,
                values: values.clone(),
                seed: first + number as u64,
                status: Status::Planned,
            })
            .collect();
        if checks.is_empty() {
            return Ok(Vec::new());
        }
        let ran = self.simulator.run(&checks.iter().collect::<Vec<_>>())?;
        self.unbroken(&checks, &ran)?;
        let mut curves = Vec::new();
        for (e, ran) in checks.iter_mut().zip(ran) {
            match ran {
                Ran::Done(outputs) => {
                    e.status = Status::Done;
                    curves.push(outputs);
                }
                Ran::Failed(reason) => e.status = Status::Failed(reason),
                Ran::Broken(_) | Ran::Stopped => {}
            }
        }
        self.save(&checks)?;
        Ok(curves)
    }

    fn plan(&mut self, stage: Stage, u: &[f64]) {
        let number = self.evaluations.len() + 1;
        let values = self.parameters.iter().zip(u).map(|(p, u)| p.rounded(*u)).collect();
        let seed = 10_000 * self.settings.seed + number as u64;
        self.evaluations.push(Evaluation { number, stage, values, seed, status: Status::Planned });
        self.outputs.push(None);
    }

    /// Makes the planned runs, and reads the outputs of runs that an earlier call has made.
    fn evaluate(&mut self) -> Result<()> {
        std::fs::create_dir_all(&self.dir).map_err(Error::write(&self.dir))?;
        self.save(&[])?;
        let open: Vec<usize> = (0..self.evaluations.len())
            .filter(|&i| self.outputs[i].is_none() && !matches!(self.evaluations[i].status, Status::Failed(_)))
            .collect();
        if open.is_empty() {
            return Ok(());
        }
        (self.tell)(&format!("runs {} to {} of {}", open[0] + 1, open[open.len() - 1] + 1, self.settings.budget));
        let wanted: Vec<&Evaluation> = open.iter().map(|&i| &self.evaluations[i]).collect();
        let ran = self.simulator.run(&wanted)?;
        let wanted: Vec<Evaluation> = wanted.into_iter().cloned().collect();
        for (i, ran) in open.into_iter().zip(ran.clone()) {
            match ran {
                Ran::Done(outputs) => {
                    self.evaluations[i].status = Status::Done;
                    self.outputs[i] = Some(outputs);
                }
                Ran::Failed(reason) => self.evaluations[i].status = Status::Failed(reason),
                Ran::Broken(_) | Ran::Stopped => {}
            }
        }
        self.save(&[])?;
        self.unbroken(&wanted, &ran)
    }

    /// Ends the calibration where runs were interrupted or broken: these stay planned, and a later call goes on with them.
    ///
    /// # Errors
    /// [`Error::Stopped`] after an interrupt, else [`Error::Campaign`]; both with each run that was broken, and why.
    fn unbroken(&self, wanted: &[Evaluation], ran: &[Ran]) -> Result<()> {
        let broken = |(e, ran): (&Evaluation, &Ran)| match ran {
            Ran::Broken(reason) => Some((self.dir.join(e.folder()), reason.clone())),
            _ => None,
        };
        let failed: Vec<(PathBuf, String)> = wanted.iter().zip(ran).filter_map(broken).collect();
        if ran.contains(&Ran::Stopped) {
            return Err(Error::Stopped { failed, done: self.done().count() + self.failed(), of: self.settings.budget });
        }
        if failed.is_empty() { Ok(()) } else { Err(Error::Campaign { failed, of: wanted.len() }) }
    }

    fn save(&self, checks: &[Evaluation]) -> Result<()> {
        let all: Vec<Evaluation> = self.evaluations.iter().chain(checks).cloned().collect();
        let scale = self.scale();
        let misfit = |i: usize| {
            let y = self.outputs.get(i)?.as_ref()?;
            let parts = y.iter().zip(&self.curve.values).zip(&scale).map(|((a, b), s)| ((a - b) / s).powi(2));
            Some((parts.sum::<f64>() / y.len() as f64).sqrt())
        };
        log::write(&self.dir, self.parameters, &all, misfit)
    }

    /// Scale of each output, one value for all outputs of a block: root of the mean of scatter
    /// variance (between the repeats) plus measurement variance; [`NO_SCATTER`] of the range where
    /// both are zero.
    fn scale(&self) -> Vec<f64> {
        let repeats: Vec<&Vec<f64>> = self.done().filter(|(e, _)| e.stage == Stage::Centre).map(|d| d.1).collect();
        let all: Vec<&Vec<f64>> = self.done().map(|d| d.1).collect();
        let mut scale = Vec::new();
        for &length in &self.blocks {
            let own = scale.len()..scale.len() + length;
            let n = repeats.len() as f64;
            let variance = |j: usize| {
                let mean = repeats.iter().map(|y| y[j]).sum::<f64>() / n;
                repeats.iter().map(|y| (y[j] - mean).powi(2)).sum::<f64>() / (n - 1.0)
            };
            let scatter: f64 = if repeats.len() > 1 { own.clone().map(variance).sum() } else { 0.0 };
            let measured: f64 = own.clone().map(|j| self.curve.sd[j].powi(2)).sum();
            let mut size = ((scatter + measured) / length as f64).sqrt();
            if size <= 0.0 || !size.is_finite() {
                let values = all.iter().flat_map(|y| &y[own.clone()]).chain(&self.curve.values[own.clone()]);
                let (low, high) = values.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
                size = NO_SCATTER * (high - low).max(f64::MIN_POSITIVE);
            }
            scale.extend(std::iter::repeat_n(size, length));
        }
        scale
    }

    fn unit(&self, e: &Evaluation) -> Vec<f64> {
        self.parameters.iter().zip(&e.values).map(|(p, v)| p.unit(*v)).collect()
    }

    /// Whether the run nearest to a point has failed.
    fn near_failure(&self, u: &[f64]) -> bool {
        let distance = |e: &Evaluation| super::design::distance(&self.unit(e), u);
        let nearest = self.evaluations.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.is_some_and(|e| matches!(e.status, Status::Failed(_)))
    }

    fn emulator(&self) -> Result<Emulator> {
        let (x, y): (Vec<_>, Vec<_>) = self.done().map(|(e, y)| (self.unit(e), y.clone())).unzip();
        let needed = 3 * self.parameters.len() + 2;
        let fitted = if x.len() < needed { None } else { Emulator::fit(&x, &y, &self.scale()) };
        fitted.ok_or_else(|| {
            let mut failed: Vec<(PathBuf, String)> = Vec::new();
            for e in &self.evaluations {
                if let Status::Failed(reason) = &e.status {
                    failed.push((self.dir.join(e.folder()), reason.clone()));
                }
            }
            if failed.is_empty() {
                let message = "the runs do not differ at the points of the curve: nothing can be found from it";
                return Error::input(self.dir.display(), "", None, message);
            }
            Error::Campaign { failed, of: self.evaluations.len() }
        })
    }
}

/// Name of the file with the quantiles of the parameters after each batch of runs.
const TRACE: &str = "convergence.csv";

fn read_trace(dir: &Path, parameters: &[Parameter]) -> Result<Vec<Trace>> {
    let path = dir.join(TRACE);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let file = Columns::read(&path)?;
    let column =
        |name: &str| -> Result<Vec<f64>> { Ok(file.numbers(name, 1.0)?.into_iter().map(|x| x.unwrap_or(f64::NAN)).collect()) };
    let counts = column("evaluations")?;
    let mut trace: Vec<Trace> = counts.iter().map(|&n| Trace { evaluations: n as usize, quantiles: Vec::new() }).collect();
    for p in parameters {
        let [low, middle, high] = ["lower", "median", "upper"].map(|which| column(&format!("{}_{which}", p.key)));
        let (low, middle, high) = (low?, middle?, high?);
        for (i, t) in trace.iter_mut().enumerate() {
            t.quantiles.push([low[i], middle[i], high[i]]);
        }
    }
    Ok(trace)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::stand_in::{self, StandIn};
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Simulator of the tests: the curve in closed form; it fails where the second parameter is
    /// small, and stops after a number of calls.
    struct Fake {
        stand_in: StandIn,
        calls: AtomicUsize,
        stop_after: usize,
    }

    impl Fake {
        fn new(stop_after: usize) -> Fake {
            Fake { stand_in: StandIn::default(), calls: AtomicUsize::new(0), stop_after }
        }
    }

    impl Simulator for Fake {
        fn run(&self, wanted: &[&Evaluation]) -> Result<Vec<Ran>> {
            Ok(wanted
                .iter()
                .map(|e| match self.calls.fetch_add(1, Ordering::Relaxed) {
                    n if n >= self.stop_after => Ran::Stopped,
                    _ if e.values[1] < 0.1 => Ran::Failed("did not come to rest".into()),
                    _ => Ran::Done(self.stand_in.curve(&e.values, e.seed)),
                })
                .collect())
        }
    }

    const TRUTH: [f64; 2] = [0.35, 0.7];

    fn target() -> Measured {
        let values = StandIn::default().curve(&TRUTH, 77);
        Measured { sd: vec![0.0; values.len()], values, specimens: 1.0 }
    }

    fn settings(budget: usize) -> Settings {
        Settings { budget, design: 14, ..Settings::usual(2) }
    }

    fn search_with(dir: &Path, fake: &Fake, budget: usize) -> Result<(Vec<[f64; 2]>, usize)> {
        let (parameters, curve, settings) = (stand_in::parameters(), target(), settings(budget));
        let mut search = Search::new(&parameters, &curve, vec![15], &settings, fake, dir, &|_| ())?;
        let emulator = search.run()?;
        let mut rng = search.rng(1 << 40);
        let chain = Posterior::new(&parameters, &emulator, &curve, 1.0).sample(24, 100, 200, 1.0, &mut rng);
        search.check(chain.mode())?;
        Ok(((0..2).map(|k| chain.quantiles(k, [0.025, 0.975])).collect(), search.failed()))
    }

    #[test]
    fn known_parameters_are_found_with_runs_that_fail_on_the_way() {
        let dir = tempfile::tempdir().expect("folder");
        let (intervals, failed) = search_with(dir.path(), &Fake::new(usize::MAX), 30).expect("found");
        assert!(failed > 0, "the design reaches where runs fail");
        for (interval, truth) in intervals.iter().zip(TRUTH) {
            assert!(interval[0] < truth && truth < interval[1], "{intervals:?}");
            assert!(interval[1] - interval[0] < 0.6, "{intervals:?}");
        }
        let log = std::fs::read_to_string(dir.path().join(log::FILE)).expect("log");
        assert_eq!(log.lines().count(), 1 + 30 + 4, "a failed run costs one evaluation");
        assert!(log.contains("did not come to rest"));
    }

    /// A calibration that was stopped (after 5, 20 or 23 runs) and continued ends with the log of
    /// one that was not stopped.
    #[test]
    fn a_stopped_calibration_goes_on_to_the_same_end() {
        let whole = tempfile::tempdir().expect("folder");
        let once = search_with(whole.path(), &Fake::new(usize::MAX), 26).expect("found");
        let log = |dir: &Path| std::fs::read_to_string(dir.join(log::FILE)).expect("log");
        for stop in [5, 20, 23] {
            let dir = tempfile::tempdir().expect("folder");
            assert!(matches!(search_with(dir.path(), &Fake::new(stop), 26), Err(Error::Stopped { .. })));
            assert!(log(dir.path()).contains("planned"));
            assert_eq!(search_with(dir.path(), &Fake::new(usize::MAX), 26).expect("found"), once);
            assert!(log(dir.path()) == log(whole.path()), "stopped after {stop}");
            let trace = |dir: &Path| std::fs::read_to_string(dir.join(TRACE)).expect("trace");
            assert!(trace(dir.path()) == trace(whole.path()) && trace(dir.path()).lines().count() == 3);
        }
        // a larger budget adds runs to those already made
        search_with(whole.path(), &Fake::new(usize::MAX), 30).expect("found");
        assert_eq!(log(whole.path()).lines().count(), 1 + 30 + 4);
    }

    /// A run that was killed says nothing about its parameters: it is no failure in the log, and is made again.
    #[test]
    fn a_run_that_was_killed_is_made_again() {
        struct Killed(AtomicUsize, Fake);
        impl Simulator for Killed {
            fn run(&self, wanted: &[&Evaluation]) -> Result<Vec<Ran>> {
                let mut ran = self.1.run(wanted)?;
                if self.0.fetch_add(1, Ordering::Relaxed) == 1 {
                    ran[1] = Ran::Broken("was killed by SIGKILL".into());
                }
                Ok(ran)
            }
        }
        let [whole, dir] = [(); 2].map(|()| tempfile::tempdir().expect("folder"));
        let once = search_with(whole.path(), &Fake::new(usize::MAX), 26).expect("found");
        let (parameters, curve, settings) = (stand_in::parameters(), target(), settings(26));
        let killed = Killed(AtomicUsize::new(0), Fake::new(usize::MAX));
        let mut search = Search::new(&parameters, &curve, vec![15], &settings, &killed, dir.path(), &|_| ()).expect("new");
        let error = search.run().expect_err("the second batch was broken");
        assert!(error.to_string().contains("run-020: was killed by SIGKILL\n1 of 5 runs failed"), "{error}");
        assert_eq!(error.exit_code(), 1);
        let log = |dir: &Path| std::fs::read_to_string(dir.join(log::FILE)).expect("log");
        assert!(log(dir.path()).contains("runs/run-020,planned") && !log(dir.path()).contains("SIGKILL"));
        assert_eq!(search_with(dir.path(), &Fake::new(usize::MAX), 26).expect("found"), once);
        assert!(log(dir.path()) == log(whole.path()));
    }

    #[test]
    fn too_many_failures_end_it_with_their_reasons() {
        struct Broken;
        impl Simulator for Broken {
            fn run(&self, wanted: &[&Evaluation]) -> Result<Vec<Ran>> {
                Ok(wanted.iter().map(|_| Ran::Failed("no floor".into())).collect())
            }
        }
        let dir = tempfile::tempdir().expect("folder");
        let (parameters, curve, settings) = (stand_in::parameters(), target(), settings(30));
        let mut search = Search::new(&parameters, &curve, vec![15], &settings, &Broken, dir.path(), &|_| ()).expect("new");
        let error = search.run().expect_err("nothing to go by");
        assert!(error.to_string().contains("no floor") && error.exit_code() == 1, "{error}");
    }
}
