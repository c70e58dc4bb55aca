//! Strength of one grain: sigma_lim = sigma_lim0 (d / d0)^(-3/m) * ratio, the ratio normal with mean 1 and standard
//! deviation `var` (Ciantia et al. 2015, eqs 6, 7, 15), truncated from below.
//!
//! # Random numbers
//!
//! Every draw has a generator of its own, keyed by the strength seed and the grain's lineage, so that no draw depends
//! on the order of events. The hash is SplitMix64's (Steele, Lea & Flood 2014):
//!
//! ```text
//! mix(z)        z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9;  z = (z ^ z >> 27) * 0x94D049BB133111EB;  z ^ z >> 31
//! combine(a, b) mix(mix(a + G) + b G),  G = 0x9E3779B97F4A7C15, all modulo 2^64
//! root(i)       combine(ROOT, i);  child(mother, k) = combine(mother, k + 1)
//! generator     ChaCha8 whose 32-byte seed is mix(s + G), mix(s + 2 G), mix(s + 3 G), mix(s + 4 G), little-endian,
//!               s = combine(combine(seed, lineage), stream)
//! ```

use super::criterion::size_factor;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;
const ROOT: u64 = 0x636F_6D6D_696E_7574;
const STRENGTH: u64 = 1;
const AZIMUTH: u64 = 2;
const PLACES: u64 = 0x706C_6163_6573;

/// Redraws after which a draw settles for `min_ratio`; only a `min_ratio` far above 1 ever gets here.
const MAX_REDRAWS: u32 = 4096;

/// What becomes of a draw below the smallest admitted ratio.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Truncation {
    /// It is drawn again. With `min_ratio` 0 and `var` 1 the mean becomes 1.288, the coefficient of variation 0.616.
    Redraw,
    /// It becomes `min_ratio`. With `min_ratio` 0 and `var` 1 the mean becomes 1.083; 15.9 % have no strength at all.
    Clamp,
    /// It is drawn again, and so is one as far above the mean: the mean stays what it is. With `min_ratio` 0 and `var` 1 the
    /// coefficient of variation becomes 0.540.
    Symmetric,
}

/// Law of the limit strength of a grain. `sigma_lim0` and `var` are parameters of the normal before truncation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StrengthModel {
    /// Mean limit strength at the reference diameter, Pa.
    pub sigma_lim0: f64,
    /// Reference diameter times the scale N, m (eq. 15).
    pub d0: f64,
    /// Exponent of size hardening, - (eq. 7).
    pub m: f64,
    /// Coefficient of variation, -.
    pub var: f64,
    pub truncation: Truncation,
    /// Smallest admitted ratio of a strength to the mean at its size, -.
    pub min_ratio: f64,
}

impl StrengthModel {
    /// Limit strength, Pa, of the grain `lineage` with diameter `d`, m.
    pub fn draw(&self, seed: u64, lineage: u64, d: f64) -> f64 {
        self.sigma_lim0 * size_factor(d, self.d0, self.m) * self.ratio(seed, lineage)
    }

    /// Ratio of the grain's strength to the mean strength at its size, -.
    fn ratio(&self, seed: u64, lineage: u64) -> f64 {
        let mut rng = generator(seed, lineage, STRENGTH);
        for _ in 0..MAX_REDRAWS {
            let deviate: f64 = StandardNormal.sample(&mut rng);
            let ratio = 1.0 + self.var * deviate;
            if ratio >= self.min_ratio && ratio <= self.max_ratio() {
                return ratio;
            }
            if self.truncation == Truncation::Clamp {
                break;
            }
        }
        self.min_ratio
    }

    /// Largest admitted ratio of a strength to the mean at its size, -.
    pub(super) fn max_ratio(&self) -> f64 {
        match self.truncation {
            Truncation::Symmetric => 2.0 - self.min_ratio,
            Truncation::Redraw | Truncation::Clamp => f64::INFINITY,
        }
    }
}

/// Lineage of the `initial`-th grain of the specimen.
pub fn lineage_root(initial: u32) -> u64 {
    combine(ROOT, u64::from(initial))
}

/// Lineage of the `k`-th daughter of a grain.
pub fn lineage_child(mother: u64, k: u32) -> u64 {
    combine(mother, u64::from(k) + 1)
}

/// A unit vector perpendicular to the unit vector `axis`, its azimuth uniform, from a stream apart from the strength's.
/// Every axis will do.
pub fn random_perpendicular(seed: u64, lineage: u64, axis: [f64; 3]) -> [f64; 3] {
    let mut rng = generator(seed, lineage, AZIMUTH);
    // A right-handed frame about the axis without a special direction (Duff et al. 2017).
    let [x, y, z] = axis;
    let sign = if z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + z);
    let b = x * y * a;
    let u = [1.0 + sign * x * x * a, sign * b, -sign * x];
    let v = [b, sign + y * y * a, -y];
    let (p, q) = loop {
        let p = symmetric_unit(&mut rng);
        let q = symmetric_unit(&mut rng);
        let square = p * p + q * q;
        if square <= 1.0 && square > 1e-6 {
            break (p, q);
        }
    };
    let w = [p * u[0] + q * v[0], p * u[1] + q * v[1], p * u[2] + q * v[2]];
    let length = (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]).sqrt();
    [w[0] / length, w[1] / length, w[2] / length]
}

/// Three numbers uniform in 0..1, from the lineage alone.
pub fn lineage_uniform(lineage: u64) -> [f64; 3] {
    [1, 2, 3].map(|k| (mix(combine(lineage, PLACES + k)) >> 11) as f64 / (1_u64 << 53) as f64)
}

/// A number uniform in -1..1.
fn symmetric_unit(rng: &mut ChaCha8Rng) -> f64 {
    let unit = (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    2.0 * unit - 1.0
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

fn combine(a: u64, b: u64) -> u64 {
    mix(mix(a.wrapping_add(GOLDEN)).wrapping_add(b.wrapping_mul(GOLDEN)))
}

/// The generator of one draw.
fn generator(seed: u64, lineage: u64, stream: u64) -> ChaCha8Rng {
    let mut state = combine(combine(seed, lineage), stream);
    let mut bytes = [0; 32];
    for word in bytes.chunks_exact_mut(8) {
        state = state.wrapping_add(GOLDEN);
        word.copy_from_slice(&mix(state).to_le_bytes());
    }
    ChaCha8Rng::from_seed(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    fn model(var: f64, truncation: Truncation) -> StrengthModel {
        StrengthModel { sigma_lim0: 300e6, d0: 2e-3, m: 2.0, var, truncation, min_ratio: 0.0 }
    }

    /// Mean and coefficient of variation of 10^6 strengths over the mean strength of their size, and the share of zeros.
    fn statistics(model: StrengthModel) -> (f64, f64, f64) {
        let n = 1_000_000;
        let d = 5e-3;
        let scale = model.sigma_lim0 * size_factor(d, model.d0, model.m);
        let (mut sum, mut squares, mut zeros) = (0.0, 0.0, 0.0);
        for i in 0..n {
            let ratio = model.draw(7, lineage_root(i), d) / scale;
            assert!(ratio >= 0.0);
            sum += ratio;
            squares += ratio * ratio;
            zeros += f64::from(u8::from(ratio == 0.0));
        }
        let n = f64::from(n);
        let mean = sum / n;
        (mean, (squares / n - mean * mean).sqrt() / mean, zeros / n)
    }

    #[test]
    fn a_million_strengths_have_the_moments_of_the_truncated_normal() {
        // Standard error of a mean is below 0.001, of a spread below 0.0006.
        for (var, truncation, mean, spread, zeros) in [
            (1.0, Truncation::Redraw, 1.288, 0.616, 0.0),
            (0.48, Truncation::Redraw, 1.022, 0.446, 0.0),
            (1.0, Truncation::Clamp, 1.0833, 0.8004, 0.1587),
            (1.0, Truncation::Symmetric, 1.0, 0.5396, 0.0),
        ] {
            let found = statistics(model(var, truncation));
            assert!((found.0 - mean).abs() < 0.0035, "{found:?}");
            assert!((found.1 - spread).abs() < 0.002, "{found:?}");
            assert!((found.2 - zeros).abs() < 0.002, "{found:?}");
        }
    }

    #[test]
    fn a_draw_depends_on_seed_and_lineage_only() {
        let law = model(1.0, Truncation::Redraw);
        let (a, b) = (lineage_root(3), lineage_root(4));
        let before = law.draw(1, lineage_child(a, 5), 5e-3);
        // An unrelated grain breaks first.
        let _ = (0..14).map(|k| law.draw(1, lineage_child(b, k), 3e-3)).collect::<Vec<_>>();
        assert_eq!(before.to_bits(), law.draw(1, lineage_child(a, 5), 5e-3).to_bits());
        assert_ne!(before, law.draw(2, lineage_child(a, 5), 5e-3));
        assert_ne!(before, law.draw(1, lineage_child(a, 6), 5e-3));
    }

    #[test]
    fn without_spread_every_grain_has_the_mean_of_its_size() {
        let law = model(0.0, Truncation::Redraw);
        for d in [1e-3, 2e-3, 9e-3] {
            assert_eq!(law.draw(5, lineage_root(1), d), 300e6 * size_factor(d, 2e-3, 2.0));
        }
        // The mean at four times the reference diameter is an eighth (m = 2).
        assert!((law.draw(5, 1, 8e-3) / 37.5e6 - 1.0).abs() < 1e-13);
    }

    #[test]
    fn a_floor_that_no_draw_reaches_still_ends() {
        let law = StrengthModel { min_ratio: 1e6, ..model(1.0, Truncation::Redraw) };
        assert!((law.draw(1, 1, 2e-3) / (300e6 * 1e6) - 1.0).abs() < 1e-12);
        assert!(model(f64::NAN, Truncation::Redraw).draw(1, 1, 2e-3).is_finite());
    }

    #[test]
    fn lineages_are_distinct() {
        let mut seen = HashSet::new();
        for i in 0..2000 {
            let root = lineage_root(i);
            assert!(seen.insert(root));
            for k in 0..14 {
                let child = lineage_child(root, k);
                assert!(seen.insert(child));
                for j in 0..14 {
                    assert!(seen.insert(lineage_child(child, j)));
                }
            }
        }
    }

    /// Golden values: a change of hash, generator or normal changes every run and must be noticed.
    #[test]
    fn streams_are_frozen() {
        let law = model(1.0, Truncation::Redraw);
        assert_eq!(lineage_root(0), GOLDEN_ROOT);
        assert_eq!(lineage_child(lineage_root(0), 0), GOLDEN_CHILD);
        let drawn = law.draw(1, lineage_root(0), 2e-3);
        let [x, y, z] = random_perpendicular(1, lineage_root(0), [0.0, 0.0, 1.0]);
        assert!((x - 0.883_596_541).abs() < 1e-9 && (y + 0.468_249_028).abs() < 1e-9 && z == 0.0);
        assert!((drawn - GOLDEN_STRENGTH).abs() < 1e-3, "{drawn:.6}");
    }
    const GOLDEN_ROOT: u64 = 0xf755_8d6a_d099_f3e8;
    const GOLDEN_CHILD: u64 = 0xf98f_013a_c9ff_fae1;
    const GOLDEN_STRENGTH: f64 = 245_250_200.592_023;

    #[test]
    fn azimuths_are_uniform_and_perpendicular_about_every_axis() {
        let third = 1.0 / 3.0_f64.sqrt();
        for axis in [
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
            [1.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [third, -third, -third],
            [0.6e-9, 0.8e-9, -1.0],
        ] {
            // Any fixed frame about the axis.
            let guide: [f64; 3] = if axis[0] * axis[0] > 0.9 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
            let v = cross(axis, guide);
            let u = cross(v, axis);
            let length = dot(u, u).sqrt();
            let n = 20_000;
            let mut moments = [0.0; 5];
            for i in 0..n {
                let w = random_perpendicular(3, lineage_root(i), axis);
                assert!(dot(w, axis).abs() < 4e-16, "{axis:?} {w:?}");
                assert!((dot(w, w) - 1.0).abs() < 1e-15);
                let (c, s) = (dot(w, u) / length, dot(w, v) / length);
                // Cosine and sine of the azimuth, of twice and of four times it.
                let (c2, s2) = (c * c - s * s, 2.0 * c * s);
                let values = [c, s, c2, s2, 2.0 * c2 * c2 - 1.0];
                for (sum, value) in moments.iter_mut().zip(values) {
                    *sum += value / f64::from(n);
                }
            }
            // Each is the mean of n numbers of variance 1/2.
            for moment in moments {
                assert!(moment.abs() < 4.0 * (0.5 / f64::from(n)).sqrt(), "{axis:?} {moments:?}");
            }
        }
    }

    #[test]
    fn azimuth_and_strength_do_not_share_a_stream() {
        let lineage = lineage_root(9);
        let mut rng = generator(1, lineage, STRENGTH);
        let (p, q) = (symmetric_unit(&mut rng), symmetric_unit(&mut rng));
        let w = random_perpendicular(1, lineage, [0.0, 0.0, 1.0]);
        // The strength's numbers would make (p, q) of it.
        assert!((p * w[1] - q * w[0]).abs() > 1e-3);
    }

    fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    }
}
