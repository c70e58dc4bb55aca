//! What convex parts cover more than once, which a sum over parts counts too often.
//!
//! Inclusion and exclusion: the sum over all sets of two parts or more of ± the moments of what they have in common, + for even numbers. What parts have in common is a box around
//! it cut by the half-spaces of all of them. Flat parts are exact. A round part is the half-spaces of tangents at normals between which angles are halved until they are small; the error, in
//! proportion to their square, is removed by extrapolation from two finenesses. So the error is in what is covered twice, and there in what is round.

use super::part::{Convex, Part};
use crate::math::vector::{cross, dot, less, plus, scaled};
use crate::shape::hull::Hull;
use crate::shape::moments::Moments;
use crate::shape::polyhedron::halfway;
use crate::shape::ring::{Ring, convex_ring};

/// Cosine of the angle to which those between normals are halved, in space a quarter of a right angle and in the plane a 128th; once more gives the error.
const SMALL: [f64; 2] = [0.923_8, 0.999_924];
/// Most sets of parts with something in common.
const MOST: usize = 4000;
/// Over the size of a body: what is thinner is nothing.
const THIN: f64 = 1e-12;

/// Half-space: unit normal out of it, and distance of its border from the origin along that, m.
type Half = ([f64; 3], f64);

/// What the parts cover more than once, each time but the first.
///
/// # Errors
/// Too many sets of parts have something in common.
pub(super) fn covered(parts: &[Part]) -> Result<Moments, String> {
    let flat = parts.iter().any(Part::is_flat);
    let of = |more: u32| {
        let halves: Vec<[Vec<Half>; 2]> = parts.iter().map(|part| halves(part, more)).collect();
        sum(parts, &halves, flat)
    };
    let coarse = of(0)?;
    if coarse.volume == 0.0 || parts.iter().all(|part| part.rounding() == 0.0) {
        return Ok(coarse);
    }
    Ok(Moments::beyond(&coarse, &of(1)?))
}

/// What is left of a box that is cut by half-spaces.
#[derive(Clone)]
struct Region {
    /// Its faces, counter-clockwise from outside; in the plane the one outline, counter-clockwise.
    faces: Vec<Vec<[f64; 3]>>,
    /// Lowest and highest coordinates.
    bounds: [[f64; 3]; 2],
    flat: bool,
    /// What is thinner is nothing, m.
    hair: f64,
}

/// The sum over all sets.
fn sum(parts: &[Part], halves: &[[Vec<Half>; 2]], flat: bool) -> Result<Moments, String> {
    let mut all = Moments::default();
    let mut count = 0;
    // sets that have something in common: how many parts, the last of them, and what it is; of one part a box around it
    let bounds: Vec<_> = parts.iter().map(Part::bounds).collect();
    let mut open: Vec<(usize, usize, Region)> = (0..parts.len()).map(|k| (1, k, Region::cuboid(bounds[k], flat))).collect();
    while let Some((many, last, region)) = open.pop() {
        for next in last + 1..parts.len() {
            let Some(shared) = region.shared(bounds[next]) else { continue };
            let both = if many == 1 {
                // flat faces first, so that little is left when round ones come
                let of = [&halves[last], &halves[next]];
                Region::cuboid(shared, flat).cut(of.iter().flat_map(|of| &of[0]).chain(of.iter().flat_map(|of| &of[1])))
            } else {
                region.clone().cut(halves[next].iter().flatten())
            };
            let Some(both) = both else { continue };
            count += 1;
            if count > MOST {
                return Err(format!("have more than {MOST} sets of parts with something in common: too many lie over each other"));
            }
            all = all.plus(&both.moments(), if many % 2 == 1 { 1.0 } else { -1.0 });
            open.push((many + 1, next, both));
        }
    }
    Ok(all)
}

impl Region {
    /// A box.
    fn cuboid([low, high]: [[f64; 3]; 2], flat: bool) -> Region {
        let half: [f64; 3] = std::array::from_fn(|a| 0.5 * (high[a] - low[a]));
        let middle: [f64; 3] = std::array::from_fn(|a| 0.5 * (low[a] + high[a]));
        let faces = if flat {
            let place = |[u, v]: [f64; 2]| [u * half[0], v * half[1], 0.0];
            vec![[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(place).to_vec()]
        } else {
            cuboid(half)
        };
        let faces = faces.into_iter().map(|face| face.into_iter().map(|p| plus(p, middle)).collect()).collect();
        let size = half.into_iter().fold(0.0, f64::max);
        Region { faces, bounds: [low, high], flat, hair: THIN * size }
    }

    /// What these bounds and its own have in common; `None` if it is no more than a hair thick.
    fn shared(&self, [from, to]: [[f64; 3]; 2]) -> Option<[[f64; 3]; 2]> {
        let [low, high] = self.bounds;
        let shared: [[f64; 3]; 2] = [std::array::from_fn(|a| low[a].max(from[a])), std::array::from_fn(|a| high[a].min(to[a]))];
        let axes = if self.flat { 2 } else { 3 };
        (0..axes).all(|a| shared[1][a] - shared[0][a] > self.hair).then_some(shared)
    }

    /// What is left of it in half-spaces; `None` if nothing is.
    fn cut<'a>(mut self, halves: impl Iterator<Item = &'a Half>) -> Option<Region> {
        for (normal, offset) in halves {
            let [low, high] = self.bounds;
            let furthest: f64 = (0..3).map(|a| (normal[a] * low[a]).max(normal[a] * high[a])).sum();
            if furthest <= offset + self.hair {
                continue;
            }
            let left = if self.flat {
                cut_ring(&mut self.faces[0], (*normal, *offset), self.hair)
            } else {
                cut(&mut self.faces, (*normal, *offset), self.hair)
            };
            if !left {
                return None;
            }
            let all = || self.faces.iter().flatten();
            self.bounds = [
                std::array::from_fn(|a| all().fold(f64::INFINITY, |low, p| p[a].min(low))),
                std::array::from_fn(|a| all().fold(f64::NEG_INFINITY, |high, p| p[a].max(high))),
            ];
        }
        (self.moments().volume > 0.0).then_some(self)
    }

    /// Its volume and moments.
    fn moments(&self) -> Moments {
        let [low, high] = self.bounds;
        // from its middle, so that nothing large is taken away
        let middle: [f64; 3] = std::array::from_fn(|a| if self.flat && a == 2 { 0.0 } else { 0.5 * (low[a] + high[a]) });
        let faces = self.faces.iter().map(|face| face.iter().map(|p| less(*p, middle)).collect::<Vec<_>>());
        let mut all = Moments::default();
        for face in faces {
            if self.flat {
                let sides = (0..face.len()).map(|k| [face[k], face[(k + 1) % face.len()]]);
                all = sides.fold(all, |sum, side| sum.plus(&Moments::of_triangle(side), 1.0));
            } else {
                let triangles = face.windows(2).skip(1).map(|w| [face[0], w[0], w[1]]);
                all = triangles.fold(all, |sum, triangle| sum.plus(&Moments::of_tetrahedron(triangle), 1.0));
            }
        }
        all.moved(middle)
    }
}

/// The faces of a box about the origin, counter-clockwise from outside.
fn cuboid(half: [f64; 3]) -> Vec<Vec<[f64; 3]>> {
    let hull: [(usize, f64); 6] = [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0), (2, -1.0), (2, 1.0)];
    let face = |(axis, side): (usize, f64)| {
        let mut round = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        if side < 0.0 {
            round.reverse();
        }
        let place = |[u, v]: [f64; 2]| {
            let mut p = [0.0; 3];
            p[axis] = side * half[axis];
            p[(axis + 1) % 3] = u * half[(axis + 1) % 3];
            p[(axis + 2) % 3] = v * half[(axis + 2) % 3];
            p
        };
        round.map(place).to_vec()
    };
    hull.map(face).to_vec()
}

/// Cuts a convex polygon by a half-space and adds the places on its border to `border`.
fn cut_face(face: &[[f64; 3]], (normal, offset): Half, hair: f64, border: &mut Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    let before = |p: [f64; 3]| dot(normal, p) - offset;
    let mut left = Vec::with_capacity(face.len() + 1);
    for (k, p) in face.iter().enumerate() {
        let q = face[(k + 1) % face.len()];
        let (here, there) = (before(*p), before(q));
        if here <= hair {
            left.push(*p);
            if here >= -hair {
                border.push(*p);
            }
        }
        if (here < -hair && there > hair) || (here > hair && there < -hair) {
            let place = plus(*p, scaled(less(q, *p), here / (here - there)));
            left.push(place);
            border.push(place);
        }
    }
    if left.len() < 3 { Vec::new() } else { left }
}

/// Cuts a polygon of the plane by a half-space; whether anything is left.
fn cut_ring(ring: &mut Vec<[f64; 3]>, half: Half, hair: f64) -> bool {
    if ring.iter().any(|p| dot(half.0, *p) - half.1 > hair) {
        *ring = cut_face(ring, half, hair, &mut Vec::new());
    }
    !ring.is_empty()
}

/// Cuts a convex polyhedron by a half-space; whether anything is left.
fn cut(faces: &mut Vec<Vec<[f64; 3]>>, half: Half, hair: f64) -> bool {
    let (normal, offset) = half;
    let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in faces.iter().flatten() {
        let before = dot(normal, *p) - offset;
        (lowest, highest) = (lowest.min(before), highest.max(before));
    }
    if highest <= hair {
        return true;
    }
    if lowest >= -hair {
        return false;
    }
    let mut border = Vec::new();
    faces.retain_mut(|face| {
        // most faces stay as they are
        if face.iter().any(|p| dot(normal, *p) - offset >= -hair) {
            *face = cut_face(face, half, hair, &mut border);
        }
        !face.is_empty()
    });
    // the new face: the hull of the places on the border
    let least = (0..3).fold(0, |least, a| if normal[a].abs() < normal[least].abs() { a } else { least });
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let u = cross(axis, normal);
    let u = scaled(u, 1.0 / dot(u, u).sqrt());
    let v = cross(normal, u);
    let flat: Vec<[f64; 2]> = border.iter().map(|p| [dot(u, *p), dot(v, *p)]).collect();
    let ring = convex_ring(&flat);
    if ring.len() > 2 {
        faces.push(ring.into_iter().map(|[x, y]| plus(scaled(normal, offset), plus(scaled(u, x), scaled(v, y)))).collect());
    }
    true
}

/// The half-spaces of the flat faces of a part, and those of tangents where it is round, at normals between which angles are halved `more` times after they are small.
fn halves(part: &Part, more: u32) -> [Vec<Half>; 2] {
    match &part.surface {
        Convex::Hull(hull) => of_hull(hull, more),
        Convex::Ring(ring) => of_ring(ring, more),
    }
}

/// Times that the angle between two normals is halved until it is small.
fn halvings(m: [f64; 3], n: [f64; 3], small: f64) -> u32 {
    let mut cosine = dot(m, n);
    let mut count = 0;
    while cosine < small && count < 16 {
        cosine = (0.5 * (1.0 + cosine)).max(0.0).sqrt();
        count += 1;
    }
    count
}

fn of_hull(hull: &Hull, more: u32) -> [Vec<Half>; 2] {
    let r = hull.rounding;
    let flat = hull.faces.iter().map(|face| (face.normal, face.offset + r)).collect();
    let mut round = Vec::new();
    if r == 0.0 {
        return [flat, round];
    }
    let corner = |k: u32| hull.corners[k as usize];
    let mut around: Vec<Vec<[[f64; 3]; 2]>> = vec![Vec::new(); hull.corners.len()];
    for ([i, j], [m, n]) in hull.edges() {
        arc(m, n, halvings(m, n, SMALL[0]) + more, &mut |normal| round.push((normal, dot(normal, corner(i)) + r)));
        [i, j].iter().for_each(|k| around[*k as usize].push([m, n]));
    }
    for (k, arcs) in around.iter().enumerate() {
        let sum = arcs.iter().flatten().fold([0.0; 3], |sum, n| plus(sum, *n));
        let length = dot(sum, sum).sqrt();
        if length > 0.0 {
            let middle = scaled(sum, 1.0 / length);
            let mut add = |normal: [f64; 3]| round.push((normal, dot(normal, corner(k as u32)) + r));
            add(middle);
            for &[m, n] in arcs {
                let longest =
                    [(m, n), (n, middle), (middle, m)].map(|(p, q)| halvings(p, q, SMALL[0])).into_iter().fold(0, u32::max);
                cap([middle, m, n], longest + more, &mut add);
            }
        }
    }
    // each once: those along an edge are also those at its corners
    round.sort_by(|a, b| (0..3).fold(std::cmp::Ordering::Equal, |order, k| order.then(a.0[k].total_cmp(&b.0[k]))));
    round.dedup_by_key(|half| half.0);
    [flat, round]
}

/// Normals between two, halved `fine` times.
fn arc(m: [f64; 3], n: [f64; 3], fine: u32, add: &mut impl FnMut([f64; 3])) {
    if fine > 0 {
        let middle = halfway(m, n);
        arc(m, middle, fine - 1, add);
        add(middle);
        arc(middle, n, fine - 1, add);
    }
}

/// Normals on the sides of a triangle of the sphere and in it.
fn cap([l, m, n]: [[f64; 3]; 3], fine: u32, add: &mut impl FnMut([f64; 3])) {
    if fine > 0 {
        let [a, b, c] = [halfway(m, n), halfway(n, l), halfway(l, m)];
        [a, b, c].into_iter().for_each(&mut *add);
        for corners in [[l, c, b], [c, m, a], [b, a, n], [a, b, c]] {
            cap(corners, fine - 1, add);
        }
    }
}

fn of_ring(ring: &Ring, more: u32) -> [Vec<Half>; 2] {
    let (n, r) = (ring.corners.len(), ring.rounding);
    let sides: Vec<([f64; 3], [f64; 3])> = ring.sides().map(|([p, _], normal)| (p, normal)).collect();
    let flat = sides.iter().map(|(p, normal)| (*normal, dot(*normal, *p) + r)).collect();
    let mut round = Vec::new();
    if r == 0.0 {
        return [flat, round];
    }
    for (k, corner) in ring.corners.iter().enumerate() {
        let mut add = |normal: [f64; 3]| round.push((normal, dot(normal, *corner) + r));
        let quarters: Vec<[f64; 3]> = match n {
            1 => vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]],
            // a half turn
            2 => {
                let [m, o] = [sides[(k + 1) % 2].1, sides[k].1];
                vec![m, [-m[1], m[0], 0.0], o]
            }
            _ => vec![sides[(k + n - 1) % n].1, sides[k].1],
        };
        for w in quarters.windows(2) {
            add(w[0]);
            arc(w[0], w[1], halvings(w[0], w[1], SMALL[1]) + more, &mut add);
        }
    }
    [flat, round]
}
