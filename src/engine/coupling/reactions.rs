//! Adds the forces of point contacts to grains and points; energy of the contacts and their bound on the time step.

use super::evaluate::PointContactScene;
use super::{Body, PointContact, PointContacts};
use crate::contact::pairs::ContactForce;
use crate::grains::Grains;
use crate::math::vector::{cross, dot, less, scaled};
use crate::mpm::Continuum;
use crate::point_contacts::{ActsOn, ContactRates, GhostFace};

impl PointContact {
    /// Elastic energy of the contact, J: `energy_factor` times normal force times overlap, and the energy of the tangential spring.
    pub(super) fn energy(&self, energy_factor: f64) -> f64 {
        let t = if self.spring == [0.0; 3] { self.touch.tangential } else { self.spring };
        let [k_n, k_t] = self.stiffness;
        if k_n > 0.0 { energy_factor * self.touch.normal_force * self.touch.overlap + 0.5 * dot(t, t) / k_t } else { 0.0 }
    }

    /// max(2 k_n, 7 k_t), N/m: its part in the bound on the inertial mass of a grain ([`crate::dem::stability`]).
    pub(super) fn inertia_stiffness(&self) -> f64 {
        let [k_n, k_t] = self.stiffness;
        (2.0 * k_n).max(7.0 * k_t)
    }

    /// From the centre of the point to where the force acts on it, m ([`crate::point_contacts::GhostFace::offset`]); `cell`: edge of a cell, m.
    pub(super) fn offset(&self, cell: f64) -> [f64; 3] {
        self.face.map_or([0.0; 3], |face| face.offset(self.radius, self.touch.overlap, cell))
    }

    /// Force of the point on the grain or wall, N.
    pub fn force(&self) -> [f64; 3] {
        self.touch.force()
    }
}

impl PointContacts {
    /// Moves the faces of the points with the nodes, after a step of the continuum of `dt` seconds. In parallel over contacts.
    pub(super) fn follow_faces(&mut self, continuum: &Continuum, dt: f64) {
        self.locate_points(continuum);
        let of_points = |c: &mut PointContact| {
            let (place, own) = (c.place[1] as usize, [c.radius, c.touch.overlap]);
            if let Some(face) = &mut c.face {
                face.follow(continuum, place, own, dt);
            }
        };
        self.candidates.change_each(of_points);
    }

    /// Adds `of_grains` times force and torque of each contact to `external_forces` (force, N, and torque, N m, by index of the grain), and `of_points`
    /// times the opposite force, with `stiff` times the larger tangent stiffness, to the faces of the points, or to
    /// their centres. Contacts are taken in the order of
    /// the list.
    pub(super) fn apply_reactions(
        &self,
        grains: &Grains,
        external_forces: &mut Vec<[[f64; 4]; 2]>,
        of_grains: f64,
        (continuum, acts_on): (&mut Continuum, ActsOn),
        [of_points, stiff]: [f64; 2],
    ) {
        external_forces.resize(grains.len(), [[0.0; 4]; 2]);
        for contact in self.touching() {
            let ([body, point], force) = (contact.place.map(|p| p as usize), contact.touch.force());
            let [k_n, k_t] = contact.stiffness;
            let (push, stiffness) = (force.map(|f| -(of_points * f)), stiff * k_n.max(k_t));
            GhostFace::push((acts_on, contact.face), [contact.radius, contact.touch.overlap], continuum, point, push, stiffness);
            if let Body::Grain(_) = contact.body {
                let torque = torque(&contact.touch, grains.radius(body));
                for a in 0..3 {
                    external_forces[body][0][a] += of_grains * force[a];
                    external_forces[body][1][a] += of_grains * torque[a];
                }
            }
        }
    }

    /// Lowers the overlaps without force by sliding: over a sliding distance of `strain` ghost diameters such an overlap falls to 1/e. Returns the elastic
    /// energy that contacts gain by it, J.
    pub(super) fn release(&mut self, scene: &PointContactScene<'_>, strain: f64) -> f64 {
        let mut energy = 0.0;
        self.candidates.change(|contact| {
            if contact.reference == 0.0 || contact.reference == f64::INFINITY {
                return;
            }
            let [body, point] = contact.place.map(|p| p as usize);
            let of_body = match contact.body {
                Body::Grain(_) => [0, 1, 2].map(|a| scene.grains.vel[body][a]),
                Body::Wall(_) => scaled(contact.touch.normal, scene.walls[body].speed),
            };
            let of_point = contact.face.map_or(scene.continuum.points().transport_velocity[point], |face| face.velocity);
            let past = less(of_body, of_point);
            let slid = dot(past, past).sqrt() * scene.dt / (2.0 * contact.radius);
            let released = contact.reference * (slid / strain).min(1.0);
            contact.reference -= released;
            energy += contact.touch.normal_force * released;
        });
        energy
    }

    /// Contacts that touch, in the order of the list.
    pub fn touching(&self) -> impl Iterator<Item = &PointContact> {
        self.candidates.touching()
    }

    /// Contacts of points with grains that touch, in the order of the list: index of the grain, index of the point, ghost radius, m, and contact force.
    pub fn on_grains(&self) -> impl Iterator<Item = (usize, usize, f64, ContactForce)> {
        let on_grain = self.touching().filter(|g| matches!(g.body, Body::Grain(_)));
        on_grain.map(|g| (g.place[0] as usize, g.place[1] as usize, g.radius, g.touch))
    }

    /// Elastic energy of all contacts, J; `energy_factor` as in [`PointContact::energy`].
    pub(super) fn stored(&self, energy_factor: f64) -> f64 {
        self.touching().map(|contact| contact.energy(energy_factor)).sum()
    }

    /// Normal force of the points on wall `k`, N.
    pub fn reaction(&self, k: usize) -> f64 {
        self.touching().filter(|g| g.body == Body::Wall(k as u32)).map(|g| g.touch.normal_force).sum()
    }

    /// Adds the normal forces of the points on the walls, N, and the stiffnesses of these contacts, N/m, to `sums`, one for each wall.
    pub fn add_wall_forces(&self, sums: &mut [[f64; 2]]) {
        for contact in self.touching() {
            if let Body::Wall(k) = contact.body {
                let [force, stiffness] = &mut sums[k as usize];
                (*force, *stiffness) = (*force + contact.touch.normal_force, *stiffness + contact.stiffness[0]);
            }
        }
    }

    /// Largest sums of stiffness over mass of a point and of a grain over the present contacts. `sums` are buffers of zeros, and are left as such.
    pub(super) fn rates(&self, grains: &Grains, sums: &mut [Vec<f64>; 2], points: usize) -> ContactRates {
        let mut most = ContactRates::default();
        let [of_points, of_grains] = sums;
        of_points.resize(points, 0.0);
        of_grains.resize(grains.len(), 0.0);
        for contact in self.touching() {
            let ([k_n, k_t], [body, point]) = (contact.stiffness, contact.place.map(|p| p as usize));
            of_points[point] += k_n.max(k_t) / contact.mass;
            most.points = most.points.max(of_points[point]);
            if let Body::Grain(_) = contact.body {
                of_grains[body] += k_n.max(3.5 * k_t) * grains.vel[body][3];
                most.grains = most.grains.max(of_grains[body]);
            }
        }
        // zeros again, where the sums were changed
        for contact in self.touching() {
            of_points[contact.place[1] as usize] = 0.0;
            if let Body::Grain(_) = contact.body {
                of_grains[contact.place[0] as usize] = 0.0;
            }
        }
        most
    }
}

/// Torque on a grain, N m: (r − δ/2) n × t with the grain's radius r, the overlap δ, the normal n and the tangential force t (Li et al. 2023, eq. 27, with
/// the grain's own radius).
fn torque(touch: &ContactForce, radius: f64) -> [f64; 3] {
    scaled(cross(touch.normal, touch.tangential), radius - 0.5 * touch.overlap)
}
