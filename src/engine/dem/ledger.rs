//! The energy ledger: every store of energy and every work, each computed by itself and none as a remainder.
//!
//! Kinetic energy is that of the leapfrog, ½ m v(t − ½)·v(t + ½). Work of contact forces on their path is summed by the trapezium rule,
//! ½ (F_old + F_new)·Δu. Then the balance
//!
//! ```text
//! work of walls + work of softening contacts of broken grains + kinetic energy from changes of scaled inertia
//!   − work on material points − path work of contacts − local damping − Δ kinetic − Δ potential
//!   − kinetic and potential energy lost in breakages = 0
//! ```
//!
//! closes to rounding and to the rotation of contact normals within one step: [`Balance::error`] tests the bookkeeping and the integration of motion.
//! The path work, with the work of growing grains, becomes stored elastic energy, slip and viscous loss; the rest is energy that the incremental
//! tangential law does not conserve (a spring whose stiffness follows the normal force), reported as [`Balance::nonconservative`].

use super::observables::Sums;
use crate::boundary::Wall;
use crate::check::{self, Checked};
use crate::grains::Grains;
use serde::{Deserialize, Serialize};

/// Energies that are not counted at a grain or wall, since the ledger was opened, J.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// Path, slip, viscous and damping work of grains that have broken (the order of [`Grains::work`]).
    pub gone: [f64; 4],
    /// Kinetic energy of broken grains minus that of their daughters.
    pub lost_kinetic: f64,
    /// Potential energy (gravity) of mass lost in breakages.
    pub lost_potential: f64,
    /// Elastic energy of contacts that ended because a grain broke.
    pub removed: f64,
    /// Elastic energy of the contacts that daughters have when they are born.
    pub made: f64,
    /// Kinetic energy added by changes of scaled inertia.
    pub inertia: f64,
    /// Work of growing grains on their contacts ([`crate::dem::birth`]).
    pub growth: f64,
    /// Work of the softening contacts of broken grains on their neighbours ([`crate::dem::birth`]).
    pub release: f64,
    /// Work of grains and walls on fines that are material points ([`crate::coupling::Embedded`]).
    pub points: f64,
    /// Number of breakages after which more elastic energy was stored around the event than before.
    pub rises: u64,
    /// Stored, kinetic and potential energy when the ledger was opened.
    pub start: [f64; 3],
}

/// All terms of the balance at one instant, J. Works and losses are those since the ledger was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// Work of the walls on the grains.
    pub wall: f64,
    /// Work of contact forces on their path, taken from the grains' motion.
    pub path: f64,
    /// Energy lost in sliding contacts.
    pub slip: f64,
    /// Energy lost in viscous contact forces.
    pub viscous: f64,
    /// Energy lost in local damping.
    pub damping: f64,
    /// Elastic energy of the contacts now.
    pub stored: f64,
    /// Kinetic energy now, with the inertial masses in use.
    pub kinetic: f64,
    /// Potential energy in gravity now.
    pub potential: f64,
    /// As [`Ledger::lost_kinetic`].
    pub lost_kinetic: f64,
    /// As [`Ledger::lost_potential`].
    pub lost_potential: f64,
    /// As [`Ledger::removed`].
    pub removed: f64,
    /// As [`Ledger::made`].
    pub made: f64,
    /// As [`Ledger::inertia`].
    pub inertia: f64,
    /// As [`Ledger::growth`].
    pub growth: f64,
    /// As [`Ledger::release`], with the half step up to now.
    pub release: f64,
    /// As [`Ledger::points`].
    pub points: f64,
    /// As [`Ledger::start`].
    pub start: [f64; 3],
}

impl Ledger {
    /// Checks that all entries are numbers.
    ///
    /// # Errors
    /// The one that is not.
    pub fn check(&self) -> Checked {
        let Ledger { gone, lost_kinetic, lost_potential, removed, made, inertia, growth, release, points, rises, start } = self;
        let single = [lost_kinetic, lost_potential, removed, made, inertia, growth, release, points];
        check::numbers("energies", gone.iter().chain(start).chain(single))?;
        check::counters("rises of energy", &[*rises])
    }

    /// Opens the ledger: sets all counters of ledger, grains and walls to zero. The caller then writes the present energies into [`Ledger::start`].
    pub fn open(&mut self, grains: &mut Grains, walls: &mut [Wall]) {
        *self = Ledger::default();
        for w in &mut grains.work {
            *w = [0.0; 4];
        }
        for w in walls {
            w.work = 0.0;
        }
    }

    /// The balance at the instant of `sums`, which [`super::observables::sums`] has computed.
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
    /// Sum of the balance, J: zero but for rounding and the rotation of contact normals within a step.
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

    /// Path work that is neither stored nor lost in slip and viscous forces, J: energy that the incremental tangential law does not conserve.
    pub fn nonconservative(&self) -> f64 {
        self.path + self.growth - (self.stored - self.start[0] + self.removed - self.made) - self.slip - self.viscous
    }

    /// Energy to compare errors with, J: the largest of work of walls, path work, work of growing grains and kinetic energy at the start; never zero.
    pub fn scale(&self) -> f64 {
        self.wall.abs().max(self.path.abs()).max(self.growth.abs()).max(self.start[1].abs()).max(f64::MIN_POSITIVE)
    }

    /// [`Self::residual`] over [`Self::scale`].
    pub fn error(&self) -> f64 {
        self.residual() / self.scale()
    }
}
