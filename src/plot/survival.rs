//! Strength of the grains that broke: the share of these grains that had not broken yet, against
//! the force over the diameter squared.

use super::Input;
use super::axis::Axis;
use super::colour;
use super::curves::title;
use super::error::Result;
use super::plot::{Mark, Plot, Series, Shape};
use super::run::Run;
use super::table::Table;

/// Fewer broken grains than this make no curve.
const FEWEST: usize = 5;

/// The figure of survival of each run's broken grains, with the grains of the start apart from
/// their fragments; `None` without enough broken grains.
pub fn plot(input: &Input) -> Result<Option<Plot>> {
    let mut series = Vec::new();
    let runs = input.groups.iter().flat_map(|g| &g.runs);
    for (i, run) in runs.enumerate() {
        let [first, later] = strengths(run)?;
        for (j, (values, what)) in [(first, "grains of the start"), (later, "fragments")].into_iter().enumerate() {
            if values.len() < FEWEST {
                continue;
            }
            let name = format!("{}: {} {what}", run.label(), values.len());
            let (x, y) = survival(values).into_iter().unzip();
            let colour = colour::kind(2 * i + j);
            series.push(Series { label: Some(name.clone()), name, colour, mark: Mark::Symbols(Shape::nth(2 * i + j)), x, y });
        }
    }
    if series.is_empty() {
        return Ok(None);
    }
    let mut title = title(input);
    title.push("broken grains only".into());
    Ok(Some(Plot {
        name: "survival".into(),
        title,
        legend_title: None,
        x: Axis::log("largest force over diameter squared F/d² (MPa)", "force_over_d2_MPa"),
        y: Axis::linear("share not yet broken (–)", "survival").including(&[0.0, 1.0]),
        series,
        equal: false,
    }))
}

/// F/d², MPa, at each breakage of a run: of grains of the start, and of fragments.
fn strengths(run: &Run) -> Result<[Vec<f64>; 2]> {
    let mut out = [Vec::new(), Vec::new()];
    let Some(table) = Table::read_if_there(&run.dir.join("breakage.csv"))? else { return Ok(out) };
    if !["generation", "force_N", "diameter_mm"].iter().all(|c| table.has(c)) {
        return Ok(out);
    }
    let (generation, force, d) = (table.numbers("generation")?, table.numbers("force_N")?, table.numbers("diameter_mm")?);
    for i in 0..force.len() {
        // N over mm² is MPa
        let strength = force[i] / (d[i] * d[i]);
        if strength.is_finite() && strength > 0.0 {
            out[usize::from(generation[i] > 0.0)].push(strength);
        }
    }
    Ok(out)
}

/// Values in rising order, each with the share of values above it: 1 − (k − 1/2)/n for the k-th of
/// n.
fn survival(mut values: Vec<f64>) -> Vec<(f64, f64)> {
    values.sort_by(f64::total_cmp);
    let n = values.len() as f64;
    values.into_iter().enumerate().map(|(k, v)| (v, 1.0 - (k as f64 + 0.5) / n)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_fall_from_near_one_to_near_none() {
        assert_eq!(survival(vec![3.0, 1.0]), [(1.0, 0.75), (3.0, 0.25)]);
    }
}
