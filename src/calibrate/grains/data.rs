//! Crushing tests from a CSV file: a row for each grain, `diameter_mm,force_N` with optional
//! `censored` and `series`.

use laboratory::error::{Error, Result};
use laboratory::scene::{bounded_columns, read_text};
use std::path::{Path, PathBuf};

/// Units of length and force by the suffix of a column, in SI.
const LENGTHS: [(&str, f64); 4] = [("mm", 1e-3), ("m", 1.0), ("cm", 1e-2), ("um", 1e-6)];
const FORCES: [(&str, f64); 4] = [("N", 1.0), ("kN", 1e3), ("MN", 1e6), ("mN", 1e-3)];
const DIAMETER: [&str; 2] = ["diameter", "d"];
const FORCE: [&str; 4] = ["force", "F", "peak_force", "crushing_force"];
/// Largest number of wrong rows that are reported.
const TOLD: usize = 8;
/// Least number of broken grains for a fit: a law of three parameters needs more than three values.
pub const LEAST: usize = 5;

/// One crushing test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// m
    pub diameter: f64,
    /// Force at which the grain broke, or the largest force that it bore without breaking, N.
    pub force: f64,
    /// Whether the grain did not break.
    pub censored: bool,
    /// Index into [`Data::series`].
    pub series: usize,
}

/// The tests of one file.
#[derive(Clone, Debug)]
pub struct Data {
    /// File of the tests.
    pub path: PathBuf,
    /// The tested grains.
    pub grains: Vec<Grain>,
    /// Names of the series; one empty name where the file has none.
    pub series: Vec<String>,
    /// Remarks for the user about the data.
    pub notes: Vec<String>,
}

impl Data {
    /// The number of grains that broke.
    pub fn broken(&self) -> usize {
        self.grains.iter().filter(|g| !g.censored).count()
    }

    /// Smallest and largest diameter, m.
    pub fn extent(&self) -> (f64, f64) {
        let sizes = self.grains.iter().map(|g| g.diameter);
        sizes.fold((f64::INFINITY, 0.0), |(low, high), d| (f64::min(low, d), f64::max(high, d)))
    }

    /// ln diameter and ln force of the broken grains.
    fn logarithms(&self) -> Vec<(f64, f64)> {
        self.grains.iter().filter(|g| !g.censored).map(|g| (g.diameter.ln(), g.force.ln())).collect()
    }

    /// Whether at least [`LEAST`] grains broke and their forces scatter about a power law of the
    /// size.
    pub fn has_spread(&self) -> bool {
        self.broken() >= LEAST && line(&self.logarithms()).1 >= 1e-6
    }

    /// Whether all grains are of one size, to a tenth of a per cent: then m cannot be found.
    pub fn one_size(&self) -> bool {
        let (low, high) = self.extent();
        high / low < 1.001
    }
}

/// Most grains of a data file, and most series.
const MOST: usize = 1_000_000;
const MOST_SERIES: usize = 1000;

/// Reads and checks a data file.
///
/// # Errors
/// Missing columns, two columns of one quantity, columns without unit; values that are no positive
/// numbers (the first few, each with its line); too few broken grains; forces without any spread.
/// The message says what is allowed, or what cannot be estimated and why.
pub fn read(path: &Path) -> Result<Data> {
    let text = read_text(path)?;
    let text = laboratory::columns::mapped(path, &text)?;
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let header = reader.headers().map_err(|e| bad(path, e))?;
    bounded_columns(path, header.len())?;
    let header: Vec<String> = header.iter().map(str::to_string).collect();
    let columns = Columns::find(path, &header)?;
    let mut data = Data { path: path.into(), grains: Vec::new(), series: Vec::new(), notes: columns.notes(&header) };
    let mut errors = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| bad(path, e))?;
        let line = record.position().map_or(0, csv::Position::line);
        if data.grains.len() == MOST || data.series.len() > MOST_SERIES {
            let message = format!("must have at most {MOST} grains in {MOST_SERIES} series");
            return Err(Error::input(path.display(), "", None, message));
        }
        match columns.grain(path, line, &header, &record, &mut data.series) {
            Ok(grain) => data.grains.push(grain),
            Err(error) if errors.len() < TOLD => errors.push(error),
            Err(_) => {
                errors.push(Error::input(path.display(), "", None, "has more wrong rows; these are the first"));
                break;
            }
        }
    }
    Error::all(errors)?;
    enough(&data)?;
    add_warnings(&mut data);
    Ok(data)
}

fn bad(path: &Path, error: csv::Error) -> Error {
    Error::input(path.display(), "", None, format!("not CSV: {error}"))
}

/// Index of each column, with the SI value of its unit where it has one.
struct Columns {
    diameter: (usize, f64),
    force: (usize, f64),
    censored: Option<usize>,
    series: Option<usize>,
}

impl Columns {
    fn find(path: &Path, header: &[String]) -> Result<Columns> {
        if let [only] = header
            && only.contains([';', '\t'])
        {
            return Err(Error::input(path.display(), "", None, "its columns must be separated by commas"));
        }
        let diameter = measured(path, header, "diameter", &DIAMETER, &LENGTHS);
        let force = measured(path, header, "force", &FORCE, &FORCES);
        let (diameter, force) = match (diameter, force) {
            (Ok(d), Ok(f)) => (d, f),
            (d, f) => {
                Error::all([d.err(), f.err()].into_iter().flatten().collect())?;
                return Err(Error::input(path.display(), "", None, "has no columns"));
            }
        };
        let named = |name: &str| header.iter().position(|h| h == name);
        Ok(Columns { diameter, force, censored: named("censored"), series: named("series") })
    }

    /// Note for the user that names the columns that are not used.
    fn notes(&self, header: &[String]) -> Vec<String> {
        let used = [Some(self.diameter.0), Some(self.force.0), self.censored, self.series];
        let unused: Vec<&str> = header
            .iter()
            .enumerate()
            .filter(|(i, h)| !used.contains(&Some(*i)) && !h.is_empty())
            .map(|(_, h)| h.as_str())
            .collect();
        if unused.is_empty() { Vec::new() } else { vec![format!("columns not used: {}", unused.join(", "))] }
    }

    fn grain(&self, path: &Path, line: u64, header: &[String], row: &csv::StringRecord, series: &mut Vec<String>) -> Result<Grain> {
        let place = format!("{}: line {line}", path.display());
        if row.len() != header.len() {
            let message = format!("has {} values where the header has {} columns (decimals need a point)", row.len(), header.len());
            return Err(Error::input(place, "", None, message));
        }
        let positive = |(at, unit): (usize, f64)| {
            let text = &row[at];
            let wrong = |message: &str| Error::input(&place, header[at].clone(), Some(format!("\"{text}\"")), message);
            let value: f64 = text.parse().map_err(|_| wrong("must be a number > 0"))?;
            if !(value.is_finite() && value > 0.0) {
                return Err(wrong("must be a number > 0 (compression is positive)"));
            }
            let si = value * unit;
            if !(1e-12..=1e12).contains(&si) {
                return Err(wrong("is not a possible size or force of a grain; is the unit in the header right?"));
            }
            Ok(si)
        };
        let (diameter, force) = (positive(self.diameter)?, positive(self.force)?);
        let censored = match self.censored.map(|at| row[at].to_lowercase()) {
            None => false,
            Some(text) => match text.as_str() {
                "" | "0" | "false" | "no" => false,
                "1" | "true" | "yes" => true,
                _ => {
                    let message = "must be 1 or true (the grain did not break), 0 or false (it broke)";
                    return Err(Error::input(place, "censored", Some(format!("\"{text}\"")), message));
                }
            },
        };
        let name = self.series.map_or("", |at| &row[at]);
        let series = series.iter().position(|s| s == name).unwrap_or_else(|| {
            series.push(name.into());
            series.len() - 1
        });
        Ok(Grain { diameter, force, censored, series })
    }
}

/// Index of the column of a quantity, and the SI value of its unit.
fn measured(path: &Path, header: &[String], what: &str, names: &[&str], units: &[(&str, f64)]) -> Result<(usize, f64)> {
    let allowed: Vec<String> = units.iter().map(|(unit, _)| format!("{what}_{unit}")).collect();
    let wrong = |key: &str, message: String| Error::input(path.display(), key, None, message);
    let (mut found, mut unknown) = (Vec::new(), None);
    for (i, column) in header.iter().enumerate() {
        let matched = names.iter().filter_map(|n| Some((*n, column.strip_prefix(n)?))).max_by_key(|(n, _)| n.len());
        match matched {
            Some((_, "")) => {
                let message = format!("has no unit: write it into the header, one of {}", allowed.join(", "));
                return Err(wrong(column, message));
            }
            Some((_, rest)) if rest.starts_with('_') => {
                let Some((_, si)) = units.iter().find(|(unit, _)| *unit == &rest[1..]) else {
                    unknown = unknown.or(Some(column));
                    continue;
                };
                found.push((i, *si));
            }
            _ => {}
        }
    }
    match found[..] {
        [one] => Ok(one),
        [] if unknown.is_some() => {
            let message = format!("its unit is not known: must be one of {}", allowed.join(", "));
            Err(wrong(unknown.map_or("", String::as_str), message))
        }
        [] => {
            let have = header.join(", ");
            Err(wrong("", format!("no column of the {what}: must have one of {}; it has {have}", allowed.join(", "))))
        }
        [_, second, ..] => Err(wrong(&header[second.0], format!("is a second column of the {what}: keep one"))),
    }
}

/// Refuses data to which no law can be fitted: no rows, too few broken grains, or forces without
/// spread.
fn enough(data: &Data) -> Result<()> {
    let refuse = |message: String| Err(Error::input(data.path.display(), "", None, message));
    let broken: Vec<&Grain> = data.grains.iter().filter(|g| !g.censored).collect();
    if data.grains.is_empty() {
        return refuse("has no rows below its header".into());
    }
    if broken.is_empty() {
        return refuse(format!(
            "none of its {} grains broke: the forces are lower bounds of their strengths, and neither sigma_lim0, m nor var. can be \
             estimated",
            data.grains.len()
        ));
    }
    if broken.len() < LEAST {
        return refuse(format!(
            "has {} broken grains, too few: {LEAST} are the least from which a mean and a spread are fitted, and intervals mean \
             something from about 30 on",
            broken.len()
        ));
    }
    if !data.has_spread() {
        let points = data.logarithms();
        let (slope, _) = line(&points);
        let constant = points.iter().all(|p| (p.1 - points[0].1).abs() < 1e-9);
        let what = if constant {
            format!("every grain broke at {} N: constant values", broken[0].force)
        } else {
            format!("all forces lie on one curve, F = c d^{slope:.4}")
        };
        return refuse(format!(
            "{what}. var. cannot be estimated from values without spread, and without it no likelihood or interval of sigma_lim0 and m; \
             are these means or results of a formula? Give the single grains"
        ));
    }
    Ok(())
}

/// Slope of the least-squares line through the points and the root mean square distance from it.
pub fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let xx: f64 = points.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
    let xy: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let slope = if xx > 1e-9 * n { xy / xx } else { 0.0 };
    let rest: f64 = points.iter().map(|p| (p.1 - y - slope * (p.0 - x)).powi(2)).sum();
    (slope, (rest / n).sqrt())
}

/// Adds notes about values that are possible but odd.
fn add_warnings(data: &mut Data) {
    let (low, high) = data.extent();
    let mut notes = Vec::new();
    if low < 10e-6 || high > 0.5 {
        notes.push(format!("diameters from {:.4} to {:.4} mm: are their units right?", 1e3 * low, 1e3 * high));
    }
    let nominal = data.grains.iter().map(|g| g.force / (g.diameter * g.diameter) * 1e-6);
    let (least, most) = nominal.fold((f64::INFINITY, 0.0), |(a, b), s| (f64::min(a, s), f64::max(b, s)));
    if least < 1e-3 || most > 1e4 {
        notes
            .push(format!("F/d² from {least:.3e} to {most:.3e} MPa, where sands and rocks have 0.1 to 1000: are the units right?"));
    }
    let broken = data.broken();
    if broken < 30 {
        notes.push(format!("only {broken} broken grains: intervals rest on large-sample theory and are too narrow below about 30"));
    }
    if data.one_size() {
        notes.push(format!("all grains are {:.4} mm: m (the effect of size) cannot be estimated from one size", 1e3 * low));
    } else if high / low < 1.3 {
        notes.push(format!("sizes differ by {:.0} % only: m is weakly determined", 1e2 * (high / low - 1.0)));
    }
    data.notes.extend(notes);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from(text: &str) -> Result<Data> {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("grains.csv");
        std::fs::write(&path, text).expect("written");
        read(&path)
    }

    fn refused(text: &str, says: &str) {
        let error = from(text).expect_err("refused").to_string();
        assert!(error.contains(says), "{error}\n instead of\n{says}");
        assert!(!error.contains("NaN"));
    }

    const ROWS: &str = "1,10\n1,12\n2,30\n2,36\n2,41\n";

    #[test]
    fn units_are_those_of_the_header() {
        let plain = from(&format!("\u{feff}diameter_mm,force_N\r\n{ROWS}")).expect("data");
        assert_eq!(plain.grains[0], Grain { diameter: 1e-3, force: 10.0, censored: false, series: 0 });
        let other = from(
            "note,F_kN,censored,d_cm,series\na,0.01,,0.1,x\na,0.012,0,0.1,y\nb,0.03,yes,0.2,x\nb,1,0,0.2,x\nb,1.1,0,0.2,x\nb,1.2,no,1,x\n",
        );
        let other = other.expect("data");
        assert!((other.grains[0].force - 10.0).abs() < 1e-12 && (other.grains[0].diameter - 1e-3).abs() < 1e-15);
        assert!(other.grains[2].censored && other.broken() == 5);
        assert_eq!((other.series.as_slice(), other.grains[1].series), (["x".to_string(), "y".into()].as_slice(), 1));
        assert!(other.notes.contains(&"columns not used: note".to_string()));
    }

    #[test]
    fn wrong_columns_are_told_with_what_is_allowed() {
        refused("diameter_mm,load\n1,2\n", "no column of the force: must have one of force_N, force_kN");
        refused("size,force_N\n1,2\n", "no column of the diameter");
        refused("diameter_mm,force\n1,2\n", "force: has no unit: write it into the header");
        refused("diameter_mm,force_lbf\n1,2\n", "force_lbf: its unit is not known");
        refused("diameter_mm,d_m,force_N\n1,2,3\n", "second column of the diameter");
        refused("diameter_mm;force_N\n1;2\n", "separated by commas");
    }

    #[test]
    fn wrong_values_are_told_with_their_lines() {
        refused("diameter_mm,force_N\n1,10\n2,-3\n", "grains.csv: line 3: force_N = \"-3\": must be a number > 0");
        refused("diameter_mm,force_N\n0,10\n", "diameter_mm = \"0\"");
        refused("diameter_mm,force_N\n1,nan\n", "force_N = \"nan\"");
        refused("diameter_mm,force_N\n1,\n", "force_N = \"\"");
        refused("diameter_mm,force_N\n1,2,5\n", "decimals need a point");
        refused("diameter_mm,force_N,censored\n1,2,maybe\n", "censored = \"maybe\"");
        let many = format!("diameter_mm,force_N\n{}", "x,1\n".repeat(20));
        refused(&many, "more wrong rows");
    }

    #[test]
    fn what_cannot_be_estimated_is_said() {
        refused("diameter_mm,force_N\n", "no rows");
        refused("diameter_mm,force_N\n1,2\n1,3\n2,6\n", "3 broken grains, too few: 5");
        refused(&format!("diameter_mm,force_N,censored\n{}", "1,5,1\n2,7,1\n".repeat(6)), "none of its 12 grains broke");
        refused(&format!("diameter_mm,force_N\n{}", "2,7\n".repeat(6)), "every grain broke at 7 N: constant values");
        refused(&format!("diameter_mm,force_N\n{}", "2,8\n4,32\n1,2\n".repeat(6)), "F = c d^2.0000");
        let one = from("diameter_mm,force_N\n2,7\n2,8\n2,9\n2,6\n2,8.5\n").expect("one size is allowed");
        assert!(one.one_size() && one.notes.iter().any(|n| n.contains("m (the effect of size) cannot")));
        let odd = from("diameter_m,force_N\n2,7\n2,8\n2,9\n2,6\n2,8.5\n").expect("data");
        assert!(odd.notes.iter().any(|n| n.contains("are the units right")), "{:?}", odd.notes);
    }
}
