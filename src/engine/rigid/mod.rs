//! Rigid bodies that are no spheres, beside grains, walls and material points: their motion, whom they touch, and what they bear.
//!
//! Everybody meets them as a sphere does: a grain, or the ghost of a material point (Li et al. 2023, section 2.3), asks the body's [`Solid`] for the nearest
//! point of its surface. The contact is the run's own law with friction and history; to so small a sphere the body is a plane, so R* is the
//! sphere's radius, as on walls. A plane wall meets the spots of a body that can reach it (corners, or the point of a superquadric that
//! is nearest), each a contact of its own with R* of the sphere of the same volume. Bodies that touch each other are an error.
//!
//! A face that lies on many points is many contacts. They live here, not among the grains', so scenes without such bodies pay nothing for them.

mod contact;
mod measure;
pub mod motion;
mod search;

pub use contact::{BlockContact, BlockScene, Other};
pub use motion::Pose;

use crate::dem::physics::Physics;
use crate::point_contacts::Age;
use crate::shape::{Shape, Solid};
use serde::{Deserialize, Serialize};

/// A body and its state. Velocity and angular momentum are those of the last half step (leapfrog).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Block {
    pub shape: Shape,
    pub material: u8,
    /// kg.
    pub mass: f64,
    /// Principal moments of inertia, kg m².
    pub moments: [f64; 3],
    /// Radius of the sphere of the same volume, m.
    pub radius: f64,
    /// Centre of mass, m.
    pub centre: [f64; 3],
    /// Unit quaternion (w, x, y, z) that turns the axes of space into the body's.
    pub turn: [f64; 4],
    /// m/s.
    pub velocity: [f64; 3],
    /// Angular momentum about the centre, in space, kg m²/s.
    pub momentum: [f64; 3],
}

impl Block {
    /// At rest at the origin, of this density, kg/m³.
    pub fn new(shape: Shape, density: f64, material: u8) -> Block {
        let bulk = shape.solid().bulk();
        Block {
            mass: density * bulk.volume,
            moments: bulk.moments.map(|moment| density * moment),
            radius: bulk.radius(),
            shape,
            material,
            centre: [0.0; 3],
            turn: [1.0, 0.0, 0.0, 0.0],
            velocity: [0.0; 3],
            momentum: [0.0; 3],
        }
    }

    pub fn solid(&self) -> &dyn Solid {
        self.shape.solid()
    }
}

/// All bodies of a scene and their contacts: everything that a restart needs.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Blocks {
    pub blocks: Vec<Block>,
    /// Whom they are near, in the order of blocks, then of points, grains, and spots on walls.
    pub candidates: Vec<BlockContact>,
    age: Age,
    /// Normal force on each wall, N.
    on_walls: Vec<f64>,
    /// What each body has been given since it moved last: force, N, and torque, N m.
    applied: Vec<[[f64; 3]; 2]>,
    /// Scratch: index by identity of grains and points.
    #[serde(skip)]
    index: [Vec<u32>; 2],
    /// Scratch: sums over points and grains.
    #[serde(skip)]
    sums: [Vec<f64>; 2],
}

impl Blocks {
    pub fn new(blocks: Vec<Block>) -> Blocks {
        Blocks { applied: vec![[[0.0; 3]; 2]; blocks.len()], blocks, ..Blocks::default() }
    }

    /// Largest speed of any part of a body, m/s.
    pub fn fastest(&self) -> f64 {
        use crate::math::vector::dot;
        let of = |b: &Block| {
            let w = b.spin();
            dot(b.velocity, b.velocity).sqrt() + dot(w, w).sqrt() * b.solid().reach()
        };
        self.blocks.iter().map(of).fold(0.0, f64::max)
    }

    /// The second half of a step: kicks, the first one half, and drifts. What was given is used up.
    pub fn advance(&mut self, physics: &Physics, fresh: bool, dt: f64) {
        let kick = if fresh { 0.5 * dt } else { dt };
        for (block, applied) in self.blocks.iter_mut().zip(&mut self.applied) {
            let [mut force, mut torque] = std::mem::take(applied);
            for (f, g) in force.iter_mut().zip(physics.gravity) {
                *f += block.mass * g;
            }
            // local damping of each component, −α |F| sign(v), as of grains
            let damped = |f: [f64; 3], v: [f64; 3]| -> [f64; 3] {
                let against = |a: usize| if v[a] == 0.0 { 0.0 } else { f[a].abs().copysign(-v[a]) };
                std::array::from_fn(|a| f[a] + physics.damping * against(a))
            };
            if physics.damping > 0.0 {
                force = damped(force, block.velocity);
                torque = damped(torque, block.spin());
            }
            if !physics.contact.turning {
                torque = [0.0; 3];
            }
            block.advance([force, torque], kick, dt);
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let index: usize = self.index.iter().map(|i| 4 * i.capacity()).sum();
        self.candidates.capacity() * size_of::<BlockContact>() + self.blocks.capacity() * size_of::<Block>() + index
    }
}
