//! External forces on points, kept until the end of the next step. Few points have any, so only those have an entry.

use super::blocks::NONE;

/// External force on one point. The fourth number of both vectors is the tangent stiffness of the contacts that make the force, N/m.
#[derive(Clone, Copy, Debug, Default)]
pub struct PointForce {
    /// Force at the point, N.
    pub force: [f64; 4],
    /// Force on the faces of the point: each component acts on the face across its axis ([`super::Points::faces`]), N.
    pub beside: [f64; 4],
    /// Index of the last of its forces beside the point, plus one; 0: there is none.
    pub last: u32,
}

/// A force that acts beside the centre of a point.
#[derive(Clone, Copy, Debug)]
pub struct OffsetForce {
    /// Force, N, and tangent stiffness of the contact, N/m.
    pub force: [f64; 4],
    /// From the centre of the point to where the force acts, m.
    pub offset: [f64; 3],
    /// Index of the force before it on the same point, plus one; 0: there is none.
    before: u32,
}

/// The external forces of a step.
#[derive(Clone, Debug, Default)]
pub struct ExternalForces {
    /// Of each point: index of its entry in `forces`, or `NONE`.
    pub places: Vec<u32>,
    forces: Vec<PointForce>,
    offset_forces: Vec<OffsetForce>,
}

impl ExternalForces {
    /// The force on point `i`, to be added to; `points`: number of points.
    pub fn of_mut(&mut self, i: usize, points: usize) -> &mut PointForce {
        if self.places.len() != points {
            self.clear();
            self.places.clear();
            self.places.resize(points, NONE);
        }
        if self.places[i] == NONE {
            self.places[i] = self.forces.len() as u32;
            self.forces.push(PointForce::default());
        }
        &mut self.forces[self.places[i] as usize]
    }

    /// Adds a force, with the stiffness of its contact as fourth number, that acts `offset` metres beside the centre of point `i`.
    pub fn add_beside(&mut self, i: usize, points: usize, force: [f64; 4], offset: [f64; 3]) {
        let number = self.offset_forces.len() as u32 + 1;
        let before = std::mem::replace(&mut self.of_mut(i, points).last, number);
        self.offset_forces.push(OffsetForce { force, offset, before });
    }

    /// The forces beside the centre of a point, the last one first.
    #[inline(always)]
    pub fn offset_forces(&self, point: &PointForce) -> impl Iterator<Item = &OffsetForce> {
        let of = |number: u32| number.checked_sub(1).map(|k| &self.offset_forces[k as usize]);
        std::iter::successors(of(point.last), move |force| of(force.before))
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
        self.offset_forces.clear();
        self.places.fill(NONE);
    }

    /// Memory in use, bytes.
    pub fn bytes(&self) -> usize {
        4 * self.places.capacity()
            + size_of::<PointForce>() * self.forces.capacity()
            + size_of::<OffsetForce>() * self.offset_forces.capacity()
    }
}
