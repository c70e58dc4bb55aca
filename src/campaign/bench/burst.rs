//! The cost of breakages: in each step one grain is broken into 14, with the changes of neighbours,
//! history and ledger.

use super::breakable;
use engine::dem;
use engine::dem::{State, Workspace};
use laboratory::error::Result;
use laboratory::model::Model;
use std::convert::Infallible;
use std::time::Instant;
use table::median;

/// The cost of a series of breakages.
#[derive(Clone, Debug)]
pub struct Burst {
    /// Number of breakages.
    pub events: usize,
    /// Median time of one breakage itself, s. The mean, below, contains the growth of arrays.
    pub each: f64,
    /// Mean time of one breakage itself, s.
    pub mean: f64,
    /// Seconds of neighbour work per step while grains break (mean).
    pub neighbours: f64,
    /// Seconds by which a step with a breakage is longer than one without (mean: what daughters cost afterwards is in it).
    pub extra: f64,
}

/// Steps without breakages, to compare with.
const PLAIN: usize = 50;

/// Breaks up to `events` loaded grains, one in each step, on the pool of the calling thread.
///
/// # Errors
/// None with a packing of the bench.
pub fn burst(model: &Model, mut state: State, events: usize) -> Result<Burst> {
    let model = &breakable(model)?;
    let mut work = Workspace::new(&model.physics, &mut state);
    let advance = |state: &mut State, work: &mut Workspace| {
        let Ok(()) = dem::step(&model.physics, state, work, |_, _| Ok::<(), Infallible>(()));
    };
    state.crushing = true;
    for _ in 0..PLAIN {
        advance(&mut state, &mut work);
    }
    let since = Instant::now();
    for _ in 0..PLAIN {
        advance(&mut state, &mut work);
    }
    let plain = since.elapsed().as_secs_f64() / PLAIN as f64;

    let victims = victims(&state, &work, events);
    let mut broken = Vec::with_capacity(victims.len());
    work.clock = Some([0; 4]);
    let mut whole = 0.0;
    for id in victims {
        // re-ordering may have moved the grain
        let Some(i) = state.grains.id.iter().position(|&j| j == id) else { continue };
        state.grains.breakage_threshold[i] = 0.0;
        let before = work.clock.unwrap_or_default()[3];
        let since = Instant::now();
        advance(&mut state, &mut work);
        whole += since.elapsed().as_secs_f64();
        if work.breakages.len() == 1 {
            broken.push(1e-9 * (work.clock.unwrap_or_default()[3] - before) as f64);
        }
    }
    let steps = broken.len().max(1) as f64;
    let clock = work.clock.unwrap_or_default().map(|ns| 1e-9 * ns as f64 / steps);
    Ok(Burst { events: broken.len(), each: median(&broken), mean: clock[3], neighbours: clock[0], extra: whole / steps - plain })
}

/// Ids of up to `events` grains that touch at least four others, spread over the specimen.
fn victims(state: &State, work: &Workspace, events: usize) -> Vec<u32> {
    let n = state.grains.len();
    let loaded: Vec<u32> = (0..n)
        .filter(|&i| {
            let touching = |e: &engine::neighbours::adjacency::Entry| !e.is_wall() && state.pairs.touch[e.slot()].overlap > 0.0;
            work.neighbours.contacts.of(i).filter(touching).count() >= 4
        })
        .map(|i| state.grains.id[i])
        .collect();
    let stride = (loaded.len() / events.max(1)).max(1);
    loaded.into_iter().step_by(stride).take(events).collect()
}
