//! Breakage: a grain that is over its breakage threshold is replaced by its daughters.
//!
//! All such grains of a step are examined with the forces of that step, then broken in the order of their identities. Daughters inherit the rigid-body
//! motion and the material of the broken grain (their mother), draw new strengths keyed by lineage, and begin without contact history.

use super::birth::Obstacles;
use crate::breakage::criterion::Judges;
use crate::breakage::pattern::{Azimuth, turned_from_space};
use crate::breakage::{Birth, CrushModel};
use crate::check::{self, Checked};
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

/// One breakage, as it is recorded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Breakage {
    /// Number of the breakage, from 1.
    pub event: u64,
    /// Step in which it happened.
    pub step: u64,
    /// Identity of the broken grain.
    pub mother: u32,
    /// Generation of the broken grain ([`crate::grains::Grains::generation`]).
    pub generation: u8,
    /// Lineage of the broken grain ([`crate::grains::Grains::lineage`]).
    pub lineage: u64,
    /// Steps since the birth of the broken grain; for a grain of the start all steps so far.
    pub age: u64,
    /// Diameter of the broken grain, m.
    pub diameter: f64,
    /// Decisive normal force: that of the contact with the largest load, N.
    pub force: f64,
    /// Normal force at which the grain fails, N.
    pub limit_force: f64,
    /// Area, m², over which the decisive force makes the stress that is compared with the strength.
    pub area: f64,
    /// Force over its limit one step before, from the distance by which the two bodies have approached each other since.
    pub before: f64,
    /// Limit strength of the broken grain, Pa.
    pub strength: f64,
    /// Unit vector along the decisive normal force; its sign means nothing.
    pub axis: [f64; 3],
    /// Centre of the broken grain, m.
    pub position: [f64; 3],
    /// Mass lost: that of the broken grain minus those of its daughters, kg.
    pub lost_mass: f64,
    /// Diameter of the smallest daughter, m.
    pub smallest: f64,
    /// Momentum of the lost mass: that of the broken grain minus those of its daughters, kg m/s.
    pub lost_momentum: [f64; 3],
    /// Kinetic energy of the lost mass, as the momentum, J.
    pub lost_kinetic: f64,
    /// Elastic energy of the contacts of the broken grain, J.
    pub stored_before: f64,
    /// Elastic energy of the contacts of its daughters, J.
    pub stored_after: f64,
}

impl Breakage {
    /// A breakage at `position`, m, of a grain of this diameter, m, that has lost so much mass, kg, at this velocity, m/s: for tests.
    #[cfg(test)]
    pub fn lost(position: [f64; 3], diameter: f64, lost_mass: f64, velocity: [f64; 3]) -> Breakage {
        Breakage {
            event: 1,
            step: 1,
            mother: 0,
            generation: 0,
            lineage: 77,
            age: 1,
            diameter,
            force: 1.0,
            limit_force: 1.0,
            area: 1.0,
            before: 1.0,
            strength: 1.0,
            axis: [0.0, 0.0, 1.0],
            position,
            lost_mass,
            smallest: 0.1 * diameter,
            lost_momentum: velocity.map(|v| lost_mass * v),
            lost_kinetic: 0.5 * lost_mass * velocity.map(|v| v * v).iter().sum::<f64>(),
            stored_before: 0.0,
            stored_after: 0.0,
        }
    }

    /// Checks the numbers from which points are made ([`crate::coupling::FinesAsPoints`]).
    ///
    /// # Errors
    /// The one that is wrong.
    pub fn check(&self) -> Checked {
        check::positive("broken grains", [self.diameter, self.lost_mass])?;
        let single = [&self.lost_kinetic, &self.stored_before, &self.stored_after];
        check::numbers("breakages", self.position.iter().chain(&self.lost_momentum).chain(single))
    }

    /// Decisive force over its limit: 1 or a little more, more in a collision.
    pub fn utilisation(&self) -> f64 {
        self.force / self.limit_force
    }

    /// Whether the grain broke in a collision ([`collided`]).
    pub fn is_collision(&self) -> bool {
        collided(self.utilisation(), self.before)
    }
}

/// Whether a grain breaks by the approach of two bodies within the last step, as in a collision. `now`: force over its limit; `before`: the same one step
/// before, computed from the approach since. True if `before` was at most 1, with a tolerance of a twentieth of the present excess, as the approach is not
/// known better.
pub fn collided(now: f64, before: f64) -> bool {
    before - 1.0 <= 0.05 * (now - 1.0)
}

/// Rises of stored energy below this share of force times radius are rounding: daughters touch each other to rounding.
const ROUNDING: f64 = 1e-12;

/// The decisive contact of a grain that breaks; fields as in [`Breakage`].
struct Verdict {
    /// Index of the grain.
    grain: usize,
    axis: [f64; 3],
    force: f64,
    limit_force: f64,
    area: f64,
    before: f64,
}

/// Breaks the grains `failing` (indices in the order of identities) and adds a record of each breakage to `out`. `external_forces`: those of this step
/// ([`crate::dem::Workspace::external_forces`]).
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
    // all grains are examined before any is changed
    let verdicts: Vec<Verdict> =
        failing.iter().map(|&i| judge(physics, crush, state, neighbours, table, external_forces, i as usize)).collect();
    for verdict in verdicts {
        out.push(break_one(physics, crush, state, neighbours, table, &verdict));
    }
}

/// The decisive contact of grain `i`: the one with the largest load or, for criteria on the mean stress, the largest normal force; of equal ones the first in
/// the order of identities.
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
    // a growing grain counts with its final size
    let d = 2.0 * state.aftermath.radius(i, g);
    let (force, limit_force, area) = match crush.criterion.judges() {
        Judges::Contacts => {
            let force = load / crush.criterion.load_weight(r_eff, pair.e_eff);
            let limit = crush.criterion.limit_force(g.strength[i], d, r_eff, pair.e_eff);
            (force, limit, crush.criterion.area(force, d, r_eff, pair.e_eff))
        }
        Judges::MeanStress => {
            // the force at which the grain would fail if all of its forces grew alike
            let stress = mean_stress::load(&crush.criterion, i, g.radius(i), neighbours, &state.pairs, &state.wall_pairs);
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

/// Velocity of grain `i` in the step that led to its present position, m/s: the change of velocity of the present step is taken back.
fn arriving(physics: &Physics, state: &State, neighbours: &Neighbours, external_forces: &[[[f64; 4]; 2]], i: usize) -> [f64; 3] {
    let (mut f, _) = gather::force_and_torque(i, physics, state, neighbours);
    if let Some([force, _]) = external_forces.get(i) {
        f.iter_mut().zip(force).for_each(|(sum, f)| *sum += f);
    }
    let [u, v, w, inverse_inertia] = state.grains.vel[i];
    less([u, v, w], f.map(|f| f * inverse_inertia * state.dt))
}

/// Replaces one grain by its daughters.
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
    let (axis, perpendicular) = match crush.azimuth {
        Azimuth::Random => (verdict.axis, random_perpendicular(crush.seed, mother.lineage, verdict.axis)),
        Azimuth::Fixed => turned_from_space(verdict.axis),
    };
    let mut kept = 0.0;
    let mut daughters_kinetic = 0.0;
    let mut born = Vec::with_capacity(crush.pattern.count());
    // daughters are placed in the sphere of the broken grain, or in its free part; their sizes are those for its final size, enlarged if all mass is kept
    let in_sphere = |radius: f64| crush.pattern.daughters(centre, radius, axis, perpendicular);
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
        // daughters only touch each other, so each contact is counted once
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

/// State of the broken grain that daughters inherit.
struct Mother {
    pos: [f64; 4],
    /// Its radius, or the radius to which it was growing, m.
    size: f64,
    vel: [f64; 4],
    spin: [f64; 4],
    mass: f64,
    lineage: u64,
    generation: u8,
    material: u8,
}

/// Makes daughter `k`, with its centre and radius, m, at index `i`.
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
    let d = 2.0 * g.radius(i);
    g.strength[i] = crush.strength.draw(crush.seed, g.lineage[i], d);
    g.breakage_threshold[i] = if d > crush.d_limit { crush.criterion.threshold(g.strength[i], d) } else { f64::INFINITY };
}

/// Momentum of grain `i` with its inertial mass, kg m/s.
fn momentum(state: &State, i: usize) -> [f64; 3] {
    let [u, v, w, _] = state.grains.vel[i];
    [u, v, w].map(|v| state.grains.inertia(i) * v)
}

/// Kinetic energy of grain `i` with its inertial mass, J.
fn kinetic_energy(state: &State, i: usize) -> f64 {
    let g = &state.grains;
    let (v, w, r) = (g.vel[i], g.spin[i], g.radius(i));
    let v2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let w2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
    0.5 * g.inertia(i) * (v2 + 0.4 * r * r * w2)
}

/// Elastic energy of the contacts of grain `i` at the present positions, J.
fn energy_around(physics: &Physics, state: &State, neighbours: &Neighbours, table: &PairTable, i: usize) -> f64 {
    let law = physics.contact.law;
    let mut sum = 0.0;
    stability::overlaps(i, state, neighbours, table, |o| {
        let elastic = o.elastic(law);
        // under a law that yields, force and stiffness may have fallen to nothing in this step while the grains still overlap; the spring is that of
        // the step before, and bears no more than friction does now
        let share = if law.table().plastic { limited_share(o.spring, o.pair.friction * elastic.force) } else { 1.0 };
        sum += elastic.energy + observables::tangential_energy(o.spring.map(|t| share * t), elastic.k_t);
    });
    sum
}

/// The share of a tangential force, N, that is left where friction limits it to `limit`, N: 1 where it is not above.
fn limited_share(force: [f64; 3], limit: f64) -> f64 {
    let size = dot(force, force).sqrt();
    if size > limit { limit / size } else { 1.0 }
}

/// Counts the path work of contacts that end with grain `m` up to the end of the step: −½ F·v dt, which the trapezium rule would add in the next step.
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
