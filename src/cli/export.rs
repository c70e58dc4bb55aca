//! `comminute export RUN --out FILE`

use comminute::error::{Error, Result};
use comminute::exchange::{self, Contents, Surfaces};
use std::path::PathBuf;

/// Write grains and bodies of a run for other programs
///
/// Lengths are in m, velocities in m/s, densities in kg/m³, those of the model; numbers of text files are exact.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples, after the run:\n  \
        comminute export runs/h-c-2 --to lammps --out h-c-2.data\n  \
        comminute export runs/h-c-2 --to paraview --out h-c-2-small")]
pub struct Args {
    /// Folder of a run
    run: PathBuf,

    /// What is written
    #[arg(long, value_name = "FORMAT")]
    to: Format,

    /// File to write; of a series the folder
    #[arg(long, value_name = "FILE")]
    out: PathBuf,

    /// Number of the snapshot in the run's list, from 0; the end of the run if not given
    #[arg(long, value_name = "N")]
    snapshot: Option<usize>,

    /// stl, ply: triangles of each grain, with corners on its sphere: 20, 80, 320 or 1280
    #[arg(long, value_name = "N", default_value_t = 80)]
    triangles: u32,

    /// paraview: quantities of the snapshots to keep, as in radius,velocity; of grains radius, generation, material, force, mean stress and
    /// number, of all else everything, if not given
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    fields: Vec<String>,

    /// Overwrite what is there
    #[arg(long)]
    force: bool,

    /// Do not say what was written
    #[arg(long)]
    quiet: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
enum Format {
    /// Triangles of grains and bodies, binary, single precision
    Stl,
    /// The same with radius, generation and body of each corner, places in double precision
    Ply,
    /// Data file of LAMMPS and LIGGGHTS, atom_style sphere, units si
    #[value(alias = "liggghts")]
    Lammps,
    /// Text of Yade: x, y, z, radius
    Yade,
    /// All snapshots once more, a seventh as long or less: single precision, rounded, compressed
    Paraview,
}

pub fn call(args: &Args) -> Result<()> {
    let there = args.out.is_file() || args.out.read_dir().is_ok_and(|mut entries| entries.next().is_some());
    if there && !args.force {
        return Err(Error::input(args.out.display(), "", None, "is there already; --force overwrites it"));
    }
    if args.to == Format::Paraview {
        let lists = exchange::series(&args.run, &args.out, &args.fields)?;
        if !args.quiet {
            super::list_files(&lists);
        }
        return Ok(());
    }
    let contents = Contents::of_run(&args.run, args.snapshot)?;
    let text = matches!(args.to, Format::Lammps | Format::Yade);
    if text && contents.grains.is_empty() {
        return Err(Error::input(args.run.display(), "", None, "holds no grains; bodies can be written as stl or ply"));
    }
    let surfaces = || Surfaces::of(&contents, args.triangles);
    let bytes = match args.to {
        Format::Stl => exchange::stl(&surfaces()?),
        Format::Ply => exchange::ply(&surfaces()?),
        Format::Lammps => exchange::lammps(&contents).into_bytes(),
        Format::Yade | Format::Paraview => exchange::yade(&contents).into_bytes(),
    };
    comminute::table::write(&args.out, bytes).map_err(Error::write(&args.out))?;
    if !args.quiet {
        let triangles = contents.bodies.triangles.len();
        eprintln!("{} grains in {}", contents.grains.len(), args.out.display());
        match (triangles, text) {
            (0, _) => {}
            (_, true) => eprintln!("note: the bodies that are no spheres are left out; stl and ply hold them"),
            (n, false) => eprintln!("bodies of {n} triangles as well"),
        }
    }
    Ok(())
}
