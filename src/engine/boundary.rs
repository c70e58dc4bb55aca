//! Walls: rigid planes and vertical cylinders, and their drives. A wall moves along its own normal only; its speed is positive
//! into the grains.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

#[derive(Clone, Debug)]
pub struct WallSpec {
    pub shape: WallShape,
    pub friction: f64,
    pub drive: Drive,
    /// Material of the wall; `None`: rigid (NOTES.md).
    pub material: Option<u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum WallShape {
    /// Grains are on the side to which `normal` points.
    Plane { point: [f64; 3], normal: [f64; 3] },
    /// Vertical cylinder (axis z), grains inside.
    Cylinder { centre: [f64; 2], radius: f64 },
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Drive {
    Fixed,
    /// Velocity along the wall's normal direction into the grains, m/s (cylinder: inwards).
    Velocity(f64),
    /// Held at a normal stress, Pa, over `area`, m^2 (cylinder: its own current area).
    Stress {
        stress: f64,
        area: f64,
        gain: f64,
    },
}

/// A wall and its state.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Wall {
    pub shape: WallShape,
    pub drive: Drive,
    /// Coulomb coefficient between wall and grains.
    pub friction: f64,
    /// Material index; `None`: rigid.
    pub material: Option<u8>,
    /// Speed into the grains during the last half step, m/s.
    pub speed: f64,
    /// Normal force of the grains on the wall at the last sweep, N (cylinder: sum of the radial forces).
    pub reaction: f64,
    /// Tangential force of the grains on the wall along z (cylinder) or in its plane (largest component not kept), N.
    pub shear_z: f64,
    /// Sum of the tangent normal stiffness of its contacts, N/m.
    pub stiffness: f64,
    /// Work done on the grains since the ledger's start, J.
    pub work: f64,
}

impl WallShape {
    /// Unit normal from the grain `p` towards the wall, and the gap between them (negative: overlap), m.
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

    /// Moves the wall by its speed over `dt`.
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

    /// Distance the wall has moved since it had the shape `reference`, m.
    pub fn moved_since(&self, reference: &WallShape) -> f64 {
        match (self.shape, reference) {
            (WallShape::Plane { point, normal }, WallShape::Plane { point: q, .. }) => {
                ((point[0] - q[0]) * normal[0] + (point[1] - q[1]) * normal[1] + (point[2] - q[2]) * normal[2]).abs()
            }
            (WallShape::Cylinder { radius, .. }, WallShape::Cylinder { radius: r, .. }) => (radius - r).abs(),
            _ => f64::INFINITY,
        }
    }
}

/// The speed by which a servo removes the share `gain` of the imbalance between `force` (target) and `reaction` through the
/// wall's own contacts in one step, at most `limit`.
pub fn servo_speed(force: f64, reaction: f64, stiffness: f64, gain: f64, dt: f64, limit: f64) -> f64 {
    if stiffness <= 0.0 {
        return limit;
    }
    (gain * (force - reaction) / (stiffness * dt)).clamp(-limit, limit)
}

/// An upright cylinder between two platens, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CylinderSpace {
    pub bottom: f64,
    pub height: f64,
    pub radius: f64,
}

impl CylinderSpace {
    /// Area of a platen, m².
    pub fn platen_area(&self) -> f64 {
        PI * self.radius * self.radius
    }

    /// Area of the shell, m².
    pub fn shell_area(&self) -> f64 {
        shell_area(self.radius, self.height)
    }

    /// Volume, m³.
    pub fn volume(&self) -> f64 {
        self.platen_area() * self.height
    }
}

/// Area of a cylinder's shell, m^2.
pub fn shell_area(radius: f64, height: f64) -> f64 {
    2.0 * PI * radius * height
}
