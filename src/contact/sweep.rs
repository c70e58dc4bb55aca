//! The sweep: every pair's geometry, then its force. Parallel over slots; each slot writes only itself and reads the grains,
//! so no result depends on threads or on the order of slots.

use super::force::{self, Meeting, Memory, Motion, Rules};
use super::law::{Law, PairTable};
use super::pairs::{FREE, Pairs};
use crate::boundary::Wall;
use crate::grains::Grains;
use crate::model::{ContactModel, Model, TangentialUnloading};
use crate::with_law;

/// Slots per parallel task, and the number of slots below which threads cost more than they bring.
const CHUNK: usize = 1024;
const SERIAL: usize = 1536;

/// All contacts of grains with grains.
pub fn grains(model: &Model, table: &PairTable, rules: &Rules, g: &Grains, pairs: &mut Pairs) {
    let ledger = !pairs.work.is_empty();
    let extra = needs_extra(&model.contact, rules, model.materials.len());
    with_law!(model.contact.law, L => match (ledger, extra) {
        (false, false) => sweep_grains::<L, false, false>(table, rules, g, pairs),
        (true, false) => sweep_grains::<L, true, false>(table, rules, g, pairs),
        (false, true) => sweep_grains::<L, false, true>(table, rules, g, pairs),
        (true, true) => sweep_grains::<L, true, true>(table, rules, g, pairs),
    })
}

/// All contacts of grains with walls.
pub fn walls(model: &Model, table: &PairTable, rules: &Rules, g: &Grains, walls: &[Wall], pairs: &mut Pairs) {
    let ledger = !pairs.work.is_empty();
    with_law!(model.contact.law, L => match ledger {
        false => sweep_walls::<L, false>(table, rules, g, walls, pairs),
        true => sweep_walls::<L, true>(table, rules, g, walls, pairs),
    })
}

/// Whether the contacts need more than one material's normal and tangential law with a kept tangential force.
fn needs_extra(contact: &ContactModel, rules: &Rules, materials: usize) -> bool {
    contact.rolling || rules.unloading == TangentialUnloading::Rescale || rules.hertz_area || materials > 1
}

/// One chunk of slots, each array's part.
struct Part<'a> {
    ends: &'a [[u32; 2]],
    history: &'a mut [[f64; 4]],
    touch: &'a mut [super::pairs::Touch],
    work: &'a mut [[f64; 3]],
    rolling: &'a mut [[f64; 3]],
}

/// Cuts the slots into chunks and runs `body` on each, in parallel where there are enough.
fn for_each_part(p: &mut Pairs, body: impl Fn(Part<'_>) + Sync) {
    let slots = p.slots();
    if slots <= SERIAL || rayon::current_num_threads() == 1 {
        return body(Part {
            ends: &p.ends,
            history: &mut p.history,
            touch: &mut p.touch,
            work: &mut p.work,
            rolling: &mut p.rolling,
        });
    }
    split(Part { ends: &p.ends, history: &mut p.history, touch: &mut p.touch, work: &mut p.work, rolling: &mut p.rolling }, &body);
}

/// Halves a part until it is small, the halves joined in parallel.
fn split(part: Part<'_>, body: &(impl Fn(Part<'_>) + Sync)) {
    let n = part.ends.len();
    if n <= CHUNK {
        return body(part);
    }
    let half = n.div_ceil(CHUNK).div_ceil(2) * CHUNK;
    fn at<T>(v: &mut [T], k: usize) -> (&mut [T], &mut [T]) {
        let k = k.min(v.len());
        v.split_at_mut(k)
    }
    let (e0, e1) = part.ends.split_at(half);
    let (h0, h1) = at(part.history, half);
    let (t0, t1) = at(part.touch, half);
    let (w0, w1) = at(part.work, half);
    let (r0, r1) = at(part.rolling, half);
    rayon::join(
        || split(Part { ends: e0, history: h0, touch: t0, work: w0, rolling: r0 }, body),
        || split(Part { ends: e1, history: h1, touch: t1, work: w1, rolling: r1 }, body),
    );
}

fn sweep_grains<L: Law, const LEDGER: bool, const EXTRA: bool>(table: &PairTable, rules: &Rules, g: &Grains, pairs: &mut Pairs) {
    let single = *table.grains(0, 0);
    for_each_part(pairs, |part| {
        for (s, &[i, j]) in part.ends.iter().enumerate() {
            if i == FREE {
                continue;
            }
            let (i, j) = (i as usize, j as usize);
            let (p, q) = (g.pos[i], g.pos[j]);
            let d = difference(p, q);
            let reach = p[3] + q[3];
            let distance2 = force::dot(d, d);
            let mut memory = Memory {
                history: &mut part.history[s],
                touch: &mut part.touch[s],
                work: if LEDGER { Some(&mut part.work[s]) } else { None },
                rolling: None,
            };
            if EXTRA && !part.rolling.is_empty() {
                memory.rolling = Some(&mut part.rolling[s]);
            }
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
    for_each_part(pairs, |part| {
        for (s, &[i, k]) in part.ends.iter().enumerate() {
            if i == FREE {
                continue;
            }
            let (i, k) = (i as usize, k as usize);
            let p = g.pos[i];
            let (normal, gap) = walls[k].shape.towards(p);
            let mut memory = Memory {
                history: &mut part.history[s],
                touch: &mut part.touch[s],
                work: if LEDGER { Some(&mut part.work[s]) } else { None },
                rolling: None,
            };
            if !part.rolling.is_empty() {
                memory.rolling = Some(&mut part.rolling[s]);
            }
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
