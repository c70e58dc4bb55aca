//! Lets half a column of dry sand, made of material points, collapse on a rough floor in plane strain, beside a plane of
//! symmetry.
//!
//! Prints for two aspect ratios a = height over length the run-out l∞/l0 and two scaling laws from experiments with columns in
//! channels: 1 + 1.2 a for a < 2.3 (Lube et al. 2005, Phys. Rev. E 72, 041301) and, of glass beads, 1 + 1.8 a for a < 3
//! (Lajeunesse et al. 2005, Phys. Fluids 17, 103302). Fails unless the run-out is at least 0.9
//! times the first law and at most 1.1 times the second, the mass is kept, and the energy does not
//! grow. `comminute verify collapse_2d` shows the influence of the resolution.
//!
//! ```text
//! cargo run --release --example column_collapse
//! ```

use comminute::{Continuum, Result, Rig, scene};

/// Length of half the column at the start, mm.
const LENGTH: f64 = 100.0;

fn main() -> Result<()> {
    println!("a      l∞/l0   1 + 1.2 a   1 + 1.8 a   steps");
    for (aspect, duration) in [(0.6, 0.5), (1.0, 0.6)] {
        let (run_out, steps) = collapse(aspect, duration)?;
        let [channel, beads] = [1.2, 1.8].map(|slope| 1.0 + slope * aspect);
        println!("{aspect:<4}   {run_out:5.3}   {channel:9.3}   {beads:9.3}   {steps:5}");
        assert!(run_out > 0.9 * channel && run_out < 1.1 * beads, "the run-out is {run_out}");
    }
    Ok(())
}

/// Run-out over the initial length after `duration` seconds, for a column `aspect` times as high as
/// long; and the number of steps.
fn collapse(aspect: f64, duration: f64) -> Result<(f64, u64)> {
    // 20 points along the length. PIC acts in each step, so that its share goes with the length of
    // the steps: 2e-4 for cells of this size, as in `verify collapse_2d`
    let changes = [
        format!("body[0].max_mm=[{LENGTH:?}, {:?}, 0.0]", aspect * LENGTH),
        "grid.cell_mm=10.0".into(),
        "grid.max_mm=[600.0, 200.0, 0.0]".into(),
        "grid.pic=2e-4".into(),
    ];
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/experiments/mpm/column_collapse_2d.toml");
    let model = scene::model(&scene::load(path, &changes)?)?;
    let Rig::Continuum(rig) = &model.rig else { unreachable!("the scene's kind is continuum") };

    let mut sand = Continuum::new(rig.settings.clone(), rig.laws.clone(), rig.points.clone())?;
    let start = sand.totals();
    let mut time = 0.0;
    while time < duration {
        let step = sand.stable_step(model.physics.stepping.safety);
        sand.step(step)?;
        time += step;
    }
    let end = sand.totals();
    assert!((end.mass / start.mass - 1.0).abs() < 1e-12, "points have been lost");
    assert!(end.kinetic + end.potential < start.potential, "energy has come from nowhere");
    Ok((1e3 * front(&sand) / LENGTH, sand.steps()))
}

/// Position of the front, m: the outermost point before the first gap wider than a cell, plus half
/// of the width that a point stands for (a quarter of a cell). Points beyond such a gap are strays.
fn front(sand: &Continuum) -> f64 {
    let cell = sand.settings().cell;
    let mut x: Vec<f64> = sand.points().position.iter().map(|p| p[0]).collect();
    x.sort_by(f64::total_cmp);
    let together = x.windows(2).find(|pair| pair[1] - pair[0] > cell).map_or(x[x.len() - 1], |pair| pair[0]);
    together + 0.25 * cell
}
