//! Shapes of rigid bodies, each in the frame of the body: origin at the centre of mass, axes along the principal axes of inertia.
//!
//! Other modules use a shape through [`Solid`] only. A body is touched by spheres (grains, ghosts of material points), for whose centres the nearest point of
//! the surface is needed, and by walls, for which the [spots](Solid::spot) of the body that can touch a plane are needed. Results are computed with
//! + − × ÷ √ or with functions made of these (`crate::math::portable`), so that they have the same bits on every machine.

mod apart;
mod compound;
mod core;
mod cuboid;
mod cut;
mod hull;
mod mesh;
mod moments;
mod polygon;
mod polyhedron;
mod ring;
mod sheet;
mod sieve;
mod smooth;
mod steiner;
mod superquadric;
mod tangent;

pub use self::core::{Core, CoreMeet, Seen};
pub use apart::{Apart, apart};
pub use compound::{Compound, Convex, Frame, MOST_PARTS, Part, Piece, PlacedCompound, Union};
pub use cuboid::Cuboid;
pub use cut::Fragment;
pub use hull::{Hull, HullFace};
pub use mesh::Mesh;
pub use polygon::Polygon;
pub use polyhedron::{Placed, Polyhedron};
pub use ring::{Ring, convex_ring};
pub use sheet::{MOST_TRIANGLES, Sheet, welded};
pub use smooth::Smooth;
pub use superquadric::Superquadric;
pub use tangent::{PlacedSmooth, Tangent, tangent};

use serde::{Deserialize, Serialize};

/// The surface of a shape, as seen from a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Distance of the position from the surface, m; negative inside.
    pub distance: f64,
    /// Outward unit normal at the nearest point of the surface; that point is the position minus `distance` times the normal.
    pub normal: [f64; 3],
}

/// Where a sphere meets a facet of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Meet {
    /// The facet as seen from the middle of the sphere.
    pub nearest: Nearest,
    /// Borders with facets that are nearer to it, as far as they are in reach, with the number of each such facet: beside them the contact counts less
    /// ([`Sheet`]). At most four; none of convex surfaces.
    pub borders: Vec<(u32, Nearest)>,
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

    /// The shape as a sheet without an inside, if it is one.
    fn sheet(&self) -> Option<&Sheet> {
        None
    }

    /// Number of facets: parts of the surface each of which can touch a sphere by itself. A convex surface is one.
    fn facets(&self) -> usize {
        1
    }

    /// Adds the numbers of the facets that are nearer to a position than `within`, m, to `found`, in their order.
    fn facets_near(&self, at: [f64; 3], within: f64, found: &mut Vec<u32>) {
        if self.clearance(at) < within && self.nearest(at).distance < within {
            found.push(0);
        }
    }

    /// Where a sphere at a position meets facet `facet`; `None` where another facet is nearer at that place, and where none can be nearer than `within`, m.
    fn meet(&self, facet: u32, at: [f64; 3], within: f64) -> Option<Meet> {
        let reached = facet == 0 && self.clearance(at) < within;
        reached.then(|| Meet { nearest: self.nearest(at), borders: Vec::new() })
    }

    /// Whether what touched facet `from`, nearer than `within`, m, has passed over a border to facet `to`.
    fn passes(&self, _from: u32, _to: u32, _at: [f64; 3], _within: f64) -> bool {
        false
    }
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
    /// A sheet of triangles.
    Mesh(Sheet),
    /// A union of convex parts.
    Compound(Box<Compound>),
}

/// A shape as other bodies touch it: corners, and a sphere or disc swept over all between them.
#[derive(Clone, Debug)]
pub enum Rounded {
    /// In space.
    Hull(Hull),
    /// In the plane.
    Ring(Ring),
    /// A sheet, with its corners.
    Sheet(Sheet, Vec<[f64; 3]>),
    /// Several hulls or rings.
    Union(Union),
    /// A superquadric, which has no corners.
    Smooth(Smooth),
}

impl Rounded {
    /// Its corners, m.
    pub fn corners(&self) -> &[[f64; 3]] {
        match self {
            Rounded::Hull(hull) => &hull.corners,
            Rounded::Ring(ring) => &ring.corners,
            Rounded::Sheet(_, corners) => corners,
            Rounded::Union(union) => &union.corners,
            Rounded::Smooth(_) => &[],
        }
    }

    /// Radius of its edges, m; of several the least.
    pub fn rounding(&self) -> f64 {
        match self {
            Rounded::Hull(hull) => hull.rounding,
            Rounded::Ring(ring) => ring.rounding,
            Rounded::Sheet(sheet, _) => sheet.rounding(),
            Rounded::Union(union) => union.roundings()[0],
            Rounded::Smooth(smooth) => smooth.rounding,
        }
    }

    /// Largest radius of its edges, m.
    pub fn widest(&self) -> f64 {
        if let Rounded::Union(union) = self { union.roundings()[1] } else { self.rounding() }
    }

    /// Radius at corner `k`, m.
    pub fn corner_radius(&self, k: usize) -> f64 {
        if let Rounded::Union(union) = self { union.corner_radius(k) } else { self.rounding() }
    }

    /// Radius of edge `k`, m.
    pub fn edge_radius(&self, k: usize) -> f64 {
        if let Rounded::Union(union) = self { union.edge_radius(k) } else { self.rounding() }
    }

    /// Distance of its furthest point from the origin, m.
    pub fn reach(&self) -> f64 {
        match self {
            Rounded::Hull(hull) => hull.reach,
            Rounded::Ring(ring) => ring.reach,
            Rounded::Sheet(sheet, _) => sheet.reach(),
            Rounded::Union(union) => union.reach,
            Rounded::Smooth(smooth) => smooth.reach,
        }
    }

    /// Where a sphere at a position meets facet `facet` ([`Solid::meet`]); of a convex surface the nearest point, `None` only where that is further than `within`, m.
    pub fn meet(&self, facet: u32, at: [f64; 3], within: f64) -> Option<Meet> {
        let nearest = match self {
            Rounded::Hull(hull) => hull.nearest_within(at, within)?,
            Rounded::Ring(ring) => ring.nearest(at),
            Rounded::Sheet(sheet, _) => return sheet.meet(facet, at, within),
            Rounded::Union(union) => return union.meet(facet, at, within),
            Rounded::Smooth(_) => return None,
        };
        Some(Meet { nearest, borders: Vec::new() })
    }

    /// A bound below on the distance of a position from a convex surface with corners, m; `None` of others.
    pub fn before(&self, at: [f64; 3]) -> Option<f64> {
        match self {
            Rounded::Hull(hull) => Some(hull.before(at)),
            Rounded::Ring(ring) => Some(ring.nearest(at).distance),
            Rounded::Sheet(..) | Rounded::Union(_) | Rounded::Smooth(_) => None,
        }
    }

    /// Numbers of the facets that are nearer to a position than `within`, m.
    pub fn facets_near(&self, at: [f64; 3], within: f64) -> Vec<u32> {
        let near = match self {
            Rounded::Hull(hull) => hull.nearest_within(at, within).is_some_and(|nearest| nearest.distance < within),
            Rounded::Ring(ring) => ring.nearest(at).distance < within,
            Rounded::Sheet(sheet, _) => {
                let mut found = Vec::new();
                sheet.facets_near(at, within, &mut found);
                return found;
            }
            Rounded::Union(union) => {
                let mut found = Vec::new();
                union.facets_near(at, within, &mut found);
                return found;
            }
            Rounded::Smooth(_) => false,
        };
        if near { vec![0] } else { Vec::new() }
    }

    /// Where a superquadric with this core meets facet `facet` of a sheet or part `facet` of a union; `None` where another one is nearer at that place, and where it is further than `within`, m.
    pub fn meet_core(&self, facet: u32, core: &Core<'_>, within: f64) -> Option<CoreMeet> {
        match self {
            Rounded::Sheet(sheet, _) => sheet.meet_core(facet, core, within),
            Rounded::Union(union) => union.meet_core(facet, core, within),
            Rounded::Hull(_) | Rounded::Ring(_) | Rounded::Smooth(_) => None,
        }
    }

    /// The place of the core of a superquadric that is nearest to facet `facet` of a sheet or part `facet` of a union, if that is nearer than `within`, m.
    pub fn near_core(&self, facet: u32, core: &Core<'_>, within: f64) -> Option<Seen> {
        match self {
            Rounded::Sheet(sheet, _) => sheet.near_core(facet, core, within),
            Rounded::Union(union) => union.near_core(facet, core, within),
            Rounded::Hull(_) | Rounded::Ring(_) | Rounded::Smooth(_) => None,
        }
    }

    /// Numbers of the facets of a sheet, or of the parts of a union, that may be nearer to a core than `within`, m.
    pub fn facets_about(&self, core: &Core<'_>, within: f64) -> Vec<u32> {
        match self {
            Rounded::Sheet(sheet, _) => sheet.facets_about(core, within),
            Rounded::Union(union) => (0..union.parts.len() as u32).collect(),
            Rounded::Hull(_) | Rounded::Ring(_) | Rounded::Smooth(_) => Vec::new(),
        }
    }

    /// The superquadric, if it is one.
    pub fn smooth(&self) -> Option<&Smooth> {
        if let Rounded::Smooth(smooth) = self { Some(smooth) } else { None }
    }

    /// Whether it is a superquadric.
    pub fn is_smooth(&self) -> bool {
        matches!(self, Rounded::Smooth(_))
    }

    /// Whether it is a convex body in space, which has a [`Self::core`].
    pub fn is_convex(&self) -> bool {
        matches!(self, Rounded::Smooth(_) | Rounded::Hull(_))
    }

    /// Whether its distance from a position can be bounded ([`Self::before`]).
    pub fn has_gaps(&self) -> bool {
        matches!(self, Rounded::Hull(_) | Rounded::Ring(_))
    }

    /// Point that is furthest along the unit vector `towards` of what the sphere is swept over; `None` of a body that is not convex or lies in the plane.
    pub fn core(&self, towards: [f64; 3]) -> Option<[f64; 3]> {
        match self {
            Rounded::Smooth(smooth) => Some(smooth.core(towards)),
            Rounded::Hull(hull) => Some(hull.furthest(towards)),
            Rounded::Ring(_) | Rounded::Sheet(..) | Rounded::Union(_) => None,
        }
    }

    /// The shape as a sheet, if it is one.
    pub fn sheet(&self) -> Option<&Sheet> {
        if let Rounded::Sheet(sheet, _) = self { Some(sheet) } else { None }
    }

    /// Whether corner `k` acts on a body in the direction `towards`, unit vector; of a convex shape it does.
    pub fn corner_acts(&self, k: usize, towards: [f64; 3]) -> bool {
        self.sheet().is_none_or(|sheet| sheet.corner_acts(k, towards))
    }

    /// As [`Self::corner_acts`], for edge `k`.
    pub fn edge_acts(&self, k: usize, towards: [f64; 3]) -> bool {
        self.sheet().is_none_or(|sheet| sheet.edge_acts(k, towards))
    }

    /// Whether what touched facet `from`, nearer than `within`, m, has passed over to facet `to` ([`Solid::passes`]).
    pub fn passes(&self, from: u32, to: u32, at: [f64; 3], within: f64) -> bool {
        match self {
            Rounded::Sheet(sheet, _) => sheet.passes(from, to, at, within),
            Rounded::Union(union) => union.passes(from, to, at, within),
            Rounded::Hull(_) | Rounded::Ring(_) | Rounded::Smooth(_) => false,
        }
    }

    /// Whether corner `k` is the middle of a disc, which has one corner in the plane.
    pub fn corner_is_disc(&self, k: usize) -> bool {
        match self {
            Rounded::Ring(ring) => ring.corners.len() == 1,
            Rounded::Union(union) => union.is_disc(k),
            Rounded::Hull(_) | Rounded::Sheet(..) | Rounded::Smooth(_) => false,
        }
    }

    /// Whether facet `facet` is a disc.
    pub fn facet_is_disc(&self, facet: u32) -> bool {
        match self {
            Rounded::Ring(ring) => ring.corners.len() == 1,
            Rounded::Union(union) => union.facet_is_disc(facet),
            Rounded::Hull(_) | Rounded::Sheet(..) | Rounded::Smooth(_) => false,
        }
    }

    /// Its convex parts with corners, without what is round; none of a sheet and of a superquadric.
    pub fn parts(&self) -> Vec<Part> {
        match self {
            Rounded::Hull(hull) => vec![Part::of(Convex::Hull(hull.clone()))],
            Rounded::Ring(ring) => vec![Part::of(Convex::Ring(ring.clone()))],
            Rounded::Union(union) => union.parts.clone(),
            Rounded::Sheet(..) | Rounded::Smooth(_) => Vec::new(),
        }
    }

    /// Ends of its edges that can cross edges of others; in the plane there are none.
    pub fn edges(&self) -> Vec<[[f64; 3]; 2]> {
        match self {
            Rounded::Hull(hull) => hull.edges().iter().map(|(ends, _)| ends.map(|k| hull.corners[k as usize])).collect(),
            Rounded::Ring(_) | Rounded::Smooth(_) => Vec::new(),
            Rounded::Sheet(sheet, _) => sheet.edges(),
            Rounded::Union(union) => union.edges(),
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
            Shape::Mesh(s) => s,
            Shape::Compound(s) => s.as_ref(),
        }
    }

    /// The shape as other bodies touch it. Edges of a box are rounded as [`Cuboid::rounded`] says.
    pub fn rounded(&self) -> Rounded {
        match self {
            Shape::Box(s) => Rounded::Hull(s.rounded()),
            Shape::Polyhedron(s) => Rounded::Hull(s.rounded_hull().clone()),
            Shape::Polygon(s) => Rounded::Ring(s.rounded_ring().clone()),
            Shape::Mesh(s) => Rounded::Sheet(s.clone(), s.corners()),
            Shape::Compound(s) => Rounded::Union(s.rounded_union().clone()),
            Shape::Superquadric(s) => Rounded::Smooth(Smooth::of(*s)),
        }
    }

    /// Whether it is one of plane strain.
    pub fn is_flat(&self) -> bool {
        match self {
            Shape::Polygon(_) => true,
            Shape::Compound(s) => s.is_flat(),
            Shape::Box(_) | Shape::Superquadric(_) | Shape::Polyhedron(_) | Shape::Mesh(_) => false,
        }
    }

    /// Radius of the sphere of the same volume, m; of a polygon that of the disc of the same area; infinite for a sheet, which to others is a plane.
    pub fn radius(&self) -> f64 {
        match self {
            Shape::Polygon(s) => s.radius(),
            Shape::Mesh(_) => f64::INFINITY,
            Shape::Compound(s) => s.radius(),
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
            Shape::Mesh(_) => "mesh",
            Shape::Compound(_) => "compound",
        }
    }
}

#[cfg(test)]
mod tests;
