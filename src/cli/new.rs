//! `comminute new KIND DIR`

use comminute::error::{Error, Result};
use std::path::{Path, PathBuf};

/// Write a scene and its material that run as they are, every line explained, to begin with
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  comminute new oedometer my-sand\n  comminute run my-sand/scene.toml --out my-sand/run-1")]
pub struct Args {
    /// What the scene does
    kind: Kind,

    /// Folder for scene.toml and material.toml; it is made, or must be empty
    dir: PathBuf,

    /// Say nothing
    #[arg(long)]
    quiet: bool,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Kind {
    /// One-dimensional compression of a sand, grains break
    Oedometer,
    /// Drained triaxial compression of a sand, grains break
    Triaxial,
    /// A free scene: grains one by one, walls and gravity
    Grains,
    /// Triaxial compression of a soil as a continuum
    Continuum,
    /// Coarse grains that break in a fine continuum
    Mixture,
    /// One-dimensional compression of angular rocks that break
    Rocks,
}

impl Kind {
    /// Files that are written: name and text of scene and material.
    fn files(self) -> [(&'static str, &'static str); 2] {
        let (scene, material) = match self {
            Kind::Oedometer => (include_str!("templates/oedometer_scene.toml"), include_str!("templates/oedometer_material.toml")),
            Kind::Triaxial => (include_str!("templates/triaxial_scene.toml"), include_str!("templates/triaxial_material.toml")),
            Kind::Grains => (include_str!("templates/grains_scene.toml"), include_str!("templates/grains_material.toml")),
            Kind::Continuum => (include_str!("templates/continuum_scene.toml"), include_str!("templates/continuum_material.toml")),
            Kind::Rocks => (include_str!("templates/rocks_scene.toml"), include_str!("templates/rocks_material.toml")),
            Kind::Mixture => (include_str!("templates/mixture_scene.toml"), include_str!("templates/mixture_material.toml")),
        };
        [("scene.toml", scene), ("material.toml", material)]
    }
}

pub fn call(args: &Args) -> Result<()> {
    free(&args.dir)?;
    std::fs::create_dir_all(&args.dir).map_err(Error::write(&args.dir))?;
    for (name, text) in args.kind.files() {
        let path = args.dir.join(name);
        std::fs::write(&path, text).map_err(Error::write(&path))?;
    }
    if !args.quiet {
        let dir = args.dir.display();
        eprintln!(
            "{dir}/scene.toml and {dir}/material.toml written; change them as you like, then\n  comminute check {dir}/scene.toml\n  comminute run {dir}/scene.toml --out {dir}/run-1"
        );
    }
    Ok(())
}

/// Refuses a folder that holds anything, so that no file of the user is overwritten.
fn free(dir: &Path) -> Result<()> {
    let refuse =
        |what: &str| Err(Error::input(dir.display(), "", None, format!("{what}; comminute new writes into a new or empty folder")));
    match std::fs::read_dir(dir) {
        Ok(entries) => {
            if entries.count() > 0 {
                return refuse("is not empty");
            }
            Ok(())
        }
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(()),
        Err(_) if dir.is_file() => refuse("is a file"),
        Err(source) => Err(Error::Read { path: dir.into(), source }),
    }
}
