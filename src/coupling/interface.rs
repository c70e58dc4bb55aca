//! Points in contact and their nodes, which follow the contacts through the steps that grains make in one of the continuum.
//!
//! This is impulse multiple time-stepping: the continuum's own forces change the nodes' velocities once, at the start of its step; contact forces change
//! them in every step of the grains, and the points are carried along. What the nodes have been given in the end is what the continuum gets as the
//! mean force on each point, and the way that its points have gone is made up for by [`Continuum::set_shift`].

use super::Ghosts;
use crate::mpm::Continuum;
use rayon::prelude::*;

/// No place.
pub const NONE: u32 = u32::MAX;
/// Points of one task.
const TASK: usize = 512;

/// Scratch of one cycle.
#[derive(Clone, Debug, Default)]
pub struct Interface {
    seats: Vec<Seat>,
    /// Seat of each point, by index.
    seat_of: Vec<u32>,
    /// Numbers of the nodes in the grid, and place of each of the grid's nodes here.
    nodes: Vec<u32>,
    place: Vec<u32>,
    velocity: Vec<[f64; 3]>,
    inverse_mass: Vec<f64>,
    /// Σ v dt, m.
    way: Vec<[f64; 3]>,
    stiffness: Vec<f64>,
    /// Since the cycle began, s; `None` before it does.
    elapsed: Option<f64>,
}

/// A point.
#[derive(Clone, Copy, Debug)]
struct Seat {
    /// Its index.
    point: u32,
    nodes: [u32; 27],
    weights: [f64; 27],
    at: [f64; 3],
    /// What carried it in the last step, m/s.
    carried: [f64; 3],
    /// Force of this instant, N, and impulse since the start of the cycle, N s.
    force: [f64; 3],
    impulse: [f64; 3],
}

impl Interface {
    /// Nobody.
    pub fn clear(&mut self) {
        for seat in self.seats.drain(..) {
            self.seat_of[seat.point as usize] = NONE;
        }
        for node in self.nodes.drain(..) {
            self.place[node as usize] = NONE;
        }
        self.velocity.clear();
        self.inverse_mass.clear();
        self.way.clear();
        self.elapsed = None;
    }

    /// The seat of a point, given to it if it has none; where it is then, m, and what carries it.
    pub fn seat(&mut self, continuum: &Continuum, point: u32) -> u32 {
        self.seat_of.resize(continuum.points().len(), NONE);
        let known = self.seat_of[point as usize];
        if known != NONE {
            return known;
        }
        let (grid_nodes, weights) = continuum.stencil(point as usize);
        let nodes = grid_nodes.map(|node| {
            if node as usize >= self.place.len() {
                self.place.resize(node as usize + 1, NONE);
            }
            let place = &mut self.place[node as usize];
            if *place == NONE {
                *place = self.nodes.len() as u32;
                self.nodes.push(node);
                let mass = continuum.mass_of_node(node);
                self.inverse_mass.push(if mass > 0.0 { 1.0 / mass } else { 0.0 });
                // without contacts so far
                let v = if self.elapsed.is_some() { continuum.foreseen(node).0 } else { [0.0; 3] };
                self.velocity.push(v);
                self.way.push(v.map(|v| v * self.elapsed.unwrap_or(0.0)));
            }
            *place
        });
        let points = continuum.points();
        let mut at = std::array::from_fn(|a| points.position[point as usize][a]);
        for (&node, w) in nodes.iter().zip(weights) {
            for (at, way) in at.iter_mut().zip(self.way[node as usize]) {
                *at += w * way;
            }
        }
        let seat = self.seats.len() as u32;
        self.seat_of[point as usize] = seat;
        let carried = points.carried[point as usize];
        let none = [0.0; 3];
        self.seats.push(Seat { point, nodes, weights, at, carried, force: none, impulse: none });
        seat
    }

    /// Place, m, and velocity, m/s, of the point in a seat.
    pub fn of(&self, seat: u32) -> ([f64; 3], [f64; 3]) {
        let seat = &self.seats[seat as usize];
        (seat.at, seat.carried)
    }

    /// The largest Σ k N/m over the nodes, 1/s²: no motion of the nodes against the contacts is faster than its root (Gershgorin).
    pub fn rate(&mut self, ghosts: &Ghosts) -> f64 {
        self.stiffness.clear();
        self.stiffness.resize(self.nodes.len(), 0.0);
        for ghost in ghosts.touching() {
            let Some(seat) = self.seats.get(ghost.seat as usize) else { continue };
            let k = ghost.stiffness[0].max(ghost.stiffness[1]);
            for (&node, w) in seat.nodes.iter().zip(seat.weights) {
                self.stiffness[node as usize] += k * w;
            }
        }
        self.stiffness.iter().zip(&self.inverse_mass).map(|(k, m)| k * m).fold(0.0, f64::max)
    }

    /// The nodes as the continuum's own forces leave them.
    pub fn begin(&mut self, continuum: &Continuum) {
        for (v, &node) in self.velocity.iter_mut().zip(&self.nodes) {
            *v = continuum.foreseen(node).0;
        }
        self.elapsed = Some(0.0);
    }

    /// A step of `dt` seconds: the contacts' forces change the nodes, the nodes carry the points.
    pub fn step(&mut self, ghosts: &Ghosts, dt: f64) {
        self.seats.iter_mut().for_each(|s| s.force = [0.0; 3]);
        for ghost in ghosts.touching().filter(|g| g.seat != NONE) {
            let force = ghost.force();
            let seat = &mut self.seats[ghost.seat as usize];
            seat.force.iter_mut().zip(force).for_each(|(sum, f)| *sum -= f);
        }
        for seat in self.seats.iter_mut().filter(|s| s.force != [0.0; 3]) {
            for a in 0..3 {
                seat.impulse[a] += seat.force[a] * dt;
            }
            for (&node, w) in seat.nodes.iter().zip(seat.weights) {
                let share = dt * w * self.inverse_mass[node as usize];
                let v = &mut self.velocity[node as usize];
                for a in 0..3 {
                    v[a] += share * seat.force[a];
                }
            }
        }
        for (way, v) in self.way.iter_mut().zip(&self.velocity) {
            for a in 0..3 {
                way[a] += v[a] * dt;
            }
        }
        self.elapsed = self.elapsed.map(|t| t + dt);
        let velocity = &self.velocity;
        self.seats.par_iter_mut().with_min_len(TASK).for_each(|seat| {
            let mut v = [0.0; 3];
            for (&node, w) in seat.nodes.iter().zip(seat.weights) {
                for a in 0..3 {
                    v[a] += w * velocity[node as usize][a];
                }
            }
            seat.carried = v;
            for a in 0..3 {
                seat.at[a] += dt * v[a];
            }
        });
    }

    /// Gives the continuum what the contacts gave its nodes in `time` seconds.
    pub fn end(&mut self, continuum: &mut Continuum, time: f64) {
        for seat in self.seats.iter().filter(|s| s.impulse != [0.0; 3]) {
            continuum.push(seat.point as usize, seat.impulse.map(|i| i / time));
        }
        let Interface { nodes, way, velocity, .. } = self;
        continuum.set_shift(nodes, |k| std::array::from_fn(|a| way[k][a] / time - velocity[k][a]));
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.seats.capacity() * size_of::<Seat>()
            + 4 * (self.seat_of.capacity() + self.nodes.capacity() + self.place.capacity())
            + 24 * (self.velocity.capacity() + self.way.capacity())
            + 8 * (self.inverse_mass.capacity() + self.stiffness.capacity())
    }
}
