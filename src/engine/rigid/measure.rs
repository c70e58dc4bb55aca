//! Measures of rigid bodies for records: energies, momentum, forces.

use super::{Block, Blocks, Other};
use crate::dem::physics::Physics;
use crate::math::vector::{dot, plus, scaled};

impl Block {
    /// One line that describes the body for a reader: shape, material, extents as it is rotated, mass.
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
        format!("{kind} of {material}, {dx} × {dy} × {dz} mm{turned}, {:.6} kg", self.mass)
    }
}

impl Blocks {
    /// Mass, kg, and momentum, kg m/s, of all bodies.
    pub fn mass_and_momentum(&self) -> (f64, [f64; 3]) {
        self.blocks.iter().fold((0.0, [0.0; 3]), |(mass, sum), b| (mass + b.mass, plus(sum, scaled(b.velocity, b.mass))))
    }

    /// Kinetic energy, potential energy in gravity, and elastic energy of the contacts of all bodies, J. `energy_factor`: elastic energy of a contact over
    /// normal force times overlap.
    pub fn energies(&self, gravity: [f64; 3], energy_factor: f64) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for b in &self.blocks {
            sums[0] += b.kinetic();
            sums[1] -= b.mass * dot(gravity, b.centre);
        }
        sums[2] = self.touching().map(|c| c.energy(energy_factor)).sum();
        sums
    }

    /// Force, N, of points, of grains and of walls on body `block`.
    pub fn forces(&self, block: usize) -> [[f64; 3]; 3] {
        let mut sums = [[0.0; 3]; 3];
        for c in self.touching().filter(|c| c.block as usize == block) {
            let k = match c.other {
                Other::Point(_) => 0,
                Other::Grain(_) => 1,
                Other::Wall { .. } => 2,
            };
            sums[k] = plus(sums[k], c.touch.force());
        }
        sums
    }
}
