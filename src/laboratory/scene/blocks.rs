//! Makes [`Block`]s from the rigid bodies of a mixture that are no spheres.

use super::bodies::{number, vector};
use super::driven::joined;
use super::material::Named;
use super::view::View;
use crate::model::continuum::{CoarseGrains, MpmTest};
use crate::rig::continuum::platens;
use engine::boundary::Wall;
use engine::material::Material;
use engine::mpm::loading_plate::ghost_radius;
use engine::rigid::motion::{about, product, quaternion};
use engine::rigid::{Block, Programme, parts_of};
use engine::shape::{Compound, Cuboid, Polygon, Polyhedron, Shape, Sheet, Solid, Superquadric};
use toml::{Table, Value};

/// Fewest and most numbers of a polyhedron's points: four points, and a thousand.
const FOUR_POINTS: usize = 12;
const MOST_NUMBERS: usize = 3000;
/// Overlap of two bodies at the start, over the sum of the radii of their edges, up to which they may stand in each other.
const LAPPED: f64 = 0.5;
/// Depth, over the radius of the sphere of its volume, to which a body may stand in a wall at the start; over its own radius that to which a grain may stand in a mesh.
const DEEP: f64 = 0.01;
/// Overlap of a point with a mesh at the start, over the radius with which it touches, up to which it may stand there: points at the face of a body overlap by a fifth with what
/// it lies on.
const POINT_DEEP: f64 = 0.5;

impl View<'_> {
    /// The rigid bodies that the scene lists, as they start.
    pub fn blocks(&self, named: &[Named], materials: &[Material]) -> Option<Vec<Block>> {
        let tables = self.list("block");
        if !self.has_blocks() {
            return Some(Vec::new());
        }
        let blocks: Vec<Option<Block>> = tables.iter().enumerate().map(|(i, t)| self.block(i, t, named, materials)).collect();
        let mut blocks: Vec<Block> = blocks.into_iter().collect::<Option<_>>()?;
        blocks.extend(self.block_sets(named, materials)?);
        if self.flag("crushing.enabled") {
            self.blocks_can_break(&blocks);
        }
        Some(blocks)
    }

    /// Refuses bodies of a test that something else than its platens moves or holds.
    pub fn blocks_are_left_alone(&self, blocks: &[Block], programmes: &[Programme]) {
        for (k, (block, programme)) in blocks.iter().zip(programmes).enumerate() {
            let message = "must be a free body in a test: what is driven, pushed or held, and a mesh, is for test.rig = \"free\"";
            self.check(!block.driven && programme.is_none(), &format!("block[{k}]"), message);
            let still = block.velocity == [0.0; 3] && block.momentum == [0.0; 3];
            self.check(still, &format!("block[{k}]"), "must be at rest at the start of a test");
        }
    }

    /// Refuses crushing where a body cannot be cut, and spheres beside bodies that break.
    fn blocks_can_break(&self, blocks: &[Block]) {
        let alone = self.list("grain").is_empty();
        let key = "crushing.enabled";
        let message = "must be false where [[grain]] stands beside [[block]] or [[block_set]]: forces of blocks on spheres do not count for their breakage";
        self.check(alone, key, message);
        let mut seen: Vec<&Compound> = Vec::new();
        for (k, b) in blocks.iter().enumerate().filter(|(_, b)| !b.driven) {
            let stays = match &b.shape {
                Shape::Compound(compound) if seen.contains(&compound.as_ref()) => None,
                Shape::Compound(compound) => {
                    seen.push(compound);
                    parts_of(compound).err().map(|why| format!("cannot break into its parts: {why}"))
                }
                shape if [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].iter().any(|n| shape.cut(*n, 0.0).is_some()) => None,
                Shape::Superquadric(_) => Some("cannot be cut, for it has no corners".into()),
                _ => Some("cannot be cut, for its edges are too round to leave a hull on both sides of a cut".into()),
            };
            if let Some(why) = stays {
                return self.refuse(key, format!("must be false: block {k}, a {}, {why}", b.shape.name()));
            }
        }
    }

    fn block(&self, i: usize, table: &Table, named: &[Named], materials: &[Material]) -> Option<Block> {
        let at = |name: &str| format!("block[{i}].{name}");
        let kind = table.get("shape").and_then(Value::as_str)?;
        let needed: &[&str] = match kind {
            "box" => &["size_mm"],
            "superquadric" => &["size_mm", "blockiness"],
            "mesh" => &["vertices_mm", "triangles"],
            "compound" => &["part"],
            _ => &["points_mm"],
        };
        let flat = self.flag("grid.plane_strain");
        let mut good = kind == "compound" || (kind == "polygon") == flat;
        if !good {
            let message = if flat {
                "must be \"polygon\" in plane strain, or \"compound\""
            } else {
                "\"polygon\" needs grid.plane_strain = true"
            };
            self.refuse(&at("shape"), message);
        }
        for name in
            ["size_mm", "blockiness", "points_mm", "rounding_mm", "mesh_file", "mesh_unit_mm", "vertices_mm", "triangles", "part"]
        {
            let (wanted, given) = (needed.contains(&name), table.contains_key(name));
            let free = name == "rounding_mm" && matches!(kind, "polyhedron" | "polygon" | "mesh");
            if wanted && !given {
                let or = if kind == "mesh" { " (or mesh_file)" } else { "" };
                self.refuse(&at(name), format!("is missing: shape = \"{kind}\" needs it{or}"));
            } else if given && !wanted && !free {
                self.refuse(&at(name), format!("has no meaning with shape = \"{kind}\""));
            }
            good &= wanted == given || free;
        }
        let material = self.material_of(&at("material"), table, named);
        let (angle, axis) = (number(table, "angle_deg")?, vector(table, "axis")?);
        if axis == [0.0; 3] {
            self.refuse(&at("axis"), "must not be zero");
            return None;
        }
        if !good {
            return None;
        }
        let half = || vector(table, "size_mm").map(|size| size.map(|x| 0.5 * x));
        let mut turn = about(axis, angle);
        let shape = match kind {
            "box" => Shape::Box(Cuboid { half: half()? }),
            "superquadric" => {
                let blockiness = self.numbers(&at("blockiness")).try_into().ok()?;
                Shape::Superquadric(Superquadric { half: half()?, blockiness })
            }
            "polygon" => Shape::Polygon(self.polygon(i, number(table, "rounding_mm").unwrap_or(0.0))?),
            "mesh" => Shape::Mesh(self.mesh(i, number(table, "rounding_mm").unwrap_or(0.0))?),
            "compound" => {
                let placed = self.compound(i)?;
                turn = product(turn, quaternion(placed.axes));
                Shape::Compound(Box::new(placed.compound))
            }
            _ => {
                let (polyhedron, axes) = self.polyhedron(i, number(table, "rounding_mm").unwrap_or(0.0))?;
                turn = product(turn, quaternion(axes));
                Shape::Polyhedron(polyhedron)
            }
        };
        let (material, spin) = (material?, vector(table, "spin_rad_s")?);
        if !self.turning() && spin != [0.0; 3] {
            self.refuse(&at("spin_rad_s"), "must be [0, 0, 0] where contact.rotation = \"fixed\"");
            return None;
        }
        if flat {
            self.check(axis[0] == 0.0 && axis[1] == 0.0, &at("axis"), "must be [0, 0, 1] in plane strain");
            for (name, out) in [("position_mm", 2), ("velocity_m_s", 2), ("spin_rad_s", 0), ("spin_rad_s", 1)] {
                let inside = vector(table, name).is_none_or(|v| v[out] == 0.0);
                self.check(inside, &at(name), format!("must have 0 along {} in plane strain", ["x", "y", "z"][out]));
            }
        }
        let mut block = Block::new(shape, materials[usize::from(material)].density, material);
        (block.centre, block.turn, block.velocity) = (vector(table, "position_mm")?, turn, vector(table, "velocity_m_s")?);
        block.set_spin(spin);
        block.driven = table.get("driven").and_then(Value::as_bool).unwrap_or(false);
        Some(block)
    }

    /// A polygon about its centre of mass.
    fn polygon(&self, i: usize, rounding: f64) -> Option<Polygon> {
        let key = format!("block[{i}].points_mm");
        let numbers = self.numbers(&key);
        let (corners, rest) = numbers.as_chunks::<2>();
        if !rest.is_empty() || corners.is_empty() || numbers.len() > MOST_NUMBERS {
            let message = format!("must be x, y of each corner, one after the other; there are {} numbers", numbers.len());
            self.refuse(&key, message);
            return None;
        }
        match Polygon::of(corners, rounding) {
            Ok((polygon, _)) => Some(polygon),
            Err(message) => {
                self.refuse(&key, message);
                None
            }
        }
    }

    /// A sheet of triangles in the frame of its file.
    fn mesh(&self, i: usize, rounding: f64) -> Option<Sheet> {
        let key = |name: &str| format!("block[{i}].{name}");
        let driven = self.flag(&key("driven")) || self.follows_a_path(i);
        self.check(driven, &key("driven"), "must be true: a mesh has no mass, so it is driven or follows a path");
        let numbers = self.numbers(&key("vertices_mm"));
        let list = self.get(&key("triangles")).and_then(Value::as_array).into_iter().flatten();
        let corners: Vec<u32> = list.filter_map(Value::as_integer).filter_map(|k| u32::try_from(k).ok()).collect();
        let ((vertices, of_vertices), (triangles, of_triangles)) = (numbers.as_chunks::<3>(), corners.as_chunks::<3>());
        for (name, left, count) in
            [("vertices_mm", of_vertices.len(), numbers.len()), ("triangles", of_triangles.len(), corners.len())]
        {
            let message = format!("must be three numbers of each, one after the other; there are {count} numbers");
            self.check(left == 0, &key(name), message);
        }
        if !(driven && of_vertices.is_empty() && of_triangles.is_empty()) {
            return None;
        }
        match Sheet::of(vertices, triangles, rounding) {
            Ok(sheet) => Some(sheet),
            Err(message) => {
                self.refuse(&key("triangles"), message);
                None
            }
        }
    }

    /// A polyhedron, and its principal axes in the frame of its points.
    fn polyhedron(&self, i: usize, rounding: f64) -> Option<(Polyhedron, [[f64; 3]; 3])> {
        let key = format!("block[{i}].points_mm");
        let numbers = self.numbers(&key);
        let (points, rest) = numbers.as_chunks::<3>();
        if !rest.is_empty() || !(FOUR_POINTS..=MOST_NUMBERS).contains(&numbers.len()) {
            let message = format!(
                "must be x, y, z of four points or more (a thousand at most), one after the other; there are {} numbers",
                numbers.len()
            );
            self.refuse(&key, message);
            return None;
        }
        match Polyhedron::hull(points, rounding) {
            Ok(placed) => Some((placed.polyhedron, placed.axes)),
            Err(message) => {
                self.refuse(&key, message);
                None
            }
        }
    }

    /// Refuses bodies that overlap at the start with points, grains, walls or each other.
    pub fn blocks_have_room(&self, rig: &MpmTest, coarse: &CoarseGrains) {
        if coarse.blocks.is_empty() {
            return;
        }
        let specimen = rig.specimen();
        let sides = specimen.map_or_else(|| coarse.walls.clone(), |s| platens(s, rig.settings.dimension));
        let walls: Vec<Wall> = sides.iter().map(Wall::new).collect();
        let called = if specimen.is_some() { "side" } else { "wall" };
        let mm = |x: f64| format!("{:.4}", 1e3 * x);
        for (i, block) in coarse.blocks.iter().enumerate() {
            let (key, solid, pose) = (format!("block[{i}].position_mm"), block.solid(), block.pose(0.0));
            let apart = |other: &(usize, &Block)| !joined(&coarse.joints, i, other.0);
            if let Some(sheet) = solid.sheet() {
                self.sheet_has_room(&key, sheet, block, rig, coarse);
                for (j, other) in coarse.blocks[..i].iter().enumerate().filter(apart) {
                    if let Some(message) = crowds(block, j, other) {
                        self.refuse(&key, message);
                    }
                }
                continue;
            }
            let holds = |p: [f64; 3]| {
                let local = pose.inwards(std::array::from_fn(|a| p[a] - pose.centre[a]));
                solid.clearance(local) < 0.0 && solid.nearest(local).distance < 0.0
            };
            let all = if self.leaves_out(20 * coarse.blocks.len(), rig.points.len()) { 0 } else { rig.points.len() };
            let inside = rig.points.position[..all].iter().filter(|&&[x, y, z, _]| holds([x, y, z])).count();
            self.check(inside == 0, &key, format!("must not put the block over points: {inside} points lie in it"));
            if let Some(k) = coarse.grains.iter().position(|g| holds(g.position)) {
                self.refuse(&key, format!("must not put the block over grains: the centre of grain {k} lies in it"));
            }
            for (k, wall) in walls.iter().enumerate() {
                let deepest = block.deepest(wall);
                self.check(
                    deepest < DEEP * block.radius,
                    &key,
                    format!("must not put the block through a {called}: it reaches {} mm behind {called} {k}", mm(deepest)),
                );
            }
            for (j, other) in coarse.blocks[..i].iter().enumerate().filter(apart) {
                if let Some(message) = crowds(block, j, other) {
                    self.refuse(&key, message);
                }
            }
        }
    }
}

impl View<'_> {
    /// Refuses a sheet through grains or points.
    fn sheet_has_room(&self, key: &str, sheet: &Sheet, block: &Block, rig: &MpmTest, coarse: &CoarseGrains) {
        let pose = block.pose(0.0);
        // depth of a sphere in the sheet over its radius
        let depth = |p: [f64; 3], radius: f64| {
            let local = pose.within(p);
            if sheet.clearance(local) < radius { 1.0 - sheet.nearest(local).distance / radius } else { 0.0 }
        };
        let deep = coarse.grains.iter().enumerate().map(|(k, g)| (k, depth(g.position, g.radius)));
        if let Some((k, share)) = deep.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, share)| *share > DEEP) {
            let message = format!(
                "must not put the mesh through grains: grain {k} overlaps it by {share:.3} of its radius, where {DEEP} is allowed"
            );
            self.refuse(key, message);
        }
        let all = if self.leaves_out(20, rig.points.len()) { 0 } else { rig.points.len() };
        let radius = |k: usize| coarse.point_radius.unwrap_or_else(|| ghost_radius(rig.settings.dimension, rig.points.solid(k)));
        let cut = |k: &usize| {
            let [x, y, z, _] = rig.points.position[*k];
            depth([x, y, z], radius(*k)) > POINT_DEEP
        };
        let inside = (0..all).filter(cut).count();
        let message =
            format!("must not put the mesh through points: it cuts {inside} of them by more than {POINT_DEEP} of their radius");
        self.check(inside == 0, key, message);
    }
}

/// Why a block may not stand where it does beside block `j`, if so.
fn crowds(block: &Block, j: usize, other: &Block) -> Option<String> {
    let mm = |x: f64| format!("{:.4}", 1e3 * x);
    let apart = (0..3).map(|a| (block.centre[a] - other.centre[a]).powi(2)).sum::<f64>().sqrt();
    let reach = block.solid().reach() + other.solid().reach();
    if apart > reach || (block.driven && other.driven) {
        return None;
    }
    let [a, b] = [block, other].map(|b| b.shape.rounded());
    let radii = a.rounding() + b.rounding();
    if radii == 0.0 {
        return Some(format!(
            "must be further from block {j}, or one of the two needs rounding_mm: without it the direction of their force is not known where sharp edges meet"
        ));
    }
    let overlap = block.overlap(other);
    (overlap > LAPPED * radii).then(|| {
        let deep = if overlap.is_finite() { format!("by {} mm, ", mm(overlap)) } else { String::new() };
        format!("must be further from block {j}: they overlap {deep}more than {LAPPED} of the radii of their edges, {} mm, and would be thrown apart", mm(radii))
    })
}
