//! Material file that a calibration writes: the strength tables, as scenes read them.

use super::Calibration;
use super::area::Model;
use super::fit::{Estimate, Fit};
use std::fmt::Write;
use std::path::{Component, Path, PathBuf};
use toml::Value;

/// Name of the material file.
pub const FILE: &str = "material.toml";

/// Text of the material file for the folder `out`, with a strength table for each area model whose
/// sigma_lim0, m and var. are all known; `None` if there is no such model. If the calibration was
/// given a material, the file takes everything else from that one as its `base`.
pub fn fragment(calibration: &Calibration, out: &Path) -> Option<String> {
    let tables: Vec<(&Fit, [Estimate; 3])> = calibration
        .drawn()
        .map(|f| (f, [f.sigma_lim0_mpa(), f.m(), f.var()]))
        .filter(|(_, values)| values.iter().all(|v| v.estimate.is_some()))
        .collect();
    if tables.is_empty() {
        return None;
    }
    let data = &calibration.data;
    let file = data.path.file_name().unwrap_or_default().to_string_lossy();
    let mut text = format!("# Strength of grains calibrated from {file}: {} tests, {} broken.\n", data.grains.len(), data.broken());
    text += "# The values are those of the truncated normal that scenes draw (sigma_lim0 and var. before truncation).\n";
    match &calibration.inputs.material {
        Some(material) => {
            let _ = writeln!(text, "# In a scene: material = \"path/to/{FILE}\", or --set material=path/to/{FILE}.");
            let base = relative(out, material).display().to_string();
            let _ = writeln!(text, "base = {}", Value::String(base));
        }
        None => {
            text +=
                "# No material was given (--material): name the one that these strengths belong to, then use this file as the\n";
            text += "# material of a scene.\n# base = \"material of the grains.toml\"\n";
        }
    }
    let source = |area: &str| Value::String(format!("calibrated from {file}, {area}, maximum likelihood"));
    if let (true, Some((young, nu))) = (calibration.inputs.own_moduli, calibration.inputs.grain) {
        let _ = writeln!(text, "\n[elastic] # of the grains, as given to the calibration (eq. 11)");
        let _ = writeln!(text, "E_GPa = {:?}\nnu = {nu:?}\nsource = \"given to the calibration\"", 1e-9 * young);
    }
    let _ = writeln!(
        text,
        "\n[strength]\nd0_mm = {:?}\ntruncation = \"redraw\"\nmin_ratio = 0.0",
        rounded(1e3 * calibration.inputs.d0)
    );
    let _ = writeln!(text, "source = \"as the calibration took it\"");
    for (fit, values) in tables {
        let (table, area) = match fit.area.model {
            Model::FixedAngle => ("fixed_angle", "fixed contact angle, eq. 16"),
            Model::Hertz => ("hertz_area", "Hertzian contact area, eq. 17"),
        };
        let _ = writeln!(text, "\n[strength.{table}] # crushing.criterion = \"{table}\"");
        for (key, value) in ["sigma_lim0_MPa", "m", "var"].iter().zip(values) {
            let _ = writeln!(text, "{key} = {:?} # 95 %: {}", rounded(value.estimate.unwrap_or(f64::NAN)), limits(&value));
        }
        if let (Model::FixedAngle, Some(theta0)) = (fit.area.model, calibration.inputs.theta0) {
            let _ = writeln!(text, "theta0_rad = {theta0:?}\nsource.theta0_rad = \"given to the calibration\"");
            for key in ["sigma_lim0_MPa", "m", "var"] {
                let _ = writeln!(text, "source.{key} = {}", source(area));
            }
        } else {
            let _ = writeln!(text, "source = {}", source(area));
        }
    }
    Some(text)
}

/// Six significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// Limits as text, `4780 to 5260`; an open limit is `open`.
pub fn limits(value: &Estimate) -> String {
    let end = |v: Option<f64>| v.map_or("open".to_string(), significant);
    format!("{} to {}", end(value.lower), end(value.upper))
}

/// Four significant digits, no needless zeros.
pub fn significant(value: f64) -> String {
    plot::significant(value, 4).replace('−', "-")
}

/// Path of `file` relative to the folder `from`; `file` itself if one of them does not exist.
fn relative(from: &Path, file: &Path) -> PathBuf {
    let (Ok(from), Ok(file)) = (from.canonicalize(), file.canonicalize()) else {
        return file.to_path_buf();
    };
    let shared = from.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    let up = from.components().count() - shared;
    let mut path: PathBuf = std::iter::repeat_n(Component::ParentDir, up).collect();
    path.extend(file.components().skip(shared));
    path
}
