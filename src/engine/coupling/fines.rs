//! Fines from crushing: the mass that a breakage loses enters the continuum as material points.
//!
//! The points are placed in the sphere of the broken grain, in the volume that daughters and present points leave free, at the porosity that the
//! continuum's own fines had at the start and without stress. That is the void ratio to which the deformation of their law refers, and nowhere in that
//! sphere are the fines denser.
//!
//! Mass that finds no room stays in a *reserve*, with its share of the momentum. So does mass whose point would be too small for the continuum (less
//! than an eighth of a point of the scene), or alone in its cell (nodes would then carry the mass of that point only), and so do points that a grain
//! pushes through a wall or loading plate. Grains, points and reserve together keep mass and momentum to rounding.
//!
//! A point stands for many fines, so its ghost overlaps the daughters around it. The overlap that a contact has when it is born bears no force
//! (the reference overlap of [`PointContact`](super::PointContact)). It shrinks when the two move apart, and while they slide past each other: to 1/e over a
//! sliding distance given by [`Rule::release_strain`]. The elastic energy gained by that is counted.

use super::PointContacts;
use crate::boundary::Wall;
use crate::check::{self, Checked, ensure};
use crate::dem::State;
use crate::dem::event::Breakage;
use crate::grains::Grains;
use crate::math::random::lineage_uniform;
use crate::math::vector::{dot, less};
use crate::mpm::loading_plate::ghost_radius;
use crate::mpm::{Continuum, Dimension, Point};
use serde::{Deserialize, Serialize};

/// How lost mass becomes points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rule {
    /// Sliding distance between point and grain, over the ghost's diameter, in which the overlap without force falls to 1/e.
    pub release_strain: f64,
    /// Index of the points' constitutive law.
    pub law: u8,
    /// Porosity of new points.
    pub porosity: f64,
    /// Largest volume of solids of a new point, m³: that of a point of the scene.
    pub solid: f64,
    /// Density of the grains, kg/m³.
    pub density: f64,
    /// Whether points begin at rest. With inertia scaling they do, as the momentum of a grain then is not that of its real mass.
    pub at_rest: bool,
}

/// An account of mass with its momentum and kinetic energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Account {
    /// Mass, kg.
    pub mass: f64,
    /// Momentum, kg m/s.
    pub momentum: [f64; 3],
    /// Kinetic energy, J.
    pub kinetic: f64,
}

impl Account {
    /// Adds mass, kg, momentum, kg m/s, and kinetic energy, J.
    fn add(&mut self, mass: f64, momentum: [f64; 3], kinetic: f64) {
        self.mass += mass;
        self.kinetic += kinetic;
        self.momentum.iter_mut().zip(momentum).for_each(|(sum, p)| *sum += p);
    }
}

/// The mass that all breakages so far have lost: in points and in the reserve.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FinesAsPoints {
    /// How lost mass becomes points.
    pub rule: Rule,
    /// Mass that has found no room.
    pub reserve: Account,
    /// Mass that is in points now; momentum and kinetic energy are those with which points were added.
    pub entered: Account,
    /// Number of points that were added and still exist.
    pub points: u64,
    /// Elastic energy that contacts have gained while their overlaps without force shrank, J.
    pub released: f64,
    /// Breakages whose mass has not become points yet.
    waiting: Vec<Breakage>,
}

/// Number of trial places for the points of one breakage; about half of them lie in the sphere of the broken grain.
const CANDIDATES: u64 = 2000;
/// Largest ratio of the solid volume of a point of the scene to that of a new point.
const SMALLER: f64 = 8.0;
/// Number of points that a breakage makes, if its mass is enough and not too much for them.
const PER_EVENT: f64 = 32.0;
/// Largest overlap of a new ghost with a grain, over the ghost's radius.
const DEEPEST: f64 = 0.6;
/// Smallest distance between two new points, over the ghost's diameter.
const LEAST_ROOM: f64 = 0.25;
/// Smallest number of points in a cell with new points.
const COMPANY: usize = 2;

/// The surroundings of a breakage, in which its points are placed.
struct Around<'a> {
    /// Centre of the broken grain, m.
    centre: [f64; 3],
    /// Radius of the broken grain, m.
    radius: f64,
    grains: &'a Grains,
    /// Radii of all grains, m; of growing ones their final radii.
    radii: &'a [f64],
    /// Indices of the grains near the broken one.
    grains_near: Vec<usize>,
    walls: &'a [Wall],
    continuum: &'a Continuum,
}

impl FinesAsPoints {
    /// Without breakages so far.
    pub fn new(rule: Rule) -> FinesAsPoints {
        let (reserve, entered) = (Account::default(), Account::default());
        FinesAsPoints { rule, reserve, entered, points: 0, released: 0.0, waiting: Vec::new() }
    }

    /// Largest number of points that `events` breakages have added.
    pub(super) fn most(events: u64) -> u64 {
        events.saturating_mul(CANDIDATES)
    }

    /// Checks the accounts of a run whose lost mass becomes points by `rule`, with `points` points in all.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub(super) fn check(&self, rule: &Rule, points: usize) -> Checked {
        ensure(self.rule == *rule, || "lost mass becomes points in another way than in the scene".into())?;
        for account in [&self.reserve, &self.entered] {
            check::numbers("accounts of fines", account.momentum.iter().chain([&account.mass, &account.kinetic]))?;
        }
        ensure(self.points <= points as u64, || format!("{} of {points} points come from breakages", self.points))?;
        check::numbers("energy of fines", [self.released])?;
        self.waiting.iter().try_for_each(Breakage::check)
    }

    /// Takes note of breakages, for [`Self::insert_points`].
    pub(super) fn queue(&mut self, breakages: &[Breakage]) {
        self.waiting.extend_from_slice(breakages);
    }

    /// Turns the mass lost in the breakages noted so far into points of the continuum; the rest goes to the reserve.
    pub(super) fn insert_points(&mut self, state: &State, continuum: &mut Continuum, point_contacts: &mut PointContacts) {
        if self.waiting.is_empty() {
            return;
        }
        let State { grains, walls, aftermath, .. } = state;
        // growing daughters count with their final size
        let radii = aftermath.radii(grains);
        for mut event in std::mem::take(&mut self.waiting) {
            if self.rule.at_rest {
                (event.lost_momentum, event.lost_kinetic) = ([0.0; 3], 0.0);
            }
            let (mass, places) = self.places(&event, grains, &radii, walls, continuum);
            let share = mass * places.len() as f64 / event.lost_mass;
            let of = |share: f64| event.lost_momentum.map(|p| share * p);
            let velocity = event.lost_momentum.map(|p| p / event.lost_mass);
            let kinetic = 0.5 * share * dot(event.lost_momentum, velocity);
            self.entered.add(share * event.lost_mass, of(share), kinetic);
            self.reserve.add((1.0 - share) * event.lost_mass, of(1.0 - share), (1.0 - share) * event.lost_kinetic);
            if places.is_empty() {
                continue;
            }
            self.points += places.len() as u64;
            let volume = mass / self.rule.density / (1.0 - self.rule.porosity);
            let Rule { law, porosity, .. } = self.rule;
            let point = |position| Point { position, velocity, mass, volume, stress: [0.0; 6], porosity, law };
            let new: Vec<Point> = places.into_iter().map(point).collect();
            point_contacts.note_newborn(continuum.insert(&new), grains.next_id);
        }
    }

    /// Moves points from breakages that a grain has pushed through a loading plate or wall back into the reserve. `through`: whether a position is behind one.
    pub(super) fn remove_points(
        &mut self,
        through: impl Fn([f64; 4]) -> bool,
        continuum: &mut Continuum,
        point_contacts: &mut PointContacts,
    ) {
        let points = continuum.points();
        let lost: Vec<usize> =
            (0..points.len()).filter(|&i| point_contacts.is_newborn(points.id[i]) && through(points.position[i])).collect();
        if lost.is_empty() {
            return;
        }
        let mut gone = vec![false; points.len()];
        for i in lost {
            let ([u, v, w, mut mass], mut velocity) = (points.velocity[i], [0.0; 3]);
            if self.rule.at_rest {
                mass = self.rule.density * points.solid(i);
            } else {
                velocity = [u, v, w];
            }
            self.reserve.add(mass, velocity.map(|u| mass * u), 0.5 * mass * dot(velocity, velocity));
            self.entered.mass -= mass;
            self.points -= 1;
            gone[i] = true;
        }
        continuum.points_mut().remove(&gone);
        point_contacts.forget();
    }

    /// Mass of each point of a breakage, kg, and the positions of its points, m; no positions if nothing can be added.
    fn places(
        &self,
        event: &Breakage,
        grains: &Grains,
        radii: &[f64],
        walls: &[Wall],
        continuum: &Continuum,
    ) -> (f64, Vec<[f64; 3]>) {
        let (rule, radius, lost) = (&self.rule, 0.5 * event.diameter, event.lost_mass / self.rule.density);
        // the daughters leave free a volume as large as that of the lost solids
        let room = (1.0 - rule.porosity) * (lost - volume_of_points(continuum, event.position, radius)).max(0.0);
        if SMALLER * room < rule.solid {
            return (0.0, Vec::new());
        }
        let number = (SMALLER * room / rule.solid).floor().min(PER_EVENT).max((room / rule.solid).ceil());
        let solid = room / number;
        let point_radius = ghost_radius(Dimension::Space, solid);
        let reach = radius + point_radius;
        let within_reach = |i: &usize| {
            let p = grains.pos[*i];
            let far = reach + radii[*i];
            let d = less([p[0], p[1], p[2]], event.position);
            dot(d, d) < far * far
        };
        let grains_near = (0..grains.len()).filter(within_reach).collect();
        let around = Around { centre: event.position, radius, grains, radii, grains_near, walls, continuum };
        let mut places = around.spread(event.lineage, point_radius, number as usize);
        let mass = solid * rule.density;
        // removing a point for one reason can leave another one alone in its cell: repeat until nothing changes
        loop {
            let number = places.len();
            around.drop_lonely(&mut places);
            around.drop_highest(event, mass, &mut places);
            if places.len() == number {
                return (mass, places);
            }
        }
    }
}

impl Around<'_> {
    /// Up to `number` positions in the sphere of the broken grain, each as far from grains and from the other positions as possible. Positions too deep in a
    /// grain or within reach of a wall are left out. `point_radius`: ghost radius of the new points, m.
    fn spread(&self, lineage: u64, point_radius: f64, number: usize) -> Vec<[f64; 3]> {
        let settings = self.continuum.settings();
        let inside = |p: &[f64; 3]| {
            (0..3).all(|a| {
                let (low, high) = (settings.lower[a], settings.lower[a] + settings.cell * f64::from(settings.cells[a]));
                p[a] > low && p[a] < high
            })
        };
        let shift = lineage_uniform(lineage);
        // position, and free distance around it over the ghost's radius
        let mut candidates: Vec<([f64; 3], f64)> = (1..=CANDIDATES)
            .map(|k| std::array::from_fn(|a| 2.0 * (halton(k, [2, 3, 5][a]) + shift[a]).fract() - 1.0))
            .filter(|u: &[f64; 3]| dot(*u, *u) < 1.0)
            .map(|u| std::array::from_fn(|a| self.centre[a] + self.radius * u[a]))
            .filter(|p| inside(p) && self.walls.iter().all(|w| w.shape.towards([p[0], p[1], p[2], point_radius]).1 >= 0.0))
            .map(|p| (p, self.clearance(p) / point_radius))
            .filter(|(_, room)| *room >= 1.0 - DEEPEST)
            .collect();
        let mut places: Vec<[f64; 3]> = Vec::with_capacity(number.min(CANDIDATES as usize));
        while places.len() < number {
            // the first of equal ones, so that the order is fixed
            let mut best: Option<usize> = None;
            for (k, (_, room)) in candidates.iter().enumerate() {
                if best.is_none_or(|b| *room > candidates[b].1) {
                    best = Some(k);
                }
            }
            let Some(best) = best else { break };
            let place = candidates.swap_remove(best).0;
            for (p, room) in &mut candidates {
                let d = less(*p, place);
                *room = room.min(0.5 * dot(d, d).sqrt() / point_radius);
            }
            // positions too close to the one taken
            candidates.retain(|(_, room)| *room > LEAST_ROOM);
            places.push(place);
        }
        places
    }

    /// Distance from the nearest surface of a grain, m; negative inside of it.
    fn clearance(&self, p: [f64; 3]) -> f64 {
        let to = |i: &usize| {
            let g = self.grains.pos[*i];
            let d = less(p, [g[0], g[1], g[2]]);
            dot(d, d).sqrt() - self.radii[*i]
        };
        self.grains_near.iter().map(to).fold(f64::INFINITY, f64::min)
    }

    /// Removes positions whose point would be alone in its cell.
    fn drop_lonely(&self, places: &mut Vec<[f64; 3]>) {
        let settings = self.continuum.settings();
        let cell =
            |p: [f64; 3]| -> [i64; 3] { std::array::from_fn(|a| ((p[a] - settings.lower[a]) / settings.cell).floor() as i64) };
        let far = self.radius + settings.cell;
        let mut cells: Vec<[i64; 3]> = places.iter().map(|p| cell(*p)).collect();
        self.continuum.visit([-far, far].map(|by| self.centre.map(|x| x + by)), |i| {
            let [x, y, z, _] = self.continuum.points().position[i];
            cells.push(cell([x, y, z]));
        });
        let mut at = 0;
        places.retain(|_| {
            at += 1;
            cells.iter().filter(|c| **c == cells[at - 1]).count() >= COMPANY
        });
    }

    /// Removes the highest positions until the kinetic and potential energy of the points is not more than the energy that the breakage has taken away.
    fn drop_highest(&self, event: &Breakage, mass: f64, places: &mut Vec<[f64; 3]>) {
        let gravity = self.continuum.settings().gravity;
        let velocity = event.lost_momentum.map(|p| p / event.lost_mass);
        let kinetic = 0.5 * mass * dot(velocity, velocity);
        let lift = |p: &[f64; 3]| -mass * dot(gravity, less(*p, event.position));
        let gone =
            |n: usize| event.lost_kinetic * mass * n as f64 / event.lost_mass + (event.stored_before - event.stored_after).max(0.0);
        while places.iter().map(|p| kinetic + lift(p)).sum::<f64>() > gone(places.len()) * (1.0 + 1e-12) {
            let highest = (0..places.len()).reduce(|a, b| if lift(&places[b]) > lift(&places[a]) { b } else { a });
            let Some(highest) = highest else { break };
            places.remove(highest);
        }
    }
}

/// Sum of the volumes of the points in a sphere, m³.
fn volume_of_points(continuum: &Continuum, centre: [f64; 3], radius: f64) -> f64 {
    let mut inside = Vec::new();
    continuum.visit([-radius, radius].map(|by| centre.map(|x| x + by)), |i| {
        let [x, y, z, volume] = continuum.points().position[i];
        let d = less([x, y, z], centre);
        if dot(d, d) < radius * radius {
            inside.push((continuum.points().id[i], volume));
        }
    });
    inside.sort_unstable_by_key(|(id, _)| *id);
    inside.into_iter().map(|(_, volume)| volume).sum()
}

/// The k-th number of van der Corput's sequence to a base, in 0..1; three bases give evenly spread points in a cube (Halton 1960).
fn halton(mut k: u64, base: u64) -> f64 {
    let (mut sum, mut share) = (0.0, 1.0);
    while k > 0 {
        share /= base as f64;
        sum += share * (k % base) as f64;
        k /= base;
    }
    sum
}
