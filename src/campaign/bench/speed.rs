//! Speed of the engine for grains: grain-steps per second, memory, and the share of each stage.

use super::machine::round_trip;
use super::{Demand, Machine, Packing, start};
use engine::contact::pairs::{FREE, Pairs};
use engine::dem;
use engine::dem::observables::{love_weber, sums};
use engine::dem::{State, Workspace};
use laboratory::error::{Error, Result};
use laboratory::model::Model;
use laboratory::rig::cylinder::{Stresses, space};
use std::convert::Infallible;
use std::time::Instant;
use table::median;

/// Numbers of steps to measure.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Steps before the first timed block.
    pub warm_up: u64,
    /// Steps of one timed block.
    pub steps: u64,
    /// Number of timed blocks.
    pub repeats: usize,
    /// Steps of the pass with clocks.
    pub clocked: u64,
}

/// Results of a measurement.
#[derive(Clone, Debug)]
pub struct Speed {
    /// Grain-steps per second of each block, in their order.
    pub blocks: Vec<f64>,
    /// Grain-steps per second of processor time of each block, all threads together, where the system tells: on a busy machine
    /// the better figure for one thread (waiting threads spin, so for several it says less).
    pub cpu_blocks: Vec<f64>,
    /// Number of steps done when stresses and hash were taken.
    pub steps: u64,
    /// Memory for each grain with its contacts, bytes.
    pub bytes_per_grain: f64,
    /// Touching pairs of grains, per grain.
    pub touching: f64,
    /// Pairs in the neighbour lists, per grain.
    pub near: f64,
    /// Contacts with walls, per grain.
    pub wall_touching: f64,
    /// Grain-wall pairs in the neighbour lists, per grain.
    pub wall_near: f64,
    /// Nanoseconds per grain-step: neighbours, contacts, grains, crush (from the pass with clocks).
    pub stages: [f64; 4],
    /// Number of searches for the neighbours of single grains during the timed blocks.
    pub searches: u64,
    /// Vertical stress averaged over the volume, from contacts between grains only, Pa.
    pub stress_volume: f64,
    /// Vertical stress at the platens, Pa.
    pub stress_platens: f64,
    /// Radial stress at the cylinder, Pa.
    pub stress_radial: f64,
    /// Hash of every position, velocity and spin, in the order of ids: the same for any number of
    /// threads.
    pub hash: u64,
    /// For the stage of contacts and that of grains: operations per second over the machine's
    /// limit, and bytes per second over its bandwidth.
    pub roofline: [[f64; 2]; 2],
    /// Load average of the last minute before and after, where the system tells.
    pub load: [Option<f64>; 2],
    /// Time for a number to go from one thread to another and back, s, before and after; `None` on one thread. Where two threads share a cache it is about 50 ns.
    pub round_trip: [Option<f64>; 2],
}

impl Speed {
    /// Median grain-steps per second.
    pub fn median(&self) -> f64 {
        median(&self.blocks)
    }

    /// Median grain-steps per second of processor time; `None` where the system does not tell.
    pub fn cpu_median(&self) -> Option<f64> {
        (!self.cpu_blocks.is_empty()).then(|| median(&self.cpu_blocks))
    }

    /// Share of each stage in the step.
    pub fn shares(&self) -> [f64; 4] {
        let all: f64 = self.stages.iter().sum();
        self.stages.map(|s| if all > 0.0 { s / all } else { 0.0 })
    }
}

/// Steps the packing on as many threads as the machine was measured with; returns the speed and the
/// state at the end.
///
/// # Errors
/// Threads that cannot be started, or a packing that becomes unstable.
pub fn measure(model: &Model, packing: &Packing, machine: &Machine, plan: &Plan) -> Result<(Speed, State)> {
    pool(machine.threads)?.install(|| timed(model, packing, machine, plan))
}

/// A pool of `threads` threads to measure on.
///
/// # Errors
/// Threads that cannot be started.
pub fn pool(threads: usize) -> Result<rayon::ThreadPool> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| Error::Failed { step: 0, what: format!("cannot start {threads} threads: {e}") })
}

fn timed(model: &Model, packing: &Packing, machine: &Machine, plan: &Plan) -> Result<(Speed, State)> {
    let before = (load_average(), round_trip());
    let (mut state, mut work) = start(model, packing, false);
    let n = state.grains.len() as f64;
    run(model, &mut state, &mut work, plan.warm_up);
    let (mut searches, mut blocks, mut cpu_blocks) = (0, Vec::new(), Vec::new());
    for _ in 0..plan.repeats {
        let (since, cpu) = (Instant::now(), cpu_seconds());
        searches += run(model, &mut state, &mut work, plan.steps);
        let grain_steps = n * plan.steps as f64;
        blocks.push(grain_steps / since.elapsed().as_secs_f64());
        cpu_blocks.extend(cpu.zip(cpu_seconds()).map(|(from, to)| grain_steps / (to - from)));
    }
    let after = (load_average(), round_trip());
    let hash = hash(&state);
    let steps = state.step;

    let mut ended = state.clone();
    // forces at this instant, from which the stresses are taken
    dem::contacts(&model.physics, &mut state, &mut work);
    let size = space(&state);
    let (vertical, _) = love_weber(&state, &work, size.radius, size.bottom, size.bottom + size.height);
    let stresses = Stresses::of(&state);
    let sums = sums(&model.physics, &state, &work);
    if !(vertical.is_finite() && stresses.vertical().is_finite()) {
        let what = format!("the packing of the bench has become unstable: its stress is not finite (dt {:e} s)", state.dt);
        return Err(Error::Unstable { step: state.step, what, grain: None });
    }
    let bytes = work.bytes(&state) as f64;

    let mut work = Workspace::new(&model.physics, &mut ended);
    run(model, &mut ended, &mut work, 50);
    work.clock = Some([0; 4]);
    run(model, &mut ended, &mut work, plan.clocked);
    let clocked = n * plan.clocked.max(1) as f64;
    let stages = work.clock.unwrap_or_default().map(|ns| ns as f64 / clocked);

    let touching = sums.contacts as f64 / n;
    let demands = [Demand::contacts(touching), Demand::grains(touching)];
    let roofline = std::array::from_fn(|k| machine.shares(demands[k], 1e-9 * stages[k + 1]));

    let speed = Speed {
        blocks,
        cpu_blocks,
        steps,
        bytes_per_grain: bytes / n,
        touching,
        near: (listed(&state.pairs) + work.neighbours.near_pairs() as f64) / n,
        wall_touching: sums.wall_contacts as f64 / n,
        wall_near: listed(&state.wall_pairs) / n,
        stages,
        searches,
        stress_volume: vertical,
        stress_platens: stresses.vertical(),
        stress_radial: stresses.horizontal,
        hash,
        roofline,
        load: [before.0, after.0],
        round_trip: [before.1, after.1],
    };
    Ok((speed, ended))
}

/// Does `steps` steps; returns the number of searches for neighbours in them.
pub(super) fn run(model: &Model, state: &mut State, work: &mut Workspace, steps: u64) -> u64 {
    let (mut searches, mut last) = (0, work.neighbours.searches);
    for _ in 0..steps {
        let Ok(()) = dem::step(&model.physics, state, work, |_, _| Ok::<(), Infallible>(()));
        let now = work.neighbours.searches;
        // re-ordering of memory sets the counter back to zero
        searches += now.checked_sub(last).unwrap_or(now);
        last = now;
    }
    searches
}

fn listed(pairs: &Pairs) -> f64 {
    pairs.ends.iter().filter(|e| e[0] != FREE).count() as f64
}

/// FNV-1a over the bits of positions, velocities and spins in the order of ids.
fn hash(state: &State) -> u64 {
    let g = &state.grains;
    let mut h = 0xcbf2_9ce4_8422_2325_u64;
    for &i in &g.by_id() {
        let i = i as usize;
        for x in g.pos[i].iter().chain(&g.vel[i]).chain(&g.spin[i]) {
            for byte in x.to_bits().to_le_bytes() {
                h = (h ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        }
    }
    h
}

/// Processor time of all threads of this process, s (Linux).
pub(super) fn cpu_seconds() -> Option<f64> {
    let mut sum = 0.0;
    for task in std::fs::read_dir("/proc/self/task").ok()? {
        let text = std::fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        sum += text.split_whitespace().next()?.parse::<f64>().ok()?;
    }
    (sum > 0.0).then_some(1e-9 * sum)
}

/// Load average of the last minute (Linux).
pub fn load_average() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/loadavg").ok()?;
    text.split_whitespace().next()?.parse().ok()
}
