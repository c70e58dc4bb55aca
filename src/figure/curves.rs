//! Quantities against the logarithm of vertical stress: compression curves, k0, crush events, breakage indices
//! (Ciantia et al. 2015, Figs 10, 11).

use super::Input;
use super::axis::Axis;
use super::colour;
use super::error::Result;
use super::group::band_note;
use super::plot::Plot;
use super::run::Branch;

/// One figure: its axis and the history columns that stand in it, each with its legend.
struct Curves {
    name: &'static str,
    y: Axis,
    columns: &'static [(&'static str, &'static str)],
    factor: f64,
    /// Left out when every value is zero (no grain can break).
    skip_zero: bool,
}

/// Axis of the vertical stress.
pub fn stress_axis() -> Axis {
    Axis::log("vertical stress σ_{v} (MPa)", "sigma_v_MPa")
}

fn all() -> Vec<Curves> {
    let curves = |name, y, columns| Curves { name, y, columns, factor: 1.0, skip_zero: false };
    let percent = Axis::linear("axial strain ε_{a} (%)", "axial_strain_percent");
    vec![
        curves("compression", Axis::linear("intergranular porosity n (–)", "porosity"), &[("porosity", "")]),
        curves(
            "compression_star",
            Axis::linear("total porosity n* (–)", "porosity_star"),
            &[("porosity_star", "mass in grains"), ("porosity_star_restored", "lost mass added back")],
        ),
        curves("void_ratio", Axis::linear("void ratio e (–)", "void_ratio"), &[("void_ratio", "")]),
        Curves { factor: 100.0, ..curves("axial_strain", percent.including(&[0.0]).downwards(), &[("axial_strain", "")]) },
        curves("k0", Axis::linear("stress ratio k_{0} = σ_{h}/σ_{v} (–)", "k0").including(&[0.0]), &[("k0", "")]),
        Curves {
            skip_zero: true,
            ..curves("crush_events", Axis::linear("crush events (–)", "crush_events").including(&[0.0]), &[("crush_events", "")])
        },
        Curves {
            skip_zero: true,
            ..curves(
                "breakage_indices",
                Axis::linear("breakage index B_{r} (–)", "breakage_index").including(&[0.0]),
                &[("hardin_br", "Hardin"), ("einav_br", "Einav")],
            )
        },
    ]
}

/// The figures against stress for which the records have something to show.
pub fn plots(input: &Input) -> Result<Vec<Plot>> {
    let mut out = Vec::new();
    for curves in all() {
        out.extend(plot(input, curves)?);
    }
    Ok(out)
}

/// Stresses below this share of the largest are what rounding leaves of an unloaded specimen.
const NOISE: f64 = 1e-7;

/// Branches without points at stresses that are no stresses, which would stretch a logarithmic axis.
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
            series.extend(group.series(&name, colour::kind(nth), dash, true, |run| {
                run.branches(("sigma_v_kPa", 1e-3), (column, curves.factor)).map(without_noise)
            })?);
        }
    }
    for data in &input.data {
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
    Ok(Some(Plot { name: curves.name.into(), title, legend_title: None, x: stress_axis(), y: curves.y, series, equal: false }))
}

/// N, d50 and outcome where they are the same for everything drawn, and what a band is.
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
    fn an_unloaded_start_does_not_stretch_the_axis() {
        let branch = |points: &[(f64, f64)]| Branch { stage: "load".into(), points: points.to_vec() };
        let all = vec![branch(&[(1e-19, 0.4), (0.001, 0.4), (1.0, 0.3)]), branch(&[(-1e-20, 0.4)])];
        assert_eq!(without_noise(all), [branch(&[(0.001, 0.4), (1.0, 0.3)])]);
        let wide = vec![branch(&[(0.005, 0.4), (100.0, 0.3)])];
        assert_eq!(without_noise(wide.clone()), wide);
    }
}
