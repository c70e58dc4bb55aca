//! Lines of Modified Cam-clay from compression of fine grains alone: a run of `kind = "isotropic"` or `"oedometer"` that loads and unloads, by its columns `p_kPa`,
//! `void_ratio` and `stage`.
//!
//! - λ and N: the virgin line v = N − λ ln p by least squares over the first loading, from a third of the largest mean stress on.
//! - κ: slope of v over ln p by least squares over the first unloading, down to a tenth of its start.
//! - p_c: where the swelling line through the first row of loading meets the virgin line.

use super::columns::Columns;
use laboratory::error::Result;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use table::number;

/// Share of the largest mean stress from which on the first loading is taken as virgin.
const VIRGIN: f64 = 1.0 / 3.0;
/// Share of the largest mean stress down to which unloading is taken as elastic.
const SWELLING: f64 = 0.1;
/// Least number of rows for a line.
const ROWS: usize = 4;

/// The lines that a compression gives.
#[derive(Clone, Debug, Serialize)]
pub struct Compression {
    /// Folder of the test.
    pub test: PathBuf,
    /// Slope λ of the virgin line in (ln p, v), -.
    pub lambda: f64,
    /// Slope κ of the swelling line in (ln p, v), -.
    pub kappa: f64,
    /// Specific volume on the virgin line at 1 kPa, -.
    pub virgin_specific_volume: f64,
    /// Preconsolidation pressure at the start, kPa.
    #[serde(rename = "preconsolidation_kPa")]
    pub preconsolidation_kpa: f64,
    /// Largest mean stress of the test, kPa: beyond it nothing is known.
    #[serde(rename = "largest_p_kPa")]
    pub largest_p_kpa: f64,
    /// Root mean square distance of the rows of loading from the virgin line, in specific volume, -.
    pub misfit: f64,
}

/// A line v = at_1 − slope ln p by least squares, with the root mean square distance from it.
fn line(points: &[[f64; 2]]) -> [f64; 3] {
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p[0].ln()).sum::<f64>() / n, points.iter().map(|p| p[1]).sum::<f64>() / n);
    let (sxy, sxx) = points.iter().fold((0.0, 0.0), |(a, b), [p, v]| {
        let x = p.ln() - mx;
        (a + x * (v - my), b + x * x)
    });
    let slope = -sxy / sxx;
    let at_1 = my + slope * mx;
    let square = points.iter().map(|[p, v]| (v - at_1 + slope * p.ln()).powi(2)).sum::<f64>() / n;
    [slope, at_1, square.sqrt()]
}

/// Reads the compression in the folder of this run and finds its lines.
///
/// # Errors
/// A folder without such a test; too few rows of loading or unloading; slopes that are no compression, or with κ not below λ.
pub fn compression(folder: &Path) -> Result<Compression> {
    let table = Columns::read(&folder.join("history.csv"))?;
    let whose = "an oedometer or an isotropic compression of grains";
    table.require("stage", whose)?;
    let stages: Vec<String> = table.texts("stage").iter().map(|stage| stage.to_string()).collect();
    let (p, e) = (table.complete("p_kPa", whose)?, table.complete("void_ratio", whose)?);
    // the first rows of one stage after another, up to where another one begins
    let part = |stage: &str| -> Vec<[f64; 2]> {
        let from = stages.iter().position(|s| s == stage).unwrap_or(stages.len());
        let count = stages[from..].iter().take_while(|s| *s == stage).count();
        (from..from + count).filter(|k| p[*k] > 0.0).map(|k| [p[k], 1.0 + e[k]]).collect()
    };
    let (loading, unloading) = (part("load"), part("unload"));
    let most = loading.iter().map(|r| r[0]).fold(0.0, f64::max);
    let virgin: Vec<[f64; 2]> = loading.iter().copied().filter(|r| r[0] >= VIRGIN * most).collect();
    let swelling: Vec<[f64; 2]> = unloading.into_iter().filter(|r| r[0] >= SWELLING * most).collect();
    for (rows, what) in [(&virgin, "load from a third of the largest mean stress on"), (&swelling, "unload down to a tenth of it")]
    {
        if rows.len() < ROWS {
            return Err(table.wrong(format!("must have at least {ROWS} rows of stage {what}; it has {}", rows.len())));
        }
    }
    let ([lambda, at_1, misfit], [kappa, ..]) = (line(&virgin), line(&swelling));
    if !(kappa > 0.0 && lambda > kappa) {
        return Err(table.wrong(format!(
            "does not compress as Cam-clay does: lambda = {lambda:.4} must be above kappa = {kappa:.4}, and both above 0; load it further, until it yields"
        )));
    }
    let [p0, v0] = loading[0];
    Ok(Compression {
        test: folder.to_path_buf(),
        lambda,
        kappa,
        virgin_specific_volume: at_1,
        preconsolidation_kpa: ((at_1 - v0 - kappa * p0.ln()) / (lambda - kappa)).exp(),
        largest_p_kpa: most,
        misfit,
    })
}

impl Compression {
    /// Text of a material file with the law of Modified Cam-clay. `base`: path of the grains' material, as written into the file; `friction_deg`: friction angle of the
    /// critical state, degrees, and `nu`: Poisson ratio, both from triaxial tests.
    pub fn material(&self, base: Option<&str>, friction_deg: f64, nu: f64) -> String {
        let mut text =
            String::from("# The continuum of fine grains as Modified Cam-clay, calibrated from tests of grains alone.\n");
        if let Some(base) = base {
            let _ = writeln!(text, "base = {}", toml::Value::String(base.into()));
        }
        let digits = |x: f64| format!("{:?}", number(x).parse::<f64>().unwrap_or(x));
        let _ = write!(
            text,
            "\n[continuum]\nlaw = \"cam_clay\"\nfriction_angle_deg = {}\nnu = {}\nlambda = {}\nkappa = {}\nvirgin_specific_volume = {}\npreconsolidation_kPa = {}\n\
             source = \"calibrated: friction_angle_deg and nu from triaxial tests of the grains, the rest from their compression up to a mean stress of {} kPa\"\n",
            digits(friction_deg),
            digits(nu),
            digits(self.lambda),
            digits(self.kappa),
            digits(self.virgin_specific_volume),
            digits(self.preconsolidation_kpa),
            digits(self.largest_p_kpa)
        );
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use engine::mpm::law::{CamClay, Clay, ConstitutiveLaw, Elastic, Evolution, InternalVariables, Parameters, Shear};

    /// Isotropic compression of the law itself, up and down, gives its lines back; so does one-dimensional compression but for the offset of its line, which belongs to the
    /// stress ratio η: N − (λ − κ) ln(1 + η²/M²).
    #[test]
    fn a_compression_of_the_law_gives_its_lines_back() {
        let (lambda, kappa, at_1, p_c) = (0.12, 0.025, 2.4, 150.0_f64);
        let clay = Clay {
            virgin_slope: lambda,
            swelling_slope: kappa,
            preconsolidation: 1e3 * p_c,
            virgin_volume: at_1 - lambda * p_c.ln(),
            shear: Shear::Poisson(0.2),
        };
        let elastic = Elastic { bulk: 0.0, shear: 0.0 };
        let law = CamClay::of(&Parameters { friction: Evolution::Constant(0.5), clay, ..Parameters::of_elastic(elastic) });
        for isotropic in [true, false] {
            let (mut stress, mut internal) = ([-3e4, -3e4, -3e4, 0.0, 0.0, 0.0], InternalVariables::default());
            let mut text = String::from("stage,p_kPa,void_ratio\n");
            for step in 0..6000 {
                let pressure = -(stress[0] + stress[1] + stress[2]) / 3e3;
                let stage = if step < 4800 { "load" } else { "unload" };
                if step % 40 == 0 {
                    let v = law.specific_volume(&stress, internal);
                    let _ = writeln!(text, "{stage},{pressure:e},{:e}", v - 1.0);
                }
                let d = if step < 4800 { -5e-5 } else { 1e-5 };
                let lateral = if isotropic { d / 3.0 } else { 0.0 };
                (stress, internal) = law.update(stress, [lateral, lateral, d - 2.0 * lateral, 0.0, 0.0, 0.0], internal);
            }
            let folder = tempfile::tempdir().expect("folder");
            std::fs::write(folder.path().join("history.csv"), text).expect("written");
            let found = compression(folder.path()).expect("lines");
            let near = |a: f64, b: f64, by: f64| assert!((a / b - 1.0).abs() < by, "{isotropic}: {a} for {b}: {found:?}");
            near(found.lambda, lambda, if isotropic { 1e-6 } else { 0.02 });
            near(found.kappa, kappa, 1e-6);
            if isotropic {
                near(found.virgin_specific_volume, at_1, 1e-6);
                near(found.preconsolidation_kpa, p_c, 1e-4);
            }
            assert!(found.material(None, 30.0, 0.2).contains("law = \"cam_clay\""));
        }
    }

    #[test]
    fn a_test_without_unloading_is_refused() {
        let folder = tempfile::tempdir().expect("folder");
        let file = folder.path().join("history.csv");
        let rows: String = (1..20).map(|k| format!("load,{k},{}\n", 1.0 - 0.01 * f64::from(k))).collect();
        std::fs::write(&file, format!("stage,p_kPa,void_ratio\n{rows}")).expect("written");
        let message = compression(folder.path()).expect_err("refused").to_string();
        assert!(message.contains("at least 4 rows of stage unload") && message.contains("it has 0"), "{message}");
        let stiff: String = (1..20).map(|k| format!("unload,{k},{}\n", 1.0 - 0.5 * f64::from(k))).collect();
        std::fs::write(&file, format!("stage,p_kPa,void_ratio\n{rows}{stiff}")).expect("written");
        let message = compression(folder.path()).expect_err("refused").to_string();
        assert!(message.contains("must be above kappa"), "{message}");
        std::fs::write(&file, "stage,p_kPa\nload,1\n").expect("written");
        let message = compression(folder.path()).expect_err("refused").to_string();
        assert!(message.contains("void_ratio") && message.contains("is missing"), "{message}");
    }
}
