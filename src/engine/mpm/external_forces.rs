//! Forces on points from outside, that wait for the next step. Few points have any, so only those have a place here.

use super::blocks::NONE;

/// What a point is given, N: force at the point, and on its faces across each axis ([`super::Points::faces`]). The fourth of both is the stiffness of what pushes, N/m.
#[derive(Clone, Copy, Debug, Default)]
pub struct PointForce {
    pub force: [f64; 4],
    pub beside: [f64; 4],
}

/// The pushes of a step.
#[derive(Clone, Debug, Default)]
pub struct ExternalForces {
    /// Of each point: where its push stands.
    pub places: Vec<u32>,
    forces: Vec<PointForce>,
}

impl ExternalForces {
    /// The push of point `i` of `points`, to be added to.
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

    /// The push of point `i`, where it has one.
    #[inline(always)]
    pub fn of(&self, i: usize) -> Option<&PointForce> {
        self.forces.get(self.places[i] as usize)
    }

    pub fn is_empty(&self) -> bool {
        self.forces.is_empty()
    }

    pub fn clear(&mut self) {
        self.forces.clear();
        self.places.fill(NONE);
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        4 * self.places.capacity() + size_of::<PointForce>() * self.forces.capacity()
    }
}
