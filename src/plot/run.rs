//! What figures read from the folder of one run: its name, seeds, scale and history.

use super::axis::{count, significant};
use super::canvas::Point;
use super::error::{FigureError, Result};
use super::table::Table;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Seeds of packing and strength.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Seed {
    pub packing: u64,
    pub strength: u64,
}

/// The consecutive records of one stage (load, unload, reload), as points.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    pub stage: String,
    pub points: Vec<Point>,
}

/// What is known of a run from its files; all but the folder and the name may be missing.
#[derive(Clone, Debug)]
pub struct Run {
    pub dir: PathBuf,
    pub name: String,
    pub seed: Option<Seed>,
    /// Scale N (Ciantia et al. 2015, eqs 13-15).
    pub scale: Option<f64>,
    /// Median size of the initial gradation, divided by N, mm.
    pub d50_mm: Option<f64>,
    /// Number of grains at the start and at the end.
    pub grains: Option<(u64, u64)>,
    pub events: Option<u64>,
    /// Number of material points at the end.
    pub points: Option<u64>,
    /// Volume at the start of the test, m³.
    pub volume: Option<f64>,
    /// Void ratio of all dry mass below which the fines would not fit into the voids
    /// (`records.least_void_ratio`).
    pub least_void_ratio: f64,
    /// Vertical stresses, kPa, or axial strains at which the scene asks for gradations.
    pub asked: Vec<f64>,
    /// Vertical stresses, kPa, at which stages of loading start and end.
    pub stages: Vec<f64>,
    /// Name of the grains' material.
    pub material: Option<String>,
    /// Whether nothing moves across one plane (`grid.plane_strain`).
    pub plane_strain: bool,
    pub history: Option<Table>,
}

/// Value of [`Run::least_void_ratio`] for runs whose summary does not hold one.
const LEAST_VOID_RATIO: f64 = 0.15;

/// The whole path of a folder, whatever way it is given, as in `.` or `../a`.
pub fn whole_path(dir: &Path) -> PathBuf {
    dir.canonicalize().unwrap_or_else(|_| dir.to_path_buf())
}

/// Name of a run's folder.
fn folder_name(dir: &Path) -> String {
    whole_path(dir).file_name().map_or_else(|| "run".into(), |n| n.to_string_lossy().into_owned())
}

/// The shortest ends of the paths of these folders that tell them apart, as `a`, or `x/a` and `y/a`.
pub fn folders_apart(dirs: &[PathBuf]) -> Vec<String> {
    let parts = |dir: &PathBuf| -> Vec<String> { whole_path(dir).iter().map(|part| part.to_string_lossy().into_owned()).collect() };
    let all: Vec<Vec<String>> = dirs.iter().map(parts).collect();
    let end = |parts: &[String], n: usize| parts[parts.len().saturating_sub(n)..].join("/");
    let own = |parts: &Vec<String>| {
        let alone = |n: &usize| all.iter().filter(|other| *other != parts).all(|other| end(other, *n) != end(parts, *n));
        (1..=parts.len()).find(alone).map_or_else(|| end(parts, 1), |n| end(parts, n))
    };
    all.iter().map(own).collect()
}

impl Run {
    /// Reads `summary.json`, `history.csv` and the resolved scene of a run folder, each if it is
    /// there.
    pub fn read(dir: &Path) -> Result<Self> {
        if !dir.is_dir() {
            return Err(FigureError::nothing(dir, "no such run folder"));
        }
        let summary = read_summary(&dir.join("summary.json"))?;
        let history = Table::read_if_there(&dir.join("history.csv"))?;
        let resolved = std::fs::read_to_string(dir.join(laboratory::scene::RESOLVED)).unwrap_or_default();
        let resolved: toml::Table = resolved.parse().unwrap_or_default();
        let name = summary["scene"].as_str().map(scene_name);
        let mut run = Self {
            dir: dir.to_path_buf(),
            name: name.unwrap_or_else(|| folder_name(dir)),
            seed: seed(&summary["seed"]),
            scale: summary["scale"].as_f64(),
            d50_mm: summary["d50_mm"].as_f64(),
            grains: summary["grains_initial"].as_u64().zip(summary["grains_final"].as_u64()),
            events: summary["crush_events"].as_u64(),
            points: summary["points"].as_u64(),
            volume: volume(&summary),
            least_void_ratio: summary["least_void_ratio"].as_f64().unwrap_or(LEAST_VOID_RATIO),
            asked: asked(&resolved),
            stages: stages(&resolved),
            material: resolved.get("material").and_then(|m| m.get("name")?.as_str()).map(str::to_string),
            plane_strain: resolved.get("grid").and_then(|grid| grid.get("plane_strain")?.as_bool()).unwrap_or(false),
            history,
        };
        if run.d50_mm.is_none() {
            let d50 = run.column("d50_mm")?.unwrap_or_default();
            run.d50_mm = d50.into_iter().find(|v| v.is_finite());
        }
        Ok(run)
    }

    /// Whether the run is a triaxial test.
    pub fn is_triaxial(&self) -> bool {
        // isotropic compression of grains records volumetric and radial strain as well, but no
        // stress ratio; triaxial tests of a continuum record no radial strain
        let sheared = |h: &Table| h.has("volumetric_strain") && (h.has("stress_ratio") || !h.has("radial_strain"));
        self.history.as_ref().is_some_and(sheared)
    }

    /// A column of the history, `None` if there is no such column.
    pub fn column(&self, name: &str) -> Result<Option<Vec<f64>>> {
        match &self.history {
            Some(table) if table.has(name) => table.numbers(name).map(Some),
            _ => Ok(None),
        }
    }

    /// Points of two history columns in file order, as a branch for each stage; each column is
    /// given with a factor. Of the preparation (stage `settle`) only the last record is kept, where
    /// loading starts. Empty if a column is missing.
    pub fn branches(&self, x: (&str, f64), y: (&str, f64)) -> Result<Vec<Branch>> {
        let (Some(xs), Some(ys)) = (self.column(x.0)?, self.column(y.0)?) else {
            return Ok(Vec::new());
        };
        let stages = self.stages()?;
        let loading = stages.iter().rposition(|s| s == "settle").unwrap_or(0);
        let mut out: Vec<Branch> = Vec::new();
        for i in loading..stages.len() {
            let stage = match stages[i].as_str() {
                "settle" => stages.get(i + 1).cloned().unwrap_or_default(),
                stage => stage.to_string(),
            };
            let (px, py) = (xs[i] * x.1, ys[i] * y.1);
            if !(px.is_finite() && py.is_finite()) {
                continue;
            }
            match out.last_mut() {
                Some(last) if last.stage == stage => last.points.push((px, py)),
                last => {
                    // A branch starts with the last point of the branch before it.
                    let joint = last.and_then(|b| b.points.last().copied());
                    let points = joint.into_iter().chain([(px, py)]).collect();
                    out.push(Branch { stage, points });
                }
            }
        }
        Ok(out)
    }

    /// The step of the last settled record, where loading starts.
    pub fn loading_step(&self) -> Result<Option<f64>> {
        let last = self.stages()?.iter().rposition(|s| s == "settle");
        let steps = self.column("step")?.unwrap_or_default();
        Ok(last.and_then(|i| steps.get(i).copied()).filter(|s| s.is_finite()))
    }

    fn stages(&self) -> Result<Vec<String>> {
        let Some(table) = &self.history else {
            return Ok(Vec::new());
        };
        if !table.has("stage") {
            return Ok(vec!["load".into(); table.len()]);
        }
        Ok(table.texts("stage")?.iter().map(|s| (*s).to_string()).collect())
    }

    /// Value of a column, times `factor`, in the first record of loading whose void ratio is below
    /// [`Run::least_void_ratio`]; `None` if there is no such record.
    pub fn below_least(&self, column: &str, factor: f64) -> Result<Option<f64>> {
        let (Some(e), Some(x)) = (self.column("void_ratio")?, self.column(column)?) else { return Ok(None) };
        let start = self.stages()?.iter().rposition(|s| s == "settle").unwrap_or(0);
        Ok((start..e.len()).find(|&i| e[i] < self.least_void_ratio).map(|i| x[i] * factor))
    }

    /// Facts for titles, such as `petroleum coke`, `grain scale 2`, `d_{50} = 7.1 mm`.
    pub fn facts(&self) -> Vec<String> {
        let scale = self.scale.map(|n| format!("grain scale {}", significant(n, 3)));
        let d50 = self.d50_mm.map(|d| format!("d_{{50}} = {} mm", significant(d, 3)));
        self.material.clone().into_iter().chain(scale).chain(d50).collect()
    }

    /// Outcome for titles, such as `680 → 18 984 grains`, `1408 events`.
    pub fn outcome(&self) -> Vec<String> {
        let grains = self
            .grains
            .map(|(a, b)| if a == b { format!("{} grains", count(a)) } else { format!("{} → {} grains", count(a), count(b)) });
        let events = self.events.map(|n| format!("{} event{}", count(n), if n == 1 { "" } else { "s" }));
        grains.into_iter().chain(events).collect()
    }

    /// Name with the seed, such as `H-C-2, seed 1`.
    pub fn label(&self) -> String {
        match self.seed {
            None => self.name.clone(),
            Some(s) if s.packing == s.strength => format!("{}, seed {}", self.name, s.packing),
            Some(s) => format!("{}, seeds {}/{}", self.name, s.packing, s.strength),
        }
    }
}

/// Volume of the cylinder at the start of its test, m³.
fn volume(summary: &Value) -> Option<f64> {
    let (d, h) = (summary["diameter_mm"].as_f64()? * 1e-3, summary["height_mm"].as_f64()? * 1e-3);
    Some(0.25 * std::f64::consts::PI * d * d * h)
}

/// Values of `records.at_kPa`, or else of `records.at_strain`, in the resolved scene; empty if
/// neither is there.
fn asked(scene: &toml::Table) -> Vec<f64> {
    let list = |key: &str| scene.get("records").and_then(|r| r.get(key)).and_then(toml::Value::as_array).cloned();
    let list = list("at_kPa").or_else(|| list("at_strain")).unwrap_or_default();
    list.iter().filter_map(number).collect()
}

/// Values of `specimen.isotropic_stress_kPa`, `loading.max_stress_kPa` and `loading.stages_kPa` in
/// the resolved scene; those that are there.
fn stages(scene: &toml::Table) -> Vec<f64> {
    let of = |key: &str| scene.get("loading").and_then(|l| l.get(key));
    let later = of("stages_kPa").and_then(toml::Value::as_array).into_iter().flatten();
    let start = scene.get("specimen").and_then(|s| s.get("isotropic_stress_kPa"));
    start.into_iter().chain(of("max_stress_kPa")).chain(later).filter_map(number).collect()
}

fn number(value: &toml::Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
}

/// The summary as JSON, or null if there is none.
pub(super) fn read_summary(path: &Path) -> Result<Value> {
    if !path.is_file() {
        return Ok(Value::Null);
    }
    let text = std::fs::read_to_string(path).map_err(|e| FigureError::io(path, e))?;
    serde_json::from_str(&text).map_err(|e| FigureError::io(path, e))
}

/// Name of a scene; for a path, the name of the file.
fn scene_name(scene: &str) -> String {
    let stem = scene.strip_suffix(".toml").map(|s| s.rsplit(['/', '\\']).next().unwrap_or(s));
    stem.unwrap_or(scene).to_string()
}

fn seed(value: &Value) -> Option<Seed> {
    if let Some(n) = value.as_u64() {
        return Some(Seed { packing: n, strength: n });
    }
    let packing = value["packing"].as_u64();
    let strength = value["strength"].as_u64();
    Some(Seed { packing: packing.or(strength)?, strength: strength.or(packing)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(summary: &str, history: &str) -> (tempfile::TempDir, Result<Run>) {
        let dir = tempfile::tempdir().expect("folder");
        std::fs::write(dir.path().join("summary.json"), summary).expect("summary");
        std::fs::write(dir.path().join("history.csv"), history).expect("history");
        let run = Run::read(dir.path());
        (dir, run)
    }

    const HISTORY: &str = "stage,sigma_v_kPa,porosity,d50_mm\nsettle,1,0.5,7\nsettle,5,0.42,7\nload,100,0.4,6.5\n\
                           load,5000,0.3,1\nunload,100,0.31,1\nreload,5000,,1\n";

    #[test]
    fn summary_and_history_are_read() {
        let text = r#"{"scene": "experiments/H-C-2.toml", "seed": {"packing": 1, "strength": 4}, "scale": 2}"#;
        let (_dir, run) = run(text, HISTORY);
        let run = run.expect("read");
        assert_eq!(run.label(), "H-C-2, seeds 1/4");
        assert_eq!(run.facts(), ["grain scale 2", "d_{50} = 7 mm"]);
    }

    #[test]
    fn a_bare_folder_is_named_by_itself() {
        let dir = tempfile::tempdir().expect("folder");
        let sub = dir.path().join("my-run");
        std::fs::create_dir(&sub).expect("folder");
        let run = Run::read(&sub).expect("read");
        assert_eq!(run.label(), "my-run");
        assert!(run.facts().is_empty() && run.outcome().is_empty());
        assert!(run.branches(("a", 1.0), ("b", 1.0)).expect("none").is_empty());
        assert!(Run::read(&dir.path().join("absent")).is_err());
    }

    #[test]
    fn branches_join_and_start_at_the_last_settled_record() {
        let (_dir, run) = run("{}", HISTORY);
        let run = run.expect("read");
        let b = run.branches(("sigma_v_kPa", 0.001), ("porosity", 1.0)).expect("branches");
        let stages: Vec<&str> = b.iter().map(|b| b.stage.as_str()).collect();
        assert_eq!(stages, ["load", "unload"], "the empty cell is left out");
        assert_eq!(b[0].points, [(0.005, 0.42), (0.1, 0.4), (5.0, 0.3)]);
        assert_eq!(b[1].points, [(5.0, 0.3), (0.1, 0.31)]);
    }

    #[test]
    fn broken_files_are_errors_that_name_them() {
        let (_dir, bad) = run("{\"scene\":", HISTORY);
        assert!(bad.expect_err("json").to_string().contains("summary.json: "));
        let (_dir, odd) = run("{}", "sigma_v_kPa,porosity\n1,abc\n");
        let error = odd.expect("lazy").branches(("sigma_v_kPa", 1.0), ("porosity", 1.0));
        let error = error.expect_err("text").to_string();
        assert!(error.contains("history.csv: line 2, column `porosity`"));
    }
}
