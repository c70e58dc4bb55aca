//! Single grains between platens: force against displacement beside Hertz' closed form, peak force against diameter beside the limit
//! force of eqs (16), (17) (Ciantia et al. 2015, Figs 7, 8), and survival against force.

use super::Input;
use super::axis::{Axis, count, significant};
use super::colour::{self, Colour, GREY, INK};
use super::error::Result;
use super::plot::{Mark, Plot, Series, Shape};
use super::run::{Run, read_summary};
use super::table::Table;
use ::table::quantile;
use serde_json::Value;

/// Both axes are logarithmic where the largest final force of the curves is more than this many
/// times the smallest.
const WIDE: f64 = 30.0;
/// Displacements below this share of a curve's last displacement are not drawn.
const SHORT: f64 = 1e-3;
/// Forces below this share of the largest force are not drawn in the figure of survival.
const TAIL: f64 = 1e-4;
/// Up to this number of tests per diameter (on average) each test is a symbol; with more tests,
/// symbols show their median and spread.
const FEW: usize = 10;
/// From this number of curves on, colours follow a sequence, and the curves of force against
/// displacement share one legend entry.
const CURVES: usize = 8;

/// A run with its tests.
struct Batch<'a> {
    run: &'a Run,
    summary: Value,
    tests: Table,
}

/// The figures of grain crushing tests: all figures for one run, the peak forces for several.
pub fn plots(input: &Input) -> Result<Vec<Plot>> {
    let mut batches = Vec::new();
    for run in input.groups.iter().flat_map(|g| &g.runs) {
        if let Some(tests) = Table::read_if_there(&run.dir.join("platen.csv"))? {
            batches.push(Batch { run, summary: read_summary(&run.dir.join("summary.json"))?, tests });
        }
    }
    let mut out = Vec::new();
    if let [batch] = &batches[..] {
        out.extend(force_displacement(batch)?);
        out.extend(survival(batch)?);
    }
    out.extend(peak_force(&batches)?);
    Ok(out)
}

fn of_size(d_mm: f64) -> String {
    format!("d = {} mm", significant(d_mm, 3))
}

impl Batch<'_> {
    fn title(&self) -> Vec<String> {
        let s = &self.summary;
        let mut out = vec![self.run.label()];
        if let (Some(grain), Some(platen)) = (s["grain"].as_str(), s["platen"].as_str()) {
            let platens = if platen == "rigid" { "rigid platens".into() } else { format!("{platen} platens") };
            out.push(format!("{grain}, {platens}"));
        }
        out.extend(s["E_star_GPa"].as_f64().map(|e| format!("E* = {} GPa", significant(e, 3))));
        if let (Some(tests), Some(broken)) = (s["tests"].as_u64(), s["crush_events"].as_u64()) {
            out.push(format!("{} grains, {} broke", count(tests), count(broken)));
        }
        out
    }

    /// The equation of the limit force.
    fn equation(&self) -> &'static str {
        if self.summary["area"] == "hertz" { "eq. 17" } else { "eq. 16" }
    }
}

fn force_axis(log: bool, label: &str) -> Axis {
    let label = format!("{label} (N)");
    if log { Axis::log(&label, "force_N") } else { Axis::linear(&label, "force_N").including(&[0.0]) }
}

fn force_displacement(batch: &Batch) -> Result<Option<Plot>> {
    let Some(table) = Table::read_if_there(&batch.run.dir.join("force_displacement.csv"))? else {
        return Ok(None);
    };
    let column = |name: &str| table.numbers(name);
    let (grain, d, x) = (column("grain")?, column("diameter_mm")?, column("displacement_mm")?);
    let (top, hertz) = (column("force_top_N")?, column("force_hertz_N")?);
    let (numbers, censored) = (batch.tests.numbers("grain")?, batch.tests.numbers("censored")?);
    let mut starts: Vec<usize> = (0..grain.len()).filter(|&i| i == 0 || grain[i] != grain[i - 1]).collect();
    starts.push(grain.len());
    let curves: Vec<std::ops::Range<usize>> = starts.windows(2).map(|w| w[0]..w[1]).collect();
    let peaks: Vec<f64> = curves.iter().map(|c| top[c.end - 1]).collect();
    let span = peaks.iter().fold(0.0f64, |a, b| a.max(*b)) / peaks.iter().fold(f64::INFINITY, |a, b| a.min(*b));
    let log = span > WIDE;
    let mut series = Vec::new();
    let mut closed = Vec::new();
    let mut ends = (Vec::new(), Vec::new());
    for (i, c) in curves.iter().enumerate() {
        let last = c.end - 1;
        let from = SHORT * x[last];
        let shown: Vec<usize> = c.clone().filter(|&k| x[k] >= from).collect();
        let points = |y: &[f64]| shown.iter().map(|&k| (x[k], y[k])).collect();
        let name = format!("grain {}, {}", grain[last], of_size(d[last]));
        let (tone, dash, label) = if curves.len() < CURVES {
            (colour::kind(i), colour::dash(i), Some(of_size(d[last])))
        } else {
            (colour::sequence(i as f64 / (curves.len() - 1) as f64), colour::dash(0), (i == 0).then(|| "tests".into()))
        };
        series.push(Series { label, ..Series::line(&name, tone, dash, points(&top)) });
        let label = (i == 0).then(|| "Hertz, closed form".into());
        closed.push(Series { label, mark: Mark::Guide(&[]), ..Series::line(&format!("{name}, Hertz"), INK, &[], points(&hertz)) });
        if numbers.iter().position(|n| *n == grain[last]).is_some_and(|k| censored[k] == 0.0) {
            ends.0.push(x[last]);
            ends.1.push(top[last]);
        }
    }
    // last, because these thin lines lie on top of the tests' lines
    series.extend(closed);
    series.push(symbols("breakage", INK, Shape::Diamond, ends));
    let label = "displacement of the platen (mm)";
    Ok(Some(Plot {
        name: "force_displacement".into(),
        title: batch.title(),
        legend_title: None,
        x: if log { Axis::log(label, "displacement_mm") } else { Axis::linear(label, "displacement_mm").including(&[0.0]) },
        y: force_axis(log, "force"),
        series,
        equal: false,
    }))
}

fn symbols(name: &str, colour: Colour, shape: Shape, (x, y): (Vec<f64>, Vec<f64>)) -> Series {
    Series { label: Some(name.into()), name: name.into(), colour, mark: Mark::Symbols(shape), x, y }
}

fn peak_force(batches: &[Batch]) -> Result<Option<Plot>> {
    let mut series = Vec::new();
    for (i, batch) in batches.iter().enumerate() {
        let tone = colour::kind(i);
        let prefix = if batches.len() == 1 { String::new() } else { format!("{}: ", batch.run.label()) };
        if let Some(law) = Table::read_if_there(&batch.run.dir.join("limit_force.csv"))? {
            let name = format!("{prefix}{}, median and 5–95 %", batch.equation());
            let band = Mark::Band {
                low: law.numbers("weakest_5_percent_N")?,
                high: law.numbers("strongest_5_percent_N")?,
                dash: colour::dash(i),
            };
            let x = law.numbers("diameter_mm")?;
            let line = Series::line(&name, tone, &[], Vec::new());
            series.push(Series { mark: band, x: x.clone(), y: law.numbers("median_N")?, ..line });
            if batches.len() == 1 {
                let name = format!("{}, no spread", batch.equation());
                let line = Series::line(&name, INK, &[], Vec::new());
                series.push(Series { mark: Mark::Guide(&[]), x, y: law.numbers("at_mean_strength_N")?, ..line });
            }
        }
        series.extend(measured(batch, &prefix, if batches.len() == 1 { INK } else { tone })?);
    }
    let lowest = series.iter().flat_map(|s| &s.y).copied().filter(|f| *f > 0.0).fold(f64::INFINITY, f64::min);
    let title = match batches {
        [] => return Ok(None),
        [one] => one.title(),
        _ => Vec::new(),
    };
    Ok(Some(Plot {
        name: "peak_force".into(),
        title,
        legend_title: None,
        x: Axis::log("diameter d (mm)", "diameter_mm"),
        y: force_axis(true, "peak force").including(&[0.75 * lowest]),
        series,
        equal: false,
    }))
}

/// Symbols of each test, or of the median and the 5 and 95 % quantiles of the tests of each
/// diameter. For the quantiles a grain that did not break is stronger than all that broke; a
/// quantile that would be such a grain is left out.
fn measured(batch: &Batch, prefix: &str, tone: Colour) -> Result<Vec<Series>> {
    let (d, force) = (batch.tests.numbers("diameter_mm")?, batch.tests.numbers("force_N")?);
    let censored = batch.tests.numbers("censored")?;
    let mut sizes = d.clone();
    sizes.sort_by(f64::total_cmp);
    sizes.dedup();
    if d.len() <= FEW * sizes.len() {
        let (broke, whole): (Vec<usize>, Vec<usize>) = (0..d.len()).partition(|&i| censored[i] == 0.0);
        let pick = |list: &[usize]| (list.iter().map(|&i| d[i]).collect(), list.iter().map(|&i| force[i]).collect());
        return Ok(vec![
            symbols(&format!("{prefix}broke"), tone, Shape::Circle, pick(&broke)),
            symbols(&format!("{prefix}did not break"), GREY, Shape::Triangle, pick(&whole)),
        ]);
    }
    let mut median = (Vec::new(), Vec::new());
    let mut spread = (Vec::new(), Vec::new());
    for size in sizes {
        let own = (0..d.len()).filter(|&i| d[i] == size);
        let mut forces: Vec<f64> = own.map(|i| if censored[i] == 0.0 { force[i] } else { f64::INFINITY }).collect();
        forces.sort_by(f64::total_cmp);
        for q in [0.05, 0.5, 0.95] {
            let value = quantile(&forces, q);
            if value.is_finite() {
                let to = if q == 0.5 { &mut median } else { &mut spread };
                to.0.push(size);
                to.1.push(value);
            }
        }
    }
    Ok(vec![
        symbols(&format!("{prefix}tests, median"), tone, Shape::Circle, median),
        symbols(&format!("{prefix}tests, 5 % and 95 %"), tone, Shape::Triangle, spread),
    ])
}

fn survival(batch: &Batch) -> Result<Option<Plot>> {
    let Some(table) = Table::read_if_there(&batch.run.dir.join("survival.csv"))? else {
        return Ok(None);
    };
    let (from, to) = (table.numbers("diameter_from_mm")?, table.numbers("diameter_to_mm")?);
    let (force, share, law) = (table.numbers("force_N")?, table.numbers("survival")?, table.numbers("survival_law")?);
    let mut classes: Vec<(f64, f64)> = from.iter().copied().zip(to.iter().copied()).collect();
    classes.dedup();
    // smaller forces are in `survival.csv` only
    let least = TAIL * force.iter().copied().fold(0.0, f64::max);
    let (mut series, mut laws) = (Vec::new(), Vec::new());
    for (i, class) in classes.iter().enumerate() {
        let mut own: Vec<usize> = (0..force.len()).filter(|&k| (from[k], to[k]) == *class).collect();
        let mut before = own.iter().rfind(|&&k| force[k] < least).map_or(1.0, |&k| share[k]);
        let mut steps: Vec<_> = (before < 1.0).then_some((least, before)).into_iter().collect();
        own.retain(|&k| force[k] >= least);
        for &k in &own {
            steps.extend([(force[k], before), (force[k], share[k])]);
            before = share[k];
        }
        let name = match class {
            (a, b) if a == b => of_size(*a),
            (a, b) => format!("d = {}–{} mm", significant(*a, 3), significant(*b, 3)),
        };
        let tone = if classes.len() < CURVES { colour::kind(i) } else { colour::sequence(i as f64 / classes.len() as f64) };
        series.push(Series::line(&name, tone, colour::dash(i), steps));
        let points: Vec<_> = own.iter().map(|&k| (force[k], law[k])).filter(|p| p.1.is_finite()).collect();
        if !points.is_empty() {
            let label = laws.is_empty().then(|| format!("{}, spread of the law", batch.equation()));
            laws.push(Series { label, mark: Mark::Guide(&[]), ..Series::line(&format!("{name}, law"), INK, &[], points) });
        }
    }
    series.extend(laws);
    Ok(Some(Plot {
        name: "survival".into(),
        title: batch.title(),
        legend_title: None,
        x: force_axis(true, "force F"),
        y: Axis::linear("share of grains that bear F (–)", "survival").including(&[0.0, 1.0]),
        series,
        equal: false,
    }))
}
