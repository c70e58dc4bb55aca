//! The sweep: every pair's geometry, then its force. Parallel over slots; each slot writes only itself and reads the grains,
//! so no result depends on threads or on the order of slots.

use super::force::{self, Meeting, Memory, Motion, Rules};
use super::law::{Law, Pair, PairTable};
use super::pairs::{FREE, Pairs, Touch};
use crate::boundary::Wall;
use crate::grains::Grains;
use crate::model::{ContactModel, Model, TangentialUnloading};
use crate::real::{Lanes, Real};
use crate::with_law;
use pulp::{Simd, WithSimd};
use std::marker::PhantomData;

/// Contacts per parallel task; up to one and a half of them threads cost more than they bring.
pub const TASK: usize = 1024;

/// Which slots a sweep takes.
#[derive(Clone, Copy)]
pub enum Slots<'a> {
    All,
    These(&'a [u32]),
}

/// Contacts of grains with grains.
pub fn grains(model: &Model, table: &PairTable, rules: &Rules, g: &Grains, pairs: &mut Pairs, slots: Slots<'_>) {
    let ledger = pairs.kept().work;
    let extra = needs_extra(&model.contact, pairs, rules, model.materials.len());
    with_law!(model.contact.law, L => match (ledger, extra) {
        (false, false) => sweep_grains::<L, false, false>(table, rules, g, pairs, slots),
        (true, false) => sweep_grains::<L, true, false>(table, rules, g, pairs, slots),
        (false, true) => sweep_grains::<L, false, true>(table, rules, g, pairs, slots),
        (true, true) => sweep_grains::<L, true, true>(table, rules, g, pairs, slots),
    })
}

/// All contacts of grains with walls.
pub fn walls(model: &Model, table: &PairTable, rules: &Rules, g: &Grains, walls: &[Wall], pairs: &mut Pairs) {
    let ledger = pairs.kept().work;
    with_law!(model.contact.law, L => match ledger {
        false => sweep_walls::<L, false>(table, rules, g, walls, pairs),
        true => sweep_walls::<L, true>(table, rules, g, walls, pairs),
    })
}

/// Whether the contacts need more than one material's normal and tangential law with a kept tangential force.
fn needs_extra(contact: &ContactModel, pairs: &Pairs, rules: &Rules, materials: usize) -> bool {
    contact.rolling || rules.unloading == TangentialUnloading::Rescale || pairs.kept().load || materials > 1
}

/// One chunk of slots, each array's part; columns that the run does not keep are empty.
struct Part<'a> {
    ends: &'a [[u32; 2]],
    touch: &'a mut [Touch],
    work: &'a mut [[f64; 4]],
    rolling: &'a mut [[f64; 3]],
    spring: &'a mut [[f64; 3]],
    load: &'a mut [f64],
}

impl<'a> Part<'a> {
    fn all(p: &'a mut Pairs) -> Part<'a> {
        Part {
            ends: &p.ends,
            touch: &mut p.touch,
            work: &mut p.work,
            rolling: &mut p.rolling,
            spring: &mut p.spring,
            load: &mut p.load,
        }
    }

    fn halves(self, at: usize) -> (Part<'a>, Part<'a>) {
        fn cut<T>(v: &mut [T], at: usize) -> (&mut [T], &mut [T]) {
            v.split_at_mut(at.min(v.len()))
        }
        let (e0, e1) = self.ends.split_at(at);
        let (t0, t1) = cut(self.touch, at);
        let (w0, w1) = cut(self.work, at);
        let (r0, r1) = cut(self.rolling, at);
        let (s0, s1) = cut(self.spring, at);
        let (l0, l1) = cut(self.load, at);
        (
            Part { ends: e0, touch: t0, work: w0, rolling: r0, spring: s0, load: l0 },
            Part { ends: e1, touch: t1, work: w1, rolling: r1, spring: s1, load: l1 },
        )
    }

    /// What slot `s` keeps. `EXTRA`: the run may have rolling moments or weighted loads.
    #[inline(always)]
    fn read<L: Law, const EXTRA: bool>(&self, s: usize) -> Memory {
        Memory {
            touch: self.touch[s],
            spring: if L::VISCOUS { Some(self.spring[s]) } else { None },
            rolling: if EXTRA { self.rolling.get(s).copied() } else { None },
            load: if EXTRA { self.load.get(s).copied() } else { None },
            work: None,
        }
    }

    #[inline(always)]
    fn write(&mut self, s: usize, m: Memory) {
        self.touch[s] = m.touch;
        for (column, value) in [(&mut *self.spring, m.spring), (&mut *self.rolling, m.rolling)] {
            if let Some(value) = value {
                column[s] = value;
            }
        }
        if let Some([path, slip, viscous]) = m.work {
            self.work[s] = [path, slip, viscous, 0.0];
        }
        if let Some(load) = m.load {
            self.load[s] = load;
        }
    }

    /// What the slots keep, one in each lane.
    #[inline(always)]
    fn read_lanes<S: Simd, L: Law, const EXTRA: bool>(&self, simd: S, slot: impl Fn(usize) -> usize) -> Memory<Lanes<S>> {
        let [x, y, z, normal_force] = Lanes::columns(simd, |k| self.touch[slot(k)].first());
        let [nx, ny, nz, overlap] = Lanes::columns(simd, |k| self.touch[slot(k)].second());
        let vectors = |column: &[[f64; 3]]| {
            let [x, y, z, _] = Lanes::columns(simd, |k| {
                let [x, y, z] = column[slot(k)];
                [x, y, z, 0.0]
            });
            [x, y, z]
        };
        Memory {
            touch: Touch { tangential: [x, y, z], normal_force, normal: [nx, ny, nz], overlap },
            spring: if L::VISCOUS { Some(vectors(self.spring)) } else { None },
            rolling: if EXTRA && !self.rolling.is_empty() { Some(vectors(self.rolling)) } else { None },
            // an outcome only: its old value is not read
            load: if EXTRA && !self.load.is_empty() { Some(overlap) } else { None },
            work: None,
        }
    }

    #[inline(always)]
    fn write_lanes<S: Simd>(&mut self, simd: S, slot: impl Fn(usize) -> usize, m: &Memory<Lanes<S>>) {
        let Touch { tangential: [x, y, z], normal_force, normal: [nx, ny, nz], overlap } = m.touch;
        Lanes::rows(simd, [x, y, z, normal_force], |k, row| self.touch[slot(k)].set_first(row));
        Lanes::rows(simd, [nx, ny, nz, overlap], |k, row| self.touch[slot(k)].set_second(row));
        for (column, value) in [(&mut *self.spring, m.spring), (&mut *self.rolling, m.rolling)] {
            if let Some([x, y, z]) = value {
                Lanes::rows(simd, [x, y, z, x], |k, [x, y, z, _]| column[slot(k)] = [x, y, z]);
            }
        }
        if let Some([path, slip, viscous]) = m.work {
            Lanes::rows(simd, [path, slip, viscous, path.constant(0.0)], |k, row| self.work[slot(k)] = row);
        }
        if let Some(load) = m.load {
            Lanes::rows(simd, [load; 4], |k, [load, ..]| self.load[slot(k)] = load);
        }
    }
}

/// Whether so many items are best done by one thread.
pub fn few(items: usize, task: usize) -> bool {
    2 * items <= 3 * task || rayon::current_num_threads() == 1
}

/// Runs `body` on the slots, cut into chunks and in parallel where there are enough.
fn for_each_part(p: &mut Pairs, slots: Slots<'_>, task: usize, body: impl Fn(Part<'_>) + Sync) {
    if let Slots::These(slots) = slots {
        for &s in slots {
            let (_, from) = Part::all(p).halves(s as usize);
            body(from.halves(1).0);
        }
        return;
    }
    let serial = few(p.slots(), task);
    let all = Part::all(p);
    if serial { body(all) } else { split(all, task, &body) }
}

/// Halves a part until it is small, the halves joined in parallel.
fn split(part: Part<'_>, task: usize, body: &(impl Fn(Part<'_>) + Sync)) {
    let n = part.ends.len();
    if n <= task {
        return body(part);
    }
    let (left, right) = part.halves(n.div_ceil(task).div_ceil(2) * task);
    rayon::join(|| split(left, task, body), || split(right, task, body));
}

fn sweep_grains<L: Law, const LEDGER: bool, const EXTRA: bool>(
    table: &PairTable,
    rules: &Rules,
    g: &Grains,
    pairs: &mut Pairs,
    slots: Slots<'_>,
) {
    for_each_part(pairs, slots, rules.task, |part| {
        rules.arch.dispatch(Sweep::<L, LEDGER, EXTRA> { table, rules, g, part, law: PhantomData });
    });
}

/// A part of the contacts of grains with grains, as many at once as the processor has lanes.
struct Sweep<'a, L, const LEDGER: bool, const EXTRA: bool> {
    table: &'a PairTable,
    rules: &'a Rules,
    g: &'a Grains,
    part: Part<'a>,
    law: PhantomData<L>,
}

impl<L: Law, const LEDGER: bool, const EXTRA: bool> WithSimd for Sweep<'_, L, LEDGER, EXTRA> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let n = self.part.ends.len();
        let lanes = Lanes::<S>::COUNT;
        let one_pair = self.table.grains(0, 0).map(|x| Lanes::constants(simd, x));
        let mut s = 0;
        while lanes > 1 && s + lanes <= n {
            if !self.together(simd, s, &one_pair) {
                for k in s..s + lanes {
                    self.alone(k);
                }
            }
            s += lanes;
        }
        for k in s..n {
            self.alone(k);
        }
    }
}

impl<L: Law, const LEDGER: bool, const EXTRA: bool> Sweep<'_, L, LEDGER, EXTRA> {
    /// The contact in slot `s`.
    #[inline(always)]
    fn alone(&mut self, s: usize) {
        let Sweep { table, rules, g, part, .. } = self;
        let [i, j] = part.ends[s];
        if i == FREE {
            return;
        }
        let (i, j) = (i as usize, j as usize);
        let (p, q) = (g.pos[i], g.pos[j]);
        let d = difference(p, q);
        let reach = p[3] + q[3];
        let distance = force::dot(d, d).sqrt();
        let old = part.read::<L, EXTRA>(s);
        // an overlap that rounds to nothing is none
        if distance < reach {
            let m_eff = if L::VISCOUS { 1.0 / (g.vel[i][3] + g.vel[j][3]) } else { 0.0 };
            let meeting = meeting(d, distance, [p[3], q[3]], m_eff, motion(g, i, j));
            let pair = if EXTRA { table.grains(g.material[i], g.material[j]) } else { table.grains(0, 0) };
            part.write(s, force::touching::<f64, L, LEDGER, EXTRA>(&meeting, pair, rules, &old));
        } else {
            part.write(s, force::apart::<LEDGER>(|| motion(g, i, j), rules.dt, &old));
        }
    }

    /// The contacts from slot `s` on, one in each lane; false, and nothing done, unless all of them touch.
    #[inline(always)]
    fn together<S: Simd>(&mut self, simd: S, s: usize, one_pair: &Pair<Lanes<S>>) -> bool {
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
        let distance = force::dot(d, d).sqrt();
        if !Lanes::all(simd, (p[3] + q[3]).above(distance)) {
            return false;
        }
        let v = [Lanes::columns(simd, |k| vel[first(k)]), Lanes::columns(simd, |k| vel[second(k)])];
        let w = [Lanes::columns(simd, |k| spin[first(k)]), Lanes::columns(simd, |k| spin[second(k)])];
        let motion = relative(v, w, [p[3], q[3]]);
        let m_eff = if L::VISCOUS { d[0].constant(1.0) / (v[0][3] + v[1][3]) } else { d[0] };
        let meeting = meeting(d, distance, [p[3], q[3]], m_eff, motion);
        let old = part.read_lanes::<S, L, EXTRA>(simd, |k| s + k);
        let pair = if EXTRA && !table.is_single() {
            &table.lanes(simd, |k| table.grains(g.material[first(k)], g.material[second(k)]))
        } else {
            one_pair
        };
        let new = force::touching::<Lanes<S>, L, LEDGER, EXTRA>(&meeting, pair, rules, &old);
        part.write_lanes(simd, |k| s + k, &new);
        true
    }
}

/// From the centre of `p` to that of `q`: the one place where displacement differences are taken.
#[inline(always)]
pub fn difference<R: Real>(p: [R; 4], q: [R; 4]) -> [R; 3] {
    [q[0] - p[0], q[1] - p[1], q[2] - p[2]]
}

/// Two spheres of radii `r` that overlap: `d` from the first centre to the second, `distance` its length.
#[inline(always)]
fn meeting<R: Real>(d: [R; 3], distance: R, r: [R; 2], m_eff: R, motion: Motion<R>) -> Meeting<R> {
    let reach = r[0] + r[1];
    // one division for 1/distance and 1/(r_i + r_j)
    let both = distance.constant(1.0) / (distance * reach);
    let normal = force::scaled(d, both * reach);
    Meeting { normal, overlap: reach - distance, r_eff: r[0] * r[1] * (both * distance), m_eff, motion }
}

/// Motion of grain i against grain j.
#[inline(always)]
pub fn motion(g: &Grains, i: usize, j: usize) -> Motion {
    relative([g.vel[i], g.vel[j]], [g.spin[i], g.spin[j]], [g.pos[i][3], g.pos[j][3]])
}

/// Motion of the first of two spheres against the second, from their velocities, spins and radii.
#[inline(always)]
fn relative<R: Real>(v: [[R; 4]; 2], w: [[R; 4]; 2], r: [R; 2]) -> Motion<R> {
    let xyz = |u: [R; 4]| [u[0], u[1], u[2]];
    let ([v0, v1], [w0, w1]) = (v.map(xyz), w.map(xyz));
    Motion {
        centres: force::less(v0, v1),
        turning: force::plus(force::scaled(w0, r[0]), force::scaled(w1, r[1])),
        mean_spin: force::plus(w0, w1).map(|x| x * 0.5),
        spin_difference: force::less(w0, w1),
    }
}

/// Motion of grain i against a wall that moves against `normal` (into the grains) with `speed`.
#[inline(always)]
pub fn motion_on_wall(g: &Grains, i: usize, normal: [f64; 3], speed: f64) -> Motion {
    relative_to_wall(g.vel[i], g.spin[i], g.pos[i][3], normal, speed)
}

#[inline(always)]
fn relative_to_wall<R: Real>(v: [R; 4], w: [R; 4], r: R, normal: [R; 3], speed: R) -> Motion<R> {
    let spin = [w[0], w[1], w[2]];
    Motion {
        centres: force::plus([v[0], v[1], v[2]], force::scaled(normal, speed)),
        turning: force::scaled(spin, r),
        mean_spin: spin,
        spin_difference: spin,
    }
}

fn sweep_walls<L: Law, const LEDGER: bool>(table: &PairTable, rules: &Rules, g: &Grains, walls: &[Wall], pairs: &mut Pairs) {
    for_each_part(pairs, Slots::All, rules.task, |part| {
        rules.arch.dispatch(WallSweep::<L, LEDGER> { table, rules, g, walls, part, law: PhantomData });
    });
}

/// A part of the contacts of grains with walls. Most of those listed do not touch: those that do are collected until they fill the lanes.
struct WallSweep<'a, L, const LEDGER: bool> {
    table: &'a PairTable,
    rules: &'a Rules,
    g: &'a Grains,
    walls: &'a [Wall],
    part: Part<'a>,
    law: PhantomData<L>,
}

/// A contact with a wall: its slot, and its normal and overlap.
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
                if lanes == 1 { self.alone(waiting[0]) } else { self.together(simd, &waiting[..lanes]) }
            }
        }
        for &one in &waiting[..n] {
            self.alone(one);
        }
    }
}

/// No instruction set has more lanes.
const MOST_LANES: usize = 8;

impl<L: Law, const LEDGER: bool> WallSweep<'_, L, LEDGER> {
    #[inline(always)]
    fn apart(&mut self, slot: usize, normal: [f64; 3]) {
        let [i, k] = self.part.ends[slot];
        let old = self.part.read::<L, true>(slot);
        // only what has just ended leaves anything to write
        if old.touch.overlap > 0.0 || LEDGER && self.part.work[slot][0] != 0.0 {
            let motion = || motion_on_wall(self.g, i as usize, normal, self.walls[k as usize].speed);
            self.part.write(slot, force::apart::<LEDGER>(motion, self.rules.dt, &old));
        }
    }

    #[inline(always)]
    fn alone(&mut self, OnWall { slot, at: [x, y, z, overlap] }: OnWall) {
        let WallSweep { table, rules, g, walls, part, .. } = self;
        let [i, k] = part.ends[slot].map(|e| e as usize);
        let normal = [x, y, z];
        let motion = motion_on_wall(g, i, normal, walls[k].speed);
        let meeting = Meeting { normal, overlap, r_eff: g.pos[i][3], m_eff: 1.0 / g.vel[i][3], motion };
        let pair = table.wall(k, g.material[i]);
        part.write(slot, force::touching::<f64, L, LEDGER, true>(&meeting, pair, rules, &part.read::<L, true>(slot)));
    }

    #[inline(always)]
    fn together<S: Simd>(&mut self, simd: S, those: &[OnWall]) {
        let WallSweep { table, rules, g, walls, part, .. } = self;
        let slot = |k: usize| those[k].slot;
        let ends = part.ends;
        let (grain, wall) = (|k: usize| ends[slot(k)][0] as usize, |k: usize| ends[slot(k)][1] as usize);
        let [x, y, z, overlap] = Lanes::columns(simd, |k| those[k].at);
        let [.., r] = Lanes::columns(simd, |k| g.pos[grain(k)]);
        let v = Lanes::columns(simd, |k| g.vel[grain(k)]);
        let w = Lanes::columns(simd, |k| g.spin[grain(k)]);
        let [speed, ..] = Lanes::columns(simd, |k| [walls[wall(k)].speed; 4]);
        let normal = [x, y, z];
        let motion = relative_to_wall(v, w, r, normal, speed);
        let meeting = Meeting { normal, overlap, r_eff: r, m_eff: r.constant(1.0) / v[3], motion };
        let pair = table.lanes(simd, |k| table.wall(wall(k), g.material[grain(k)]));
        let old = part.read_lanes::<S, L, true>(simd, slot);
        part.write_lanes(simd, slot, &force::touching::<Lanes<S>, L, LEDGER, true>(&meeting, &pair, rules, &old));
    }
}
