//! One time step: the stages in order. Nothing else knows the order.
//!
//! Leapfrog: positions and forces at full steps, velocities at half steps. A step is
//!
//! 1. contacts: force of every pair from positions and half-step velocities,
//! 2. beside it the lists: neighbours of what has moved too far, near pairs that meet,
//! 3. reactions of the walls, inertia or time step when due,
//! 4. control: what the rig does with the forces of this instant (records, wall speeds),
//! 5. grains: each sums its contacts in the order of its partners' ids, is judged, kicked and drifted; walls advance,
//! 6. crush: grains whose load exceeded their limit are replaced by daughters, in id order; what breakages have left to do goes on.
//!
//! Only + − × ÷ √ in a stated order reach the results.

pub mod birth;
pub mod event;
pub mod gather;
pub mod ledger;
pub mod mean_stress;
pub mod observables;
pub mod physics;
pub mod stability;

use crate::boundary::Wall;
use crate::contact::chunk::{self, Slots};
use crate::contact::force::Rules;
use crate::contact::pair::PairTable;
use crate::contact::pairs::{FREE, Kept, Pairs};
use crate::grains::Grains;
use crate::math::vector::dot;
use crate::neighbours::{Neighbours, Pools, flagged};
use birth::Aftermath;
use event::Breakage;
use ledger::Ledger;
use physics::Physics;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicBool, Ordering};

/// Everything a restart needs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct State {
    /// Steps done.
    pub step: u64,
    /// Time, s (in inertia-scaled runs: steps).
    pub time: f64,
    pub dt: f64,
    pub grains: Grains,
    pub pairs: Pairs,
    pub walls: Vec<Wall>,
    pub wall_pairs: Pairs,
    /// Friction between grains that replaces the materials' (preparation).
    pub friction: Option<f64>,
    /// Local damping coefficient in force.
    pub damping: f64,
    /// Whether grains may break now.
    pub crushing: bool,
    /// A stress, Pa, from which grains without contacts get their inertia (inertia scaling).
    pub reference_stress: f64,
    /// Steps between two looks at inertia or time step.
    pub stability_interval: u64,
    /// Grains were born in the last step: the time step is looked at again.
    pub births: bool,
    pub ledger: Ledger,
    pub crush_events: u64,
    /// (lost mass, kg; smallest daughter's diameter, m) of each event, for the reconstructed gradation.
    pub lost: Vec<(f64, f64)>,
    /// What breakages have left to do: radii that grow, forces that fade.
    pub aftermath: Aftermath,
    /// The next kick is a half one: velocities are those of the full step.
    pub fresh: bool,
}

/// Scratch: may be dropped and made anew between any two steps.
pub struct Workspace {
    pub neighbours: Neighbours,
    pub table: PairTable,
    moved: Vec<u32>,
    failing: Vec<u32>,
    /// Grains a contact of which has ended, and slots of contacts that have begun.
    parted: Vec<u32>,
    begun: Vec<u32>,
    flags: Vec<u8>,
    scratch: stability::InertiaBuffers,
    /// Force, N, and torque, N m, on each grain from elsewhere, for the next pass over grains; empty where there is nothing else.
    pub external_forces: Vec<[[f64; 4]; 2]>,
    /// Breakages of the last step.
    pub breakages: Vec<Breakage>,
    /// Friction the table was made for.
    table_friction: Option<f64>,
    births_since_reorder: usize,
    /// Force a path in tests: lists anew at every step, or a random order in memory.
    pub rebuild_always: bool,
    /// Contacts per parallel task; a near pair costs a quarter of a contact, a grain four times one.
    pub task: usize,
    /// The instruction set of the inner loops; changes no bit of the results.
    pub arch: pulp::Arch,
    /// Nanoseconds per stage (`bench`): neighbours, contacts, grains, crush.
    pub clock: Option<[u64; 4]>,
}

/// Name of [`Workspace`] until the last of its users has the new one.
#[doc(hidden)]
pub type Work = Workspace;

impl Workspace {
    pub fn new(physics: &Physics, state: &mut State) -> Workspace {
        let State { grains, walls, pairs, wall_pairs, .. } = state;
        let neighbours = Neighbours::new(grains, walls, &mut Pools { pairs, wall_pairs }, physics.stepping.skin);
        Workspace {
            neighbours,
            table: physics.contact.law.pairs(&physics.materials, walls, state.friction),
            moved: Vec::new(),
            failing: Vec::new(),
            parted: Vec::new(),
            begun: Vec::new(),
            flags: vec![0; state.grains.len()],
            scratch: stability::InertiaBuffers::default(),
            external_forces: Vec::new(),
            breakages: Vec::new(),
            table_friction: state.friction,
            births_since_reorder: 0,
            rebuild_always: false,
            task: chunk::TASK,
            arch: crate::math::real::arch(),
            clock: None,
        }
    }

    /// The state has become another one: all anew but what was asked for.
    pub fn restart(&mut self, physics: &Physics, state: &mut State) {
        let Workspace { rebuild_always, task, arch, clock, .. } = *self;
        *self = Workspace { rebuild_always, task, arch, clock, ..Workspace::new(physics, state) };
    }

    /// The radii have changed: grains that have outgrown their neighbourhood are searched before the next forces.
    pub fn grown(&mut self, grains: &Grains) {
        self.neighbours.account_for_growth(grains, &mut self.moved);
    }

    /// Bytes held by lists and pools, state included.
    pub fn bytes(&self, state: &State) -> usize {
        let n = state.grains.pos.capacity();
        n * (3 * 32 + 8 * 4 + 8 + 4 + 2 + 32) + state.pairs.bytes() + state.wall_pairs.bytes() + self.neighbours.bytes()
    }
}

impl State {
    /// A state without preparation: the given grains and walls at rest or moving, ledger open.
    pub fn new(physics: &Physics, grains: Grains, walls: Vec<Wall>, energy: bool) -> State {
        let kept = Kept {
            work: energy,
            rolling: physics.contact.rolling,
            spring: physics.contact.law.is_viscous(),
            largest: physics.contact.law.table().plastic,
            load: physics.crush.as_ref().is_some_and(|c| c.criterion.is_weighted()),
        };
        State {
            step: 0,
            time: 0.0,
            dt: 0.0,
            grains,
            pairs: Pairs::new(kept),
            walls,
            wall_pairs: Pairs::new(kept),
            friction: None,
            damping: physics.damping,
            crushing: false,
            reference_stress: 0.0,
            stability_interval: STABILITY_INTERVAL,
            births: false,
            ledger: Ledger::default(),
            crush_events: 0,
            lost: Vec::new(),
            aftermath: Aftermath::default(),
            fresh: true,
        }
    }
}

/// Steps between two looks at inertia or time step, unless a rig asks for more.
const STABILITY_INTERVAL: u64 = 32;

/// Advances by one step. `control` runs when the forces of this instant are known; it may change wall speeds.
pub fn step<E>(
    physics: &Physics,
    state: &mut State,
    work: &mut Workspace,
    control: impl FnOnce(&mut State, &mut Workspace) -> Result<(), E>,
) -> Result<(), E> {
    compute_forces(physics, state, work);
    control(state, work)?;
    integrate(physics, state, work);
    Ok(())
}

/// The first half of a step: the forces of this instant.
pub fn compute_forces(physics: &Physics, state: &mut State, work: &mut Workspace) {
    let mut watch = Stopwatch::new(&mut work.clock);
    tidy(state, work);
    if watch.0.is_some() {
        // apart from the sweep, to be timed
        let State { grains, walls, wall_pairs, .. } = state;
        search(&mut work.neighbours, &mut work.moved, work.rebuild_always, grains, walls, wall_pairs);
    }
    watch.lap(&mut work.clock, 0);
    contacts(physics, state, work);
    watch.lap(&mut work.clock, 1);
}

/// The second half: motion, and what breaks.
pub fn integrate(physics: &Physics, state: &mut State, work: &mut Workspace) {
    move_grains(physics, state, work);
    breakage(physics, state, work);
}

/// Grains and walls move.
pub fn move_grains(physics: &Physics, state: &mut State, work: &mut Workspace) {
    let mut watch = Stopwatch::new(&mut work.clock);
    stability::follow_fast_contacts(physics, state, work);
    state.aftermath.add_forces(&mut work.external_forces, state.grains.len());
    let half = 0.5 * state.dt;
    state.ledger.release += half * state.aftermath.power(&state.grains);
    gather::advance(physics, state, work);
    mean_stress::judge(physics, state, work);
    state.ledger.release += half * state.aftermath.power(&state.grains);
    on_one_thread(small(state, work), || collect(state, work));
    for w in &mut state.walls {
        w.advance(state.dt);
    }
    watch.lap(&mut work.clock, 2);
}

/// Grains over their limit break, and what breakages have left to do goes on; the step is done.
pub fn breakage(physics: &Physics, state: &mut State, work: &mut Workspace) {
    let mut watch = Stopwatch::new(&mut work.clock);
    on_one_thread(small(state, work), || crush(physics, state, work));
    work.external_forces.clear();
    if !state.aftermath.is_empty() {
        let criterion = physics.crush.as_ref().map(|c| &c.criterion);
        birth::advance(criterion, state, &work.neighbours, &mut work.moved);
    }
    watch.lap(&mut work.clock, 3);
    state.step += 1;
    state.time += state.dt;
    state.fresh = false;
}

/// Runs what one thread has to do alone while the others stay awake: waking a sleeping worker costs as much as a sweep of a thousand
/// contacts.
fn on_one_thread(small: bool, job: impl FnOnce() + Send) {
    if small {
        return job();
    }
    let done = AtomicBool::new(false);
    let spin = || {
        while !done.load(Ordering::Acquire) {
            std::hint::spin_loop();
        }
    };
    let job = || {
        let _ends = Ends(&done);
        job();
    };
    rayon::join(job, spin);
}

/// Tells the waiting workers that a job has ended, even by a panic.
struct Ends<'a>(&'a AtomicBool);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// Whether a step is too small for threads to bring anything.
fn small(state: &State, work: &Workspace) -> bool {
    chunk::few(state.pairs.slots(), work.task)
}

/// Grains in space order again once many were born or moved about.
fn tidy(state: &mut State, work: &mut Workspace) {
    if work.births_since_reorder * 16 > state.grains.len() || work.neighbours.searches > 2 * state.grains.len() as u64 {
        reorder(state, work);
    }
}

/// Searches the neighbourhoods of what has moved too far.
fn search(lists: &mut Neighbours, moved: &mut Vec<u32>, all: bool, grains: &Grains, walls: &[Wall], wall_pairs: &mut Pairs) {
    if all {
        moved.clear();
        moved.extend(0..grains.len() as u32);
    }
    lists.update(moved, grains, walls, wall_pairs);
    moved.clear();
}

/// Forces of all contacts at the present positions, the walls' reactions, and, when due, inertia or time step.
pub fn contacts(physics: &Physics, state: &mut State, work: &mut Workspace) {
    if work.table_friction != state.friction {
        work.table = physics.contact.law.pairs(&physics.materials, &state.walls, state.friction);
        work.table_friction = state.friction;
    }
    if state.dt == 0.0 {
        state.dt = stability::first_step(physics, state);
    }
    let rules = Rules { dt: state.dt, unloading: physics.contact.unloading, task: work.task, arch: work.arch };
    let small = small(state, work);
    let task = work.task;
    let State { grains, walls, pairs, wall_pairs, .. } = state;
    let Workspace { table, neighbours, begun, moved, rebuild_always, .. } = work;
    let table = &*table;
    // the lists change only what does not touch, which the sweep of contacts leaves alone
    let laws = physics.contact.law.table();
    let rolling = physics.contact.rolling;
    let mut sweep = || (laws.sweep_grains)(rolling, table, &rules, grains, pairs, Slots::All);
    let mut lists = || {
        search(neighbours, moved, *rebuild_always, grains, walls, wall_pairs);
        neighbours.activate_contacts(&grains.pos, 4 * task);
        (laws.sweep_walls)(table, &rules, grains, walls, wall_pairs);
    };
    if small {
        (sweep(), lists())
    } else {
        rayon::join(sweep, lists)
    };
    on_one_thread(small, || {
        neighbours.begin_contacts(grains, pairs, begun);
        (laws.sweep_grains)(rolling, table, &rules, grains, pairs, Slots::These(begun));
        reactions(physics, table, &rules, grains, walls, wall_pairs, neighbours);
    });
    state.aftermath.compute_forces(physics, &state.grains, &work.table);
    // newborn grains get their scaled inertia at birth; an unscaled time step has to follow them
    let born =
        (std::mem::take(&mut state.births) || state.aftermath.restless().next().is_some()) && !physics.stepping.inertia_scaling;
    if born || state.step.is_multiple_of(state.stability_interval) {
        stability::refresh(physics, state, work);
    }
}

fn reactions(
    physics: &Physics,
    table: &PairTable,
    rules: &Rules,
    grains: &Grains,
    walls: &mut [Wall],
    pairs: &Pairs,
    neighbours: &Neighbours,
) {
    for (k, wall) in walls.iter_mut().enumerate() {
        let (mut sum, mut stiffness, mut shear) = (0.0, 0.0, 0.0);
        for &(_, slot) in &neighbours.wall_lists[k] {
            let touch = &pairs.touch[slot as usize];
            if touch.overlap > 0.0 {
                let i = pairs.ends[slot as usize][0] as usize;
                let (force, n) = (touch.force(), touch.normal);
                sum -= dot(force, n);
                shear -= force[2] - dot(force, n) * n[2];
                let pair = table.wall(k, grains.material[i]);
                stiffness += physics
                    .contact
                    .law
                    .elastic(touch.overlap, pairs.largest(slot as usize, touch.overlap), grains.pos[i][3], pair)
                    .k_n;
            }
        }
        wall.work += 0.5 * (wall.reaction + sum) * wall.speed * rules.dt;
        wall.reaction = sum;
        wall.stiffness = stiffness;
        wall.shear_z = shear;
    }
}

/// Sorts out what the grains' pass flagged; contacts that have ended go back to the near pairs.
fn collect(state: &mut State, work: &mut Workspace) {
    let Workspace { flags, moved, failing, parted, neighbours, .. } = work;
    for list in [&mut *moved, failing, parted] {
        list.clear();
    }
    flagged(flags, |i, flag| {
        for (bit, list) in [(gather::MOVED, &mut *moved), (gather::FAILED, failing), (gather::PARTED, parted)] {
            if flag & bit != 0 {
                list.push(i);
            }
        }
    });
    for &i in &*parted {
        neighbours.end_contacts(i as usize, &state.grains, &mut state.pairs);
    }
}

fn crush(physics: &Physics, state: &mut State, work: &mut Workspace) {
    work.breakages.clear();
    if work.failing.is_empty() {
        return;
    }
    // what has just moved out of its skin is searched before daughters look for whom they touch
    let State { grains, walls, wall_pairs, .. } = state;
    search(&mut work.neighbours, &mut work.moved, false, grains, walls, wall_pairs);
    work.failing.sort_unstable_by_key(|&i| state.grains.id[i as usize]);
    let before = state.grains.len();
    state.births = true;
    let Workspace { neighbours, failing, breakages, table, external_forces, .. } = work;
    event::break_grains(physics, state, neighbours, table, external_forces, failing, breakages);
    work.births_since_reorder += state.grains.len() - before;
    work.flags.resize(state.grains.len(), 0);
}

/// Puts grains near in space near in memory (Z-order), and slots in the order of their first grain. Changes no result.
pub fn reorder(state: &mut State, work: &mut Workspace) {
    let g = &state.grains;
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in &g.pos {
        for a in 0..3 {
            low[a] = low[a].min(p[a]);
            high[a] = high[a].max(p[a]);
        }
    }
    let longest = (0..3).map(|a| high[a] - low[a]).fold(f64::MIN_POSITIVE, f64::max);
    let mut keyed: Vec<(u64, u32)> = g
        .pos
        .par_iter()
        .enumerate()
        .map(|(i, p)| {
            let cell: [u64; 3] = std::array::from_fn(|a| ((p[a] - low[a]) / longest * 1023.0) as u64);
            (spread(cell[0]) | spread(cell[1]) << 1 | spread(cell[2]) << 2, i as u32)
        })
        .collect();
    keyed.par_sort_unstable_by_key(|&(key, i)| (key, g.id[i as usize]));
    let order: Vec<u32> = keyed.into_iter().map(|(_, i)| i).collect();
    permute(state, work, &order);
}

/// Permutes memory: new index `k` holds the grain that was at `order[k]`.
pub fn permute(state: &mut State, work: &mut Workspace, order: &[u32]) {
    let mut place = vec![0u32; order.len()];
    for (k, &i) in order.iter().enumerate() {
        place[i as usize] = k as u32;
    }
    for i in &mut work.moved {
        *i = place[*i as usize];
    }
    state.grains.permute(order);
    state.aftermath.permute(&place);
    // slots in the order in which the pass over grains first meets them
    let slot_order = |pairs: &Pairs| {
        let mut slots: Vec<u32> = (0..pairs.slots() as u32).filter(|&s| pairs.ends[s as usize][0] != FREE).collect();
        slots.sort_unstable_by_key(|&s| {
            let [a, b] = pairs.ends[s as usize].map(|i| place[i as usize]);
            (a.min(b), a.max(b))
        });
        slots
    };
    let order_pairs = slot_order(&state.pairs);
    state.pairs.permute(&order_pairs, |[i, j]| [place[i as usize], place[j as usize]]);
    let mut order_walls: Vec<u32> =
        (0..state.wall_pairs.slots() as u32).filter(|&s| state.wall_pairs.ends[s as usize][0] != FREE).collect();
    order_walls.sort_unstable_by_key(|&s| {
        let [i, k] = state.wall_pairs.ends[s as usize];
        (k, place[i as usize])
    });
    state.wall_pairs.permute(&order_walls, |[i, k]| [place[i as usize], k]);
    let State { grains, pairs, wall_pairs, .. } = state;
    work.neighbours.permute(order, &place, grains, &Pools { pairs, wall_pairs });
    work.births_since_reorder = 0;
}

/// Spreads the low ten bits three apart.
fn spread(x: u64) -> u64 {
    let mut x = x & 0x3ff;
    x = (x | x << 16) & 0x0300_00ff;
    x = (x | x << 8) & 0x0300_f00f;
    x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Times the stages when asked to; otherwise reads no clock.
struct Stopwatch(Option<std::time::Instant>);

impl Stopwatch {
    fn new(clock: &mut Option<[u64; 4]>) -> Stopwatch {
        Stopwatch(clock.as_ref().map(|_| std::time::Instant::now()))
    }

    fn lap(&mut self, clock: &mut Option<[u64; 4]>, stage: usize) {
        if let (Some(since), Some(clock)) = (&mut self.0, clock.as_mut()) {
            let now = std::time::Instant::now();
            clock[stage] += (now - *since).as_nanos() as u64;
            *since = now;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_alone_does_not_leave_the_others_waiting() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
        let run = || pool.install(|| on_one_thread(false, || panic!("on purpose")));
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(run));
        assert!(outcome.is_err());
    }
}
