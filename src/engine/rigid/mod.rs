//! Rigid bodies that are not spheres: their motion and their contacts with grains, walls and material points.
//!
//! A grain, or the ghost of a material point (Li et al. 2023, section 2.3), touches a body as a sphere: the body's [`Solid`] gives the nearest point of
//! its surface. The contact follows the contact law of the run, with friction and history. To a small sphere the body's surface is a plane, so R* is
//! the radius of the sphere, as on walls.
//!
//! A wall touches *spots* of a body: its corners, or the one point of a superquadric that is nearest to the wall. Each spot is a contact of its own
//! with R* of the sphere that has the body's volume. Two bodies touch at corners and at edges that cross (`pair.rs`), each a contact with R* of two such spheres.
//! A superquadric has no corners: it touches another convex body where both are nearest, and each facet of a sheet and part of a compound where it is nearest to that (`facets.rs`).
//!
//! A sheet of triangles ([`crate::shape::Sheet`]) is a driven body without mass. What touches it has a contact with each facet, and on its way from facet to facet the contact
//! that begins takes over the history of the one that ends.
//!
//! Bodies may break in two, compounds into their parts (`breaking.rs`), be moved, pushed and held from outside (`drive.rs`), and be joined to each other and to the world (`joint.rs`).
//!
//! A face that lies on many points has many contacts. They are stored here and not with those of the grains, so scenes without such bodies pay nothing.

mod at_nodes;
mod breaking;
mod contact;
mod drive;
mod facets;
mod joint;
mod laps;
mod list;
mod measure;
pub mod motion;
mod near;
mod pair;
mod search;
mod ways;

pub use breaking::{Breakage, Breaking, Fate, LEAST, MOST_LOST, parts_of};
pub use contact::{BlockContact, BlockScene, Other};
pub use drive::{Drive, Drives, Path, Programme, Push};
pub use joint::{Bond, Cement, Joint, Kind, Pull};
pub use laps::Lap;
pub use motion::Pose;
pub use pair::Site;

use crate::check::{self, Checked, below, ensure};
use crate::dem::State;
use crate::dem::physics::Physics;
use crate::math::vector::plus;
use crate::mpm::Continuum;
use crate::point_contacts::Age;
use crate::shape::{Shape, Solid};
use at_nodes::AtNodes;
use list::Contacts;
use pair::Outline;
use serde::{Deserialize, Serialize};

/// A rigid body and its state. Velocity and angular momentum are those of the last half step (leapfrog).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Block {
    /// Shape, in the frame of the body: origin at its centre of mass, axes along its principal axes.
    pub shape: Shape,
    /// Index of the material.
    pub material: u8,
    /// Mass, kg.
    pub mass: f64,
    /// Principal moments of inertia, kg m².
    pub moments: [f64; 3],
    /// Radius of the sphere of the same volume, m.
    pub radius: f64,
    /// Centre of mass, m.
    pub centre: [f64; 3],
    /// Orientation: unit quaternion (w, x, y, z) that rotates the axes of space into those of the body.
    pub turn: [f64; 4],
    /// Velocity of the centre of mass, m/s.
    pub velocity: [f64; 3],
    /// Angular momentum about the centre of mass, in the axes of space, kg m²/s.
    pub momentum: [f64; 3],
    /// Whether it keeps its velocity and angular momentum whatever presses on it.
    pub driven: bool,
}

impl Block {
    /// A body at rest at the origin, not rotated, of density `density`, kg/m³. A sheet has no mass; its moments are 1 kg m², so that its angular momentum is its
    /// angular velocity and its spin stays as it is whatever its direction.
    pub fn new(shape: Shape, density: f64, material: u8) -> Block {
        let bulk = shape.solid().bulk();
        let sheet = shape.solid().sheet().is_some();
        Block {
            mass: density * bulk.volume,
            moments: if sheet { [1.0; 3] } else { bulk.moments.map(|moment| density * moment) },
            radius: shape.radius(),
            shape,
            material,
            centre: [0.0; 3],
            turn: [1.0, 0.0, 0.0, 0.0],
            velocity: [0.0; 3],
            momentum: [0.0; 3],
            driven: false,
        }
    }

    /// Checks the body, which has moved since it was `made`.
    ///
    /// # Errors
    /// What is wrong, in words.
    fn check(&self, made: &Block) -> Checked {
        let size = |b: &Block| (b.material, b.mass, b.moments, b.radius, b.driven);
        ensure(self.shape == made.shape && size(self) == size(made), || "a rigid body is not that of the scene".into())?;
        self.check_motion()
    }

    /// Checks a piece of a body, of less than the mass `most`, kg, which is what it is made of.
    fn check_piece(&self, most: f64) -> Checked {
        let bulk = self.solid().bulk();
        check::positive("masses of pieces", self.moments.into_iter().chain([self.mass, self.radius, bulk.volume]))?;
        let shaped = self.shape.is_sound() && self.radius == self.shape.radius();
        ensure(shaped && self.mass < most && !self.driven, || "a piece of a rigid body is none".into())?;
        self.check_motion()
    }

    /// Checks place and motion.
    fn check_motion(&self) -> Checked {
        check::numbers("motions of rigid bodies", self.centre.iter().chain(&self.velocity).chain(&self.momentum))?;
        let square: f64 = self.turn.iter().map(|x| x * x).sum();
        ensure((square - 1.0).abs() < 1e-6, || format!("a rigid body is turned by no turn: {:?}", self.turn))
    }

    /// The geometry of its shape.
    pub fn solid(&self) -> &dyn Solid {
        self.shape.solid()
    }
}

/// All rigid bodies of a scene and their contacts: what a restart needs of them.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Blocks {
    /// The bodies.
    pub blocks: Vec<Block>,
    /// Their contacts, touching or near.
    contacts: Contacts,
    /// Radius with which points touch bodies, m; `None`: that of their ghosts.
    point_radius: Option<f64>,
    /// Square of the angular frequency, 1/s², that the first touch of a point has, by a contact law whose stiffness does not begin at zero.
    first_touch: f64,
    /// How the bodies touch points at the nodes of the grid; `None`: they touch each point by itself.
    at_nodes: Option<Box<AtNodes>>,
    /// Age of the list.
    age: Age,
    /// How the bodies break; `None`: they do not.
    breaking: Option<Box<Breaking>>,
    /// What drives, pushes, holds and joins the bodies from outside; `None`: nothing does.
    drives: Option<Box<Drives>>,
    /// Force, N, and torque about the centre of mass, N m, on each body, added since its last step.
    applied: Vec<[[f64; 3]; 2]>,
    /// What other bodies touch of each body; made when it is first needed.
    #[serde(skip)]
    outlines: Vec<Outline>,
    /// Number of updates of the list in this process.
    #[serde(skip)]
    looks: u64,
    /// Buffers: index by identity, of grains and of points.
    #[serde(skip)]
    index: [Vec<u32>; 2],
    /// Buffers of zeros for sums over points and over grains.
    #[serde(skip)]
    sums: [Vec<f64>; 2],
}

impl Blocks {
    /// Bodies without contacts.
    pub fn new(blocks: Vec<Block>) -> Blocks {
        Blocks { applied: vec![[[0.0; 3]; 2]; blocks.len()], blocks, ..Blocks::default() }
    }

    /// Lets points touch the bodies with this radius, m (Jiang et al. 2020, eqs 44, 45); `None`: with that of their ghosts. `first_touch`: square of the angular
    /// frequency, 1/s², at the first touch of the lightest point; 0 for Hertzian laws. The bound on the step needs it before they touch.
    pub fn with_points(self, point_radius: Option<f64>, first_touch: f64) -> Blocks {
        Blocks { point_radius, first_touch, ..self }
    }

    /// Checks bodies and contacts that come from outside against grains, walls and points of their run; `made` are the bodies as the same run made them.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, made: &Blocks, state: &State, continuum: &Continuum) -> Checked {
        let n = self.blocks.len();
        match (&self.breaking, &made.breaking) {
            (None, None) => {
                check::lengths("rigid bodies", made.blocks.len(), [n, self.applied.len()])?;
                self.blocks.iter().zip(&made.blocks).try_for_each(|(block, made)| block.check(made))?;
            }
            (Some(breaking), Some(_)) => {
                check::lengths("forces on rigid bodies", n, [self.applied.len()])?;
                breaking.check(n, made.blocks.len())?;
                let fates = breaking.bodies.iter().map(|fate| fate.generation);
                let by_generation = |((block, made), generation): ((&Block, Option<&Block>), u8)| match made {
                    Some(made) if generation == 0 => block.check(made),
                    _ => block.check_piece(made.map_or(f64::INFINITY, |made| made.mass)),
                };
                let started = made.blocks.iter().map(Some).chain(std::iter::repeat(None));
                self.blocks.iter().zip(started).zip(fates).try_for_each(by_generation)?;
            }
            _ => return Err("rigid bodies break which do not in the scene, or do not which do".into()),
        }
        match (&self.drives, &made.drives) {
            (Some(drives), Some(made)) => drives.check(made)?,
            (None, None) => {}
            _ => return Err("rigid bodies are driven or joined which are not in the scene, or are not which are".into()),
        }
        match (&self.at_nodes, &made.at_nodes) {
            (Some(at_nodes), Some(made)) => at_nodes.check(made)?,
            (None, None) => {}
            _ => return Err("rigid bodies touch points at nodes which do not in the scene, or do not which do".into()),
        }
        self.age.check()?;
        let with_points = |b: &Blocks| (b.point_radius, b.first_touch);
        ensure(with_points(self) == with_points(made), || "points touch rigid bodies in another way than in the scene".into())?;
        check::numbers("forces on rigid bodies", self.applied.as_flattened().as_flattened())?;
        self.contacts.check()?;
        for pair in &self.contacts.pairs {
            below("a rigid body is near body", pair.bodies[1], n)?;
        }
        for c in self.contacts.all() {
            below("rigid body", c.block, n)?;
            if matches!(c.other, Other::Point(_) | Other::Grain(_)) {
                below("facet of a rigid body", c.facet, self.blocks[c.block as usize].solid().facets())?;
            }
            match c.other {
                Other::Point(id) => below("a rigid body touches point", id, continuum.points().next_id as usize)?,
                Other::Grain(id) => below("a rigid body touches grain", id, state.grains.next_id as usize)?,
                Other::Wall { wall, spot } => {
                    below("a rigid body touches wall", wall, state.walls.len())?;
                    below("spot of a rigid body", spot, self.blocks[c.block as usize].solid().spots())?;
                }
                // a site that there is not has no force
                Other::Block { block, .. } => {
                    below("a rigid body touches body", block, n)?;
                    ensure(block > c.block, || "a contact of two rigid bodies does not begin at the first of them".into())?;
                }
            }
            check::numbers("contacts of rigid bodies", c.numbers())?;
        }
        Ok(())
    }

    /// Makes what other bodies touch of each body, if that is not known yet.
    fn outline(&mut self) {
        if self.outlines.len() != self.blocks.len() {
            self.outlines = self.blocks.iter().map(Outline::of).collect();
        }
    }

    /// Upper bound on the speed of any part of any body, m/s.
    pub fn fastest(&self) -> f64 {
        use crate::math::vector::dot;
        let of = |b: &Block| {
            let w = b.spin();
            dot(b.velocity, b.velocity).sqrt() + dot(w, w).sqrt() * b.solid().reach()
        };
        self.blocks.iter().map(of).fold(0.0, f64::max)
    }

    /// Moves all bodies by one step of `dt` seconds with the forces added since the last step, gravity and local damping. `time`: at the beginning of the
    /// step, s; `kick`: time over which forces change velocities first, s.
    pub fn advance(&mut self, physics: &Physics, time: f64, kick: f64, dt: f64) {
        self.add_joints();
        let mut drives = self.drives.as_mut().map(|drives| drives.bodies.iter_mut());
        for (block, applied) in self.blocks.iter_mut().zip(&mut self.applied) {
            let [mut force, mut torque] = std::mem::take(applied);
            let drive = drives.as_mut().and_then(Iterator::next);
            if let Some(drive) = &drive {
                let [push, turn] = drive.programme.push.at(time);
                (force, torque) = (plus(force, push), plus(torque, turn));
            }
            for (f, g) in force.iter_mut().zip(physics.gravity) {
                *f += block.mass * g;
            }
            // local damping of each component, −α |F| sign(v), as for grains
            let damped = |f: [f64; 3], v: [f64; 3]| -> [f64; 3] {
                let against = |a: usize| if v[a] == 0.0 { 0.0 } else { f[a].abs().copysign(-v[a]) };
                std::array::from_fn(|a| f[a] + physics.damping * against(a))
            };
            if physics.damping > 0.0 && !block.driven {
                force = damped(force, block.velocity);
                torque = damped(torque, block.spin());
            }
            if !physics.contact.turning {
                torque = [0.0; 3];
            }
            match drive {
                Some(drive) => drive.advance(block, [force, torque], time, kick, dt),
                None => block.advance([force, torque], kick, dt),
            }
        }
        self.add_viscous_work(kick);
    }

    /// Memory in use, bytes.
    pub fn bytes(&self) -> usize {
        let index: usize = self.index.iter().map(|i| 4 * i.capacity()).sum();
        self.contacts.bytes() + self.blocks.capacity() * size_of::<Block>() + index
    }
}
