//! Symmetric tensors: invariants and products.

use super::Sym;

/// Trace a_ii.
#[inline]
pub fn trace(a: &Sym) -> f64 {
    a[0] + a[1] + a[2]
}

/// Deviator a_ij - a_kk / 3 delta_ij.
#[inline]
pub fn deviator(a: &Sym) -> Sym {
    let mean = trace(a) * (1.0 / 3.0);
    [a[0] - mean, a[1] - mean, a[2] - mean, a[3], a[4], a[5]]
}

/// Double contraction a_ij b_ij.
#[inline]
pub fn contract(a: &Sym, b: &Sym) -> f64 {
    (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
}

/// Second invariant of the deviator, J2 = s_ij s_ij / 2; from differences of normal components, so that a large mean does not spoil its digits.
#[inline]
pub fn j2(a: &Sym) -> f64 {
    let (d0, d1, d2) = (a[0] - a[1], a[1] - a[2], a[2] - a[0]);
    (d0 * d0 + d1 * d1 + d2 * d2) * (1.0 / 6.0) + (a[3] * a[3] + a[4] * a[4] + a[5] * a[5])
}

/// Equivalent strain sqrt(2/3 a_ij a_ij); of a plastic strain increment, the increment of the accumulated plastic strain.
#[inline]
pub fn equivalent(a: &Sym) -> f64 {
    (2.0 / 3.0 * contract(a, a)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Sym = [3.0, -1.0, 2.5, 0.7, -0.4, 1.1];

    #[test]
    fn invariants_agree_with_their_definitions() {
        let s = deviator(&A);
        assert!(trace(&s).abs() < 1e-15);
        assert!((j2(&A) - 0.5 * contract(&s, &s)).abs() < 1e-14);
        assert_eq!(contract(&A, &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0]), trace(&A));
        // uniaxial: q = |sigma| = sqrt(3 J2)
        assert!((3.0 * j2(&[-5.0, 0.0, 0.0, 0.0, 0.0, 0.0]) - 25.0).abs() < 1e-14);
        // isochoric axial compression: the equivalent strain is the axial one
        assert!((equivalent(&[-0.01, 0.005, 0.005, 0.0, 0.0, 0.0]) - 0.01).abs() < 1e-16);
    }

    #[test]
    fn a_large_pressure_does_not_drown_the_shear() {
        let a = [1e9 + 1.0, 1e9, 1e9, 0.0, 0.0, 0.0];
        assert!((j2(&a) - 1.0 / 3.0).abs() < 1e-12);
    }
}
