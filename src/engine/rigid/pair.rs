//! Where two rigid bodies touch: corners of one on the surface of the other, and edges that cross.
//!
//! Both bodies are hulls of corners with a sphere swept over them, or polygons with a disc ([`crate::shape::Rounded`]), so to any side two of them overlap by R − d, with R the sum of the radii of
//! the spheres and d the distance of the hulls within. Each corner of one body is compared with the nearest point of the other's hull, and each edge with each edge
//! of the other, as Jiang et al. 2020 do with corners and edges in the plane (eqs 38 to 40). A face that lies on a face touches at the corners of the area that
//! they share, which carries moments; that area's corners are corners of the two faces or crossings of their edges.
//!
//! Beside the end of an edge its corner touches at nearly the same place as the edge does. There the energy of the two edges is U = Φ(δ) Π (1 − Φ(δ_i)/Φ(δ)), with the
//! energy Φ of the contact law at an overlap, the overlap δ of the edges and δ_i of each of their four ends with the other edge. So what corner and edge bear
//! together is that of the one place where the bodies are nearest; forces follow from U, have no jumps and conserve energy.

use super::contact::PosedBlock;
use crate::math::vector::{cross, dot, less, plus, scaled};
use crate::shape::{Rounded, Shape};
use serde::{Deserialize, Serialize};

/// A part of each of two bodies that may touch. Numbers are those of corners and edges of their hulls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Site {
    /// A corner of the first body and the surface of the second.
    CornerOfFirst(u16),
    /// The surface of the first body and a corner of the second.
    CornerOfSecond(u16),
    /// An edge of each.
    Edges([u16; 2]),
}

/// What other bodies touch of a body, in its frame.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    /// Corners, surface and radius of the edges.
    pub body: Rounded,
    /// Ends of the edges.
    pub edges: Vec<[[f64; 3]; 2]>,
}

impl Outline {
    /// The outline of a shape; `None` for one without corners.
    pub fn of(shape: &Shape) -> Option<Outline> {
        let body = shape.rounded()?;
        let edges = body.edges();
        Some(Outline { body, edges })
    }
}

/// How two bodies overlap at a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Overlap {
    /// Unit normal out of the first body.
    pub normal: [f64; 3],
    /// Depth, m; negative where there is a gap.
    pub depth: f64,
    /// Middle of the overlap, m.
    pub at: [f64; 3],
}

/// How two bodies meet at a site.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    /// Their overlap.
    pub overlap: Overlap,
    /// Of two edges: the overlaps of the ends of each with the other.
    pub ends: Option<[Overlap; 4]>,
}

/// Deepest overlap over the sum of the radii of the edges: the hulls within must not come so near that their order is lost.
pub(super) const DEEPEST: f64 = 0.9;
/// Squares of the sine of the angle between edges below which they count as parallel.
const PARALLEL: f64 = 1e-12;

/// The two bodies at `site`, with a gap of any size; `None` where edges are nearest beyond one of their ends, where a corner touches instead.
pub(super) fn meeting(first: &PosedBlock<'_>, second: &PosedBlock<'_>, site: Site) -> Option<Meeting> {
    let (a, b) = (first.outline?, second.outline?);
    match site {
        Site::CornerOfFirst(k) => {
            let (corner, radius) = (first.pose.place(*a.body.corners().get(k as usize)?), a.body.rounding());
            let nearest = b.body.nearest(second.pose.within(corner));
            let (normal, depth) = (second.pose.outwards(nearest.normal).map(|x| -x), radius - nearest.distance);
            let overlap = Overlap { normal, depth, at: plus(corner, scaled(normal, radius - 0.5 * depth)) };
            Some(Meeting { overlap, ends: None })
        }
        Site::CornerOfSecond(k) => {
            let (corner, radius) = (second.pose.place(*b.body.corners().get(k as usize)?), b.body.rounding());
            let nearest = a.body.nearest(first.pose.within(corner));
            let (normal, depth) = (first.pose.outwards(nearest.normal), radius - nearest.distance);
            let overlap = Overlap { normal, depth, at: less(corner, scaled(normal, radius - 0.5 * depth)) };
            Some(Meeting { overlap, ends: None })
        }
        Site::Edges([i, j]) => {
            let p = a.edges.get(i as usize)?.map(|x| first.pose.place(x));
            let q = b.edges.get(j as usize)?.map(|x| second.pose.place(x));
            let [on_first, on_second] = crossing(p, q)?;
            // for edges that cut each other: across both
            let across = cross(less(p[1], p[0]), less(q[1], q[0]));
            let side = 1.0_f64.copysign(dot(across, less(second.pose.centre, first.pose.centre)));
            let across = scaled(across, side / dot(across, across).sqrt());
            let radii = [a.body.rounding(), b.body.rounding()];
            let between = |x, y| spheres([x, y], radii, across);
            let ends = [
                between(p[0], nearest_on(q, p[0])),
                between(p[1], nearest_on(q, p[1])),
                between(nearest_on(p, q[0]), q[0]),
                between(nearest_on(p, q[1]), q[1]),
            ];
            Some(Meeting { overlap: between(on_first, on_second), ends: Some(ends) })
        }
    }
}

/// The overlap of two spheres at these centres, m; `across`: the normal if they are at one place.
fn spheres([x, y]: [[f64; 3]; 2], [r, s]: [f64; 2], across: [f64; 3]) -> Overlap {
    let apart = less(y, x);
    let distance = dot(apart, apart).sqrt();
    let (normal, depth) = (if distance > 0.0 { scaled(apart, 1.0 / distance) } else { across }, r + s - distance);
    Overlap { normal, depth, at: plus(x, scaled(normal, r - 0.5 * depth)) }
}

/// The points in which two edges, given by their ends, are nearest; `None` if one of these is an end, or if the edges are parallel.
fn crossing(p: [[f64; 3]; 2], q: [[f64; 3]; 2]) -> Option<[[f64; 3]; 2]> {
    let (u, v, r) = (less(p[1], p[0]), less(q[1], q[0]), less(p[0], q[0]));
    let (uu, uv, vv, ur, vr) = (dot(u, u), dot(u, v), dot(v, v), dot(u, r), dot(v, r));
    let below = uu * vv - uv * uv;
    if below <= PARALLEL * uu * vv {
        return None;
    }
    let (s, t) = ((uv * vr - vv * ur) / below, (uu * vr - uv * ur) / below);
    let inside = |x: f64| x > 0.0 && x < 1.0;
    (inside(s) && inside(t)).then(|| [plus(p[0], scaled(u, s)), plus(q[0], scaled(v, t))])
}

/// The point of an edge that is nearest to a position.
fn nearest_on([p, q]: [[f64; 3]; 2], at: [f64; 3]) -> [f64; 3] {
    let along = less(q, p);
    let s = (dot(along, less(at, p)) / dot(along, along)).clamp(0.0, 1.0);
    plus(p, scaled(along, s))
}

/// Distance of a position from an edge.
fn from_edge(at: [f64; 3], edge: [[f64; 3]; 2]) -> f64 {
    let away = less(at, nearest_on(edge, at));
    dot(away, away).sqrt()
}

/// The sites at which two bodies are nearer than `skin`, m, or may come so while they move by less than that.
pub(super) fn sites(first: &PosedBlock<'_>, second: &PosedBlock<'_>, skin: f64) -> Vec<Site> {
    let (Some(a), Some(b)) = (first.outline, second.outline) else { return Vec::new() };
    let near = |x: [f64; 3], body: &PosedBlock<'_>, far: f64| {
        let away = less(x, body.pose.centre);
        dot(away, away) < far * far
    };
    let mut found = Vec::new();
    let corners = |body: &PosedBlock<'_>, of: &Outline, other: &PosedBlock<'_>, on: &Outline, site: &dyn Fn(u16) -> Site| {
        let (far, gap) = (of.body.rounding() + on.body.reach() + skin, of.body.rounding() + skin);
        let near = |(_, corner): &(usize, [f64; 3])| {
            near(*corner, other, far) && on.body.nearest(other.pose.within(*corner)).distance < gap
        };
        let corners = of.body.corners().iter().map(|c| body.pose.place(*c)).enumerate();
        corners.filter(near).map(|(k, _)| site(k as u16)).collect::<Vec<_>>()
    };
    // a disc has one corner, its centre, whose distance from the other surface is all there is to know
    let [one, other] = [a, b].map(|outline| outline.body.corners().len() == 1);
    if one || !other {
        found.extend(corners(first, a, second, b, &Site::CornerOfFirst));
    }
    if !one {
        found.extend(corners(second, b, first, a, &Site::CornerOfSecond));
    }
    let radii = a.body.rounding() + b.body.rounding() + skin;
    let edges = |body: &PosedBlock<'_>, of: &Outline, other: &PosedBlock<'_>, on: &Outline| {
        let far = of.body.rounding() + on.body.reach() + skin;
        let placed = of.edges.iter().map(|ends| ends.map(|x| body.pose.place(x))).enumerate();
        placed.filter(|(_, ends)| from_edge(other.pose.centre, *ends) < far).collect::<Vec<_>>()
    };
    let of_second = edges(second, b, first, a);
    for (i, p) in edges(first, a, second, b) {
        for (j, q) in &of_second {
            if between(p, *q) < radii {
                found.push(Site::Edges([i as u16, *j as u16]));
            }
        }
    }
    found
}

/// Distance of two edges.
fn between(p: [[f64; 3]; 2], q: [[f64; 3]; 2]) -> f64 {
    if let Some([x, y]) = crossing(p, q) {
        let apart = less(x, y);
        return dot(apart, apart).sqrt();
    }
    [from_edge(p[0], q), from_edge(p[1], q), from_edge(q[0], p), from_edge(q[1], p)].into_iter().fold(f64::INFINITY, f64::min)
}
