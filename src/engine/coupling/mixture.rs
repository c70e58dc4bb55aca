//! One cycle of grains and continuum, each with steps of its own.
//!
//! The slower side makes one step of `time` seconds, the other κ steps of a κ-th of it (Zhang et al., section 4.2, eqs 51–60; here either side may be the
//! slower one). Contacts between them are found at every step of the faster side, with the slower one carried on by the mean velocity of its last step (eq. 60: the
//! way it went over the time it took). What a contact gives the faster side in each of its steps, it takes from the slower one over the cycle as the mean
//! of these forces: impulses are equal and opposite, so momentum is conserved to rounding, whatever κ is. With κ = 1 both are found from one instant.

use super::{FinesAsPoints, PointContacts, Rule};
use crate::coupling::evaluate::PointContactScene;
use crate::dem;
use crate::dem::event::Breakage;
use crate::dem::physics::Physics;
use crate::dem::{State, Workspace};
use crate::error::{Error, Result};
use crate::grains::Grains;
use crate::math::vector::plus;
use crate::mpm::Continuum;
use crate::mpm::loading_plate::{self, LoadingPlate};
use crate::point_contacts::{ContactRates, PointContactTable};
use crate::rigid::{self, Blocks};
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
    /// What they add to the square of a frequency, 1/s².
    pub contacts: f64,
    pub safety: f64,
    /// A cycle may be so much shorter than the slower side could do, 1 or less, if that saves a step of the faster one.
    pub nearly: f64,
    /// Instead of the rates that the bounds give.
    pub rates: Option<Rates>,
}

impl Cycle {
    /// The longest cycle that is stable: a side's frequency and that of the contacts add up, ω² ≤ ω_side² + ω_contacts². With rates that are given, the
    /// longest cycle that both sides can do with them.
    pub fn longest(allowed: &Allowed) -> Cycle {
        let of = |dt: f64| {
            let own = 2.0 * allowed.safety / dt;
            2.0 * allowed.safety / (own * own + allowed.contacts).sqrt()
        };
        let (grains, continuum) = (of(allowed.grains), of(allowed.continuum));
        let rates = allowed.rates.unwrap_or_else(|| {
            if allowed.grains == f64::INFINITY || allowed.continuum == f64::INFINITY {
                return Rates { grains: 1, continuum: 1 };
            }
            let steps = |slow: f64, fast: f64| (allowed.nearly * slow / fast).ceil().clamp(1.0, MOST) as u32;
            if grains <= continuum {
                Rates { grains: steps(continuum, grains), continuum: 1 }
            } else {
                Rates { grains: 1, continuum: steps(grains, continuum) }
            }
        });
        let time = (grains * f64::from(rates.grains)).min(continuum * f64::from(rates.continuum));
        Cycle { time, rates }
    }
}

/// Most steps of the faster side in a cycle.
const MOST: f64 = 1000.0;

/// The grains of a mixture with their contacts with points, beside a continuum.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Mixture {
    pub grains: State,
    pub point_contacts: PointContacts,
    /// Rigid bodies that are no spheres, where there are some; they make the grains' steps.
    pub blocks: Option<Box<Blocks>>,
    /// Where the mass that breakages lose becomes points.
    pub fines: Option<Box<FinesAsPoints>>,
    /// Breakages of a cycle, until they are taken.
    #[serde(skip)]
    pub breakages: Vec<Breakage>,
    /// Elastic energy of a contact between grains over its normal force and overlap: 2/5 by Hertz, 1/2 of a linear one.
    pub(super) energy_factor: f64,
    /// The last cycle.
    pub cycle: Cycle,
    /// Cycles done.
    pub cycles: u64,
    /// The last step of grains, and what their own contacts allow, s.
    pub(super) last: f64,
    own: f64,
    /// Steps of the continuum, and the largest speed at which a point was carried in the last one, m/s.
    fastest: (u64, f64),
    /// What the nodes felt of the contacts' stiffness in the last cycle, of what each point by itself would have.
    pub bound_ratio: f64,
    /// The latter for this cycle, 1/s², until the continuum's first step.
    #[serde(skip)]
    pub isolated_bound: Option<f64>,
    #[serde(skip)]
    sums: [Vec<f64>; 2],
}

/// What a mixture works on besides itself.
pub struct Parts<'a> {
    pub physics: &'a Physics,
    pub table: &'a PointContactTable,
    pub work: &'a mut Workspace,
    pub continuum: &'a mut Continuum,
    pub plates: &'a mut [LoadingPlate],
}

impl Mixture {
    pub fn new(physics: &Physics, grains: State, continuum: &mut Continuum, fines: Option<Rule>) -> Mixture {
        let energy_factor = if physics.contact.law.is_hertzian() { 0.4 } else { 0.5 };
        continuum.keep_transport_velocity();
        let cycle = Cycle { time: 0.0, rates: Rates { grains: 1, continuum: 1 } };
        Mixture {
            grains,
            point_contacts: PointContacts::default(),
            blocks: None,
            fines: fines.map(|rule| Box::new(FinesAsPoints::new(rule))),
            breakages: Vec::new(),
            energy_factor,
            cycle,
            cycles: 0,
            last: 0.0,
            own: 0.0,
            fastest: (u64::MAX, 0.0),
            bound_ratio: 1.0,
            isolated_bound: None,
            sums: Default::default(),
        }
    }

    /// The forces of this instant: between grains, and between grains and points.
    ///
    /// # Errors
    /// Rigid bodies that come within reach of each other.
    pub fn compute_forces(&mut self, parts: &mut Parts<'_>) -> Result<()> {
        dem::compute_forces(parts.physics, &mut self.grains, parts.work);
        self.note_bound();
        self.find(parts, self.last, [0.0; 2])?;
        self.evaluate_bodies(parts);
        Ok(())
    }

    /// What the grains' own contacts allow, s, and what those of points with grains and loading plates add to the square of a frequency, 1/s².
    ///
    /// What the nodes feel of the contacts' stiffness is known when the continuum has made its step. Contacts change little from a step to the next, so what they felt
    /// last of what each point by itself would have is taken for the present.
    pub fn bounds(&mut self, continuum: &Continuum, plates: &[LoadingPlate], slow: bool) -> (f64, f64) {
        // without grains nothing bounds their step
        let own = if self.grains.grains.is_empty() { f64::INFINITY } else { self.own };
        let mut rates = self.point_contacts.rates(&self.grains.grains, &mut self.sums, continuum.points().len());
        if let Some(blocks) = &mut self.blocks {
            let theirs = blocks.rates(&self.grains.grains, continuum.points().len());
            rates = ContactRates { points: rates.points + theirs.points, grains: rates.grains + theirs.grains };
        }
        let plates = plates.iter().map(|p| p.rate).fold(0.0, f64::max);
        self.isolated_bound = slow.then(|| rates.isolated_bound(plates));
        (own, rates.frequency2(plates, slow.then_some(self.bound_ratio)))
    }

    /// Makes one cycle with the forces that [`Self::compute_forces`] has found and loading plates that have pressed; walls and loading plates move at their speeds.
    ///
    /// # Errors
    /// A lost point; a loading plate through the points.
    pub fn make_cycle(&mut self, parts: &mut Parts<'_>, cycle: Cycle) -> Result<()> {
        self.cycle = cycle;
        let Cycle { time, rates } = cycle;
        let [of_grains, of_points] = [rates.continuum, rates.grains].map(|n| 1.0 / f64::from(n));
        self.apply_reactions(parts, of_grains, [of_points, ContactRates::END_SHARES[0]]);
        // but for the last one the steps of the continuum, beside grains that go on as they went
        let dt = time * of_grains;
        for j in 1..rates.continuum {
            self.step_continuum(parts, dt)?;
            loading_plate::press(parts.plates, parts.continuum)?;
            self.find(parts, dt, [dt * f64::from(j), 0.0])?;
            self.apply_reactions(parts, of_grains, [of_points, 0.0]);
        }
        self.move_grains(parts, time * of_points);
        self.end(parts, time - self.last, rates.grains - 1)
    }

    /// Goes on with a cycle of which `done` steps of the grains were made elsewhere: points already have what contacts gave them, the last forces included.
    ///
    /// # Errors
    /// As [`Self::make_cycle`].
    #[cfg(feature = "gpu")]
    pub fn finish_cycle(&mut self, parts: &mut Parts<'_>, done: u32) -> Result<()> {
        let Cycle { time, rates } = self.cycle;
        let dt = time / f64::from(rates.grains);
        self.apply_reactions(parts, 1.0, [0.0; 2]);
        self.move_grains(parts, dt);
        self.end(parts, time - dt * f64::from(done + 1), rates.grains - done - 1)
    }

    /// The other steps of the grains, for `left` seconds, beside points that go on as they went, and the last step of the continuum. Newborn grains may need shorter steps.
    fn end(&mut self, parts: &mut Parts<'_>, mut left: f64, mut steps: u32) -> Result<()> {
        let Cycle { time, rates } = self.cycle;
        while steps > 0 {
            dem::compute_forces(parts.physics, &mut self.grains, parts.work);
            if self.note_bound() {
                steps = steps.max((left / self.own).ceil().min(MOST) as u32);
            }
            self.find(parts, self.last, [0.0, time - left])?;
            self.evaluate_bodies(parts);
            let dt = left / f64::from(steps);
            self.apply_reactions(parts, 1.0, [dt / time, 0.0]);
            self.move_grains(parts, dt);
            left -= dt;
            steps -= 1;
        }
        self.cycles += 1;
        self.step_continuum(parts, time * (1.0 / f64::from(rates.continuum)))?;
        if let Some(fines) = &mut self.fines {
            fines.insert_points(&self.grains, parts.continuum, &mut self.point_contacts);
            let plates = &*parts.plates;
            let through = |p| plates.iter().any(|plate| plate.height(p).0 < 0.0);
            fines.remove_points(through, parts.continuum, &mut self.point_contacts);
        }
        Ok(())
    }

    fn move_grains(&mut self, parts: &mut Parts<'_>, dt: f64) {
        (self.grains.dt, self.last) = (dt, dt);
        if let Some(blocks) = &mut self.blocks {
            let State { grains, walls, fresh, .. } = &mut self.grains;
            blocks.apply_grain_and_wall_reactions(grains, &mut parts.work.external_forces, walls, dt);
            blocks.advance(parts.physics, *fresh, dt);
        }
        dem::integrate(parts.physics, &mut self.grains, parts.work);
        self.breakages.extend_from_slice(&parts.work.breakages);
        if let Some(fines) = &mut self.fines {
            fines.queue(&parts.work.breakages);
        }
    }

    /// A step of the continuum, and its loading plates' way in it.
    fn step_continuum(&mut self, parts: &mut Parts<'_>, dt: f64) -> Result<()> {
        parts.continuum.step(dt)?;
        if let Some(isolated) = self.isolated_bound.take() {
            self.bound_ratio = if isolated > 0.0 { (parts.continuum.contact_frequency_bound() / isolated).min(1.0) } else { 1.0 };
        }
        parts.plates.iter_mut().for_each(|p| p.advance(dt));
        Ok(())
    }

    fn apply_reactions(&mut self, parts: &mut Parts<'_>, of_grains: f64, of_points: [f64; 2]) {
        self.point_contacts.apply_reactions(
            &self.grains.grains,
            &mut parts.work.external_forces,
            of_grains,
            parts.continuum,
            of_points,
        );
        if let Some(blocks) = &mut self.blocks {
            blocks.apply_point_reactions(of_grains, parts.continuum, of_points);
        }
    }

    /// Forces between rigid bodies, grains and walls.
    fn evaluate_bodies(&mut self, parts: &Parts<'_>) {
        let Some(blocks) = &mut self.blocks else { return };
        blocks.evaluate(&rigid_scene(&self.grains, parts, self.last, [0.0; 2]), false);
    }

    /// Takes the grains' own bound where their step is not the one that they were given: then their contacts have been looked at again.
    fn note_bound(&mut self) -> bool {
        let looked = self.grains.dt != self.last;
        if looked {
            self.own = self.grains.dt;
        }
        looked
    }

    /// Lists and forces `dt` seconds after the last ones, with grains and points taken so far ahead.
    fn find(&mut self, parts: &Parts<'_>, dt: f64, ahead: [f64; 2]) -> Result<()> {
        let Parts { table, continuum, .. } = parts;
        let State { grains, walls, .. } = &self.grains;
        let walls = if table.touched_walls() == 0 { &[] } else { &walls[..] };
        let square = |v: &[f64]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        if self.fastest.0 != continuum.steps() {
            let velocities = &continuum.points().transport_velocity;
            let most = velocities.par_iter().with_min_len(4096).map(|v| square(v)).reduce(|| 0.0, f64::max);
            self.fastest = (continuum.steps(), most.sqrt());
        }
        let point = self.fastest.1;
        let grain = grains.vel.iter().map(|v| square(v)).fold(0.0, f64::max).sqrt();
        if dt * grain > continuum.settings().cell {
            too_fast(grains, continuum, dt)?;
        }
        let wall = walls.iter().map(|w| w.speed.abs()).fold(0.0, f64::max);
        let way = dt * (point + grain.max(wall)) + self.grains.aftermath.fastest_growth();
        self.point_contacts.update(grains, walls, continuum, way);
        let scene = PointContactScene { grains, walls, continuum, table, unloading: parts.physics.contact.unloading, dt, ahead };
        self.point_contacts.evaluate(&scene);
        if let Some(fines) = self.fines.as_mut().filter(|f| f.points > 0) {
            fines.released += self.point_contacts.release(&scene, fines.rule.release_strain);
        }
        if let Some(blocks) = &mut self.blocks {
            let way = dt * (point.max(grain).max(wall) + blocks.fastest());
            blocks.update(grains, &self.grains.walls, continuum, way)?;
            blocks.evaluate(&rigid_scene(&self.grains, parts, dt, ahead), true);
        }
        Ok(())
    }

    /// Mass, kg, and momentum, kg m/s, of grains, points and what breakages have left in reserve.
    pub fn mass_and_momentum(&self, continuum: &Continuum) -> (f64, [f64; 3]) {
        let (g, totals) = (&self.grains.grains, continuum.totals());
        let (mut mass, mut momentum) = (totals.mass, totals.momentum);
        for i in g.by_id().into_iter().map(|i| i as usize) {
            mass += g.mass[i];
            for (sum, v) in momentum.iter_mut().zip(g.vel[i]) {
                *sum += g.mass[i] * v;
            }
        }
        if let Some(blocks) = &self.blocks {
            let theirs = blocks.mass_and_momentum();
            mass += theirs.0;
            momentum = plus(momentum, theirs.1);
        }
        if let Some(fines) = &self.fines {
            mass += fines.reserve.mass;
            momentum.iter_mut().zip(fines.reserve.momentum).for_each(|(sum, p)| *sum += p);
        }
        (mass, momentum)
    }
}

/// Grains on the grid that would be through points before they see them; what has left it meets none.
fn too_fast(grains: &Grains, continuum: &Continuum, dt: f64) -> Result<()> {
    let settings = continuum.settings();
    let over = |i: &usize| {
        let (p, v) = (grains.pos[*i], grains.vel[*i]);
        let way = dt * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        let high = |a: usize| settings.lower[a] + settings.cell * f64::from(settings.cells[a]);
        way > settings.cell && (0..3).all(|a| (settings.lower[a]..high(a)).contains(&p[a]))
    };
    let Some(i) = (0..grains.len()).find(over) else { return Ok(()) };
    let what = format!(
        "a grain goes further than a cell, {:.4} mm, in a step of {dt:.3e} s, and would not see points in its way: lower stepping.safety or stepping.dt_s",
        1e3 * settings.cell
    );
    Err(Error::Unstable { step: continuum.steps(), what, grain: Some(u64::from(grains.id[i])) })
}

/// What contacts of rigid bodies are found from.
fn rigid_scene<'a>(state: &'a State, parts: &'a Parts<'_>, dt: f64, ahead: [f64; 2]) -> rigid::BlockScene<'a> {
    let Parts { physics, table, work, continuum, .. } = parts;
    let State { grains, walls, .. } = state;
    let (law, unloading) = (physics.contact.law, physics.contact.unloading);
    rigid::BlockScene { grains, walls, continuum, point_table: table, table: &work.table, law, unloading, dt, ahead }
}
