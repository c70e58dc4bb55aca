//! Shapes of rigid bodies, each in the frame of the body: origin at the centre of mass, axes along the principal axes of inertia.
//!
//! Other modules use a shape through [`Solid`] only. A body is touched by spheres (grains, ghosts of material points), for whose centres the nearest point of
//! the surface is needed, and by walls, for which the [spots](Solid::spot) of the body that can touch a plane are needed. Results are computed with
//! + − × ÷ √ or with functions made of these (`crate::math::portable`), so that they have the same bits on every machine.

mod cuboid;
mod hull;
mod mesh;
mod polygon;
mod polyhedron;
mod ring;
mod superquadric;

pub use cuboid::Cuboid;
pub use hull::{Hull, HullFace};
pub use mesh::Mesh;
pub use polygon::Polygon;
pub use polyhedron::{Placed, Polyhedron};
pub use ring::Ring;
pub use superquadric::Superquadric;

use serde::{Deserialize, Serialize};

/// The surface of a shape, as seen from a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Distance of the position from the surface, m; negative inside.
    pub distance: f64,
    /// Outward unit normal at the nearest point of the surface; that point is the position minus `distance` times the normal.
    pub normal: [f64; 3],
}

/// Volume and moments of inertia of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bulk {
    /// Volume, m³.
    pub volume: f64,
    /// Moments of inertia about the three axes for a density of 1: ∫ (y² + z²) dV and so on, m⁵.
    pub moments: [f64; 3],
}

impl Bulk {
    /// Radius of the sphere of the same volume, m.
    pub fn radius(&self) -> f64 {
        (0.75 / std::f64::consts::PI * self.volume).cbrt()
    }
}

/// Geometry of a shape. Lengths in m, in the frame of the body.
pub trait Solid {
    /// Distance and normal of the surface from a position. Contacts ask for positions outside; inside, the answer may be approximate.
    fn nearest(&self, at: [f64; 3]) -> Nearest;

    /// A lower bound on the distance of a position from the surface, cheap to compute.
    fn clearance(&self, at: [f64; 3]) -> f64;

    /// Distance of the furthest point of the shape from the origin.
    fn reach(&self) -> f64;

    /// Number of spots: parts of the surface that can touch a plane, such as corners.
    fn spots(&self) -> usize;

    /// Point of spot `k` that is furthest along the unit vector `towards`.
    fn spot(&self, k: usize, towards: [f64; 3]) -> [f64; 3];

    /// Volume and moments of inertia.
    fn bulk(&self) -> Bulk;

    /// The surface as triangles, for pictures.
    fn surface(&self) -> Mesh;
}

/// A shape of one of the known kinds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// A box with sharp edges.
    Box(Cuboid),
    /// A superquadric.
    Superquadric(Superquadric),
    /// A rounded convex polyhedron.
    Polyhedron(Polyhedron),
    /// A rounded convex polygon of plane strain.
    Polygon(Polygon),
}

/// A shape as other bodies touch it: corners, and a sphere or disc swept over all between them.
#[derive(Clone, Debug)]
pub enum Rounded {
    /// In space.
    Hull(Hull),
    /// In the plane.
    Ring(Ring),
}

impl Rounded {
    /// Its corners, m.
    pub fn corners(&self) -> &[[f64; 3]] {
        match self {
            Rounded::Hull(hull) => &hull.corners,
            Rounded::Ring(ring) => &ring.corners,
        }
    }

    /// Radius of its edges, m.
    pub fn rounding(&self) -> f64 {
        match self {
            Rounded::Hull(hull) => hull.rounding,
            Rounded::Ring(ring) => ring.rounding,
        }
    }

    /// Distance of its furthest point from the origin, m.
    pub fn reach(&self) -> f64 {
        match self {
            Rounded::Hull(hull) => hull.reach,
            Rounded::Ring(ring) => ring.reach,
        }
    }

    /// The surface nearest to a position.
    pub fn nearest(&self, at: [f64; 3]) -> Nearest {
        match self {
            Rounded::Hull(hull) => hull.nearest(at),
            Rounded::Ring(ring) => ring.nearest(at),
        }
    }

    /// Ends of its edges that can cross edges of others; in the plane there are none.
    pub fn edges(&self) -> Vec<[[f64; 3]; 2]> {
        match self {
            Rounded::Hull(hull) => hull.edges().iter().map(|(ends, _)| ends.map(|k| hull.corners[k as usize])).collect(),
            Rounded::Ring(_) => Vec::new(),
        }
    }
}

impl Shape {
    /// The geometry of the shape.
    pub fn solid(&self) -> &dyn Solid {
        match self {
            Shape::Box(s) => s,
            Shape::Superquadric(s) => s,
            Shape::Polyhedron(s) => s,
            Shape::Polygon(s) => s,
        }
    }

    /// The shape as other bodies touch it; `None` for a superquadric, which has no corners. Edges of a box are rounded as [`Cuboid::rounded`] says.
    pub fn rounded(&self) -> Option<Rounded> {
        match self {
            Shape::Box(s) => Some(Rounded::Hull(s.rounded())),
            Shape::Polyhedron(s) => Some(Rounded::Hull(s.rounded_hull().clone())),
            Shape::Polygon(s) => Some(Rounded::Ring(s.rounded_ring().clone())),
            Shape::Superquadric(_) => None,
        }
    }

    /// Radius of the sphere of the same volume, m; of a polygon that of the disc of the same area.
    pub fn radius(&self) -> f64 {
        match self {
            Shape::Polygon(s) => s.radius(),
            _ => self.solid().bulk().radius(),
        }
    }

    /// Name of the kind of shape.
    pub fn name(&self) -> &'static str {
        match self {
            Shape::Box(_) => "box",
            Shape::Superquadric(_) => "superquadric",
            Shape::Polyhedron(_) => "polyhedron",
            Shape::Polygon(_) => "polygon",
        }
    }
}

#[cfg(test)]
mod tests;
