//! Figures of a continuum and of mixtures: σ1/σ3 against axial strain with the values of the law,
//! parts of the deviatoric stress, breakage, run-out and energies against time, and views of the
//! points from the side at the start and at the end.

use super::Input;
use super::axis::{Axis, count};
use super::balls::{Ball, Balls};
use super::canvas::{Canvas, WIDTH};
use super::colour::{self, GREY, INK};
use super::curves::title;
use super::energy;
use super::error::{FigureError, Result};
use super::plot::{Mark, Plot, Series, fit};
use super::run::{Run, read_summary};
use super::specimen::{Key, MARGIN, SIZE, TONES, Tones, label, scale_bar};
use super::table::Table;
use super::text::{Anchor, Line};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A column that only a continuum's triaxial test has.
const RATIO: &str = "principal_ratio";
/// A column that only free scenes with grains have.
const LOWEST: &str = "lowest_grain_mm";
/// Energies of a free scene: columns and legend entries. [`FALLEN`] is computed from the potential energies.
const TERMS: [(&str, &str); 5] = [
    ("kinetic_J", "kinetic, of points"),
    ("coarse_kinetic_J", "kinetic, of grains and bodies"),
    (FALLEN, "given by gravity"),
    ("stress_work_J", "work of stresses"),
    ("dissipated_J", "damping, friction, transfer"),
];
/// Loss of the potential energies of points, grains and bodies since the start.
const FALLEN: &str = "fallen_J";
/// Columns and legend entries of a mixture's deviatoric stress and of its parts.
const BEARERS: [(&str, &str); 4] = [
    ("q_kPa", "on the platens"),
    ("q_matrix_kPa", "matrix"),
    ("q_interface_kPa", "contacts of grains and points"),
    ("q_skeleton_kPa", "contacts of grains"),
];
/// Largest height of one view of the points, page units.
const TALLEST: f64 = 560.0;

/// The graphs that the records allow.
pub fn plots(input: &Input) -> Result<Vec<Plot>> {
    let mut out = Vec::new();
    out.extend(ratio(input)?);
    out.extend(lowest(input)?);
    if let [group] = &input.groups[..]
        && let [run] = &group.runs[..]
    {
        out.extend(run_out(run)?);
        out.extend(bearers(run)?);
        out.extend(breakage(run)?);
        out.extend(energies(run)?);
    }
    Ok(out)
}

/// σ1/σ3 against axial strain, with the peak and residual values of the law as horizontal lines.
fn ratio(input: &Input) -> Result<Option<Plot>> {
    let mut series = Vec::new();
    for (i, group) in input.groups.iter().enumerate() {
        series.extend(group.series(&group.label, colour::kind(i), colour::dash(i), false, |run| {
            run.branches(("axial_strain", 100.0), (RATIO, 1.0))
        })?);
    }
    let widest = series.iter().flat_map(|s| &s.x).copied().fold(0.0, f64::max);
    if series.is_empty() {
        return Ok(None);
    }
    let mut seen: Vec<f64> = Vec::new();
    for group in &input.groups {
        let summary = read_summary(&group.runs[0].dir.join("summary.json"))?;
        for (key, name) in [("peak_stress_ratio_of_the_law", "law, peak"), ("residual_stress_ratio_of_the_law", "law, residual")] {
            let Some(value) = summary[key].as_f64().filter(|v| seen.iter().all(|s| (s - v).abs() > 1e-3)) else { continue };
            seen.push(value);
            let name = format!("{name}: {value:.3}");
            // dashes tell the lines of the law from each other, grey tells them from the runs
            let dash = colour::dash(seen.len() - 1);
            series.push(Series { mark: Mark::Guide(dash), ..Series::line(&name, GREY, &[], vec![(0.0, value), (widest, value)]) });
        }
    }
    Ok(Some(Plot {
        name: "stress_ratio".into(),
        title: title(input),
        legend_title: None,
        x: Axis::linear("axial strain ε_{a} (%)", "axial_strain_percent").including(&[0.0]),
        y: Axis::linear("stress ratio σ_{1}/σ_{3} (–)", RATIO).including(&[1.0]),
        series,
        equal: false,
    }))
}

/// The lowest point of the grains of free scenes against time.
fn lowest(input: &Input) -> Result<Option<Plot>> {
    let mut series = Vec::new();
    for (i, group) in input.groups.iter().enumerate() {
        series.extend(
            group.series(&group.label, colour::kind(i), colour::dash(i), false, |run| {
                run.branches(("time_s", 1.0), (LOWEST, 1.0))
            })?,
        );
    }
    Ok((!series.is_empty()).then(|| Plot {
        name: "lowest_grain".into(),
        title: title(input),
        legend_title: None,
        x: Axis::linear("time (s)", "time_s").including(&[0.0]),
        y: Axis::linear("lowest point of the grains z (mm)", LOWEST).including(&[0.0]),
        series,
        equal: false,
    }))
}

fn against_time(name: &str, run: &Run, y: Axis, lines: Vec<(&str, Vec<f64>)>) -> Result<Option<Plot>> {
    let Some(time) = run.column("time_s")? else { return Ok(None) };
    let line = |(i, (name, values)): (usize, (&str, Vec<f64>))| {
        Series::line(name, colour::kind(i), colour::dash(i), time.iter().copied().zip(values).collect())
    };
    let series: Vec<Series> = lines.into_iter().enumerate().map(line).collect();
    let x = Axis::linear("time (s)", "time_s").including(&[0.0]);
    let plot = Plot { name: name.into(), title: vec![run.label()], legend_title: None, x, y, series, equal: false };
    Ok((!plot.series.is_empty()).then_some(plot))
}

/// Whether a curve shows anything: of what a scene has none of, all numbers are 0.
fn is_drawn(values: impl IntoIterator<Item = f64>) -> bool {
    values.into_iter().any(|v| v != 0.0 && v.is_finite())
}

fn run_out(run: &Run) -> Result<Option<Plot>> {
    let (Some(front), Some(height)) = (run.column("front_mm")?, run.column("height_mm")?) else { return Ok(None) };
    // without points there is neither
    if !is_drawn(front.iter().chain(&height).copied()) {
        return Ok(None);
    }
    let y = Axis::linear("distance of the front, height (mm)", "length_mm").including(&[0.0]);
    against_time("run_out", run, y, vec![("front", front), ("height", height)])
}

/// Deviatoric stress of a mixture and its parts (matrix, interface, skeleton) against axial strain;
/// `None` if a column is missing.
fn bearers(run: &Run) -> Result<Option<Plot>> {
    let mut series = Vec::new();
    for (i, (column, name)) in BEARERS.into_iter().enumerate() {
        let branches = run.branches(("axial_strain", 100.0), (column, 1.0))?;
        if branches.is_empty() {
            return Ok(None);
        }
        let points: Vec<_> = branches.into_iter().flat_map(|b| b.points).collect();
        if is_drawn(points.iter().map(|point| point.1)) {
            series.push(Series::line(name, colour::kind(i), colour::dash(i), points));
        }
    }
    // what one kind bears alone is what the platens feel
    if series.len() < 3 {
        return Ok(None);
    }
    Ok(Some(Plot {
        name: "stress_bearers".into(),
        title: vec![run.label()],
        legend_title: None,
        x: Axis::linear("axial strain ε_{a} (%)", "axial_strain_percent").including(&[0.0]),
        y: Axis::linear("deviatoric stress q (kPa)", "q_kPa").including(&[0.0]),
        series,
        equal: false,
    }))
}

/// Breakage indices of the grains of a mixture against axial strain, in a free scene against time;
/// `None` if no grain has broken.
fn breakage(run: &Run) -> Result<Option<Plot>> {
    // for grains alone (no such column), `curves` draws these indices against stress
    if run.column("platen_work_J")?.is_none() {
        return Ok(None);
    }
    let free = run.column("axial_strain")?.is_none();
    let x = if free { ("time_s", 1.0) } else { ("axial_strain", 100.0) };
    let mut series = Vec::new();
    for (i, (column, name)) in [("hardin_br", "Hardin"), ("einav_br", "Einav")].into_iter().enumerate() {
        let points: Vec<_> = run.branches(x, (column, 1.0))?.into_iter().flat_map(|b| b.points).collect();
        if points.iter().any(|p| p.1 > 0.0) {
            series.push(Series::line(name, colour::kind(i), colour::dash(i), points));
        }
    }
    let x = if free { Axis::linear("time (s)", "time_s") } else { Axis::linear("axial strain ε_{a} (%)", "axial_strain_percent") };
    let mut title = vec![run.label()];
    title.extend(run.events.map(|n| format!("{} breakage{} of grains", count(n), if n == 1 { "" } else { "s" })));
    Ok((!series.is_empty()).then(|| Plot {
        name: "breakage_mixture".into(),
        title,
        legend_title: None,
        x: x.including(&[0.0]),
        y: Axis::linear("breakage index of the grains B_{r} (–)", "breakage_index").including(&[0.0]),
        series,
        equal: false,
    }))
}

/// Energies of a free scene against time; `None` for tests, whose figures show stresses.
fn energies(run: &Run) -> Result<Option<Plot>> {
    let Some(potential) = run.column("potential_J")?.filter(|_| run.history.as_ref().is_some_and(|h| h.has("front_mm"))) else {
        return Ok(None);
    };
    let coarse = run.column("coarse_potential_J")?.unwrap_or_else(|| vec![0.0; potential.len()]);
    let height: Vec<f64> = potential.iter().zip(&coarse).map(|(points, coarse)| points + coarse).collect();
    let start = height.first().copied().unwrap_or(0.0);
    let mut terms = Vec::new();
    for (column, name) in TERMS {
        let values = match column {
            FALLEN => Some(height.iter().map(|now| start - now).collect()),
            _ => run.column(column)?,
        };
        terms.extend(values.filter(|values: &Vec<f64>| is_drawn(values.iter().copied())).map(|values| (name, values)));
    }
    let largest = terms.iter().flat_map(|t| &t.1).filter(|v| v.is_finite()).map(|v| v.abs()).fold(0.0, f64::max);
    if largest <= 0.0 {
        return Ok(None);
    }
    let (unit, factor) = energy::unit(largest);
    let y = Axis::linear(&format!("energy ({unit})"), &format!("energy_{unit}")).including(&[0.0]);
    let terms = terms.into_iter().map(|(name, values)| (name, values.into_iter().map(|v| v * factor).collect())).collect();
    against_time("energy_time", run, y, terms)
}

/// A view of the points along y (in plane strain along z): coordinates rightwards, upwards and
/// towards the reader, m, and the values that colour the points.
struct View {
    name: &'static str,
    points: Vec<[f64; 3]>,
    value: Vec<f64>,
}

impl View {
    fn read(name: &'static str, path: &Path, column: &str) -> Result<Option<(View, f64)>> {
        let Some(table) = Table::read_if_there(path)? else { return Ok(None) };
        let (x, y, z) = (table.numbers("x_m")?, table.numbers("y_m")?, table.numbers("z_m")?);
        let flat = z.iter().all(|v| *v == 0.0);
        let points = (0..x.len()).map(|i| if flat { [x[i], y[i], 0.0] } else { [x[i], z[i], -y[i]] }).collect();
        let spacing = table.note("spacing_m").unwrap_or(0.0);
        Ok(Some((View { name, points, value: table.numbers(column)? }, spacing)))
    }

    fn bounds(&self) -> [f64; 4] {
        self.points.iter().fold([f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY], |b, p| {
            [b[0].min(p[0]), b[1].max(p[0]), b[2].min(p[1]), b[3].max(p[1])]
        })
    }
}

/// Draws `out/points.{svg,png,csv}`, coloured by plastic strain if any point has some, else by
/// displacement; draws nothing without points.
pub fn draw_points(run: &Run, out: &Path) -> Result<Vec<PathBuf>> {
    let read = |name, file: &str, column: &str| View::read(name, &run.dir.join(file), column);
    let Some((end, spacing)) = read("end", "points_final.csv", "plastic_strain")? else { return Ok(Vec::new()) };
    let plastic = end.value.iter().any(|v| *v > 0.0);
    let column = if plastic { "plastic_strain" } else { "displacement_mm" };
    let views: Vec<View> = [("start", "points_start.csv"), ("end", "points_final.csv")]
        .into_iter()
        .map(|(name, file)| read(name, file, column))
        .collect::<Result<Vec<_>>>()?
        .into_iter()
        .flatten()
        .map(|v| v.0)
        .filter(|v| !v.points.is_empty() && v.points.iter().flatten().all(|x| x.is_finite()))
        .collect();
    if views.is_empty() || spacing <= 0.0 {
        return Ok(Vec::new());
    }
    let what = if plastic { "plastic strain (–)" } else { "displacement (mm)" };
    let values = || views.iter().flat_map(|v| &v.value).copied().filter(|v| v.is_finite());
    let hi = high_of(values().collect());
    let tones = Tones {
        palette: (0..TONES).map(|i| colour::sequence(i as f64 / (TONES - 1) as f64)).collect(),
        key: Key::Field { name: what.into(), lo: 0.0, hi },
    };
    let (canvas, csv) = picture(run, &views, &tones, hi, 0.5 * spacing);
    table::folder(out).map_err(|e| FigureError::io(out, e))?;
    let mut files = canvas.write(out, "points")?.to_vec();
    let path = out.join("points.csv");
    table::write(&path, format!("view,x_m,height_m,{column}\n{csv}")).map_err(|e| FigureError::io(&path, e))?;
    files.push(path);
    Ok(files)
}

/// Upper end of the colour bar: the value below which 99 % of the values lie; 0 without values.
pub(super) fn high_of(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len().saturating_sub(1) * 99 / 100).copied().unwrap_or(0.0)
}

fn picture(run: &Run, views: &[View], tones: &Tones, hi: f64, radius: f64) -> (Canvas, String) {
    let all = views.iter().map(View::bounds).fold([f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY], |a, b| {
        [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])]
    });
    let (wide, tall) = (all[1] - all[0] + 2.0 * radius, all[3] - all[2] + 2.0 * radius);
    let scale = ((WIDTH - 2.0 * MARGIN) / wide).min(TALLEST / tall);
    let left = (WIDTH - wide * scale) / 2.0 + (radius - all[0]) * scale;
    let panel = tall * scale + 80.0;
    let foot = 90.0 + panel * views.len() as f64;
    let mut canvas = Canvas::new((foot + 140.0).round());
    let points = count(views.last().map_or(0, |v| v.points.len()) as u64);
    let heading = format!("{} · {points} points, seen from the side", run.label());
    let size = fit(&heading, SIZE, WIDTH - 2.0 * MARGIN);
    canvas.text(Line { at: (WIDTH / 2.0, 40.0), text: heading, size, colour: INK, anchor: Anchor::Middle, upwards: false });
    let mut csv = String::new();
    for (k, view) in views.iter().enumerate() {
        let base = 90.0 + panel * (k + 1) as f64 - 10.0;
        let place = |p: &[f64; 3]| (left + p[0] * scale, base - (p[1] - all[2] + radius) * scale);
        let tone =
            |v: f64| if hi > 0.0 { (v / hi * (TONES - 1) as f64).round().clamp(0.0, (TONES - 1) as f64) as usize } else { 0 };
        let items = view.points.iter().zip(&view.value).map(|(p, v)| {
            let (x, y) = place(p);
            Ball { x, y, depth: p[2] * scale, r: radius * scale, colour: tone(*v) }
        });
        let balls = Balls { palette: tones.palette.clone(), items: items.collect() };
        for i in balls.visible_order() {
            let _ = writeln!(csv, "{},{:.6},{:.6},{:.6}", view.name, view.points[i][0], view.points[i][1], view.value[i]);
        }
        label(&mut canvas, (MARGIN, base - tall * scale - 26.0), view.name.into(), Anchor::Start);
        canvas.balls(balls);
        let ends = [all[0] - radius, all[1] + radius].map(|x| (left + x * scale, base));
        canvas.line(&ends, GREY, 2.5, &[]);
    }
    scale_bar(&mut canvas, wide, scale, foot + 50.0);
    tones.legend(&mut canvas, foot + 50.0);
    (canvas, csv)
}
