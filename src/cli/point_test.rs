//! `comminute point-test MATERIAL`

use super::{list_files, print};
use comminute::error::Result;
use comminute::point_test::{self, Path, Settings};
use comminute::scene;
use serde_json::Value;
use std::path::PathBuf;

/// Take the continuum law of a material through a laboratory path at a single point
///
/// Writes history.csv (compression positive), summary.json, the material with its defaults and figures.
#[derive(Debug, clap::Args)]
#[command(after_help = "triaxial       drained, at constant cell pressure; a negative strain is extension\n\
        oedometer      axial strain without lateral strain\n\
        simple_shear   shear strain without any other, so at constant volume\n\
        isotropic      the same strain along every axis\n\
        undrained      axial strain at constant volume; stresses are effective\n\n\
        Examples, from the repository root:\n  comminute point-test materials/li2023_fines.toml --confining-kPa 50,100,150\n  \
        comminute point-test materials/li2023_fines.toml --path oedometer --strain 0.02 --set continuum.nu=0.3 --out runs/oedometer")]
pub struct Args {
    /// Material file (TOML) with a table [continuum]
    #[arg(value_name = "MATERIAL")]
    material: PathBuf,

    /// Replace a value of the material, as in continuum.cohesion_kPa=5
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,

    /// What is done to the point
    #[arg(long, value_name = "PATH", default_value = "triaxial")]
    path: Way,

    /// Isotropic stress at the start, kPa; the cell pressure of a triaxial test. Each of several
    /// values makes a test
    #[arg(long = "confining-kPa", value_name = "KPA", value_delimiter = ',', default_value = "100", allow_negative_numbers = true)]
    confining_kpa: Vec<f64>,

    /// Axial strain at the end, or engineering shear strain
    #[arg(long, value_name = "STRAIN", default_value_t = 0.15, allow_negative_numbers = true)]
    strain: f64,

    /// Steps of equal strain
    #[arg(long, value_name = "N", default_value_t = 1500, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    steps: u32,

    /// Folder for everything the test leaves [default: runs/point-test- and the name of the material file]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Overwrite an older test
    #[arg(long)]
    force: bool,

    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,

    /// Print summary.json to standard output
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Way {
    Triaxial,
    Oedometer,
    #[value(name = "simple_shear", alias = "simple-shear")]
    SimpleShear,
    Isotropic,
    Undrained,
}

pub fn call(args: &Args) -> Result<()> {
    let settings = Settings {
        path: match args.path {
            Way::Triaxial => Path::Triaxial,
            Way::Oedometer => Path::Oedometer,
            Way::SimpleShear => Path::SimpleShear,
            Way::Isotropic => Path::Isotropic,
            Way::Undrained => Path::Undrained,
        },
        confining: args.confining_kpa.iter().map(|p| 1e3 * p).collect(),
        strain: args.strain,
        steps: args.steps,
    };
    settings.check()?;
    let material = scene::continuum(&args.material, &args.sets)?;
    let out = args.out.clone().unwrap_or_else(|| {
        let stem = args.material.file_stem().unwrap_or_default().to_string_lossy();
        PathBuf::from("runs").join(format!("point-test-{stem}"))
    });
    let tests = point_test::drive(&material.law, &settings)?;
    point_test::claim(&out, args.force)?;
    let figures = point_test::write(&material, &settings, &tests, &out)?;
    let summary = point_test::summary(&material, &settings, &tests);
    if args.json {
        print(&format!("{summary:#}"))?;
    }
    if !args.quiet {
        for a in &material.assumed {
            eprintln!("assumed: {} = {}  ({})", a.key, scene::shown(&a.value), a.source);
        }
        print_results(&summary);
        eprintln!("records in {}", out.display());
        list_files(&figures);
    }
    Ok(())
}

fn print_results(summary: &Value) {
    let text = |v: &Value| v.as_f64().map_or("-".into(), |x| format!("{x:.4}"));
    for test in summary["tests"].as_array().into_iter().flatten() {
        let known = |key: &str, what: &str| match &test[key] {
            Value::Null => String::new(),
            value => format!(", {what} {}", text(value)),
        };
        eprintln!(
            "initial stress {} kPa: largest q {} kPa, stress ratio at the peak {}{}{}{}{}",
            test["confining_kPa"].as_f64().unwrap_or(0.0),
            text(&test["peak_q_kPa"]),
            text(&test["peak_stress_ratio"]),
            known("closed_form_peak_stress_ratio", "closed form"),
            known("final_stress_ratio", "at the end"),
            known("final_k0", "k0 at the end"),
            known("largest_tau_kPa", "largest tau (kPa)"),
        );
    }
}
