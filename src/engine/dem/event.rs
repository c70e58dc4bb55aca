//! Breakage: a grain whose load exceeds its limit is replaced by its daughters.
//!
//! All grains that exceed in a step are judged on that step's forces, then broken in the order of ids (NOTES.md). Daughters inherit the
//! mother's rigid-body motion and material, draw fresh strengths keyed by lineage, and start without history.

use super::birth::Obstacles;
use crate::breakage::criterion::Judges;
use crate::breakage::{Birth, CrushModel};
use crate::contact::pair::PairTable;
use crate::contact::{sweep, wall_sweep};
use crate::dem::observables;
use crate::dem::physics::Physics;
use crate::dem::{State, gather, mean_stress, stability};
use crate::grains::{sphere_volume, stiffness_radius};
use crate::math::portable;
use crate::math::random::{lineage_child, random_perpendicular};
use crate::math::vector::{cross, dot, less};
use crate::neighbours::{Neighbours, Pools};
use serde::{Deserialize, Serialize};

/// One breakage, as recorded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Breakage {
    /// Number of the event, from 1.
    pub event: u64,
    pub step: u64,
    /// Persistent id, generation and lineage key of the mother.
    pub mother: u32,
    pub generation: u8,
    pub lineage: u64,
    /// Steps since the mother's own birth; of initial grains all steps so far.
    pub age: u64,
    /// Diameter, m.
    pub diameter: f64,
    /// Decisive normal force and its limit, N, and the area, m^2, over which the force is the stress that is compared with the strength.
    pub force: f64,
    pub limit_force: f64,
    pub area: f64,
    /// Force over limit a step before, by the way that the two bodies have moved against each other since.
    pub before: f64,
    /// Limit strength, Pa.
    pub strength: f64,
    /// Direction of the decisive force.
    pub axis: [f64; 3],
    pub position: [f64; 3],
    /// Mass lost, kg, and diameter of the smallest daughter, m.
    pub lost_mass: f64,
    pub smallest: f64,
    /// Momentum, kg m/s, and kinetic energy, J, of the mass lost: the mother's less her daughters'.
    pub lost_momentum: [f64; 3],
    pub lost_kinetic: f64,
    /// Elastic energy of the contacts around the event, J.
    pub stored_before: f64,
    pub stored_after: f64,
}

impl Breakage {
    /// Load over limit: how far above its limit the grain was when it was judged.
    pub fn utilisation(&self) -> f64 {
        self.force / self.limit_force
    }

    /// Whether two bodies have collided ([`collided`]).
    pub fn is_collision(&self) -> bool {
        collided(self.utilisation(), self.before)
    }
}

/// Whether a load over its limit, `now` and a step `before` by the way that the two bodies have come since, is above 1 by that way alone: but for a twentieth of the excess, as the way is not known
/// better, and a grain that is judged at every step was within its limit a step before.
pub fn collided(now: f64, before: f64) -> bool {
    before - 1.0 <= 0.05 * (now - 1.0)
}

/// Siblings touch to rounding; a rise of stored energy below this share of force times radius is none.
const ROUNDING: f64 = 1e-12;

/// The decisive contact of a failing grain.
struct Verdict {
    grain: usize,
    axis: [f64; 3],
    force: f64,
    limit_force: f64,
    area: f64,
    /// As [`Breakage::before`].
    before: f64,
}

/// Breaks the grains listed (indices in the order of ids); `external_forces` are the forces that grains took from elsewhere in this step, [`crate::dem::Workspace::external_forces`].
pub fn break_grains(
    physics: &Physics,
    state: &mut State,
    neighbours: &mut Neighbours,
    table: &PairTable,
    external_forces: &[[[f64; 4]; 2]],
    failing: &[u32],
    out: &mut Vec<Breakage>,
) {
    let crush = physics.crush.as_ref().expect("only judged grains fail");
    // all verdicts before any change
    let verdicts: Vec<Verdict> =
        failing.iter().map(|&i| judge(physics, crush, state, neighbours, table, external_forces, i as usize)).collect();
    for verdict in verdicts {
        out.push(break_one(physics, crush, state, neighbours, table, &verdict));
    }
}

/// The contact with the largest load decides, or, where the grain's mean stress is judged, the one with the largest normal force; among equals the first in the order of ids.
fn judge(
    physics: &Physics,
    crush: &CrushModel,
    state: &State,
    neighbours: &Neighbours,
    table: &PairTable,
    external_forces: &[[[f64; 4]; 2]],
    i: usize,
) -> Verdict {
    let (mut best, mut load) = (None, f64::NEG_INFINITY);
    for e in neighbours.contacts.of(i) {
        let pool = if e.is_wall() { &state.wall_pairs } else { &state.pairs };
        let l = pool.load(e.slot());
        if l > load {
            (best, load) = (Some(e), l);
        }
    }
    let e = best.expect("a failing grain has a contact");
    let slot = e.slot();
    let (r_eff, pair) = observables::pair_from(state, table, slot, e.is_wall());
    let g = &state.grains;
    // of the size that it was judged by, which it may still be growing to
    let d = 2.0 * state.aftermath.radius(i, g);
    let (force, limit_force, area) = match crush.criterion.judges() {
        Judges::Contacts => {
            let force = load / crush.criterion.load_weight(r_eff, pair.e_eff);
            let limit = crush.criterion.limit_force(g.strength[i], d, r_eff, pair.e_eff);
            (force, limit, crush.criterion.area(force, d, r_eff, pair.e_eff))
        }
        Judges::MeanStress => {
            // the force at which the grain would fail if all of its forces grew alike
            let stress = mean_stress::load(&crush.criterion, i, g.pos[i][3], neighbours, &state.pairs, &state.wall_pairs);
            (load, load * crush.criterion.threshold(g.strength[i], d) / stress, load / stress)
        }
    };
    let arriving = |i: usize| arriving(physics, state, neighbours, external_forces, i);
    let (touch, approach) = if e.is_wall() {
        let touch = &state.wall_pairs.touch[slot];
        (touch, dot(arriving(i), touch.normal) + state.walls[e.wall_index()].speed)
    } else {
        let [a, b] = state.pairs.ends[slot];
        let touch = &state.pairs.touch[slot];
        (touch, dot(less(arriving(a as usize), arriving(b as usize)), touch.normal))
    };
    let overlap = (touch.overlap - approach * state.dt).max(0.0);
    let pool = if e.is_wall() { &state.wall_pairs } else { &state.pairs };
    let law = physics.contact.law;
    let elastic =
        |overlap: f64| if overlap > 0.0 { law.elastic(overlap, pool.largest(slot, overlap), r_eff, pair).force } else { 0.0 };
    Verdict {
        grain: i,
        axis: observables::normal(state, slot, e.is_wall()),
        force,
        limit_force,
        area,
        before: (force - elastic(touch.overlap) + elastic(overlap)) / limit_force,
    }
}

/// Velocity, m/s, with which grain `i` has come to the place where it was judged: what the kick of this step has given it since is taken back.
fn arriving(physics: &Physics, state: &State, neighbours: &Neighbours, external_forces: &[[[f64; 4]; 2]], i: usize) -> [f64; 3] {
    let (mut f, _) = gather::force_and_torque(i, physics, state, neighbours);
    if let Some([force, _]) = external_forces.get(i) {
        f.iter_mut().zip(force).for_each(|(sum, f)| *sum += f);
    }
    let [u, v, w, inverse_inertia] = state.grains.vel[i];
    less([u, v, w], f.map(|f| f * inverse_inertia * state.dt))
}

fn break_one(
    physics: &Physics,
    crush: &CrushModel,
    state: &mut State,
    neighbours: &mut Neighbours,
    table: &PairTable,
    verdict: &Verdict,
) -> Breakage {
    let m = verdict.grain;
    let g = &state.grains;
    let mother = Mother {
        pos: g.pos[m],
        size: state.aftermath.radius(m, g),
        vel: g.vel[m],
        spin: g.spin[m],
        mass: g.mass[m],
        lineage: g.lineage[m],
        generation: g.generation[m],
        material: g.material[m],
    };
    let mut event = Breakage {
        event: state.crush_events + 1,
        step: state.step,
        mother: g.id[m],
        generation: mother.generation,
        lineage: mother.lineage,
        age: state.step - g.born[m],
        diameter: 2.0 * mother.size,
        force: verdict.force,
        limit_force: verdict.limit_force,
        area: verdict.area,
        before: verdict.before,
        strength: g.strength[m],
        axis: verdict.axis,
        position: [mother.pos[0], mother.pos[1], mother.pos[2]],
        lost_mass: 0.0,
        smallest: 2.0 * mother.size * crush.pattern.smallest(),
        lost_momentum: momentum(state, m),
        lost_kinetic: 0.0,
        stored_before: energy_around(physics, state, neighbours, table, m),
        stored_after: 0.0,
    };
    close_contacts(state, neighbours, m);
    state.aftermath.forget(m);
    let mut obstacles = Obstacles::default();
    if let Birth::Gradual { release, .. } = crush.birth {
        let State { aftermath, grains, pairs, .. } = state;
        obstacles = Obstacles::around(m, grains, neighbours, pairs);
        aftermath.release(m, grains, neighbours, pairs, release);
    }
    let kinetic = kinetic_energy(state, m);
    for k in 0..4 {
        state.ledger.gone[k] += state.grains.work[m][k];
    }
    let mut pools = Pools { pairs: &mut state.pairs, wall_pairs: &mut state.wall_pairs };
    neighbours.detach(m, &state.grains, &mut pools);

    let centre = event.position;
    let perpendicular = random_perpendicular(crush.seed, mother.lineage, verdict.axis);
    let mut kept = 0.0;
    let mut daughters_kinetic = 0.0;
    let mut born = Vec::with_capacity(crush.pattern.count());
    // in the sphere that she had, or in what of it is free; their own sizes are those of the sphere that she was growing to, and of all her mass if it is kept
    let in_sphere = |radius: f64| crush.pattern.daughters(centre, radius, verdict.axis, perpendicular);
    let mut sphere = mother.pos[3];
    if matches!(crush.birth, Birth::Gradual { .. })
        && in_sphere(sphere).any(|(at, radius)| obstacles.bury(at, radius, &state.walls))
    {
        sphere = obstacles.free_radius(centre, sphere, &state.walls);
    }
    let mass = if crush.keeps_mass { portable::pow(crush.pattern.volume_kept(), -1.0 / 3.0) } else { 1.0 };
    let larger = mass * mother.size / sphere;
    for (k, (position, radius)) in in_sphere(sphere).enumerate() {
        let i = if k == 0 { m } else { state.grains.len() };
        let target = larger * radius;
        place(physics, crush, state, i, &mother, k as u32, position, target);
        kept += state.grains.mass[i];
        if let Birth::Gradual { growth, .. } = crush.birth {
            let free = obstacles.free_radius(position, radius, &state.walls);
            if free < target {
                state.grains.pos[i][3] = free;
                state.aftermath.grow(i, target, (target - free) / f64::from(growth.max(1)));
            }
        }
        if k == 0 {
            neighbours.refresh(i, &state.grains, &mut state.wall_pairs);
        } else {
            neighbours.append(i, &state.grains, &mut state.wall_pairs);
        }
        born.push(i);
    }
    for &i in &born {
        stability::newborn_inertia(i, physics, state, neighbours, table);
        daughters_kinetic += kinetic_energy(state, i);
        event.lost_momentum.iter_mut().zip(momentum(state, i)).for_each(|(sum, p)| *sum -= p);
        // siblings only touch, so each new contact is counted once
        event.stored_after += energy_around(physics, state, neighbours, table, i);
    }
    event.lost_mass = mother.mass - kept;
    event.lost_kinetic = kinetic - daughters_kinetic;
    let l = &mut state.ledger;
    l.lost_kinetic += event.lost_kinetic;
    l.lost_potential -= event.lost_mass * dot(physics.gravity, centre);
    l.removed += event.stored_before;
    l.made += event.stored_after;
    let rounding = ROUNDING * verdict.force * mother.pos[3];
    l.rises += u64::from(event.stored_after > event.stored_before + rounding);
    state.crush_events += 1;
    if !crush.keeps_mass {
        state.lost.push((event.lost_mass, event.smallest));
    }
    event
}

/// What daughters inherit.
struct Mother {
    pos: [f64; 4],
    /// Radius that she had or was growing to, m.
    size: f64,
    vel: [f64; 4],
    spin: [f64; 4],
    mass: f64,
    lineage: u64,
    generation: u8,
    material: u8,
}

/// Puts daughter `k` at index `i`.
#[allow(clippy::too_many_arguments)]
fn place(
    physics: &Physics,
    crush: &CrushModel,
    state: &mut State,
    i: usize,
    mother: &Mother,
    k: u32,
    position: [f64; 3],
    radius: f64,
) {
    let g = &mut state.grains;
    if i == g.len() {
        g.add(position, radius, mother.material, &physics.materials);
    } else {
        g.pos[i] = [position[0], position[1], position[2], radius];
        g.mass[i] = physics.materials[mother.material as usize].density * sphere_volume(radius);
        g.id[i] = g.next_id;
        g.next_id += 1;
        g.work[i] = [0.0; 4];
    }
    let arm = [position[0] - mother.pos[0], position[1] - mother.pos[1], position[2] - mother.pos[2]];
    let c = cross([mother.spin[0], mother.spin[1], mother.spin[2]], arm);
    g.vel[i] = [mother.vel[0] + c[0], mother.vel[1] + c[1], mother.vel[2] + c[2], 1.0 / g.mass[i]];
    g.spin[i] = mother.spin;
    if physics.contact.law.table().inherited {
        let sized = stiffness_radius(mother.pos, mother.spin);
        g.spin[i][3] = (sized - radius) / radius;
    }
    g.lineage[i] = lineage_child(mother.lineage, k);
    g.generation[i] = mother.generation.saturating_add(1);
    g.born[i] = state.step;
    arm_grain(crush, state, i);
}

/// Draws a grain's strength and sets its limit; grains at or below the comminution limit cannot break.
pub fn arm_grain(crush: &CrushModel, state: &mut State, i: usize) {
    let g = &mut state.grains;
    let d = 2.0 * g.pos[i][3];
    g.strength[i] = crush.strength.draw(crush.seed, g.lineage[i], d);
    g.breakage_threshold[i] = if d > crush.d_limit { crush.criterion.threshold(g.strength[i], d) } else { f64::INFINITY };
}

/// Momentum with the inertia in use, kg m/s.
fn momentum(state: &State, i: usize) -> [f64; 3] {
    let [u, v, w, _] = state.grains.vel[i];
    [u, v, w].map(|v| state.grains.inertia(i) * v)
}

/// Kinetic energy with the inertia in use, J.
fn kinetic_energy(state: &State, i: usize) -> f64 {
    let g = &state.grains;
    let (v, w, r) = (g.vel[i], g.spin[i], g.pos[i][3]);
    let v2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let w2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
    0.5 * g.inertia(i) * (v2 + 0.4 * r * r * w2)
}

/// Elastic energy of a grain's contacts at the present positions, J.
fn energy_around(physics: &Physics, state: &State, neighbours: &Neighbours, table: &PairTable, i: usize) -> f64 {
    let mut sum = 0.0;
    stability::overlaps(i, state, neighbours, table, |o| {
        let elastic = o.elastic(physics.contact.law);
        sum += elastic.energy + observables::tangential_energy(o.spring, elastic.k_t);
    });
    sum
}

/// The trapezium of path work is left open by contacts that vanish after the kick: −½ F·v of the last half step is theirs.
fn close_contacts(state: &mut State, neighbours: &Neighbours, m: usize) {
    let g = &state.grains;
    let mut open = 0.0;
    for e in neighbours.contacts.of(m) {
        let slot = e.slot();
        let power = if e.is_wall() {
            let normal = observables::normal(state, slot, true);
            wall_sweep::motion_on_wall(g, m, normal, state.walls[e.wall_index()].speed).power(&state.wall_pairs.touch[slot])
        } else {
            let [a, b] = state.pairs.ends[slot];
            sweep::motion(g, a as usize, b as usize).power(&state.pairs.touch[slot])
        };
        open -= 0.5 * power * state.dt;
    }
    state.ledger.gone[0] += open;
}
