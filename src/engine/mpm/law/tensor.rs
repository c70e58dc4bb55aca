//! Symmetric tensors: invariants, products, and the rotation of a stress with its material.

use super::Sym;

/// a_ii
#[inline]
pub fn trace(a: &Sym) -> f64 {
    a[0] + a[1] + a[2]
}

/// a_ij - a_kk / 3 delta_ij
#[inline]
pub fn deviator(a: &Sym) -> Sym {
    let mean = trace(a) * (1.0 / 3.0);
    [a[0] - mean, a[1] - mean, a[2] - mean, a[3], a[4], a[5]]
}

/// a_ij b_ij
#[inline]
pub fn contract(a: &Sym, b: &Sym) -> f64 {
    (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
}

/// Second invariant of the deviator, J2 = s_ij s_ij / 2. From differences, so that a large pressure does not drown it.
#[inline]
pub fn j2(a: &Sym) -> f64 {
    let (d0, d1, d2) = (a[0] - a[1], a[1] - a[2], a[2] - a[0]);
    (d0 * d0 + d1 * d1 + d2 * d2) * (1.0 / 6.0) + (a[3] * a[3] + a[4] * a[4] + a[5] * a[5])
}

/// Accumulated plastic strain of an increment: sqrt(2/3 a_ij a_ij).
#[inline]
pub fn equivalent(a: &Sym) -> f64 {
    (2.0 / 3.0 * contract(a, a)).sqrt()
}

/// The stress after its material has turned by `spin`: the components xy, yz, zx of the antisymmetric part of the displacement
/// gradient of the step, W_xy = (du_x/dy - du_y/dx) / 2.
///
/// The Jaumann rate in the incremental form of Hughes & Winget (1980): R = (I - W/2)⁻¹ (I + W/2) is a rotation for any W, so that
/// invariants stay and no stress leaves its yield surface by turning.
#[inline]
pub fn rotated(stress: Sym, spin: [f64; 3]) -> Sym {
    turned(&stress, &cayley(spin))
}

/// (I - W/2)⁻¹ (I + W/2) = I + (W + W²/2) / (1 + w²/4), w the axial vector of W.
#[inline]
fn cayley([xy, yz, zx]: [f64; 3]) -> [[f64; 3]; 3] {
    // W x = w × x
    let (x, y, z) = (-yz, -zx, -xy);
    let scale = 1.0 / (1.0 + 0.25 * (x * x + y * y + z * z));
    let half = 0.5 * scale;
    let (xx, yy, zz) = (x * x, y * y, z * z);
    [
        [1.0 - half * (yy + zz), half * x * y - scale * z, half * x * z + scale * y],
        [half * x * y + scale * z, 1.0 - half * (xx + zz), half * y * z - scale * x],
        [half * x * z - scale * y, half * y * z + scale * x, 1.0 - half * (xx + yy)],
    ]
}

/// R a Rᵀ
#[inline]
pub fn turned(a: &Sym, r: &[[f64; 3]; 3]) -> Sym {
    let m = [[a[0], a[3], a[5]], [a[3], a[1], a[4]], [a[5], a[4], a[2]]];
    let row = |i: usize| -> [f64; 3] { std::array::from_fn(|k| r[i][0] * m[0][k] + r[i][1] * m[1][k] + r[i][2] * m[2][k]) };
    let (x, y, z) = (row(0), row(1), row(2));
    let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    [dot(&x, &r[0]), dot(&y, &r[1]), dot(&z, &r[2]), dot(&x, &r[1]), dot(&y, &r[2]), dot(&z, &r[0])]
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Sym = [3.0, -1.0, 2.5, 0.7, -0.4, 1.1];

    fn near(a: &Sym, b: &Sym, within: f64) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() <= within)
    }

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

    #[test]
    fn a_rotation_keeps_the_invariants_and_follows_the_spin() {
        for spin in [[0.3, -0.2, 0.5], [1e-6, 2e-6, -3e-6], [4.0, 3.0, -2.0]] {
            let b = rotated(A, spin);
            assert!((trace(&b) - trace(&A)).abs() < 1e-14 && (j2(&b) - j2(&A)).abs() < 1e-13);
        }
        // first order: sigma + W sigma - sigma W, written out for one spin
        let w = 1e-7;
        let b = rotated(A, [w, 0.0, 0.0]);
        let first =
            [A[0] + 2.0 * w * A[3], A[1] - 2.0 * w * A[3], A[2], A[3] + w * (A[1] - A[0]), A[4] - w * A[5], A[5] + w * A[4]];
        assert!(near(&b, &first, 1e-12), "{b:?} {first:?}");
    }

    #[test]
    fn a_quarter_turn_exchanges_the_axes() {
        // tan(angle / 2) = |w| / 2
        let b = rotated(A, [-2.0, 0.0, 0.0]);
        assert!(near(&b, &[A[1], A[0], A[2], -A[3], A[5], -A[4]], 1e-15), "{b:?}");
    }
}
