//! The energy ledger. Every term is computed by itself; none is a remainder.
//!
//! With the leapfrog's kinetic energy ½ m v(t−½)·v(t+½) and path work summed by the trapezium ½ (F_old + F_new)·Δu, the balance
//!
//! ```text
//! wall work + work of broken grains' fading hold − work on material points − path work − damping − Δkinetic − Δpotential − kinetic lost in breakages
//! + kinetic from re-scaled inertia = 0
//! ```
//!
//! closes to rounding and to the turn of the normals within one step: `error` tests the bookkeeping and the integrator. The path
//! work itself, with that of grains that grow, goes into stored elastic energy, slip and viscous loss; what remains is what the incremental tangential law does not
//! conserve (a spring whose stiffness follows the normal force), reported apart as `nonconservative`.

use super::observables::Sums;
use crate::boundary::Wall;
use crate::grains::Grains;
use serde::{Deserialize, Serialize};

/// Counters that are not kept per grain or per wall, J.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// Path, slip, viscous, damping work of grains that are no more.
    pub gone: [f64; 4],
    /// Kinetic energy of broken grains less that of their daughters.
    pub lost_kinetic: f64,
    /// Potential energy (gravity) of lost mass.
    pub lost_potential: f64,
    /// Elastic energy of contacts removed with broken grains, and of contacts daughters are born with.
    pub removed: f64,
    pub made: f64,
    /// Kinetic energy that came from changes of scaled inertia.
    pub inertia: f64,
    /// Work of grains that grow on their contacts, and of broken grains' fading hold on their neighbours ([`crate::dem::birth`]).
    pub growth: f64,
    pub release: f64,
    /// Work of grains and walls on fines that are material points ([`crate::coupling::Embedded`]).
    pub points: f64,
    /// Breakages after which more elastic energy was stored around the event than before.
    pub rises: u64,
    /// Stored, kinetic and potential energy at the start.
    pub start: [f64; 3],
}

/// The balance at one instant, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    pub wall: f64,
    pub path: f64,
    pub slip: f64,
    pub viscous: f64,
    pub damping: f64,
    pub stored: f64,
    pub kinetic: f64,
    pub potential: f64,
    pub lost_kinetic: f64,
    pub lost_potential: f64,
    pub removed: f64,
    pub made: f64,
    pub inertia: f64,
    pub growth: f64,
    pub release: f64,
    pub points: f64,
    /// Stored, kinetic, potential at the start.
    pub start: [f64; 3],
}

impl Ledger {
    /// Opens the ledger: all counters zero, the present energies as the start.
    pub fn open(&mut self, grains: &mut Grains, walls: &mut [Wall]) {
        *self = Ledger::default();
        for w in &mut grains.work {
            *w = [0.0; 4];
        }
        for w in walls {
            w.work = 0.0;
        }
    }

    /// The balance now; `sums` are those of [`super::observables::sums`].
    pub fn balance(&self, walls: &[Wall], sums: &Sums) -> Balance {
        let work: [f64; 4] = std::array::from_fn(|k| self.gone[k] + sums.work[k]);
        Balance {
            wall: walls.iter().fold(0.0, |s, w| s + w.work),
            path: work[0],
            slip: work[1],
            viscous: work[2],
            damping: work[3],
            stored: sums.stored,
            kinetic: sums.kinetic,
            potential: sums.potential,
            lost_kinetic: self.lost_kinetic,
            lost_potential: self.lost_potential,
            removed: self.removed,
            made: self.made,
            inertia: self.inertia,
            growth: self.growth,
            release: self.release + sums.release,
            points: self.points,
            start: self.start,
        }
    }
}

impl Balance {
    /// What the balance does not account for, J.
    pub fn residual(&self) -> f64 {
        self.wall + self.inertia + self.release
            - self.path
            - self.damping
            - (self.kinetic - self.start[1])
            - (self.potential - self.start[2])
            - self.lost_kinetic
            - self.lost_potential
            - self.points
    }

    /// Path work that is neither stored nor lost in slip and viscosity, J.
    pub fn nonconservative(&self) -> f64 {
        self.path + self.growth - (self.stored - self.start[0] + self.removed - self.made) - self.slip - self.viscous
    }

    /// The energy that has gone through: work of walls and of growing daughters, or the start's kinetic and potential energy in free scenes, J.
    pub fn scale(&self) -> f64 {
        self.wall.abs().max(self.path.abs()).max(self.growth.abs()).max(self.start[1].abs()).max(f64::MIN_POSITIVE)
    }

    /// Residual over the energy gone through.
    pub fn error(&self) -> f64 {
        self.residual() / self.scale()
    }
}
