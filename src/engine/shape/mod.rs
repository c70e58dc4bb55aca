//! Shapes of rigid bodies, each in a frame of its own: origin at the centre of mass, axes along the principal axes of inertia.
//!
//! [`Solid`] is all that the rest knows of a shape. What touches a body is a sphere (a grain, the ghost of a material point), whose middle asks for the
//! nearest point, or a plane, which looks at the [spots](Solid::spot) of the body that can reach it. Only + − × ÷ √ stand behind the answers, or what
//! `crate::math::portable` makes of them.

mod cuboid;
mod mesh;
mod polyhedron;
mod superquadric;

pub use cuboid::Cuboid;
pub use mesh::Mesh;
pub use polyhedron::{Placed, Polyhedron};
pub use superquadric::Superquadric;

use serde::{Deserialize, Serialize};

/// Where a surface is from a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Distance from the surface, m; negative inside.
    pub distance: f64,
    /// Outward unit normal there. The nearest point is the place less `distance` times this.
    pub normal: [f64; 3],
}

/// Volume, m³, and the moments of inertia of unit density about the three axes, m⁵.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bulk {
    pub volume: f64,
    pub moments: [f64; 3],
}

impl Bulk {
    /// Radius of the sphere of the same volume, m.
    pub fn radius(&self) -> f64 {
        (0.75 / std::f64::consts::PI * self.volume).cbrt()
    }
}

/// What is asked of a shape. Lengths in m.
pub trait Solid {
    /// The surface from a place, which lies outside in all that a contact asks.
    fn nearest(&self, at: [f64; 3]) -> Nearest;

    /// At most the distance of a place; cheap.
    fn clearance(&self, at: [f64; 3]) -> f64;

    /// Distance of the furthest point from the origin.
    fn reach(&self) -> f64;

    /// Number of spots that can touch a plane.
    fn spots(&self) -> usize;

    /// The spot `k`: its point furthest along the unit vector `towards`.
    fn spot(&self, k: usize, towards: [f64; 3]) -> [f64; 3];

    fn bulk(&self) -> Bulk;

    /// The surface as triangles, for pictures.
    fn surface(&self) -> Mesh;
}

/// One of the shapes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    Box(Cuboid),
    Superquadric(Superquadric),
    Polyhedron(Polyhedron),
}

impl Shape {
    /// The shape behind the seam.
    pub fn solid(&self) -> &dyn Solid {
        match self {
            Shape::Box(s) => s,
            Shape::Superquadric(s) => s,
            Shape::Polyhedron(s) => s,
        }
    }

    /// In words.
    pub fn name(&self) -> &'static str {
        match self {
            Shape::Box(_) => "box",
            Shape::Superquadric(_) => "superquadric",
            Shape::Polyhedron(_) => "polyhedron",
        }
    }
}

#[cfg(test)]
mod tests;
