//! `comminute calibrate fines RUN…`

use super::list_files;
use comminute::calibrate::compression::compression;
use comminute::calibrate::fines::{FILE, calibrate};
use comminute::calibrate::grains::report;
use comminute::calibrate::interface::interface;
use comminute::calibrate::json_text;
use comminute::error::{Error, Result};
use comminute::mpm::law::Dilation;
use std::path::PathBuf;

/// Find the continuum law of fine grains from drained triaxial tests of these grains
///
/// Reads stiffness, friction against plastic strain (Li et al. 2023, eq. 43) and dilation off the
/// curves of runs with grains only, no continuum, and writes material.toml, calibration.json and
/// friction_angle.csv. With a compression of the same grains also the lines of Modified Cam-clay, in
/// cam_clay.toml and compression.json.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example, from the repository root:\n  comminute run experiments/mixture/twin_grains.toml --set coarse.mass_fraction=0 --out runs/fines\n  \
        comminute calibrate fines runs/fines --base ../../materials/li2023_fines.toml --out runs/fines_law\n  \
        comminute calibrate fines runs/fines --dilation mobilised --compression runs/isotropic --out runs/fines_law\n  \
        comminute calibrate fines runs/fines --interface runs/mixture --out runs/fines_law"
)]
pub struct Args {
    /// Folders of triaxial runs with several seeds or cell pressures
    #[arg(value_name = "RUN", required = true)]
    runs: Vec<PathBuf>,

    /// The grains' material, written as `base` of material.toml, relative to it
    #[arg(long, value_name = "FILE")]
    base: Option<String>,

    /// Whether the dilation angle of material.toml stays, or ends with softening; calibration.json has both
    #[arg(long, value_name = "RULE", default_value = "constant")]
    dilation: Rule,

    /// Folder of an isotropic compression or an oedometer of the same grains, with loading and unloading
    #[arg(long, value_name = "RUN")]
    compression: Option<PathBuf>,

    /// Folders of triaxial tests of a mixture of these grains with coarse ones, run with
    /// records.contacts=true: interface_friction of material.toml is the friction along the coarse grains,
    /// which falls with plastic strain where it does in these tests
    #[arg(long, value_name = "RUN", num_args = 1..)]
    interface: Vec<PathBuf>,

    /// Folder for the results
    #[arg(long, value_name = "DIR", default_value = "runs/calibrate-fines")]
    out: PathBuf,

    /// Overwrite an older calibration
    #[arg(long)]
    force: bool,

    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Rule {
    Constant,
    Mobilised,
}

pub fn call(args: &Args) -> Result<()> {
    let found = calibrate(&args.runs)?;
    let lines = args.compression.as_deref().map(compression).transpose()?;
    let elastic = [1e6 * found.young_mpa, found.nu];
    let along = if args.interface.is_empty() { None } else { Some(interface(&args.interface, elastic)?) };
    let dilation = match args.dilation {
        Rule::Constant => Dilation::Constant,
        Rule::Mobilised => Dilation::Mobilised,
    };
    report::claim(&args.out, args.force)?;
    let mut files = found.write(&args.out, args.base.as_deref(), dilation, along.as_ref())?;
    let mut more = Vec::new();
    if let Some(lines) = &lines {
        more.push(("cam_clay.toml", lines.material(args.base.as_deref(), found.residual_deg, found.nu)));
        more.push(("compression.json", json_text(lines)));
    }
    if let Some(along) = &along {
        more.push(("interface.json", json_text(along)));
    }
    for (name, text) in more {
        let path = args.out.join(name);
        std::fs::write(&path, text).map_err(Error::write(&path))?;
        files.push(path);
    }
    if !args.quiet {
        let line = |name: &str, value: String| eprintln!("  {name:<24}{value}");
        eprintln!("{} tests", found.tests.len());
        line("E (MPa), nu", format!("{:.2}, {:.3}", found.young_mpa, found.nu));
        line("phi peak, residual (deg)", format!("{:.2}, {:.2}", found.peak_deg, found.residual_deg));
        line("plastic strain at peak", format!("{:.4}", found.peak_plastic_strain));
        line("H", format!("{:.1}", found.decay));
        line("psi (deg)", format!("{:.2}, misfit of volume {:.2e}", found.dilation_deg, found.volume_misfit));
        line(
            "psi that ends (deg)",
            format!("{:.2}, misfit of volume {:.2e}", found.mobilised_dilation_deg, found.mobilised_volume_misfit),
        );
        if let Some(lines) = &lines {
            line("lambda, kappa", format!("{:.4}, {:.4}", lines.lambda, lines.kappa));
            line("v at 1 kPa, p_c (kPa)", format!("{:.4}, {:.1}", lines.virgin_specific_volume, lines.preconsolidation_kpa));
        }
        if let Some(along) = &along {
            let spread = along.spread.map_or(String::new(), |s| format!(" +- {s:.3} between tests"));
            line("friction along coarse", format!("{:.3}{spread}, misfit {:.3}", along.friction, along.misfit));
            if let (Some(falling), Some(misfit)) = (along.falling, along.falling_misfit) {
                line(
                    "the same, falling",
                    format!("{:.3} to {:.3}, H {:.1}, misfit {misfit:.3}", falling.initial, falling.residual, falling.decay),
                );
            }
        }
        line("misfit (deg)", format!("{:.2}", found.misfit_deg));
        eprintln!("in a scene: materials.fines = \"path/to/{FILE}\"");
        list_files(&files);
    }
    Ok(())
}
