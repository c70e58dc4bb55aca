//! The energy account of a continuum or mixture: what was given, and where it has gone, each term by a sum of its own. What is left over is the error of the
//! account. The sums are those of [`::engine::mpm::account`] (points and nodes), of `engine::coupling` (contacts of points) and of [`::engine::dem::ledger`]
//! (contacts of grains).

use super::{MpmTest, State};
use crate::error::{Error, Result};
use crate::model::Model;
use ::engine::check::{self, Checked};
use ::engine::coupling::GrainWorks;
use ::engine::mpm::law::Law;
use ::engine::point_contacts::ActsOn;
use serde::{Deserialize, Serialize};

/// Energies when the account was opened, J.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Opened {
    /// Kinetic energy of points and grains.
    kinetic: f64,
    /// Potential energy of points and grains.
    potential: f64,
    /// Elastic energy of the stresses of the points.
    elastic: f64,
    /// Elastic energy of the contacts of grains, of points with grains, and of loading plates.
    contacts: [f64; 3],
}

impl Opened {
    /// Checks that all are numbers.
    pub(super) fn check(&self) -> Checked {
        let Opened { kinetic, potential, elastic, contacts } = self;
        check::numbers("energies of the account", [kinetic, potential, elastic].into_iter().chain(contacts))
    }
}

/// Columns of the account, with 1 for what is given and −1 for what it has become.
pub const TERMS: [(&str, f64); TERM_COUNT] = [
    ("platen_work_J", 1.0),
    ("gravity_work_J", 1.0),
    ("released_J", 1.0),
    ("broken_grains_J", 1.0),
    ("born_contacts_J", 1.0),
    ("kinetic_J", -1.0),
    ("elastic_points_J", -1.0),
    ("elastic_contacts_J", -1.0),
    ("plastic_work_J", -1.0),
    ("volume_J", -1.0),
    ("slip_grains_J", -1.0),
    ("slip_points_J", -1.0),
    ("viscous_grains_J", -1.0),
    ("viscous_points_J", -1.0),
    ("damping_grains_J", -1.0),
    ("damping_nodes_J", -1.0),
    ("transfer_J", -1.0),
    ("wall_impact_J", -1.0),
    ("wall_friction_J", -1.0),
    ("ended_contacts_J", -1.0),
    ("lost_mass_J", -1.0),
    ("strain_lag_J", -1.0),
    ("gravity_lag_J", -1.0),
    ("contact_lag_J", -1.0),
    ("step_change_J", -1.0),
    ("nonconservative_J", -1.0),
];

/// Number of terms.
const TERM_COUNT: usize = 26;

/// The account at an instant.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyAccount {
    /// The terms, J, in the order of [`TERMS`].
    pub terms: [f64; TERM_COUNT],
    /// Sum of the magnitudes of all energies given, with the motion at the start, J: the scale of the error.
    pub scale: f64,
}

impl EnergyAccount {
    /// What was given and no term has, J.
    pub fn residual(&self) -> f64 {
        self.terms.iter().zip(TERMS).map(|(term, (_, sign))| sign * term).sum()
    }

    /// [`Self::residual`] over the energies given, -.
    pub fn error(&self) -> f64 {
        self.residual() / self.scale.max(f64::MIN_POSITIVE)
    }
}

impl State {
    /// Opens the energy account with the first step.
    ///
    /// # Errors
    /// Rigid bodies, whose contacts keep no account, and laws whose stiffness goes with the pressure.
    pub(super) fn open_account(&mut self, rig: &MpmTest) -> Result<()> {
        if rig.coarse.as_ref().is_some_and(|c| !c.blocks.is_empty()) {
            let message = "is not available with [[block]]: contacts of rigid bodies keep no account of their work";
            return Err(Error::input("the scene", "records.account", Some("true".into()), message));
        }
        if rig.coarse.as_ref().is_some_and(|c| c.acts_on == ActsOn::Node) {
            let message = "is not available with contact.on_points = \"node\": such contacts do not keep their energy";
            return Err(Error::input("the scene", "records.account", Some("true".into()), message));
        }
        if rig.laws.iter().any(Law::stiffens) {
            let message = "is not available with a law whose stiffness goes with the pressure: its plastic work is not counted";
            return Err(Error::input("the scene", "records.account", Some("true".into()), message));
        }
        self.continuum.keep_account();
        if let Some(mixture) = &mut self.mixture {
            mixture.keep_account(&self.continuum);
        }
        Ok(())
    }

    /// Kinetic energy, potential energy and elastic energies of this instant, and the works of the grains' contacts.
    fn energies_now(&self, model: &Model, rig: &MpmTest) -> (Opened, GrainWorks) {
        let totals = self.continuum.totals();
        let [kinetic, potential, _] = self.mixture.as_ref().map_or([0.0; 3], |m| m.energies(rig.settings.gravity));
        let works = self.mixture.as_ref().map_or(GrainWorks::default(), |m| m.grain_works(&model.physics));
        let points = self.mixture.as_ref().and_then(|m| m.point_contacts.account()).map_or(0.0, |a| a.stored());
        let now = Opened {
            kinetic: totals.kinetic + kinetic + works.half_step,
            potential: totals.potential + potential,
            elastic: self.continuum.elastic_energy(),
            contacts: [works.stored, points, self.plates.iter().map(|p| p.stored).sum()],
        };
        (now, works)
    }

    /// Notes the energies at the start, when the forces of the first instant are known.
    pub(super) fn note_start(&mut self, model: &Model, rig: &MpmTest) {
        if model.records.account && self.opened.is_none() {
            self.opened = Some(self.energies_now(model, rig).0);
        }
    }

    /// The energy account at this instant, whose forces are known; `None`: the run keeps none.
    pub fn account(&self, model: &Model, rig: &MpmTest) -> Option<EnergyAccount> {
        let (start, points) = (self.opened.as_ref()?, self.continuum.account()?);
        let (now, works) = self.energies_now(model, rig);
        let none = Default::default();
        let contacts = self.mixture.as_ref().and_then(|m| m.point_contacts.account()).unwrap_or(&none);
        let ledger = self.mixture.as_ref().map(|m| m.grains.ledger.clone()).unwrap_or_default();
        let released = self.mixture.as_ref().and_then(|m| m.fines.as_ref()).map_or(0.0, |f| f.released);
        let on_grains: f64 = self.mixture.iter().flat_map(|m| &m.grains.walls).map(|w| w.work).sum();
        let on_points: f64 = self.plates.iter().map(|p| p.work).sum();
        let [in_grains, in_points, in_plates]: [f64; 3] = std::array::from_fn(|k| now.contacts[k] - start.contacts[k]);
        let held = ledger.release + ledger.growth + ledger.inertia;
        // elastic contacts of loading plates pass on what they do not store
        let contact_lag = on_points - in_plates - contacts.path - contacts.on_grains - points.external;
        let of_grains = works.path + ledger.growth - (in_grains + ledger.removed - ledger.made) - works.slip - works.viscous;
        let of_points =
            contacts.path + released - (in_points + contacts.removed - contacts.made) - contacts.slip - contacts.viscous;
        let terms = [
            on_points + on_grains,
            start.potential - now.potential,
            released,
            held,
            ledger.made + contacts.made,
            now.kinetic - start.kinetic,
            now.elastic - start.elastic,
            in_grains + in_points + in_plates,
            points.plastic,
            points.volume,
            works.slip,
            contacts.slip,
            works.viscous,
            contacts.viscous,
            works.damping,
            points.damping,
            points.transfer(),
            points.wall_impact,
            points.wall_friction,
            ledger.removed + contacts.removed,
            ledger.lost_kinetic + ledger.lost_potential - contacts.inserted.iter().sum::<f64>(),
            points.strain_lag,
            points.gravity_lag,
            contact_lag,
            contacts.step_change,
            of_grains + of_points,
        ];
        let scale = terms[..5].iter().map(|x| x.abs()).sum::<f64>() + start.kinetic;
        Some(EnergyAccount { terms, scale })
    }
}
