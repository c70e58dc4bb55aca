//! The stable step. For the leapfrog, dt < 2/ω_max; with the work of a contact bounded by Cauchy–Schwarz over the four motions that
//! feed it (two translations, two rotations of spheres, I = 2/5 m r²), ω² of grain i is at most
//!
//! ```text
//! ω_i² = (1 + α) Σ_contacts max(2 k_n, 7 k_t) / m_i
//! ```
//!
//! a sufficient bound (α: local damping). Unscaled: dt = safety · min 2/ω_i. Inertia-scaled: every grain's inertia is what makes dt = 1 the stable step,
//! m_i = (1 + α) Σ max(2 k_n, 7 k_t) dt² / (4 safety²).

use super::{State, Workspace};
use crate::contact::ContactLaw;
use crate::contact::law::Elastic;
use crate::contact::pair::{Pair, PairTable};
use crate::contact::sweep::{difference, r_eff};
use crate::dem::physics::Physics;
use crate::grains::{Grains, sphere_volume};
use crate::math::vector::dot;
use crate::neighbours::Neighbours;
use rayon::prelude::*;

fn effective_stiffness(e: &Elastic) -> f64 {
    (2.0 * e.k_n).max(7.0 * e.k_t)
}

/// What grain `i` overlaps at the present positions.
pub struct Overlap<'a> {
    pub depth: f64,
    /// Largest depth so far, m.
    pub largest: f64,
    /// R*, m.
    pub r_eff: f64,
    pub pair: &'a Pair,
    /// Tangential spring force of the contact, N; zero where the next sweep will find the two in contact for the first time.
    pub spring: [f64; 3],
}

impl Overlap<'_> {
    /// Force, stiffness and energy of the contact under the run's law.
    pub fn elastic(&self, law: ContactLaw) -> Elastic {
        law.elastic(self.depth, self.largest, self.r_eff, self.pair)
    }
}

/// Calls `visit` with all that grain `i` overlaps at the present positions, in the order of ids, walls last.
pub fn overlaps<'a>(i: usize, state: &State, neighbours: &Neighbours, table: &'a PairTable, mut visit: impl FnMut(Overlap<'a>)) {
    let g = &state.grains;
    let p = g.pos[i];
    for (e, j) in neighbours.around(i, &state.pairs) {
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

/// Σ max(2 k_n, 7 k_t) over the contacts of grain `i`, from current overlaps, N/m.
fn stiffness(i: usize, physics: &Physics, state: &State, neighbours: &Neighbours, table: &PairTable) -> f64 {
    let mut sum = 0.0;
    overlaps(i, state, neighbours, table, |o| sum += effective_stiffness(&o.elastic(physics.contact.law)));
    sum + 2.0 * state.aftermath.stiffness(i)
}

/// Stiffness a grain of this size has when two contacts bear the reference stress on its cross-section.
fn stiffness_at_rest(i: usize, physics: &Physics, g: &Grains, stress: f64, table: &PairTable) -> f64 {
    let r = g.pos[i][3];
    let pair = table.grains(g.material[i], g.material[i]);
    let r_eff = 0.5 * g.stiffness_radius(i);
    let force = stress * std::f64::consts::PI * r * r;
    let law = physics.contact.law;
    let overlap = law.overlap_under(force, r_eff, pair);
    2.0 * effective_stiffness(&law.elastic(overlap, overlap, r_eff, pair))
}

/// Inertia for which the step is stable under stiffness `k`, kg (time in steps). Local damping α adds up to α |F| to a force, as
/// if contacts were stiffer by 1 + α.
fn scaled_inertia(k: f64, damping: f64, dt: f64, safety: f64) -> f64 {
    (1.0 + damping) * k * dt * dt / (4.0 * safety * safety)
}

/// Margin by which stiffness may grow before inertia is looked at again.
const MARGIN: f64 = 1.2;

/// Inertia that a new grain or one out of bounds gets, or `None` while the present one serves.
fn new_inertia(i: usize, physics: &Physics, state: &State, neighbours: &Neighbours, table: &PairTable) -> Option<f64> {
    let floor = stiffness_at_rest(i, physics, &state.grains, state.reference_stress, table);
    let needed = stiffness(i, physics, state, neighbours, table).max(floor);
    let inertia = scaled_inertia(needed, state.damping, state.dt, physics.stepping.safety);
    let present = state.grains.inertia(i);
    (present < inertia || present > 2.0 * MARGIN * inertia).then_some(MARGIN * inertia)
}

/// The step before any contact is known: what the scene asks, 1 (inertia-scaled), or a share ([`crate::dem::physics::Stepping::rayleigh`]) of the Rayleigh step
/// Δt = π r √(ρ/G) / (0.163 ν + 0.877) of the most delicate grain (Li et al. 2023 eq. 38); for the linear law of the free
/// oscillation √(m/k).
pub fn first_step(physics: &Physics, state: &State) -> f64 {
    if physics.stepping.inertia_scaling {
        return 1.0;
    }
    physics.stepping.dt.unwrap_or_else(|| rayleigh(physics, &state.grains))
}

/// That share of the least of these over the grains, s.
pub fn rayleigh(physics: &Physics, g: &Grains) -> f64 {
    let least = (0..g.len())
        .map(|i| free_step(physics, g.material[i], g.mass[i], g.pos[i][3], g.stiffness_radius(i)))
        .fold(f64::INFINITY, f64::min);
    // without grains nothing bounds it
    if least.is_finite() { physics.stepping.rayleigh() * resolved(physics) * least } else { 1.0 }
}

/// As [`rayleigh`], of grains of these diameters, m, and materials, before there are any.
pub fn rayleigh_of(physics: &Physics, grains: impl IntoIterator<Item = (f64, u8)>) -> f64 {
    let of = |(d, material): (f64, u8)| {
        let r = 0.5 * d;
        free_step(physics, material, physics.materials[usize::from(material)].density * sphere_volume(r), r, r)
    };
    let least = grains.into_iter().map(of).fold(f64::INFINITY, f64::min);
    if least.is_finite() { physics.stepping.rayleigh() * resolved(physics) * least } else { 1.0 }
}

/// Step, s, of a grain by itself: Rayleigh's, or that of a free oscillation.
fn free_step(physics: &Physics, material: u8, mass: f64, r: f64, stiffness_radius: f64) -> f64 {
    (physics.contact.law.table().free_step)(&physics.materials[material as usize], mass, r, stiffness_radius)
}

/// Restitution from which on dashpots are resolved by the step of an elastic impact.
const LIVELY: f64 = 0.8;

/// Share of the step of an elastic impact that resolves the dashpots, whose force comes from velocities half a step old: that makes an error in proportion to the
/// step and, relative to what is left of the speed, to 1/e. With this share restitutions are within 1 % from 0.05 on (`tests/verification/impact.rs`).
fn resolved(physics: &Physics) -> f64 {
    let restitution = physics.contact.law.table().restitution;
    physics.materials.iter().map(|m| (restitution(&m.contact) / LIVELY).min(1.0)).fold(1.0, f64::min)
}

/// Looks at inertia (scaled runs) or the time step (unscaled) again.
pub fn refresh(physics: &Physics, state: &mut State, work: &mut Workspace) {
    if physics.stepping.inertia_scaling {
        rescale(physics, state, work);
    } else if physics.stepping.dt.is_none() {
        let frozen: &State = state;
        let least = (0..frozen.grains.len())
            .into_par_iter()
            .with_min_len(256)
            .map(|i| {
                let k = stiffness(i, physics, frozen, &work.neighbours, &work.table);
                if k > 0.0 { 2.0 * (frozen.grains.mass[i] / ((1.0 + frozen.damping) * k * MARGIN)).sqrt() } else { f64::INFINITY }
            })
            .reduce(|| f64::INFINITY, f64::min);
        state.dt = (physics.stepping.safety * least).min(rayleigh(physics, &state.grains));
    }
}

/// New inertia for the grains whose present one is out of bounds; the ledger's sum in the order of ids.
fn rescale(physics: &Physics, state: &mut State, work: &mut Workspace) {
    let Workspace { neighbours, table, scratch, .. } = work;
    scratch.inertia.resize(state.grains.len(), None);
    let frozen: &State = state;
    scratch
        .inertia
        .par_iter_mut()
        .with_min_len(256)
        .enumerate()
        .for_each(|(i, new)| *new = new_inertia(i, physics, frozen, neighbours, table));
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

/// Inertia, at every step, of the grains whose contacts change fast because something has just broken beside them (inertia scaling).
pub fn follow_fast_contacts(physics: &Physics, state: &mut State, work: &mut Workspace) {
    if !physics.stepping.inertia_scaling || state.aftermath.is_empty() {
        return;
    }
    let Workspace { neighbours, table, scratch, .. } = work;
    scratch.restless.clear();
    scratch.restless.extend(state.aftermath.restless());
    for &i in &scratch.restless {
        if let Some(inertia) = new_inertia(i, physics, state, neighbours, table)
            && inertia > state.grains.inertia(i)
        {
            set_inertia(state, i, inertia);
        }
    }
}

/// Raises the inertia of grain `i` to what its contacts ask for with others, of elsewhere, whose Σ max(2 k_n, 7 k_t) is `others`, N/m (inertia scaling).
pub fn raise_inertia(i: usize, others: f64, physics: &Physics, state: &mut State, work: &Workspace) {
    let needed = stiffness(i, physics, state, &work.neighbours, &work.table) + others;
    let inertia = scaled_inertia(needed, state.damping, state.dt, physics.stepping.safety);
    if state.grains.inertia(i) < inertia {
        set_inertia(state, i, MARGIN * inertia);
    }
}

/// Buffers of `rescale` and [`follow_fast_contacts`].
#[derive(Default)]
pub struct InertiaBuffers {
    restless: Vec<usize>,
    inertia: Vec<Option<f64>>,
    changed: Vec<(u32, u32)>,
}

fn set_inertia(state: &mut State, i: usize, inertia: f64) {
    let g = &mut state.grains;
    let before = g.inertia(i);
    let (v, s, r) = (g.vel[i], g.spin[i], g.pos[i][3]);
    let v2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let s2 = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];
    state.ledger.inertia += 0.5 * (inertia - before) * (v2 + 0.4 * r * r * s2);
    g.vel[i][3] = 1.0 / inertia;
}

/// Gives a newborn grain its inertia, from the contacts it is born into.
pub fn newborn_inertia(i: usize, physics: &Physics, state: &mut State, neighbours: &Neighbours, table: &PairTable) {
    if physics.stepping.inertia_scaling
        && let Some(inertia) = {
            state.grains.vel[i][3] = f64::INFINITY;
            new_inertia(i, physics, state, neighbours, table)
        }
    {
        state.grains.vel[i][3] = 1.0 / inertia;
    }
}
