//! Walls at the sides of the domain, each along a plane of nodes.
//!
//! Shape functions of points near a wall reach across its plane. In contact the material behind the wall is taken as the mirror image of the material in
//! front: momentum, mass and force that a node behind the plane has received are *folded* onto the node in front of it, so that uniform strain stays
//! exact up to the wall.
//!
//! For a plane of symmetry the normal component is mirrored with the opposite sign, the tangential ones with the same sign. For a rough wall all
//! components change sign. A wall with friction is a plane of symmetry while it has to push, and it reduces the tangential momentum of its nodes by at
//! most μ times the normal impulse; while it would have to pull, it does nothing.
//!
//! On an edge the result does not depend on which axis is called x: walls that hold are folded first, and their folds commute; those with friction
//! follow all together (`friction.rs`).

mod friction;

use super::blocks::{CellBlocks, NONE, block_corner, cell_key, cells};
use serde::{Deserialize, Serialize};

/// The wall at one side of the domain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GridWall {
    /// No wall: a point that leaves the domain here is an error.
    #[default]
    Open,
    /// Smooth, and holds the material in both directions: a plane of symmetry.
    Symmetry,
    /// Rough, and holds the material in both directions.
    Stick,
    /// Pushes but never pulls, with Coulomb friction.
    Friction {
        /// Coefficient of friction; 0: smooth.
        friction: f64,
    },
}

/// Three nodes in a row across a wall: behind its plane, on it, in front of it, as indices into [`Walls::nodes`].
type Triple = [u32; 3];

/// One wall and its nodes.
#[derive(Clone, Debug, Default)]
struct WallPlane {
    /// Axis across the plane.
    axis: usize,
    /// 1 or −1: direction of the normal into the domain along the axis.
    sign: f64,
    wall: GridWall,
    /// Rows of nodes across the wall.
    triples: Vec<Triple>,
    /// Key of the node on the plane of each row, in order.
    keys: Vec<u64>,
    /// Of each row: whether the wall acts, in the present folding.
    contact: Vec<bool>,
    /// Of each row: whether the wall acted when nodes were last accelerated.
    pressed: Vec<bool>,
    /// `keys` and `pressed` before the blocks of nodes changed.
    before: (Vec<u64>, Vec<bool>),
    /// Of each row, for a wall with friction: with which impulse it has to push, then which one it has given, N s.
    push: Vec<f64>,
    /// Of rows that lie behind another wall with friction: the row, and its image in front.
    images: Vec<[u32; 2]>,
}

impl WallPlane {
    fn rubs(&self) -> bool {
        matches!(self.wall, GridWall::Friction { .. })
    }

    /// 1 or −1: what the mirror image of a component along axis `a` has for a sign.
    #[inline(always)]
    fn parity(&self, a: usize) -> f64 {
        if a == self.axis || self.wall == GridWall::Stick { -1.0 } else { 1.0 }
    }
}

/// The nodes near walls, and buffers for their values.
#[derive(Clone, Debug, Default)]
pub struct Walls {
    /// Nodes near walls, as indices of the grid's nodes.
    nodes: Vec<u32>,
    /// The walls in the order x low, x high, y low, …
    faces: [WallPlane; 6],
    /// Momentum, kg m/s, and mass, kg, of these nodes; after folding their velocities.
    momentum: Vec<[f64; 4]>,
    /// Impulse of the forces of this step on these nodes, N s; after folding changes of velocity.
    impulse: Vec<[f64; 4]>,
    /// Of each node of the grid: its index in `nodes`, or `NONE`.
    place: Vec<u32>,
}

impl Walls {
    /// Finds the nodes near the walls, given in the order x low, x high, y low, …; `size`: number of cells of the domain along each axis.
    pub fn find<const D: usize>(&mut self, blocks: &CellBlocks, walls: &[GridWall; 6], size: [i32; 3]) {
        self.nodes.clear();
        self.place.clear();
        self.place.resize(blocks.node_keys.len() * cells(D), NONE);
        for (side, face) in self.faces.iter_mut().enumerate() {
            let (axis, high) = (side / 2, side % 2 == 1);
            let sign = if high { -1.0 } else { 1.0 };
            (face.axis, face.sign, face.wall) = (axis, sign, walls[side]);
            std::mem::swap(&mut face.before.0, &mut face.keys);
            std::mem::swap(&mut face.before.1, &mut face.pressed);
            face.keys.clear();
            face.pressed.clear();
            face.triples.clear();
            if axis >= D || face.wall == GridWall::Open {
                continue;
            }
            let plane = if high { size[axis] } else { 0 };
            let inward = if high { -1 } else { 1 };
            for &key in &blocks.node_keys {
                let corner = block_corner(key);
                if plane < corner[axis] || plane >= corner[axis] + 4 {
                    continue;
                }
                for k in 0..cells(D) as i32 {
                    let at = [corner[0] + k % 4, corner[1] + k / 4 % 4, if D == 3 { corner[2] + k / 16 } else { 0 }];
                    if at[axis] != plane {
                        continue;
                    }
                    let triple = [-inward, 0, inward].map(|step| {
                        let mut at = at;
                        at[axis] += step;
                        let Some(node) = blocks.node::<D>(at) else { return NONE };
                        let place = &mut self.place[node as usize];
                        if *place == NONE {
                            *place = self.nodes.len() as u32;
                            self.nodes.push(node);
                        }
                        *place
                    });
                    face.triples.push(triple);
                    let key = cell_key::<D>(at);
                    let old = face.before.0.binary_search(&key);
                    face.keys.push(key);
                    face.pressed.push(old.is_ok_and(|k| face.before.1[k]));
                }
            }
            face.contact.clear();
            face.contact.resize(face.triples.len(), false);
            face.find_images::<D>(walls, size);
        }
        self.momentum.resize(self.nodes.len(), [0.0; 4]);
        self.impulse.resize(self.nodes.len(), [0.0; 4]);
    }

    /// The nodes near walls, as indices of the grid's nodes.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Writes the velocities of the nodes near walls, from the momentum of the nodes. A wall with friction that acted in [`Self::accelerate`] of this step
    /// still acts: where material rests, momentum alone would decide by rounding.
    pub fn project(&mut self, momentum: &[[f64; 4]], velocity: &mut [[f64; 4]]) {
        for (k, &node) in self.nodes.iter().enumerate() {
            self.momentum[k] = momentum[node as usize];
            self.impulse[k] = [0.0; 4];
        }
        self.fold(&mut [[0.0; 3]; 6], true);
        for (k, &node) in self.nodes.iter().enumerate() {
            velocity[node as usize] = self.momentum[k];
        }
    }

    /// Writes velocities and changes of velocity of the nodes near walls, from their momentum and from the changes that they would have without walls.
    /// Returns the impulse of each wall on the material, N s.
    pub fn accelerate(&mut self, momentum: &[[f64; 4]], velocity: &mut [[f64; 4]], change: &mut [[f64; 4]]) -> [[f64; 3]; 6] {
        let mut reaction = [[0.0; 3]; 6];
        for (k, &node) in self.nodes.iter().enumerate() {
            let (p, dv) = (momentum[node as usize], change[node as usize]);
            self.momentum[k] = p;
            self.impulse[k] = [p[3] * dv[0], p[3] * dv[1], p[3] * dv[2], 0.0];
        }
        self.fold(&mut reaction, false);
        for face in &mut self.faces {
            face.pressed.copy_from_slice(&face.contact);
        }
        for (k, &node) in self.nodes.iter().enumerate() {
            velocity[node as usize] = self.momentum[k];
            change[node as usize][..3].copy_from_slice(&self.impulse[k][..3]);
        }
        reaction
    }

    /// Folds momentum and impulse at the walls, divides by the mass, and mirrors velocities back to the nodes behind the walls. `held`: walls that acted at
    /// the last acceleration act in any case.
    fn fold(&mut self, reaction: &mut [[f64; 3]; 6], held: bool) {
        let (p, i) = (&mut self.momentum, &mut self.impulse);
        for (face, reaction) in self.faces.iter_mut().zip(&mut *reaction).filter(|(face, _)| !face.rubs()) {
            // most rows of a block of nodes are empty
            for triple in &face.triples {
                if triple.iter().any(|&k| k != NONE && p[k as usize][3] > 0.0) {
                    face.hold(*triple, p, i, reaction);
                }
            }
            face.contact.fill(true);
        }
        if self.faces.iter().any(WallPlane::rubs) {
            friction::rub(&mut self.faces, p, i, reaction, held);
        }
        for (p, i) in p.iter_mut().zip(i.iter_mut()) {
            let m = p[3];
            let over = |q: f64| if m > 0.0 { q / m } else { 0.0 };
            *p = [over(p[0]), over(p[1]), over(p[2]), 0.0];
            *i = [over(i[0]), over(i[1]), over(i[2]), 0.0];
        }
        // if the domain is one cell wide, the wall opposite has folded onto this plane meanwhile
        for face in &self.faces {
            for (&[_, on, _], _) in face.triples.iter().zip(&face.contact).filter(|(_, contact)| **contact) {
                for a in (0..3).filter(|&a| a == face.axis || face.wall == GridWall::Stick) {
                    (p[on as usize][a], i[on as usize][a]) = (0.0, 0.0);
                }
            }
        }
        // against the order of folding: what lies behind two walls is the image of an image
        let rubs = |face: &&WallPlane| face.rubs();
        let backwards = self.faces.iter().rev();
        for face in backwards.clone().filter(rubs).chain(backwards.filter(|face| !rubs(face))) {
            for (&[behind, _, before], _) in face.triples.iter().zip(&face.contact).filter(|(_, contact)| **contact) {
                if behind != NONE && before != NONE {
                    for a in 0..3 {
                        let mirrored = |x: f64| if face.parity(a) < 0.0 { 0.0 - x } else { x };
                        p[behind as usize][a] = mirrored(p[before as usize][a]);
                        i[behind as usize][a] = mirrored(i[before as usize][a]);
                    }
                }
            }
        }
    }

    /// Memory in use, bytes.
    pub fn bytes(&self) -> usize {
        let faces: usize =
            self.faces.iter().map(|f| 36 * f.triples.capacity() + 8 * (f.push.capacity() + f.images.capacity())).sum();
        faces + 4 * (self.nodes.capacity() + self.place.capacity()) + 32 * (self.momentum.capacity() + self.impulse.capacity())
    }
}

impl WallPlane {
    /// Folds three nodes in a row across a wall that holds the material. Adds the impulse of the wall to `reaction`.
    #[inline(always)]
    fn hold(&self, triple: Triple, p: &mut [[f64; 4]], i: &mut [[f64; 4]], reaction: &mut [f64; 3]) {
        let on = triple[1] as usize;
        let given = needed(triple, i);
        self.mirror(triple, p, i);
        for a in (0..3).filter(|&a| self.parity(a) < 0.0) {
            reaction[a] += given[a];
            (p[on][a], i[on][a]) = (0.0, 0.0);
        }
    }

    /// Adds what the node behind the wall has, mirrored, to the node in front of it.
    #[inline(always)]
    fn mirror(&self, [behind, _, before]: Triple, p: &mut [[f64; 4]], i: &mut [[f64; 4]]) {
        if behind == NONE || before == NONE {
            return;
        }
        let (p_behind, i_behind) = (p[behind as usize], i[behind as usize]);
        let before = before as usize;
        for a in 0..3 {
            p[before][a] += self.parity(a) * p_behind[a];
            i[before][a] += self.parity(a) * i_behind[a];
        }
        p[before][3] += p_behind[3];
        (p[behind as usize], i[behind as usize]) = ([0.0; 4], [0.0; 4]);
    }
}

/// Impulse that a wall must give so that nothing passes: minus the sum over the node on the plane and, twice with its image, the node behind.
#[inline(always)]
fn needed([behind, on, _]: Triple, i: &[[f64; 4]]) -> [f64; 3] {
    let i_behind = if behind == NONE { [0.0; 4] } else { i[behind as usize] };
    std::array::from_fn(|a| 0.0 - (i[on as usize][a] + 2.0 * i_behind[a]))
}
