//! Graphs that a plan describes: columns of the runs' tables against each other, numbers of the plan, laws, and published points.

use super::plan::Plan;
use super::reading::{Expression, Rows};
use super::results::Done;
use laboratory::error::Result;
use plot::{Drawn, Graph, Look, Quantity, Tone};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Intervals of the line of a law.
const STEPS: u32 = 100;

/// A graph.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chart {
    /// Horizontal axis.
    pub x: Scale,
    /// Vertical axis.
    pub y: Scale,
    /// Lines from tables.
    #[serde(default)]
    pub curves: Vec<Curve>,
    /// Symbols from series of the plan's numbers.
    #[serde(default)]
    pub series: Vec<Named>,
    /// Lines of laws.
    #[serde(default)]
    pub laws: Vec<Law>,
    /// Published points.
    #[serde(default)]
    pub published: Vec<Published>,
}

/// An axis.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scale {
    /// Quantity and unit, as printed.
    pub label: String,
    /// Name of the column in the CSV of the figure.
    pub column: String,
    /// Whether it is logarithmic.
    #[serde(default)]
    pub log: bool,
    /// Values that a linear axis must contain.
    #[serde(default)]
    pub include: Vec<f64>,
}

/// A line through the rows of a table.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Curve {
    /// Entry in the legend.
    pub label: String,
    /// Name of a run of the plan; each of its seeds is a line.
    pub run: String,
    /// The rows.
    #[serde(default)]
    pub from: Rows,
    /// Abscissa, an expression of columns.
    pub x: Expression,
    /// Ordinate, an expression of columns.
    pub y: Expression,
    /// Which colour; that of its place among the curves if it is not given.
    pub colour: Option<usize>,
}

/// A series of the plan's numbers.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Named {
    /// Entry in the legend.
    pub label: String,
    /// Name of the series.
    pub name: String,
}

/// A law y(x).
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Law {
    /// Entry in the legend.
    pub label: String,
    /// Expression of x.
    pub value: Expression,
    /// First and last x.
    pub between: [f64; 2],
}

/// Points that were published.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Entry in the legend.
    pub label: String,
    /// Places x, y.
    pub points: Vec<[f64; 2]>,
}

impl Scale {
    fn quantity(&self) -> Quantity {
        if self.log { Quantity::log(&self.label, &self.column) } else { Quantity::linear(&self.label, &self.column, &self.include) }
    }
}

impl Chart {
    /// What is wrong with it: each name, and why.
    pub fn faults(&self, plan: &Plan) -> Vec<(String, String)> {
        let runs = self.curves.iter().filter(|c| plan.run(&c.run).is_none());
        let runs = runs.map(|c| (c.run.clone(), "is no run of the plan".into()));
        let series = self.series.iter().filter(|s| !plan.has_series(&s.name));
        let series = series.map(|s| (s.name.clone(), "is no series of the plan's numbers".into()));
        let laws = self.laws.iter().filter_map(|l| l.value.along("x", std::iter::empty()).err().map(|why| (l.label.clone(), why)));
        runs.chain(series).chain(laws).collect()
    }

    /// Draws `dir/NAME.{svg,png,csv}`; nothing if no run of it is done.
    ///
    /// # Errors
    /// Tables that cannot be read and files that cannot be written.
    pub fn draw(&self, name: &str, plan: &Plan, done: &[Done], dir: &Path) -> Result<Vec<PathBuf>> {
        let mut series = Vec::new();
        for (k, curve) in self.curves.iter().enumerate() {
            let folders = done.iter().find(|d| d.id == curve.run).map(Done::folders).unwrap_or_default();
            let colour = curve.colour.unwrap_or(k);
            for (nth, folder) in folders.iter().enumerate() {
                let rows = curve.from.read(folder, [&curve.x, &curve.y])?;
                series.push(Drawn {
                    label: (nth == 0).then(|| curve.label.clone()),
                    name: format!("{} {}", curve.label, nth + 1),
                    tone: Tone::Kind(colour),
                    look: Look::Line(colour),
                    points: rows.into_iter().map(|(_, [x, y])| (x, y)).collect(),
                });
            }
        }
        for (k, Named { label, name }) in self.series.iter().enumerate() {
            let mut points = Vec::new();
            for number in plan.numbers.iter().filter(|n| n.series.as_ref() == Some(name)) {
                points.extend(number.at.zip(number.found(done)?.map(|s| s.mean)));
            }
            let (label, name, tone, look) =
                (Some(label.clone()), name.clone(), Tone::Kind(self.curves.len() + k), Look::Symbols(k));
            series.push(Drawn { label, name, tone, look, points });
        }
        if series.iter().all(|s| s.points.is_empty()) {
            return Ok(Vec::new());
        }
        for law in &self.laws {
            let [from, to] = law.between;
            let places = (0..=STEPS).map(|k| from + (to - from) * f64::from(k) / f64::from(STEPS));
            let points = law.value.along("x", places).unwrap_or_default();
            series.push(Drawn {
                label: Some(law.label.clone()),
                name: law.label.clone(),
                tone: Tone::Ink,
                look: Look::Line(0),
                points,
            });
        }
        for (k, published) in self.published.iter().enumerate() {
            series.push(Drawn {
                label: Some(published.label.clone()),
                name: published.label.clone(),
                tone: Tone::Ink,
                look: Look::Symbols(self.series.len() + k),
                points: published.points.iter().map(|&[x, y]| (x, y)).collect(),
            });
        }
        let (x, y) = (self.x.quantity(), self.y.quantity());
        let graph = Graph { name: name.into(), title: Vec::new(), legend_title: None, x, y, series };
        Ok(graph.draw(dir)?)
    }
}
