//! Principal values and directions of a symmetric tensor by Jacobi's rotations, with + − × ÷ √ in a stated order: the same bits on every machine.

/// Sweeps after which the off-diagonal entries of every tensor are rounding.
const SWEEPS: usize = 10;

/// Principal values of the symmetric tensor `[xx, yy, zz, xy, yz, zx]`, largest first, and the unit direction of each. Equal values have any directions
/// perpendicular to the others.
pub fn principal([xx, yy, zz, xy, yz, zx]: [f64; 6]) -> ([f64; 3], [[f64; 3]; 3]) {
    let mut a = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
    // its columns become the directions
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..SWEEPS {
        if a[0][1] == 0.0 && a[1][2] == 0.0 && a[0][2] == 0.0 {
            break;
        }
        for (p, q) in [(0, 1), (1, 2), (0, 2)] {
            rotate(&mut a, &mut v, p, q);
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| a[j][j].total_cmp(&a[i][i]).then(i.cmp(&j)));
    (order.map(|k| a[k][k]), order.map(|k| [v[0][k], v[1][k], v[2][k]]))
}

/// Turns in the plane of the axes `p` and `q` so that their off-diagonal entry vanishes.
fn rotate(a: &mut [[f64; 3]; 3], v: &mut [[f64; 3]; 3], p: usize, q: usize) {
    let off = a[p][q];
    if off == 0.0 {
        return;
    }
    let half = (a[q][q] - a[p][p]) / (2.0 * off);
    let root = (half * half + 1.0).sqrt();
    let tangent = if half < 0.0 { -1.0 / (root - half) } else { 1.0 / (root + half) };
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;
    let r = 3 - p - q;
    a[p][p] -= tangent * off;
    a[q][q] += tangent * off;
    (a[p][q], a[q][p]) = (0.0, 0.0);
    let (rp, rq) = (a[r][p], a[r][q]);
    (a[r][p], a[r][q]) = (cosine * rp - sine * rq, sine * rp + cosine * rq);
    (a[p][r], a[q][r]) = (a[r][p], a[r][q]);
    for row in v {
        let (x, y) = (row[p], row[q]);
        (row[p], row[q]) = (cosine * x - sine * y, sine * x + cosine * y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn known_tensors() {
        assert_eq!(principal([1.0, 3.0, 2.0, 0.0, 0.0, 0.0]).0, [3.0, 2.0, 1.0]);
        // pure shear: ± the shear stress, at 45°
        let (values, directions) = principal([0.0, 0.0, 0.0, 5.0, 0.0, 0.0]);
        assert!((values[0] - 5.0).abs() < 1e-14 && values[1].abs() < 1e-14 && (values[2] + 5.0).abs() < 1e-14);
        assert!((directions[0][0] - directions[0][1]).abs() < 1e-15);
        assert_eq!(principal([0.0; 6]).0, [0.0; 3]);
    }

    proptest! {
        /// The tensor put together from its principal values and directions is the tensor.
        #[test]
        fn the_tensor_comes_back(t in prop::array::uniform6(-1.0..1.0f64), scale in 1e-12..1e12f64) {
            let t = t.map(|x| x * scale);
            let (values, d) = principal(t);
            prop_assert!(values[0] >= values[1] && values[1] >= values[2]);
            for (k, (i, j)) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)].into_iter().enumerate() {
                let back: f64 = (0..3).map(|m| values[m] * d[m][i] * d[m][j]).sum();
                prop_assert!((back - t[k]).abs() < 1e-14 * scale * 4.0, "{k}: {back} {}", t[k]);
                let unit: f64 = (0..3).map(|m| d[i][m] * d[j][m]).sum();
                prop_assert!((unit - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
    }
}
