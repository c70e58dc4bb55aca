//! Force of every ghost contact, and who gets it.

use super::{Body, Bound, Ghost, GhostTable, Ghosts};
use crate::boundary::Wall;
use crate::contact::force::{self, Meeting, Memory, Motion, Rules, cross, dot, less, scaled};
use crate::contact::law::Law;
use crate::contact::pairs::Touch;
use crate::grains::Grains;
use crate::model::TangentialUnloading;
use crate::mpm::Continuum;
use crate::with_law;
use rayon::prelude::*;

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

impl Ghost {
    /// Elastic energy of its normal compression, so large a share of force times overlap, and of its tangential spring, J.
    pub(super) fn energy(&self, share: f64) -> f64 {
        let t = if self.spring == [0.0; 3] { self.touch.tangential } else { self.spring };
        let [k_n, k_t] = self.stiffness;
        if k_n > 0.0 { share * self.touch.normal_force * self.touch.overlap + 0.5 * dot(t, t) / k_t } else { 0.0 }
    }

    /// Force on the body, N.
    pub fn force(&self) -> [f64; 3] {
        self.touch.force()
    }
}

impl Ghosts {
    /// Finds the forces of this instant. Parallel over contacts; each writes only itself.
    pub(super) fn evaluate(&mut self, scene: &Scene<'_>) {
        let rules = Rules { dt: scene.dt, unloading: scene.unloading, task: TASK, arch: pulp::Arch::Scalar };
        with_law!(scene.table.law, L => {
            self.near.par_iter_mut().with_min_len(TASK).for_each(|ghost| contact::<L>(scene, &rules, ghost));
        });
    }

    /// Gives grains and points their shares of what the contacts bear, in the order of bodies and points.
    pub(super) fn give(
        &self,
        grains: &Grains,
        outside: &mut Vec<[[f64; 4]; 2]>,
        of_grains: f64,
        continuum: &mut Continuum,
        of_points: f64,
    ) {
        outside.resize(grains.len(), [[0.0; 4]; 2]);
        for ghost in self.touching() {
            let ([body, point], force) = (ghost.place.map(|p| p as usize), ghost.touch.force());
            continuum.push(point, force.map(|f| -(of_points * f)));
            if let Body::Grain(_) = ghost.body {
                let torque = torque(&ghost.touch, grains.pos[body][3]);
                for a in 0..3 {
                    outside[body][0][a] += of_grains * force[a];
                    outside[body][1][a] += of_grains * torque[a];
                }
            }
        }
    }

    /// The overlaps without force of contacts that have slid for `dt` seconds fall by 1/e in a way of `strain` ghost diameters; the elastic energy
    /// that they get by it, J.
    pub(super) fn release(&mut self, scene: &Scene<'_>, strain: f64) -> f64 {
        let mut energy = 0.0;
        for ghost in self.near.iter_mut().filter(|g| g.reference > 0.0 && g.reference < f64::INFINITY) {
            let [body, point] = ghost.place.map(|p| p as usize);
            let of_body = match ghost.body {
                Body::Grain(_) => [0, 1, 2].map(|a| scene.grains.vel[body][a]),
                Body::Wall(_) => scaled(ghost.touch.normal, scene.walls[body].speed),
            };
            let past = less(of_body, scene.continuum.points().carried[point]);
            let slid = dot(past, past).sqrt() * scene.dt / (2.0 * ghost.radius);
            let released = ghost.reference * (slid / strain).min(1.0);
            ghost.reference -= released;
            energy += ghost.touch.normal_force * released;
        }
        energy
    }

    /// Contacts that bear something, in order.
    pub fn touching(&self) -> impl Iterator<Item = &Ghost> {
        self.near.iter().filter(|g| g.touch.overlap > 0.0)
    }

    /// Elastic energy of all contacts, J.
    pub(super) fn stored(&self, share: f64) -> f64 {
        self.touching().map(|ghost| ghost.energy(share)).sum()
    }

    /// Normal force of the points on wall `k`, N.
    pub fn reaction(&self, k: usize) -> f64 {
        self.touching().filter(|g| g.body == Body::Wall(k as u32)).map(|g| g.touch.normal_force).sum()
    }

    /// What the contacts of this instant allow as a time step: the largest sum over a point, and over a grain.
    pub(super) fn bound(&self, grains: &Grains, sums: &mut [Vec<f64>; 2], points: usize) -> Bound {
        let mut most = Bound::default();
        let [of_points, of_grains] = sums;
        of_points.resize(points, 0.0);
        of_grains.resize(grains.len(), 0.0);
        for ghost in self.touching() {
            let ([k_n, k_t], [body, point]) = (ghost.stiffness, ghost.place.map(|p| p as usize));
            of_points[point] += k_n.max(k_t) / ghost.mass;
            most.points = most.points.max(of_points[point]);
            if let Body::Grain(_) = ghost.body {
                of_grains[body] += k_n.max(3.5 * k_t) * grains.vel[body][3];
                most.grains = most.grains.max(of_grains[body]);
            }
        }
        // empty again, and only where it was not
        for ghost in self.touching() {
            of_points[ghost.place[1] as usize] = 0.0;
            if let Body::Grain(_) = ghost.body {
                of_grains[ghost.place[0] as usize] = 0.0;
            }
        }
        most
    }
}

/// Torque on a grain of this radius: (r − δ/2) n × t (Li et al. 2023, eq. 27, with the grain's own radius).
fn torque(touch: &Touch, radius: f64) -> [f64; 3] {
    scaled(cross(touch.normal, touch.tangential), radius - 0.5 * touch.overlap)
}

fn contact<L: Law>(scene: &Scene<'_>, rules: &Rules, ghost: &mut Ghost) {
    let points = scene.continuum.points();
    let [body, point] = ghost.place.map(|p| p as usize);
    let carried = points.carried[point];
    let at = ahead(points.position[point], carried, scene.ahead[1]);
    // unit normal from body to ghost, overlap, R*, motion of the body against the ghost, inverse mass of the body, pair
    let (normal, mut overlap, r_eff, motion, inverse_mass, pair) = match ghost.body {
        Body::Grain(_) => {
            let (p, v, w) = (scene.grains.pos[body], scene.grains.vel[body], scene.grains.spin[body]);
            let (v3, w3) = ([v[0], v[1], v[2]], [w[0], w[1], w[2]]);
            let d = less(at, ahead(p, v3, scene.ahead[0]));
            let distance = dot(d, d).sqrt();
            let motion =
                Motion { centres: less(v3, carried), turning: scaled(w3, p[3]), mean_spin: scaled(w3, 0.5), spin_difference: w3 };
            let reach = p[3] + ghost.radius;
            let normal = scaled(d, 1.0 / distance);
            let r_eff = p[3] * ghost.radius / reach;
            (normal, reach - distance, r_eff, motion, v[3], scene.table.of_grain(ghost.law, scene.grains.material[body]))
        }
        Body::Wall(k) => {
            let wall = &scene.walls[body];
            let [x, y, z] = at;
            let (towards, gap) = wall.shape.towards([x, y, z, ghost.radius]);
            let normal = scaled(towards, -1.0);
            let (none, moving) = ([0.0; 3], scaled(normal, wall.speed));
            let overlap = wall.speed * scene.ahead[0] - gap;
            let motion = Motion { centres: less(moving, carried), turning: none, mean_spin: none, spin_difference: none };
            (normal, overlap, ghost.radius, motion, 0.0, scene.table.of_wall(ghost.law, k as usize))
        }
    };
    if ghost.reference > 0.0 {
        // lower where they have parted
        ghost.reference = ghost.reference.min(overlap.max(0.0));
        overlap -= ghost.reference;
    }
    let old = Memory { touch: ghost.touch, spring: L::VISCOUS.then_some(ghost.spring), rolling: None, load: None, work: None };
    if overlap > 0.0 {
        let m_eff = if L::VISCOUS { 1.0 / (inverse_mass + 1.0 / ghost.mass) } else { 0.0 };
        let meeting = Meeting { normal, overlap, r_eff, m_eff, motion };
        let new = force::touching::<f64, L, false, true>(&meeting, pair, rules, &old);
        let e = L::elastic(overlap, r_eff, pair);
        ghost.stiffness = [e.k_n, e.k_t];
        keep(ghost, new);
    } else if ghost.touch.overlap > 0.0 {
        ghost.stiffness = [0.0; 2];
        keep(ghost, force::apart::<false>(|| motion, rules.dt, &old));
    }
}

fn keep(ghost: &mut Ghost, new: Memory) {
    ghost.touch = new.touch;
    ghost.spring = new.spring.unwrap_or_default();
}

fn ahead(p: [f64; 4], v: [f64; 3], by: f64) -> [f64; 3] {
    std::array::from_fn(|a| p[a] + v[a] * by)
}
