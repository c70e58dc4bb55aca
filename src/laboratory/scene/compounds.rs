//! Makes compounds from the parts of a `[[block]]`: keys of `[[block.part]]`.

use super::bodies::{number, vector};
use super::view::View;
use engine::rigid::motion::{about, axes};
use engine::shape::{Compound, Cuboid, Frame, Piece, PlacedCompound};
use toml::{Table, Value};

/// Most numbers of a part's points.
const MOST_NUMBERS: usize = 3000;

impl View<'_> {
    /// The compound of block `i`, about its centre of mass; `None`, with the reasons noted, where it is refused.
    pub fn compound(&self, i: usize) -> Option<PlacedCompound> {
        let key = format!("block[{i}].part");
        let list = self.get(&key)?;
        if let Some((_, placed)) = self.compounds.borrow().iter().find(|(parts, _)| *parts == list) {
            return Some(placed.clone());
        }
        let tables = self.list(&key);
        let pieces: Vec<Option<Piece>> = tables.iter().enumerate().map(|(k, t)| self.piece(&format!("{key}[{k}]"), t)).collect();
        let pieces: Vec<Piece> = pieces.into_iter().collect::<Option<_>>()?;
        match Compound::of(&pieces) {
            Ok(placed) => {
                self.compounds.borrow_mut().push((list, placed.clone()));
                Some(placed)
            }
            Err(message) => {
                self.refuse(&key, message);
                None
            }
        }
    }

    /// One part, whose keys begin with `at`.
    fn piece(&self, at: &str, table: &Table) -> Option<Piece> {
        let key = |name: &str| format!("{at}.{name}");
        let (kind, flat) = (table.get("shape").and_then(Value::as_str)?, self.flag("grid.plane_strain"));
        let mut good = (kind == "polygon") == flat;
        let message = if flat { "must be \"polygon\" in plane strain" } else { "\"polygon\" needs grid.plane_strain = true" };
        self.check(good, &key("shape"), message);
        for (name, wanted) in [("size_mm", kind == "box"), ("points_mm", kind != "box")] {
            let given = table.contains_key(name);
            if wanted && !given {
                self.refuse(&key(name), format!("is missing: shape = \"{kind}\" needs it"));
            } else if given && !wanted {
                self.refuse(&key(name), format!("has no meaning with shape = \"{kind}\""));
            }
            good &= wanted == given;
        }
        let rounded = table.contains_key("rounding_mm") && kind == "box";
        self.check(!rounded, &key("rounding_mm"), "has no meaning with shape = \"box\"");
        let (origin, axis) = (vector(table, "position_mm")?, vector(table, "axis")?);
        let upright = !flat || (axis[0] == 0.0 && axis[1] == 0.0);
        self.check(axis != [0.0; 3], &key("axis"), "must not be zero");
        self.check(upright, &key("axis"), "must be [0, 0, 1] in plane strain");
        self.check(!flat || origin[2] == 0.0, &key("position_mm"), "must have 0 along z in plane strain");
        if !good || rounded || axis == [0.0; 3] || !upright || (flat && origin[2] != 0.0) {
            return None;
        }
        let frame = Frame { origin, axes: axes(about(axis, number(table, "angle_deg")?)) };
        if kind == "box" {
            let half = vector(table, "size_mm")?.map(|x| 0.5 * x);
            return Some(Piece::cuboid(Cuboid { half }, frame));
        }
        let (numbers, rounding) = (self.numbers(&key("points_mm")), number(table, "rounding_mm").unwrap_or(0.0));
        let ([per, fewest], what) =
            if flat { ([2, 2], "x, y of each corner") } else { ([3, 12], "x, y, z of four points or more") };
        if numbers.len() % per != 0 || !(fewest..=MOST_NUMBERS).contains(&numbers.len()) {
            let message =
                format!("must be {what}, one after the other, {MOST_NUMBERS} numbers at most; there are {}", numbers.len());
            self.refuse(&key("points_mm"), message);
            return None;
        }
        let made = if flat {
            Piece::polygon(numbers.as_chunks::<2>().0, rounding, frame)
        } else {
            Piece::polyhedron(numbers.as_chunks::<3>().0, rounding, frame)
        };
        made.map_err(|message| self.refuse(&key("points_mm"), message)).ok()
    }
}
