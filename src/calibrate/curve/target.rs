//! Target of a calibration: a measured oedometer curve, with k₀ and gradations if they were
//! measured.

use super::posterior::Measured;
use crate::columns::Columns;
use laboratory::error::{Error, Result};
use std::path::PathBuf;

/// Quantities that can be measured against vertical stress: column in the history of a run, column
/// in the file of the curve, and the factor from the second to the first. `void_ratio` and
/// `porosity` count all dry mass as solid, as a laboratory does. Older files, in which these two
/// end in `_restored`, are read too (`table::old_names`).
const QUANTITIES: [(&str, &str, f64); 8] = [
    ("void_ratio", "void_ratio", 1.0),
    ("void_ratio_grains", "void_ratio_grains", 1.0),
    ("void_ratio_star", "void_ratio_star", 1.0),
    ("porosity", "porosity", 1.0),
    ("porosity_grains", "porosity_grains", 1.0),
    ("porosity_star", "porosity_star", 1.0),
    ("axial_strain", "axial_strain", 1.0),
    ("axial_strain", "axial_strain_percent", 0.01),
];
const STRESSES: [(&str, f64); 3] = [("sigma_v_kPa", 1.0), ("sigma_v_MPa", 1e3), ("sigma_v_Pa", 1e-3)];
const SIZES: [(&str, f64); 2] = [("diameter_mm", 1.0), ("diameter_m", 1e3)];
/// Fewest points of a curve.
const FEWEST: usize = 4;

/// Quantity that was measured.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A column of the history, against vertical stress.
    History(&'static str),
    /// Per cent finer by mass, against size, at this vertical stress, kPa.
    Gradation(f64),
}

/// Measured points of one quantity: stress in kPa, or size in mm, with value and standard deviation
/// of each.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// The quantity.
    pub kind: Kind,
    /// Vertical stress, kPa, or size, mm, of each point.
    pub at: Vec<f64>,
    /// Measured value of each point.
    pub values: Vec<f64>,
    /// Standard deviation of each point.
    pub sd: Vec<f64>,
}

/// Everything that was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// The measured lines.
    pub blocks: Vec<Block>,
    /// Messages to the user about columns and points that are not used.
    pub notes: Vec<String>,
}

/// Files of a target.
#[derive(Clone, Debug, Default)]
pub struct Files {
    /// File of the curve; it may have a column k0.
    pub curve: PathBuf,
    /// File of stress ratios k0, if they are not in that of the curve.
    pub k0: Option<PathBuf>,
    /// File of gradations, if there are any.
    pub gradations: Option<PathBuf>,
}

impl Target {
    /// Reads the files. Points at `from` kPa and above are used.
    ///
    /// # Errors
    /// Missing columns, columns without unit, values that are impossible, stresses that do not rise
    /// from row to row, too few points, or the same value at every point.
    pub fn read(files: &Files, from: f64) -> Result<Target> {
        let mut target = Target { blocks: Vec::new(), notes: Vec::new() };
        let curve = Columns::read(&files.curve)?;
        if curve.has("series") && curve.texts("series").windows(2).any(|w| w[0] != w[1]) {
            return Err(curve.wrong("holds several series: a calibration takes one curve; leave only its rows"));
        }
        let found: Vec<_> = QUANTITIES.iter().filter(|q| curve.has(q.1)).collect();
        let Some((column, name, factor)) = found.first() else {
            let names = QUANTITIES.map(|q| q.1).join(", ");
            return Err(curve.wrong(format!("has no column of a curve: need one of {names}; it has {}", curve.headers.join(", "))));
        };
        if let Some(other) = found.get(1) {
            target.notes.push(format!("{} is used, {} is not", name, other.1));
        }
        target.line(&curve, column, name, *factor, "sd", from, FEWEST)?;
        if curve.has("k0") {
            target.line(&curve, "k0", "k0", 1.0, "k0_sd", from, 1)?;
        }
        if let Some(path) = &files.k0 {
            if curve.has("k0") {
                return Err(Error::input(path.display(), "", None, format!("k0 stands in {} already", files.curve.display())));
            }
            let k0 = Columns::read(path)?;
            if !k0.has("k0") {
                return Err(k0.wrong(format!("has no column k0; it has {}", k0.headers.join(", "))));
            }
            target.line(&k0, "k0", "k0", 1.0, "sd", from, 1)?;
        }
        if let Some(path) = &files.gradations {
            target.gradations(&Columns::read(path)?)?;
        }
        Ok(target)
    }

    /// Reads a quantity against stress and adds its block. `column`: name in the history of a run;
    /// `name` and `factor`: name in `file` and factor to the unit of the history; `sd_name`: column
    /// of its standard deviations; `from`: least stress, kPa; `fewest`: number of points needed.
    #[allow(clippy::too_many_arguments)]
    fn line(
        &mut self,
        file: &Columns,
        column: &'static str,
        name: &str,
        factor: f64,
        sd_name: &str,
        from: f64,
        fewest: usize,
    ) -> Result<()> {
        let (stress_name, stress) = stresses(file)?;
        let values = file.numbers(name, factor)?;
        let sds = deviations(file, sd_name, factor)?;
        let mut block = Block { kind: Kind::History(column), at: vec![], values: vec![], sd: vec![] };
        let (mut below, mut last) = (0, 0.0);
        for row in 0..values.len() {
            let Some(sigma) = stress[row] else {
                return Err(file.wrong_value(row, stress_name, "a point needs a stress"));
            };
            if sigma <= 0.0 {
                return Err(file.wrong_value(row, stress_name, "must be > 0 (compression is positive)"));
            }
            let Some(value) = values[row] else { continue };
            check(file, row, name, column, value)?;
            if sigma <= last {
                let message = "must be above the stress of the line before: only first loading is calibrated, in order of stress";
                return Err(file.wrong_value(row, stress_name, message));
            }
            last = sigma;
            if sigma < from * (1.0 - 1e-9) {
                below += 1;
                continue;
            }
            block.at.push(sigma);
            block.values.push(value);
            block.sd.push(sds[row]);
        }
        if below > 0 {
            self.notes.push(format!(
                "{}: {below} points of {name} below {from} kPa, the isotropic stress of the scene, are left out",
                file.path.display()
            ));
        }
        if block.at.len() < fewest {
            return Err(file.wrong(format!(
                "has {} points of {name} at or above {from} kPa, the isotropic stress of the scene; {fewest} are needed",
                block.at.len()
            )));
        }
        let constant = block.values.iter().all(|v| *v == block.values[0]);
        if fewest > 1 && constant {
            return Err(file.wrong(format!("{name} is {} at every stress: nothing can be found from it", block.values[0])));
        }
        self.blocks.push(block);
        Ok(())
    }

    /// Reads gradations and adds a block for each stress at which one was measured.
    fn gradations(&mut self, file: &Columns) -> Result<()> {
        let (stress_name, stress) = stresses(file)?;
        let size = SIZES.iter().find(|s| file.has(s.0));
        let (Some((size_name, factor)), true) = (size, file.has("passing_percent")) else {
            let have = file.headers.join(", ");
            return Err(file.wrong(format!("needs the columns diameter_mm and passing_percent; it has {have}")));
        };
        let (sizes, passing) = (file.numbers(size_name, *factor)?, file.numbers("passing_percent", 1.0)?);
        let sds = deviations(file, "sd", 1.0)?;
        let mut blocks: Vec<Block> = Vec::new();
        for row in 0..sizes.len() {
            let (Some(sigma), Some(d), Some(p)) = (stress[row], sizes[row], passing[row]) else {
                return Err(file.wrong_value(row, stress_name, "a point needs stress, size and per cent passing"));
            };
            if sigma <= 0.0 {
                return Err(file.wrong_value(row, stress_name, "must be > 0"));
            }
            if d <= 0.0 {
                return Err(file.wrong_value(row, size_name, "must be > 0"));
            }
            if !(0.0..=100.0).contains(&p) {
                return Err(file.wrong_value(row, "passing_percent", "must be from 0 to 100"));
            }
            let kind = Kind::Gradation(sigma);
            let at = blocks.iter().position(|b| b.kind == kind).unwrap_or_else(|| {
                blocks.push(Block { kind, at: vec![], values: vec![], sd: vec![] });
                blocks.len() - 1
            });
            blocks[at].at.push(d);
            blocks[at].values.push(p);
            blocks[at].sd.push(sds[row]);
        }
        self.blocks.extend(blocks);
        Ok(())
    }

    /// All values with their standard deviations, block after block.
    pub fn measured(&self, specimens: f64) -> Measured {
        let all = |f: fn(&Block) -> &Vec<f64>| self.blocks.iter().flat_map(|b| f(b).iter().copied()).collect();
        Measured { values: all(|b| &b.values), sd: all(|b| &b.sd), specimens }
    }

    /// Largest vertical stress, kPa.
    pub fn largest_stress(&self) -> f64 {
        let of = |b: &Block| match b.kind {
            Kind::History(_) => b.at.iter().copied().fold(0.0, f64::max),
            Kind::Gradation(sigma) => sigma,
        };
        self.blocks.iter().map(of).fold(0.0, f64::max)
    }

    /// Stresses, kPa, at which gradations were measured.
    pub fn gradation_stresses(&self) -> Vec<f64> {
        let mut all: Vec<f64> = self
            .blocks
            .iter()
            .filter_map(|b| match b.kind {
                Kind::Gradation(sigma) => Some(sigma),
                Kind::History(_) => None,
            })
            .collect();
        all.sort_by(f64::total_cmp);
        all
    }
}

fn stresses(file: &Columns) -> Result<(&'static str, Vec<Option<f64>>)> {
    let Some((name, factor)) = STRESSES.iter().find(|s| file.has(s.0)) else {
        let near = file.headers.iter().find(|h| h.starts_with("sigma") || h.starts_with("stress"));
        let hint = near.map_or(String::new(), |h| format!("; `{h}` does not say its unit"));
        let have = file.headers.join(", ");
        return Err(file.wrong(format!("has no column sigma_v_kPa or sigma_v_MPa{hint}; it has {have}")));
    };
    Ok((name, file.numbers(name, *factor)?))
}

/// Standard deviations; 0 where none is given.
fn deviations(file: &Columns, name: &str, factor: f64) -> Result<Vec<f64>> {
    if !file.has(name) {
        return Ok(vec![0.0; file.rows.len()]);
    }
    let all = file.numbers(name, factor)?;
    for (row, sd) in all.iter().enumerate() {
        if sd.is_some_and(|s| s < 0.0) {
            return Err(file.wrong_value(row, name, "must not be negative"));
        }
    }
    Ok(all.into_iter().map(|sd| sd.unwrap_or(0.0)).collect())
}

/// Refuses a value that the quantity cannot have.
fn check(file: &Columns, row: usize, name: &str, column: &str, value: f64) -> Result<()> {
    let allowed = match column {
        "void_ratio" | "void_ratio_grains" | "void_ratio_star" => {
            (value > 0.0 && value < 20.0).then_some(()).ok_or("must be > 0 and < 20")
        }
        "axial_strain" => (value > -0.5 && value < 0.95)
            .then_some(())
            .ok_or("must be a strain, compression positive, below 0.95; per cent are given as axial_strain_percent"),
        "k0" => (value > 0.0 && value < 10.0).then_some(()).ok_or("must be > 0 and < 10"),
        _ => (value > 0.0 && value < 1.0).then_some(()).ok_or("must be > 0 and < 1, not per cent"),
    };
    allowed.map_err(|message| file.wrong_value(row, name, message))
}

/// Reads a target from the text of a curve file; for the tests of this and other modules.
#[cfg(test)]
pub fn from_text(curve: &str, from: f64) -> Result<Target> {
    let dir = tempfile::tempdir().expect("folder");
    let path = dir.path().join("curve.csv");
    std::fs::write(&path, curve).expect("written");
    Target::read(&Files { curve: path, ..Files::default() }, from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_from_the_columns() {
        let t =
            from_text("# a test\nsigma_v_MPa,axial_strain_percent,sd,k0\n0.1,1,0.1,0.5\n1,4,,\n2,8,0.2,0.6\n3,10,0.2,0.6\n", 5.0);
        let t = t.expect("target");
        assert_eq!(t.blocks[0].kind, Kind::History("axial_strain"));
        assert_eq!(t.blocks[0].at, [100.0, 1000.0, 2000.0, 3000.0]);
        assert_eq!(t.blocks[0].values[1], 0.04);
        assert!((t.blocks[0].sd[0] - 0.001).abs() < 1e-15 && t.blocks[0].sd[1] == 0.0);
        assert_eq!(t.blocks[1].at, [100.0, 2000.0, 3000.0], "an empty cell is no point");
        assert_eq!((t.largest_stress(), t.measured(1.0).values.len()), (3000.0, 7));
    }

    #[test]
    fn points_below_the_isotropic_stress_are_left_out_and_told() {
        let t = from_text("sigma_v_kPa,void_ratio\n1,0.9\n5,0.8\n50,0.7\n500,0.6\n5000,0.5\n", 5.0).expect("target");
        assert_eq!(t.blocks[0].at.len(), 4);
        assert!(t.notes[0].contains("1 points"));
    }

    #[test]
    fn wrong_files_are_refused_with_line_and_column() {
        let ok = "10,0.8\n100,0.7\n1000,0.6\n";
        for (text, says) in [
            ("sigma,void_ratio\n1,1\n".to_string(), "`sigma` does not say its unit"),
            ("sigma_v_kPa,e\n1,1\n".into(), "need one of void_ratio, void_ratio_grains, void_ratio_star, porosity"),
            (format!("sigma_v_kPa,void_ratio\n{ok}"), "has 3 points"),
            (format!("sigma_v_kPa,void_ratio\n{ok}500,0.65\n"), "line 5: sigma_v_kPa = 500: must be above"),
            (format!("sigma_v_kPa,void_ratio\n{ok}-5,0.65\n"), "line 5: sigma_v_kPa = -5: must be > 0"),
            (format!("sigma_v_kPa,void_ratio\n{ok}2000,nan\n"), "void_ratio = nan: must be a finite number"),
            (format!("sigma_v_kPa,porosity\n{ok}2000,55\n"), "line 5: porosity = 55: must be > 0 and < 1"),
            (format!("sigma_v_kPa,void_ratio,sd\n{}", "10,0.8,-1\n"), "must not be negative"),
            (format!("sigma_v_kPa,void_ratio\n{}2000,0.5,3\n", ok), "line 5: has 3 values"),
            ("sigma_v_kPa;void_ratio\n1;2\n".into(), "separated by commas"),
            ("sigma_v_kPa,void_ratio\n10,0.5\n20,0.5\n30,0.5\n40,0.5\n".into(), "is 0.5 at every stress"),
            (format!("sigma_v_kPa,void_ratio,series\n{}", "10,0.8,a\n20,0.7,b\n"), "several series"),
            ("sigma_v_kPa,void_ratio\n".into(), "holds no rows"),
        ] {
            let error = from_text(&text, 5.0).expect_err(&text).to_string();
            assert!(error.contains(says) && error.contains("curve.csv"), "{text}: {error}");
        }
    }
}
