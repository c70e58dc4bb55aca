//! The native part of the Python package `comminute`. It hands scenes, runs and tables of the library to Python and holds no law, table or
//! text of its own; what Python programs call stands in `comminute/*.py`.

#![deny(missing_docs)]

mod command;
mod error;
mod records;
mod scene;
mod simulation;
mod value;
mod watch;

/// The native part of the package `comminute`.
#[pyo3::pymodule]
mod _comminute {
    #[pymodule_export]
    use crate::command::{call, command, runs_by};
    #[pymodule_export]
    use crate::records::{columns, draw, overlay, report, resume};
    #[pymodule_export]
    use crate::scene::{Scene, key_reference};
    #[pymodule_export]
    use crate::simulation::Simulation;
    #[pymodule_export]
    use crate::value::{literal, toml_text};

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
