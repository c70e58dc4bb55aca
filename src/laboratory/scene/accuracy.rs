//! How accurate a test is to be: numerical keys that a level sets where the scene does not. Physical keys are never touched.

use super::Scene;
use super::layers::{Layer, Origin};
use super::provenance::{Assumption, sourced};
use toml::{Table, Value};

/// What a level sets, and by how much its results may differ from those of `reference`.
#[derive(Debug)]
pub struct Level {
    /// Word of the key `accuracy`.
    pub word: &'static str,
    /// Table, key, value as TOML, and the reason.
    keys: &'static [(&'static str, &'static str, &'static str, &'static str)],
    /// What a run of this level is held to.
    pub promise: Promise,
}

/// Largest differences from a run with `accuracy = "reference"`, as means over ten seeds with their intervals of 95 % (`experiments/studies/accuracy.toml`), and the largest difference of the platens'
/// stresses at which a run still counts as quasi-static.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Promise {
    /// Of the porosity along the logarithm of the stress, root mean square.
    pub porosity: f64,
    /// Of the number of breakages, over it.
    pub crush_events: f64,
    /// Of k0 at the end.
    pub k0: f64,
    /// Of the stresses on the platens from each other, over their mean, in any step above 50 kPa.
    pub platen_difference: f64,
}

impl Promise {
    /// What is promised, in a sentence.
    pub fn in_words(&self) -> String {
        if self.crush_events == 0.0 {
            return "what the other levels are measured against".into();
        }
        format!(
            "within {} of the porosity, {:.0} % of the breakages and {} of k0 of a run with accuracy = \"reference\" (coke to 1 MPa, mean of ten seeds)",
            self.porosity,
            100.0 * self.crush_events,
            self.k0
        )
    }
}

/// Words of the key, from the coarsest.
pub const WORDS: [&str; 3] = ["draft", "standard", "reference"];

const LEVELS: [Level; 3] = [
    Level {
        word: "draft",
        keys: &[
            ("stepping", "safety", "0.8", "half the step gives the same curve"),
            ("loading", "programme", "\"adaptive\"", "the stress rises while the specimen is in balance"),
            ("loading", "pace", "0.01", "five times the usual share of the stress in a step"),
            ("loading", "max_inertial_number", "0.004", "five times the usual speed of the platen"),
            ("loading", "inertial_number", "0.0015", "five times the usual speed of the platen"),
            ("loading", "max_lag", "0.05", "platens within 5 % of the target"),
            ("crushing", "interval", "10", "grains are judged every tenth step"),
        ],
        promise: Promise { porosity: 0.01, crush_events: 0.25, k0: 0.08, platen_difference: 0.15 },
    },
    Level {
        word: "standard",
        keys: &[
            ("stepping", "safety", "0.8", "half the step gives the same curve"),
            ("loading", "programme", "\"adaptive\"", "0.6 of the steps of eq. 18, and nowhere seen to differ from it"),
            ("loading", "pace", "0.002", "the platens stay in balance"),
            ("loading", "max_inertial_number", "0.0008", "0.002 and more give more breakages"),
            ("loading", "inertial_number", "0.0003", "well below 0.001, where loading is quasi-static"),
            ("loading", "max_lag", "0.015", "platens within 1.5 % of the target"),
            ("crushing", "interval", "1", "grains are judged in every step"),
        ],
        promise: Promise { porosity: 0.005, crush_events: 0.2, k0: 0.04, platen_difference: 0.1 },
    },
    Level {
        word: "reference",
        keys: &[
            ("stepping", "safety", "0.4", "half the usual step"),
            ("preparation", "max_steps", "800000", "with half the step the specimen takes more of them to come to rest"),
            ("loading", "programme", "\"adaptive\"", "the stress rises while the specimen is in balance"),
            ("loading", "pace", "0.0005", "a quarter of the usual share of the stress in a step"),
            ("loading", "max_inertial_number", "0.0004", "half the usual speed of the platen"),
            ("loading", "inertial_number", "0.00015", "half the usual speed of the platen"),
            ("loading", "max_lag", "0.005", "platens within 0.5 % of the target"),
            ("crushing", "interval", "1", "grains are judged in every step"),
        ],
        promise: Promise { porosity: 0.0, crush_events: 0.0, k0: 0.0, platen_difference: 0.06 },
    },
];

impl Level {
    /// The level of a word; `None` where it is none.
    pub fn of(word: &str) -> Option<&'static Level> {
        LEVELS.iter().find(|level| level.word == word)
    }
}

/// How the source of a value begins that a level has set.
const SET: &str = "set by accuracy";

/// Sets the keys of the scene's level that it does not have itself. A word that is no level is refused later, with what is allowed.
pub fn fill(layer: &mut Layer) {
    let word = |key: &str| layer.table.get(key).and_then(Value::as_str);
    let Some(level) = word("accuracy").filter(|_| word("kind") == Some("oedometer")).and_then(Level::of) else { return };
    let breaks = layer.table.get("crushing").and_then(|c| c.get("enabled")).and_then(Value::as_bool) == Some(true);
    for (table, key, value, why) in level.keys {
        if *table == "crushing" && !breaks {
            continue;
        }
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
        assert!(of(&["accuracy=reference"]).contains(&"stepping.safety=0.4".to_string()));
    }

    #[test]
    fn a_word_that_is_no_level_is_refused_with_those_that_are() {
        let told = scene(&["accuracy=fast"]).expect_err("no level").to_string();
        assert!(WORDS.iter().all(|word| told.contains(word)), "{told}");
    }

    #[test]
    fn levels_have_the_words_of_the_key_and_get_stricter() {
        assert_eq!(LEVELS.each_ref().map(|level| level.word), WORDS);
        for pair in LEVELS.windows(2) {
            let [a, b] = [pair[0].promise, pair[1].promise];
            assert!(a.porosity > b.porosity && a.crush_events > b.crush_events && a.platen_difference > b.platen_difference);
        }
    }
}
