//! Scenes.

use crate::error::raised;
use crate::records::complete;
use crate::value::to_python;
use crate::watch::watched;
use comminute::machine::Pace;
use comminute::run::{Backend, SceneOptions, run_scene};
use comminute::{bench, scene};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::PathBuf;

/// A scene as read; it never changes.
#[pyclass(frozen, module = "comminute._comminute")]
pub struct Scene(pub(crate) scene::Scene);

#[pymethods]
impl Scene {
    /// The scene of a file with `key=value` laid over it.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf, sets: Vec<String>) -> PyResult<Scene> {
        raised(py, py.detach(|| scene::load(path, &sets))).map(Scene)
    }

    /// The scene of a text in TOML; paths in it are relative to `folder`.
    #[staticmethod]
    fn of_text(py: Python<'_>, text: &str, folder: PathBuf, sets: Vec<String>) -> PyResult<Scene> {
        raised(py, py.detach(|| scene::from_text(text, folder, &sets))).map(Scene)
    }

    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    #[getter]
    fn description(&self) -> &str {
        self.0.description()
    }

    #[getter]
    fn default_out(&self) -> PathBuf {
        self.0.default_out()
    }

    /// The value at a dotted key; `None` where there is none.
    fn get(&self, py: Python<'_>, key: &str) -> PyResult<Option<Py<PyAny>>> {
        self.0.get(key).map(|value| to_python(py, value)).transpose()
    }

    /// The scene with every default, as TOML.
    fn resolved(&self) -> String {
        scene::resolved(&self.0)
    }

    /// What the run would be, as JSON.
    fn check(&self, py: Python<'_>, range: bool, measure: bool) -> PyResult<String> {
        let pace = || {
            if !measure {
                return Ok(Pace::known());
            }
            let pace = bench::yardstick()?;
            pace.keep();
            Ok(Some(pace))
        };
        let checked = watched(py, None, |_| scene::check(&self.0, range, pace))?;
        Ok(scene::in_json(&self.0, &checked.model, &checked.estimate).to_string())
    }

    /// Makes the run, or what is left of it, draws its figures, writes its page if the scene asks for one, and gives its folder and its summary as JSON.
    #[pyo3(signature = (*, out, threads, backend, force, left, stop_after, tell))]
    #[expect(clippy::too_many_arguments, reason = "named options of one call")]
    fn run(
        &self,
        py: Python<'_>,
        out: Option<PathBuf>,
        threads: Option<usize>,
        backend: Option<&str>,
        force: bool,
        left: bool,
        stop_after: Option<u64>,
        tell: Option<Py<PyAny>>,
    ) -> PyResult<(PathBuf, String)> {
        let backend = backend.map(self::backend).transpose()?;
        let options = SceneOptions { out, threads, backend, force, left, stop_after, quiet: false, json: false };
        let outcome = watched(py, tell.as_ref(), |say| {
            let mut outcome = run_scene(&self.0, options, say)?;
            complete(&mut outcome)?;
            Ok(outcome)
        })?;
        Ok((outcome.out, outcome.summary.to_string()))
    }
}

/// The backend with this name.
pub fn backend(name: &str) -> PyResult<Backend> {
    let all = [Backend::Cpu, Backend::Gpu, Backend::Auto];
    all.into_iter()
        .find(|backend| backend.name() == name)
        .ok_or_else(|| PyValueError::new_err(format!("backend = {name:?}: must be one of {}", all.map(Backend::name).join(", "))))
}

/// Every key of scenes and materials with its default and meaning, as `comminute check --keys` prints them.
#[pyfunction]
pub fn key_reference() -> String {
    scene::key_reference()
}
