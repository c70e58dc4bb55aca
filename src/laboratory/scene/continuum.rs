//! From `[continuum]` of a material to its [`Law`].

use super::layers::Layer;
use super::material::Named;
use super::provenance::{Assumption, assumed_in};
use super::view::View;
use super::{files, overrides, validate, write};
use crate::error::{Error, Result};
use engine::material::InterfaceFriction;
use engine::math::portable::ln;
use engine::mpm::law::{Clay, Cone, Dilation, Elastic, Evolution, Law, Parameters, Shear, dilatancy};
use std::path::Path;
use toml::Value;

/// A material as a continuum, read from its file without a scene.
#[derive(Clone, Debug)]
pub struct ContinuumMaterial {
    /// Name of the material.
    pub name: String,
    /// Constitutive law.
    pub law: Law,
    /// The material with every override and default, as text of a material file.
    pub resolved: String,
    /// Values whose source is an assumption.
    pub assumed: Vec<Assumption>,
}

/// Reads the constitutive law of the material file `path`, with the overrides `sets` (`continuum.nu=0.2`) laid over it.
///
/// # Errors
/// Every mistake in file and overrides, with file, key, value and what is allowed.
pub fn continuum(path: &Path, sets: &[String]) -> Result<ContinuumMaterial> {
    let mut material = files::material_file(path)?;
    if material.table.contains_key("kind") {
        return Err(Error::input(path.display(), "kind", None, "is that of a scene: a material file is needed"));
    }
    for set in sets {
        // as in scenes, where a material is a table
        overrides::apply(&mut material, set.trim_start().strip_prefix("material.").unwrap_or(set))?;
    }
    let mut layer = Layer::default();
    layer.mount("material", material);
    validate::validate_material(&mut layer)?;
    let view = View::of(&layer);
    let named = Named { name: view.text("material.name").into(), at: "material".into() };
    let law = view.continuum(&named);
    view.interface_friction("material.continuum");
    Error::all(view.into_errors())?;
    let law = law.ok_or_else(|| Error::input(path.display(), "continuum", None, "is not a complete law"))?;
    let table = layer.table.get("material").and_then(Value::as_table).cloned().unwrap_or_default();
    let assumed = table.get("continuum").and_then(Value::as_table).map(|t| assumed_in(t, "continuum")).unwrap_or_default();
    Ok(ContinuumMaterial { name: named.name, law, resolved: write::write_material(&table), assumed })
}

impl View<'_> {
    /// The law of a material as a continuum; what it lacks or what does not agree is noted.
    pub fn continuum(&self, of: &Named) -> Option<Law> {
        let at = of.key("continuum");
        if !self.has(&at) {
            self.refuse(&at, "is missing: a continuum needs [continuum] with law, E_MPa and nu");
            return None;
        }
        let key = |name: &str| format!("{at}.{name}");
        let word = self.text(&key("law"));
        let reads = Law::keys(word)?;
        for (name, stem) in PLASTIC {
            self.check(reads.contains(&stem) || !self.has(&key(name)), &key(name), format!("has no meaning with law = \"{word}\""));
        }
        if reads.contains(&"lambda") {
            return Law::named(word, &self.clay(&at)?);
        }
        let moduli = (self.number(&key("G_MPa")), self.number(&key("E_MPa")));
        let nu = self.needed(&key("nu"), "the Poisson ratio")?;
        let elastic = match moduli {
            (Some(g), None) => Elastic::of_shear(g, nu),
            (None, Some(e)) => Elastic::of_young(e, nu),
            _ => {
                self.refuse(&at, "must have G_MPa or E_MPa, one of them");
                return None;
            }
        };
        if reads.is_empty() {
            return Law::named(word, &Parameters::of_elastic(elastic));
        }
        let cone = match self.text(&key("cone")) {
            _ if !reads.contains(&"cone") => Cone::Outer,
            "outer" => Cone::Outer,
            "inner" => Cone::Inner,
            "plane_strain" => Cone::PlaneStrain,
            _ => {
                self.refuse(
                    &key("cone"),
                    "is missing: write \"outer\", \"inner\" or \"plane_strain\"; friction angles mean nothing without it",
                );
                return None;
            }
        };
        let friction = self.angle(&at, "friction_angle");
        let dilation = self.angle(&at, "dilation_angle");
        let cohesion = self.number(&key("cohesion_kPa"));
        if cohesion.is_none() {
            self.refuse(&key("cohesion_kPa"), "is missing: write 0 for a soil without cohesion");
        }
        let friction = self.evolution(&key("friction_evolution"), friction?, ["_deg", "_rad"]);
        let cohesion = self.evolution(&key("cohesion_evolution"), cohesion?, ["_kPa", ""]);
        let (friction, cohesion, dilation) = (friction?, cohesion?, dilation?);
        let dilation_rule = if self.text(&key("dilation")) == "mobilised" { Dilation::Mobilised } else { Dilation::Constant };
        let ok = self.agree(&at, &friction, &cohesion, (dilation, dilation_rule));
        let tension = self.number(&key("tension_kPa")).unwrap_or(f64::INFINITY);
        if ok {
            {
                let base = Parameters::of_elastic(elastic);
                Law::named(word, &Parameters { cone, friction, cohesion, dilation, dilation_rule, tension, ..base })
            }
        } else {
            None
        }
    }

    /// Friction of a material as a continuum, whose table is `at`, on grains and rigid bodies; what does not agree is noted.
    pub fn interface_friction(&self, at: &str) -> Option<InterfaceFriction> {
        let keys = ["", "_residual", "_decay"].map(|part| format!("{at}.interface_friction{part}"));
        let [initial, residual, decay] = [0, 1, 2].map(|k| self.number(&keys[k]));
        if residual.is_none() && decay.is_none() {
            return initial.map(InterfaceFriction::constant);
        }
        let word = self.text(&format!("{at}.law"));
        let accumulates = Law::keys(word).is_some_and(|keys| keys.contains(&"dilation_angle"));
        let own = if residual.is_some() { &keys[1] } else { &keys[2] };
        self.check(accumulates, own, format!("has no meaning with law = \"{word}\": it accumulates no plastic shear strain"));
        let all = "friction that falls with plastic strain is given by interface_friction, interface_friction_residual and interface_friction_decay";
        let [initial, residual, decay] = [0, 1, 2].map(|k| self.needed(&keys[k], all));
        Some(InterfaceFriction { initial: initial?, residual: residual?, decay: decay? })
    }

    /// The number at a key that this law needs; `what` it is.
    fn needed(&self, key: &str, what: &str) -> Option<f64> {
        let value = self.number(key);
        if value.is_none() {
            self.refuse(key, format!("is missing: {what}"));
        }
        value
    }

    /// The parameters of Modified Cam-clay. Its virgin line is given at 1 kPa, the law has it at the preconsolidation pressure.
    fn clay(&self, at: &str) -> Option<Parameters> {
        let key = |name: &str| format!("{at}.{name}");
        self.check(
            !self.has(&key("E_MPa")),
            &key("E_MPa"),
            "has no meaning with law = \"cam_clay\": its stiffness goes with the pressure, by kappa and nu or G_MPa",
        );
        let shear = match (self.number(&key("G_MPa")), self.number(&key("nu"))) {
            (Some(g), None) => Some(Shear::Modulus(g)),
            (None, Some(nu)) => Some(Shear::Poisson(nu)),
            _ => {
                self.refuse(
                    at,
                    "must have nu or G_MPa, one of them, with law = \"cam_clay\": a Poisson ratio or a shear modulus that stays",
                );
                None
            }
        };
        let friction = self.angle(at, "friction_angle");
        let lambda = self.needed(&key("lambda"), "slope of the virgin line in (ln p, v)");
        let kappa = self.needed(&key("kappa"), "slope of swelling lines in (ln p, v)");
        let at_1_kpa = self.needed(&key("virgin_specific_volume"), "specific volume 1 + e on the virgin line at 1 kPa");
        let preconsolidation =
            self.needed(&key("preconsolidation_kPa"), "the largest isotropic pressure that is elastic at the start");
        let (shear, friction, lambda, kappa) = (shear?, friction?, lambda?, kappa?);
        let (at_1_kpa, preconsolidation) = (at_1_kpa?, preconsolidation?);
        let virgin_volume = at_1_kpa - lambda * ln(1e-3 * preconsolidation);
        let mut ok = true;
        let mut check = |good: bool, name: &str, message: String| {
            ok &= good;
            self.check(good, &key(name), message);
        };
        check(kappa < lambda, "kappa", format!("must be below lambda, {lambda}"));
        check(friction > 0.0, "friction_angle_deg", "must be > 0: the ellipse has no height without friction".into());
        check(
            virgin_volume > 1.0,
            "virgin_specific_volume",
            format!(
                "leaves no pores at the preconsolidation pressure: the specific volume there is {virgin_volume:.4}; write more than {:.4}",
                1.0 + lambda * ln(1e-3 * preconsolidation)
            ),
        );
        let clay = Clay { virgin_slope: lambda, swelling_slope: kappa, preconsolidation, virgin_volume, shear };
        // the law has moduli of its own
        let elastic = Elastic { bulk: 0.0, shear: 0.0 };
        ok.then(|| Parameters { friction: Evolution::Constant(friction), clay, ..Parameters::of_elastic(elastic) })
    }

    /// Ranges that no single key shows.
    fn agree(&self, at: &str, friction: &Evolution, cohesion: &Evolution, (dilation, rule): (f64, Dilation)) -> bool {
        const DEGREE: f64 = std::f64::consts::PI / 180.0;
        let ((least, most), (weakest, strongest)) = (friction.range(), cohesion.range());
        let key = |name: &str| format!("{at}.{name}");
        let in_use = |names: [&str; 2]| names.iter().map(|n| key(n)).find(|k| self.has(k)).unwrap_or(key(names[0]));
        let cubic = |table: &str, name: &str| in_use([&format!("{table}.{name}"), table]);
        let mut ok = true;
        let mut check = |good: bool, key: String, message: String| {
            ok &= good;
            self.check(good, &key, message);
        };
        check(
            least >= 0.0 && most < 1.55,
            cubic("friction_evolution", "cubic_rad"),
            format!(
                "gives friction angles from {:.2} to {:.2} degrees; they must stay within 0 and 88.8",
                least / DEGREE,
                most / DEGREE
            ),
        );
        check(
            weakest >= 0.0,
            cubic("cohesion_evolution", "cubic_kPa"),
            format!("gives cohesions down to {:.4} kPa; they must not be negative", 1e-3 * weakest),
        );
        let (largest, which) = if rule == Dilation::Mobilised { (most, "largest") } else { (least, "smallest") };
        check(
            dilation <= largest.max(0.0) * (1.0 + 1e-12),
            in_use(["dilation_angle_deg", "dilation_angle_rad"]),
            format!(
                "must not be larger than the {which} friction angle, {:.4} degrees: flow would create energy",
                largest / DEGREE
            ),
        );
        check(
            rule == Dilation::Constant || dilatancy::softens(friction),
            key("dilation"),
            "needs friction that falls to a final value: write continuum.friction_evolution whose last value is not its largest, or dilation = \"constant\"".into(),
        );
        check(
            most > 0.0 || strongest > 0.0,
            in_use(["friction_angle_deg", "friction_angle_rad"]),
            "leaves no strength, with cohesion_kPa = 0: one of them must be > 0".into(),
        );
        ok
    }

    /// An angle in degrees or rad.
    fn angle(&self, at: &str, name: &str) -> Option<f64> {
        self.either(at, name, ["_deg", "_rad"])
    }

    /// `name` with one of two suffixes, the second of which may be empty (there is only one).
    fn either(&self, at: &str, name: &str, suffixes: [&str; 2]) -> Option<f64> {
        let keys = suffixes.map(|suffix| format!("{at}.{name}{suffix}"));
        let (first, second) = (self.number(&keys[0]), self.number(&keys[1]).filter(|_| !suffixes[1].is_empty()));
        match (first, second) {
            (Some(value), None) | (None, Some(value)) => Some(value),
            (None, None) => {
                let or = if suffixes[1].is_empty() { String::new() } else { format!(" or {name}{}", suffixes[1]) };
                self.refuse(&keys[0], format!("is missing: write {name}{}{or}", suffixes[0]));
                None
            }
            _ => {
                self.refuse(&keys[0], format!("must not stand beside {name}{}", suffixes[1]));
                None
            }
        }
    }

    /// Constant, or as the table `at` says.
    fn evolution(&self, at: &str, initial: f64, suffixes: [&str; 2]) -> Option<Evolution> {
        if !self.has(at) {
            return Some(Evolution::Constant(initial));
        }
        let key = |name: &str| format!("{at}.{name}");
        let law = self.text(&key("law"));
        let (own, other) = if law == "linear" { (LINEAR, CUBIC) } else { (CUBIC, LINEAR) };
        for stem in other {
            for suffix in ["", "_deg", "_rad", "_kPa"] {
                let key = key(&format!("{stem}{suffix}"));
                let alone = !own.contains(stem) && self.has(&key);
                self.check(!alone, &key, format!("has no meaning with law = \"{law}\""));
            }
        }
        let needed = |name: &str| {
            let value = self.number(&key(name));
            if value.is_none() {
                self.refuse(&key(name), format!("is missing: law = \"{law}\" needs {name}"));
            }
            value
        };
        if law == "linear" {
            let (last, strain) = (self.either(at, "last", suffixes), needed("plastic_strain"));
            return Some(Evolution::Linear { initial, last: last?, strain: strain? });
        }
        let cubic = key(if suffixes[0] == "_kPa" { "cubic_kPa" } else { "cubic_rad" });
        let coefficients: Option<[f64; 4]> = self.numbers(&cubic).try_into().ok();
        if coefficients.is_none() {
            self.refuse(&cubic, "is missing: [a, b, c, d] of eq. 43");
        }
        let (peak, residual) = (self.either(at, "peak", suffixes), self.either(at, "residual", suffixes));
        let (peak_strain, decay) = (needed("peak_plastic_strain"), needed("decay"));
        Some(Evolution::CubicExponential {
            initial,
            cubic: coefficients?,
            peak_strain: peak_strain?,
            peak: peak?,
            residual: residual?,
            decay: decay?,
        })
    }
}

/// Keys of plasticity, with and without their units.
const PLASTIC: [(&str, &str); 14] = [
    ("cone", "cone"),
    ("friction_angle_deg", "friction_angle"),
    ("friction_angle_rad", "friction_angle"),
    ("dilation_angle_deg", "dilation_angle"),
    ("dilation_angle_rad", "dilation_angle"),
    ("dilation", "dilation"),
    ("cohesion_kPa", "cohesion"),
    ("tension_kPa", "tension"),
    ("friction_evolution", "friction_evolution"),
    ("cohesion_evolution", "cohesion_evolution"),
    ("lambda", "lambda"),
    ("kappa", "kappa"),
    ("virgin_specific_volume", "virgin_specific_volume"),
    ("preconsolidation_kPa", "preconsolidation"),
];
/// Keys of the two kinds of evolution, without their units.
const LINEAR: &[&str] = &["last", "plastic_strain"];
const CUBIC: &[&str] = &["cubic", "peak_plastic_strain", "peak", "residual", "decay"];

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "name = \"m\"\n[grain]\ndensity_kg_m3 = 2600.0\n[continuum]\n";
    const SOIL: &str = "law = \"drucker_prager\"\nE_MPa = 4.6\nnu = 0.12\ncone = \"outer\"\nfriction_angle_deg = 30.0\ndilation_angle_deg = 5.0\ncohesion_kPa = 2.0\n";

    fn read(text: &str, sets: &[&str]) -> Result<ContinuumMaterial> {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("m.toml");
        std::fs::write(&path, format!("{HEAD}{text}")).expect("written");
        continuum(&path, &sets.iter().map(|s| s.to_string()).collect::<Vec<_>>())
    }

    fn refusal(text: &str, sets: &[&str]) -> String {
        read(text, sets).expect_err("refused").to_string()
    }

    #[test]
    fn values_become_si() {
        let Law::DruckerPrager(law) = read(SOIL, &["continuum.tension_kPa=1"]).expect("a law").law else { panic!("the law") };
        let p = *law.parameters();
        assert_eq!((p.cone, p.cohesion, p.tension), (Cone::Outer, Evolution::Constant(2e3), 1e3));
        assert_eq!(p.friction, Evolution::Constant(30.0 * (std::f64::consts::PI / 180.0)));
        assert!((p.elastic.young() - 4.6e6).abs() < 1e-6);
        let Law::Elastic(law) = read("law = \"elastic\"\nG_MPa = 2.0\nnu = 0.25\n", &[]).expect("a law").law else {
            panic!("the law")
        };
        assert!((law.young() - 5e6).abs() < 1e-6);
    }

    #[test]
    fn a_key_in_the_other_unit_replaces_that_of_the_file() {
        let radians = read(SOIL, &["material.continuum.friction_angle_rad=0.5"]).expect("a law");
        let Law::DruckerPrager(law) = radians.law else { panic!("the law") };
        assert_eq!(law.parameters().friction, Evolution::Constant(0.5));
    }

    #[test]
    fn the_resolved_file_gives_the_same_law() {
        let first = read(SOIL, &["continuum.nu=0.3"]).expect("a law");
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("again.toml");
        std::fs::write(&path, &first.resolved).expect("written");
        let second = continuum(&path, &[]).expect("a law");
        assert_eq!((first.law, first.resolved), (second.law, second.resolved));
    }

    const CLAY: &str = "law = \"cam_clay\"\nnu = 0.3\nlambda = 0.16\nkappa = 0.06\nfriction_angle_deg = 23.0\nvirgin_specific_volume = 2.8\npreconsolidation_kPa = 200.0\n";

    #[test]
    fn clay_is_read_with_its_virgin_line_at_the_preconsolidation_pressure() {
        let Law::CamClay(law) = read(CLAY, &[]).expect("a law").law else { panic!("the law") };
        let parameters: Parameters = law.into();
        let clay = parameters.clay;
        assert_eq!(
            (clay.virgin_slope, clay.swelling_slope, clay.preconsolidation, clay.shear),
            (0.16, 0.06, 2e5, Shear::Poisson(0.3))
        );
        assert!((clay.virgin_volume - (2.8 - 0.16 * 200f64.ln())).abs() < 1e-12);
        let modulus = CLAY.replace("nu = 0.3", "G_MPa = 5.0");
        let Law::CamClay(law) = read(&modulus, &[]).expect("a law").law else { panic!("the law") };
        assert_eq!(Parameters::from(law).clay.shear, Shear::Modulus(5e6));
        // a key of clay takes Young's modulus away
        let elastic = "law = \"elastic\"\nE_MPa = 4.6\nnu = 0.12\n";
        let sets: Vec<String> =
            CLAY.lines().filter(|l| !l.starts_with("nu")).map(|l| format!("continuum.{}", l.replace(' ', ""))).collect();
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        assert!(matches!(read(elastic, &sets).expect("a law").law, Law::CamClay(_)));
        // and the file with defaults gives the same law
        let dir = tempfile::tempdir().expect("folder");
        let first = read(CLAY, &[]).expect("a law");
        std::fs::write(dir.path().join("again.toml"), &first.resolved).expect("written");
        assert_eq!(continuum(&dir.path().join("again.toml"), &[]).expect("a law").law, first.law);
    }

    #[test]
    fn plastic_keys_go_only_with_the_laws_that_use_them() {
        let soft = format!("{SOIL}[continuum.friction_evolution]\nlaw = \"linear\"\nlast_deg = 20.0\nplastic_strain = 0.1\n");
        // above the smallest friction angle, not above the largest
        let Law::DruckerPrager(law) =
            read(&soft, &["continuum.dilation=mobilised", "continuum.dilation_angle_deg=25"]).expect("a law").law
        else {
            panic!("the law")
        };
        assert_eq!(law.parameters().dilation_rule, Dilation::Mobilised);
        for (text, sets, says) in [
            (
                &*soft,
                &["continuum.dilation=mobilised", "continuum.dilation_angle_deg=31"][..],
                "must not be larger than the largest friction angle, 30",
            ),
            (&soft, &["continuum.dilation_angle_deg=25"], "must not be larger than the smallest friction angle, 20"),
            (SOIL, &["continuum.dilation=mobilised"], "needs friction that falls to a final value"),
            (SOIL, &["continuum.dilation=rowe"], "must be \"constant\" or \"mobilised\""),
            (CLAY, &["continuum.dilation=mobilised"], "continuum.dilation=mobilised: has no meaning with law = \"cam_clay\""),
            (CLAY, &["continuum.kappa=0.2"], "must be below lambda, 0.16"),
            (
                CLAY,
                &[
                    "continuum.interface_friction=0.2",
                    "continuum.interface_friction_residual=0.1",
                    "continuum.interface_friction_decay=9",
                ],
                "accumulates no plastic shear strain",
            ),
            (
                SOIL,
                &["continuum.interface_friction=0.2", "continuum.interface_friction_decay=9"],
                "continuum.interface_friction_residual: is missing",
            ),
            (
                SOIL,
                &["continuum.interface_friction_residual=0.2", "continuum.interface_friction_decay=9"],
                "continuum.interface_friction: is missing",
            ),
            (CLAY, &["continuum.G_MPa=5"], "must have nu or G_MPa, one of them"),
            (CLAY, &["continuum.virgin_specific_volume=1.5"], "leaves no pores at the preconsolidation pressure"),
            (CLAY, &["continuum.friction_angle_deg=0"], "the ellipse has no height without friction"),
            (&CLAY.replace("lambda = 0.16\n", ""), &[], "continuum.lambda: is missing"),
            (&format!("{CLAY}E_MPa = 3.0\n"), &[], "continuum.E_MPa = 3: has no meaning"),
            (SOIL, &["continuum.lambda=0.1"], "has no meaning with law = \"drucker_prager\""),
        ] {
            let message = refusal(text, sets);
            assert!(message.contains(says), "{says}: {message}");
        }
    }

    #[test]
    fn mistakes_are_named_before_any_work() {
        let without = |line: &str| SOIL.lines().filter(|l| !l.starts_with(line)).collect::<Vec<_>>().join("\n");
        for (text, sets, says) in [
            (without("cone"), vec![], "continuum.cone: is missing"),
            (without("cohesion"), vec![], "continuum.cohesion_kPa: is missing"),
            (
                without("dilation"),
                vec![],
                "continuum.dilation_angle_deg: is missing: write dilation_angle_deg or dilation_angle_rad",
            ),
            (without("E_MPa"), vec![], "must have G_MPa or E_MPa"),
            (without("nu"), vec![], "continuum.nu: is missing"),
            (SOIL.into(), vec!["continuum.nu=0.5"], "must be > -1 and < 0.5"),
            (SOIL.into(), vec!["continuum.cone=middle"], "must be \"outer\" or \"inner\" or \"plane_strain\""),
            (SOIL.into(), vec!["continuum.dilation_angle_deg=31"], "must not be larger than the smallest friction angle, 30"),
            (SOIL.into(), vec!["continuum.friction_angle_deg=90"], "< 89"),
            (SOIL.into(), vec!["continuum.law=elastic"], "has no meaning with law = \"elastic\""),
            (SOIL.into(), vec!["continuum.friction_evolution.law=linear"], "linear: is missing: write last_deg or last_rad"),
            (SOIL.into(), vec!["continuum.frictoin_angle_deg=3"], "did you mean continuum.friction_angle_deg?"),
            (
                SOIL.into(),
                vec!["continuum.friction_angle_deg=0", "continuum.dilation_angle_deg=0", "continuum.cohesion_kPa=0"],
                "leaves no strength",
            ),
            (format!("{SOIL}friction_angle_rad = 0.5\n"), vec![], "must not stand beside friction_angle_rad"),
            (
                format!(
                    "{SOIL}[continuum.cohesion_evolution]\nlaw = \"linear\"\nlast_kPa = 1.0\nplastic_strain = 0.1\ndecay = 2.0\n"
                ),
                vec![],
                "continuum.cohesion_evolution.decay = 2: has no meaning with law = \"linear\"",
            ),
            (
                format!(
                    "{SOIL}[continuum.cohesion_evolution]\nlaw = \"cubic_exponential\"\ncubic_kPa = [0.0, 0.0, -100.0, 2.0]\n\
                     peak_plastic_strain = 0.1\npeak_kPa = 1.0\nresidual_kPa = 0.5\ndecay = 2.0\n"
                ),
                vec![],
                "gives cohesions down to -8.0000 kPa",
            ),
        ] {
            let message = refusal(&text, &sets);
            assert!(message.contains(says), "{says}: {message}");
        }
        let message = refusal("", &[]);
        assert!(message.contains("continuum.law: is missing"), "{message}");
    }
}
