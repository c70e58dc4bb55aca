//! Walls of the grains: planes and upright cylinders, and how they move.
//!
//! A wall moves along its own normal only. Its speed is positive towards the grains, its reaction positive where the grains press on it.

use crate::check::{Checked, ensure, numbers, positive};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A wall as a scene describes it: what [`Wall::new`] needs.
#[derive(Clone, Debug)]
pub struct WallSpec {
    /// Shape and place at the start.
    pub shape: WallShape,
    /// Coefficient of friction between wall and grains.
    pub friction: f64,
    /// How the wall moves.
    pub drive: Drive,
    /// Index of the wall's material; `None`: the wall is rigid.
    pub material: Option<u8>,
}

/// Shape and place of a wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum WallShape {
    /// A plane without an edge; the grains are on the side to which `normal` points.
    Plane {
        /// A point on the plane, m.
        point: [f64; 3],
        /// Unit normal, towards the grains.
        normal: [f64; 3],
    },
    /// An upright cylinder (axis z) without ends; the grains are inside.
    Cylinder {
        /// x and y of the axis, m.
        centre: [f64; 2],
        /// Radius, m.
        radius: f64,
    },
}

/// How a wall moves along its normal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Drive {
    /// Not at all.
    Fixed,
    /// At this speed, m/s, positive towards the grains (a cylinder then becomes narrower).
    Velocity(f64),
    /// So that the normal stress on the wall stays at a value ([`servo_speed`]).
    Stress {
        /// Normal stress to be held, Pa, compression positive.
        stress: f64,
        /// Area on which the stress acts, m²; a cylinder uses its own present area instead.
        area: f64,
        /// Share of the difference between target and reaction that is removed in one step.
        gain: f64,
        /// Largest speed, m/s; `None`: that of the rig.
        fastest: Option<f64>,
    },
    /// As the programme of a test says, which sets its speed.
    Programme,
}

/// A wall and its state.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Wall {
    /// Shape and present place.
    pub shape: WallShape,
    /// How the wall moves.
    pub drive: Drive,
    /// Coefficient of friction between wall and grains.
    pub friction: f64,
    /// Index of the wall's material; `None`: the wall is rigid.
    pub material: Option<u8>,
    /// Present speed towards the grains, m/s (that of the last half step, as the grains' velocities).
    pub speed: f64,
    /// Normal force of the grains on the wall when contact forces were last computed, N, positive in compression (cylinder: sum of the radial forces).
    pub reaction: f64,
    /// Sum of the z components of the tangential forces of the grains on the wall, N; zero on a horizontal plane.
    pub shear_z: f64,
    /// Sum of the tangent normal stiffnesses of the wall's contacts, N/m.
    pub stiffness: f64,
    /// Work of the wall on the grains since the energy ledger was opened, J.
    pub work: f64,
}

impl WallShape {
    /// Way along its normal from the shape `reference` to here, m, positive towards the grains.
    pub fn way_since(&self, reference: &WallShape) -> f64 {
        match (*self, reference) {
            (WallShape::Plane { point, normal }, WallShape::Plane { point: q, .. }) => {
                (point[0] - q[0]) * normal[0] + (point[1] - q[1]) * normal[1] + (point[2] - q[2]) * normal[2]
            }
            (WallShape::Cylinder { radius, .. }, WallShape::Cylinder { radius: r, .. }) => r - radius,
            _ => f64::INFINITY,
        }
    }

    /// Unit normal from a sphere towards the wall, and the gap between sphere and wall, m (negative: they overlap). `p`: centre x, y, z and radius, m.
    #[inline(always)]
    pub fn towards(&self, p: [f64; 4]) -> ([f64; 3], f64) {
        match *self {
            WallShape::Plane { point, normal } => {
                let h = (p[0] - point[0]) * normal[0] + (p[1] - point[1]) * normal[1] + (p[2] - point[2]) * normal[2];
                ([-normal[0], -normal[1], -normal[2]], h - p[3])
            }
            WallShape::Cylinder { centre, radius } => {
                let (x, y) = (p[0] - centre[0], p[1] - centre[1]);
                let rho = (x * x + y * y).sqrt();
                let inverse = if rho > 0.0 { 1.0 / rho } else { 0.0 };
                ([x * inverse, y * inverse, 0.0], radius - rho - p[3])
            }
        }
    }
}

impl Wall {
    /// A wall without contacts, at the place of its specification; moving if that gives a velocity.
    pub fn new(spec: &WallSpec) -> Wall {
        Wall {
            shape: spec.shape,
            drive: spec.drive,
            friction: spec.friction,
            material: spec.material,
            speed: if let Drive::Velocity(v) = spec.drive { v } else { 0.0 },
            reaction: 0.0,
            shear_z: 0.0,
            stiffness: 0.0,
            work: 0.0,
        }
    }

    /// Checks the wall, which has moved since it was `made`.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, made: &Wall) -> Checked {
        let Wall { shape, drive, friction, material, speed, reaction, shear_z, stiffness, work } = self;
        let same = *drive == made.drive && *friction == made.friction && *material == made.material;
        let alike = match (shape, made.shape) {
            (WallShape::Plane { normal, .. }, WallShape::Plane { normal: as_made, .. }) => *normal == as_made,
            (WallShape::Cylinder { centre, .. }, WallShape::Cylinder { centre: as_made, .. }) => *centre == as_made,
            _ => false,
        };
        ensure(same && alike, || "a wall is not that of the scene".into())?;
        match shape {
            WallShape::Plane { point, .. } => numbers("places of walls", point)?,
            WallShape::Cylinder { radius, .. } => positive("radii of walls", [radius])?,
        }
        numbers("forces and motions of walls", [speed, reaction, shear_z, stiffness, work])
    }

    /// Moves the wall at its present speed for `dt` seconds.
    pub fn advance(&mut self, dt: f64) {
        let step = self.speed * dt;
        match &mut self.shape {
            WallShape::Plane { point, normal } => {
                for a in 0..3 {
                    point[a] += step * normal[a];
                }
            }
            WallShape::Cylinder { radius, .. } => *radius -= step,
        }
    }

    /// Distance by which the wall has moved along its normal since it had the shape `reference`, m.
    pub fn moved_since(&self, reference: &WallShape) -> f64 {
        self.way_since(reference).abs()
    }

    /// Way of the wall along its normal since it had the shape `reference`, m, positive towards the grains.
    pub fn way_since(&self, reference: &WallShape) -> f64 {
        self.shape.way_since(reference)
    }
}

/// Speed of a wall, m/s, positive towards the grains, that removes the share `gain` of the imbalance `force` − `reaction` (target and present
/// reaction, N) in one step of `dt` seconds through the wall's contacts, whose stiffnesses add up to `stiffness`, N/m.
///
/// The speed is at most `limit`, m/s, in either direction; a wall without contacts moves towards the grains at `limit`.
pub fn servo_speed(force: f64, reaction: f64, stiffness: f64, gain: f64, dt: f64, limit: f64) -> f64 {
    if stiffness <= 0.0 {
        return limit;
    }
    limited(gain * (force - reaction) / (stiffness * dt), limit)
}

/// A speed limited to `limit` in either direction; 0 where the limit is negative or not a number, as in a state that has become meaningless.
pub fn limited(speed: f64, limit: f64) -> f64 {
    if limit >= 0.0 { speed.clamp(-limit, limit) } else { 0.0 }
}

/// The space of a cylindrical specimen: upright, between two platens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CylinderSpace {
    /// z of the lower platen, m.
    pub bottom: f64,
    /// Distance between the platens, m.
    pub height: f64,
    /// Radius, m.
    pub radius: f64,
}

impl CylinderSpace {
    /// Area of one platen, m².
    pub fn platen_area(&self) -> f64 {
        PI * self.radius * self.radius
    }

    /// Area of the curved surface, m².
    pub fn shell_area(&self) -> f64 {
        shell_area(self.radius, self.height)
    }

    /// Volume, m³.
    pub fn volume(&self) -> f64 {
        self.platen_area() * self.height
    }
}

/// Area of the curved surface of a cylinder, m².
pub fn shell_area(radius: f64, height: f64) -> f64 {
    2.0 * PI * radius * height
}
