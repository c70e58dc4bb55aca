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
use crate::mpm::{Continuum, Dimension, LoadingPlate, Point};
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

    /// Moves points from breakages that a grain has pushed through one of the loading plates back into the reserve.
    pub(super) fn remove_points_behind(
        &mut self,
        plates: &[LoadingPlate],
        continuum: &mut Continuum,
        point_contacts: &mut PointContacts,
    ) {
        self.remove_points(|p| plates.iter().any(|plate| plate.height(p).0 < 0.0), continuum, point_contacts);
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

#[cfg(test)]
mod tests {
    use super::super::tests::{continuum, floor, grain, physics, point, settings};
    use super::*;
    use crate::contact::ContactLaw;
    use crate::mpm::law::{Elastic, Law};
    use crate::mpm::{Points, Settings};

    /// Density of grains, kg/m³.
    const DENSITY: f64 = 2500.0;

    fn rule(solid: f64) -> Rule {
        Rule { release_strain: 0.1, law: 0, porosity: 0.4, solid, density: DENSITY, at_rest: false }
    }

    /// What a breakage leaves: the account, the continuum with its points, and their contacts.
    fn made(
        rule: Rule,
        event: Breakage,
        grains: Grains,
        walls: Vec<Wall>,
        mut continuum: Continuum,
    ) -> (FinesAsPoints, Continuum, PointContacts) {
        let state = State::new(&physics(ContactLaw::Hertz), grains, walls, false);
        let mut fines = FinesAsPoints::new(rule);
        let mut contacts = PointContacts::default();
        fines.queue(&[event]);
        fines.insert_points(&state, &mut continuum, &mut contacts);
        // nothing waits any more
        fines.insert_points(&state, &mut continuum, &mut contacts);
        (fines, continuum, contacts)
    }

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{found} instead of {expected}");
    }

    fn place(continuum: &Continuum, i: usize) -> [f64; 3] {
        let [x, y, z, _] = continuum.points().position[i];
        [x, y, z]
    }

    #[test]
    fn halton_numbers_are_digits_mirrored_at_the_point() {
        let of = |base: u64| (1..=5).map(|k| halton(k, base)).collect::<Vec<_>>();
        assert_eq!(of(2), [0.5, 0.25, 0.75, 0.125, 0.625]);
        for (found, ninths) in of(3).iter().zip([3.0, 6.0, 1.0, 4.0, 7.0]) {
            near(*found, ninths / 9.0);
        }
    }

    /// Breaks a grain in the open: mass and momentum of the breakage are those of the points and of the reserve together. The solids of a point, room for
    /// which the daughters leave at the fines' porosity, are as many as 32 points can share, and the points fill the sphere of the grain without crowding.
    #[test]
    fn mass_and_momentum_of_a_breakage_are_in_points_and_reserve() {
        let (radius, lost, velocity) = (0.1, 8.0, [0.3, -0.2, 0.1]);
        let solids = lost / DENSITY;
        let room = 0.6 * solids;
        for (solid, number) in [(room / 4.5, 32), (room / 2.5, 20), (room / 40.5, 41)] {
            let event = Breakage::lost([0.05, 0.1, -0.1], 2.0 * radius, lost, velocity);
            let (fines, continuum, contacts) = made(rule(solid), event.clone(), Grains::default(), Vec::new(), continuum(&[]));
            let points = continuum.points();
            // some would be alone in their cells and are left out
            let made = points.len();
            assert!(made <= number && made > number / 2 && fines.points == made as u64, "{solid}: {made}");
            near(fines.entered.mass + fines.reserve.mass, lost);
            near(fines.entered.mass, DENSITY * room * made as f64 / number as f64);
            near(fines.entered.kinetic + fines.reserve.kinetic, 0.5 * lost * dot(velocity, velocity));
            let of_points = continuum.totals();
            near(of_points.mass, fines.entered.mass);
            for (a, v) in velocity.iter().enumerate() {
                near(fines.entered.momentum[a] + fines.reserve.momentum[a], lost * v);
                near(of_points.momentum[a], fines.entered.momentum[a]);
            }
            // a point takes up the room of its solids: over (1 - porosity)
            assert!(points.position.iter().all(|p| (p[3] / (solids / number as f64) - 1.0).abs() < 1e-12));
            let ghost = ghost_radius(Dimension::Space, room / number as f64);
            for i in 0..made {
                assert!(contacts.is_newborn(points.id[i]));
                assert_eq!((points.law[i], points.initial_porosity[i], points.stress[i]), (0, 0.4, [0.0; 6]));
                let d = less(place(&continuum, i), event.position);
                assert!(dot(d, d).sqrt() < radius);
                for j in 0..i {
                    let d = less(place(&continuum, i), place(&continuum, j));
                    assert!(dot(d, d).sqrt() > LEAST_ROOM * 2.0 * ghost, "{i} {j}");
                }
            }
            // spread over the sphere: the middle of the points is near its own
            let middle = (0..made).fold([0.0; 3], |m, i| plus3(m, place(&continuum, i)));
            let off = less(middle.map(|x| x / made as f64), event.position);
            assert!(dot(off, off).sqrt() < 0.25 * radius, "{off:?}");
        }
    }

    fn continuum_without_points() -> Continuum {
        continuum(&[])
    }

    fn plus3(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| a[k] + b[k])
    }

    /// With inertia scaling points begin at rest, and nothing is said of the momentum.
    #[test]
    fn points_at_rest_have_no_momentum() {
        let event = Breakage::lost([0.0; 3], 0.4, 8.0, [0.3, -0.2, 0.1]);
        let (fines, continuum, _) =
            made(Rule { at_rest: true, ..rule(5e-4) }, event, Grains::default(), Vec::new(), continuum(&[]));
        assert!(!continuum.points().is_empty());
        assert_eq!((continuum.totals().momentum, fines.entered.momentum, fines.reserve.momentum), ([0.0; 3], [0.0; 3], [0.0; 3]));
        assert_eq!((fines.entered.kinetic, fines.reserve.kinetic), (0.0, 0.0));
    }

    /// Too little mass for a point goes to the reserve: below an eighth of the solids of a point.
    #[test]
    fn too_little_mass_waits() {
        let lost = 8.0;
        let room = 0.6 * lost / DENSITY;
        for (share, points) in [(7.9, true), (8.1, false)] {
            let event = Breakage::lost([0.0; 3], 0.2, lost, [0.0; 3]);
            // one point alone in its cell would be dropped: there are others beside
            let others: Vec<Point> = (0..27)
                .map(|k| point([f64::from(k % 3), f64::from(k / 3 % 3), f64::from(k / 9)].map(|x| 0.125 * x - 0.12), [0.0; 3]))
                .collect();
            // one of them is inside of the sphere
            let volume = others[13].volume;
            let lacking = Breakage { lost_mass: lost + DENSITY * volume, ..event };
            let (fines, _, _) = made(rule(share * room), lacking.clone(), Grains::default(), Vec::new(), continuum(&others));
            assert_eq!(fines.points, u64::from(points), "{share}");
            assert_eq!(fines.reserve.mass == lacking.lost_mass, !points);
        }
    }

    /// Points of a breakage keep away from grains and walls, and stay in the domain.
    #[test]
    fn points_find_room_between_grains_and_walls() {
        let at = [0.1, 0.0, 0.1];
        let grains = grain(at, [0.0; 3], [0.0; 3], &physics(ContactLaw::Hertz));
        let event = Breakage::lost([0.1, 0.0, 0.15], 0.4, 8.0, [0.0; 3]);
        let (fines, continuum, _) = made(rule(5e-4), event, grains.clone(), vec![floor(0.0)], continuum(&[]));
        assert!(fines.points > 5, "{}", fines.points);
        let ghost = ghost_radius(Dimension::Space, continuum.points().solid(0));
        for i in 0..continuum.points().len() {
            let p = place(&continuum, i);
            let d = less(p, at);
            // not deeper in a grain than the share that is allowed, and not in the wall at all
            assert!(dot(d, d).sqrt() - grains.radius(0) >= (1.0 - DEEPEST) * ghost && p[2] >= ghost, "{p:?}");
        }
        // at the edge of the grid: inside of it
        let event = Breakage::lost([0.95, 0.0, -0.95], 0.4, 8.0, [0.0; 3]);
        let (fines, continuum, _) = made(rule(5e-4), event, Grains::default(), Vec::new(), continuum_without_points());
        assert!(fines.points > 2);
        for i in 0..continuum.points().len() {
            let [x, _, z] = place(&continuum, i);
            assert!(x < 1.0 && z > -1.0);
        }
    }

    /// The first position is the one with the most room; the others follow with less and less, and keep away from those before.
    #[test]
    fn the_position_with_the_most_room_is_taken_first() {
        let grains = grain([0.1, 0.0, 0.1], [0.0; 3], [0.0; 3], &physics(ContactLaw::Hertz));
        let continuum = continuum_without_points();
        let radii = [grains.radius(0)];
        let around = Around {
            centre: [0.1, 0.0, 0.15],
            radius: 0.2,
            grains: &grains,
            radii: &radii,
            grains_near: vec![0],
            walls: &[],
            continuum: &continuum,
        };
        let ghost = 0.02;
        let places = around.spread(77, ghost, 12);
        assert_eq!(places.len(), 12);
        let room = |k: usize| {
            let apart = |q: &[f64; 3]| 0.5 * dot(less(places[k], *q), less(places[k], *q)).sqrt();
            places[..k].iter().map(apart).fold(around.clearance(places[k]), f64::min)
        };
        for k in 1..places.len() {
            assert!(room(k) <= room(k - 1) && room(k) > LEAST_ROOM * ghost, "{} of {}", room(k), room(k - 1));
        }
    }

    /// Points that are there already have taken their room.
    #[test]
    fn room_is_what_other_points_leave() {
        let others: Vec<Point> =
            (0..8).map(|k| point([k & 1, k >> 1 & 1, k >> 2].map(|x| 0.08 * f64::from(x) - 0.04), [0.0; 3])).collect();
        let far = point([0.5, 0.5, 0.5], [0.0; 3]);
        let taken = 8.0 * others[0].volume;
        let all: Vec<Point> = others.into_iter().chain([far]).collect();
        near(volume_of_points(&continuum(&all), [0.0; 3], 0.2), taken);
        let event = Breakage::lost([0.0; 3], 0.4, 8.0, [0.0; 3]);
        let (fines, _, _) = made(rule(5e-4), event, Grains::default(), Vec::new(), continuum(&all));
        let room = 0.6 * (8.0 / DENSITY - taken);
        // as many as 8 room/solid, at most 32
        let number = (8.0 * room / 5e-4).floor().min(32.0);
        near(fines.entered.mass, DENSITY * room * fines.points as f64 / number);
    }

    /// A point alone in its cell would move with a node of hardly any mass: there are at least two in every cell.
    #[test]
    fn no_point_is_alone_in_its_cell() {
        let event = Breakage::lost([0.02, 0.01, -0.03], 0.4, 8.0, [0.0; 3]);
        // twelve points, in a sphere of 34 cells
        let (fines, continuum, _) = made(rule(0.6 * 8.0 / DENSITY / 1.5), event, Grains::default(), Vec::new(), continuum(&[]));
        let cell = |i: usize| place(&continuum, i).map(|x| ((x + 1.0) / 0.125).floor() as i32);
        let cells: Vec<[i32; 3]> = (0..continuum.points().len()).map(cell).collect();
        assert!(fines.points < 12, "some would be alone");
        assert!(cells.iter().all(|c| cells.iter().filter(|d| c == *d).count() > 1), "{cells:?}");
        near(fines.entered.mass + fines.reserve.mass, 8.0);
    }

    /// In gravity points may not be lifted by more energy than the breakage has set free: the highest ones are left out.
    #[test]
    fn points_are_not_lifted_for_nothing() {
        let settings = Settings { gravity: [0.0, 0.0, -10.0], ..settings() };
        let open = || {
            let mut c = Continuum::new(settings.clone(), vec![Law::Elastic(Elastic::of_young(1e6, 0.3))], Points::default())
                .expect("allowed");
            c.keep_transport_velocity();
            c
        };
        let event = Breakage::lost([0.0; 3], 0.4, 8.0, [0.0; 3]);
        let lift = |c: &Continuum| (0..c.points().len()).map(|i| 10.0 * c.points().velocity[i][3] * place(c, i)[2]).sum::<f64>();
        let (all, rich, _) =
            made(rule(2e-4), Breakage { stored_before: 100.0, ..event.clone() }, Grains::default(), Vec::new(), open());
        let (few, poor, _) = made(rule(2e-4), event.clone(), Grains::default(), Vec::new(), open());
        assert!(lift(&poor) <= 0.0 && few.points <= all.points, "{} {}", lift(&poor), lift(&rich));
        // energy that the contacts keep is not free
        let held = Breakage { stored_before: 100.0, stored_after: 100.0, ..event };
        let (same, _, _) = made(rule(2e-4), held, Grains::default(), Vec::new(), open());
        assert_eq!(same.points, few.points);
    }

    /// A point that has been pushed through a wall returns to the reserve with its mass and momentum; points of the scene stay.
    #[test]
    fn points_behind_a_wall_return_to_the_reserve() {
        let event = Breakage::lost([0.0; 3], 0.4, 8.0, [0.3, -0.2, 0.1]);
        let scene = point([0.7, 0.7, 0.7], [0.0; 3]);
        let (mut fines, mut continuum, mut contacts) = made(rule(5e-4), event, Grains::default(), Vec::new(), continuum(&[scene]));
        let (points, entered) = (fines.points, fines.entered);
        let mass = continuum.points().velocity[1][3];
        let behind = |p: [f64; 4]| p[0] > 0.05;
        let gone = (1..continuum.points().len()).filter(|&i| behind(continuum.points().position[i])).count();
        assert!(gone > 1);
        fines.remove_points(behind, &mut continuum, &mut contacts);
        assert_eq!((fines.points, continuum.points().len() as u64), (points - gone as u64, points + 1 - gone as u64));
        near(fines.entered.mass, entered.mass - gone as f64 * mass);
        near(fines.entered.mass + fines.reserve.mass, 8.0);
        near(fines.reserve.momentum[0], 0.3 * fines.reserve.mass);
        near(fines.reserve.kinetic, 0.5 * fines.reserve.mass * 0.14);
        let left = continuum.points().len();
        fines.remove_points(|_| false, &mut continuum, &mut contacts);
        assert_eq!(continuum.points().len(), left);
        // with inertia scaling the real mass counts, not the inertial one
        let event = Breakage::lost([0.0; 3], 0.4, 8.0, [0.0; 3]);
        let (mut fines, mut continuum, mut contacts) =
            made(Rule { at_rest: true, ..rule(5e-4) }, event, Grains::default(), Vec::new(), continuum_without_points());
        let real = fines.entered.mass;
        for v in &mut continuum.points_mut().velocity {
            *v = [1.0, 2.0, 3.0, 50.0];
        }
        fines.remove_points(|_| true, &mut continuum, &mut contacts);
        near(fines.reserve.mass, 8.0);
        assert!((fines.entered.mass / real).abs() < 1e-12 && fines.points == 0);
        assert_eq!((fines.reserve.momentum, fines.reserve.kinetic), ([0.0; 3], 0.0));
    }
}
