//! One step of the continuum: the stages in order. No other file knows the order.
//!
//! The method is MUSL with the shape functions of the new positions (Li et al. 2023, section 2.4). Mass and momentum of the nodes by eqs 36 and 37 serve
//! the strain increment of this step and are the start of the next one; internal forces go to the nodes in the same loop in which stresses are computed.
//! So a step needs two loops over points that gather from nodes and two that spread to nodes. If there is no grid (first step, restart, points changed
//! from outside), it is made from the points by the same sums, with the same bits.

use super::account::{NodeAccount, OfBlock, kinetic_of_points};
use super::blocks::{CellBlocks, STAYS, cell_key, tile};
use super::external_forces::ExternalForces;
use super::grid::NodeGrid;
use super::pass::{BlockSlices, Fault, Pass, cell_of, run, stage};
use super::points::Points;
use super::spline::{BSpline, Gimp, ShapeFunction};
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

/// Makes one step of `dt` seconds.
///
/// # Errors
/// A point that is lost.
pub fn step(c: &mut Continuum, dt: f64) -> Result<()> {
    if c.points.is_empty() {
        c.step += 1;
        return Ok(());
    }
    match (c.settings.dimension, c.settings.shape) {
        (Dimension::PlaneStrain, ShapeFunctions::BSpline) => stages::<2, _>(c, BSpline, dt),
        (Dimension::PlaneStrain, ShapeFunctions::Gimp { half_width }) => stages::<2, _>(c, Gimp(half_width), dt),
        (Dimension::Space, ShapeFunctions::BSpline) => stages::<3, _>(c, BSpline, dt),
        (Dimension::Space, ShapeFunctions::Gimp { half_width }) => stages::<3, _>(c, Gimp(half_width), dt),
    }
}

/// The stages of a step in `D` dimensions.
fn stages<const D: usize, S: ShapeFunction>(c: &mut Continuum, shape: S, dt: f64) -> Result<()> {
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
    let pushed = !c.work.external_forces.is_empty();
    if pushed {
        pass::<{ stage::EXTERNAL }, D, S>(c, shape, dt);
    }
    // eq. 28: velocities of the nodes, walls
    let GridWorkspace { grid, blocks, free, .. } = &mut c.work;
    let mut account = c.account.as_mut().map(|sums| NodeAccount { sums, free });
    c.wall_force = grid.accelerate::<D>(blocks, &c.settings, dt, account.as_mut());
    if counted {
        pass::<{ stage::WORK }, D, S>(c, shape, dt);
        add_sums(c);
    }
    if pushed {
        c.work.external_forces.clear();
    }
    // eqs 30, 33: velocities and positions of the points
    pass::<{ stage::MOVE }, D, S>(c, shape, dt);
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
