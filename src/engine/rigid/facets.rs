//! Where a superquadric touches a body of several facets: a sheet of triangles or a compound.
//!
//! About the place of its core that is nearest to a facet the superquadric is a sphere ([`crate::shape::Smooth`]), which meets the facet as a corner or a grain does. Each facet is a contact of its own.

use super::contact::PosedBlock;
use super::pair::{Meeting, Outline, sphere_on};
use crate::shape::{Core, Rounded, Seen, Smooth};

/// A superquadric and a body of facets.
struct Beside<'a> {
    smooth: &'a Smooth,
    of: &'a PosedBlock<'a>,
    on: &'a PosedBlock<'a>,
    facets: &'a Rounded,
    /// Whether the superquadric is the first of the two.
    is_first: bool,
}

impl<'a> Beside<'a> {
    /// The two, if one is a superquadric and the other is not convex.
    fn find(first: &'a PosedBlock<'a>, second: &'a PosedBlock<'a>) -> Option<Beside<'a>> {
        let (Some(Outline { body: a, .. }), Some(Outline { body: b, .. })) = (first.outline, second.outline) else { return None };
        match (a.smooth(), b.smooth()) {
            (Some(smooth), None) if !b.is_convex() => Some(Beside { smooth, of: first, on: second, facets: b, is_first: true }),
            (None, Some(smooth)) if !a.is_convex() => Some(Beside { smooth, of: second, on: first, facets: a, is_first: false }),
            _ => None,
        }
    }

    /// Calls `look` with the core of the superquadric in the frame of the other body.
    fn with_core<T>(&self, look: impl FnOnce(&Core<'_>) -> T) -> T {
        let Beside { smooth, of, on, .. } = self;
        let furthest = |towards: [f64; 3]| {
            let local = smooth.core(of.pose.inwards(on.pose.outwards(towards)));
            on.pose.within(of.pose.place(local))
        };
        look(&Core::new(on.pose.within(of.pose.centre), smooth.reach - smooth.rounding, &furthest))
    }
}

/// Whether one of two bodies is a superquadric and the other has facets.
pub(super) fn are(first: &PosedBlock<'_>, second: &PosedBlock<'_>) -> bool {
    Beside::find(first, second).is_some()
}

/// The two at facet `facet`, if they are such bodies: as [`super::pair::meeting`].
pub(super) fn meeting(first: &PosedBlock<'_>, second: &PosedBlock<'_>, facet: u32, gap: f64) -> Option<Meeting> {
    let beside = Beside::find(first, second)?;
    let Beside { smooth, on, facets, is_first, .. } = &beside;
    let radius = smooth.rounding;
    let met = beside.with_core(|core| facets.meet_core(facet, core, radius + gap))?;
    let overlap = |seen: &Seen| sphere_on(on, &seen.nearest, (on.pose.place(seen.at), radius), *is_first);
    let borders = met.borders.iter().map(|(other, border)| (*other, overlap(border))).collect();
    Some(Meeting { overlap: overlap(&met.on), ends: None, borders })
}

/// The facets that are nearer than `skin`, m, to the superquadric, if they are such bodies.
pub(super) fn near(first: &PosedBlock<'_>, second: &PosedBlock<'_>, skin: f64) -> Vec<u32> {
    let Some(beside) = Beside::find(first, second) else { return Vec::new() };
    let within = beside.smooth.rounding + skin;
    beside.with_core(|core| {
        let about = beside.facets.facets_about(core, within);
        about.into_iter().filter(|facet| beside.facets.near_core(*facet, core, within).is_some()).collect()
    })
}

/// The place of the superquadric's core that is nearest to facet `facet`, in the frame of the body of facets, and the radius of the sphere about it, m, with that body.
pub(super) fn place_on<'a>(
    first: &'a PosedBlock<'a>,
    second: &'a PosedBlock<'a>,
    facet: u32,
) -> Option<(&'a PosedBlock<'a>, [f64; 3], f64)> {
    let beside = Beside::find(first, second)?;
    let radius = beside.smooth.rounding;
    // a contact may end some way beyond its reach
    let seen = beside.with_core(|core| beside.facets.near_core(facet, core, 2.0 * radius))?;
    Some((beside.on, seen.at, radius))
}

#[cfg(test)]
mod tests {
    use super::super::Block;
    use super::super::motion::about;
    use super::super::pair::sites;
    use super::*;
    use crate::math::vector::{dot, less};
    use crate::shape::{Compound, Frame, Piece, Shape, Sheet, Superquadric};
    use proptest::prelude::*;

    /// A valley, a ridge and a wall of two triangles each, along y.
    fn sheet() -> Block {
        let profile = [[-2.0, 0.5], [-1.0, 0.0], [0.0, 0.1], [1.0, -0.4], [1.2, 1.0]];
        let vertices: Vec<[f64; 3]> = profile.iter().flat_map(|[x, z]| [-1.5, 1.5].map(|y| [*x, y, *z])).collect();
        let triangles: Vec<[u32; 3]> =
            (0..4).flat_map(|k| [[2 * k, 2 * k + 1, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 2]]).collect();
        Block::new(Shape::Mesh(Sheet::of(&vertices, &triangles, 0.05).expect("a sheet")), 1.0, 0)
    }

    /// Three rounded boxes: two side by side, the second of which goes on below, and one that stands on the first at a shallow angle.
    fn compound() -> Block {
        let hull = |low: [f64; 3], high: [f64; 3], angle: f64| {
            let corner = |k: usize| [0, 1, 2].map(|a| if k >> a & 1 == 1 { high[a] } else { low[a] });
            let (sine, cosine) = angle.sin_cos();
            let axes = [[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]];
            let points: Vec<[f64; 3]> = (0..8).map(corner).collect();
            Piece::polyhedron(&points, 0.05, Frame { origin: [0.0; 3], axes }).expect("a hull")
        };
        let parts = [
            hull([-1.5, -1.0, -0.6], [0.0, 1.0, 0.0], 0.0),
            hull([0.0, -1.0, -1.0], [1.5, 1.0, 0.0], 0.0),
            hull([-1.4, -0.9, -0.3], [1.4, 0.9, 0.1], 0.15),
        ];
        Block::new(Shape::Compound(Box::new(Compound::of(&parts).expect("a compound").compound)), 1.0, 0)
    }

    fn round(shape: [f64; 3], blockiness: [f64; 2], at: [f64; 3]) -> Block {
        Block { centre: at, ..Block::new(Shape::Superquadric(Superquadric { half: shape, blockiness }), 1.0, 0) }
    }

    /// Looks at two bodies, the second of which is at the first place of the pair with `swapped`.
    fn look<T>(body: &Block, egg: &Block, swapped: bool, look: impl FnOnce(&PosedBlock<'_>, &PosedBlock<'_>) -> T) -> T {
        let [a, b] = if swapped { [egg, body] } else { [body, egg] };
        let outlines = [a, b].map(Outline::of);
        look(&PosedBlock::new(a, Some(&outlines[0]), 0.0), &PosedBlock::new(b, Some(&outlines[1]), 0.0))
    }

    proptest! {
        /// A round superquadric meets each facet of a sheet and each part of a compound as a sphere does: it acts at the same facets, with the same overlap and normal, beside the same borders.
        #[test]
        fn a_round_superquadric_meets_facets_as_a_sphere_does(
            at in [-2.2..1.7_f64, -1.7..1.7_f64, -1.2..1.2_f64],
            turn in -3.0..3.0_f64,
            (on_sheet, swapped) in (any::<bool>(), any::<bool>()),
        ) {
            let mut body = if on_sheet { sheet() } else { compound() };
            (body.turn, body.centre) = (about([0.3, -0.2, 0.9], turn), [0.3, 0.1, -0.2]);
            let radius = 0.3;
            // in a part the nearest point is not asked for
            prop_assume!(body.solid().nearest(at).distance > 0.0);
            let pose = body.pose(0.0);
            let ball = round([radius; 3], [2.0; 2], pose.place(at));
            let (shape, facets) = (body.shape.rounded(), body.solid().facets());
            look(&body, &ball, swapped, |a, b| {
                let found = sites(a, b, 0.0);
                for facet in 0..facets as u32 {
                    let sphere = shape.meet(facet, at, radius).filter(|met| met.nearest.distance < radius);
                    let met = meeting(a, b, facet, 0.0).filter(|met| met.overlap.depth > 0.0);
                    prop_assert_eq!(sphere.is_some(), met.is_some(), "facet {}: {:?} {:?}", facet, sphere, met);
                    let (Some(sphere), Some(met)) = (sphere, met) else { continue };
                    prop_assert!(found.contains(&(super::super::Site::Nearest, facet)));
                    let same = |nearest: &crate::shape::Nearest, overlap: &super::super::pair::Overlap| {
                        let out = pose.outwards(nearest.normal);
                        let normal = if swapped { overlap.normal.map(|x| -x) } else { overlap.normal };
                        let aside = less(out, normal);
                        (radius - nearest.distance - overlap.depth).abs() < 1e-12 && dot(aside, aside) < 1e-20
                    };
                    prop_assert!(same(&sphere.nearest, &met.overlap), "facet {}: {:?} {:?}", facet, sphere, met);
                    prop_assert_eq!(sphere.borders.len(), met.borders.len(), "facet {}: {:?} {:?}", facet, sphere, met);
                    for ((k, border), (l, other)) in sphere.borders.iter().zip(&met.borders) {
                        prop_assert!(k == l && same(border, other), "facet {}: {:?} {:?}", facet, sphere, met);
                    }
                }
                Ok(())
            })?;
        }
    }

    /// The overlap of an ellipsoid with a facet, a part and an edge is that of its support function, and one that is cut is known to be so.
    #[test]
    fn ellipsoids_overlap_facets_as_closed_forms_say() {
        let half = [0.3, 0.2, 0.15];
        for angle in [0.0, 0.2, 0.7, 1.3] {
            let high = f64::hypot(half[0] * f64::sin(angle), half[2] * f64::cos(angle));
            let mut egg = round(half, [2.0; 2], [0.6, 0.1, high - 1e-3]);
            egg.turn = about([0.0, 1.0, 0.0], angle);
            let flat = Sheet::of(&[[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0]], &[[0, 1, 2]], 0.0).expect("a triangle");
            let floor = Block::new(Shape::Mesh(flat), 1.0, 0);
            assert!((floor.overlap(&egg) - 1e-3).abs() < 1e-12 && (egg.overlap(&floor) - 1e-3).abs() < 1e-12);
            egg.centre[2] = 0.05;
            assert!(floor.overlap(&egg) == f64::INFINITY && egg.overlap(&floor) == f64::INFINITY);
            egg.centre[2] = high + 1e-6;
            assert!(floor.overlap(&egg) < 0.0);
        }
        let mut egg = round(half, [2.0; 2], [0.0, 0.0, 2.0]);
        let rock = compound();
        assert!(rock.overlap(&egg) < 0.0);
        egg.centre = rock.centre;
        assert_eq!(rock.overlap(&egg), f64::INFINITY);
        assert_eq!(egg.overlap(&rock), f64::INFINITY);
    }
}
