//! A yardstick of a second: what a step of a grain and of a point takes on one thread of this machine, from which the duration of a run is
//! estimated (`laboratory::scene`). Nothing has to be made first: grains are a cubic lattice, points a cube.

use super::mpm::mpm_case;
use super::speed::run;
use super::{Case, SKIN, model, pool};
use engine::contact::ContactLaw;
use engine::dem::{State, Workspace};
use engine::grains::Grains;
use engine::material::Material;
use engine::mpm::Transfer;
use laboratory::error::Result;
use laboratory::machine::Pace;
use std::time::{Duration, Instant};
use table::median;

/// Grains along an edge of the lattice: about as much memory as a small specimen, more than the inner caches hold.
const EDGE: usize = 16;
/// Overlap of neighbours over their diameter.
const OVERLAP: f64 = 0.005;
/// Points of the cube.
const POINTS: usize = 8000;
/// Time for either case, and in how many blocks: the median counts.
const TIME: Duration = Duration::from_millis(500);
const BLOCKS: usize = 5;

/// Measures the machine, in about a second.
///
/// # Errors
/// A thread that cannot be started.
pub fn yardstick() -> Result<Pace> {
    pool(1)?.install(|| {
        let mut model = model(Case::Uniform, EDGE.pow(3), ContactLaw::Hertz, SKIN);
        // so short that the lattice, which nothing holds together, stays as it is
        model.physics.stepping.dt = Some(1e-12);
        let mut state = State::new(&model.physics, lattice(&model.physics.materials), Vec::new(), false);
        let mut work = Workspace::new(&model.physics, &mut state);
        let grain = time_of_a_step(10, |steps| {
            run(&model, &mut state, &mut work, steps);
            Ok(())
        })?;
        let (mut continuum, dt) = mpm_case(POINTS, Transfer::Blend { pic: 0.0 })?;
        let points = continuum.points().len() as f64;
        let point = time_of_a_step(1, |steps| Ok((0..steps).try_for_each(|_| continuum.step(dt))?))?;
        Ok(Pace { grain: grain / EDGE.pow(3) as f64, point: point / points })
    })
}

/// Time of one step, s, where `run` makes a number of them; `at_once` at least between two looks at the clock.
fn time_of_a_step(at_once: u64, mut run: impl FnMut(u64) -> Result<()>) -> Result<f64> {
    run(at_once)?;
    let mut blocks = Vec::new();
    for _ in 0..BLOCKS {
        let (since, mut steps) = (Instant::now(), 0);
        while steps == 0 || since.elapsed() < TIME / BLOCKS as u32 {
            run(at_once)?;
            steps += at_once;
        }
        blocks.push(since.elapsed().as_secs_f64() / steps as f64);
    }
    Ok(median(&blocks))
}

/// Equal grains at rest, each of which touches its neighbours along three axes.
fn lattice(materials: &[Material]) -> Grains {
    let r = 1e-3;
    let at = |k: usize| 2.0 * r * (1.0 - OVERLAP) * k as f64;
    let mut grains = Grains::default();
    for k in 0..EDGE.pow(3) {
        grains.add([at(k % EDGE), at(k / EDGE % EDGE), at(k / (EDGE * EDGE))], r, 0, materials);
    }
    grains
}
