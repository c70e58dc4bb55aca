//! Random draws keyed by the lineage of a grain. Every draw has a generator of its own, made from a seed, the lineage and the purpose, so that no draw depends
//! on the order of events.
//!
//! The hash is SplitMix64's (Steele, Lea & Flood 2014):
//!
//! ```text
//! mix(z)        z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9;  z = (z ^ z >> 27) * 0x94D049BB133111EB;  z ^ z >> 31
//! combine(a, b) mix(mix(a + G) + b G),  G = 0x9E3779B97F4A7C15, all modulo 2^64
//! root(i)       combine(ROOT, i);  child(mother, k) = combine(mother, k + 1)
//! generator     ChaCha8 whose 32-byte seed is mix(s + G), mix(s + 2 G), mix(s + 3 G), mix(s + 4 G), little-endian,
//!               s = combine(combine(seed, lineage), stream)
//! ```

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Stream for the draw of a grain's strength.
pub const STRENGTH: u64 = 1;
/// Stream for the draw of the azimuth of a grain's splitting.
pub const AZIMUTH: u64 = 2;

const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;
const ROOT: u64 = 0x636F_6D6D_696E_7574;
const PLACES: u64 = 0x706C_6163_6573;

/// Lineage of the `initial`-th grain of the specimen.
pub fn lineage_root(initial: u32) -> u64 {
    combine(ROOT, u64::from(initial))
}

/// Lineage of the `k`-th daughter of a grain.
pub fn lineage_child(mother: u64, k: u32) -> u64 {
    combine(mother, u64::from(k) + 1)
}

/// A random unit vector perpendicular to the unit vector `axis` (of any direction), uniform in its azimuth, from the stream [`AZIMUTH`].
pub fn random_perpendicular(seed: u64, lineage: u64, axis: [f64; 3]) -> [f64; 3] {
    let mut rng = generator(seed, lineage, AZIMUTH);
    // Two unit vectors perpendicular to the axis, without a case distinction (Duff et al. 2017).
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

/// Three uniform numbers in 0..1, from the lineage alone (without a seed).
pub fn lineage_uniform(lineage: u64) -> [f64; 3] {
    [1, 2, 3].map(|k| (mix(combine(lineage, PLACES + k)) >> 11) as f64 / (1_u64 << 53) as f64)
}

/// A number uniform in 0..1, without 0.
pub fn positive_unit(rng: &mut ChaCha8Rng) -> f64 {
    ((rng.next_u64() >> 11) as f64 + 1.0) / (1_u64 << 53) as f64
}

/// A uniform number in −1..1.
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

/// Generator of one draw: for a seed, a lineage and a stream.
pub fn generator(seed: u64, lineage: u64, stream: u64) -> ChaCha8Rng {
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
    use crate::math::vector::{cross, dot};
    use std::collections::HashSet;

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
}
