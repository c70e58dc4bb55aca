//! Makes the specimen of a test of rigid bodies without points: the box of the scene's sets, and how the bodies come to rest in it.

use super::bodies::vector;
use super::view::View;
use crate::model::continuum::{Bed, MpmSpecimen};
use engine::contact::ContactLaw;
use engine::material::Material;
use engine::mpm::Dimension;
use engine::rigid::Block;

impl View<'_> {
    /// The specimen between platens at the sides of the box that the sets of bodies fill, as far as it does not depend on the bodies ([`Self::bodies_fill`]); `None`, with the reason noted, where
    /// the scene is refused.
    pub fn bed(&self, dimension: Dimension, axial_strain: f64) -> Option<MpmSpecimen> {
        let sets = self.list("block_set");
        if sets.is_empty() {
            let rig = self.text("test.rig");
            self.refuse(
                "block_set",
                format!("is missing: without a [[body]] of points test.rig = \"{rig}\" needs one, whose box is the specimen"),
            );
            return None;
        }
        let corner = |name: &str| sets.iter().map(|t| vector(t, name)).collect::<Option<Vec<_>>>();
        let fold = |of: Vec<[f64; 3]>, f: fn(f64, f64) -> f64| of.into_iter().reduce(|a, b| std::array::from_fn(|k| f(a[k], b[k])));
        let (low, high) = (fold(corner("min_mm")?, f64::min)?, fold(corner("max_mm")?, f64::max)?);
        let flat = dimension == Dimension::PlaneStrain;
        let stress = if self.text("test.rig") == "triaxial" {
            self.check(
                !self.has(SEATING),
                SEATING,
                "has no meaning with test.rig = \"triaxial\": bodies come to rest under the cell pressure",
            );
            self.number("test.cell_pressure_kPa")
        } else {
            let stress = self.number(SEATING);
            if stress.is_none() {
                self.refuse(
                    SEATING,
                    "is missing: an oedometer of rigid bodies needs the stress under which they come to rest before it begins",
                );
            }
            stress
        };
        for key in ["test.contact_modulus_MPa", "stepping.points_inertia"] {
            let own = if key.starts_with("test") { self.number(key).is_none() } else { self.si(key) == 1.0 };
            self.check(own, key, "has no meaning without a [[body]] of points");
        }
        for key in ["coarse.mass_fraction", "coarse.diameter_mm", "coarse.material"] {
            self.check(!self.has(key), key, "has no meaning without a [[body]] of points");
        }
        Some(MpmSpecimen {
            lower: low,
            size: std::array::from_fn(|a| if flat && a == 2 { 1.0 } else { high[a] - low[a] }),
            round: false,
            stress: 0.0,
            spacing: 0.0,
            porosity: 0.0,
            law: 0,
            density: 0.0,
            lattice: false,
            modulus: 0.0,
            axial_strain,
            strain_per_wave: self.si("test.strain_per_wave"),
            gain: self.si("test.servo_gain"),
            bed: Some(Bed { stress: stress?, friction: self.number("growth.friction"), diameter: 0.0, modulus: 0.0 }),
        })
    }

    /// Notes in a specimen of rigid bodies what depends on them: porosity and density at the start, and the modulus under the stress at which loading begins. `None`, with the reason noted, where they fill
    /// nothing.
    pub fn bodies_fill(
        &self,
        specimen: &mut MpmSpecimen,
        dimension: Dimension,
        blocks: &[Block],
        materials: &[Material],
    ) -> Option<()> {
        let Some(bed) = &mut specimen.bed else { return Some(()) };
        let room: f64 = specimen.size.iter().product();
        let sums = blocks.iter().fold([0.0; 3], |[mass, volume, weighted], b| {
            let v = solid_volume(b, materials);
            [mass + b.mass, volume + v, weighted + v * 2.0 * b.radius]
        });
        let [mass, volume, weighted] = sums;
        let material = &materials[usize::from(blocks.first()?.material)];
        specimen.porosity = 1.0 - volume / room;
        specimen.density = mass / room;
        bed.diameter = weighted / volume;
        bed.modulus = lattice_modulus(self.law(), material, bed.diameter, bed.stress, dimension);
        Some(())
    }
}

/// Volume of a body that has a mass, m³ (m² in plane strain); 0 of a mesh.
pub fn solid_volume(block: &Block, materials: &[Material]) -> f64 {
    block.mass / materials[usize::from(block.material)].density
}

/// Key of the stress under which bodies come to rest in an oedometer.
pub const SEATING: &str = "test.seating_kPa";

/// Modulus, Pa, of a cubic lattice of equal spheres of diameter `d`, m, that bears `stress`, Pa, along one axis: a contact bears σ d² and gives way by d dε, so M = k_n/d; in plane strain σ d per
/// metre, and M = k_n.
fn lattice_modulus(law: ContactLaw, material: &Material, d: f64, stress: f64, dimension: Dimension) -> f64 {
    let (force, per) = if dimension == Dimension::Space { (stress * d * d, 1.0 / d) } else { (stress * d, 1.0) };
    let (r_eff, pair) = (0.25 * d, law.between(material, material));
    let overlap = law.overlap_under(force, r_eff, &pair);
    law.elastic(overlap, overlap, r_eff, &pair).k_n * per
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lattice_of_spheres_stiffens_with_the_cube_root_of_the_stress() {
        let material = Material {
            name: "glass".into(),
            density: 2500.0,
            internal_porosity: 0.0,
            young: 70e9,
            poisson: 0.2,
            friction: 0.5,
            rolling_friction: 0.0,
            interface_friction: None,
            contact: Default::default(),
        };
        let of = |d, stress| lattice_modulus(ContactLaw::Hertz, &material, d, stress, Dimension::Space);
        // Hertz: F = 4/3 E* √R* δ^1.5 with E* = E/(2 (1 - ν²)) and R* = d/4 gives M = 1.5 σ d/δ
        let (d, stress) = (0.01_f64, 1e5);
        let e_star = 0.5 * 70e9 / (1.0 - 0.04);
        let overlap = (stress * d * d / (4.0 / 3.0 * e_star * (0.25 * d).sqrt())).powf(2.0 / 3.0);
        let expected = 1.5 * stress * d / overlap;
        assert!((of(d, stress) / expected - 1.0).abs() < 1e-9, "{} {expected}", of(d, stress));
        // of the stress alone, not of the size
        assert!((of(0.1, stress) / expected - 1.0).abs() < 1e-9);
        assert!((of(d, 8.0 * stress) / expected - 2.0).abs() < 1e-9);
    }
}
