//! Makes the coarse fraction and the growth of a mixture's specimen from their keys.

use super::material::Named;
use super::view::View;
use crate::model::continuum::{Fraction, Growth, MpmSpecimen};
use engine::material::Material;

/// Most grains of a fraction.
const MOST: usize = 100_000_000;

impl View<'_> {
    /// Material, smallest and largest radius, m, and share of the mass of a specimen's coarse grains, if it has some; `None`,
    /// with the reason noted, where the scene is refused.
    pub fn coarse_grains(&self, named: &[Named]) -> Option<Option<(u8, [f64; 2], f64)>> {
        let keys = ["coarse.mass_fraction", "coarse.diameter_mm", "coarse.material"];
        let there = keys.map(|k| self.has(k));
        if there == [false; 3] {
            return Some(None);
        }
        if let Some(k) = there.iter().position(|t| !t) {
            self.refuse(keys[k], format!("is missing: {} go together", keys.join(", ")));
            return None;
        }
        let share = self.si(keys[0]);
        let material = self.lookup(keys[2], self.text(keys[2]), named)?;
        Some(Some((material, self.radii(keys[1])?, share)))
    }

    /// Refuses a share of coarse grains whose volume, m³, is less than that of one grain.
    pub fn at_least_one(&self, radii: [f64; 2], volume: f64, share: f64) {
        let one = Fraction { material: 0, radii, volume };
        let message =
            format!("is too large: {share} of the mass is {volume:.3e} m³ of coarse grains, less than one grain of this size");
        self.check(share == 0.0 || one.count() > 0, "coarse.diameter_mm", message);
    }

    /// Refuses more grains than a run can number; `None` where they are too many.
    pub fn not_too_many(&self, key: &str, of: &Fraction) -> Option<()> {
        let count = of.count();
        if count > MOST {
            let message = format!("would be some {count} grains; at most {MOST} are made: use larger ones or a smaller body");
            self.refuse(key, message);
            return None;
        }
        Some(())
    }

    /// How a specimen grows, if the scene asks for it; `None`, with the reason noted, where the scene is refused.
    pub fn growth(
        &self,
        named: &[Named],
        materials: &[Material],
        point_materials: &[u8],
        specimen: Option<&MpmSpecimen>,
    ) -> Option<Option<Growth>> {
        let (key, others) = ("growth.fines_diameter_mm", ["growth.friction", "specimen.file"]);
        if !self.has(key) {
            // bodies without points are pressed to rest as well
            let bed = specimen.is_some_and(|s| s.bed.is_some());
            for other in others {
                self.check(!self.has(other) || bed && other == others[0], other, format!("has no meaning without {key}"));
            }
            self.check(self.text("growth.fines") == "points", "growth.fines", format!("must be \"points\" without {key}"));
            return Some(None);
        }
        let Some(specimen) = specimen else {
            self.refuse(key, "has no meaning with test.rig = \"free\"");
            return None;
        };
        self.check(self.list("grain").is_empty(), key, "has no meaning beside listed grains");
        self.check(!self.has_blocks(), key, "has no meaning beside [[block]] and [[block_set]]: spheres would grow into them");
        self.check(!specimen.round, key, "must be left out where body[0].shape = \"cylinder\": only boxes grow");
        if specimen.stress <= 0.0 {
            self.refuse(key, "needs a stress to press the specimen with: body.stress_kPa, or the cell pressure");
            return None;
        }
        let material = point_materials[usize::from(specimen.law)];
        // all solids fill the box at its porosity
        let solids = (1.0 - specimen.porosity) * specimen.size.iter().product::<f64>();
        let density = |m: u8| materials[usize::from(m)].density;
        let coarse = self.coarse_grains(named)?.map(|(of, radii, share)| {
            let (coarse, fine) = (share / density(of), (1.0 - share) / density(material));
            let volume = solids * coarse / (coarse + fine);
            self.at_least_one(radii, volume, share);
            Fraction { material: of, radii, volume }
        });
        let volume = solids - coarse.map_or(0.0, |c| c.volume);
        let fines = Fraction { material, radii: self.radii(key)?, volume };
        self.not_too_many(key, &fines)?;
        coarse.iter().try_for_each(|coarse| self.not_too_many("coarse.diameter_mm", coarse))?;
        Some(Some(Growth {
            fines,
            coarse,
            as_points: self.text("growth.fines") == "points",
            friction: self.number("growth.friction"),
            stress: specimen.stress,
            steps: self.whole("growth.steps")?,
            max_steps: self.whole("growth.max_steps")?,
        }))
    }

    /// Smallest and largest radius, m, of a key with two diameters.
    fn radii(&self, key: &str) -> Option<[f64; 2]> {
        let [low, high]: [f64; 2] = self.numbers(key).try_into().ok()?;
        if low > high {
            self.refuse(key, "must be the smallest, then the largest");
            return None;
        }
        Some([0.5 * low, 0.5 * high])
    }
}
