//! Shapes against closed forms, and what must hold for any of them.

use super::*;
use crate::math::vector::{dot, less, plus, scaled};
use proptest::prelude::*;

/// The unit vector between two numbers of −1..1.
fn direction([x, y, z]: [f64; 3]) -> [f64; 3] {
    let length = dot([x, y, z], [x, y, z]).sqrt();
    if length < 1e-3 { [0.6, 0.0, 0.8] } else { scaled([x, y, z], 1.0 / length) }
}

fn vector() -> impl Strategy<Value = [f64; 3]> {
    [-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64]
}

fn rock(rounding: f64) -> Placed {
    let points = [
        [0.0, 0.0, 0.0],
        [1.0, 0.1, 0.0],
        [0.2, 0.9, 0.1],
        [0.1, 0.2, 0.8],
        [0.9, 0.8, 0.6],
        [1.1, 0.5, 0.3],
        [0.4, 0.5, 1.1],
        [0.5, 0.5, 0.5],
    ];
    Polyhedron::hull(&points, rounding).expect("a hull")
}

fn shapes() -> Vec<Shape> {
    let quadric = |half, blockiness| Shape::Superquadric(Superquadric { half, blockiness });
    vec![
        Shape::Box(Cuboid { half: [0.5, 0.3, 0.2] }),
        Shape::Polyhedron(rock(0.0).polyhedron),
        Shape::Polyhedron(rock(0.15).polyhedron),
        quadric([0.4, 0.4, 0.4], [2.0, 2.0]),
        quadric([0.5, 0.3, 0.2], [2.0, 2.0]),
        quadric([0.5, 0.3, 0.2], [20.0, 20.0]),
        quadric([0.5, 0.3, 0.2], [2.0, 8.0]),
        quadric([0.5, 0.3, 0.2], [8.0, 2.0]),
        quadric([0.5, 0.3, 0.2], [3.3, 2.7]),
    ]
}

proptest! {
    /// A place is moved out of the surface along its normal by a known distance: the surface is found at that distance again, whatever the shape.
    #[test]
    fn the_nearest_point_of_a_convex_surface_is_found_again(towards in vector(), out in 0.01..0.5_f64) {
        for shape in shapes() {
            let solid = shape.solid();
            let n = direction(towards);
            // a point of the surface with the normal n: the furthest spot along n
            let spot = (0..solid.spots())
                .map(|k| solid.spot(k, n))
                .max_by(|p, q| dot(*p, n).total_cmp(&dot(*q, n)))
                .expect("spots");
            let nearest = solid.nearest(plus(spot, scaled(n, out)));
            prop_assert!((nearest.distance - out).abs() < 1e-11, "{shape:?}: {nearest:?} at {out}");
            prop_assert!((dot(nearest.normal, n) - 1.0).abs() < 1e-10, "{shape:?}: {nearest:?} for {n:?}");
            prop_assert!(solid.clearance(plus(spot, scaled(n, out))) <= out * (1.0 + 1e-12));
            prop_assert!(dot(spot, spot).sqrt() <= solid.reach() * (1.0 + 1e-12));
        }
    }

    /// From any place outside: the foot lies on the surface, and no spot lies beyond the plane through it.
    #[test]
    fn a_foot_has_all_of_the_body_behind_it(towards in vector(), far in 0.4..2.0_f64) {
        for shape in shapes() {
            let (solid, n) = (shape.solid(), direction(towards));
            let at = scaled(n, far * solid.reach());
            let nearest = solid.nearest(at);
            if nearest.distance <= 0.0 {
                continue;
            }
            prop_assert!((dot(nearest.normal, nearest.normal) - 1.0).abs() < 1e-14);
            let foot = less(at, scaled(nearest.normal, nearest.distance));
            let beyond = (0..solid.spots())
                .map(|k| dot(nearest.normal, less(solid.spot(k, nearest.normal), foot)))
                .fold(f64::NEG_INFINITY, f64::max);
            prop_assert!(beyond.abs() < 1e-9 * solid.reach(), "{shape:?}: {beyond:e} from {at:?}");
            let back = solid.nearest(foot);
            prop_assert!(back.distance.abs() < 1e-9, "{shape:?}: {back:?}");
        }
    }

    /// Inside it is negative, and no further than along a ray.
    #[test]
    fn inside_is_negative(towards in vector(), depth in 0.0..0.9_f64) {
        for shape in shapes() {
            let (solid, n) = (shape.solid(), direction(towards));
            // the surface along a ray, by halving
            let (mut low, mut high) = (0.0, solid.reach());
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if solid.nearest(scaled(n, middle)).distance < 0.0 { low = middle } else { high = middle }
            }
            let inside = solid.nearest(scaled(n, depth * low));
            prop_assert!(inside.distance < 0.0 && inside.distance.is_finite(), "{shape:?} {inside:?}");
            prop_assert!((dot(inside.normal, inside.normal) - 1.0).abs() < 1e-12);
            prop_assert!(inside.distance >= -(1.0 - depth) * low * (1.0 + 1e-9), "{shape:?} {inside:?}");
        }
    }
}

#[test]
fn the_middle_has_a_surface_too() {
    for shape in shapes() {
        let nearest = shape.solid().nearest([0.0; 3]);
        assert!(nearest.distance < 0.0 && (dot(nearest.normal, nearest.normal) - 1.0).abs() < 1e-14, "{shape:?}: {nearest:?}");
    }
}

#[test]
fn a_sphere_is_a_superquadric() {
    let ball = Superquadric { half: [0.4; 3], blockiness: [2.0; 2] };
    for at in [[1.0, 0.0, 0.0], [0.3, -0.4, 1.2], [-0.5, 0.5, 0.0]] {
        let length = dot(at, at).sqrt();
        let nearest = ball.nearest(at);
        assert!((nearest.distance - (length - 0.4)).abs() < 1e-15, "{nearest:?}");
        assert!((dot(nearest.normal, at) - length).abs() < 1e-15);
    }
    let (bulk, r) = (ball.bulk(), 0.4_f64);
    let volume = 4.0 / 3.0 * std::f64::consts::PI * r.powi(3);
    assert!((bulk.volume / volume - 1.0).abs() < 1e-13, "{bulk:?}");
    assert!(bulk.moments.iter().all(|i| (i / (0.4 * volume * r * r) - 1.0).abs() < 1e-13));
    assert!((bulk.radius() / r - 1.0).abs() < 1e-13);
}

#[test]
fn an_ellipsoid_has_its_closed_forms() {
    let [a, b, c] = [0.5_f64, 0.3, 0.2];
    let body = Superquadric { half: [a, b, c], blockiness: [2.0; 2] };
    let (bulk, volume) = (body.bulk(), 4.0 / 3.0 * std::f64::consts::PI * a * b * c);
    assert!((bulk.volume / volume - 1.0).abs() < 1e-13);
    let exact = [b * b + c * c, a * a + c * c, a * a + b * b].map(|sum| 0.2 * volume * sum);
    assert!((0..3).all(|k| (bulk.moments[k] / exact[k] - 1.0).abs() < 1e-13), "{bulk:?}");
}

/// With n → ∞ a superquadric is its box: at the faces to the last digits, in volume as 1/n.
#[test]
fn a_blocky_superquadric_is_nearly_a_box() {
    let half = [0.5, 0.3, 0.2];
    let (block, cuboid) = (Superquadric { half, blockiness: [100.0; 2] }, Cuboid { half });
    for at in [[0.6, 0.0, 0.0], [0.1, -0.5, 0.02], [-0.2, 0.1, 0.3]] {
        let (near, exact) = (block.nearest(at), cuboid.nearest(at));
        assert!((near.distance - exact.distance).abs() < 1e-9, "{near:?} {exact:?}");
        assert!((dot(near.normal, exact.normal) - 1.0).abs() < 1e-12);
    }
    let (bulk, exact) = (block.bulk(), cuboid.bulk());
    assert!((bulk.volume / exact.volume - 1.0).abs() < 1e-3);
    assert!((0..3).all(|k| (bulk.moments[k] / exact.moments[k] - 1.0).abs() < 2e-3));
}

/// Closed forms of volume and inertia against triangles, which lie inside of what is round: 24 pieces for a quarter of a superquadric (0.21 % of an ellipsoid's volume, a sixteenth of that with four times
/// as many). Of a polyhedron with round edges the limit of finer and finer triangles.
#[test]
fn bulk_is_that_of_the_surface() {
    for (shape, tolerance) in shapes().iter().zip([1e-13, 1e-13, 2e-5, 2.5e-3, 2.5e-3, 2.5e-3, 2.5e-3, 2.5e-3, 2.5e-3]) {
        let [coarse, fine] = match shape {
            Shape::Polyhedron(rock) => [3, 4].map(|fine| polyhedron::triangles(rock.rounded_hull(), fine)),
            _ => [shape.solid().surface(), shape.solid().surface()],
        }
        .map(|surface| surface.inertia());
        let limit = |fine: f64, coarse: f64| fine + (fine - coarse) / 3.0;
        let bulk = shape.solid().bulk();
        assert!((bulk.volume / limit(fine.0, coarse.0) - 1.0).abs() < tolerance, "{shape:?}: {bulk:?} {fine:?}");
        let moment = |k: usize| limit(fine.2[k], coarse.2[k]);
        assert!((0..3).all(|k| (bulk.moments[k] / moment(k) - 1.0).abs() < 2.0 * tolerance), "{shape:?}: {bulk:?} {fine:?}");
        let off = [0, 1, 2].map(|k| limit(fine.1[k], coarse.1[k])).into_iter().chain([3, 4, 5].map(|k| moment(k) / moment(0)));
        assert!(off.into_iter().all(|x| x.abs() < tolerance), "{shape:?}: {fine:?}");
    }
}

fn corners(half: [f64; 3]) -> Vec<[f64; 3]> {
    let cuboid = Cuboid { half };
    (0..8).map(|k| cuboid.spot(k, [0.0; 3])).collect()
}

/// A rounded box has the closed forms of Steiner; a sharp one those of the box, wherever and however it stands.
#[test]
fn a_box_of_eight_points_is_a_box() {
    let half = [0.5, 0.3, 0.2];
    let sharp =
        Polyhedron::hull(&corners(half).iter().map(|p| plus(*p, [7.0, -3.0, 2.0])).collect::<Vec<_>>(), 0.0).expect("a hull");
    assert!((0..3).all(|a| (sharp.centre[a] - [7.0, -3.0, 2.0][a]).abs() < 1e-14), "{:?}", sharp.centre);
    let (bulk, exact) = (sharp.polyhedron.bulk(), Cuboid { half }.bulk());
    assert!((bulk.volume / exact.volume - 1.0).abs() < 1e-13);
    let sorted = |mut m: [f64; 3]| {
        m.sort_by(f64::total_cmp);
        m
    };
    let (found, moments) = (sorted(bulk.moments), sorted(exact.moments));
    assert!((0..3).all(|k| (found[k] / moments[k] - 1.0).abs() < 1e-12), "{found:?} {moments:?}");

    let r = 0.1;
    let round = Polyhedron::hull(&corners(half), r).expect("a hull").polyhedron;
    let [a, b, c] = half.map(|h| 2.0 * h);
    let pi = std::f64::consts::PI;
    let steiner = a * b * c + 2.0 * r * (a * b + b * c + c * a) + pi * r * r * (a + b + c) + 4.0 / 3.0 * pi * r.powi(3);
    assert!((round.bulk().volume / steiner - 1.0).abs() < 1e-13, "{} {steiner}", round.bulk().volume);
    // second moments along x, y, z: of the box, its six slabs, twelve quarters of cylinders and eight eighths of the sphere
    let second = |axis: usize| {
        let [l, m, n] = [0, 1, 2].map(|k| 2.0 * half[(axis + k) % 3]);
        let h = 0.5 * l;
        let inside = l.powi(3) / 12.0;
        // ∫ x² over what is beyond the face: quarter discs and eighths of spheres have ∫ (h + s)² dA with s from the corner
        let disc = pi * r * r * h * h + 2.0 * h * (4.0 * r.powi(3) / 3.0) + pi * r.powi(4) / 4.0;
        let ball = 4.0 / 3.0 * pi * r.powi(3) * h * h + 2.0 * h * (pi * r.powi(4) / 2.0) + 4.0 / 15.0 * pi * r.powi(5);
        let slab = 2.0 * ((h + r).powi(3) - h.powi(3)) / 3.0;
        inside * (m * n + 2.0 * r * (m + n) + pi * r * r) + slab * m * n + disc * (m + n) + ball
    };
    let [x, y, z] = [0, 1, 2].map(second);
    let exact = sorted([y + z, z + x, x + y]);
    let found = sorted(round.bulk().moments);
    assert!((0..3).all(|k| (found[k] / exact[k] - 1.0).abs() < 1e-13), "{found:?} {exact:?}");
}

/// Each moment is that about its own axis, from bodies of a metre down to a millimetre, also where two moments are equal and their axes any: Σ I_k a_k a_k is the tensor of the box in
/// the frame of the points, turned.
#[test]
fn moments_belong_to_their_axes() {
    for (size, turned) in [1.0, 0.03, 1e-3].into_iter().flat_map(|size| [(size, 0.0), (size, 0.4)]) {
        for half in
            [[0.5, 1.0, 2.0], [1.0, 1.0, 2.0], [0.5, 1.0, 1.0], [1.0, 1.0, 1.0]].map(|half: [f64; 3]| half.map(|h| size * h))
        {
            let (s, c) = f64::sin_cos(turned);
            // two turns about two axes
            let turn = |[x, y, z]: [f64; 3]| {
                let (x, y) = (c * x - s * y, s * x + c * y);
                [x, c * y - s * z, s * y + c * z]
            };
            let points: Vec<[f64; 3]> = corners(half).into_iter().map(turn).collect();
            let placed = Polyhedron::hull(&points, 0.0).expect("a hull");
            let tensor = |moments: [f64; 3], axes: [[f64; 3]; 3], i: usize, j: usize| {
                (0..3).map(|k| moments[k] * axes[k][i] * axes[k][j]).sum::<f64>()
            };
            let (exact, found) = (Cuboid { half }.bulk().moments, placed.polyhedron.bulk().moments);
            let sides = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(turn);
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let off = tensor(found, placed.axes, i, j) - tensor(exact, sides, i, j);
                assert!(off.abs() < 1e-12 * exact[0].max(exact[1]), "{half:?} {turned}: {off:e} of {exact:?}");
            }
        }
    }
}

/// A corner of the hull within is inside by the rounding, also where the two triangles of a flat face do not agree on which side it is. One once lay a metre outside.
#[test]
fn corners_lie_inside_by_the_rounding() {
    let skew = |[x, y, z]: [f64; 3]| [1.3 * x + 0.2 * y, y - 0.1 * z * x, 0.7 * z + 0.1 * x];
    let points: Vec<[f64; 3]> = corners([1.0; 3]).into_iter().map(skew).collect();
    let rock = Polyhedron::hull(&points, 0.05).expect("a hull").polyhedron;
    for corner in &rock.rounded_hull().corners {
        assert!((rock.nearest(*corner).distance + 0.05).abs() < 1e-12, "{corner:?}: {:?}", rock.nearest(*corner));
    }
}

/// A rounded polyhedron is its inner one, nearer by the radius.
#[test]
fn rounding_moves_the_surface_out() {
    let (sharp, round) = (rock(0.0), rock(0.15));
    for at in [[2.0, 0.3, 0.1], [-0.5, -0.6, -0.7], [0.5, 0.5, 2.0], [0.5, -1.0, 0.4]] {
        let of = |p: &Placed| {
            let d = less(at, p.centre);
            p.polyhedron.nearest(p.axes.map(|axis| dot(axis, d))).distance
        };
        assert!((of(&sharp) - of(&round) - 0.15).abs() < 1e-12);
    }
}

#[test]
fn flat_points_are_no_polyhedron() {
    let flat = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.4, 0.4, 0.0]];
    let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
    for points in [&flat[..], &line[..], &[[0.0; 3]; 4][..]] {
        let told = Polyhedron::hull(points, 0.0).expect_err("refused");
        assert!(told.contains("no convex hull with a volume"), "{told}");
    }
}
