//! Transfer between one point and its nodes: sums over 3 × 3 (× 3) nodes of a tile, one row along x at a time.
//!
//! The entry of a node has four numbers and is handled in one SIMD register. Products are taken in the same order on every machine: w(ζy) w(ζz) first,
//! then w(ζx).

use super::blocks::TILE;
use super::spline::Weights;
use crate::math::real::Four;

/// Runs `body` for each row of three nodes along x that a point reaches, with the index of its first node in the tile and the weights along y and z. This is a
/// macro because a closure that is not inlined would not be compiled for the wider instruction set.
macro_rules! rows {
    ($d:ident, $at:expr, $w:expr, |$place:ident, $row:ident| $body:block) => {
        for k in 0..if $d == 3 { 3 } else { 1 } {
            let (wz, sz) = if $d == 3 { ($w.value[k][2], $w.slope[k][2]) } else { (1.0, 0.0) };
            for j in 0..3 {
                let (wy, sy) = ($w.value[j][1], $w.slope[j][1]);
                let $place = $at + TILE * (j + TILE * k);
                let $row = Row { j, k, value: wy * wz, along_y: sy * wz, along_z: wy * sz };
                $body
            }
        }
    };
}

/// A row of nodes along x.
struct Row {
    /// Number of the row along y, 0 to 2.
    j: usize,
    /// Number of the row along z, 0 to 2.
    k: usize,
    /// w(ζy) w(ζz).
    value: f64,
    /// w'(ζy) w(ζz), 1/m.
    along_y: f64,
    /// w(ζy) w'(ζz), 1/m.
    along_z: f64,
}

/// Weights along x of the three nodes, each in all lanes.
#[inline(always)]
fn three<F: Four>(token: F::Token, w: &[[f64; 4]; 3]) -> [F; 3] {
    [F::all(token, w[0][0]), F::all(token, w[1][0]), F::all(token, w[2][0])]
}

/// Three nodes of a tile from index `at` on.
#[inline(always)]
fn nodes_of(tile: &[[f64; 4]], at: usize) -> &[[f64; 4]; 3] {
    (&tile[at..at + 3]).try_into().expect("three nodes")
}

/// As [`nodes_of`], to be changed.
#[inline(always)]
fn nodes_mut(tile: &mut [[f64; 4]], at: usize) -> &mut [[f64; 4]; 3] {
    (&mut tile[at..at + 3]).try_into().expect("three nodes")
}

/// Adds N `q` to each node: `q` is momentum and mass of a point (Li et al. 2023, eqs 36, 37), or a force on it (eq. 29). `at`: index of the point's first node in
/// the tile.
#[inline(always)]
pub fn spread<F: Four, const D: usize>(token: F::Token, tile: &mut [[f64; 4]], at: usize, w: &Weights, q: F) {
    let wx: [F; 3] = three(token, &w.value);
    rows!(D, at, w, |at, row| {
        let q = q * F::all(token, row.value);
        let nodes = nodes_mut(tile, at);
        for i in 0..3 {
            nodes[i] = (F::of(token, nodes[i]) + q * wx[i]).xyzw();
        }
    });
}

/// As [`spread`] for APIC: the momentum differs from node to node by `along` (per node along x, y, z); `q` is that for the first node.
#[inline(always)]
pub fn spread_affine<F: Four, const D: usize>(token: F::Token, tile: &mut [[f64; 4]], at: usize, w: &Weights, q: F, along: [F; 3]) {
    let wx: [F; 3] = three(token, &w.value);
    let steps = [F::all(token, 0.0), F::all(token, 1.0), F::all(token, 2.0)];
    rows!(D, at, w, |at, row| {
        let (mut q, value) = (q + along[1] * steps[row.j], F::all(token, row.value));
        if D == 3 {
            q = q + along[2] * steps[row.k];
        }
        let nodes = nodes_mut(tile, at);
        for i in 0..3 {
            nodes[i] = (F::of(token, nodes[i]) + (q + along[0] * steps[i]) * value * wx[i]).xyzw();
        }
    });
}

/// Adds S·∇N to each node, with S given by its columns; S = −V σ gives the internal force (Li et al. 2023, eqs 8, 12).
#[inline(always)]
pub fn spread_stress<F: Four, const D: usize>(token: F::Token, tile: &mut [[f64; 4]], at: usize, w: &Weights, s: [F; 3]) {
    let (wx, sx): ([F; 3], [F; 3]) = (three(token, &w.value), three(token, &w.slope));
    rows!(D, at, w, |at, row| {
        let across = s[0] * F::all(token, row.value);
        let mut along = s[1] * F::all(token, row.along_y);
        if D == 3 {
            along = along + s[2] * F::all(token, row.along_z);
        }
        let nodes = nodes_mut(tile, at);
        for i in 0..3 {
            nodes[i] = (F::of(token, nodes[i]) + (across * sx[i] + along * wx[i])).xyzw();
        }
    });
}

/// Value at the point of a field given at its nodes: Σ N u.
#[inline(always)]
pub fn gather<F: Four, const D: usize>(token: F::Token, tile: &[[f64; 4]], at: usize, w: &Weights) -> F {
    let wx: [F; 3] = three(token, &w.value);
    let mut sum = F::all(token, 0.0);
    rows!(D, at, w, |at, row| {
        let [a, b, c] = *nodes_of(tile, at);
        let (a, b, c) = (F::of(token, a), F::of(token, b), F::of(token, c));
        sum = sum + (a * wx[0] + b * wx[1] + c * wx[2]) * F::all(token, row.value);
    });
    sum
}

/// Gradient at the point of a field given at its nodes, Σ u ∇N, as columns ∂u/∂x, ∂u/∂y, ∂u/∂z.
#[inline(always)]
pub fn gradient<F: Four, const D: usize>(token: F::Token, tile: &[[f64; 4]], at: usize, w: &Weights) -> [F; 3] {
    let (wx, sx): ([F; 3], [F; 3]) = (three(token, &w.value), three(token, &w.slope));
    let mut sum = [F::all(token, 0.0); 3];
    rows!(D, at, w, |at, row| {
        let [a, b, c] = *nodes_of(tile, at);
        let (a, b, c) = (F::of(token, a), F::of(token, b), F::of(token, c));
        let value = a * wx[0] + b * wx[1] + c * wx[2];
        let slope = a * sx[0] + b * sx[1] + c * sx[2];
        sum[0] = sum[0] + slope * F::all(token, row.value);
        sum[1] = sum[1] + value * F::all(token, row.along_y);
        if D == 3 {
            sum[2] = sum[2] + value * F::all(token, row.along_z);
        }
    });
    sum
}
