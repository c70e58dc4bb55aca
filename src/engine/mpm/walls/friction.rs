//! Walls with friction, all of them together, so that an edge where two or three meet does not depend on the order of the axes.
//!
//! Whether they push is decided for all of them from what the walls that hold have left, and in the same way for a node and for its image in another
//! wall with friction: then it does not matter which of them is folded first. A node that several of them press is rubbed once, from one velocity: the
//! limits of their friction add up, its motion along them is never reversed, and each has a share of the force in proportion to its limit.

use super::super::blocks::{NONE, cell_at, cell_key};
use super::{GridWall, WallPlane, needed};

impl WallPlane {
    /// Finds the rows of a wall with friction that lie behind other walls with friction, and their images; `walls` and `size` as in [`super::Walls::find`].
    pub(super) fn find_images<const D: usize>(&mut self, walls: &[GridWall; 6], size: [i32; 3]) {
        let rubs = |side: usize| side / 2 < D && matches!(walls[side], GridWall::Friction { .. });
        self.images.clear();
        self.push.clear();
        if !self.rubs() {
            return;
        }
        self.push.resize(self.triples.len(), 0.0);
        for axis in (0..D).filter(|&a| a != self.axis && (rubs(2 * a) || rubs(2 * a + 1))) {
            for (row, &key) in self.keys.iter().enumerate() {
                let mut at = cell_at::<D>(key);
                if at[axis] == -1 && rubs(2 * axis) {
                    at[axis] = 1;
                } else if at[axis] == size[axis] + 1 && rubs(2 * axis + 1) {
                    at[axis] = size[axis] - 1;
                } else {
                    continue;
                }
                if let Ok(image) = self.keys.binary_search(&cell_key::<D>(at)) {
                    self.images.push([row as u32, image as u32]);
                }
            }
        }
    }

    /// Decides for each row of a wall with friction whether the wall acts: if it has to push, or, with `held`, if it acted at the last acceleration.
    fn decide(&mut self, p: &[[f64; 4]], i: &[[f64; 4]], held: bool) {
        for (&triple, push) in self.triples.iter().zip(&mut self.push) {
            let on = triple[1] as usize;
            let p_behind = if triple[0] == NONE { 0.0 } else { p[triple[0] as usize][self.axis] };
            *push = self.sign * (needed(triple, i)[self.axis] - (p[on][self.axis] + 2.0 * p_behind));
        }
        for &[row, image] in &self.images {
            self.push[image as usize] += self.push[row as usize];
        }
        for ((contact, push), pressed) in self.contact.iter_mut().zip(&self.push).zip(&self.pressed) {
            *contact = *push > 0.0 || held && *pressed;
        }
        for &[row, image] in self.images.iter().rev() {
            self.contact[row as usize] = self.contact[image as usize];
        }
    }

    /// Rows of a wall with friction that acts, each with its node on the plane.
    fn acting(&self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.triples.len()).filter(|&row| self.contact[row]).map(|row| (row, self.triples[row][1] as usize))
    }

    /// Of a row of a wall that acts: the largest impulse of its friction, N s; `None` for a smooth wall.
    #[inline(always)]
    fn limit(&self, row: usize) -> Option<f64> {
        let GridWall::Friction { friction } = self.wall else { return None };
        (friction > 0.0).then(|| friction * self.push[row].max(0.0))
    }
}

/// Folds the walls with friction, once the others are.
pub(super) fn rub(faces: &mut [WallPlane; 6], p: &mut [[f64; 4]], i: &mut [[f64; 4]], reaction: &mut [[f64; 3]; 6], held: bool) {
    for face in faces.iter_mut().filter(|face| face.rubs()) {
        face.decide(p, i, held);
    }
    // what the walls give across stays at the nodes on their planes, for another wall may fold it onto its image
    for face in faces.iter().filter(|face| face.rubs()) {
        for (row, on) in face.acting() {
            let given = needed(face.triples[row], i)[face.axis];
            (p[on][face.axis], i[on][face.axis]) = (0.0, 0.0 - given);
        }
    }
    for face in faces.iter().filter(|face| face.rubs()) {
        for (row, _) in face.acting() {
            face.mirror(face.triples[row], p, i);
        }
    }
    // the fourth number of an impulse is free: here it is the sum of what the walls' friction may give to the node
    for (face, reaction) in faces.iter_mut().zip(&mut *reaction).filter(|(face, _)| face.rubs()) {
        for row in 0..face.triples.len() {
            let on = face.triples[row][1] as usize;
            if face.contact[row] {
                let given = 0.0 - i[on][face.axis];
                (p[on][face.axis], i[on][face.axis]) = (0.0, 0.0);
                reaction[face.axis] += given;
                face.push[row] = face.sign * given;
                i[on][3] += face.limit(row).unwrap_or(0.0);
            }
        }
    }
    for (face, reaction) in faces.iter().zip(reaction).filter(|(face, _)| face.rubs()) {
        for (row, on) in face.acting() {
            let Some(limit) = face.limit(row) else { break };
            let share = if i[on][3] > 0.0 { limit / i[on][3] } else { 0.0 };
            let (along, kept) = rubbed(p[on], i[on]);
            for a in 0..3 {
                reaction[a] += share * (along[a] * kept - along[a]);
            }
        }
    }
    for face in faces.iter().filter(|face| face.rubs()) {
        for (row, on) in face.acting() {
            if face.limit(row).is_none() || i[on][3] < 0.0 {
                continue;
            }
            let (along, kept) = rubbed(p[on], i[on]);
            for a in 0..3 {
                i[on][a] = along[a] * kept - p[on][a];
            }
            i[on][3] = -1.0;
        }
    }
}

/// Momentum of a node along its walls without friction, and the part of it that friction leaves.
#[inline(always)]
fn rubbed(p: [f64; 4], i: [f64; 4]) -> ([f64; 3], f64) {
    let along: [f64; 3] = std::array::from_fn(|a| p[a] + i[a]);
    let size = (along[0] * along[0] + along[1] * along[1] + along[2] * along[2]).sqrt();
    (along, if size > i[3] { 1.0 - i[3] / size } else { 0.0 })
}
