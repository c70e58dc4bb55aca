//! The energy account of the continuum: where the work on points and nodes goes, each term by a sum of its own and none as a remainder.
//!
//! With the mean velocity of a step at the nodes, v̄ = ½ (v⁻ + v⁺), the change of the nodes' kinetic energy is the work of all forces on the way v̄ Δt, exactly.
//! So a step of MUSL (Li et al. 2023, section 2.4) obeys
//!
//! ```text
//! K_points(new) − K_points(old) = −transfer − W_internal + W_external + W_gravity − wall impact − wall friction − damping
//! transfer      = [K_points(old) − Σ p²/(2m) of the projected nodes] + [K_nodes(v⁺) − K_points(new)]
//! wall impact   = Σ p²/(2m) − K_nodes(v⁻), with the velocities v⁻ that walls leave
//! W_internal    = Σ V σ : ∇v̄ Δt at the points, in their places at the start of the step
//! W_external    = Σ F · v̄ Δt at the points and their faces
//! W_gravity     = −ΔP − gravity lag
//! W_internal    = ΔE + plastic work + energy of volume + strain lag
//! ```
//!
//! *Strain lag*: stresses work on the strain from the velocities that are projected anew after points have moved, and internal forces on v̄. *Gravity lag*:
//! points move with v⁺, not with v̄. *Energy of volume*: stresses are updated by strain alone, so a volume that shrinks by −ΔV takes the energy
//! −½ (e + e') ΔV out, with the elastic energy per volume before, e, and after the step, e'.

use super::grid::damped;
use super::{Continuum, Settings};
use crate::check::{self, Checked};
use serde::{Deserialize, Serialize};

/// Energies of points and nodes since the account was opened, J. Losses are positive.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyAccount {
    /// Work of the stresses on plastic strain.
    pub plastic: f64,
    /// Elastic energy that comes with a change of volume ([module documentation](self)).
    pub volume: f64,
    /// Work against the stresses on the nodes' mean velocity less that on the strain of the points.
    pub strain_lag: f64,
    /// Work of gravity on the ways of the points less that on the nodes' mean velocity.
    pub gravity_lag: f64,
    /// Work of external forces (loading plates, grains, walls of grains) on the nodes' mean velocity: what the continuum has got from them.
    pub external: f64,
    /// Kinetic energy of points less that of the nodes with their momenta projected, p²/(2m), before walls act.
    pub to_nodes: f64,
    /// Kinetic energy of the accelerated nodes less that of the points with their new velocities.
    pub to_points: f64,
    /// Kinetic energy that projected nodes lose when walls of the grid stop them.
    pub wall_impact: f64,
    /// Work of the nodes against the friction of walls of the grid.
    pub wall_friction: f64,
    /// Work of the nodes against local damping.
    pub damping: f64,
    /// Kinetic energy of the points after the last step; `None` if points were changed since.
    pub(super) kinetic: Option<f64>,
}

/// Sums over the points of a block in a step, J: internal work on the mean velocity, external work; stress work, plastic work, energy of volume.
pub(super) type OfBlock = [f64; 5];

impl EnergyAccount {
    /// Loss in the transfer between points and nodes, J: to the nodes and back.
    pub fn transfer(&self) -> f64 {
        self.to_nodes + self.to_points
    }

    /// Checks that all sums are numbers.
    ///
    /// # Errors
    /// The one that is not.
    pub fn check(&self) -> Checked {
        let EnergyAccount { plastic, volume, strain_lag, gravity_lag, external, .. } = self;
        let EnergyAccount { to_nodes, to_points, wall_impact, wall_friction, damping, kinetic, .. } = self;
        let works = [plastic, volume, strain_lag, gravity_lag, external];
        let losses = [to_nodes, to_points, wall_impact, wall_friction, damping];
        check::numbers("energies of points", works.into_iter().chain(losses).chain(kinetic))
    }

    /// Adds the sums of all blocks, in their order.
    pub(super) fn add(&mut self, blocks: &[OfBlock]) {
        for [internal, external, stress, plastic, volume] in blocks {
            self.external += external;
            self.strain_lag += internal - stress;
            self.plastic += plastic;
            self.volume += volume;
        }
    }
}

/// Kinetic energy of all points, J, summed in their order in memory, which is that of cells and identities.
pub(super) fn kinetic_of_points(c: &Continuum) -> f64 {
    c.points.velocity.iter().map(|[u, v, w, m]| 0.5 * m * (u * u + v * v + w * w)).sum()
}

/// The sums of a step over nodes.
///
/// A node behind a wall is the image of one in front of it: folded or not, masses and velocities have the same kinetic energy, and forces the same power.
#[derive(Debug)]
pub(super) struct NodeAccount<'a> {
    /// Where the sums are added.
    pub sums: &'a mut EnergyAccount,
    /// Buffer: changes of velocity of the nodes near walls without walls, m/s.
    pub free: &'a mut Vec<[f64; 4]>,
}

impl NodeAccount<'_> {
    /// Takes the kinetic energy of the projected momenta, before walls act, and notes what walls will change. `momentum`: with the mass as the fourth
    /// number; `change`: change of velocity by forces and gravity; `walled`: nodes near walls.
    pub fn before_walls(&mut self, momentum: &[[f64; 4]], change: &[[f64; 4]], walled: &[u32]) {
        let of = |[x, y, z, m]: [f64; 4]| if m > 0.0 { 0.5 * (x * x + y * y + z * z) / m } else { 0.0 };
        let nodes: f64 = momentum.iter().map(|p| of(*p)).sum();
        let near: f64 = walled.iter().map(|&k| of(momentum[k as usize])).sum();
        self.sums.to_nodes += self.sums.kinetic.unwrap_or(nodes) - nodes;
        self.sums.wall_impact += near;
        self.free.clear();
        self.free.extend(walled.iter().map(|&k| change[k as usize]));
    }

    /// Adds the sums over the nodes, before damping is applied to `change`.
    pub fn after_walls(
        &mut self,
        momentum: &[[f64; 4]],
        velocity: &[[f64; 4]],
        change: &[[f64; 4]],
        walled: &[u32],
        settings: &Settings,
        dt: f64,
    ) {
        let (alpha, g) = (settings.damping, settings.gravity);
        let (mut end, mut damping, mut lag, mut impact, mut friction) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for ((p, v), dv) in momentum.iter().zip(velocity).zip(change) {
            let m = p[3];
            for a in 0..3 {
                let all = damped(v[a], dv[a], alpha);
                let (mean, last) = (v[a] + 0.5 * all, v[a] + all);
                end += 0.5 * m * last * last;
                damping += m * (dv[a] - all) * mean;
                lag += m * g[a] * (last - mean) * dt;
            }
        }
        for (&k, free) in walled.iter().zip(self.free.iter()) {
            let (m, v, dv) = (momentum[k as usize][3], velocity[k as usize], change[k as usize]);
            for a in 0..3 {
                impact += 0.5 * m * v[a] * v[a];
                friction += m * (free[a] - dv[a]) * (v[a] + 0.5 * damped(v[a], dv[a], alpha));
            }
        }
        let sums = &mut *self.sums;
        sums.wall_impact -= impact;
        sums.wall_friction += friction;
        sums.damping += damping;
        sums.gravity_lag += lag;
        // less the kinetic energy of the points, when they have their velocities
        sums.to_points += end;
    }
}
