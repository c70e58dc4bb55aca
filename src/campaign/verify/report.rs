//! The results of verification as a table, a page and figures: error against resolution and against
//! time.

use super::{Case, Plan, Row};
use laboratory::error::{Error, Result};
use laboratory::run::Backend;
use plot::{Drawn, Graph, Look, Quantity, Tone, significant};
use std::fmt::Write as _;
use std::path::PathBuf;
use table::number;

/// The table of all runs, in the folder that is written.
pub const TABLE: &str = "verification.csv";
const PAGE: &str = "verification.md";
/// Errors below `LEAST` are drawn at `LEAST` if the case has an error above `ROUNDING`; else all
/// errors are rounding errors and are drawn as they are.
const LEAST: f64 = 1e-8;
const ROUNDING: f64 = 1e-6;
/// With more ways than this, the ways come in threes: colours tell the threes apart, and only the
/// first quantity is drawn.
const FEW: usize = 5;

/// Writes the table, the page, and for each case two figures and its own ones into `plan.out`; returns
/// the files.
///
/// # Errors
/// Files that cannot be written.
pub fn write(done: &[(&Case, Vec<Row>)], plan: &Plan) -> Result<Vec<PathBuf>> {
    let out = plan.out;
    std::fs::create_dir_all(out).map_err(Error::write(out))?;
    let mut files = vec![out.join(TABLE), out.join(PAGE)];
    std::fs::write(&files[0], table(done)).map_err(Error::write(&files[0]))?;
    std::fs::write(&files[1], page(done, plan)).map_err(Error::write(&files[1]))?;
    for (case, rows) in done {
        let own = case.graphs.map(|graphs| graphs(rows)).unwrap_or_default();
        for graph in graphs(case, rows).into_iter().chain(own) {
            files.extend(graph.draw(out)?);
        }
    }
    Ok(files)
}

/// A row for each error.
fn table(done: &[(&Case, Vec<Row>)]) -> String {
    let mut text = String::from("case,way,cells,points,steps,seconds,point_steps_per_s,quantity,error\n");
    for (case, rows) in done {
        for row in rows {
            for (quantity, error) in case.quantities.iter().zip(&row.found.errors) {
                let run = format!("{},{},{}", row.cells, row.found.points, row.found.steps);
                let speed = format!("{},{}", number(row.seconds), number(row.rate().round()));
                let _ = writeln!(text, "{},\"{}\",{run},{speed},\"{quantity}\",{}", case.name, case.ways[row.way], number(*error));
            }
        }
    }
    text
}

impl Row {
    /// Point-steps per second.
    fn rate(&self) -> f64 {
        self.found.points as f64 * self.found.steps as f64 / self.seconds.max(1e-9)
    }
}

/// Rows of one way, from coarse to fine.
fn of_way(rows: &[Row], way: usize) -> Vec<&Row> {
    rows.iter().filter(|r| r.way == way).collect()
}

/// Order of convergence of an error, from the last two resolutions; `None` if there is only one, or
/// if the error is no more than rounding.
fn order(rows: &[&Row], quantity: usize) -> Option<f64> {
    let [.., a, b] = rows else { return None };
    let error = |r: &Row| r.found.errors[quantity].abs();
    let order = (error(a) / error(b)).ln() / (f64::from(b.cells) / f64::from(a.cells)).ln();
    (error(a) > 1e-9 && order.is_finite()).then_some(order)
}

fn page(done: &[(&Case, Vec<Row>)], plan: &Plan) -> String {
    let threads = if plan.threads == 1 { "one thread".into() } else { format!("{} threads", plan.threads) };
    let beside = if plan.jobs > 1 { format!(", {} ways at a time", plan.jobs) } else { String::new() };
    let times = match plan.backend {
        Backend::Cpu if plan.jobs > 1 => format!("Times are of {threads}{beside}, by the clock."),
        Backend::Cpu => format!("Times are of {threads}, as measured; those of scenes on one thread are the processor's."),
        backend => format!("Times are those by the clock, with --backend {}{beside}.", backend.name()),
    };
    let mut text = format!(
        "# Closed forms of the continuum\n\nMade by `comminute verify`. Errors are relative; the order is that of the last two resolutions. {times}\n"
    );
    for (case, rows) in done {
        let _ = writeln!(text, "\n## {}\n\n{}.\n\nExact: {}.\n", case.name, case.about, case.exact);
        let _ = writeln!(text, "| {} | | points | seconds | 10⁶ point-steps/s | {} |", case.across, case.quantities.join(" | "));
        let _ = writeln!(text, "|---|---|---|---|---|{}", "---|".repeat(case.quantities.len()));
        for (way, name) in case.ways.iter().enumerate() {
            let rows = of_way(rows, way);
            for row in &rows {
                let errors: Vec<String> = (0..case.quantities.len()).map(|q| shown(row.found.errors[q])).collect();
                let run = format!("{} | {name} | {} | {}", row.cells, row.found.points, significant(row.seconds, 2));
                let _ = writeln!(text, "| {run} | {} | {} |", significant(1e-6 * row.rate(), 2), errors.join(" | "));
            }
            let orders: Vec<String> = (0..case.quantities.len())
                .map(|q| order(&rows, q).map_or(String::new(), |o| format!("{o:.1}").replace('-', "−")))
                .collect();
            if orders.iter().any(|o| !o.is_empty()) {
                let _ = writeln!(text, "| order | {name} | | | | {} |", orders.join(" | "));
            }
        }
    }
    text
}

fn shown(error: f64) -> String {
    if error.is_nan() {
        return String::new();
    }
    let text = if error.abs() < 1e-5 { format!("{error:.0e}") } else { format!("{:.3} %", 100.0 * error) };
    text.replace('-', "−")
}

fn graphs(case: &Case, rows: &[Row]) -> [Graph; 2] {
    let many = case.ways.len() > FEW;
    let quantities = if many { &case.quantities[..1] } else { case.quantities };
    let errors = || rows.iter().flat_map(|r| &r.found.errors[..quantities.len()]).map(|e| e.abs());
    let least = if errors().any(|e| e > ROUNDING) { LEAST } else { f64::MIN_POSITIVE };
    let small = errors().any(|e| e < least);
    let label = if small { "relative error (–), 10^{−8} if smaller" } else { "relative error (–)" };
    let draw = |name: &str, x: Quantity, at: fn(&Row) -> f64| {
        let mut series = Vec::new();
        for (way, label) in case.ways.iter().enumerate() {
            for (q, quantity) in quantities.iter().enumerate() {
                let rows = of_way(rows, way);
                // NaN: the way does not have this quantity
                if rows.iter().any(|r| r.found.errors[q].is_nan()) {
                    continue;
                }
                let points: Vec<(f64, f64)> = rows.iter().map(|r| (at(r), r.found.errors[q].abs().max(least))).collect();
                // colours tell the ways apart, dashes and symbols the quantities
                let (tone, kind) = if many { (way / 3, way % 3) } else { (way, q) };
                let name = if many { (*label).into() } else { format!("{quantity}, {label}") };
                let drawn = |look, label| Drawn { label, name: name.clone(), tone: Tone::Kind(tone), look, points: points.clone() };
                series.push(drawn(Look::Line(kind), Some(name.clone())));
                series.push(drawn(Look::Symbols(kind), None));
            }
        }
        let about = case.about.split(" (").next().unwrap_or_default();
        Graph {
            name: format!("{}_{name}", case.name),
            title: about.split(", ").map(String::from).collect(),
            legend_title: None,
            x,
            y: Quantity::log(label, "error"),
            series,
        }
    };
    [
        draw("resolution", Quantity::log(case.across, "cells"), |r| f64::from(r.cells)),
        draw("time", Quantity::log("time (s)", "seconds"), |r| r.seconds),
    ]
}
