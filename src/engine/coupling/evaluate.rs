//! Forces of all point contacts: first the geometry of each candidate, then the contact law for as many touching ones at once as the processor's
//! registers hold numbers (lanes).

use super::account::OfContact;
use super::candidates::{TASK, note};
use super::{Body, PointContact, PointContacts};
use crate::boundary::Wall;
use crate::contact::TangentialUnloading;
use crate::contact::force::{self, ContactGeometry, ContactHistory, RelativeMotion, Rules};
use crate::contact::law::Law;
use crate::contact::pair::{Pair, PairTable};
use crate::contact::pairs::ContactForce;
use crate::contact::registry::with_law;
use crate::dem::observables::tangential_energy;
use crate::grains::Grains;
use crate::math::real::{Lanes, MOST_LANES, arch};
use crate::math::vector::{dot, less, plus, scaled};
use crate::mpm::Continuum;
use crate::point_contacts::{ActsOn, GhostFace, PointContactTable};
use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use std::marker::PhantomData;

/// Grains, walls and points from which contact forces are computed. Where one side is between two of its steps, its positions are extrapolated in
/// time with its present velocities.
pub(super) struct PointContactScene<'a> {
    pub grains: &'a Grains,
    pub walls: &'a [Wall],
    pub continuum: &'a Continuum,
    pub table: &'a PointContactTable,
    pub unloading: TangentialUnloading,
    pub dt: f64,
    /// Times, s, by which positions are extrapolated: of grains and walls, and of points.
    pub ahead: [f64; 2],
}

impl PointContacts {
    /// Computes the force of every candidate at this instant. In parallel over candidates; each task writes only its own.
    pub(super) fn evaluate(&mut self, scene: &PointContactScene<'_>) {
        let rules = Rules { dt: scene.dt, unloading: scene.unloading, weighs_radius: true, task: TASK, arch: arch() };
        let PointContacts { candidates: list, account, .. } = self;
        let (candidates, history) = list.parts();
        let Some(account) = account else {
            return with_law!(scene.table.law, L => {
                candidates.par_chunks_mut(TASK).zip(history.par_chunks_mut(TASK)).for_each(|(part, history)| {
                    rules.arch.dispatch(PointContactSweep::<L, false> { scene, rules: &rules, part, work: &mut [], law: PhantomData });
                    note(part, history);
                });
            });
        };
        let works = account.begin(candidates.len());
        with_law!(scene.table.law, L => {
            let parts = candidates.par_chunks_mut(TASK).zip(history.par_chunks_mut(TASK)).zip(works.par_chunks_mut(TASK));
            parts.for_each(|((part, history), work)| {
                rules.arch.dispatch(PointContactSweep::<L, true> { scene, rules: &rules, part, work, law: PhantomData });
                note(part, history);
            });
        });
        account.end(candidates, scene.grains, scene.continuum);
    }
}

/// The computation for a part of the candidates.
struct PointContactSweep<'a, L, const LEDGER: bool> {
    scene: &'a PointContactScene<'a>,
    rules: &'a Rules,
    part: &'a mut [PointContact],
    /// Works and elastic energy of each candidate, with the energy account.
    work: &'a mut [OfContact],
    law: PhantomData<L>,
}

/// Points whose data are copied before any of them is used: they are scattered in memory, and a processor fetches several at once.
const AHEAD: usize = 32;

/// Position, m, and transport velocity, m/s, of a point.
#[derive(Clone, Copy, Default)]
struct Spot {
    at: [f64; 4],
    transport_velocity: [f64; 3],
}

/// A candidate that touches: its index in the part, and its geometry.
#[derive(Clone, Copy, Default)]
struct Found {
    at: usize,
    geometry: ContactGeometry,
}

impl<L: Law, const LEDGER: bool> WithSimd for PointContactSweep<'_, L, LEDGER> {
    type Output = ();

    /// Collects touching contacts until they fill the lanes, then applies the law to them at once; a rest is done one at a time.
    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let lanes = Lanes::<S>::COUNT;
        let mut waiting = [Found::default(); MOST_LANES];
        let mut n = 0;
        let mut spots = [Spot::default(); AHEAD];
        for first in (0..self.part.len()).step_by(AHEAD) {
            let some = first..self.part.len().min(first + AHEAD);
            for (spot, contact) in spots.iter_mut().zip(&self.part[some.clone()]) {
                // separate assignments, so that the processor starts both fetches without waiting
                let (points, point) = (self.scene.continuum.points(), contact.place[1] as usize);
                spot.at = points.position[point];
                spot.transport_velocity = points.transport_velocity[point];
            }
            for (at, spot) in some.zip(&spots) {
                let Some(geometry) = self.geometry(at, spot) else { continue };
                waiting[n] = Found { at, geometry };
                n += 1;
                if n == lanes {
                    n = 0;
                    if const { Lanes::<S>::COUNT > 1 } { self.simd(simd, &waiting[..lanes]) } else { self.scalar(&waiting[0]) }
                }
            }
        }
        for found in &waiting[..n] {
            self.scalar(found);
        }
    }
}

impl<L: Law, const LEDGER: bool> PointContactSweep<'_, L, LEDGER> {
    /// Geometry of candidate `at` if it touches. A contact that has ceased to touch gets a zero force.
    #[inline(always)]
    fn geometry(&mut self, at: usize, spot: &Spot) -> Option<ContactGeometry> {
        let contact = &mut self.part[at];
        let mut geometry = self.scene.contact_geometry::<L>(contact, spot);
        let of_ghost = geometry.overlap;
        if let Some(face) = &mut contact.face {
            // the nodes move the face, not the point
            face.normal = geometry.normal;
            geometry.overlap += face.beyond;
            geometry.motion.centres = plus(geometry.motion.centres, less(spot.transport_velocity, face.velocity));
        } else if self.scene.table.acts_on == ActsOn::Face && of_ghost > 0.0 {
            contact.face = Some(GhostFace::at_first_touch(geometry.normal, spot.transport_velocity));
        }
        if contact.reference > 0.0 {
            // the overlap without force never exceeds the present overlap
            contact.reference = contact.reference.min(geometry.overlap.max(0.0));
            geometry.overlap -= contact.reference;
        }
        if geometry.overlap > 0.0 {
            return Some(geometry);
        }
        if contact.touch.overlap > 0.0 {
            contact.stiffness = [0.0; 2];
            let ended = force::apart::<LEDGER>(|| geometry.motion, self.rules.dt, &contact.history::<L>());
            contact.keep(ended);
            if LEDGER {
                self.work[at].set(ended.work, 0.0);
            }
        }
        if of_ghost <= 0.0 {
            contact.face = None;
        }
        None
    }

    /// Force of one contact.
    #[inline(always)]
    fn scalar(&mut self, &Found { at, geometry }: &Found) {
        let contact = &mut self.part[at];
        let pair = Pair { friction: self.scene.friction(contact), ..*self.scene.pair(contact) };
        let new = force::touching::<f64, L, LEDGER, true>(&geometry, &pair, self.rules, &contact.history::<L>());
        let e = L::elastic(geometry.overlap, geometry.overlap, geometry.r_eff, &pair);
        contact.stiffness = [e.k_n, e.k_t];
        contact.keep(new);
        if LEDGER {
            let spring = new.spring.unwrap_or(new.touch.tangential);
            self.work[at].set(new.work, e.energy + tangential_energy(spring, e.k_t));
        }
    }

    /// Forces of several contacts, one in each lane.
    #[inline(always)]
    fn simd<S: Simd>(&mut self, simd: S, those: &[Found]) {
        let (scene, at, m) = (self.scene, |k: usize| those[k].at, |k: usize| &those[k].geometry);
        let with = |v: [f64; 3], last: f64| [v[0], v[1], v[2], last];
        let part = &mut *self.part;
        let [nx, ny, nz, overlap] = Lanes::columns(simd, |k| with(m(k).normal, m(k).overlap));
        let [vx, vy, vz, r_eff] = Lanes::columns(simd, |k| with(m(k).motion.centres, m(k).r_eff));
        let [tx, ty, tz, m_eff] = Lanes::columns(simd, |k| with(m(k).motion.turning, m(k).m_eff));
        let [wx, wy, wz, _] = Lanes::columns(simd, |k| with(m(k).motion.mean_spin, 0.0));
        // point contacts have no rolling resistance: the difference of spins is not used
        let (turning, mean_spin) = ([tx, ty, tz], [wx, wy, wz]);
        let motion = RelativeMotion { centres: [vx, vy, vz], turning, mean_spin, spin_difference: mean_spin };
        let geometry = ContactGeometry { normal: [nx, ny, nz], overlap, r_eff, m_eff, motion };
        let mut pair = PairTable::lanes(simd, |k| scene.pair(&part[at(k)]));
        if scene.table.softens() {
            [pair.friction, ..] = Lanes::columns(simd, |k| with([scene.friction(&part[at(k)]); 3], 0.0));
        }
        let [x, y, z, normal_force] = Lanes::columns(simd, |k| part[at(k)].touch.first());
        let [ox, oy, oz, before] = Lanes::columns(simd, |k| part[at(k)].touch.second());
        let touch = ContactForce { tangential: [x, y, z], normal_force, normal: [ox, oy, oz], overlap: before };
        let spring = if L::VISCOUS {
            let [x, y, z, _] = Lanes::columns(simd, |k| with(part[at(k)].spring, 0.0));
            Some([x, y, z])
        } else {
            None
        };
        let old = ContactHistory { touch, spring, rolling: None, load: None, largest: None, work: None };
        let new = force::touching::<Lanes<S>, L, LEDGER, true>(&geometry, &pair, self.rules, &old);
        let ContactForce { tangential: [x, y, z], normal_force, normal: [nx, ny, nz], overlap } = new.touch;
        Lanes::rows(simd, [x, y, z, normal_force], |k, row| part[at(k)].touch.set_first(row));
        Lanes::rows(simd, [nx, ny, nz, overlap], |k, row| part[at(k)].touch.set_second(row));
        if let Some([x, y, z]) = new.spring {
            Lanes::rows(simd, [x, y, z, x], |k, [x, y, z, _]| part[at(k)].spring = [x, y, z]);
        }
        let e = L::elastic(geometry.overlap, geometry.overlap, geometry.r_eff, &pair);
        if let Some([path, slip, viscous]) = new.work {
            let spring = new.spring.unwrap_or(new.touch.tangential);
            let stored = e.energy + dot(spring, spring) * 0.5 / e.k_t;
            Lanes::rows(simd, [path, slip, viscous, stored], |k, [path, slip, viscous, stored]| {
                self.work[at(k)].set(Some([path, slip, viscous]), stored);
            });
        }
        Lanes::rows(simd, [e.k_n, e.k_t, e.k_n, e.k_t], |k, [k_n, k_t, ..]| part[at(k)].stiffness = [k_n, k_t]);
    }
}

impl PointContactScene<'_> {
    /// Geometry of a candidate. The normal points from the body to the point; an overlap of zero or less means that they do not touch.
    #[inline(always)]
    fn contact_geometry<L: Law>(&self, contact: &PointContact, &Spot { at, transport_velocity }: &Spot) -> ContactGeometry {
        let body = contact.place[0] as usize;
        let at = ahead(at, transport_velocity, self.ahead[1]);
        let m_eff = |inverse_mass: f64| if L::VISCOUS { 1.0 / (inverse_mass + 1.0 / contact.mass) } else { 0.0 };
        match contact.body {
            Body::Grain(_) => {
                let (p, v, w) = (self.grains.pos[body], self.grains.vel[body], self.grains.spin[body]);
                let (v3, w3) = ([v[0], v[1], v[2]], [w[0], w[1], w[2]]);
                let d = less(at, ahead(p, v3, self.ahead[0]));
                let distance = dot(d, d).sqrt();
                let reach = p[3] + contact.radius;
                let motion = RelativeMotion {
                    centres: less(v3, transport_velocity),
                    turning: scaled(w3, p[3]),
                    mean_spin: scaled(w3, 0.5),
                    spin_difference: w3,
                };
                let (normal, r_eff) = (scaled(d, 1.0 / distance), p[3] * contact.radius / reach);
                ContactGeometry { normal, overlap: reach - distance, r_eff, m_eff: m_eff(v[3]), motion }
            }
            Body::Wall(_) => {
                let wall = &self.walls[body];
                let [x, y, z] = at;
                let (towards, gap) = wall.shape.towards([x, y, z, contact.radius]);
                let normal = scaled(towards, -1.0);
                let centres = less(scaled(normal, wall.speed), transport_velocity);
                let overlap = wall.speed * self.ahead[0] - gap;
                ContactGeometry {
                    normal,
                    overlap,
                    r_eff: contact.radius,
                    m_eff: m_eff(0.0),
                    motion: RelativeMotion { centres, ..RelativeMotion::default() },
                }
            }
        }
    }

    /// Coefficient of friction of the contact, at the plastic strain that its point has now.
    #[inline(always)]
    fn friction(&self, contact: &PointContact) -> f64 {
        let pair = self.pair(contact);
        let plastic = || self.continuum.points().memory[contact.place[1] as usize].plastic;
        match contact.body {
            Body::Grain(_) => self.table.friction(contact.law, pair, plastic),
            Body::Wall(_) => pair.friction,
        }
    }

    /// Parameters of the contact, with the friction before any plastic strain.
    #[inline(always)]
    fn pair(&self, contact: &PointContact) -> &Pair {
        match contact.body {
            Body::Grain(_) => self.table.of_grain(contact.law, self.grains.material[contact.place[0] as usize]),
            Body::Wall(k) => self.table.of_wall(contact.law, k as usize),
        }
    }
}

impl PointContact {
    /// State of the contact at the end of the last step, as the contact law needs it.
    #[inline(always)]
    fn history<L: Law>(&self) -> ContactHistory {
        ContactHistory {
            touch: self.touch,
            spring: L::VISCOUS.then_some(self.spring),
            rolling: None,
            load: None,
            largest: None,
            work: None,
        }
    }

    /// Stores the state that the contact law has computed.
    #[inline(always)]
    fn keep(&mut self, new: ContactHistory) {
        self.touch = new.touch;
        self.spring = new.spring.unwrap_or_default();
    }
}

/// Position after `by` seconds at the velocity `v`.
#[inline(always)]
fn ahead(p: [f64; 4], v: [f64; 3], by: f64) -> [f64; 3] {
    std::array::from_fn(|a| p[a] + v[a] * by)
}
