//! Strain and spin increments from a velocity gradient, rotation of a stress by the spin, and the work of a stress.

use super::law::Sym;

/// Strain increment ½ (L + Lᵀ) dt (xx, yy, zz, xy, yz, zx, extension positive) and spin increment W dt = ½ (L − Lᵀ) dt (xy, yz, zx), from the columns
/// ∂v/∂x, ∂v/∂y, ∂v/∂z of the velocity gradient L times the time step; fourth numbers are ignored.
#[inline(always)]
pub fn increments(columns: [[f64; 4]; 3]) -> (Sym, [f64; 3]) {
    let [x, y, z] = columns;
    let strain = [x[0], y[1], z[2], 0.5 * (x[1] + y[0]), 0.5 * (y[2] + z[1]), 0.5 * (z[0] + x[2])];
    let spin = [0.5 * (y[0] - x[1]), 0.5 * (z[1] - y[2]), 0.5 * (x[2] - z[0])];
    (strain, spin)
}

/// W σ − σ W: change of a stress by rotation with the spin W, of which xy, yz, zx are given (Jiang et al. 2020, eq. 22).
#[inline(always)]
fn rate(s: Sym, [xy, yz, zx]: [f64; 3]) -> Sym {
    // W = (0, xy, −zx; −xy, 0, yz; zx, −yz, 0)
    let a = xy * s[3];
    let b = yz * s[4];
    let c = zx * s[5];
    [
        2.0 * (a - c),
        2.0 * (b - a),
        2.0 * (c - b),
        xy * (s[1] - s[0]) - zx * s[4] + yz * s[5],
        yz * (s[2] - s[1]) - xy * s[5] + zx * s[3],
        zx * (s[0] - s[2]) - yz * s[3] + xy * s[4],
    ]
}

/// The stress, Pa, after its material has rotated in a step: the Jaumann rate to second order in the spin increment `spin` = (W_xy, W_yz, W_zx), with
/// W_xy = (∂u_x/∂y − ∂u_y/∂x)/2. The magnitude of the deviator changes by the fourth power of the angle only; to first order it would grow by the second
/// power in every step.
#[inline(always)]
pub fn rotate_jaumann(stress: Sym, spin: [f64; 3]) -> Sym {
    let first = rate(stress, spin);
    let second = rate(first, spin);
    let mut rotated = stress;
    for k in 0..6 {
        rotated[k] += first[k] + 0.5 * second[k];
    }
    rotated
}

/// Work of a stress on a strain per volume, σ : ε, J/m³.
#[inline(always)]
pub fn work(s: Sym, e: Sym) -> f64 {
    (s[0] * e[0] + s[1] * e[1] + s[2] * e[2]) + 2.0 * (s[3] * e[3] + s[4] * e[4] + s[5] * e[5])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(s: Sym) -> nalgebra::Matrix3<f64> {
        nalgebra::Matrix3::new(s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2])
    }

    #[test]
    fn the_rate_is_that_of_matrices() {
        let (s, w) = ([1.0, -2.0, 3.5, 0.7, -0.3, 1.1], [0.3, -0.2, 0.9]);
        let spin = nalgebra::Matrix3::new(0.0, w[0], -w[2], -w[0], 0.0, w[1], w[2], -w[1], 0.0);
        let exact = spin * matrix(s) - matrix(s) * spin;
        assert!((matrix(rate(s, w)) - exact).norm() < 1e-14, "{exact}");
    }

    /// A turn about z at 1 rad/s: v = (−y, x), so ∂v/∂x = (0, 1, 0), ∂v/∂y = (−1, 0, 0). σxx = 1 turns into σyy after a quarter.
    #[test]
    fn a_quarter_turn_carries_xx_to_yy() {
        let steps = 1000;
        let angle = std::f64::consts::FRAC_PI_2 / f64::from(steps);
        let (strain, spin) = increments([[0.0, angle, 0.0, 0.0], [-angle, 0.0, 0.0, 0.0], [0.0; 4]]);
        assert_eq!(strain, [0.0; 6]);
        let mut s = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        for _ in 0..steps {
            s = rotate_jaumann(s, spin);
        }
        // with θ = 2 angle per step the deviator grows by θ⁴/8 and lags by θ³/6 of a turn: 1.2e-8 and 5.2e-6 of ½
        assert!(s[0].abs() < 1e-8 && (s[1] - 1.0).abs() < 1e-8 && s[3].abs() < 3e-6, "{s:?}");
    }
}
