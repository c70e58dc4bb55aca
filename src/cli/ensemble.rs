//! `comminute ensemble SCENE`

use super::campaign::{self, Options};
use comminute::campaign::{Hold, Job, Vary, parse_seeds};
use comminute::error::{Error, Result};
use comminute::figure;
use std::path::PathBuf;

/// Run a scene with several seeds, and draw mean and band of every curve
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example, from the repository root:\n  comminute ensemble experiments/petroleum_coke/h-c-2.toml --seeds 1..4 --set loading.max_stress_kPa=100 --out runs/seeds"
)]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,

    /// Seeds, as 1..8 (both included) or 1,2,5
    #[arg(long, value_name = "LIST", default_value = "1..8")]
    seeds: String,

    /// What the seeds choose
    #[arg(long, value_enum, default_value = "both")]
    vary: What,

    /// Replace a value of the scene or its material, as in loading.max_stress_kPa=2000
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,

    /// Folder of the runs, seed-1 …, and of the figures; runs/ and the name of the scene file with -ensemble if not given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    #[command(flatten)]
    options: Options,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub enum What {
    /// Specimen and strengths
    Both,
    /// The specimen
    Packing,
    /// The strengths
    Strength,
}

impl From<What> for Vary {
    fn from(what: What) -> Vary {
        match what {
            What::Both => Vary::Both,
            What::Packing => Vary::Packing,
            What::Strength => Vary::Strength,
        }
    }
}

pub fn call(args: &Args) -> Result<()> {
    args.options.may_vary(args.vary.into())?;
    let seeds = parse_seeds(&args.seeds)?;
    let out = args.out.clone().unwrap_or_else(|| campaign::default_out(&args.scene, "ensemble"));
    let job = |seed: u64| Job::new(&args.scene, out.join(format!("seed-{seed}"))).with(&args.sets).seeded(args.vary.into(), seed);
    let mut jobs: Vec<Job> = seeds.into_iter().map(job).collect();
    let Some(outcomes) = args.options.run(&mut jobs, &out)? else { return Ok(()) };
    // tables and figures of two campaigns at once would be written into each other
    let _alone = Hold::wait_for(&out)?;
    let done = campaign::done(&jobs, &outcomes);
    let mut files = Vec::new();
    if !done.is_empty() {
        files = figure::overlay(&done, &args.options.data, &out.join("figures"))?;
        files.extend(figure::write_means(&done, &out).map_err(Error::from)?);
    }
    args.options.close(&jobs, &outcomes, &files)
}
