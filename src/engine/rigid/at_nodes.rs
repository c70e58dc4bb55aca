//! Rigid bodies that the material touches at the nodes of the grid ([`crate::mpm::BodyPoint`]), the scheme MPM-DEM of Liu et al., to compare with (Jiang et al. 2020, section 5.4).

use super::Blocks;
use crate::check::{self, Checked, ensure};
use crate::math::vector::{cross, less, plus, scaled};
use crate::mpm::BodyPoint;
use crate::shape::Rounded;
use serde::{Deserialize, Serialize};

/// What bodies need of contacts at nodes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct AtNodes {
    /// Coefficient of friction of each body with the material.
    friction: Vec<f64>,
    /// Force, N, and torque about the centre of mass, N m, of the material on each body in the last step of the continuum.
    forces: Vec<[[f64; 3]; 2]>,
}

impl AtNodes {
    /// Checks what comes from outside; `made` is what the same run made.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, made: &AtNodes) -> Checked {
        check::lengths("forces at nodes on rigid bodies", made.forces.len(), [self.forces.len()])?;
        ensure(self.friction == made.friction, || "friction of rigid bodies is not that of the scene".into())?;
        check::numbers("forces at nodes on rigid bodies", self.forces.as_flattened().as_flattened())
    }
}

impl Blocks {
    /// Lets the material touch the bodies, which are polygons, at nodes, with these coefficients of friction, and not by its points.
    pub fn at_nodes(self, friction: Vec<f64>) -> Blocks {
        let forces = vec![[[0.0; 3]; 2]; friction.len()];
        Blocks { at_nodes: Some(Box::new(AtNodes { friction, forces })), ..self }
    }

    /// The points that stand for the bodies at the nodes, body by body; none where the material touches the bodies by its own points.
    pub fn body_points(&mut self) -> Vec<BodyPoint> {
        if self.at_nodes.is_some() {
            self.outline();
        }
        let Some(at_nodes) = &self.at_nodes else { return Vec::new() };
        let mut found = Vec::new();
        for (((body, block), outline), &friction) in (0_u32..).zip(&self.blocks).zip(&self.outlines).zip(&at_nodes.friction) {
            let (pose, spin, driven) = (block.pose(0.0), block.spin(), block.driven);
            let places = if let Rounded::Ring(ring) = &outline.body { ring.landmarks() } else { Vec::new() };
            let mass = block.mass / places.len().max(1) as f64;
            found.extend(places.into_iter().map(|at| {
                let position = pose.place(at);
                let velocity = plus(block.velocity, cross(spin, less(position, block.centre)));
                BodyPoint { body, mass, position, velocity, friction, driven, impulse: [0.0; 3] }
            }));
        }
        found
    }

    /// Force, N, and torque about the centre of mass, N m, of the material on each body in the last step of the continuum, where it touches them at nodes; else none.
    pub(super) fn forces_at_nodes(&self) -> &[[[f64; 3]; 2]] {
        self.at_nodes.as_ref().map_or(&[], |at_nodes| &at_nodes.forces)
    }

    /// Gives the bodies the impulses that the material has given to their points in a step of `dt` seconds.
    pub fn take_impulses(&mut self, points: &[BodyPoint], dt: f64) {
        let Some(at_nodes) = &mut self.at_nodes else { return };
        at_nodes.forces.fill([[0.0; 3]; 2]);
        for point in points {
            let (block, force) = (&mut self.blocks[point.body as usize], &mut at_nodes.forces[point.body as usize]);
            let turn = cross(less(point.position, block.centre), point.impulse);
            *force = [plus(force[0], scaled(point.impulse, 1.0 / dt)), plus(force[1], scaled(turn, 1.0 / dt))];
            if !block.driven {
                block.velocity = plus(block.velocity, scaled(point.impulse, 1.0 / block.mass));
                block.momentum = plus(block.momentum, turn);
            }
        }
    }
}
