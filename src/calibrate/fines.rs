//! Finds the continuum law of fine grains from runs of drained triaxial tests of these grains
//! alone, as Li et al. (2023), section 4.1, find Table 3 and eq. 43. Stiffness, friction against
//! plastic strain, and dilation are read off the curves:
//!
//! - E and ν: slopes of q and of the lateral strain against the axial strain, below a third of q at
//!   the peak.
//! - φ: from σ1/σ3, because the outer cone of the law agrees with Mohr–Coulomb's in triaxial
//!   compression.
//! - Plastic strain: total strain less the elastic one, accumulated as in the law, dε_p = √(2/3
//!   dε^p : dε^p). The increments are taken over equal, large steps of axial strain, because noise
//!   would add up over many small ones.
//! - Eq. 43: the peak angle is the largest one (mean of the tests), the residual angle the mean
//!   over the last tenth of the axial strain. The cubic, which is level at the peak, and the decay
//!   H follow by least squares, for the plastic strain at the peak with which eq. 43 fits the tests
//!   best.
//! - ψ: slope of the plastic volumetric strain against the plastic axial strain, between half and
//!   twice the axial strain of the peak.
//! - ψ where dilation ends with softening (`dilation = "mobilised"`): the angle at the peak with which
//!   the law's plastic volumetric strain, from where φ passes its residual value on, is nearest to the
//!   tests'; the residual angle is that of the critical state. How far the volumes of either rule are
//!   from the tests' is reported.

use super::columns::Columns;
use super::interface::Interface;
use engine::material::InterfaceFriction;
use engine::mpm::law::dilatancy::Dilatancy;
use engine::mpm::law::{Cone, Dilation, Elastic, Evolution as Strength, Parameters};
use laboratory::error::{Error, Result};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use table::number;

/// File of the material.
pub const FILE: &str = "material.toml";
/// File of the result.
pub const REPORT: &str = "calibration.json";

/// Share of q at the peak below which a test is taken as elastic.
const ELASTIC: f64 = 1.0 / 3.0;
/// Axial strain, about, of each of the equal steps over which plastic strain is accumulated.
const STEP: f64 = 0.002;
/// Share of the axial strain, at the end of a test, over which the residual angle is averaged.
const RESIDUAL: f64 = 0.1;
/// Remaining share of the softening down to which points are used for the fit of the decay.
const LEFT: f64 = 0.1;
/// Number of values that are tried for the plastic strain at the peak.
const PLACES: u32 = 200;
/// Least number of rows of shear in a test.
const ROWS: usize = 30;

/// Curves of a test: axial and volumetric strain (compression positive), σ1 and σ3, Pa.
pub(super) struct Test {
    axial: Vec<f64>,
    volumetric: Vec<f64>,
    sigma_1: Vec<f64>,
    sigma_3: Vec<f64>,
}

/// The parameters that the tests give.
#[derive(Clone, Debug, Serialize)]
pub struct Fines {
    /// Folders of the tests.
    pub tests: Vec<PathBuf>,
    /// Young's modulus, MPa.
    #[serde(rename = "E_MPa")]
    pub young_mpa: f64,
    /// Poisson's ratio.
    pub nu: f64,
    /// Friction angle at the peak, degrees.
    pub peak_deg: f64,
    /// Residual friction angle, degrees.
    pub residual_deg: f64,
    /// Dilation angle that stays, degrees.
    pub dilation_deg: f64,
    /// Dilation angle at the peak, degrees, where dilation ends with softening.
    pub mobilised_dilation_deg: f64,
    /// Root mean square difference between plastic volumetric strains of the law and of the tests, from where the friction angle passes its residual value on, -: with dilation
    /// that stays.
    pub volume_misfit: f64,
    /// The same with dilation that ends with softening.
    pub mobilised_volume_misfit: f64,
    /// Axial strain at the peak, compression positive.
    pub peak_axial_strain: f64,
    /// Accumulated plastic strain at the peak.
    pub peak_plastic_strain: f64,
    /// Coefficients of the friction angle, rad, before the peak, of the highest power of the
    /// plastic strain first (Li et al. 2023, eq. 43).
    pub cubic_rad: [f64; 4],
    /// Rate H of the decay after the peak (Li et al. 2023, eq. 43).
    pub decay: f64,
    /// Root mean square difference between eq. 43 and the friction angles of the tests, degrees.
    pub misfit_deg: f64,
    /// Friction angle, degrees, against plastic strain, of each test.
    #[serde(skip)]
    pub angles: Vec<Vec<(f64, f64)>>,
}

/// Slope of a line through (x, y), by least squares with an intercept.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let (sxy, sxx) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + (x - mx) * (y - my), b + (x - mx) * (x - mx)));
    sxy / sxx
}

fn mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().sum::<f64>() / values.count() as f64
}

impl Test {
    /// Reads `history.csv` in the folder of a run, the rows after settling.
    ///
    /// # Errors
    /// A table without these columns, or with too few rows.
    pub(super) fn read(folder: &Path) -> Result<Test> {
        let table = Columns::read(&folder.join("history.csv"))?;
        let settling: Vec<bool> = table.texts("stage").iter().map(|stage| *stage == "settle").collect();
        let column = |(name, factor): (&str, f64)| -> Result<Vec<f64>> {
            table.require(name, "a drained triaxial test of grains")?;
            let value = |(row, value): (usize, Option<f64>)| value.ok_or_else(|| table.wrong_value(row, name, "must be a number"));
            table.numbers(name, factor)?.into_iter().enumerate().filter(|(row, _)| !settling[*row]).map(value).collect()
        };
        let names = [("axial_strain", 1.0), ("volumetric_strain", 1.0), ("sigma_1_kPa", 1e3), ("sigma_3_kPa", 1e3)];
        let [axial, volumetric, sigma_1, sigma_3] = names.map(column);
        let (axial, volumetric, sigma_1, sigma_3) = (axial?, volumetric?, sigma_1?, sigma_3?);
        if axial.len() < ROWS || sigma_3.iter().any(|s| *s <= 0.0) {
            let message = format!("must have at least {ROWS} rows of shear with sigma_3 > 0; it has {}", axial.len());
            return Err(table.wrong(message));
        }
        Ok(Test { axial, volumetric, sigma_1, sigma_3 })
    }

    fn angle(&self, i: usize) -> f64 {
        let (a, b) = (self.sigma_1[i], self.sigma_3[i]);
        ((a - b) / (a + b)).asin()
    }

    fn peak(&self) -> usize {
        (0..self.axial.len())
            .fold(0, |best, i| if self.sigma_1[i] / self.sigma_3[i] > self.sigma_1[best] / self.sigma_3[best] { i } else { best })
    }

    /// Young's modulus, Pa, and Poisson's ratio, from the rows before q passes [`ELASTIC`] of its
    /// value at the peak.
    fn elastic(&self) -> [f64; 2] {
        let q = |i: usize| self.sigma_1[i] - self.sigma_3[i];
        let most = q(self.peak());
        let end = (0..self.axial.len()).position(|i| q(i) > ELASTIC * most).unwrap_or(2).max(3);
        let young = slope(&(0..end).map(|i| (self.axial[i], q(i))).collect::<Vec<_>>());
        let lateral = slope(&(0..end).map(|i| (self.axial[i], 0.5 * (self.volumetric[i] - self.axial[i]))).collect::<Vec<_>>());
        [young, (-lateral).clamp(0.0, 0.45)]
    }

    /// Value of a column at an axial strain, interpolated linearly between rows.
    fn at(&self, column: &[f64], strain: f64) -> f64 {
        let k = self.axial.partition_point(|a| *a < strain).clamp(1, self.axial.len() - 1);
        let (x0, x1) = (self.axial[k - 1], self.axial[k]);
        let share = if x1 > x0 { ((strain - x0) / (x1 - x0)).clamp(0.0, 1.0) } else { 0.0 };
        column[k - 1] + share * (column[k] - column[k - 1])
    }

    /// Plastic axial, plastic volumetric and accumulated plastic strain, and friction angle, rad,
    /// at equal steps of axial strain.
    pub(super) fn plastic(&self, [young, nu]: [f64; 2]) -> Vec<[f64; 4]> {
        let angles: Vec<f64> = (0..self.axial.len()).map(|i| self.angle(i)).collect();
        let end = self.axial[self.axial.len() - 1];
        let steps = (end / STEP).round().max(1.0) as usize;
        let q0 = self.sigma_1[0] - self.sigma_3[0];
        let mut rows: Vec<[f64; 4]> = vec![[0.0, 0.0, 0.0, angles[0]]];
        for k in 1..=steps {
            let strain = end * k as f64 / steps as f64;
            let q = self.at(&self.sigma_1, strain) - self.at(&self.sigma_3, strain) - q0;
            let axial = strain - q / young;
            let volumetric = self.at(&self.volumetric, strain) - (1.0 - 2.0 * nu) * q / young;
            let [a, v, sum, _] = rows[k - 1];
            let (da, dr) = (axial - a, 0.5 * ((volumetric - v) - (axial - a)));
            let step = (2.0 / 3.0 * (da * da + 2.0 * dr * dr)).sqrt();
            rows.push([axial, volumetric, sum + step, self.at(&angles, strain)]);
        }
        rows
    }

    /// Accumulated plastic strain of `rows` ([`Test::plastic`]) at an axial strain, interpolated linearly.
    pub(super) fn plastic_strain_at(&self, rows: &[[f64; 4]], axial: f64) -> f64 {
        let place = axial / self.axial[self.axial.len() - 1] * (rows.len() - 1) as f64;
        let k = (place.max(0.0) as usize).min(rows.len() - 2);
        rows[k][2] + (place - k as f64).clamp(0.0, 1.0) * (rows[k + 1][2] - rows[k][2])
    }
}

/// Eq. 43 fitted with a given plastic strain at the peak.
struct Evolution {
    peak_plastic: f64,
    cubic: [f64; 4],
    decay: f64,
    misfit: f64,
}

/// Fits eq. 43 to `points` (plastic strain; friction angle, rad) with the peak at the plastic
/// strain `top`. `peak` and `last`: peak and residual angle, rad. Before the peak the angle is
/// φ_p + A x² + B x³ with x = ε_p − top, after it the angle decays at the rate H; both by least
/// squares. `None` if the cubic does not rise all the way to the peak, or the angle does not decay.
fn evolution(points: &[(f64, f64)], top: f64, peak: f64, last: f64) -> Option<Evolution> {
    let (mut m, mut v) = ([[0.0; 2]; 2], [0.0; 2]);
    for (e, angle) in points.iter().filter(|p| p.0 <= top) {
        let x = e - top;
        let row = [x * x, x * x * x];
        for i in 0..2 {
            v[i] += row[i] * (angle - peak);
            for j in 0..2 {
                m[i][j] += row[i] * row[j];
            }
        }
    }
    let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    let (a, b) = ((v[0] * m[1][1] - v[1] * m[0][1]) / determinant, (v[1] * m[0][0] - v[0] * m[1][0]) / determinant);
    // dφ/dε = x (2 A + 3 B x) from x = −top to 0
    let rises = a <= 0.0 && 2.0 * a - 3.0 * b * top <= 0.0;
    let left = |angle: f64| (angle - last) / (peak - last);
    let softening = points.iter().filter(|p| p.0 > top && left(p.1) > LEFT).map(|p| (p.0 - top, -left(p.1).ln()));
    let (num, den) = softening.fold((0.0, 0.0), |(s, t), (x, y)| (s + x * y, t + x * x));
    let decay = num / den;
    if !(rises && decay > 0.0 && decay.is_finite()) {
        return None;
    }
    let model = |e: f64| {
        let x = e - top;
        if x <= 0.0 { peak + x * x * (a + b * x) } else { last + (peak - last) * (-decay * x).exp() }
    };
    let misfit = mean(points.iter().map(|(e, angle)| (model(*e) - angle).powi(2))).sqrt();
    let cubic = [b, a - 3.0 * b * top, top * (3.0 * b * top - 2.0 * a), peak + top * top * (a - b * top)];
    Some(Evolution { peak_plastic: top, cubic, decay, misfit })
}

/// Square root of the mean square difference between the plastic volumetric strains of tests (rows of [`Test::plastic`]) and those of a law whose potential has the slope
/// `slope` at a plastic strain, from where that strength is above its final value on.
fn volume_misfit(tests: &[Vec<[f64; 4]>], strength: &Strength, slope: impl Fn(f64) -> f64) -> f64 {
    const PARTS: u32 = 8;
    let (mut square, mut count) = (0.0, 0.0);
    for rows in tests {
        let from = rows.iter().position(|r| strength.at(r[2]).0 > strength.last()).unwrap_or(rows.len());
        let mut volume = 0.0;
        for w in rows[from..].windows(2) {
            let part = (w[1][2] - w[0][2]) / f64::from(PARTS);
            for k in 0..PARTS {
                let alpha = slope(w[0][2] + (f64::from(k) + 0.5) * part);
                volume -= 3.0 * alpha / (1.0 / 3.0 + 2.0 * alpha * alpha).sqrt() * part;
            }
            square += (volume - (w[1][1] - rows[from][1])).powi(2);
            count += 1.0;
        }
    }
    (square / f64::max(count, 1.0)).sqrt()
}

/// The dilation angle at the peak, rad, with which dilation that ends with softening is nearest to the tests, and the misfit of volume.
fn mobilised(tests: &[Vec<[f64; 4]>], strength: &Strength) -> [f64; 2] {
    const TRIED: u32 = 1000;
    let most = strength.range().1;
    let parameters = Parameters {
        friction: *strength,
        dilation: most,
        dilation_rule: Dilation::Mobilised,
        ..Parameters::of_elastic(Elastic { bulk: 1.0, shear: 1.0 })
    };
    let Some(full) = Dilatancy::of(&parameters, Cone::Outer) else { return [0.0, f64::NAN] };
    let per_full = 1.0 / Cone::Outer.at(most).alpha;
    let tried = (0..=TRIED).map(|k| {
        let psi = most * f64::from(k) / f64::from(TRIED);
        let share = Cone::Outer.at(psi).alpha * per_full;
        [psi, volume_misfit(tests, strength, |e| share * full.at(Cone::Outer.at(strength.at(e).0).alpha).0)]
    });
    tried.min_by(|a, b| a[1].total_cmp(&b[1])).unwrap_or([0.0, f64::NAN])
}

/// Reads the tests in the folders of these runs and fits the law.
///
/// # Errors
/// A folder without a drained triaxial test; a test without a peak; tests to which eq. 43 cannot be
/// fitted.
pub fn calibrate(folders: &[PathBuf]) -> Result<Fines> {
    let tests: Vec<Test> = folders.iter().map(|f| Test::read(f)).collect::<Result<_>>()?;
    let elastic: Vec<[f64; 2]> = tests.iter().map(Test::elastic).collect();
    let of = |k: usize| mean(elastic.iter().map(|e| e[k]));
    let elastic = [of(0), of(1)];
    let rows: Vec<Vec<[f64; 4]>> = tests.iter().map(|t| t.plastic(elastic)).collect();
    let peaks: Vec<usize> =
        rows.iter().map(|r| (0..r.len()).fold(0, |best, k| if r[k][3] > r[best][3] { k } else { best })).collect();
    if let Some(k) = peaks.iter().zip(&rows).position(|(p, r)| *p + 5 > r.len()) {
        return Err(Error::input(folders[k].display(), "", None, "has no peak before its end: shear it further"));
    }
    let residual = |t: &Test| {
        let from = t.axial[t.axial.len() - 1] * (1.0 - RESIDUAL);
        let kept: Vec<f64> = (0..t.axial.len()).filter(|i| t.axial[*i] >= from).map(|i| t.angle(i)).collect();
        mean(kept.into_iter())
    };
    let last = mean(tests.iter().map(residual));
    let peak = mean(peaks.iter().zip(&rows).map(|(p, r)| r[*p][3]));
    // all tests have one plastic strain at the peak: of those tried, the one with which eq. 43 fits
    // best
    let points: Vec<(f64, f64)> = rows.iter().flatten().filter(|r| r[0] > 0.0).map(|r| (r[2], r[3])).collect();
    let furthest = peaks.iter().zip(&rows).map(|(p, r)| r[*p][2]).fold(0.0, f64::max);
    let tried = (1..=PLACES).filter_map(|k| evolution(&points, furthest * f64::from(k) / f64::from(PLACES), peak, last));
    let best = tried.min_by(|a, b| a.misfit.total_cmp(&b.misfit));
    let Some(Evolution { peak_plastic, cubic, decay, misfit }) = best else {
        return Err(Error::input(folders[0].display(), "", None, "does not harden and soften as eq. 43 does"));
    };
    // α_ψ = r / (√3 (3 + r)) with r = −dε_v^p / dε_a^p, and sin ψ of the outer cone from α_ψ
    let window = |(peak, rows): (&usize, &Vec<[f64; 4]>)| {
        let end = (2 * peak).min(rows.len() - 1);
        -slope(&rows[peak / 2..=end].iter().map(|r| (r[0], r[1])).collect::<Vec<_>>())
    };
    let ratio = mean(peaks.iter().zip(&rows).map(window)).max(0.0);
    let alpha = ratio / (3f64.sqrt() * (3.0 + ratio));
    let sine = 3.0 * 3f64.sqrt() * alpha / (2.0 + 3f64.sqrt() * alpha);
    let dilation = sine.asin().min(last).min(cubic[3]);
    let strength = Strength::CubicExponential { initial: cubic[3], cubic, peak_strain: peak_plastic, peak, residual: last, decay };
    let [mobilised_dilation, mobilised_volume_misfit] = mobilised(&rows, &strength);
    let stays = Cone::Outer.at(dilation).alpha;
    Ok(Fines {
        tests: folders.to_vec(),
        young_mpa: 1e-6 * elastic[0],
        nu: elastic[1],
        peak_deg: peak.to_degrees(),
        residual_deg: last.to_degrees(),
        dilation_deg: dilation.to_degrees(),
        mobilised_dilation_deg: mobilised_dilation.to_degrees(),
        volume_misfit: volume_misfit(&rows, &strength, |_| stays),
        mobilised_volume_misfit,
        peak_axial_strain: mean(tests.iter().map(|t| t.axial[t.peak()])),
        peak_plastic_strain: peak_plastic,
        cubic_rad: cubic,
        decay,
        misfit_deg: misfit.to_degrees(),
        angles: rows.iter().map(|r| r.iter().map(|r| (r[2], r[3].to_degrees())).collect()).collect(),
    })
}

impl Fines {
    /// Text of a material file with the tables of the law. `base`: path of the grains' material, as
    /// written into the file; `dilation`: whether dilation stays or ends with softening;
    /// `interface`: friction along coarse grains, where it was measured.
    pub fn material(&self, base: Option<&str>, dilation: Dilation, interface: Option<&Interface>) -> String {
        let mut text = String::from("# The continuum of fine grains, calibrated from drained triaxial tests of grains alone.\n");
        if let Some(base) = base {
            let _ = writeln!(text, "base = {}", toml::Value::String(base.into()));
        }
        let digits = |x: f64| format!("{:?}", number(x).parse::<f64>().unwrap_or(x));
        let cubic = self.cubic_rad.map(digits).join(", ");
        // `friction_angle_deg` is the angle at first yield, the cubic at zero plastic strain
        let first = digits(self.cubic_rad[3].to_degrees());
        let (psi, rule) = match dilation {
            Dilation::Constant => (self.dilation_deg, ""),
            Dilation::Mobilised => (self.mobilised_dilation_deg, "dilation = \"mobilised\"\n"),
        };
        let friction = interface.map_or(String::new(), |i| match i.falling {
            Some(InterfaceFriction { initial, residual, decay }) => format!(
                "interface_friction = {}\ninterface_friction_residual = {}\ninterface_friction_decay = {}\n",
                digits(initial),
                digits(residual),
                digits(decay)
            ),
            None => format!("interface_friction = {}\n", digits(i.friction)),
        });
        let with = if interface.is_some() { ", interface_friction from contacts in a mixture of grains" } else { "" };
        let [young, nu, residual, psi] = [self.young_mpa, self.nu, self.residual_deg, psi].map(digits);
        let _ = write!(
            text,
            "\n[continuum]\nlaw = \"drucker_prager\"\nE_MPa = {young}\nnu = {nu}\ncone = \"outer\"\nfriction_angle_deg = {first}\ndilation_angle_deg = {psi}\n{rule}cohesion_kPa = 0.0\n{friction}\
             source = \"calibrated from triaxial tests of the grains{with}\"\n\n[continuum.friction_evolution]\nlaw = \"cubic_exponential\"\ncubic_rad = [{cubic}]\n\
             peak_plastic_strain = {}\npeak_deg = {}\nresidual_deg = {residual}\ndecay = {}\nsource = \"calibrated from triaxial tests of the grains; form of Li et al. 2023, eq. 43\"\n",
            digits(self.peak_plastic_strain),
            digits(self.peak_deg),
            digits(self.decay)
        );
        text
    }

    /// Writes the material, the report (JSON) and the angles (CSV) into the folder `out` and
    /// returns the files; arguments as in [`Fines::material`].
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn write(&self, out: &Path, base: Option<&str>, dilation: Dilation, interface: Option<&Interface>) -> Result<Vec<PathBuf>> {
        let mut angles = String::from("test,plastic_strain,friction_angle_deg\n");
        for (k, rows) in self.angles.iter().enumerate() {
            for (e, angle) in rows {
                let _ = writeln!(angles, "{k},{},{}", number(*e), number(*angle));
            }
        }
        let json = crate::json_text(self);
        let files = [(FILE, self.material(base, dilation, interface)), (REPORT, json), ("friction_angle.csv", angles)];
        let write = |(name, text): (&str, String)| {
            let path = out.join(name);
            std::fs::write(&path, text).map_err(Error::write(&path)).map(|()| path)
        };
        files.into_iter().map(write).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use engine::mpm::law::{ConstitutiveLaw, DruckerPrager, Evolution, InternalVariables};

    /// A test computed with the law, whose lateral strain keeps the cell pressure constant, gives
    /// the parameters of the law back; so does one with dilation that ends with softening, and each rule is nearer to the volume of its own.
    #[test]
    fn a_test_of_the_law_gives_its_parameters_back() {
        let found = calibrated(0.15, Dilation::Constant);
        near(&found, found.dilation_deg, 0.15f64.to_degrees(), 0.03);
        assert!(found.volume_misfit < 0.3 * found.mobilised_volume_misfit, "{found:?}");
        let found = calibrated(0.25, Dilation::Mobilised);
        near(&found, found.mobilised_dilation_deg, 0.25f64.to_degrees(), 0.05);
        assert!(found.mobilised_volume_misfit < 0.1 * found.volume_misfit, "{found:?}");
        assert!(found.material(None, Dilation::Mobilised, None).contains("dilation = \"mobilised\"\n"));
        assert!(!found.material(None, Dilation::Constant, None).contains("mobilised"));
    }

    #[track_caller]
    fn near(found: &Fines, a: f64, b: f64, by: f64) {
        assert!((a / b - 1.0).abs() < by, "{a} {b}: {found:?}");
    }

    fn calibrated(dilation: f64, dilation_rule: Dilation) -> Fines {
        let friction = Evolution::CubicExponential {
            initial: 0.3,
            cubic: [0.0, -300.0, 14.0, 0.3],
            peak_strain: 0.02,
            peak: 0.46,
            residual: 0.33,
            decay: 40.0,
        };
        let parameters = Parameters {
            cone: Cone::Outer,
            friction,
            cohesion: Evolution::Constant(0.0),
            dilation,
            dilation_rule,
            ..Parameters::of_elastic(Elastic::of_young(8e6, 0.2))
        };
        let law = DruckerPrager::new(parameters);
        let cell = 5e4;
        let (mut stress, mut memory) = ([-cell, -cell, -cell, 0.0, 0.0, 0.0], InternalVariables::default());
        let (mut axial, mut lateral) = (0.0, 0.0);
        let mut text = String::from("axial_strain,volumetric_strain,sigma_1_kPa,sigma_3_kPa\n");
        for step in 0..=12_000 {
            if step % 60 == 0 {
                let (a, v) = (axial, axial + 2.0 * lateral);
                let _ = writeln!(text, "{a:e},{v:e},{:e},{:e}", -1e-3 * stress[2], -1e-3 * stress[0]);
            }
            let da = 1e-5;
            // secant method for the increment of lateral strain that keeps the cell pressure
            let tried = |dr: f64| law.update(stress, [-dr, -dr, -da, 0.0, 0.0, 0.0], memory);
            let (mut x0, mut x1) = (-0.2 * da, -0.6 * da);
            for _ in 0..60 {
                let [f0, f1] = [x0, x1].map(|x| tried(x).0[0] + cell);
                if f1.abs() < 1e-7 || f1 == f0 {
                    break;
                }
                (x0, x1) = (x1, x1 - f1 * (x1 - x0) / (f1 - f0));
            }
            (stress, memory) = tried(x1);
            axial += da;
            lateral += x1;
        }
        let folder = tempfile::tempdir().expect("folder");
        std::fs::write(folder.path().join("history.csv"), text).expect("written");
        let found = calibrate(&[folder.path().into()]).expect("a calibration");
        let near = |a: f64, b: f64, by: f64| near(&found, a, b, by);
        near(found.young_mpa, 8.0, 0.02);
        near(found.nu, 0.2, 0.05);
        near(found.peak_deg, 0.46f64.to_degrees(), 0.02);
        near(found.residual_deg, 0.33f64.to_degrees(), 0.02);
        near(found.peak_plastic_strain, 0.02, 0.1);
        near(found.decay, 40.0, 0.1);
        assert!(found.misfit_deg < 0.4, "{found:?}");
        found
    }
}
