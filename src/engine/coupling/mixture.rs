//! One cycle of grains and continuum, each with time steps of its own.
//!
//! The side that allows the longer step makes one step of `time` seconds in a cycle, the other side κ steps of `time`/κ (Zhang et al., section 4.2,
//! eqs 51–60; here either side may be the slower one). Contact forces between the sides are computed at every step of the faster side. The slower
//! side's positions are extrapolated meanwhile with the mean velocity of its last step (eq. 60: distance over time). The slower side gets the mean over
//! the cycle of the forces that the faster side gets step by step. So impulses are equal and opposite, and momentum is conserved to rounding for any
//! κ. With κ = 1 both sides get the forces of one instant.

use super::{FinesAsPoints, PointContacts, Rule, account};
use crate::boundary::Drive;
use crate::check::{self, Checked, ensure};
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

/// Numbers of steps in a cycle; one of both is 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rates {
    /// Steps of the grains.
    pub grains: u32,
    /// Steps of the continuum.
    pub continuum: u32,
}

/// Length of a cycle, and the steps in it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cycle {
    /// Length, s.
    pub time: f64,
    /// Steps of both sides.
    pub rates: Rates,
}

/// Bounds from which a cycle is chosen ([`Cycle::longest`]).
#[derive(Clone, Copy, Debug)]
pub struct Allowed {
    /// Largest step of the grains by their own contacts, s, with the factor `safety` in it.
    pub grains: f64,
    /// Largest step of the continuum by waves through a cell, s, with the factor `safety` in it.
    pub continuum: f64,
    /// What contacts of points with grains and loading plates add to the square of a frequency, 1/s².
    pub contacts: f64,
    /// Time step over the largest stable one.
    pub safety: f64,
    /// Shortest cycle over what the slower side could do, 1 or less: a shorter cycle is taken if that saves a step of the faster side.
    pub nearly: f64,
    /// Numbers of steps that are given instead of chosen.
    pub rates: Option<Rates>,
}

impl Cycle {
    /// The longest stable cycle. Squares of frequencies add up, ω² ≤ ω_side² + ω_contacts², so each side's step becomes shorter by the contacts. The numbers
    /// of steps follow from the two steps, unless they are given.
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
            // from steps that are not numbers one step follows, and the next look at the state ends the run; a clamp would pass them on
            #[expect(clippy::manual_clamp)]
            let steps = |slow: f64, fast: f64| (allowed.nearly * slow / fast).ceil().max(1.0).min(MOST) as u32;
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

/// Largest number of steps of the faster side in a cycle.
const MOST: f64 = 1000.0;

/// The grains of a mixture and everything that couples them to a continuum. The continuum itself is passed to each call ([`Parts`]).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Mixture {
    /// The grains, with their walls and contacts.
    pub grains: State,
    /// Contacts of points with grains and walls.
    pub point_contacts: PointContacts,
    /// Rigid bodies that are not spheres, if there are some; they make the same steps as the grains.
    pub blocks: Option<Box<Blocks>>,
    /// Fines from crushing, if the mass that breakages lose becomes material points.
    pub fines: Option<Box<FinesAsPoints>>,
    /// Breakages since the caller last took them out.
    #[serde(skip)]
    pub breakages: Vec<Breakage>,
    /// Elastic energy of a contact over normal force times overlap: 2/5 by Hertz, 1/2 for linear laws.
    pub(super) energy_factor: f64,
    /// The present cycle; after it, the last one.
    pub cycle: Cycle,
    /// Number of cycles done.
    pub cycles: u64,
    /// Last step of the grains, s.
    pub(super) last: f64,
    /// Largest step of the grains by their own contacts, s.
    own: f64,
    /// Number of steps of the continuum, and the largest transport velocity of a point in the last of them, m/s.
    fastest: (u64, f64),
    /// In the last cycle: the bound on the square of a frequency that the nodes got from the stiffness of point contacts, over the bound if every point
    /// moved by itself. Neighbours share the masses of nodes, which makes it small; a face lies beside the centre of its point, which makes it larger than 1
    /// for a point by itself.
    pub bound_ratio: f64,
    /// The bound if every point moved by itself, 1/s², of this cycle; taken by the first step of the continuum in it.
    #[serde(skip)]
    pub isolated_bound: Option<f64>,
    /// Buffers of zeros for sums over points and over grains.
    #[serde(skip)]
    sums: [Vec<f64>; 2],
    /// Buffer: force, N, and stiffness, N/m, on each wall.
    #[serde(skip)]
    on_walls: Vec<[f64; 2]>,
}

/// What a cycle needs besides the mixture.
pub struct Parts<'a> {
    /// Laws and constants of the grains.
    pub physics: &'a Physics,
    /// Parameters of the point contacts.
    pub table: &'a PointContactTable,
    /// Buffers and neighbour lists of the grains.
    pub work: &'a mut Workspace,
    /// The continuum.
    pub continuum: &'a mut Continuum,
    /// Loading plates that press on the continuum.
    pub plates: &'a mut [LoadingPlate],
}

impl Mixture {
    /// A mixture before its first cycle. `fines`: how lost mass becomes points, if it does. The continuum keeps transport velocities from now on.
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
            on_walls: Vec::new(),
        }
    }

    /// Opens the energy account of the points' contacts with sums of zero.
    pub fn keep_account(&mut self, continuum: &Continuum) {
        self.point_contacts.keep_account(&self.grains.grains, continuum);
    }

    /// Checks a mixture that comes from outside with its `continuum`. `made` are both as the same run made them; points touch `walls` walls of the grains.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, continuum: &Continuum, physics: &Physics, made: (&Mixture, &Continuum), walls: usize) -> Checked {
        self.grains.check(physics, &made.0.grains)?;
        let added = if self.fines.is_some() { FinesAsPoints::most(self.grains.crush_events) } else { 0 };
        continuum.check(made.1, added)?;
        self.point_contacts.check(&self.grains.grains, walls, continuum)?;
        match (&self.blocks, &made.0.blocks) {
            (Some(blocks), Some(made)) => blocks.check(made, &self.grains, continuum)?,
            (None, None) => {}
            _ => return Err("rigid bodies are not those of the scene".into()),
        }
        match (&self.fines, &made.0.fines) {
            (Some(fines), Some(made)) => fines.check(&made.rule, continuum.points().len())?,
            (None, None) => {}
            _ => return Err("lost mass becomes points in another way than in the scene".into()),
        }
        ensure(self.energy_factor == made.0.energy_factor, || "energies of contacts are of another law".into())?;
        let Cycle { time, rates: Rates { grains, continuum } } = self.cycle;
        let possible = (1..=MOST as u32).contains(&grains.max(continuum)) && grains.min(continuum) == 1;
        ensure(possible, || format!("a cycle has {grains} steps of grains and {continuum} of points"))?;
        check::counters("cycles", &[self.cycles])?;
        check::not_negative("times of a cycle", [time, self.last, self.fastest.1])?;
        check::all("largest step of the grains", [self.own], "not from 0 on", |x| x >= 0.0)?;
        check::not_negative("bound by contacts", [self.bound_ratio])
    }

    /// Computes the forces of this instant between grains, and between grains and points.
    ///
    /// # Errors
    /// Rigid bodies that come within reach of each other; a grain that moves further than a cell in a step.
    pub fn compute_forces(&mut self, parts: &mut Parts<'_>) -> Result<()> {
        dem::compute_forces(parts.physics, &mut self.grains, parts.work);
        self.note_bound();
        // contacts of points were last computed before the last step of the faster side
        let since = self.last / f64::from(self.cycle.rates.continuum);
        self.find(parts, since, [0.0; 2])?;
        self.evaluate_bodies(parts);
        self.press_walls();
        Ok(())
    }

    /// Largest step of the grains by their own contacts, s, and what contacts of points with grains and loading plates add to the square of a frequency,
    /// 1/s². `slow`: contacts have to be stable only ([`crate::dem::physics::Stepping::slow`]).
    ///
    /// The bound at the nodes is known only after the step of the continuum. As contacts change little in a step, the bound of isolated points is multiplied
    /// with the ratio of the two in the last cycle.
    pub fn bounds(&mut self, continuum: &Continuum, plates: &[LoadingPlate], slow: bool) -> (f64, f64) {
        // no grains, no bound
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

    /// Makes one cycle. Before it, [`Self::compute_forces`] and [`loading_plate::press`] must have computed the forces of this instant. Walls and loading
    /// plates move at their speeds.
    ///
    /// # Errors
    /// A point that is lost; a loading plate that has passed a point; as [`Self::compute_forces`].
    pub fn make_cycle(&mut self, parts: &mut Parts<'_>, cycle: Cycle) -> Result<()> {
        self.cycle = cycle;
        let Cycle { time, rates } = cycle;
        let [of_grains, of_points] = [rates.continuum, rates.grains].map(|n| 1.0 / f64::from(n));
        self.apply_reactions(parts, of_grains, [of_points, ContactRates::END_SHARES[0]]);
        // all steps of the continuum but the last, with extrapolated grains
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

    /// Continues a cycle of which a device has made `done` steps of the grains. The points already have the forces of their contacts up to and with the
    /// present instant, but for the stiffness.
    ///
    /// # Errors
    /// As [`Self::make_cycle`].
    #[cfg(feature = "gpu")]
    pub fn finish_cycle(&mut self, parts: &mut Parts<'_>, done: u32) -> Result<()> {
        let Cycle { time, rates } = self.cycle;
        let dt = time / f64::from(rates.grains);
        self.apply_reactions(parts, 1.0, [0.0, ContactRates::END_SHARES[0]]);
        self.move_grains(parts, dt);
        self.end(parts, time - dt * f64::from(done + 1), rates.grains - done - 1)
    }

    /// Ends a cycle: the other `steps` steps of the grains, `left` seconds in all, with extrapolated points; then the last step of the continuum. Grains born
    /// meanwhile may need shorter steps.
    fn end(&mut self, parts: &mut Parts<'_>, mut left: f64, mut steps: u32) -> Result<()> {
        let Cycle { time, rates } = self.cycle;
        while steps > 0 {
            dem::compute_forces(parts.physics, &mut self.grains, parts.work);
            if self.note_bound() {
                steps = steps.max((left / self.own).ceil().min(MOST) as u32);
            }
            self.find(parts, self.last, [0.0, time - left])?;
            self.evaluate_bodies(parts);
            self.press_walls();
            let dt = left / f64::from(steps);
            self.apply_reactions(parts, 1.0, [dt / time, 0.0]);
            self.move_grains(parts, dt);
            left -= dt;
            steps -= 1;
        }
        self.cycles += 1;
        self.step_continuum(parts, time * (1.0 / f64::from(rates.continuum)))?;
        if let Some(fines) = &mut self.fines {
            let before = self.point_contacts.account.as_ref().map(|_| account::of_points(parts.continuum));
            fines.insert_points(&self.grains, parts.continuum, &mut self.point_contacts);
            fines.remove_points_behind(parts.plates, parts.continuum, &mut self.point_contacts);
            if let (Some(before), Some(account)) = (before, &mut self.point_contacts.account) {
                account.add_inserted(before, account::of_points(parts.continuum));
            }
        }
        Ok(())
    }

    /// Moves points from breakages that are behind one of the loading plates back into the reserve; contacts of the others keep their forces.
    #[cfg(feature = "gpu")]
    pub fn remove_fines_behind(&mut self, plates: &[LoadingPlate], continuum: &mut Continuum) {
        if let Some(fines) = &mut self.fines {
            fines.remove_points_behind(plates, continuum, &mut self.point_contacts);
            self.point_contacts.locate_points(continuum);
        }
    }

    /// As after breakages that have lost mass: it becomes points at the end of the next cycle.
    #[cfg(all(test, feature = "gpu"))]
    pub fn lose(&mut self, breakages: &[Breakage]) {
        if let Some(fines) = &mut self.fines {
            fines.queue(breakages);
        }
    }

    /// Time over which the forces of this instant change the velocities of grains and rigid bodies before a step of `dt` seconds, s. Velocities stand at the middles of steps: from
    /// middle to middle it is half of both. Points take the forces of their contacts over the new step alone, and so does what they push, or momentum would be made.
    fn kick(&self, continuum: &Continuum, dt: f64) -> f64 {
        match (self.grains.fresh, continuum.points().is_empty()) {
            (true, _) => 0.5 * dt,
            (false, true) => 0.5 * (self.last + dt),
            (false, false) => dt,
        }
    }

    /// One step of the grains and rigid bodies with the forces added so far.
    fn move_grains(&mut self, parts: &mut Parts<'_>, dt: f64) {
        let kick = self.kick(parts.continuum, dt);
        if self.point_contacts.account.is_some() && dt != self.last && !self.grains.fresh {
            let power = self.power_on_grains(parts.physics.gravity);
            if let Some(account) = &mut self.point_contacts.account {
                account.step_change += (0.5 * (self.last + dt) - kick) * power;
            }
        }
        (self.grains.dt, self.last) = (dt, dt);
        parts.work.kick = Some(kick);
        if let Some(blocks) = &mut self.blocks {
            let State { grains, step, time, .. } = &self.grains;
            blocks.apply_grain_and_wall_reactions(grains, &mut parts.work.external_forces);
            let crush = parts.physics.crush.as_ref().filter(|crush| step.is_multiple_of(crush.interval.max(1)));
            let failing = crush.map_or(Vec::new(), |crush| blocks.failing(crush, &parts.work.table));
            blocks.advance(parts.physics, *time, kick, dt);
            if let Some(crush) = crush.filter(|_| !failing.is_empty()) {
                blocks.break_bodies(crush, &failing, *step, self.energy_factor);
            }
        }
        if let Some(account) = &mut self.point_contacts.account {
            account.before_grains(&parts.work.external_forces, &self.grains.grains, kick);
        }
        dem::move_grains(parts.physics, &mut self.grains, parts.work);
        if let Some(account) = &mut self.point_contacts.account {
            account.add_half_step(&self.grains.grains, kick);
        }
        dem::breakage(parts.physics, &mut self.grains, parts.work);
        self.breakages.extend_from_slice(&parts.work.breakages);
        if let Some(fines) = &mut self.fines {
            fines.queue(&parts.work.breakages);
        }
    }

    /// One step of the continuum and of the loading plates.
    fn step_continuum(&mut self, parts: &mut Parts<'_>, dt: f64) -> Result<()> {
        let mut of_bodies = self.blocks.as_mut().map_or(Vec::new(), |blocks| blocks.body_points());
        parts.continuum.step_beside(dt, &mut of_bodies)?;
        self.point_contacts.follow_faces(parts.continuum, dt);
        if let Some(blocks) = &mut self.blocks {
            blocks.take_impulses(&of_bodies, dt);
            blocks.follow_faces(&self.grains.grains, parts.continuum, dt);
        }
        if let Some(isolated) = self.isolated_bound.take() {
            self.bound_ratio = if isolated > 0.0 { parts.continuum.contact_frequency_bound() / isolated } else { 1.0 };
        }
        parts.plates.iter_mut().for_each(|p| p.advance(dt));
        Ok(())
    }

    /// Adds the forces of all point contacts: times `of_grains` to grains and rigid bodies, times `of_points[0]` to points, whose stiffness counts times
    /// `of_points[1]`.
    fn apply_reactions(&mut self, parts: &mut Parts<'_>, of_grains: f64, of_points: [f64; 2]) {
        self.point_contacts.apply_reactions(
            &self.grains.grains,
            &mut parts.work.external_forces,
            of_grains,
            (parts.continuum, parts.table.acts_on),
            of_points,
        );
        if let Some(blocks) = &mut self.blocks {
            blocks.apply_point_reactions(of_grains, (parts.continuum, parts.table.acts_on), of_points);
        }
    }

    /// Forces of the contacts of rigid bodies with grains and walls.
    fn evaluate_bodies(&mut self, parts: &Parts<'_>) {
        let Some(blocks) = &mut self.blocks else { return };
        blocks.evaluate(&rigid_scene(&self.grains, parts, self.last, [0.0; 2]), false);
        blocks.pull(self.grains.time);
    }

    /// Adds the forces of points and rigid bodies to the walls' reactions, stiffnesses and work, which have been those of grains so far. Where no wall moves nobody asks.
    fn press_walls(&mut self) {
        if !self.has_moving_walls() {
            return;
        }
        let mut sums = std::mem::take(&mut self.on_walls);
        self.press_by_others(&mut sums);
        for (wall, &mut [force, stiffness]) in self.grains.walls.iter_mut().zip(&mut sums) {
            // trapezium rule: the last reaction, of all, has been counted by the grains' step as if grains alone had pressed
            wall.work += 0.5 * force * wall.speed * self.last;
            wall.reaction += force;
            wall.stiffness += stiffness;
        }
        self.on_walls = sums;
    }

    /// Sets `sums` to the forces of points and rigid bodies on each wall, N, and the stiffnesses of their contacts, N/m.
    fn press_by_others(&self, sums: &mut Vec<[f64; 2]>) {
        sums.clear();
        sums.resize(self.grains.walls.len(), [0.0; 2]);
        self.point_contacts.add_wall_forces(sums);
        if let Some(blocks) = &self.blocks {
            blocks.add_wall_forces(sums);
        }
    }

    /// Normal force of grains, points and rigid bodies on wall `wall`, N, at the instant of the last [`Self::compute_forces`], whether walls move or not.
    pub fn force_on_wall(&self, wall: usize) -> f64 {
        let mut sums = Vec::new();
        if !self.has_moving_walls() {
            self.press_by_others(&mut sums);
        }
        self.grains.walls[wall].reaction + sums.get(wall).map_or(0.0, |[force, _]| *force)
    }

    /// Breakages of grains and of rigid bodies so far.
    pub fn crush_events(&self) -> u64 {
        self.grains.crush_events + self.blocks.as_ref().and_then(|b| b.breaking()).map_or(0, |b| b.events)
    }

    /// Whether a wall of the grains moves or is under servo. Then the walls' reactions count grains, points and rigid bodies, else grains alone.
    pub fn has_moving_walls(&self) -> bool {
        self.grains.walls.iter().any(|wall| wall.drive != Drive::Fixed)
    }

    /// Takes over a new bound on the grains' step. [`dem::compute_forces`] writes it into the grains' time step, which then differs from the last step.
    fn note_bound(&mut self) -> bool {
        let looked = self.grains.dt != self.last;
        if looked {
            self.own = self.grains.dt;
        }
        looked
    }

    /// Renews candidates and forces of point contacts, `dt` seconds after the last time; `ahead`: times, s, by which grains and points are extrapolated.
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
        if let Some(account) = &mut self.point_contacts.account {
            account.note_gone(&self.point_contacts.candidates, grains, continuum);
        }
        self.point_contacts.update(grains, walls, continuum, way);
        let scene = PointContactScene { grains, walls, continuum, table, unloading: parts.physics.contact.unloading, dt, ahead };
        self.point_contacts.evaluate(&scene);
        if let Some(fines) = self.fines.as_mut().filter(|f| f.points > 0) {
            fines.released += self.point_contacts.release(&scene, fines.rule.release_strain);
        }
        if let Some(blocks) = &mut self.blocks {
            let fastest = blocks.fastest();
            let way = dt * (point.max(grain).max(wall).max(fastest) + fastest);
            blocks.update(grains, &self.grains.walls, continuum, way, ahead[0])?;
            blocks.evaluate(&rigid_scene(&self.grains, parts, dt, ahead), true);
        }
        Ok(())
    }

    /// Mass, kg, and momentum, kg m/s, of grains, rigid bodies, points and the reserve of fines.
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

/// Checks for grains inside of the grid that move further than a cell in a step, and so could pass points without touching them.
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

/// Input for the contact forces of rigid bodies.
fn rigid_scene<'a>(state: &'a State, parts: &'a Parts<'_>, dt: f64, ahead: [f64; 2]) -> rigid::BlockScene<'a> {
    let Parts { physics, table, work, continuum, .. } = parts;
    let State { grains, walls, .. } = state;
    let (law, unloading) = (physics.contact.law, physics.contact.unloading);
    rigid::BlockScene { grains, walls, continuum, point_table: table, table: &work.table, law, unloading, dt, ahead }
}
