//! Drives a law along the paths, step by step. Inside this file tension is positive, as in the
//! laws; in a [`Row`] compression is positive.

use super::{Path, Settings};
use engine::mpm::law::{InternalVariables, Law, Sym, YieldParameters, tensor};
use engine::mpm::rotate_jaumann;
use laboratory::error::{Error, Result};

/// Record of one step; stresses in Pa, compression positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Number of the step; 0 is the start.
    pub step: u32,
    /// Axial strain, compression positive.
    pub axial_strain: f64,
    /// Lateral strain, compression positive.
    pub lateral_strain: f64,
    /// Engineering shear strain
    pub shear_strain: f64,
    /// Volumetric strain, compression positive.
    pub volumetric_strain: f64,
    /// Axial stress.
    pub axial: f64,
    /// Lateral stress.
    pub lateral: f64,
    /// Shear stress in the x-z plane, positive with positive shear strain.
    pub shear: f64,
    /// Mean stress
    pub p: f64,
    /// Axial less lateral stress; in simple shear sqrt(3 J2)
    pub q: f64,
    /// Largest over smallest principal stress; `None` unless the smallest is compressive.
    pub stress_ratio: Option<f64>,
    /// Accumulated plastic strain.
    pub plastic_strain: f64,
    /// Yield surface at this plastic strain; `None` for laws without one.
    pub strength: Option<YieldParameters>,
}

/// One test.
#[derive(Clone, Debug, PartialEq)]
pub struct Test {
    /// Isotropic stress at the start, Pa
    pub confining: f64,
    /// A row for each step.
    pub rows: Vec<Row>,
    /// Largest distance of the lateral stress from the cell pressure, Pa (triaxial tests)
    pub cell_pressure_error: f64,
}

/// State of the point during a test, tension positive.
#[derive(Clone, Copy)]
struct Point {
    stress: Sym,
    strain: Sym,
    memory: InternalVariables,
}

impl Point {
    fn strained(&self, law: &Law, dstrain: Sym) -> Point {
        let (stress, memory) = law.update(self.stress, dstrain, self.memory);
        Point { stress, memory, strain: std::array::from_fn(|i| self.strain[i] + dstrain[i]) }
    }

    fn row(&self, law: &Law, path: Path, step: u32) -> Row {
        let pressure: Sym = self.stress.map(|s| 0.0 - s);
        let strain: Sym = self.strain.map(|e| 0.0 - e);
        let q = if path == Path::SimpleShear { (3.0 * tensor::j2(&pressure)).sqrt() } else { pressure[2] - pressure[0] };
        Row {
            step,
            axial_strain: strain[2],
            lateral_strain: strain[0],
            // shear has no compressive side: strain and stress keep the sign of the law
            shear_strain: 2.0 * self.strain[5],
            volumetric_strain: tensor::trace(&strain),
            axial: pressure[2],
            lateral: pressure[0],
            shear: self.stress[5],
            p: tensor::trace(&pressure) / 3.0,
            q,
            stress_ratio: ratio(&pressure),
            plastic_strain: self.memory.plastic,
            strength: law.yield_line(self.memory.plastic),
        }
    }
}

/// Largest over smallest principal stress of a tensor whose only shear component is xz; `None`
/// unless the smallest is compressive.
fn ratio(pressure: &Sym) -> Option<f64> {
    let (middle, half) = (0.5 * (pressure[0] + pressure[2]), 0.5 * (pressure[0] - pressure[2]));
    let radius = (half * half + pressure[5] * pressure[5]).sqrt();
    let principal = [middle + radius, middle - radius, pressure[1]];
    let (low, high) = principal.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (p.min(a), p.max(b)));
    (low > 1e-9 * high).then(|| high / low)
}

/// Drives the law along the path of `settings`, in one test for each confining stress.
///
/// # Errors
/// Settings with which no test can be made; a cell pressure that no lateral strain can hold.
pub fn drive(law: &Law, settings: &Settings) -> Result<Vec<Test>> {
    settings.check()?;
    settings.confining.iter().map(|confining| test(law, settings, *confining)).collect()
}

fn test(law: &Law, settings: &Settings, confining: f64) -> Result<Test> {
    let path = settings.path;
    let stress = [-confining, -confining, -confining, 0.0, 0.0, 0.0];
    let mut point = Point { stress, strain: [0.0; 6], memory: InternalVariables::default() };
    let mut rows = vec![point.row(law, path, 0)];
    let mut lateral = Lateral { law, confining, ratio: -law.poisson(), error: 0.0 };
    let part = settings.strain / f64::from(settings.steps);
    for step in 1..=settings.steps {
        point = match path {
            Path::Triaxial => lateral.step(&point, -part, step)?,
            Path::Oedometer => point.strained(law, [0.0, 0.0, -part, 0.0, 0.0, 0.0]),
            Path::Isotropic => point.strained(law, [-part, -part, -part, 0.0, 0.0, 0.0]),
            Path::Undrained => point.strained(law, [0.5 * part, 0.5 * part, -part, 0.0, 0.0, 0.0]),
            Path::SimpleShear => {
                // du_x/dz = part: half of it is strain, half of it turns the material
                let turned = Point { stress: rotate_jaumann(point.stress, [0.0, 0.0, -0.5 * part]), ..point };
                turned.strained(law, [0.0, 0.0, 0.0, 0.0, 0.0, 0.5 * part])
            }
        };
        if !point.stress.iter().all(|s| s.is_finite()) {
            return Err(Error::Failed { step: u64::from(step), what: "the stress is not a finite number".into() });
        }
        rows.push(point.row(law, path, step));
    }
    Ok(Test { confining, rows, cell_pressure_error: lateral.error })
}

/// Finds the lateral strain that keeps the lateral stress at the cell pressure.
struct Lateral<'a> {
    law: &'a Law,
    confining: f64,
    /// Lateral over axial strain of the last step
    ratio: f64,
    error: f64,
}

impl Lateral<'_> {
    /// Largest allowed error of the lateral stress, as a share of the cell pressure plus 10⁻⁶ E.
    const ALLOWED: f64 = 1e-3;

    fn step(&mut self, point: &Point, axial: f64, step: u32) -> Result<Point> {
        let at = |lateral: f64| point.strained(self.law, [lateral, lateral, axial, 0.0, 0.0, 0.0]);
        let rest = |p: &Point| p.stress[0] + self.confining;
        let scale = self.confining + 1e-6 * self.law.young();
        let close = |p: &Point| rest(p).abs() <= 1e-11 * scale;
        let mut low = self.ratio * axial;
        let mut best = at(low);
        if !close(&best) {
            // the lateral stress grows with the lateral strain: take longer and longer strides
            // until the stress has passed the cell pressure
            let (mut a, mut high) = (best, low);
            let mut stride = 0.05 * axial.abs() * if rest(&a) > 0.0 { -1.0 } else { 1.0 };
            let mut b = a;
            for _ in 0..80 {
                high = low + stride;
                b = at(high);
                if rest(&b) * rest(&a) <= 0.0 {
                    break;
                }
                (low, a) = (high, b);
                stride *= 2.0;
            }
            // then search between the last two strains: by false position, and every third time by
            // halving
            for round in 0..200 {
                if close(&b) || low == high {
                    break;
                }
                let (f, g) = (rest(&a), rest(&b));
                let share = if round % 3 == 2 { 0.5 } else { f / (f - g) };
                let middle = low + share * (high - low);
                if middle == low || middle == high {
                    break;
                }
                let m = at(middle);
                if rest(&m) * g <= 0.0 {
                    (low, a) = (high, b);
                }
                (high, b) = (middle, m);
            }
            best = if rest(&a).abs() < rest(&b).abs() { a } else { b };
        }
        let error = rest(&best).abs();
        if error.is_nan() || error > Self::ALLOWED * scale {
            let what = format!(
                "no lateral strain holds the cell pressure of {} kPa: the nearest is {} kPa",
                1e-3 * self.confining,
                -1e-3 * best.stress[0]
            );
            return Err(Error::Failed { step: u64::from(step), what });
        }
        self.error = self.error.max(error);
        self.ratio = (best.strain[0] - point.strain[0]) / axial;
        Ok(best)
    }
}
