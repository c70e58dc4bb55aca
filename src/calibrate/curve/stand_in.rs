//! Curves in closed form with random scatter, which replace runs in tests of the statistics.

use super::design::latin;
use super::parameter::Parameter;
use laboratory::scene::Prior;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Compression curve n(ln σ) with two parameters, bent where grains would begin to break. Specimens
/// scatter in initial porosity (`offset`), in slope (`slope`) and from point to point (`rough`).
pub struct StandIn {
    points: usize,
    offset: f64,
    slope: f64,
    rough: f64,
}

impl Default for StandIn {
    fn default() -> StandIn {
        StandIn { points: 15, offset: 0.004, slope: 0.003, rough: 0.001 }
    }
}

pub fn parameters() -> Vec<Parameter> {
    let parameter = |key: &str| Parameter { key: key.into(), lower: 0.0, upper: 1.0, prior: Prior::Uniform };
    vec![parameter("strength"), parameter("stiffness")]
}

impl StandIn {
    /// The curve at unit coordinates with the scatter of a seed.
    pub fn curve(&self, u: &[f64], seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let (offset, slope) = (self.offset * normal(), self.slope * normal());
        (0..self.points)
            .map(|j| {
                let x = j as f64 / (self.points - 1) as f64;
                let bend = x - 0.3 - 0.4 * u[0];
                let crushed = 0.15 * (bend + (bend * bend + 0.01).sqrt());
                0.45 - (0.02 + 0.05 * (1.0 - u[1])) * x - crushed + offset + slope * x + self.rough * normal()
            })
            .collect()
    }

    /// Parameters and curves of a design of runs, each with its own seed.
    pub fn runs(&self, n: usize, seed: u64) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        let x = latin(n, 2, &mut ChaCha8Rng::seed_from_u64(seed));
        let y = x.iter().enumerate().map(|(i, u)| self.curve(u, seed * 10_000 + i as u64)).collect();
        (x, y)
    }

    pub fn scale(&self) -> Vec<f64> {
        vec![0.005; self.points]
    }
}
