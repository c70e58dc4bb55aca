//! Checks that end a run whose state is no longer meaningful, before its numbers become infinite.

use crate::error::{Error, Result};
use crate::model::continuum::MpmTest;
use crate::model::{Assembly, Model, Rig};
use crate::record::continuum::Recorder;
use crate::record::cylinder::AtEnd;
use crate::rig::continuum;
use crate::scene::wave_step;
use engine::dem::{State, Workspace, stability};
use engine::math::vector::dot;

/// Largest share of all energy given that may appear from nothing (a negative `dissipated_share`). Measured: less than 0.001 in
/// the scenes, and less than 1e-4 in cubes of 4 to 16 cells without damping and PIC.
const CREATED: f64 = 0.05;
/// Largest difference of the forces on opposite platens over their mean. At 1 the resultant on the specimen is as large as if one
/// of the platens were missing.
const APART: f64 = 1.0;

/// Checks the last row of a continuum between platens.
///
/// # Errors
/// [`Error::Impossible`] for a negative void ratio; for a test of points alone that is under way, also for energy from nothing
/// and for opposite platens out of balance.
pub fn continuum(rig: &MpmTest, state: &continuum::State, row: &Recorder) -> Result<()> {
    if rig.specimen().is_none() {
        return Ok(());
    }
    let impossible = |what: String| Err(Error::Impossible { step: state.continuum.steps(), what });
    // without points the void ratio is that of grains, whose overlaps may fill the whole volume
    if !state.continuum.points().is_empty() && (row.void_ratio.is_nan() || row.void_ratio < 0.0) {
        return impossible(format!(
            "the void ratio is {:.4} at an axial strain of {:.4}: the solids fill more than the whole volume, which the constitutive law does not prevent; \
             lower test.axial_strain or use a stiffer law; if strains are small, lower stepping.safety or raise damping.local",
            row.void_ratio, row.last[0]
        ));
    }
    if state.mixture.is_some() || !row.under_way(rig, state.phase) {
        return Ok(());
    }
    unbalanced(row.dissipated, row.difference).map_or(Ok(()), impossible)
}

/// What is wrong with a test, in words: `dissipated` is the share of all energy given that was dissipated, `difference` that of
/// the forces on opposite platens over their mean. `None`: nothing is wrong.
fn unbalanced(dissipated: f64, difference: f64) -> Option<String> {
    let change = "lower stepping.safety, raise damping.local (0.1) or grid.pic (0.1)";
    if dissipated.is_nan() || dissipated < -CREATED {
        return Some(format!(
            "dissipated_share is {dissipated:.4}, below {:.2}: energy comes from nothing, which is the sign of a growing oscillation; {change}",
            -CREATED
        ));
    }
    if difference.is_nan() || difference > APART {
        return Some(format!(
            "the forces on opposite platens differ by {difference:.2} of their mean (platen_difference), more than {APART}: the test is not quasi-static; {change}, or lower test.strain_per_wave"
        ));
    }
    None
}

/// Checks the voids of a specimen of grains at its last row.
///
/// # Errors
/// [`Error::Impossible`] when the solid part of all dry mass, the pores inside the grains excluded, would fill more than the
/// whole volume; not with `records.stop_without_voids = false`.
pub fn voids(model: &Model, step: u64, row: &AtEnd) -> Result<()> {
    if row.void_ratio_star >= 0.0 || !model.records.stop_without_voids {
        return Ok(());
    }
    let what = format!(
        "the void ratio of all dry mass, the pores inside the grains counted as voids, is {:.4} at an axial strain of {:.4}: the solids would fill more than the whole volume (mass lost by breakages \
         bears no stress, and the volume of overlaps counts twice); stop at a lower stress, use stronger grains or keep the mass (crushing.lost_mass = \"points\" in an oedometer, or \"grow\"), \
         or go on with records.stop_without_voids = false",
        row.void_ratio_star, row.axial_strain
    );
    Err(Error::Impossible { step, what })
}

/// Compares the kinetic energy of a free scene of points, with grains or without, with all energy that it was ever given.
///
/// # Errors
/// [`Error::Unstable`] when the kinetic energy is larger.
pub fn kinetic_of_points(rig: &MpmTest, state: &continuum::State) -> Result<()> {
    if rig.specimen().is_some() {
        return Ok(());
    }
    let Some([now, possible, scale]) = state.kinetic(rig) else { return Ok(()) };
    if now <= possible + ABOVE * scale {
        return Ok(());
    }
    let points = state.continuum.points();
    let speed = |i: &usize| points.velocity[*i][..3].iter().map(|v| v * v).sum::<f64>();
    let fastest = (0..points.len()).max_by(|i, j| speed(i).total_cmp(&speed(j)));
    let fastest =
        fastest.map_or(String::new(), |i| format!(". The fastest point is {} with {:.3e} m/s", points.id[i], speed(&i).sqrt()));
    let what = format!(
        "the kinetic energy of points and grains, {now:.3e} J, is larger than all energy that they were ever given, {possible:.3e} J: the time integration has become \
         unstable; try a smaller stepping.dt_s (or \"auto\"), stepping.safety = 0.4, in this order{fastest}"
    );
    Err(Error::Unstable { step: state.continuum.steps(), what, grain: None })
}

/// Largest stable step of the grains of a free scene before any of them touch, s: what later steps are compared with ([`slow_grains`]). 0 where steps do
/// not change.
pub fn first_step_of_grains(model: &Model) -> f64 {
    match &model.rig {
        Rig::Assembly(rig) if !model.physics.stepping.inertia_scaling => {
            stability::rayleigh_of(&model.physics, rig.grains.iter().map(|g| (2.0 * g.radius, g.material)))
        }
        _ => 0.0,
    }
}

/// Largest stable step of points and grains at the start, s: what later steps are compared with ([`slow_points`]).
pub fn first_step_of_points(model: &Model, rig: &MpmTest) -> f64 {
    let grains = rig.coarse.iter().flat_map(|c| &c.grains).map(|g| (2.0 * g.radius, g.material));
    let grains = if rig.coarse.as_ref().is_some_and(|c| !c.grains.is_empty()) {
        stability::rayleigh_of(&model.physics, grains)
    } else {
        f64::INFINITY
    };
    let step = wave_step(rig).min(grains);
    if step.is_finite() { step } else { 0.0 }
}

/// What is said of a step that is too short; `cause`: who causes it and what helps.
fn creeps(model: &Model, dt: f64, first: f64, cause: &str) -> String {
    format!(
        "the time step is {dt:.3e} s, below records.stop_at_step = {:e} of that at the start, {first:.3e} s, and the run would never end: {cause}",
        model.records.stop_at_step
    )
}

/// Compares the time step of a free scene of grains with that at the start ([`first_step_of_grains`]).
///
/// # Errors
/// [`Error::Unstable`] where it is below the share `records.stop_at_step`; it names the grain whose contacts allow the shortest step.
pub fn slow_grains(model: &Model, state: &State, work: &Workspace, first: f64) -> Result<()> {
    if state.dt >= model.records.stop_at_step * first {
        return Ok(());
    }
    let grain = stability::slowest(&model.physics, state, work);
    let size = grain.map_or(String::new(), |i| {
        format!(" The shortest step is that of a grain of diameter {:.3e} m", 2.0 * state.grains.radius(i))
    });
    let cause = format!(
        "contacts have become too stiff or grains too small (deep overlaps, tiny daughters), or stepping.safety or stepping.dt_s is too small.{size}"
    );
    let what = creeps(model, state.dt, first, &cause);
    Err(Error::Unstable { step: state.step, what, grain: grain.map(|i| u64::from(state.grains.id[i])) })
}

/// Compares the time step of a continuum or mixture with that at the start ([`first_step_of_points`]).
///
/// # Errors
/// [`Error::Unstable`] where it is below the share `records.stop_at_step`; it names the point whose waves and motion allow the shortest step, or says
/// that contacts are the cause.
pub fn slow_points(model: &Model, state: &continuum::State, first: f64) -> Result<()> {
    if state.dt >= model.records.stop_at_step * first {
        return Ok(());
    }
    let (c, points) = (&state.continuum, state.continuum.points());
    let speed = |i: &usize| {
        let [u, v, w, _] = points.velocity[*i];
        c.laws()[usize::from(points.law[*i])].wave_speed_at(points.density(*i), &points.stress[*i], points.memory[*i])
            + (u * u + v * v + w * w).sqrt()
    };
    let fastest = (0..points.len()).max_by(|i, j| speed(i).total_cmp(&speed(j)));
    let cause = match fastest.filter(|i| c.settings().cell / speed(i) < 10.0 * model.records.stop_at_step * first) {
        Some(i) => format!(
            "point {} of density {:.3e} kg/m3 moves at {:.3e} m/s; use less strain, a stiffer law or a larger grid",
            points.id[i],
            points.density(i),
            points.velocity[i][..3].iter().map(|v| v * v).sum::<f64>().sqrt()
        ),
        None => {
            "contacts of grains, points and platens have become too stiff, or stepping.safety or stepping.dt_s is too small".into()
        }
    };
    Err(Error::Unstable { step: c.steps(), what: creeps(model, state.dt, first, &cause), grain: None })
}

/// Steps between two comparisons of a fixed time step with the largest stable one: fewer than an impact lasts.
const BETWEEN_BOUNDS: u64 = 4;

/// Compares the fixed time step of a free scene, where it has one, with the largest stable one of the present contacts.
///
/// # Errors
/// [`Error::Unstable`] where it is above; not with `stepping.above_bound = true`.
pub fn step(model: &Model, rig: &Assembly, state: &State, work: &Workspace) -> Result<()> {
    let Some(dt) = model.physics.stepping.dt.filter(|_| !rig.above_bound && state.step.is_multiple_of(BETWEEN_BOUNDS)) else {
        return Ok(());
    };
    let bound = stability::largest_step(&model.physics, state, work, 1.0);
    if dt <= bound {
        return Ok(());
    }
    let what = format!(
        "stepping.dt_s = {dt:e} is above {bound:.4e} s, the largest stable step of the present contacts: use a smaller one, \"auto\", or stepping.above_bound = true at your own risk"
    );
    Err(Error::Unstable { step: state.step, what, grain: None })
}

/// Largest share of all energy given by which the kinetic energy of grains may exceed it. Velocities are half a step older than
/// positions, so a grain that rises against gravity may have a little more than the energy at its place: m g v dt/2.
const ABOVE: f64 = 0.05;

/// Compares the kinetic energy of the grains with all energy that they have been given since the ledger was opened: stored and
/// kinetic energy at the start, work of walls, of growing daughters, of changes of scaled inertia and of softening contacts, and
/// the way that they have fallen in `gravity`, m/s². To be called once the ledger is open.
///
/// # Errors
/// [`Error::Unstable`] when the kinetic energy is larger.
pub fn energy(state: &State, gravity: [f64; 3]) -> Result<()> {
    let (g, ledger) = (&state.grains, &state.ledger);
    let [stored, kinetic, potential] = ledger.start;
    let of = |i: usize| {
        let ([u, v, w, inverse], [x, y, z, _], r) = (g.vel[i], g.spin[i], g.radius(i));
        (0.5 * (u * u + v * v + w * w) + 0.2 * r * r * (x * x + y * y + z * z)) / inverse
    };
    let now: f64 = (0..g.len()).map(of).sum();
    let height = |i: usize| -g.mass[i] * dot([g.pos[i][0], g.pos[i][1], g.pos[i][2]], gravity);
    let fallen = if gravity == [0.0; 3] { 0.0 } else { potential - ledger.lost_potential - (0..g.len()).map(height).sum::<f64>() };
    let given: f64 = state.walls.iter().map(|w| w.work.max(0.0)).sum();
    let others = [ledger.growth, ledger.inertia, ledger.release].iter().map(|w| w.max(0.0)).sum::<f64>();
    let possible = stored + kinetic + given + others + fallen;
    let scale = stored + kinetic + given + others + fallen.abs();
    if now <= possible + ABOVE * scale {
        return Ok(());
    }
    let fastest = (0..g.len()).max_by(|&i, &j| of(i).total_cmp(&of(j))).unwrap_or(0);
    let what = format!(
        "the kinetic energy of the grains, {now:.3e} J, is larger than all energy that they were ever given, {possible:.3e} J: the time integration has become \
         unstable; try a smaller stepping.dt_s (or \"auto\"), stepping.safety = 0.4, contact.unloading = \"rescale\", crushing.birth = \"gradual\", in this order. \
         The fastest grain has diameter {:.3e} m",
        2.0 * g.radius(fastest)
    );
    Err(Error::Unstable { step: state.step, what, grain: Some(u64::from(g.id[fastest])) })
}

/// Checks position and overlaps of every grain; `deepest` is the largest allowed overlap over the smaller radius, `step` the step
/// that an error names.
///
/// # Errors
/// [`Error::Unstable`] for a grain without a finite position, one outside a wall, or an overlap that is too large.
pub fn grains(state: &State, deepest: f64, step: u64) -> Result<()> {
    let g = &state.grains;
    let bad = |i: usize, what: String| Err(Error::Unstable { step, what, grain: Some(u64::from(g.id[i])) });
    for (i, p) in g.pos.iter().enumerate() {
        if !(p[0] + p[1] + p[2]).is_finite() {
            return bad(i, "the position of a grain is not finite: the time step is too large for the stiffness; lower stepping.safety or stepping.dt_s".into());
        }
        for (k, w) in state.walls.iter().enumerate() {
            if w.shape.towards(*p).1 < -2.0 * p[3] {
                return bad(i, format!("a grain of diameter {:.3e} m has left through wall {k}", 2.0 * p[3]));
            }
        }
    }
    for (ends, touch) in state.pairs.ends.iter().zip(&state.pairs.touch) {
        if touch.overlap <= 0.0 {
            continue;
        }
        let [i, j] = ends.map(|i| i as usize);
        let small = if g.radius(i) < g.radius(j) { i } else { j };
        // a daughter that still grows to its radius may overlap with a neighbour
        if touch.overlap > deepest * g.radius(small) && state.aftermath.radius(small, g) == g.radius(small) {
            let large = if small == i { j } else { i };
            let what = format!(
                "a grain of diameter {:.3e} m overlaps by {:.2} of its radius with a grain of {:.3e} m (grain {}): contacts are too soft for these forces; raise material.elastic \
                 or the comminution limit, load to a lower stress, or go on with a higher records.stop_at_overlap",
                2.0 * g.radius(small),
                touch.overlap / g.radius(small),
                2.0 * g.radius(large),
                g.id[large]
            );
            return bad(small, what);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use engine::boundary::Wall;
    use engine::grains::Grains;

    /// A test with one grain that moves, and one wall that has done this work, J.
    fn state(speed: f64, work: f64) -> State {
        let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/free/box_settling.toml");
        let model = crate::scene::model(&crate::scene::load(scene, &[]).expect("a scene")).expect("a model");
        let mut grains = Grains::default();
        grains.add([0.0; 3], 1e-3, 0, &model.physics.materials);
        grains.vel[0] = [speed, 0.0, 0.0, 1.0];
        let spec = engine::boundary::WallSpec {
            shape: engine::boundary::WallShape::Plane { point: [0.0, 0.0, -1e-3], normal: [0.0, 0.0, 1.0] },
            friction: 0.0,
            drive: engine::boundary::Drive::Fixed,
            material: None,
        };
        let mut state = State::new(&model.physics, grains, vec![Wall { work, ..Wall::new(&spec) }], true);
        state.ledger.start = [1.0, 0.0, 0.0];
        state
    }

    #[test]
    fn a_continuum_keeps_its_balance() {
        assert_eq!(unbalanced(-0.01, 0.5), None);
        assert!(unbalanced(-0.06, 0.5).is_some_and(|told| told.contains("dissipated_share is -0.0600")));
        assert!(unbalanced(0.0, 1.5).is_some_and(|told| told.contains("differ by 1.50")));
        assert!(unbalanced(f64::NAN, 0.0).is_some() && unbalanced(0.0, f64::NAN).is_some());
    }

    #[test]
    fn energy_out_of_nothing_ends_a_test() {
        assert!(energy(&state(1.9, 1.0), [0.0; 3]).is_ok());
        let told = energy(&state(2.1, 1.0), [0.0; 3]).expect_err("2.2 J of 2 J");
        assert!(told.exit_code() == 3 && told.to_string().contains("ever given"), "{told}");
        assert!(energy(&state(f64::NAN, 1.0), [0.0; 3]).is_err(), "what is not a number is no energy");
    }

    #[test]
    fn a_grain_that_falls_may_become_faster_and_one_that_rises_must_become_slower() {
        let (mut fallen, weight) = (state(1.9, 0.0), [0.0, 0.0, -9.81]);
        let mass = fallen.grains.mass[0];
        assert!(energy(&fallen, weight).is_err(), "1.8 J of 1 J");
        // 1 J of height
        fallen.grains.pos[0][2] = -1.0 / (mass * 9.81);
        assert!(energy(&fallen, weight).is_ok());
        let mut risen = state(1.3, 0.0);
        assert!(energy(&risen, weight).is_ok(), "0.85 J of 1 J");
        risen.grains.pos[0][2] = 0.5 / (mass * 9.81);
        assert!(energy(&risen, weight).is_err(), "0.85 J of 0.5 J");
    }
}
