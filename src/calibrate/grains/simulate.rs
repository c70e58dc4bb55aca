//! Crushing tests made by the strength law of the engine itself, and the random numbers of calibration.

use super::area::Area;
use super::data::{Data, Grain};
use engine::breakage::strength::StrengthModel;
use engine::math::random::lineage_root;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::path::PathBuf;

/// Simulated tests of `each` grains of every size, m, with the strengths that the engine draws for
/// `seed`.
pub fn tests(law: &StrengthModel, area: &Area, sizes: &[f64], each: usize, seed: u64) -> Data {
    let mut grains = Vec::with_capacity(sizes.len() * each);
    for &diameter in sizes {
        for _ in 0..each {
            let strength = law.draw(seed, lineage_root(grains.len() as u32), diameter);
            grains.push(Grain { diameter, force: area.force(strength, diameter), censored: false, series: 0 });
        }
    }
    Data { path: PathBuf::from("simulated"), grains, series: vec![String::new()], notes: Vec::new() }
}

/// Random stream number `index` of a seed.
pub fn generator(seed: u64, index: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(index);
    rng
}

/// A number uniform strictly between 0 and 1.
pub fn unit(rng: &mut ChaCha8Rng) -> f64 {
    ((rng.next_u64() >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
}

/// A whole number uniform in 0..n.
pub fn below(rng: &mut ChaCha8Rng, n: usize) -> usize {
    ((unit(rng) * n as f64) as usize).min(n.saturating_sub(1))
}
