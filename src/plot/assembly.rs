//! Figures of free scenes against time: energies, and positions of the grains that moved most.

use super::Input;
use super::axis::Axis;
use super::colour;
use super::energy;
use super::error::Result;
use super::plot::{Plot, Series};
use super::run::Run;
use super::table::Table;

/// At most this many grains are drawn.
const MOST: usize = 6;
const TERMS: [(&str, &str); 3] =
    [("kinetic_energy_J", "kinetic"), ("stored_energy_J", "stored in contacts"), ("potential_energy_J", "potential")];

/// The figures of a free scene; none for other runs, and none for several runs.
pub fn plots(input: &Input) -> Result<Vec<Plot>> {
    let [group] = &input.groups[..] else {
        return Ok(Vec::new());
    };
    let [run] = &group.runs[..] else {
        return Ok(Vec::new());
    };
    let mut out = Vec::new();
    out.extend(energies(run)?);
    out.extend(tracks(run)?);
    Ok(out)
}

fn time_axis() -> Axis {
    Axis::linear("time (s)", "time_s").including(&[0.0])
}

fn energies(run: &Run) -> Result<Option<Plot>> {
    let Some(time) = run.column("time_s")? else {
        return Ok(None);
    };
    let mut terms = Vec::new();
    for (column, name) in TERMS {
        terms.extend(run.column(column)?.map(|values| (name, values)));
    }
    let all = terms.iter().flat_map(|t| &t.1).filter(|v| v.is_finite());
    let largest = all.map(|v| v.abs()).fold(0.0, f64::max);
    if largest <= 0.0 {
        return Ok(None);
    }
    let (unit, factor) = energy::unit(largest);
    let line = |(i, (name, values)): (usize, (&str, Vec<f64>))| {
        let points = time.iter().copied().zip(values.into_iter().map(|v| v * factor)).collect();
        Series::line(name, colour::kind(i), colour::dash(i), points)
    };
    Ok(Some(Plot {
        name: "energy_time".into(),
        title: vec![run.label()],
        legend_title: None,
        x: time_axis(),
        y: Axis::linear(&format!("energy ({unit})"), &format!("energy_{unit}")).including(&[0.0]),
        series: terms.into_iter().enumerate().map(line).collect(),
        equal: false,
    }))
}

/// Positions against time along the one axis (x, y or z) with the longest travel of a grain, for
/// the [`MOST`] grains that travel farthest along that axis.
fn tracks(run: &Run) -> Result<Option<Plot>> {
    let Some(table) = Table::read_if_there(&run.dir.join("tracks.csv"))? else {
        return Ok(None);
    };
    let (time, grain) = (table.numbers("time_s")?, table.numbers("grain")?);
    let mut best: Option<(f64, &str, Vec<Track>)> = None;
    for axis in ["x", "y", "z"] {
        let tracks = collect(&time, &grain, &table.numbers(&format!("{axis}_m"))?);
        let most = tracks.iter().map(Track::travel).fold(0.0, f64::max);
        if best.as_ref().is_none_or(|b| most > b.0) {
            best = Some((most, axis, tracks));
        }
    }
    let Some((_, axis, mut tracks)) = best.filter(|b| !b.2.is_empty()) else {
        return Ok(None);
    };
    tracks.sort_by(|a, b| b.travel().total_cmp(&a.travel()));
    tracks.truncate(MOST);
    tracks.sort_by(|a, b| a.grain.total_cmp(&b.grain));
    let line = |(i, t): (usize, Track)| {
        let name = format!("grain {}", t.grain);
        Series::line(&name, colour::kind(i), colour::dash(i), t.points)
    };
    Ok(Some(Plot {
        name: "tracks".into(),
        title: vec![run.label()],
        legend_title: None,
        x: time_axis(),
        y: Axis::linear(&format!("position {axis} (mm)"), &format!("{axis}_mm")),
        series: tracks.into_iter().enumerate().map(line).collect(),
        equal: false,
    }))
}

struct Track {
    grain: f64,
    points: Vec<(f64, f64)>,
}

impl Track {
    fn travel(&self) -> f64 {
        let values = || self.points.iter().map(|p| p.1).filter(|v| v.is_finite());
        let high = values().fold(f64::NEG_INFINITY, f64::max);
        let low = values().fold(f64::INFINITY, f64::min);
        if high >= low { high - low } else { 0.0 }
    }
}

/// Separates the records into one track for each grain: time and position, mm.
fn collect(time: &[f64], grain: &[f64], position_m: &[f64]) -> Vec<Track> {
    let mut place = std::collections::HashMap::new();
    let mut out: Vec<Track> = Vec::new();
    for ((t, g), p) in time.iter().zip(grain).zip(position_m) {
        let at = *place.entry(g.to_bits()).or_insert_with(|| {
            out.push(Track { grain: *g, points: Vec::new() });
            out.len() - 1
        });
        out[at].points.push((*t, p * 1e3));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tracks_are_separated_by_grain() {
        let t = collect(&[0.0, 0.0, 1.0, 1.0], &[3.0, 5.0, 3.0, 5.0], &[1.0, 2.0, 1.5, 2.0]);
        assert_eq!(t.len(), 2);
        assert_eq!(t[0].points, [(0.0, 1000.0), (1.0, 1500.0)]);
        assert_eq!((t[0].travel(), t[1].travel()), (500.0, 0.0));
    }
}
