//! A convex part of a compound: a hull of corners with a sphere swept over it, or in the plane a ring of corners with a disc.

use crate::math::vector::{dot, less, plus, scaled};
use crate::shape::core::{Core, Seen};
use crate::shape::hull::{Hull, HullFace};
use crate::shape::ring::Ring;
use crate::shape::sheet::foot::of_triangle;
use crate::shape::{Mesh, Nearest, polygon, polyhedron};
use serde::{Deserialize, Serialize};

/// The surface of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Convex {
    /// In space.
    Hull(Hull),
    /// In the plane.
    Ring(Ring),
}

/// A convex part, with a sphere around it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its surface, in the frame of the compound.
    pub surface: Convex,
    /// Middle of its corners, m.
    middle: [f64; 3],
    /// Distance of its furthest point from there, m.
    round: f64,
}

impl Part {
    /// A part with this surface.
    pub fn of(surface: Convex) -> Part {
        let mut part = Part { surface, middle: [0.0; 3], round: 0.0 };
        let corners = part.corners();
        let sum = corners.iter().fold([0.0; 3], |sum, corner| plus(sum, *corner));
        let middle = scaled(sum, 1.0 / corners.len().max(1) as f64);
        let far = corners.iter().map(|corner| less(*corner, middle)).map(|away| dot(away, away).sqrt()).fold(0.0, f64::max);
        (part.middle, part.round) = (middle, far + part.rounding());
        part
    }

    /// The part with each corner moved by `place`, a rotation and a shift.
    pub fn moved(&self, place: impl Fn([f64; 3]) -> [f64; 3]) -> Part {
        Part::of(match &self.surface {
            Convex::Hull(hull) => {
                let triangles: Vec<[u32; 3]> = hull.faces.iter().map(|face| face.corners).collect();
                Convex::Hull(Hull::of(hull.corners.iter().map(|p| place(*p)).collect(), &triangles, hull.rounding))
            }
            Convex::Ring(ring) => Convex::Ring(Ring::of(ring.corners.iter().map(|p| place(*p)).collect(), ring.rounding)),
        })
    }

    /// Its corners, m, in the middle of what is round.
    pub fn corners(&self) -> &[[f64; 3]] {
        match &self.surface {
            Convex::Hull(hull) => &hull.corners,
            Convex::Ring(ring) => &ring.corners,
        }
    }

    /// Radius of the sphere or disc that is swept over it, m.
    pub fn rounding(&self) -> f64 {
        match &self.surface {
            Convex::Hull(hull) => hull.rounding,
            Convex::Ring(ring) => ring.rounding,
        }
    }

    /// Whether it lies in the plane.
    pub(super) fn is_flat(&self) -> bool {
        matches!(self.surface, Convex::Ring(_))
    }

    /// Whether it is a disc.
    pub(super) fn is_disc(&self) -> bool {
        self.is_flat() && self.corners().len() == 1
    }

    /// Surface nearest to a position.
    pub(super) fn nearest(&self, at: [f64; 3]) -> Nearest {
        match &self.surface {
            Convex::Hull(hull) => nearest_of(hull, at),
            Convex::Ring(ring) => ring.nearest(at),
        }
    }

    /// The place of a core that is nearest to the part, if that is nearer than `within`, m; `None` of a part in the plane.
    pub(super) fn near_core(&self, core: &Core<'_>, within: f64) -> Option<Seen> {
        let Convex::Hull(hull) = &self.surface else { return None };
        if self.clearance(core.centre) - core.reach >= within {
            return None;
        }
        let from = self.nearest(core.centre);
        let about = less(core.centre, scaled(from.normal, from.distance + hull.rounding));
        let found = core.nearest_to(|towards| hull.furthest(towards), (about, None), within + hull.rounding)?;
        if found.distance == 0.0 {
            return Some(Seen { at: about, nearest: Nearest { distance: -hull.rounding, normal: from.normal } });
        }
        let [rough, exact] = {
            let seen = |at: [f64; 3]| Seen { at, nearest: self.nearest(at) };
            let rough = seen(found.on_first);
            // exact where it is a face that is nearest
            [rough, seen(core.furthest(rough.nearest.normal.map(|x| -x)))]
        };
        let best = if exact.nearest.distance <= rough.nearest.distance { exact } else { rough };
        (best.nearest.distance < within).then_some(best)
    }

    /// A lower bound on the distance of a position from the surface, m.
    pub(super) fn clearance(&self, at: [f64; 3]) -> f64 {
        let [x, y, z] = less(at, self.middle);
        let z = if self.is_flat() { 0.0 } else { z };
        (x * x + y * y + z * z).sqrt() - self.round
    }

    /// Whether a ball of this radius, m, around a position lies in it, within a hair, m.
    pub(super) fn holds(&self, at: [f64; 3], radius: f64, hair: f64) -> bool {
        self.clearance(at) <= hair && self.nearest(at).distance <= hair - radius
    }

    /// Lowest and highest coordinates, m.
    pub(super) fn bounds(&self) -> [[f64; 3]; 2] {
        let (corners, r) = (self.corners(), self.rounding());
        [(f64::INFINITY, -1.0), (f64::NEG_INFINITY, 1.0)].map(|(start, side)| {
            std::array::from_fn(|a| {
                let most = corners.iter().map(|p| p[a]).fold(start, |x: f64, y| if side > 0.0 { x.max(y) } else { x.min(y) });
                most + side * r
            })
        })
    }

    /// Whether the two cut each other, without what is round.
    pub fn cuts(&self, other: &Part) -> bool {
        match (&self.surface, &other.surface) {
            (Convex::Hull(a), Convex::Hull(b)) => Hull::cut(&a.corners, &b.corners),
            (Convex::Ring(a), Convex::Ring(b)) => Ring::cross(a, b),
            _ => false,
        }
    }

    /// Edges of the hull between faces that are not in one plane: their ends and the normals of both faces. None in the plane.
    pub(super) fn edges(&self) -> Vec<([u32; 2], [[f64; 3]; 2])> {
        match &self.surface {
            Convex::Hull(hull) => hull.edges(),
            Convex::Ring(_) => Vec::new(),
        }
    }

    /// The surface as triangles, for pictures.
    pub(super) fn shown(&self) -> Mesh {
        match &self.surface {
            Convex::Hull(hull) => polyhedron::triangles(hull, polyhedron::SHOWN),
            Convex::Ring(ring) => polygon::fan(ring, self.middle),
        }
    }
}

/// Over the reach of a hull: a place that is no further before its faces is on them or inside. The planes of two triangles of one face differ by rounding.
const ON: f64 = 1e-13;

/// Surface of a hull nearest to a position, as [`Hull::nearest`] has it, also for places on the surface to the last digit, where feet of spheres and corners of other parts lie.
fn nearest_of(hull: &Hull, at: [f64; 3]) -> Nearest {
    let before = |face: &HullFace| dot(face.normal, at) - face.offset;
    let (mut deepest, mut face) = (f64::NEG_INFINITY, [0.0, 0.0, 1.0]);
    for of in &hull.faces {
        let before = before(of);
        if before > deepest {
            (deepest, face) = (before, of.normal);
        }
    }
    if deepest <= ON * hull.reach {
        return Nearest { distance: deepest - hull.rounding, normal: face };
    }
    let (mut least, mut out) = (f64::INFINITY, [0.0; 3]);
    for of in &hull.faces {
        let before = before(of);
        if before > 0.0 && before * before < least {
            let foot = of_triangle(&hull.corners, of.corners, of.normal, at);
            if foot.square < least {
                (least, out) = (foot.square, foot.out);
            }
        }
    }
    let distance = least.sqrt();
    let normal = if distance > 0.0 { scaled(out, 1.0 / distance) } else { face };
    Nearest { distance: distance - hull.rounding, normal }
}
