//! `comminute run SCENE`

use super::Overrides;
use comminute::error::{Error, Result};
use comminute::rig::preparation::range::void_ratio;
use comminute::run::{Backend, Found, Outcome, ResumeOptions, RunRequest, choose, in_pool, look, occupied, resume, run, settle};
use comminute::scene;
use std::path::{Path, PathBuf};

/// Run a scene and draw its figures
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example, from the repository root:\n  comminute run experiments/petroleum_coke/h-c-2.toml --set loading.max_stress_kPa=500 --out runs/try"
)]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,

    /// Folder for everything the run leaves; runs/ and the name of the scene file if not given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    #[command(flatten)]
    overrides: Overrides,

    /// Threads; all cores if not given. Results do not depend on it
    #[arg(long, value_name = "N", value_parser = super::threads())]
    threads: Option<u16>,

    /// Backend that computes the steps of a continuum; cpu if not given
    #[arg(long, value_enum)]
    backend: Option<super::Backend>,

    /// Begin with a prepared specimen (specimen.csv of another run) instead of making one
    #[arg(long, value_name = "FILE")]
    specimen: Option<PathBuf>,

    /// Overwrite the run that the folder holds
    #[arg(long)]
    force: bool,

    /// Do only what is left of the run: nothing if the folder holds it finished, the rest if it
    /// holds a checkpoint, else all of it. With --force a run of another scene is overwritten
    #[arg(long = "continue")]
    left: bool,

    /// Stop after this many steps, preparation included (on a graphics device at its next look, at most 64 steps later); `comminute resume` goes on from there
    #[arg(long, value_name = "STEPS")]
    stop_after: Option<u64>,

    /// No progress and no closing summary
    #[arg(long)]
    quiet: bool,

    /// Print the summary as JSON to standard output
    #[arg(long)]
    json: bool,
}

pub fn call(mut args: Args) -> Result<()> {
    if let Some(specimen) = &args.specimen {
        args.overrides.sets.push(format!("specimen.file={:?}", specimen.display().to_string()));
    }
    let scene = args.overrides.load(&args.scene)?;
    let mut model = scene::model(&scene)?;
    let out = args.out.unwrap_or_else(|| scene.default_out());
    if args.left {
        let found = look(&out, &scene, &model)?;
        let options = ResumeOptions {
            threads: args.threads.map(usize::from),
            quiet: args.quiet,
            json: args.json,
            stop_after: args.stop_after,
            backend: args.backend.map(Into::into),
        };
        match found {
            Found::Finished(summary) => return super::close(Outcome { summary, out, draw: false }, args.quiet, args.json),
            Found::Undrawn(summary) => return super::close(Outcome { summary, out, draw: true }, args.quiet, args.json),
            Found::Unfinished => return super::close(resume(&out, options)?, args.quiet, args.json),
            Found::Busy => return Err(Error::Busy { path: out }),
            Found::Other(what) if !args.force => return Err(Error::Other { path: out, what }),
            Found::Broken | Found::Other(_) => args.force = true,
            Found::Nothing => {}
        }
    }
    free(&out, args.force)?;
    let outline = scene::outline(&scene)?;
    let estimate = scene::estimate(&outline, None);
    scene::enough_disk(&outline, &estimate, &out)?;
    drop(outline);
    let backend = choose(args.backend.map_or_else(Backend::default, Into::into), &model)?;
    if !args.quiet {
        if let Some(why) = &backend.why {
            eprintln!("backend {}: {why}", backend.name());
        }
        let crowded = scene::crowded(&estimate, comminute::machine::free_memory());
        for warning in estimate.warnings.iter().chain(&crowded) {
            eprintln!("warning: {warning}");
        }
    }
    let threads = args.threads.map(usize::from);
    if !args.quiet && !scene::is_given_its_specimen(&scene) {
        scene::reach(&model).and_then(|reach| scene::doubt(&model, &reach)).iter().for_each(|doubt| eprintln!("{doubt}"));
    }
    let reach = in_pool(threads, || Ok(scene::sure_reach(&scene, &model, true)))?;
    if let (Some(reach), None) = (reach, scene.specimen()) {
        scene::within_reach(&scene, &model, &reach)?;
        reach.settle(&mut model);
        let density = model.rig.specimen().and_then(|rig| rig.relative_density);
        if let (Some(density), false) = (density, args.quiet) {
            let measuring = if reach.measured { "" } else { " (measured now, once for these grains)" };
            eprintln!("relative density {density}: a share of the range of void ratios{measuring}");
        }
        if let (Some(range), false) = (settle(&mut model, threads)?, args.quiet) {
            let n = model.rig.specimen().map_or(f64::NAN, |rig| rig.porosity);
            let [e, dense, loose] = [n, range.densest, range.loosest].map(void_ratio);
            eprintln!("void ratio {e:.3}, between {dense:.3} and {loose:.3} (measured)");
        }
    }
    let outcome = run(RunRequest {
        model,
        scene_resolved: scene::resolved(&scene),
        out,
        force: args.force,
        threads,
        specimen: scene.specimen(),
        quiet: args.quiet,
        json: args.json,
        stop_after: args.stop_after,
        backend,
    })?;
    super::close(outcome, args.quiet, args.json)
}

/// Refuses a folder that holds anything but the message of a run that failed, unless `force`.
fn free(out: &Path, force: bool) -> Result<()> {
    if out.is_file() {
        let message = "is a file; --out needs a folder";
        return Err(Error::input(out.display(), "", None, message));
    }
    match std::fs::read_dir(out) {
        Ok(_) if occupied(out) && !force => Err(Error::Exists { path: out.into() }),
        Ok(_) => Ok(()),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(()),
        Err(source) => Err(Error::Read { path: out.into(), source }),
    }
}
