//! The sweep: every pair's geometry, then its force. Parallel over slots; each slot writes only itself and reads the grains,
//! so no result depends on threads or on the order of slots.

use super::force::{self, Meeting, Memory, Motion, Rules};
use super::law::{Law, PairTable};
use super::pairs::{FREE, Pairs, Touch};
use crate::boundary::Wall;
use crate::grains::Grains;
use crate::model::{ContactModel, Model, TangentialUnloading};
use crate::with_law;

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
    work: &'a mut [[f64; 3]],
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
    fn memory<L: Law, const LEDGER: bool, const EXTRA: bool>(&mut self, s: usize) -> Memory<'_> {
        Memory {
            touch: &mut self.touch[s],
            work: if LEDGER { Some(&mut self.work[s]) } else { None },
            rolling: if EXTRA { self.rolling.get_mut(s) } else { None },
            spring: if L::VISCOUS { self.spring.get_mut(s) } else { None },
            load: if EXTRA { self.load.get_mut(s) } else { None },
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
    let single = *table.grains(0, 0);
    for_each_part(pairs, slots, rules.task, |mut part| {
        let ends = part.ends;
        for (s, &[i, j]) in ends.iter().enumerate() {
            if i == FREE {
                continue;
            }
            let (i, j) = (i as usize, j as usize);
            let (p, q) = (g.pos[i], g.pos[j]);
            let d = difference(p, q);
            let reach = p[3] + q[3];
            let distance2 = force::dot(d, d);
            let memory = part.memory::<L, LEDGER, EXTRA>(s);
            // without the root where it is not needed; an overlap that rounds to nothing is none
            let distance = if distance2 < reach * reach { distance2.sqrt() } else { reach };
            if distance >= reach {
                force::apart::<LEDGER>(|| motion(g, i, j), rules.dt, memory);
                continue;
            }
            // one division for 1/distance and 1/(r_i + r_j)
            let both = 1.0 / (distance * reach);
            let inverse = both * reach;
            let meeting = Meeting {
                normal: [d[0] * inverse, d[1] * inverse, d[2] * inverse],
                overlap: reach - distance,
                r_eff: p[3] * q[3] * (both * distance),
                m_eff: if L::VISCOUS { 1.0 / (g.vel[i][3] + g.vel[j][3]) } else { 0.0 },
                motion: motion(g, i, j),
            };
            let pair = if EXTRA { table.grains(g.material[i], g.material[j]) } else { &single };
            force::touching::<L, LEDGER, EXTRA>(&meeting, pair, rules, memory);
        }
    });
}

/// From the centre of `p` to that of `q`: the one place where displacement differences are taken.
#[inline(always)]
pub fn difference(p: [f64; 4], q: [f64; 4]) -> [f64; 3] {
    [q[0] - p[0], q[1] - p[1], q[2] - p[2]]
}

/// Motion of grain i against grain j.
#[inline(always)]
pub fn motion(g: &Grains, i: usize, j: usize) -> Motion {
    let (v, w) = (g.vel[i], g.vel[j]);
    let (a, b) = (g.spin[i], g.spin[j]);
    let (ri, rj) = (g.pos[i][3], g.pos[j][3]);
    Motion {
        centres: [v[0] - w[0], v[1] - w[1], v[2] - w[2]],
        turning: [ri * a[0] + rj * b[0], ri * a[1] + rj * b[1], ri * a[2] + rj * b[2]],
        mean_spin: [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])],
        spin_difference: [a[0] - b[0], a[1] - b[1], a[2] - b[2]],
    }
}

/// Motion of grain i against a wall that moves against `normal` (into the grains) with `speed`.
#[inline(always)]
pub fn motion_on_wall(g: &Grains, i: usize, normal: [f64; 3], speed: f64) -> Motion {
    let (v, w, r) = (g.vel[i], g.spin[i], g.pos[i][3]);
    let spin = [w[0], w[1], w[2]];
    Motion {
        centres: [v[0] + speed * normal[0], v[1] + speed * normal[1], v[2] + speed * normal[2]],
        turning: [r * w[0], r * w[1], r * w[2]],
        mean_spin: spin,
        spin_difference: spin,
    }
}

fn sweep_walls<L: Law, const LEDGER: bool>(table: &PairTable, rules: &Rules, g: &Grains, walls: &[Wall], pairs: &mut Pairs) {
    for_each_part(pairs, Slots::All, rules.task, |mut part| {
        let ends = part.ends;
        for (s, &[i, k]) in ends.iter().enumerate() {
            if i == FREE {
                continue;
            }
            let (i, k) = (i as usize, k as usize);
            let p = g.pos[i];
            let (normal, gap) = walls[k].shape.towards(p);
            let memory = part.memory::<L, LEDGER, true>(s);
            let motion = motion_on_wall(g, i, normal, walls[k].speed);
            if gap >= 0.0 {
                force::apart::<LEDGER>(|| motion, rules.dt, memory);
                continue;
            }
            let meeting = Meeting { normal, overlap: -gap, r_eff: p[3], m_eff: 1.0 / g.vel[i][3], motion };
            force::touching::<L, LEDGER, true>(&meeting, table.wall(k, g.material[i]), rules, memory);
        }
    });
}
