//! Dense random packings of rigid bodies in a box: placed far apart in a box that is too large, which then shrinks and pushes them together. It is geometry
//! alone: nothing has weight or speed, and friction does not count.

use super::shapes::orientation;
use engine::math::vector::{dot, less};
use engine::rigid::{Block, Blocks};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Share of the first box that spheres around the bodies fill, along each axis to the power of the dimensions.
const LOOSE: f64 = 0.25;
/// Random places that are tried for a body.
const TRIES: u32 = 10_000;
/// Way of a side of the box in a step, over the least radius of edges.
const WAY: f64 = 0.25;
/// Rounds of pushing apart after each step, and at most in the end.
const ROUNDS: [u32; 2] = [6, 4000];
/// Gap that bodies are given in the end, over the least radius of edges; what is left of it is enough, as long as they do not overlap.
const GAP: f64 = 0.02;

/// Places the bodies, whose shapes, masses and radii are known, in the box between the two corners, m. In plane strain (`flat`) z does not count.
///
/// # Errors
/// The largest overlap that is left, m, where they do not fit.
pub fn pack(blocks: Vec<Block>, [low, high]: [[f64; 3]; 2], flat: bool, rng: &mut ChaCha8Rng) -> Result<Vec<Block>, f64> {
    let axes = if flat { 2 } else { 3 };
    let size: [f64; 3] = std::array::from_fn(|a| high[a] - low[a]);
    let middle: [f64; 3] = std::array::from_fn(|a| if a < axes { 0.5 * (low[a] + high[a]) } else { 0.0 });
    let box_times = |scale: f64| [-0.5, 0.5].map(|side| std::array::from_fn(|a| middle[a] + side * scale * size[a]));
    let reaches: Vec<f64> = blocks.iter().map(|b| b.solid().reach()).collect();
    let filled: f64 = reaches.iter().map(|r| (2.0 * r).powi(axes as i32)).sum();
    let volume: f64 = size[..axes].iter().product();
    let least = size[..axes].iter().fold(f64::INFINITY, |a, b| a.min(*b));
    let widest = reaches.iter().fold(0.0_f64, |a, b| a.max(*b));
    let start = (filled / (LOOSE * volume)).powf(1.0 / axes as f64).max(2.5 * widest / least).max(1.0);
    let mut all = scatter(blocks, &reaches, box_times(start), axes, rng).ok_or(f64::INFINITY)?;
    let edge = all.blocks.iter().map(|b| b.shape.rounded().rounding()).fold(f64::INFINITY, f64::min);
    // equal factors, so that no side goes further in a step than bodies may overlap
    let longest = size[..axes].iter().fold(0.0_f64, |a, b| a.max(*b));
    let steps = (start.ln() * 0.5 * longest * start / (WAY * edge)).ceil().max(1.0);
    let factor = start.powf(-1.0 / steps);
    let mut scale = start;
    for _ in 0..steps as u32 {
        scale *= factor;
        for block in &mut all.blocks {
            for (x, m) in block.centre.iter_mut().zip(middle) {
                *x = m + factor * (*x - m);
            }
        }
        push_apart(&mut all, box_times(scale), axes, ROUNDS[0], [0.0, 0.5 * WAY * edge]);
    }
    let left = push_apart(&mut all, [low, high], axes, ROUNDS[1], [GAP * edge, 0.0]);
    if left > 0.0 { Err(left) } else { Ok(all.blocks) }
}

/// Bodies at random places in a box, turned at random, so that spheres around them do not overlap; `None` where there is no room.
fn scatter(
    mut blocks: Vec<Block>,
    reaches: &[f64],
    [low, high]: [[f64; 3]; 2],
    axes: usize,
    rng: &mut ChaCha8Rng,
) -> Option<Blocks> {
    let mut order: Vec<usize> = (0..blocks.len()).collect();
    // the largest first: later there is no room for them
    order.sort_by(|&i, &j| reaches[j].total_cmp(&reaches[i]));
    for n in 0..order.len() {
        let (k, reach) = (order[n], reaches[order[n]]);
        let mut draw = || -> [f64; 3] {
            std::array::from_fn(|a| {
                if a < axes { low[a] + reach + (high[a] - low[a] - 2.0 * reach).max(0.0) * rng.random::<f64>() } else { 0.0 }
            })
        };
        let free = |at: &[f64; 3]| {
            order[..n].iter().all(|&j| {
                let away = less(*at, blocks[j].centre);
                dot(away, away) > (reach + reaches[j]) * (reach + reaches[j])
            })
        };
        blocks[k].centre = (0..TRIES).map(|_| draw()).find(free)?;
        blocks[k].turn = orientation(axes == 2, rng);
    }
    Some(Blocks::new(blocks))
}

/// Pushes bodies towards a gap between them, until no overlap is above `enough`, m, at most `rounds` times; the largest overlap that is left, m, less than 0
/// for a gap.
fn push_apart(all: &mut Blocks, inside: [[f64; 3]; 2], axes: usize, rounds: u32, [gap, enough]: [f64; 2]) -> f64 {
    let mut left = f64::INFINITY;
    for _ in 0..rounds {
        let laps = all.laps(inside, axes, gap);
        left = laps.iter().map(|lap| lap.depth - gap).fold(-gap, f64::max);
        if left <= enough {
            break;
        }
        all.part(&laps);
    }
    left
}

#[cfg(test)]
mod tests {
    use super::super::shapes::{Form, Shapes};
    use super::*;
    use rand::SeedableRng;

    /// Packs `count` bodies and tells what part of the box they fill, if they fit.
    fn packed(flat: bool, count: usize, fill: f64, seed: u64) -> Result<f64, f64> {
        let shapes = Shapes {
            flat,
            diameter: [0.8, 1.2],
            form: Form::Random { corners: if flat { [5, 5] } else { [10, 14] }, elongation: [1.0, 1.3], flatness: [1.0, 1.2] },
            rounding: 0.05,
        };
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let blocks: Vec<Block> = (0..count).map(|_| Block::new(shapes.draw(&mut rng).expect("a shape"), 1.0, 0)).collect();
        // density 1: masses are areas or volumes
        let solid: f64 = blocks.iter().map(|b| b.mass).sum();
        let edge = (solid / fill).powf(if flat { 0.5 } else { 1.0 / 3.0 });
        let inside = [[0.0; 3], [edge; 3]];
        let mut all = Blocks::new(pack(blocks, inside, flat, &mut rng)?);
        let laps = all.laps(inside, if flat { 2 } else { 3 }, 0.0);
        assert!(laps.is_empty(), "{laps:?}");
        let centre =
            all.blocks.iter().all(|b| b.centre[..2].iter().all(|x| (0.0..edge).contains(x)) && (!flat || b.centre[2] == 0.0));
        assert!(centre, "out of the box");
        Ok(solid / edge.powi(if flat { 2 } else { 3 }))
    }

    #[test]
    fn bodies_fill_a_box_without_overlaps() {
        assert!((packed(true, 40, 0.78, 1).expect("pentagons fit") - 0.78).abs() < 1e-9);
        assert!((packed(false, 30, 0.5, 2).expect("polyhedra fit") - 0.5).abs() < 1e-9);
        let full = packed(true, 30, 1.05, 3).expect_err("no box can be more than full");
        assert!(full > 0.0);
    }
}
