//! `comminute import FILE --out grains.csv`

use comminute::error::{Error, Result};
use comminute::exchange;
use comminute::scene::MOST_GRAINS;
use std::path::PathBuf;

/// Make the table of grains of a free scene from a file of another program
///
/// A scene takes the table with grains_csv = "grains.csv". Velocities and spins come with it; densities are those of the scene's materials.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
        comminute import packing.data --out grains.csv\n  \
        comminute import spheres.txt --unit-mm 1 --out grains.csv")]
pub struct Args {
    /// Data file of LAMMPS or LIGGGHTS (atom_style sphere), or text of Yade (x, y, z, radius)
    file: PathBuf,

    /// Program that the file is of; LAMMPS where its name ends in .data or .lmp, else Yade, if not given
    #[arg(long, value_name = "PROGRAM")]
    from: Option<Program>,

    /// Length of the file's unit, mm
    #[arg(long, value_name = "MM", default_value_t = 1000.0)]
    unit_mm: f64,

    /// Names of the scene's materials, one for each type of the file, in their order
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    materials: Vec<String>,

    /// Table to write
    #[arg(long, value_name = "CSV")]
    out: PathBuf,

    /// Overwrite a table that is there
    #[arg(long)]
    force: bool,

    /// Do not say what was read
    #[arg(long)]
    quiet: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
enum Program {
    /// LAMMPS, or LIGGGHTS
    #[value(alias = "liggghts")]
    Lammps,
    /// Yade
    Yade,
}

pub fn call(args: &Args) -> Result<()> {
    if !(args.unit_mm.is_finite() && args.unit_mm > 0.0) {
        return Err(Error::input("--unit-mm", "", None, "must be a number > 0"));
    }
    if args.out.exists() && !args.force {
        return Err(Error::input(args.out.display(), "", None, "is there already; --force overwrites it"));
    }
    let ending = args.file.extension().and_then(|e| e.to_str()).unwrap_or("");
    let from = args.from.unwrap_or(if ["data", "lmp"].contains(&ending) { Program::Lammps } else { Program::Yade });
    let unit = args.unit_mm / 1000.0;
    let packing = match from {
        Program::Lammps => exchange::read_lammps(&args.file, unit)?,
        Program::Yade => exchange::read_yade(&args.file, unit)?,
    };
    if packing.grains.len() > MOST_GRAINS {
        let message = format!("has {} grains; a scene may have at most {MOST_GRAINS}", packing.grains.len());
        return Err(Error::input(args.file.display(), "", None, message));
    }
    let (types, named) = (packing.types, args.materials.len());
    if (named > 0 && named != types) || (named == 0 && types > 1) {
        let message = format!("must name {types} materials, one for each type of {}", args.file.display());
        return Err(Error::input("--materials", "", None, message));
    }
    let text = exchange::grains_csv(&packing, &args.materials);
    comminute::table::write(&args.out, text).map_err(Error::write(&args.out))?;
    if !args.quiet {
        let radii = || packing.grains.iter().map(|g| 1e3 * g.radius);
        let (low, high) = (radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max));
        eprintln!("{} grains with radii of {low:.4} to {high:.4} mm in {}", packing.grains.len(), args.out.display());
    }
    Ok(())
}
