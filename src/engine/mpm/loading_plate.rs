//! Loading plates: rigid planes, and upright cylindrical shells, that press on material points by contacts as on grains (Li et al. 2023, section 2.3).
//! A plate can so stand anywhere between two nodes of the grid.
//!
//! A point touches a plate as a sphere, its ghost, with (1 − n) V = 4/3 π r³ (eq. 22), where n is the porosity and V the volume of the point. (1 − n) V is
//! the volume of solids, which does not change, so r is a constant of the point. The force is that of Hertz for a sphere on a rigid plane,
//! F = 4/3 E* √r δ^{3/2} with the overlap δ (eqs 18, 20 with infinite radius and modulus of the plane), without friction. In plane strain the ghost is a
//! disc, (1 − n) V = π r² with V per metre of thickness, and stands for a row of touching spheres of radius r, 1/(2r) of them per metre.
//!
//! Li et al. spread the force from the centre of the point to the nodes (eq. 29). Here the force acts on the *face* of the point, where the material ends.
//! Then a uniform stress is in equilibrium up to the face. With the force at the centre the outermost points carry only a part of the stress, and
//! moduli are too high by half a point's edge over the specimen's length at each end. From the first touch on the face is moved with the
//! nodes' velocities ([`super::Points::faces`]), and the ghost keeps its distance from the face inside of the material. So planes must stand across the
//! axes, and points in a shell must be in rings; each component of a shell's force acts on the face across its own axis.

use super::{Continuum, Dimension, Points, Settings};
use crate::check::{self, Checked, ensure};
use crate::error::{Error, Result};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A loading plate with its motion, and the sums over its contacts at the last call of [`press`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoadingPlate {
    /// A point on the plane, m; of a shell a point of its axis.
    pub point: [f64; 3],
    /// Unit normal of the plane, towards the material; zero for a shell.
    pub normal: [f64; 3],
    /// Radius, m, if the plate is an upright shell around the material; `None`: a plane.
    pub radius: Option<f64>,
    /// Speed, m/s, positive into the material.
    pub speed: f64,
    /// Effective modulus E* of the contacts with points, Pa.
    pub modulus: f64,
    /// Sum of the normal forces of the points, N (per metre in plane strain), positive in compression.
    pub reaction: f64,
    /// Sum of the tangent stiffnesses of the contacts, N/m.
    pub stiffness: f64,
    /// Elastic energy of the contacts, J.
    pub stored: f64,
    /// Work of the plate on the points so far, J, by the trapezium rule over every step.
    pub work: f64,
    /// Largest tangent stiffness over mass of a point in contact, 1/s², which bounds the time step ([`super::with_plates`]).
    pub rate: f64,
    /// Force, N, and tangent stiffness, N/m, of the grains on the plate, if there are grains; set by the caller.
    pub others: [f64; 2],
    /// Number of points in contact.
    pub touching: u64,
    /// Largest ghost radius of all points, m.
    reach: f64,
    /// Distance by which the plate has moved into the material since contact forces were last computed, m.
    pub moved: f64,
    /// Points in contact, in the order of identities.
    #[serde(skip)]
    contacts: Vec<PlateContact>,
    /// Indices of points that have ceased to be in contact.
    #[serde(skip)]
    left: Vec<u32>,
}

/// A point in contact with a plate: identity, index, overlap, m, ghost radius, m, tangent stiffness, N/m, unit normal into the material.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlateContact {
    id: u32,
    index: u32,
    overlap: f64,
    radius: f64,
    tangent: f64,
    normal: [f64; 3],
}

/// Computes the contact forces of all plates, adds them to the points for the next step, and sums reactions, energy and work of each plate. Contacts are
/// found in parallel over plates; sums are taken one plate after the other.
///
/// # Errors
/// A plate that has passed the centre of a point.
pub fn press(plates: &mut [LoadingPlate], continuum: &mut Continuum) -> Result<()> {
    let points = &*continuum;
    plates.par_iter_mut().for_each(|plate| plate.find_contacts(points));
    plates.iter_mut().try_for_each(|plate| plate.apply_forces(continuum))
}

/// Ghost radius, m, of a point with the volume of solids `solid`, m³ (Li et al. 2023, eq. 22); in plane strain the radius of a disc of area `solid`, m².
pub fn ghost_radius(dimension: Dimension, solid: f64) -> f64 {
    match dimension {
        Dimension::Space => cube_root(solid * (0.75 / PI)),
        Dimension::PlaneStrain => (solid / PI).sqrt(),
    }
}

/// Overlap, m, of a point of ghost radius `radius`, m, with a plate of modulus `modulus`, Pa, under the force `force`, N: the inverse of Hertz's law.
pub fn overlap(dimension: Dimension, modulus: f64, radius: f64, force: f64) -> f64 {
    let coefficient = 4.0 / 3.0 * modulus * radius.sqrt() * row(dimension, radius);
    let root = cube_root(force / coefficient);
    root * root
}

/// Number of spheres that a ghost stands for: one, or in plane strain a row of 1/(2r) per metre.
fn row(dimension: Dimension, radius: f64) -> f64 {
    if dimension == Dimension::Space { 1.0 } else { 0.5 / radius }
}

/// Cube root from + − × ÷ alone, with the same bits on every machine; 0 for a number that is not positive and normal.
pub(super) fn cube_root(x: f64) -> f64 {
    if !(x.is_normal() && x > 0.0) {
        return 0.0;
    }
    // start with a third of the exponent; each step of Halley's method triples the number of correct digits
    let mut y = f64::from_bits(x.to_bits() / 3 + 0x2A9F_7893_782D_A1CE);
    for _ in 0..4 {
        let cube = y * y * y;
        y *= (cube + 2.0 * x) / (2.0 * cube + x);
    }
    y
}

/// Error: a plate has passed the centre of point `id`.
pub fn passed(step: u64, id: u32) -> Error {
    let what = format!("a platen has passed point {id}: its speed or the time step is too large, or the material too soft for it");
    Error::Unstable { step, what, grain: None }
}

impl LoadingPlate {
    /// A plane at rest with a point and a unit normal towards the material, for the points of `continuum`; `modulus`: E* of its contacts, Pa.
    pub fn new(continuum: &Continuum, point: [f64; 3], normal: [f64; 3], modulus: f64) -> LoadingPlate {
        let points = continuum.points();
        let most = (0..points.len()).map(|i| points.solid(i)).fold(0.0, f64::max);
        LoadingPlate {
            point,
            normal,
            radius: None,
            speed: 0.0,
            modulus,
            reaction: 0.0,
            stiffness: 0.0,
            stored: 0.0,
            work: 0.0,
            rate: 0.0,
            others: [0.0; 2],
            touching: 0,
            reach: ghost_radius(continuum.settings().dimension, most),
            moved: 0.0,
            contacts: Vec::new(),
            left: Vec::new(),
        }
    }

    /// A shell at rest around the upright axis through `point`, with its radius, m, and the modulus E* of its contacts, Pa.
    pub fn shell(continuum: &Continuum, point: [f64; 3], radius: f64, modulus: f64) -> LoadingPlate {
        LoadingPlate { radius: Some(radius), ..LoadingPlate::new(continuum, point, [0.0; 3], modulus) }
    }

    /// Checks the plate, which has moved since it was `made`.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, made: &LoadingPlate) -> Checked {
        let same = self.normal == made.normal && self.modulus == made.modulus && self.reach == made.reach;
        ensure(same && self.radius.is_some() == made.radius.is_some(), || "a platen is not that of the scene".into())?;
        check::positive("radii of platens", self.radius)?;
        let single = [self.speed, self.reaction, self.stiffness, self.stored, self.work, self.moved];
        check::numbers("platens", self.point.into_iter().chain(self.others).chain(single))?;
        check::not_negative("stiffnesses of platens", [self.rate])
    }

    /// Distance of a position from the surface of the plate, m (negative behind it), and the unit normal there, into the material.
    pub fn height(&self, p: [f64; 4]) -> (f64, [f64; 3]) {
        let d: [f64; 3] = std::array::from_fn(|a| p[a] - self.point[a]);
        let Some(radius) = self.radius else {
            let [nx, ny, nz] = self.normal;
            return (nx * d[0] + ny * d[1] + nz * d[2], self.normal);
        };
        let rho = (d[0] * d[0] + d[1] * d[1]).sqrt();
        let inverse = if rho > 0.0 { -1.0 / rho } else { 0.0 };
        (radius - rho, [d[0] * inverse, d[1] * inverse, 0.0])
    }

    /// Index of the axis along which the normal points; 0 for a shell.
    pub fn axis(&self) -> usize {
        (0..3).find(|&a| self.normal[a] != 0.0).unwrap_or(0)
    }

    /// Adds the forces of the contacts to the points for the next step and sums them in the order of identities. Nothing is done if the plate has passed a
    /// point.
    fn apply_forces(&mut self, continuum: &mut Continuum) -> Result<()> {
        if let Some(contact) = self.contacts.iter().find(|c| c.overlap > c.radius) {
            return Err(passed(continuum.steps(), contact.id));
        }
        for &index in &self.left {
            let at = continuum.points().position[index as usize];
            continuum.release_face(index as usize, self.height(at).1);
        }
        let before = self.reaction;
        (self.reaction, self.stiffness, self.stored, self.rate) = (0.0, 0.0, 0.0, 0.0);
        for &PlateContact { index, overlap, tangent, normal, .. } in &self.contacts {
            let force = 2.0 / 3.0 * tangent * overlap;
            self.reaction += force;
            self.stiffness += tangent;
            self.stored += 0.4 * force * overlap;
            self.rate = self.rate.max(tangent / continuum.points().velocity[index as usize][3]);
            continuum.add_face_force(index as usize, force, normal, tangent);
        }
        self.touching = self.contacts.len() as u64;
        self.work += 0.5 * (before + self.reaction) * self.moved;
        self.moved = 0.0;
        Ok(())
    }

    /// Position of the ghost of a point, m, at its constant distance from the followed face if there is one; and whether a face is followed.
    fn ghost(&self, points: &Points, index: usize, dimension: Dimension) -> ([f64; 4], bool) {
        let (mut place, mut followed) = (points.position[index], false);
        if let Some([beside, face]) = points.faces.get(index) {
            let normal = self.height(place).1;
            for a in (0..3).filter(|&a| beside[a] * normal[a] < 0.0) {
                (place[a], followed) = (face[a] + normal[a] * points.half_edge(index, dimension), true);
            }
        }
        (place, followed)
    }

    /// Finds the points in contact, in the order of identities.
    fn find_contacts(&mut self, continuum: &Continuum) {
        let (points, dimension) = (continuum.points(), continuum.settings().dimension);
        let (mut contacts, mut left) = (std::mem::take(&mut self.contacts), std::mem::take(&mut self.left));
        contacts.clear();
        left.clear();
        continuum.visit(self.vicinity(continuum), |index| {
            let radius = ghost_radius(dimension, points.solid(index));
            let (ghost, followed) = self.ghost(points, index, dimension);
            let (height, normal) = self.height(ghost);
            let overlap = radius - height;
            if height < self.reach && overlap > 0.0 {
                let tangent = 2.0 * self.modulus * (radius * overlap).sqrt() * row(dimension, radius);
                let (id, index) = (points.id[index], index as u32);
                contacts.push(PlateContact { id, index, overlap, radius, tangent, normal });
            } else if followed && self.height(points.position[index]).0 >= radius {
                left.push(index as u32);
            }
        });
        contacts.sort_unstable_by_key(|c| c.id);
        (self.contacts, self.left) = (contacts, left);
    }

    /// Corners of a box that holds all points that may be in contact, m: the domain, for a plane across an axis only its part behind the plate and within reach.
    fn vicinity(&self, continuum: &Continuum) -> [[f64; 3]; 2] {
        let Settings { lower, cells, cell, .. } = continuum.settings();
        let mut corners = [*lower, std::array::from_fn(|a| lower[a] + f64::from(cells[a]) * cell)];
        let axis = self.axis();
        if self.normal[axis].abs() == 1.0 {
            let before = self.point[axis] + self.reach * self.normal[axis];
            corners[usize::from(self.normal[axis] > 0.0)][axis] = before;
        }
        corners
    }

    /// Normal force of points and grains on the plate, N, positive in compression.
    pub fn force(&self) -> f64 {
        self.reaction + self.others[0]
    }

    /// Moves the plate at its speed for `dt` seconds.
    pub fn advance(&mut self, dt: f64) {
        let step = self.speed * dt;
        self.moved += step;
        self.shift(step);
    }

    /// Moves the plate by `step` into the material, m.
    fn shift(&mut self, step: f64) {
        for (x, n) in self.point.iter_mut().zip(self.normal) {
            *x += step * n;
        }
        if let Some(radius) = &mut self.radius {
            *radius -= step;
        }
    }

    /// Takes back the motion since contact forces were last computed.
    #[cfg(feature = "gpu")]
    pub fn withdraw(&mut self) {
        self.shift(-self.moved);
        self.moved = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cube_roots_are_those_of_the_library() {
        for x in [1e-18, 3.7e-9, 0.125, 1.0, 2.0, 5.5e7, 1e20] {
            assert!((cube_root(x) / x.cbrt() - 1.0).abs() < 4e-16, "{x}");
        }
        assert_eq!((cube_root(0.0), cube_root(-1.0)), (0.0, 0.0));
    }

    /// Only points near a plane are looked at: the same contacts as from a look at all of them.
    #[test]
    fn a_plane_finds_every_point_that_it_touches() {
        use crate::mpm::law::{Elastic, Law};
        use crate::mpm::{Continuum, GridWall, Point, Points, ShapeFunctions, Transfer};
        let settings = Settings {
            dimension: Dimension::Space,
            cell: 0.1,
            lower: [-0.3, 0.2, 0.0],
            cells: [14; 3],
            walls: [GridWall::Open; 6],
            gravity: [0.0; 3],
            shape: ShapeFunctions::BSpline,
            transfer: Transfer::Blend { pic: 0.0 },
            damping: 0.0,
        };
        let mut points = Points::default();
        for k in 0..1000 {
            let at = [k % 10, k / 10 % 10, k / 100].map(|n: i32| 0.05 * f64::from(n));
            points.add(&Point {
                position: [at[0], 0.5 + at[1], 0.3 + at[2]],
                velocity: [0.1, -0.2, 0.3],
                mass: 0.2,
                volume: 1.25e-4,
                stress: [0.0; 6],
                porosity: 0.4,
                law: 0,
            });
        }
        let mut c = Continuum::new(settings, vec![Law::Elastic(Elastic::of_young(1e6, 0.3))], points).unwrap();
        for sorted in [false, true] {
            if sorted {
                c.step(1e-4).unwrap();
            }
            let [low, high] = [[-0.01, 0.49, 0.29], [0.46, 0.96, 0.76]];
            for axis in 0..3 {
                for (corner, sign) in [(low, 1.0), (high, -1.0)] {
                    let normal = std::array::from_fn(|a| if a == axis { sign } else { 0.0 });
                    let mut plate = LoadingPlate::new(&c, corner, normal, 1e6);
                    plate.find_contacts(&c);
                    let mut all: Vec<u32> = (0..c.points().len())
                        .filter(|&i| plate.height(c.points().position[i]).0 < plate.reach)
                        .map(|i| c.points().id[i])
                        .collect();
                    all.sort_unstable();
                    assert!(all.len() >= 100, "{} points", all.len());
                    assert_eq!(plate.contacts.iter().map(|c| c.id).collect::<Vec<u32>>(), all);
                }
            }
        }
    }

    #[test]
    fn an_overlap_gives_its_force_back() {
        let (modulus, radius, force) = (8e8, 2e-3, 1.3);
        let d = overlap(Dimension::Space, modulus, radius, force);
        assert!((4.0 / 3.0 * modulus * radius.sqrt() * d.powf(1.5) / force - 1.0).abs() < 1e-12);
        let r = ghost_radius(Dimension::Space, 4.0 / 3.0 * PI * 8.0);
        assert!((r - 2.0).abs() < 1e-15);
        assert!((ghost_radius(Dimension::PlaneStrain, PI * 9.0) - 3.0).abs() < 1e-15);
    }
}
