//! Compounds: bodies that are not convex, as unions of convex parts with one mass and one motion (in the plane Jiang et al. 2020, Fig. 3).
//!
//! Parts may overlap or touch. Their surface is that of the union (`union.rs`): points, grains, walls and other bodies touch parts, and nothing inside. Volume and inertia are the sums
//! over parts, less what is covered more than once (`overlap.rs`). A compound that breaks falls into its parts, cut free of each other (`parting.rs`).

mod outline;
mod overlap;
mod part;
mod parting;
mod union;

pub use part::{Convex, Part};
pub use union::Union;

use super::hull::Hull;
use super::moments::Moments;
use super::ring::Ring;
use super::{Bulk, Cuboid, Meet, Mesh, Nearest, Polygon, Polyhedron, Solid};
use crate::math::eigen::principal;
use crate::math::vector::{cross, dot, less, plus, scaled};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Most parts of a compound.
pub const MOST_PARTS: usize = 100;

/// Most corners of all parts of a compound.
const MOST_CORNERS: usize = 3000;

/// Where a part stands in the frame in which a compound is written: x = origin + Σ axes`[k]` x'_k.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Origin of the part, m.
    pub origin: [f64; 3],
    /// Its axes, right-handed unit vectors.
    pub axes: [[f64; 3]; 3],
}

impl Frame {
    fn place(&self, at: [f64; 3]) -> [f64; 3] {
        plus(self.origin, self.outwards(at))
    }

    fn outwards(&self, v: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = self.axes;
        plus(scaled(a, v[0]), plus(scaled(b, v[1]), scaled(c, v[2])))
    }

    fn within(&self, at: [f64; 3]) -> [f64; 3] {
        let away = less(at, self.origin);
        self.axes.map(|axis| dot(axis, away))
    }
}

/// A part in the frame in which a compound is written.
#[derive(Clone, Debug)]
pub struct Piece {
    part: Part,
    moments: Moments,
    /// What a box is.
    cuboid: Option<(Cuboid, Frame)>,
}

impl Piece {
    /// A box about the origin of its frame.
    pub fn cuboid(cuboid: Cuboid, frame: Frame) -> Piece {
        let sharp = Part::of(Convex::Hull(Cuboid::hull([cuboid.half.map(|h| -h), cuboid.half], 0.0)));
        let moments = Moments::of_bulk(&cuboid.bulk(), frame.origin, frame.axes);
        Piece { part: sharp.moved(|p| frame.place(p)), moments, cuboid: Some((cuboid, frame)) }
    }

    /// The convex hull of `points`, m, with a sphere of radius `rounding`, m, swept over it.
    ///
    /// # Errors
    /// Points whose hull has no volume; the text says so.
    pub fn polyhedron(points: &[[f64; 3]], rounding: f64, frame: Frame) -> Result<Piece, String> {
        let placed = Polyhedron::hull(points, rounding)?;
        let own = Frame { origin: placed.centre, axes: placed.axes };
        let part = Part::of(Convex::Hull(placed.polyhedron.rounded_hull().clone())).moved(|p| frame.place(own.place(p)));
        let axes = own.axes.map(|axis| frame.outwards(axis));
        let moments = Moments::of_bulk(&placed.polyhedron.bulk(), frame.place(own.origin), axes);
        Ok(Piece { part, moments, cuboid: None })
    }

    /// The polygon of plane strain with these corners, m, with a disc of radius `rounding`, m, swept over it.
    ///
    /// # Errors
    /// Points that are not the corners of a convex outline; no area.
    pub fn polygon(corners: &[[f64; 2]], rounding: f64, frame: Frame) -> Result<Piece, String> {
        let (polygon, [x, y]) = Polygon::of(corners, rounding)?;
        let part = Part::of(Convex::Ring(polygon.rounded_ring().clone())).moved(|p| frame.place(plus(p, [x, y, 0.0])));
        let bulk = polygon.bulk();
        Ok(Piece { part, moments: Moments::of_area(bulk.volume, frame.place([x, y, 0.0]), bulk.moments[0]), cuboid: None })
    }

    /// A box as other bodies touch it, with edges of radius `r`, m. A side that lies in another part by twice that goes on into it, so that there is no groove around a
    /// joint.
    fn rounded(&self, others: &[&Piece], r: f64) -> Part {
        let Some((Cuboid { half }, frame)) = self.cuboid else { return self.part.clone() };
        let hair = union::HAIR * half.into_iter().fold(0.0, f64::max);
        let end = |axis: usize, side: f64| {
            // the corners of what would be covered
            let within = |k: usize| {
                let mut p: [f64; 3] = std::array::from_fn(|a| if k >> a & 1 == 1 { half[a] } else { -half[a] });
                p[axis] = side * (half[axis] + if k >> axis & 1 == 1 { 2.0 * r } else { 0.0 });
                frame.place(p)
            };
            let covered = others.iter().any(|other| (0..8).all(|k| other.part.holds(within(k), 0.0, hair)));
            side * (half[axis] + if covered { r } else { -r })
        };
        let ends = [-1.0, 1.0].map(|side| std::array::from_fn(|axis| end(axis, side)));
        Part::of(Convex::Hull(Cuboid::hull(ends, r))).moved(|p| frame.place(p))
    }
}

/// A union of convex parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compound {
    /// Its surface, to points, grains and walls: boxes have sharp edges.
    surface: Union,
    /// As other bodies touch it, where boxes have round edges; the same where there are no boxes.
    rounded: Option<Union>,
    bulk: Bulk,
}

/// A compound in its own frame, with the place of that frame in the one in which it was written: x = centre + Σ axes`[k]` x'_k.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedCompound {
    /// The compound.
    pub compound: Compound,
    /// Its centre of mass, m.
    pub centre: [f64; 3],
    /// Its principal axes, unit vectors.
    pub axes: [[f64; 3]; 3],
}

impl Compound {
    /// The union of these parts, all in space or all in the plane.
    ///
    /// # Errors
    /// Fewer than two parts, too many, too many corners, parts that do not hang together, too many that lie over each other; the text says which.
    pub fn of(pieces: &[Piece]) -> Result<PlacedCompound, String> {
        if pieces.len() < 2 || pieces.len() > MOST_PARTS {
            return Err(format!("must be 2 to {MOST_PARTS} parts; there are {}", pieces.len()));
        }
        let parts: Vec<Part> = pieces.iter().map(|piece| piece.part.clone()).collect();
        let corners: usize = parts.iter().map(|part| part.corners().len()).sum();
        if corners > MOST_CORNERS {
            return Err(format!("have {corners} corners, where a compound may have {MOST_CORNERS}"));
        }
        let flat = parts[0].is_flat();
        if parts.iter().any(|part| part.is_flat() != flat) {
            return Err("must all be in space or all in the plane".into());
        }
        if let Some(k) = apart(&parts) {
            return Err(format!("must hang together: part {k} neither overlaps nor touches those that hang together with part 0"));
        }
        let whole = pieces.iter().fold(Moments::default(), |sum, piece| sum.plus(&piece.moments, 1.0));
        let whole = whole.plus(&overlap::covered(&parts)?, -1.0);
        let (centre, inertia) = (whole.centre(), whole.inertia());
        let (axes, moments) = if flat {
            ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [inertia[2]; 3])
        } else {
            let (moments, [first, second, _]) = principal(inertia);
            ([first, second, cross(first, second)], moments)
        };
        let own = Frame { origin: centre, axes };
        let inside = |part: &Part| part.moved(|p| own.within(p));
        let least =
            pieces.iter().filter_map(|piece| piece.cuboid).map(|(cuboid, _)| cuboid.rounding()).fold(f64::INFINITY, f64::min);
        let rounded = least.is_finite().then(|| {
            let round = |k: usize| {
                let others: Vec<&Piece> = pieces.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, other)| other).collect();
                inside(&pieces[k].rounded(&others, least))
            };
            Union::of((0..pieces.len()).map(round).collect())
        });
        let surface = Union::of(parts.iter().map(inside).collect());
        let compound = Compound { surface, rounded, bulk: Bulk { volume: whole.volume, moments } };
        Ok(PlacedCompound { compound, centre, axes })
    }

    /// Number of its parts.
    pub fn parts(&self) -> usize {
        self.surface.parts.len()
    }

    /// Whether it is one of plane strain.
    pub fn is_flat(&self) -> bool {
        self.surface.parts.iter().any(Part::is_flat)
    }

    /// Radius of the sphere of the same volume, m; in plane strain of the disc of the same area.
    pub fn radius(&self) -> f64 {
        if self.is_flat() { (self.bulk.volume / PI).sqrt() } else { self.bulk.radius() }
    }

    /// As other bodies touch it. Its boxes have edges with a twentieth of the least half edge of all of them.
    pub fn rounded_union(&self) -> &Union {
        self.rounded.as_ref().unwrap_or(&self.surface)
    }
}

/// A part that does not hang together with the first one.
fn apart(parts: &[Part]) -> Option<usize> {
    let size = parts.iter().flat_map(Part::bounds).flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
    let mut seen = vec![false; parts.len()];
    let mut open = vec![0];
    while let Some(k) = open.pop() {
        if !std::mem::replace(&mut seen[k], true) {
            open.extend((0..parts.len()).filter(|j| !seen[*j] && touch(&parts[k], &parts[*j], 1e-6 * size)));
        }
    }
    seen.iter().position(|seen| !seen)
}

/// Whether two parts overlap or touch, within a hair, m.
fn touch(a: &Part, b: &Part, hair: f64) -> bool {
    let ([low, high], [from, to]) = (a.bounds(), b.bounds());
    let axes = if a.is_flat() { 2 } else { 3 };
    if (0..axes).any(|axis| low[axis] > to[axis] + hair || from[axis] > high[axis] + hair) {
        return false;
    }
    let near = |of: &Part, on: &Part| of.corners().iter().any(|p| on.nearest(*p).distance <= of.rounding() + hair);
    near(a, b)
        || near(b, a)
        || match (&a.surface, &b.surface) {
            (Convex::Hull(a), Convex::Hull(b)) => Hull::gap(&a.corners, &b.corners) <= a.rounding + b.rounding + hair,
            (Convex::Ring(a), Convex::Ring(b)) => Ring::cross(a, b),
            _ => false,
        }
}

impl Solid for Compound {
    fn nearest(&self, at: [f64; 3]) -> Nearest {
        self.surface.nearest(at)
    }

    fn clearance(&self, [x, y, z]: [f64; 3]) -> f64 {
        let z = if self.is_flat() { 0.0 } else { z };
        (x * x + y * y + z * z).sqrt() - self.surface.reach
    }

    fn reach(&self) -> f64 {
        self.surface.reach
    }

    fn spots(&self) -> usize {
        self.surface.corners.len()
    }

    fn spot(&self, k: usize, towards: [f64; 3]) -> [f64; 3] {
        plus(self.surface.corners[k], scaled(towards, self.surface.corner_radius(k)))
    }

    fn bulk(&self) -> Bulk {
        self.bulk
    }

    fn surface(&self) -> Mesh {
        let mut all = Mesh::default();
        for part in &self.surface.parts {
            let (Mesh { corners, triangles }, first) = (part.shown(), all.corners.len() as u32);
            all.corners.extend(corners);
            all.triangles.extend(triangles.into_iter().map(|t| t.map(|k| first + k)));
        }
        all
    }

    fn facets(&self) -> usize {
        self.surface.parts.len()
    }

    fn facets_near(&self, at: [f64; 3], within: f64, found: &mut Vec<u32>) {
        if self.clearance(at) < within {
            self.surface.facets_near(at, within, found);
        }
    }

    fn meet(&self, facet: u32, at: [f64; 3], within: f64) -> Option<Meet> {
        if self.clearance(at) >= within {
            return None;
        }
        self.surface.meet_near(facet, at, within)
    }

    fn passes(&self, from: u32, to: u32, at: [f64; 3], within: f64) -> bool {
        self.surface.passes(from, to, at, within)
    }
}

#[cfg(test)]
mod tests;
