//! Grains inside a continuum. A material point near a grain or a wall touches it as a sphere, its *ghost* (Li et al. 2023, section 2.3).
//!
//! The ghost has the volume of the point's solids, (1 − n) V = 4/3 π r³ (eq. 22); its radius r stays while the point's volume changes. The contact
//! follows the contact law of the run, with friction and history (eqs 18–21, 23, 24). The grain gets a force and a torque (eqs 25–27), the point the
//! opposite force (eq. 28). Only points near a surface are looked at.
//!
//! Li et al. spread that force from the centre of the point by its shape functions (eq. 29), and so do free scenes. In tests with loading plates it acts on the
//! face of the ghost, where the grain is, and the overlap is measured from there ([`crate::point_contacts::GhostFace`]): what moves with a grain is then what
//! touches it.
//!
//! Ghosts do not rotate. The velocity of a point in a contact is the one that moved it in its last step ([`crate::mpm::Points::transport_velocity`]), or that of
//! the nodes at its face. With FLIP both differ from the velocity stored at the point, which does not move the contact.

mod account;
mod candidates;
mod embedded;
mod evaluate;
#[cfg(feature = "gpu")]
pub mod exchange;
mod fines;
mod measure;
mod mixture;
mod reactions;
mod search;
#[cfg(test)]
mod tests;

pub use account::{ContactAccount, GrainWorks};
pub use candidates::Candidates;
pub use embedded::{Embedded, Embedding};
pub use fines::{Account, FinesAsPoints, Rule};
pub use measure::{Shares, Touching};
pub use mixture::{Allowed, Cycle, Mixture, Parts, Rates};

use crate::check::{self, Checked, below, ensure};
use crate::contact::pairs::ContactForce;
use crate::grains::Grains;
use crate::mpm::Continuum;
use crate::point_contacts::{Age, GhostFace};
use serde::{Deserialize, Serialize};

/// The grain or wall of a point contact. Grains are ordered before walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Body {
    /// A grain's identity.
    Grain(u32),
    /// A wall's number.
    Wall(u32),
}

/// A material point and a grain or wall that it touches or may touch soon.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct PointContact {
    /// Grain or wall.
    pub body: Body,
    /// Identity of the point.
    pub point: u32,
    /// Present indices of the grain or wall, and of the point.
    place: [u32; 2],
    /// Constitutive law of the point.
    law: u8,
    /// Ghost radius of the point, m.
    radius: f64,
    /// Mass of the point, kg.
    mass: f64,
    /// Force of the contact; its first end is the body, its second the point. All zero while they do not touch.
    pub touch: ContactForce,
    /// Tangential spring, N (viscous laws; for others the tangential force is the spring).
    spring: [f64; 3],
    /// Tangent stiffnesses when forces were last computed: normal and tangential, N/m.
    stiffness: [f64; 2],
    /// Overlap that bears no force, m: the overlap with which a point from a breakage was born. Infinite until forces are first computed, then that overlap.
    reference: f64,
    /// Where the body presses on the point; `None` until they first touch, and again once they have parted.
    face: Option<GhostFace>,
}

/// All contacts and candidates of contacts between points and grains or walls: what a restart needs of them.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct PointContacts {
    /// Points near grains and walls, touching or not, sorted by body and then by the identity of the point.
    pub candidates: Candidates,
    /// Age of the list.
    age: Age,
    /// Points that come from breakages, if there are some.
    newborn: Option<Newborn>,
    /// The energy account, if one is kept.
    account: Option<Box<ContactAccount>>,
    /// Buffers: index by identity, of grains and of points.
    #[serde(skip)]
    index: [Vec<u32>; 2],
}

/// Which points come from breakages, and which grains and points are new since the last search.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Newborn {
    /// Identity of the first point that came from a breakage.
    first: u32,
    /// Grains with this identity or a higher one are new since the last search.
    grains: u32,
    /// Points with this identity or a higher one are new since the last search.
    points: u32,
}

impl PointContacts {
    /// Tells that points from identity `first` on have been added by a breakage, when the next new grain had the identity `grains`: the overlaps that
    /// these points have at the next search bear no force ([`PointContact`]'s reference overlap).
    fn note_newborn(&mut self, first: u32, grains: u32) {
        self.newborn.get_or_insert(Newborn { first, grains, points: first });
    }

    /// Whether the point with this identity comes from a breakage.
    fn is_newborn(&self, point: u32) -> bool {
        self.newborn.is_some_and(|born| point >= born.first)
    }

    /// Checks contacts that come from outside against the grains, the number of `walls` that points touch, and the points of their run.
    ///
    /// # Errors
    /// What is wrong, in words.
    fn check(&self, grains: &Grains, walls: usize, continuum: &Continuum) -> Checked {
        let points = continuum.points();
        self.age.check()?;
        self.account.as_ref().map_or(Ok(()), |account| account.check())?;
        let sorted = self.candidates.windows(2).all(|w| (w[0].body, w[0].point) < (w[1].body, w[1].point));
        ensure(sorted, || "contacts of points are not in their order".into())?;
        let mut ids = points.id.clone();
        ids.sort_unstable();
        // points that are no more leave the list with the next search
        let stands = self.age.may_stand([grains.len(), points.len()]);
        for c in self.candidates.iter() {
            match c.body {
                Body::Grain(id) => below("a point touches grain", id, grains.next_id as usize)?,
                Body::Wall(k) => below("a point touches wall", k, walls)?,
            }
            ensure(!stands || ids.binary_search(&c.point).is_ok(), || format!("a grain touches point {}, which is none", c.point))?;
            below("law", c.law, continuum.laws().len())?;
            check::numbers("forces on points", c.touch.first().iter().chain(&c.touch.second()).chain(&c.spring))?;
            check::not_negative("stiffnesses at points", c.stiffness)?;
            check::positive("points in contact", [c.radius, c.mass])?;
            check::numbers("faces of points", c.face.iter().flat_map(GhostFace::numbers))?;
            check::all("overlaps of points", [c.reference], "not from 0 on", |x| x >= 0.0)?;
        }
        Ok(())
    }

    /// Opens the energy account with sums of zero.
    fn keep_account(&mut self, grains: &Grains, continuum: &Continuum) {
        self.account = Some(Box::new(ContactAccount::new(grains, continuum)));
    }

    /// The energy account, if one is kept.
    pub fn account(&self) -> Option<&ContactAccount> {
        self.account.as_deref()
    }

    /// Makes a new search due.
    fn forget(&mut self) {
        self.age.forget();
    }

    /// Memory in use, bytes.
    pub fn bytes(&self) -> usize {
        self.account.as_ref().map_or(0, |account| account.bytes())
            + self.candidates.bytes()
            + self.index.iter().map(|i| 4 * i.capacity()).sum::<usize>()
    }
}
