//! What is done to rigid bodies from outside: keys of `[[block]]` that move, push and hold a body, and `[[joint]]`, which joins two of them or one to the world.

use super::bodies::{number, vector};
use super::layers::Layer;
use super::number_file::Format;
use super::view::View;
use crate::error::{Error, Result};
use engine::math::vector::{dot, scaled};
use engine::rigid::{Block, Cement, Joint, Kind, Path, Programme, Push};
use engine::shape::Shape;
use std::path::Path as FilePath;
use toml::{Table, Value};

/// Keys of a block by which it follows a path.
const PATH: [&str; 5] = ["path_csv", "path_s", "path_mm", "path_deg", "path_axis"];
/// Keys of a block by which it is pushed.
const PUSH: [&str; 3] = ["force_N", "torque_N_m", "stress_kPa"];
/// Keys of a block by which what pushes it follows the time.
const SHARES: [&str; 3] = ["ramp_s", "push_s", "push_share"];
/// Largest distance of the first place of a path from the body's own, m.
const SAME_PLACE: f64 = 1e-9;

impl View<'_> {
    /// Whether a listed block follows a path.
    pub fn follows_a_path(&self, i: usize) -> bool {
        self.has(&format!("block[{i}].path_s"))
    }

    /// What is done to each of the bodies `blocks`, of which the listed ones come first. A body on a path becomes driven and starts with the velocity of the path.
    pub fn programmes(&self, blocks: &mut [Block]) -> Option<Vec<Programme>> {
        let tables = self.list("block");
        let made: Vec<Option<Programme>> =
            tables.iter().enumerate().zip(&mut *blocks).map(|((i, table), block)| self.programme(i, table, block)).collect();
        let mut made: Vec<Programme> = made.into_iter().collect::<Option<_>>()?;
        made.resize_with(blocks.len(), Programme::default);
        Some(made)
    }

    fn programme(&self, i: usize, table: &Table, block: &mut Block) -> Option<Programme> {
        let key = |name: &str| format!("block[{i}].{name}");
        let given = |names: &[&'static str]| names.iter().copied().find(|name| table.contains_key(*name));
        let (path, push, held, shares) = (given(&PATH), given(&PUSH), given(&["held"]), given(&SHARES));
        let Some(first) = path.or(push).or(held).or(shares) else { return Some(Programme::default()) };
        let breaks = self.flag("crushing.enabled");
        let message = "has no meaning with crushing.enabled = true: bodies that break are not driven along paths, pushed or held";
        self.check(!breaks, &key(first), message);
        if let (Some(_), Some(other)) = (path, push.or(held).or(shares)) {
            self.refuse(&key(other), "has no meaning for a block on a path, which goes where that says");
            return None;
        }
        if path.is_some() {
            let path = self.path(i, table, block)?;
            block.driven = true;
            let [velocity, spin] = path.first_motion();
            block.velocity = velocity;
            block.set_spin(spin);
            return Some(Programme { path: Some(path), ..Programme::default() });
        }
        if let (true, Some(name)) = (block.driven, push.or(held)) {
            self.refuse(&key(name), "has no meaning with driven = true: such a block keeps its velocity whatever acts on it");
            return None;
        }
        if let (None, Some(name)) = (push, shares) {
            self.refuse(&key(name), "has no meaning without force_N, torque_N_m or stress_kPa");
        }
        let word = |word: &str| {
            self.get(&key("held")).and_then(Value::as_array).is_some_and(|list| list.iter().any(|w| w.as_str() == Some(word)))
        };
        Some(Programme {
            path: None,
            push: self.push(i, table, block)?,
            held: ["x", "y", "z"].map(word),
            held_turn: word("rotation"),
        })
    }

    fn push(&self, i: usize, table: &Table, block: &Block) -> Option<Push> {
        let key = |name: &str| format!("block[{i}].{name}");
        let of = |name: &str| vector(table, name).unwrap_or_default();
        let (mut force, torque, flat) = (of("force_N"), of("torque_N_m"), self.flag("grid.plane_strain"));
        if flat {
            self.check(force[2] == 0.0, &key("force_N"), "must have 0 along z in plane strain");
            self.check(torque[..2] == [0.0; 2], &key("torque_N_m"), "must have 0 along x and y in plane strain");
        }
        let turns = self.turning() || torque == [0.0; 3];
        self.check(turns, &key("torque_N_m"), "must be [0, 0, 0] where contact.rotation = \"fixed\"");
        if let Some(stress) = vector(table, "stress_kPa") {
            let square = number(table, "angle_deg") == Some(0.0);
            let Shape::Box(cuboid) = &block.shape else {
                self.refuse(
                    &key("stress_kPa"),
                    "needs shape = \"box\": of other shapes write force_N, the stress times the area that you mean",
                );
                return None;
            };
            self.check(square, &key("stress_kPa"), "needs angle_deg = 0: the areas are those of the box's sides across x, y and z");
            let [a, b, c] = cuboid.half.map(|half| 2.0 * half);
            for (f, (s, area)) in force.iter_mut().zip(stress.into_iter().zip([b * c, c * a, a * b])) {
                *f += s * area;
            }
        }
        let (times, shares) = self.shares(i, table)?;
        Some(Push { force, torque, times, shares })
    }

    /// Times, s, of the table that what pushes block `i` follows, and its share at each.
    fn shares(&self, i: usize, table: &Table) -> Option<(Vec<f64>, Vec<f64>)> {
        let key = |name: &str| format!("block[{i}].{name}");
        let ramp = number(table, "ramp_s").filter(|ramp| *ramp > 0.0);
        let named = SHARES[1..].iter().find(|name| table.contains_key(**name));
        let Some(named) = named else {
            return Some(ramp.map_or((vec![], vec![]), |ramp| (vec![0.0, ramp], vec![0.0, 1.0])));
        };
        if table.contains_key("ramp_s") {
            self.refuse(&key(named), "must not stand beside ramp_s, which is the table from 0 to 1");
            return None;
        }
        let (times, shares) = (self.numbers(&key("push_s")), self.numbers(&key("push_share")));
        if times.is_empty() || times.len() != shares.len() {
            let message = format!("must be times and as many shares: push_s has {}, push_share has {}", times.len(), shares.len());
            self.refuse(&key(named), message);
            return None;
        }
        self.rises(&key("push_s"), &times).then_some((times, shares))
    }

    /// Whether times rise from row to row; else it is refused.
    fn rises(&self, key: &str, times: &[f64]) -> bool {
        let falls = times.windows(2).position(|w| w[1] <= w[0]);
        if let Some(k) = falls {
            self.refuse(key, format!("must rise from row to row: row {} is not later than the row before", k + 1));
        }
        falls.is_none()
    }

    fn path(&self, i: usize, table: &Table, block: &Block) -> Option<Path> {
        let key = |name: &str| format!("block[{i}].{name}");
        let times = self.numbers(&key("path_s"));
        if times.is_empty() {
            self.refuse(&key("path_s"), "is missing: a path needs the times of its rows (or path_csv)");
            return None;
        }
        if !self.rises(&key("path_s"), &times) {
            return None;
        }
        let numbers = self.numbers(&key("path_mm"));
        let (places, rest) = numbers.as_chunks::<3>();
        let angles = if self.has(&key("path_deg")) { self.numbers(&key("path_deg")) } else { vec![0.0; times.len()] };
        if !rest.is_empty() || places.len() != times.len() {
            let message = format!(
                "must be x, y, z of the centre of mass at each time of path_s, one after the other: {} numbers; there are {}",
                3 * times.len(),
                numbers.len()
            );
            self.refuse(&key("path_mm"), message);
            return None;
        }
        if angles.len() != times.len() {
            let message = format!("must have an angle for each time of path_s, {}; there are {}", times.len(), angles.len());
            self.refuse(&key("path_deg"), message);
            return None;
        }
        let away = (0..3).map(|a| (places[0][a] - block.centre[a]).powi(2)).sum::<f64>().sqrt();
        self.check(away <= SAME_PLACE, &key("path_mm"), "must begin at position_mm, where the block stands at the start");
        self.check(angles[0] == 0.0, &key("path_deg"), "must begin with 0: angles count from how the block stands at the start");
        for name in ["velocity_m_s", "spin_rad_s"] {
            let still = vector(table, name).is_none_or(|v| v == [0.0; 3]);
            self.check(still, &key(name), "must be [0, 0, 0] for a block on a path, whose velocity is that of the path");
        }
        let axis = vector(table, "path_axis").unwrap_or([0.0, 0.0, 1.0]);
        if axis == [0.0; 3] {
            self.refuse(&key("path_axis"), "must not be zero");
            return None;
        }
        let turns = angles.iter().any(|angle| *angle != 0.0);
        if turns && !self.turning() {
            self.refuse(&key("path_deg"), "must be 0 where contact.rotation = \"fixed\"");
        }
        if self.flag("grid.plane_strain") {
            self.check(places.iter().all(|p| p[2] == 0.0), &key("path_mm"), "must have 0 along z in plane strain");
            self.check(axis[..2] == [0.0; 2], &key("path_axis"), "must be [0, 0, 1] in plane strain");
        }
        let axis = scaled(axis, 1.0 / dot(axis, axis).sqrt());
        Some(Path { times, places: places.to_vec(), angles, axis, turn: block.turn })
    }

    /// The joints of the scene between the bodies `blocks`, of which the listed ones come first.
    pub fn joints(&self, blocks: &[Block]) -> Option<Vec<Joint>> {
        let tables = self.list("joint");
        let listed = self.list("block").len();
        let joint = |(k, table): (usize, &&Table)| self.joint(k, table, blocks, listed);
        let made: Vec<Option<Joint>> = tables.iter().enumerate().map(joint).collect();
        made.into_iter().collect()
    }

    fn joint(&self, k: usize, table: &Table, blocks: &[Block], listed: usize) -> Option<Joint> {
        let key = |name: &str| format!("joint[{k}].{name}");
        let kind = match self.text(&key("kind")) {
            "glue" => Kind::Glue,
            "hinge" => Kind::Hinge,
            _ => Kind::Ball,
        };
        let breaks = self.flag("crushing.enabled");
        self.check(!breaks, &key("kind"), "has no meaning with crushing.enabled = true: bodies that break are not joined");
        let list = self.get(&key("blocks")).and_then(Value::as_array).into_iter().flatten();
        let ends: Vec<usize> = list.filter_map(Value::as_integer).map(|k| k as usize).collect();
        let message = match ends[..] {
            [a] | [a, _] if a >= listed => Some(format!("there is no [[block]] {a}; there are {listed}, from 0")),
            [_, b] if b >= listed => Some(format!("there is no [[block]] {b}; there are {listed}, from 0")),
            [a, b] if a == b => Some("must be two blocks, or one that is joined to the world".into()),
            [a] if blocks[a].driven => Some(format!("block {a} is driven, so nothing joins it to the world")),
            [a, b] if blocks[a].driven && blocks[b].driven => Some("both are driven: what joins them moves neither".into()),
            [_] | [_, _] => None,
            _ => Some(format!("must be two blocks, or one that is joined to the world; there are {}", ends.len())),
        };
        if let Some(message) = message {
            self.refuse(&key("blocks"), message);
            return None;
        }
        let (place, flat) = (vector(table, "position_mm")?, self.flag("grid.plane_strain"));
        let axis = match (vector(table, "axis"), kind) {
            (Some(_), Kind::Ball) => {
                self.refuse(&key("axis"), "has no meaning for a ball joint, which turns every way");
                return None;
            }
            (Some(axis), _) => axis,
            (None, Kind::Hinge) if !flat => {
                self.refuse(&key("axis"), "is missing: a hinge needs the axis about which it turns");
                return None;
            }
            (None, Kind::Glue) => {
                self.refuse(&key("axis"), "is missing: glue needs the direction across the glued face, along which it is pulled");
                return None;
            }
            (None, _) => [0.0, 0.0, 1.0],
        };
        if axis == [0.0; 3] {
            self.refuse(&key("axis"), "must not be zero");
            return None;
        }
        if flat {
            self.check(place[2] == 0.0, &key("position_mm"), "must have 0 along z in plane strain");
            let good = if kind == Kind::Glue { axis[2] == 0.0 } else { axis[..2] == [0.0; 2] };
            let message =
                if kind == Kind::Glue { "must have 0 along z in plane strain" } else { "must be [0, 0, 1] in plane strain" };
            self.check(good, &key("axis"), message);
        }
        for name in ["tension_MPa", "shear_MPa"] {
            let meant = kind == Kind::Glue || !table.contains_key(name);
            self.check(meant, &key(name), "has no meaning but for glue: hinges and ball joints do not break");
        }
        let strength = ["tension_MPa", "shear_MPa"].map(|name| number(table, name).unwrap_or(f64::INFINITY));
        let cement = Cement {
            radius: number(table, "radius_mm")?,
            thickness: number(table, "thickness_mm")?,
            young: number(table, "E_MPa")?,
            poisson: number(table, "nu")?,
            damping: number(table, "damping")?,
            strength,
        };
        let index = |k: usize| ends.get(k).map(|&k| k as u32);
        Some(Joint::new(blocks, [index(0), index(1)], kind, place, axis, &cement, flat))
    }
}

/// Whether a joint holds bodies `i` and `j` together, which then do not touch.
pub fn joined(joints: &[Joint], i: usize, j: usize) -> bool {
    joints.iter().any(|joint| joint.bond.partner(i as u32) == Some(Some(j as u32)))
}

/// Most rows of a path in a file: as many as a scene can list.
const MOST: usize = super::files::MOST_VALUES / 5;
/// Columns of a path, the key that each becomes with its place there, and what takes it into the unit of that key.
const COLUMNS: [(&str, usize, f64); 8] = [
    ("time_s", 0, 1.0),
    ("x_mm", 1, 1.0),
    ("y_mm", 2, 1.0),
    ("z_mm", 3, 1.0),
    ("x_m", 1, 1e3),
    ("y_m", 2, 1e3),
    ("z_m", 3, 1e3),
    ("angle_deg", 4, 1.0),
];

/// Replaces `path_csv` of each block by what its file holds, so that a resolved scene needs no other file.
///
/// # Errors
/// A file that cannot be read, or has no columns of a path; a path that is written as well.
pub fn paths(layer: &mut Layer) -> Result<()> {
    let count = layer.table.get("block").and_then(Value::as_array).map_or(0, Vec::len);
    for i in 0..count {
        let origin = layer.origin(&format!("block[{i}].path_csv"));
        let Some(block) = layer.table.get_mut("block").and_then(|b| b.get_mut(i)).and_then(Value::as_table_mut) else { continue };
        let Some(Value::String(name)) = block.get("path_csv").cloned() else { continue };
        if ["path_s", "path_mm", "path_deg"].iter().any(|key| block.contains_key(*key)) {
            return Err(Error::input(origin.place, origin.key, Some(name), "must not stand beside path_s, path_mm and path_deg"));
        }
        let [times, places, angles] = read(FilePath::new(&name))?;
        block.remove("path_csv");
        let list = |values: Vec<f64>| Value::Array(values.into_iter().map(Value::Float).collect());
        if !angles.is_empty() {
            block.insert("path_deg".into(), list(angles));
        }
        block.insert("path_s".into(), list(times));
        block.insert("path_mm".into(), list(places));
    }
    Ok(())
}

/// Times, s, places, mm, one after the other, and angles, degrees, of the file `path`; no angles where it has none.
fn read(path: &FilePath) -> Result<[Vec<f64>; 3]> {
    let words = "time_s, x_mm, y_mm, z_mm (or _m), and may be angle_deg";
    let table = Format::<5> { columns: &COLUMNS, needed: 4, positive: 5, label: "", rows: "rows", words, most: MOST }.read(path)?;
    let of = |what: usize| table.rows.iter().map(|row| row.numbers[what]).collect();
    let places = table.rows.iter().flat_map(|row| [row.numbers[1], row.numbers[2], row.numbers[3]]).collect();
    Ok([of(0), places, if table.has[4] { of(4) } else { Vec::new() }])
}
