//! The loop over grains. Each grain sums its contact forces in the order of its partners' identities (walls last), is compared with its breakage threshold,
//! gets gravity and local damping, and is accelerated and moved. In parallel over grains; each task writes only its own grains.
//!
//! This is an inner loop: it uses lane 3 of positions (radius), velocities (inverse inertial mass) and spins directly ([`crate::grains`]).

use super::{State, Workspace};
use crate::breakage::CrushModel;
use crate::breakage::criterion::Judges;
use crate::contact::pairs::{ContactForce, Pairs};
use crate::dem::physics::Physics;
#[cfg(target_arch = "x86_64")]
use crate::math::real::Quad;
use crate::math::real::{Four, Plain, quads};
use crate::neighbours::Neighbours;
use crate::neighbours::adjacency::Link;
use crate::parallel::{few, join, middle};
use pulp::Arch;

/// Flag: the grain has left its reference sphere.
pub const MOVED: u8 = 1;
/// Flag: the grain is over its breakage threshold.
pub const FAILED: u8 = 2;
/// Flag: a contact of the grain has ended.
pub const PARTED: u8 = 4;

/// Sums over the contacts of one grain.
#[derive(Clone, Copy)]
struct ContactSums<F> {
    /// Force, N.
    force: F,
    /// Torque about the centre, N m.
    torque: F,
    /// Largest load of a contact, in the units of the breakage threshold.
    load: f64,
    /// Path, slip and viscous work in this step of the contacts of which the grain is the first end, J (with the energy ledger).
    work: F,
    /// Whether a contact with a grain has ended.
    parted: bool,
}

/// Sums the contacts of grain `i` of radius `radius`, m, in the order of its partners' identities, walls last.
#[inline(always)]
fn sum<F: Four, const LEDGER: bool>(
    token: F::Token,
    i: usize,
    radius: f64,
    neighbours: &Neighbours,
    pairs: &Pairs,
    wall_pairs: &Pairs,
) -> ContactSums<F> {
    let (half, radius) = (F::all(token, 0.5), F::all(token, radius));
    let (mut force, mut torque, mut work) = (F::all(token, 0.0), F::all(token, 0.0), F::all(token, 0.0));
    // only the fourth numbers are used: largest normal force and smallest overlap
    let (mut largest, mut smallest) = (F::all(token, 0.0), F::all(token, f64::INFINITY));
    let links = neighbours.contacts.links(i);
    let mut touching = links.len();
    for (k, &e) in links.iter().enumerate() {
        if e.is_wall() {
            touching = k;
            break;
        }
        let slot = e.slot();
        let (t, n) = halves::<F>(token, &pairs.touch[slot]);
        largest = t.max(largest);
        smallest = n.min(smallest);
        force = force + (t - t.w() * n) * F::all(token, e.sign());
        torque = torque + (radius - n.w() * half) * (n * t.yzxw() - n.yzxw() * t);
        if LEDGER {
            work = work + F::of(token, pairs.work[slot]) * F::all(token, e.first_end());
        }
    }
    let mut load = if pairs.load.is_empty() { largest.xyzw()[3] } else { heaviest(&links[..touching], &pairs.load) };
    for &e in &links[touching..] {
        let slot = e.slot();
        let (t, n) = halves::<F>(token, &wall_pairs.touch[slot]);
        force = force + (t - t.w() * n);
        torque = torque + (radius - n.w()) * (n * t.yzxw() - n.yzxw() * t);
        load = load.max(wall_pairs.load(slot));
        if LEDGER {
            work = work + F::of(token, wall_pairs.work[slot]);
        }
    }
    // with n' for n in the order y, z, x: n t' − n' t is the cross product n × t in the order z, x, y
    ContactSums { force, torque: torque.yzxw(), load, work, parted: smallest.xyzw()[3] == 0.0 }
}

/// The two registers of a contact force: tangential force with the normal force, normal with the overlap.
#[inline(always)]
fn halves<F: Four>(token: F::Token, touch: &ContactForce) -> (F, F) {
    (F::of(token, touch.first()), F::of(token, touch.second()))
}

/// The largest of the stored loads of these contacts.
fn heaviest(links: &[Link], loads: &[f64]) -> f64 {
    links.iter().map(|e| loads[e.slot()]).fold(0.0, f64::max)
}

/// The torque of grain `i` with the rolling moments of its contacts.
#[inline(always)]
fn with_rolling<F: Four>(token: F::Token, torque: F, i: usize, neighbours: &Neighbours, pairs: &Pairs, wall_pairs: &Pairs) -> F {
    let mut sum = torque;
    for &e in neighbours.contacts.links(i) {
        let of = if e.is_wall() { wall_pairs } else { pairs };
        let [x, y, z] = of.rolling[e.slot()];
        sum = sum + F::of(token, [x, y, z, 0.0]) * F::all(token, e.sign());
    }
    sum
}

/// Adds the weight of a grain to its force.
fn weigh(force: &mut [f64; 4], mass: f64, gravity: [f64; 3]) {
    for (f, g) in force.iter_mut().zip(gravity) {
        *f += mass * g;
    }
}

/// Force, N, and torque, N m, on grain `i` from contacts, rolling moments, gravity and softening contacts of broken neighbours, before damping. The torque is
/// zero if grains are kept from rotating.
pub fn force_and_torque(i: usize, physics: &Physics, state: &State, neighbours: &Neighbours) -> ([f64; 3], [f64; 3]) {
    let mut s = sum::<Plain, false>((), i, state.grains.pos[i][3], neighbours, &state.pairs, &state.wall_pairs);
    if physics.contact.rolling {
        s.torque = with_rolling((), s.torque, i, neighbours, &state.pairs, &state.wall_pairs);
    }
    let (mut f, mut t) = (s.force.xyzw(), s.torque.xyzw());
    if physics.gravity != [0.0; 3] {
        weigh(&mut f, state.grains.mass[i], physics.gravity);
    }
    if !state.aftermath.is_empty() {
        f.iter_mut().zip(state.aftermath.on(i)).for_each(|(sum, f)| *sum += f);
    }
    if !physics.contact.turning {
        t = [0.0; 4];
    }
    ([f[0], f[1], f[2]], [t[0], t[1], t[2]])
}

/// The slices of the grains' arrays that a task writes.
struct GrainSlices<'a> {
    /// Index of the first grain.
    first: usize,
    pos: &'a mut [[f64; 4]],
    vel: &'a mut [[f64; 4]],
    spin: &'a mut [[f64; 4]],
    work: &'a mut [[f64; 4]],
    flags: &'a mut [u8],
}

/// Input of the loop, read by all tasks.
struct Input<'a> {
    neighbours: &'a Neighbours,
    pairs: &'a Pairs,
    wall_pairs: &'a Pairs,
    limit: &'a [f64],
    mass: &'a [f64],
    gravity: [f64; 3],
    damping: f64,
    /// m r²/I of a sphere, 5/2; 0 if grains are kept from rotating.
    turning: f64,
    /// Time over which positions change, s.
    dt: f64,
    /// Time over which velocities change, s: from the middle of the last step to that of this one.
    kick: f64,
    /// Force, N, and torque, N m, on each grain besides those of contacts; empty if there are none.
    external_forces: &'a [[[f64; 4]; 2]],
    task: usize,
    arch: Arch,
}

/// Whether grains are compared with their thresholds in this step, and by a criterion that judges `by` (contacts or mean stress).
pub(super) fn judged(physics: &Physics, state: &State, by: Judges) -> bool {
    // every `interval` steps
    let now = |c: &CrushModel| c.criterion.judges() == by && state.step.is_multiple_of(c.interval);
    state.crushing && physics.crush.as_ref().is_some_and(now)
}

/// Compares all grains with their breakage thresholds, accelerates and moves them, and writes a flag for each.
pub fn advance(physics: &Physics, state: &mut State, work: &mut Workspace) {
    let kick = work.kick.take().unwrap_or(if state.fresh { 0.5 * state.dt } else { state.dt });
    let Workspace { neighbours, flags, external_forces, task, arch, .. } = work;
    let (task, arch) = (*task, *arch);
    let ledger = state.pairs.kept().work;
    let crush = judged(physics, state, Judges::Contacts);
    let State { grains, pairs, wall_pairs, .. } = state;
    let input = Input {
        neighbours,
        pairs,
        wall_pairs,
        limit: &grains.breakage_threshold,
        mass: &grains.mass,
        gravity: physics.gravity,
        damping: state.damping,
        turning: if physics.contact.turning { 2.5 } else { 0.0 },
        dt: state.dt,
        kick,
        external_forces,
        task,
        arch,
    };
    let part =
        GrainSlices { first: 0, pos: &mut grains.pos, vel: &mut grains.vel, spin: &mut grains.spin, work: &mut grains.work, flags };
    match (ledger, crush, physics.contact.rolling) {
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

/// Runs the loop, in parallel if there are enough grains.
fn run<const LEDGER: bool, const CRUSH: bool, const ROLLING: bool>(input: &Input<'_>, part: GrainSlices<'_>) {
    if few(part.pos.len(), input.task) {
        return dispatch::<LEDGER, CRUSH, ROLLING>(input, part);
    }
    split::<LEDGER, CRUSH, ROLLING>(input, part);
}

/// Divides the grains into tasks.
fn split<const LEDGER: bool, const CRUSH: bool, const ROLLING: bool>(input: &Input<'_>, part: GrainSlices<'_>) {
    let n = part.pos.len();
    if n <= input.task {
        return dispatch::<LEDGER, CRUSH, ROLLING>(input, part);
    }
    let half = middle(n);
    let (p0, p1) = part.pos.split_at_mut(half);
    let (v0, v1) = part.vel.split_at_mut(half);
    let (s0, s1) = part.spin.split_at_mut(half);
    let (w0, w1) = part.work.split_at_mut(half);
    let (f0, f1) = part.flags.split_at_mut(half);
    let left = GrainSlices { first: part.first, pos: p0, vel: v0, spin: s0, work: w0, flags: f0 };
    let right = GrainSlices { first: part.first + half, pos: p1, vel: v1, spin: s1, work: w1, flags: f1 };
    join(|| split::<LEDGER, CRUSH, ROLLING>(input, left), || split::<LEDGER, CRUSH, ROLLING>(input, right));
}

/// Chooses code with or without external forces.
fn dispatch<const LEDGER: bool, const CRUSH: bool, const ROLLING: bool>(input: &Input<'_>, part: GrainSlices<'_>) {
    // a test at each grain would cost 4 % of a step in runs without external forces
    if input.external_forces.is_empty() {
        vectorised::<LEDGER, CRUSH, ROLLING, false>(input, part);
    } else {
        vectorised::<LEDGER, CRUSH, ROLLING, true>(input, part);
    }
}

/// Chooses SIMD or plain code.
fn vectorised<const LEDGER: bool, const CRUSH: bool, const ROLLING: bool, const EXTERNAL: bool>(
    input: &Input<'_>,
    part: GrainSlices<'_>,
) {
    match quads(input.arch) {
        #[cfg(target_arch = "x86_64")]
        Some(v3) => v3.vectorize(
            #[inline(always)]
            || chunk::<Quad, LEDGER, CRUSH, ROLLING, EXTERNAL>(v3, input, part),
        ),
        _ => chunk::<Plain, LEDGER, CRUSH, ROLLING, EXTERNAL>((), input, part),
    }
}

/// The loop over the grains of one task.
#[inline(always)]
fn chunk<F: Four, const LEDGER: bool, const CRUSH: bool, const ROLLING: bool, const EXTERNAL: bool>(
    token: F::Token,
    input: &Input<'_>,
    part: GrainSlices<'_>,
) {
    let references = &input.neighbours.references()[part.first..][..part.pos.len()];
    let gravity = input.gravity != [0.0; 3];
    let all = |x| F::all(token, x);
    let (drift, kick, damping, turning) = (all(input.dt), all(input.kick), all(input.damping), all(input.turning));
    let rows = part.pos.iter_mut().zip(part.vel).zip(part.spin).zip(part.flags).zip(references).enumerate();
    for (k, ((((pos, vel), spin), flag), reference)) in rows {
        let i = part.first + k;
        let (p, v) = (F::of(token, *pos), F::of(token, *vel));
        let external = if EXTERNAL { input.external_forces.get(i) } else { None };
        if !gravity && external.is_none() && input.neighbours.contacts.links(i).is_empty() {
            // a grain without contacts, as most fragments: only its position changes
            let p = (p + v * drift).with_w_of(p);
            *pos = p.xyzw();
            *flag = if Neighbours::has_left(reference, p, token) { MOVED } else { 0 };
            continue;
        }
        let mut sums = sum::<F, LEDGER>(token, i, pos[3], input.neighbours, input.pairs, input.wall_pairs);
        if ROLLING {
            sums.torque = with_rolling(token, sums.torque, i, input.neighbours, input.pairs, input.wall_pairs);
        }
        if let Some(&[force, torque]) = external {
            sums.force = sums.force + F::of(token, force);
            sums.torque = sums.torque + F::of(token, torque);
        }
        if gravity {
            let mut f = sums.force.xyzw();
            weigh(&mut f, input.mass[i], input.gravity);
            sums.force = F::of(token, f);
        }
        let (f, t, s) = (sums.force, sums.torque, F::of(token, *spin));
        let inverse_mass = v.w();
        // I = 2/5 m r^2
        let inverse_inertia = turning * inverse_mass / (p.w() * p.w());
        // local non-viscous damping of each component, −α |F| sign(v) (Ciantia et al. 2015, after Cundall 1987)
        let (df, dt) = ((f * damping).against(v), (t * damping).against(s));
        let new_v = (v + (f + df) * kick * inverse_mass).with_w_of(v);
        let new_s = (s + (t + dt) * kick * inverse_inertia).with_w_of(s);
        let p = (p + new_v * drift).with_w_of(p);
        (*pos, *vel, *spin) = (p.xyzw(), new_v.xyzw(), new_s.xyzw());
        if LEDGER {
            let [x, y, z, _] = (all(0.5) * (df * (v + new_v) + dt * (s + new_s)) * drift).xyzw();
            let [path, slip, viscous, _] = sums.work.xyzw();
            let work = &mut part.work[k];
            *work = [work[0] + path, work[1] + slip, work[2] + viscous, work[3] + (0.0 - x - y - z)];
        }
        let mut flags = if sums.parted { PARTED } else { 0 };
        if Neighbours::has_left(reference, p, token) {
            flags |= MOVED;
        }
        if CRUSH && sums.load > input.limit[i] {
            flags |= FAILED;
        }
        *flag = flags;
    }
}
