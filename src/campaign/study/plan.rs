//! The plan of a study: a TOML file that names a scene, factors with levels, a reference and seeds.

use super::Measure;
use crate::{Job, Vary, parse_seeds};
use laboratory::error::{Error, Result};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What is varied, against what, and by what it is judged.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Title of the report.
    pub title: String,
    /// The question that the study answers, in a sentence or two.
    #[serde(default)]
    pub question: String,
    /// Scene file, relative to the folder of the plan.
    pub scene: PathBuf,
    /// `key=value` laid over the scene in every run.
    #[serde(default)]
    pub set: Vec<String>,
    /// Seeds of each setting, as `1..5`; `none` for a scene that draws nothing.
    #[serde(default = "five")]
    pub seeds: String,
    /// Which combinations of levels are run.
    #[serde(default)]
    pub design: Design,
    /// The setting with which all others are compared; without it the scene as it is, in a factorial the first level of each factor.
    pub reference: Option<Reference>,
    /// Whether all runs of a seed begin with one specimen, that of the scene as it is, which is then a setting of its own. Otherwise each run prepares its own, and a
    /// choice that changes the preparation changes the specimen.
    #[serde(default)]
    pub same_specimens: bool,
    /// What the settings are judged by; all that the runs have if none are named.
    #[serde(default)]
    pub measures: Vec<Measure>,
    /// Largest difference from the reference that is allowed; for a measure without one the standard deviation of the reference over its seeds.
    #[serde(default)]
    pub tolerance: BTreeMap<Measure, f64>,
    /// Remarks that stand at the end of the report.
    #[serde(default)]
    pub notes: Vec<String>,
    /// The factors.
    #[serde(default, rename = "factor")]
    pub factors: Vec<Factor>,
    /// Folder of the plan.
    #[serde(skip)]
    folder: PathBuf,
}

/// Which combinations of levels are run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Design {
    /// The reference, and each level of each factor while the other factors stay as in the reference.
    #[default]
    OneAtATime,
    /// Every combination of levels.
    Full,
    /// A fraction of the combinations of factors with two levels: the levels of those with `product_of` follow from the others.
    Fraction,
}

/// The setting with which all others are compared.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// Name in tables and figures.
    #[serde(default = "reference")]
    pub name: String,
    /// `key=value` laid over the scene.
    #[serde(default)]
    pub set: Vec<String>,
}

/// A factor with its levels: values of one key, or settings of their own.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Factor {
    /// Name in tables and figures.
    pub name: String,
    /// The key whose values are the levels.
    pub key: Option<String>,
    /// Values of `key`.
    #[serde(default)]
    pub values: Vec<toml::Value>,
    /// Levels with names and settings of their own.
    #[serde(default)]
    pub levels: Vec<Level>,
    /// In a fraction: the factors whose product is this one (low and high level as −1 and 1).
    #[serde(default)]
    pub product_of: Vec<String>,
}

/// A level of a factor.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Level {
    /// Name in tables and figures.
    pub name: String,
    /// `key=value` laid over the scene.
    pub set: Vec<String>,
}

/// A combination of levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Name in tables and figures.
    pub name: String,
    /// Index of the level of each factor; `None` where it is that of the reference.
    pub levels: Vec<Option<usize>>,
    /// `key=value` laid over the scene.
    pub sets: Vec<String>,
    /// Whether its runs begin with the specimens of the scene as it is.
    pub borrows: bool,
}

/// Name of the scene as it is.
const SCENE: &str = "the scene";

fn five() -> String {
    "1..5".into()
}

fn reference() -> String {
    "reference".into()
}

/// Most settings and most runs of a study.
const MOST: usize = 1000;
const MOST_RUNS: usize = 20_000;

impl Setting {
    /// The folder of its runs: its name without signs that folders should not have.
    pub fn folder(&self) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() || "-._".contains(c) { c } else { '_' };
        self.name.chars().map(plain).collect()
    }
}

impl Factor {
    /// Whether its levels are numbers, which have an order and values between them.
    pub fn is_numeric(&self) -> bool {
        let number = |value: &toml::Value| value.is_float() || value.is_integer();
        self.key.is_some() && self.values.iter().all(number)
    }

    /// The levels: those written out, or the values of the key.
    fn all(&self) -> Vec<Level> {
        let Some(key) = &self.key else { return self.levels.clone() };
        let level = |value: &toml::Value| {
            let name = value.as_str().map_or_else(|| value.to_string(), str::to_string);
            Level { name, set: vec![format!("{key}={value}")] }
        };
        self.values.iter().map(level).collect()
    }
}

impl Plan {
    /// Reads a plan from a file.
    ///
    /// # Errors
    /// A file that is missing or is no plan of a study: with the key and what is allowed.
    pub fn read(path: &Path) -> Result<Plan> {
        let text = laboratory::scene::read_text(path)?;
        let mut plan: Plan =
            toml::from_str(&text).map_err(|e| Error::input(path.display(), "", None, e.to_string().trim_end().to_string()))?;
        plan.folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        plan.check(path)?;
        for factor in &mut plan.factors {
            factor.levels = factor.all();
        }
        Ok(plan)
    }

    fn check(&self, path: &Path) -> Result<()> {
        let wrong = |key: String, value: &str, message: &str| {
            Err(Error::input(path.display(), key, Some(value.to_string()), message.to_string()))
        };
        if self.factors.is_empty() {
            return wrong("factor".into(), "none", "a study needs at least one [[factor]] with its levels");
        }
        let least = if self.design == Design::OneAtATime { 1 } else { 2 };
        for (i, factor) in self.factors.iter().enumerate() {
            let key = |what: &str| format!("factor[{i}].{what}");
            let levels = factor.all();
            if factor.name.is_empty() || self.factors[..i].iter().any(|other| other.name == factor.name) {
                return wrong(key("name"), &factor.name, "must be a name of its own");
            }
            if factor.key.is_some() == factor.values.is_empty() || factor.key.is_some() != factor.levels.is_empty() {
                return wrong(key("key"), &factor.name, "needs either key and values, or levels, each with name and set");
            }
            if levels.len() < least {
                return wrong(key("values"), &factor.name, "a factorial needs at least two levels of each factor");
            }
            if let Some(twice) = (1..levels.len()).find(|k| levels[..*k].iter().any(|l| l.name == levels[*k].name)) {
                return wrong(key("levels"), &levels[twice].name, "stands there twice");
            }
            if let Some(empty) = levels.iter().find(|l| l.set.is_empty()) {
                return wrong(key("levels.set"), &empty.name, "sets nothing: each level needs key=value");
            }
            if self.design == Design::Fraction && levels.len() != 2 {
                return wrong(key("levels"), &factor.name, "must have two levels in a fraction");
            }
            let known = |name: &String| self.factors.iter().any(|f| f.name == *name && f.product_of.is_empty());
            if let Some(unknown) = factor.product_of.iter().find(|name| !known(name)) {
                return wrong(key("product_of"), unknown, "must name factors without product_of");
            }
            if !factor.product_of.is_empty() && self.design != Design::Fraction {
                return wrong(key("product_of"), &factor.product_of.join(", "), "needs design = \"fraction\"");
            }
        }
        if let Some((measure, limit)) = self.tolerance.iter().find(|(_, limit)| !(**limit > 0.0 && limit.is_finite())) {
            return wrong(format!("tolerance.{}", measure.name()), &limit.to_string(), "must be above 0");
        }
        let free: Vec<usize> = self.factors.iter().filter(|f| f.product_of.is_empty()).map(|f| f.all().len()).collect();
        let runs = match self.design {
            Design::OneAtATime => free.iter().sum(),
            _ => free.iter().fold(1_usize, |n, k| n.saturating_mul(*k)),
        };
        if runs > MOST {
            return wrong("factor".into(), &runs.to_string(), &format!("gives more settings than {MOST}"));
        }
        let seeds = self.numbers()?.map_or(1, |seeds| seeds.len());
        if runs * seeds > MOST_RUNS {
            return wrong("seeds".into(), &self.seeds, &format!("gives more runs than {MOST_RUNS}"));
        }
        let settings = self.settings();
        let folders: Vec<String> = settings.iter().map(Setting::folder).collect();
        match (1..folders.len()).find(|k| folders[..*k].contains(&folders[*k])) {
            Some(twice) => wrong("factor".into(), &settings[twice].name, "has the folder of another setting: choose other names"),
            None => Ok(()),
        }
    }

    /// The seeds; `None` for a scene that draws nothing.
    ///
    /// # Errors
    /// Text that is no list of seeds.
    pub fn numbers(&self) -> Result<Option<Vec<u64>>> {
        if self.seeds == "none" { Ok(None) } else { parse_seeds(&self.seeds).map(Some) }
    }

    /// All settings, the reference first.
    pub fn settings(&self) -> Vec<Setting> {
        let levels: Vec<Vec<Level>> = self.factors.iter().map(Factor::all).collect();
        let own = self.reference.as_ref().map_or_else(Vec::new, |r| r.set.clone());
        let named = Setting {
            name: self.reference.as_ref().map_or_else(reference, |r| r.name.clone()),
            levels: vec![None; levels.len()],
            sets: [&self.set[..], &own].concat(),
            borrows: self.same_specimens,
        };
        let scene = Setting { name: SCENE.into(), sets: self.set.clone(), borrows: false, ..named.clone() };
        let lender = self.same_specimens.then_some(scene);
        if self.design == Design::OneAtATime {
            let one = |f: usize, k: usize| {
                let mut setting = named.clone();
                setting.levels[f] = Some(k);
                setting.name = format!("{} {}", self.factors[f].name, levels[f][k].name);
                setting.sets.extend_from_slice(&levels[f][k].set);
                setting
            };
            let others: Vec<Setting> =
                (0..levels.len()).flat_map(|f| (0..levels[f].len()).map(move |k| (f, k))).map(|(f, k)| one(f, k)).collect();
            return std::iter::once(named).chain(lender).chain(others).collect();
        }
        let mut rows: Vec<Vec<usize>> = vec![Vec::new()];
        for (factor, levels) in self.factors.iter().zip(&levels) {
            let count = if factor.product_of.is_empty() { levels.len() } else { 1 };
            rows = rows.iter().flat_map(|row| (0..count).map(move |k| [&row[..], &[k]].concat())).collect();
        }
        for row in &mut rows {
            for (f, factor) in self.factors.iter().enumerate().filter(|(_, f)| !f.product_of.is_empty()) {
                let of = |name: &String| self.factors.iter().position(|f| f.name == *name).map_or(0, |g| row[g]);
                // an even number of low levels is the product 1, the high one
                let low = factor.product_of.iter().filter(|name| of(name) == 0).count();
                row[f] = usize::from(low % 2 == 0);
            }
        }
        let combined = rows.into_iter().map(|row| Setting {
            name: row
                .iter()
                .enumerate()
                .map(|(f, k)| format!("{} {}", self.factors[f].name, levels[f][*k].name))
                .collect::<Vec<_>>()
                .join(", "),
            sets: row.iter().enumerate().fold(self.set.clone(), |sets, (f, k)| [&sets[..], &levels[f][*k].set].concat()),
            levels: row.into_iter().map(Some).collect(),
            borrows: self.same_specimens,
        });
        if self.reference.is_some() {
            return std::iter::once(named).chain(lender).chain(combined).collect();
        }
        let mut all: Vec<Setting> = combined.collect();
        all.splice(1..1, lender);
        all
    }

    /// The jobs of a setting, one for each seed, in `out/SETTING/seed-N`; without seeds one in `out/SETTING/run`. Those that borrow a specimen can be made only when
    /// the run that prepares it is done.
    ///
    /// # Errors
    /// Text in `seeds` that is no list of seeds.
    pub fn jobs(&self, setting: &Setting, out: &Path) -> Result<Vec<Job>> {
        let lender = out.join(Setting { name: SCENE.into(), ..setting.clone() }.folder());
        let job = |name: &str| Job {
            specimen: setting.borrows.then(|| lender.join(name).join("specimen.csv")),
            ..Job::new(self.folder.join(&self.scene), out.join(setting.folder()).join(name)).with(&setting.sets)
        };
        let Some(seeds) = self.numbers()? else { return Ok(vec![job("run")]) };
        Ok(seeds.into_iter().map(|seed| job(&format!("seed-{seed}")).seeded(Vary::Both, seed)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Plan> {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("plan.toml");
        std::fs::write(&path, text).expect("written");
        Plan::read(&path)
    }

    const HEAD: &str = "title = \"t\"\nscene = \"a.toml\"\n";
    const TWO: &str = "[[factor]]\nname = \"step\"\nkey = \"stepping.safety\"\nvalues = [0.2, 0.4]\n\
        [[factor]]\nname = \"law\"\nlevels = [{ name = \"a\", set = [\"contact.law=hertz\"] }, { name = \"b\", set = [\"contact.law=linear\"] }]\n";

    #[test]
    fn one_factor_at_a_time_leaves_the_others_as_in_the_reference() {
        let plan = read(&format!("{HEAD}set = [\"x=1\"]\n[reference]\nset = [\"stepping.safety=0.1\"]\n{TWO}")).expect("plan");
        let settings = plan.settings();
        let names: Vec<&str> = settings.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["reference", "step 0.2", "step 0.4", "law a", "law b"]);
        assert_eq!(settings[2].sets, ["x=1", "stepping.safety=0.1", "stepping.safety=0.4"]);
        assert_eq!(settings[3].levels, [None, Some(0)]);
        let jobs = plan.jobs(&settings[4], Path::new("out")).expect("jobs");
        assert_eq!((jobs.len(), jobs[0].out.display().to_string().as_str()), (5, "out/law_b/seed-1"));
    }

    #[test]
    fn specimens_are_borrowed_from_the_scene_as_it_is() {
        let plan =
            read(&format!("same_specimens = true\n{HEAD}set = [\"x=1\"]\n[reference]\nset = [\"y=2\"]\n{TWO}")).expect("plan");
        let settings = plan.settings();
        assert_eq!((settings.len(), settings[1].name.as_str(), settings[1].sets.len()), (6, "the scene", 1));
        let specimen = |k: usize| plan.jobs(&settings[k], Path::new("out")).expect("jobs")[2].specimen.clone();
        assert_eq!((specimen(1), specimen(0)), (None, Some(PathBuf::from("out/the_scene/seed-3/specimen.csv"))));
        let full = read(&format!("same_specimens = true\ndesign = \"full\"\n{HEAD}{TWO}")).expect("plan").settings();
        assert_eq!((full[0].name.as_str(), full[1].name.as_str(), full.len()), ("step 0.2, law a", "the scene", 5));
    }

    #[test]
    fn a_factorial_has_every_combination_and_a_fraction_its_part() {
        let plan = read(&format!("design = \"full\"\n{HEAD}{TWO}")).expect("plan");
        let settings = plan.settings();
        let names: Vec<&str> = settings.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["step 0.2, law a", "step 0.2, law b", "step 0.4, law a", "step 0.4, law b"]);
        let third = "[[factor]]\nname = \"third\"\nkey = \"k\"\nvalues = [1, 2]\nproduct_of = [\"step\", \"law\"]\n";
        let plan = read(&format!("design = \"fraction\"\n{HEAD}{TWO}{third}")).expect("plan");
        let levels: Vec<Vec<usize>> =
            plan.settings().iter().map(|s| s.levels.iter().map(|k| k.expect("all are set")).collect()).collect();
        assert_eq!(levels, [[0, 0, 1], [0, 1, 0], [1, 0, 0], [1, 1, 1]]);
    }

    #[test]
    fn wrong_plans_are_refused_with_their_place() {
        for (text, says) in [
            (HEAD.to_string(), "a study needs at least one [[factor]]"),
            (format!("{HEAD}{TWO}").replace("[0.2, 0.4]", "[0.2, 0.2]"), "factor[0].levels = 0.2: stands there twice"),
            (
                format!("{HEAD}{TWO}").replace("name = \"law\"", "name = \"step\""),
                "factor[1].name = step: must be a name of its own",
            ),
            (format!("{HEAD}{TWO}").replace("values = [0.2, 0.4]", ""), "factor[0].key = step: needs either key and values"),
            (format!("design = \"full\"\n{HEAD}{TWO}").replace("[0.2, 0.4]", "[0.2]"), "at least two levels"),
            (format!("seeds = \"3..1\"\n{HEAD}{TWO}"), "counts down"),
            (format!("seeds = \"1..10000\"\n{HEAD}{TWO}"), "seeds = 1..10000: gives more runs than 20000"),
            (format!("tolerance = {{ k0 = -1.0 }}\n{HEAD}{TWO}"), "tolerance.k0 = -1: must be above 0"),
            (format!("tolerance = {{ colour = 1.0 }}\n{HEAD}{TWO}"), "colour"),
            (format!("{HEAD}{TWO}product_of = [\"step\"]\n"), "needs design = \"fraction\""),
            (format!("design = \"fraction\"\n{HEAD}{TWO}product_of = [\"law\"]\n"), "must name factors without product_of"),
            (format!("{HEAD}{TWO}").replace("set = [\"contact.law=linear\"]", "set = []"), "sets nothing"),
        ] {
            let error = read(&text).expect_err(says).to_string();
            assert!(error.contains(says), "{says}: {error}");
        }
    }
}
