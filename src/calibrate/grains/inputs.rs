//! Inputs of a calibration that crushing forces cannot determine: the contact angle, or the moduli
//! of grain and platen.

use super::area::{Area, Model};
use engine::material::effective_modulus;
use laboratory::error::{Error, Result};
use laboratory::scene::{material_keys, shown};
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Reference diameter where none is given, m (Ciantia et al. 2015, below eq. 7).
pub const D0: f64 = 2e-3;

/// Inputs as the user gave them; a material gives those that are missing.
#[derive(Clone, Debug, Default)]
pub struct Given {
    /// Area models to be fitted; `None`: the one whose inputs (angle, or moduli) are known, both
    /// models if both or neither are.
    pub models: Option<Vec<Model>>,
    /// Contact angle, rad (eq. 16).
    pub theta0: Option<f64>,
    /// Young's modulus of the grains, GPa.
    pub grain_e_gpa: Option<f64>,
    /// Poisson's ratio of the grains.
    pub grain_nu: Option<f64>,
    /// Young's modulus of the platens, GPa.
    pub platen_e_gpa: f64,
    /// Poisson's ratio of the platens.
    pub platen_nu: f64,
    /// Reference diameter, mm.
    pub d0_mm: Option<f64>,
    /// Material file that gives missing inputs.
    pub material: Option<PathBuf>,
}

/// The inputs of a calibration, complete and in SI units.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// Area models that are fitted.
    pub areas: Vec<Area>,
    /// Reference diameter, m.
    pub d0: f64,
    /// Contact angle, rad.
    pub theta0: Option<f64>,
    /// Young's modulus, Pa, and Poisson ratio of the grain.
    pub grain: Option<(f64, f64)>,
    /// Young's modulus, Pa, and Poisson's ratio of the platens.
    pub platen: (f64, f64),
    /// Whether Young's modulus of the grain was given directly and does not come from the material.
    pub own_moduli: bool,
    /// Material file that gives missing inputs.
    pub material: Option<PathBuf>,
}

impl Given {
    /// Checks the inputs and takes missing ones from the material.
    pub fn resolve(&self) -> Result<Inputs> {
        let table = match &self.material {
            Some(path) => Some((path.as_path(), material_keys(path)?)),
            None => None,
        };
        let from = |key: &str| match &table {
            Some((path, table)) => number(path, table, key),
            None => Ok(None),
        };
        let own_moduli = self.grain_e_gpa.is_some();
        let theta0 = self.theta0.map_or_else(|| from("strength.fixed_angle.theta0_rad"), |v| Ok(Some(v)))?;
        let nu = self.grain_nu.map_or_else(|| from("elastic.nu"), |v| Ok(Some(v)))?;
        let young = match (self.grain_e_gpa, from("elastic.E_GPa")?, from("elastic.G_GPa")?) {
            (Some(e), _, _) | (None, Some(e), _) => Some(e),
            (None, None, Some(g)) => nu.map(|nu| 2.0 * g * (1.0 + nu)),
            _ => None,
        };
        let d0_mm = self.d0_mm.map_or_else(|| from("strength.d0_mm"), |v| Ok(Some(v)))?.unwrap_or(1e3 * D0);
        check(theta0, "--theta0", |v| v > 0.0 && v < 1.57, "must be > 0 and < 1.57 rad (20° are 0.349)")?;
        check(young, "--grain-E-GPa", |v| v > 0.0 && v < 1e6, "must be > 0 and < 1e6")?;
        check(nu, "--grain-nu", |v| v > -1.0 && v < 0.5, "must be > -1 and < 0.5")?;
        check(Some(self.platen_e_gpa), "--platen-E-GPa", |v| v > 0.0 && v < 1e6, "must be > 0 and < 1e6")?;
        check(Some(self.platen_nu), "--platen-nu", |v| v > -1.0 && v < 0.5, "must be > -1 and < 0.5")?;
        check(Some(d0_mm), "--d0-mm", |v| v > 0.0 && v < 1e6, "must be > 0 and < 1e6")?;
        if young.is_some() && nu.is_none() {
            return Err(Error::input("--grain-nu", "", None, "is needed beside --grain-E-GPa (eq. 11)"));
        }
        let grain = young.zip(nu).map(|(e, nu)| (1e9 * e, nu));
        let platen = (1e9 * self.platen_e_gpa, self.platen_nu);
        let models = self.models.clone().unwrap_or(match (theta0, grain) {
            (Some(_), None) => vec![Model::FixedAngle],
            (None, Some(_)) => vec![Model::Hertz],
            _ => vec![Model::FixedAngle, Model::Hertz],
        });
        let areas = models.iter().map(|m| match m {
            Model::FixedAngle => Area::fixed_angle(theta0),
            Model::Hertz => Area::hertz(grain.map(|g| effective_modulus(g, platen))),
        });
        Ok(Inputs { areas: areas.collect(), d0: 1e-3 * d0_mm, theta0, grain, platen, own_moduli, material: self.material.clone() })
    }
}

fn check(value: Option<f64>, place: &str, allowed: impl Fn(f64) -> bool, message: &str) -> Result<()> {
    match value {
        // every comparison with NaN is false, so that NaN is refused
        Some(v) if !allowed(v) => Err(Error::input(format!("{place} {v}"), "", None, message)),
        _ => Ok(()),
    }
}

/// The number at a dotted `key` of a material file; `None` if the file has no such key.
fn number(path: &Path, table: &Table, key: &str) -> Result<Option<f64>> {
    let mut names = key.split('.');
    let mut value = names.next().and_then(|n| table.get(n));
    for name in names {
        value = value.and_then(|v| v.get(name));
    }
    match value {
        None => Ok(None),
        Some(Value::Float(x)) => Ok(Some(*x)),
        Some(Value::Integer(i)) => Ok(Some(*i as f64)),
        Some(other) => Err(Error::input(path.display(), key, Some(shown(other)), "must be a number")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given() -> Given {
        Given { platen_e_gpa: 200.0, platen_nu: 0.3, ..Given::default() }
    }

    #[test]
    fn area_models_follow_what_is_given() {
        let models = |g: Given| g.resolve().expect("inputs").areas.iter().map(|a| (a.model, a.known)).collect::<Vec<_>>();
        assert_eq!(models(given()), [(Model::FixedAngle, false), (Model::Hertz, false)]);
        assert_eq!(models(Given { theta0: Some(0.35), ..given() }), [(Model::FixedAngle, true)]);
        assert_eq!(models(Given { grain_e_gpa: Some(8.0), grain_nu: Some(0.3), ..given() }), [(Model::Hertz, true)]);
        let both = Given { theta0: Some(0.35), models: Some(vec![Model::FixedAngle, Model::Hertz]), ..given() };
        assert_eq!(models(both), [(Model::FixedAngle, true), (Model::Hertz, false)]);
    }

    #[test]
    fn a_material_fills_the_gaps() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let coke = Given { material: Some(root.join("materials/petroleum_coke.toml")), d0_mm: Some(5.0), ..given() };
        let inputs = coke.resolve().expect("inputs");
        assert_eq!(inputs.areas.len(), 2);
        assert!(inputs.areas.iter().all(|a| a.known));
        let (young, nu) = inputs.grain.expect("moduli");
        assert!((young - 0.858e9).abs() < 1.0 && nu == 0.3 && inputs.d0 == 5e-3 && !inputs.own_moduli);
        assert!((inputs.theta0.expect("angle") - std::f64::consts::PI / 9.0).abs() < 1e-12);
    }

    #[test]
    fn wrong_inputs_are_refused() {
        for (given, says) in [
            (Given { theta0: Some(20.0), ..given() }, "--theta0 20: must be > 0 and < 1.57 rad"),
            (Given { theta0: Some(f64::NAN), ..given() }, "--theta0 NaN"),
            (Given { grain_e_gpa: Some(-1.0), grain_nu: Some(0.3), ..given() }, "--grain-E-GPa -1"),
            (Given { grain_e_gpa: Some(1.0), ..given() }, "--grain-nu: is needed"),
            (Given { platen_nu: 0.7, ..given() }, "--platen-nu 0.7"),
            (Given { d0_mm: Some(0.0), ..given() }, "--d0-mm 0"),
            (Given { material: Some("no.toml".into()), ..given() }, "no such file"),
        ] {
            let error = given.resolve().expect_err("refused").to_string();
            assert!(error.contains(says), "{error}");
        }
    }
}
