//! The core of a superquadric ([`super::Smooth`]) in the frame of a body of several facets, and where the two are nearest.
//!
//! Facets of a sheet and parts of a union are convex or, as facets that are not, sums of triangles; so is the core. The place of the core that is nearest to a facet is found from furthest points alone
//! ([`apart`]); about it the superquadric is a sphere.

use super::{Apart, Nearest, apart};
use crate::math::vector::{dot, less, scaled};
use std::cell::OnceCell;

/// A convex core with a sphere swept over it.
pub struct Core<'a> {
    /// Its middle, m.
    pub centre: [f64; 3],
    /// No place of the core is further from there, m.
    pub reach: f64,
    furthest: &'a dyn Fn([f64; 3]) -> [f64; 3],
    bounds: OnceCell<[[f64; 3]; 2]>,
}

/// Where a superquadric meets a facet of a surface.
#[derive(Clone, Debug)]
pub struct CoreMeet {
    /// The facet as seen from the core.
    pub on: Seen,
    /// Borders with facets that are nearer to the core, as far as they are in reach, with the number of each such facet: beside them the contact counts less, as that of a sphere does
    /// ([`super::Meet`]).
    pub borders: Vec<(u32, Seen)>,
}

/// A place of the core and what it is nearest to.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// The place, m.
    pub at: [f64; 3],
    /// The surface as seen from it.
    pub nearest: Nearest,
}

impl<'a> Core<'a> {
    /// A core about `centre` in which no place is further from there than `reach`, m; `furthest` returns its furthest point along a unit vector, m.
    pub fn new(centre: [f64; 3], reach: f64, furthest: &'a dyn Fn([f64; 3]) -> [f64; 3]) -> Core<'a> {
        Core { centre, reach, furthest, bounds: OnceCell::new() }
    }

    /// Its point that is furthest along a unit vector, m.
    pub(super) fn furthest(&self, towards: [f64; 3]) -> [f64; 3] {
        (self.furthest)(towards)
    }

    /// Lowest and highest coordinates of what is nearer to it than `within`, m.
    pub(super) fn around(&self, within: f64) -> [[f64; 3]; 2] {
        let [low, high] = *self.bounds.get_or_init(|| {
            [-1.0, 1.0].map(|side| {
                std::array::from_fn(|a| {
                    let mut towards = [0.0; 3];
                    towards[a] = side;
                    self.furthest(towards)[a]
                })
            })
        });
        [low.map(|x| x - within), high.map(|x| x + within)]
    }

    /// Where the core is nearest to a convex body, if they are no further from each other than `beyond`, m. `about`: the place of that body, m, that is nearest to the centre of the core; where they
    /// cut each other the distance is 0, and the place is that. `start`: direction from the core to the body, unit vector, if it is about known.
    pub(super) fn nearest_to(
        &self,
        body: impl Fn([f64; 3]) -> [f64; 3],
        (about, start): ([f64; 3], Option<[f64; 3]>),
        beyond: f64,
    ) -> Option<Apart> {
        let away = less(about, self.centre);
        let length = dot(away, away).sqrt();
        if length > self.reach + beyond {
            return None;
        }
        let start = start.unwrap_or_else(|| if length > 0.0 { scaled(away, 1.0 / length) } else { [0.0, 0.0, 1.0] });
        let found = apart(|n| self.furthest(n), body, start, [beyond, 0.0])?;
        Some(if found.distance == 0.0 { Apart { on_first: about, ..found } } else { found })
    }

    /// As [`Self::nearest_to`], for the hull of some corners.
    pub(super) fn nearest_to_hull(&self, corners: &[[f64; 3]], about: ([f64; 3], Option<[f64; 3]>), beyond: f64) -> Option<Apart> {
        self.nearest_to(|towards| furthest(corners, towards), about, beyond)
    }
}

/// The corner that is furthest along a direction; of several the first.
pub(super) fn furthest(corners: &[[f64; 3]], towards: [f64; 3]) -> [f64; 3] {
    let mut best = (f64::NEG_INFINITY, [0.0; 3]);
    for corner in corners {
        let along = dot(*corner, towards);
        if along > best.0 {
            best = (along, *corner);
        }
    }
    best.1
}
