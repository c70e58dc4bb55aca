//! Where bodies overlap, as geometry alone: for placing them.

use super::Blocks;
use super::contact::{PosedBlock, posed};
use super::motion::Yields;
use super::pair::{meeting, sites};
use crate::math::vector::{cross, dot, less, plus, scaled};

/// A place where a body is too near to another one, or to the side of a box.
#[derive(Clone, Copy, Debug)]
pub struct Lap {
    /// The body.
    pub block: usize,
    /// The other one; `None`: a side of the box.
    pub other: Option<usize>,
    /// Unit vector out of the body.
    pub normal: [f64; 3],
    /// Overlap, m, and the gap that was asked for.
    pub depth: f64,
    /// Where it is, m.
    pub at: [f64; 3],
}

/// Times that the laps of one geometry are gone through.
const SWEEPS: usize = 4;

impl Blocks {
    /// All places where bodies are nearer than `gap`, m, to each other or to the sides of the box between the two corners, m, along its first `axes` axes.
    pub fn laps(&mut self, [low, high]: [[f64; 3]; 2], axes: usize, gap: f64) -> Vec<Lap> {
        self.outline();
        let bodies = posed(&self.blocks, &self.outlines, 0.0);
        let mut laps = Vec::new();
        for [i, j] in self.near(gap) {
            for site in sites(&bodies[i], &bodies[j], gap) {
                let Some(overlap) = meeting(&bodies[i], &bodies[j], site, None, gap).map(|m| m.overlap) else { continue };
                let depth = overlap.depth + gap;
                if depth > 0.0 {
                    laps.push(Lap { block: i, other: Some(j), normal: overlap.normal, depth, at: overlap.at });
                }
            }
        }
        for (block, body) in bodies.iter().enumerate() {
            let (solid, pose, reach) = (body.block.solid(), &body.pose, body.block.solid().reach());
            for a in 0..axes {
                for (side, end) in [(-1.0, low[a]), (1.0, high[a])] {
                    if side * (pose.centre[a] - end) + reach + gap <= 0.0 {
                        continue;
                    }
                    let mut normal = [0.0; 3];
                    normal[a] = side;
                    let towards = pose.inwards(normal);
                    for spot in 0..solid.spots() {
                        let at = pose.place(solid.spot(spot, towards));
                        let depth = side * (at[a] - end) + gap;
                        if depth > 0.0 {
                            laps.push(Lap { block, other: None, normal, depth, at });
                        }
                    }
                }
            }
        }
        laps
    }

    /// Moves and turns bodies so far that the given overlaps are undone, as far as small motions go: each lap in turn pushes its two bodies apart, in
    /// proportion to how easily they give way.
    pub fn part(&mut self, laps: &[Lap]) {
        let mut moved = vec![[[0.0; 3]; 2]; self.blocks.len()];
        let bodies: Vec<PosedBlock<'_>> = self.blocks.iter().map(|block| PosedBlock::new(block, None, 0.0)).collect();
        // how far the place of a lap has moved along its normal
        let along = |moved: &[[f64; 3]; 2], arm: [f64; 3], normal: [f64; 3]| dot(normal, plus(moved[0], cross(moved[1], arm)));
        let ways: Vec<_> = laps
            .iter()
            .map(|lap| {
                let of = |k: usize| {
                    let arm = less(lap.at, bodies[k].pose.centre);
                    (k, arm, bodies[k].inverse_mass(arm, lap.normal))
                };
                (of(lap.block), lap.other.map(of))
            })
            .collect();
        for _ in 0..SWEEPS {
            for (lap, &(first, second)) in laps.iter().zip(&ways) {
                let sides = [(Some(first), -1.0), (second, 1.0)];
                let depth = sides.iter().fold(lap.depth, |depth, (side, sign)| {
                    depth - side.map_or(0.0, |(k, arm, _)| sign * along(&moved[k], arm, lap.normal))
                });
                let sum: f64 = sides.iter().filter_map(|(side, _)| side.map(|(_, _, w)| w)).sum();
                if depth <= 0.0 || sum <= 0.0 {
                    continue;
                }
                for (side, sign) in sides {
                    let Some((k, arm, _)) = side else { continue };
                    let push = scaled(lap.normal, sign * depth / sum);
                    let PosedBlock { block, pose, .. } = &bodies[k];
                    let Yields { inverse_mass: mass, inverse_moments: moments, .. } = block.yields();
                    let torque = pose.inwards(cross(arm, push));
                    let turn = pose.outwards(std::array::from_fn(|a| torque[a] * moments[a]));
                    moved[k] = [plus(moved[k][0], scaled(push, mass)), plus(moved[k][1], turn)];
                }
            }
        }
        for (block, [way, turn]) in self.blocks.iter_mut().zip(moved) {
            block.shift(way, turn);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Block;
    use super::*;
    use crate::shape::{Cuboid, Polygon, Shape};

    #[test]
    fn bodies_that_overlap_are_pushed_apart_about_their_common_centre_of_mass() {
        let square = Polygon::of(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]], 0.1).expect("a polygon").0;
        let mut blocks =
            Blocks::new(vec![Block::new(Shape::Polygon(square.clone()), 1.0, 0), Block::new(Shape::Polygon(square), 3.0, 0)]);
        blocks.blocks[1].centre = [2.15, 0.4, 0.0];
        let far = [[-9.0; 3], [9.0; 3]];
        let before = blocks.laps(far, 2, 0.0);
        assert!(before.iter().all(|lap| (lap.depth - 0.05).abs() < 1e-12), "{before:?}");
        for _ in 0..50 {
            let laps = blocks.laps(far, 2, 0.0);
            blocks.part(&laps);
        }
        assert!(blocks.laps(far, 2, 0.0).iter().all(|lap| lap.depth < 1e-6), "{:?}", blocks.laps(far, 2, 0.0));
        let moment: f64 = blocks.blocks.iter().map(|b| b.mass * b.centre[0]).sum();
        assert!((moment - blocks.blocks[1].mass * 2.15).abs() < 1e-9);
    }

    #[test]
    fn a_body_comes_back_into_its_box() {
        let mut blocks = Blocks::new(vec![Block::new(Shape::Box(Cuboid { half: [1.0, 1.0, 1.0] }), 1.0, 0)]);
        blocks.blocks[0].centre = [0.7, 0.0, 4.9];
        let inside = [[-1.5, -1.5, 0.0], [1.5, 1.5, 5.0]];
        for _ in 0..20 {
            let laps = blocks.laps(inside, 3, 0.0);
            blocks.part(&laps);
        }
        assert!(blocks.laps(inside, 3, 0.0).iter().all(|lap| lap.depth < 1e-6));
        // corners are pushed one after the other, which turns it a little and so takes it further in than a push at its middle would
        let [x, y, z] = blocks.blocks[0].centre;
        assert!((0.4..=0.5).contains(&x) && y.abs() < 1e-6 && (3.9..=4.0).contains(&z), "{x} {y} {z}");
    }
}
