//! Gradations of the grains of a run: at an instant, before loading, and as rows of `gsd.csv`.

use super::table::Row;
use crate::gradation::{Gradation, sieve_sizes};
use crate::grains::{Grains, sphere_volume};
use crate::model::{GrainSpec, Model};
use crate::step::State;

/// Sizes at which a gradation is written.
const SIEVES: usize = 121;

/// Present gradation, lost mass reconstructed (eq. 12).
pub fn gradation(model: &Model, state: &State) -> Gradation {
    let g = &state.grains;
    let radii = state.aftermath.radii(g);
    let grains = g.by_id().into_iter().map(|i| (2.0 * radii[i as usize], g.mass[i as usize]));
    Gradation::new(grains, state.lost.iter().copied(), model.fines, model.scale)
}

/// Gradation of a specimen before loading.
pub fn initial(model: &Model, g: &Grains) -> Gradation {
    let grains = (0..g.len()).map(|i| (2.0 * g.pos[i][3], g.mass[i]));
    Gradation::new(grains, std::iter::empty(), model.fines, model.scale)
}

/// Gradation of grains that are listed.
pub fn of_listed(model: &Model, grains: &[GrainSpec]) -> Gradation {
    let mass = |g: &GrainSpec| model.materials[usize::from(g.material)].density * sphere_volume(g.radius);
    let grains = grains.iter().map(|g| (2.0 * g.radius, mass(g)));
    Gradation::new(grains, std::iter::empty(), model.fines, model.scale)
}

/// Where a test stands: its step and stage, vertical stress, Pa, and axial strain.
#[derive(Clone, Copy, Debug)]
pub struct At {
    pub step: u64,
    pub stage: &'static str,
    pub sigma_v: f64,
    pub axial_strain: f64,
}

/// Rows of `gsd.csv` for this instant.
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
