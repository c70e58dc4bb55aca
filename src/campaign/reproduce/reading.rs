//! Numbers and curves that a plan reads from the tables of its runs: an expression of columns, in the rows that are chosen.

use laboratory::error::{Error, Result};
pub use laboratory::expression::Expression;
use plot::Table;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

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
        let columns = |e: &Expression| e.names().iter().map(|name| table.numbers(name)).collect::<plot::Result<Vec<_>>>();
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
                *value = expression.value(&cells).map_err(|e| Error::input(path.display(), "", None, e))?;
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
}
