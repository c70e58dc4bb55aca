//! What ends a run that has lost its meaning, before anything in it is not a number.

use crate::error::{Error, Result};
use crate::model::Model;
use crate::model::continuum::Continuum as Rig;
use crate::record::continuum::Recorder;
use crate::record::cylinder::AtEnd;
use crate::rig::continuum;
use engine::dem::State;

/// Energy that appears from nothing, as a share of all given. Measured: above -0.001 in the scenes, and above -1e-4 in cubes of 4 to 16 cells without damping and PIC.
const CREATED: f64 = 0.05;
/// Opposite platens whose forces differ by more than their mean: the rest would accelerate the specimen as if one of them were not there.
const APART: f64 = 1.0;

/// The last row of a continuum between platens.
///
/// # Errors
/// Pores of negative volume; in a test without grains that is under way, energy from nothing and opposite platens that do not balance.
pub fn continuum(rig: &Rig, state: &continuum::State, row: &Recorder) -> Result<()> {
    if rig.specimen().is_none() {
        return Ok(());
    }
    let impossible = |what: String| Err(Error::Impossible { step: state.continuum.steps(), what });
    // of grains alone it is that of the whole, which their overlaps may fill
    if !state.continuum.points().is_empty() && (row.void_ratio.is_nan() || row.void_ratio < 0.0) {
        return impossible(format!(
            "the void ratio is {:.4}, at an axial strain of {:.4}: the solids fill more than the whole volume, which the law does not know; \
             lower test.axial_strain or use a stiffer law; if strains are small, lower stepping.safety or raise damping.local",
            row.void_ratio, row.last[0]
        ));
    }
    if state.mixture.is_some() || !row.under_way(rig, state.phase) {
        return Ok(());
    }
    unbalanced(row.dissipated, row.difference).map_or(Ok(()), impossible)
}

/// What is wrong with the share of energy that a continuum has dissipated, and with the difference of opposite platens over their mean.
fn unbalanced(dissipated: f64, difference: f64) -> Option<String> {
    let change = "lower stepping.safety, raise damping.local (0.1) or grid.pic (0.1)";
    if dissipated.is_nan() || dissipated < -CREATED {
        return Some(format!(
            "dissipated_share is {dissipated:.4}, below {:.2}: energy comes from nothing, an oscillation that feeds itself; {change}",
            -CREATED
        ));
    }
    if difference.is_nan() || difference > APART {
        return Some(format!(
            "forces of opposite platens differ by {difference:.2} of their mean (platen_difference), above {APART}: the test is not quasi-static; {change}, or lower test.strain_per_wave"
        ));
    }
    None
}

/// The voids of a specimen at its last row.
///
/// # Errors
/// Dry mass that, without the grains' own pores, would fill more than the whole volume, unless the scene goes on without voids.
pub fn voids(model: &Model, step: u64, row: &AtEnd) -> Result<()> {
    if row.void_ratio_star >= 0.0 || !model.records.stop_without_voids {
        return Ok(());
    }
    let what = format!(
        "the void ratio of all dry mass, the grains' own pores counted as voids, is {:.4} at an axial strain of {:.4}: the solids would fill more than the whole volume (what breakages have lost bears \
         nothing, and overlaps count twice); stop at a lower stress, use stronger grains or keep the mass (crushing.lost_mass = \"points\" in an oedometer, or \"grow\"), \
         or go on with records.stop_without_voids = false",
        row.void_ratio, row.axial_strain
    );
    Err(Error::Impossible { step, what })
}

/// The kinetic energy of a test of a specimen of grains beside all energy that there can be.
///
/// # Errors
/// Grains of a quasi-static test that have more kinetic energy than walls and growth have ever given and contacts had at the start: the motion feeds itself.
pub fn energy(state: &State) -> Result<()> {
    let (g, ledger) = (&state.grains, &state.ledger);
    let [stored, kinetic, _] = ledger.start;
    if stored == 0.0 {
        // the test has not begun
        return Ok(());
    }
    let of = |i: usize| {
        let [u, v, w, inverse] = g.vel[i];
        0.5 * (u * u + v * v + w * w) / inverse
    };
    let now: f64 = (0..g.len()).map(of).sum();
    let given: f64 = state.walls.iter().map(|w| w.work.max(0.0)).sum();
    let possible = stored + kinetic + given + ledger.growth.max(0.0) + ledger.inertia.max(0.0);
    if now <= possible {
        return Ok(());
    }
    let fastest = (0..g.len()).max_by(|&i, &j| of(i).total_cmp(&of(j))).unwrap_or(0);
    let what = format!(
        "the kinetic energy of the grains, {now:.3e} J, is more than all energy that they were ever given, {possible:.3e} J: the time step has become \
         unstable; try stepping.safety = 0.4, contact.unloading = \"rescale\", crushing.birth = \"gradual\", in this order. The fastest grain has diameter {:.3e} m",
        2.0 * g.pos[fastest][3]
    );
    Err(Error::Unstable { step: state.step, what, grain: Some(u64::from(g.id[fastest])) })
}

/// After `step` steps of the run; grains may overlap by `deepest` of the smaller one's radius.
///
/// # Errors
/// A grain that is nowhere, has left through a wall, or is too deep in another one.
pub fn grains(state: &State, deepest: f64, step: u64) -> Result<()> {
    let g = &state.grains;
    let bad = |i: usize, what: String| Err(Error::Unstable { step, what, grain: Some(u64::from(g.id[i])) });
    for (i, p) in g.pos.iter().enumerate() {
        if !(p[0] + p[1] + p[2]).is_finite() {
            return bad(i, "a grain's position is not a number: the time step is too large for the stiffness; lower stepping.safety or stepping.dt_s".into());
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
        let small = if g.pos[i][3] < g.pos[j][3] { i } else { j };
        // what has just been born may still have to grow out of a neighbour
        if touch.overlap > deepest * g.pos[small][3] && state.aftermath.radius(small, g) == g.pos[small][3] {
            let large = if small == i { j } else { i };
            let what = format!(
                "a grain of diameter {:.3e} m is {:.2} of its radius deep in one of {:.3e} m (grain {}): contacts are too soft for these forces; raise material.elastic \
                 or the comminution limit, load to a lower stress, or go on with a higher records.stop_at_overlap",
                2.0 * g.pos[small][3],
                touch.overlap / g.pos[small][3],
                2.0 * g.pos[large][3],
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
        assert!(energy(&state(1.9, 1.0)).is_ok());
        let told = energy(&state(2.1, 1.0)).expect_err("2.2 J of 2 J");
        assert!(told.exit_code() == 3 && told.to_string().contains("ever given"), "{told}");
        assert!(energy(&state(f64::NAN, 1.0)).is_err(), "what is not a number is no energy");
    }
}
