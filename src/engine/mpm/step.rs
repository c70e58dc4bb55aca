//! One step of the continuum: the stages in order. No other file knows the order.
//!
//! The method is MUSL with the shape functions of the new positions (Li et al. 2023, section 2.4). Mass and momentum of the nodes by eqs 36 and 37 serve
//! the strain increment of this step and are the start of the next one; internal forces go to the nodes in the same loop in which stresses are computed.
//! So a step needs two loops over points that gather from nodes and two that spread to nodes. If there is no grid (first step, restart, points changed
//! from outside), it is made from the points by the same sums, with the same bits.

use super::account::{NodeAccount, OfBlock, kinetic_of_points};
use super::blocks::{CellBlocks, STAYS, block_corner, cell_key, tile};
use super::body_points::{BodyPoint, Nodes};
use super::external_forces::ExternalForces;
use super::grid::{NodeGrid, node_in_tile};
use super::pass::{BlockSlices, Fault, Pass, cell_of, run, stage};
use super::points::Points;
use super::spline::{BSpline, Gimp, ShapeFunction, hats};
use super::{Continuum, Dimension, Settings, ShapeFunctions, Transfer};
use crate::error::{Error, Result};
use pulp::Arch;
use std::sync::atomic::{AtomicU64, Ordering};

/// Grid and buffers; may be dropped between any two steps, but for the external forces.
#[derive(Debug, Default)]
pub struct GridWorkspace {
    /// Instruction set to be used instead of the best.
    pub arch: Option<Arch>,
    /// Blocks of cells that hold points.
    blocks: CellBlocks,
    /// Values at the nodes.
    grid: NodeGrid,
    /// Key of the new cell of each point that leaves its cell in this step; `STAYS` for others.
    target: Vec<u64>,
    /// Of each block: number of points that leave their cell.
    left: Vec<u32>,
    /// Of each block: work of the stresses in this step, J.
    block_work: Vec<f64>,
    /// Of each block: largest value of the bound below.
    block_frequency: Vec<f64>,
    /// Of each block: sums of the energy account in this step; empty unless it is kept.
    block_account: Vec<OfBlock>,
    /// Buffer of the energy account.
    free: Vec<[f64; 4]>,
    /// As [`Continuum::contact_frequency_bound`], 1/s².
    pub contact_frequency: f64,
    /// First fault of a point in this step ([`Fault`]).
    faults: AtomicU64,
    /// External forces for the next step.
    pub external_forces: ExternalForces,
    /// Whether the points are sorted by cells.
    sorted: bool,
    /// Whether the grid holds the points' mass and momentum, and the tiles their internal forces.
    ready: bool,
}

impl Clone for GridWorkspace {
    /// Copies the external forces only; grid and buffers are made anew when they are needed.
    fn clone(&self) -> GridWorkspace {
        GridWorkspace { arch: self.arch, external_forces: self.external_forces.clone(), ..GridWorkspace::default() }
    }
}

impl GridWorkspace {
    /// Calls `visit` with the index of every point in the box from `low` to `high`, m, and of some points around it.
    pub fn visit<const D: usize>(
        &self,
        settings: &Settings,
        points: &Points,
        [low, high]: [[f64; 3]; 2],
        mut visit: impl FnMut(usize),
    ) {
        if !self.sorted {
            return (0..points.len()).for_each(visit);
        }
        let inverse_cell = 1.0 / settings.cell;
        // a point belongs to a cell whose first node lies between 0 and 1.5 cells below the point
        let cell = |x: [f64; 3], reach: f64| {
            let [x, y, z] = x;
            cell_of::<D>(&[x, y, z, 0.0], settings.lower, inverse_cell, reach)
        };
        let (from, to) = (cell(low, 1.0), cell(high, 0.0));
        // a box of more cells than there are points, such as that of a body which has grown beyond all bounds
        let many = (0..D).map(|a| f64::from(to[a]) - f64::from(from[a]) + 1.0).product::<f64>() > 1e3 * (points.len() + 64) as f64;
        if many {
            return (0..points.len()).for_each(visit);
        }
        self.blocks.visit::<D>(from, to, |range| range.for_each(&mut visit));
    }

    /// Tells that points were changed from outside: the next step sorts them and makes the grid anew.
    pub fn forget(&mut self) {
        (self.sorted, self.ready) = (false, false);
    }

    /// Memory in use, bytes.
    pub fn bytes(&self) -> usize {
        self.blocks.bytes()
            + self.grid.bytes()
            + 8 * (self.target.capacity() + self.block_work.capacity() + self.block_frequency.capacity())
            + 4 * self.left.capacity()
            + size_of::<OfBlock>() * self.block_account.capacity()
            + 32 * self.free.capacity()
            + self.external_forces.bytes()
    }
}

/// Makes one step of `dt` seconds, with contacts with these points of rigid bodies at nodes ([`Nodes`]).
///
/// # Errors
/// A point that is lost.
pub fn step(c: &mut Continuum, dt: f64, bodies: &mut [BodyPoint]) -> Result<()> {
    if c.points.is_empty() {
        c.step += 1;
        return Ok(());
    }
    match (c.settings.dimension, c.settings.shape) {
        (Dimension::PlaneStrain, ShapeFunctions::BSpline) => stages::<2, _>(c, BSpline, dt, bodies),
        (Dimension::PlaneStrain, ShapeFunctions::Gimp { half_width }) => stages::<2, _>(c, Gimp(half_width), dt, bodies),
        (Dimension::Space, ShapeFunctions::BSpline) => stages::<3, _>(c, BSpline, dt, bodies),
        (Dimension::Space, ShapeFunctions::Gimp { half_width }) => stages::<3, _>(c, Gimp(half_width), dt, bodies),
    }
}

/// See [`Continuum::velocity_beside`].
pub fn velocity_beside<const D: usize>(c: &Continuum, i: usize, offset: [f64; 3]) -> [f64; 3] {
    let (Settings { lower, cell, shape, .. }, blocks) = (&c.settings, &c.work.blocks);
    let (inverse_cell, p) = (1.0 / cell, &c.points.position[i]);
    let reach = match shape {
        ShapeFunctions::BSpline => BSpline.reach(),
        ShapeFunctions::Gimp { half_width } => Gimp(*half_width).reach(),
    };
    let first = cell_of::<D>(p, *lower, inverse_cell, reach);
    let Some(block) = blocks.find(cell_key::<D>(first) >> (2 * D)) else { return [0.0; 3] };
    let corner = block_corner(blocks.keys[block]);
    let weights: [[f64; 3]; 3] = std::array::from_fn(|a| {
        if a < D { hats((p[a] - lower[a] + offset[a]) * inverse_cell - f64::from(first[a])) } else { [1.0, 0.0, 0.0] }
    });
    let mut sum = [0.0; 3];
    for (k, z) in weights[2].iter().enumerate().filter(|(_, w)| **w > 0.0) {
        for (j, y) in weights[1].iter().enumerate().filter(|(_, w)| **w > 0.0) {
            for (i, x) in weights[0].iter().enumerate().filter(|(_, w)| **w > 0.0) {
                let at = [i, j, k].map(|n| n as i32);
                let in_tile: [usize; 3] = std::array::from_fn(|a| if a < D { (first[a] + at[a] - corner[a]) as usize } else { 0 });
                let v = c.work.grid.velocity[node_in_tile::<D>(&blocks.ahead[block], in_tile)];
                let weight = x * y * z;
                for a in 0..3 {
                    sum[a] += weight * v[a];
                }
            }
        }
    }
    sum
}

/// The stages of a step in `D` dimensions.
fn stages<const D: usize, S: ShapeFunction>(c: &mut Continuum, shape: S, dt: f64, bodies: &mut [BodyPoint]) -> Result<()> {
    c.step += 1;
    c.work.faults.store(u64::MAX, Ordering::Relaxed);
    if !c.work.ready {
        sort::<D, S>(c, shape);
        pass::<{ stage::PROJECT }, D, S>(c, shape, dt);
        c.work.grid.project::<D>(&c.work.blocks);
        pass::<{ stage::FORCES }, D, S>(c, shape, dt);
    }
    let counted = begin_account(c);
    // eq. 29: forces on points from contacts
    if !c.work.external_forces.is_empty() {
        pass::<{ stage::EXTERNAL }, D, S>(c, shape, dt);
    }
    // eq. 28: velocities of the nodes, walls
    let GridWorkspace { grid, blocks, free, .. } = &mut c.work;
    grid.change::<D>(blocks, &c.settings, dt);
    if !bodies.is_empty() {
        Nodes { shape, settings: &c.settings, blocks, points: &c.points, grid: &mut *grid }.touch::<D>(bodies);
    }
    let mut account = c.account.as_mut().map(|sums| NodeAccount { sums, free });
    c.wall_force = grid.accelerate::<D>(&c.settings, dt, account.as_mut());
    if counted {
        pass::<{ stage::WORK }, D, S>(c, shape, dt);
        add_sums(c);
    }
    // eqs 30, 33: velocities and positions of the points
    pass::<{ stage::MOVE }, D, S>(c, shape, dt);
    c.work.external_forces.clear();
    c.work.contact_frequency = c.work.block_frequency.iter().fold(0.0, |most, frequency| frequency.max(most));
    check_faults(c)?;
    resort::<D>(c);
    // eqs 36, 37: velocities of the nodes from those of the points
    pass::<{ stage::PROJECT }, D, S>(c, shape, dt);
    c.work.grid.project::<D>(&c.work.blocks);
    // strain, spin, stress, and the internal forces of the next step
    if counted {
        let kinetic = kinetic_of_points(c);
        if let Some(account) = &mut c.account {
            account.to_points -= kinetic;
            account.kinetic = Some(kinetic);
        }
        // points may have gone to other blocks
        add_sums(c);
        pass::<{ stage::COUNTED_STRESS }, D, S>(c, shape, dt);
        add_sums(c);
    } else {
        pass::<{ stage::STRESS }, D, S>(c, shape, dt);
    }
    c.stress_work += c.work.block_work.iter().sum::<f64>();
    check_faults(c)?;
    c.work.ready = true;
    Ok(())
}

/// Prepares the sums of the energy account, if it is kept: whether it is.
fn begin_account(c: &mut Continuum) -> bool {
    let kinetic = match &c.account {
        None => return false,
        Some(account) => account.kinetic.unwrap_or_else(|| kinetic_of_points(c)),
    };
    if let Some(account) = &mut c.account {
        account.kinetic = Some(kinetic);
    }
    add_sums(c);
    true
}

/// Adds the blocks' sums to the energy account, and makes room for those of the present blocks.
fn add_sums(c: &mut Continuum) {
    let Continuum { account, work, .. } = c;
    if let Some(account) = account {
        account.add(&work.block_account);
    }
    work.block_account.clear();
    work.block_account.resize(work.blocks.len(), OfBlock::default());
}

/// Runs one loop over all points.
fn pass<const STAGE: u8, const D: usize, S: ShapeFunction>(c: &mut Continuum, shape: S, dt: f64) {
    let Continuum { settings, laws, points, work, .. } = c;
    let Points { position, velocity, stress, memory, affine, transport_velocity, faces, law, id, .. } = points;
    let pic = if let Transfer::Blend { pic } = settings.transfer { pic } else { 1.0 };
    let pass = Pass {
        arch: work.arch.unwrap_or_else(crate::math::real::arch),
        shape,
        blocks: &work.blocks,
        laws,
        lower: settings.lower,
        cell: settings.cell,
        size: settings.size(),
        dt,
        pic,
        velocity: &work.grid.velocity,
        change: &work.grid.change,
        law,
        id,
        external_forces: &work.external_forces,
        faults: &work.faults,
    };
    let count = work.blocks.len();
    let part = BlockSlices {
        first: 0,
        count,
        position,
        velocity,
        stress,
        memory,
        affine,
        transport_velocity,
        faces,
        target: &mut work.target,
        tiles: &mut work.grid.tiles[..count * tile(D)],
        left: &mut work.left,
        work: &mut work.block_work,
        contact_frequency: &mut work.block_frequency,
        account: &mut work.block_account,
    };
    run::<STAGE, D, S>(&pass, part);
}

/// Sorts the points by cells, if they are not sorted.
fn sort<const D: usize, S: ShapeFunction>(c: &mut Continuum, shape: S) {
    let Continuum { settings, points, work, .. } = c;
    if !work.sorted {
        let inverse_cell = 1.0 / settings.cell;
        work.blocks.sort::<D>(points, &mut work.external_forces.places, |p| {
            cell_key::<D>(cell_of::<D>(p, settings.lower, inverse_cell, shape.reach()))
        });
        work.target.resize(points.len(), STAYS);
        work.sorted = true;
        fit::<D>(c);
    }
}

/// Moves points that have left their cell to their new cells.
fn resort<const D: usize>(c: &mut Continuum) {
    let GridWorkspace { blocks, target, left, .. } = &mut c.work;
    if blocks.resort::<D>(&mut c.points, target, left) {
        fit::<D>(c);
    }
}

/// Fits grid and buffers to the present blocks.
fn fit<const D: usize>(c: &mut Continuum) {
    let GridWorkspace { blocks, grid, left, block_work, block_frequency, .. } = &mut c.work;
    grid.fit::<D>(blocks, &c.settings);
    left.resize(blocks.len(), 0);
    block_work.resize(blocks.len(), 0.0);
    block_frequency.resize(blocks.len(), 0.0);
}

/// Checks whether a point was lost in the last loop.
///
/// # Errors
/// The lost point with the lowest identity.
fn check_faults(c: &mut Continuum) -> Result<()> {
    let Some((fault, id)) = Fault::reported(c.work.faults.load(Ordering::Relaxed)) else { return Ok(()) };
    c.work.forget();
    let what = match fault {
        Fault::NotFinite => "has no finite position or velocity: use a smaller time step and look at the law's parameters",
        Fault::OutsideGrid => "has left the grid: enlarge the domain, put a wall there, or use a smaller time step",
        Fault::TooFast => "has passed more than one cell in a step: use a smaller time step",
        Fault::Inverted => "is turned inside out (volume not positive): use a smaller time step, a finer grid, or a stiffer law",
    };
    Err(Error::Unstable { step: c.step, what: format!("point {id} {what}"), grain: None })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vector::cross;
    use crate::mpm::blocks::cell_at;
    use crate::mpm::law::{Elastic, Law};
    use crate::mpm::{GridWall, Point};

    /// A block of 14 × 14 × 14 points, two along a cell's edge of 0.1 m, with these velocities at their positions.
    fn block(velocity: impl Fn([f64; 3]) -> [f64; 3]) -> Continuum {
        let settings = Settings {
            dimension: Dimension::Space,
            cell: 0.1,
            lower: [-0.2; 3],
            cells: [12; 3],
            walls: [GridWall::Open; 6],
            gravity: [0.0; 3],
            shape: ShapeFunctions::BSpline,
            transfer: Transfer::Blend { pic: 0.0 },
            damping: 0.0,
        };
        let mut points = Points::default();
        for k in 0..14 * 14 * 14 {
            let position = [k % 14, k / 14 % 14, k / 196].map(|n: i32| 0.025 + 0.05 * f64::from(n));
            points.add(&Point {
                position,
                velocity: velocity(position),
                mass: 0.2,
                volume: 1.25e-4,
                stress: [0.0; 6],
                porosity: 0.0,
                law: 0,
            });
        }
        let mut c = Continuum::new(settings, vec![Law::Elastic(Elastic::of_young(1e6, 0.3))], points).expect("allowed");
        c.keep_transport_velocity();
        c
    }

    /// A step up to where the nodes have their new velocities.
    fn accelerate_nodes(c: &mut Continuum, dt: f64) {
        sort::<3, _>(c, BSpline);
        pass::<{ stage::PROJECT }, 3, _>(c, BSpline, dt);
        c.work.grid.project::<3>(&c.work.blocks);
        pass::<{ stage::FORCES }, 3, _>(c, BSpline, dt);
        pass::<{ stage::EXTERNAL }, 3, _>(c, BSpline, dt);
        let GridWorkspace { grid, blocks, .. } = &mut c.work;
        grid.change::<3>(blocks, &c.settings, dt);
        grid.accelerate::<3>(&c.settings, dt, None);
    }

    /// A force beside a point gives the nodes its impulse and its moment about the origin.
    #[test]
    fn a_force_beside_a_point_arrives_with_its_moment() {
        let mut c = block(|_| [0.0; 3]);
        let (force, dt) = ([3.0, -2.0, 0.7], 1e-5);
        let offsets = [[0.0, 0.02, -0.03], [-0.05, 0.05, 0.01], [0.013, 0.0, 0.0]];
        let (mut impulse, mut moment) = ([0.0; 3], [0.0; 3]);
        for (i, offset) in [7, 7, 200].into_iter().zip(offsets) {
            c.add_force_beside(i, force, 1e5, offset);
            let at = std::array::from_fn(|a| c.points.position[i][a] + offset[a]);
            for (sum, part) in [(&mut impulse, force), (&mut moment, cross(at, force))] {
                (0..3).for_each(|a| sum[a] += dt * part[a]);
            }
        }
        // the nodes just before the points move: momentum of the points alone is that of a later time
        accelerate_nodes(&mut c, dt);
        let (settings, GridWorkspace { grid, blocks, .. }) = (&c.settings, &c.work);
        let (mut given, mut turned) = ([0.0; 3], [0.0; 3]);
        for (n, (p, dv)) in grid.momentum.iter().zip(&grid.change).enumerate() {
            let node = cell_at::<3>((blocks.node_keys[n / 64] << 6) | (n % 64) as u64);
            let at: [f64; 3] = std::array::from_fn(|a| settings.lower[a] + settings.cell * f64::from(node[a]));
            let own = [dv[0] * p[3], dv[1] * p[3], dv[2] * p[3]];
            let turn = cross(at, own);
            for a in 0..3 {
                given[a] += own[a];
                turned[a] += turn[a];
            }
        }
        for a in 0..3 {
            assert!((given[a] - impulse[a]).abs() < 1e-17, "{given:?} {impulse:?}");
            assert!((turned[a] - moment[a]).abs() < 1e-14, "{turned:?} {moment:?}");
        }
        assert!(moment.iter().all(|m| m.abs() > 1e-7));
    }

    /// A force at the node nearest to a point moves that node alone.
    #[test]
    fn a_force_at_the_nearest_node_moves_no_other() {
        let mut c = block(|_| [0.0; 3]);
        let (force, dt) = ([3.0, -2.0, 0.7], 1e-5);
        let offset = c.nearest_node(200);
        let place: [f64; 3] = std::array::from_fn(|a| c.points.position[200][a] + offset[a]);
        assert!(offset.iter().all(|x| x.abs() <= 0.5 * c.settings.cell));
        c.add_force_beside(200, force, 0.0, offset);
        accelerate_nodes(&mut c, dt);
        let (settings, GridWorkspace { grid, blocks, .. }) = (&c.settings, &c.work);
        for (n, (p, dv)) in grid.momentum.iter().zip(&grid.change).enumerate() {
            let node = cell_at::<3>((blocks.node_keys[n / 64] << 6) | (n % 64) as u64);
            let there = (0..3).all(|a| (settings.lower[a] + settings.cell * f64::from(node[a]) - place[a]).abs() < 1e-9);
            for a in 0..3 {
                let expected = if there { dt * force[a] } else { 0.0 };
                assert!((dv[a] * p[3] - expected).abs() < 1e-16, "{node:?}: {dv:?}");
            }
        }
    }

    /// In a field that is linear in space the velocity beside a point is that of the field there.
    #[test]
    fn velocities_beside_points_are_those_of_the_field() {
        let field = |[x, y, z]: [f64; 3]| [0.1 + 0.3 * y - 0.2 * z, 0.4 * x - 0.1, 0.2 * x + 0.5 * z];
        let mut c = block(field);
        c.step(1e-9).expect("a small step");
        let inner: Vec<usize> =
            (0..c.points.len()).filter(|&i| c.points.position[i][..3].iter().all(|x| (0.32..0.38).contains(x))).collect();
        assert_eq!(inner.len(), 8);
        for i in inner {
            for offset in [[0.0; 3], [0.02, -0.01, 0.017], [-0.03, 0.0, 0.0]] {
                let at = std::array::from_fn(|a| c.points.position[i][a] + offset[a]);
                let (found, expected) = (c.velocity_beside(i, offset), field(at));
                assert!((0..3).all(|a| (found[a] - expected[a]).abs() < 1e-7), "{found:?} {expected:?}");
            }
        }
    }

    /// The stiffness of a force beside a point bounds the square of the frequency where it acts: Σ N² k/m over the nodes, by the weights there.
    #[test]
    fn a_stiffness_beside_a_point_is_bounded_where_it_acts() {
        let settings = block(|_| [0.0; 3]).settings;
        let mut points = Points::default();
        // in the middle of a cell: its spline is 1/2, 1/2 along each axis; 0.025 m beside it the linear weights are 3/4, 1/4
        points.add(&Point {
            position: [0.15; 3],
            velocity: [0.0; 3],
            mass: 2.0,
            volume: 1e-3,
            stress: [0.0; 6],
            porosity: 0.0,
            law: 0,
        });
        let mut c = Continuum::new(settings, vec![Law::Elastic(Elastic::of_young(1e6, 0.3))], points).expect("allowed");
        c.keep_transport_velocity();
        c.add_force_beside(0, [1.0, 0.0, 0.0], 1e5, [-0.025, 0.0, 0.0]);
        c.step(1e-9).expect("a small step");
        // along y and z the spline is 1/8, 3/4, 1/8 or 1/2, 1/2 where the linear weights are those of the point itself
        let along = |spline: &[f64], hat: &[f64]| spline.iter().zip(hat).map(|(n, h)| h * h / n).sum::<f64>();
        let expected = 1e5 / 2.0 * along(&[0.5, 0.5], &[0.75, 0.25]) * along(&[0.5, 0.5], &[0.5, 0.5]).powi(2);
        assert!((c.contact_frequency_bound() / expected - 1.0).abs() < 1e-9, "{} {expected}", c.contact_frequency_bound());
    }
}
