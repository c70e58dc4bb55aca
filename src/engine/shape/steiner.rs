//! Volume and moments of a convex hull with a sphere swept over it, in closed form, as Steiner's formula for its volume: those of the hull, of a slab on each face, of a sector of a
//! cylinder on each edge and of a sector of the sphere on each corner.

use super::hull::Hull;
use super::moments::Moments;
use super::polyhedron::halfway;
use crate::math::portable::angle;
use crate::math::vector::{cross, dot, less, plus, scaled};

/// Volume, m³, centre, m, and tensor of inertia about it for a density of 1, `[xx, yy, zz, xy, yz, zx]`, m⁵.
pub(super) fn inertia(hull: &Hull) -> (f64, [f64; 3], [f64; 6]) {
    // about the centre itself, so that no large parts cancel
    let origin = hull.corners.first().copied().unwrap_or_default();
    let centre = plus(origin, moments(hull, origin).centre());
    let about = moments(hull, centre);
    (about.volume, centre, about.inertia())
}

/// Moments about a point.
fn moments(hull: &Hull, origin: [f64; 3]) -> Moments {
    let (corner, r) = (|k: u32| less(hull.corners[k as usize], origin), hull.rounding);
    let mut sum = Moments::default();
    let mut add = |part: Moments| sum = sum.plus(&part, 1.0);
    for face in &hull.faces {
        let corners = face.corners.map(corner);
        add(Moments::of_tetrahedron(corners));
        if r > 0.0 {
            let [a, b, c] = corners;
            let across = cross(less(b, a), less(c, a));
            let triangle = Moments::of_simplex(0.5 * dot(across, across).sqrt(), &corners);
            add(triangle.swept_over(&Moments::of_simplex(r, &[[0.0; 3], scaled(face.normal, r)])));
        }
    }
    if r == 0.0 {
        return sum;
    }
    let corner_normals = hull.outwards();
    for ([i, j], [m, n]) in hull.edges() {
        let (p, q) = (corner(i), corner(j));
        let along = less(q, p);
        let edge = Moments::of_simplex(dot(along, along).sqrt(), &[p, q]);
        add(edge.swept_over(&sector(Arc::of(m, n), r)));
        for (k, at) in [(i, p), (j, q)] {
            add(Moments::of_simplex(1.0, &[at]).swept_over(&cone([corner_normals[k as usize], m, n], r)));
        }
    }
    sum
}

/// The part of a great circle of the unit sphere between two unit vectors that are not opposite.
struct Arc {
    /// Its middle, unit vector.
    middle: [f64; 3],
    /// Its ends' difference, from the first to the second.
    chord: [f64; 3],
    /// Length of the difference: ∫ u over it is `middle` times this.
    length: f64,
    /// Angle between its ends, rad.
    angle: f64,
}

impl Arc {
    fn of(m: [f64; 3], n: [f64; 3]) -> Arc {
        let (chord, sum) = (less(n, m), plus(m, n));
        let (length, twice) = (dot(chord, chord).sqrt(), dot(sum, sum).sqrt());
        Arc { middle: halfway(m, n), chord, length, angle: 2.0 * angle(length / twice, 1.0) }
    }

    /// Unit normal of its plane, from which it goes round counter-clockwise; 0 where its ends are one.
    fn normal(&self) -> [f64; 3] {
        let across = cross(self.middle, self.chord);
        if self.length > 0.0 { scaled(across, 1.0 / self.length) } else { [0.0; 3] }
    }
}

/// The sector of a disc of radius `r` that an arc bounds.
fn sector(arc: Arc, r: f64) -> Moments {
    let (h, k, sine) =
        (arc.middle, scaled(arc.chord, 1.0 / arc.length), arc.length * (1.0 - 0.25 * arc.length * arc.length).sqrt());
    // ∫ cos² and ∫ sin² from −θ/2 to θ/2
    let [along, across] = [0.5 * (arc.angle + sine), 0.5 * (arc.angle - sine)];
    let fourth = 0.25 * r * r * r * r;
    let second = std::array::from_fn(|i| std::array::from_fn(|j| fourth * (along * h[i] * h[j] + across * k[i] * k[j])));
    Moments { volume: 0.5 * r * r * arc.angle, first: scaled(h, r * r * r / 3.0 * arc.length), second }
}

/// The part of a ball of radius `r` about the origin within the spherical triangle of three unit vectors. On the sphere u is an eigenfunction of the Laplacian with eigenvalue −2, and u uᵀ − I/3 one with
/// −6, so that their integrals are those of their slopes along the border.
fn cone([a, b, c]: [[f64; 3]; 3], r: f64) -> Moments {
    // counter-clockwise
    let [a, b, c] = if dot(a, cross(b, c)) >= 0.0 { [a, b, c] } else { [a, c, b] };
    let arcs = [Arc::of(a, b), Arc::of(b, c), Arc::of(c, a)];
    let first = arcs.iter().fold([0.0; 3], |sum, arc| plus(sum, scaled(arc.normal(), 0.5 * arc.angle)));
    // its angle (van Oosterom & Strackee 1983), less than half of the sphere's
    let (above, below) = (dot(a, cross(b, c)), 1.0 + dot(a, b) + dot(b, c) + dot(c, a));
    let angle = 2.0 * angle(above, below);
    let second = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let border = |arc: &Arc| {
                let (n, u) = (arc.normal(), scaled(arc.middle, arc.length));
                (u[i] * n[j] + n[i] * u[j]) / 6.0
            };
            let middle = if i == j { angle / 3.0 } else { 0.0 };
            r * r * r * r * r / 5.0 * arcs.iter().fold(middle, |sum, arc| sum + border(arc))
        })
    });
    Moments { volume: r * r * r / 3.0 * angle, first: scaled(first, r * r * r * r / 4.0), second }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An eighth of a ball: ∫ x = π r⁴/16, ∫ x² = 2π r⁵/15/4 and ∫ x y = r⁵/15, in whatever order its corners are given.
    #[test]
    fn an_eighth_of_a_ball_has_its_closed_forms() {
        let (pi, r) = (std::f64::consts::PI, 1.3_f64);
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for corners in [[x, y, z], [y, x, z]] {
            let eighth = cone(corners, r);
            assert!((eighth.volume / (pi / 6.0 * r.powi(3)) - 1.0).abs() < 1e-14);
            for i in 0..3 {
                assert!((eighth.first[i] / (pi / 16.0 * r.powi(4)) - 1.0).abs() < 1e-14, "{:?}", eighth.first);
                for j in 0..3 {
                    let exact = r.powi(5) / 15.0 * if i == j { 0.5 * pi } else { 1.0 };
                    assert!((eighth.second[i][j] / exact - 1.0).abs() < 1e-14, "{i} {j} {:?}", eighth.second);
                }
            }
        }
    }

    /// Sectors and cones add up: a cut through them changes nothing. Arcs without a length have none of what they bound.
    #[test]
    fn parts_of_sectors_and_cones_add_up() {
        let unit = |v: [f64; 3]| scaled(v, 1.0 / dot(v, v).sqrt());
        let (a, b, c) = (unit([1.0, 0.2, 0.1]), unit([-0.3, 1.0, 0.4]), unit([0.1, -0.2, 1.0]));
        let middle = halfway(b, c);
        let close = |whole: Moments, parts: [Moments; 2]| {
            let sum = parts[0].plus(&parts[1], 1.0);
            let all = |m: &Moments| [vec![m.volume], m.first.to_vec(), m.second.concat()].concat();
            let same = all(&whole).into_iter().zip(all(&sum)).all(|(x, y)| (x - y).abs() < 1e-14);
            assert!(same, "{whole:?} {sum:?}");
        };
        close(cone([a, b, c], 0.9), [cone([a, b, middle], 0.9), cone([a, middle, c], 0.9)]);
        close(sector(Arc::of(b, c), 0.9), [sector(Arc::of(b, middle), 0.9), sector(Arc::of(middle, c), 0.9)]);
        close(cone([a, a, c], 0.9), [Moments::default(); 2]);
    }
}
