//! The table of all keys of scenes and materials: for each key the allowed values, the default, the kinds of scenes that have the
//! key, and its meaning. `comminute check --keys` prints it.

use super::accuracy::WORDS;
use super::schema::{Default, KIND_WORDS, Key, Of, Range, Shape};

use engine::breakage::Criterion;
use engine::contact::ContactLaw;
use engine::mpm::law::Law;
use engine::parameter::Parameter;
use std::collections::{HashMap, HashSet};
use std::sync::LazyLock;

use Default::{Absent, ByKind, Is, Required};
use Shape::{Choice, Flag, Indices, IndicesOr, Integer, Name, Number, NumberOr, Numbers, Points, Text, Words};

const ANY: Range = Range::ANY;
const POSITIVE: Range = Range::POSITIVE;
const NOT_NEGATIVE: Range = Range::NOT_NEGATIVE;
const COUNT: Shape = Integer { low: 1, high: 1_000_000_000_000 };
const STEPS: Shape = Integer { low: 0, high: 1_000_000 };
const FROM_ZERO: Shape = Integer { low: 0, high: i64::MAX };
const VECTOR: Shape = Numbers(ANY, Some(3));
const RATIO: Range = Range::below(0.0, 1.0);
const WALL: Shape = Choice(&["open", "symmetry", "stick", "slip", "coulomb"]);
const WALL_WHAT: &str = "side of the grid. open: no wall, and a point that gets there ends the run; symmetry: a smooth wall from which the material cannot part; stick: a rough wall on which the material cannot move; slip: a smooth wall that only pushes; coulomb: a wall that only pushes, with friction";
const FRICTION: Range = Range::closed(0.0, 100.0);
const DEGREES: Range = Range::below(0.0, 89.0);
const RADIANS: Range = Range::below(0.0, 1.55);
const EVOLUTION: Shape = Choice(&["linear", "cubic_exponential"]);
const VARIATION: Range = Range::closed(0.0, 10.0);
const VARIATION_WHAT: &str =
    "coefficient of variation of the limit strength, for distribution = \"normal\"; Weibull's follows from m";
const MODULUS_WHAT: &str = "Weibull modulus, eq. 7";
const QUOTED: Shape = Choice(&["mean", "survival_37"]);
const QUOTED_WHAT: &str = "which value of many grains of one size `crushing_stress_MPa` is. mean: their mean; survival_37: the stress that 37 % (1/e) of them survive, as Weibull plots give it";

// Each function below makes a key of the group of scenes that the function is named after; `Of` says which kinds are in a group.

const fn both(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { path, shape, default, of: Of::Both, what }
}

const fn every(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::Every, ..both(path, shape, default, what) }
}

const fn grain_crushing(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::GrainCrushing, ..both(path, shape, default, what) }
}

const fn oedometer(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::Oedometer, ..both(path, shape, default, what) }
}

const fn compression(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::Compression, ..both(path, shape, default, what) }
}

const fn cylinder(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::Cylinder, ..both(path, shape, default, what) }
}

const fn tests(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::Tests, ..both(path, shape, default, what) }
}

const fn triaxial(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::Triaxial, ..both(path, shape, default, what) }
}

const fn assembly(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::Assembly, ..both(path, shape, default, what) }
}

const fn states(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::States, ..both(path, shape, default, what) }
}

const fn grains(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::Grains, ..both(path, shape, default, what) }
}

const fn free(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::Free, ..both(path, shape, default, what) }
}

const fn listed(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::Listed, ..both(path, shape, default, what) }
}

const fn prepared(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::Prepared, ..both(path, shape, default, what) }
}

const fn mixture(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::Mixture, ..both(path, shape, default, what) }
}

const fn fines(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::Fines, ..both(path, shape, default, what) }
}

const fn continuum(path: &'static str, shape: Shape, default: Default, what: &'static str) -> Key {
    Key { of: Of::Continuum, ..both(path, shape, default, what) }
}

/// Tables that a scene or material may leave out: their required keys are required only where the table is written, and their
/// defaults are filled in only there. Tables of strengths are optional too ([`is_optional`]).
const OPTIONAL_TABLES: &[&str] = &[
    "material",
    "material.elastic",
    "material.linear",
    "material.gradation",
    "material.strength",
    "material.comminution",
    "material.fines",
    "material.continuum",
    "material.continuum.friction_evolution",
    "material.continuum.cohesion_evolution",
];

/// Names of the tables that are written as lists, one entry each (`[[grain]]`).
pub const LIST_TABLES: &[&str] = &["grain", "wall", "calibrate", "body", "block", "block.part", "block_set", "joint"];

/// Pairs of keys of one table that exclude each other: where a file or an override sets one of a pair, the other one is removed
/// from what it is laid over (the base of a file, the file under an override). Both stay where one file sets both; what uses them
/// may refuse that.
pub const RIVALS: &[(&str, &str)] = &[
    ("G_GPa", "E_GPa"),
    ("G_MPa", "E_MPa"),
    ("E_MPa", "kappa"),
    ("friction_angle_deg", "friction_angle_rad"),
    ("dilation_angle_deg", "dilation_angle_rad"),
    ("last_deg", "last_rad"),
    ("peak_deg", "peak_rad"),
    ("residual_deg", "residual_rad"),
    ("friction_angle_rad", "friction"),
    ("sigma_lim0_MPa", "sigma_c_MPa"),
    ("sigma_lim0_MPa", "sigma_t_MPa"),
    ("sigma_lim0_MPa", "crushing_stress_MPa"),
    ("sigma_lim0_MPa", "crushing_stress_is"),
    ("sigma_c_MPa", "crushing_stress_MPa"),
    ("sigma_c_MPa", "crushing_stress_is"),
    ("sigma_t_MPa", "crushing_stress_MPa"),
    ("sigma_t_MPa", "crushing_stress_is"),
    ("steps", "duration_s"),
    ("grain", "grains_csv"),
    ("grains", "dry_mass_g"),
    ("porosity", "void_ratio"),
    ("porosity", "height_mm"),
    ("void_ratio", "height_mm"),
    ("relative_density", "porosity"),
    ("relative_density", "void_ratio"),
    ("relative_density", "height_mm"),
    ("material", "materials"),
    ("criterion", "area"),
];

/// All keys of scenes and materials, in the order in which `scene.resolved.toml` lists them. The parameters that contact laws and
/// failure criteria declare are among them.
pub static KEYS: LazyLock<Vec<Key>> = LazyLock::new(assembled);

/// All keys: those of [`OWN`], and one for each parameter that a contact law or a failure criterion declares. The help texts of the
/// keys that choose a law or a criterion are joined from the descriptions of the words.
fn assembled() -> Vec<Key> {
    let mut keys = OWN.to_vec();
    let meanings: Vec<String> = ContactLaw::ALL.iter().map(|law| format!("{}: {}", law.word(), law.meaning())).collect();
    let named = |words: &[&str], meanings: &[&str]| -> Vec<String> {
        words.iter().zip(meanings).map(|(word, meaning)| format!("{word}: {meaning}")).collect()
    };
    let criteria = named(Criterion::WORDS, Criterion::MEANINGS);
    let laws = named(Law::WORDS, Law::MEANINGS);
    for (path, what) in [("contact.law", meanings), ("crushing.criterion", criteria), ("material.continuum.law", laws)] {
        for key in keys.iter_mut().filter(|key| key.path == path) {
            key.what = what.join("; ").leak();
        }
    }
    for law in ContactLaw::ALL {
        declare(&mut keys, law.table().parameters, "material.contact.friction_angle_rad");
    }
    for (word, parameters) in Criterion::WORDS.iter().zip(Criterion::PARAMETERS) {
        strengths(&mut keys, word);
        declare(&mut keys, parameters, COMMINUTION);
    }
    keys
}

/// The key of [`OWN`] before which new tables of strengths are inserted.
const COMMINUTION: &str = "material.comminution.d_limit_over_d50";

/// Adds the keys of strength, `sigma_lim0_MPa` to `var`, to the table `material.strength.<word>` of the criterion `word`, if they
/// are not there. Only criteria that judge the mean stress need this: [`OWN`] has the keys of `fixed_angle` and `hertz_area`, with
/// help texts of their own.
fn strengths(keys: &mut Vec<Key>, word: &str) {
    let path = |name: &str| -> &'static str { format!("material.strength.{word}.{name}").leak() };
    if keys.iter().any(|key| key.path == path("m")) {
        return;
    }
    let place = keys.iter().position(|key| key.path == COMMINUTION).unwrap_or(keys.len());
    keys.splice(
        place..place,
        [
            every(
                path("sigma_lim0_MPa"),
                Number(POSITIVE),
                Absent,
                "mean strength of a grain of diameter d0 in uniaxial compression, of its mean stress: 6/pi = 1.91 times F/d^2 of a single-grain test; or `crushing_stress_MPa`",
            ),
            every(
                path("crushing_stress_MPa"),
                Number(POSITIVE),
                Absent,
                "F/d^2 of grains of diameter d0 crushed between flat platens, as laboratories give it. With `crushing_stress_is`",
            ),
            every(path("crushing_stress_is"), QUOTED, Absent, QUOTED_WHAT),
            every(path("m"), Number(POSITIVE), Required, MODULUS_WHAT),
            every(path("var"), Number(VARIATION), Absent, VARIATION_WHAT),
        ],
    );
}

/// Whether a scene or a material may leave out the table `path`.
pub fn is_optional(path: &str) -> bool {
    OPTIONAL_TABLES.contains(&path) || path.starts_with("material.strength.")
}

/// Adds a key for each of the parameters, as the last key of its table. A new table is inserted before the key `anchor`.
fn declare(keys: &mut Vec<Key>, parameters: &[Parameter], anchor: &str) {
    for parameter in parameters {
        let path = format!("material.{}", parameter.key);
        if keys.iter().any(|key| key.path == path) {
            continue; // another law has declared the same parameter
        }
        let key = every(path.leak(), Number(parameter.range), parameter.default.map_or(Absent, Is), parameter.meaning);
        let last = keys.iter().rposition(|other| other.split().0 == key.split().0).map(|k| k + 1);
        let place = last.or(keys.iter().position(|other| other.path == anchor)).unwrap_or(keys.len());
        keys.insert(place, key);
    }
}

/// The keys that are written down here. [`assembled`] adds the parameters of contact laws and failure criteria, and the strengths
/// of the criteria that judge the mean stress.
const OWN: &[Key] = &[
    every(
        "kind",
        Choice(&KIND_WORDS),
        Required,
        "what is done: one-dimensional compression, drained triaxial compression, compression from all sides, a free scene, single grains crushed between platens, a continuum of material points, or grains in one",
    ),
    every("name", Name, Absent, "name in legends and records; the file's own name if not written"),
    every("description", Text, Is("\"\""), "one line about the scene"),
    tests(
        "accuracy",
        Choice(&WORDS),
        Absent,
        "sets the numerical keys that the scene does not set itself, never a physical one: draft, for a first look; standard; reference, to measure the others against. `check` says what it sets and why",
    ),
    free("gravity_m_s2", VECTOR, Is("[0, 0, 0]"), "gravity"),
    free("duration_s", Number(POSITIVE), Absent, "time simulated; or `steps`"),
    free("steps", COUNT, Absent, "steps simulated; or `duration_s`"),
    assembly(
        "grains_csv",
        Text,
        Absent,
        "grains from a file with x_m,y_m,z_m,r_m (or _mm, or x,y,z,r in m) and optional vx_m_s…, wx_rad_s…, material; or [[grain]]",
    ),
    listed("grain.position_m", VECTOR, Required, "centre"),
    listed("grain.radius_m", Number(POSITIVE), Required, "radius"),
    listed("grain.velocity_m_s", VECTOR, Is("[0, 0, 0]"), "velocity"),
    listed("grain.spin_rad_s", VECTOR, Is("[0, 0, 0]"), "angular velocity"),
    listed("grain.material", Text, Absent, "name of one of `materials`; needed when there are several"),
    listed(
        "wall.kind",
        Choice(&["plane", "cylinder", "box"]),
        Required,
        "shape: a plane, an upright cylinder around the grains, or six planes around them",
    ),
    listed("wall.point_m", VECTOR, Absent, "plane: a point on it"),
    listed("wall.normal", VECTOR, Absent, "plane: direction to the grains"),
    listed("wall.centre_m", Numbers(ANY, Some(2)), Absent, "cylinder: x and y of its axis"),
    listed("wall.radius_m", Number(POSITIVE), Absent, "cylinder: radius"),
    listed("wall.min_m", VECTOR, Absent, "box: lower corner"),
    listed("wall.max_m", VECTOR, Absent, "box: upper corner"),
    listed("wall.friction", Number(FRICTION), Is("0.0"), "sliding friction coefficient"),
    listed("wall.velocity_m_s", Number(ANY), Absent, "plane, cylinder: velocity into the grains"),
    listed("wall.stress_kPa", Number(NOT_NEGATIVE), Absent, "plane, cylinder: normal stress held by a servo"),
    listed("wall.area_m2", Number(POSITIVE), Absent, "plane with a stress: area it acts on"),
    listed(
        "wall.max_velocity_m_s",
        Number(POSITIVE),
        Absent,
        "wall with a stress: largest speed; else in a mixture the stress over the root of Young's modulus times density, the speed at which a plane wave of that stress moves a material, and in an assembly a thousandth of the largest radius per step",
    ),
    listed("wall.gain", Number(Range::above(0.0, 1.0)), Is("0.2"), "wall with a stress: share of the imbalance removed per step"),
    listed("wall.material", Text, Is("\"rigid\""), "\"rigid\" (a mirrored grain) or one of `materials`"),
    mixture(
        "block.shape",
        Choice(&["box", "superquadric", "polyhedron", "polygon", "mesh", "compound"]),
        Required,
        "a rigid body: a box (sharp edges; against other blocks rounded by a twentieth of its least half edge), a superquadric (Li et al. 2023, eq. 39), the convex hull of points with a sphere swept over it, in plane strain a convex polygon with a disc swept over it, a sheet of triangles that is driven, or a compound: a body that need not be convex, the union of the convex parts that [[block.part]] lists",
    ),
    mixture(
        "block.size_mm",
        Numbers(POSITIVE, Some(3)),
        Absent,
        "box: its edges; superquadric: 2a, 2b, 2c, its lengths along its axes",
    ),
    mixture(
        "block.blockiness",
        Numbers(Range::closed(2.0, 100.0), Some(2)),
        Absent,
        "superquadric: n1 (towards its z) and n2 (around that); 2 and 2 an ellipsoid, 20 and 20 nearly a box",
    ),
    mixture(
        "block.points_mm",
        Numbers(ANY, None),
        Absent,
        "polyhedron: x, y, z of each point, one after the other; polygon: x, y of each corner, one corner for a disc",
    ),
    mixture(
        "block.rounding_mm",
        Number(NOT_NEGATIVE),
        Absent,
        "polyhedron, polygon and mesh: radius of the sphere or disc swept over it, with which other blocks touch it; 0 if not written",
    ),
    mixture(
        "block.mesh_file",
        Text,
        Absent,
        "mesh: a file of triangles, STL (text or binary) or OBJ; it acts on both sides, open or closed",
    ),
    mixture(
        "block.mesh_unit_mm",
        Number(POSITIVE),
        Absent,
        "mesh: length of the file's unit, which no such file says: 1 where it is in mm, 1000 where it is in m; needed with `mesh_file`",
    ),
    mixture("block.vertices_mm", Numbers(ANY, None), Absent, "mesh: x, y, z of each vertex, one after the other; or `mesh_file`"),
    mixture(
        "block.triangles",
        Indices,
        Absent,
        "mesh: the three vertices, from 0, of each triangle, one after the other; or `mesh_file`",
    ),
    mixture("block.position_mm", VECTOR, Required, "centre of mass; of a mesh where the origin of its file lies"),
    mixture("block.axis", VECTOR, Is("[0, 0, 1]"), "axis of the rotation by `angle_deg` that the block has at the start"),
    mixture(
        "block.angle_deg",
        Number(Range::closed(-180.0, 180.0)),
        Is("0.0"),
        "angle by which the block is rotated about `axis` at the start",
    ),
    mixture("block.velocity_m_s", VECTOR, Is("[0, 0, 0]"), "velocity"),
    mixture("block.spin_rad_s", VECTOR, Is("[0, 0, 0]"), "angular velocity"),
    mixture(
        "block.driven",
        Flag,
        Is("false"),
        "true: it keeps its velocity and spin whatever presses on it; with both zero it stands fixed; needed for a mesh, which has no mass",
    ),
    mixture(
        "block.path_s",
        Numbers(NOT_NEGATIVE, None),
        Absent,
        "times of the rows of a path that the block follows whatever presses on it, each later than the one before; between two rows it moves on a straight line at one speed, before the first and after the last it stands",
    ),
    mixture(
        "block.path_mm",
        Numbers(ANY, None),
        Absent,
        "path: x, y, z of the centre of mass at each time, one after the other; it begins at position_mm",
    ),
    mixture(
        "block.path_deg",
        Numbers(ANY, None),
        Absent,
        "path: angle at each time by which the block is turned about `path_axis` from how it stands at the start, more than a turn if need be; it begins with 0",
    ),
    mixture("block.path_axis", VECTOR, Absent, "path: axis of `path_deg` through the centre of mass; [0, 0, 1] if not written"),
    mixture(
        "block.path_csv",
        Text,
        Absent,
        "path: a CSV file instead, with columns time_s, x_mm, y_mm, z_mm (or x_m, y_m, z_m) and, if it turns, angle_deg",
    ),
    mixture(
        "block.force_N",
        VECTOR,
        Absent,
        "force on the centre of mass, besides gravity and contacts; in plane strain per metre of depth",
    ),
    mixture("block.torque_N_m", VECTOR, Absent, "torque on the block, besides that of its contacts"),
    mixture(
        "block.stress_kPa",
        VECTOR,
        Absent,
        "box that is not rotated at the start: stresses whose forces on its sides across x, y and z act on its centre of mass, each in the direction of its sign, besides force_N",
    ),
    mixture(
        "block.ramp_s",
        Number(NOT_NEGATIVE),
        Absent,
        "time in which force_N, torque_N_m and stress_kPa grow linearly from zero; 0 if not written",
    ),
    mixture(
        "block.push_s",
        Numbers(NOT_NEGATIVE, None),
        Absent,
        "times of a table that force_N, torque_N_m and stress_kPa follow, each later than the one before; for loading and unloading, or cycles",
    ),
    mixture(
        "block.push_share",
        Numbers(ANY, None),
        Absent,
        "share of force_N, torque_N_m and stress_kPa that acts at each time of push_s, with straight lines between; before the first and after the last it stays",
    ),
    mixture(
        "block.held",
        Words(&["x", "y", "z", "rotation"]),
        Absent,
        "directions in which the block keeps the velocity that it starts with whatever acts on it, and \"rotation\", with which it keeps its spin: a footing that may not tilt is held in \"x\", \"y\" and \"rotation\"",
    ),
    mixture("block.material", Text, Absent, "name of one of `materials`; needed when there are several"),
    mixture(
        "block.part.shape",
        Choice(&["box", "polyhedron", "polygon"]),
        Required,
        "a convex part of the compound before it, as the block of that shape is; superquadrics and meshes cannot be parts. Parts may overlap, and must hang together; what they cover twice counts once",
    ),
    mixture("block.part.size_mm", Numbers(POSITIVE, Some(3)), Absent, "box: its edges, about the origin of the part"),
    mixture(
        "block.part.points_mm",
        Numbers(ANY, None),
        Absent,
        "polyhedron: x, y, z of each point; polygon: x, y of each corner, one corner for a disc, two for a rod; in the frame of the part. Hulls that have a face in common join without a groove",
    ),
    mixture(
        "block.part.rounding_mm",
        Number(NOT_NEGATIVE),
        Absent,
        "polyhedron and polygon: radius of the sphere or disc swept over it; 0 if not written. Against other blocks boxes of a compound are rounded by a twentieth of the least half edge of all of them",
    ),
    mixture(
        "block.part.position_mm",
        VECTOR,
        Is("[0, 0, 0]"),
        "where the origin of the part lies in the frame of the compound; the block's own position_mm is that of the centre of mass of the whole",
    ),
    mixture("block.part.axis", VECTOR, Is("[0, 0, 1]"), "axis through the origin of the part of the rotation by `angle_deg`"),
    mixture(
        "block.part.angle_deg",
        Number(Range::closed(-180.0, 180.0)),
        Is("0.0"),
        "angle by which the part is rotated about `axis` in the frame of the compound",
    ),
    mixture(
        "joint.kind",
        Choice(&["glue", "hinge", "ball"]),
        Required,
        "an elastic joint between two blocks, or a block and the world: glue holds every turn, a hinge leaves that about its axis free, a ball joint all. Blocks that a joint holds do not touch each other; those whose glue has broken do",
    ),
    mixture(
        "joint.blocks",
        Indices,
        Required,
        "the two [[block]]s that are joined, by their numbers from 0; one number: that block and the world",
    ),
    mixture("joint.position_mm", VECTOR, Required, "where the joint sits at the start"),
    mixture(
        "joint.axis",
        VECTOR,
        Absent,
        "glue: direction across the glued face; hinge: axis about which it turns (in plane strain [0, 0, 1])",
    ),
    mixture(
        "joint.radius_mm",
        Number(POSITIVE),
        Required,
        "radius of the disc of cement, or of the pin; in plane strain half width of the strip",
    ),
    mixture(
        "joint.thickness_mm",
        Number(POSITIVE),
        Required,
        "thickness t of the cement: it resists with E A/t, G A/t, E I/t and G J/t (Potyondy & Cundall 2004), a pin with E A/t in every direction",
    ),
    mixture("joint.E_MPa", Number(POSITIVE), Required, "Young's modulus of the cement"),
    mixture("joint.nu", Number(Range::below(0.0, 0.5)), Is("0.25"), "Poisson's ratio of the cement"),
    mixture(
        "joint.damping",
        Number(Range::closed(0.0, 1.0)),
        Is("0.0"),
        "damping of the joint over critical damping of its own vibrations",
    ),
    mixture(
        "joint.tension_MPa",
        Number(POSITIVE),
        Absent,
        "glue: stress N/A + M R/I at which it breaks for good; never if not written",
    ),
    mixture(
        "joint.shear_MPa",
        Number(POSITIVE),
        Absent,
        "glue: stress V/A + T R/J at which it breaks for good (in plane strain V/A); never if not written",
    ),
    mixture(
        "block_set.shape",
        Choice(&["polyhedron", "polygon"]),
        Required,
        "random rigid bodies that fill a box: rounded convex polyhedra, or in plane strain polygons, whose corners lie on an ellipsoid or ellipse. They are packed by geometry alone, as in a box that shrinks around them, and points in them are left out",
    ),
    mixture("block_set.count", Integer { low: 1, high: 5000 }, Required, "number of bodies"),
    mixture(
        "block_set.diameter_mm",
        Numbers(POSITIVE, Some(2)),
        Required,
        "least and largest diameter of the sphere of the same volume, or of the disc of the same area; drawn with equal probability between both",
    ),
    mixture(
        "block_set.corners",
        Numbers(Range::closed(3.0, 100.0), Some(2)),
        Absent,
        "least and largest number of corners, from 3 on of polygons, from 4 on of polyhedra; or `outlines_csv`",
    ),
    mixture(
        "block_set.outlines_csv",
        Text,
        Absent,
        "a file of outlines, outline,x,y (in space outline,x,y,z), of which each body takes one with equal probability, in the size that is drawn for it: their convex hulls, in any unit. Rows with the same name are one outline",
    ),
    mixture(
        "block_set.outline_corners",
        Numbers(Range::closed(1.0, 1e6), None),
        Absent,
        "number of points of each outline; or `outlines_csv`",
    ),
    mixture(
        "block_set.outline_points",
        Numbers(ANY, None),
        Absent,
        "x, y, z of the points of all outlines, one after the other; or `outlines_csv`",
    ),
    mixture(
        "block_set.elongation",
        Numbers(Range::closed(1.0, 10.0), Some(2)),
        Is("[1.0, 1.0]"),
        "least and largest ratio of the longest to the intermediate axis of the ellipsoid, or of the axes of the ellipse",
    ),
    mixture(
        "block_set.flatness",
        Numbers(Range::closed(1.0, 10.0), Some(2)),
        Is("[1.0, 1.0]"),
        "polyhedra: least and largest ratio of the intermediate to the shortest axis",
    ),
    mixture("block_set.rounding", Number(Range::closed(0.005, 0.4)), Is("0.05"), "radius of the edges over the diameter"),
    mixture("block_set.min_mm", VECTOR, Required, "lower corner of the box"),
    mixture("block_set.max_mm", VECTOR, Required, "upper corner of the box"),
    mixture("block_set.material", Text, Absent, "name of one of `materials`; needed when there are several"),
    continuum(
        "body.shape",
        Choice(&["box", "cylinder", "sphere", "points"]),
        Required,
        "what is filled with material points; a sphere is a disc in plane strain",
    ),
    continuum("body.material", Text, Absent, "name of one of `materials`; needed when there are several"),
    continuum("body.min_mm", VECTOR, Absent, "box: lower corner"),
    continuum("body.max_mm", VECTOR, Absent, "box: upper corner"),
    continuum("body.centre_mm", VECTOR, Absent, "sphere: centre; cylinder: middle of its base, its axis stands along z"),
    continuum("body.radius_mm", Number(POSITIVE), Absent, "cylinder, sphere: radius"),
    continuum("body.height_mm", Number(POSITIVE), Absent, "cylinder: height"),
    continuum(
        "body.points_csv",
        Text,
        Absent,
        "points: a file with x_mm,y_mm,z_mm (or _m) and an optional volume_mm3 (or _m3); a point without a volume has the volume of a cell over the number of points per cell",
    ),
    continuum("body.points_m", Numbers(ANY, None), Absent, "points: x, y, z of each, one after the other; or `points_csv`"),
    continuum("body.volumes_m3", Numbers(POSITIVE, None), Absent, "points: volume of each (in plane strain per metre)"),
    continuum(
        "body.porosity",
        Number(RATIO),
        Absent,
        "porosity at the start: density is the grains' times 1 - porosity, and platens meet the solid volume of a point; 0 without it or void_ratio",
    ),
    continuum("body.void_ratio", Number(POSITIVE), Absent, "void ratio at the start; or porosity"),
    continuum("body.velocity_m_s", VECTOR, Is("[0, 0, 0]"), "velocity at the start"),
    continuum(
        "body.stress_kPa",
        Number(NOT_NEGATIVE),
        Absent,
        "isotropic pressure at the start; the cell pressure in a triaxial test, else 0",
    ),
    continuum("grid.cell_mm", Number(POSITIVE), Absent, "edge of a cell; or `fines_diameter_mm` and `grains_per_point`"),
    continuum("grid.fines_diameter_mm", Number(POSITIVE), Absent, "mean diameter of the fine grains that the points replace"),
    continuum(
        "grid.grains_per_point",
        Number(POSITIVE),
        Absent,
        "number of fine grains that a point replaces, 8 for a particle reduction of 1:8; the edge of a cell follows, adjusted to a whole number of points along the first edge of a box",
    ),
    continuum("grid.min_mm", VECTOR, Absent, "lower corner of the grid; a free scene needs it, a test finds its own"),
    continuum("grid.max_mm", VECTOR, Absent, "upper corner of the grid, a whole number of cells further"),
    continuum("grid.points_per_edge", Integer { low: 1, high: 8 }, Is("2"), "points along the edge of a cell"),
    continuum(
        "grid.plane_strain",
        Flag,
        Is("false"),
        "two dimensions, x and y (upwards); the third entries of vectors mean nothing",
    ),
    continuum(
        "grid.shape_functions",
        Choice(&["bspline", "gimp"]),
        Is("\"bspline\""),
        "quadratic B-splines (Li et al. 2023, eqs 10-12), or generalised interpolation",
    ),
    continuum(
        "grid.transfer",
        Choice(&["flip_pic", "apic"]),
        Is("\"flip_pic\""),
        "how velocities go to the points: blended (eq. 30), or affine",
    ),
    continuum("grid.pic", Number(Range::closed(0.0, 1.0)), Is("0.0"), "flip_pic: share of PIC, alpha of eq. 30; 0 is FLIP"),
    continuum("grid.x_low", WALL, Is("\"open\""), WALL_WHAT),
    continuum("grid.x_high", WALL, Is("\"open\""), WALL_WHAT),
    continuum("grid.y_low", WALL, Is("\"open\""), WALL_WHAT),
    continuum("grid.y_high", WALL, Is("\"open\""), WALL_WHAT),
    continuum("grid.z_low", WALL, Is("\"open\""), WALL_WHAT),
    continuum("grid.z_high", WALL, Is("\"open\""), WALL_WHAT),
    continuum("grid.friction", Number(FRICTION), Is("0.0"), "friction coefficient of sides that are \"coulomb\""),
    continuum(
        "test.rig",
        Choice(&["free", "oedometer", "triaxial"]),
        Is("\"free\""),
        "free: no platens; oedometer: a box with smooth fixed sides under a driven top platen; triaxial: a box between six platens (four in plane strain)",
    ),
    continuum("test.cell_pressure_kPa", Number(POSITIVE), Absent, "triaxial: stress that the lateral platens hold"),
    continuum(
        "test.drainage",
        Choice(&["drained", "constant_volume"]),
        Is("\"drained\""),
        "triaxial. drained: the lateral platens hold the cell pressure; constant_volume: they move so that the volume stays, and the cell pressure minus their stress is the equivalent pore pressure",
    ),
    continuum("test.axial_strain", Number(Range::between(0.0, 1.0)), Absent, "oedometer, triaxial: axial strain at the end"),
    continuum(
        "test.strain_per_wave",
        Number(Range::above(0.0, 0.01)),
        Is("0.0001"),
        "axial strain in the time that a compression wave takes through the specimen of real density: how far from quasi-static",
    ),
    continuum(
        "test.contact_modulus_MPa",
        NumberOr(POSITIVE, "auto"),
        Is("\"auto\""),
        "E* of the platens' contacts; auto: E/(1 - nu^2) of the material's grains, or 50 times the continuum's oedometric modulus if it has none",
    ),
    continuum(
        "test.servo_gain",
        Number(Range::above(0.0, 1.0)),
        Is("0.3"),
        "share of the imbalance that a platen removes per step",
    ),
    mixture(
        "test.seating_kPa",
        Number(POSITIVE),
        Absent,
        "oedometer of rigid bodies without points: stress of the top platen under which they come to rest before they are loaded",
    ),
    mixture(
        "coarse.mass_fraction",
        Number(Range::closed(0.0, 1.0)),
        Absent,
        "test: share of coarse grains in the mass of all solids; they are placed at random in the box, and the points fill what they leave",
    ),
    mixture(
        "coarse.diameter_mm",
        Numbers(POSITIVE, Some(2)),
        Absent,
        "smallest and largest diameter of coarse grains, uniform between",
    ),
    mixture("coarse.material", Text, Absent, "name of one of `materials`"),
    mixture(
        "growth.fines_diameter_mm",
        Numbers(POSITIVE, Some(2)),
        Absent,
        "test: the specimen grows; smallest and largest diameter of its fine grains, uniform between. Coarse and fine ones together fill the box at its porosity, then its walls press until they bear the stress",
    ),
    mixture(
        "growth.fines",
        Choice(&["points", "grains"]),
        Is("\"points\""),
        "points: the fine grains of the grown specimen are replaced by material points; grains: they stay grains, and the test has no continuum",
    ),
    mixture(
        "growth.friction",
        Number(FRICTION),
        Absent,
        "friction between grains, or between rigid bodies without points, until the walls bear the stress; the materials' if not written",
    ),
    mixture("growth.steps", COUNT, Is("4000"), "steps of growth"),
    mixture("growth.max_steps", COUNT, Is("100000"), "steps after which growth and pressing give up"),
    both(
        "specimen.scale",
        Number(POSITIVE),
        Is("1.0"),
        "scale N of eqs 13-15: sizes, d0 and the comminution limit are multiplied by it, gradations divided",
    ),
    prepared(
        "specimen.file",
        Text,
        Absent,
        "a prepared specimen (specimen.csv of a run; of a mixture one that has grown) to begin with; option --specimen",
    ),
    cylinder("specimen.grains", Integer { low: 1, high: 100_000_000 }, Absent, "grains at the start; or dry_mass_g"),
    cylinder(
        "specimen.dry_mass_g",
        Number(POSITIVE),
        Absent,
        "mass of the grains, of the size that they have at this scale: their number follows; or grains",
    ),
    cylinder("specimen.diameter_mm", Number(POSITIVE), Required, "diameter of the oedometer"),
    cylinder(
        "specimen.porosity",
        Number(Range::between(0.0, 1.0)),
        Absent,
        "intergranular porosity at the isotropic stress; or void_ratio, relative_density or height_mm",
    ),
    cylinder(
        "specimen.void_ratio",
        Number(POSITIVE),
        Absent,
        "void ratio at the isotropic stress; or porosity, relative_density or height_mm",
    ),
    cylinder(
        "specimen.relative_density",
        Number(RATIO),
        Absent,
        "(e_max - e) / (e_max - e_min) between the loosest and the densest specimen that the program makes of these grains, which it measures once and keeps in the user's cache; needs preparation.growth_friction = \"auto\"; or porosity, void_ratio or height_mm",
    ),
    cylinder(
        "specimen.height_mm",
        Number(POSITIVE),
        Absent,
        "height at the isotropic stress, with the grains and the diameter; or porosity, void_ratio or relative_density",
    ),
    cylinder("specimen.isotropic_stress_kPa", Number(POSITIVE), Is("5.0"), "stress of the prepared specimen"),
    grain_crushing(
        "batch.diameters_mm",
        Numbers(POSITIVE, None),
        Absent,
        "diameters that are tested; without them sizes are drawn from the gradation of the grains' material",
    ),
    grain_crushing(
        "batch.grains",
        Integer { low: 1, high: 1_000_000 },
        Required,
        "grains of each diameter, or drawn from the gradation; each has its own strength",
    ),
    both("contact.law", Choice(ContactLaw::WORDS), Is("\"hertz\""), ""), // `assembled` writes the help text
    both(
        "contact.unloading",
        Choice(&["keep", "rescale"]),
        Absent,
        "tangential force while the normal force falls. keep: unchanged, as in the paper; rescale: reduced in proportion to the tangential stiffness, which creates no energy. If not written: rescale where grains break, else keep",
    ),
    mixture(
        "contact.on_points",
        Choice(&["face", "centre", "node", "mutual_nodes"]),
        Absent,
        "where forces of contacts with grains and rigid bodies act on a point: face, where the grain is; centre (Li et al. 2023, eq. 29); two more to compare with (Jiang et al. 2020, section 5.4; on the processor, without records.account): node, the one nearest to the point (MPM-GRID there), and mutual_nodes, those that points and polygons both reach, where the two may not approach each other (MPM-DEM there; polygons are some points of their own, and contact.point_radius_mm is not used). If not written: face in a test between platens, centre in a free scene",
    ),
    mixture(
        "contact.point_radius_mm",
        Number(POSITIVE),
        Absent,
        "radius with which points touch each [[block]] (Jiang et al. 2020, eqs 44, 45: between the distance of two points and a cell); if not written, that of the sphere or disc of a point's own volume",
    ),
    both("contact.rotation", Choice(&["free", "fixed"]), Is("\"free\""), "whether grains turn; fixed, they stand for angular ones"),
    cylinder("walls.friction.bottom", Number(FRICTION), Is("0.0"), "friction coefficient of the lower platen"),
    cylinder("walls.friction.top", Number(FRICTION), Is("0.0"), "friction coefficient of the upper platen"),
    cylinder("walls.friction.cylinder", Number(FRICTION), Is("0.0"), "friction coefficient of the ring"),
    grains("crushing.enabled", Flag, ByKind("false", "false", "true"), "whether grains break"),
    grains("crushing.criterion", Choice(Criterion::WORDS), Absent, ""), // `assembled` writes the help text
    grains(
        "crushing.area",
        Choice(&["fixed_angle", "hertz"]),
        Absent,
        "older name of `criterion`: \"fixed_angle\", or \"hertz\" for \"hertz_area\"",
    ),
    grains(
        "crushing.area_radius",
        Choice(&["pair", "own"]),
        Is("\"pair\""),
        "criterion hertz_area: the radius r' of the contact area (eq. 9). pair: the reduced radius of both bodies (eq. 10); own: that of the grain that is judged, as between platens (eq. 17)",
    ),
    grains("crushing.pattern", Integer { low: 2, high: 68 }, Is("14"), "daughters of a broken grain: 2, 5, 14, 26, 38, 50 or 68"),
    grains(
        "crushing.azimuth",
        Choice(&["random", "fixed"]),
        Is("\"random\""),
        "how the pattern of the daughters is turned about the force that broke the grain. random: by an angle keyed by lineage; fixed: as two rotations about the axes y and x of space turn it to the force (the paper's appendix), so that its x' points towards +x",
    ),
    grains("crushing.d_limit_over_d50", Number(POSITIVE), Absent, "comminution limit, instead of the material's"),
    grains(
        "crushing.birth",
        Choice(&["gradual", "overlapping"]),
        Absent,
        "how the daughters of a broken grain begin. gradual: small enough to touch nothing; they grow while the forces of the broken grain on its neighbours fade; overlapping: at once at full size, with the overlaps of the broken grain, as in the paper. If not written: gradual, in a mixture overlapping",
    ),
    grains(
        "crushing.release_steps",
        STEPS,
        Is("200"),
        "gradual birth: steps in which the forces of the broken grain on its neighbours fade",
    ),
    grains(
        "crushing.growth_steps",
        STEPS,
        Is("1000"),
        "gradual birth: least number of steps in which a daughter grows to full size; it stops growing while its load is near its limit",
    ),
    grains("crushing.interval", Integer { low: 1, high: 1_000_000 }, Is("1"), "steps between two judgements of all grains"),
    grains(
        "crushing.lost_mass",
        Choice(&["leave", "grow", "points"]),
        Is("\"leave\""),
        "what becomes of the mass that the daughters of a broken grain do not hold: it leaves the mechanics (the paper), the daughters grow until they have it (gradual birth), or in an oedometer or a mixture it becomes material points where there is room",
    ),
    mixture(
        "crushing.block_pieces",
        Numbers(Range::closed(-1.0, 1.0), None),
        Absent,
        "rigid bodies break into cells around these seeds, a piece for each: x, y, z of one after the other (in plane strain x, y), in shares of half the body's size along its own axes, from -1 to 1; if not written, in two along a plane through their largest contacts. Compounds break into their parts, and these so",
    ),
    oedometer(
        "crushing.points_cell_mm",
        NumberOr(POSITIVE, "auto"),
        Is("\"auto\""),
        "lost_mass = \"points\": edge of a cell of their grid, times the scale; auto: 0.4 of d50",
    ),
    oedometer(
        "crushing.points_porosity",
        Number(RATIO),
        Is("0.45"),
        "lost_mass = \"points\": porosity with which fines begin, free of stress",
    ),
    fines(
        "crushing.release_strain",
        Number(POSITIVE),
        Is("0.1"),
        "lost_mass = \"points\": a new point overlaps its neighbours, and this first overlap bears no force; it falls to 1/e when the point has slid past the neighbour by this many diameters of its contact sphere",
    ),
    cylinder(
        "preparation.growth_friction",
        NumberOr(FRICTION, "auto"),
        Is("\"auto\""),
        "friction between grains while their radii grow: it sets the loosest porosity that can be reached; auto: the specimen is compressed from its loosest state on while friction gives way, and sheared to and fro without friction where it has to be denser",
    ),
    cylinder("preparation.growth_steps", COUNT, Is("8000"), "steps of radius growth"),
    cylinder("preparation.damping", Number(RATIO), Is("0.7"), "local damping during preparation"),
    cylinder(
        "preparation.porosity_tolerance",
        Number(Range::between(0.0, 1.0)),
        Is("0.005"),
        "relative distance to the target porosity that is accepted",
    ),
    cylinder("preparation.max_steps", COUNT, Is("200000"), "steps after which preparation gives up"),
    compression(
        "loading.max_stress_kPa",
        Number(POSITIVE),
        Required,
        "vertical stress of the first loading (isotropic: stress on all sides)",
    ),
    compression(
        "loading.stages_kPa",
        Numbers(POSITIVE, None),
        Is("[]"),
        "vertical stresses after that: a lower one unloads, a higher one reloads",
    ),
    oedometer(
        "loading.rate",
        Number(Range::above(0.0, 1e3)),
        Is("0.01"),
        "load increase coefficient L_C of eq. 18: natural logarithm, one increment per step",
    ),
    oedometer("loading.sigma_ref_kPa", Number(POSITIVE), Is("1.0"), "reference stress of eq. 18"),
    oedometer(
        "loading.programme",
        Choice(&["eq18", "adaptive"]),
        Is("\"eq18\""),
        "how the target stress changes in a step: by eq. 18, or in proportion to itself and to how little the platens' stresses differ from it and from each other",
    ),
    compression(
        "loading.pace",
        Number(Range::above(0.0, 1.0)),
        Is("0.002"),
        "adaptive programme: change of the target in one step over the target, while the platens are in balance",
    ),
    cylinder(
        "loading.servo_gain",
        Number(Range::above(0.0, 1.0)),
        Is("0.5"),
        "share of the load imbalance that a platen removes per step",
    ),
    compression(
        "loading.max_inertial_number",
        Number(POSITIVE),
        Is("0.0008"),
        "largest inertial number that the platen may impose",
    ),
    compression(
        "loading.max_lag",
        Number(Range::above(0.0, 1.0)),
        Is("0.015"),
        "largest difference between the stress on a platen and the target, over the target: above it the programme waits, and an adaptive programme slows down as it comes near. With friction on the cylinder only the driven platen counts",
    ),
    compression(
        "loading.max_wait_steps",
        COUNT,
        Is("1000000"),
        "steps after which the run stops itself (exit code 3, records kept) where the stress has not followed its target (longest wait of the committed runs: some 72 000)",
    ),
    cylinder("loading.settle_steps", FROM_ZERO, Is("1000"), "steps of rest at the isotropic stress before loading"),
    triaxial(
        "loading.axial_strain",
        Number(Range::between(0.0, 1.0)),
        Is("0.15"),
        "axial strain at the end of shear; the cell pressure is specimen.isotropic_stress_kPa",
    ),
    oedometer(
        "loading.control",
        Choice(&["stress", "strain"]),
        Is("\"stress\""),
        "what the programme gives in first loading: the stress by `loading.programme`, or the strain, at loading.inertial_number, and the stress is what comes out; unloading and reloading are by stress",
    ),
    cylinder(
        "loading.inertial_number",
        Number(POSITIVE),
        Is("0.0003"),
        "inertial number at which the top platen moves (oedometer: with loading.control = \"strain\")",
    ),
    grain_crushing(
        "loading.step",
        Number(Range::closed(1e-6, 1e-2)),
        Is("0.0005"),
        "displacement of the platen in one step over its displacement so far; the force rises by up to 1.5 times this share in a step",
    ),
    grain_crushing(
        "loading.max_displacement_over_d",
        Number(Range::between(1e-3, 1.0)),
        Is("0.5"),
        "displacement over the diameter at which a test ends with an unbroken grain",
    ),
    grain_crushing("loading.max_force_N", Number(POSITIVE), Absent, "force at which a test ends with an unbroken grain"),
    states(
        "damping.local",
        Number(RATIO),
        ByKind("0.05", "0.0", "0.0"),
        "local damping (Cundall 1987): a force against the velocity, this share of the unbalanced force of each grain or node",
    ),
    every("stepping.safety", Number(Range::above(0.0, 1.0)), Is("0.8"), "share of the stable time step"),
    both(
        "stepping.inertia_scaling",
        Flag,
        Is("false"),
        "quasi-static: inertia so that every grain has the same stable step; time counts steps",
    ),
    states("stepping.dt_s", NumberOr(POSITIVE, "auto"), Is("\"auto\""), "time step"),
    free(
        "stepping.above_bound",
        Flag,
        Is("false"),
        "whether stepping.dt_s may be above the largest stable step: the run then stops itself only where energy comes from nothing",
    ),
    mixture(
        "stepping.grain_steps",
        Integer { low: 1, high: 1000 },
        Absent,
        "steps of the grains per step of the continuum, kappa of Zhang et al.; or `continuum_steps`. If neither is written, the ratio of the stable steps",
    ),
    mixture(
        "stepping.continuum_steps",
        Integer { low: 1, high: 1000 },
        Absent,
        "steps of the continuum per step of the grains; or `grain_steps`",
    ),
    continuum(
        "stepping.points_inertia",
        Number(Range::closed(1.0, 1e4)),
        Is("1.0"),
        "oedometer, triaxial: inertia of the points over that of their real mass; longer steps at the same strain rate, as long as the test stays quasi-static",
    ),
    both(
        "stepping.skin",
        Number(Range::above(0.0, 2.0)),
        Is("0.2"),
        "neighbour skin of a grain at rest over its radius (of a fast one up to four times that); changes speed, never results",
    ),
    compression("records.per_decade", Integer { low: 1, high: 10_000 }, Is("40"), "rows of history per decade of vertical stress"),
    compression(
        "records.at_kPa",
        Numbers(POSITIVE, None),
        Is("[]"),
        "vertical stresses with a gradation and a snapshot, besides the first and the last",
    ),
    cylinder(
        "records.every_strain",
        Number(Range::between(0.0, 1.0)),
        Absent,
        "axial strain between rows of history: 0.001 in a triaxial test if not written; in an oedometer besides the rows by stress, 0.002 where loading.control = \"strain\", else none",
    ),
    compression("records.every_events", COUNT, Absent, "breakages between rows of history, besides those by stress and strain"),
    triaxial(
        "records.at_strain",
        Numbers(Range::between(0.0, 1.0), None),
        Is("[]"),
        "axial strains with a gradation and a snapshot, besides the first and the last",
    ),
    cylinder(
        "records.least_void_ratio",
        Number(Range::between(0.0, 1.0)),
        Is("0.15"),
        "void ratio of all dry mass that fines can just fill: below it the run warns once, and figures draw curves pale and dashed",
    ),
    cylinder(
        "records.end_below_least_void_ratio",
        Flag,
        Is("false"),
        "whether the run ends in good order where the void ratio falls below records.least_void_ratio",
    ),
    cylinder(
        "records.stop_without_voids",
        Flag,
        Is("true"),
        "whether the run stops itself (exit code 3, records kept) where void_ratio_star falls below 0: all dry mass, without the grains' own pores, would fill more than the whole volume",
    ),
    assembly("records.every", COUNT, Is("100"), "steps between rows of history and tracks"),
    assembly("records.tracks", IndicesOr("all"), Is("[]"), "grains (from 0) whose motion is recorded"),
    grain_crushing(
        "records.curves",
        IndicesOr("typical"),
        Is("\"typical\""),
        "grains (from 0) whose force-displacement curves are written, or the one of median strength of each diameter (four of a gradation)",
    ),
    states(
        "records.stop_at_step",
        Number(RATIO),
        Is("1e-6"),
        "share of the stable step at the start below which a time step stops the run (exit code 3, records kept), which would never end; 0: never",
    ),
    both(
        "records.stop_at_overlap",
        Number(POSITIVE),
        Is("2.0"),
        "overlap of two grains over the radius of the smaller at which the run stops itself (exit code 3, records kept): at 2 the smaller is inside the larger",
    ),
    listed(
        "records.largest_overlap_at_start",
        Number(POSITIVE),
        Is("0.25"),
        "largest overlap of two listed grains, or of one and a wall, over the radius of the smaller: a scene with a deeper one is refused",
    ),
    both("records.energy", Flag, Is("true"), "whether the energy ledger is kept"),
    continuum(
        "records.account",
        Flag,
        Is("false"),
        "whether the energy account of points, nodes and grains is kept and written to account.csv: each term by a sum of its own (on the processor, without rigid bodies)",
    ),
    continuum("records.rows", Integer { low: 1, high: 100_000 }, Is("200"), "rows of history over the run"),
    continuum("records.frames", Integer { low: 1, high: 10_000 }, Is("5"), "snapshots over the run, besides the first"),
    continuum(
        "records.gate_mm",
        VECTOR,
        Absent,
        "free scene: a point of the plane whose passage is recorded: the column `passed_kg` has the mass of points, grains and rigid bodies whose centres are beyond it",
    ),
    continuum("records.gate_direction", VECTOR, Absent, "vector across that plane, of any length, to the side beyond"),
    states("records.snapshots", Flag, Is("true"), "whether ParaView snapshots are written"),
    both(
        "records.contacts",
        Flag,
        Is("false"),
        "whether every contact of grains (bodies, place, forces, overlap) is written as snapshots/contacts_*.csv at the instants of snapshots; from these the figure of force chains is drawn",
    ),
    every("records.figures", Flag, Is("true"), "whether figures are drawn"),
    every(
        "records.report",
        Flag,
        Is("false"),
        "whether a page that shows the run is written when it ends, report.html in its folder",
    ),
    states("records.checkpoint_seconds", Number(POSITIVE), Is("60.0"), "seconds of wall-clock time between checkpoints"),
    oedometer("calibrate.key", Text, Required, "key that `comminute calibrate curve` finds; no run looks at this table"),
    oedometer("calibrate.lower", Number(ANY), Required, "smallest value of the key"),
    oedometer("calibrate.upper", Number(ANY), Required, "largest value of the key"),
    oedometer(
        "calibrate.prior",
        Choice(&["uniform", "log_uniform", "normal"]),
        Is("\"uniform\""),
        "what is known of the parameter before the calibration. uniform: every value between the bounds is as likely; log_uniform: every order of magnitude is; normal: a normal distribution",
    ),
    oedometer("calibrate.mean", Number(ANY), Absent, "mean of a normal prior"),
    oedometer("calibrate.sd", Number(POSITIVE), Absent, "standard deviation of a normal prior"),
    grains("seed.packing", FROM_ZERO, Is("1"), "random stream of the specimen"),
    grains("seed.strength", FROM_ZERO, Is("1"), "random stream of strengths and pattern azimuths, keyed by lineage"),
    every("material.name", Text, Required, "name of the material"),
    every("material.grain.density_kg_m3", Number(POSITIVE), Required, "density of a grain with its pores"),
    every("material.grain.internal_porosity", Number(RATIO), Is("0.0"), "porosity of a grain (eqs 19, 20)"),
    every("material.elastic.G_GPa", Number(POSITIVE), Absent, "shear modulus; or `E_GPa`"),
    every("material.elastic.E_GPa", Number(POSITIVE), Absent, "Young's modulus; or `G_GPa`"),
    every("material.elastic.nu", Number(Range::between(-1.0, 0.5)), Required, "Poisson ratio"),
    every(
        "material.contact.friction_angle_rad",
        Number(Range::below(0.0, 1.55)),
        Absent,
        "angle of sliding friction between grains; or `friction`",
    ),
    every(
        "material.contact.friction",
        Number(FRICTION),
        Absent,
        "coefficient of sliding friction between grains; or `friction_angle_rad`",
    ),
    every("material.contact.rolling_friction", Number(Range::closed(0.0, 10.0)), Is("0.0"), "coefficient of rolling friction"),
    every("material.gradation.points", Points, Required, "[diameter in mm, mass fraction finer] from 0 to 1, unscaled"),
    every("material.strength.d0_mm", Number(POSITIVE), Is("2.0"), "reference diameter of size hardening (eq. 7), unscaled"),
    every(
        "material.strength.distribution",
        Choice(&["normal", "weibull"]),
        Is("\"normal\""),
        "how strengths of grains of one size are distributed: normal with `var` (eq. 6), or Weibull's with the modulus `m` of the size hardening",
    ),
    every(
        "material.strength.truncation",
        Choice(&["redraw", "clamp", "symmetric", "mean_preserving", "absolute"]),
        Is("\"redraw\""),
        "what is done with a draw below `min_ratio`. redraw: it is drawn again; clamp: it is set to `min_ratio`; symmetric: it is drawn again, and so is a draw that is as far above the mean; mean_preserving: it is drawn again, and all are divided by the mean of what is left, so that the mean stays; absolute: it becomes as far above `min_ratio` as it was below, where that is 0 its absolute value",
    ),
    every(
        "material.strength.min_ratio",
        Number(RATIO),
        Is("0.0"),
        "smallest strength over the mean at its size; with truncation = \"mean_preserving\" before the division by the mean",
    ),
    every(
        "material.strength.fixed_angle.sigma_lim0_MPa",
        Number(POSITIVE),
        Absent,
        "mean limit strength at d0 (eq. 7), a force over the area of its contact: 4 / (pi sin^2 theta0) times F/d^2 of a single-grain test (eq. 16), 11 times at theta0 = 0.35; or `crushing_stress_MPa`, or `sigma_c_MPa` and `sigma_t_MPa`",
    ),
    every(
        "material.strength.fixed_angle.crushing_stress_MPa",
        Number(POSITIVE),
        Absent,
        "F/d^2 of grains of diameter d0 crushed between flat platens, as laboratories give it; sigma_lim0 follows from it by eq. 16 and does not depend on the platens. With `crushing_stress_is`",
    ),
    every("material.strength.fixed_angle.crushing_stress_is", QUOTED, Absent, QUOTED_WHAT),
    every(
        "material.strength.fixed_angle.sigma_c_MPa",
        Number(POSITIVE),
        Absent,
        "uniaxial compressive strength of the grain's substance (eq. 2), not of a grain",
    ),
    every("material.strength.fixed_angle.sigma_t_MPa", Number(POSITIVE), Absent, "uniaxial tensile strength (eq. 2)"),
    every("material.strength.fixed_angle.m", Number(POSITIVE), Required, MODULUS_WHAT),
    every("material.strength.fixed_angle.var", Number(VARIATION), Absent, VARIATION_WHAT),
    every(
        "material.strength.hertz_area.sigma_lim0_MPa",
        Number(POSITIVE),
        Absent,
        "mean limit strength at d0 (eq. 7), a force over Hertz's area of its contact, far above F/d^2 of a single-grain test, which goes with its cube (eq. 17); or `crushing_stress_MPa`, or `sigma_c_MPa` and `sigma_t_MPa`",
    ),
    every(
        "material.strength.hertz_area.crushing_stress_MPa",
        Number(POSITIVE),
        Absent,
        "F/d^2 of grains of diameter d0 crushed between flat rigid platens; sigma_lim0 follows from it by eq. 17 with the material's elastic moduli and the spread of strengths. Platens of steel: multiply what was measured by (E'_steel / E'_rigid)^2, 0.55 for grains of E = 70 GPa (eq. 11). With `crushing_stress_is`",
    ),
    every("material.strength.hertz_area.crushing_stress_is", QUOTED, Absent, QUOTED_WHAT),
    every("material.strength.hertz_area.sigma_c_MPa", Number(POSITIVE), Absent, "uniaxial compressive strength (eq. 2)"),
    every("material.strength.hertz_area.sigma_t_MPa", Number(POSITIVE), Absent, "uniaxial tensile strength (eq. 2)"),
    every("material.strength.hertz_area.m", Number(POSITIVE), Required, MODULUS_WHAT),
    every("material.strength.hertz_area.var", Number(VARIATION), Absent, VARIATION_WHAT),
    every(
        "material.comminution.d_limit_over_d50",
        Number(POSITIVE),
        Required,
        "comminution limit over d50: smaller grains do not break",
    ),
    every(
        "material.comminution.d50_mm",
        Number(POSITIVE),
        Absent,
        "d50 of that ratio, unscaled; the gradation's median if not written",
    ),
    every("material.fines.alpha", Number(Range::closed(0.0, 10.0)), Is("2.6"), "fractal dimension of the lost mass (eq. 12)"),
    every(
        "material.fines.d_min_mm",
        Number(POSITIVE),
        Required,
        "smallest size of the lost mass (eq. 12), unscaled, below every daughter",
    ),
    every("material.continuum.law", Choice(Law::WORDS), Required, ""), // `assembled` writes the help text
    every(
        "material.continuum.G_MPa",
        Number(POSITIVE),
        Absent,
        "shear modulus of the continuum; or `E_MPa`; cam_clay: one that stays, or `nu`",
    ),
    every("material.continuum.E_MPa", Number(POSITIVE), Absent, "Young's modulus of the continuum; or `G_MPa`; not of cam_clay"),
    every(
        "material.continuum.nu",
        Number(Range::between(-1.0, 0.5)),
        Absent,
        "Poisson ratio of the continuum; cam_clay has this or `G_MPa`, other laws always have it",
    ),
    every(
        "material.continuum.cone",
        Choice(&["outer", "inner", "plane_strain"]),
        Absent,
        "drucker_prager: where the cone meets the Mohr-Coulomb pyramid: triaxial compression, triaxial extension, or matched in plane strain",
    ),
    every(
        "material.continuum.friction_angle_deg",
        Number(DEGREES),
        Absent,
        "drucker_prager, mohr_coulomb: friction angle (before any plastic strain, if it changes); cam_clay: that of the critical state in triaxial compression; or `friction_angle_rad`",
    ),
    every(
        "material.continuum.friction_angle_rad",
        Number(RADIANS),
        Absent,
        "drucker_prager, mohr_coulomb, cam_clay: friction angle; or `friction_angle_deg`",
    ),
    every(
        "material.continuum.dilation_angle_deg",
        Number(DEGREES),
        Absent,
        "drucker_prager, mohr_coulomb: dilation angle, at most the smallest friction angle (with `dilation = \"mobilised\"` that at the largest friction angle, and at most that one); or `dilation_angle_rad`",
    ),
    every(
        "material.continuum.dilation_angle_rad",
        Number(RADIANS),
        Absent,
        "drucker_prager, mohr_coulomb: dilation angle; or `dilation_angle_deg`",
    ),
    every(
        "material.continuum.dilation",
        Choice(&["constant", "mobilised"]),
        Absent,
        "drucker_prager, mohr_coulomb: whether the dilation angle stays (constant, also where not written), or falls with the friction angle and is 0 at its final value, so that dilation ends at the critical state (mobilised)",
    ),
    every(
        "material.continuum.interface_friction",
        Number(Range::closed(0.0, 10.0)),
        Absent,
        "coefficient of friction of the continuum on grains and rigid bodies in it, before any plastic strain; where not written, that of its grains (contact.friction), which never roll then",
    ),
    every(
        "material.continuum.interface_friction_residual",
        Number(Range::closed(0.0, 10.0)),
        Absent,
        "drucker_prager, mohr_coulomb: coefficient of friction on grains and rigid bodies towards which interface_friction goes; where not written, it stays",
    ),
    every(
        "material.continuum.interface_friction_decay",
        Number(POSITIVE),
        Absent,
        "with interface_friction_residual: rate H of exp(-H plastic strain) with which the difference to it falls",
    ),
    every(
        "material.continuum.cohesion_kPa",
        Number(NOT_NEGATIVE),
        Absent,
        "drucker_prager, mohr_coulomb: cohesion (before any plastic strain, if it changes)",
    ),
    every(
        "material.continuum.tension_kPa",
        Number(NOT_NEGATIVE),
        Absent,
        "drucker_prager: largest mean tension; the cone's apex if not written or beyond it",
    ),
    every(
        "material.continuum.lambda",
        Number(POSITIVE),
        Absent,
        "cam_clay: slope of the virgin line of isotropic compression, specific volume over ln of the mean stress",
    ),
    every(
        "material.continuum.kappa",
        Number(POSITIVE),
        Absent,
        "cam_clay: slope of unloading and reloading, specific volume over ln of the mean stress; below `lambda`",
    ),
    every(
        "material.continuum.virgin_specific_volume",
        Number(POSITIVE),
        Absent,
        "cam_clay: specific volume 1 + e on the virgin line at 1 kPa, often called N",
    ),
    every(
        "material.continuum.preconsolidation_kPa",
        Number(POSITIVE),
        Absent,
        "cam_clay: largest isotropic pressure that is elastic at the start; the overconsolidation ratio is this over the mean stress at the start",
    ),
    every(
        "material.continuum.friction_evolution.law",
        EVOLUTION,
        Required,
        "how the friction angle follows the accumulated plastic strain: linear, or Li et al. 2023, eq. 43",
    ),
    every(
        "material.continuum.friction_evolution.last_deg",
        Number(DEGREES),
        Absent,
        "linear: friction angle at the end; or `last_rad`",
    ),
    every(
        "material.continuum.friction_evolution.last_rad",
        Number(RADIANS),
        Absent,
        "linear: friction angle at the end; or `last_deg`",
    ),
    every(
        "material.continuum.friction_evolution.plastic_strain",
        Number(POSITIVE),
        Absent,
        "linear: plastic strain from which on the last value holds",
    ),
    every(
        "material.continuum.friction_evolution.cubic_rad",
        Numbers(ANY, Some(4)),
        Absent,
        "eq. 43: [a, b, c, d] of the friction angle in rad, up to the peak",
    ),
    every(
        "material.continuum.friction_evolution.peak_plastic_strain",
        Number(POSITIVE),
        Absent,
        "eq. 43: plastic strain at the peak",
    ),
    every(
        "material.continuum.friction_evolution.peak_deg",
        Number(DEGREES),
        Absent,
        "eq. 43: friction angle behind the peak; or `peak_rad`",
    ),
    every(
        "material.continuum.friction_evolution.peak_rad",
        Number(RADIANS),
        Absent,
        "eq. 43: friction angle behind the peak; or `peak_deg`",
    ),
    every(
        "material.continuum.friction_evolution.residual_deg",
        Number(DEGREES),
        Absent,
        "eq. 43: residual friction angle; or `residual_rad`",
    ),
    every(
        "material.continuum.friction_evolution.residual_rad",
        Number(RADIANS),
        Absent,
        "eq. 43: residual friction angle; or `residual_deg`",
    ),
    every("material.continuum.friction_evolution.decay", Number(POSITIVE), Absent, "eq. 43: softening rate H per plastic strain"),
    every(
        "material.continuum.cohesion_evolution.law",
        EVOLUTION,
        Required,
        "how the cohesion follows the accumulated plastic strain: linear, or as Li et al. 2023, eq. 43",
    ),
    every("material.continuum.cohesion_evolution.last_kPa", Number(NOT_NEGATIVE), Absent, "linear: cohesion at the end"),
    every(
        "material.continuum.cohesion_evolution.plastic_strain",
        Number(POSITIVE),
        Absent,
        "linear: plastic strain from which on the last value holds",
    ),
    every(
        "material.continuum.cohesion_evolution.cubic_kPa",
        Numbers(ANY, Some(4)),
        Absent,
        "as eq. 43: [a, b, c, d] of the cohesion, up to the peak",
    ),
    every(
        "material.continuum.cohesion_evolution.peak_plastic_strain",
        Number(POSITIVE),
        Absent,
        "as eq. 43: plastic strain at the peak",
    ),
    every("material.continuum.cohesion_evolution.peak_kPa", Number(NOT_NEGATIVE), Absent, "as eq. 43: cohesion behind the peak"),
    every("material.continuum.cohesion_evolution.residual_kPa", Number(NOT_NEGATIVE), Absent, "as eq. 43: residual cohesion"),
    every(
        "material.continuum.cohesion_evolution.decay",
        Number(POSITIVE),
        Absent,
        "as eq. 43: softening rate H per plastic strain",
    ),
];

/// Whether `path` is a table: whether there are keys whose dotted path begins with `path` and a dot.
pub fn is_table(path: &str) -> bool {
    static TABLES: LazyLock<HashSet<&str>> =
        LazyLock::new(|| KEYS.iter().flat_map(|k| k.path.match_indices('.').map(|(end, _)| &k.path[..end])).collect());
    TABLES.contains(path)
}

/// The keys that stand directly in the table `path`, in the order of [`KEYS`].
pub fn keys_in(path: &str) -> &'static [&'static Key] {
    static BY_TABLE: LazyLock<HashMap<&str, Vec<&'static Key>>> = LazyLock::new(|| {
        let mut tables: HashMap<&str, Vec<&'static Key>> = HashMap::new();
        KEYS.iter().for_each(|key| tables.entry(key.split().0).or_default().push(key));
        tables
    });
    BY_TABLE.get(path).map_or(&[], Vec::as_slice)
}

/// Names of the keys and sub-tables that may stand directly in the table `path` (`""`: the top level) of a scene of the kind `of`,
/// in the order of [`KEYS`]. At the top level `materials` comes last, for the kinds of scenes that may have several materials.
pub fn names_in(path: &str, of: Of) -> Vec<&'static str> {
    let fits = |k: &&Key| k.of.fits(of);
    let mut names: Vec<&str> = Vec::new();
    for key in KEYS.iter().filter(fits) {
        let rest = match path {
            "" => Some(key.path),
            _ => key.path.strip_prefix(path).and_then(|r| r.strip_prefix('.')),
        };
        let Some(rest) = rest else { continue };
        let name = rest.split('.').next().unwrap_or(rest);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    if path.is_empty() && (of == Of::Every || !Of::Cylinder.fits(of)) {
        names.push("materials");
    }
    names
}

/// The key with the dotted path `path`, without list indices (`wall.kind`); `None` where there is none.
pub fn find(path: &str) -> Option<&'static Key> {
    static BY_PATH: LazyLock<HashMap<&str, &'static Key>> = LazyLock::new(|| KEYS.iter().map(|key| (key.path, key)).collect());
    BY_PATH.get(path).copied()
}

/// Text that `comminute check --keys` prints: every key with its meaning, allowed values, default and kinds of scenes, table by
/// table.
pub fn reference() -> String {
    const HEAD: &str = "\
Keys of scenes and materials. A key that holds a dimension ends in its unit (_mm, _m, _kPa, _MPa, _GPa, _rad, _s, …).
A scene names its material by a path relative to itself (material = \"../../materials/x.toml\"), or holds it
as a table [material], whose keys are those listed under material. A free scene, a continuum or a mixture with several
materials holds them as [materials.NAME], a platen test of elastic platens as [materials.grain] and [materials.platen].
`base = \"other.toml\"` takes every key of another file, and keys written beside it replace those of that file; it works
in scenes, materials and [material]. Every table may hold
`source`, a text for the whole table or one per key (source.nu = \"…\"); a source that begins with
\"assumed\" is listed by `comminute check`.
";
    let mut text = HEAD.to_string();
    let mut table = "-";
    for key in KEYS.iter() {
        let (parent, name) = key.split();
        if parent != table {
            table = parent;
            let list = LIST_TABLES.contains(&table);
            text += &match (table, list) {
                ("", _) => "\n".to_string(),
                (_, true) => format!("\n[[{table}]]\n"),
                _ => format!("\n[{table}]\n"),
            };
        }
        let of = match key.scenes().as_str() {
            "" => String::new(),
            kinds => format!("; {kinds}"),
        };
        text += &format!("  {name}: {}\n      {} ({}{of})\n", key.what, key.shape.text(), key.default_text());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_default_is_allowed_by_its_own_key() {
        for key in KEYS.iter() {
            for kind in [Of::Oedometer, Of::Assembly, Of::GrainCrushing, Of::Continuum] {
                if let Some(value) = key.default_for(kind) {
                    assert!(key.shape.accept(value).is_ok(), "{}", key.path);
                } else {
                    assert!(matches!(key.default, Required | Absent), "{}", key.path);
                }
            }
        }
    }

    #[test]
    fn keys_are_unique_and_tables_stand_together() {
        let mut seen: Vec<&str> = Vec::new();
        for key in KEYS.iter() {
            let (table, _) = key.split();
            match seen.last() {
                Some(last) if *last == table => {}
                _ => {
                    assert!(!seen.contains(&table), "{table} is scattered");
                    seen.push(table);
                }
            }
            assert_eq!(KEYS.iter().filter(|k| k.path == key.path).count(), 1);
        }
    }
}
