//! The plan of a reproduction: a TOML file that names runs, the numbers published of these runs,
//! and figures.

use super::comparison::Compare;
use super::graph::Chart;
use super::reading::{Expression, Rows, Take};
use crate::{Job, Vary, parse_seeds};
use laboratory::error::{Error, Result};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A paper's runs and figures.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Authors, year, title, journal.
    pub title: String,
    /// What the published figures are and where the published numbers stand.
    pub source: String,
    /// Sum of the published run times, min.
    #[serde(default)]
    pub published_minutes: Option<f64>,
    /// Remarks that stand under the table.
    #[serde(default)]
    pub notes: Vec<String>,
    /// What the runs are compared by.
    #[serde(default)]
    pub compare: Compare,
    /// What the paper says of triaxial tests, each beside what the runs show.
    #[serde(default, rename = "statement")]
    pub statements: Vec<Statement>,
    /// Numbers that the paper states, or that the figures need, each read from a run.
    #[serde(default, rename = "number")]
    pub numbers: Vec<Number>,
    /// Power laws through numbers of a series.
    #[serde(default, rename = "fit")]
    pub fits: Vec<Fit>,
    /// The runs.
    #[serde(default, rename = "run")]
    pub runs: Vec<Run>,
    /// The figures.
    #[serde(default, rename = "figure")]
    pub figures: Vec<Figure>,
    /// Folder of the plan; paths of scenes are relative to this folder.
    #[serde(skip)]
    folder: PathBuf,
}

/// One scene with some seeds.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Name of the run's folder, and of the run's row in the table.
    pub id: String,
    /// Scene file, relative to the folder of the plan.
    pub scene: PathBuf,
    /// Seeds, written as on a command line: `1..5`; `none` for a scene that draws nothing, a continuum without grains.
    #[serde(default = "one")]
    pub seeds: String,
    /// `key=value` laid over the scene.
    #[serde(default)]
    pub set: Vec<String>,
    /// Published numbers of the run.
    #[serde(default)]
    pub published: Vec<Published>,
    /// Published numbers of a triaxial test.
    pub published_test: Option<PublishedTest>,
}

/// What is published of a triaxial test.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedTest {
    /// Share of coarse grains in the mass, %.
    pub coarse_percent: f64,
    /// Material points.
    pub points: Option<f64>,
    /// Coarse grains.
    pub grains: Option<f64>,
    /// Run time, s.
    pub seconds: Option<f64>,
    /// Time that the run simulates, s.
    pub simulated_s: Option<f64>,
}

/// What the paper says of several triaxial tests.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Statement {
    /// What the paper says.
    pub paper: String,
    /// The measure of which it speaks.
    pub of: Measure,
    /// How the measure goes along the runs, by the paper.
    pub expect: Option<Order>,
    /// Names of runs of the plan, in the order of the statement.
    pub runs: Vec<String>,
}

/// A measure of a triaxial test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Largest σ₁/σ₃.
    Peak,
    /// Axial strain at it.
    PeakStrain,
    /// Mean σ₁/σ₃ over the last percent of axial strain.
    Residual,
    /// Volumetric strain at the end, compression positive.
    VolumetricStrain,
    /// Mean plastic strain of the points next to coarse grains over that of all points, at the end.
    PlasticStrainAroundGrains,
    /// Run time.
    WallTime,
}

/// How a measure goes along runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// Each is larger than the one before.
    Rises,
    /// Each is smaller than the one before.
    Falls,
    /// All are the same.
    Equal,
}

/// A number that a run shows.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Number {
    /// What it is, and where the paper states it.
    pub what: String,
    /// The paper's.
    pub paper: Option<f64>,
    /// Unit of both.
    #[serde(default)]
    pub unit: String,
    /// Name of a run of the plan.
    pub run: String,
    /// The rows that it is read from.
    #[serde(default)]
    pub from: Rows,
    /// Expression of their columns.
    pub value: Expression,
    /// Which of the values of all rows it is.
    #[serde(default)]
    pub take: Take,
    /// Series to which it belongs, for figures and fits.
    pub series: Option<String>,
    /// Abscissa in the series.
    pub at: Option<f64>,
}

/// A power law y = c u^n through the numbers of a series.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fit {
    /// What it is.
    pub what: String,
    /// The series.
    pub series: String,
    /// u, an expression of the abscissa x.
    pub base: Expression,
    /// The paper's n.
    pub exponent: Option<f64>,
    /// The paper's c.
    pub factor: Option<f64>,
}

/// A row of a published table.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct Published {
    /// Vertical stress to which the row belongs, kPa; the end of the run if it is not given.
    pub stress_kPa: Option<f64>,
    /// Breakages.
    pub events: f64,
    /// Grains.
    pub grains: f64,
    /// Additional grains that keeping all lost mass would have needed.
    pub excluded: f64,
    /// Run time, min.
    pub minutes: Option<f64>,
}

/// One figure of the paper.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// Name of the figure's folder.
    pub name: String,
    /// Heading: `Fig. 10(a), (b): …`.
    pub title: String,
    /// What the figure shows, according to the paper's text.
    pub paper: String,
    /// What the figure drawn here shows.
    #[serde(default)]
    pub here: String,
    /// What is drawn.
    pub draw: Content,
}

/// What is drawn.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "of", rename_all = "snake_case", deny_unknown_fields)]
pub enum Content {
    /// Curves: each figure of `show` with all runs.
    Curves {
        /// Names of figures.
        show: Vec<String>,
        /// Names of runs of the plan.
        runs: Vec<String>,
    },
    /// Views of the specimens of runs before and after the test.
    Specimen {
        /// Names of runs of the plan.
        runs: Vec<String>,
    },
    /// Sections through mixtures before and after the test, coloured by plastic strain.
    Section {
        /// Names of runs of the plan.
        runs: Vec<String>,
    },
    /// Rigid bodies that are no spheres, at the start and at the end of runs, in plane strain with the points.
    Bodies {
        /// Names of runs of the plan.
        runs: Vec<String>,
    },
    /// A graph of columns of the runs' tables, of numbers of the plan, and of laws.
    Graph(Chart),
    /// Run time against initial grains, crush events and final grains; all runs of the table if none are named.
    Cost {
        /// Names of runs of the plan.
        #[serde(default)]
        runs: Vec<String>,
    },
    /// Limit force of a grain between platens against its diameter (Ciantia et al. 2015, eqs 16 and 17).
    LimitForce {
        /// Smallest and largest diameter, mm.
        diameter_mm: [f64; 2],
        /// Exponents m of the size effect, a curve for each.
        m: Vec<f64>,
        /// Parameters of strength.
        sets: Vec<StrengthSet>,
    },
}

/// Parameters of strength: a row of Table 1 (with an angle) or of Table 2 (with moduli).
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct StrengthSet {
    /// Name in the legend.
    pub label: String,
    /// Mean limit strength at the diameter `d0_mm`, MPa.
    pub sigma_lim0_MPa: f64,
    /// Reference diameter, mm.
    pub d0_mm: f64,
    /// Contact angle, rad (eq. 16).
    pub theta0_rad: Option<f64>,
    /// Young's modulus of the grain, GPa (eq. 17).
    pub E_GPa: Option<f64>,
    /// Poisson's ratio of the grain.
    pub nu: Option<f64>,
    /// Young's modulus of the platen, GPa.
    pub platen_E_GPa: Option<f64>,
    /// Poisson's ratio of the platen.
    pub platen_nu: Option<f64>,
}

/// Whether a folder of this name lies in the folder where it is made, and nowhere else.
fn is_folder_name(name: &str) -> bool {
    !name.is_empty() && name != "." && name != ".." && !name.contains(['/', '\\'])
}

fn one() -> String {
    "1".into()
}

/// Most runs and most figures of a plan.
const MOST: usize = 1000;

impl Plan {
    /// Reads a plan from a file, or by the name of a file in `experiments/`.
    ///
    /// # Errors
    /// A file that is missing or is no plan, a run named twice, a figure of a run that is not in
    /// the plan.
    pub fn read(name: &str) -> Result<Plan> {
        let path = locate(name)?;
        let text = laboratory::scene::read_text(&path)?;
        let mut plan: Plan =
            toml::from_str(&text).map_err(|e| Error::input(path.display(), "", None, e.to_string().trim_end().to_string()))?;
        plan.folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        plan.check(&path)?;
        Ok(plan)
    }

    fn check(&self, path: &Path) -> Result<()> {
        for (what, count) in [("run", self.runs.len()), ("figure", self.figures.len())] {
            if count > MOST {
                let message = format!("must have at most {MOST} entries; there are {count}");
                return Err(Error::input(path.display(), what, None, message));
            }
        }
        let mut errors = Vec::new();
        for (i, run) in self.runs.iter().enumerate() {
            let wrong = |key: &str, value: &str, message: &str| {
                Error::input(path.display(), format!("run.{key}"), Some(value.to_string()), message)
            };
            if !is_folder_name(&run.id) {
                errors.push(wrong("id", &run.id, "must be the name of a folder"));
            }
            if self.runs[..i].iter().any(|other| other.id == run.id) {
                errors.push(wrong("id", &run.id, "stands there twice"));
            }
            errors.extend(run.numbers().err());
        }
        errors.extend(self.check_tests(path));
        errors.extend(self.check_numbers(path));
        for figure in &self.figures {
            let wrong = |value: &str, message: &str| {
                Error::input(path.display(), format!("figure {}", figure.name), Some(value.to_string()), message)
            };
            if !is_folder_name(&figure.name) {
                errors.push(wrong(&figure.name, "must be the name of a folder"));
            }
            match &figure.draw {
                Content::Curves { runs, .. }
                | Content::Specimen { runs }
                | Content::Section { runs }
                | Content::Bodies { runs }
                | Content::Cost { runs } => {
                    let unknown = runs.iter().filter(|id| self.run(id).is_none());
                    errors.extend(unknown.map(|id| wrong(id, "is no run of the plan")));
                }
                Content::Graph(chart) => errors.extend(chart.faults(self).into_iter().map(|(of, message)| wrong(&of, &message))),
                Content::LimitForce { sets, .. } => {
                    let open = |s: &&StrengthSet| s.theta0_rad.is_some() == s.moduli().is_some();
                    let message = "needs either theta0_rad, or E_GPa, nu, platen_E_GPa and platen_nu";
                    errors.extend(sets.iter().filter(open).map(|s| wrong(&s.label, message)));
                }
            }
        }
        Error::all(errors)
    }

    /// Mistakes in what is said of triaxial tests.
    fn check_tests(&self, path: &Path) -> Vec<Error> {
        let wrong = |key: &str, value: &str, message: &str| Error::input(path.display(), key, Some(value.to_string()), message);
        let mut errors = Vec::new();
        for (i, statement) in self.statements.iter().enumerate() {
            let key = format!("statement[{i}].runs");
            let unknown = statement.runs.iter().filter(|id| self.run(id).is_none());
            errors.extend(unknown.map(|id| wrong(&key, id, "is no run of the plan")));
        }
        let tests = self.runs.iter().filter(|run| run.published_test.is_some()).map(|run| ("run.published_test", &*run.id));
        let statements = self.statements.iter().map(|s| ("statement", &*s.paper));
        if self.compare != Compare::Triaxial {
            errors.extend(tests.chain(statements).map(|(key, of)| wrong(key, of, "needs compare = \"triaxial\"")));
        } else {
            let counted = self.runs.iter().filter(|run| !run.published.is_empty());
            errors.extend(counted.map(|run| wrong("run.published", &run.id, "needs compare = \"crushing\"")));
        }
        errors
    }

    /// Mistakes in the numbers and power laws.
    fn check_numbers(&self, path: &Path) -> Vec<Error> {
        let wrong = |key: String, value: &str, message: &str| Error::input(path.display(), key, Some(value.to_string()), message);
        let mut errors = Vec::new();
        for (i, number) in self.numbers.iter().enumerate() {
            if self.run(&number.run).is_none() {
                errors.push(wrong(format!("number[{i}].run"), &number.run, "is no run of the plan"));
            }
            if !is_folder_name(&number.from.table) {
                errors.push(wrong(format!("number[{i}].from.table"), &number.from.table, "must be the name of a file of a run"));
            }
        }
        if self.compare != Compare::Numbers {
            let first = self.numbers.first().map(|n| ("number", &n.what)).or(self.fits.first().map(|f| ("fit", &f.what)));
            errors.extend(first.map(|(key, what)| wrong(key.into(), what, "needs compare = \"numbers\"")));
        }
        for (i, fit) in self.fits.iter().enumerate() {
            if let Err(message) = fit.base.along("x", std::iter::empty()) {
                errors.push(wrong(format!("fit[{i}].base"), &fit.what, &message));
            }
            if !self.has_series(&fit.series) {
                errors.push(wrong(format!("fit[{i}].series"), &fit.series, "is no series of the plan's numbers"));
            }
        }
        errors
    }

    /// Whether a number belongs to this series.
    pub fn has_series(&self, name: &str) -> bool {
        self.numbers.iter().any(|n| n.series.as_deref() == Some(name))
    }

    /// The run named `id`.
    pub fn run(&self, id: &str) -> Option<&Run> {
        self.runs.iter().find(|run| run.id == id)
    }

    /// The jobs of a run, one for each seed, in `out/ID/seed-N`; without seeds one in `out/ID/run`.
    ///
    /// # Errors
    /// Text in `seeds` that is no list of seeds.
    pub fn jobs(&self, run: &Run, out: &Path) -> Result<Vec<Job>> {
        let seeds = run.numbers()?;
        let job = |name: &str| Job::new(self.folder.join(&run.scene), out.join(&run.id).join(name)).with(&run.set);
        if seeds.is_empty() {
            return Ok(vec![job("run")]);
        }
        Ok(seeds.into_iter().map(|seed| job(&format!("seed-{seed}")).seeded(Vary::Both, seed)).collect())
    }
}

impl Run {
    /// The seeds; none for a scene that draws nothing.
    fn numbers(&self) -> Result<Vec<u64>> {
        if self.seeds == "none" { Ok(Vec::new()) } else { parse_seeds(&self.seeds) }
    }
}

impl StrengthSet {
    /// E, Pa, and ν of the grain and of the platen; `None` if one of them is not given.
    pub fn moduli(&self) -> Option<[(f64, f64); 2]> {
        Some([(1e9 * self.E_GPa?, self.nu?), (1e9 * self.platen_E_GPa?, self.platen_nu?)])
    }
}

/// Path of the plan `name`: a file of this name, or `experiments/NAME.toml`.
fn locate(name: &str) -> Result<PathBuf> {
    let given = PathBuf::from(name);
    let named = Path::new("experiments").join(format!("{name}.toml"));
    if given.is_file() {
        return Ok(given);
    }
    if named.is_file() {
        return Ok(named);
    }
    let message = format!("is neither a plan (TOML) nor the name of one: there is no {}", named.display());
    Err(Error::input(name, "", None, message))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Plan> {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("plan.toml");
        std::fs::write(&path, text).expect("written");
        Plan::read(&path.display().to_string())
    }

    const HEAD: &str = "title = \"t\"\nsource = \"s\"\n";
    const RUN: &str = "[[run]]\nid = \"a\"\nscene = \"a.toml\"\nseeds = \"1..3\"\n";

    #[test]
    fn a_run_has_a_job_for_each_seed() {
        let plan = read(&format!("{HEAD}{RUN}")).expect("plan");
        let jobs = plan.jobs(&plan.runs[0], Path::new("out")).expect("jobs");
        let folders: Vec<String> = jobs.iter().map(|j| j.out.display().to_string()).collect();
        assert_eq!(folders, ["out/a/seed-1", "out/a/seed-2", "out/a/seed-3"]);
        assert!(jobs[0].scene.ends_with("a.toml") && jobs[0].scene.is_absolute());
        let plan = read(&format!("{HEAD}{RUN}").replace("1..3", "none")).expect("plan");
        let [job] = &plan.jobs(&plan.runs[0], Path::new("out")).expect("jobs")[..] else { panic!("one") };
        assert!(job.seed_packing.is_none() && job.out.ends_with("a/run"));
    }

    #[test]
    fn wrong_plans_are_refused_with_their_place() {
        let figure = "[[figure]]\nname = \"f\"\ntitle = \"\"\npaper = \"\"\n";
        for (text, says) in [
            (format!("{HEAD}{RUN}{RUN}"), "run.id = a: stands there twice"),
            (format!("{HEAD}{RUN}").replace("1..3", "3..1"), "counts down"),
            (format!("{HEAD}{RUN}").replace("\"a\"", "\"..\""), "run.id = ..: must be the name of a folder"),
            (
                format!("{HEAD}{figure}[figure.draw]\nof = \"cost\"\n").replace("\"f\"", "\"../f\""),
                "figure ../f = ../f: must be the name of a folder",
            ),
            (
                format!("{HEAD}{figure}[figure.draw]\nof = \"curves\"\nshow = []\nruns = [\"b\"]\n"),
                "figure f = b: is no run of the plan",
            ),
            (
                format!(
                    "{HEAD}{figure}[figure.draw]\nof = \"limit_force\"\ndiameter_mm = [1, 2]\nm = [2]\nsets = [{{ label = \"x\", sigma_lim0_MPa = 1, d0_mm = 2 }}]\n"
                ),
                "needs either theta0_rad",
            ),
            (format!("{HEAD}speed = 3\n"), "unknown field `speed`"),
        ] {
            let error = read(&text).expect_err(says).to_string();
            assert!(error.contains(says) && (error.contains("plan.toml") || error.contains("seeds ")), "{error}");
        }
        assert!(Plan::read("no-such-paper").expect_err("absent").to_string().contains("experiments/no-such-paper.toml"));
    }
}
