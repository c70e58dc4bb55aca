//! Compounds against closed forms: mass, surface, corners and edges.

use super::*;
use crate::shape::Shape;

const HERE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn cuboid(low: [f64; 3], high: [f64; 3]) -> Piece {
    let half = std::array::from_fn(|a| 0.5 * (high[a] - low[a]));
    let origin = std::array::from_fn(|a| 0.5 * (high[a] + low[a]));
    Piece::cuboid(Cuboid { half }, Frame { origin, axes: HERE })
}

fn polygon(corners: &[[f64; 2]], rounding: f64) -> Piece {
    Piece::polygon(corners, rounding, Frame { origin: [0.0; 3], axes: HERE }).expect("a polygon")
}

fn polyhedron(low: [f64; 3], high: [f64; 3], rounding: f64) -> Piece {
    let points: Vec<[f64; 3]> = (0..8).map(|k| std::array::from_fn(|a| if k >> a & 1 == 1 { high[a] } else { low[a] })).collect();
    Piece::polyhedron(&points, rounding, Frame { origin: [0.0; 3], axes: HERE }).expect("a polyhedron")
}

fn whole(pieces: &[Piece]) -> PlacedCompound {
    Compound::of(pieces).unwrap_or_else(|e| panic!("{e}"))
}

fn sorted(mut moments: [f64; 3]) -> [f64; 3] {
    moments.sort_by(f64::total_cmp);
    moments
}

/// Asserts volume, centre and moments, each within a share of its size.
fn same(found: &PlacedCompound, volume: f64, centre: [f64; 3], moments: [f64; 3], share: f64) {
    let bulk = found.compound.bulk();
    let size = found.compound.reach();
    assert!((bulk.volume / volume - 1.0).abs() < share, "{} {volume}: {:e}", bulk.volume, bulk.volume / volume - 1.0);
    let off = less(found.centre, centre);
    assert!(dot(off, off).sqrt() < share * size, "{:?} {centre:?}", found.centre);
    let (a, b) = (sorted(bulk.moments), sorted(moments));
    assert!((0..3).all(|k| (a[k] / b[k] - 1.0).abs() < share), "{a:?} {b:?}: {:e}", a[0] / b[0] - 1.0);
}

/// Moments of boxes, each with a sign, about their common centre: volume, centre and the moments if the axes are principal ones.
fn boxes(list: &[([f64; 3], [f64; 3], f64)]) -> (f64, [f64; 3], [[f64; 3]; 3]) {
    let (mut volume, mut first, mut second) = (0.0, [0.0; 3], [[0.0; 3]; 3]);
    for (low, high, sign) in list {
        let size: [f64; 3] = std::array::from_fn(|a| high[a] - low[a]);
        let middle: [f64; 3] = std::array::from_fn(|a| 0.5 * (high[a] + low[a]));
        let v = sign * size[0] * size[1] * size[2];
        volume += v;
        for a in 0..3 {
            first[a] += v * middle[a];
            for b in 0..3 {
                second[a][b] += v * (middle[a] * middle[b] + if a == b { size[a] * size[a] / 12.0 } else { 0.0 });
            }
        }
    }
    let centre = first.map(|x| x / volume);
    for a in 0..3 {
        for b in 0..3 {
            second[a][b] -= volume * centre[a] * centre[b];
        }
    }
    let trace = second[0][0] + second[1][1] + second[2][2];
    (volume, centre, std::array::from_fn(|a| std::array::from_fn(|b| if a == b { trace - second[a][a] } else { -second[a][b] })))
}

/// Boxes side by side, boxes that overlap, three that lie over each other, a ring of four and a cross: all exact.
#[test]
fn boxes_have_their_closed_forms() {
    // side by side: one box
    let two = whole(&[cuboid([0.0; 3], [1.0, 2.0, 3.0]), cuboid([1.0, 0.0, 0.0], [4.0, 2.0, 3.0])]);
    let one = Cuboid { half: [2.0, 1.0, 1.5] }.bulk();
    same(&two, one.volume, [2.0, 1.0, 1.5], one.moments, 1e-13);
    // a cross of two bars through each other
    let cross = whole(&[cuboid([-3.0, -1.0, -1.0], [3.0, 1.0, 1.0]), cuboid([-1.0, -3.0, -1.0], [1.0, 3.0, 1.0])]);
    let bars = [
        ([-3.0, -1.0, -1.0], [3.0, 1.0, 1.0], 1.0),
        ([-1.0, -3.0, -1.0], [1.0, 3.0, 1.0], 1.0),
        ([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0], -1.0),
    ];
    let (volume, centre, inertia) = boxes(&bars);
    same(&cross, volume, centre, [inertia[0][0], inertia[1][1], inertia[2][2]], 1e-13);
    // three bars along the axes: pairs and all three have a cube in common
    let jack = whole(&[
        cuboid([-3.0, -1.0, -1.0], [3.0, 1.0, 1.0]),
        cuboid([-1.0, -3.0, -1.0], [1.0, 3.0, 1.0]),
        cuboid([-1.0, -1.0, -3.0], [1.0, 1.0, 3.0]),
    ]);
    let arms = [
        ([-3.0, -1.0, -1.0], [3.0, 1.0, 1.0], 1.0),
        ([-1.0, -3.0, -1.0], [1.0, 3.0, 1.0], 1.0),
        ([-1.0, -1.0, -3.0], [1.0, 1.0, 3.0], 1.0),
        ([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0], -2.0),
    ];
    let (volume, centre, inertia) = boxes(&arms);
    same(&jack, volume, centre, [inertia[0][0], inertia[1][1], inertia[2][2]], 1e-13);
    // an L whose legs overlap; its axes are turned
    let corner = whole(&[cuboid([0.0; 3], [4.0, 1.0, 1.0]), cuboid([0.0; 3], [1.0, 3.0, 1.0])]);
    let (volume, centre, inertia) =
        boxes(&[([0.0; 3], [4.0, 1.0, 1.0], 1.0), ([0.0; 3], [1.0, 3.0, 1.0], 1.0), ([0.0; 3], [1.0; 3], -1.0)]);
    let (mean, half) = (0.5 * (inertia[0][0] + inertia[1][1]), 0.5 * (inertia[0][0] - inertia[1][1]));
    let away = (half * half + inertia[0][1] * inertia[0][1]).sqrt();
    same(&corner, volume, centre, [mean - away, mean + away, inertia[2][2]], 1e-13);
    // a turned box over another one, twice in the same way: the same bits
    let turned = Frame { origin: [0.3, 0.1, 0.2], axes: [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]] };
    let make = || whole(&[cuboid([-1.0; 3], [1.0; 3]), Piece::cuboid(Cuboid { half: [2.0, 0.3, 0.4] }, turned)]);
    assert_eq!(make(), make());
}

/// Halves of a rounded box whose hulls have a face in common are the whole; what is round overlaps, and is exact within 1e-5 of the body.
#[test]
fn halves_of_a_rounded_box_are_the_whole() {
    let r = 0.2;
    let whole_box = Polyhedron::hull(
        &(0..8).map(|k| [0, 1, 2].map(|a| if k >> a & 1 == 1 { [4.0, 2.0, 3.0][a] } else { 0.0 })).collect::<Vec<_>>(),
        r,
    )
    .expect("a box");
    let halves = whole(&[polyhedron([0.0; 3], [1.5, 2.0, 3.0], r), polyhedron([1.5, 0.0, 0.0], [4.0, 2.0, 3.0], r)]);
    let bulk = whole_box.polyhedron.bulk();
    println!("volume {:e}", halves.compound.bulk().volume / bulk.volume - 1.0);
    same(&halves, bulk.volume, [2.0, 1.0, 1.5], bulk.moments, 2e-5);
}

/// Polygons: an L of two rectangles that share a side, the same with legs that overlap, and two discs (lens).
#[test]
fn polygons_have_their_closed_forms() {
    let rectangle = |[x, y]: [f64; 2], [u, v]: [f64; 2], r: f64| polygon(&[[x, y], [u, y], [u, v], [x, v]], r);
    for legs in [
        [rectangle([0.0, 0.0], [4.0, 1.0], 0.0), rectangle([0.0, 1.0], [1.0, 3.0], 0.0)],
        [rectangle([0.0, 0.0], [4.0, 1.0], 0.0), rectangle([0.0, 0.0], [1.0, 3.0], 0.0)],
    ] {
        let (volume, centre, inertia) =
            boxes(&[([0.0, 0.0, -0.5], [4.0, 1.0, 0.5], 1.0), ([0.0, 1.0, -0.5], [1.0, 3.0, 0.5], 1.0)]);
        same(&whole(&legs), volume, [centre[0], centre[1], 0.0], [inertia[2][2]; 3], 1e-13);
    }
    // a rounded square of two halves
    let halves = whole(&[rectangle([0.0, 0.0], [0.7, 2.0], 0.3), rectangle([0.7, 0.0], [2.0, 2.0], 0.3)]);
    let square = Polygon::of(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], 0.3).expect("a square").0.bulk();
    println!("square {:e}", halves.compound.bulk().volume / square.volume - 1.0);
    same(&halves, square.volume, [1.0, 1.0, 0.0], square.moments, 1e-8);
    // two discs: the lens of height 2 h between them has 2 (r² acos(d/2r) − d h/2)
    let (r, d) = (1.0_f64, 1.2_f64);
    let discs = whole(&[polygon(&[[0.0, 0.0]], r), polygon(&[[d, 0.0]], r)]);
    let angle = (0.5 * d / r).acos();
    let h = (r * r - 0.25 * d * d).sqrt();
    let lens = 2.0 * (r * r * angle - 0.5 * d * h);
    let volume = 2.0 * PI * r * r - lens;
    // half of the lens: 2 ∫ (x − d/2)² √(r² − x²) dx and 2/3 ∫ (r² − x²)^{3/2} dx from d/2 to r, by Simpson's rule in the angle
    let (mut along, mut across) = (0.0, 0.0);
    let n = 2000;
    for k in 0..=n {
        let t = angle * f64::from(k) / f64::from(n);
        let weight = if k == 0 || k == n {
            1.0
        } else if k % 2 == 1 {
            4.0
        } else {
            2.0
        };
        let (s, c) = t.sin_cos();
        along += weight * 2.0 * (r * c - 0.5 * d).powi(2) * (r * s) * (r * s);
        across += weight * 2.0 / 3.0 * (r * s).powi(3) * (r * s);
    }
    let step = angle / f64::from(n) / 3.0;
    let polar = 2.0 * (0.5 * PI * r.powi(4) + PI * r * r * 0.25 * d * d) - 2.0 * (along + across) * step;
    println!("lens {:e}, polar {:e}", discs.compound.bulk().volume / volume - 1.0, discs.compound.bulk().moments[2] / polar - 1.0);
    same(&discs, volume, [0.5 * d, 0.0, 0.0], [polar; 3], 1e-8);
}

/// Corners and edges of a union are those that stick out: of two boxes in line those of the one box, of a cross twice twelve corners of its arms, of a kite its four.
#[test]
fn corners_and_edges_stick_out() {
    let near = |found: &PlacedCompound, union: &Union, at: [f64; 3]| {
        let own = found.axes.map(|axis| dot(axis, less(at, found.centre)));
        union.corners.iter().filter(|c| dot(less(**c, own), less(**c, own)).sqrt() < 1e-9).count()
    };
    let two = whole(&[cuboid([0.0; 3], [1.0, 2.0, 3.0]), cuboid([1.0, 0.0, 0.0], [4.0, 2.0, 3.0])]);
    assert_eq!((two.compound.spots(), two.compound.surface.edges().len()), (8, 12));
    let union = two.compound.rounded_union();
    assert_eq!((union.corners.len(), union.edges().len()), (8, 12));
    let r = union.roundings()[0];
    assert!((r - 0.025).abs() < 1e-15);
    for k in 0..8 {
        let at = std::array::from_fn(|a| if k >> a & 1 == 1 { [4.0, 2.0, 3.0][a] - r } else { r });
        assert_eq!(near(&two, union, at), 1, "{at:?}");
    }
    // the bars of a cross in one plane: four arms with two corners at each end and face, and edges that end in the other bar
    let cross = whole(&[cuboid([-3.0, -1.0, -1.0], [3.0, 1.0, 1.0]), cuboid([-1.0, -3.0, -1.0], [1.0, 3.0, 1.0])]);
    assert_eq!(cross.compound.spots(), 16);
    // each arm: four at its end, four along it
    assert_eq!(cross.compound.surface.edges().len(), 32);
    assert_eq!(cross.compound.rounded_union().edges().len(), 32);
    // an arm that stands in the middle of a plate
    let tee = whole(&[cuboid([-3.0, -3.0, 0.0], [3.0, 3.0, 1.0]), cuboid([-1.0, -1.0, 1.0], [1.0, 1.0, 4.0])]);
    assert_eq!((tee.compound.spots(), tee.compound.surface.edges().len()), (12, 20));
    assert_eq!(tee.compound.rounded_union().corners.len(), 12);
    // an L of two boxes of one width, which end on each other: one flat side of six corners
    let legs = whole(&[cuboid([0.0; 3], [1.0, 1.0, 4.0]), cuboid([1.0, 0.0, 0.0], [3.0, 1.0, 1.0])]);
    assert_eq!((legs.compound.spots(), legs.compound.rounded_union().corners.len()), (10, 10));
    let edges = legs.compound.rounded_union().edges();
    let mut lengths: Vec<f64> = edges.iter().map(|[p, q]| dot(less(*p, *q), less(*p, *q)).sqrt()).collect();
    lengths.sort_by(f64::total_cmp);
    println!("{lengths:?}");
    // along the bottom in one piece
    assert_eq!(lengths.iter().filter(|l| (**l - 2.95).abs() < 1e-9).count(), 2);
    // a kite of two triangles has four corners; a square of two triangles too
    for top in [[0.0, 1.0], [0.0, 3.0]] {
        let kite = whole(&[polygon(&[[-1.0, 0.0], [1.0, 0.0], top], 0.1), polygon(&[[-1.0, 0.0], [0.0, -1.0], [1.0, 0.0]], 0.1)]);
        assert_eq!(kite.compound.spots(), 4);
    }
    // a straight rod of two, and one with a knee
    let straight = whole(&[polygon(&[[-1.0, 0.0], [0.0, 0.0]], 0.1), polygon(&[[0.0, 0.0], [2.0, 0.0]], 0.1)]);
    assert_eq!(straight.compound.spots(), 2);
    let knee = whole(&[polygon(&[[-1.0, 0.0], [0.0, 0.0]], 0.1), polygon(&[[0.0, 0.0], [2.0, 0.5]], 0.1)]);
    assert_eq!(knee.compound.spots(), 3);
}

/// Over a flush joint a sphere has one contact at any place, at the distance that it has from one body; where it passes, history goes along.
#[test]
fn a_flush_joint_is_no_joint() {
    let (one, two) = (
        whole(&[cuboid([0.0; 3], [1.0, 2.0, 1.0]), cuboid([1.0, 0.0, 0.0], [3.0, 2.0, 1.0])]),
        whole(&[cuboid([0.0; 3], [2.0, 2.0, 1.0]), cuboid([1.0, 0.0, 0.0], [3.0, 2.0, 1.0])]),
    );
    for body in [&one, &two] {
        for union in [&body.compound.surface, body.compound.rounded_union()] {
            for k in 0..400 {
                let x = 0.5 + 0.005 * f64::from(k);
                for y in [0.7, 1.0, 1.93] {
                    let at = body.axes.map(|axis| dot(axis, less([x, y, 1.1], body.centre)));
                    let met: Vec<Meet> = (0..2).filter_map(|facet| union.meet(facet, at, 0.2)).collect();
                    assert_eq!(met.len(), 1, "{x} {y}");
                    assert!(met[0].borders.is_empty() && (met[0].nearest.distance - 0.1).abs() < 1e-12, "{x} {y} {met:?}");
                }
            }
        }
    }
    let at = |x: f64| one.axes.map(|axis| dot(axis, less([x, 1.0, 1.1], one.centre)));
    assert!(one.compound.passes(0, 1, at(1.01), 0.2) && !one.compound.passes(0, 1, at(0.99), 0.2));
    assert!(one.compound.passes(1, 0, at(0.99), 0.2));
}

/// In a right inner corner a sphere touches both legs whole; in a shallow one what they have in common counts once, without a jump where the foot on one
/// leaves its face.
#[test]
fn an_inner_edge_has_what_both_parts_have_in_common_once() {
    let legs = whole(&[cuboid([-1.0, 0.0, 0.0], [0.0, 4.0, 4.0]), cuboid([-1.0, 0.0, -1.0], [4.0, 4.0, 0.0])]);
    let at = legs.axes.map(|axis| dot(axis, less([0.3, 2.0, 0.3], legs.centre)));
    let met: Vec<Meet> = (0..2).filter_map(|facet| legs.compound.meet(facet, at, 0.31)).collect();
    assert_eq!(met.len(), 2);
    assert!(met.iter().all(|m| m.borders.is_empty() && (m.nearest.distance - 0.3).abs() < 1e-12), "{met:?}");
    // two half-planes that rise by 0.01 to both sides
    let slope = 0.01;
    let hollow = whole(&[
        polygon(&[[-5.0, -1.0], [0.5, -1.0], [0.5, -0.5 * slope], [-5.0, 5.0 * slope]], 0.0),
        polygon(&[[-0.5, -1.0], [5.0, -1.0], [5.0, 5.0 * slope], [-0.5, -0.5 * slope]], 0.0),
    ]);
    // the elastic energy of a spring, as the contact law shares it
    let radius = 1.0;
    let energy = |x: f64| {
        let at = less([x, 0.9995, 0.0], hollow.centre);
        let phi = |distance: f64| 0.5 * (radius - distance).max(0.0).powi(2);
        let met = (0..2).filter_map(|facet| hollow.compound.meet(facet, at, radius));
        met.map(|m| phi(m.nearest.distance) - m.borders.iter().map(|(_, b)| phi(b.distance)).sum::<f64>()).sum::<f64>()
    };
    let n = 4000;
    let values: Vec<f64> = (0..=n).map(|k| energy(-0.02 + 0.04 * f64::from(k) / f64::from(n))).collect();
    let most = values.iter().copied().fold(0.0, f64::max);
    let jump = values.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
    println!("energy {:e} at the crease, {most:e} at most; largest step {jump:e}", energy(0.0));
    assert!(jump < 2e-3 * most, "{jump:e} of {most:e}");
    // symmetric
    assert!((energy(0.007) / energy(-0.007) - 1.0).abs() < 1e-6);
}

#[test]
fn what_is_no_compound_is_refused() {
    let told = |pieces: &[Piece]| Compound::of(pieces).expect_err("refused");
    assert!(told(&[]).contains("2 to 100 parts; there are 0"));
    assert!(told(&[cuboid([0.0; 3], [1.0; 3])]).contains("there are 1"));
    let far = [cuboid([0.0; 3], [1.0; 3]), cuboid([0.5; 3], [1.5; 3]), cuboid([3.0; 3], [4.0; 3])];
    assert!(told(&far).contains("part 2 neither overlaps nor touches"));
    // bars that cross without a corner of one in the other hang together, discs that touch too
    whole(&[cuboid([-3.0, -1.0, 0.0], [3.0, 1.0, 1.0]), cuboid([-1.0, -3.0, 1.0], [1.0, 3.0, 2.0])]);
    whole(&[polygon(&[[0.0, 0.0]], 1.0), polygon(&[[3.0, 0.0]], 2.0)]);
    assert!(told(&[polygon(&[[0.0, 0.0]], 1.0), polygon(&[[3.01, 0.0]], 2.0)]).contains("hang together"));
    // twelve cubes over each other have too many sets
    let many: Vec<Piece> = (0..12).map(|k| cuboid([0.01 * f64::from(k); 3], [1.0 + 0.01 * f64::from(k); 3])).collect();
    assert!(told(&many).contains("too many lie over each other"), "{}", told(&many));
}

/// Discs of different size keep their own radii.
#[test]
fn a_snowman_has_two_radii() {
    let man = whole(&[polygon(&[[0.0, 0.0]], 0.02), polygon(&[[0.0, 0.03]], 0.015)]);
    let union = man.compound.rounded_union();
    assert_eq!(union.roundings(), [0.015, 0.02]);
    let top = man.compound.spot(1, [0.0, 1.0, 0.0]);
    assert!((top[1] + man.centre[1] - 0.045).abs() < 1e-15, "{top:?}");
    assert!(
        (Shape::Compound(Box::new(man.compound.clone())).radius().powi(2) * PI / man.compound.bulk().volume - 1.0).abs() < 1e-12
    );
}

/// Four tapered legs from one place, as `tests/blocks/compound.rs` has them.
fn tetrapod() -> PlacedCompound {
    let points: Vec<[f64; 3]> =
        [[-3.0, 12.0], [60.0, 8.0]].iter().flat_map(|[z, h]| [[-h, -h, *z], [*h, -h, *z], [-h, *h, *z], [*h, *h, *z]]).collect();
    // along z, and three times at the angle of a tetrahedron to it
    let (c, s) = (-1.0 / 3.0, 8.0_f64.sqrt() / 3.0);
    let turned = |[x, y]: [f64; 2]| {
        let along = [s * x, s * y, c];
        let across = [-y, x, 0.0];
        [cross(across, along), across, along]
    };
    let sides = [[1.0, 0.0], [-0.5, 0.75_f64.sqrt()], [-0.5, -(0.75_f64.sqrt())]].map(turned);
    let leg = |axes| Piece::polyhedron(&points, 4.0, Frame { origin: [0.0; 3], axes }).expect("a leg");
    whole(&[HERE].into_iter().chain(sides).map(leg).collect::<Vec<_>>())
}

/// Parts as bodies of their own fill the compound but for their edges, lie inside of it and do not overlap.
#[test]
fn parts_come_free_of_each_other() {
    let l = [cuboid([0.0, 0.0, 0.0], [50.0, 10.0, 10.0]), cuboid([0.0, 0.0, 0.0], [10.0, 10.0, 40.0])];
    // the stem goes into the bar, or stands on it
    let t = |low: f64| whole(&[cuboid([-5.0, -5.0, low], [5.0, 5.0, 60.0]), cuboid([-40.0, -5.0, -5.0], [40.0, 5.0, 5.0])]);
    let cross_of_bars = [cuboid([-60.0, -15.0, -15.0], [60.0, 15.0, 15.0]), cuboid([-15.0, -60.0, -15.0], [15.0, 60.0, 15.0])];
    let jack = [0, 1, 2].map(|a| {
        let half: [f64; 3] = std::array::from_fn(|b| if a == b { 50.0 } else { 10.0 });
        cuboid(half.map(|h| -h), half)
    });
    let u = [
        polyhedron([-50.0, -15.0, -20.0], [50.0, 15.0, 0.0], 4.0),
        polyhedron([-50.0, -15.0, 0.0], [-30.0, 15.0, 60.0], 4.0),
        polyhedron([30.0, -15.0, 0.0], [50.0, 15.0, 60.0], 4.0),
    ];
    let halves = [polyhedron([-40.0, -9.0, -9.0], [0.0, 9.0, 9.0], 1.0), polyhedron([0.0, -9.0, -9.0], [40.0, 9.0, 9.0], 1.0)];
    let hexagram =
        [polygon(&[[-35.0, -20.0], [35.0, -20.0], [0.0, 40.0]], 3.0), polygon(&[[-35.0, 20.0], [0.0, -40.0], [35.0, 20.0]], 3.0)];
    let arrow = [polygon(&[[0.0, 0.0], [60.0, -30.0], [20.0, 0.0]], 2.0), polygon(&[[0.0, 0.0], [20.0, 0.0], [60.0, 30.0]], 2.0)];
    let disc_beside = [polygon(&[[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0]], 1.0), polygon(&[[36.0, 10.0]], 15.0)];
    for (name, placed, count, most_lost) in [
        ("L", whole(&l), 2, 0.005),
        ("T, touching", t(5.0), 2, 0.005),
        ("T, into the bar", t(1.0), 2, 0.005),
        ("cross", whole(&cross_of_bars), 3, 0.005),
        ("jack", whole(&jack), 5, 0.005),
        ("tetrapod", tetrapod(), 4, 0.05),
        ("U", whole(&u), 3, 0.02),
        ("halves", whole(&halves), 2, 0.003),
        ("hexagram", whole(&hexagram), 4, 0.06),
        ("arrow", whole(&arrow), 2, 0.06),
        ("a disc beside a square", whole(&disc_beside), 2, 0.005),
    ] {
        let compound = &placed.compound;
        let (volume, reach) = (compound.bulk().volume, compound.reach());
        let parts = compound.fragments();
        let volumes: Vec<f64> = parts.iter().map(|part| part.volume()).collect();
        let lost = 1.0 - volumes.iter().sum::<f64>() / volume;
        println!("{name}: {} pieces, {lost:.5} lost, {volumes:?} of {volume}", parts.len());
        assert_eq!(parts.len(), count, "{name}");
        assert!(lost > -1e-9 && lost < most_lost, "{name}: {lost}");
        for (k, part) in parts.iter().enumerate() {
            assert!(parts[..k].iter().all(|other| !parting::overlap(part, other, 1e-9 * reach)), "{name}: {k}");
            let rounded = part.shape.rounded();
            let inside = |p: &[f64; 3]| compound.nearest(part.place(*p)).distance <= 1e-9 * reach - rounded.rounding();
            assert!(rounded.corners().iter().all(inside), "{name}: {k}");
        }
    }
    // two equal halves of a bar that share a face come out equal
    let [p, q] = whole(&halves).compound.fragments().try_into().expect("two");
    assert!((p.volume() / q.volume() - 1.0).abs() < 1e-12);
}
