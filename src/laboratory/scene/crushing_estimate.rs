//! The crushing strength F/d² of a single grain of the scene between platens, as laboratories state it.

use super::crushing::{grain_materials, loose, rigid_platens};
use super::estimate::median;
use crate::model::{Model, Rig, Subject};
use engine::breakage::crushing_stress::Quoted;
use serde::Serialize;

/// Range of the mean F/d², MPa, of grains of soils and bulk goods, from loose agglomerates to single crystals of a tenth of a
/// millimetre. A value in a unit that is wrong by a factor of 1000 lies outside.
const USUAL: [f64; 2] = [0.5, 5000.0];

/// Mean crushing stress at the median size of the scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CrushingStress {
    /// Diameter of the grain, mm, without the scale of the specimen.
    pub d_mm: f64,
    /// Mean F/d² between rigid platens, MPa.
    #[serde(rename = "mean_MPa")]
    pub mean_mpa: f64,
}

impl CrushingStress {
    /// A warning for a strength that no real grain has.
    pub fn warning(&self) -> Option<String> {
        let [low, high] = USUAL;
        let beyond = !(low..=high).contains(&self.mean_mpa);
        beyond.then(|| {
            format!(
                "a single grain of {:.3} mm breaks at a mean F/d^2 of {:.3e} MPa, outside the {low} to {high} MPa of real grains: check the unit (MPa), and that sigma_lim0 was not given a value of F/d^2 (crushing_stress_MPa takes one)",
                self.d_mm, self.mean_mpa
            )
        })
    }
}

/// The mean crushing strength by the scene's strength distribution; `None` where no grain breaks.
pub fn crushing_stress(model: &Model) -> Option<CrushingStress> {
    let crush = model.physics.crush.as_ref()?;
    let number = grain_materials(&model.rig).and_then(|all| all.first().copied()).unwrap_or(0);
    let material = model.physics.materials.get(usize::from(number))?;
    let d = middle_size(&model.rig)?;
    let e_eff = rigid_platens((material.young, material.poisson));
    let mean = crush.strength.crushing_stress(crush.criterion, e_eff, d, Quoted::Mean);
    Some(CrushingStress { d_mm: 1e3 * d / model.scale, mean_mpa: 1e-6 * mean })
}

/// Median diameter of the grains by mass, m.
fn middle_size(rig: &Rig) -> Option<f64> {
    let listed = match rig.subject() {
        Subject::Specimen(s) => return Some(median(&s.gradation)),
        Subject::GrainCrushing(p) => p.diameters.clone(),
        Subject::Assembly(a) => a.grains.iter().map(|g| 2.0 * g.radius).collect(),
        Subject::Continuum(rig) => match &rig.growth {
            Some(growth) => {
                let [low, high] = growth.coarse.unwrap_or(growth.fines).radii;
                return Some(low + high);
            }
            None => {
                let coarse = rig.coarse.as_ref()?;
                coarse.grains.iter().map(|g| g.radius).chain(loose(&coarse.blocks).map(|b| b.radius)).map(|r| 2.0 * r).collect()
            }
        },
    };
    by_mass(listed)
}

/// Diameter below which half of the mass of these spheres is.
fn by_mass(mut diameters: Vec<f64>) -> Option<f64> {
    diameters.sort_by(f64::total_cmp);
    let half = 0.5 * diameters.iter().map(|d| d * d * d).sum::<f64>();
    let mut sum = 0.0;
    diameters.into_iter().find(|d| {
        sum += d * d * d;
        sum >= half
    })
}
