//! Volume, first and second moments of parts of space, which add up and take away.

use super::Bulk;
use crate::math::vector::{cross, dot, less, plus, scaled};

/// ∫ dV, m³, ∫ x dV, m⁴, and ∫ x xᵀ dV, m⁵. In the plane those of a slice of one metre, with half of the polar moment along x and along y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Moments {
    pub volume: f64,
    pub first: [f64; 3],
    pub second: [[f64; 3]; 3],
}

/// The matrix v vᵀ.
fn square(v: [f64; 3]) -> [[f64; 3]; 3] {
    v.map(|x| scaled(v, x))
}

impl Moments {
    /// `self` and `share` times another.
    pub fn plus(&self, other: &Moments, share: f64) -> Moments {
        Moments {
            volume: self.volume + share * other.volume,
            first: plus(self.first, scaled(other.first, share)),
            second: std::array::from_fn(|a| plus(self.second[a], scaled(other.second[a], share))),
        }
    }

    /// The limit of two approximations whose errors are as the squares of their steps, the second with half the step of the first.
    pub fn beyond(coarse: &Moments, fine: &Moments) -> Moments {
        fine.plus(&fine.plus(coarse, -1.0), 1.0 / 3.0)
    }

    /// Those of a body with its centre at `centre` and its principal axes along `axes`.
    pub fn of_bulk(bulk: &Bulk, centre: [f64; 3], axes: [[f64; 3]; 3]) -> Moments {
        let [x, y, z] = bulk.moments;
        // ∫ x² from ∫ (y² + z²) and so on
        let own = [0.5 * (y + z - x), 0.5 * (z + x - y), 0.5 * (x + y - z)];
        let none = Moments {
            volume: bulk.volume,
            first: scaled(centre, bulk.volume),
            second: square(centre).map(|row| scaled(row, bulk.volume)),
        };
        axes.into_iter().zip(own).fold(none, |sum, (axis, moment)| {
            let second = square(axis).map(|row| scaled(row, moment));
            sum.plus(&Moments { second, ..Moments::default() }, 1.0)
        })
    }

    /// Those of a shape of the plane with this area, m², centre, m, and polar moment about it, m⁴.
    pub fn of_area(area: f64, centre: [f64; 3], polar: f64) -> Moments {
        let half = 0.5 * (polar + area * dot(centre, centre));
        Moments { volume: area, first: scaled(centre, area), second: [[half, 0.0, 0.0], [0.0, half, 0.0], [0.0; 3]] }
    }

    /// Those of the tetrahedron from the origin to a triangle, negative where that looks inwards.
    pub fn of_tetrahedron([a, b, c]: [[f64; 3]; 3]) -> Moments {
        Moments::of_simplex(dot(a, cross(b, c)) / 6.0, &[[0.0; 3], a, b, c])
    }

    /// Those of a point, a line, a triangle or a tetrahedron with these corners and the measure (1, length, area, volume) `measure`.
    pub fn of_simplex(measure: f64, corners: &[[f64; 3]]) -> Moments {
        let n = corners.len() as f64;
        let sum = corners.iter().fold([0.0; 3], |sum, corner| plus(sum, *corner));
        let squares = || std::iter::once(sum).chain(corners.iter().copied()).map(square);
        let second = std::array::from_fn(|i| {
            let rows = squares().fold([0.0; 3], |total, of| plus(total, of[i]));
            scaled(rows, 1.0 / (n * (n + 1.0)) * measure)
        });
        Moments { volume: measure, first: scaled(sum, 1.0 / n * measure), second }
    }

    /// Those of all sums of a point of this part and a point of another one, where the two are perpendicular to each other.
    pub fn swept_over(&self, other: &Moments) -> Moments {
        let (m, n) = (self, other);
        let second = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                m.second[i][j] * n.volume + m.first[i] * n.first[j] + n.first[i] * m.first[j] + m.volume * n.second[i][j]
            })
        });
        Moments { volume: m.volume * n.volume, first: plus(scaled(m.first, n.volume), scaled(n.first, m.volume)), second }
    }

    /// Those of the triangle from the origin to a side in the plane, negative where that goes round clockwise.
    pub fn of_triangle([p, q]: [[f64; 3]; 2]) -> Moments {
        let area = 0.5 * (p[0] * q[1] - p[1] * q[0]);
        let half = area * (dot(p, p) + dot(p, q) + dot(q, q)) / 12.0;
        Moments { volume: area, first: scaled(plus(p, q), area / 3.0), second: [[half, 0.0, 0.0], [0.0, half, 0.0], [0.0; 3]] }
    }

    /// The same as seen from an origin that is moved by −`by`.
    pub fn moved(&self, by: [f64; 3]) -> Moments {
        let first = plus(self.first, scaled(by, self.volume));
        let second = std::array::from_fn(|i| {
            std::array::from_fn(|j| self.second[i][j] + by[i] * self.first[j] + self.first[i] * by[j] + self.volume * by[i] * by[j])
        });
        Moments { volume: self.volume, first, second }
    }

    /// Centre, m.
    pub fn centre(&self) -> [f64; 3] {
        scaled(self.first, 1.0 / self.volume)
    }

    /// Tensor of inertia about the centre for a density of 1, `[xx, yy, zz, xy, yz, zx]`, m⁵.
    pub fn inertia(&self) -> [f64; 6] {
        let [[xx, xy, _], [_, yy, yz], [zx, _, zz]] = self.moved(less([0.0; 3], self.centre())).second;
        [yy + zz, zz + xx, xx + yy, -xy, -yz, -zx]
    }
}
