//! The parts of a compound as bodies of their own: convex, free of each other, and inside of the compound.
//!
//! Parts are taken by size, the largest first. Two that overlap are cut along one plane, of which each keeps what lies on its side: halfway between both, across the line through their
//! centres, or a face of one of them, whichever leaves most. Where a part goes through another one, so that every plane would lose a part of it, it is cut into what lies beyond the faces of
//! the other one instead, which stays whole. Cuts are those of [`super::super::cut`]: the pieces touch in the plane, and their edges there are round.

use super::{Compound, Convex, touch};
use crate::math::vector::{dot, less, scaled};
use crate::shape::{Fragment, Rounded, Solid};

/// Smallest share of a part that becomes a piece where it is cut into several, and that must be lost for this.
const LEAST: f64 = 0.05;
/// Over the reach of the compound: parts that overlap by less than this touch.
const HAIR: f64 = 1e-9;
/// Share of both by which a plane must leave more than those before it to be taken.
const MORE: f64 = 1e-6;
/// Normals that differ by less than this belong to one flat face.
const FLAT: f64 = 1e-6;

/// A plane: unit normal, and distance from the origin along that, m.
type Plane = ([f64; 3], f64);

impl Compound {
    /// Its parts as bodies of their own, in its frame: by size but for what cuts take, pieces of one part one after the other. What is covered by larger parts is left out.
    pub fn fragments(&self) -> Vec<Fragment> {
        let mut parts: Vec<Fragment> = (0..self.parts()).filter_map(|k| self.fragment(k)).collect();
        parts.sort_by(|p, q| q.volume().total_cmp(&p.volume()));
        let hair = HAIR * self.reach();
        // what is free so far, with the number of the part that it is of
        let mut free: Vec<(usize, Fragment)> = Vec::new();
        for (k, part) in parts.iter().enumerate() {
            let mut pieces = vec![part.clone()];
            for (of, other) in &mut free {
                let between = halfway(&parts[*of], part);
                let mut left = Vec::new();
                for piece in pieces {
                    let (cut, rest) = freed(other, piece, between, hair);
                    *other = cut;
                    left.extend(rest);
                }
                pieces = left;
            }
            free.extend(pieces.into_iter().map(|piece| (k, piece)));
        }
        free.into_iter().map(|(_, piece)| piece).collect()
    }

    /// A part by itself, as other bodies touch it: sides of boxes do not go on into others.
    fn fragment(&self, k: usize) -> Option<Fragment> {
        let r = self.rounded_union().parts[k].rounding();
        match &self.surface.parts[k].surface {
            Convex::Hull(hull) if r > hull.rounding => Fragment::of_hull(&drawn_in(&hull.corners, r), r),
            Convex::Hull(hull) => Fragment::of_hull(&hull.corners, r),
            Convex::Ring(ring) => Fragment::of_ring(&ring.corners, r),
        }
    }
}

/// The corners of a box with sharp edges, m, each `r` further inside from its three faces. Corner k lies at the far end of axis a where bit a of k is 1.
fn drawn_in(corners: &[[f64; 3]], r: f64) -> Vec<[f64; 3]> {
    let axes = [1, 2, 4].map(|far: usize| {
        let along = less(corners[far], corners[0]);
        scaled(along, r / dot(along, along).sqrt())
    });
    let of = |(k, corner): (usize, &[f64; 3])| {
        let inwards = |p: [f64; 3], a: usize| less(p, scaled(axes[a], if k >> a & 1 == 1 { 1.0 } else { -1.0 }));
        (0..3).fold(*corner, inwards)
    };
    corners.iter().enumerate().map(of).collect()
}

/// Cuts two parts free of each other, the first the larger one, `between` the plane halfway between both as they were: what is left of the first, and the pieces of the second.
fn freed(first: &Fragment, second: Fragment, between: Option<Plane>, hair: f64) -> (Fragment, Vec<Fragment>) {
    if !overlap(first, &second, hair) {
        return (first.clone(), vec![second]);
    }
    let against = |(n, offset): Plane| (scaled(n, -1.0), -offset);
    let beyond = |of: &Fragment, (n, offset): Plane| of.clone().beyond(n, offset);
    let halves = between.map(|plane| (beyond(first, against(plane)), beyond(&second, plane)));
    let first_stays = faces(first).into_iter().map(|face| (Some(first.clone()), beyond(&second, face)));
    let second_stays = faces(&second).into_iter().map(|face| (beyond(first, face), Some(second.clone())));
    let (mut best, mut most) = (None, 0.0);
    for sides in halves.into_iter().chain(first_stays).chain(second_stays) {
        let (Some(p), Some(q)) = sides else { continue };
        let kept = p.volume() + q.volume();
        if kept > most + MORE * (first.volume() + second.volume()) {
            (best, most) = (Some((p, vec![q])), kept);
        }
    }
    let pieces = around(&second, &faces(first));
    let kept = pieces.iter().fold(first.volume(), |sum, piece| sum + piece.volume());
    match best {
        Some(best) if kept <= most + LEAST * second.volume() => best,
        _ => (first.clone(), pieces),
    }
}

/// Whether two parts overlap by more than a hair, m.
pub(super) fn overlap(first: &Fragment, second: &Fragment, hair: f64) -> bool {
    let parts = |of: &Fragment| of.shape.rounded().parts().iter().map(|part| part.moved(|p| of.place(p))).collect::<Vec<_>>();
    let seconds = parts(second);
    parts(first).iter().any(|p| seconds.iter().any(|q| touch(p, q, -hair)))
}

/// What of a part lies beyond the faces of another one: the largest piece beyond one face, then of the rest the largest beyond another one, and so on.
fn around(part: &Fragment, faces: &[Plane]) -> Vec<Fragment> {
    let (mut rest, mut pieces) = (Some(part.clone()), Vec::new());
    while let Some(left) = rest {
        let beyond = |&(n, offset): &Plane| Some(((n, offset), left.clone().beyond(n, offset)?));
        let large = |(_, piece): &(Plane, Fragment)| piece.volume() >= LEAST * part.volume();
        let larger = |p: (Plane, Fragment), q: (Plane, Fragment)| if q.1.volume() > p.1.volume() { q } else { p };
        let Some(((n, offset), piece)) = faces.iter().filter_map(beyond).filter(large).reduce(larger) else { break };
        pieces.push(piece);
        rest = left.beyond(scaled(n, -1.0), -offset);
    }
    pieces
}

/// The plane halfway between two parts, across the line from the centre of the first to that of the second; `None` where the centres are one.
fn halfway(first: &Fragment, second: &Fragment) -> Option<Plane> {
    let along = less(second.centre, first.centre);
    let length = dot(along, along).sqrt();
    if length <= HAIR * first.shape.solid().reach() {
        return None;
    }
    let n = scaled(along, 1.0 / length);
    Some((n, 0.5 * (furthest(first, n) - furthest(second, scaled(n, -1.0)))))
}

/// How far a part reaches along a unit vector, m.
fn furthest(part: &Fragment, n: [f64; 3]) -> f64 {
    let (rounded, own) = (part.shape.rounded(), part.axes.map(|axis| dot(axis, n)));
    let corners = rounded.corners().iter().map(|p| dot(*p, own));
    corners.fold(f64::NEG_INFINITY, f64::max) + rounded.rounding() + dot(part.centre, n)
}

/// The planes of the flat faces of a part, with normals out of it.
fn faces(part: &Fragment) -> Vec<Plane> {
    let own: Vec<Plane> = match part.shape.rounded() {
        Rounded::Hull(hull) => hull.faces.iter().map(|face| (face.normal, face.offset + hull.rounding)).collect(),
        Rounded::Ring(ring) => ring.sides().map(|([p, _], n)| (n, dot(n, p) + ring.rounding)).collect(),
        Rounded::Sheet(..) | Rounded::Union(_) | Rounded::Smooth(_) => Vec::new(),
    };
    let mut found: Vec<Plane> = Vec::new();
    for (n, offset) in own {
        let n = part.outwards(n);
        let other = |(m, _): &Plane| {
            let apart = less(n, *m);
            dot(apart, apart) > FLAT * FLAT
        };
        if found.iter().all(other) {
            found.push((n, offset + dot(part.centre, n)));
        }
    }
    found
}
