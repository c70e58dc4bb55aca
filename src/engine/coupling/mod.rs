//! Grains inside a continuum: a material point near a grain or a wall is a ghost sphere that touches it as a grain would (Li et al. 2023,
//! section 2.3).
//!
//! The ghost's radius is that of the point's solids, (1 − n) V = 4/3 π r³ (eq. 22), which stays while the point's volume changes. The contact is the
//! run's own contact law with friction and history (eqs 18–21, 23, 24); the grain gets force and torque (eqs 25–27), the point the opposite force, which
//! goes to the nodes by its shape functions (eqs 28, 29). Only points near a surface take part.
//!
//! Ghosts have no spin. Slip is taken from the velocity that carried the point, not from its own: with FLIP these differ, and only the first
//! moves the contact point.

mod embedded;
mod evaluate;
#[cfg(feature = "gpu")]
pub mod exchange;
mod fines;
mod measure;
mod mixture;
mod reactions;
mod search;

pub use embedded::{Embedded, Embedding};
pub use fines::{Account, FinesAsPoints, Rule};
pub use measure::{Shares, Touching};
pub use mixture::{Allowed, Cycle, Mixture, Parts, Rates};

use crate::contact::pairs::ContactForce;
use crate::point_contacts::Age;
use serde::{Deserialize, Serialize};

/// Whose surface a ghost may touch. Grains come first, in the order of ids.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Body {
    /// A grain's identity.
    Grain(u32),
    /// A wall's number.
    Wall(u32),
}

/// A body and a point near it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct PointContact {
    pub body: Body,
    /// The point's identity.
    pub point: u32,
    /// Present indices of grain or wall, and of the point.
    place: [u32; 2],
    /// The point's law.
    law: u8,
    /// Ghost radius, m, and mass of the point, kg.
    radius: f64,
    mass: f64,
    /// The contact: first end the body, second the ghost. All zero while they do not touch.
    pub touch: ContactForce,
    /// Tangential spring (viscous laws), N.
    spring: [f64; 3],
    /// Tangent stiffnesses of the last sweep, normal and tangential, N/m.
    stiffness: [f64; 2],
    /// Overlap that bears no force, m: of a point that was born inside the body's reach; infinite until the first look.
    reference: f64,
}

/// Everything about the contacts between points and surfaces that a restart needs.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct PointContacts {
    /// In the order of bodies, then of points.
    pub candidates: Vec<PointContact>,
    age: Age,
    /// Points that breakages have left, where there are some.
    newborn: Option<Newborn>,
    /// Scratch: index by identity.
    #[serde(skip)]
    index: [Vec<u32>; 2],
}

/// Who was born inside another's reach.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Newborn {
    /// The first point that a breakage left.
    first: u32,
    /// Grains and points that are new since the last search have these identities and higher ones.
    grains: u32,
    points: u32,
}

impl PointContacts {
    /// Points from `first` on have come, with grains below `grains` there: what they overlap with at their first look bears no force.
    fn note_newborn(&mut self, first: u32, grains: u32) {
        self.newborn.get_or_insert(Newborn { first, grains, points: first });
    }

    /// Whether breakages have left this point.
    fn is_newborn(&self, point: u32) -> bool {
        self.newborn.is_some_and(|born| point >= born.first)
    }

    /// The next look searches anew.
    fn forget(&mut self) {
        self.age.forget();
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.candidates.capacity() * size_of::<PointContact>() + self.index.iter().map(|i| 4 * i.capacity()).sum::<usize>()
    }
}
