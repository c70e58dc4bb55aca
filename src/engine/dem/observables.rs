//! Sums and measures of one instant, taken when its contact forces are known and before grains move. All sums are in the order of identities.

use crate::contact::fabric::Fabric;
use crate::contact::sweep::{difference, r_eff};
use crate::dem::physics::Physics;
use crate::dem::{State, Workspace, gather};
use crate::grains::sphere_volume;
use crate::math::vector::dot;
use std::f64::consts::PI;

/// Sums over all grains and contacts at one instant.
#[derive(Clone, Debug, Default)]
pub struct Sums {
    /// Path, slip, viscous and damping work of the present grains up to this instant, J (the order of [`crate::grains::Grains::work`]).
    pub work: [f64; 4],
    /// Elastic energy of all contacts, J.
    pub stored: f64,
    /// Kinetic energy of translation and rotation, Σ ½ m v(t − ½)·v(t + ½), with the inertial masses in use, J.
    pub kinetic: f64,
    /// Potential energy in gravity, J.
    pub potential: f64,
    /// Number of contacts between grains.
    pub contacts: usize,
    /// Number of contacts of grains with walls.
    pub wall_contacts: usize,
    /// Fabric of the contacts between grains.
    pub fabric: Fabric,
    /// Number of grains without a contact.
    pub without: usize,
    /// Number of grains with one contact.
    pub with_one: usize,
    /// Sum of the magnitudes of the resultant forces on grains, N.
    pub net_force: f64,
    /// Sum of the normal forces of all contacts, N.
    pub contact_force: f64,
    /// Work of the softening contacts of broken grains over the half step up to this instant, J ([`crate::dem::birth`]).
    pub release: f64,
    /// Volume in which spheres overlap each other or walls, m³.
    pub overlap_volume: f64,
    /// Real mass of all grains, kg.
    pub mass: f64,
    /// Volume of all grains, m³; a growing grain counts with its final size.
    pub volume: f64,
    /// Inertial mass of all grains, kg.
    pub inertia: f64,
    /// Largest overlap of a contact over the smaller radius of its grains.
    pub worst_overlap: f64,
}

impl Sums {
    /// Mean coordination number: mean number of contacts of a grain, those with walls included.
    pub fn coordination(&self, grains: usize) -> f64 {
        (2 * self.contacts + self.wall_contacts) as f64 / grains.max(1) as f64
    }

    /// Mechanical coordination number (Thornton 2000): mean number of contacts of the grains that have two or more.
    pub fn mechanical_coordination(&self, grains: usize) -> f64 {
        let bearing = grains - self.without - self.with_one;
        (2 * self.contacts + self.wall_contacts - self.with_one) as f64 / bearing.max(1) as f64
    }

    /// Unbalanced ratio: mean resultant force of a grain over the mean normal contact force; 0 without contacts.
    pub fn unbalanced_ratio(&self, grains: usize) -> f64 {
        let mean_contact = self.contact_force / (self.contacts + self.wall_contacts).max(1) as f64;
        if mean_contact > 0.0 { self.net_force / grains.max(1) as f64 / mean_contact } else { 0.0 }
    }
}

/// Computes all sums of the present instant.
pub fn sums(physics: &Physics, state: &State, work: &Workspace) -> Sums {
    let g = &state.grains;
    let mut s = Sums { release: 0.5 * state.dt * state.aftermath.power(g), ..Sums::default() };
    let radii = state.aftermath.radii(g);
    // velocities half a step before and after this instant
    let (back, kick) = if state.fresh { (0.5 * state.dt, 0.5 * state.dt) } else { (0.0, state.dt) };
    for &i in &g.by_id() {
        let i = i as usize;
        let (p, v, w) = (g.pos[i], g.vel[i], g.spin[i]);
        let (f, t) = force_and_torque(i, physics, state, work);
        let m = g.inertia(i);
        let rotational = 0.4 * m * p[3] * p[3];
        s.inertia += m;
        s.mass += g.mass[i];
        s.volume += sphere_volume(radii[i]);
        for k in 0..4 {
            s.work[k] += g.work[i][k];
        }
        for a in 0..3 {
            // v(t−½)·v(t+½) is v(t)² but for a term of second order in dt
            let (before, after) = (v[a] - back * f[a] / m, v[a] + kick * f[a] / m);
            let (spin_before, spin_after) = (w[a] - back * t[a] / rotational, w[a] + kick * t[a] / rotational);
            s.kinetic += 0.5 * m * before * after + 0.5 * rotational * spin_before * spin_after;
            s.potential -= g.mass[i] * physics.gravity[a] * p[a];
            s.work[3] += 0.5 * state.damping * state.dt * (f[a].abs() * v[a].abs() + t[a].abs() * w[a].abs());
        }
        s.net_force += dot(f, f).sqrt();
        let mut touching = 0;
        for e in work.neighbours.contacts.of(i) {
            let slot = e.slot();
            let pool = if e.is_wall() { &state.wall_pairs } else { &state.pairs };
            if !e.second_end() && !pool.work.is_empty() {
                for k in 0..3 {
                    s.work[k] += pool.work[slot][k];
                }
            }
            let touch = &pool.touch[slot];
            if touch.overlap <= 0.0 {
                continue;
            }
            touching += 1;
            if e.second_end() {
                continue;
            }
            s.worst_overlap = s.worst_overlap.max(touch.overlap / smaller_radius(state, slot, e.is_wall()));
            s.stored += stored(physics, state, work, slot, e.is_wall());
            let normal = normal_force(state, slot, e.is_wall());
            s.contact_force += normal;
            if e.is_wall() {
                s.wall_contacts += 1;
                s.overlap_volume += PI * touch.overlap * touch.overlap * (p[3] - touch.overlap / 3.0);
            } else {
                s.contacts += 1;
                s.fabric.add(touch.normal);
                s.overlap_volume += lens(p[3], g.radius(state.pairs.ends[slot][1] as usize), touch.overlap);
            }
        }
        s.without += usize::from(touching == 0);
        s.with_one += usize::from(touching == 1);
    }
    s
}

/// Force, N, and torque, N m, on grain `i` before damping: those of [`gather::force_and_torque`], and those of material points, which act in the coming step.
pub fn force_and_torque(i: usize, physics: &Physics, state: &State, work: &Workspace) -> ([f64; 3], [f64; 3]) {
    let (mut f, mut t) = gather::force_and_torque(i, physics, state, &work.neighbours);
    if let Some([force, torque]) = work.external_forces.get(i) {
        f.iter_mut().zip(force).for_each(|(sum, f)| *sum += f);
        if physics.contact.turning {
            t.iter_mut().zip(torque).for_each(|(sum, t)| *sum += t);
        }
    }
    (f, t)
}

/// The smaller radius of the two grains of a contact, m; on a wall that of the grain.
fn smaller_radius(state: &State, slot: usize, wall: bool) -> f64 {
    let g = &state.grains;
    if wall {
        g.radius(state.wall_pairs.ends[slot][0] as usize)
    } else {
        let [a, b] = state.pairs.ends[slot];
        g.radius(a as usize).min(g.radius(b as usize))
    }
}

/// Volume common to two spheres of radii `r1`, `r2`, m, that overlap by `overlap`, m.
fn lens(r1: f64, r2: f64, overlap: f64) -> f64 {
    let d = r1 + r2 - overlap;
    if d <= (r1 - r2).abs() {
        return sphere_volume(r1.min(r2));
    }
    PI * overlap * overlap * (d * d + 2.0 * d * (r1 + r2) - 3.0 * (r1 - r2) * (r1 - r2)) / (12.0 * d)
}

/// Unit normal of the contact in a slot at the present positions, from its first end to the other grain or the wall. `wall`: whether `slot` is one of the
/// contacts with walls.
pub fn normal(state: &State, slot: usize, wall: bool) -> [f64; 3] {
    let g = &state.grains;
    if wall {
        let [i, k] = state.wall_pairs.ends[slot];
        state.walls[k as usize].shape.towards(g.pos[i as usize]).0
    } else {
        let [i, j] = state.pairs.ends[slot];
        let d = difference(g.pos[i as usize], g.pos[j as usize]);
        let l = dot(d, d).sqrt();
        [d[0] / l, d[1] / l, d[2] / l]
    }
}

/// Normal force of the contact in a slot, N, compression positive; arguments as of [`normal`].
pub fn normal_force(state: &State, slot: usize, wall: bool) -> f64 {
    let pool = if wall { &state.wall_pairs } else { &state.pairs };
    -dot(pool.touch[slot].force(), normal(state, slot, wall))
}

/// Reduced radius R*, m, and parameters of the contact in a slot; arguments as of [`normal`].
pub fn pair_of<'a>(state: &State, work: &'a Workspace, slot: usize, wall: bool) -> (f64, &'a crate::contact::pair::Pair) {
    pair_from(state, &work.table, slot, wall)
}

/// As [`pair_of`], with the table of parameters given.
pub fn pair_from<'a>(
    state: &State,
    table: &'a crate::contact::pair::PairTable,
    slot: usize,
    wall: bool,
) -> (f64, &'a crate::contact::pair::Pair) {
    let g = &state.grains;
    if wall {
        let [i, k] = state.wall_pairs.ends[slot];
        (g.stiffness_radius(i as usize), table.wall(k as usize, g.material[i as usize]))
    } else {
        let [i, j] = state.pairs.ends[slot];
        let (i, j) = (i as usize, j as usize);
        (r_eff(g.stiffness_radius(i), g.stiffness_radius(j)), table.grains(g.material[i], g.material[j]))
    }
}

/// Elastic energy of the contact in a slot when forces were last computed, J: that of the normal law and F_t²/(2 k_t) of the tangential spring.
pub fn stored(physics: &Physics, state: &State, work: &Workspace, slot: usize, wall: bool) -> f64 {
    let pool = if wall { &state.wall_pairs } else { &state.pairs };
    let (r_eff, pair) = pair_of(state, work, slot, wall);
    let e = physics.contact.law.elastic(pool.touch[slot].overlap, pool.largest(slot, pool.touch[slot].overlap), r_eff, pair);
    e.energy + tangential_energy(pool.spring(slot), e.k_t)
}

/// Energy of a tangential spring with force F_t, N, and stiffness k_t, N/m: F_t²/(2 k_t), J; 0 without a force.
pub fn tangential_energy(spring: [f64; 3], k_t: f64) -> f64 {
    let t2 = dot(spring, spring);
    if t2 > 0.0 { 0.5 * t2 / k_t } else { 0.0 }
}

/// Love–Weber stress, Pa, compression positive: (vertical, mean of x and y), from the contacts between grains whose contact point lies in a cylinder about
/// the z axis with radius `radius` between the heights `low` and `high`, m.
pub fn love_weber(state: &State, work: &Workspace, radius: f64, low: f64, high: f64) -> (f64, f64) {
    let g = &state.grains;
    let (mut zz, mut xx, mut yy) = (0.0, 0.0, 0.0);
    for &i in &g.by_id() {
        let i = i as usize;
        for e in work.neighbours.contacts.of(i) {
            if e.is_wall() || e.second_end() {
                continue;
            }
            let slot = e.slot();
            let touch = &state.pairs.touch[slot];
            if touch.overlap <= 0.0 {
                continue;
            }
            let j = state.pairs.ends[slot][1] as usize;
            let d = difference(g.pos[i], g.pos[j]);
            let p = g.pos[i];
            let at = p[3] / (p[3] + g.radius(j));
            let c = [p[0] + at * d[0], p[1] + at * d[1], p[2] + at * d[2]];
            if c[0] * c[0] + c[1] * c[1] < radius * radius && c[2] > low && c[2] < high {
                let force = touch.force();
                xx -= force[0] * d[0];
                yy -= force[1] * d[1];
                zz -= force[2] * d[2];
            }
        }
    }
    let volume = PI * radius * radius * (high - low);
    (zz / volume, 0.5 * (xx + yy) / volume)
}

/// Largest normal force of a contact of each grain, N, by index of the grain.
pub fn largest_forces(state: &State, work: &Workspace) -> Vec<f64> {
    (0..state.grains.len())
        .map(|i| {
            work.neighbours.contacts.of(i).fold(0.0f64, |largest, e| {
                let pool = if e.is_wall() { &state.wall_pairs } else { &state.pairs };
                if pool.touch[e.slot()].overlap > 0.0 { largest.max(normal_force(state, e.slot(), e.is_wall())) } else { largest }
            })
        })
        .collect()
}
