//! How much a step on the device moves and computes, so that a reader can tell what a device should reach: bytes over its bandwidth, flops over its rate, or dispatches
//! times what each costs (some microseconds), whichever is the longest.
//!
//! One count for all: the dispatches are those of `plan.rs`. Each pass reads and writes what it needs of a buffer once, as if a cache held what several of its threads
//! read; buffers are those of the blocks in use, and a point leaves its cell in every step. Operations are the additions, multiplications, divisions and roots of the
//! shaders' f32, with the elastic law; whole numbers, comparisons and returns to a yield surface are not counted. Each point near a grain has one contact, and lists of candidates
//! are not made.

use super::bounds::{BLOCK, GROUP, SLOTS, TILE};
use super::grains::layout::{CONTACT, GRAIN, NODES, POINT_CONTACT};
use super::layout::nodes_on_walls;
use super::plan::Extent;
use serde::Serialize;
use std::ops::Add;

/// What one step takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct StepWork {
    /// Number of dispatches, each of which waits for the one before it.
    pub dispatches: u64,
    /// Bytes read and written.
    pub bytes: u64,
    /// Operations with floating-point numbers.
    pub flops: u64,
}

impl Add for StepWork {
    type Output = StepWork;

    fn add(self, other: StepWork) -> StepWork {
        StepWork {
            dispatches: self.dispatches + other.dispatches,
            bytes: self.bytes + other.bytes,
            flops: self.flops + other.flops,
        }
    }
}

impl StepWork {
    /// Of one step, with `near` points near grains.
    pub fn of(extent: &Extent, near: u32) -> StepWork {
        extent.step().iter().map(|d| of_pass(d.pass, extent, near.into())).fold(StepWork::default(), Add::add)
    }
}

/// Bytes of an entry of four words, and of a word.
const PLANE: u64 = 16;
const WORD: u64 = 4;

/// Operations of the elastic law.
pub const ELASTIC: u64 = 15;
/// Operations of a point with all of its nodes: `deposit`, `press_nodes`, each with three threads for a point, `advance`, `strain`.
pub const DEPOSIT: u64 = 360;
pub const PRESS: u64 = 762;
pub const ADVANCE: u64 = 498;
pub const STRAIN: u64 = 723 + ELASTIC;
/// Operations of a cell where its block sums up what it gives to 27 nodes; of a node that sums up eight tiles.
const SUM_TILE: u64 = 4 * 27;
const FROM_TILES: u64 = 4 * 8;
/// Estimates: operations at a node on a wall and those beside it; with which a point finds how far it is from a loading plate; of a contact, with what it presses on nodes; of
/// a grain's motion.
const WALL: u64 = 40;
const TOUCH: u64 = 10;
const CONTACT_FORCE: u64 = 100 + 8 * NODES as u64;
const MOVE: u64 = 100;

fn of_pass(pass: &str, e: &Extent, near: u64) -> StepWork {
    let [points, blocks] = [e.points, e.blocks[0]].map(u64::from);
    let (cells, tiles) = (BLOCK as u64 * blocks, TILE as u64 * blocks * PLANE);
    let plates = u64::from(e.plates);
    let (pressed, coupled) = (u64::from(plates > 0), u64::from(e.grains.is_some()));
    // two cells deep, with two points along the edge of a cell
    let at_plates = points.min(plates * (4.0 * (points as f64).powf(2.0 / 3.0)) as u64);
    let of_groups = plates * points.div_ceil(GROUP as u64) * PLANE;
    let grains = e.grains.map_or(0, |g| u64::from(g.grains));
    let on_walls = nodes_on_walls(e.size, &e.walls);
    let [bytes, flops] = match pass {
        // place, velocity; identity, order twice; starts, counts; tiles
        "deposit" => [points * (2 * PLANE + 3 * WORD) + cells * 3 * WORD + tiles, points * DEPOSIT + cells * SUM_TILE],
        // place, stress twice, forces of plates, row; order; starts; tiles
        "press_nodes" => {
            [points * ((3 + pressed + coupled) * PLANE + WORD) + cells * WORD + tiles, points * PRESS + cells * SUM_TILE]
        }
        // tiles; momentum, speed; whether a wall acts
        "project" => [tiles + (cells * 2 + on_walls) * PLANE, cells * FROM_TILES + on_walls * WALL],
        // tiles; momentum, speed, change; impulses of walls; grains
        "accelerate" => [
            tiles + (cells * 3 + on_walls + grains * 2 * GRAIN as u64) * PLANE,
            cells * FROM_TILES + on_walls * WALL + grains * MOVE,
        ],
        // place, rest, velocity and its low part, twice; faces, transport twice; of points at a plate the rest of their faces; speed and change
        "advance" => [(points * (8 + pressed + 2 * coupled) + at_plates * 3 + cells * 2) * PLANE, points * ADVANCE],
        // counts twice; starts
        "find_starts" => [cells * 3 * WORD, 0],
        // place, order; counts twice
        "scatter" => [points * (PLANE + WORD) + cells * 2 * WORD, 0],
        // place, four of stress, work; five of them again; law, faces, row; of points at a plate the rest of their faces; speed
        "strain" => {
            [(points * (11 + u64::from(e.several_laws) + pressed + coupled) + at_plates * 3 + cells) * PLANE, points * STRAIN]
        }
        // place; force; sums of workgroups; of points near a plate rest, faces, radius
        "plate_forces" => {
            [(points * 2 + at_plates * 3) * PLANE + at_plates * WORD + of_groups, (points * plates + at_plates) * TOUCH]
        }
        // sums of workgroups; impulses of walls
        "finish" => [of_groups + on_walls * PLANE, 0],
        "move_grains" => [grains * 2 * GRAIN as u64 * PLANE, grains * MOVE],
        // point, contact twice, what it presses on nodes twice
        "point_contact_forces" => [near * (5 + 2 * (POINT_CONTACT + NODES) as u64) * PLANE, near * CONTACT_FORCE],
        // slots, half of which are contacts, and contacts with points
        "grain_forces" => [
            (grains * (CONTACT * SLOTS) as u64 + near * CONTACT as u64) * PLANE,
            (grains * SLOTS as u64 / 2 + near) * CONTACT_FORCE,
        ],
        "build_grid" | "candidates" | "step_bound" => [0, 0],
        _ => unreachable!("{pass} is a pass of a step"),
    };
    StepWork { dispatches: 1, bytes, flops }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::plan::GrainExtent;

    /// The count goes with the points, the grid and the steps of the grains; a point reads and writes its own state at least twice in a step.
    #[test]
    fn work_goes_with_what_there_is() {
        let bare =
            Extent { points: 1000, several_laws: false, blocks: [20, 30], size: [6; 3], walls: [0; 6], plates: 0, grains: None };
        let one = StepWork::of(&bare, 0);
        assert_eq!(one.dispatches, bare.step().len() as u64);
        let twice = StepWork::of(&Extent { points: 2000, ..bare }, 0);
        let [of_points, flops] = [twice.bytes - one.bytes, twice.flops - one.flops];
        assert!(of_points > 2 * 1000 * 9 * PLANE && one.bytes > of_points);
        assert!(0 < flops && flops < one.flops);
        assert_eq!(one.bytes - of_points, 20 * (4 * TILE as u64 * PLANE + 32 * (8 * PLANE + 9 * WORD)));
        let with = |rates| StepWork::of(&Extent { grains: Some(GrainExtent { grains: 5, rows: 100, rates }), ..bare }, 50);
        let more = [with(2), with(3), with(4)].map(|w| w.flops);
        assert!(with(1).flops > one.flops && more[1] - more[0] == more[2] - more[1] && more[0] < more[1]);
    }
}
