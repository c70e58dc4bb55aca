//! Sheets of triangles, as files of meshes have them: fixed or driven boundaries of any form, open or closed, that act on both sides.
//!
//! Triangles that lie in one plane and hang together are one *facet*, so that a floor of many triangles is one, and what slides on it keeps its history. A sphere
//! touches a facet at the facet's nearest point, unless that lies on a border with another facet that is nearer there, or equally near with a lower number: contacts
//! are the local minima of distance over the sheet. On an edge that sticks out there is one, in an inner corner of three walls there are three.
//!
//! In a shallow inner edge a sphere touches two facets at nearly the same place. There the energy of the further one is Φ(δ) − Φ(δ_e), with the energy Φ of the contact law
//! at an overlap, the facet's overlap δ and the overlap δ_e of the edge (or only vertex) between: forces begin and end without a jump, and together the two bear what one sheet without
//! an edge would. So a facet is met with the *borders* beside which that is so ([`Meet::borders`]).
//!
//! A sheet has no inside, no volume and no mass.

mod core;
pub(super) mod foot;
mod topology;

pub use topology::welded;

use super::{Bulk, Meet, Mesh, Nearest, Solid};
use crate::math::vector::{dot, less, scaled};
use foot::{Foot, Place, of_side, of_triangle};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use topology::{NONE, Topology};

/// Most triangles of a sheet.
pub const MOST_TRIANGLES: usize = 100_000;
/// Cosine of the angle to the side to which the sheet bends within which its edges and corners act on no other body: there facets do.
const BENT: f64 = 0.7;
/// Most triangles of a facet that are all looked at, rather than those in a box that the tree finds.
const FEW: usize = 16;
/// Most borders that a contact is shared over.
const BORDERS: usize = 4;

/// The borders of a contact that it is shared over: the nearest ones, of which `distance` returns how far each is, m.
pub(super) fn shared_over<T>(mut borders: Vec<(u32, T)>, distance: impl Fn(&T) -> f64) -> Vec<(u32, T)> {
    if borders.len() > BORDERS {
        borders.sort_by(|a, b| distance(&a.1).total_cmp(&distance(&b.1)));
        borders.truncate(BORDERS);
    }
    borders
}

/// What a sheet is made from, and all that is kept of it in a file.
#[derive(Clone, Serialize, Deserialize)]
struct Plain {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    rounding: f64,
}

/// A sheet of triangles with a sphere swept over it; copies share its parts.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(into = "Plain", try_from = "Plain")]
pub struct Sheet(Arc<Parts>);

struct Parts {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    rounding: f64,
    topology: Topology,
    /// Boxes of the triangles.
    tree: Bvh,
    /// Lowest and highest coordinates of the vertices.
    bounds: [[f64; 3]; 2],
    reach: f64,
}

impl std::fmt::Debug for Parts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} triangles, {} facets, rounding {} m", self.triangles.len(), self.topology.members.len(), self.rounding)
    }
}

impl PartialEq for Sheet {
    fn eq(&self, other: &Sheet) -> bool {
        let of = |s: &Sheet| (s.0.rounding.to_bits(), s.0.triangles.len(), s.0.vertices.len());
        Arc::ptr_eq(&self.0, &other.0)
            || of(self) == of(other) && self.0.triangles == other.0.triangles && self.0.vertices == other.0.vertices
    }
}

impl From<Sheet> for Plain {
    fn from(sheet: Sheet) -> Plain {
        let Parts { vertices, triangles, rounding, .. } = &*sheet.0;
        Plain { vertices: vertices.clone(), triangles: triangles.clone(), rounding: *rounding }
    }
}

impl TryFrom<Plain> for Sheet {
    type Error = String;

    fn try_from(plain: Plain) -> Result<Sheet, String> {
        Sheet::of(&plain.vertices, &plain.triangles, plain.rounding)
    }
}

impl Sheet {
    /// The sheet of these triangles, m, with a sphere of radius `rounding`, m, swept over it. Equal vertices become one.
    ///
    /// # Errors
    /// No triangles or too many, a vertex that there is not or that is no place, a flat triangle, more than two triangles at an edge; the text says which.
    pub fn of(vertices: &[[f64; 3]], triangles: &[[u32; 3]], rounding: f64) -> Result<Sheet, String> {
        if triangles.len() > MOST_TRIANGLES {
            return Err(format!("has {} triangles, where there may be {MOST_TRIANGLES}", triangles.len()));
        }
        let beyond = |t: &[u32; 3]| t.iter().any(|k| *k as usize >= vertices.len());
        if let Some((k, t)) = triangles.iter().enumerate().find(|(_, t)| beyond(t)) {
            return Err(format!("has triangle {k} with the vertices {t:?} of {}", vertices.len()));
        }
        if !(rounding.is_finite() && rounding >= 0.0) {
            return Err(format!("is rounded by {rounding} m"));
        }
        let (vertices, triangles) = welded(vertices, triangles);
        let topology = Topology::of(&vertices, &triangles)?;
        let bounds_of = |t: &mut dyn Iterator<Item = [f64; 3]>| {
            t.fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[low, high], p| {
                [std::array::from_fn(|a| p[a].min(low[a])), std::array::from_fn(|a| p[a].max(high[a]))]
            })
        };
        let boxes: Vec<Aabb> = triangles
            .iter()
            .map(|t| {
                let [low, high] = bounds_of(&mut t.iter().map(|k| vertices[*k as usize]));
                Aabb::new(Vector::from(low), Vector::from(high))
            })
            .collect();
        let tree = Bvh::from_leaves(BvhBuildStrategy::default(), &boxes);
        let bounds = bounds_of(&mut vertices.iter().copied());
        let reach = vertices.iter().map(|p| dot(*p, *p).sqrt()).fold(0.0, f64::max) + rounding;
        Ok(Sheet(Arc::new(Parts { vertices, triangles, rounding, topology, tree, bounds, reach })))
    }

    /// Radius of the sphere that is swept over it, m.
    pub fn rounding(&self) -> f64 {
        self.0.rounding
    }

    /// Number of triangles.
    pub fn triangles(&self) -> usize {
        self.0.triangles.len()
    }

    /// Lowest and highest coordinates, m, without the rounding.
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        self.0.bounds
    }

    /// Whether it has no border.
    pub fn is_closed(&self) -> bool {
        self.0.topology.closed
    }

    /// Vertices at which its edges end, m.
    pub fn corners(&self) -> Vec<[f64; 3]> {
        self.0.topology.corners.iter().map(|corner| self.0.vertices[corner.vertex as usize]).collect()
    }

    /// Ends of its borders and of the lines along which it bends, m, straight ones in one piece.
    pub fn edges(&self) -> Vec<[[f64; 3]; 2]> {
        self.0.topology.edges.iter().map(|edge| edge.ends.map(|k| self.0.vertices[k as usize])).collect()
    }

    /// Whether corner `k` acts on a body in the direction `towards`, unit vector: not on the side to which the sheet bends.
    pub fn corner_acts(&self, k: usize, towards: [f64; 3]) -> bool {
        self.0.topology.corners.get(k).is_some_and(|corner| dot(corner.bend, towards) < BENT)
    }

    /// As [`Self::corner_acts`], for edge `k`.
    pub fn edge_acts(&self, k: usize, towards: [f64; 3]) -> bool {
        self.0.topology.edges.get(k).is_some_and(|edge| dot(edge.bend, towards) < BENT)
    }

    /// Numbers of the corners and of the edges in the box of this half size, m, about a position, each in their order. Some more may be among them.
    pub fn sharp_near(&self, at: [f64; 3], half: f64) -> [Vec<u32>; 2] {
        let Topology { edge_of, corner_of, .. } = &self.0.topology;
        let (mut corners, mut edges) = (Vec::new(), Vec::new());
        self.visit(cube(at, half), |t| {
            edges.extend(edge_of[t].iter().filter(|e| **e != NONE));
            corners.extend(self.0.triangles[t].iter().map(|k| corner_of[*k as usize]).filter(|c| *c != NONE));
        });
        [corners, edges].map(|mut list| {
            list.sort_unstable();
            list.dedup();
            list
        })
    }

    /// The corners of each triangle that reaches into the box of this half size, m, about a position, in the order of the triangles.
    pub fn triangles_near(&self, at: [f64; 3], half: f64) -> Vec<[[f64; 3]; 3]> {
        let mut found = Vec::new();
        self.visit(cube(at, half), |t| found.push(t));
        found.sort_unstable();
        found.into_iter().map(|t| self.0.triangles[t].map(|k| self.0.vertices[k as usize])).collect()
    }

    /// Calls `each` with every triangle whose box cuts the box between two corners, in no order.
    fn visit(&self, [low, high]: [[f64; 3]; 2], mut each: impl FnMut(usize)) {
        let around = Aabb::new(Vector::from(low), Vector::from(high));
        self.0.tree.intersect_aabb(&around).for_each(|t| each(t as usize));
    }

    fn foot(&self, t: usize, at: [f64; 3]) -> Foot {
        of_triangle(&self.0.vertices, self.0.triangles[t], self.0.topology.normals[t], at)
    }

    /// As [`Self::visit`], for the triangles of one facet only; of a small facet all of them.
    fn visit_facet(&self, facet: u32, bounds: impl FnOnce() -> [[f64; 3]; 2], mut each: impl FnMut(usize)) {
        let Topology { members, facet: of, .. } = &self.0.topology;
        match members.get(facet as usize) {
            Some(few) if few.len() <= FEW => few.iter().for_each(|t| each(*t as usize)),
            Some(_) => self.visit(bounds(), |t| {
                if of[t] == facet {
                    each(t);
                }
            }),
            None => {}
        }
    }

    /// The nearest point on facet `facet`, or on all, nearer than `within`, m, and its triangle.
    fn nearest_on(&self, facet: Option<u32>, at: [f64; 3], within: f64) -> Option<(Foot, usize)> {
        let mut best: Option<(Foot, usize)> = None;
        let compare = |t: usize| {
            let foot = self.foot(t, at);
            // of equally near ones the lowest, whatever the order of the tree
            if best.is_none_or(|(least, of)| (foot.square, t) < (least.square, of)) {
                best = Some((foot, t));
            }
        };
        match facet {
            Some(facet) => self.visit_facet(facet, || cube(at, within), compare),
            None => self.visit(cube(at, within), compare),
        }
        best.filter(|(foot, _)| foot.square < within * within)
    }

    /// The triangles of other facets at the place of a foot on triangle `t`.
    fn others_at(&self, foot: &Foot, t: usize) -> impl Iterator<Item = usize> {
        let Topology { beyond, around, facet, .. } = &self.0.topology;
        let (across, about): (u32, &[u32]) = match foot.place {
            Place::Face => (NONE, &[]),
            Place::Side(k) => (beyond[t][k], &[]),
            Place::Vertex(k) => (NONE, &around[k as usize]),
        };
        let all = about.iter().copied().chain((across != NONE).then_some(across));
        all.map(|other| other as usize).filter(move |other| facet[*other] != facet[t])
    }

    /// The surface as seen from the place of a foot on triangle `t`.
    fn seen(&self, foot: &Foot, t: usize) -> Nearest {
        let distance = foot.square.sqrt();
        let normal = if distance > 0.0 { scaled(foot.out, 1.0 / distance) } else { self.0.topology.normals[t] };
        Nearest { distance: distance - self.0.rounding, normal }
    }

    /// Borders, sides or vertices, of facet `facet`, whose nearest point is at `best` (square of the distance), with facets that are nearer: the nearest place of each, as far
    /// as it is nearer than `within`, m.
    fn borders(&self, facet: u32, best: f64, at: [f64; 3], within: f64) -> Vec<(u32, Nearest)> {
        let Topology { beyond, around, facet: of, .. } = &self.0.topology;
        let mut found: Vec<(u32, usize, Foot)> = Vec::new();
        self.visit_facet(
            facet,
            || cube(at, within),
            |t| {
                for (k, beside) in beyond[t].into_iter().enumerate() {
                    let side = of_side(&self.0.vertices, self.0.triangles[t], k, at);
                    let vertex = self.0.triangles[t][k];
                    let out = less(at, self.0.vertices[vertex as usize]);
                    let corner = Foot { square: dot(out, out), out, place: Place::Vertex(vertex) };
                    let across = Some(beside).into_iter().filter(|other| *other != NONE && side.square < within * within);
                    let about = around[vertex as usize].iter().copied().filter(|_| corner.square < within * within);
                    let others = across.map(|other| (other, side)).chain(about.map(|other| (other, corner)));
                    let others = others.map(|(other, foot)| (of[other as usize], t, foot));
                    found.extend(others.filter(|(other, ..)| *other != facet));
                }
            },
        );
        found.sort_unstable_by(|a, b| {
            (a.0, a.2.square, a.1).partial_cmp(&(b.0, b.2.square, b.1)).unwrap_or(std::cmp::Ordering::Equal)
        });
        found.dedup_by_key(|(other, ..)| *other);
        let nearer = |other: u32| {
            let theirs = self.nearest_on(Some(other), at, within);
            theirs.is_some_and(|(foot, _)| (foot.square, other) < (best, facet))
        };
        let borders: Vec<(u32, Nearest)> =
            found.into_iter().filter(|(other, ..)| nearer(*other)).map(|(other, t, foot)| (other, self.seen(&foot, t))).collect();
        shared_over(borders, |border| border.distance)
    }
}

/// The corners of the box of this half size, m, about a position.
fn cube(at: [f64; 3], half: f64) -> [[f64; 3]; 2] {
    [at.map(|x| x - half), at.map(|x| x + half)]
}

impl Solid for Sheet {
    fn nearest(&self, at: [f64; 3]) -> Nearest {
        let mut within = self.clearance(at).max(0.0) + 1e-3 * self.0.reach;
        // the box of all vertices is found within a few doublings, if the position is one
        for _ in 0..128 {
            if let Some((foot, t)) = self.nearest_on(None, at, within) {
                return self.seen(&foot, t);
            }
            within *= 2.0;
        }
        Nearest { distance: f64::INFINITY, normal: [0.0, 0.0, 1.0] }
    }

    fn clearance(&self, at: [f64; 3]) -> f64 {
        let [low, high] = self.0.bounds;
        let out: [f64; 3] = std::array::from_fn(|a| (low[a] - at[a]).max(at[a] - high[a]).max(0.0));
        dot(out, out).sqrt() - self.0.rounding
    }

    fn reach(&self) -> f64 {
        self.0.reach
    }

    /// None: walls do not touch a sheet, which is driven.
    fn spots(&self) -> usize {
        0
    }

    fn spot(&self, _: usize, _: [f64; 3]) -> [f64; 3] {
        [0.0; 3]
    }

    fn bulk(&self) -> Bulk {
        Bulk { volume: 0.0, moments: [0.0; 3] }
    }

    fn surface(&self) -> Mesh {
        Mesh { corners: self.0.vertices.clone(), triangles: self.0.triangles.clone() }
    }

    fn sheet(&self) -> Option<&Sheet> {
        Some(self)
    }

    fn facets(&self) -> usize {
        self.0.topology.members.len()
    }

    fn facets_near(&self, at: [f64; 3], within: f64, found: &mut Vec<u32>) {
        let (far, mut near) = (within + self.0.rounding, Vec::new());
        if self.clearance(at) < within {
            self.visit(cube(at, far), |t| {
                if self.foot(t, at).square < far * far {
                    near.push(self.0.topology.facet[t]);
                }
            });
        }
        near.sort_unstable();
        near.dedup();
        found.append(&mut near);
    }

    fn meet(&self, facet: u32, at: [f64; 3], within: f64) -> Option<Meet> {
        if self.clearance(at) >= within {
            return None;
        }
        let (of, far) = (&self.0.topology.facet, within + self.0.rounding);
        let (foot, t) = self.nearest_on(Some(facet), at, far)?;
        let behind = self.others_at(&foot, t).any(|other| (self.foot(other, at).square, of[other]) < (foot.square, facet));
        (!behind).then(|| Meet { nearest: self.seen(&foot, t), borders: self.borders(facet, foot.square, at, far) })
    }

    fn passes(&self, from: u32, to: u32, at: [f64; 3], within: f64) -> bool {
        let of = &self.0.topology.facet;
        let found = self.nearest_on(Some(from), at, within + self.0.rounding);
        found.is_some_and(|(foot, t)| self.others_at(&foot, t).any(|other| of[other] == to))
    }
}

#[cfg(test)]
mod tests;
