//! Graphs of points that a caller gives (calibrations, verification, reproductions): symbols, lines
//! and bands. Looks, axes, legend and the files written are those of every other figure.

use super::axis::Axis;
use super::colour::{self, GREY, INK};
use super::error::Result;
use super::plot::{Mark, Plot, Series, Shape};
use std::path::{Path, PathBuf};

/// One axis.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// Quantity and unit, as printed.
    pub label: String,
    /// Quantity and unit, as the column of the CSV.
    pub column: String,
    /// Whether the axis is logarithmic.
    pub log: bool,
    /// Values that the axis must contain.
    pub include: Vec<f64>,
}

impl Quantity {
    /// A linear axis that contains the values `include`.
    pub fn linear(label: &str, column: &str, include: &[f64]) -> Quantity {
        Quantity { label: label.into(), column: column.into(), log: false, include: include.to_vec() }
    }

    /// A logarithmic axis.
    pub fn log(label: &str, column: &str) -> Quantity {
        Quantity { label: label.into(), column: column.into(), log: true, include: Vec::new() }
    }

    fn axis(&self) -> Axis {
        let axis = if self.log { Axis::log(&self.label, &self.column) } else { Axis::linear(&self.label, &self.column) };
        axis.including(&self.include)
    }
}

/// Colour of a series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tone {
    /// The n-th colour of the palette for kinds.
    Kind(usize),
    /// Share of an ordered quantity, 0 dark to 1 light.
    Ordered(f64),
    /// The colour of text.
    Ink,
    /// Grey.
    Grey,
}

/// How a series is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Look {
    /// The n-th symbol.
    Symbols(usize),
    /// A line with the n-th dash.
    Line(usize),
    /// A line with a band around it.
    Band {
        /// Lower limits, one for each point.
        low: Vec<f64>,
        /// Upper limits.
        high: Vec<f64>,
    },
    /// A thin construction line.
    Guide,
}

/// A series of points.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Legend entry, if it has one.
    pub label: Option<String>,
    /// Name in the CSV.
    pub name: String,
    /// Colour.
    pub tone: Tone,
    /// How the series is drawn.
    pub look: Look,
    /// Points (x, y), in the units of the axes.
    pub points: Vec<(f64, f64)>,
}

/// A graph that is written as SVG, PNG and CSV.
#[derive(Clone, Debug)]
pub struct Graph {
    /// File name without extension.
    pub name: String,
    /// Parts of the title above the frame.
    pub title: Vec<String>,
    /// Heading of the legend, if it has one.
    pub legend_title: Option<String>,
    /// Horizontal axis.
    pub x: Quantity,
    /// Vertical axis.
    pub y: Quantity,
    /// The series, drawn in this order.
    pub series: Vec<Drawn>,
}

impl Graph {
    /// Draws `dir/name.{svg,png,csv}` and returns the files written.
    pub fn draw(&self, dir: &Path) -> Result<Vec<PathBuf>> {
        let plot = Plot {
            name: self.name.clone(),
            title: self.title.clone(),
            legend_title: self.legend_title.clone(),
            x: self.x.axis(),
            y: self.y.axis(),
            series: self.series.iter().map(series).collect(),
            equal: false,
        };
        plot.draw(dir)
    }
}

fn series(drawn: &Drawn) -> Series {
    let (x, y) = drawn.points.iter().copied().unzip();
    let mark = match &drawn.look {
        Look::Symbols(n) => Mark::Symbols(Shape::nth(*n)),
        Look::Line(n) => Mark::Line(colour::dash(*n)),
        Look::Band { low, high } => Mark::Band { low: low.clone(), high: high.clone(), dash: colour::dash(0) },
        Look::Guide => Mark::Guide(&[]),
    };
    let colour = match drawn.tone {
        Tone::Kind(n) => colour::kind(n),
        Tone::Ordered(t) => colour::sequence(0.92 * t),
        Tone::Ink => INK,
        Tone::Grey => GREY,
    };
    Series { label: drawn.label.clone(), name: drawn.name.clone(), colour, mark, x, y }
}
