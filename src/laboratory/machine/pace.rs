//! How fast one thread of a machine makes steps. It is measured once, in a second, by `campaign::bench::yardstick`, and kept in the
//! user's cache; estimates of a run's duration follow it.

use crate::cache;
use engine::math::real;
use serde::{Deserialize, Serialize};

/// What a step takes on one thread, for each grain and for each point of the cases of `campaign::bench::yardstick`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pace {
    /// For a grain with its contacts, s.
    #[serde(rename = "grain_step_s")]
    pub grain: f64,
    /// For a point with its share of the grid, s.
    #[serde(rename = "point_step_s")]
    pub point: f64,
}

/// Kind of its file in the cache.
const KIND: &str = "pace";

impl Pace {
    /// Of a virtual AMD EPYC (Zen 5) with AVX-512, on which `comminute bench` makes 25.7 million steps of grains and 10.0 million of points a
    /// second: each of those takes 1.38 and 0.97 times what a step of the yardstick does.
    pub const FAST: Pace = Pace { grain: 28e-9, point: 103e-9 };

    /// What was measured on this machine; `None` where nothing was, or by another version of the program.
    pub fn known() -> Option<Pace> {
        let sound = |t: f64| t.is_finite() && t > 0.0;
        cache::read(KIND, &of_this_machine()).filter(|pace: &Pace| sound(pace.grain) && sound(pace.point))
    }

    /// Keeps it for this machine.
    pub fn keep(self) {
        cache::keep(KIND, &of_this_machine(), self);
    }
}

/// Processor, instruction set and version of the program, as text.
fn of_this_machine() -> String {
    format!("comminute {} on {}, {}", env!("CARGO_PKG_VERSION"), super::processor(), real::name(real::arch()))
}
