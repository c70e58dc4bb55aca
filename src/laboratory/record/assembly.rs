//! Records of a free scene: sums over all grains in `history.csv`, chosen grains in `tracks.csv`.

use crate::model::{Assembly, Model};
use engine::dem::observables;
use engine::dem::{State, Workspace, gather};
use table::Row;

/// The row of `history.csv` for the present state.
pub fn history_row(model: &Model, state: &State, work: &Workspace) -> Row {
    let sums = observables::sums(&model.physics, state, work);
    let balance = state.ledger.balance(&state.walls, &sums);
    let lost: f64 = state.lost.iter().map(|l| l.0).sum();
    vec![
        ("step", state.step.into()),
        ("time_s", state.time.into()),
        ("grains", state.grains.len().into()),
        ("crush_events", state.crush_events.into()),
        ("coordination_number", sums.coordination(state.grains.len()).into()),
        ("unbalanced_ratio", sums.unbalanced_ratio(state.grains.len()).into()),
        ("kinetic_energy_J", balance.kinetic.into()),
        ("stored_energy_J", balance.stored.into()),
        ("potential_energy_J", balance.potential.into()),
        ("slip_work_J", balance.slip.into()),
        ("viscous_work_J", balance.viscous.into()),
        ("damping_work_J", balance.damping.into()),
        ("wall_work_J", balance.wall.into()),
        ("energy_error", balance.error().into()),
        ("energy_nonconservative", (balance.nonconservative() / balance.scale()).into()),
        ("mass_grains_kg", sums.mass.into()),
        ("mass_lost_kg", lost.into()),
    ]
}

/// One row of `tracks.csv` for each tracked grain that still exists. Velocities and spins are those of the present instant; the
/// state holds those of half a step before.
pub fn track_rows(model: &Model, rig: &Assembly, state: &State, work: &Workspace) -> Vec<Row> {
    let g = &state.grains;
    let back = if state.fresh { 0.0 } else { 0.5 * state.dt };
    let mut rows = Vec::new();
    for &id in &rig.tracks {
        let Some(i) = g.id.iter().position(|&k| k == id) else { continue };
        let (f, t) = gather::force_and_torque(i, &model.physics, state, &work.neighbours);
        let m = g.inertia(i);
        let (p, v, w) = (g.pos[i], g.vel[i], g.spin[i]);
        let inertia = 0.4 * m * p[3] * p[3];
        let velocity: [f64; 3] = std::array::from_fn(|a| v[a] + back * f[a] / m);
        let spin: [f64; 3] = std::array::from_fn(|a| w[a] + back * t[a] / inertia);
        rows.push(vec![
            ("step", state.step.into()),
            ("time_s", state.time.into()),
            ("grain", u64::from(id).into()),
            ("x_m", p[0].into()),
            ("y_m", p[1].into()),
            ("z_m", p[2].into()),
            ("vx_m_s", velocity[0].into()),
            ("vy_m_s", velocity[1].into()),
            ("vz_m_s", velocity[2].into()),
            ("wx_rad_s", spin[0].into()),
            ("wy_rad_s", spin[1].into()),
            ("wz_rad_s", spin[2].into()),
            ("fx_N", f[0].into()),
            ("fy_N", f[1].into()),
            ("fz_N", f[2].into()),
        ]);
    }
    rows
}
