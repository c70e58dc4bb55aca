//! How well a test has held its stress and remained quasi-static, over every step and not only at records.

use crate::rig::cylinder::Stresses;
use crate::scene::{Level, Platens};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Least vertical stress of the steps that count, Pa: below it small forces give large relative differences.
pub const FROM: f64 = 50e3;

/// The largest values so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Held {
    /// Difference of the stress from its target, over the target.
    distance: f64,
    /// Difference of the platens' stresses, over their mean.
    platens: f64,
    /// The sum of these over the steps that count.
    platens_sum: f64,
    /// Inertial number.
    inertial: f64,
    /// Number of steps that count.
    steps: u64,
    /// Those in which the target waited for the stress.
    waited: u64,
    /// Longest wait, steps.
    longest: u64,
    /// Target of the stress during the longest wait, Pa.
    longest_at: f64,
    /// Length of the present wait, steps.
    waiting: u64,
}

/// One step of a test.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// Target of the stress under servo, Pa.
    pub target: f64,
    /// The same stress as measured, Pa.
    pub held: f64,
    /// Inertial number.
    pub inertial_number: f64,
    /// Whether the target waits until the stress is near it.
    pub waits: bool,
}

impl Instant {
    /// Difference of the stress from its target, over the target.
    pub fn distance(&self) -> f64 {
        distance(self.held, self.target)
    }
}

/// Difference of the stress `stress` from `target`, both in Pa, over the target.
pub fn distance(stress: f64, target: f64) -> f64 {
    (stress / target - 1.0).abs()
}

impl Held {
    /// Adds one step; `stresses` are those on the walls.
    pub fn look(&mut self, now: &Instant, stresses: &Stresses) {
        if stresses.vertical() < FROM {
            return;
        }
        self.steps += 1;
        self.distance = self.distance.max(now.distance());
        let platens = stresses.platen_difference();
        self.platens = self.platens.max(platens);
        self.platens_sum += platens;
        self.inertial = self.inertial.max(now.inertial_number);
        self.waiting = if now.waits { self.waiting + 1 } else { 0 };
        self.waited += u64::from(now.waits);
        if self.waiting > self.longest {
            (self.longest, self.longest_at) = (self.waiting, now.target);
        }
    }

    /// Mean difference of the platens' stresses, over their mean; 0 where no step counts.
    fn mean_platens(&self) -> f64 {
        self.platens_sum / self.steps.max(1) as f64
    }

    /// The difference of the platens' stresses that a level is held to: the largest, or the mean.
    fn found(&self, level: &Level) -> f64 {
        match level.promise.platens {
            Platens::Largest(_) => self.platens,
            Platens::Mean(_) => self.mean_platens(),
        }
    }

    /// Whether the platens' stresses have differed by no more than the level allows; nobody knows where no step counts.
    pub fn keeps(&self, level: &Level) -> Option<bool> {
        (self.steps > 0).then_some(level.allows(self.found(level)))
    }

    /// The entry `accuracy` of `summary.json` ([`Level::against`]).
    pub fn against(&self, level: &Level) -> Value {
        level.against(self.found(level), self.keeps(level))
    }

    /// The entry `held_every_step` of `summary.json`.
    pub fn summary(&self) -> Value {
        json!({
            "above_kPa": FROM * 1e-3,
            "steps": self.steps,
            "largest_distance_from_target": self.distance,
            "largest_platen_difference": self.platens,
            "largest_inertial_number": self.inertial,
            "waited_steps": self.waited,
            "longest_wait_steps": self.longest,
            "longest_wait_at_kPa": self.longest_at * 1e-3,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_step_counts_and_waits_are_measured() {
        let stresses = |top: f64, bottom: f64| Stresses { top, bottom, horizontal: 0.0 };
        let now = |held: f64, waits: bool| Instant { target: 1e6, held, inertial_number: 1e-4, waits };
        let mut held = Held::default();
        held.look(&now(1e4, true), &stresses(1e4, 1e4));
        assert_eq!(held, Held::default());
        let [draft, standard] = ["draft", "standard"].map(|word| Level::of("isotropic", "", word).expect("a level"));
        assert_eq!(held.keeps(draft), None);
        for (sigma, waits) in [(1e6, false), (0.7e6, true), (0.8e6, true), (0.99e6, false), (0.9e6, true)] {
            held.look(&now(sigma, waits), &stresses(1.02 * sigma, 0.98 * sigma));
        }
        let s = held.summary();
        assert!((s["largest_distance_from_target"].as_f64().unwrap() - 0.3).abs() < 1e-12);
        assert!((s["largest_platen_difference"].as_f64().unwrap() - 0.04).abs() < 1e-12);
        assert_eq!([draft, standard].map(|level| held.keeps(level)), [Some(true), Some(false)]);
        assert_eq!((s["waited_steps"].as_u64(), s["longest_wait_steps"].as_u64()), (Some(3), Some(2)));
    }
}
