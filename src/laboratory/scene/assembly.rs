//! Makes [`Assembly`] from the grains and walls of a free scene.

use super::material::Named;
use super::schema::unit;
use super::view::View;
use crate::model::{Assembly, GrainSpec};
use engine::boundary::{Drive, WallShape, WallSpec};
use engine::neighbours::overlap::{Overlap, first_deeper_than};
use std::collections::HashMap;
use toml::{Table, Value};

/// Key of the largest overlap of listed grains at the start, over the smaller radius.
const OVERLAP: &str = "records.largest_overlap_at_start";

impl View<'_> {
    pub fn assembly(&self, named: &[Named]) -> Option<Assembly> {
        let grains = self.grains(named)?;
        let walls = self.walls(named, &grains);
        let (steps, duration) = (self.whole("steps"), self.number("duration_s"));
        self.check(steps.is_some() != duration.is_some(), "steps", "must be given, or `duration_s`, one of them");
        Some(Assembly {
            tracks: self.tracks(grains.len()),
            grains,
            walls,
            steps,
            duration,
            above_bound: self.flag("stepping.above_bound"),
            record_every: self.whole("records.every")?,
        })
    }

    /// The walls that the scene lists; grains that do not lie inside them are refused.
    pub fn walls(&self, named: &[Named], grains: &[GrainSpec]) -> Vec<WallSpec> {
        let walls: Vec<WallSpec> =
            self.list("wall").iter().enumerate().filter_map(|(i, wall)| self.wall(i, wall, named)).flatten().collect();
        self.inside(grains, &walls);
        walls
    }

    /// The grains that the scene lists.
    pub fn grains(&self, named: &[Named]) -> Option<Vec<GrainSpec>> {
        let tables = self.list("grain");
        if tables.is_empty() {
            let message = "is missing: list grains as [[grain]], or name a file, grains_csv = \"….csv\"";
            self.refuse("grain", message);
            return None;
        }
        let mut places = HashMap::with_capacity(tables.len());
        let mut grains = Vec::with_capacity(tables.len());
        for (i, table) in tables.iter().enumerate() {
            let grain = GrainSpec {
                position: vector(table, "position_m")?,
                radius: number(table, "radius_m")?,
                velocity: vector(table, "velocity_m_s")?,
                spin: vector(table, "spin_rad_s")?,
                material: self.material_of(&format!("grain[{i}].material"), table, named)?,
            };
            if !self.turning() && grain.spin != [0.0; 3] {
                self.refuse(&format!("grain[{i}].spin_rad_s"), "must be [0, 0, 0] where contact.rotation = \"fixed\"");
                return None;
            }
            if let Some(first) = places.insert(grain.position.map(f64::to_bits), i) {
                self.refuse(&format!("grain[{i}].position_m"), format!("is also that of grain {first}"));
                return None;
            }
            grains.push(grain);
        }
        self.apart(&grains);
        Some(grains)
    }

    /// Refuses listed grains that overlap deeply: they would be thrown apart, or break, in the first steps.
    fn apart(&self, grains: &[GrainSpec]) {
        let allowed = self.si(OVERLAP);
        let places: Vec<[f64; 4]> = grains.iter().map(|g| [g.position[0], g.position[1], g.position[2], g.radius]).collect();
        if let Some(Overlap { grains: [i, j], share }) = first_deeper_than(allowed, &places) {
            let message = format!(
                "grains {i} (radius {:?} m) and {j} (radius {:?} m) overlap by {share:.3} of the smaller radius, more than {OVERLAP} = {allowed}: correct positions or radii, or raise that key",
                grains[i].radius, grains[j].radius
            );
            self.refuse(&format!("grain[{j}].position_m"), message);
        }
    }

    /// The material that an entry of a list names at `key`. In a scene with one material it may be left out.
    pub fn material_of(&self, key: &str, table: &Table, named: &[Named]) -> Option<u8> {
        match table.get("material").and_then(Value::as_str) {
            None if named.len() == 1 => Some(0),
            None => {
                let message = format!("is missing: the scene has several, {}", names(named));
                self.refuse(key, message);
                None
            }
            Some(name) => self.lookup(key, name, named),
        }
    }

    /// A material by name, or by number where none has that name.
    pub fn lookup(&self, key: &str, name: &str, named: &[Named]) -> Option<u8> {
        let by_name = named.iter().position(|n| n.name == name);
        let number = name.parse::<usize>().ok().filter(|i| *i < named.len());
        let found = by_name.or(number).and_then(|i| u8::try_from(i).ok());
        if found.is_none() {
            let message = format!("\"{name}\" is no material of the scene; there are {}", names(named));
            self.refuse(key, message);
        }
        found
    }

    /// One wall, or the six of a box.
    fn wall(&self, i: usize, table: &Table, named: &[Named]) -> Option<Vec<WallSpec>> {
        let at = |name: &str| format!("wall[{i}].{name}");
        let kind = table.get("kind").and_then(Value::as_str)?;
        let needed: &[&str] = match kind {
            "plane" => &["point_m", "normal"],
            "cylinder" => &["centre_m", "radius_m"],
            _ => &["min_m", "max_m"],
        };
        let mut good = true;
        for name in ["point_m", "normal", "centre_m", "radius_m", "min_m", "max_m"] {
            let (wanted, given) = (needed.contains(&name), table.contains_key(name));
            if wanted && !given {
                self.refuse(&at(name), format!("is missing: a {kind} needs it"));
            } else if given && !wanted {
                self.refuse(&at(name), format!("has no meaning for a {kind}"));
            }
            good &= wanted == given;
        }
        let drive = self.drive(i, table, kind);
        let material = match table.get("material").and_then(Value::as_str) {
            None | Some("rigid") => Some(None),
            Some(name) => self.lookup(&at("material"), name, named).map(Some),
        };
        let shapes = good.then(|| self.shapes(i, table, kind)).flatten();
        let (drive, material, friction) = (drive?, material?, number(table, "friction")?);
        let wall = |shape| WallSpec { shape, friction, drive, material };
        Some(shapes?.into_iter().map(wall).collect())
    }

    fn shapes(&self, i: usize, table: &Table, kind: &str) -> Option<Vec<WallShape>> {
        let at = |name: &str| format!("wall[{i}].{name}");
        match kind {
            "plane" => {
                let [x, y, z] = vector(table, "normal")?;
                let length = (x * x + y * y + z * z).sqrt();
                if length == 0.0 {
                    self.refuse(&at("normal"), "must not be zero");
                    return None;
                }
                Some(vec![WallShape::Plane { point: vector(table, "point_m")?, normal: [x / length, y / length, z / length] }])
            }
            "cylinder" => Some(vec![WallShape::Cylinder {
                centre: numbers(table, "centre_m")?.try_into().ok()?,
                radius: number(table, "radius_m")?,
            }]),
            _ => {
                let (min, max) = (vector(table, "min_m")?, vector(table, "max_m")?);
                if (0..3).any(|k| max[k] <= min[k]) {
                    self.refuse(&at("max_m"), "must be above min_m in x, y and z");
                    return None;
                }
                let side = |point: [f64; 3], k: usize, sign: f64| {
                    let mut normal = [0.0; 3];
                    normal[k] = sign;
                    WallShape::Plane { point, normal }
                };
                let sides = (0..3).flat_map(|k| [side(min, k, 1.0), side(max, k, -1.0)]);
                Some(sides.collect())
            }
        }
    }

    fn drive(&self, i: usize, table: &Table, kind: &str) -> Option<Drive> {
        let at = |name: &str| format!("wall[{i}].{name}");
        let (velocity, stress) = (number(table, "velocity_m_s"), number(table, "stress_kPa"));
        let (area, gain) = (number(table, "area_m2"), number(table, "gain")?);
        let driven = velocity.is_some() || stress.is_some();
        if kind == "box" && driven {
            let name = if velocity.is_some() { "velocity_m_s" } else { "stress_kPa" };
            self.refuse(&at(name), "has no meaning for a box: write the moving side as a plane");
            return None;
        }
        if stress.is_none() && table.contains_key("max_velocity_m_s") {
            self.refuse(&at("max_velocity_m_s"), "has no meaning without stress_kPa");
            return None;
        }
        if stress.is_none() && area.is_some() {
            self.refuse(&at("area_m2"), "has no meaning without stress_kPa");
            return None;
        }
        match (velocity, stress) {
            (Some(_), Some(_)) => {
                self.refuse(&at("velocity_m_s"), "must not stand beside stress_kPa");
                None
            }
            (Some(velocity), None) => Some(Drive::Velocity(velocity)),
            (None, None) => Some(Drive::Fixed),
            (None, Some(stress)) => {
                if kind == "plane" && area.is_none() {
                    self.refuse(&at("area_m2"), "is missing: a plane with stress_kPa needs it");
                    return None;
                }
                if kind == "cylinder" && area.is_some() {
                    self.refuse(&at("area_m2"), "has no meaning for a cylinder: its own is used");
                    return None;
                }
                Some(Drive::Stress { stress, area: area.unwrap_or(0.0), gain, fastest: number(table, "max_velocity_m_s") })
            }
        }
    }

    /// Refuses grains behind a wall, or deep in one: they would be thrown out.
    fn inside(&self, grains: &[GrainSpec], walls: &[WallSpec]) {
        let allowed = self.si(OVERLAP);
        for (i, grain) in grains.iter().enumerate() {
            let (p, r) = (grain.position, grain.radius);
            let distance = walls.iter().map(|w| w.shape.towards([p[0], p[1], p[2], 0.0]).1).fold(f64::INFINITY, f64::min);
            let overlap = 1.0 - distance / r;
            let message = if distance <= 0.0 {
                format!("grain {i} lies behind a wall, at {p:?}")
            } else {
                format!(
                    "grain {i} of radius {r:?} m overlaps a wall by {overlap:.3} of its radius, more than {OVERLAP} = {allowed}: correct its position or radius, or raise that key"
                )
            };
            if distance <= 0.0 || overlap > allowed {
                self.refuse(&format!("grain[{i}].position_m"), message);
                return;
            }
        }
    }

    fn tracks(&self, count: usize) -> Vec<u32> {
        let Some(Value::Array(list)) = self.get("records.tracks") else {
            return (0..count as u32).collect();
        };
        let tracks: Vec<u32> = list.iter().filter_map(Value::as_integer).filter_map(|i| u32::try_from(i).ok()).collect();
        if let Some(bad) = tracks.iter().find(|i| **i as usize >= count) {
            let last = count.saturating_sub(1);
            let message = format!("there is no grain {bad}; they go from 0 to {last}");
            self.refuse("records.tracks", message);
        }
        tracks
    }
}

fn number(table: &Table, key: &str) -> Option<f64> {
    table.get(key)?.as_float().map(|x| x * unit(key))
}

fn numbers(table: &Table, key: &str) -> Option<Vec<f64>> {
    table.get(key)?.as_array()?.iter().map(Value::as_float).collect()
}

fn vector(table: &Table, key: &str) -> Option<[f64; 3]> {
    numbers(table, key)?.try_into().ok()
}

fn names(named: &[Named]) -> String {
    let names: Vec<&str> = named.iter().map(|n| n.name.as_str()).collect();
    names.join(", ")
}
