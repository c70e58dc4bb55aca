//! Changes of frame and of units, and comparisons of what they should leave the same.

use comminute::Material;
use comminute::mpm::law::Sym;

/// Exponents of length, time and mass in the unit of a quantity.
pub type Unit = [i32; 3];

pub const LENGTH: Unit = [1, 0, 0];
pub const VELOCITY: Unit = [1, -1, 0];
pub const ACCELERATION: Unit = [1, -2, 0];
pub const SPIN: Unit = [0, -1, 0];
pub const TIME: Unit = [0, 1, 0];
pub const MASS: Unit = [0, 0, 1];
pub const VOLUME: Unit = [3, 0, 0];
pub const AREA: Unit = [2, 0, 0];
pub const DENSITY: Unit = [-3, 0, 1];
pub const FORCE: Unit = [1, -2, 1];
pub const STRESS: Unit = [-1, -2, 1];
pub const ENERGY: Unit = [2, -2, 1];
pub const MOMENTUM: Unit = [1, -1, 1];
pub const STIFFNESS: Unit = [0, -2, 1];
pub const NONE: Unit = [0; 3];

/// A change of frame, a rotation with or without a mirror, and of units.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    /// Rows of the matrix that turns vectors.
    pub turn: [[f64; 3]; 3],
    /// Factors on numbers of length, time and mass.
    pub factors: [f64; 3],
}

impl Change {
    /// No change at all.
    pub const NOTHING: Change = Change { turn: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], factors: [1.0; 3] };

    /// Lengths × 2⁶, times × 2⁻⁴, masses × 2⁸: no product of powers of these with whole exponents has a mantissa, and neither has its root, so that
    /// only exponents of numbers change.
    pub const UNITS: Change = Change { factors: [64.0, 0.0625, 256.0], ..Change::NOTHING };

    /// Mirrored across the plane through the origin at right angles to an axis.
    pub fn mirror(axis: usize) -> Change {
        let mut change = Change::NOTHING;
        change.turn[axis][axis] = -1.0;
        change
    }

    /// A quarter turn about an axis.
    pub fn quarter(axis: usize) -> Change {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut turn = [[0.0; 3]; 3];
        turn[axis][axis] = 1.0;
        turn[b][c] = -1.0;
        turn[c][b] = 1.0;
        Change { turn, ..Change::NOTHING }
    }

    /// A turn by the unit quaternion along `q`.
    pub fn turned(q: [f64; 4]) -> Change {
        let size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        let [w, x, y, z] = q.map(|v| v / size);
        let turn = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ];
        Change { turn, ..Change::NOTHING }
    }

    /// A number of this unit.
    pub fn scalar(&self, x: f64, unit: Unit) -> f64 {
        self.factors.iter().zip(unit).fold(x, |x, (factor, power)| x * factor.powi(power))
    }

    /// A vector of this unit.
    pub fn vector(&self, v: [f64; 3], unit: Unit) -> [f64; 3] {
        std::array::from_fn(|a| self.scalar((0..3).map(|b| self.turn[a][b] * v[b]).sum(), unit))
    }

    /// An axial vector of this unit, such as a spin: a mirror turns it round once more.
    pub fn axial(&self, v: [f64; 3], unit: Unit) -> [f64; 3] {
        let [x, y, z] = self.turn;
        let determinant = comminute::math::vector::dot(x, comminute::math::vector::cross(y, z));
        self.vector(v, unit).map(|x| x * determinant.signum())
    }

    /// A symmetric tensor of this unit.
    pub fn tensor(&self, s: Sym, unit: Unit) -> Sym {
        let m = [[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]];
        [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)].map(|(i, j)| {
            let sum =
                (0..3).flat_map(|a| (0..3).map(move |b| (a, b))).map(|(a, b)| self.turn[i][a] * m[a][b] * self.turn[j][b]).sum();
            self.scalar(sum, unit)
        })
    }

    /// The constants of a material in the new units.
    pub fn material(&self, m: &Material, parameters: &[comminute::parameter::Parameter]) -> Material {
        let mut contact = m.contact;
        for (value, parameter) in contact.iter_mut().zip(parameters) {
            let unit = match parameter.key {
                key if key.ends_with("_MPa") => STRESS,
                key if key.ends_with("_N_m") => STIFFNESS,
                _ => NONE,
            };
            *value = self.scalar(*value, unit);
        }
        Material { density: self.scalar(m.density, DENSITY), young: self.scalar(m.young, STRESS), contact, ..m.clone() }
    }
}

/// What two results may differ by: by nothing, or by this share of the largest number of their kind.
#[derive(Clone, Copy, Debug)]
pub enum Within {
    Nothing,
    Share(f64),
}

/// Checks lists of numbers of one kind.
#[track_caller]
pub fn same<const N: usize>(what: &str, found: &[[f64; N]], expected: &[[f64; N]], within: Within) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let largest = expected.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    let (mut worst, mut at) = (0.0f64, 0);
    for (k, (a, b)) in found.iter().zip(expected).enumerate() {
        for (a, b) in a.iter().zip(b) {
            assert!(a.is_finite() && b.is_finite(), "{what} {k}: {a} {b}");
            if (a - b).abs() > worst {
                (worst, at) = ((a - b).abs(), k);
            }
        }
    }
    let allowed = match within {
        Within::Nothing => 0.0,
        Within::Share(share) => share * largest,
    };
    assert!(
        worst <= allowed,
        "{what} {at}: {:?} instead of {:?}, off by {:.1e} of {largest:.3e}",
        found[at],
        expected[at],
        worst / largest
    );
}
