//! The point of a triangle that is nearest to a position.
//!
//! The nearest point of a side is computed from its ends in the order of their numbers, so two triangles with a common side find the same bits there. What is
//! decided by comparing distances is then the same from both.

use crate::math::vector::{cross, dot, less, plus, scaled};

/// Where on a triangle its nearest point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::shape) enum Place {
    /// Between its sides.
    Face,
    /// On side `k`, from corner `k` of the triangle to the next, between its ends.
    Side(usize),
    /// At the vertex with this number.
    Vertex(u32),
}

/// The nearest point of a triangle.
#[derive(Clone, Copy, Debug)]
pub(in crate::shape) struct Foot {
    /// Square of its distance, m².
    pub square: f64,
    /// From it to the position, m.
    pub out: [f64; 3],
    /// Where it lies.
    pub place: Place,
}

/// The nearest point of side `k` of a triangle with these corners.
pub(super) fn of_side(vertices: &[[f64; 3]], triangle: [u32; 3], k: usize, at: [f64; 3]) -> Foot {
    let (i, j) = (triangle[k], triangle[(k + 1) % 3]);
    let (i, j) = (i.min(j), i.max(j));
    let (p, q) = (vertices[i as usize], vertices[j as usize]);
    let along = less(q, p);
    let s = dot(along, less(at, p)) / dot(along, along);
    let (out, place) = if s <= 0.0 {
        (less(at, p), Place::Vertex(i))
    } else if s >= 1.0 {
        (less(at, q), Place::Vertex(j))
    } else {
        (less(at, plus(p, scaled(along, s))), Place::Side(k))
    };
    Foot { square: dot(out, out), out, place }
}

/// The nearest point of a triangle with the unit normal `normal`. It lies in the face only if that is nearer than all sides.
pub(in crate::shape) fn of_triangle(vertices: &[[f64; 3]], triangle: [u32; 3], normal: [f64; 3], at: [f64; 3]) -> Foot {
    let mut best = of_side(vertices, triangle, 0, at);
    for k in [1, 2] {
        let foot = of_side(vertices, triangle, k, at);
        if foot.square < best.square {
            best = foot;
        }
    }
    let [a, b, c] = triangle.map(|k| vertices[k as usize]);
    let inside = [(a, b), (b, c), (c, a)].into_iter().all(|(p, q)| dot(cross(normal, less(q, p)), less(at, p)) > 0.0);
    let before = dot(normal, less(at, a));
    if inside && before * before < best.square {
        return Foot { square: before * before, out: scaled(normal, before), place: Place::Face };
    }
    best
}
