//! How far bodies have moved. Two bodies with a gap between the places that may touch need no look before they have moved by as much; what is not looked at changes no bit of a result.

use super::Pose;
use super::contact::PosedBlock;
use super::pair::{Site, gap};
use crate::math::vector::{dot, less};

/// Share of the reach of a body by which gaps are taken to be smaller, for rounding.
pub(super) const HAIR: f64 = 1e-9;

/// How bodies have moved between the last two looks. It is not saved: a run that is continued looks at all contacts first.
#[derive(Clone, Debug, Default)]
pub(super) struct Ways {
    /// Pose of each body at the last look.
    poses: Vec<Pose>,
    /// What each of them has moved by since the look before.
    moves: Vec<Move>,
}

/// What a body has moved by.
#[derive(Clone, Copy, Debug, Default)]
struct Move {
    /// Way of its centre, m.
    by: [f64; 3],
    /// Bound on what its rotation has moved any of its places by, m.
    turned: f64,
}

impl Move {
    /// Of a body of this reach, m, from one pose to another. A rotation by θ moves a place by 2 sin(θ/2) times its distance from the axis at most, and the three axes of the body by
    /// √8 sin(θ/2), as the root of the sum of squares.
    fn between(from: &Pose, to: &Pose, reach: f64) -> Move {
        let turned: f64 = from.axes.iter().zip(&to.axes).map(|(a, b)| less(*b, *a)).map(|d| dot(d, d)).sum();
        // a hair for rounding
        Move { by: less(to.centre, from.centre), turned: (1.0 + HAIR) * reach * (0.5 * turned).sqrt() }
    }
}

impl Ways {
    /// Memory in use, bytes.
    pub fn bytes(&self) -> usize {
        size_of::<Pose>() * self.poses.capacity() + size_of::<Move>() * self.moves.capacity()
    }

    /// Bound on how much nearer any places of two bodies have come to each other between the last two looks, m.
    pub fn between(&self, bodies: [u32; 2]) -> f64 {
        let [a, b] = bodies.map(|k| &self.moves[k as usize]);
        let by = less(a.by, b.by);
        dot(by, by).sqrt() + a.turned + b.turned
    }

    /// Notes where the bodies are now, and returns whether any has moved.
    pub fn follow(&mut self, bodies: &[PosedBlock<'_>]) -> bool {
        if self.poses.len() != bodies.len() {
            self.poses = bodies.iter().map(|body| body.pose).collect();
            self.moves = vec![Move::default(); bodies.len()];
            return false;
        }
        let mut any = false;
        for ((body, pose), moved) in bodies.iter().zip(&mut self.poses).zip(&mut self.moves) {
            if *pose == body.pose {
                *moved = Move::default();
            } else {
                *moved = Move::between(pose, &body.pose, body.block.solid().reach());
                *pose = body.pose;
                any = true;
            }
        }
        any
    }
}

/// A bound below on the gap between two bodies at a site that does not touch, m, less what rounding may make of it; 0 where none is known.
pub(super) fn gap_at([first, second]: [&PosedBlock<'_>; 2], site: Site) -> f64 {
    let reach = first.block.solid().reach() + second.block.solid().reach();
    gap(first, second, site).map_or(0.0, |gap| (gap - HAIR * reach).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::super::Block;
    use super::super::motion::about;
    use super::super::pair::{Outline, meeting, sites};
    use super::*;
    use crate::math::vector::scaled;
    use crate::shape::{Cuboid, Polyhedron, Shape};
    use proptest::prelude::*;

    fn unit(v: [f64; 3]) -> [f64; 3] {
        scaled(v, 1.0 / dot(v, v).sqrt())
    }

    fn direction() -> impl Strategy<Value = [f64; 3]> {
        [-1.0..1.0, -1.0..1.0, -1.0..1.0_f64].prop_filter("a direction", |v| dot(*v, *v) > 0.01).prop_map(unit)
    }

    /// A rock and a box, the second somewhere beside the first.
    fn bodies(turns: [([f64; 3], f64); 2], away: [f64; 3]) -> [Block; 2] {
        let corners = [[1.0, 0.1, -0.2], [-0.9, 0.4, 0.1], [0.2, 1.1, 0.3], [0.1, -0.8, 0.4], [0.0, 0.2, 0.9], [0.3, -0.1, -1.0]];
        let rock = Polyhedron::hull(&corners, 0.1).expect("a hull").polyhedron;
        let mut both =
            [Block::new(Shape::Polyhedron(rock), 1.0, 0), Block::new(Shape::Box(Cuboid { half: [0.6, 0.4, 0.8] }), 1.0, 0)];
        for (block, (axis, angle)) in both.iter_mut().zip(turns) {
            block.turn = about(axis, angle);
        }
        both[1].centre = away;
        both
    }

    proptest! {
        /// No gap is taken to be larger than it is, at any site that is found; and while the bodies move by less than it nothing touches there.
        #[test]
        fn nothing_touches_in_its_sleep(
            (first, second, to) in (direction(), direction(), direction()),
            (turn, other, length) in (-3.0..3.0_f64, -3.0..3.0_f64, 0.8..2.6_f64),
            (way, spin, angle, share) in (direction(), direction(), -0.5..0.5_f64, 0.05..1.0_f64),
        ) {
            let both = bodies([(first, turn), (second, other)], scaled(to, length));
            let outlines = both.each_ref().map(Outline::of);
            let posed = |both: &[Block; 2]| [0, 1].map(|k| PosedBlock::new(&both[k], Some(&outlines[k]), 0.0).pose);
            let body = |both, k: usize, pose| PosedBlock { pose, ..PosedBlock::new(both, Some(&outlines[k]), 0.0) };
            let poses = posed(&both);
            let [a, b] = [body(&both[0], 0, poses[0]), body(&both[1], 1, poses[1])];
            let mut moved = both.clone();
            moved[1].shift(scaled(way, 0.3 * share), scaled(spin, angle * share));
            let reach = both[1].solid().reach();
            let Move { by, turned } = Move::between(&poses[1], &posed(&moved)[1], reach);
            let by = dot(by, by).sqrt() + turned;
            let c = body(&moved[1], 1, posed(&moved)[1]);
            for (site, facet) in sites(&a, &b, 1.0) {
                let Some(gap) = gap(&a, &b, site) else { continue };
                if let Some(found) = meeting(&a, &b, (site, facet), None, 10.0) {
                    prop_assert!(gap <= 1e-12 - found.overlap.depth, "{site:?}: {gap} {}", found.overlap.depth);
                }
                if by < gap - 1e-12 {
                    let touches = meeting(&a, &c, (site, facet), None, 0.0).is_some_and(|m| m.overlap.depth > 0.0);
                    prop_assert!(!touches, "{site:?}: {gap} {by}");
                }
            }
            // and the way is that of the furthest of its places, at least
            for corner in outlines[1].body.corners() {
                let gone = less(moved[1].pose(0.0).place(*corner), poses[1].place(*corner));
                prop_assert!(dot(gone, gone).sqrt() <= by * (1.0 + 1e-12));
            }
        }
    }
}
