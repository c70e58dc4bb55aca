//! The material points: a structure of arrays, one entry per point.
//!
//! A point's index changes when it crosses cells; its [`Points::id`] never does. What is summed over points for a record is summed in the
//! order of ids.

use super::Dimension;
use super::law::{InternalVariables, Sym};
use super::loading_plate::cube_root;
use serde::{Deserialize, Serialize};

/// A point as it is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Position, m. In plane strain the third coordinate is kept and never used.
    pub position: [f64; 3],
    /// Velocity, m/s.
    pub velocity: [f64; 3],
    /// Mass, kg, and volume, m³ (in plane strain: per metre of thickness).
    pub mass: f64,
    pub volume: f64,
    /// Cauchy stress, Pa, tension positive.
    pub stress: Sym,
    /// Pores per volume, 0 where that means nothing.
    pub porosity: f64,
    /// Index of the law.
    pub law: u8,
}

/// See [`Points::faces`]: distances, then places.
pub type Face = [[f64; 3]; 2];

/// State of all points.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Points {
    /// Position x, y, z, m, and current volume, m³.
    pub position: Vec<[f64; 4]>,
    /// Velocity, m/s, of the last half step, and mass, kg.
    pub velocity: Vec<[f64; 4]>,
    /// Cauchy stress, Pa, tension positive.
    pub stress: Vec<Sym>,
    /// What the law remembers.
    pub memory: Vec<InternalVariables>,
    /// Volume, m³, and porosity at the start.
    pub initial_volume: Vec<f64>,
    pub initial_porosity: Vec<f64>,
    /// Columns ∂v/∂x, ∂v/∂y, ∂v/∂z, 1/s, of the affine field around the point; empty without APIC.
    pub affine: Vec<[[f64; 3]; 3]>,
    /// Velocity, m/s, that carried the point in its last step (with FLIP not its own); empty unless something asks for it.
    pub transport_velocity: Vec<[f64; 3]>,
    /// Face of the point that a loading plate presses on, across each axis: how far it lies beside the point, m (0 where nothing presses), and where it is, m, moved
    /// along with the nodes since it was first touched; empty unless loading plates press.
    pub faces: Vec<Face>,
    /// Index of the law.
    pub law: Vec<u8>,
    /// Persistent identity, in order of creation.
    pub id: Vec<u32>,
    /// The identity that the next new point gets.
    pub next_id: u32,
}

impl Points {
    pub fn len(&self) -> usize {
        self.position.len()
    }

    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Adds a point; returns its id.
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

    /// Takes away the points that are marked, before a run begins: the others are counted anew.
    pub fn drop_those(&mut self, gone: &[bool]) {
        self.remove(gone);
        self.id = (0..self.position.len() as u32).collect();
        self.next_id = self.id.len() as u32;
    }

    /// Takes away the points that are marked.
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

    /// Mass over current volume, kg/m³.
    pub fn density(&self, i: usize) -> f64 {
        self.velocity[i][3] / self.position[i][3]
    }

    /// Solid volume, m³, which stays.
    pub fn solid(&self, i: usize) -> f64 {
        (1.0 - self.initial_porosity[i]) * self.initial_volume[i]
    }

    /// Half of the edge of what the point stands for at the start, m.
    pub fn half_edge(&self, i: usize, dimension: Dimension) -> f64 {
        let volume = self.initial_volume[i];
        0.5 * if dimension == Dimension::Space { cube_root(volume) } else { volume.sqrt() }
    }

    /// Current porosity: the solid volume (1 − n₀) V₀ stays.
    pub fn porosity(&self, i: usize) -> f64 {
        1.0 - self.solid(i) / self.position[i][3]
    }

    /// Indices in the order of ids.
    pub fn by_id(&self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.len() as u32).collect();
        order.sort_unstable_by_key(|&i| self.id[i as usize]);
        order
    }

    /// Bytes held.
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
