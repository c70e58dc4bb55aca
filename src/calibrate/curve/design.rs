//! Points that fill the unit cube.

use rand::{Rng, RngExt, seq::SliceRandom};

/// Number of random Latin hypercubes, of which the one with the largest smallest distance between
/// points is used.
const TRIES: usize = 200;

/// `n` points of a Latin hypercube of `d` inputs. Of many random hypercubes the one whose nearest
/// points are furthest apart is returned.
pub fn latin(n: usize, d: usize, rng: &mut impl Rng) -> Vec<Vec<f64>> {
    let mut best = (f64::NEG_INFINITY, Vec::new());
    for _ in 0..TRIES {
        let mut points = vec![vec![0.0; d]; n];
        for k in 0..d {
            let mut order: Vec<usize> = (0..n).collect();
            order.shuffle(rng);
            for (point, slot) in points.iter_mut().zip(order) {
                point[k] = (slot as f64 + rng.random::<f64>()) / n as f64;
            }
        }
        let near = nearest(&points);
        if near > best.0 {
            best = (near, points);
        }
    }
    best.1
}

/// Smallest squared distance between two of the points; `f64::MAX` for fewer than two points.
fn nearest(points: &[Vec<f64>]) -> f64 {
    let mut least = f64::MAX;
    for (i, a) in points.iter().enumerate() {
        for b in &points[..i] {
            least = least.min(distance(a, b));
        }
    }
    least
}

/// Squared distance of two points.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn every_slice_of_every_input_holds_one_point() {
        let points = latin(17, 3, &mut ChaCha8Rng::seed_from_u64(1));
        for k in 0..3 {
            let mut slots: Vec<usize> = points.iter().map(|p| (p[k] * 17.0) as usize).collect();
            slots.sort_unstable();
            assert_eq!(slots, (0..17).collect::<Vec<_>>());
        }
        assert_eq!(points, latin(17, 3, &mut ChaCha8Rng::seed_from_u64(1)));
        assert_eq!(latin(1, 2, &mut ChaCha8Rng::seed_from_u64(1)).len(), 1);
    }
}
