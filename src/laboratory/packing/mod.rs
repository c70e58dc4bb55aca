//! Random sizes and first places of grains, from which preparation ([`crate::rig::preparation`]) makes specimens; random shapes of rigid bodies and their packings.

pub mod blocks;
pub mod shapes;

use crate::gradation::stratified_diameters;
use crate::model::Specimen;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

/// Radii, m, of a specimen's grains in the order of their ids. The draws are stratified: every seed gives nearly the gradation of
/// the scene.
pub fn radii(specimen: &Specimen, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    stratified_diameters(&specimen.gradation, specimen.grains, &mut rng).into_iter().map(|d| 0.5 * d).collect()
}

/// Random points in a vertical cylinder about the z axis, bottom at z = 0; all lengths m. Point `i` is at least `margins[i]` from
/// the surface of the cylinder, where the cylinder is large enough.
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

/// Height, m, of a cylinder of radius `radius`, m, in which grains of volume `grains_volume`, m³, have the porosity `porosity`.
pub fn height_for(porosity: f64, grains_volume: f64, radius: f64) -> f64 {
    grains_volume / ((1.0 - porosity) * PI * radius * radius)
}

/// Radii, m, drawn uniformly between `radii[0]` and `radii[1]` until the volume of all spheres is as near to `volume`, m³, as
/// whole spheres allow.
pub fn sizes(radii: [f64; 2], volume: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut sizes = Vec::new();
    let mut sum = 0.0;
    loop {
        let r = radii[0] + (radii[1] - radii[0]) * rng.random::<f64>();
        let v = engine::grains::sphere_volume(r);
        if sum + 0.5 * v > volume {
            return sizes;
        }
        sum += v;
        sizes.push(r);
    }
}

/// Random places that [`dispersed`] tries for one sphere before it gives up.
const TRIES: u32 = 200_000;

/// Places spheres at random in a box with lower corner `lower` and size `size`, or where `round` in the upright cylinder in this
/// box. Radii are those of [`sizes`] for `radii` and `volume`; gaps between spheres, and to the sides, are at least `room`. All
/// lengths m. Gives centre and radius of each sphere.
///
/// # Errors
/// The volume, m³, of the spheres that found a place, where not all did.
pub fn dispersed(
    lower: [f64; 3],
    size: [f64; 3],
    round: bool,
    radii: [f64; 2],
    volume: f64,
    room: f64,
    seed: u64,
) -> Result<Vec<([f64; 3], f64)>, f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // the largest first: later there is no room for them
    let mut sizes = sizes(radii, volume, &mut rng);
    sizes.sort_unstable_by(|a, b| b.total_cmp(a));
    let mut spheres: Vec<([f64; 3], f64)> = Vec::with_capacity(sizes.len());
    let mut placed = 0.0;
    for r in sizes {
        let margin = r + room;
        let inside = |c: &[f64; 3]| {
            let [x, y] = [0, 1].map(|a| c[a] - lower[a] - 0.5 * size[a]);
            let most = 0.5 * size[0] - margin;
            !round || x * x + y * y <= most * most
        };
        let free = |c: &[f64; 3]| {
            inside(c)
                && spheres.iter().all(|(p, q)| {
                    let reach = r + q + room;
                    (0..3).map(|a| (p[a] - c[a]) * (p[a] - c[a])).sum::<f64>() >= reach * reach
                })
        };
        if size.iter().any(|s| *s < 2.0 * margin) {
            return Err(placed);
        }
        let mut draw = || std::array::from_fn(|a| lower[a] + margin + (size[a] - 2.0 * margin) * rng.random::<f64>());
        let Some(centre) = (0..TRIES).map(|_| draw()).find(|c| free(c)) else { return Err(placed) };
        spheres.push((centre, r));
        placed += engine::grains::sphere_volume(r);
    }
    Ok(spheres)
}
