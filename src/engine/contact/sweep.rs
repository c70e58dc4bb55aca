//! The loop over all contacts between grains: the geometry of each pair, then its force, for as many pairs at once as the processor has SIMD lanes. It runs in
//! parallel over slots; each slot reads the grains and writes itself only, so results depend neither on the number of threads nor on the order of slots.
//!
//! It reads the arrays of the grains as they lie in memory: the fourth numbers of position, velocity and spin are the radius, 1/mass and the number that
//! [`crate::grains::stiffness_radius`] takes.

use super::chunk::{Chunk, for_each_chunk};
use super::force::{self, ContactGeometry, RelativeMotion, Rules};
use super::law::Law;
use super::pair::{Pair, PairTable};
use super::pairs::FREE;
use super::unloading::TangentialUnloading;
use crate::grains::{Grains, stiffness_radius};
use crate::math::real::{Lanes, Real};
use crate::math::vector::{dot, less, plus, scaled};
use pulp::{Simd, WithSimd};
use std::marker::PhantomData;

/// Computes the contacts `slots` between grains under the law `L`. `rolling`: whether any material has rolling friction.
pub fn grains<L: Law>(rolling: bool, table: &PairTable, rules: &Rules, g: &Grains, slots: Chunk<'_>) {
    // the shorter code suffices for a single material without rolling friction and weighted loads, whose tangential force stays as the normal force falls
    let extra = rolling || rules.unloading == TangentialUnloading::Rescale || slots.keeps_loads() || table.materials() > 1;
    match (slots.keeps_works(), extra) {
        (false, false) => sweep_grains::<L, false, false>(table, rules, g, slots),
        (true, false) => sweep_grains::<L, true, false>(table, rules, g, slots),
        (false, true) => sweep_grains::<L, false, true>(table, rules, g, slots),
        (true, true) => sweep_grains::<L, true, true>(table, rules, g, slots),
    }
}

fn sweep_grains<L: Law, const LEDGER: bool, const EXTRA: bool>(table: &PairTable, rules: &Rules, g: &Grains, slots: Chunk<'_>) {
    for_each_chunk(slots, rules.task, |part| {
        rules.arch.dispatch(Sweep::<L, LEDGER, EXTRA> { table, rules, g, part, law: PhantomData });
    });
}

/// The computation of one chunk of contacts between grains.
struct Sweep<'a, L, const LEDGER: bool, const EXTRA: bool> {
    table: &'a PairTable,
    rules: &'a Rules,
    g: &'a Grains,
    part: Chunk<'a>,
    law: PhantomData<L>,
}

impl<L: Law, const LEDGER: bool, const EXTRA: bool> WithSimd for Sweep<'_, L, LEDGER, EXTRA> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let n = self.part.ends.len();
        let one_pair = self.table.grains(0, 0).map(|x| Lanes::constants(simd, x));
        let mut s = 0;
        while s < n {
            let next = n.min(s + Lanes::<S>::COUNT);
            // a constant block: without lanes the compiler does not even see the code for them
            let done = if const { Lanes::<S>::COUNT > 1 } {
                next == s + Lanes::<S>::COUNT && self.simd(simd, s, &one_pair)
            } else {
                false
            };
            if !done {
                for k in s..next {
                    self.scalar(k);
                }
            }
            s = next;
        }
    }
}

impl<L: Law, const LEDGER: bool, const EXTRA: bool> Sweep<'_, L, LEDGER, EXTRA> {
    /// Computes the contact in slot `s`.
    #[inline(always)]
    fn scalar(&mut self, s: usize) {
        let Sweep { table, rules, g, part, .. } = self;
        let [i, j] = part.ends[s];
        if i == FREE {
            return;
        }
        let (i, j) = (i as usize, j as usize);
        let (p, q) = (g.pos[i], g.pos[j]);
        let d = difference(p, q);
        let reach = p[3] + q[3];
        let distance = dot(d, d).sqrt();
        let old = part.read::<L, EXTRA>(s);
        // an overlap that rounds to zero is no contact
        if distance < reach {
            let m_eff = if L::VISCOUS { 1.0 / (g.vel[i][3] + g.vel[j][3]) } else { 0.0 };
            let mut geometry = contact_geometry(d, distance, [p[3], q[3]], m_eff, motion(g, i, j));
            if L::INHERITED {
                geometry.r_eff = r_eff(g.stiffness_radius(i), g.stiffness_radius(j));
            }
            let pair = if EXTRA { table.grains(g.material[i], g.material[j]) } else { table.grains(0, 0) };
            part.write(s, force::touching::<f64, L, LEDGER, EXTRA>(&geometry, pair, rules, &old));
        } else {
            part.write(s, force::apart::<LEDGER>(|| motion(g, i, j), rules.dt, &old));
        }
    }

    /// Computes as many contacts as there are lanes, from slot `s` on. Returns false, with nothing done, unless all of them touch.
    #[inline(always)]
    fn simd<S: Simd>(&mut self, simd: S, s: usize, one_pair: &Pair<Lanes<S>>) -> bool {
        let Sweep { table, rules, g, part, .. } = self;
        let n = g.pos.len();
        let (pos, vel, spin) = (&g.pos[..n], &g.vel[..n], &g.spin[..n]);
        let ends = &part.ends[s..s + Lanes::<S>::COUNT];
        if ends.iter().any(|e| e[0] == FREE) {
            return false;
        }
        let first = |k: usize| ends[k][0] as usize;
        let second = |k: usize| ends[k][1] as usize;
        let p = Lanes::columns(simd, |k| pos[first(k)]);
        let q = Lanes::columns(simd, |k| pos[second(k)]);
        let d = difference(p, q);
        let distance = dot(d, d).sqrt();
        if !Lanes::all(simd, (p[3] + q[3]).above(distance)) {
            return false;
        }
        let v = [Lanes::columns(simd, |k| vel[first(k)]), Lanes::columns(simd, |k| vel[second(k)])];
        let w = [Lanes::columns(simd, |k| spin[first(k)]), Lanes::columns(simd, |k| spin[second(k)])];
        let motion = relative(v, w, [p[3], q[3]]);
        let m_eff = if L::VISCOUS { d[0].constant(1.0) / (v[0][3] + v[1][3]) } else { d[0] };
        let mut geometry = contact_geometry(d, distance, [p[3], q[3]], m_eff, motion);
        if L::INHERITED {
            geometry.r_eff = r_eff(stiffness_radius(p, w[0]), stiffness_radius(q, w[1]));
        }
        let old = part.read_lanes::<S, L, EXTRA>(simd, |k| s + k);
        let pair = if EXTRA && !table.is_single() {
            &PairTable::lanes(simd, |k| table.grains(g.material[first(k)], g.material[second(k)]))
        } else {
            one_pair
        };
        let new = force::touching::<Lanes<S>, L, LEDGER, EXTRA>(&geometry, pair, rules, &old);
        part.write_lanes(simd, |k| s + k, &new);
        true
    }
}

/// Vector from the centre of `p` to the centre of `q`, m. All code that needs it calls this, so that it rounds the same everywhere.
#[inline(always)]
pub fn difference<R: Real>(p: [R; 4], q: [R; 4]) -> [R; 3] {
    [q[0] - p[0], q[1] - p[1], q[2] - p[2]]
}

/// Reduced radius R* of two radii, m.
#[inline(always)]
pub fn r_eff<R: Real>(a: R, b: R) -> R {
    a * b / (a + b)
}

/// Contact geometry of two spheres of the radii `r`, m, that overlap; `d` is the vector from the first centre to the second, `distance` its length, m.
#[inline(always)]
fn contact_geometry<R: Real>(d: [R; 3], distance: R, r: [R; 2], m_eff: R, motion: RelativeMotion<R>) -> ContactGeometry<R> {
    let reach = r[0] + r[1];
    // one division for 1/distance and 1/(r_i + r_j)
    let both = distance.constant(1.0) / (distance * reach);
    let normal = scaled(d, both * reach);
    ContactGeometry { normal, overlap: reach - distance, r_eff: r[0] * r[1] * (both * distance), m_eff, motion }
}

/// Relative motion of grains `i` and `j`.
#[inline(always)]
pub fn motion(g: &Grains, i: usize, j: usize) -> RelativeMotion {
    relative([g.vel[i], g.vel[j]], [g.spin[i], g.spin[j]], [g.pos[i][3], g.pos[j][3]])
}

/// Relative motion of two spheres from their velocities `v`, m/s, spins `w`, rad/s, and radii `r`, m. Of four numbers the first three are the vector.
#[inline(always)]
fn relative<R: Real>(v: [[R; 4]; 2], w: [[R; 4]; 2], r: [R; 2]) -> RelativeMotion<R> {
    let xyz = |u: [R; 4]| [u[0], u[1], u[2]];
    let ([v0, v1], [w0, w1]) = (v.map(xyz), w.map(xyz));
    RelativeMotion {
        centres: less(v0, v1),
        turning: plus(scaled(w0, r[0]), scaled(w1, r[1])),
        mean_spin: plus(w0, w1).map(|x| x * 0.5),
        spin_difference: less(w0, w1),
    }
}
