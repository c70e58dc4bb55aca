//! How accurate a test is to be: numerical keys that a level sets where the scene does not. Physical keys are never touched.

use super::Scene;
use super::layers::{Layer, Origin, shown};
use super::provenance::{Assumption, sourced};
use serde::{Serialize, Serializer};
use toml::{Table, Value};

/// What a level sets in a test, and by how much its results may differ from those of `reference`.
#[derive(Debug)]
pub struct Level {
    /// Word of the key `accuracy`.
    pub word: &'static str,
    /// What it sets.
    keys: &'static [Set],
    /// What a run of this level is held to.
    pub promise: Promise,
}

/// Largest differences from a run with `accuracy = "reference"`, as means over seeds with their intervals of 95 %, and how close to balance a run that counts as quasi-static
/// keeps its platens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promise {
    /// Of each quantity that the study of the test has measured; none for `reference` itself.
    pub differences: &'static [Difference],
    /// The study's test.
    of: &'static str,
    /// How close to balance the platens stay.
    pub platens: Platens,
}

/// The most by which the stresses on the platens may differ, over their mean, in steps above 50 kPa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Platens {
    /// In any step.
    Largest(f64),
    /// On the average of all steps: where a platen moves on whatever breaks, single steps tell of single grains.
    Mean(f64),
}

impl Platens {
    /// The difference, and its name in `summary.json`.
    fn named(self) -> (&'static str, f64) {
        match self {
            Platens::Largest(most) => ("platen_difference", most),
            Platens::Mean(most) => ("mean_platen_difference", most),
        }
    }

    /// What is allowed, in words.
    pub fn in_words(self) -> String {
        match self {
            Platens::Largest(most) => format!("the {most} of their mean"),
            Platens::Mean(most) => format!("the {most} of their mean, on the average of all steps,"),
        }
    }
}

/// The largest difference of a quantity from that of `reference`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Its name in `summary.json`.
    pub name: &'static str,
    /// The difference: over the value of `reference` where it is a share.
    pub most: f64,
    /// Words for it, after the number.
    words: &'static str,
    share: bool,
}

const fn of(name: &'static str, most: f64, words: &'static str) -> Difference {
    Difference { name, most, words, share: false }
}

const fn share(name: &'static str, most: f64, words: &'static str) -> Difference {
    Difference { name, most, words, share: true }
}

impl Promise {
    /// What is promised, in a sentence.
    pub fn in_words(&self) -> String {
        let each = |d: &Difference| {
            if d.share { format!("{:.0} % of {}", 100.0 * d.most, d.words) } else { format!("{} of {}", d.most, d.words) }
        };
        let all: Vec<String> = self.differences.iter().map(each).collect();
        match &all[..] {
            [] => "what the other levels are measured against".into(),
            [first @ .., last] => {
                format!("within {} and {last} of a run with accuracy = \"reference\" ({})", first.join(", "), self.of)
            }
        }
    }
}

impl Serialize for Promise {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let differences = self.differences.iter().map(|d| (d.name, d.most));
        serializer.collect_map(differences.chain([self.platens.named()]))
    }
}

/// Words of the key, from the coarsest.
pub const WORDS: [&str; 3] = ["draft", "standard", "reference"];

/// A table, a key in it, its value as TOML, and the reason.
type Set = (&'static str, &'static str, &'static str, &'static str);

// what levels of all tests set
const STEP: Set = ("stepping", "safety", "0.8", "half the step gives the same curve");
const HALF_STEP: Set = ("stepping", "safety", "0.4", "half the usual step");
const MORE_STEPS: Set =
    ("preparation", "max_steps", "800000", "with half the step the specimen takes more of them to come to rest");
const JUDGED_ALWAYS: Set = ("crushing", "interval", "1", "grains are judged in every step");
const JUDGED_SELDOM: Set = ("crushing", "interval", "10", "grains are judged every tenth step");

// of tests of points, where the platens move at a share of the speed of waves
const USUAL_RATE: Set = ("test", "strain_per_wave", "0.0001", "half of it changes strengths by a fifth of a percent");
const SLOW_RATE: Set = ("test", "strain_per_wave", "0.00005", "half the usual speed of the platens");
const FAST_RATE: Set = ("test", "strain_per_wave", "0.0005", "five times the usual speed of the platens");

/// Levels of the tests that have them, by the kind of the scene and, of those with points, its test.
const LEVELS: [(&str, Option<&str>, [Level; 3]); 7] = [
    ("oedometer", None, OEDOMETER),
    ("isotropic", None, ISOTROPIC),
    ("triaxial", None, TRIAXIAL),
    ("continuum", Some("oedometer"), OEDOMETER_OF_POINTS),
    ("continuum", Some("triaxial"), TRIAXIAL_OF_POINTS),
    ("mixture", Some("oedometer"), OEDOMETER_OF_POINTS),
    ("mixture", Some("triaxial"), TRIAXIAL_OF_POINTS),
];

const OF_OEDOMETER: &str = "coke to 1 MPa, mean of ten seeds";

/// By `experiments/studies/accuracy.toml`.
const OEDOMETER: [Level; 3] = [
    Level {
        word: "draft",
        keys: &[
            STEP,
            ("loading", "programme", "\"adaptive\"", "the stress rises while the specimen is in balance"),
            ("loading", "pace", "0.01", "five times the usual share of the stress in a step"),
            ("loading", "max_inertial_number", "0.004", "five times the usual speed of the platen"),
            ("loading", "inertial_number", "0.0015", "five times the usual speed of the platen"),
            ("loading", "max_lag", "0.05", "platens within 5 % of the target"),
            JUDGED_SELDOM,
        ],
        promise: Promise {
            differences: &[
                of("porosity", 0.01, "the porosity"),
                share("crush_events", 0.25, "the breakages"),
                of("k0", 0.08, "k0"),
            ],
            of: OF_OEDOMETER,
            platens: Platens::Largest(0.15),
        },
    },
    Level {
        word: "standard",
        keys: &[
            STEP,
            ("loading", "programme", "\"adaptive\"", "0.6 of the steps of eq. 18, and nowhere seen to differ from it"),
            ("loading", "pace", "0.002", "the platens stay in balance"),
            ("loading", "max_inertial_number", "0.0008", "0.002 and more give more breakages"),
            ("loading", "inertial_number", "0.0003", "well below 0.001, where loading is quasi-static"),
            ("loading", "max_lag", "0.015", "platens within 1.5 % of the target"),
            JUDGED_ALWAYS,
        ],
        promise: Promise {
            differences: &[
                of("porosity", 0.005, "the porosity"),
                share("crush_events", 0.2, "the breakages"),
                of("k0", 0.04, "k0"),
            ],
            of: OF_OEDOMETER,
            platens: Platens::Largest(0.1),
        },
    },
    Level {
        word: "reference",
        keys: &[
            HALF_STEP,
            MORE_STEPS,
            ("loading", "programme", "\"adaptive\"", "the stress rises while the specimen is in balance"),
            ("loading", "pace", "0.0005", "a quarter of the usual share of the stress in a step"),
            ("loading", "max_inertial_number", "0.0004", "half the usual speed of the platen"),
            ("loading", "inertial_number", "0.00015", "half the usual speed of the platen"),
            ("loading", "max_lag", "0.005", "platens within 0.5 % of the target"),
            JUDGED_ALWAYS,
        ],
        promise: Promise { differences: &[], of: OF_OEDOMETER, platens: Platens::Largest(0.06) },
    },
];

const OF_ISOTROPIC: &str = "coke to 1 MPa on all sides, mean of ten seeds";

/// By `experiments/studies/accuracy_isotropic.toml`.
const ISOTROPIC: [Level; 3] = [
    Level {
        word: "draft",
        keys: &[
            STEP,
            ("loading", "pace", "0.01", "five times the usual share of the stress in a step"),
            ("loading", "max_inertial_number", "0.004", "five times the usual speed of the platen"),
            ("loading", "max_lag", "0.05", "platens within 5 % of the target"),
            JUDGED_SELDOM,
        ],
        promise: Promise {
            differences: &[of("porosity", 0.006, "the porosity"), share("crush_events", 0.25, "the breakages")],
            of: OF_ISOTROPIC,
            platens: Platens::Mean(0.045),
        },
    },
    Level {
        word: "standard",
        keys: &[
            STEP,
            ("loading", "pace", "0.002", "the platens stay in balance"),
            ("loading", "max_inertial_number", "0.0008", "as in the oedometer"),
            ("loading", "max_lag", "0.015", "platens within 1.5 % of the target"),
            JUDGED_ALWAYS,
        ],
        promise: Promise {
            differences: &[of("porosity", 0.006, "the porosity"), share("crush_events", 0.15, "the breakages")],
            of: OF_ISOTROPIC,
            platens: Platens::Mean(0.02),
        },
    },
    Level {
        word: "reference",
        keys: &[
            HALF_STEP,
            MORE_STEPS,
            ("loading", "pace", "0.0005", "a quarter of the usual share of the stress in a step"),
            ("loading", "max_inertial_number", "0.0004", "half the usual speed of the platen"),
            ("loading", "max_lag", "0.005", "platens within 0.5 % of the target"),
            JUDGED_ALWAYS,
        ],
        promise: Promise { differences: &[], of: OF_ISOTROPIC, platens: Platens::Mean(0.01) },
    },
];

const OF_TRIAXIAL: &str = "coke at 300 kPa to 10 % axial strain, mean of ten seeds";

/// By `experiments/studies/accuracy_triaxial.toml`.
const TRIAXIAL: [Level; 3] = [
    Level {
        word: "draft",
        keys: &[STEP, ("loading", "inertial_number", "0.001", "three times the usual speed of the platen"), JUDGED_SELDOM],
        promise: Promise {
            differences: &[
                share("residual_strength", 0.11, "q/p in the last half of the test"),
                share("crush_events", 0.15, "the breakages"),
                of("void_ratio", 0.011, "the void ratio at the end"),
            ],
            of: OF_TRIAXIAL,
            platens: Platens::Mean(0.06),
        },
    },
    Level {
        word: "standard",
        keys: &[STEP, ("loading", "inertial_number", "0.0003", "well below 0.001, where shearing is quasi-static"), JUDGED_ALWAYS],
        promise: Promise {
            differences: &[
                share("residual_strength", 0.1, "q/p in the last half of the test"),
                share("crush_events", 0.1, "the breakages"),
                of("void_ratio", 0.011, "the void ratio at the end"),
            ],
            of: OF_TRIAXIAL,
            platens: Platens::Mean(0.025),
        },
    },
    Level {
        word: "reference",
        keys: &[
            HALF_STEP,
            MORE_STEPS,
            ("loading", "inertial_number", "0.0001", "a third of the usual speed of the platen"),
            JUDGED_ALWAYS,
        ],
        promise: Promise { differences: &[], of: OF_TRIAXIAL, platens: Platens::Mean(0.01) },
    },
];

/// Levels of a test of points, alone or with coarse grains: its platens' speed and its step. What `draft` and `standard` promise, and how far the platens' stresses may differ.
const fn of_points(draft: Promise, standard: Promise, reference: Platens) -> [Level; 3] {
    let promise = Promise { differences: &[], of: standard.of, platens: reference };
    [
        Level { word: "draft", keys: &[STEP, FAST_RATE], promise: draft },
        Level { word: "standard", keys: &[STEP, USUAL_RATE], promise: standard },
        Level { word: "reference", keys: &[HALF_STEP, SLOW_RATE], promise },
    ]
}

const OF_OEDOMETER_OF_POINTS: &str = "points alone, and with a fifth of coarse grains, mean of three seeds";

/// By `experiments/studies/accuracy_continuum_oedometer.toml` and `accuracy_mixture_oedometer.toml`.
const OEDOMETER_OF_POINTS: [Level; 3] = of_points(
    Promise {
        differences: &[share("largest_stress", 0.03, "the largest stress"), of("k0", 0.01, "k0")],
        of: OF_OEDOMETER_OF_POINTS,
        platens: Platens::Largest(0.04),
    },
    Promise {
        differences: &[share("largest_stress", 0.01, "the largest stress"), of("k0", 0.005, "k0")],
        of: OF_OEDOMETER_OF_POINTS,
        platens: Platens::Largest(0.01),
    },
    Platens::Largest(0.005),
);

const OF_TRIAXIAL_OF_POINTS: &str = "points alone, and with a fifth of coarse grains, at 50 kPa, mean of three seeds";

/// By `experiments/studies/accuracy_continuum_triaxial.toml` and `accuracy_mixture_triaxial.toml`.
const TRIAXIAL_OF_POINTS: [Level; 3] = of_points(
    Promise {
        differences: &[
            share("peak_strength", 0.02, "the peak of σ₁/σ₃"),
            share("residual_strength", 0.03, "σ₁/σ₃ at the end"),
            of("void_ratio", 0.015, "the void ratio at the end"),
        ],
        of: OF_TRIAXIAL_OF_POINTS,
        platens: Platens::Largest(0.04),
    },
    Promise {
        differences: &[
            share("peak_strength", 0.01, "the peak of σ₁/σ₃"),
            share("residual_strength", 0.01, "σ₁/σ₃ at the end"),
            of("void_ratio", 0.01, "the void ratio at the end"),
        ],
        of: OF_TRIAXIAL_OF_POINTS,
        platens: Platens::Largest(0.01),
    },
    Platens::Largest(0.005),
);

impl Level {
    /// The level of a word for a kind of scene and, of those with points, its test (`test.rig`); `None` where there is none.
    pub fn of(kind: &str, rig: &str, word: &str) -> Option<&'static Level> {
        let (.., levels) = LEVELS.iter().find(|(name, test, _)| *name == kind && test.is_none_or(|test| test == rig))?;
        levels.iter().find(|level| level.word == word)
    }

    /// Whether it allows this difference of the platens' stresses, over their mean: the largest, or the mean.
    pub fn allows(&self, found: f64) -> bool {
        let (_, most) = self.promise.platens.named();
        found <= most
    }

    /// The entry `accuracy` of a summary: what the level promises, how far the platens' stresses have differed, and whether that is as close to balance as it asks for; `None`: nobody knows.
    pub fn against(&self, found: f64, kept: Option<bool>) -> serde_json::Value {
        let name = match self.promise.platens {
            Platens::Largest(_) => "largest_platen_difference",
            Platens::Mean(_) => "mean_platen_difference",
        };
        serde_json::json!({ "level": self.word, "promise": self.promise, name: found, "kept": kept })
    }

    /// What a run is warned of whose platens have not been so close to balance.
    pub fn warning(&self) -> String {
        format!(
            "the stresses on the platens differed by more than {} that accuracy = \"{}\" allows: load more slowly, or ask for more accuracy",
            self.promise.platens.in_words(),
            self.word
        )
    }
}

/// How the source of a value begins that a level has set.
const SET: &str = "set by accuracy";

/// The level of a scene, and those of its keys that the scene uses.
fn asked(scene: &Table) -> Option<(&'static Level, Vec<&'static Set>)> {
    let word = |key: &str| scene.get(key).and_then(Value::as_str);
    let rig = scene.get("test").and_then(|test| test.get("rig")).and_then(Value::as_str).unwrap_or("");
    let level = Level::of(word("kind")?, rig, word("accuracy")?)?;
    let breaks = scene.get("crushing").and_then(|c| c.get("enabled")).and_then(Value::as_bool) == Some(true);
    Some((level, level.keys.iter().filter(|(table, ..)| breaks || *table != "crushing").collect()))
}

/// Sets the keys of the scene's level that it does not have itself. A word that is no level is refused later, with what is allowed.
pub fn fill(layer: &mut Layer) {
    let Some((level, keys)) = asked(&layer.table) else { return };
    for (table, key, value, why) in keys {
        let entry = layer.table.entry(*table).or_insert_with(|| Value::Table(Table::new()));
        let Some(values) = entry.as_table_mut().filter(|values| !values.contains_key(*key)) else { continue };
        values.insert((*key).into(), value.parse().expect("a value in TOML"));
        if let Value::Table(sources) = values.entry("source").or_insert_with(|| Value::Table(Table::new())) {
            sources.insert((*key).into(), Value::String(format!("{SET} = \"{}\": {why}", level.word)));
        }
        let place = format!("accuracy = \"{}\"", level.word);
        layer.note(&format!("{table}.{key}"), Origin { place, key: format!("{table}.{key}") });
    }
}

/// What the level of a scene has set, with the reasons; empty for a scene without one.
pub fn set_by_accuracy(scene: &Scene) -> Vec<Assumption> {
    let mut found = sourced(scene, SET);
    for value in &mut found {
        value.source = value.source.split_once(": ").map_or("", |(_, why)| why).to_string();
    }
    found
}

/// A key of a level that the scene sets itself, otherwise than the level would.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Overruled {
    /// Dotted key.
    pub key: String,
    /// The scene's value, in the unit of the key.
    pub value: Value,
    /// The level's value.
    pub level: Value,
}

/// The keys of a scene's level that the scene sets otherwise: no study has measured what the level promises with them.
pub fn accuracy_overruled(scene: &Scene) -> Vec<Overruled> {
    let table = &scene.layer.table;
    let own = |(of, key, wanted, _): &Set| {
        let value = table.get(*of)?.get(*key)?;
        let level: Value = wanted.parse().expect("a value in TOML");
        (shown(value) != shown(&level)).then(|| Overruled { key: format!("{of}.{key}"), value: value.clone(), level })
    };
    asked(table).into_iter().flat_map(|(_, keys)| keys).filter_map(own).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::from_text;

    const SCENE: &str = "kind = \"oedometer\"\nmaterial = \"materials/petroleum_coke.toml\"\naccuracy = \"draft\"\n\
        [specimen]\ngrains = 300\ndiameter_mm = 100.0\nporosity = 0.42\n[loading]\nmax_stress_kPa = 500.0\n";

    fn scene(sets: &[&str]) -> crate::error::Result<Scene> {
        let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
        from_text(SCENE, concat!(env!("CARGO_MANIFEST_DIR"), "/../.."), &sets)
    }

    #[test]
    fn a_level_sets_what_the_scene_does_not() {
        let of = |sets: &[&str]| {
            let found = set_by_accuracy(&scene(sets).expect("a scene"));
            found.iter().map(|a| format!("{}={}", a.key, a.value)).collect::<Vec<_>>()
        };
        let draft = of(&[]);
        assert_eq!(draft.len(), 6, "{draft:?}");
        assert!(draft.contains(&"loading.pace=0.01".to_string()), "{draft:?}");
        let own = of(&["loading.pace=0.003", "crushing.enabled=true"]);
        assert!(own.iter().all(|set| !set.starts_with("loading.pace")) && own.contains(&"crushing.interval=10".into()), "{own:?}");
        let despite = |sets: &[&str]| {
            let found = accuracy_overruled(&scene(sets).expect("a scene"));
            found.iter().map(|a| format!("{}={} for {}", a.key, a.value, a.level)).collect::<Vec<_>>()
        };
        assert_eq!(despite(&["loading.pace=0.003"]), ["loading.pace=0.003 for 0.01"]);
        assert!(despite(&[]).is_empty() && despite(&["loading.pace=0.01"]).is_empty());
        assert!(of(&["accuracy=reference"]).contains(&"stepping.safety=0.4".to_string()));
    }

    /// A test of points has the speed of its platens and its step from its level; where nothing is tested there is none.
    #[test]
    fn tests_of_points_have_levels() {
        let of = |rig: &str, word: &str| {
            let text = format!(
                "kind = \"continuum\"\naccuracy = \"{word}\"\n[material]\nbase = \"materials/li2023_fines.toml\"\n\
                [[body]]\nshape = \"box\"\nmin_mm = [0.0, 0.0, 0.0]\nmax_mm = [30.0, 30.0, 30.0]\nporosity = 0.37\nstress_kPa = 20.0\n\
                [grid]\ncell_mm = 5.0\n[test]\nrig = \"{rig}\"\naxial_strain = 0.01\n"
            );
            let found = from_text(&text, concat!(env!("CARGO_MANIFEST_DIR"), "/../.."), &[]).expect("a scene");
            set_by_accuracy(&found).iter().map(|a| format!("{}={}", a.key, a.value)).collect::<Vec<_>>()
        };
        assert_eq!(of("oedometer", "draft"), ["stepping.safety=0.8", "test.strain_per_wave=0.0005"]);
        assert_eq!(of("oedometer", "reference"), ["stepping.safety=0.4", "test.strain_per_wave=0.00005"]);
    }

    /// Mixtures of grains alone have no levels: no study has measured them.
    #[test]
    fn mixtures_without_points_have_no_levels() {
        let told = |name: &str| {
            let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/mixture").join(name);
            let scene = crate::scene::load(path, &["accuracy=draft".into()]).expect("a scene");
            crate::scene::model(&scene).err().map(|e| e.to_string())
        };
        assert_eq!(told("twin_points.toml"), None);
        assert!(told("twin_grains.toml").is_some_and(|told| told.contains("accuracy")));
    }

    #[test]
    fn a_word_that_is_no_level_is_refused_with_those_that_are() {
        let told = scene(&["accuracy=fast"]).expect_err("no level").to_string();
        assert!(WORDS.iter().all(|word| told.contains(word)), "{told}");
    }

    #[test]
    fn levels_have_the_words_of_the_key_and_get_stricter() {
        for (kind, rig, levels) in &LEVELS {
            assert_eq!(levels.each_ref().map(|level| level.word), WORDS, "{kind}");
            for pair in levels.windows(2) {
                let [a, b] = [pair[0].promise, pair[1].promise];
                let (x, y) = (a.platens.named(), b.platens.named());
                assert!(x.0 == y.0 && x.1 > y.1, "{kind}");
                for (a, b) in a.differences.iter().zip(b.differences) {
                    // ten seeds of the other tests cannot tell all differences of their levels apart
                    let stricter = a.most > b.most || *kind != "oedometer" && a.name != "crush_events" && a.most == b.most;
                    assert!(a.name == b.name && stricter, "{kind} {}", a.name);
                }
            }
            let names = |word| Level::of(kind, rig.unwrap_or(""), word).map(|level| level.promise.differences.len());
            assert_eq!(names("draft"), names("standard"), "{kind}");
            assert_eq!(names("reference"), Some(0), "{kind}");
        }
    }

    /// Every test of a specimen of grains has levels, and what they set are keys of that test.
    #[test]
    fn every_test_of_a_specimen_has_levels() {
        for (kind, loading) in
            [("isotropic", "[loading]\nmax_stress_kPa = 500.0\n"), ("triaxial", "[loading]\naxial_strain = 0.1\n")]
        {
            for word in WORDS {
                let text = SCENE.replace("oedometer", kind).replace("draft", word);
                let text = text[..text.find("[loading]").expect("a table")].to_string() + loading;
                let text = text.replace("[loading]", "isotropic_stress_kPa = 100.0\n[loading]");
                let scene = from_text(&text, concat!(env!("CARGO_MANIFEST_DIR"), "/../.."), &[]).expect("a scene");
                let unbroken = Level::of(kind, "", word).expect("a level").keys.iter().filter(|(table, ..)| *table != "crushing");
                assert_eq!(set_by_accuracy(&scene).len(), unbroken.count(), "{kind} {word}");
            }
        }
    }
}
