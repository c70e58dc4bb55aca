//! Gradations of the grains of a run: now, before loading, and as rows of `gsd.csv`.

use crate::gradation::{Gradation, Indices, sieve_sizes};
use crate::model::{GrainSpec, Model};
use engine::dem::State;
use engine::grains::{Grains, sphere_volume};
use table::Row;

/// Number of sizes at which a gradation is written.
const SIEVES: usize = 121;

/// The present gradation, with the mass that breakages have lost spread over sizes (Ciantia et al. 2015, eq. 12).
pub fn gradation(model: &Model, state: &State) -> Gradation {
    let g = &state.grains;
    let radii = state.aftermath.radii(g);
    let grains = g.by_id().into_iter().map(|i| (2.0 * radii[i as usize], g.mass[i as usize]));
    Gradation::new(grains, state.lost.iter().copied(), model.fines, model.scale)
}

/// Relative breakage of Hardin and of Einav, and the part beyond Einav's ultimate gradation; NaN where they are not defined.
pub fn breakage(indices: Option<&Indices>) -> [f64; 3] {
    let of = |f: fn(&Indices) -> Option<f64>| indices.and_then(f).unwrap_or(f64::NAN);
    [of(|i| i.hardin_br), of(|i| i.einav_br), of(|i| i.einav_beyond)]
}

/// The columns of a history with diameters and indices of the present gradation.
pub fn columns(indices: Option<&Indices>) -> Row {
    let of = |f: fn(&Indices) -> f64| indices.map_or(f64::NAN, f);
    let [hardin, einav, beyond] = breakage(indices);
    vec![
        ("d10_mm", (1e3 * of(|i| i.d10)).into()),
        ("d30_mm", (1e3 * of(|i| i.d30)).into()),
        ("d50_mm", (1e3 * of(|i| i.d50)).into()),
        ("d60_mm", (1e3 * of(|i| i.d60)).into()),
        ("cu", of(|i| i.cu).into()),
        ("cc", of(|i| i.cc).into()),
        ("hardin_br", hardin.into()),
        ("einav_br", einav.into()),
        ("einav_beyond", beyond.into()),
    ]
}

/// The gradation of rigid bodies, given by the square sieve that each passes, m, and its mass, kg; they lose none. A sheet has no mass.
pub fn of_bodies(model: &Model, bodies: impl Iterator<Item = (f64, f64)>) -> Gradation {
    Gradation::new(bodies.filter(|(_, mass)| *mass > 0.0), std::iter::empty(), model.fines, model.scale)
}

/// The gradation of a specimen before loading.
pub fn initial(model: &Model, g: &Grains) -> Gradation {
    let grains = (0..g.len()).map(|i| (2.0 * g.radius(i), g.mass[i]));
    Gradation::new(grains, std::iter::empty(), model.fines, model.scale)
}

/// The gradation of the grains of a scene.
pub fn of_listed(model: &Model, grains: &[GrainSpec]) -> Gradation {
    let mass = |g: &GrainSpec| model.physics.materials[usize::from(g.material)].density * sphere_volume(g.radius);
    let grains = grains.iter().map(|g| (2.0 * g.radius, mass(g)));
    Gradation::new(grains, std::iter::empty(), model.fines, model.scale)
}

/// An instant of a test, as it stands beside a gradation.
#[derive(Clone, Copy, Debug)]
pub struct At {
    /// Step.
    pub step: u64,
    /// Name of the stage.
    pub stage: &'static str,
    /// Vertical stress, Pa, compression positive.
    pub sigma_v: f64,
    /// Axial strain, compression positive.
    pub axial_strain: f64,
}

/// Rows of `gsd.csv` for the gradation `now`; the largest size is that of `initial`.
pub fn rows(model: &Model, now: &Gradation, at: &At, initial: &Gradation) -> Vec<Row> {
    let sizes = sieve_sizes(model.fines.d_min / model.scale, initial.largest().unwrap_or(model.fines.d_min), SIEVES);
    let (all, grains) = (now.curve(&sizes), now.curve_grains(&sizes));
    sizes
        .iter()
        .zip(all.iter().zip(&grains))
        .map(|(&d, (&a, &g))| -> Row {
            vec![
                ("step", at.step.into()),
                ("stage", at.stage.into()),
                ("sigma_v_kPa", (at.sigma_v * 1e-3).into()),
                ("axial_strain", at.axial_strain.into()),
                ("diameter_mm", (d * 1e3).into()),
                ("passing_percent", (a * 100.0).into()),
                ("passing_percent_grains", (g * 100.0).into()),
            ]
        })
        .collect()
}
