//! The pass over grains: each sums its contacts in the order of its partners' ids (walls last), is judged against its
//! limit, gets local damping and gravity, is kicked and drifted. Parallel over grains; each writes only itself.

use super::State;
use crate::contact::pairs::Pairs;
use crate::contact::sweep::few;
use crate::model::Model;
use crate::neighbours::Neighbours;

/// Flag: the grain has used up its skin.
pub const MOVED: u8 = 1;
/// Flag: the grain's load exceeds its limit.
pub const FAILED: u8 = 2;
/// Flag: a contact of the grain has ended.
pub const PARTED: u8 = 4;

/// Sums over the contacts of one grain.
#[derive(Clone, Copy, Default)]
pub struct Sums {
    /// Force, N, and torque, N m.
    force: [f64; 3],
    torque: [f64; 3],
    /// Largest load, in the units of the area model.
    load: f64,
    /// Path, slip, viscous work of the contacts whose first end the grain is, J (with the ledger).
    work: [f64; 3],
    /// Whether a contact with a grain has ended.
    parted: bool,
}

/// Sums the contacts of grain `i` in the order of its partners' ids. Without branches but for walls, which come last.
#[inline(always)]
fn sum<const LEDGER: bool>(i: usize, radius: f64, neighbours: &Neighbours, pairs: &Pairs, wall_pairs: &Pairs) -> Sums {
    let mut s = Sums::default();
    for &e in neighbours.contacts.links(i) {
        let slot = e.slot();
        let (pool, first, sink) = if e.is_wall() { (wall_pairs, 1.0, 1.0) } else { (pairs, e.first_end(), 0.5) };
        let touch = &pool.touch[slot];
        let (force, torque) = (touch.force(), touch.torque());
        let sign = 2.0 * first - 1.0;
        let arm = radius - sink * touch.overlap;
        for a in 0..3 {
            s.force[a] += sign * force[a];
            s.torque[a] += arm * torque[a];
        }
        s.parted |= touch.overlap == 0.0 && !e.is_wall();
        let load = pool.load(slot);
        s.load = if load > s.load { load } else { s.load };
        if LEDGER {
            for (sum, work) in s.work.iter_mut().zip(pool.work[slot]) {
                *sum += first * work;
            }
        }
    }
    s
}

/// Adds rolling moments, where the run has them.
fn add_rolling(t: &mut [f64; 3], i: usize, neighbours: &Neighbours, pairs: &Pairs, wall_pairs: &Pairs) {
    for &e in neighbours.contacts.links(i) {
        let slot = e.slot();
        let (moment, sign) = match (e.is_wall(), e.second_end()) {
            (true, _) => (wall_pairs.rolling[slot], 1.0),
            (false, false) => (pairs.rolling[slot], 1.0),
            (false, true) => (pairs.rolling[slot], -1.0),
        };
        for a in 0..3 {
            t[a] += sign * moment[a];
        }
    }
}

fn weigh(force: &mut [f64; 3], mass: f64, gravity: [f64; 3]) {
    for (f, g) in force.iter_mut().zip(gravity) {
        *f += mass * g;
    }
}

/// Force and torque on grain `i` from contacts and gravity (before damping), with rolling where the run has it.
pub fn force_and_torque(i: usize, model: &Model, state: &State, neighbours: &Neighbours) -> ([f64; 3], [f64; 3]) {
    let Sums { force: mut f, torque: mut t, .. } =
        sum::<false>(i, state.grains.pos[i][3], neighbours, &state.pairs, &state.wall_pairs);
    if model.contact.rolling {
        add_rolling(&mut t, i, neighbours, &state.pairs, &state.wall_pairs);
    }
    if model.gravity != [0.0; 3] {
        weigh(&mut f, state.grains.mass[i], model.gravity);
    }
    (f, t)
}

/// Cundall's local non-viscous damping of one component (Ciantia et al. 2015, after Cundall 1987): −α |F| sign(v).
#[inline(always)]
fn damping_force(force: f64, velocity: f64, coefficient: f64) -> f64 {
    let opposed = (-coefficient * force.abs()).copysign(-velocity);
    if velocity == 0.0 { 0.0 } else { opposed }
}

struct Part<'a> {
    first: usize,
    pos: &'a mut [[f64; 4]],
    vel: &'a mut [[f64; 4]],
    spin: &'a mut [[f64; 4]],
    work: &'a mut [[f64; 4]],
    flags: &'a mut [u8],
}

/// What the pass reads.
struct Input<'a> {
    neighbours: &'a Neighbours,
    pairs: &'a Pairs,
    wall_pairs: &'a Pairs,
    limit: &'a [f64],
    mass: &'a [f64],
    gravity: [f64; 3],
    damping: f64,
    /// Step of the drift, and of the kick (half of it on the first step).
    dt: f64,
    kick: f64,
    task: usize,
}

/// Judges, kicks and drifts all grains, so many to a parallel task; leaves a flag per grain.
pub fn advance(model: &Model, state: &mut State, neighbours: &Neighbours, flags: &mut [u8], task: usize) {
    let ledger = state.pairs.kept().work;
    let crush = state.crushing;
    let State { grains, pairs, wall_pairs, .. } = state;
    let input = Input {
        neighbours,
        pairs,
        wall_pairs,
        limit: &grains.limit,
        mass: &grains.mass,
        gravity: model.gravity,
        damping: state.damping,
        dt: state.dt,
        kick: if state.fresh { 0.5 * state.dt } else { state.dt },
        task,
    };
    let part = Part { first: 0, pos: &mut grains.pos, vel: &mut grains.vel, spin: &mut grains.spin, work: &mut grains.work, flags };
    match (ledger, crush, model.contact.rolling) {
        (false, false, false) => run::<false, false, false>(&input, part),
        (true, false, false) => run::<true, false, false>(&input, part),
        (false, true, false) => run::<false, true, false>(&input, part),
        (true, true, false) => run::<true, true, false>(&input, part),
        (false, false, true) => run::<false, false, true>(&input, part),
        (true, false, true) => run::<true, false, true>(&input, part),
        (false, true, true) => run::<false, true, true>(&input, part),
        (true, true, true) => run::<true, true, true>(&input, part),
    }
}

fn run<const LEDGER: bool, const CRUSH: bool, const ROLLING: bool>(input: &Input<'_>, part: Part<'_>) {
    if few(part.pos.len(), input.task) {
        return chunk::<LEDGER, CRUSH, ROLLING>(input, part);
    }
    split::<LEDGER, CRUSH, ROLLING>(input, part);
}

fn split<const LEDGER: bool, const CRUSH: bool, const ROLLING: bool>(input: &Input<'_>, part: Part<'_>) {
    let n = part.pos.len();
    if n <= input.task {
        return chunk::<LEDGER, CRUSH, ROLLING>(input, part);
    }
    let half = n.div_ceil(input.task).div_ceil(2) * input.task;
    let (p0, p1) = part.pos.split_at_mut(half);
    let (v0, v1) = part.vel.split_at_mut(half);
    let (s0, s1) = part.spin.split_at_mut(half);
    let (w0, w1) = part.work.split_at_mut(half);
    let (f0, f1) = part.flags.split_at_mut(half);
    let left = Part { first: part.first, pos: p0, vel: v0, spin: s0, work: w0, flags: f0 };
    let right = Part { first: part.first + half, pos: p1, vel: v1, spin: s1, work: w1, flags: f1 };
    rayon::join(|| split::<LEDGER, CRUSH, ROLLING>(input, left), || split::<LEDGER, CRUSH, ROLLING>(input, right));
}

fn chunk<const LEDGER: bool, const CRUSH: bool, const ROLLING: bool>(input: &Input<'_>, part: Part<'_>) {
    let references = input.neighbours.references();
    let gravity = input.gravity != [0.0; 3];
    for k in 0..part.pos.len() {
        let i = part.first + k;
        let (p, v, s) = (&mut part.pos[k], &mut part.vel[k], &mut part.spin[k]);
        if !gravity && input.neighbours.contacts.links(i).is_empty() {
            // most fragments fly free: nothing but their place changes, and nothing else is read
            for a in 0..3 {
                p[a] += v[a] * input.dt;
            }
            part.flags[k] = if Neighbours::outside(&references[i], p) { MOVED } else { 0 };
            continue;
        }
        let Sums { force: mut f, torque: mut t, load, work, parted } =
            sum::<LEDGER>(i, p[3], input.neighbours, input.pairs, input.wall_pairs);
        if ROLLING {
            add_rolling(&mut t, i, input.neighbours, input.pairs, input.wall_pairs);
        }
        if gravity {
            weigh(&mut f, input.mass[i], input.gravity);
        }
        let inverse_mass = v[3];
        // I = 2/5 m r^2
        let inverse_inertia = 2.5 * inverse_mass / (p[3] * p[3]);
        let mut damped = 0.0;
        for a in 0..3 {
            let d = damping_force(f[a], v[a], input.damping);
            let before = v[a];
            v[a] += (f[a] + d) * input.kick * inverse_mass;
            p[a] += v[a] * input.dt;
            let dt = damping_force(t[a], s[a], input.damping);
            let spin_before = s[a];
            s[a] += (t[a] + dt) * input.kick * inverse_inertia;
            if LEDGER {
                damped -= 0.5 * (d * (before + v[a]) + dt * (spin_before + s[a])) * input.dt;
            }
        }
        if LEDGER {
            let w = &mut part.work[k];
            *w = [w[0] + work[0], w[1] + work[1], w[2] + work[2], w[3] + damped];
        }
        let mut flag = if parted { PARTED } else { 0 };
        if Neighbours::outside(&references[i], p) {
            flag |= MOVED;
        }
        if CRUSH && load > input.limit[i] {
            flag |= FAILED;
        }
        part.flags[k] = flag;
    }
}
