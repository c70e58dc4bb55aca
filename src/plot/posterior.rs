//! Figures of a calibration against a curve: the curve with the bands of the calibration, the draws
//! of the parameters two by two, the sensitivity of the curve to each parameter, and how the
//! intervals of the parameters narrowed.

use super::axis::{Axis, Range, Scale};
use super::canvas::{Canvas, Point, WIDTH};
use super::colour::{self, Colour, GREY, GRID, INK};
use super::error::{FigureError, Result};
use super::plot::{Mark, Plot, Series, Shape, fit};
use super::text::{Anchor, Line, room};
use std::path::{Path, PathBuf};

/// A measured curve, and what the calibration predicts for it.
#[derive(Clone, Debug)]
pub struct FittedLine {
    /// The measured quantity: a column of a history, or `gradation`.
    pub quantity: String,
    /// File name without extension.
    pub name: String,
    /// Abscissae: vertical stress, kPa, or grain size, mm.
    pub x: Vec<f64>,
    /// Measured values.
    pub measured: Vec<f64>,
    /// Median of the mean curves.
    pub median: Vec<f64>,
    /// Lower and upper 95 % limit of the mean curves.
    pub mean: [Vec<f64>; 2],
    /// Lower and upper 95 % limit of single specimens.
    pub specimen: [Vec<f64>; 2],
    /// The curve in each run with the likeliest parameters.
    pub checks: Vec<Vec<f64>>,
    /// Parts of the title above the frame.
    pub title: Vec<String>,
}

/// A calibrated parameter, with the axis on which figures show it.
#[derive(Clone, Debug)]
pub struct Input {
    /// Name of the parameter, with its unit.
    pub name: String,
    /// Whether the axis is logarithmic.
    pub log: bool,
    /// Lower bound.
    pub lower: f64,
    /// Upper bound.
    pub upper: f64,
}

/// Draws the measured curve with the bands of the calibration; returns the files written.
pub fn draw_fitted(line: &FittedLine, out: &Path) -> Result<Vec<PathBuf>> {
    let (x, y, x_factor, factor) = axes(&line.quantity);
    let scaled = |v: &[f64], f: f64| v.iter().map(|v| v * f).collect::<Vec<f64>>();
    let xs = scaled(&line.x, x_factor);
    let band = |label: &str, colour, [low, high]: &[Vec<f64>; 2], dash| Series {
        label: Some(label.into()),
        name: label.into(),
        colour,
        mark: Mark::Band { low: scaled(low, factor), high: scaled(high, factor), dash },
        x: xs.clone(),
        y: scaled(&line.median, factor),
    };
    let mut series = vec![
        band("95 % of specimens", colour::kind(5), &line.specimen, colour::dash(0)),
        band("95 % of mean curves", colour::kind(0), &line.mean, colour::dash(0)),
    ];
    for (i, check) in line.checks.iter().enumerate() {
        let label = "runs with the parameters found";
        series.push(Series {
            label: (i == 0).then(|| label.to_string()),
            name: format!("{label}, {}", i + 1),
            colour: colour::kind(1),
            mark: Mark::Guide(&[]),
            x: xs.clone(),
            y: scaled(check, factor),
        });
    }
    series.push(Series {
        label: Some("measured".into()),
        name: "measured".into(),
        colour: INK,
        mark: Mark::Symbols(Shape::Circle),
        x: xs.clone(),
        y: scaled(&line.measured, factor),
    });
    let plot = Plot { name: line.name.clone(), title: line.title.clone(), legend_title: None, x, y, series, equal: false };
    plot.draw(out)
}

/// Axes of a quantity, and the factors from its recorded abscissae and values to the axes' units.
fn axes(quantity: &str) -> (Axis, Axis, f64, f64) {
    let stress = super::curves::stress_axis();
    let y = |label: &str, column: &str| Axis::linear(label, column);
    match quantity {
        "gradation" => (
            Axis::log("grain size (mm)", "diameter_mm"),
            y("passing by mass (%)", "passing_percent").including(&[0.0, 100.0]),
            1.0,
            1.0,
        ),
        "void_ratio" => (stress, y("void ratio e (–)", "void_ratio"), 1e-3, 1.0),
        "void_ratio_grains" => (stress, y("void ratio of grains alone (–)", "void_ratio_grains"), 1e-3, 1.0),
        "void_ratio_star" => (stress, y("void ratio with grains' pores e* (–)", "void_ratio_star"), 1e-3, 1.0),
        "porosity_grains" => (stress, y("porosity of grains alone (–)", "porosity_grains"), 1e-3, 1.0),
        "axial_strain" => (stress, y("axial strain ε_{a} (%)", "axial_strain_percent").downwards(), 1e-3, 100.0),
        "k0" => (stress, y("stress ratio k_{0} = σ_{h}/σ_{v} (–)", "k0").including(&[0.0]), 1e-3, 1.0),
        "porosity_star" => (stress, y("total porosity n* (–)", "porosity_star"), 1e-3, 1.0),
        _ => (stress, y("intergranular porosity n (–)", "porosity"), 1e-3, 1.0),
    }
}

/// Draws how the intervals narrowed: a panel for each parameter with its median and 95 % interval
/// against the number of runs. `quantiles` holds lower limit, median and upper limit of each
/// parameter for each entry of `runs`. Returns the files written.
pub fn draw_convergence(inputs: &[Input], runs: &[f64], quantiles: &[Vec<[f64; 3]>], out: &Path) -> Result<Vec<PathBuf>> {
    const SIZE: f64 = 42.0;
    const GAP: f64 = 40.0;
    let (left, top, bottom, height) = (260.0, 80.0, 150.0, 340.0);
    let count = inputs.len() as f64;
    let mut canvas = Canvas::new(top + bottom + count * height + (count - 1.0) * GAP);
    let Some(x) = Axis::linear("", "").range(runs.iter().copied()) else {
        return Ok(Vec::new());
    };
    let tone = colour::kind(0);
    let mut rows = String::from("parameter,runs,lower,median,upper\n");
    let what = "line: median, band: 95 % interval".into();
    canvas.text(Line { at: (left, 40.0), text: what, size: 37.0, colour: INK, anchor: Anchor::Start, upwards: false });
    for (k, input) in inputs.iter().enumerate() {
        let panel = Panel { left, top: top + k as f64 * (height + GAP), width: WIDTH - left - 50.0, height };
        let of =
            |q: usize| runs.iter().zip(quantiles).map(|(n, t)| panel.at(x.place(*n), input.place(t[k][q]))).collect::<Vec<Point>>();
        let mut outline = of(0);
        outline.extend(of(2).into_iter().rev());
        canvas.area(outline, tone, 0.28);
        canvas.line(&of(1), tone, 7.0, &[]);
        panel.frame(&mut canvas);
        ticks(&mut canvas, panel, &input.range(), &input.name, SIZE, true);
        let last = k + 1 == inputs.len();
        if last {
            ticks(&mut canvas, panel, &x, "runs (–)", SIZE, false);
        }
        for (n, t) in runs.iter().zip(quantiles) {
            let [low, middle, high] = t[k];
            rows += &format!("{},{n},{low},{middle},{high}\n", super::plot::quoted(&input.name));
        }
    }
    table::folder(out).map_err(|e| FigureError::io(out, e))?;
    let mut files = canvas.write(out, "convergence")?.to_vec();
    files.push(table(out, "convergence", &rows)?);
    Ok(files)
}

impl Input {
    fn range(&self) -> Range {
        let scale = if self.log { Scale::Log } else { Scale::Linear };
        Range { scale, lo: self.lower, hi: self.upper }
    }

    /// Place of a value on the parameter's axis: 0 at the lower, 1 at the upper bound.
    fn place(&self, v: f64) -> f64 {
        self.range().place(v)
    }
}

/// A frame on the page.
#[derive(Clone, Copy)]
struct Panel {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
}

impl Panel {
    /// Page position of a place in the panel: x from 0 (left) to 1, y from 0 (bottom) to 1.
    fn at(&self, x: f64, y: f64) -> Point {
        (self.left + x * self.width, self.top + (1.0 - y) * self.height)
    }

    fn frame(&self, canvas: &mut Canvas) {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0), (0.01, 0.0)].map(|(x, y)| self.at(x, y));
        canvas.line(&corners, INK, 3.0, &[]);
    }
}

/// Cells of a density along one side.
const CELLS: usize = 48;
/// Standard deviation of the smoothing of a density, cells.
const BLUR: f64 = 1.3;
/// The two shaded regions: share of the draws in the region, and its opacity.
const REGIONS: [(f64, f64); 2] = [(0.95, 0.28), (0.68, 0.75)];

/// Draws the corner figure: for each pair of parameters, the regions that hold 68 and 95 % of the
/// `draws`; on the diagonal, the density of each parameter with its median and 95 % interval.
/// Returns the files written.
pub fn draw_corner(inputs: &[Input], draws: &[Vec<f64>], out: &Path) -> Result<Vec<PathBuf>> {
    let d = inputs.len();
    let gap = 22.0;
    let small = if d < 4 { 40.0 } else { 30.0 };
    let (left, right, top, bottom) = (205.0, 30.0, 30.0, 190.0);
    let side = (WIDTH - left - right - gap * (d as f64 - 1.0)) / d as f64;
    let height = top + bottom + side * d as f64 + gap * (d as f64 - 1.0);
    let mut canvas = Canvas::new(height.round());
    let tone = colour::kind(0);
    let places: Vec<Vec<f64>> = inputs.iter().enumerate().map(|(k, p)| draws.iter().map(|v| p.place(v[k])).collect()).collect();
    for row in 0..d {
        for column in 0..=row {
            let step = side + gap;
            let panel = Panel { left: left + step * column as f64, top: top + step * row as f64, width: side, height: side };
            if row == column {
                marginal(&mut canvas, panel, &places[row], tone);
            } else {
                joint(&mut canvas, panel, &places[column], &places[row], tone);
            }
            panel.frame(&mut canvas);
            if row == d - 1 {
                ticks(&mut canvas, panel, &inputs[column].range(), &inputs[column].name, small, false);
            }
            if column == 0 && row > 0 {
                ticks(&mut canvas, panel, &inputs[row].range(), &inputs[row].name, small, true);
            }
        }
    }
    table::folder(out).map_err(|e| FigureError::io(out, e))?;
    let mut files = canvas.write(out, "corner")?.to_vec();
    let header: Vec<&str> = inputs.iter().map(|p| p.name.as_str()).collect();
    let rows = draws.iter().map(|v| v.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n");
    files.push(table(out, "corner", &(header.join(",") + "\n" + &rows.collect::<String>()))?);
    Ok(files)
}

fn table(out: &Path, name: &str, text: &str) -> Result<PathBuf> {
    let path = out.join(format!("{name}.csv"));
    table::write(&path, text).map_err(|e| FigureError::io(&path, e))?;
    Ok(path)
}

fn cell(place: f64) -> usize {
    ((place * CELLS as f64) as usize).min(CELLS - 1)
}

/// Counts of cells smoothed with normal weights. The weights of each cell are divided by their sum
/// over the cells between the bounds, so that the total stays.
fn blurred(counts: &[f64]) -> Vec<f64> {
    let weight = |i: usize, j: usize| (-0.5 * ((i as f64 - j as f64) / BLUR).powi(2)).exp();
    let spread: Vec<f64> = (0..CELLS).map(|j| (0..CELLS).map(|i| weight(i, j)).sum()).collect();
    (0..CELLS).map(|i| (0..CELLS).map(|j| counts[j] * weight(i, j) / spread[j]).sum()).collect()
}

fn marginal(canvas: &mut Canvas, panel: Panel, places: &[f64], tone: Colour) {
    let mut counts = vec![0.0; CELLS];
    places.iter().for_each(|p| counts[cell(*p)] += 1.0);
    let density = blurred(&counts);
    let most = density.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let top = |i: usize| panel.at((i as f64 + 0.5) / CELLS as f64, 0.92 * density[i] / most);
    let mut curve = vec![panel.at(0.0, 0.92 * density[0] / most)];
    curve.extend((0..CELLS).map(top));
    curve.push(panel.at(1.0, 0.92 * density[CELLS - 1] / most));
    let mut outline = curve.clone();
    outline.extend([panel.at(1.0, 0.0), panel.at(0.0, 0.0)]);
    canvas.area(outline, tone, 0.28);
    canvas.line(&curve, tone, 6.0, &[]);
    let mut sorted = places.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |q: f64| sorted.get((q * (sorted.len() - 1) as f64) as usize).copied().unwrap_or(f64::NAN);
    for (q, dash) in [(0.5, colour::dash(0)), (0.025, colour::dash(1)), (0.975, colour::dash(1))] {
        canvas.line(&[panel.at(at(q), 0.0), panel.at(at(q), 1.0)], INK, 3.0, dash);
    }
}

fn joint(canvas: &mut Canvas, panel: Panel, xs: &[f64], ys: &[f64], tone: Colour) {
    let mut counts = vec![vec![0.0; CELLS]; CELLS];
    xs.iter().zip(ys).for_each(|(x, y)| counts[cell(*y)][cell(*x)] += 1.0);
    // smoothed along the rows first, then along the columns
    let rows: Vec<Vec<f64>> = counts.iter().map(|row| blurred(row)).collect();
    let columns: Vec<Vec<f64>> = (0..CELLS).map(|i| blurred(&rows.iter().map(|r| r[i]).collect::<Vec<_>>())).collect();
    let density = |i: usize, j: usize| columns[i][j];
    let mut all: Vec<f64> = columns.concat();
    all.sort_by(|a, b| b.total_cmp(a));
    let total: f64 = all.iter().sum();
    for (share, alpha) in REGIONS {
        let mut sum = 0.0;
        let level = all.iter().find(|v| {
            sum += **v;
            sum >= share * total
        });
        let level = level.copied().unwrap_or(0.0);
        for j in 0..CELLS {
            // adjacent cells of a row are one rectangle
            let mut i = 0;
            while i < CELLS {
                let start = i;
                while i < CELLS && density(i, j) >= level && density(i, j) > 0.0 {
                    i += 1;
                }
                if i > start {
                    let place = |k: usize| k as f64 / CELLS as f64;
                    canvas.rect(panel.at(place(start), place(j)), panel.at(place(i), place(j + 1)), tone, alpha);
                }
                i += 1;
            }
        }
    }
}

/// Draws the ticks of a panel's axis, their labels and the name. A label that would overlap another
/// one, or the panel beside, is left out.
fn ticks(canvas: &mut Canvas, panel: Panel, range: &Range, name: &str, size: f64, upwards: bool) {
    let text = |at, text: &str, size, anchor, upwards| Line { at, text: text.into(), size, colour: INK, anchor, upwards };
    let along = if upwards { panel.height } else { panel.width };
    let mut last = f64::NEG_INFINITY;
    for tick in range.ticks() {
        let p = range.place(tick.value);
        let length = if tick.label.is_some() { 14.0 } else { 8.0 };
        let from = if upwards { panel.at(0.0, p) } else { panel.at(p, 0.0) };
        let to = if upwards { (from.0 + length, from.1) } else { (from.0, from.1 - length) };
        canvas.line(&[from, to], INK, 3.0, &[]);
        let Some(label) = tick.label else { continue };
        let extent = if upwards { 1.2 * size } else { room(&label, size) + 0.4 * size };
        let at = p * along;
        let beside = !upwards && (at < 0.4 * extent || along - at < 0.4 * extent);
        if at - last < extent || beside {
            continue;
        }
        last = at;
        if upwards {
            canvas.text(text((from.0 - 10.0, from.1), &label, size, Anchor::End, false));
        } else {
            canvas.text(text((from.0, from.1 + 36.0), &label, size, Anchor::Middle, false));
        }
    }
    let fitted = fit(name, 1.1 * size, along);
    if upwards {
        canvas.text(text((44.0, panel.top + 0.5 * panel.height), name, fitted, Anchor::Middle, true));
    } else {
        canvas.text(text((panel.left + 0.5 * panel.width, panel.top + panel.height + 108.0), name, fitted, Anchor::Middle, false));
    }
}

/// Draws, for each name, its shares of the curve's variance over the prior: `first`, the parameter
/// alone, and `total`, with its interactions with the others (first-order and total Sobol'
/// indices). Returns the files written.
pub fn draw_sensitivity(names: &[String], first: &[f64], total: &[f64], out: &Path) -> Result<Vec<PathBuf>> {
    const ROW: f64 = 130.0;
    const SIZE: f64 = 46.0;
    let widest = names.iter().map(|n| room(n, SIZE)).fold(0.0, f64::max).min(0.5 * WIDTH);
    let (left, top) = (40.0 + widest, 110.0);
    let width = WIDTH - left - 60.0;
    let bottom = top + ROW * names.len() as f64;
    let mut canvas = Canvas::new(bottom + 150.0);
    let text = |at, text: &str, size, anchor| Line { at, text: text.into(), size, colour: INK, anchor, upwards: false };
    let x = |v: f64| left + v * width;
    for i in 0..=5 {
        let v = f64::from(i) * 0.2;
        canvas.line(&[(x(v), top), (x(v), bottom)], GRID, 2.0, &[]);
        canvas.text(text((x(v), bottom + 38.0), &format!("{v:.1}"), SIZE, Anchor::Middle));
    }
    let (light, dark) = (colour::kind(5), colour::kind(0));
    for (i, name) in names.iter().enumerate() {
        let y = top + ROW * (i as f64 + 0.5);
        canvas.rect((left, y - 38.0), (x(total[i]), y), light, 1.0);
        canvas.rect((left, y), (x(first[i]), y + 38.0), dark, 1.0);
        canvas.text(text((left - 18.0, y), name, fit(name, SIZE, widest), Anchor::End));
    }
    let frame = [(left, top), (left + width, top), (left + width, bottom), (left, bottom), (left, top), (left + 1.0, top)];
    canvas.line(&frame, INK, 3.0, &[]);
    let middle = left + 0.5 * width;
    let label = "share of the curve's variance (–)";
    canvas.text(text((middle, bottom + 108.0), label, fit(label, 48.0, width), Anchor::Middle));
    let mut at = left;
    for (label, tone) in [("with the others", light), ("alone", dark)] {
        canvas.rect((at, 34.0), (at + 60.0, 72.0), tone, 1.0);
        canvas.text(text((at + 76.0, 53.0), label, 42.0, Anchor::Start));
        at += 130.0 + room(label, 42.0);
    }
    canvas.line(&[(left, top), (left, bottom)], GREY, 3.0, &[]);
    table::folder(out).map_err(|e| FigureError::io(out, e))?;
    let mut files = canvas.write(out, "sensitivity")?.to_vec();
    let rows = names.iter().zip(first).zip(total).map(|((n, a), b)| format!("{},{a},{b}\n", super::plot::quoted(n)));
    files.push(table(out, "sensitivity", &format!("name,alone,with_others\n{}", rows.collect::<String>()))?);
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inputs() -> Vec<Input> {
        let input = |name: &str, log, lower, upper| Input { name: name.into(), log, lower, upper };
        vec![input("sigma_lim0_MPa", true, 100.0, 1000.0), input("m", false, 1.0, 5.0)]
    }

    #[test]
    fn a_corner_has_its_draws_beside_it() {
        let dir = tempfile::tempdir().expect("folder");
        let draws: Vec<Vec<f64>> = (0..500).map(|i| vec![200.0 + f64::from(i), 2.0 + f64::from(i % 7) * 0.1]).collect();
        let files = draw_corner(&inputs(), &draws, dir.path()).expect("drawn");
        assert_eq!(files.len(), 3);
        let csv = std::fs::read_to_string(&files[2]).expect("csv");
        assert_eq!(csv.lines().count(), 501);
        assert!(csv.starts_with("sigma_lim0_MPa,m\n200,2\n"));
    }

    #[test]
    fn smoothing_keeps_the_number_of_draws() {
        let mut counts = vec![0.0; CELLS];
        (counts[0], counts[20], counts[CELLS - 1]) = (5.0, 3.0, 2.0);
        let sum: f64 = blurred(&counts).iter().sum();
        assert!((sum - 10.0).abs() < 1e-9);
    }

    #[test]
    fn intervals_are_drawn_between_the_bounds() {
        let dir = tempfile::tempdir().expect("folder");
        let trace = vec![vec![[100.0, 316.227766, 1000.0], [1.0, 3.0, 5.0]], vec![[200.0, 300.0, 400.0], [2.0, 3.0, 4.0]]];
        let files = draw_convergence(&inputs(), &[10.0, 20.0], &trace, dir.path()).expect("drawn");
        let csv = std::fs::read_to_string(files.iter().find(|f| f.ends_with("convergence.csv")).expect("csv")).expect("text");
        assert!(csv.contains("sigma_lim0_MPa,10,100,316.227766,1000") && csv.contains("m,20,2,3,4"), "{csv}");
        assert!((inputs()[0].place(316.227766) - 0.5).abs() < 1e-9);
        let files = draw_sensitivity(&["a".into(), "b".into()], &[0.1, 0.5], &[0.3, 0.8], dir.path()).expect("drawn");
        assert!(files.iter().all(|f| f.is_file()));
    }
}
