//! Grains and bodies for other programs, and grains from them: STL and PLY surfaces, data files of LAMMPS and LIGGGHTS, texts of Yade, small
//! series for ParaView. Lengths are those of the model, m.

mod contents;
mod grains_csv;
mod lammps;
mod ply;
mod series;
mod stl;
mod surfaces;
mod text_file;
mod yade;

pub use contents::{Contents, Grain, Kind};
pub use grains_csv::write as grains_csv;
pub use lammps::{read as read_lammps, write as lammps};
pub use ply::write as ply;
pub use series::write as series;
pub use stl::write as stl;
pub use surfaces::{Levels, Surfaces};
pub use yade::{read as read_yade, write as yade};

/// Grains that a file of another program holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Packing {
    /// The grains; their `kind` is the type of the file less 1.
    pub grains: Vec<Grain>,
    /// Number of types of the file; 1 where it knows none.
    pub types: usize,
}
