//! Where grains come from: random filling with radius expansion (rig::preparation), or a file (scene, record::specimen).

use crate::gradation::stratified_diameters;
use crate::model::Specimen;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

/// Radii, m, of a specimen's grains in the order of their ids: stratified draws from the gradation, so that the gradation is met
/// whatever the seed.
pub fn radii(specimen: &Specimen, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    stratified_diameters(&specimen.gradation, specimen.grains, &mut rng).into_iter().map(|d| 0.5 * d).collect()
}

/// Random points in a vertical cylinder about the z axis (bottom at 0), each at least `margins[i]` from its surface where there is room.
pub fn random_points(radius: f64, height: f64, margins: &[f64], seed: u64) -> Vec<[f64; 3]> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x9e37_79b9_7f4a_7c15);
    margins
        .iter()
        .map(|&m| {
            let inner = (radius - m).max(0.1 * radius);
            let (x, y) = loop {
                let (x, y) = (rng.random_range(-inner..inner), rng.random_range(-inner..inner));
                if x * x + y * y < inner * inner {
                    break (x, y);
                }
            };
            let span = (height - 2.0 * m).max(0.1 * height);
            [x, y, 0.5 * (height - span) + span * rng.random::<f64>()]
        })
        .collect()
}

/// Height of a cylinder of this radius in which the given volume of grains has the porosity.
pub fn height_for(porosity: f64, grains_volume: f64, radius: f64) -> f64 {
    grains_volume / ((1.0 - porosity) * PI * radius * radius)
}
