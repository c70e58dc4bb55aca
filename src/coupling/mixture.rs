//! One cycle of grains and continuum, each with steps of its own.
//!
//! The slower side makes one step of `time` seconds, the other κ steps of a κ-th of it (Zhang et al., section 4.2, eqs 51–60; here either side may be the
//! slower one). Contacts between them are found at every step of the faster side, with the slower one carried on by the mean velocity of its last step (eq. 60: the
//! way it went over the time it took). What a contact gives the faster side in each of its steps, it takes from the slower one over the cycle as the mean
//! of these forces: impulses are equal and opposite, so momentum is conserved to rounding, whatever κ is. With κ = 1 both are found from one instant.

use super::{Bound, GhostTable, Ghosts};
use crate::coupling::evaluate::Scene;
use crate::error::{Error, Result};
use crate::model::{Model, TangentialUnloading};
use crate::mpm::Continuum;
use crate::mpm::platen::Platen;
use crate::step::{self, State, Work};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Who makes how many steps in a cycle; one of both is 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rates {
    pub grains: u32,
    pub continuum: u32,
}

/// A cycle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cycle {
    /// s.
    pub time: f64,
    pub rates: Rates,
}

/// What each side allows by itself, with the scene's safety, s; what contacts between them allow; and what the scene asks for.
#[derive(Clone, Copy, Debug)]
pub struct Allowed {
    pub grains: f64,
    pub continuum: f64,
    pub contacts: Bound,
    pub safety: f64,
    /// Instead of the rates that the bounds give.
    pub rates: Option<Rates>,
    /// Instead of the step of the slower side that they give, s.
    pub time: Option<f64>,
}

impl Cycle {
    /// The longest cycle that is stable: a side's frequency and that of the contacts add up, ω² ≤ ω_side² + ω_contacts². With rates that are given, the
    /// longest cycle that both sides can do with them.
    pub fn longest(allowed: &Allowed) -> Cycle {
        let of = |dt: f64| {
            let own = 2.0 * allowed.safety / dt;
            2.0 * allowed.safety / (own * own + allowed.contacts.frequency2()).sqrt()
        };
        let (grains, continuum) = (of(allowed.grains), of(allowed.continuum));
        let rates = allowed.rates.unwrap_or_else(|| {
            let steps = |slow: f64, fast: f64| (slow / fast).ceil().clamp(1.0, MOST) as u32;
            if grains <= continuum {
                Rates { grains: steps(continuum, grains), continuum: 1 }
            } else {
                Rates { grains: 1, continuum: steps(grains, continuum) }
            }
        });
        let time = (grains * f64::from(rates.grains)).min(continuum * f64::from(rates.continuum));
        Cycle { time: allowed.time.unwrap_or(time), rates }
    }
}

/// Most steps of the faster side in a cycle.
const MOST: f64 = 1000.0;

/// The grains of a mixture with their contacts with points, beside a continuum.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Mixture {
    pub grains: State,
    pub ghosts: Ghosts,
    /// The last cycle.
    pub cycle: Cycle,
    /// Cycles done.
    pub cycles: u64,
    /// The last step of grains, and what their own contacts allow, s.
    last: f64,
    own: f64,
    #[serde(skip)]
    sums: [Vec<f64>; 2],
}

/// What a cycle works on besides the mixture.
pub struct Parts<'a> {
    pub model: &'a Model,
    pub table: &'a GhostTable,
    pub work: &'a mut Work,
    pub continuum: &'a mut Continuum,
    pub platens: &'a mut [Platen],
}

/// What is known at the start of a cycle, when all forces are.
pub struct Instant<'a> {
    pub grains: &'a mut State,
    pub work: &'a Work,
    pub ghosts: &'a Ghosts,
    pub continuum: &'a mut Continuum,
    pub platens: &'a mut [Platen],
    /// What the grains' own contacts, and those with points, allow.
    pub own: f64,
    pub contacts: Bound,
}

impl Mixture {
    pub fn new(grains: State, continuum: &mut Continuum) -> Mixture {
        continuum.keep_carried();
        let cycle = Cycle { time: 0.0, rates: Rates { grains: 1, continuum: 1 } };
        Mixture { grains, ghosts: Ghosts::default(), cycle, cycles: 0, last: 0.0, own: 0.0, sums: Default::default() }
    }

    /// One cycle. `decide` sees the forces of its first instant, sets speeds and answers the cycle to be done, or `None` if there is nothing left to
    /// do: then nothing moves. Answers whether anything has.
    ///
    /// # Errors
    /// What `decide` returns; a lost point; a platen through the points.
    pub fn advance(&mut self, parts: &mut Parts<'_>, decide: impl FnOnce(Instant<'_>) -> Result<Option<Cycle>>) -> Result<bool> {
        let Parts { model, table, work, continuum, platens } = parts;
        let Mixture { grains, ghosts, cycle, cycles, last, own, sums } = self;
        let finder = Finder { table, unloading: model.contact.unloading, fastest: fastest(continuum) };
        let first = step::step(model, grains, work, |grains, work| {
            note_bound(grains, *last, own);
            finder.find(ghosts, grains, continuum, *last, [0.0; 2]);
            press(platens, continuum)?;
            let contacts = ghosts.bound(&grains.grains, sums, continuum.points().len());
            let instant = Instant { grains, work, ghosts, continuum, platens, own: *own, contacts };
            let Some(next) = decide(instant)? else { return Err(End::Done) };
            *cycle = next;
            let [of_grains, of_points] = [next.rates.continuum, next.rates.grains].map(|n| 1.0 / f64::from(n));
            ghosts.give(&grains.grains, &mut work.outside, of_grains, continuum, of_points);
            if next.rates.grains == 1 {
                let dt = next.time * of_grains;
                for j in 1..next.rates.continuum {
                    continuum.step(dt)?;
                    platens.iter_mut().for_each(|p| p.advance(dt));
                    finder.find(ghosts, grains, continuum, dt, [dt * f64::from(j), 0.0]);
                    press(platens, continuum)?;
                    ghosts.give(&grains.grains, &mut work.outside, of_grains, continuum, 1.0);
                }
            }
            grains.dt = next.time * of_points;
            *last = grains.dt;
            Ok(())
        });
        match first {
            Ok(()) => {}
            Err(End::Done) => return Ok(false),
            Err(End::Failed(e)) => return Err(e),
        }
        // the other steps of the grains, beside points that go on as they went; newborn grains may need shorter ones
        let (mut left, mut steps) = (cycle.time - *last, cycle.rates.grains - 1);
        while steps > 0 {
            step::step(model, grains, work, |grains, work| {
                if note_bound(grains, *last, own) {
                    steps = steps.max((left / *own).ceil().min(MOST) as u32);
                }
                finder.find(ghosts, grains, continuum, *last, [0.0, cycle.time - left]);
                grains.dt = left / f64::from(steps);
                *last = grains.dt;
                ghosts.give(&grains.grains, &mut work.outside, 1.0, continuum, grains.dt / cycle.time);
                Ok::<(), Error>(())
            })?;
            left -= *last;
            steps -= 1;
        }
        let dt = cycle.time / f64::from(cycle.rates.continuum);
        continuum.step(dt)?;
        platens.iter_mut().for_each(|p| p.advance(dt));
        *cycles += 1;
        Ok(true)
    }

    /// Mass, kg, and momentum, kg m/s, of grains and points.
    pub fn mass_and_momentum(&self, continuum: &Continuum) -> (f64, [f64; 3]) {
        let (g, totals) = (&self.grains.grains, continuum.totals());
        let (mut mass, mut momentum) = (totals.mass, totals.momentum);
        for i in g.by_id().into_iter().map(|i| i as usize) {
            mass += g.mass[i];
            for (sum, v) in momentum.iter_mut().zip(g.vel[i]) {
                *sum += g.mass[i] * v;
            }
        }
        (mass, momentum)
    }
}

/// How a first instant ends a cycle.
enum End {
    Done,
    Failed(Error),
}

impl From<Error> for End {
    fn from(e: Error) -> End {
        End::Failed(e)
    }
}

/// Takes the grains' own bound where their step is not the one that they were given: then their contacts have been looked at again.
fn note_bound(grains: &State, given: f64, own: &mut f64) -> bool {
    let looked = grains.dt != given;
    if looked {
        *own = grains.dt;
    }
    looked
}

fn press(platens: &mut [Platen], continuum: &mut Continuum) -> Result<()> {
    platens.iter_mut().try_for_each(|p| p.press(continuum))
}

/// Largest speed at which a point was carried, m/s.
fn fastest(continuum: &Continuum) -> f64 {
    let square = |v: &[f64; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let carried = &continuum.points().carried;
    carried.par_iter().with_min_len(4096).map(square).reduce(|| 0.0, f64::max).sqrt()
}

/// What stays the same when contacts are found during a cycle.
struct Finder<'a> {
    table: &'a GhostTable,
    unloading: TangentialUnloading,
    fastest: f64,
}

impl Finder<'_> {
    /// Lists and forces; `dt` seconds after the last ones, with grains and points taken ahead.
    fn find(&self, ghosts: &mut Ghosts, state: &State, continuum: &Continuum, dt: f64, ahead: [f64; 2]) {
        let speed = |v: &[f64; 4]| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        let grains = state.grains.vel.iter().map(speed).fold(0.0, f64::max);
        let walls = state.walls.iter().map(|w| w.speed.abs()).fold(0.0, f64::max);
        ghosts.update(&state.grains, &state.walls, continuum, dt * (self.fastest + grains.max(walls)));
        let Finder { table, unloading, .. } = *self;
        let scene = Scene { grains: &state.grains, walls: &state.walls, continuum, table, unloading, dt, ahead };
        if state.pairs.kept().work { ghosts.evaluate::<true>(&scene) } else { ghosts.evaluate::<false>(&scene) }
    }
}
