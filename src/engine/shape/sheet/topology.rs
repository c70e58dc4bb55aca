//! How the triangles of a sheet hang together: which share a side, which lie in one plane, and the edges and corners that other bodies can touch.

use crate::math::vector::{cross, dot, less, plus, scaled};
use std::collections::BTreeMap;

/// Stands for no triangle, edge or corner.
pub(super) const NONE: u32 = u32::MAX;
/// Angle, rad, up to which two triangles lie in one plane and two edges on one line: numbers of single precision, as files have them, leave some 1e-7 times size over
/// height of a triangle, and a pipe of as many sides would have more triangles than a scene may have.
const FLAT: f64 = 1e-4;
/// Height of a triangle over its longest side below which it has no plane.
const THINNEST: f64 = 1e-7;
/// Largest coordinate of a vertex, m.
const FURTHEST: f64 = 1e6;

/// A border of the sheet, or a line along which it bends, as long as it is straight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// Vertices at its ends.
    pub ends: [u32; 2],
    /// Direction to the side to which the sheet bends, or from a border into it; unit vector.
    pub bend: [f64; 3],
}

/// A vertex at which edges end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Its vertex.
    pub vertex: u32,
    /// Direction to the side to which the sheet bends; unit vector, or zero.
    pub bend: [f64; 3],
}

/// How the triangles of a sheet hang together.
#[derive(Clone, Debug)]
pub(super) struct Topology {
    /// Unit normals of the triangles.
    pub normals: Vec<[f64; 3]>,
    /// The triangle beyond each side; [`NONE`] at a border.
    pub beyond: Vec<[u32; 3]>,
    /// The facet of each triangle.
    pub facet: Vec<u32>,
    /// The triangles of each facet, in their order.
    pub members: Vec<Vec<u32>>,
    /// The triangles at each vertex.
    pub around: Vec<Vec<u32>>,
    /// Edges.
    pub edges: Vec<Edge>,
    /// The edge on each side of each triangle; [`NONE`] inside a facet.
    pub edge_of: Vec<[u32; 3]>,
    /// Corners.
    pub corners: Vec<Corner>,
    /// The corner at each vertex; [`NONE`] where there is none.
    pub corner_of: Vec<u32>,
    /// Whether no side is a border.
    pub closed: bool,
}

/// Triangles whose equal vertices are one; vertices that no triangle has are left out.
pub fn welded(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (mut places, mut known, mut number) = (Vec::new(), BTreeMap::new(), vec![NONE; vertices.len()]);
    let mut weld = |k: u32| {
        if number[k as usize] == NONE {
            // zero has two signs
            let place = vertices[k as usize].map(|x| x + 0.0);
            number[k as usize] = *known.entry(place.map(f64::to_bits)).or_insert_with(|| {
                places.push(place);
                places.len() as u32 - 1
            });
        }
        number[k as usize]
    };
    let triangles = triangles.iter().map(|t| t.map(&mut weld)).collect();
    (places, triangles)
}

/// Unit vector of a direction; zero for zero.
fn unit(v: [f64; 3]) -> [f64; 3] {
    let square = dot(v, v);
    if square > 0.0 { scaled(v, 1.0 / square.sqrt()) } else { [0.0; 3] }
}

fn near(a: [f64; 3], b: [f64; 3]) -> bool {
    let apart = less(a, b);
    dot(apart, apart) < FLAT * FLAT
}

impl Topology {
    /// Of triangles whose equal vertices are one.
    ///
    /// # Errors
    /// A vertex that is no place, a flat triangle, more than two triangles at an edge, no triangles; the text says which.
    pub fn of(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<Topology, String> {
        if triangles.is_empty() {
            return Err("has no triangles".into());
        }
        if let Some((k, p)) = vertices.iter().enumerate().find(|(_, p)| !p.iter().all(|x| x.abs() <= FURTHEST)) {
            return Err(format!("has its vertex {k} at {p:?} m, which is no place"));
        }
        let corners = |t: &[u32; 3]| t.map(|k| vertices[k as usize]);
        let mut normals = Vec::with_capacity(triangles.len());
        for (k, triangle) in triangles.iter().enumerate() {
            let [a, b, c] = corners(triangle);
            let sides = [less(b, a), less(c, b), less(a, c)];
            let (n, longest) = (cross(sides[0], sides[1]), sides.iter().map(|s| dot(*s, *s)).fold(0.0, f64::max));
            let double = dot(n, n).sqrt();
            if double.is_nan() || double <= THINNEST * longest || longest < 1e-24 {
                return Err(format!("has a flat triangle, number {k} from 0, with the corners {a:?}, {b:?} and {c:?} m"));
            }
            normals.push(scaled(n, 1.0 / double));
        }
        let beyond = neighbours(triangles)?;
        // in the plane of triangle t, across its side k, into it
        let into = |t: usize, k: usize| {
            let [p, q, r] = [0, 1, 2].map(|i| vertices[triangles[t][(k + i) % 3] as usize]);
            let along = unit(less(q, p));
            unit(less(less(r, p), scaled(along, dot(along, less(r, p)))))
        };
        let flat = |t: usize, k: usize| {
            let other = beyond[t][k];
            other != NONE && near(into(t, k), into(other as usize, common(triangles, t, k, other)).map(|x| -x))
        };
        // facets: from each triangle that has none yet, over sides at which the sheet goes on in its plane
        let (mut facet, mut facets) = (vec![NONE; triangles.len()], 0);
        for seed in 0..triangles.len() {
            if facet[seed] != NONE {
                continue;
            }
            facet[seed] = facets;
            let mut open = vec![seed];
            while let Some(t) = open.pop() {
                for (k, beside) in beyond[t].into_iter().enumerate() {
                    let other = beside as usize;
                    if beside == NONE || facet[other] != NONE || !flat(t, k) {
                        continue;
                    }
                    let n = normals[other];
                    if near(n, normals[seed]) || near(n.map(|x| -x), normals[seed]) {
                        facet[other] = facets;
                        open.push(other);
                    }
                }
            }
            facets += 1;
        }
        let mut members = vec![Vec::new(); facets as usize];
        facet.iter().enumerate().for_each(|(t, f)| members[*f as usize].push(t as u32));
        let mut around = vec![Vec::new(); vertices.len()];
        for (t, triangle) in triangles.iter().enumerate() {
            triangle.iter().for_each(|k| around[*k as usize].push(t as u32));
        }
        let (edges, edge_of) = edges(vertices, triangles, &beyond, &facet, &into);
        let (corners, corner_of) = self::corners(vertices, &edges);
        let closed = beyond.as_flattened().iter().all(|t| *t != NONE);
        Ok(Topology { normals, beyond, facet, members, around, edges, edge_of, corners, corner_of, closed })
    }
}

/// The side of triangle `other` that is side `k` of triangle `t`.
fn common(triangles: &[[u32; 3]], t: usize, k: usize, other: u32) -> usize {
    let ends = |t: usize, k: usize| {
        let (i, j) = (triangles[t][k], triangles[t][(k + 1) % 3]);
        [i.min(j), i.max(j)]
    };
    (0..3).find(|&l| ends(other as usize, l) == ends(t, k)).unwrap_or(0)
}

/// The triangle beyond each side.
fn neighbours(triangles: &[[u32; 3]]) -> Result<Vec<[u32; 3]>, String> {
    let mut sides: Vec<([u32; 2], u32, usize)> = Vec::with_capacity(3 * triangles.len());
    for (t, triangle) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (i, j) = (triangle[k], triangle[(k + 1) % 3]);
            sides.push(([i.min(j), i.max(j)], t as u32, k));
        }
    }
    sides.sort_unstable();
    let mut beyond = vec![[NONE; 3]; triangles.len()];
    for at_edge in sides.chunk_by(|a, b| a.0 == b.0) {
        match *at_edge {
            [_] => {}
            [(_, t, k), (_, u, l)] => {
                beyond[t as usize][k] = u;
                beyond[u as usize][l] = t;
            }
            _ => {
                let numbers: Vec<String> = at_edge.iter().take(5).map(|(_, t, _)| t.to_string()).collect();
                let of = at_edge.len();
                return Err(format!(
                    "has {of} triangles at one edge, where two may meet at most: numbers {} from 0",
                    numbers.join(", ")
                ));
            }
        }
    }
    Ok(beyond)
}

/// A side of a triangle at which the sheet ends or bends.
struct Bent {
    /// Vertices at its ends, lower number first.
    ends: [u32; 2],
    /// The triangles and their sides, one or two.
    sides: Vec<(usize, usize)>,
    /// The facets at it, lower number first.
    facets: [u32; 2],
    /// Unit vector from the lower to the higher vertex.
    along: [f64; 3],
}

/// The edges, and the edge on each side of each triangle.
fn edges(
    vertices: &[[f64; 3]],
    triangles: &[[u32; 3]],
    beyond: &[[u32; 3]],
    facet: &[u32],
    into: &impl Fn(usize, usize) -> [f64; 3],
) -> (Vec<Edge>, Vec<[u32; 3]>) {
    let mut bent: Vec<Bent> = Vec::new();
    let mut at: Vec<Vec<usize>> = vec![Vec::new(); vertices.len()];
    for (t, triangle) in triangles.iter().enumerate() {
        for k in 0..3 {
            let other = beyond[t][k];
            let g = if other == NONE { NONE } else { facet[other as usize] };
            // each once, from the triangle of lower number
            if g == facet[t] || (other != NONE && (other as usize) < t) {
                continue;
            }
            let (i, j) = (triangle[k], triangle[(k + 1) % 3]);
            let (i, j) = (i.min(j), i.max(j));
            let mut sides = vec![(t, k)];
            if other != NONE {
                sides.push((other as usize, common(triangles, t, k, other)));
            }
            [i, j].iter().for_each(|end| at[*end as usize].push(bent.len()));
            let along = unit(less(vertices[j as usize], vertices[i as usize]));
            bent.push(Bent { ends: [i, j], sides, facets: [facet[t].min(g), facet[t].max(g)], along });
        }
    }
    let (mut edges, mut edge_of, mut seen) = (Vec::new(), vec![[NONE; 3]; triangles.len()], vec![false; bent.len()]);
    for first in 0..bent.len() {
        if seen[first] {
            continue;
        }
        let number = edges.len() as u32;
        let mut take = |b: usize, seen: &mut [bool]| {
            seen[b] = true;
            bent[b].sides.iter().for_each(|(t, k)| edge_of[*t][*k] = number);
        };
        take(first, &mut seen);
        let start = &bent[first];
        let ends = start.ends.map(|end| {
            // on over vertices at which nothing but this edge passes, as long as it is straight
            let (mut end, mut last) = (end, first);
            while let [a, b] = at[end as usize][..] {
                let next = if a == last { b } else { a };
                let straight = near(bent[next].along, start.along) || near(bent[next].along.map(|x| -x), start.along);
                if seen[next] || bent[next].facets != start.facets || !straight {
                    break;
                }
                take(next, &mut seen);
                let [i, j] = bent[next].ends;
                (end, last) = (if i == end { j } else { i }, next);
            }
            end
        });
        let bend = start.sides.iter().fold([0.0; 3], |sum, (t, k)| plus(sum, into(*t, *k)));
        edges.push(Edge { ends, bend: unit(bend) });
    }
    (edges, edge_of)
}

/// The vertices at which edges end, and the corner at each vertex.
fn corners(vertices: &[[f64; 3]], edges: &[Edge]) -> (Vec<Corner>, Vec<u32>) {
    let mut bends: BTreeMap<u32, [f64; 3]> = BTreeMap::new();
    for edge in edges {
        for (here, there) in [(edge.ends[0], edge.ends[1]), (edge.ends[1], edge.ends[0])] {
            let away = unit(less(vertices[there as usize], vertices[here as usize]));
            let sum = bends.entry(here).or_insert([0.0; 3]);
            *sum = plus(*sum, away);
        }
    }
    let mut corner_of = vec![NONE; vertices.len()];
    // where edges leave to all sides the sum is rounding
    let corner = |(n, (vertex, sum)): (usize, (u32, [f64; 3]))| {
        corner_of[vertex as usize] = n as u32;
        Corner { vertex, bend: if dot(sum, sum) > FLAT * FLAT { unit(sum) } else { [0.0; 3] } }
    };
    (bends.into_iter().enumerate().map(corner).collect(), corner_of)
}
