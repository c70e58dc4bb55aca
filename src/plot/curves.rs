//! Quantities against vertical stress, mean stress (both logarithmic) or work of the walls:
//! compression curves, strains, k0, crush events, breakage indices (Ciantia et al. 2015, Figs 10,
//! 11).

use super::Input;
use super::axis::{Axis, significant};
use super::colour;
use super::error::Result;
use super::group::{Group, band_note};
use super::plot::{Mark, Plot, Series};
use super::run::{Branch, Run};

/// One figure: its axes, and the history columns that it shows, each with its legend entry.
struct Curves {
    name: &'static str,
    x: Abscissa,
    y: Axis,
    columns: &'static [(&'static str, &'static str)],
    factor: f64,
    /// Whether the figure is left out when every value is zero (no grain can break).
    skip_zero: bool,
}

/// Quantity on the horizontal axis.
#[derive(Clone, Copy, PartialEq)]
enum Abscissa {
    VerticalStress,
    MeanStress,
    /// Work of the walls over the volume at the start.
    Work,
}

impl Abscissa {
    /// History column of the abscissa, with the factor to the unit of the axis; `None` if the run's
    /// volume is not known.
    fn of(self, run: &Run) -> Option<(&'static str, f64)> {
        match self {
            Self::VerticalStress => Some(("sigma_v_kPa", 1e-3)),
            Self::MeanStress => Some(("p_kPa", 1e-3)),
            Self::Work => run.volume.map(|v| ("energy_wall_J", 1e-3 / v)),
        }
    }

    fn axis(self) -> Axis {
        match self {
            Self::VerticalStress => stress_axis(),
            Self::MeanStress => Axis::log("mean stress p (MPa)", "p_MPa"),
            Self::Work => Axis::linear("work of the walls per initial volume (kJ/m³)", "work_kJ_m3").including(&[0.0]),
        }
    }
}

/// Columns that have no meaning where the void ratio is below [`Run::least_void_ratio`].
const DENSE: [&str; 3] = ["void_ratio", "porosity", "porosity_star"];
/// Dash pattern of a curve where its values have no meaning.
const BEYOND: &[f64] = &[14.0, 14.0];

/// Axis of the vertical stress.
pub fn stress_axis() -> Axis {
    Axis::log("vertical stress σ_{v} (MPa)", "sigma_v_MPa")
}

fn all() -> Vec<Curves> {
    let curves = |name, y, columns| Curves { name, x: Abscissa::VerticalStress, y, columns, factor: 1.0, skip_zero: false };
    let breakage = || Axis::linear("breakage index B_{r} (–)", "breakage_index").including(&[0.0]);
    const BREAKAGE: &[(&str, &str)] = &[("hardin_br", "Hardin"), ("einav_br", "Einav")];
    let percent = Axis::linear("axial strain ε_{a} (%)", "axial_strain_percent");
    vec![
        curves("compression", Axis::linear("intergranular porosity n (–)", "porosity"), &[("porosity", "")]),
        curves("compression_star", Axis::linear("total porosity n* (–)", "porosity_star"), &[("porosity_star", "")]),
        curves("void_ratio", Axis::linear("void ratio e (–)", "void_ratio"), &[("void_ratio", "")]),
        Curves {
            x: Abscissa::MeanStress,
            ..curves("void_ratio_mean_stress", Axis::linear("void ratio e (–)", "void_ratio"), &[("void_ratio", "")])
        },
        Curves { factor: 100.0, ..curves("axial_strain", percent.including(&[0.0]).downwards(), &[("axial_strain", "")]) },
        // only tests in which the cylinder wall moves record this column
        Curves {
            x: Abscissa::MeanStress,
            factor: 100.0,
            ..curves(
                "volumetric_strain",
                Axis::linear("volumetric strain ε_{v} (%)", "volumetric_strain_percent").including(&[0.0]).downwards(),
                &[("volumetric_strain", "")],
            )
        },
        curves("k0", Axis::linear("stress ratio k_{0} = σ_{h}/σ_{v} (–)", "k0").including(&[0.0]), &[("k0", "")]),
        Curves {
            skip_zero: true,
            ..curves("crush_events", Axis::linear("crush events (–)", "crush_events").including(&[0.0]), &[("crush_events", "")])
        },
        Curves { skip_zero: true, ..curves("breakage_indices", breakage(), BREAKAGE) },
        Curves { x: Abscissa::Work, skip_zero: true, ..curves("breakage_work", breakage(), BREAKAGE) },
    ]
}

/// The figures for which the records have something to show.
pub fn plots(input: &Input) -> Result<Vec<Plot>> {
    let mut out = Vec::new();
    for curves in all() {
        out.extend(plot(input, curves)?);
    }
    Ok(out)
}

/// Stresses below this share of the largest are rounding errors of an unloaded specimen.
const NOISE: f64 = 1e-7;

/// Removes points whose stress is a rounding error or not positive, and branches that are then
/// empty: such points would stretch a logarithmic axis.
fn without_noise(mut branches: Vec<Branch>) -> Vec<Branch> {
    let most = branches.iter().flat_map(|b| &b.points).map(|p| p.0.abs()).fold(0.0, f64::max);
    for branch in &mut branches {
        branch.points.retain(|p| p.0 > NOISE * most);
    }
    branches.retain(|b| !b.points.is_empty());
    branches
}

fn plot(input: &Input, curves: Curves) -> Result<Option<Plot>> {
    let mut series = Vec::new();
    let single = input.groups.len() == 1;
    let several = curves.columns.len() > 1;
    for (i, group) in input.groups.iter().enumerate() {
        for (j, (column, legend)) in curves.columns.iter().enumerate() {
            let name = match (several, single) {
                (false, _) => group.label.clone(),
                (true, true) => (*legend).to_string(),
                (true, false) => format!("{}: {legend}", group.label),
            };
            let nth = if single { j } else { i };
            let dash = colour::dash(i * curves.columns.len() + j);
            let log = curves.x != Abscissa::Work;
            let drawn = group.series(&name, colour::kind(nth), dash, log, |run| {
                let Some(x) = curves.x.of(run) else { return Ok(Vec::new()) };
                let branches = run.branches(x, (column, curves.factor))?;
                Ok(if log { without_noise(branches) } else { branches })
            })?;
            let limit = if DENSE.contains(column) { below_least(group, curves.x)? } else { None };
            series.extend(match limit {
                Some((limit, least)) => faded(drawn, limit, least),
                None => drawn,
            });
        }
    }
    // several groups may have the same legend entry: only the first keeps it
    let mut said: Vec<String> = Vec::new();
    for label in series.iter_mut().map(|s| &mut s.label) {
        match label {
            Some(text) if said.contains(text) => *label = None,
            Some(text) => said.push(text.clone()),
            None => {}
        }
    }
    for data in input.data.iter().filter(|_| curves.x == Abscissa::VerticalStress) {
        series.extend(data.against_stress(curves.columns[0].0, curves.factor)?);
    }
    let all_zero = series.iter().all(|s| s.y.iter().all(|v| v.abs() < 1e-12));
    if series.is_empty() || (curves.skip_zero && all_zero) {
        return Ok(None);
    }
    let mut title = title(input);
    if several && single {
        title.insert(0, input.groups[0].label.clone());
    }
    Ok(Some(Plot { name: curves.name.into(), title, legend_title: None, x: curves.x.axis(), y: curves.y, series, equal: false }))
}

/// Smallest abscissa at which a run of the group first has a void ratio below
/// [`Run::least_void_ratio`], with that least void ratio; `None` if no run gets there.
fn below_least(group: &Group, x: Abscissa) -> Result<Option<(f64, f64)>> {
    let mut first: Option<(f64, f64)> = None;
    for run in &group.runs {
        let Some((column, factor)) = x.of(run) else { continue };
        if let Some(at) = run.below_least(column, factor)?.filter(|at| first.is_none_or(|f| *at < f.0)) {
            first = Some((at, run.least_void_ratio));
        }
    }
    Ok(first)
}

/// Splits series at the first point whose abscissa reaches `limit`: everything from that point on,
/// later series included, is drawn pale and dashed. The legend entry of the pale part names the
/// void ratio `least`.
fn faded(series: Vec<Series>, limit: f64, least: f64) -> Vec<Series> {
    let mut passed = false;
    let mut out: Vec<Series> = Vec::new();
    for whole in series {
        let at = if passed { 0 } else { whole.x.iter().position(|x| *x >= limit * (1.0 - 1e-9)).unwrap_or(whole.x.len()) };
        if at >= whole.x.len() {
            out.push(whole);
            continue;
        }
        let label = (!passed).then(|| format!("e < {}: fines could not fill the voids", significant(least, 2)));
        passed = true;
        let part = |range: std::ops::Range<usize>, dash: Option<&'static [f64]>| Series {
            x: whole.x[range.clone()].to_vec(),
            y: whole.y[range.clone()].to_vec(),
            mark: match &whole.mark {
                Mark::Band { low, high, dash: own } => {
                    Mark::Band { low: low[range.clone()].to_vec(), high: high[range].to_vec(), dash: dash.unwrap_or(own) }
                }
                Mark::Line(own) => Mark::Line(dash.unwrap_or(own)),
                other => other.clone(),
            },
            ..whole.clone()
        };
        let rest = part(at..whole.x.len(), Some(BEYOND));
        if at > 0 {
            out.push(part(0..at + 1, None));
        }
        out.push(Series {
            label,
            colour: colour::mix(whole.colour, colour::WHITE, 0.5),
            name: format!("{} below least", whole.name),
            ..rest
        });
    }
    out
}

/// Parts of the title: material, scale and d50 if all runs have the same, the outcome of a single
/// run, and what a band shows.
pub fn title(input: &Input) -> Vec<String> {
    let mut runs = input.groups.iter().flat_map(|g| &g.runs);
    let Some(first) = runs.next() else {
        return Vec::new();
    };
    let rest: Vec<_> = runs.collect();
    let mut out: Vec<String> = first.facts().into_iter().filter(|f| rest.iter().all(|r| r.facts().contains(f))).collect();
    if rest.is_empty() {
        out.extend(first.outcome());
    }
    out.extend(band_note(&input.groups).map(str::to_string));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_pale_from_where_fines_could_not_fill_the_voids() {
        let line = Series::line("a", colour::INK, &[], vec![(0.1, 0.5), (1.0, 0.3), (2.0, 0.1), (5.0, 0.0), (0.1, 0.02)]);
        let parts = faded(vec![line.clone()], 2.0, 0.15);
        assert_eq!(parts.len(), 2);
        assert_eq!((parts[0].x.len(), &parts[1].x[..]), (3, &[2.0, 5.0, 0.1][..]));
        assert!(parts[1].label.as_ref().is_some_and(|l| l.contains("0.15")) && parts[1].mark == Mark::Line(BEYOND));
        assert_eq!(faded(vec![line], 9.0, 0.15).len(), 1);
    }

    #[test]
    fn an_unloaded_start_does_not_stretch_the_axis() {
        let branch = |points: &[(f64, f64)]| Branch { stage: "load".into(), points: points.to_vec() };
        let all = vec![branch(&[(1e-19, 0.4), (0.001, 0.4), (1.0, 0.3)]), branch(&[(-1e-20, 0.4)])];
        assert_eq!(without_noise(all), [branch(&[(0.001, 0.4), (1.0, 0.3)])]);
        let wide = vec![branch(&[(0.005, 0.4), (100.0, 0.3)])];
        assert_eq!(without_noise(wide.clone()), wide);
    }
}
