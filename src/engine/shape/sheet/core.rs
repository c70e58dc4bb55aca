//! How a superquadric meets a sheet: its convex core with a sphere swept over it, on facets.
//!
//! A facet acts where it is nearest to the core. On a border with another facet that is nearer to the core, or equally near with a lower number, it does not; beside such a border it acts less, by the overlap with the
//! border itself. So the energy of two facets is that of a sphere's contacts with them, each distance being that of the core: it is the energy of a place, so forces from it conserve energy.

use super::foot::{Foot, Place};
use super::topology::NONE;
use super::{Sheet, shared_over};
use crate::math::vector::{dot, less, scaled};
use crate::shape::core::{Core, CoreMeet, Seen};

/// Share of a distance within which two count as equal, for rounding.
const HAIR: f64 = 1e-11;
/// Share of the square of a distance by which the nearest place of a facet may lie aside of the plane's.
const ASIDE: f64 = 1e-14;

/// The place of a core that is nearest to a facet.
struct OnFacet {
    at: [f64; 3],
    foot: Foot,
    /// Triangle of the foot.
    triangle: usize,
}

impl OnFacet {
    fn distance(&self) -> f64 {
        self.foot.square.sqrt()
    }
}

impl Sheet {
    /// Where a core meets facet `facet`; `None` where another facet is nearer at that place, and where it is further than `within`, m.
    pub(in crate::shape) fn meet_core(&self, facet: u32, core: &Core<'_>, within: f64) -> Option<CoreMeet> {
        let far = within + self.rounding();
        let on = self.on_facet(facet, core, far)?;
        let distance = on.distance();
        let of = &self.0.topology.facet;
        let at_foot: Vec<u32> = self.others_at(&on.foot, on.triangle).map(|other| of[other]).collect();
        let mut borders = Vec::new();
        for other in self.beside(facet, core, far) {
            let room = (1.0 + HAIR) * distance;
            let Some(theirs) = self.on_facet(other, core, room).map(|theirs| theirs.distance()) else { continue };
            if theirs >= (1.0 - HAIR) * distance && other > facet {
                continue;
            }
            if at_foot.contains(&other) {
                return None;
            }
            borders.extend(self.border(facet, other, core, far).map(|border| (other, border)));
        }
        let borders = shared_over(borders, |border: &Seen| border.nearest.distance);
        let on = Seen { at: on.at, nearest: self.seen(&on.foot, on.triangle) };
        Some(CoreMeet { on, borders })
    }

    /// The place of a core that is nearest to facet `facet`, if that is nearer than `within`, m.
    pub(in crate::shape) fn near_core(&self, facet: u32, core: &Core<'_>, within: f64) -> Option<Seen> {
        let on = self.on_facet(facet, core, within + self.rounding())?;
        Some(Seen { at: on.at, nearest: self.seen(&on.foot, on.triangle) })
    }

    /// Numbers of the facets in the box around what is nearer to a core than `within`, m.
    pub(in crate::shape) fn facets_about(&self, core: &Core<'_>, within: f64) -> Vec<u32> {
        let mut found = Vec::new();
        self.visit(core.around(within + self.rounding()), |t| found.push(self.0.topology.facet[t]));
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The place of the core that is nearest to a facet, if that is nearer than `far`, m.
    fn on_facet(&self, facet: u32, core: &Core<'_>, far: f64) -> Option<OnFacet> {
        let start = match self.above(facet, core, far) {
            Ok(found) => return Some(found),
            Err(start) => start,
        };
        let mut near = Vec::new();
        self.visit_facet(facet, || core.around(far), |t| near.push(t));
        near.sort_unstable();
        let (mut best, mut beyond) = (None, far);
        for t in near {
            let about = less(core.centre, self.foot(t, core.centre).out);
            let corners = self.0.triangles[t].map(|k| self.0.vertices[k as usize]);
            // of equally near ones the lowest
            if let Some(found) =
                core.nearest_to_hull(&corners, (about, start), beyond).filter(|found| best.is_none() || found.distance < beyond)
            {
                (best, beyond) = (Some((found.on_first, t)), found.distance);
            }
        }
        let (at, t) = best?;
        if beyond == 0.0 {
            return Some(OnFacet { at, foot: Foot { square: 0.0, out: [0.0; 3], place: Place::Face }, triangle: t });
        }
        let (foot, triangle) = self.nearest_on(Some(facet), at, far)?;
        Some(OnFacet { at, foot, triangle })
    }

    /// The same of a core that lies wholly on one side of the plane of a facet, with the facet under its lowest point: the usual case. Else the direction from that point to the facet, if it is near.
    fn above(&self, facet: u32, core: &Core<'_>, far: f64) -> Result<OnFacet, Option<[f64; 3]>> {
        let normals = &self.0.topology.normals;
        let first = self.0.topology.members.get(facet as usize).and_then(|members| members.first());
        let (mut of, mut start) = (*first.ok_or(None)? as usize, None);
        // triangles of a facet may be turned against each other by a little
        for _ in 0..2 {
            let (normal, corner) = (normals[of], self.0.vertices[self.0.triangles[of][0] as usize]);
            let out = scaled(normal, 1.0_f64.copysign(dot(normal, less(core.centre, corner))));
            let at = core.furthest(out.map(|x| -x));
            let height = dot(out, less(at, corner));
            if height <= 0.0 {
                return Err(None);
            }
            let (foot, triangle) = self.nearest_on(Some(facet), at, 2.0 * far).ok_or(start)?;
            if foot.square <= height * height * (1.0 + ASIDE) && foot.square < far * far {
                return Ok(OnFacet { at, foot, triangle });
            }
            start = (foot.square > 0.0).then(|| scaled(foot.out, -1.0 / foot.square.sqrt()));
            if triangle == of {
                break;
            }
            of = triangle;
        }
        Err(start)
    }

    /// Other facets at the sides and vertices of a facet that are nearer to a core than `far`, m, with some more.
    fn beside(&self, facet: u32, core: &Core<'_>, far: f64) -> Vec<u32> {
        let of = &self.0.topology.facet;
        let mut found = Vec::new();
        self.visit_facet(
            facet,
            || core.around(far),
            |t| {
                let about = self.0.triangles[t].iter().flat_map(|k| &self.0.topology.around[*k as usize]);
                found.extend(about.map(|other| of[*other as usize]).filter(|other| *other != facet));
            },
        );
        found.sort_unstable();
        found.dedup();
        found
    }

    /// What facets `facet` and `other` have in common, as seen from the core: sides, or vertices.
    fn border(&self, facet: u32, other: u32, core: &Core<'_>, far: f64) -> Option<Seen> {
        let (topology, vertices) = (&self.0.topology, &self.0.vertices);
        let is_other = |t: u32| t != NONE && topology.facet[t as usize] == other;
        let (mut sides, mut single): (Vec<[u32; 2]>, Vec<u32>) = Default::default();
        self.visit_facet(
            facet,
            || core.around(far),
            |t| {
                let triangle = self.0.triangles[t];
                for k in 0..3 {
                    let (i, j) = (triangle[k], triangle[(k + 1) % 3]);
                    if is_other(topology.beyond[t][k]) {
                        sides.push([i.min(j), i.max(j)]);
                    }
                    if topology.around[i as usize].iter().any(|t| is_other(*t)) {
                        single.push(i);
                    }
                }
            },
        );
        sides.sort_unstable();
        single.sort_unstable();
        single.dedup();
        single.retain(|k| !sides.as_flattened().contains(k));
        let (mut best, mut beyond) = (None, far);
        let mut take = |corners: &[[f64; 3]], about: [f64; 3]| {
            if let Some(found) =
                core.nearest_to_hull(corners, (about, None), beyond).filter(|found| best.is_none() || found.distance < beyond)
            {
                (best, beyond) = (Some(found), found.distance);
            }
        };
        for ends in sides {
            let [p, q] = ends.map(|k| vertices[k as usize]);
            let along = less(q, p);
            let share = (dot(along, less(core.centre, p)) / dot(along, along)).clamp(0.0, 1.0);
            take(&[p, q], less(p, scaled(along, -share)));
        }
        for k in single {
            let at = vertices[k as usize];
            take(&[at], at);
        }
        let found = best.filter(|found| found.distance > 0.0)?;
        let foot = Foot { square: found.distance * found.distance, out: scaled(found.normal, -found.distance), place: Place::Face };
        Some(Seen { at: found.on_first, nearest: self.seen(&foot, 0) })
    }
}
