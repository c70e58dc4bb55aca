//! Measures of rigid bodies for records: energies, momentum, forces.

use super::contact::PosedBlock;
use super::pair::{Outline, meeting, sites};
use super::{Block, Blocks, Other};
use crate::dem::physics::Physics;
use crate::grains::Grains;
use crate::math::vector::{dot, less, plus, scaled};
use crate::mpm::Continuum;
use crate::shape::{Hull, Part, Shape, Sheet, Solid};

impl Block {
    /// One line that describes the body for a reader: shape, material, extents as it is rotated, mass; of a sheet its triangles and facets.
    pub fn in_words(&self, physics: &Physics) -> String {
        let [w, x, y, z] = self.turn;
        let pose = self.pose(0.0);
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in self.solid().surface().corners {
            let p = pose.outwards(p);
            (low, high) = (std::array::from_fn(|a| low[a].min(p[a])), std::array::from_fn(|a| high[a].max(p[a])));
        }
        let [dx, dy, dz] = std::array::from_fn(|a| format!("{:.4}", 1e3 * (high[a] - low[a])));
        let turned = if [w, x, y, z] == [1.0, 0.0, 0.0, 0.0] { "" } else { " as it is turned" };
        let (kind, material) = (self.shape.name(), &physics.materials[usize::from(self.material)].name);
        if let Some(sheet) = self.solid().sheet() {
            let (triangles, facets) = (sheet.triangles(), sheet.facets());
            let form = if sheet.is_closed() { "closed" } else { "open" };
            return format!(
                "{kind} of {material}, {triangles} triangles in {facets} facets, {form}, {dx} × {dy} × {dz} mm{turned}"
            );
        }
        let parts =
            if let Shape::Compound(compound) = &self.shape { format!(" of {} parts", compound.parts()) } else { String::new() };
        format!("{kind} of {material}{parts}, {dx} × {dy} × {dz} mm{turned}, {:.6} kg", self.mass)
    }
}

impl Block {
    /// Deepest overlap with another body, m; negative if they are apart, infinite if it is deeper than the edges of both are round (of compounds part by part) or a sheet cuts the other.
    pub fn overlap(&self, other: &Block) -> f64 {
        let [a, b] = [self, other].map(Outline::of);
        let (first, second) = (PosedBlock::new(self, Some(&a), 0.0), PosedBlock::new(other, Some(&b), 0.0));
        let corners =
            |of: &Outline, body: &PosedBlock<'_>| of.body.corners().iter().map(|c| body.pose.place(*c)).collect::<Vec<_>>();
        let cut = match (a.body.sheet(), b.body.sheet()) {
            (None, None) => {
                let [a, b] = [(&a, &first), (&b, &second)].map(|(of, body)| placed(&of.body.parts(), body));
                a.iter().any(|p| b.iter().any(|q| p.cuts(q)))
            }
            (Some(sheet), None) => cuts(sheet, &first, &corners(&b, &second)),
            (None, Some(sheet)) => cuts(sheet, &second, &corners(&a, &first)),
            (Some(_), Some(_)) => false,
        };
        if cut {
            return f64::INFINITY;
        }
        let overlap = |site| meeting(&first, &second, site, None, 0.0).map_or(f64::NEG_INFINITY, |m| m.overlap.depth);
        let deepest = sites(&first, &second, 0.0).into_iter().map(overlap).fold(f64::NEG_INFINITY, f64::max);
        let smooth = a.body.is_smooth() || b.body.is_smooth();
        if smooth && deepest >= a.body.rounding() + b.body.rounding() { f64::INFINITY } else { deepest }
    }
}

/// Convex parts of a body, in space.
fn placed(parts: &[Part], body: &PosedBlock<'_>) -> Vec<Part> {
    parts.iter().map(|part| part.moved(|p| body.pose.place(p))).collect()
}

/// Whether a sheet cuts the hull of these corners in space.
fn cuts(sheet: &Sheet, body: &PosedBlock<'_>, corners: &[[f64; 3]]) -> bool {
    let corners: Vec<[f64; 3]> = corners.iter().map(|c| body.pose.within(*c)).collect();
    let Some(first) = corners.first() else { return false };
    let half = corners.iter().flat_map(|c| (0..3).map(|a| (c[a] - first[a]).abs())).fold(0.0, f64::max);
    Hull::cut_by(&corners, &sheet.triangles_near(*first, half))
}

impl Blocks {
    /// Mass, kg, and momentum, kg m/s, of all bodies.
    pub fn mass_and_momentum(&self) -> (f64, [f64; 3]) {
        self.blocks.iter().fold((0.0, [0.0; 3]), |(mass, sum), b| (mass + b.mass, plus(sum, scaled(b.velocity, b.mass))))
    }

    /// Kinetic energy, potential energy in gravity, and elastic energy of the contacts and joints of all bodies, J. `energy_factor`: elastic energy of a contact over
    /// normal force times overlap.
    pub fn energies(&self, gravity: [f64; 3], energy_factor: f64) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for b in &self.blocks {
            sums[0] += b.kinetic();
            sums[1] -= b.mass * dot(gravity, b.centre);
        }
        sums[2] = self.touching().map(|c| c.energy(energy_factor)).sum();
        if self.drives().is_some() {
            sums[2] += self.stored_in_joints();
        }
        sums
    }

    /// Force, N, of points, of grains, of walls and of other bodies on each body.
    pub fn all_forces(&self) -> Vec<[[f64; 3]; 4]> {
        let mut sums = vec![[[0.0; 3]; 4]; self.blocks.len()];
        let mut add = |body: u32, kind: usize, force| {
            let sum = &mut sums[body as usize][kind];
            *sum = plus(*sum, force);
        };
        for (body, [force, _]) in (0..).zip(self.forces_at_nodes()) {
            add(body, 0, *force);
        }
        for c in self.touching() {
            let force = c.force();
            match c.other {
                Other::Point(_) => add(c.block, 0, force),
                Other::Grain(_) => add(c.block, 1, force),
                Other::Wall { .. } => add(c.block, 2, force),
                Other::Block { block, .. } => {
                    add(c.block, 3, force);
                    add(block, 3, scaled(force, -1.0));
                }
            }
        }
        sums
    }

    /// Force, N, of points, of grains, of walls and of other bodies on body `block`; for many bodies [`Self::all_forces`].
    pub fn forces(&self, block: usize) -> [[f64; 3]; 4] {
        self.all_forces()[block]
    }

    /// Torque of all that touches body `block` and of its joints about its centre of mass, N m.
    pub fn torque(&self, block: usize) -> [f64; 3] {
        let mut sum = self.joint_torque(block);
        if let Some([_, torque]) = self.forces_at_nodes().get(block) {
            sum = plus(sum, *torque);
        }
        for c in self.touching() {
            if c.block as usize == block {
                sum = plus(sum, c.torque());
            }
            if matches!(c.other, Other::Block { block: second, .. } if second as usize == block) {
                sum = less(sum, c.torque_about(&self.blocks, block));
            }
        }
        sum
    }

    /// Calls `add` for each contact that touches with whether its other side is a point, the force on the body, N, and the vector from the body's centre to that of the other side, m: to
    /// where a wall is touched, and to where the force acts on a point. Their dyadic products make the Love–Weber stress of the contacts.
    pub fn branches(&self, grains: &Grains, continuum: &Continuum, mut add: impl FnMut(bool, [f64; 3], [f64; 3])) {
        let first = |[x, y, z, _]: [f64; 4]| [x, y, z];
        for c in self.touching() {
            let centre = self.blocks[c.block as usize].centre;
            let branch = match c.other {
                Other::Block { block, .. } => less(self.blocks[block as usize].centre, centre),
                Other::Grain(_) => less(first(grains.pos[c.place as usize]), centre),
                Other::Wall { .. } => c.arm,
                Other::Point(_) => {
                    let at = first(continuum.points().position[c.place as usize]);
                    let face = c.face.map_or([0.0; 3], |f| f.offset(c.radius, c.touch.overlap, continuum.settings().cell));
                    less(plus(at, face), centre)
                }
            };
            add(c.is_of_point(), c.force(), branch);
        }
    }

    /// Numbers of grains and bodies, of walls, and of points that touch a body, each pair counted once however many places it touches at. `normal` is called for each place where grains and bodies touch, with
    /// its unit normal.
    pub fn partners(&self, mut normal: impl FnMut([f64; 3])) -> [u64; 3] {
        let (mut counts, mut last) = ([0; 3], None);
        for c in self.touching() {
            let kind = match c.other {
                Other::Block { .. } | Other::Grain(_) => 0,
                Other::Wall { .. } => 1,
                Other::Point(_) => 2,
            };
            if kind == 0 {
                normal(c.touch.normal);
            }
            let pair = Some((c.block, c.other.partner()));
            // the list is sorted by both bodies
            counts[kind] += u64::from(pair != last);
            last = pair;
        }
        counts
    }

    /// Mean resultant of the contacts of a body over the mean force of a contact, -; small is near equilibrium. 0 without contacts. What drives and pushes bodies does not count.
    pub fn unbalanced_ratio(&self) -> f64 {
        let length = |f: [f64; 3]| dot(f, f).sqrt();
        let resultants = self.all_forces().into_iter().map(|parts| length(parts.into_iter().fold([0.0; 3], plus)));
        let mean = resultants.sum::<f64>() / self.blocks.len().max(1) as f64;
        let (sum, count) = self.touching().fold((0.0, 0.0), |(sum, count), c| (sum + length(c.force()), count + 1.0));
        if sum > 0.0 { mean / (sum / count) } else { 0.0 }
    }
}
