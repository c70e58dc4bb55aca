//! Force of every ghost contact: its geometry one by one, then the law for as many that touch as the processor has lanes.

use super::{Body, Ghost, Ghosts};
use crate::boundary::Wall;
use crate::contact::TangentialUnloading;
use crate::contact::force::{self, ContactGeometry, ContactHistory, RelativeMotion, Rules};
use crate::contact::law::Law;
use crate::contact::pair::{Pair, PairTable};
use crate::contact::pairs::ContactForce;
use crate::contact::registry::with_law;
use crate::grains::Grains;
use crate::math::real::{Lanes, MOST_LANES, arch};
use crate::math::vector::{dot, less, scaled};
use crate::mpm::Continuum;
use crate::point_contacts::GhostTable;
use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use std::marker::PhantomData;

/// Contacts of one task.
const TASK: usize = 512;

/// What the contacts are found from: bodies and points, each so many seconds further along the way that they are going.
pub(super) struct Scene<'a> {
    pub grains: &'a Grains,
    pub walls: &'a [Wall],
    pub continuum: &'a Continuum,
    pub table: &'a GhostTable,
    pub unloading: TangentialUnloading,
    pub dt: f64,
    /// Seconds by which grains and walls, and points, are taken ahead.
    pub ahead: [f64; 2],
}

impl Ghosts {
    /// Finds the forces of this instant. Parallel over contacts; each writes only itself.
    pub(super) fn evaluate(&mut self, scene: &Scene<'_>) {
        let rules = Rules { dt: scene.dt, unloading: scene.unloading, task: TASK, arch: arch() };
        with_law!(scene.table.law, L => {
            self.near.par_chunks_mut(TASK).for_each(|part| {
                rules.arch.dispatch(Sweep::<L> { scene, rules: &rules, part, law: PhantomData });
            });
        });
    }
}

/// Some of the contacts.
struct Sweep<'a, L> {
    scene: &'a Scene<'a>,
    rules: &'a Rules,
    part: &'a mut [Ghost],
    law: PhantomData<L>,
}

/// Points that are fetched before they are looked at: they lie all over the memory, and a processor waits for some at a time.
const AHEAD: usize = 32;

/// Where a point is, m, and the velocity that carried it, m/s.
#[derive(Clone, Copy, Default)]
struct Spot {
    at: [f64; 4],
    carried: [f64; 3],
}

/// A contact that touches: its place in the part, and how its ends meet.
#[derive(Clone, Copy, Default)]
struct Found {
    at: usize,
    meeting: ContactGeometry,
}

impl<L: Law> WithSimd for Sweep<'_, L> {
    type Output = ();

    /// Those that touch are collected until they fill the lanes.
    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let lanes = Lanes::<S>::COUNT;
        let mut waiting = [Found::default(); MOST_LANES];
        let mut n = 0;
        let mut spots = [Spot::default(); AHEAD];
        for first in (0..self.part.len()).step_by(AHEAD) {
            let some = first..self.part.len().min(first + AHEAD);
            for (spot, ghost) in spots.iter_mut().zip(&self.part[some.clone()]) {
                // one field after the other: a copy of both at once would wait for itself
                let (points, point) = (self.scene.continuum.points(), ghost.place[1] as usize);
                spot.at = points.position[point];
                spot.carried = points.carried[point];
            }
            for (at, spot) in some.zip(&spots) {
                let Some(meeting) = self.geometry(at, spot) else { continue };
                waiting[n] = Found { at, meeting };
                n += 1;
                if n == lanes {
                    n = 0;
                    if lanes == 1 { self.scalar(&waiting[0]) } else { self.simd(simd, &waiting[..lanes]) }
                }
            }
        }
        for found in &waiting[..n] {
            self.scalar(found);
        }
    }
}

impl<L: Law> Sweep<'_, L> {
    /// How the ends of contact `at` meet; what does not touch any more is left without a force.
    #[inline(always)]
    fn geometry(&mut self, at: usize, spot: &Spot) -> Option<ContactGeometry> {
        let ghost = &mut self.part[at];
        let mut meeting = self.scene.meeting::<L>(ghost, spot);
        if ghost.reference > 0.0 {
            // lower where they have parted
            ghost.reference = ghost.reference.min(meeting.overlap.max(0.0));
            meeting.overlap -= ghost.reference;
        }
        if meeting.overlap > 0.0 {
            return Some(meeting);
        }
        if ghost.touch.overlap > 0.0 {
            ghost.stiffness = [0.0; 2];
            ghost.keep(force::apart::<false>(|| meeting.motion, self.rules.dt, &ghost.memory::<L>()));
        }
        None
    }

    #[inline(always)]
    fn scalar(&mut self, &Found { at, meeting }: &Found) {
        let ghost = &mut self.part[at];
        let pair = self.scene.pair(ghost);
        let new = force::touching::<f64, L, false, true>(&meeting, pair, self.rules, &ghost.memory::<L>());
        let e = L::elastic(meeting.overlap, meeting.overlap, meeting.r_eff, pair);
        ghost.stiffness = [e.k_n, e.k_t];
        ghost.keep(new);
    }

    /// One contact in each lane.
    #[inline(always)]
    fn simd<S: Simd>(&mut self, simd: S, those: &[Found]) {
        let (scene, at, m) = (self.scene, |k: usize| those[k].at, |k: usize| &those[k].meeting);
        let with = |v: [f64; 3], last: f64| [v[0], v[1], v[2], last];
        let part = &mut *self.part;
        let [nx, ny, nz, overlap] = Lanes::columns(simd, |k| with(m(k).normal, m(k).overlap));
        let [vx, vy, vz, r_eff] = Lanes::columns(simd, |k| with(m(k).motion.centres, m(k).r_eff));
        let [tx, ty, tz, m_eff] = Lanes::columns(simd, |k| with(m(k).motion.turning, m(k).m_eff));
        let [wx, wy, wz, _] = Lanes::columns(simd, |k| with(m(k).motion.mean_spin, 0.0));
        // nothing rolls: their difference is not asked for
        let (turning, mean_spin) = ([tx, ty, tz], [wx, wy, wz]);
        let motion = RelativeMotion { centres: [vx, vy, vz], turning, mean_spin, spin_difference: mean_spin };
        let meeting = ContactGeometry { normal: [nx, ny, nz], overlap, r_eff, m_eff, motion };
        let pair = PairTable::lanes(simd, |k| scene.pair(&part[at(k)]));
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
        let new = force::touching::<Lanes<S>, L, false, true>(&meeting, &pair, self.rules, &old);
        let ContactForce { tangential: [x, y, z], normal_force, normal: [nx, ny, nz], overlap } = new.touch;
        Lanes::rows(simd, [x, y, z, normal_force], |k, row| part[at(k)].touch.set_first(row));
        Lanes::rows(simd, [nx, ny, nz, overlap], |k, row| part[at(k)].touch.set_second(row));
        if let Some([x, y, z]) = new.spring {
            Lanes::rows(simd, [x, y, z, x], |k, [x, y, z, _]| part[at(k)].spring = [x, y, z]);
        }
        let e = L::elastic(meeting.overlap, meeting.overlap, meeting.r_eff, &pair);
        Lanes::rows(simd, [e.k_n, e.k_t, e.k_n, e.k_t], |k, [k_n, k_t, ..]| part[at(k)].stiffness = [k_n, k_t]);
    }
}

impl Scene<'_> {
    /// How a point meets its body. Normal from the body to the ghost; without an overlap they are apart.
    #[inline(always)]
    fn meeting<L: Law>(&self, ghost: &Ghost, &Spot { at, carried }: &Spot) -> ContactGeometry {
        let body = ghost.place[0] as usize;
        let at = ahead(at, carried, self.ahead[1]);
        let m_eff = |inverse_mass: f64| if L::VISCOUS { 1.0 / (inverse_mass + 1.0 / ghost.mass) } else { 0.0 };
        match ghost.body {
            Body::Grain(_) => {
                let (p, v, w) = (self.grains.pos[body], self.grains.vel[body], self.grains.spin[body]);
                let (v3, w3) = ([v[0], v[1], v[2]], [w[0], w[1], w[2]]);
                let d = less(at, ahead(p, v3, self.ahead[0]));
                let distance = dot(d, d).sqrt();
                let reach = p[3] + ghost.radius;
                let motion = RelativeMotion {
                    centres: less(v3, carried),
                    turning: scaled(w3, p[3]),
                    mean_spin: scaled(w3, 0.5),
                    spin_difference: w3,
                };
                let (normal, r_eff) = (scaled(d, 1.0 / distance), p[3] * ghost.radius / reach);
                ContactGeometry { normal, overlap: reach - distance, r_eff, m_eff: m_eff(v[3]), motion }
            }
            Body::Wall(_) => {
                let wall = &self.walls[body];
                let [x, y, z] = at;
                let (towards, gap) = wall.shape.towards([x, y, z, ghost.radius]);
                let normal = scaled(towards, -1.0);
                let centres = less(scaled(normal, wall.speed), carried);
                let overlap = wall.speed * self.ahead[0] - gap;
                ContactGeometry {
                    normal,
                    overlap,
                    r_eff: ghost.radius,
                    m_eff: m_eff(0.0),
                    motion: RelativeMotion { centres, ..RelativeMotion::default() },
                }
            }
        }
    }

    /// The contact's parameters.
    #[inline(always)]
    fn pair(&self, ghost: &Ghost) -> &Pair {
        match ghost.body {
            Body::Grain(_) => self.table.of_grain(ghost.law, self.grains.material[ghost.place[0] as usize]),
            Body::Wall(k) => self.table.of_wall(ghost.law, k as usize),
        }
    }
}

impl Ghost {
    #[inline(always)]
    fn memory<L: Law>(&self) -> ContactHistory {
        ContactHistory {
            touch: self.touch,
            spring: L::VISCOUS.then_some(self.spring),
            rolling: None,
            load: None,
            largest: None,
            work: None,
        }
    }

    #[inline(always)]
    fn keep(&mut self, new: ContactHistory) {
        self.touch = new.touch;
        self.spring = new.spring.unwrap_or_default();
    }
}

#[inline(always)]
fn ahead(p: [f64; 4], v: [f64; 3], by: f64) -> [f64; 3] {
    std::array::from_fn(|a| p[a] + v[a] * by)
}
