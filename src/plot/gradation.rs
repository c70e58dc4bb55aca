//! Evolving gradation: per cent passing by mass against log size, coarse on the right (Ciantia et al. 2015, Fig. 10).

use super::Input;
use super::axis::{Axis, significant};
use super::canvas::Point;
use super::colour;
use super::curves::title;
use super::error::Result;
use super::group::{Group, interpolate};
use super::plot::{Plot, Series};
use super::run::{Branch, Run};
use super::table::Table;

/// At most this many gradations of one run are drawn.
const MOST: usize = 7;
/// Gradations closer than this (largest difference, per cent) are drawn once.
const SAME: f64 = 1.0;

/// The quantity that orders and labels the gradations of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum By {
    /// Vertical stress, MPa: a specimen of grains that is loaded by stress.
    Stress,
    /// Axial strain: triaxial tests, and grains in a continuum, whose platens move at a given
    /// speed.
    Strain,
    /// Time, s: a free scene.
    Time,
}

impl By {
    fn legend(self) -> &'static str {
        match self {
            By::Stress => "σ_{v} (MPa)",
            By::Strain => "axial strain (%)",
            By::Time => "time (s)",
        }
    }

    /// A value as the legend shows it.
    fn shown(self, value: f64) -> String {
        significant(if self == By::Strain { 100.0 * value } else { value }, 3)
    }

    fn with_unit(self, value: f64) -> String {
        match self {
            By::Stress => format!("{} MPa", significant(value, 2)),
            By::Strain => format!("{} % strain", significant(100.0 * value, 2)),
            By::Time => format!("{} s", significant(value, 2)),
        }
    }
}

/// The gradation of one record.
#[derive(Clone, Debug, PartialEq)]
struct Gradation {
    by: By,
    /// Stress, strain or time of the record.
    level: f64,
    /// Recorded while the specimen was unloaded or loaded again.
    unloaded: bool,
    /// Size in mm and per cent passing.
    points: Vec<Point>,
}

/// The gradations of one run, or the first and last gradation of each group of runs.
pub fn plot(input: &Input) -> Result<Option<Plot>> {
    let mut series = Vec::new();
    let one = match &input.groups[..] {
        [g] if g.runs.len() == 1 => Some(&g.runs[0]),
        _ => None,
    };
    let mut heading = title(input);
    let mut by = By::Stress;
    if let Some(run) = one {
        let all = read(run)?;
        by = all.first().map_or(By::Stress, |g| g.by);
        let chosen = choose(&all, &asked(run, by), &stages(run, by));
        series.extend(evolution(&chosen));
        heading.insert(0, run.label());
        let loading = loaded(&all).len();
        if loading > chosen.len() {
            heading.push(format!("{} more in gsd.csv", loading - chosen.len()));
        }
        if run.column("platen_work_J")?.is_some() && run.points != Some(0) {
            heading.push("grains only, points not counted".into());
        }
        if all.iter().any(|g| g.unloaded) {
            heading.push("unloading stages not shown".into());
        }
    } else {
        let same = same_start(&input.groups)?;
        for (i, group) in input.groups.iter().enumerate() {
            series.extend(ends(group, i, same.is_none())?);
        }
        if let Some(start) = same {
            let name = format!("all: {}", start.by.with_unit(start.level));
            series.push(Series::line(&name, colour::INK, colour::dash(1), start.points));
        }
    }
    let simulated = !series.is_empty();
    for data in &input.data {
        series.extend(data.gradation()?);
    }
    if series.is_empty() {
        return Ok(None);
    }
    let legend_title = (one.is_some() && simulated).then(|| by.legend().to_string());
    Ok(Some(Plot {
        name: "gradation".into(),
        title: heading,
        legend_title,
        x: Axis::log("grain size (mm)", "diameter_mm"),
        y: Axis::linear("passing by mass (%)", "passing_percent").including(&[0.0, 100.0]),
        series,
        equal: false,
    }))
}

/// Stresses in MPa, or axial strains, at which the scene asked for gradations.
fn asked(run: &Run, by: By) -> Vec<f64> {
    run.asked.iter().map(|v| if by == By::Stress { v * 1e-3 } else { *v }).collect()
}

/// Stresses in MPa at which stages of loading start and end; none if gradations are not ordered by
/// stress.
fn stages(run: &Run, by: By) -> Vec<f64> {
    if by == By::Stress { run.stages.iter().map(|v| v * 1e-3).collect() } else { Vec::new() }
}

/// Series of the chosen gradations of one run, in their order, from dark to light.
fn evolution(chosen: &[(String, &Gradation)]) -> Vec<Series> {
    let last = chosen.len().saturating_sub(1).max(1) as f64;
    chosen
        .iter()
        .enumerate()
        .map(|(i, (name, g))| {
            let tone = colour::sequence(i as f64 / last * 0.92);
            Series::line(name, tone, colour::dash(i), g.points.clone())
        })
        .collect()
}

/// The first gradation, if there are several groups and all their runs start with the same one
/// (within [`SAME`]).
fn same_start(groups: &[Group]) -> Result<Option<Gradation>> {
    let mut start: Option<Gradation> = None;
    for run in groups.iter().flat_map(|group| &group.runs) {
        let Some(own) = read(run)?.into_iter().next() else { continue };
        if start.as_ref().is_some_and(|start| difference(start, &own) > SAME) {
            return Ok(None);
        }
        start.get_or_insert(own);
    }
    Ok(start.filter(|_| groups.len() > 1))
}

/// Series of the last gradation of a group and, with `with_first`, of the first one (another dash).
fn ends(group: &Group, i: usize, with_first: bool) -> Result<Vec<Series>> {
    let (mut reached, mut first, mut by) = (f64::NAN, f64::NAN, By::Stress);
    for run in &group.runs {
        if let (Some(a), Some(b)) = (read(run)?.first(), loaded(&read(run)?).last()) {
            (first, by) = (a.level, a.by);
            reached = reached.max(b.level);
        }
    }
    let tone = colour::kind(i);
    let name = |level| format!("{}: {}", group.label, by.with_unit(level));
    let branch = |g: Option<&Gradation>| {
        let points = g.map(|g| g.points.clone());
        points.into_iter().map(|points| Branch { stage: String::new(), points })
    };
    let dash = |k| colour::dash(2 * i + k);
    let mut out =
        group.series(&name(reached), tone, dash(0), true, |run| Ok(branch(loaded(&read(run)?).last().copied()).collect()))?;
    if !with_first {
        return Ok(out);
    }
    out.extend(group.series(&name(first), tone, dash(1), true, |run| Ok(branch(read(run)?.first()).collect()))?);
    Ok(out)
}

/// The records of first loading: those at a larger stress (strain, time) than any before.
fn loaded(all: &[Gradation]) -> Vec<&Gradation> {
    let mut most = f64::NEG_INFINITY;
    let rising = all.iter().filter(|g| {
        let higher = g.level > most;
        most = most.max(g.level);
        higher
    });
    rising.collect()
}

/// Largest relative distance of a record from the requested value for which the record was written.
/// A record comes with the first step past the requested value, or with the last step before it
/// where the stress falls because grains break.
const NEAR: f64 = 0.05;

/// Chooses the gradations to draw, with their labels: the first, the last and every requested one.
/// The label is the requested value or, at the end of a stage of loading, the stress of the stage.
/// If no record is a requested one, the gradations that differ most are chosen.
fn choose<'a>(all: &'a [Gradation], asked: &[f64], stages: &[f64]) -> Vec<(String, &'a Gradation)> {
    let rising = loaded(all);
    let wanted = |g: &Gradation| nearest(g.level, asked);
    let label = |g: &Gradation| g.by.shown(wanted(g).or_else(|| nearest(g.level, stages)).unwrap_or(g.level));
    if !rising.iter().any(|g| wanted(g).is_some()) {
        return most_different(rising).into_iter().map(|g| (label(g), g)).collect();
    }
    let last = rising.len() - 1;
    let kept = rising.iter().enumerate().filter(|(i, g)| *i == 0 || *i == last || wanted(g).is_some());
    let mut chosen: Vec<(String, &Gradation)> = Vec::new();
    for next in kept.map(|(_, g)| (label(g), *g)) {
        // of two records with one label, the later one is kept
        if chosen.last().is_some_and(|before| before.0 == next.0) {
            chosen.pop();
        }
        chosen.push(next);
    }
    chosen
}

/// The nearest of the values, if its relative distance from `level` is below [`NEAR`].
fn nearest(level: f64, values: &[f64]) -> Option<f64> {
    let off = |a: &f64| (level / a - 1.0).abs();
    values.iter().copied().filter(|a| off(a) < NEAR).min_by(|a, b| off(a).total_cmp(&off(b)))
}

/// The first, the last, and further gradations up to [`MOST`] in all: each further one differs most
/// from those already chosen, and by more than [`SAME`].
fn most_different(all: Vec<&Gradation>) -> Vec<&Gradation> {
    let Some(last) = all.len().checked_sub(1) else {
        return Vec::new();
    };
    let mut chosen = vec![0];
    if last > 0 {
        chosen.push(last);
    }
    while chosen.len() < MOST {
        let distance = |i: usize| {
            let to = chosen.iter().map(|j| difference(all[i], all[*j]));
            to.fold(f64::INFINITY, f64::min)
        };
        let best = (0..all.len()).map(|i| (distance(i), i)).max_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((d, i)) if d > SAME && d.is_finite() => chosen.push(i),
            _ => break,
        }
    }
    chosen.sort_unstable();
    chosen.into_iter().map(|i| all[i]).collect()
}

/// Largest difference in per cent passing at any size.
fn difference(a: &Gradation, b: &Gradation) -> f64 {
    let one_way = |a: &Gradation, b: &Gradation| {
        let gaps = a.points.iter().map(|p| (p.1 - interpolate(&b.points, p.0)).abs());
        gaps.filter(|g| g.is_finite()).fold(0.0, f64::max)
    };
    one_way(a, b).max(one_way(b, a))
}

/// The gradations of a run in file order, without the sizes smaller or larger than all grains.
fn read(run: &Run) -> Result<Vec<Gradation>> {
    let Some(table) = Table::read_if_there(&run.dir.join("gsd.csv"))? else {
        return Ok(Vec::new());
    };
    let steps = table.numbers("step")?;
    let stress = table.numbers("sigma_v_kPa")?;
    let in_continuum = table.has("time_s");
    let by = match run.history.as_ref() {
        Some(h) if in_continuum && h.has("front_mm") => By::Time,
        Some(_) if (in_continuum || run.is_triaxial()) && table.has("axial_strain") => By::Strain,
        _ => By::Stress,
    };
    let level = match by {
        By::Stress => stress.iter().map(|s| s * 1e-3).collect(),
        By::Strain => table.numbers("axial_strain")?,
        By::Time => table.numbers("time_s")?,
    };
    let stages = if table.has("stage") { table.texts("stage")? } else { Vec::new() };
    let unloaded = |i: usize| stages.get(i).is_some_and(|s| ["unload", "reload"].contains(s));
    let (size, passing) = (table.numbers("diameter_mm")?, table.numbers("passing_percent")?);
    let mut out: Vec<Gradation> = Vec::new();
    let mut last = f64::NAN;
    // a test of grains in a continuum starts with the settling stage, and breakages in that stage
    // count
    let start = if in_continuum { None } else { run.loading_step()? };
    for i in 0..table.len() {
        if start.is_some_and(|s| steps[i] < s) {
            continue;
        }
        if !(size[i] > 0.0 && passing[i].is_finite() && level[i].is_finite()) {
            continue;
        }
        let new = steps[i] != last;
        last = steps[i];
        let point = (size[i], passing[i]);
        match out.last_mut() {
            Some(g) if !new => g.points.push(point),
            _ => out.push(Gradation { by, level: level[i], unloaded: unloaded(i), points: vec![point] }),
        }
    }
    for g in &mut out {
        g.points.sort_by(|a, b| a.0.total_cmp(&b.0));
        trim(&mut g.points);
    }
    Ok(out)
}

/// Removes points at 0 % and at 100 % so that one of each is left.
fn trim(points: &mut Vec<Point>) {
    let full = points.iter().position(|p| p.1 >= 100.0 - 1e-9);
    points.truncate(full.map_or(points.len(), |i| i + 1));
    let zeros = points.iter().take_while(|p| p.1 <= 1e-9).count();
    points.drain(..zeros.saturating_sub(1));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradation(sigma: f64, at_one: f64) -> Gradation {
        Gradation { by: By::Stress, level: sigma, unloaded: false, points: vec![(0.1, 0.0), (1.0, at_one), (10.0, 100.0)] }
    }

    #[test]
    fn first_last_and_the_most_different_are_chosen() {
        let all: Vec<Gradation> = (0..40).map(|i| gradation(0.1 * f64::from(i + 1), 2.0 * f64::from(i))).collect();
        let chosen = most_different(loaded(&all));
        assert_eq!(chosen.len(), MOST);
        assert_eq!((chosen[0].level, chosen[MOST - 1].level), (all[0].level, all[39].level));
        assert!(chosen.windows(2).all(|w| w[1].points[1].1 - w[0].points[1].1 > 5.0));
    }

    #[test]
    fn equal_gradations_and_unloading_are_drawn_once() {
        let mut all: Vec<Gradation> = (1..6).map(|i| gradation(f64::from(i), 20.0)).collect();
        all.push(gradation(0.5, 90.0));
        let chosen = most_different(loaded(&all));
        let stresses: Vec<f64> = chosen.iter().map(|g| g.level).collect();
        assert_eq!(stresses, [1.0, 5.0]);
        assert!(choose(&[], &[], &[]).is_empty());
        assert_eq!(choose(&all[..1], &[], &[]).len(), 1);
    }

    #[test]
    fn what_was_asked_for_is_drawn_by_the_value_asked() {
        let all: Vec<Gradation> = [0.005, 0.992, 2.0, 3.02, 4.5].map(|s| gradation(s, 10.0)).to_vec();
        let labels = |asked: &[f64]| choose(&all, asked, &[4.6]).into_iter().map(|(label, _)| label).collect::<Vec<_>>();
        assert_eq!(labels(&[1.0, 3.0, 9.0]), ["0.005", "1", "3", "4.6"]);
        assert_eq!(labels(&[2.0, 2.05, 4.5]), ["0.005", "2", "4.5"], "the nearest value");
        assert_eq!(labels(&[]), ["0.005", "4.6"], "all alike: the first and the last");
        let twice: Vec<Gradation> = [0.005, 0.98, 1.0].map(|s| gradation(s, 10.0)).to_vec();
        assert_eq!(choose(&twice, &[1.0], &[]).iter().map(|c| c.1.level).collect::<Vec<_>>(), [0.005, 1.0], "one for each value");
        let mut sheared = all.clone();
        sheared.iter_mut().enumerate().for_each(|(k, g)| (g.by, g.level) = (By::Strain, 0.0502 * k as f64));
        let chosen = choose(&sheared, &[0.05, 0.1], &[]);
        assert_eq!(chosen.iter().map(|c| c.0.as_str()).collect::<Vec<_>>(), ["0", "5", "10", "20.1"]);
    }

    #[test]
    fn ends_at_zero_and_hundred_are_kept_once() {
        let mut p = vec![(0.1, 0.0), (0.2, 0.0), (1.0, 50.0), (5.0, 100.0), (9.0, 100.0)];
        trim(&mut p);
        assert_eq!(p, [(0.2, 0.0), (1.0, 50.0), (5.0, 100.0)]);
    }
}
