//! Mass, momentum and velocity of the nodes that material reaches, block by block. Made anew from the points when it is missing.
//!
//! Each block of points adds to a tile of nodes of its own. A node then sums the up to eight tiles that hold it, in a fixed order. Sums start from +0 and
//! so are never −0: an empty tile changes no bit.

use super::Settings;
use super::account::NodeAccount;
use super::blocks::{CellBlocks, EDGE, NONE, TILE, cells, tile};
use super::walls::Walls;
use rayon::prelude::*;

/// Smallest number of blocks of nodes in a parallel task.
const TASK: usize = 8;

/// Values at nodes.
#[derive(Clone, Debug, Default)]
pub struct NodeGrid {
    /// Tile of each block of points: momentum, kg m/s, and mass, kg; or force, N, and stiffness of external forces, N/m.
    pub tiles: Vec<[f64; 4]>,
    /// Momentum, kg m/s, and mass, kg, of each node, from the points.
    pub momentum: Vec<[f64; 4]>,
    /// Velocity of each node, m/s, with the effect of walls.
    pub velocity: Vec<[f64; 4]>,
    /// Change of the velocity of each node in this step, m/s; fourth number: stiffness of external forces over the node's mass, 1/s².
    pub change: Vec<[f64; 4]>,
    /// Walls at the sides of the domain.
    pub walls: Walls,
}

impl NodeGrid {
    /// Makes room for the present blocks and finds the nodes near walls.
    pub fn fit<const D: usize>(&mut self, blocks: &CellBlocks, settings: &Settings) {
        let nodes = blocks.node_keys.len() * cells(D);
        self.tiles.resize(blocks.len() * tile(D), [0.0; 4]);
        for array in [&mut self.momentum, &mut self.velocity, &mut self.change] {
            array.resize(nodes, [0.0; 4]);
        }
        self.walls.find::<D>(blocks, &settings.walls, settings.size());
    }

    /// Velocities of the nodes, v = p/m, from the tiles' momentum and mass (Li et al. 2023, eqs 36, 37), with the effect of walls.
    pub fn project<const D: usize>(&mut self, blocks: &CellBlocks) {
        let tiles = &self.tiles;
        let arrays = self.momentum.par_chunks_exact_mut(cells(D)).zip(self.velocity.par_chunks_exact_mut(cells(D)));
        arrays.enumerate().with_min_len(TASK).for_each(|(n, (momentum, velocity))| {
            collect::<D>(&blocks.behind[n], tiles, momentum);
            for (v, p) in velocity.iter_mut().zip(momentum) {
                let over = 1.0 / if p[3] > 0.0 { p[3] } else { f64::INFINITY };
                *v = [p[0] * over, p[1] * over, p[2] * over, 0.0];
            }
        });
        self.walls.project(&self.momentum, &mut self.velocity);
    }

    /// Sets the changes of the nodes' velocities by the tiles' forces and gravity, Δt f/m (Li et al. 2023, eq. 28).
    pub fn change<const D: usize>(&mut self, blocks: &CellBlocks, settings: &Settings, dt: f64) {
        let (tiles, g) = (&self.tiles, settings.gravity);
        let arrays = self.momentum.par_chunks_exact(cells(D)).zip(self.change.par_chunks_exact_mut(cells(D)));
        arrays.enumerate().with_min_len(TASK).for_each(|(n, (momentum, change))| {
            // `change` holds forces first, then changes of velocity
            collect::<D>(&blocks.behind[n], tiles, change);
            for (f, p) in change.iter_mut().zip(momentum) {
                let m = p[3];
                let mass = if m > 0.0 { m } else { f64::INFINITY };
                let over = dt / mass;
                *f = [(f[0] + m * g[0]) * over, (f[1] + m * g[1]) * over, (f[2] + m * g[2]) * over, f[3] / mass];
            }
        });
    }

    /// Accelerates the nodes by the changes of this step, v ← v + Δv, with the effect of walls and local damping. Returns the force of each wall on the material, N.
    pub fn accelerate<const D: usize>(
        &mut self,
        settings: &Settings,
        dt: f64,
        mut account: Option<&mut NodeAccount<'_>>,
    ) -> [[f64; 3]; 6] {
        let damping = settings.damping;
        if let Some(account) = &mut account {
            account.before_walls(&self.momentum, &self.change, self.walls.nodes());
        }
        let impulses = self.walls.accelerate(&self.momentum, &mut self.velocity, &mut self.change);
        if let Some(account) = account {
            account.after_walls(&self.momentum, &self.velocity, &self.change, self.walls.nodes(), settings, dt);
        }
        let arrays = self.velocity.par_chunks_exact_mut(cells(D)).zip(self.change.par_chunks_exact_mut(cells(D)));
        arrays.with_min_len(2 * TASK).for_each(|(velocity, change)| {
            for (v, dv) in velocity.iter_mut().zip(change) {
                for a in 0..3 {
                    dv[a] = damped(v[a], dv[a], damping);
                    v[a] += dv[a];
                }
            }
        });
        impulses.map(|i| i.map(|x| x / dt))
    }

    /// Memory in use, bytes.
    pub fn bytes(&self) -> usize {
        let vectors = self.tiles.capacity() + self.momentum.capacity() + self.velocity.capacity() + self.change.capacity();
        32 * vectors + self.walls.bytes()
    }
}

/// Change of a component of a node's velocity, m/s, with local damping −α |f| sign(v) of the force that walls have left; a node that friction has stopped
/// stays at rest. `v`: velocity before the step, `dv`: its change without damping.
#[inline(always)]
pub fn damped(v: f64, dv: f64, damping: f64) -> f64 {
    if damping > 0.0 && v != 0.0 && v + dv != 0.0 {
        let size = damping * dv.abs();
        dv + if v > 0.0 { 0.0 - size } else { size }
    } else {
        dv
    }
}

/// Values at the nodes of a block: sums of the tiles that hold them. `behind`: blocks of points whose tiles reach these nodes.
fn collect<const D: usize>(behind: &[u32; 8], tiles: &[[f64; 4]], out: &mut [[f64; 4]]) {
    out.fill([0.0; 4]);
    for (k, &b) in behind.iter().enumerate().take(1 << D) {
        if b == NONE {
            continue;
        }
        let tile = &tiles[b as usize * tile(D)..][..tile(D)];
        let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2];
        let count = |far: usize| if far == 1 { TILE - EDGE } else { EDGE };
        for kz in 0..if D == 3 { count(z) } else { 1 } {
            for ky in 0..count(y) {
                let from = &tile[EDGE * x + TILE * (ky + EDGE * y + TILE * (kz + EDGE * z))..][..count(x)];
                let to = &mut out[EDGE * (ky + EDGE * kz)..][..count(x)];
                for (to, from) in to.iter_mut().zip(from) {
                    for a in 0..4 {
                        to[a] += from[a];
                    }
                }
            }
        }
    }
}

/// Index of the node with these coordinates in a block's tile. `ahead`: blocks of nodes that the tile covers.
pub fn node_in_tile<const D: usize>(ahead: &[u32; 8], [x, y, z]: [usize; 3]) -> usize {
    let block = ahead[x / EDGE + 2 * (y / EDGE) + 4 * (z / EDGE)];
    block as usize * cells(D) + x % EDGE + EDGE * (y % EDGE + EDGE * (z % EDGE))
}

/// Copies the values at the nodes of a block's tile to `out`. `ahead`: blocks of nodes that the tile covers.
#[inline(always)]
pub fn load<const D: usize>(ahead: &[u32; 8], nodes: &[[f64; 4]], out: &mut [[f64; 4]]) {
    for z in 0..if D == 3 { TILE } else { 1 } {
        for y in 0..TILE {
            let to = &mut out[TILE * (y + TILE * z)..][..TILE];
            let k = 2 * (y / EDGE) + 4 * (z / EDGE);
            let row = EDGE * (y % EDGE + EDGE * (z % EDGE));
            let at = |b: u32| b as usize * cells(D) + row;
            to[..EDGE].copy_from_slice(&nodes[at(ahead[k])..][..EDGE]);
            to[EDGE..].copy_from_slice(&nodes[at(ahead[k + 1])..][..TILE - EDGE]);
        }
    }
}
