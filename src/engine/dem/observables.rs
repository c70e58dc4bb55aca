//! Measures of one instant, all summed in the order of ids. Called when the forces of the instant are known (the control stage).

use crate::contact::fabric::Fabric;
use crate::contact::sweep::{difference, r_eff};
use crate::dem::physics::Physics;
use crate::dem::{State, Workspace, gather};
use crate::grains::sphere_volume;
use crate::math::vector::dot;
use std::f64::consts::PI;

/// Sums over grains and contacts.
#[derive(Clone, Debug, Default)]
pub struct Sums {
    /// Path, slip, viscous, damping work of living grains, J.
    pub work: [f64; 4],
    /// Elastic energy of all contacts, J.
    pub stored: f64,
    /// Leapfrog kinetic energy, translation and rotation, with the inertia actually used, J.
    pub kinetic: f64,
    /// Potential energy in gravity, J.
    pub potential: f64,
    /// Touching contacts between grains, and with walls.
    pub contacts: usize,
    pub wall_contacts: usize,
    /// Of the contacts between grains.
    pub fabric: Fabric,
    /// Grains with no contact, and with one.
    pub without: usize,
    pub with_one: usize,
    /// Sums of the magnitudes of grains' net forces and of normal contact forces, N.
    pub net_force: f64,
    pub contact_force: f64,
    /// Work of this instant's fading forces over the last half step, J ([`crate::dem::birth`]).
    pub release: f64,
    /// Volume that contacts overlap, m^3.
    pub overlap_volume: f64,
    pub mass: f64,
    /// Of the grains, of those that grow what they will have, m^3.
    pub volume: f64,
    /// Inertial mass, kg.
    pub inertia: f64,
    /// Largest overlap over the smaller radius.
    pub worst_overlap: f64,
}

impl Sums {
    /// Mean coordination number Z = contacts per grain, walls included.
    pub fn coordination(&self, grains: usize) -> f64 {
        (2 * self.contacts + self.wall_contacts) as f64 / grains.max(1) as f64
    }

    /// Mechanical coordination number (Thornton 2000): without grains that have no contact or one.
    pub fn mechanical_coordination(&self, grains: usize) -> f64 {
        let bearing = grains - self.without - self.with_one;
        (2 * self.contacts + self.wall_contacts - self.with_one) as f64 / bearing.max(1) as f64
    }

    /// Mean net force of a grain over mean contact force.
    pub fn unbalanced_ratio(&self, grains: usize) -> f64 {
        let mean_contact = self.contact_force / (self.contacts + self.wall_contacts).max(1) as f64;
        if mean_contact > 0.0 { self.net_force / grains.max(1) as f64 / mean_contact } else { 0.0 }
    }
}

/// All sums of this instant.
pub fn sums(physics: &Physics, state: &State, work: &Workspace) -> Sums {
    let g = &state.grains;
    let mut s = Sums { release: 0.5 * state.dt * state.aftermath.power(g), ..Sums::default() };
    let radii = state.aftermath.radii(g);
    // velocities half a step before and after this instant
    let (back, kick) = if state.fresh { (0.5 * state.dt, 0.5 * state.dt) } else { (0.0, state.dt) };
    for &i in &g.by_id() {
        let i = i as usize;
        let (p, v, w) = (g.pos[i], g.vel[i], g.spin[i]);
        let (mut f, mut t) = gather::force_and_torque(i, physics, state, &work.neighbours);
        // forces of material points, which the coming step will take
        if let Some([force, torque]) = work.external_forces.get(i) {
            f.iter_mut().zip(force).for_each(|(sum, f)| *sum += f);
            if physics.contact.turning {
                t.iter_mut().zip(torque).for_each(|(sum, t)| *sum += t);
            }
        }
        let m = g.inertia(i);
        let rotational = 0.4 * m * p[3] * p[3];
        s.inertia += m;
        s.mass += g.mass[i];
        s.volume += sphere_volume(radii[i]);
        for k in 0..4 {
            s.work[k] += g.work[i][k];
        }
        for a in 0..3 {
            // v(t−½)·v(t+½), which is v(t)² less a term of second order in dt
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
                s.overlap_volume += lens(p[3], g.pos[state.pairs.ends[slot][1] as usize][3], touch.overlap);
            }
        }
        s.without += usize::from(touching == 0);
        s.with_one += usize::from(touching == 1);
    }
    s
}

fn smaller_radius(state: &State, slot: usize, wall: bool) -> f64 {
    let g = &state.grains;
    if wall {
        g.pos[state.wall_pairs.ends[slot][0] as usize][3]
    } else {
        let [a, b] = state.pairs.ends[slot];
        g.pos[a as usize][3].min(g.pos[b as usize][3])
    }
}

/// Volume common to two spheres.
fn lens(r1: f64, r2: f64, overlap: f64) -> f64 {
    let d = r1 + r2 - overlap;
    if d <= (r1 - r2).abs() {
        return sphere_volume(r1.min(r2));
    }
    PI * overlap * overlap * (d * d + 2.0 * d * (r1 + r2) - 3.0 * (r1 - r2) * (r1 - r2)) / (12.0 * d)
}

/// Unit normal of a slot, from its first end.
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

/// Normal force of a touching slot, N.
pub fn normal_force(state: &State, slot: usize, wall: bool) -> f64 {
    let pool = if wall { &state.wall_pairs } else { &state.pairs };
    -dot(pool.touch[slot].force(), normal(state, slot, wall))
}

/// R* of a slot and its pair law.
pub fn pair_of<'a>(state: &State, work: &'a Workspace, slot: usize, wall: bool) -> (f64, &'a crate::contact::pair::Pair) {
    pair_from(state, &work.table, slot, wall)
}

/// As [`pair_of`], from the table.
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

/// Elastic energy of a touching slot as the last sweep left it, J: normal, and F_t² / (2 k_t).
pub fn stored(physics: &Physics, state: &State, work: &Workspace, slot: usize, wall: bool) -> f64 {
    let pool = if wall { &state.wall_pairs } else { &state.pairs };
    let (r_eff, pair) = pair_of(state, work, slot, wall);
    let e = physics.contact.law.elastic(pool.touch[slot].overlap, pool.largest(slot, pool.touch[slot].overlap), r_eff, pair);
    e.energy + tangential_energy(pool.spring(slot), e.k_t)
}

/// F_t² / (2 k_t), J.
pub fn tangential_energy(spring: [f64; 3], k_t: f64) -> f64 {
    let t2 = dot(spring, spring);
    if t2 > 0.0 { 0.5 * t2 / k_t } else { 0.0 }
}

/// Love–Weber stress of the contacts whose point lies in a cylinder about the z axis, Pa, compression positive: (vertical, radial mean).
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
            let at = p[3] / (p[3] + g.pos[j][3]);
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

/// Largest normal force on each grain, N, by index.
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
