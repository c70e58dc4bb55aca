//! Arithmetic that a user writes, such as `1 - (vx_m_s/0.02)^2`.

use exmex::{Express, FlatEx, FloatOpsFactory, MatchLiteral, literal_matcher_from_pattern};
use serde::Deserialize;

literal_matcher_from_pattern!(Numerals, r"^[0-9]+(\.[0-9]+)?([eE][-+]?[0-9]+)?");

/// An expression of named numbers, with the operators, functions and constants (e, PI, TAU) of `exmex`; names that are more than letters, digits
/// and _, or are those of constants, stand in `{…}`.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "String")]
pub struct Expression(FlatEx<f64, FloatOpsFactory<f64>, Numerals>);

impl TryFrom<String> for Expression {
    type Error = String;

    fn try_from(text: String) -> std::result::Result<Expression, String> {
        let parsed = FlatEx::parse(&text).map_err(|e| format!("`{text}` is no expression: {}", e.msg()))?;
        Ok(Expression(parsed))
    }
}

impl Expression {
    /// The names in it, in the order in which [`Expression::value`] takes their numbers.
    pub fn names(&self) -> &[String] {
        self.0.var_names()
    }

    /// Its value for these numbers of its names.
    ///
    /// # Errors
    /// Another number of numbers than of names, in words.
    pub fn value(&self, numbers: &[f64]) -> std::result::Result<f64, String> {
        self.0.eval(numbers).map_err(|e| e.msg().to_string())
    }

    /// Its value for each of the values of `name`.
    ///
    /// # Errors
    /// An expression of anything but this name, in words.
    pub fn along(&self, name: &str, values: impl Iterator<Item = f64>) -> std::result::Result<Vec<(f64, f64)>, String> {
        if let Some(other) = self.names().iter().find(|n| *n != name) {
            return Err(format!("must be an expression of {name}; `{other}` is not known"));
        }
        values.map(|x| Ok((x, self.value(&vec![x; self.names().len()])?))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expression(text: &str) -> Expression {
        text.to_string().try_into().expect("an expression")
    }

    #[test]
    fn what_is_no_expression_is_refused_where_it_is_read() {
        #[derive(Debug, Deserialize)]
        struct Holder {
            #[allow(dead_code)]
            value: Expression,
        }
        let error = toml::from_str::<Holder>("value = \"1 +\"").expect_err("no expression").to_string();
        assert!(error.contains("`1 +` is no expression"), "{error}");
        let line = expression("2*x");
        assert_eq!(line.along("x", [1.0, 2.0].into_iter()), Ok(vec![(1.0, 2.0), (2.0, 4.0)]));
        assert!(line.along("y", [1.0].into_iter()).expect_err("other name").contains("`x` is not known"));
    }

    #[test]
    fn any_name_may_stand_in_braces() {
        let of = expression("{Sig_v [MPa]} * 1000 + {e}");
        assert_eq!(of.names(), ["Sig_v [MPa]", "e"]);
        assert_eq!(of.value(&[0.5, 1.0]), Ok(501.0));
    }
}
