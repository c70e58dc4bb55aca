//! Makes material points from the bodies of a continuum. A body that reaches beyond a plane of symmetry is filled on the inner
//! side only.

use super::material::Named;
use super::schema::unit;
use super::view::View;
use engine::math::portable::sin;
use engine::mpm::{Dimension, GridWall, Point, Points, Settings};
use std::f64::consts::{FRAC_PI_2, PI};
use toml::{Table, Value};

/// Turns from one ring of points to the next.
const GOLDEN: f64 = 0.381_966_011_250_105;
/// Most points of a scene.
const MOST: f64 = 2e8;
/// Points that an outline makes ([`super::outline`]).
const OUTLINE: usize = 100_000;

/// A body in SI units: its shape, and the properties of its points.
struct Body {
    shape: Shape,
    velocity: [f64; 3],
    stress: f64,
    porosity: f64,
    law: u8,
    density: f64,
}

enum Shape {
    Box { min: [f64; 3], max: [f64; 3] },
    Cylinder { base: [f64; 3], radius: f64, height: f64 },
    Sphere { centre: [f64; 3], radius: f64 },
    Points { positions: Vec<[f64; 3]>, volumes: Vec<f64> },
}

impl Shape {
    fn bounds(&self) -> [[f64; 3]; 2] {
        match self {
            Shape::Box { min, max } => [*min, *max],
            Shape::Cylinder { base: [x, y, z], radius: r, height } => [[x - r, y - r, *z], [x + r, y + r, z + height]],
            Shape::Sphere { centre, radius } => [centre.map(|x| x - radius), centre.map(|x| x + radius)],
            Shape::Points { .. } => [[0.0; 3]; 2],
        }
    }

    fn holds(&self, p: [f64; 3], d: usize) -> bool {
        let square = |centre: &[f64; 3], n: usize| (0..n).map(|a| (p[a] - centre[a]) * (p[a] - centre[a])).sum::<f64>();
        match self {
            Shape::Box { .. } => true,
            Shape::Cylinder { base, radius, .. } => square(base, 2) <= radius * radius,
            Shape::Sphere { centre, radius } => square(centre, d) <= radius * radius,
            Shape::Points { .. } => false,
        }
    }
}

impl View<'_> {
    /// The points of all bodies, the number of those that an outline leaves out, and where run-out counts from. Points stand on the
    /// lattice of the grid, `per` along a cell's edge.
    pub fn bodies(&self, named: &[Named], settings: &Settings, per: u32, pressure: f64) -> Option<(Points, usize, [f64; 3])> {
        let tables = self.list("body");
        if tables.is_empty() {
            self.refuse("body", "is missing: a continuum needs a [[body]] with a shape");
            return None;
        }
        let bodies: Vec<Option<Body>> = tables.iter().enumerate().map(|(i, t)| self.body(i, t, named, pressure)).collect();
        let bodies: Vec<Body> = bodies.into_iter().collect::<Option<_>>()?;
        let axis = match &bodies[0].shape {
            Shape::Box { min, .. } => *min,
            Shape::Cylinder { base, .. } => *base,
            Shape::Sphere { centre, .. } => *centre,
            Shape::Points { positions, .. } => positions[0],
        };
        let counts: Vec<f64> =
            bodies.iter().enumerate().map(|(i, body)| self.count(i, body, settings, per)).collect::<Option<_>>()?;
        let wanted: f64 = counts.iter().sum();
        if wanted > MOST {
            self.refuse(
                "body",
                format!("would have some {wanted:.0} points together; at most {MOST:.0} are made: use a larger grid.cell_mm"),
            );
            return None;
        }
        let each = if self.outlined && wanted > OUTLINE as f64 { (OUTLINE / bodies.len()).max(1) } else { usize::MAX };
        let (mut points, mut left_out) = (Points::default(), 0);
        for (i, (body, count)) in bodies.iter().zip(counts).enumerate() {
            let before = points.len();
            self.fill(i, body, settings, per, each, &mut points)?;
            let made = points.len() - before;
            if made == 0 {
                let message = "holds no point: it is smaller than the distance of two points, or outside of the grid; use a smaller grid.cell_mm or more grid.points_per_edge";
                self.refuse(&format!("body[{i}]"), message);
                return None;
            }
            if made == each {
                left_out += (count as usize).saturating_sub(made);
                self.incomplete.set(true);
            }
        }
        Some((points, left_out, axis))
    }

    fn body(&self, i: usize, table: &Table, named: &[Named], pressure: f64) -> Option<Body> {
        let at = |name: &str| format!("body[{i}].{name}");
        let shape = table.get("shape").and_then(Value::as_str)?;
        let needed: &[&str] = match shape {
            "box" => &["min_mm", "max_mm"],
            "cylinder" => &["centre_mm", "radius_mm", "height_mm"],
            "sphere" => &["centre_mm", "radius_mm"],
            _ => &["points_m"],
        };
        let mut good = true;
        for name in ["min_mm", "max_mm", "centre_mm", "radius_mm", "height_mm", "points_m", "points_csv", "volumes_m3"] {
            let (wanted, given) = (needed.contains(&name), table.contains_key(name));
            if wanted && !given {
                let or = if name == "points_m" { " (or points_csv)" } else { "" };
                self.refuse(&at(name), format!("is missing: shape = \"{shape}\" needs it{or}"));
                good = false;
            } else if given && !wanted && !(shape == "points" && name == "volumes_m3") {
                self.refuse(&at(name), format!("has no meaning with shape = \"{shape}\""));
                good = false;
            }
        }
        if table.contains_key("porosity") && table.contains_key("void_ratio") {
            self.refuse(&at("void_ratio"), "must not stand beside porosity: one of them");
            good = false;
        }
        let law = self.material_of_body(i, table, named);
        if !good {
            return None;
        }
        let shape = match shape {
            "box" => {
                let (min, max) = (vector(table, "min_mm")?, vector(table, "max_mm")?);
                let d = if self.flag("grid.plane_strain") { 2 } else { 3 };
                if (0..d).any(|a| max[a] <= min[a]) {
                    self.refuse(&at("max_mm"), "must be above min_mm along every axis");
                    return None;
                }
                Shape::Box { min, max }
            }
            "cylinder" => {
                if self.flag("grid.plane_strain") {
                    self.refuse(&at("shape"), "must not be \"cylinder\" in plane strain: a disc is a \"sphere\" there");
                    return None;
                }
                Shape::Cylinder {
                    base: vector(table, "centre_mm")?,
                    radius: number(table, "radius_mm")?,
                    height: number(table, "height_mm")?,
                }
            }
            "sphere" => Shape::Sphere { centre: vector(table, "centre_mm")?, radius: number(table, "radius_mm")? },
            _ => self.cloud(i, table)?,
        };
        let law = law?;
        let porosity = porosity(table);
        Some(Body {
            shape,
            velocity: vector(table, "velocity_m_s")?,
            stress: number(table, "stress_kPa").unwrap_or(pressure),
            porosity,
            law,
            density: self.si(&named[usize::from(law)].key("grain.density_kg_m3")) * (1.0 - porosity),
        })
    }

    fn cloud(&self, i: usize, table: &Table) -> Option<Shape> {
        let flat = numbers(table, "points_m")?;
        let volumes = numbers(table, "volumes_m3").unwrap_or_default();
        if flat.is_empty() || flat.len() % 3 != 0 {
            self.refuse(&format!("body[{i}].points_m"), format!("must be x, y, z of each point; it has {} numbers", flat.len()));
            return None;
        }
        let positions: Vec<[f64; 3]> = flat.as_chunks::<3>().0.to_vec();
        if !volumes.is_empty() && volumes.len() != positions.len() {
            let message = format!("must be one for each of the {} points; there are {}", positions.len(), volumes.len());
            self.refuse(&format!("body[{i}].volumes_m3"), message);
            return None;
        }
        Some(Shape::Points { positions, volumes })
    }

    fn material_of_body(&self, i: usize, table: &Table, named: &[Named]) -> Option<u8> {
        let key = format!("body[{i}].material");
        let names: Vec<&str> = named.iter().map(|n| n.name.as_str()).collect();
        let found = match table.get("material").and_then(Value::as_str) {
            None if named.len() == 1 => return Some(0),
            None => None,
            Some(name) => names.iter().position(|n| *n == name).and_then(|k| u8::try_from(k).ok()),
        };
        if found.is_none() {
            self.refuse(&key, format!("must be one of the scene's materials: {}", names.join(", ")));
        }
        found
    }

    /// Number of points of a body, without making them; near the shell of a sphere or cylinder it may be wrong by some. `None`, with
    /// the reason noted, where there are too many.
    fn count(&self, i: usize, body: &Body, settings: &Settings, per: u32) -> Option<f64> {
        let d = if settings.dimension == Dimension::Space { 3 } else { 2 };
        let spacing = settings.cell / f64::from(per);
        let count = match &body.shape {
            Shape::Points { positions, .. } => positions.len() as f64,
            Shape::Cylinder { radius, height, .. } if self.text("test.rig") != "free" => {
                // Σ 3 (2 k + 1) over the rings of each layer
                let [rings, layers] = ring_counts(*radius, *height, spacing);
                3.0 * rings * rings * layers
            }
            shape => {
                let sites = lattice(shape, settings, per, d);
                let across = sites.map(|[a, b]| (b as f64 - a as f64).max(0.0));
                let all: f64 = across.iter().product();
                // a ball fills half of the box around it
                if all > 2.0 * MOST { all } else { inside(shape, settings, spacing, sites, d) }
            }
        };
        if count > MOST {
            let message = format!("would have some {count:.0} points; at most {MOST:.0} are made: use a larger grid.cell_mm");
            self.refuse(&format!("body[{i}]"), message);
            return None;
        }
        Some(count)
    }

    /// Adds the points of a body, at most `most` of them.
    fn fill(&self, i: usize, body: &Body, settings: &Settings, per: u32, most: usize, points: &mut Points) -> Option<()> {
        let d = if settings.dimension == Dimension::Space { 3 } else { 2 };
        let spacing = settings.cell / f64::from(per);
        let volume = spacing.powi(d as i32);
        let at = format!("body[{i}]");
        let within = |p: [f64; 3]| {
            for a in 0..d {
                let (low, high) = (settings.lower[a], settings.lower[a] + f64::from(settings.cells[a]) * settings.cell);
                if !(p[a] > low && p[a] < high) {
                    let [axis, p, low, high] = [["x", "y", "z"][a].to_string(), mm(p[a]), mm(low), mm(high)];
                    let message = format!(
                        "has a point at {axis} = {p} mm, outside of the grid, {low} to {high} mm: enlarge grid.min_mm and grid.max_mm, or move it"
                    );
                    self.refuse(&at, message);
                    return None;
                }
            }
            Some(())
        };
        let mut add = |p: [f64; 3], volume: f64| {
            within(p)?;
            let s = -body.stress;
            let stress = [s, s, s, 0.0, 0.0, 0.0];
            let (mass, velocity, porosity, law) = (body.density * volume, body.velocity, body.porosity, body.law);
            points.add(&Point { position: p, velocity, mass, volume, stress, porosity, law });
            Some(())
        };
        if let Shape::Points { positions, volumes } = &body.shape {
            for (k, p) in positions.iter().enumerate().take(most) {
                add(*p, volumes.get(k).copied().unwrap_or(volume))?;
            }
            return Some(());
        }
        if let (Shape::Cylinder { base, radius, height }, true) = (&body.shape, self.text("test.rig") != "free") {
            for (p, volume) in rings(*base, *radius, *height, spacing).take(most) {
                add(p, volume)?;
            }
            return Some(());
        }
        let sites = lattice(&body.shape, settings, per, d);
        let middle = |a: usize, n: i64| if a < d { settings.lower[a] + (n as f64 + 0.5) * spacing } else { 0.0 };
        let place = |[x, y, z]: [i64; 3]| [middle(0, x), middle(1, y), middle(2, z)];
        if most < usize::MAX {
            // the sites in the middle of each side, as those that lie outside of the grid may be left out
            let middles = sites.map(|[from, to]| from + (to - 1 - from) / 2);
            for (a, ends) in sites.iter().enumerate().take(d) {
                for end in [ends[0], ends[1] - 1] {
                    let mut site = middles;
                    site[a] = end;
                    if body.shape.holds(place(site), d) {
                        within(place(site))?;
                    }
                }
            }
        }
        let mut left = most;
        for z in sites[2][0]..sites[2][1] {
            for y in sites[1][0]..sites[1][1] {
                for x in sites[0][0]..sites[0][1] {
                    let p = place([x, y, z]);
                    if body.shape.holds(p, d) {
                        if left == 0 {
                            return Some(());
                        }
                        left -= 1;
                        add(p, volume)?;
                    }
                }
            }
        }
        Some(())
    }
}

/// First and last sites, the last one excluded, along each axis of the lattice of points around a shape. Sites are counted from
/// the grid's corner; those whose middles lie inside are taken, with a hair of room for rounding.
fn lattice(shape: &Shape, settings: &Settings, per: u32, d: usize) -> [[i64; 2]; 3] {
    let spacing = settings.cell / f64::from(per);
    let [low, high] = shape.bounds();
    std::array::from_fn(|a| {
        let site = |x: f64| ((x - settings.lower[a]) / spacing - 0.5 - 1e-6).ceil() as i64;
        if a >= d {
            return [0, 1];
        }
        // the part beyond a plane of symmetry is the image of the part before it
        let kept = |side: usize, site: i64, end: i64, inner: fn(i64, i64) -> i64| {
            if settings.walls[2 * a + side] == GridWall::Symmetry { inner(site, end) } else { site }
        };
        let end = i64::from(settings.cells[a]) * i64::from(per);
        [kept(0, site(low[a]), 0, i64::max), kept(1, site(high[a] + 2e-6 * spacing), end, i64::min)]
    })
}

/// Number of lattice sites in a shape, row by row along x.
fn inside(shape: &Shape, settings: &Settings, spacing: f64, sites: [[i64; 2]; 3], d: usize) -> f64 {
    let [along, rows, layers] = sites.map(|[a, b]| (b as f64 - a as f64).max(0.0));
    let (centre, radius, round) = match shape {
        Shape::Cylinder { base, radius, .. } => (base, radius, 2),
        Shape::Sphere { centre, radius } => (centre, radius, d),
        _ => return along * rows * layers,
    };
    let place = |a: usize, n: f64| settings.lower[a] + (n + 0.5) * spacing;
    let site = |x: f64| (x - settings.lower[0]) / spacing - 0.5;
    let row = |y: i64, z: i64| {
        let apart: f64 = [y, z].iter().zip(1..round).map(|(n, a)| (place(a, *n as f64) - centre[a]).powi(2)).sum();
        let half = (radius * radius - apart).sqrt();
        // not a number where the row misses the shape
        let (from, to) = (site(centre[0] - half).ceil(), site(centre[0] + half).floor());
        if half >= 0.0 { (to.min(sites[0][1] as f64 - 1.0) - from.max(sites[0][0] as f64) + 1.0).max(0.0) } else { 0.0 }
    };
    let layer = |z: i64| (sites[1][0]..sites[1][1]).map(|y| row(y, z)).sum::<f64>();
    // all layers of a cylinder are alike
    if round == 3 { (sites[2][0]..sites[2][1]).map(layer).sum() } else { layers * layer(sites[2][0]) }
}

/// Numbers of rings and of layers of points in a cylinder, at least one of each.
fn ring_counts(radius: f64, height: f64, spacing: f64) -> [f64; 2] {
    [radius, height].map(|length| (length / spacing).round().max(1.0))
}

/// Places and volumes of points in rings around the axis of a cylinder, about `spacing` from each other, so that the outermost
/// stand half that inside its shell.
fn rings(base: [f64; 3], radius: f64, height: f64, spacing: f64) -> impl Iterator<Item = ([f64; 3], f64)> {
    let [count, layers] = ring_counts(radius, height, spacing);
    let [width, thick] = [radius / count, height / layers];
    let of_layer = move |z: f64| {
        (0..count as u32).map(f64::from).flat_map(move |k| {
            // three in the middle, nine around them, …: all of the same area
            let many = 3.0 * (2.0 * k + 1.0);
            (0..many as u32).map(f64::from).map(move |i| {
                // turned from ring to ring and layer to layer, so that they do not line up
                let turns = i / many + GOLDEN * (k + z);
                let (angle, r) = (2.0 * PI * (turns - turns.round()), (k + 0.5) * width);
                let place = [base[0] + r * sin(FRAC_PI_2 - angle.abs()), base[1] + r * sin(angle), base[2] + (z + 0.5) * thick];
                (place, PI / 3.0 * width * width * thick)
            })
        })
    };
    (0..layers as u32).map(f64::from).flat_map(of_layer)
}

fn mm(x: f64) -> String {
    table::number((1e9 * x).round() * 1e-6)
}

/// Porosity of a body at the start, from it or its void ratio.
pub fn porosity(body: &Table) -> f64 {
    let of_voids = || number(body, "void_ratio").map_or(0.0, |e| e / (1.0 + e));
    number(body, "porosity").unwrap_or_else(of_voids)
}

pub fn number(table: &Table, key: &str) -> Option<f64> {
    table.get(key)?.as_float().map(|x| x * unit(key))
}

fn numbers(table: &Table, key: &str) -> Option<Vec<f64>> {
    table.get(key)?.as_array()?.iter().map(|v| v.as_float().map(|x| x * unit(key))).collect()
}

pub fn vector(table: &Table, key: &str) -> Option<[f64; 3]> {
    numbers(table, key)?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use crate::model::Rig;
    use crate::scene::{from_text, model};

    /// Porosity of the points of a box with these lines.
    fn porosity(lines: &str) -> Result<f64, String> {
        let text = format!(
            "kind = \"continuum\"\n[material]\nbase = \"materials/li2023_fines.toml\"\n[grid]\ncell_mm = 5.0\n[test]\nrig = \"oedometer\"\naxial_strain = 0.01\n\
            [[body]]\nshape = \"box\"\nmin_mm = [0.0, 0.0, 0.0]\nmax_mm = [20.0, 20.0, 20.0]\nstress_kPa = 20.0\n{lines}"
        );
        let of = |scene| model(&scene).map_err(|e| e.to_string());
        let found = from_text(&text, concat!(env!("CARGO_MANIFEST_DIR"), "/../.."), &[]).map_err(|e| e.to_string()).and_then(of)?;
        let Rig::Continuum(rig) = found.rig else { panic!("the rig") };
        Ok(rig.specimen().expect("a specimen").porosity)
    }

    #[test]
    fn a_body_has_a_porosity_or_a_void_ratio() {
        assert_eq!([porosity("porosity = 0.4\n"), porosity("void_ratio = 0.6\n"), porosity("")], [Ok(0.4), Ok(0.6 / 1.6), Ok(0.0)]);
        let told = porosity("porosity = 0.4\nvoid_ratio = 0.6\n").expect_err("two of them");
        assert!(told.contains("body[0].void_ratio") && told.contains("porosity"), "{told}");
    }
}
