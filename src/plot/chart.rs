//! Graphs as data: the same axes, units, series and numbers that [`draw_run`](crate::draw_run) draws, for whoever draws them in another way.

use super::axis::{Axis, Scale};
use super::colour::{self, Colour, GENERATION_COLOURS};
use super::data::Measured;
use super::error::Result;
use super::group;
use super::plot::{Mark, Plot, Series};
use super::run::{Run, folders_apart};
use super::{Input, plots};
use std::path::PathBuf;

/// An axis of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartAxis {
    /// Quantity and unit, as printed; `_{…}` and `^{…}` enclose sub- and superscripts.
    pub label: String,
    /// The column of the CSV beside the figure.
    pub column: String,
    /// Whether the axis is logarithmic.
    pub log: bool,
    /// Whether values grow downwards.
    pub downwards: bool,
    /// Where the axis of the figure begins and ends; of several runs the widest.
    pub range: [f64; 2],
}

/// How a series of a chart is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum ChartMark {
    /// A line in the order of its points.
    Line,
    /// A line over the area between these values.
    Band {
        /// Lower edge at each point.
        low: Vec<f64>,
        /// Upper edge at each point.
        high: Vec<f64>,
    },
    /// A construction line that is no result of a simulation.
    Guide,
    /// Symbols that are never joined: measured or published numbers.
    Symbols,
}

/// A series of a chart: the points that its figure shows.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartSeries {
    /// Number of the run in the list that was asked for; `None`: of several runs, or of none.
    pub run: Option<usize>,
    /// Legend entry; empty for a series without one.
    pub label: String,
    /// Name in the CSV.
    pub name: String,
    /// Red, green, blue, as `#0072b2`.
    pub colour: String,
    /// Drawn and skipped lengths in turn, in widths of a line; empty for a solid line.
    pub dash: Vec<f64>,
    /// How it is drawn.
    pub mark: ChartMark,
    /// Abscissae.
    pub x: Vec<f64>,
    /// Ordinates.
    pub y: Vec<f64>,
}

/// A graph as data.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Name of the figure's files, without extension.
    pub name: String,
    /// Parts of the title: scene, sizes, counts; empty for several runs.
    pub title: Vec<String>,
    /// What the legend's entries are, with its unit, where they are values.
    pub legend_title: Option<String>,
    /// The horizontal axis.
    pub x: ChartAxis,
    /// The vertical axis.
    pub y: ChartAxis,
    /// Whether one unit is equally long on both axes.
    pub equal: bool,
    /// What is drawn, in this order.
    pub series: Vec<ChartSeries>,
}

/// What the figures of runs have in common: names and colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Palette {
    /// Name of each run with its seed, as legends have it.
    pub names: Vec<String>,
    /// Colour of each run.
    pub runs: Vec<String>,
    /// Colours of the generations of grains; the last stands for all later ones.
    pub generations: Vec<String>,
    /// Colours of an ordered quantity from its least to its largest value, at equal distances.
    pub sequence: Vec<String>,
}

/// Names and colours for the runs in the folders `dirs`.
///
/// # Errors
/// Records that cannot be read.
pub fn palette(dirs: &[PathBuf]) -> Result<Palette> {
    let runs = dirs.iter().map(|dir| Run::read(dir)).collect::<Result<Vec<Run>>>()?;
    let mut names: Vec<String> = runs.iter().map(Run::label).collect();
    let twins = |name: &String| names.iter().filter(|other| *other == name).count() > 1;
    let twin: Vec<usize> = (0..names.len()).filter(|&i| twins(&names[i])).collect();
    let folders = folders_apart(&twin.iter().map(|&i| dirs[i].clone()).collect::<Vec<_>>());
    for (i, folder) in twin.into_iter().zip(folders) {
        names[i] += &format!(" [{folder}]");
    }
    const TONES: usize = 24;
    Ok(Palette {
        names,
        runs: (0..dirs.len()).map(|i| hex(colour::kind(i))).collect(),
        generations: (0..GENERATION_COLOURS).map(|i| hex(colour::generation(i))).collect(),
        sequence: (0..=TONES).map(|i| hex(colour::sequence(i as f64 / TONES as f64))).collect(),
    })
}

/// Every graph that the records of the runs in `dirs` allow. The graphs of one run are those of [`draw_run`](crate::draw_run). Of several runs each
/// keeps its own series, in a colour for each run, and where seeds of one scene are among them, their median and band are series as well.
///
/// # Errors
/// Records that cannot be read.
pub fn charts(dirs: &[PathBuf]) -> Result<Vec<Chart>> {
    let runs = dirs.iter().map(|dir| Run::read(dir)).collect::<Result<Vec<Run>>>()?;
    let of = |groups| plots(&Input { groups, data: Vec::<Measured>::new() });
    let mut found: Vec<Chart> = Vec::new();
    let several = runs.len() > 1;
    for (i, run) in runs.iter().enumerate() {
        for plot in of(group::group(vec![run.clone()]))? {
            let at = chart(&mut found, &plot, several);
            let mut labels: Vec<String> = Vec::new();
            for series in &plot.series {
                let mut series = shown(series, &plot, Some(i));
                if several && series.mark == ChartMark::Line {
                    let nth = labels.iter().position(|l| *l == series.name).unwrap_or(labels.len());
                    if nth == labels.len() {
                        labels.push(series.name.clone());
                    }
                    series.colour = hex(colour::kind(i));
                    series.dash = widths(colour::dash(nth));
                }
                found[at].series.push(series);
            }
        }
    }
    let groups = group::group(runs);
    if groups.iter().any(|group| group.runs.len() > 1) {
        for plot in of(groups)? {
            let at = chart(&mut found, &plot, several);
            let mut kinds: Vec<Colour> = Vec::new();
            for band in plot.series.iter().filter(|series| matches!(series.mark, Mark::Band { .. })) {
                let nth = kinds.iter().position(|colour| *colour == band.colour).unwrap_or(kinds.len());
                if nth == kinds.len() {
                    kinds.push(band.colour);
                }
                // in other colours than the runs have
                found[at].series.push(ChartSeries { colour: hex(colour::kind(dirs.len() + nth)), ..shown(band, &plot, None) });
            }
        }
    }
    found.retain(|chart| chart.series.iter().any(|series| !series.x.is_empty()));
    Ok(found)
}

/// The chart of the same figure as `plot`, made if there is none yet, with axes that reach as far as those of `plot`.
fn chart(found: &mut Vec<Chart>, plot: &Plot, several: bool) -> usize {
    let at = found.iter().position(|chart| chart.name == plot.name).unwrap_or_else(|| {
        found.push(Chart {
            name: plot.name.clone(),
            title: if several { Vec::new() } else { plot.title.clone() },
            legend_title: plot.legend_title.clone(),
            x: axis(&plot.x),
            y: axis(&plot.y),
            equal: plot.equal,
            series: Vec::new(),
        });
        found.len() - 1
    });
    if let Some((x, y)) = plot.ranges() {
        let chart = &mut found[at];
        for (axis, range) in [(&mut chart.x, x), (&mut chart.y, y)] {
            axis.range = [axis.range[0].min(range.lo), axis.range[1].max(range.hi)];
        }
    }
    at
}

fn axis(axis: &Axis) -> ChartAxis {
    ChartAxis {
        label: axis.label.clone(),
        column: axis.column.clone(),
        log: axis.scale == Scale::Log,
        downwards: axis.downwards,
        range: [f64::INFINITY, f64::NEG_INFINITY],
    }
}

/// A series with the points that both axes show.
fn shown(series: &Series, plot: &Plot, run: Option<usize>) -> ChartSeries {
    let kept: Vec<usize> =
        (0..series.x.len().min(series.y.len())).filter(|i| plot.x.shows(series.x[*i]) && plot.y.shows(series.y[*i])).collect();
    let pick = |values: &[f64]| kept.iter().map(|i| values.get(*i).copied().unwrap_or(f64::NAN)).collect::<Vec<f64>>();
    let (mark, dash) = match &series.mark {
        Mark::Line(dash) => (ChartMark::Line, *dash),
        Mark::Band { low, high, dash } => (ChartMark::Band { low: pick(low), high: pick(high) }, *dash),
        Mark::Guide(dash) => (ChartMark::Guide, *dash),
        Mark::Symbols(_) => (ChartMark::Symbols, &[][..]),
    };
    ChartSeries {
        run,
        label: series.label.clone().unwrap_or_default(),
        name: series.name.clone(),
        colour: hex(series.colour),
        dash: widths(dash),
        mark,
        x: pick(&series.x),
        y: pick(&series.y),
    }
}

/// A dash pattern in widths of a curve.
fn widths(dash: &[f64]) -> Vec<f64> {
    dash.iter().map(|length| length / super::plot::CURVE).collect()
}

fn hex(Colour(red, green, blue): Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

#[cfg(test)]
mod tests {
    use super::super::table::Table;
    use super::*;

    fn run(seed: u64, porosity: f64) -> tempfile::TempDir {
        let dir = tempfile::tempdir().expect("folder");
        let summary = format!("{{\"scene\":\"H-C-2\",\"seed\":{seed}}}");
        std::fs::write(dir.path().join("summary.json"), summary).expect("summary");
        let rows = format!("step,stage,sigma_v_kPa,porosity\n1,load,10,0.42\n2,load,1000,{porosity}\n3,unload,100,0.37\n");
        std::fs::write(dir.path().join("history.csv"), rows).expect("history");
        dir
    }

    #[test]
    fn a_chart_has_the_numbers_of_the_csv_beside_the_figure() {
        let dir = run(1, 1.0 / 3.0);
        let charts = charts(&[dir.path().to_path_buf()]).expect("charts");
        super::super::draw_run(dir.path()).expect("drawn");
        assert_eq!(charts.len(), 1);
        let chart = &charts[0];
        let csv = Table::read(&dir.path().join(format!("figures/{}.csv", chart.name))).expect("csv");
        let drawn = |axis: &ChartAxis| csv.numbers(&axis.column).expect("column");
        let all = |of: fn(&ChartSeries) -> &Vec<f64>| chart.series.iter().flat_map(of).copied().collect::<Vec<f64>>();
        assert_eq!(all(|s| &s.x), drawn(&chart.x));
        assert_eq!(all(|s| &s.y), drawn(&chart.y));
        assert!(chart.x.log && !chart.y.log && chart.series[0].run == Some(0));
    }

    #[test]
    fn each_run_keeps_its_series_and_seeds_have_a_band() {
        let (a, b) = (run(1, 0.35), run(2, 0.33));
        let dirs = [a.path().to_path_buf(), b.path().to_path_buf()];
        let charts = charts(&dirs).expect("charts");
        let series = &charts[0].series;
        let runs: Vec<Option<usize>> = series.iter().map(|s| s.run).collect();
        assert_eq!(runs, [Some(0), Some(1), None, None]);
        assert!(series[0].colour != series[1].colour);
        assert!(matches!(&series[2].mark, ChartMark::Band { low, high } if low.last() < high.last()));
        let names = palette(&dirs).expect("names").names;
        assert_eq!(names, ["H-C-2, seed 1", "H-C-2, seed 2"]);
        let same = palette(&[dirs[0].clone(), dirs[0].clone()]).expect("names").names;
        assert!(same[0].starts_with("H-C-2, seed 1 ["), "{same:?}");
    }
}
