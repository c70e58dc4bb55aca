//! Deviatoric against mean stress on equal scales, with the line of the K0 reached at the largest stress
//! (Ciantia et al. 2015, Fig. 11).

use super::Input;
use super::axis::{Axis, significant};
use super::colour;
use super::curves::title;
use super::error::Result;
use super::plot::{Plot, Series, ray};

/// Largest number of groups for which K0 lines are drawn; more lines would only hide each other.
const RAYS: usize = 3;
/// End of a K0 line over the largest mean stress: above 1, so that the line can be seen beyond the
/// path.
const BEYOND: f64 = 1.07;

/// The stress path, if the records have one.
pub fn plot(input: &Input) -> Result<Option<Plot>> {
    let mut paths = Vec::new();
    let mut rays = Vec::new();
    let single = input.groups.len() == 1;
    for (i, group) in input.groups.iter().enumerate() {
        let series = group
            .series(&group.label, colour::kind(i), colour::dash(i), false, |run| run.branches(("p_kPa", 1e-3), ("q_kPa", 1e-3)))?;
        // the stress ratio that a triaxial test reaches is not k0; in plane strain p and q do not give it
        let at_rest = !group.runs.iter().any(|run| run.is_triaxial() || run.plane_strain);
        if let Some(mut line) = k0_line(&series).filter(|_| at_rest) {
            if !single {
                line.colour = colour::kind(i);
                line.label = line.label.map(|l| format!("{l} ({})", group.runs[0].name));
            }
            rays.push(line);
        }
        paths.extend(series);
    }
    if paths.is_empty() {
        return Ok(None);
    }
    if input.groups.len() <= RAYS {
        paths.splice(0..0, rays);
    }
    // with the stress across the plane, or without one (p_kPa of history.csv)
    let flat = input.groups.iter().flat_map(|group| &group.runs).any(|run| run.plane_strain);
    let mean = if flat { "mean stress p (MPa)" } else { "mean stress p = (σ_{v} + 2σ_{h})/3 (MPa)" };
    Ok(Some(Plot {
        name: "stress_path".into(),
        title: title(input),
        legend_title: None,
        x: Axis::linear(mean, "p_MPa").including(&[0.0]),
        y: Axis::linear("q = σ_{v} − σ_{h} (MPa)", "q_MPa").including(&[0.0]),
        series: paths,
        equal: true,
    }))
}

/// The line through the origin and the state of the largest mean stress.
fn k0_line(series: &[Series]) -> Option<Series> {
    let points = series.iter().flat_map(|s| s.x.iter().zip(&s.y));
    let (p, q) = points.max_by(|a, b| a.0.total_cmp(b.0))?;
    let (k0, sigma_v) = state(*p, *q)?;
    let name = format!("k_{{0}} = {} at σ_{{v}} = {} MPa", significant(k0, 2), significant(sigma_v, 2));
    Some(ray(&name, q / p, BEYOND * p))
}

/// k0 and vertical stress of a state with mean stress p and deviatoric stress q.
fn state(p: f64, q: f64) -> Option<(f64, f64)> {
    let (vertical, horizontal) = (p + 2.0 * q / 3.0, p - q / 3.0);
    (p > 0.0 && vertical > 0.0).then_some((horizontal / vertical, vertical))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn k0_comes_back_from_p_and_q() {
        let (v, h) = (5.0, 3.1);
        let (k0, sigma) = state((v + 2.0 * h) / 3.0, v - h).expect("state");
        assert!((k0 - h / v).abs() < 1e-12 && (sigma - v).abs() < 1e-12);
        assert_eq!(state(0.0, 0.0), None);
    }

    #[test]
    fn the_line_passes_through_the_largest_state() {
        let path = Series::line("a", colour::GREY, &[], vec![(0.1, 0.05), (3.0, 1.2), (1.0, -0.1)]);
        let line = k0_line(&[path]).expect("line");
        assert!((line.y[1] / line.x[1] - 1.2 / 3.0).abs() < 1e-12 && line.x[1] > 3.0);
        assert_eq!(line.label.as_deref(), Some("k_{0} = 0.68 at σ_{v} = 3.8 MPa"));
    }
}
