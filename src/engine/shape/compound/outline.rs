//! Corners and edges of a union of convex parts: those of its parts that are not buried in other parts.
//!
//! The surface of a union bends inwards where its parts cross, so nothing sticks out there: its corners and edges are some of those of its parts. A corner counts where the
//! ball around it lies in no other part. Where it is also a corner of others, the first of these parts has it, but only if together they come to a point there, as the
//! two halves of a kite do; two boxes side by side have no corner in the middle of their common face. It is the same along edges. Pieces of edges that go on straight
//! over a joint are one edge.

use super::part::Part;
use crate::math::vector::{cross, dot, less, plus, scaled};

/// A corner of the union.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Its place, m.
    pub at: [f64; 3],
    /// Radius of the ball around it, m.
    pub radius: f64,
    /// Whether its part is a disc.
    pub disc: bool,
}

/// An edge of the union, straight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// Its ends, m.
    pub ends: [[f64; 3]; 2],
    /// Radius of the balls along it, m.
    pub radius: f64,
    /// Whether there is a corner at each end; at others it goes into a part.
    pub corners: [bool; 2],
}

/// Sines below which directions are parallel, and parts of a wedge nothing.
const PARALLEL: f64 = 1e-6;

fn distance(p: [f64; 3], q: [f64; 3]) -> f64 {
    let apart = less(p, q);
    dot(apart, apart).sqrt()
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    scaled(v, 1.0 / dot(v, v).sqrt())
}

/// Unit vectors from corner `k` of a part along its edges, or sides.
fn along(part: &Part, k: usize) -> Vec<[f64; 3]> {
    let corners = part.corners();
    let to = |other: usize| unit(less(corners[other], corners[k]));
    if part.is_flat() {
        let n = corners.len();
        let mut beside = vec![(k + 1) % n, (k + n - 1) % n];
        beside.dedup();
        return beside.into_iter().filter(|other| *other != k).map(to).collect();
    }
    let edges = part.edges().into_iter().map(|(ends, _)| ends.map(|end| end as usize));
    edges.filter_map(|[i, j]| if i == k { Some(j) } else { (j == k).then_some(i) }).map(to).collect()
}

/// Whether bodies that leave a place along these unit vectors come to a point there: some open set of directions points away from all of them.
fn pointed(leaving: &[[f64; 3]], flat: bool) -> bool {
    let mut rays = Vec::new();
    for (k, u) in leaving.iter().enumerate() {
        if flat {
            rays.extend([[u[1], -u[0], 0.0], [-u[1], u[0], 0.0]]);
        } else {
            let normals = leaving[..k].iter().map(|v| cross(*u, *v)).filter(|n| dot(*n, *n) > PARALLEL * PARALLEL).map(unit);
            rays.extend(normals.flat_map(|n| [n, n.map(|x| -x)]));
        }
    }
    // the borders of that set, and its middle
    let borders = rays.into_iter().filter(|n| leaving.iter().all(|u| dot(*n, *u) <= PARALLEL));
    let middle = borders.fold([0.0; 3], plus);
    leaving.iter().all(|u| dot(middle, *u) < -PARALLEL)
}

/// The corners of a union of these parts; what is nearer than a hair, m, is at one place.
pub(super) fn corners(parts: &[Part], hair: f64) -> Vec<Corner> {
    let mut found = Vec::new();
    for (i, part) in parts.iter().enumerate() {
        for (k, at) in part.corners().iter().enumerate() {
            let radius = part.rounding();
            let within: Vec<usize> = (0..parts.len()).filter(|j| *j == i || parts[*j].holds(*at, radius, hair)).collect();
            let shared = || {
                let corner = |j: &usize| {
                    let same = (parts[*j].rounding() - radius).abs() <= hair;
                    let at = parts[*j].corners().iter().position(|other| distance(*other, *at) <= 2.0 * hair);
                    at.filter(|_| same).map(|k| along(&parts[*j], k))
                };
                let leaving: Option<Vec<Vec<[f64; 3]>>> = within.iter().map(corner).collect();
                within[0] == i && leaving.is_some_and(|all| pointed(&all.concat(), part.is_flat()))
            };
            if within.len() == 1 || shared() {
                found.push(Corner { at: part.corners()[k], radius, disc: part.is_disc() });
            }
        }
    }
    found
}

/// Edge of a part as a segment.
struct Segment {
    ends: [[f64; 3]; 2],
    /// Normals of the faces beside it.
    wedge: [[f64; 3]; 2],
}

fn segments(part: &Part) -> Vec<Segment> {
    let place = |ends: [u32; 2]| ends.map(|k| part.corners()[k as usize]);
    part.edges().into_iter().map(|(ends, wedge)| Segment { ends: place(ends), wedge }).collect()
}

/// Between which shares of its way the balls of this radius, m, along a segment lie in a part.
fn buried([p, q]: [[f64; 3]; 2], radius: f64, part: &Part, hair: f64) -> Option<[f64; 2]> {
    let super::part::Convex::Hull(hull) = &part.surface else { return None };
    let room = hull.rounding - radius + hair;
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for face in &hull.faces {
        let [start, end] = [p, q].map(|x| dot(face.normal, x) - face.offset - room);
        let share = start / (start - end);
        match (start > 0.0, end > 0.0) {
            (true, true) => return None,
            (true, false) => from = from.max(share),
            (false, true) => to = to.min(share),
            (false, false) => {}
        }
    }
    (from < to).then_some([from, to])
}

/// The wedge of an edge of these that runs along a segment where its share of the way is `share`.
fn beside(segment: &Segment, share: f64, edges: &[Segment], hair: f64) -> Option<[[f64; 3]; 2]> {
    let [p, q] = segment.ends;
    let (at, way) = (plus(p, scaled(less(q, p), share)), unit(less(q, p)));
    let runs = |other: &&Segment| {
        let [a, b] = other.ends;
        let (theirs, length) = (unit(less(b, a)), distance(a, b));
        let (to, off) = (dot(theirs, less(at, a)), cross(theirs, less(at, a)));
        let turned = cross(theirs, way);
        dot(turned, turned) < PARALLEL * PARALLEL && dot(off, off) <= 4.0 * hair * hair && to > -hair && to < length + hair
    };
    edges.iter().find(runs).map(|other| other.wedge)
}

/// Whether directions are common to all these wedges, each given by its two borders, that are all across one line.
fn common(wedges: &[[[f64; 3]; 2]]) -> bool {
    let holds = |[m, n]: [[f64; 3]; 2], ray: [f64; 3]| {
        // a sum of the borders with shares that are not negative
        let (c, a, b) = (dot(m, n), dot(m, ray), dot(n, ray));
        a - c * b >= -PARALLEL && b - c * a >= -PARALLEL && a + b > 0.0
    };
    let inside: Vec<[f64; 3]> = wedges.iter().flatten().copied().filter(|ray| wedges.iter().all(|w| holds(*w, *ray))).collect();
    inside.iter().any(|ray| distance(*ray, inside[0]) > PARALLEL)
}

/// The edges of a union of these parts, whose corners are known.
pub(super) fn edges(parts: &[Part], corners: &[Corner], hair: f64) -> Vec<Edge> {
    let all: Vec<Vec<Segment>> = parts.iter().map(segments).collect();
    let acts = |at: [f64; 3]| corners.iter().any(|corner| distance(corner.at, at) <= 4.0 * hair);
    let mut found = Vec::new();
    for (i, part) in parts.iter().enumerate() {
        let radius = part.rounding();
        for segment in &all[i] {
            let [p, q] = segment.ends;
            let place = |share: f64| plus(p, scaled(less(q, p), share));
            let others = (0..parts.len()).filter(|j| *j != i);
            let under: Vec<(usize, [f64; 2])> =
                others.filter_map(|j| Some((j, buried(segment.ends, radius, &parts[j], hair)?))).collect();
            let mut cuts: Vec<f64> = under.iter().flat_map(|(_, [from, to])| [*from, *to]).chain([0.0, 1.0]).collect();
            cuts.sort_by(f64::total_cmp);
            let length = distance(p, q);
            let open = |share: f64| {
                let within: Vec<usize> = under.iter().filter(|(_, [a, b])| *a < share && share < *b).map(|(j, _)| *j).collect();
                let wedge = |j: &usize| {
                    let same = (parts[*j].rounding() - radius).abs() <= hair;
                    beside(segment, share, &all[*j], hair).filter(|_| same)
                };
                let wedges: Option<Vec<[[f64; 3]; 2]>> = within.iter().map(wedge).collect();
                within.is_empty()
                    || within.iter().all(|j| *j > i)
                        && wedges.is_some_and(|mut wedges| {
                            wedges.push(segment.wedge);
                            common(&wedges)
                        })
            };
            let mut pieces: Vec<[f64; 2]> = Vec::new();
            for w in cuts.windows(2) {
                if (w[1] - w[0]) * length <= 10.0 * hair || !open(0.5 * (w[0] + w[1])) {
                    continue;
                }
                match pieces.last_mut() {
                    Some(last) if (w[0] - last[1]) * length <= 10.0 * hair => last[1] = w[1],
                    _ => pieces.push([w[0], w[1]]),
                }
            }
            // ends to the bit
            let end = |share: f64| {
                if share == 0.0 {
                    p
                } else if share == 1.0 {
                    q
                } else {
                    place(share)
                }
            };
            found.extend(pieces.into_iter().map(|ends| Edge { ends: ends.map(end), radius, corners: [false; 2] }));
        }
    }
    for edge in &mut found {
        edge.corners = edge.ends.map(acts);
    }
    joined(found, hair)
}

/// The edges, with those in one piece that go on straight where one ends and there is no corner.
fn joined(edges: Vec<Edge>, hair: f64) -> Vec<Edge> {
    let (mut whole, mut open): (Vec<Edge>, Vec<Edge>) = edges.into_iter().partition(|edge| edge.corners == [true; 2]);
    while !open.is_empty() {
        let mut edge = open.remove(0);
        while let Some((k, longer)) = open.iter().enumerate().find_map(|(k, other)| Some((k, join(&edge, other, hair)?))) {
            open.remove(k);
            edge = longer;
        }
        whole.push(edge);
    }
    whole
}

/// Two edges as one, where one goes on straight from an end of the other at which there is no corner.
fn join(first: &Edge, second: &Edge, hair: f64) -> Option<Edge> {
    if (first.radius - second.radius).abs() > hair {
        return None;
    }
    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let open = !first.corners[i] && !second.corners[j];
        if !open || distance(first.ends[i], second.ends[j]) > 20.0 * hair {
            continue;
        }
        let [u, v] = [(first, 1 - i), (second, j)].map(|(edge, end)| unit(less(edge.ends[1 - end], edge.ends[end])));
        let turned = cross(u, v);
        if dot(turned, turned) < PARALLEL * PARALLEL && dot(u, v) > 0.0 {
            let ends = [first.ends[1 - i], second.ends[1 - j]];
            return Some(Edge { ends, corners: [first.corners[1 - i], second.corners[1 - j]], ..*first });
        }
    }
    None
}
