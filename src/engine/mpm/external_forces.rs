//! External forces on points, kept until the next step. Few points have any, so only those have an entry.

use super::blocks::NONE;

/// External force on one point. The fourth number of both vectors is the tangent stiffness of the contacts that make the force, N/m.
#[derive(Clone, Copy, Debug, Default)]
pub struct PointForce {
    /// Force at the point, N.
    pub force: [f64; 4],
    /// Force on the faces of the point: each component acts on the face across its axis ([`super::Points::faces`]), N.
    pub beside: [f64; 4],
}

/// The external forces of a step.
#[derive(Clone, Debug, Default)]
pub struct ExternalForces {
    /// Of each point: index of its entry in `forces`, or `NONE`.
    pub places: Vec<u32>,
    forces: Vec<PointForce>,
}

impl ExternalForces {
    /// The force on point `i`, to be added to; `points`: number of points.
    pub fn of_mut(&mut self, i: usize, points: usize) -> &mut PointForce {
        if self.places.len() != points {
            self.forces.clear();
            self.places.clear();
            self.places.resize(points, NONE);
        }
        if self.places[i] == NONE {
            self.places[i] = self.forces.len() as u32;
            self.forces.push(PointForce::default());
        }
        &mut self.forces[self.places[i] as usize]
    }

    /// The force on point `i`, if there is one.
    #[inline(always)]
    pub fn of(&self, i: usize) -> Option<&PointForce> {
        self.forces.get(self.places[i] as usize)
    }

    /// Whether no point has an external force.
    pub fn is_empty(&self) -> bool {
        self.forces.is_empty()
    }

    /// Removes all forces.
    pub fn clear(&mut self) {
        self.forces.clear();
        self.places.fill(NONE);
    }

    /// Memory in use, bytes.
    pub fn bytes(&self) -> usize {
        4 * self.places.capacity() + size_of::<PointForce>() * self.forces.capacity()
    }
}
