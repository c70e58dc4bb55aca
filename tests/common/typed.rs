//! Continuum scenes of `experiments/mpm`, and those of other folders by theirs, as a user types them, and what their runs leave.

use super::ROOT;
use assert_cmd::Command;
use csv::StringRecord;
use serde_json::Value;
use std::path::Path;

/// `comminute VERB` in the repository's root.
pub fn comminute(verb: &str) -> Command {
    let mut command = Command::cargo_bin("comminute").expect("the program");
    command.current_dir(ROOT).arg(verb);
    command
}

/// `comminute run` of a scene on one thread, with these overrides and arguments.
pub fn run(scene: &str, out: &Path, sets: &[&str], more: &[&str]) -> Command {
    let mut command = comminute("run");
    let folder = if scene.contains('/') { "experiments" } else { "experiments/mpm" };
    command.arg(format!("{folder}/{scene}.toml")).arg("--out").arg(out).args(["--threads", "1", "--quiet"]).args(more);
    for set in sets {
        command.args(["--set", set]);
    }
    command
}

pub fn summary(out: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(out.join("summary.json")).expect("summary")).expect("JSON")
}

pub fn number(summary: &Value, key: &str) -> f64 {
    summary[key].as_f64().unwrap_or_else(|| panic!("{key} in {summary}"))
}

/// Rows of some columns of the history, those of its stage `load`.
pub fn columns<const N: usize>(out: &Path, names: [&str; N]) -> Vec<[f64; N]> {
    let (header, rows) = table(&out.join("history.csv"));
    let stage = place(&header, "stage");
    let at = names.map(|name| place(&header, name));
    rows.iter().filter(|row| &row[stage] == "load").map(|row| at.map(|k| row[k].parse().expect("number"))).collect()
}

/// Some columns of the grains at the end.
pub fn final_grains<const N: usize>(out: &Path, names: [&str; N]) -> Vec<[f64; N]> {
    let (header, rows) = table(&out.join("grains_final.csv"));
    let at = names.map(|name| place(&header, name));
    rows.iter().map(|row| at.map(|k| row[k].parse().expect("number"))).collect()
}

/// Header and rows of a table.
pub fn table(path: &Path) -> (StringRecord, Vec<StringRecord>) {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).expect("table");
    (reader.headers().expect("header").clone(), reader.records().map(|row| row.expect("row")).collect())
}

fn place(header: &StringRecord, name: &str) -> usize {
    header.iter().position(|h| h == name).unwrap_or_else(|| panic!("{name}"))
}

/// Some columns of a table of numbers that a run has left; an empty cell is not a number.
pub fn numbers<const N: usize>(path: &Path, names: [&str; N]) -> Vec<[f64; N]> {
    let (header, rows) = table(path);
    let at = names.map(|name| place(&header, name));
    rows.iter().map(|row| at.map(|k| row[k].parse().unwrap_or(f64::NAN))).collect()
}

/// Whether two runs have left the same bytes.
#[track_caller]
pub fn same_files(a: &Path, b: &Path) {
    for file in ["history.csv", "points_final.csv", "points_start.csv", "breakage.csv", "gsd.csv"] {
        let bytes = |dir: &Path| std::fs::read(dir.join(file)).ok();
        let breaks = ["breakage.csv", "gsd.csv"].contains(&file);
        assert!(bytes(a) == bytes(b) && (breaks || bytes(a).is_some()), "{file} differs");
    }
}

/// An array of a snapshot for ParaView, by name: numbers of eight bytes.
pub fn array(file: &[u8], name: &str) -> Vec<[u8; 8]> {
    let text = String::from_utf8_lossy(file);
    let tag = text.split("<DataArray ").find(|tag| tag.contains(&format!("Name=\"{name}\""))).expect(name);
    let offset: usize = tag.split("offset=\"").nth(1).and_then(|t| t.split('"').next()).expect("offset").parse().expect("number");
    let mark = b"encoding=\"raw\">\n_";
    let start = file.windows(mark.len()).position(|w| w == mark).expect("mark") + mark.len() + offset;
    let count = u64::from_le_bytes(file[start..start + 8].try_into().expect("8 bytes")) as usize;
    file[start + 8..start + 8 + count].as_chunks::<8>().0.to_vec()
}

/// In a specimen between walls at the sides all solids stay, also what breakages lose: 1 + e goes with the height, 1 - axial strain. (A platen lies at the
/// faces of points, less their overlap, which is 10⁻⁴ of the height here and nothing in the first row.)
pub fn keeps_its_solids(out: &Path) {
    let rows = columns(out, ["void_ratio", "axial_strain"]);
    let size = |r: &[f64; 2]| (1.0 + r[0]) / (1.0 - r[1]);
    for row in &rows {
        assert!((size(row) / size(&rows[0]) - 1.0).abs() < 3e-4, "{row:?} after {:?}", rows[0]);
    }
}
