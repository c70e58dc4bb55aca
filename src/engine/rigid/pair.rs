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
//!
//! A sheet of triangles ([`crate::shape::Sheet`]) is no hull: corners of the other body lie on its facets, and its own corners and edges act only where it sticks out,
//! not on the side to which it bends. Corners lie on the parts of a compound ([`crate::shape::Compound`]) as on facets; its own are those that stick out of all its parts. Where its
//! edges end in an inner corner of a flat side no corner takes over: what passes there leaves both edges without a jump.
//!
//! A superquadric has no corners: it touches a convex body where the two are nearest, and facets and parts where it is nearest to each (`facets.rs`).

use super::contact::PosedBlock;
use super::motion::Yields;
use super::{Block, facets};
use crate::math::vector::{cross, dot, less, plus, scaled};
use crate::shape::{Apart, Meet, Nearest, PlacedSmooth, Rounded, Tangent, apart, tangent};
use serde::{Deserialize, Serialize};

/// A part of each of two bodies that may touch. Numbers are those of corners and edges of their hulls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Site {
    /// A corner of the first body and the surface of the second.
    CornerOfFirst(u32),
    /// The surface of the first body and a corner of the second.
    CornerOfSecond(u32),
    /// An edge of each.
    Edges([u32; 2]),
    /// The nearest points of the two, of which one is a superquadric; of a sheet or a compound, those with a facet.
    Nearest,
}

/// What other bodies touch of a body, in its frame.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    /// Corners, surface and radius of the edges.
    pub body: Rounded,
    /// Ends of the edges.
    pub edges: Vec<[[f64; 3]; 2]>,
    /// How the body yields to forces.
    pub yields: Yields,
}

impl Outline {
    /// The outline of a body.
    pub fn of(block: &Block) -> Outline {
        let body = block.shape.rounded();
        let edges = body.edges();
        Outline { body, edges, yields: block.yields() }
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

impl Overlap {
    /// No overlap anywhere.
    pub const NONE: Overlap = Overlap { normal: [0.0; 3], depth: f64::NEG_INFINITY, at: [0.0; 3] };
}

/// How two bodies meet at a site.
#[derive(Clone, Debug)]
pub(super) struct Meeting {
    /// Their overlap.
    pub overlap: Overlap,
    /// Of two edges that overlap: the overlaps of the ends of each with the other.
    pub ends: Option<[Overlap; 4]>,
    /// Of a corner or a superquadric on a sheet or a compound: the borders beside which it counts less, with the number of the facet beyond each.
    pub borders: Vec<(u32, Overlap)>,
}

/// Deepest overlap over the sum of the radii of the edges: the hulls within must not come so near that their order is lost.
pub(super) const DEEPEST: f64 = 0.9;
/// Squares of the sine of the angle between edges below which they count as parallel.
const PARALLEL: f64 = 1e-12;

/// The two bodies at `site`; `None` where a gap is larger than `gap`, m (not all of those are left out), edges are nearest beyond one of their ends, where a corner touches instead, and where a sheet does not
/// act. `facet`: that of a sheet, or the part of a compound, on which a corner or a superquadric lies; `was`: the normal of a moment ago, if they touched there.
pub(super) fn meeting(
    first: &PosedBlock<'_>,
    second: &PosedBlock<'_>,
    (site, facet): (Site, u32),
    was: Option<[f64; 3]>,
    gap: f64,
) -> Option<Meeting> {
    let (a, b) = (first.outline?, second.outline?);
    match site {
        Site::Nearest if facets::are(first, second) => facets::meeting(first, second, facet, gap),
        Site::Nearest if a.body.is_smooth() || b.body.is_smooth() => {
            let overlap = nearest(first, second, [a, b], was, gap)?;
            Some(Meeting { overlap, ends: None, borders: Vec::new() })
        }
        Site::Nearest => None,
        Site::CornerOfFirst(k) => corner_on((k, facet), [a, b], [first, second], gap, true),
        Site::CornerOfSecond(k) => corner_on((k, facet), [b, a], [second, first], gap, false),
        Site::Edges([i, j]) => {
            let p = a.edges.get(i as usize)?.map(|x| first.pose.place(x));
            let q = b.edges.get(j as usize)?.map(|x| second.pose.place(x));
            let [on_first, on_second] = crossing(p, q)?;
            // for edges that cut each other: across both
            let across = cross(less(p[1], p[0]), less(q[1], q[0]));
            let side = 1.0_f64.copysign(dot(across, less(second.pose.centre, first.pose.centre)));
            let across = scaled(across, side / dot(across, across).sqrt());
            let radii = [a.body.edge_radius(i as usize), b.body.edge_radius(j as usize)];
            let between = |x, y| spheres([x, y], radii, across);
            let overlap = between(on_first, on_second);
            let towards = [first.pose.inwards(overlap.normal), second.pose.inwards(overlap.normal.map(|x| -x))];
            let acts = a.body.edge_acts(i as usize, towards[0]) && b.body.edge_acts(j as usize, towards[1]);
            // of edges that are apart nobody asks
            let ends = || {
                [
                    between(p[0], nearest_on(q, p[0])),
                    between(p[1], nearest_on(q, p[1])),
                    between(nearest_on(p, q[0]), q[0]),
                    between(nearest_on(p, q[1]), q[1]),
                ]
            };
            acts.then(|| Meeting { overlap, ends: (overlap.depth > 0.0).then(ends), borders: Vec::new() })
        }
    }
}

/// Corner `k` of a body on facet `facet` of another one, as [`meeting`]. `is_first`: whether the corner is of the first body. Inlined for each of the two: a step of many polyhedra is 3 % shorter so.
#[inline(always)]
fn corner_on(
    (k, facet): (u32, u32),
    [of, other]: [&Outline; 2],
    [body, on]: [&PosedBlock<'_>; 2],
    gap: f64,
    is_first: bool,
) -> Option<Meeting> {
    let (corner, radius) = (body.pose.place(*of.body.corners().get(k as usize)?), of.body.corner_radius(k as usize));
    let Meet { nearest, borders } = other.body.meet(facet, on.pose.within(corner), radius + gap)?;
    let overlap = |nearest: &Nearest| sphere_on(on, nearest, (corner, radius), is_first);
    let borders = borders.iter().map(|(other, border)| (*other, overlap(border))).collect();
    let overlap = overlap(&nearest);
    let towards = if is_first { overlap.normal } else { overlap.normal.map(|x| -x) };
    let acts = of.body.corner_acts(k as usize, body.pose.inwards(towards));
    acts.then_some(Meeting { overlap, ends: None, borders })
}

/// The overlap of a sphere, its centre and radius in m, with the surface of a body as seen from that centre. `is_first`: whether the sphere is of the first body.
pub(super) fn sphere_on(on: &PosedBlock<'_>, nearest: &Nearest, (centre, radius): ([f64; 3], f64), is_first: bool) -> Overlap {
    let (out, depth) = (on.pose.outwards(nearest.normal), radius - nearest.distance);
    let normal = if is_first { out.map(|x| -x) } else { out };
    Overlap { normal, depth, at: less(centre, scaled(out, radius - 0.5 * depth)) }
}

/// A bound below on the gap at a site of two bodies of which none is a sheet, a compound or a superquadric, m; `None` of others.
pub(super) fn gap(first: &PosedBlock<'_>, second: &PosedBlock<'_>, site: Site) -> Option<f64> {
    let (a, b) = (first.outline?, second.outline?);
    let corner = |k: u32, [of, on]: [&Outline; 2], [body, other]: [&PosedBlock<'_>; 2]| {
        let at = other.pose.within(body.pose.place(*of.body.corners().get(k as usize)?));
        Some(on.body.before(at)? - of.body.corner_radius(k as usize))
    };
    match site {
        Site::CornerOfFirst(k) => corner(k, [a, b], [first, second]),
        Site::CornerOfSecond(k) => corner(k, [b, a], [second, first]),
        Site::Edges([i, j]) => {
            let p = a.edges.get(i as usize)?.map(|x| first.pose.place(x));
            let q = b.edges.get(j as usize)?.map(|x| second.pose.place(x));
            Some(between(p, q) - a.body.edge_radius(i as usize) - b.body.edge_radius(j as usize))
        }
        Site::Nearest => None,
    }
}

/// Share of the square of the distance of two cores within which Newton's method is given a start.
const ROUGH: f64 = 1e-2;

/// The overlap of two convex bodies, one of them a superquadric, where they are nearest, if it is no gap of more than `gap`, m. `was`: the normal of a moment ago, if they touched. Cores that cut each other overlap by
/// both radii, along the line between the centres.
fn nearest(
    first: &PosedBlock<'_>,
    second: &PosedBlock<'_>,
    [a, b]: [&Outline; 2],
    was: Option<[f64; 3]>,
    gap: f64,
) -> Option<Overlap> {
    let [r, s] = [a.body.rounding(), b.body.rounding()];
    let away = less(second.pose.centre, first.pose.centre);
    let both = match (&a.body, &b.body) {
        (Rounded::Smooth(p), Rounded::Smooth(q)) => Some((
            PlacedSmooth { smooth: p, centre: [0.0; 3], axes: first.pose.axes },
            PlacedSmooth { smooth: q, centre: away, axes: second.pose.axes },
        )),
        _ => None,
    };
    let by_newton = |start: [f64; 3]| {
        let (p, q) = both?;
        let Tangent { normal, depth, at } = tangent(p, q, start)?;
        Some(Overlap { normal, depth, at: plus(first.pose.centre, at) })
    };
    if let Some(found) = was.and_then(by_newton) {
        return Some(found);
    }
    let length = dot(away, away).sqrt();
    let start = was.unwrap_or_else(|| if length > 0.0 { scaled(away, 1.0 / length) } else { [1.0, 0.0, 0.0] });
    let cores = |rough: f64| cores_apart([first, second], [a, b], start, [r + s + gap, rough]);
    if both.is_some() {
        let about = cores(ROUGH)?;
        if let Some(found) = by_newton(about.normal) {
            return Some(found);
        }
    }
    let found = cores(0.0)?;
    let depth = r + s - found.distance;
    let on_first = plus(first.pose.centre, found.on_first);
    Some(Overlap { normal: found.normal, depth, at: plus(on_first, scaled(found.normal, r - 0.5 * depth)) })
}

/// The nearest points of the cores of two convex bodies ([`Rounded::core`]), from the centre of the first; see [`apart`].
fn cores_apart([first, second]: [&PosedBlock<'_>; 2], [a, b]: [&Outline; 2], start: [f64; 3], limits: [f64; 2]) -> Option<Apart> {
    let away = less(second.pose.centre, first.pose.centre);
    let core = |of: &Outline, body: &PosedBlock<'_>, towards: [f64; 3]| {
        body.pose.outwards(of.body.core(body.pose.inwards(towards)).unwrap_or_default())
    };
    apart(|n| core(a, first, n), |n| plus(away, core(b, second, n)), start, limits)
}

/// A bound below on the gap between two bodies, m: the better of that of the spheres around them and, of two convex bodies in space, that of their nearest points. A gap of more than `far`, m, need not be known
/// better than so.
pub(super) fn clearance(first: &PosedBlock<'_>, second: &PosedBlock<'_>, far: f64) -> f64 {
    let (Some(a), Some(b)) = (first.outline, second.outline) else { return 0.0 };
    let between = less(second.pose.centre, first.pose.centre);
    let length = dot(between, between).sqrt();
    let of_spheres = length - a.body.reach() - b.body.reach();
    if of_spheres >= far || length == 0.0 || !a.body.is_convex() || !b.body.is_convex() {
        return of_spheres;
    }
    let radii = a.body.widest() + b.body.widest();
    match cores_apart([first, second], [a, b], scaled(between, 1.0 / length), [radii + far, ABOUT]) {
        Some(found) => of_spheres.max((1.0 - ABOUT) * found.distance - radii),
        None => far,
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

/// The middle of the corner that lies on a surface of facets at `site`, in the frame of its body, and its radius, m, with that body; of a superquadric the place that is nearest to facet `facet`. `None` at other sites.
pub(super) fn corner_on_facets<'a>(
    first: &'a PosedBlock<'a>,
    second: &'a PosedBlock<'a>,
    (site, facet): (Site, u32),
) -> Option<(&'a PosedBlock<'a>, [f64; 3], f64)> {
    let (k, of, on) = match site {
        Site::CornerOfFirst(k) => (k, first, second),
        Site::CornerOfSecond(k) => (k, second, first),
        Site::Nearest => return facets::place_on(first, second, facet),
        Site::Edges(_) => return None,
    };
    let body = &of.outline?.body;
    let corner = *body.corners().get(k as usize)?;
    (on.block.solid().facets() > 1).then(|| (on, on.pose.within(of.pose.place(corner)), body.corner_radius(k as usize)))
}

/// What of a body can be near another one: what lies beyond a plane between them.
struct Facing {
    /// Unit vector across the plane, towards the other body, in the frame of this one.
    along: [f64; 3],
    /// Place of the plane along it, m.
    plane: f64,
}

/// Share of the square of the distance of two hulls to which the direction between them is sought.
const ABOUT: f64 = 0.1;

impl Facing {
    /// Of each of two bodies whose hulls within count as near up to the distance `radii`, m; `None` where they are further from each other. A sheet lies all around. Any direction will do; the nearer to
    /// that in which the bodies are nearest, the less can be near.
    fn of(first: &PosedBlock<'_>, second: &PosedBlock<'_>, [a, b]: [&Outline; 2], radii: f64) -> Option<[Facing; 2]> {
        let between = less(second.pose.centre, first.pose.centre);
        let length = dot(between, between).sqrt();
        if length == 0.0 || a.body.sheet().is_some() || b.body.sheet().is_some() {
            return Some([(); 2].map(|()| Facing { along: [0.0; 3], plane: f64::NEG_INFINITY }));
        }
        // a hair for rounding
        let radii = radii + 1e-9 * length;
        let mut along = scaled(between, 1.0 / length);
        if a.body.is_convex() && b.body.is_convex() {
            along = cores_apart([first, second], [a, b], along, [radii, ABOUT])?.normal;
        }
        let [of_first, of_second] = [first.pose.inwards(along), second.pose.inwards(along.map(|x| -x))];
        let end = |of: &Outline, along: [f64; 3]| {
            of.body.corners().iter().map(|corner| dot(along, *corner)).fold(f64::NEG_INFINITY, f64::max)
        };
        let room = dot(between, along) - radii;
        let [first_end, second_end] = [end(a, of_first), end(b, of_second)];
        (first_end + second_end >= room)
            .then_some([Facing { along: of_first, plane: room - second_end }, Facing { along: of_second, plane: room - first_end }])
    }

    /// Whether any of these places in the frame of the body can be near the other.
    fn takes(&self, places: &[[f64; 3]]) -> bool {
        places.iter().any(|p| dot(self.along, *p) >= self.plane)
    }
}

/// The sphere around an edge.
struct Ball {
    middle: [f64; 3],
    radius: f64,
}

impl Ball {
    fn around([p, q]: [[f64; 3]; 2]) -> Ball {
        let along = less(q, p);
        // a hair for rounding
        Ball { middle: scaled(plus(p, q), 0.5), radius: 0.5 * dot(along, along).sqrt() * (1.0 + 1e-9) }
    }

    /// Whether it is nearer to another one than `gap`, m.
    fn is_near(&self, other: &Ball, gap: f64) -> bool {
        let (away, far) = (less(other.middle, self.middle), self.radius + other.radius + gap);
        dot(away, away) < far * far
    }
}

/// The sites at which two bodies are nearer than `skin`, m, or may come so while they move by less than that, each with the facet of the surface there.
pub(super) fn sites(first: &PosedBlock<'_>, second: &PosedBlock<'_>, skin: f64) -> Vec<(Site, u32)> {
    let (Some(a), Some(b)) = (first.outline, second.outline) else { return Vec::new() };
    let near = |x: [f64; 3], body: &PosedBlock<'_>, far: f64| {
        let away = less(x, body.pose.centre);
        dot(away, away) < far * far
    };
    if facets::are(first, second) {
        return facets::near(first, second, skin).into_iter().map(|facet| (Site::Nearest, facet)).collect();
    }
    if a.body.is_smooth() || b.body.is_smooth() {
        let far = a.body.reach() + b.body.reach() + skin;
        let found = near(second.pose.centre, first, far).then(|| nearest(first, second, [a, b], None, skin)).flatten();
        return found.map(|_| (Site::Nearest, 0)).into_iter().collect();
    }
    let mut found = Vec::new();
    // of a sheet only what is near the other body
    let sharp = |body: &PosedBlock<'_>, of: &Outline, other: &PosedBlock<'_>, on: &Outline| -> [Vec<u32>; 2] {
        match of.body.sheet() {
            Some(sheet) => sheet.sharp_near(body.pose.within(other.pose.centre), of.body.widest() + on.body.reach() + skin),
            None => [of.body.corners().len(), of.edges.len()].map(|n| (0..n as u32).collect()),
        }
    };
    let radii = a.body.widest() + b.body.widest() + skin;
    let Some(facing) = Facing::of(first, second, [a, b], radii) else { return Vec::new() };
    let [of_first, of_second] = [sharp(first, a, second, b), sharp(second, b, first, a)];
    let corners =
        |list: &[u32], body: &PosedBlock<'_>, of: &Outline, other: &PosedBlock<'_>, on: &Outline, site: &dyn Fn(u32) -> Site| {
            let at = |k: u32| {
                let radius = of.body.corner_radius(k as usize);
                let (far, gap) = (radius + on.body.reach() + skin, radius + skin);
                let (corner, of_first) = (of.body.corners()[k as usize], std::ptr::eq(of, a));
                let place = || Some(body.pose.place(corner)).filter(|corner| near(*corner, other, far));
                let placed = facing[usize::from(!of_first)].takes(&[corner]).then(place).flatten();
                let facets = placed.map_or(Vec::new(), |corner| on.body.facets_near(other.pose.within(corner), gap));
                // the middle of a disc on the other surface is all there is to know of it, and of two discs the first is asked
                let disc = of_first && of.body.corner_is_disc(k as usize);
                let known = move |facet: &u32| disc || !on.body.facet_is_disc(*facet);
                facets.into_iter().filter(known).map(move |facet| (k, facet))
            };
            list.iter().flat_map(|k| at(*k)).map(|(k, facet)| (site(k), facet)).collect::<Vec<_>>()
        };
    found.extend(corners(&of_first[0], first, a, second, b, &Site::CornerOfFirst));
    found.extend(corners(&of_second[0], second, b, first, a, &Site::CornerOfSecond));
    let edges = |list: &[u32], body: &PosedBlock<'_>, of: &Outline, other: &PosedBlock<'_>, on: &Outline| {
        let far = of.body.widest() + on.body.reach() + skin;
        let facing = &facing[usize::from(!std::ptr::eq(of, a))];
        let placed = list.iter().map(|k| (*k, of.edges[*k as usize])).filter(|(_, ends)| facing.takes(ends));
        let placed = placed.map(|(k, ends)| (k, ends.map(|x| body.pose.place(x))));
        let close = placed.filter(|(_, ends)| from_edge(other.pose.centre, *ends) < far);
        close.map(|(k, ends)| (k, ends, Ball::around(ends))).collect::<Vec<_>>()
    };
    let second_edges = edges(&of_second[1], second, b, first, a);
    for (i, p, around) in edges(&of_first[1], first, a, second, b) {
        for (j, q, other) in &second_edges {
            if around.is_near(other, radii) && between(p, *q) < radii {
                found.push((Site::Edges([i, *j]), 0));
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
