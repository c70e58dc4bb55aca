//! The stable time step, and the inertial masses that make a given step stable (inertia scaling).
//!
//! The leapfrog is stable for dt < 2/ω_max. The energy of a contact depends on four motions, the translations and rotations of two spheres
//! (I = 2/5 m r²); bounding it by Cauchy–Schwarz gives for grain i the sufficient bound
//!
//! ```text
//! ω_i² ≤ (1 + α) Σ_contacts max(2 k_n, 7 k_t) / m_i
//! ```
//!
//! with the tangent stiffnesses k_n, k_t, N/m, and the coefficient α of local damping. Without inertia scaling dt = safety · min_i 2/ω_i. With inertia
//! scaling dt = 1 (time counts steps) and m_i = (1 + α) Σ max(2 k_n, 7 k_t) dt² / (4 safety²).

use super::{State, Workspace};
use crate::contact::ContactLaw;
use crate::contact::law::Elastic;
use crate::contact::pair::{Pair, PairTable};
use crate::contact::sweep::{difference, r_eff};
use crate::dem::physics::Physics;
use crate::grains::{Grains, sphere_volume};
use crate::math::vector::dot;
use crate::neighbours::{Entry, Neighbours};
use rayon::prelude::*;

/// max(2 k_n, 7 k_t) of a contact, N/m: its part in the bound above.
fn effective_stiffness(e: &Elastic) -> f64 {
    (2.0 * e.k_n).max(7.0 * e.k_t)
}

/// An overlap of a grain with another grain or a wall at the present positions.
pub struct Overlap<'a> {
    /// Overlap, m.
    pub depth: f64,
    /// Largest depth so far, m.
    pub largest: f64,
    /// Reduced radius R*, m.
    pub r_eff: f64,
    /// Parameters of the contact.
    pub pair: &'a Pair,
    /// Tangential spring force of the contact, N; zero if contact forces have not been computed since the two began to touch.
    pub spring: [f64; 3],
}

impl Overlap<'_> {
    /// Force, stiffness and energy of the contact under the run's law.
    pub fn elastic(&self, law: ContactLaw) -> Elastic {
        law.elastic(self.depth, self.largest, self.r_eff, self.pair)
    }
}

/// Calls `visit` with every overlap of grain `i` at the present positions, in the order of the partners' identities, walls last.
pub fn overlaps<'a>(i: usize, state: &State, neighbours: &Neighbours, table: &'a PairTable, visit: impl FnMut(Overlap<'a>)) {
    overlaps_with(i, neighbours.around(i, &state.pairs), state, neighbours, table, visit);
}

/// As [`overlaps`], with these other grains: all that may overlap with it.
fn overlaps_with<'a>(
    i: usize,
    others: impl Iterator<Item = (Entry, usize)>,
    state: &State,
    neighbours: &Neighbours,
    table: &'a PairTable,
    mut visit: impl FnMut(Overlap<'a>),
) {
    let g = &state.grains;
    let p = g.pos[i];
    for (e, j) in others {
        let q = g.pos[j];
        let d = difference(p, q);
        let depth = p[3] + q[3] - dot(d, d).sqrt();
        if depth > 0.0 {
            let (spring, largest) = match e.link.is_apart() {
                true => ([0.0; 3], depth),
                false => (state.pairs.spring(e.slot()), state.pairs.largest(e.slot(), depth)),
            };
            visit(Overlap {
                depth,
                largest,
                r_eff: r_eff(g.stiffness_radius(i), g.stiffness_radius(j)),
                pair: table.grains(g.material[i], g.material[j]),
                spring,
            });
        }
    }
    for e in neighbours.contacts.of(i).filter(|e| e.is_wall()) {
        let (_, gap) = state.walls[e.wall_index()].shape.towards(p);
        if gap < 0.0 {
            let pair = table.wall(e.wall_index(), g.material[i]);
            let (spring, largest) = (state.wall_pairs.spring(e.slot()), state.wall_pairs.largest(e.slot(), -gap));
            visit(Overlap { depth: -gap, largest, r_eff: g.stiffness_radius(i), pair, spring });
        }
    }
}

/// Σ max(2 k_n, 7 k_t) over the contacts of grain `i` at the present positions, N/m, softening contacts of broken neighbours included.
/// Contact forces must have been computed at these positions, so that all overlaps are listed as contacts: these are a quarter of a grain's neighbours.
fn stiffness(i: usize, physics: &Physics, state: &State, neighbours: &Neighbours, table: &PairTable) -> f64 {
    stiffness_with(i, neighbours.touching(i, &state.pairs), physics, state, neighbours, table)
}

/// As [`stiffness`], with these other grains: all that may overlap with it.
fn stiffness_with(
    i: usize,
    others: impl Iterator<Item = (Entry, usize)>,
    physics: &Physics,
    state: &State,
    neighbours: &Neighbours,
    table: &PairTable,
) -> f64 {
    let mut sum = 0.0;
    overlaps_with(i, others, state, neighbours, table, |o| sum += effective_stiffness(&o.elastic(physics.contact.law)));
    sum + 2.0 * state.aftermath.stiffness(i)
}

/// Σ max(2 k_n, 7 k_t), N/m, of a grain of this size and material that has two contacts with its like, each under the force `stress` π r²: a lower bound
/// for grains with few or light contacts.
fn stiffness_at_rest(i: usize, physics: &Physics, g: &Grains, stress: f64, table: &PairTable) -> f64 {
    let r = g.radius(i);
    let pair = table.grains(g.material[i], g.material[i]);
    let r_eff = 0.5 * g.stiffness_radius(i);
    let force = stress * std::f64::consts::PI * r * r;
    let law = physics.contact.law;
    let overlap = law.overlap_under(force, r_eff, pair);
    2.0 * effective_stiffness(&law.elastic(overlap, overlap, r_eff, pair))
}

/// Inertial mass for which a step of `dt` is stable with the sum of stiffnesses `k`, N/m. Local damping adds up to α |F| to a force F, as if contacts
/// were stiffer by 1 + α.
fn scaled_inertia(k: f64, damping: f64, dt: f64, safety: f64) -> f64 {
    (1.0 + damping) * k * dt * dt / (4.0 * safety * safety)
}

/// Factor by which inertia, or the square of a frequency, is taken larger than needed, so that stiffnesses may grow until the next look.
const MARGIN: f64 = 1.2;

/// New inertial mass of grain `i`, kg, whose contacts have the sum of stiffnesses `stiffness`, N/m, if the present mass is too small or more than 2.4 times
/// what is needed; else `None`.
fn new_inertia(i: usize, stiffness: f64, physics: &Physics, state: &State, table: &PairTable) -> Option<f64> {
    let needed = stiffness.max(stiffness_at_rest(i, physics, &state.grains, state.reference_stress, table));
    let inertia = scaled_inertia(needed, state.damping, state.dt, physics.stepping.safety);
    let present = state.grains.inertia(i);
    (present < inertia || present > 2.0 * MARGIN * inertia).then_some(MARGIN * inertia)
}

/// Time step, s, before any contact is known: 1 with inertia scaling, the scene's fixed step, or that of [`rayleigh`].
pub fn first_step(physics: &Physics, state: &State) -> f64 {
    if physics.stepping.inertia_scaling {
        return 1.0;
    }
    physics.stepping.dt.unwrap_or_else(|| rayleigh(physics, &state.grains))
}

/// Share ([`crate::dem::physics::Stepping::rayleigh`]) of the smallest free step of all grains, s: the Rayleigh step
/// π r √(ρ/G) / (0.163 ν + 0.877) (Li et al. 2023, eq. 38), or √(m/k) for linear contact laws. 1 s without grains.
pub fn rayleigh(physics: &Physics, g: &Grains) -> f64 {
    let least = (0..g.len())
        .map(|i| free_step(physics, g.material[i], g.mass[i], g.radius(i), g.stiffness_radius(i)))
        .fold(f64::INFINITY, f64::min);
    // without grains nothing bounds the step
    if least.is_finite() { physics.stepping.rayleigh() * resolved(physics) * least } else { 1.0 }
}

/// As [`rayleigh`], for grains given by diameter, m, and material before they are made.
pub fn rayleigh_of(physics: &Physics, grains: impl IntoIterator<Item = (f64, u8)>) -> f64 {
    let of = |(d, material): (f64, u8)| {
        let r = 0.5 * d;
        (physics.materials[usize::from(material)].density * sphere_volume(r), r, material)
    };
    free_of(physics, grains.into_iter().map(of))
}

/// As [`rayleigh`], for bodies given by mass, kg, radius, m, and material.
pub fn free_of(physics: &Physics, bodies: impl IntoIterator<Item = (f64, f64, u8)>) -> f64 {
    let of = |(mass, r, material)| free_step(physics, material, mass, r, r);
    let least = bodies.into_iter().map(of).fold(f64::INFINITY, f64::min);
    if least.is_finite() { physics.stepping.rayleigh() * resolved(physics) * least } else { 1.0 }
}

/// Free step of a grain, s: its Rayleigh step, or for linear laws the time √(m/k) of an oscillation.
fn free_step(physics: &Physics, material: u8, mass: f64, r: f64, stiffness_radius: f64) -> f64 {
    (physics.contact.law.table().free_step)(&physics.materials[material as usize], mass, r, stiffness_radius)
}

/// Coefficient of restitution from which on the step of an elastic impact resolves the viscous forces as well.
const LIVELY: f64 = 0.8;

/// Share, 1 or less, of the step of an elastic impact that also resolves viscous contact forces. These are found from velocities half a step old, which
/// gives an error in proportion to the step and, relative to the speed after an impact, to 1/e, with the coefficient of restitution e. With this share
/// restitutions from 0.05 on are met within 1 % (`tests/verification/impact.rs`).
fn resolved(physics: &Physics) -> f64 {
    let restitution = physics.contact.law.table().restitution;
    physics.materials.iter().map(|m| (restitution(&m.contact) / LIVELY).min(1.0)).fold(1.0, f64::min)
}

/// Brings inertial masses (with inertia scaling) or the time step (without, unless it is fixed) up to date with the present contacts.
pub fn refresh(physics: &Physics, state: &mut State, work: &mut Workspace) {
    if physics.stepping.inertia_scaling {
        rescale(physics, state, work);
    } else if physics.stepping.dt.is_none() {
        state.dt = (physics.stepping.safety * largest_step(physics, state, work, MARGIN)).min(rayleigh(physics, &state.grains));
    }
}

/// Largest stable step, s, of grains with their real masses if all contacts were `margin` times as stiff as they are: min_i 2/ω_i with the bound above,
/// infinite without contacts.
pub fn largest_step(physics: &Physics, state: &State, work: &Workspace, margin: f64) -> f64 {
    let of = |i: usize| own_step(i, physics, state, work, margin);
    (0..state.grains.len()).into_par_iter().with_min_len(256).map(of).reduce(|| f64::INFINITY, f64::min)
}

/// Largest stable step, s, of grain `i` as in [`largest_step`].
fn own_step(i: usize, physics: &Physics, state: &State, work: &Workspace, margin: f64) -> f64 {
    let k = stiffness(i, physics, state, &work.neighbours, &work.table);
    if k > 0.0 { 2.0 * (state.grains.mass[i] / ((1.0 + state.damping) * k * margin)).sqrt() } else { f64::INFINITY }
}

/// The grain whose contacts allow the shortest step; `None` without grains.
pub fn slowest(physics: &Physics, state: &State, work: &Workspace) -> Option<usize> {
    let of = |i: &usize| own_step(*i, physics, state, work, 1.0);
    (0..state.grains.len()).min_by(|i, j| of(i).total_cmp(&of(j)))
}

/// Gives new inertial masses to the grains that need them. The ledger is updated in the order of identities, so that its sum has the same bits whatever
/// the number of threads.
fn rescale(physics: &Physics, state: &mut State, work: &mut Workspace) {
    let Workspace { neighbours, table, scratch, .. } = work;
    scratch.inertia.resize(state.grains.len(), None);
    let frozen: &State = state;
    scratch.inertia.par_iter_mut().with_min_len(256).enumerate().for_each(|(i, new)| {
        *new = new_inertia(i, stiffness(i, physics, frozen, neighbours, table), physics, frozen, table);
    });
    scratch.changed.clear();
    for (i, new) in scratch.inertia.iter().enumerate() {
        if new.is_some() {
            scratch.changed.push((frozen.grains.id[i], i as u32));
        }
    }
    scratch.changed.sort_unstable();
    for &(_, i) in &scratch.changed {
        if let Some(inertia) = scratch.inertia[i as usize] {
            set_inertia(state, i as usize, inertia);
        }
    }
}

/// With inertia scaling: raises the inertial mass, where needed, of grains whose contacts change fast because a grain has just broken beside them. Called
/// at every step.
pub fn follow_fast_contacts(physics: &Physics, state: &mut State, work: &mut Workspace) {
    if !physics.stepping.inertia_scaling || state.aftermath.is_empty() {
        return;
    }
    let Workspace { neighbours, table, scratch, .. } = work;
    scratch.restless.clear();
    scratch.restless.extend(state.aftermath.restless());
    for &i in &scratch.restless {
        let needed = stiffness(i, physics, state, neighbours, table);
        if let Some(inertia) = new_inertia(i, needed, physics, state, table)
            && inertia > state.grains.inertia(i)
        {
            set_inertia(state, i, inertia);
        }
    }
}

/// With inertia scaling: raises the inertial mass of grain `i`, where needed, for its contacts and others that are not in the lists (with material
/// points), whose Σ max(2 k_n, 7 k_t) is `others`, N/m.
pub fn raise_inertia(i: usize, others: f64, physics: &Physics, state: &mut State, work: &Workspace) {
    let needed = stiffness(i, physics, state, &work.neighbours, &work.table) + others;
    let inertia = scaled_inertia(needed, state.damping, state.dt, physics.stepping.safety);
    if state.grains.inertia(i) < inertia {
        set_inertia(state, i, MARGIN * inertia);
    }
}

/// Buffers of [`refresh`] and [`follow_fast_contacts`].
#[derive(Default)]
pub struct InertiaBuffers {
    restless: Vec<usize>,
    inertia: Vec<Option<f64>>,
    changed: Vec<(u32, u32)>,
}

/// Sets the inertial mass of grain `i`; its velocities stay, and the ledger counts the change of kinetic energy.
fn set_inertia(state: &mut State, i: usize, inertia: f64) {
    let g = &mut state.grains;
    let before = g.inertia(i);
    let (v, s, r) = (g.vel[i], g.spin[i], g.radius(i));
    let v2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let s2 = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];
    state.ledger.inertia += 0.5 * (inertia - before) * (v2 + 0.4 * r * r * s2);
    g.set_inertia(i, inertia);
}

/// With inertia scaling: gives a newborn grain the inertial mass that its first contacts need. The ledger does not count it.
pub fn newborn_inertia(i: usize, physics: &Physics, state: &mut State, neighbours: &Neighbours, table: &PairTable) {
    if physics.stepping.inertia_scaling
        && let Some(inertia) = {
            state.grains.vel[i][3] = f64::INFINITY;
            // its contacts have no forces yet
            let needed = stiffness_with(i, neighbours.around(i, &state.pairs), physics, state, neighbours, table);
            new_inertia(i, needed, physics, state, table)
        }
    {
        state.grains.set_inertia(i, inertia);
    }
}
