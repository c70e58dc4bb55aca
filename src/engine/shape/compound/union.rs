//! The surface of a union of convex parts, as spheres and other bodies touch it.
//!
//! Each part is a facet. A sphere that touches two parts is pushed by both, as in an inner corner, but what they have in common counts once: with the energy Φ of the contact
//! law at an overlap,
//!
//! U = Φ(δ_i) + Φ(δ_j) − Φ(δ_ij),
//!
//! δ_ij the overlap with what is in both parts, which is convex. Where the foot on part i, its point nearest to the middle of the sphere, lies in part j, δ_ij is δ_i, so that part
//! j alone acts: on a flush joint there is one contact, as on one body, without a jump. In a deep inner corner δ_ij is negative, and both act whole. Between, where parts meet in a
//! shallow inner edge, the nearer of them acts whole and the further one beside a *border* ([`Meet::borders`]), as facets of a sheet do.

use super::outline;
use super::part::Part;
use crate::math::vector::{cross, dot, less, plus, scaled};
use crate::shape::core::{Core, CoreMeet, Seen};
use crate::shape::sheet::shared_over;
use crate::shape::{Meet, Nearest};
use serde::{Deserialize, Serialize};

/// Over the reach of a compound: what is nearer than that is at one place.
pub(super) const HAIR: f64 = 1e-9;
/// Share of that hair within which a core counts as equally near to two parts.
const SAME: f64 = 1e-3;
/// Most times that the nearest place of what two parts have in common is looked for.
const ROUNDS: u32 = 12;

/// Convex parts that hang together, their corners and their edges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Union {
    /// The parts.
    pub parts: Vec<Part>,
    /// Corners that stick out, m.
    pub corners: Vec<[f64; 3]>,
    /// Radius at each corner, m.
    radii: Vec<f64>,
    /// Whether each is the middle of a disc.
    discs: Vec<bool>,
    /// Ends of the edges that stick out, m.
    edges: Vec<[[f64; 3]; 2]>,
    /// Radius of each edge, m.
    round: Vec<f64>,
    /// Distance of the furthest point from the origin, m.
    pub reach: f64,
    /// Distance below which places are one, m.
    hair: f64,
}

impl Union {
    /// The union of these parts.
    pub(super) fn of(parts: Vec<Part>) -> Union {
        let far = |part: &Part| part.corners().iter().map(|p| dot(*p, *p).sqrt()).fold(0.0, f64::max) + part.rounding();
        let reach = parts.iter().map(far).fold(0.0, f64::max);
        let hair = HAIR * reach;
        let corners = outline::corners(&parts, hair);
        let edges = outline::edges(&parts, &corners, hair);
        Union {
            parts,
            radii: corners.iter().map(|c| c.radius).collect(),
            discs: corners.iter().map(|c| c.disc).collect(),
            corners: corners.into_iter().map(|c| c.at).collect(),
            round: edges.iter().map(|e| e.radius).collect(),
            edges: edges.into_iter().map(|e| e.ends).collect(),
            reach,
            hair,
        }
    }

    /// Least and largest radius of its edges, m.
    pub fn roundings(&self) -> [f64; 2] {
        let of = self.parts.iter().map(Part::rounding);
        of.fold([f64::INFINITY, 0.0], |[least, most], r| [r.min(least), r.max(most)])
    }

    /// Radius at corner `k`, m.
    pub fn corner_radius(&self, k: usize) -> f64 {
        self.radii.get(k).copied().unwrap_or(0.0)
    }

    /// Whether corner `k` is the middle of a disc.
    pub fn is_disc(&self, k: usize) -> bool {
        self.discs.get(k).copied().unwrap_or(false)
    }

    /// Whether facet `facet` is a disc.
    pub fn facet_is_disc(&self, facet: u32) -> bool {
        self.parts.get(facet as usize).is_some_and(Part::is_disc)
    }

    /// Ends of its edges, m, straight ones in one piece.
    pub fn edges(&self) -> Vec<[[f64; 3]; 2]> {
        self.edges.clone()
    }

    /// Radius of edge `k`, m.
    pub fn edge_radius(&self, k: usize) -> f64 {
        self.round.get(k).copied().unwrap_or(0.0)
    }

    /// Surface nearest to a position; inside, of the part in which it is deepest.
    pub fn nearest(&self, at: [f64; 3]) -> Nearest {
        let mut best = Nearest { distance: f64::INFINITY, normal: [0.0, 0.0, 1.0] };
        for part in &self.parts {
            if part.clearance(at) < best.distance {
                let found = part.nearest(at);
                if found.distance < best.distance {
                    best = found;
                }
            }
        }
        best
    }

    /// Adds the numbers of the parts that are nearer to a position than `within`, m, to `found`, in their order.
    pub fn facets_near(&self, at: [f64; 3], within: f64, found: &mut Vec<u32>) {
        let near = |part: &Part| part.clearance(at) < within && part.nearest(at).distance < within;
        found.extend((0_u32..).zip(&self.parts).filter(|(_, part)| near(part)).map(|(k, _)| k));
    }

    /// Where a sphere at a position meets part `facet`, however far; `None` where that part's nearest point lies in another part. Parts that are nearer, and nearer than `within`, m, have
    /// borders with it.
    pub fn meet(&self, facet: u32, at: [f64; 3], within: f64) -> Option<Meet> {
        let part = self.parts.get(facet as usize)?;
        self.met(facet, part, part.nearest(at), at, within)
    }

    /// As [`Self::meet`]; `None` also where the part is further than `within`, m.
    pub fn meet_near(&self, facet: u32, at: [f64; 3], within: f64) -> Option<Meet> {
        let part = self.parts.get(facet as usize).filter(|part| part.clearance(at) < within)?;
        let own = part.nearest(at);
        if own.distance < within { self.met(facet, part, own, at, within) } else { None }
    }

    fn met(&self, facet: u32, part: &Part, own: Nearest, at: [f64; 3], within: f64) -> Option<Meet> {
        let foot = foot(at, &own);
        let mut borders = Vec::new();
        for (k, other) in (0_u32..).zip(&self.parts).filter(|(k, _)| *k != facet) {
            // where the foot lies in another part that is not further
            if other.clearance(at) > own.distance + self.hair {
                continue;
            }
            let theirs = other.nearest(at);
            if theirs.distance > own.distance + 2.0 * self.hair {
                continue;
            }
            if other.holds(foot, 0.0, self.hair) {
                // of feet that are in each other's part the first counts
                if k < facet || !part.holds(self::foot(at, &theirs), 0.0, self.hair) {
                    return None;
                }
            } else if own.distance < within && (theirs.distance, k) < (own.distance, facet) {
                let planes = [plane(&own, at), plane(&theirs, at)];
                let crease = crease([part, other], planes, self.hair, |planes| behind(planes, at));
                let seen = crease.and_then(|place| seen(place, at));
                borders.extend(seen.filter(|edge| edge.distance < within).map(|edge| (k, edge)));
            }
        }
        let borders = shared_over(borders, |border: &Nearest| border.distance);
        Some(Meet { nearest: own, borders })
    }

    /// The place of the core of a superquadric that is nearest to part `facet`, if that is nearer than `within`, m.
    pub fn near_core(&self, facet: u32, core: &Core<'_>, within: f64) -> Option<Seen> {
        self.parts.get(facet as usize)?.near_core(core, within)
    }

    /// Where the core of a superquadric meets part `facet`, if it is nearer than `within`, m; `None` also where that part's nearest point lies in another part that is nearer, or equally near with a lower number.
    pub fn meet_core(&self, facet: u32, core: &Core<'_>, within: f64) -> Option<CoreMeet> {
        let part = self.parts.get(facet as usize)?;
        let on = part.near_core(core, within)?;
        let (own, same) = (on.nearest, SAME * self.hair);
        let foot = foot(on.at, &own);
        let mut borders = Vec::new();
        for (k, other) in (0_u32..).zip(&self.parts).filter(|(k, _)| *k != facet) {
            let Some(theirs) = other.near_core(core, own.distance + same) else { continue };
            if theirs.nearest.distance >= own.distance - same && k > facet {
                continue;
            }
            if other.holds(foot, 0.0, self.hair) {
                return None;
            }
            let planes = [plane(&own, on.at), plane(&theirs.nearest, theirs.at)];
            let crease = crease([part, other], planes, self.hair, |planes| core_behind(planes, core));
            let seen = crease.and_then(|place| core.nearest_to_hull(&[place], (place, None), within));
            borders.extend(seen.filter(|edge| edge.distance > 0.0).map(|edge| {
                let nearest = Nearest { distance: edge.distance, normal: edge.normal.map(|x| -x) };
                (k, Seen { at: edge.on_first, nearest })
            }));
        }
        let borders = shared_over(borders, |border: &Seen| border.nearest.distance);
        Some(CoreMeet { on, borders })
    }

    /// Whether what touched part `from`, nearer than `within`, m, has passed on to part `to`: there the nearest point of `from` lies.
    pub fn passes(&self, from: u32, to: u32, at: [f64; 3], within: f64) -> bool {
        let (Some(part), Some(other)) = (self.parts.get(from as usize), self.parts.get(to as usize)) else { return false };
        let own = part.nearest(at);
        from != to && own.distance < within && other.holds(foot(at, &own), 0.0, self.hair)
    }
}

/// The point of a surface that is nearest to a position.
fn foot(at: [f64; 3], nearest: &Nearest) -> [f64; 3] {
    less(at, scaled(nearest.normal, nearest.distance))
}

/// The half-space behind a surface at its nearest point, as seen from a position: its normal and the distance of its plane from the origin.
type Plane = ([f64; 3], f64);

fn plane(nearest: &Nearest, from: [f64; 3]) -> Plane {
    (nearest.normal, dot(nearest.normal, foot(from, nearest)))
}

/// A place as seen from another one.
fn seen(place: [f64; 3], at: [f64; 3]) -> Option<Nearest> {
    let away = less(at, place);
    let distance = dot(away, away).sqrt();
    (distance > 0.0).then(|| Nearest { distance, normal: scaled(away, 1.0 / distance) })
}

/// The nearest place of what two parts have in common; `None` where it is not found. Each part is replaced by the half-space
/// behind its surface at its nearest point, `planes`, and `behind` says which place behind two of them is nearest. It is the place looked for where both are flat there; else half-spaces are taken anew from the
/// place found.
fn crease(
    [a, b]: [&Part; 2],
    mut planes: [Plane; 2],
    hair: f64,
    behind: impl Fn([Plane; 2]) -> Option<[f64; 3]>,
) -> Option<[f64; 3]> {
    for _ in 0..ROUNDS {
        let place = behind(planes)?;
        let found = [a, b].map(|part| part.nearest(place));
        if found.iter().all(|nearest| nearest.distance <= hair) {
            return Some(place);
        }
        for (of, nearest) in planes.iter_mut().zip(found) {
            if nearest.distance > hair {
                *of = plane(&nearest, place);
            }
        }
    }
    None
}

/// The place nearest to `at` behind two planes, each given by its normal and its distance from the origin; `None` where they are parallel.
fn behind([(m, p), (n, q)]: [Plane; 2], at: [f64; 3]) -> Option<[f64; 3]> {
    let (before, beyond, cosine) = (dot(m, at) - p, dot(n, at) - q, dot(m, n));
    if before <= 0.0 && beyond <= 0.0 {
        return Some(at);
    }
    if before > 0.0 && beyond - before * cosine <= 0.0 {
        return Some(less(at, scaled(m, before)));
    }
    if beyond > 0.0 && before - beyond * cosine <= 0.0 {
        return Some(less(at, scaled(n, beyond)));
    }
    let below = 1.0 - cosine * cosine;
    (below > 1e-14).then(|| {
        let [x, y] = [(before - cosine * beyond) / below, (beyond - cosine * before) / below];
        less(less(at, scaled(m, x)), scaled(n, y))
    })
}

/// The place behind two planes that is nearest to a core; `None` where the core reaches behind one of them, or they are parallel.
fn core_behind([(m, p), (n, q)]: [Plane; 2], core: &Core<'_>) -> Option<[f64; 3]> {
    for ((m, p), (n, q)) in [((m, p), (n, q)), ((n, q), (m, p))] {
        let lowest = core.furthest(m.map(|x| -x));
        let height = dot(m, lowest) - p;
        let place = less(lowest, scaled(m, height));
        if height > 0.0 && dot(n, place) - q <= 0.0 {
            return Some(place);
        }
    }
    // their common line
    let line = cross(m, n);
    let square = dot(line, line);
    if square <= 1e-14 {
        return None;
    }
    let onto = |at: [f64; 3]| {
        let ([x, y], cosine) = ([dot(m, at) - p, dot(n, at) - q], dot(m, n));
        let [x, y] = [(x - cosine * y) / square, (y - cosine * x) / square];
        less(less(at, scaled(m, x)), scaled(n, y))
    };
    let about = onto(core.centre);
    let half = scaled(line, 2.0 * core.reach / square.sqrt());
    let found = core.nearest_to_hull(&[less(about, half), plus(about, half)], (about, None), f64::INFINITY)?;
    (found.distance > 0.0).then(|| onto(plus(found.on_first, scaled(found.normal, found.distance))))
}
