//! Loops over all points (*passes*), block by block. A block writes only its own points and its own tile of nodes, so blocks can be done in any order and on
//! any thread. In a block, points are taken cell by cell and in the order of identities in a cell, so sums depend on the state alone.

use super::account::OfBlock;
use super::blocks::{BIAS, CellBlocks, EDGE, STAYS, TILE, block_corner, cell_key, cells, tile};
use super::external_forces::{ExternalForces, OffsetForce, PointForce};
use super::grid::load;
use super::law::{ConstitutiveLaw, Elastic, InternalVariables, Law, Sym, with_law};
use super::points::Face;
use super::spline::{ShapeFunction, Weights, hats};
use super::stress::{increments, rotate_jaumann, work};
use super::transfer::{gather, gradient, spread, spread_affine, spread_stress};
#[cfg(target_arch = "x86_64")]
use crate::math::real::Quad;
use crate::math::real::{Four, Plain, quads};
use pulp::Arch;
use std::sync::atomic::{AtomicU64, Ordering};

/// Largest number of points in a parallel task, unless a block has more.
const TASK: usize = 2048;

/// The passes, as constants for generic code.
pub mod stage {
    /// Momentum and mass of the points to the tiles.
    pub const PROJECT: u8 = 0;
    /// Strain of the points from the nodes' velocities, new stress, internal forces to the tiles.
    pub const STRESS: u8 = 1;
    /// Internal forces of the present stress to the tiles.
    pub const FORCES: u8 = 2;
    /// External forces, added to the tiles.
    pub const EXTERNAL: u8 = 3;
    /// New velocities and positions of the points from the nodes.
    pub const MOVE: u8 = 4;
    /// Work of internal and external forces on the nodes' mean velocity, for the energy account.
    pub const WORK: u8 = 5;
    /// As [`STRESS`], with plastic work for the energy account.
    pub const COUNTED_STRESS: u8 = 6;
}

/// Why a point is lost. Of several points the one with the lowest identity is reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Its position is not finite.
    NotFinite,
    /// It has left the grid.
    OutsideGrid,
    /// It has moved by more than one cell in a step.
    TooFast,
    /// Its volume is not positive.
    Inverted,
}

impl Fault {
    const ALL: [Fault; 4] = [Fault::NotFinite, Fault::OutsideGrid, Fault::TooFast, Fault::Inverted];

    /// Reports the fault of point `id` into the shared word `faults`.
    fn report(self, faults: &AtomicU64, id: u32) {
        faults.fetch_min((u64::from(id) << 8) | self as u64, Ordering::Relaxed);
    }

    /// The fault with the lowest identity that was reported, and that identity; `None` without a fault.
    pub fn reported(faults: u64) -> Option<(Fault, u32)> {
        (faults != u64::MAX).then(|| (Fault::ALL[(faults & 3) as usize], (faults >> 8) as u32))
    }
}

/// Input of a pass, read by all blocks.
pub struct Pass<'a, S> {
    /// Instruction set.
    pub arch: Arch,
    /// Shape functions.
    pub shape: S,
    /// Blocks of cells that hold points.
    pub blocks: &'a CellBlocks,
    /// Constitutive laws.
    pub laws: &'a [Law],
    /// Lower corner of the domain, m.
    pub lower: [f64; 3],
    /// Edge of a cell, m.
    pub cell: f64,
    /// Number of cells of the domain along each axis.
    pub size: [i32; 3],
    /// Time step, s.
    pub dt: f64,
    /// Share of PIC: 1 is PIC, 0 is FLIP (Li et al. 2023, eq. 30).
    pub pic: f64,
    /// Velocities of the nodes, m/s.
    pub velocity: &'a [[f64; 4]],
    /// Changes of the nodes' velocities in this step, m/s; fourth number: stiffness of external forces over mass, 1/s².
    pub change: &'a [[f64; 4]],
    /// Constitutive law of each point.
    pub law: &'a [u8],
    /// Identity of each point.
    pub id: &'a [u32],
    /// External forces on points.
    pub external_forces: &'a ExternalForces,
    /// Where faults are reported.
    pub faults: &'a AtomicU64,
}

/// Output of a pass for a range of blocks: slices of the points' arrays and of arrays with one entry per block.
pub struct BlockSlices<'a> {
    /// First block.
    pub first: usize,
    /// Number of blocks.
    pub count: usize,
    /// As [`super::Points::position`].
    pub position: &'a mut [[f64; 4]],
    /// As [`super::Points::velocity`].
    pub velocity: &'a mut [[f64; 4]],
    /// As [`super::Points::stress`].
    pub stress: &'a mut [Sym],
    /// As [`super::Points::memory`].
    pub memory: &'a mut [InternalVariables],
    /// As [`super::Points::affine`]; empty without APIC.
    pub affine: &'a mut [[[f64; 3]; 3]],
    /// As [`super::Points::transport_velocity`]; empty unless it is kept.
    pub transport_velocity: &'a mut [[f64; 3]],
    /// As [`super::Points::faces`]; empty unless loading plates press.
    pub faces: &'a mut [Face],
    /// Key of the new cell of each point that leaves its cell; `STAYS` for others.
    pub target: &'a mut [u64],
    /// Tiles of the blocks.
    pub tiles: &'a mut [[f64; 4]],
    /// Of each block: number of points that leave their cell.
    pub left: &'a mut [u32],
    /// Of each block: work of the stresses, J.
    pub work: &'a mut [f64],
    /// Of each block: largest value over its points of the sum that bounds [`super::Continuum::contact_frequency_bound`], 1/s²; 0 unless transport
    /// velocities are kept.
    pub contact_frequency: &'a mut [f64],
    /// Of each block: sums of the energy account; empty unless it is kept.
    pub account: &'a mut [OfBlock],
}

impl<'a> BlockSlices<'a> {
    /// Splits into the first `blocks` blocks with their `points` points, and the rest.
    fn split<const D: usize>(self, blocks: usize, points: usize) -> (BlockSlices<'a>, BlockSlices<'a>) {
        let (p0, p1) = self.position.split_at_mut(points);
        let (v0, v1) = self.velocity.split_at_mut(points);
        let (s0, s1) = self.stress.split_at_mut(points);
        let (m0, m1) = self.memory.split_at_mut(points);
        let (a0, a1) = self.affine.split_at_mut(if self.affine.is_empty() { 0 } else { points });
        let (c0, c1) = self.transport_velocity.split_at_mut(if self.transport_velocity.is_empty() { 0 } else { points });
        let (e0, e1) = self.faces.split_at_mut(if self.faces.is_empty() { 0 } else { points });
        let (t0, t1) = self.target.split_at_mut(points);
        let (n0, n1) = self.tiles.split_at_mut(blocks * tile(D));
        let (l0, l1) = self.left.split_at_mut(blocks);
        let (w0, w1) = self.work.split_at_mut(blocks);
        let (f0, f1) = self.contact_frequency.split_at_mut(blocks);
        let (b0, b1) = self.account.split_at_mut(if self.account.is_empty() { 0 } else { blocks });
        let left = BlockSlices {
            first: self.first,
            count: blocks,
            position: p0,
            velocity: v0,
            stress: s0,
            memory: m0,
            affine: a0,
            transport_velocity: c0,
            faces: e0,
            target: t0,
            tiles: n0,
            left: l0,
            work: w0,
            contact_frequency: f0,
            account: b0,
        };
        let right = BlockSlices {
            first: self.first + blocks,
            count: self.count - blocks,
            position: p1,
            velocity: v1,
            stress: s1,
            memory: m1,
            affine: a1,
            transport_velocity: c1,
            faces: e1,
            target: t1,
            tiles: n1,
            left: l1,
            work: w1,
            contact_frequency: f1,
            account: b1,
        };
        (left, right)
    }
}

/// The constitutive law of each point, as the loop over points takes it.
trait LawOfPoint: Sync {
    /// [`ConstitutiveLaw::update`] of the point with this index.
    fn update(&self, point: usize, stress: Sym, dstrain: Sym, internal: InternalVariables) -> (Sym, InternalVariables);

    /// [`ConstitutiveLaw::elastic`] of the point with this index.
    fn elastic(&self, point: usize) -> Elastic;
}

/// One law for all points, of its own type: the loop is compiled for it alone. With the code of every law in one loop an elastic step took 15 % longer.
struct OneLaw<'a, L>(&'a L);

impl<L: ConstitutiveLaw + Sync> LawOfPoint for OneLaw<'_, L> {
    #[inline(always)]
    fn update(&self, _: usize, stress: Sym, dstrain: Sym, internal: InternalVariables) -> (Sym, InternalVariables) {
        self.0.update(stress, dstrain, internal)
    }

    fn elastic(&self, _: usize) -> Elastic {
        self.0.elastic()
    }
}

/// Several laws, and the number of that of each point.
struct SeveralLaws<'a>(&'a [Law], &'a [u8]);

impl LawOfPoint for SeveralLaws<'_> {
    #[inline(always)]
    fn update(&self, point: usize, stress: Sym, dstrain: Sym, internal: InternalVariables) -> (Sym, InternalVariables) {
        self.0[self.1[point] as usize].update(stress, dstrain, internal)
    }

    fn elastic(&self, point: usize) -> Elastic {
        self.0[self.1[point] as usize].elastic()
    }
}

/// Runs the pass `STAGE` over the blocks of `part`, in parallel.
pub fn run<const STAGE: u8, const D: usize, S: ShapeFunction>(pass: &Pass<'_, S>, part: BlockSlices<'_>) {
    if const { matches!(STAGE, stage::STRESS | stage::COUNTED_STRESS) }
        && let [law] = pass.laws
    {
        return with_law!(law, own => parallel::<STAGE, D, S, _>(pass, &OneLaw(own), part));
    }
    parallel::<STAGE, D, S, _>(pass, &SeveralLaws(pass.laws, pass.law), part);
}

/// Splits `part` into halves that run in parallel, down to tasks.
fn parallel<const STAGE: u8, const D: usize, S: ShapeFunction, L: LawOfPoint>(pass: &Pass<'_, S>, law: &L, part: BlockSlices<'_>) {
    let points = part.position.len();
    if points <= TASK || part.count < 2 {
        return dispatch::<STAGE, D, S, L>(pass, law, part);
    }
    // split at the block that holds the middle point
    let start = |b: usize| pass.blocks.starts[b * cells(D)] as usize;
    let first = start(part.first);
    let (mut low, mut high) = (part.first + 1, part.first + part.count - 1);
    while low < high {
        let middle = (low + high) / 2;
        if start(middle) - first < points / 2 { low = middle + 1 } else { high = middle }
    }
    let (a, b) = (low - part.first, start(low) - first);
    let (left, right) = part.split::<D>(a, b);
    rayon::join(|| parallel::<STAGE, D, S, L>(pass, law, left), || parallel::<STAGE, D, S, L>(pass, law, right));
}

/// Runs the pass with the best instructions that `pass.arch` allows.
fn dispatch<const STAGE: u8, const D: usize, S: ShapeFunction, L: LawOfPoint>(pass: &Pass<'_, S>, law: &L, part: BlockSlices<'_>) {
    match quads(pass.arch) {
        #[cfg(target_arch = "x86_64")]
        Some(v3) => v3.vectorize(
            #[inline(always)]
            || some::<Quad, STAGE, D, S, L>(v3, pass, law, part),
        ),
        _ => some::<Plain, STAGE, D, S, L>((), pass, law, part),
    }
}

/// Runs the pass over the blocks of `part` one after the other.
#[inline(always)]
fn some<F: Four, const STAGE: u8, const D: usize, S: ShapeFunction, L: LawOfPoint>(
    token: F::Token,
    pass: &Pass<'_, S>,
    law: &L,
    part: BlockSlices<'_>,
) {
    let first_point = pass.blocks.starts[part.first * cells(D)] as usize;
    let place = CellMap::<F, S>::new(token, pass);
    let (mut velocity, mut change) = ([[0.0; 4]; TILE * TILE * TILE], [[0.0; 4]; TILE * TILE * TILE]);
    let mut part = part;
    for k in 0..part.count {
        let b = part.first + k;
        let corner = block_corner(pass.blocks.keys[b]);
        let starts = &pass.blocks.starts[b * cells(D)..=(b + 1) * cells(D)];
        if starts[0] == starts[cells(D)] {
            // a block without points any more
            if matches!(STAGE, stage::PROJECT | stage::STRESS | stage::COUNTED_STRESS | stage::FORCES) {
                part.tiles[k * tile(D)..][..tile(D)].fill([0.0; 4]);
            }
            (part.left[k], part.work[k], part.contact_frequency[k]) = (0, 0.0, 0.0);
            continue;
        }
        if matches!(STAGE, stage::STRESS | stage::COUNTED_STRESS | stage::MOVE | stage::WORK) {
            load::<D>(&pass.blocks.ahead[b], pass.velocity, &mut velocity);
        }
        if matches!(STAGE, stage::MOVE | stage::WORK) {
            load::<D>(&pass.blocks.ahead[b], pass.change, &mut change);
        }
        if STAGE == stage::WORK {
            // the mean velocity of the step
            for (v, dv) in velocity.iter_mut().zip(&change) {
                *v = std::array::from_fn(|a| v[a] - 0.5 * dv[a]);
            }
        }
        if matches!(STAGE, stage::PROJECT | stage::STRESS | stage::COUNTED_STRESS | stage::FORCES) {
            part.tiles[k * tile(D)..][..tile(D)].fill([0.0; 4]);
        }
        let mut sums = BlockSums { left: 0, work: 0.0, contact_frequency: 0.0, account: [0.0; 5] };
        for c in 0..cells(D) {
            let [x, y, z] = [c % EDGE, c / EDGE % EDGE, c / (EDGE * EDGE)];
            let cell = [corner[0] + x as i32, corner[1] + y as i32, if D == 3 { corner[2] + z as i32 } else { 0 }];
            let at = x + TILE * (y + TILE * z);
            for i in starts[c] as usize - first_point..starts[c + 1] as usize - first_point {
                let point = At { token, i, whole: first_point + i, at, cell, k };
                match STAGE {
                    stage::PROJECT => project::<F, D, S>(pass, &place, &mut part, point),
                    stage::STRESS => strain::<F, D, S, L, false>(pass, law, &place, &mut part, point, &velocity, &mut sums),
                    stage::COUNTED_STRESS => strain::<F, D, S, L, true>(pass, law, &place, &mut part, point, &velocity, &mut sums),
                    stage::WORK => works::<F, D, S>(pass, &place, &part, point, &velocity, &mut sums),
                    stage::FORCES => forces::<F, D, S>(pass, &place, &mut part, point),
                    stage::EXTERNAL => external_forces::<F, D, S>(pass, &place, &mut part, point),
                    _ => advance::<F, D, S>(pass, &place, &mut part, point, [&velocity, &change], &mut sums),
                }
            }
        }
        match STAGE {
            stage::STRESS => part.work[k] = sums.work,
            stage::COUNTED_STRESS => {
                part.work[k] = sums.work;
                part.account[k] = [0.0, 0.0, sums.work, sums.account[3], sums.account[4]];
            }
            stage::WORK => part.account[k] = sums.account,
            stage::MOVE => (part.left[k], part.contact_frequency[k]) = (sums.left, sums.contact_frequency),
            _ => {}
        }
    }
}

/// Sums over the points of a block; the fields are those of [`BlockSlices`].
struct BlockSums {
    left: u32,
    work: f64,
    contact_frequency: f64,
    account: OfBlock,
}

/// One point of a pass.
#[derive(Clone, Copy)]
struct At<T> {
    token: T,
    /// Index in the slices.
    i: usize,
    /// Index in the whole arrays.
    whole: usize,
    /// Index of its first node in the tile.
    at: usize,
    /// Its cell.
    cell: [i32; 3],
    /// Index of its block in the slices.
    k: usize,
}

/// Constants for the way from a position to cell coordinates and weights.
struct CellMap<F: Four, S> {
    token: F::Token,
    shape: S,
    lower: F,
    inverse: F,
    inverse_cell: f64,
    reach: F,
}

impl<F: Four, S: ShapeFunction> CellMap<F, S> {
    #[inline(always)]
    fn new(token: F::Token, pass: &Pass<'_, S>) -> Self {
        let [x, y, z] = pass.lower;
        let inverse_cell = 1.0 / pass.cell;
        CellMap {
            token,
            shape: pass.shape,
            lower: F::of(token, [x, y, z, 0.0]),
            inverse: F::all(token, inverse_cell),
            inverse_cell,
            reach: F::all(token, pass.shape.reach()),
        }
    }

    /// Position in cells from the lower corner of the domain.
    #[inline(always)]
    fn in_cells(&self, position: F) -> F {
        (position - self.lower) * self.inverse
    }

    /// Distance of a position from the first node of its cell, in cells, and the weights there.
    #[inline(always)]
    fn weights(&self, position: [f64; 4], cell: [i32; 3]) -> (F, Weights) {
        let first = F::of(self.token, [f64::from(cell[0]), f64::from(cell[1]), f64::from(cell[2]), 0.0]);
        let t = self.in_cells(F::of(self.token, position)) - first;
        (t, self.shape.weights(self.token, t, self.inverse_cell))
    }

    /// Linear weights `offset` metres beside a point. `t`: distance of the point from its first node, in cells.
    #[inline(always)]
    fn beside<const D: usize>(&self, t: [f64; 4], offset: [f64; 3]) -> Weights {
        let mut w = Weights { value: [[0.0; 4]; 3], slope: [[0.0; 4]; 3] };
        for a in 0..D {
            for (node, value) in w.value.iter_mut().zip(hats(t[a] + offset[a] * self.inverse_cell)) {
                node[a] = value;
            }
        }
        w
    }

    /// Weights of a face of a point: those of the point, `w`, along the other axes, and along `axis` those for a traction on the face `beside` metres from
    /// the point ([`ShapeFunction::at_edge`]). `t`: distance of the point from its first node, in cells.
    #[inline(always)]
    fn at_face(&self, t: [f64; 4], w: &Weights, axis: usize, beside: f64) -> Weights {
        let mut w = *w;
        let beside = beside * self.inverse_cell;
        let values = self.shape.at_edge(t[axis] + beside, beside.abs());
        for (node, value) in w.value.iter_mut().zip(values) {
            node[axis] = value;
        }
        w
    }
}

/// Cell of a position, with the same bits as in the passes.
pub fn cell_of<const D: usize>(position: &[f64; 4], lower: [f64; 3], inverse_cell: f64, reach: f64) -> [i32; 3] {
    std::array::from_fn(|a| if a < D { ((position[a] - lower[a]) * inverse_cell - reach).floor() as i32 } else { 0 })
}

/// Tile of block `k` of the slices.
#[inline(always)]
fn own<'t, const D: usize>(part: &'t mut BlockSlices<'_>, k: usize) -> &'t mut [[f64; 4]] {
    &mut part.tiles[k * tile(D)..][..tile(D)]
}

/// Adds momentum and mass of a point to its tile.
#[inline(always)]
fn project<F: Four, const D: usize, S: ShapeFunction>(
    pass: &Pass<'_, S>,
    place: &CellMap<F, S>,
    part: &mut BlockSlices<'_>,
    p: At<F::Token>,
) {
    let (t, w) = place.weights(part.position[p.i], p.cell);
    let v = F::of(p.token, part.velocity[p.i]);
    let q = (v * v.w()).with_w_of(v);
    if part.affine.is_empty() {
        return spread::<F, D>(p.token, own::<D>(part, p.k), p.at, &w, q);
    }
    // APIC: m (v + C (x_I − x_p)) at the first node, and its difference from node to node
    let scale = v.w() * F::all(p.token, pass.cell);
    let [x, y, z] = part.affine[p.i];
    let along = [column::<F>(p.token, x) * scale, column::<F>(p.token, y) * scale, column::<F>(p.token, z) * scale];
    let t = t.xyzw();
    let mut q = q - along[0] * F::all(p.token, t[0]) - along[1] * F::all(p.token, t[1]);
    if D == 3 {
        q = q - along[2] * F::all(p.token, t[2]);
    }
    spread_affine::<F, D>(p.token, own::<D>(part, p.k), p.at, &w, q, along);
}

/// A vector with a fourth number of zero.
#[inline(always)]
fn column<F: Four>(token: F::Token, [x, y, z]: [f64; 3]) -> F {
    F::of(token, [x, y, z, 0.0])
}

/// The columns of −V σ.
#[inline(always)]
fn pull<F: Four>(token: F::Token, volume: f64, s: &Sym) -> [F; 3] {
    let v = F::all(token, 0.0 - volume);
    let columns = [[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]];
    [column::<F>(token, columns[0]) * v, column::<F>(token, columns[1]) * v, column::<F>(token, columns[2]) * v]
}

/// Strain and spin of a point, its new stress and volume, the places of its faces, and its internal force on the tile.
#[inline(always)]
fn strain<F: Four, const D: usize, S: ShapeFunction, L: LawOfPoint, const COUNTED: bool>(
    pass: &Pass<'_, S>,
    law: &L,
    place: &CellMap<F, S>,
    part: &mut BlockSlices<'_>,
    p: At<F::Token>,
    velocity: &[[f64; 4]],
    sums: &mut BlockSums,
) {
    let (t, w) = place.weights(part.position[p.i], p.cell);
    let dt = F::all(p.token, pass.dt);
    let [x, y, z] = gradient::<F, D>(p.token, velocity, p.at, &w);
    let (strain, spin) = increments([(x * dt).xyzw(), (y * dt).xyzw(), (z * dt).xyzw()]);
    let before = rotate_jaumann(part.stress[p.i], spin);
    let (stress, memory) = law.update(p.whole, before, strain, part.memory[p.i]);
    let volume = part.position[p.i][3];
    // a gap is no part of the volume of the soil
    let grown = volume * (1.0 + ((strain[0] + strain[1] + strain[2]) - (memory.gap - part.memory[p.i].gap)));
    if grown.is_nan() || grown <= 0.0 {
        Fault::Inverted.report(pass.faults, pass.id[p.whole]);
    }
    // the mean of both stresses, and of both volumes
    sums.work += 0.25 * (volume + grown) * (work(before, strain) + work(stress, strain));
    if COUNTED {
        let elastic = law.elastic(p.whole);
        sums.account[3] += 0.5 * (volume + grown) * elastic.plastic_work(&before, strain, &stress);
        sums.account[4] -= 0.5 * (grown - volume) * (elastic.energy(&part.stress[p.i]) + elastic.energy(&stress));
    }
    part.position[p.i][3] = grown;
    part.stress[p.i] = stress;
    part.memory[p.i] = memory;
    if let Some([beside, face]) = part.faces.get_mut(p.i) {
        for a in (0..D).filter(|&a| beside[a] != 0.0) {
            let w = place.at_face(t.xyzw(), &w, a, face[a] - part.position[p.i][a]);
            face[a] += (gather::<F, D>(p.token, velocity, p.at, &w) * dt).xyzw()[a];
        }
    }
    spread_stress::<F, D>(p.token, own::<D>(part, p.k), p.at, &w, pull(p.token, grown, &stress));
}

/// Adds the internal force of a point with its present stress to its tile.
#[inline(always)]
fn forces<F: Four, const D: usize, S: ShapeFunction>(
    _: &Pass<'_, S>,
    place: &CellMap<F, S>,
    part: &mut BlockSlices<'_>,
    p: At<F::Token>,
) {
    let (_, w) = place.weights(part.position[p.i], p.cell);
    let pull = pull(p.token, part.position[p.i][3], &part.stress[p.i]);
    spread_stress::<F, D>(p.token, own::<D>(part, p.k), p.at, &w, pull);
}

/// Adds the external force on a point and its faces to its tile.
#[inline(always)]
fn external_forces<F: Four, const D: usize, S: ShapeFunction>(
    pass: &Pass<'_, S>,
    place: &CellMap<F, S>,
    part: &mut BlockSlices<'_>,
    p: At<F::Token>,
) {
    let Some(point @ &PointForce { force, beside, .. }) = pass.external_forces.of(p.whole) else { return };
    let (t, w) = place.weights(part.position[p.i], p.cell);
    if force != [0.0; 4] {
        spread::<F, D>(p.token, own::<D>(part, p.k), p.at, &w, F::of(p.token, force));
    }
    for one in pass.external_forces.offset_forces(point) {
        let w = place.beside::<D>(t.xyzw(), one.offset);
        spread::<F, D>(p.token, own::<D>(part, p.k), p.at, &w, F::of(p.token, one.force));
    }
    for a in (0..D).filter(|&a| beside[a] != 0.0) {
        let mut along = [0.0; 4];
        along[a] = beside[a];
        // the stiffness is divided among the components as the force is
        along[3] = beside[3] * (beside[a].abs() / (beside[0].abs() + beside[1].abs() + beside[2].abs()));
        let w = place.at_face(t.xyzw(), &w, a, part.faces[p.i][0][a]);
        spread::<F, D>(p.token, own::<D>(part, p.k), p.at, &w, F::of(p.token, along));
    }
}

/// Adds the work of the stress of a point, and of the external force on it and its faces, on the nodes' mean velocity `mean`. The weights are those with which
/// the forces were spread.
#[inline(always)]
fn works<F: Four, const D: usize, S: ShapeFunction>(
    pass: &Pass<'_, S>,
    place: &CellMap<F, S>,
    part: &BlockSlices<'_>,
    p: At<F::Token>,
    mean: &[[f64; 4]],
    sums: &mut BlockSums,
) {
    let (t, w) = place.weights(part.position[p.i], p.cell);
    let [x, y, z] = gradient::<F, D>(p.token, mean, p.at, &w);
    let (strain, _) = increments([x.xyzw(), y.xyzw(), z.xyzw()]);
    sums.account[0] += part.position[p.i][3] * work(part.stress[p.i], strain) * pass.dt;
    if pass.external_forces.is_empty() {
        return;
    }
    let Some(point @ &PointForce { force, beside, .. }) = pass.external_forces.of(p.whole) else { return };
    let v = gather::<F, D>(p.token, mean, p.at, &w).xyzw();
    let mut power = force[0] * v[0] + force[1] * v[1] + force[2] * v[2];
    for OffsetForce { force, offset, .. } in pass.external_forces.offset_forces(point) {
        let w = place.beside::<D>(t.xyzw(), *offset);
        let v = gather::<F, D>(p.token, mean, p.at, &w).xyzw();
        power += force[0] * v[0] + force[1] * v[1] + force[2] * v[2];
    }
    for a in (0..D).filter(|&a| beside[a] != 0.0) {
        let w = place.at_face(t.xyzw(), &w, a, part.faces[p.i][0][a]);
        power += beside[a] * gather::<F, D>(p.token, mean, p.at, &w).xyzw()[a];
    }
    sums.account[1] += power * pass.dt;
}

/// New velocity and position of a point.
#[inline(always)]
fn advance<F: Four, const D: usize, S: ShapeFunction>(
    pass: &Pass<'_, S>,
    place: &CellMap<F, S>,
    part: &mut BlockSlices<'_>,
    p: At<F::Token>,
    [velocity, change]: [&[[f64; 4]]; 2],
    sums: &mut BlockSums,
) {
    let (position, own) = (F::of(p.token, part.position[p.i]), F::of(p.token, part.velocity[p.i]));
    let (t, w) = place.weights(part.position[p.i], p.cell);
    let field = gather::<F, D>(p.token, velocity, p.at, &w);
    let asked = !part.transport_velocity.is_empty();
    let mut gain = F::all(p.token, 0.0);
    if asked || part.affine.is_empty() {
        gain = gather::<F, D>(p.token, change, p.at, &w);
    }
    let new = if part.affine.is_empty() {
        // Li et al. 2023, eq. 30
        let flip = own + gain;
        field * F::all(p.token, pass.pic) + flip * F::all(p.token, 1.0 - pass.pic)
    } else {
        // C = 4/h² Σ N v (x_I − x_p)ᵀ, with quadratic splines
        let mut arms = w;
        let t = t.xyzw();
        let scale = 4.0 / pass.cell;
        for (n, (arm, value)) in arms.slope.iter_mut().zip(&w.value).enumerate() {
            for ((arm, value), t) in arm.iter_mut().zip(value).zip(&t).take(3) {
                *arm = scale * (n as f64 - t) * value;
            }
        }
        let [dx, dy, dz] = gradient::<F, D>(p.token, velocity, p.at, &arms);
        let (dx, dy, dz) = (dx.xyzw(), dy.xyzw(), dz.xyzw());
        part.affine[p.i] = [[dx[0], dx[1], dx[2]], [dy[0], dy[1], dy[2]], [dz[0], dz[1], dz[2]]];
        field
    };
    // eq. 33
    let moved = (position + field * F::all(p.token, pass.dt)).with_w_of(position);
    part.velocity[p.i] = new.with_w_of(own).xyzw();
    part.position[p.i] = moved.xyzw();
    if asked {
        let [x, y, z, _] = field.xyzw();
        part.transport_velocity[p.i] = [x, y, z];
        sums.contact_frequency = sums.contact_frequency.max(gain.xyzw()[3]);
        if !pass.external_forces.is_empty()
            && let Some(point) = pass.external_forces.of(p.whole)
        {
            // those at the start of the step of the continuum have a stiffness
            for one in pass.external_forces.offset_forces(point).filter(|one| one.force[3] > 0.0) {
                let w = place.beside::<D>(t.xyzw(), one.offset);
                let there = gather::<F, D>(p.token, change, p.at, &w).xyzw()[3];
                sums.contact_frequency = sums.contact_frequency.max(there);
            }
        }
    }
    let there = (place.in_cells(moved) - place.reach).xyzw();
    let mut stays = true;
    for (there, cell) in there.iter().zip(p.cell).take(D) {
        let cell = f64::from(cell);
        stays &= *there >= cell && *there < cell + 1.0;
    }
    part.target[p.i] = if stays { STAYS } else { crossing::<D, S>(pass, there, p.whole, p.cell, sums) };
}

/// Key of the new cell of a point that has left its cell; reports a fault if the point is lost.
#[cold]
#[inline(never)]
fn crossing<const D: usize, S: ShapeFunction>(
    pass: &Pass<'_, S>,
    there: [f64; 4],
    i: usize,
    from: [i32; 3],
    sums: &mut BlockSums,
) -> u64 {
    let mut cell = [0; 3];
    for a in 0..D {
        let fault = if !there[a].is_finite() {
            Some(Fault::NotFinite)
        } else {
            cell[a] = there[a].floor() as i32;
            match cell[a] {
                // cell −1 is allowed: its first node is one behind the wall
                c if c < -1 || c >= pass.size[a] || c >= BIAS => Some(Fault::OutsideGrid),
                c if (c - from[a]).abs() > 1 => Some(Fault::TooFast),
                _ => None,
            }
        };
        if let Some(fault) = fault {
            fault.report(pass.faults, pass.id[i]);
            return STAYS;
        }
    }
    sums.left += 1;
    cell_key::<D>(cell)
}
