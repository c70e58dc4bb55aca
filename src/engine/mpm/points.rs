//! The arrays of material points: one entry per point.
//!
//! The index of a point changes when points cross cells; its identity [`Points::id`] never does. Sums over points for records are taken in the order of
//! identities.

use super::Dimension;
use super::law::{InternalVariables, Sym};
use super::loading_plate::cube_root;
use serde::{Deserialize, Serialize};

/// A new point, for [`Points::add`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Position, m. In plane strain the third coordinate is stored but not used.
    pub position: [f64; 3],
    /// Velocity, m/s.
    pub velocity: [f64; 3],
    /// Mass, kg (in plane strain per metre of thickness).
    pub mass: f64,
    /// Volume, m³ (in plane strain per metre of thickness).
    pub volume: f64,
    /// Cauchy stress, Pa, tension positive.
    pub stress: Sym,
    /// Volume of pores over total volume; 0 for a material without pores.
    pub porosity: f64,
    /// Index of the constitutive law.
    pub law: u8,
}

/// Faces of a point, see [`Points::faces`]: distances of the faces from the point, then coordinates of the faces, m, each along x, y, z.
pub type Face = [[f64; 3]; 2];

/// State of all points.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Points {
    /// Position x, y, z, m; lane 3: present volume, m³.
    pub position: Vec<[f64; 4]>,
    /// Velocity x, y, z, m/s, of the last half step; lane 3: mass, kg.
    pub velocity: Vec<[f64; 4]>,
    /// Cauchy stress, Pa, tension positive.
    pub stress: Vec<Sym>,
    /// Internal variables of the constitutive law.
    pub memory: Vec<InternalVariables>,
    /// Volume at the start, m³.
    pub initial_volume: Vec<f64>,
    /// Porosity at the start.
    pub initial_porosity: Vec<f64>,
    /// Velocity gradient around the point with APIC: columns ∂v/∂x, ∂v/∂y, ∂v/∂z, 1/s; empty without APIC.
    pub affine: Vec<[[f64; 3]; 3]>,
    /// Velocity with which the nodes moved the point in its last step, m/s; with FLIP it differs from `velocity`. Empty unless
    /// [`super::Continuum::keep_transport_velocity`] was called.
    pub transport_velocity: Vec<[f64; 3]>,
    /// Faces of the point on which loading plates press, across x, y, z: distance of the face from the point along the axis, m (0: nothing presses there),
    /// and coordinate of the face, m, moved with the nodes since it was first touched. Empty unless loading plates press.
    pub faces: Vec<Face>,
    /// Index of the constitutive law.
    pub law: Vec<u8>,
    /// Identity of the point, given in the order of creation.
    pub id: Vec<u32>,
    /// Identity that the next new point gets.
    pub next_id: u32,
}

impl Points {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Adds a point; returns its identity.
    pub fn add(&mut self, point: &Point) -> u32 {
        let ([x, y, z], [u, v, w]) = (point.position, point.velocity);
        let id = self.next_id;
        self.position.push([x, y, z, point.volume]);
        self.velocity.push([u, v, w, point.mass]);
        self.stress.push(point.stress);
        self.memory.push(InternalVariables::default());
        self.initial_volume.push(point.volume);
        self.initial_porosity.push(point.porosity);
        self.law.push(point.law);
        self.id.push(id);
        self.next_id += 1;
        id
    }

    /// Removes the points that are marked, before a run begins; the others get new identities from 0 on.
    pub fn drop_those(&mut self, gone: &[bool]) {
        self.remove(gone);
        self.id = (0..self.position.len() as u32).collect();
        self.next_id = self.id.len() as u32;
    }

    /// Removes the points that are marked; the others keep their identities.
    pub fn remove(&mut self, gone: &[bool]) {
        fn kept<T: Copy>(values: &mut Vec<T>, gone: &[bool]) {
            let mut gone = gone.iter();
            values.retain(|_| !gone.next().copied().unwrap_or(false));
        }
        kept(&mut self.position, gone);
        kept(&mut self.velocity, gone);
        kept(&mut self.stress, gone);
        kept(&mut self.memory, gone);
        kept(&mut self.initial_volume, gone);
        kept(&mut self.initial_porosity, gone);
        kept(&mut self.affine, gone);
        kept(&mut self.transport_velocity, gone);
        kept(&mut self.faces, gone);
        kept(&mut self.law, gone);
        kept(&mut self.id, gone);
    }

    /// Density of point `i`: mass over present volume, kg/m³.
    pub fn density(&self, i: usize) -> f64 {
        self.velocity[i][3] / self.position[i][3]
    }

    /// Volume of solids of point `i`, m³, which does not change.
    pub fn solid(&self, i: usize) -> f64 {
        (1.0 - self.initial_porosity[i]) * self.initial_volume[i]
    }

    /// Half of the edge of the cube (square) that point `i` fills at the start, m.
    pub fn half_edge(&self, i: usize, dimension: Dimension) -> f64 {
        let volume = self.initial_volume[i];
        0.5 * if dimension == Dimension::Space { cube_root(volume) } else { volume.sqrt() }
    }

    /// Present porosity of point `i`, from its constant volume of solids (1 − n₀) V₀.
    pub fn porosity(&self, i: usize) -> f64 {
        1.0 - self.solid(i) / self.position[i][3]
    }

    /// Indices of all points in the order of identities.
    pub fn by_id(&self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.len() as u32).collect();
        order.sort_unstable_by_key(|&i| self.id[i as usize]);
        order
    }

    /// Memory in use, bytes.
    pub fn bytes(&self) -> usize {
        use std::mem::size_of;
        let vectors = (self.position.capacity() + self.velocity.capacity()) * size_of::<[f64; 4]>();
        let scalars = (self.initial_volume.capacity() + self.initial_porosity.capacity()) * size_of::<f64>();
        let affine = self.affine.capacity() * size_of::<[[f64; 3]; 3]>();
        vectors
            + scalars
            + affine
            + self.transport_velocity.capacity() * size_of::<[f64; 3]>()
            + self.faces.capacity() * size_of::<Face>()
            + self.stress.capacity() * size_of::<Sym>()
            + self.memory.capacity() * size_of::<InternalVariables>()
            + self.law.capacity()
            + self.id.capacity() * size_of::<u32>()
    }
}
