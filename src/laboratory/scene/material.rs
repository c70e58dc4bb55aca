//! Makes [`Material`] from the keys of a material.

use super::schema::unit;
use super::view::View;
use engine::material::Material;
use engine::parameter::{Parameter, Values};
use toml::{Table, Value};

/// A material of the scene.
pub struct Named {
    /// Name of the material in the scene.
    pub name: String,
    /// Dotted key of the table that holds the material: `material` or `materials.NAME`.
    pub at: String,
}

impl Named {
    /// Dotted key in the scene of the material's own key `key` (`elastic.nu`).
    pub fn key(&self, key: &str) -> String {
        format!("{}.{key}", self.at)
    }
}

impl View<'_> {
    /// The materials of the scene; the index of a material in the list is its number. `None`, with the reason noted, where there is
    /// none, where there are more than 256, or where `material` and `materials` both stand there.
    pub fn materials(&self) -> Option<Vec<Named>> {
        if self.has("material") {
            let several = self.has("materials");
            self.check(!several, "materials", "must not stand beside `material`");
            return (!several).then(|| vec![Named { name: self.text("material.name").into(), at: "material".into() }]);
        }
        let named: Vec<Named> = self
            .table("materials")
            .into_iter()
            .flat_map(Table::keys)
            .map(|name| Named { name: name.clone(), at: format!("materials.{name}") })
            .collect();
        if named.is_empty() {
            let example = "material = \"../../materials/petroleum_coke.toml\"";
            self.refuse("material", format!("is missing: write {example}"));
            return None;
        }
        if named.len() > 256 {
            self.refuse("materials", "must be at most 256 materials");
            return None;
        }
        Some(named)
    }

    /// Young's modulus, Pa, and Poisson ratio, -; (0, 0) where the material has none and they are not `needed`. `None`, with the
    /// reason noted, where they are needed and missing, or where the material does not have exactly one modulus. `why`: what needs
    /// them, for the message.
    pub fn elastic(&self, of: &Named, needed: bool, why: &str) -> Option<(f64, f64)> {
        let table = of.key("elastic");
        if !self.has(&table) {
            if needed {
                self.refuse(&table, format!("is missing: {why} needs G_GPa or E_GPa, and nu"));
                return None;
            }
            return Some((0.0, 0.0));
        }
        let nu = self.si(&of.key("elastic.nu"));
        let g = self.number(&of.key("elastic.G_GPa"));
        let e = self.number(&of.key("elastic.E_GPa"));
        match (g, e) {
            (Some(g), None) => Some((2.0 * g * (1.0 + nu), nu)),
            (None, Some(e)) => Some((e, nu)),
            _ => {
                self.refuse(&table, "must have G_GPa or E_GPa, one of them");
                None
            }
        }
    }

    /// The constants of a grain material; `None`, with the reason noted, where elastic constants or friction are missing or given
    /// twice.
    pub fn material(&self, of: &Named) -> Option<Material> {
        let law = self.law();
        let hertzian_area = self.flag("crushing.enabled") && self.criterion() == "hertz_area";
        let why = if !law.is_hertzian() {
            "crushing.criterion = \"hertz_area\"".to_string()
        } else if self.is_grain_crushing() {
            "a platen test".into()
        } else {
            format!("contact.law = \"{}\"", self.text("contact.law"))
        };
        let elastic = self.elastic(of, law.is_hertzian() || hertzian_area, &why);
        let contact = self.parameters(of, law.table().parameters, &format!("contact.law = \"{}\"", law.word()));
        let friction = self.friction(of);
        let (young, poisson) = elastic?;
        Some(Material {
            name: self.text(&of.key("name")).into(),
            density: self.si(&of.key("grain.density_kg_m3")),
            internal_porosity: self.si(&of.key("grain.internal_porosity")),
            young,
            poisson,
            friction: friction?,
            rolling_friction: self.si(&of.key("contact.rolling_friction")),
            interface_friction: self.interface_friction(&of.key("continuum")),
            contact,
        })
    }

    /// Values, in SI units, of the parameters `asked` that a contact law or failure criterion needs of a material. A parameter that
    /// the material lacks and that has no default is noted as missing, and its value is 0. `why`: the key and word that choose the
    /// law, for the message.
    pub fn parameters(&self, of: &Named, asked: &[Parameter], why: &str) -> Values {
        let mut values = Values::default();
        for (value, parameter) in values.iter_mut().zip(asked) {
            let key = of.key(parameter.key);
            let default = || parameter.default.and_then(|text| text.parse::<f64>().ok()).map(|x| x * unit(parameter.key));
            if let Some(x) = self.number(&key).or_else(default) {
                *value = x;
                continue;
            }
            let (table, name) = key.rsplit_once('.').unwrap_or(("", &key));
            if self.has(table) {
                self.refuse(&key, format!("is missing: {why} needs it ({})", parameter.meaning));
            } else {
                self.refuse(table, format!("is missing: {why} needs {name}"));
            }
        }
        values
    }

    /// Coefficient of sliding friction between grains, -: as written, or the tangent of the friction angle. `None`, with the reason
    /// noted, unless one of the two is given.
    fn friction(&self, of: &Named) -> Option<f64> {
        let angle = self.number(&of.key("contact.friction_angle_rad"));
        let friction = self.number(&of.key("contact.friction"));
        match (angle, friction) {
            (Some(angle), None) => Some(angle.tan()),
            (None, Some(friction)) => Some(friction),
            _ => {
                self.refuse(&of.key("contact"), "must have friction_angle_rad or friction, one of them");
                None
            }
        }
    }

    /// The gradation as points (diameter, m, multiplied by the scale N; mass fraction finer, 0 to 1), increasing. `None`, with the
    /// reason noted, where the material has none or it is not a gradation.
    pub fn gradation(&self, of: &Named) -> Option<Vec<(f64, f64)>> {
        let key = of.key("gradation.points");
        let Some(value) = self.get(&key) else {
            self.refuse(
                &of.key("gradation"),
                "is missing: the sizes of the grains are drawn from a gradation, points = [[d_mm, fraction finer], …]",
            );
            return None;
        };
        let points = pairs(value);
        if let Some(message) = not_a_gradation(&points) {
            self.refuse(&key, message);
            return None;
        }
        let scale = 1e-3 * self.scale();
        Some(points.iter().map(|p| (p.0 * scale, p.1)).collect())
    }
}

/// Fills in `comminution.d50_mm` of every material that has a table `comminution` without this key: with the median of its
/// gradation, by mass, mm. Materials without a valid gradation are left as they are.
pub fn fill_d50(scene: &mut Table) {
    if let Some(Value::Table(material)) = scene.get_mut("material") {
        fill(material);
    }
    if let Some(Value::Table(named)) = scene.get_mut("materials") {
        for (_, material) in named.iter_mut() {
            if let Value::Table(material) = material {
                fill(material);
            }
        }
    }
}

/// Fills in the d50 of one material ([`fill_d50`]).
fn fill(material: &mut Table) {
    let points = material.get("gradation").and_then(|g| g.get("points")).map(pairs);
    let Some(points) = points.filter(|p| not_a_gradation(p).is_none()) else {
        return;
    };
    if let Some(Value::Table(table)) = material.get_mut("comminution")
        && !table.contains_key("d50_mm")
    {
        table.insert("d50_mm".into(), Value::Float(super::estimate::median(&points)));
    }
}

/// The pairs of numbers of a list; entries that are no pairs are left out.
fn pairs(value: &Value) -> Vec<(f64, f64)> {
    let list = value.as_array().into_iter().flatten();
    list.filter_map(|pair| Some((pair.get(0)?.as_float()?, pair.get(1)?.as_float()?))).collect()
}

/// Why the points (diameter, mass fraction finer) are not a gradation; `None` where they are one.
fn not_a_gradation(points: &[(f64, f64)]) -> Option<String> {
    let (first, last) = (points.first(), points.last());
    if points.len() < 2 {
        return Some("must have at least two points".into());
    }
    if let Some(i) = points.windows(2).position(|w| w[1].0 <= w[0].0) {
        return Some(format!("diameters must rise from point to point; point {} does not", i + 2));
    }
    if let Some(i) = points.windows(2).position(|w| w[1].1 < w[0].1) {
        return Some(format!("fractions finer must not fall; that of point {} does", i + 2));
    }
    if first.is_none_or(|p| p.0 <= 0.0) {
        return Some("diameters must be > 0".into());
    }
    if first.is_none_or(|p| p.1 != 0.0) || last.is_none_or(|p| p.1 != 1.0) {
        return Some("fractions finer must begin with 0 and end with 1".into());
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradations_rise_from_zero_to_one() {
        assert_eq!(not_a_gradation(&[(5.0, 0.0), (10.0, 1.0)]), None);
        for bad in [
            vec![(5.0, 0.0)],
            vec![(5.0, 0.0), (5.0, 1.0)],
            vec![(5.0, 0.0), (7.0, 0.6), (8.0, 0.5), (10.0, 1.0)],
            vec![(0.0, 0.0), (10.0, 1.0)],
            vec![(5.0, 0.1), (10.0, 1.0)],
            vec![(5.0, 0.0), (10.0, 0.9)],
        ] {
            assert!(not_a_gradation(&bad).is_some(), "{bad:?}");
        }
    }

    #[test]
    fn the_median_of_a_uniform_gradation_is_its_middle() {
        assert_eq!(crate::scene::estimate::median(&[(5.0, 0.0), (10.0, 1.0)]), 7.5);
        assert_eq!(crate::scene::estimate::median(&[(1.0, 0.0), (2.0, 0.5), (4.0, 1.0)]), 2.0);
    }
}
