//! Numbers and curves that a plan reads from the tables of its runs: an expression of columns, in the rows that are chosen.

use exmex::{Express, FlatEx, FloatOpsFactory, MatchLiteral, literal_matcher_from_pattern};
use laboratory::error::{Error, Result};
use plot::Table;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

literal_matcher_from_pattern!(Numerals, r"^[0-9]+(\.[0-9]+)?([eE][-+]?[0-9]+)?");

/// An expression of the columns of a table, such as `1 - (vx_m_s/0.02)^2`, with the operators and functions of `exmex`.
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
    /// Its value for each of the values of `name`.
    ///
    /// # Errors
    /// An expression of anything but this name, in words.
    pub fn along(&self, name: &str, values: impl Iterator<Item = f64>) -> std::result::Result<Vec<(f64, f64)>, String> {
        if let Some(other) = self.0.var_names().iter().find(|n| *n != name) {
            return Err(format!("must be an expression of {name}; `{other}` is not known"));
        }
        let at = |x: f64| self.0.eval(&vec![x; self.0.var_names().len()]).map_err(|e| e.msg().to_string());
        values.map(|x| Ok((x, at(x)?))).collect()
    }
}

/// Rows of a table in a run's folder.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Rows {
    /// The file.
    pub table: String,
    /// Columns with the number that a row must have there: `{ block = 1 }`.
    pub rows: BTreeMap<String, f64>,
    /// First and last time of the rows, s.
    pub during_s: Option<[f64; 2]>,
}

impl Default for Rows {
    fn default() -> Rows {
        Rows { table: "history.csv".into(), rows: BTreeMap::new(), during_s: None }
    }
}

/// The one number of many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Take {
    /// The last one.
    #[default]
    Last,
    /// The first one.
    First,
    /// Their mean.
    Mean,
    /// The largest.
    Largest,
    /// The least.
    Least,
    /// Their sum.
    Sum,
    /// Change from the first to the last over the time between them, 1/s.
    Rate,
    /// Time of the first row with a value above zero, s.
    TimeAboveZero,
}

impl Rows {
    /// Time, s (0 in a table without times), and the values of the expressions of each row.
    ///
    /// # Errors
    /// A table that cannot be read, a column that it lacks, a cell that is no number.
    pub fn read<const N: usize>(&self, folder: &Path, of: [&Expression; N]) -> Result<Vec<(f64, [f64; N])>> {
        let path = folder.join(&self.table);
        let table = Table::read(&path)?;
        let columns = |e: &Expression| e.0.var_names().iter().map(|name| table.numbers(name)).collect::<plot::Result<Vec<_>>>();
        let columns = of.map(columns).into_iter().collect::<plot::Result<Vec<_>>>()?;
        let timed = table.has("time_s") || self.during_s.is_some();
        let times = if timed { table.numbers("time_s")? } else { vec![0.0; table.len()] };
        let mut chosen = vec![true; table.len()];
        for (name, wanted) in &self.rows {
            chosen.iter_mut().zip(table.numbers(name)?).for_each(|(chosen, x)| *chosen &= x == *wanted);
        }
        if let Some([from, to]) = self.during_s {
            chosen.iter_mut().zip(&times).for_each(|(chosen, t)| *chosen &= (from..=to).contains(t));
        }
        let mut out = Vec::new();
        for row in (0..table.len()).filter(|&row| chosen[row]) {
            let mut values = [0.0; N];
            for ((value, expression), columns) in values.iter_mut().zip(of).zip(&columns) {
                let cells: Vec<f64> = columns.iter().map(|column| column[row]).collect();
                let failed = |e: exmex::ExError| Error::input(path.display(), "", None, e.msg().to_string());
                *value = expression.0.eval(&cells).map_err(failed)?;
            }
            out.push((times[row], values));
        }
        Ok(out)
    }
}

impl Take {
    /// The number; `None` without rows, or where there is no such row.
    pub fn of(self, rows: &[(f64, [f64; 1])]) -> Option<f64> {
        let (&(start, [first]), &(end, [last])) = (rows.first()?, rows.last()?);
        let values = || rows.iter().map(|(_, [value])| *value);
        Some(match self {
            Take::Last => last,
            Take::First => first,
            Take::Mean => values().sum::<f64>() / rows.len() as f64,
            Take::Largest => values().fold(f64::NEG_INFINITY, f64::max),
            Take::Least => values().fold(f64::INFINITY, f64::min),
            Take::Sum => values().sum(),
            Take::Rate if end > start => (last - first) / (end - start),
            Take::Rate => return None,
            Take::TimeAboveZero => rows.iter().find(|(_, [value])| *value > 0.0)?.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expression(text: &str) -> Expression {
        text.to_string().try_into().expect("an expression")
    }

    #[test]
    fn values_are_expressions_of_columns_in_the_rows_that_are_chosen() {
        let dir = tempfile::tempdir().expect("folder");
        let text = "time_s,block,v_m_s\n0,0,2\n0,1,0\n0.5,0,1\n0.5,1,1.5\n1,0,0.5\n1,1,1.9\n";
        std::fs::write(dir.path().join("blocks.csv"), text).expect("written");
        let second: Rows = toml::from_str("table = \"blocks.csv\"\nrows = { block = 1 }").expect("rows");
        let late = Rows { during_s: Some([0.5, 1.0]), ..second.clone() };
        let kept = late.read(dir.path(), [&expression("1 - (v_m_s/2e0)^2"), &expression("time_s")]).expect("rows");
        assert_eq!(kept.len(), 2);
        assert!((kept[1].1[0] - (1.0 - 0.95_f64.powi(2))).abs() < 1e-12 && kept[1].1[1] == 1.0, "{kept:?}");
        let speed = second.read(dir.path(), [&expression("v_m_s - 1.0")]).expect("rows");
        let of = |take: Take| take.of(&speed).expect("a number");
        assert_eq!((of(Take::First), of(Take::Largest), of(Take::TimeAboveZero)), (-1.0, 1.9 - 1.0, 0.5));
        assert!((of(Take::Rate) - 1.9).abs() < 1e-12 && (of(Take::Sum) - 0.4).abs() < 1e-12 && of(Take::Least) == -1.0);
        assert!((of(Take::Mean) - 0.4 / 3.0).abs() < 1e-12 && of(Take::Last) == of(Take::Largest));
        assert_eq!(Take::Last.of(&[]), None);
        let lacks = second.read(dir.path(), [&expression("w")]).expect_err("no such column");
        assert!(lacks.to_string().contains("no column `w`"), "{lacks}");
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
}
