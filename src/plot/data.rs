//! Measured or published numbers from CSV files, drawn as symbols.

use super::colour::{GREY, INK};
use super::error::{FigureError, Result};
use super::plot::{Mark, Series, Shape};
use super::table::Table;
use std::path::Path;

/// Columns of vertical stress, each with its factor to MPa.
const STRESS: [(&str, f64); 2] = [("sigma_v_MPa", 1.0), ("sigma_v_kPa", 1e-3)];
/// Columns that can be drawn against vertical stress.
const QUANTITIES: [&str; 9] = [
    "void_ratio",
    "void_ratio_grains",
    "void_ratio_star",
    "porosity",
    "porosity_grains",
    "porosity_star",
    "axial_strain",
    "k0",
    "crush_events",
];

/// Column of axial strain with its factor to per cent, and the columns that can be drawn against
/// axial strain (triaxial tests).
const STRAIN: (&str, f64) = ("axial_strain", 100.0);
const OF_STRAIN: [&str; 2] = ["q_kPa", "volumetric_strain"];

/// One data file. Its legend entry is the comment `# label = ...` or the file name; an optional
/// column `series` splits the file into several series.
#[derive(Clone, Debug)]
pub struct Measured {
    table: Table,
    label: String,
    index: usize,
}

impl Measured {
    /// Reads a data file and checks that it has columns to draw. `index` counts the data files;
    /// symbols and colour follow from it.
    pub fn read(path: &Path, index: usize) -> Result<Self> {
        let table = Table::of_user(path)?;
        let stem = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().replace('_', " "));
        let label = table.note_text("label").map_or(stem, str::to_string);
        let data = Self { table, label, index };
        let stress = STRESS.iter().any(|(c, _)| data.table.has(c));
        let curve = stress && QUANTITIES.iter().any(|c| data.table.has(c));
        let gradation = data.table.has("diameter_mm") && data.table.has("passing_percent");
        let strain = data.table.has(STRAIN.0) && OF_STRAIN.iter().any(|c| data.table.has(c));
        if curve || gradation || strain {
            return Ok(data);
        }
        Err(FigureError::nothing(
            path,
            "no columns to draw: need sigma_v_kPa or sigma_v_MPa with any of void_ratio or porosity (also with \
             _grains or _star), axial_strain, k0, crush_events; axial_strain with q_kPa or volumetric_strain; or diameter_mm with passing_percent",
        ))
    }

    /// Symbols of a quantity against stress in MPa; empty if the file does not have the quantity.
    /// Where the file has only the void ratio e, a porosity is computed as n = e/(1 + e), and the
    /// reverse.
    pub fn against_stress(&self, column: &str, factor: f64) -> Result<Vec<Series>> {
        let Some(stress) = STRESS.iter().find(|(c, _)| self.table.has(c)) else { return Ok(Vec::new()) };
        let named =
            |from: &str, to: &str| column.strip_prefix(from).map(|which| format!("{to}{which}")).filter(|c| self.table.has(c));
        if self.table.has(column) {
            self.symbols(*stress, (column, |y| factor * y), "series")
        } else if let Some(void_ratio) = named("porosity", "void_ratio") {
            self.symbols(*stress, (&void_ratio, |e| factor * e / (1.0 + e)), "series")
        } else if let Some(porosity) = named("void_ratio", "porosity") {
            self.symbols(*stress, (&porosity, |n| factor * n / (1.0 - n)), "series")
        } else {
            Ok(Vec::new())
        }
    }

    /// Symbols of a quantity against axial strain in percent; empty if the file does not have both.
    pub fn against_strain(&self, column: &str, factor: f64) -> Result<Vec<Series>> {
        if !(self.table.has(STRAIN.0) && self.table.has(column)) {
            return Ok(Vec::new());
        }
        self.symbols(STRAIN, (column, |y| factor * y), "series")
    }

    /// Symbols of a gradation, one series for each stress if the file has stresses.
    pub fn gradation(&self) -> Result<Vec<Series>> {
        if !(self.table.has("diameter_mm") && self.table.has("passing_percent")) {
            return Ok(Vec::new());
        }
        let by_stress = STRESS.iter().find(|(c, _)| self.table.has(c));
        let split = by_stress.map_or("series", |(c, _)| *c);
        self.symbols(("diameter_mm", 1.0), ("passing_percent", |y| y), split)
    }

    fn symbols(&self, x: (&str, f64), y: (&str, impl Fn(f64) -> f64), split: &str) -> Result<Vec<Series>> {
        let (xs, ys) = (self.table.numbers(x.0)?, self.table.numbers(y.0)?);
        let names = if self.table.has(split) { self.table.texts(split)? } else { vec![""; xs.len()] };
        let mut out: Vec<(&str, Series)> = Vec::new();
        for i in 0..xs.len() {
            let at = out.iter().position(|(n, _)| *n == names[i]);
            let at = at.unwrap_or_else(|| {
                let nth = self.index + out.len();
                let name = match names[i] {
                    "" => self.label.clone(),
                    part => format!("{}, {}", self.label, with_unit(split, part)),
                };
                let series = Series {
                    label: Some(name.clone()),
                    name,
                    colour: if nth < 4 { INK } else { GREY },
                    mark: Mark::Symbols(Shape::nth(nth)),
                    x: Vec::new(),
                    y: Vec::new(),
                };
                out.push((names[i], series));
                out.len() - 1
            });
            out[at].1.x.push(xs[i] * x.1);
            out[at].1.y.push(y.1(ys[i]));
        }
        Ok(out.into_iter().map(|(_, s)| s).collect())
    }
}

/// The value of a splitting column, with its unit if the column is a stress.
fn with_unit(split: &str, value: &str) -> String {
    match split.strip_prefix("sigma_v_") {
        Some(unit) => format!("{value} {unit}"),
        None => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Measured> {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("coke_test.csv");
        std::fs::write(&path, text).expect("written");
        Measured::read(&path, 0)
    }

    #[test]
    fn stress_in_either_unit_is_mpa() {
        let kpa = read("sigma_v_kPa,porosity\n100,0.4\n5000,0.27\n").expect("read");
        let s = kpa.against_stress("porosity", 1.0).expect("series");
        assert!((s[0].x[0] - 0.1).abs() < 1e-12);
        assert_eq!(s[0].label.as_deref(), Some("coke test"));
        assert!(kpa.against_stress("k0", 1.0).expect("none").is_empty());
        let mpa = read("# label = Test A\nsigma_v_MPa,axial_strain\n2,0.1\n").expect("read");
        let s = mpa.against_stress("axial_strain", 100.0).expect("series");
        assert_eq!((s[0].x[0], s[0].y[0]), (2.0, 10.0));
        assert_eq!(s[0].name, "Test A");
    }

    #[test]
    fn a_void_ratio_is_drawn_as_a_porosity_and_back() {
        let e = read("sigma_v_MPa,void_ratio\n2,0.25\n").expect("read");
        assert_eq!(e.against_stress("porosity", 1.0).expect("series")[0].y, [0.2]);
        assert!(e.against_stress("porosity_star", 1.0).expect("none").is_empty());
        let n = read("sigma_v_MPa,porosity_grains\n2,0.2\n").expect("read");
        assert!((n.against_stress("void_ratio_grains", 1.0).expect("series")[0].y[0] - 0.25).abs() < 1e-15);
    }

    #[test]
    fn gradations_are_split_by_stress() {
        let d = read("sigma_v_MPa,diameter_mm,passing_percent\n0,5,50\n0,10,100\n5,1,50\n");
        let s = d.expect("read").gradation().expect("series");
        assert_eq!(s.len(), 2);
        assert_eq!(s[1].name, "coke test, 5 MPa");
        assert_ne!(s[0].mark, s[1].mark);
    }

    #[test]
    fn a_file_without_known_columns_says_what_is_needed() {
        let error = read("stress,n\n1,2\n").expect_err("refused").to_string();
        assert!(error.contains("coke_test.csv: no columns to draw: need sigma_v_kPa"));
        assert!(read("sigma_v_kPa,n\n1,2\n").is_err());
    }
}
