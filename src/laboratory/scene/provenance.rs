//! The sources of values: assumed values that no paper gives, and decisions on matters that the papers leave open.

use super::Scene;
use super::layers::join;
use super::view::View;
use serde::Serialize;
use toml::{Table, Value};

/// A value with its source: one that is assumed, or that a level of accuracy has set.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Assumption {
    /// Dotted key.
    pub key: String,
    /// Value in the unit of the key.
    pub value: Value,
    /// Source as written.
    pub source: String,
}

/// A matter that the papers leave open, and how this scene settles it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Decision {
    /// The matter, in words.
    pub matter: &'static str,
    /// The key that settles the matter; empty where the program settles it.
    pub key: &'static str,
    /// Value of the key in its unit; a text where the program settles the matter.
    pub value: Value,
}

/// Every assumed value of a scene and its materials.
pub fn assumptions(scene: &Scene) -> Vec<Assumption> {
    sourced(scene, ASSUMED)
}

/// Every assumed value of the table at `at`.
pub fn assumed_in(table: &Table, at: &str) -> Vec<Assumption> {
    let mut found = Vec::new();
    collect(table, at, ASSUMED, &mut found);
    found
}

/// Every value of a scene and its materials whose source begins with these words, in small letters.
pub fn sourced(scene: &Scene, words: &str) -> Vec<Assumption> {
    let mut found = Vec::new();
    collect(&scene.layer.table, "", words, &mut found);
    found
}

/// How the source of a value begins that no paper gives.
const ASSUMED: &str = "assumed";

fn collect(table: &Table, at: &str, words: &str, found: &mut Vec<Assumption>) {
    for (name, value) in table {
        let key = join(at, name);
        if name == "source" {
            continue;
        }
        if let Value::Table(inner) = value {
            collect(inner, &key, words, found);
            continue;
        }
        let source = match table.get("source") {
            Some(Value::String(s)) => s.as_str(),
            Some(Value::Table(by_key)) => by_key.get(name).and_then(Value::as_str).unwrap_or(""),
            _ => "",
        };
        if source.trim_start().to_lowercase().starts_with(words) {
            found.push(Assumption { key, value: value.clone(), source: source.into() });
        }
    }
}

/// Matters that keys settle. Keys that a scene does not have are left out.
const SETTLED: &[(&str, &str)] = &[
    ("wall friction", "walls.friction.bottom"),
    ("wall friction", "walls.friction.top"),
    ("wall friction", "walls.friction.cylinder"),
    ("strength draw below min_ratio", "material.strength.truncation"),
    ("strength draw below min_ratio", "material.strength.min_ratio"),
    ("strength draw below min_ratio", "materials.grain.strength.truncation"),
    ("strength draw below min_ratio", "materials.grain.strength.min_ratio"),
    ("random streams", "seed.packing"),
    ("random streams", "seed.strength"),
    ("load programme, L_C of eq. 18", "loading.rate"),
    ("load programme, eq. 18", "loading.sigma_ref_kPa"),
    ("load programme", "loading.programme"),
    ("platen servo", "loading.servo_gain"),
    ("platen servo", "test.servo_gain"),
    ("platens' contacts", "test.contact_modulus_MPa"),
    ("quasi-static, speed of the platens", "test.strain_per_wave"),
    ("shape functions", "grid.shape_functions"),
    ("transfer", "grid.transfer"),
    ("transfer", "grid.pic"),
    ("preparation, friction while growing", "preparation.growth_friction"),
    ("preparation, damping", "preparation.damping"),
    ("preparation, distance to the target porosity", "preparation.porosity_tolerance"),
    ("quasi-static, inertial number of the platen", "loading.max_inertial_number"),
    ("quasi-static, measured against target stress", "loading.max_lag"),
    ("inertia scaling", "stepping.inertia_scaling"),
    ("inertia of the points over the real one", "stepping.points_inertia"),
    ("tangential force on unloading", "contact.unloading"),
    ("rotation of grains", "contact.rotation"),
    ("daughters of a broken grain", "crushing.pattern"),
    ("azimuth of the pattern", "crushing.azimuth"),
    ("radius of the area of a Hertzian contact", "crushing.area_radius"),
    ("how daughters begin", "crushing.birth"),
    ("steps between judgements", "crushing.interval"),
    ("mass that daughters do not hold", "crushing.lost_mass"),
    ("smallest size of the lost mass", "material.fines.d_min_mm"),
    ("energy ledger", "records.energy"),
];

/// Matters that the program settles, for specimens and free scenes of grains.
const FIXED: &[(&str, &str)] = &[
    ("when grains are judged", "in loading, on the forces of the step; all that exceed break, in id order"),
    ("logarithm and increment of eq. 18", "natural, one increment per step; lower platen fixed, upper moves"),
    ("oedometer stresses", "mean platen force over area; radial force over current height"),
    ("volumes", "grains without subtracting overlaps; specimen from current walls"),
    ("a wall", "rigid: a grain meets its mirror image"),
];

/// Matters that the program settles, for single grains between platens.
const FIXED_OF_PLATENS: &[(&str, &str)] = &[
    ("when grains are judged", "every step, on that step's forces; a test ends where its grain breaks"),
    ("platens", "lower one fixed, upper one moves; without friction"),
    ("displacement", "approach of the platens, both contacts together"),
    ("force", "the larger of the two platens'"),
    ("platens without a material", "rigid: a grain meets its mirror image"),
];

/// Matters that the program settles, for tests of continua and mixtures.
const FIXED_OF_TESTS: &[(&str, &str)] = &[
    ("platens", "rigid and smooth; a point meets them with its ghost radius (Li et al. 2023, eq. 22) and Hertz's force"),
    ("where a platen's force acts", "on the point's face, half its edge beyond it (Li et al. 2023 spread it from the point)"),
    ("stresses of a test", "sum of the platens' forces over the area between the other platens; means since the row before"),
    ("extent of a specimen", "between its platens, less how far ghosts reach out of the material at the start"),
];

/// Matters that the program settles, for tests of rigid bodies without points.
const FIXED_OF_BEDS: &[(&str, &str)] = &[
    ("platens", "rigid and smooth planes at the sides of the box in which the bodies were packed"),
    ("stresses of a test", "forces on the platens over the area between the other platens; means since the row before"),
    ("wave time, for the speed", "by the modulus of a cubic lattice of equal spheres under the first stress, and the bulk density"),
    (
        "rest before the test",
        "sides within 0.5 % of the stress, mean resultant on a body below 0.01 of the mean force of a contact",
    ),
    ("void ratio", "from the volume of the bodies at the start, which breakages keep"),
];

/// Matters that the program settles, for material points.
const FIXED_OF_POINTS: &[(&str, &str)] = &[
    ("void ratio", "from the points' volumes, of a mixture from all solids in the specimen; solids stay"),
    ("plastic strain", "integral of sqrt(2/3 ep:ep)"),
];

/// Matters that the program settles, for rigid bodies that break.
const FIXED_OF_BREAKING: &[(&str, &str)] = &[
    ("when blocks are judged", "on the forces of the step; all places of one partner count as one contact"),
    (
        "how a block breaks",
        "in two, along the plane through its two largest contacts and its centre of mass, or into the cells of crushing.block_pieces; a compound into its parts, cut free of each other",
    ),
    ("size of a block", "diameter of the sphere of its volume; its gradation by the square sieve it passes"),
];

/// Every decision that holds for a scene: first those of its keys, then those of the program.
pub fn decisions(scene: &Scene) -> Vec<Decision> {
    let view = View::of(&scene.layer);
    let is = |key: &str, value: &str| view.get(key).and_then(Value::as_str) == Some(value);
    let breaks = view.get("crushing.enabled").and_then(Value::as_bool) != Some(false);
    let of_points = matches!(view.text("kind"), "continuum" | "mixture");
    let (free, without_points) = (of_points && is("test.rig", "free"), of_points && view.is_without_points());
    // beside spheres blocks do not break
    let only_blocks = of_points && view.has_blocks() && view.list("grain").is_empty();
    // what a scene has by default and does not use
    let matters = |key: &str| match key {
        "crushing.area_radius" => breaks && is("crushing.criterion", "hertz_area"),
        "crushing.pattern" | "crushing.azimuth" | "crushing.birth" | "crushing.lost_mass" => breaks && !only_blocks,
        _ if free && key.starts_with("test.") => false,
        "stepping.points_inertia" => !free && !without_points,
        "test.contact_modulus_MPa" => !without_points,
        _ if without_points && key.starts_with("grid.") => false,
        _ => breaks || !(key.starts_with("crushing.") || key.contains(".strength.") || key.contains(".fines.")),
    };
    let settled = SETTLED.iter().filter(|(_, key)| matters(key));
    let settled = settled.filter_map(|(matter, key)| view.get(key).map(|value| Decision { matter, key, value: value.clone() }));
    let platens = view.text("kind") == "platen";
    let fixed = [
        (platens, FIXED_OF_PLATENS),
        (of_points && !free && !without_points, FIXED_OF_TESTS),
        (!free && without_points, FIXED_OF_BEDS),
        (of_points && !without_points, FIXED_OF_POINTS),
        (breaks && only_blocks, FIXED_OF_BREAKING),
        (!platens && !of_points, FIXED),
    ];
    let fixed = fixed.into_iter().filter(|(used, _)| *used).flat_map(|(_, matters)| matters);
    let fixed = fixed.map(|(matter, value)| Decision { matter, key: "", value: Value::String((*value).into()) });
    settled.chain(fixed).collect()
}
