//! Random rigid bodies that fill a box: their shapes and places from the keys of `[[block_set]]`.

use super::bodies::{number, vector};
use super::layers::PackedFrom;
use super::material::Named;
use super::view::View;
use crate::packing::blocks::pack;
use crate::packing::shapes::{Form, Shapes};
use engine::material::Material;
use engine::mpm::Points;
use engine::rigid::Block;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use toml::{Table, Value};

/// Share of the box beyond which bodies are not tried to be packed.
const FULL: f64 = 0.98;

impl View<'_> {
    /// The bodies of all sets, at rest where they start; `None`, with the reasons noted, where the scene is refused.
    pub fn block_sets(&self, named: &[Named], materials: &[Material]) -> Option<Vec<Block>> {
        let tables = self.list("block_set");
        let sets: Vec<Option<Vec<Block>>> =
            tables.iter().enumerate().map(|(i, t)| self.block_set(i, t, named, materials)).collect();
        Some(sets.into_iter().collect::<Option<Vec<_>>>()?.into_iter().flatten().collect())
    }

    fn block_set(&self, i: usize, table: &Table, named: &[Named], materials: &[Material]) -> Option<Vec<Block>> {
        let at = |name: &str| format!("block_set[{i}].{name}");
        let flat = self.flag("grid.plane_strain");
        let kind = table.get("shape").and_then(Value::as_str)?;
        let message = if flat { "must be \"polygon\" in plane strain" } else { "\"polygon\" needs grid.plane_strain = true" };
        self.check((kind == "polygon") == flat, &at("shape"), message);
        let material = self.material_of(&at("material"), table, named)?;
        let range = |name: &str| -> Option<[f64; 2]> {
            let [low, high]: [f64; 2] = self.numbers(&at(name)).try_into().ok()?;
            self.check(low <= high, &at(name), "must be the least, then the largest");
            (low <= high).then_some([low, high])
        };
        let (diameter, elongation, flatness) = (range("diameter_mm")?, range("elongation")?, range("flatness")?);
        let form = if table.contains_key("outline_points") || table.contains_key("outline_corners") {
            for (key, unused) in [
                ("corners", !table.contains_key("corners")),
                ("elongation", elongation == [1.0; 2]),
                ("flatness", flatness == [1.0; 2]),
            ] {
                self.check(unused, &at(key), "has no meaning beside outlines, which have corners and shapes of their own");
            }
            self.outlines(&at, flat)?
        } else if table.contains_key("corners") {
            let (corners, fewest) = (range("corners")?, if flat { 3.0 } else { 4.0 });
            self.check(
                corners.iter().all(|n| n.fract() == 0.0 && *n >= fewest),
                &at("corners"),
                format!("must be whole numbers from {fewest} on for shape = \"{kind}\""),
            );
            Form::Random { corners: corners.map(|n| n as u32), elongation, flatness }
        } else {
            self.refuse(&at("corners"), "is missing: give the least and largest number of corners, or outlines_csv = \"….csv\"");
            return None;
        };
        let (low, high) = (vector(table, "min_mm")?, vector(table, "max_mm")?);
        let axes = if flat { 2 } else { 3 };
        if (0..axes).any(|a| high[a] <= low[a]) {
            self.refuse(&at("max_mm"), "must be above min_mm along every axis");
            return None;
        }
        let shapes = Shapes { flat, diameter, form, rounding: number(table, "rounding")? };
        let count = table.get("count").and_then(Value::as_integer)?;
        let (seed, density) = (self.whole("seed.packing")?, materials[usize::from(material)].density);
        let from = PackedFrom { table: table.clone(), random: (i, seed), material: (material, density), flat };
        if let Some(blocks) = self.packed(&from) {
            return Some(blocks);
        }
        // sets are independent of each other
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(i as u64);
        let mut blocks = Vec::new();
        for _ in 0..count {
            match shapes.draw(&mut rng) {
                Ok(shape) => blocks.push(Block::new(shape, density, material)),
                Err(message) => {
                    self.refuse(&at("rounding"), format!("does not go with these shapes: they {message}"));
                    return None;
                }
            }
        }
        let filled = blocks.iter().map(|b| b.mass / density).sum::<f64>() / (0..axes).map(|a| high[a] - low[a]).product::<f64>();
        let reach = blocks.iter().map(|b| 2.0 * b.solid().reach()).fold(0.0, f64::max);
        let fits = (0..axes).all(|a| reach < high[a] - low[a]);
        self.check(fits, &at("max_mm"), format!("leaves no room: a body of the set is {:.4} mm long", 1e3 * reach));
        let full = |left: String| format!("is too large: the bodies would fill {:.1} % of the box{left}", 100.0 * filled);
        if filled > FULL {
            self.refuse(&at("count"), full(String::new()));
        }
        if !fits || filled > FULL {
            return None;
        }
        match pack(blocks, [low, high], flat, &mut rng) {
            Ok(blocks) => {
                self.keep_packed(from, &blocks);
                Some(blocks)
            }
            Err(left) => {
                let left = format!(", and overlap by up to {:.4} mm", 1e3 * left);
                self.refuse(&at("count"), full(left));
                None
            }
        }
    }

    /// The outlines of a set; `None`, with the reason noted, where they are refused.
    fn outlines(&self, at: &impl Fn(&str) -> String, flat: bool) -> Option<Form> {
        let (counts, numbers) = (self.numbers(&at("outline_corners")), self.numbers(&at("outline_points")));
        let whole = counts.iter().all(|n| n.fract() == 0.0);
        if !whole || 3.0 * counts.iter().sum::<f64>() != numbers.len() as f64 || counts.is_empty() {
            let message = format!(
                "must be the numbers of points of the outlines, in all a third of the {} numbers in outline_points",
                numbers.len()
            );
            self.refuse(&at("outline_corners"), message);
            return None;
        }
        let mut points = numbers.as_chunks::<3>().0.iter().copied();
        let outlines: Vec<Vec<[f64; 3]>> = counts.iter().map(|&n| points.by_ref().take(n as usize).collect()).collect();
        let refuse = |(k, wrong): (usize, &str)| {
            let message = format!("must be of bodies: outline {k} of {}, of {} points, {wrong}", outlines.len(), outlines[k].len());
            self.refuse(&at("outline_points"), message);
        };
        Form::listed(&outlines, flat).map_err(refuse).ok()
    }
}

/// Leaves out points in bodies, and points that would touch them: nearer to a body than `radius`, m, of the point's index.
pub fn make_room(points: &mut Points, blocks: &[Block], radius: impl Fn(&Points, usize) -> f64) {
    if blocks.is_empty() {
        return;
    }
    let posed: Vec<_> = blocks.iter().map(|b| (b.solid(), b.pose(0.0))).collect();
    let gone: Vec<bool> = (0..points.len())
        .map(|i| {
            let ([x, y, z, _], r) = (points.position[i], radius(points, i));
            posed.iter().any(|(solid, pose)| {
                let at = pose.within([x, y, z]);
                solid.clearance(at) < r && solid.nearest(at).distance < r
            })
        })
        .collect();
    points.drop_those(&gone);
}
