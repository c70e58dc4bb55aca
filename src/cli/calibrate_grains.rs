//! `comminute calibrate grains DATA.csv`

use super::{list_files, print};
use comminute::calibrate::grains::area::Model;
use comminute::calibrate::grains::fit::Intervals;
use comminute::calibrate::grains::inputs::Given;
use comminute::calibrate::grains::report::{self, in_words};
use comminute::calibrate::grains::spread::Spread;
use comminute::calibrate::grains::{Calibration, Settings, calibrate, data, fragment};
use comminute::error::{Error, Result};
use indicatif::ProgressBar;
use std::path::PathBuf;

/// Strength of grains from the forces that crushed them between platens
///
/// Fits sigma_lim0, m and var. (Ciantia et al. 2015, eqs 7, 16, 17) by maximum likelihood, with normal, truncated normal,
/// log-normal and Weibull spread, and writes calibration.json, report.md, material.toml and figures.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "DATA.csv has a row for each grain: diameter_mm (or _m, _cm, _um) and force_N (or _kN, _MN, _mN), the force at which it broke;\n\
        optional: censored (1: it did not break at this force), series (a name).\n\n\
        Forces alone identify sigma_lim0 sin²(theta0), or sigma_lim0³/E'²: give --theta0, or --grain-E-GPa and --grain-nu, or a\n\
        --material that has them. Without, m and var. are found and sigma_lim0 is left open.\n\n\
        Preferred is the smallest AIC; a truncated normal, which scenes draw, unless another spread is better by 2.\n\n\
        Examples, from the repository root:\n  comminute calibrate grains figures/calibration/grains/simulated.csv --theta0 0.1309\n  \
        comminute calibrate grains figures/calibration/grains/simulated.csv --material materials/silica_sand.toml --out runs/silica"
)]
pub struct Args {
    /// Crushing tests (CSV)
    #[arg(value_name = "DATA")]
    data: PathBuf,

    /// Model of the contact area; if not given: the one whose input (angle, or moduli) is known, or
    /// both models if both inputs or none are
    #[arg(long, value_name = "MODEL")]
    area_model: Option<AreaModels>,

    /// Contact angle, rad (eq. 16)
    #[arg(long, value_name = "RAD")]
    theta0: Option<f64>,

    /// Young's modulus of the grains, GPa (eq. 17)
    #[arg(long = "grain-E-GPa", value_name = "GPA")]
    grain_e_gpa: Option<f64>,

    /// Poisson ratio of the grains
    #[arg(long, value_name = "NU", allow_negative_numbers = true)]
    grain_nu: Option<f64>,

    /// Young's modulus of the platens, GPa (steel)
    #[arg(long = "platen-E-GPa", value_name = "GPA", default_value_t = 200.0)]
    platen_e_gpa: f64,

    /// Poisson ratio of the platens
    #[arg(long, value_name = "NU", default_value_t = 0.3, allow_negative_numbers = true)]
    platen_nu: f64,

    /// Reference diameter of sigma_lim0, mm [default: the material's, else 2]
    #[arg(long = "d0-mm", value_name = "MM")]
    d0_mm: Option<f64>,

    /// Material of the grains: gives theta0, moduli and d0 that are not given here, and the base of material.toml
    #[arg(long, value_name = "FILE")]
    material: Option<PathBuf>,

    /// How the 95 % limits are found
    #[arg(long, value_name = "METHOD", default_value = "profile")]
    intervals: Method,

    /// Resamples of the bootstrap
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(100..=1_000_000))]
    bootstrap: u32,

    /// Samples drawn to judge the goodness of each fit (0: none)
    #[arg(long, value_name = "N", default_value_t = 199, value_parser = clap::value_parser!(u32).range(0..=100_000))]
    samples: u32,

    /// Seed of bootstrap and samples
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Folder for the results [default: runs/calibrate- and the name of the data file]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Overwrite an older calibration
    #[arg(long)]
    force: bool,

    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,

    /// Print calibration.json to standard output
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum AreaModels {
    FixedAngle,
    Hertz,
    Both,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Method {
    Profile,
    Bootstrap,
}

pub fn call(args: &Args) -> Result<()> {
    let given = Given {
        models: args.area_model.map(|m| match m {
            AreaModels::FixedAngle => vec![Model::FixedAngle],
            AreaModels::Hertz => vec![Model::Hertz],
            AreaModels::Both => vec![Model::FixedAngle, Model::Hertz],
        }),
        theta0: args.theta0,
        grain_e_gpa: args.grain_e_gpa,
        grain_nu: args.grain_nu,
        platen_e_gpa: args.platen_e_gpa,
        platen_nu: args.platen_nu,
        d0_mm: args.d0_mm,
        material: args.material.clone(),
    };
    let inputs = given.resolve()?;
    let tests = data::read(&args.data)?;
    let out = args.out.clone().unwrap_or_else(|| {
        let stem = args.data.file_stem().unwrap_or_default().to_string_lossy();
        PathBuf::from("runs").join(format!("calibrate-{stem}"))
    });
    if out.is_file() {
        return Err(Error::input(out.display(), "", None, "is a file, not a folder"));
    }
    report::claim(&out, args.force)?;
    let intervals = match args.intervals {
        Method::Profile => Intervals::Profile,
        Method::Bootstrap => Intervals::Bootstrap { resamples: args.bootstrap as usize, seed: args.seed },
    };
    let settings = Settings { intervals, samples: args.samples as usize, seed: args.seed };
    let bar = bar(args.quiet, (inputs.areas.len() * Spread::ALL.len()) as u64, "models");
    let result = calibrate(tests, inputs, settings, || bar.inc(1));
    bar.finish_and_clear();
    let files = report::write(&result, &out)?;
    if args.json {
        print(&format!("{:#}", report::json(&result)))?;
    }
    if !args.quiet {
        print_estimates(&result, files.iter().any(|f| f.ends_with(fragment::FILE)));
        list_files(&files);
    }
    Ok(())
}

/// Progress bar; it is drawn on a terminal only.
pub fn bar(quiet: bool, length: u64, what: &'static str) -> ProgressBar {
    let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(length) };
    if let Ok(style) = indicatif::ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}  {elapsed}, {eta} left") {
        bar.set_style(style);
    }
    bar.with_message(what)
}

fn print_estimates(c: &Calibration, material: bool) {
    let best = c.best();
    let censored = c.data.grains.len() - c.data.broken();
    let sizes = if c.classes.len() == 1 { "one size".into() } else { format!("{} sizes", c.classes.len()) };
    eprintln!("{} grains, {sizes}, {censored} not broken", c.data.grains.len());
    eprintln!("{}, {} spread: {}", best.area.model.name(), best.spread.name(), c.why);
    let line = |name: &str, value: String| eprintln!("  {name:<24}{value}");
    line("sigma_lim0 (MPa)", in_words(&best.sigma_lim0_mpa()));
    if let Some(at_size) = best.sigma_at_size_mpa() {
        line("strength at this size", in_words(&at_size));
    }
    line("m", in_words(&best.m()));
    line("var.", in_words(&best.var()));
    line(best.area.identified_name(), format!("{} MPa", in_words(&best.identified_mpa())));
    if let Some(p) = c.goodness[c.best].p_value {
        line("goodness of fit", format!("p = {p:.3} (Anderson-Darling)"));
    }
    for note in c.notes() {
        eprintln!("note: {note}");
    }
    if !material {
        eprintln!(
            "note: no material.toml: a scene needs sigma_lim0, m and var. of the truncated normal, and not all could be estimated"
        );
    }
}
