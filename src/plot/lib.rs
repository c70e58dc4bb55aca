//! Figures from the files that runs leave: compression curves, gradations, stress paths, ledgers and views of the
//! specimen, each as SVG (84 mm wide), PNG (1600 pixels wide) and the CSV of what was drawn. Reads record files only
//! and never sees a simulation.

#![deny(missing_docs)]

mod account;
mod assembly;
mod axis;
mod balls;
mod bodies;
mod calibration;
mod canvas;
mod chart;
mod colour;
mod continuum;
mod curves;
mod data;
mod effects;
mod energy;
mod error;
mod flow;
mod force_chains;
mod gradation;
mod grain_crushing;
mod group;
mod legend;
mod mean;
mod plot;
mod point_test;
mod posterior;
mod run;
mod runs_table;
mod section;
mod specimen;
mod stress_path;
mod survival;
mod table;
mod text;
mod triaxial;
mod walls;

pub use axis::significant;
pub use calibration::{Drawn, Graph, Look, Quantity, Tone};
pub use chart::{Chart, ChartAxis, ChartMark, ChartSeries, Palette, charts, palette};
pub use effects::{Bar, draw_effects};
pub use error::{FigureError, Result};
pub use mean::write as write_means;
pub use point_test::{draw as draw_point_test, files as point_test_files};
pub use posterior::{FittedLine, Input as PosteriorInput, draw_convergence, draw_corner, draw_fitted, draw_sensitivity};
pub use runs_table::write as write_runs;
pub use specimen::Colouring;
pub use table::Table;

use data::Measured;
use group::Group;
use laboratory::run::{DRAWING, DRAWN, FIGURES, Outcome};
use plot::Plot;
use run::Run;
use std::path::{Path, PathBuf};

/// The groups of runs and the measured data from which the figures of one call are drawn.
struct Input {
    groups: Vec<Group>,
    data: Vec<Measured>,
}

/// Draws every figure that the records of one run allow into `dir/figures` and returns the files written. They are drawn in a folder of
/// their own and moved when all are whole; `drawn.txt` beside them lists their names.
pub fn draw_run(dir: &Path) -> Result<Vec<PathBuf>> {
    let [out, drawing] = [FIGURES, DRAWING].map(|name| dir.join(name));
    if drawing.is_dir() {
        std::fs::remove_dir_all(&drawing).map_err(|e| FigureError::io(&drawing, e))?;
    }
    let fresh = draw_records(dir, &drawing)?;
    ::table::folder(&out).map_err(|e| FigureError::io(&out, e))?;
    let names: Vec<_> = fresh.iter().filter_map(|path| path.file_name()).collect();
    let lines: String = names.iter().map(|name| format!("{}\n", name.display())).collect();
    ::table::write(out.join(DRAWN), lines).map_err(|e| FigureError::io(&out, e))?;
    let files: Vec<PathBuf> = names.iter().map(|name| out.join(name)).collect();
    for (from, to) in fresh.iter().zip(&files) {
        std::fs::rename(from, to).map_err(|e| FigureError::io(to, e))?;
    }
    std::fs::remove_dir(&drawing).map_err(|e| FigureError::io(&drawing, e))?;
    Ok(files)
}

/// Draws the figures of a run that has just ended, if its scene asks for them, and returns the files written; the summary then says how long
/// that took.
///
/// # Errors
/// As of [`draw_run`]; a summary that cannot be written.
pub fn complete(outcome: &mut Outcome) -> laboratory::error::Result<Vec<PathBuf>> {
    if !outcome.draw {
        return Ok(Vec::new());
    }
    let started = std::time::Instant::now();
    let files = draw_run(&outcome.out)?;
    outcome.drawn(started.elapsed().as_secs_f64())?;
    Ok(files)
}

/// Draws every figure that the records of the run in `dir` allow into `out`.
fn draw_records(dir: &Path, out: &Path) -> Result<Vec<PathBuf>> {
    let run = Run::read(dir)?;
    let input = Input { groups: group::group(vec![run.clone()]), data: Vec::new() };
    let mut files = draw_all(&input, out)?;
    files.extend(specimen::draw(&run, &Colouring::Generation, out)?);
    files.extend(continuum::draw_points(&run, out)?);
    files.extend(section::draw(&run, out)?);
    files.extend(bodies::draw(&run, out)?);
    files.extend(force_chains::draw(&run, out)?);
    if files.is_empty() {
        let why = "nothing to draw: no records in history.csv, gsd.csv, platen.csv, tracks.csv, specimen.csv or grains_final.csv";
        return Err(FigureError::nothing(dir, why));
    }
    Ok(files)
}

/// Draws several runs together into `out`, with measured data as symbols. Runs of one scene and scale with different
/// seeds become a band with its median, all others lines.
pub fn overlay(dirs: &[PathBuf], data: &[PathBuf], out: &Path) -> Result<Vec<PathBuf>> {
    let mut files = draw_all(&input(dirs, data)?, out)?;
    if !files.is_empty() {
        files.extend(runs_table::write(dirs, out)?);
    }
    if files.is_empty() {
        let why = "nothing to draw: the runs given have no records";
        return Err(FigureError::nothing(out, why));
    }
    Ok(files)
}

/// Draws only those figures of [`overlay`] whose names are in `names`, and no table of runs. A
/// figure that the runs do not have is left out.
pub fn chosen(dirs: &[PathBuf], data: &[PathBuf], names: &[String], out: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for plot in plots(&input(dirs, data)?)?.iter().filter(|p| names.contains(&p.name)) {
        files.extend(plot.draw(out)?);
    }
    Ok(files)
}

fn input(dirs: &[PathBuf], data: &[PathBuf]) -> Result<Input> {
    let runs: Result<Vec<Run>> = dirs.iter().map(|d| Run::read(d)).collect();
    let data: Result<Vec<Measured>> = data.iter().enumerate().map(|(i, path)| Measured::read(path, i)).collect();
    Ok(Input { groups: group::group(runs?), data: data? })
}

/// A column of numbers of a table that a run has left; empty cells are NaN.
pub fn read_column(path: &Path, column: &str) -> Result<Vec<f64>> {
    let [column] = read_columns(path, [column])?;
    Ok(column)
}

/// Columns of numbers of a table that a run has left, which is read once; empty cells are NaN.
pub fn read_columns<const N: usize>(path: &Path, columns: [&str; N]) -> Result<[Vec<f64>; N]> {
    let table = table::Table::read(path)?;
    let mut found: [Vec<f64>; N] = std::array::from_fn(|_| Vec::new());
    for (values, column) in found.iter_mut().zip(columns) {
        *values = table.numbers(column)?;
    }
    Ok(found)
}

/// Draws the section through the mixture of a run at its start and end into `out`; nothing without both points and grains.
pub fn draw_section(dir: &Path, out: &Path) -> Result<Vec<PathBuf>> {
    section::draw(&Run::read(dir)?, out)
}

/// Draws the rigid bodies of a run that are no spheres, at its start and end, into `out`; nothing without such bodies.
pub fn draw_bodies(dir: &Path, out: &Path) -> Result<Vec<PathBuf>> {
    bodies::draw(&Run::read(dir)?, out)
}

/// Draws the view of a run's specimen with grains coloured by `colouring` into `out`.
pub fn draw_specimen(dir: &Path, colouring: &Colouring, out: &Path) -> Result<Vec<PathBuf>> {
    let files = specimen::draw(&Run::read(dir)?, colouring, out)?;
    if files.is_empty() {
        let why = "no grains in specimen.csv or grains_final.csv";
        return Err(FigureError::nothing(dir, why));
    }
    Ok(files)
}

fn draw_all(input: &Input, out: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for plot in plots(input)? {
        files.extend(plot.draw(out)?);
    }
    Ok(files)
}

/// Every figure that the records allow.
fn plots(input: &Input) -> Result<Vec<Plot>> {
    let mut plots: Vec<Plot> = if triaxial::is(input) { triaxial::plots(input)? } else { curves::plots(input)? };
    plots.extend(gradation::plot(input)?);
    plots.extend(survival::plot(input)?);
    plots.extend(stress_path::plot(input)?);
    plots.extend(energy::plot(input)?);
    plots.extend(assembly::plots(input)?);
    plots.extend(grain_crushing::plots(input)?);
    plots.extend(continuum::plots(input)?);
    plots.extend(account::plot(input)?);
    plots.extend(walls::plots(input)?);
    Ok(plots)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "step,stage,sigma_v_kPa,k0,q_kPa,p_kPa,axial_strain,porosity,crush_events";

    fn folder(seed: u64, rows: &str) -> tempfile::TempDir {
        let dir = tempfile::tempdir().expect("folder");
        let summary = format!("{{\"scene\":\"H-C-2\",\"seed\":{{\"packing\":{seed},\"strength\":{seed}}}}}");
        std::fs::write(dir.path().join("summary.json"), summary).expect("summary");
        std::fs::write(dir.path().join("history.csv"), format!("{HEADER}\n{rows}")).expect("history");
        dir
    }

    const ROWS: &str = "1,load,10,0.6,4,7,0.001,0.42,0\n2,load,1000,0.5,500,667,0.1,0.35,20\n\
                        3,unload,100,0.9,10,93,0.09,0.36,20\n";

    fn names(files: &[PathBuf], extension: &str) -> Vec<String> {
        files
            .iter()
            .filter(|f| f.extension().is_some_and(|e| e == extension))
            .filter_map(|f| Some(f.file_stem()?.to_string_lossy().into_owned()))
            .collect()
    }

    #[test]
    fn a_run_is_drawn_from_the_columns_that_it_has() {
        let dir = folder(1, ROWS);
        let files = draw_run(dir.path()).expect("drawn");
        let want = ["compression", "axial_strain", "k0", "crush_events", "stress_path"];
        for kind in ["svg", "png", "csv"] {
            assert_eq!(names(&files, kind), want);
        }
        assert!(files.iter().all(|f| f.is_file()));
    }

    #[test]
    fn unloading_stays_in_file_order() {
        let dir = folder(1, ROWS);
        draw_run(dir.path()).expect("drawn");
        let csv = std::fs::read_to_string(dir.path().join("figures/compression.csv")).expect("csv");
        let x: Vec<&str> = csv.lines().skip(1).filter_map(|l| l.rsplit(',').nth(1)).collect();
        assert_eq!(x, ["0.01", "1", "0.1"]);
    }

    #[test]
    fn seeds_make_a_band_and_data_symbols() {
        let (a, b) = (folder(1, ROWS), folder(2, &ROWS.replace("0.35", "0.33")));
        let out = tempfile::tempdir().expect("out");
        let data = out.path().join("measured.csv");
        std::fs::write(&data, "sigma_v_MPa,porosity\n0.5,0.37\n").expect("data");
        let dirs = [a.path().to_path_buf(), b.path().to_path_buf()];
        overlay(&dirs, &[data], out.path()).expect("drawn");
        let csv = std::fs::read_to_string(out.path().join("compression.csv")).expect("csv");
        let at_one = csv.lines().find(|l| l.contains("band,0.99999") || l.contains("band,1,"));
        let end: Vec<f64> = at_one.expect("end of loading").rsplit(',').take(3).filter_map(|v| v.parse().ok()).collect();
        assert!((end[0] - 0.35).abs() < 1e-6 && (end[1] - 0.33).abs() < 1e-6, "{end:?}");
        assert!((end[2] - 0.34).abs() < 1e-6);
        assert!(csv.contains("measured,data,0.5,0.37"));
    }

    #[test]
    fn empty_and_broken_folders_are_told_not_panicked_over() {
        let bare = tempfile::tempdir().expect("folder");
        let error = draw_run(bare.path()).expect_err("empty").to_string();
        assert!(error.contains("nothing to draw"), "{error}");
        assert!(draw_run(folder(1, "").path()).is_err());
        let settle = folder(1, "1,settle,5,1,0,5,0,0.42,0\n");
        assert!(draw_run(settle.path()).is_ok(), "one record is a point");
        let odd = draw_run(folder(1, "1,load,ten,0.6,4,7,0,0.4,0\n").path());
        assert!(odd.expect_err("text").to_string().contains("column `sigma_v_kPa`"));
        assert!(overlay(&[], &[], bare.path()).is_err());
    }
}
