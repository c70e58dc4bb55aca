//! The loop over all pairs of a grain and a wall. Most of them do not touch; those that do are collected until they fill the SIMD lanes and then computed
//! together. The fourth numbers of position, velocity and spin are those of [`super::sweep`].

use super::chunk::{Chunk, for_each_chunk};
use super::force::{self, ContactGeometry, RelativeMotion, Rules};
use super::law::Law;
use super::pair::PairTable;
use super::pairs::{FREE, Pairs};
use crate::boundary::Wall;
use crate::grains::{Grains, stiffness_radius};
use crate::math::real::{Lanes, MOST_LANES, Real};
use crate::math::vector::{plus, scaled};
use pulp::{Simd, WithSimd};
use std::marker::PhantomData;

/// Computes all contacts of grains with walls under the law `L`.
pub fn walls<L: Law>(table: &PairTable, rules: &Rules, g: &Grains, walls: &[Wall], pairs: &mut Pairs) {
    match pairs.kept().work {
        false => sweep_walls::<L, false>(table, rules, g, walls, pairs),
        true => sweep_walls::<L, true>(table, rules, g, walls, pairs),
    }
}

/// Relative motion of grain `i` and a wall. `normal`: unit vector from the grain to the wall; `speed`, m/s: that of the wall against the normal, positive into
/// the grains.
#[inline(always)]
pub fn motion_on_wall(g: &Grains, i: usize, normal: [f64; 3], speed: f64) -> RelativeMotion {
    relative_to_wall(g.vel[i], g.spin[i], g.pos[i][3], normal, speed)
}

#[inline(always)]
fn relative_to_wall<R: Real>(v: [R; 4], w: [R; 4], r: R, normal: [R; 3], speed: R) -> RelativeMotion<R> {
    let spin = [w[0], w[1], w[2]];
    RelativeMotion {
        centres: plus([v[0], v[1], v[2]], scaled(normal, speed)),
        turning: scaled(spin, r),
        mean_spin: spin,
        spin_difference: spin,
    }
}

fn sweep_walls<L: Law, const LEDGER: bool>(table: &PairTable, rules: &Rules, g: &Grains, walls: &[Wall], pairs: &mut Pairs) {
    for_each_chunk(Chunk::all(pairs), rules.task, |part| {
        rules.arch.dispatch(WallSweep::<L, LEDGER> { table, rules, g, walls, part, law: PhantomData });
    });
}

/// The computation of one chunk of pairs of a grain and a wall.
struct WallSweep<'a, L, const LEDGER: bool> {
    table: &'a PairTable,
    rules: &'a Rules,
    g: &'a Grains,
    walls: &'a [Wall],
    part: Chunk<'a>,
    law: PhantomData<L>,
}

/// A contact with a wall that waits to be computed: its slot; its unit normal, and its overlap, m.
#[derive(Clone, Copy, Default)]
struct OnWall {
    slot: usize,
    at: [f64; 4],
}

impl<L: Law, const LEDGER: bool> WithSimd for WallSweep<'_, L, LEDGER> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let lanes = Lanes::<S>::COUNT;
        let mut waiting = [OnWall::default(); MOST_LANES];
        let mut n = 0;
        for slot in 0..self.part.ends.len() {
            let [i, k] = self.part.ends[slot];
            if i == FREE {
                continue;
            }
            let ([x, y, z], gap) = self.walls[k as usize].shape.towards(self.g.pos[i as usize]);
            if gap >= 0.0 {
                self.apart(slot, [x, y, z]);
                continue;
            }
            waiting[n] = OnWall { slot, at: [x, y, z, -gap] };
            n += 1;
            if n == lanes {
                n = 0;
                if const { Lanes::<S>::COUNT > 1 } { self.simd(simd, &waiting[..lanes]) } else { self.scalar(waiting[0]) }
            }
        }
        for &one in &waiting[..n] {
            self.scalar(one);
        }
    }
}

impl<L: Law, const LEDGER: bool> WallSweep<'_, L, LEDGER> {
    /// Clears the history of a pair that does not touch.
    #[inline(always)]
    fn apart(&mut self, slot: usize, normal: [f64; 3]) {
        let [i, k] = self.part.ends[slot];
        let old = self.part.read::<L, true>(slot);
        // nothing to write unless the contact has ended in this step or the last
        if old.touch.overlap > 0.0 || LEDGER && self.part.work[slot][0] != 0.0 {
            let motion = || motion_on_wall(self.g, i as usize, normal, self.walls[k as usize].speed);
            self.part.write(slot, force::apart::<LEDGER>(motion, self.rules.dt, &old));
        }
    }

    /// Computes one contact.
    #[inline(always)]
    fn scalar(&mut self, OnWall { slot, at: [x, y, z, overlap] }: OnWall) {
        let WallSweep { table, rules, g, walls, part, .. } = self;
        let [i, k] = part.ends[slot].map(|e| e as usize);
        let normal = [x, y, z];
        let motion = motion_on_wall(g, i, normal, walls[k].speed);
        let geometry = ContactGeometry { normal, overlap, r_eff: g.stiffness_radius(i), m_eff: 1.0 / g.vel[i][3], motion };
        let pair = table.wall(k, g.material[i]);
        part.write(slot, force::touching::<f64, L, LEDGER, true>(&geometry, pair, rules, &part.read::<L, true>(slot)));
    }

    /// Computes as many contacts as there are lanes.
    #[inline(always)]
    fn simd<S: Simd>(&mut self, simd: S, those: &[OnWall]) {
        let WallSweep { table, rules, g, walls, part, .. } = self;
        let slot = |k: usize| those[k].slot;
        let ends = part.ends;
        let (grain, wall) = (|k: usize| ends[slot(k)][0] as usize, |k: usize| ends[slot(k)][1] as usize);
        let [x, y, z, overlap] = Lanes::columns(simd, |k| those[k].at);
        let p = Lanes::columns(simd, |k| g.pos[grain(k)]);
        let r = p[3];
        let v = Lanes::columns(simd, |k| g.vel[grain(k)]);
        let w = Lanes::columns(simd, |k| g.spin[grain(k)]);
        let [speed, ..] = Lanes::columns(simd, |k| [walls[wall(k)].speed; 4]);
        let normal = [x, y, z];
        let motion = relative_to_wall(v, w, r, normal, speed);
        let r_eff = if L::INHERITED { stiffness_radius(p, w) } else { r };
        let geometry = ContactGeometry { normal, overlap, r_eff, m_eff: r.constant(1.0) / v[3], motion };
        let pair = PairTable::lanes(simd, |k| table.wall(wall(k), g.material[grain(k)]));
        let old = part.read_lanes::<S, L, true>(simd, slot);
        part.write_lanes(simd, slot, &force::touching::<Lanes<S>, L, LEDGER, true>(&geometry, &pair, rules, &old));
    }
}
