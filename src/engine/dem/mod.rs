//! One time step of the grains: the stages in order. No other module knows the order.
//!
//! The integration is a leapfrog: positions and forces are those of full steps, velocities those of half steps. The stages of a step are
//!
//! 1. contact forces of every pair, from positions and velocities;
//! 2. in parallel with them, neighbour lists: search around grains that have moved too far, find listed pairs that begin to touch; then contacts with walls and
//!    their reactions;
//! 3. contacts that begin; inertial masses or the time step when due;
//! 4. control: the test looks at the forces of this instant (records, wall speeds);
//! 5. motion: each grain sums its contacts in the order of its partners' identities, is compared with its breakage threshold, and is accelerated and
//!    moved; walls move;
//! 6. breakage: grains over their thresholds are replaced by daughters, in the order of identities; the consequences of earlier breakages go on.
//!
//! Results depend only on + − × ÷ √ in a stated order.

pub mod birth;
pub mod event;
pub mod gather;
pub mod ledger;
pub mod mean_stress;
pub mod observables;
pub mod physics;
pub mod stability;

use crate::boundary::Wall;
use crate::check::{self, Checked, below, ensure};
use crate::contact::chunk::{self, Chunk};
use crate::contact::force::Rules;
use crate::contact::pair::PairTable;
use crate::contact::pairs::{FREE, Kept, Pairs};
use crate::grains::Grains;
use crate::math::vector::dot;
use crate::neighbours::{Half, Neighbours, Pools, WallList, flagged};
use crate::parallel::{self, join, middle};
use birth::Aftermath;
use event::Breakage;
use ledger::Ledger;
use physics::Physics;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// The state of the grains, their contacts and walls: all that a restart needs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct State {
    /// Number of steps done.
    pub step: u64,
    /// Time, s; with inertia scaling the number of steps.
    pub time: f64,
    /// Present time step, s; with inertia scaling 1. 0 before the first step.
    pub dt: f64,
    /// The grains.
    pub grains: Grains,
    /// Contacts between grains.
    pub pairs: Pairs,
    /// The walls.
    pub walls: Vec<Wall>,
    /// Contacts of grains with walls.
    pub wall_pairs: Pairs,
    /// Coefficient of friction between grains during preparation; `None`: that of the materials.
    pub friction: Option<f64>,
    /// Present coefficient of local damping.
    pub damping: f64,
    /// Whether grains may break now.
    pub crushing: bool,
    /// With inertia scaling: stress, Pa, that gives grains without contacts their inertial mass ([`stability`]).
    pub reference_stress: f64,
    /// Number of steps between two updates of inertial masses or of the time step.
    pub stability_interval: u64,
    /// Whether grains were born in the last step, so that the time step has to be computed again.
    pub births: bool,
    /// Energies that are not counted at a grain or wall.
    pub ledger: Ledger,
    /// Number of breakages so far.
    pub crush_events: u64,
    /// Of each breakage: lost mass, kg, and diameter of the smallest daughter, m, for the reconstructed gradation.
    pub lost: Vec<(f64, f64)>,
    /// Consequences of breakages that are still going on: growing daughters, softening contacts.
    pub aftermath: Aftermath,
    /// Whether velocities are those of the full step (at the start), so that the next change of velocity is over half a step.
    pub fresh: bool,
}

/// Neighbour lists and buffers; may be dropped and made again between any two steps.
pub struct Workspace {
    /// Lists of pairs of grains.
    pub neighbours: Neighbours,
    /// Parameters of the contacts for each pair of materials and each wall.
    pub table: PairTable,
    /// Indices of grains that have left their reference spheres.
    moved: Vec<u32>,
    /// Indices of grains over their breakage thresholds.
    failing: Vec<u32>,
    /// Indices of grains with a contact that has ended.
    parted: Vec<u32>,
    /// Slots of contacts that have begun.
    begun: Vec<u32>,
    /// Of each grain: flags of the loop over grains ([`gather`]).
    flags: Vec<u8>,
    /// Buffers for inertial masses.
    scratch: stability::InertiaBuffers,
    /// Force, N, and torque, N m, on each grain from points, rigid bodies and softening contacts, for the coming step; empty if there are none.
    pub external_forces: Vec<[[f64; 4]; 2]>,
    /// Time over which forces change velocities in the coming step, s; `None`: that of the step, or half of it in the first.
    pub kick: Option<f64>,
    /// Breakages of the last step.
    pub breakages: Vec<Breakage>,
    /// [`State::friction`] for which `table` was made.
    table_friction: Option<f64>,
    /// Number of grains born since grains were last sorted in memory.
    births_since_reorder: usize,
    /// For tests: makes all lists anew at every step.
    pub rebuild_always: bool,
    /// Number of contacts, or of grains, in a parallel task. A pair that does not touch costs about a quarter of a contact.
    pub task: usize,
    /// Instruction set of the inner loops; changes no bit of the results.
    pub arch: pulp::Arch,
    /// For benches: time spent in neighbour lists, contacts, motion of grains and breakage, ns; `None`: no clock is read.
    pub clock: Option<[u64; 4]>,
}

impl Workspace {
    /// Lists and buffers for a state. The list of contacts with walls in `state` may change.
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
            kick: None,
            breakages: Vec::new(),
            table_friction: state.friction,
            births_since_reorder: 0,
            rebuild_always: false,
            task: chunk::TASK,
            arch: crate::math::real::arch(),
            clock: None,
        }
    }

    /// [`Workspace::new`] after the grains, and contacts with them, were sorted in memory by their place.
    pub fn sorted(physics: &Physics, state: &mut State) -> Workspace {
        let mut work = Workspace::new(physics, state);
        reorder(state, &mut work);
        work
    }

    /// Makes lists and buffers anew for a state that was changed from outside; keeps the settings of tests and benches.
    pub fn restart(&mut self, physics: &Physics, state: &mut State) {
        let Workspace { rebuild_always, task, arch, clock, .. } = *self;
        *self = Workspace { rebuild_always, task, arch, clock, ..Workspace::new(physics, state) };
    }

    /// To be called after radii were changed from outside: grains that are not inside their reference spheres any more are searched before the next forces.
    pub fn grown(&mut self, grains: &Grains) {
        self.neighbours.account_for_growth(grains, &mut self.moved);
    }

    /// Memory in use by lists and state, bytes.
    pub fn bytes(&self, state: &State) -> usize {
        let n = state.grains.pos.capacity();
        n * (3 * 32 + 8 * 4 + 8 + 4 + 2 + 32) + state.pairs.bytes() + state.wall_pairs.bytes() + self.neighbours.bytes()
    }
}

impl State {
    /// A state at its start, with the given grains and walls. `energy`: whether contacts keep account of their work for the energy ledger.
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

impl State {
    /// Checks a state that comes from outside. `made` is a state of the same run as it was made, with grains or without: it tells which walls there are and what
    /// contacts keep.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, physics: &Physics, made: &State) -> Checked {
        let State { grains: g, pairs, walls, wall_pairs, ledger, aftermath, lost, .. } = self;
        check::counters("steps", &[self.step, self.crush_events])?;
        check::not_negative("times", [self.time])?;
        let dt = self.dt;
        check::not_negative("time steps", [dt])?;
        let scaled = physics.stepping.inertia_scaling;
        ensure(dt == 0.0 || if scaled { dt == 1.0 } else { dt.is_normal() }, || format!("the time step is {dt:e}"))?;
        check::not_negative("friction", self.friction)?;
        check::all("damping", [self.damping], "not from 0 to 1", |x| (0.0..=1.0).contains(&x))?;
        check::not_negative("reference stress", [self.reference_stress])?;
        let interval = self.stability_interval;
        ensure((1..=STABILITY_INTERVAL).contains(&interval), || format!("the time step is looked at every {interval} steps"))?;
        ensure(!self.crushing || physics.crush.is_some(), || "grains break which cannot".into())?;
        check::lengths("walls", made.walls.len(), [walls.len()])?;
        walls.iter().zip(&made.walls).try_for_each(|(wall, made)| wall.check(made))?;
        g.check(physics.materials.len())?;
        pairs.check(&g.id, g.len(), true, made.pairs.kept())?;
        wall_pairs.check(&g.id, walls.len(), false, made.wall_pairs.kept())?;
        // every identity is that of a grain which is there or has broken
        ensure(g.next_id as u64 == g.len() as u64 + self.crush_events, || {
            format!("{} grains and {} breakages do not make {} identities", g.len(), self.crush_events, g.next_id)
        })?;
        let counted = physics.crush.as_ref().is_none_or(|c| !c.keeps_mass);
        let losses = if counted { self.crush_events as usize } else { 0 };
        check::lengths("breakages", losses, [lost.len()])?;
        check::numbers("lost masses", lost.iter().flat_map(|l| [l.0, l.1]))?;
        g.born.iter().try_for_each(|born| below("born at step", *born, self.step as usize + 1))?;
        ledger.check()?;
        aftermath.check(g, physics.materials.len())
    }
}

/// Number of steps between two updates of inertial masses or of the time step, unless a test sets another.
const STABILITY_INTERVAL: u64 = 32;

/// Makes one step. `control` is called when the forces of this instant are known, and may change wall speeds.
///
/// # Errors
/// The error of `control`; the grains have not moved then.
///
/// # Example
/// Two equal spheres meet head-on without loss: each leaves with the velocity of the other.
///
/// ```
/// use comminute_engine::contact::ContactLaw;
/// use comminute_engine::dem::{State, Workspace, physics::Physics, step};
/// use comminute_engine::{grains::Grains, material::Material};
///
/// let quartz = Material {
///     name: "quartz".into(),
///     density: 2650.0,
///     internal_porosity: 0.0,
///     young: 70e9,
///     poisson: 0.17,
///     friction: 0.4,
///     contact: [0.0; 4], // Hertz's law asks for nothing more
///     rolling_friction: 0.0,
///     interface_friction: None,
/// };
/// let physics = Physics::of(vec![quartz], ContactLaw::Hertz);
/// let mut grains = Grains::default();
/// for (x, velocity) in [(-1.001e-3, 0.5), (1.001e-3, -0.5)] {
///     let i = grains.add([x, 0.0, 0.0], 1e-3, 0, &physics.materials);
///     grains.vel[i][0] = velocity;
/// }
/// let walls = Vec::new();
/// let mut state = State::new(&physics, grains, walls, false);
/// let mut work = Workspace::new(&physics, &mut state);
/// let mut largest_force = 0.0_f64;
/// while state.time < 2e-5 {
///     step(&physics, &mut state, &mut work, |state, _| {
///         let forces = state.pairs.touch.iter().map(|contact| contact.force()[0].abs());
///         largest_force = forces.fold(largest_force, f64::max);
///         Ok::<(), std::convert::Infallible>(())
///     })?;
/// }
/// // Hertz: 4/3 E* √R* δ^(3/2) with the largest overlap δ of the impact
/// let (modulus, radius, mass) = (0.5 * 70e9 / (1.0 - 0.17 * 0.17), 0.5e-3_f64, 0.5 * state.grains.mass[0]);
/// let overlap = (15.0 * mass / (16.0 * modulus * radius.sqrt())).powf(0.4);
/// let expected = 4.0 / 3.0 * modulus * radius.sqrt() * overlap.powf(1.5);
/// assert!((largest_force / expected - 1.0).abs() < 0.02, "{largest_force} N instead of {expected} N");
/// assert!((state.grains.vel[0][0] + 0.5).abs() < 1e-3 && (state.grains.vel[1][0] - 0.5).abs() < 1e-3);
/// # Ok::<(), std::convert::Infallible>(())
/// ```
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

/// First half of a step: computes the forces of this instant.
pub fn compute_forces(physics: &Physics, state: &mut State, work: &mut Workspace) {
    let mut watch = Stopwatch::new(&mut work.clock);
    tidy(state, work);
    if watch.0.is_some() {
        // before the forces and not in parallel with them, to be timed
        let State { dt, grains, walls, wall_pairs, .. } = state;
        search(&mut work.neighbours, &mut work.moved, work.rebuild_always, *dt, grains, walls, wall_pairs);
    }
    watch.lap(&mut work.clock, 0);
    contacts(physics, state, work);
    watch.lap(&mut work.clock, 1);
}

/// Second half of a step: moves grains and walls, then breaks grains.
pub fn integrate(physics: &Physics, state: &mut State, work: &mut Workspace) {
    move_grains(physics, state, work);
    breakage(physics, state, work);
}

/// Moves grains and walls by one step.
pub fn move_grains(physics: &Physics, state: &mut State, work: &mut Workspace) {
    let mut watch = Stopwatch::new(&mut work.clock);
    awake(small(state, work), || accelerate(physics, state, work));
    for w in &mut state.walls {
        w.advance(state.dt);
    }
    watch.lap(&mut work.clock, 2);
}

/// Moves grains by one step, and collects what that has flagged.
fn accelerate(physics: &Physics, state: &mut State, work: &mut Workspace) {
    stability::follow_fast_contacts(physics, state, work);
    state.aftermath.add_forces(&mut work.external_forces, state.grains.len());
    let half = 0.5 * state.dt;
    state.ledger.release += half * state.aftermath.power(&state.grains);
    gather::advance(physics, state, work);
    mean_stress::judge(physics, state, work);
    state.ledger.release += half * state.aftermath.power(&state.grains);
    collect(state, work);
}

/// Breaks the grains over their thresholds, continues the consequences of earlier breakages, and ends the step.
pub fn breakage(physics: &Physics, state: &mut State, work: &mut Workspace) {
    let mut watch = Stopwatch::new(&mut work.clock);
    awake(small(state, work), || {
        crush(physics, state, work);
        work.external_forces.clear();
        if !state.aftermath.is_empty() {
            let criterion = physics.crush.as_ref().map(|c| &c.criterion);
            birth::advance(criterion, state, &work.neighbours, &mut work.moved);
        }
    });
    watch.lap(&mut work.clock, 3);
    state.step += 1;
    state.time += state.dt;
    state.fresh = false;
}

/// Runs `job`, which has parts for one thread and for several, while another thread stays awake; in a `small` step, which has parts for one alone, it is simply
/// run.
fn awake(small: bool, job: impl FnOnce() + Send) {
    if small { job() } else { parallel::awake(job) }
}

/// Does both jobs, in a `small` step one after the other.
fn both(small: bool, here: impl FnOnce() + Send, there: impl FnOnce() + Send) {
    if small {
        here();
        there();
    } else {
        join(here, there);
    }
}

/// Whether a step has too few contacts for several threads to be of use.
fn small(state: &State, work: &Workspace) -> bool {
    parallel::few(state.pairs.slots(), work.task)
}

/// Leaves no gaps between contacts in memory, and sorts grains there when many were born or many searches were needed since the last time.
fn tidy(state: &mut State, work: &mut Workspace) {
    work.neighbours.close_gaps(&state.grains, &mut state.pairs);
    if work.births_since_reorder * 16 > state.grains.len() || work.neighbours.searches > 2 * state.grains.len() as u64 {
        reorder(state, work);
    }
}

/// Renews the lists around the grains `moved` (or around all grains), and empties that list. `dt`: time step, s.
fn search(
    lists: &mut Neighbours,
    moved: &mut Vec<u32>,
    all: bool,
    dt: f64,
    grains: &Grains,
    walls: &[Wall],
    wall_pairs: &mut Pairs,
) {
    if all {
        moved.clear();
        moved.extend(0..grains.len() as u32);
    }
    lists.update(moved, dt, grains, walls, wall_pairs);
    moved.clear();
}

/// Computes the forces of all contacts at the present positions, the walls' reactions and, when due, inertial masses or the time step.
pub fn contacts(physics: &Physics, state: &mut State, work: &mut Workspace) {
    if work.table_friction != state.friction {
        work.table = physics.contact.law.pairs(&physics.materials, &state.walls, state.friction);
        work.table_friction = state.friction;
    }
    if state.dt == 0.0 {
        state.dt = stability::first_step(physics, state);
    }
    let weighs_radius = physics.crush.as_ref().is_none_or(|c| c.criterion.weighs_radius());
    let rules = Rules { dt: state.dt, unloading: physics.contact.unloading, weighs_radius, task: work.task, arch: work.arch };
    let small = small(state, work);
    awake(small, || sweep(physics, small, &rules, state, work));
    state.aftermath.compute_forces(physics, &state.grains, &work.table);
    // with inertia scaling newborn grains get their inertial mass at birth; without, the time step has to be computed again
    let born =
        (std::mem::take(&mut state.births) || state.aftermath.restless().next().is_some()) && !physics.stepping.inertia_scaling;
    if born || state.step.is_multiple_of(state.stability_interval) {
        stability::refresh(physics, state, work);
    }
}

/// Computes the forces of all contacts, brings the lists up to date, and sums the walls' reactions. In a step that is not `small` each of two threads computes
/// the contacts of the half of the grains that it also moves ([`crate::parallel`]): the lists are searched before the first half, and what else there is
/// follows the second.
fn sweep(physics: &Physics, small: bool, rules: &Rules, state: &mut State, work: &mut Workspace) {
    let State { grains, walls, pairs, wall_pairs, .. } = state;
    let Workspace { table, neighbours, begun, moved, rebuild_always, .. } = work;
    let (grains, table) = (&*grains, &*table);
    let laws = physics.contact.law.table();
    let forces = |slots: Chunk<'_>| (laws.sweep_grains)(physics.contact.rolling, table, rules, grains, slots);
    let half = middle(pairs.slots());
    let (first, second) = Chunk::all(pairs).halves(half);
    // the lists change only pairs that do not touch, which the computation of contact forces does not read
    let first_and_lists = || {
        search(neighbours, moved, *rebuild_always, rules.dt, grains, walls, wall_pairs);
        let ([near, far], wall_lists) = neighbours.apart();
        let touching = |pairs: Half<'_>| pairs.mark_touching(&grains.pos, 4 * rules.task);
        let of_first = || {
            forces(first);
            touching(near);
        };
        let of_second = || {
            touching(far);
            (laws.sweep_walls)(table, rules, grains, walls, wall_pairs);
            reactions(physics, table, rules, grains, walls, wall_pairs, wall_lists);
        };
        both(small, of_first, of_second);
    };
    both(small, first_and_lists, || forces(second));
    neighbours.begin_contacts(grains, pairs, begun);
    for &slot in &*begun {
        forces(Chunk::one(pairs, slot));
    }
}

/// Reaction, stiffness and work of each wall, from its contacts in the order of identities.
fn reactions(
    physics: &Physics,
    table: &PairTable,
    rules: &Rules,
    grains: &Grains,
    walls: &mut [Wall],
    pairs: &Pairs,
    lists: &[WallList],
) {
    for (k, wall) in walls.iter_mut().enumerate() {
        let (mut sum, mut stiffness, mut shear) = (0.0, 0.0, 0.0);
        for &(_, slot) in &lists[k] {
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
                    .elastic(touch.overlap, pairs.largest(slot as usize, touch.overlap), grains.radius(i), pair)
                    .k_n;
            }
        }
        wall.work += 0.5 * (wall.reaction + sum) * wall.speed * rules.dt;
        wall.reaction = sum;
        wall.stiffness = stiffness;
        wall.shear_z = shear;
    }
}

/// Collects the grains that were flagged by the loop over grains, and ends the contacts that do not touch any more.
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
    // lists have to be valid before daughters look for neighbours
    let State { dt, grains, walls, wall_pairs, .. } = state;
    search(&mut work.neighbours, &mut work.moved, false, *dt, grains, walls, wall_pairs);
    work.failing.sort_unstable_by_key(|&i| state.grains.id[i as usize]);
    let before = state.grains.len();
    state.births = true;
    let Workspace { neighbours, failing, breakages, table, external_forces, .. } = work;
    event::break_grains(physics, state, neighbours, table, external_forces, failing, breakages);
    work.births_since_reorder += state.grains.len() - before;
    work.flags.resize(state.grains.len(), 0);
}

/// Sorts grains in memory along a space-filling curve (Z-order), and contacts in the order of their grains. Changes no bit of a result.
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

/// Sorts grains in memory: entry `k` becomes the grain that was at `order[k]`. Contacts and lists follow. Changes no bit of a result.
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
    // contacts in the order in which a loop over grains first comes to them
    let slot_order = |pairs: &Pairs| {
        let mut slots: Vec<u32> = (0..pairs.slots() as u32).filter(|&s| pairs.ends[s as usize][0] != FREE).collect();
        slots.par_sort_unstable_by_key(|&s| {
            let [a, b] = pairs.ends[s as usize].map(|i| place[i as usize]);
            (a.min(b), a.max(b))
        });
        slots
    };
    let order_pairs = slot_order(&state.pairs);
    state.pairs.permute(&order_pairs, |[i, j]| [place[i as usize], place[j as usize]]);
    let mut order_walls: Vec<u32> =
        (0..state.wall_pairs.slots() as u32).filter(|&s| state.wall_pairs.ends[s as usize][0] != FREE).collect();
    order_walls.par_sort_unstable_by_key(|&s| {
        let [i, k] = state.wall_pairs.ends[s as usize];
        (k, place[i as usize])
    });
    state.wall_pairs.permute(&order_walls, |[i, k]| [place[i as usize], k]);
    let State { grains, pairs, wall_pairs, .. } = state;
    work.neighbours.permute(order, &place, grains, &Pools { pairs, wall_pairs });
    work.births_since_reorder = 0;
}

/// Spreads the lowest ten bits so that each is followed by two zeros, for the key of the Z-order.
fn spread(x: u64) -> u64 {
    let mut x = x & 0x3ff;
    x = (x | x << 16) & 0x0300_00ff;
    x = (x | x << 8) & 0x0300_f00f;
    x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Measures the time of stages for benches; reads no clock otherwise.
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
    use crate::boundary::{Drive, WallShape, WallSpec};
    use crate::contact::ContactLaw;
    use crate::material::Material;

    /// Two grains that touch each other and a wall, some steps after their start.
    fn moved() -> (Physics, State) {
        let stuff = Material {
            name: "stuff".into(),
            density: 2000.0,
            internal_porosity: 0.0,
            young: 1e9,
            poisson: 0.2,
            friction: 0.5,
            contact: [0.0; 4],
            rolling_friction: 0.0,
            interface_friction: None,
        };
        let physics = Physics { gravity: [0.0, 0.0, -9.81], ..Physics::of(vec![stuff], ContactLaw::Hertz) };
        let mut grains = Grains::default();
        for x in [-0.9999e-3, 0.9999e-3] {
            grains.add([x, 0.0, 0.9999e-3], 1e-3, 0, &physics.materials);
        }
        let shape = WallShape::Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
        let wall = Wall::new(&WallSpec { shape, friction: 0.2, drive: Drive::Fixed, material: None });
        let mut state = State::new(&physics, grains, vec![wall], true);
        let mut work = Workspace::new(&physics, &mut state);
        for _ in 0..10 {
            step(&physics, &mut state, &mut work, |_, _| Ok::<(), std::convert::Infallible>(())).expect("a step");
        }
        (physics, state)
    }

    type Change = fn(&mut State);

    /// What no run has made is refused in words that name it.
    #[test]
    fn a_state_that_no_run_has_made_is_refused() {
        let (physics, whole) = moved();
        assert_eq!((whole.pairs.slots(), whole.wall_pairs.slots()), (1, 2));
        let made = State::new(&physics, Grains::default(), whole.walls.clone(), true);
        assert_eq!(whole.check(&physics, &made), Ok(()));
        let changes: [(&str, Change); 19] = [
            ("contact 0 names grain 300 of 2", |s| s.pairs.ends[0][0] = 300),
            ("contact 0 names 1 of 1", |s| s.wall_pairs.ends[0][1] = 1),
            ("not in their order", |s| s.pairs.ends[0].swap(0, 1)),
            ("a contact stands twice", |s| s.wall_pairs.ends[1] = s.wall_pairs.ends[0]),
            ("free places", |s| s.pairs.ends[0] = [FREE; 2]),
            ("list 0 has 2 entries for 1", |s| s.pairs.touch.push(Default::default())),
            ("other values than the scene asks for", |s| s.pairs = Pairs::new(Kept::default())),
            ("value 3: NaN", |s| s.wall_pairs.touch[0].normal_force = f64::NAN),
            ("grains: list 3 has 1 entries for 2", |s| s.grains.mass.truncate(1)),
            ("grain 1 stands twice", |s| s.grains.id = vec![1, 1]),
            ("material 9 of 1", |s| s.grains.material[0] = 9),
            ("radii of grains, value 1", |s| s.grains.pos[1][3] = -1e-3),
            ("places of grains, value 0: 1e300", |s| s.grains.pos[0][0] = 1e300),
            ("do not make 4000000000 identities", |s| s.grains.next_id = 4_000_000_000),
            ("time step is 5e-324", |s| s.dt = 5e-324),
            ("no number that can be reached by counting", |s| s.step = u64::MAX - 1),
            ("grains break which cannot", |s| s.crushing = true),
            ("a wall is not that of the scene", |s| s.walls[0].friction = 0.3),
            ("growing grain 2 of 2", |s| s.aftermath.grow(2, 1e-3, 1e-6)),
        ];
        for (expected, change) in changes {
            let mut state = whole.clone();
            change(&mut state);
            let told = state.check(&physics, &made).expect_err(expected);
            assert!(told.contains(expected), "{told} instead of {expected}");
        }
    }

    /// Grains that were in any order are in that of their places, and move as they would have.
    #[test]
    fn sorting_changes_the_order_in_memory_only() {
        let (physics, state) = moved();
        let advance = |mut state: State, start: fn(&Physics, &mut State) -> Workspace| {
            let mut work = start(&physics, &mut state);
            for _ in 0..10 {
                step(&physics, &mut state, &mut work, |_, _| Ok::<(), std::convert::Infallible>(())).expect("a step");
            }
            state.grains
        };
        let mut any = state.clone();
        let mut work = Workspace::new(&physics, &mut any);
        permute(&mut any, &mut work, &[1, 0]);
        let (sorted, any) = (advance(any.clone(), Workspace::sorted), advance(any, Workspace::new));
        assert_eq!((&sorted.id, &any.id), (&vec![0, 1], &vec![1, 0]));
        assert!((0..2).all(|i| sorted.pos[i] == any.pos[1 - i] && sorted.vel[i] == any.vel[1 - i]));
    }
}
