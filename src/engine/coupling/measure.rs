//! Measures of a mixture for records: shares of the stress, contacts, energies.

use super::{Body, Mixture};
use crate::contact::fabric::Fabric;
use crate::dem::State;
use crate::mpm::Continuum;
use serde::{Deserialize, Serialize};

/// Parts of the mean stress of a volume: normal stresses along x, y, z, Pa, compression positive. In equilibrium their sum is the stress on the sides of
/// the volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shares {
    /// Stress of the material points, Σ σ V over the volume.
    pub matrix: [f64; 3],
    /// Love–Weber stress of the contacts of grains with each other and with loading plates.
    pub skeleton: [f64; 3],
    /// Love–Weber stress of the contacts of grains with points.
    pub interface: [f64; 3],
}

impl Shares {
    /// Sum of the three parts along an axis, Pa.
    pub fn total(&self, axis: usize) -> f64 {
        self.matrix[axis] + self.skeleton[axis] + self.interface[axis]
    }

    /// Mean of two sets of parts.
    pub fn midway(self, to: Shares) -> Shares {
        let mid = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
        Shares {
            matrix: mid(self.matrix, to.matrix),
            skeleton: mid(self.skeleton, to.skeleton),
            interface: mid(self.interface, to.interface),
        }
    }
}

/// Numbers of contacts, and fabric. Rigid bodies that are no spheres count as grains; two bodies that touch at several places are one contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touching {
    /// Number of contacts between grains.
    pub grains: u64,
    /// Number of contacts of grains with walls.
    pub walls: u64,
    /// Number of contacts of points with grains and walls.
    pub points: u64,
    /// Fabric tensor of the contacts between grains: xx, yy, zz, xy, yz, zx; zeros without contacts. Of two bodies each place where they touch counts.
    pub fabric: [f64; 6],
}

impl Mixture {
    /// Parts of the mean stress of `volume`, m³, which holds all points, grains and rigid bodies.
    pub fn shares(&self, continuum: &Continuum, volume: f64) -> Shares {
        let (g, points, mut shares) = (&self.grains.grains, continuum.points(), Shares::default());
        for i in points.by_id().into_iter().map(|i| i as usize) {
            for (sum, s) in shares.matrix.iter_mut().zip(points.stress[i]) {
                *sum -= s * points.position[i][3] / volume;
            }
        }
        let add = |sums: &mut [f64; 3], force: [f64; 3], branch: [f64; 3]| {
            for a in 0..3 {
                sums[a] -= force[a] * branch[a] / volume;
            }
        };
        let id = |i: u32| g.id[i as usize];
        for s in self.grains.pairs.touching(|[i, j]| [id(i), id(j)]) {
            let [p, q] = self.grains.pairs.ends[s].map(|i| g.pos[i as usize]);
            add(&mut shares.skeleton, self.grains.pairs.touch[s].force(), std::array::from_fn(|a| q[a] - p[a]));
        }
        for s in self.grains.wall_pairs.touching(|[i, k]| [k, id(i)]) {
            let touch = &self.grains.wall_pairs.touch[s];
            let arm = g.radius(self.grains.wall_pairs.ends[s][0] as usize) - touch.overlap;
            add(&mut shares.skeleton, touch.force(), touch.normal.map(|n| n * arm));
        }
        for contact in self.point_contacts.touching().filter(|contact| matches!(contact.body, Body::Grain(_))) {
            let [p, q] = [g.pos[contact.place[0] as usize], points.position[contact.place[1] as usize]];
            let offset = contact.offset(continuum.settings().cell);
            add(&mut shares.interface, contact.force(), std::array::from_fn(|a| q[a] + offset[a] - p[a]));
        }
        if let Some(blocks) = &self.blocks {
            blocks.branches(g, continuum, |of_point, force, branch| {
                add(if of_point { &mut shares.interface } else { &mut shares.skeleton }, force, branch);
            });
        }
        shares
    }

    /// Numbers of contacts and fabric at this instant.
    pub fn touching(&self) -> Touching {
        let (g, pairs) = (&self.grains.grains, &self.grains.pairs);
        let id = |i: u32| g.id[i as usize];
        let between = pairs.touching(|[i, j]| [id(i), id(j)]);
        let mut fabric = Fabric::default();
        between.iter().for_each(|&s| fabric.add(pairs.touch[s].normal));
        let mut touching = Touching {
            grains: fabric.contacts,
            walls: self.grains.wall_pairs.touching(|[i, k]| [k, id(i)]).len() as u64,
            points: self.point_contacts.touching().count() as u64,
            fabric: [0.0; 6],
        };
        if let Some(blocks) = &self.blocks {
            let [grains, walls, points] = blocks.partners(|normal| fabric.add(normal));
            touching.grains += grains;
            touching.walls += walls;
            touching.points += points;
        }
        Touching { fabric: fabric.tensor(), ..touching }
    }

    /// Kinetic energy of grains and rigid bodies, their potential energy in gravity, and the elastic energy of their contacts, those with points included,
    /// J. Of tangential springs only those of point contacts and of contacts of rigid bodies are counted.
    pub fn energies(&self, gravity: [f64; 3]) -> [f64; 3] {
        let g = &self.grains.grains;
        let square = |v: [f64; 4]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        let [mut kinetic, mut potential, mut stored] = [0.0, 0.0, self.point_contacts.stored(self.energy_factor)];
        for i in g.by_id().into_iter().map(|i| i as usize) {
            let (p, m) = (g.pos[i], g.mass[i]);
            kinetic += 0.5 * m * (square(g.vel[i]) + 0.4 * p[3] * p[3] * square(g.spin[i]));
            potential -= m * (gravity[0] * p[0] + gravity[1] * p[1] + gravity[2] * p[2]);
        }
        let id = |i: u32| g.id[i as usize];
        let State { pairs, wall_pairs, .. } = &self.grains;
        for s in pairs.touching(|[i, j]| [id(i), id(j)]) {
            stored += self.energy_factor * pairs.touch[s].normal_force * pairs.touch[s].overlap;
        }
        for s in wall_pairs.touching(|[i, k]| [k, id(i)]) {
            stored += self.energy_factor * wall_pairs.touch[s].normal_force * wall_pairs.touch[s].overlap;
        }
        if let Some(blocks) = &self.blocks {
            let theirs = blocks.energies(gravity, self.energy_factor);
            return [kinetic + theirs[0], potential + theirs[1], stored + theirs[2]];
        }
        [kinetic, potential, stored]
    }
}
