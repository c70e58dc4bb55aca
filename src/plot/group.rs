//! Runs of one scene with different seeds are drawn together: the median and the spread over the seeds.

use super::canvas::Point;
use super::colour::Colour;
use super::error::Result;
use super::plot::{Mark, Series};
use super::run::{Branch, Run, Seed, folders_apart, whole_path};
use std::path::PathBuf;

/// Number of abscissae at which a band is computed.
const GRID: usize = 90;
/// From this number of seeds on, a band spans 10-90 % of the values instead of their whole range.
const MANY: usize = 10;

/// One run, or the runs of one scene and scale with different seeds.
#[derive(Clone, Debug)]
pub struct Group {
    pub label: String,
    pub runs: Vec<Run>,
}

/// Median and spread of several curves over common abscissae.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    pub x: Vec<f64>,
    pub median: Vec<f64>,
    pub low: Vec<f64>,
    pub high: Vec<f64>,
}

/// Groups runs in the order given: runs of one scene and scale in one folder, with different seeds, are one group.
pub fn group(runs: Vec<Run>) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for run in runs {
        let fits = |g: &&mut Group| {
            let first = &g.runs[0];
            run.seed.is_some()
                && first.name == run.name
                && first.scale == run.scale
                && folder_of(first) == folder_of(&run)
                && g.runs.iter().all(|r| r.seed.is_some() && r.seed != run.seed)
        };
        match groups.iter_mut().find(fits) {
            Some(g) => g.runs.push(run),
            None => groups.push(Group { label: String::new(), runs: vec![run] }),
        }
    }
    let scales = |g: &Group| g.runs[0].scale;
    let one_scale = groups.windows(2).all(|w| scales(&w[0]) == scales(&w[1]));
    for g in &mut groups {
        g.label = label(&g.runs);
        if let (false, Some(n)) = (one_scale, g.runs[0].scale) {
            g.label += &format!(" (grain scale {n})");
        }
    }
    tell_apart(&mut groups);
    groups
}

/// The folder in which the run's own folder is.
fn folder_of(run: &Run) -> PathBuf {
    let mut path = whole_path(&run.dir);
    path.pop();
    path
}

/// Adds the folder to the labels of groups of one name and scale: that of the run, or the one in which all its runs are.
fn tell_apart(groups: &mut [Group]) {
    let scene = |g: &Group| (g.runs[0].name.clone(), g.runs[0].scale);
    let scenes: Vec<_> = groups.iter().map(scene).collect();
    let of = |g: &&mut Group| scenes.iter().filter(|other| **other == scene(g)).count() > 1;
    let twins: Vec<&mut Group> = groups.iter_mut().filter(of).collect();
    let folder = |g: &&mut Group| if let [run] = &g.runs[..] { run.dir.clone() } else { folder_of(&g.runs[0]) };
    let folders = folders_apart(&twins.iter().map(folder).collect::<Vec<_>>());
    for (g, folder) in twins.into_iter().zip(folders) {
        g.label += &format!(" [{folder}]");
    }
}

fn label(runs: &[Run]) -> String {
    if let [run] = runs {
        return run.label();
    }
    let mut seeds: Vec<Seed> = runs.iter().filter_map(|r| r.seed).collect();
    seeds.sort();
    let twins = seeds.iter().all(|s| s.packing == s.strength);
    let follow = seeds.windows(2).all(|w| w[1].packing == w[0].packing.wrapping_add(1));
    let name = &runs[0].name;
    match (seeds.first(), seeds.last()) {
        (Some(a), Some(b)) if twins && follow => {
            format!("{name}, seeds {}–{}", a.packing, b.packing)
        }
        _ if twins && seeds.len() <= 4 => {
            let list: Vec<String> = seeds.iter().map(|s| s.packing.to_string()).collect();
            format!("{name}, seeds {}", list.join(", "))
        }
        _ => format!("{name}, {} seeds", runs.len()),
    }
}

/// Note for the title that says what a band spans; `None` without bands.
pub fn band_note(groups: &[Group]) -> Option<&'static str> {
    let most = groups.iter().map(|g| g.runs.len()).max().unwrap_or(0);
    match most {
        0 | 1 => None,
        n if n < MANY => Some("line: median, band: range"),
        _ => Some("line: median, band: 10–90 %"),
    }
}

impl Group {
    /// The group's series of one quantity: a line for one run, else a band for each branch that all
    /// runs of the group have.
    pub fn series(
        &self,
        name: &str,
        colour: Colour,
        dash: &'static [f64],
        log_x: bool,
        branches: impl Fn(&Run) -> Result<Vec<Branch>>,
    ) -> Result<Vec<Series>> {
        let mut runs = Vec::new();
        for run in &self.runs {
            runs.push(branches(run)?);
        }
        runs.retain(|b| !b.is_empty());
        if let [one] = &runs[..] {
            return Ok(vec![Series::line(name, colour, dash, joined(one))]);
        }
        let common =
            (0..runs.iter().map(Vec::len).min().unwrap_or(0)).take_while(|i| runs.iter().all(|r| r[*i].stage == runs[0][*i].stage));
        let mut out = Vec::new();
        for i in common {
            let curves: Vec<&[Point]> = runs.iter().map(|r| &r[i].points[..]).collect();
            if let Some(band) = band(&curves, log_x) {
                out.push(Series {
                    label: out.is_empty().then(|| name.to_string()),
                    name: name.into(),
                    colour,
                    x: band.x,
                    y: band.median,
                    mark: Mark::Band { low: band.low, high: band.high, dash },
                });
            }
        }
        Ok(out)
    }
}

/// The branches as one line in file order; a point shared by two branches is kept once.
fn joined(branches: &[Branch]) -> Vec<Point> {
    let mut out: Vec<Point> = branches.iter().flat_map(|b| b.points.clone()).collect();
    out.dedup();
    out
}

/// Median and spread of curves over the range of abscissae that all curves cover; `None` if there
/// is no such range.
pub fn band(curves: &[&[Point]], log_x: bool) -> Option<Band> {
    let curves: Vec<Vec<Point>> = curves.iter().map(|c| rising(c, log_x)).collect();
    let lo = curves.iter().map(|c| c.first().map_or(f64::INFINITY, |p| p.0)).fold(f64::NEG_INFINITY, f64::max);
    let hi = curves.iter().map(|c| c.last().map_or(f64::NEG_INFINITY, |p| p.0)).fold(f64::INFINITY, f64::min);
    if curves.is_empty() || !(lo.is_finite() && hi.is_finite() && lo < hi) {
        return None;
    }
    let mut out = Band { x: Vec::new(), median: Vec::new(), low: Vec::new(), high: Vec::new() };
    for i in 0..GRID {
        let x = lo + (hi - lo) * i as f64 / (GRID - 1) as f64;
        let [low, median, high] = edges(curves.iter().map(|c| interpolate(c, x)).collect());
        out.x.push(if log_x { x.exp() } else { x });
        out.median.push(median);
        out.low.push(low);
        out.high.push(high);
    }
    Some(out)
}

/// Lower edge, median and upper edge of a band at the values of several curves.
pub(super) fn edges(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    let spread = if values.len() < MANY { 0.0 } else { 0.1 };
    [spread, 0.5, 1.0 - spread].map(|q| ::table::quantile(&values, q))
}

/// The finite points in rising order of x, or of ln x with `log_x`; of several points at one x, the
/// first.
pub(super) fn rising(points: &[Point], log_x: bool) -> Vec<Point> {
    let mut out: Vec<Point> =
        points.iter().map(|p| (if log_x { p.0.ln() } else { p.0 }, p.1)).filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
    out.sort_by(|a, b| a.0.total_cmp(&b.0));
    out.dedup_by(|b, a| b.0 == a.0);
    out
}

/// Linear interpolation between points with rising x, constant before the first and after the last;
/// NaN without points.
pub fn interpolate(points: &[Point], x: f64) -> f64 {
    let i = points.partition_point(|p| p.0 < x);
    match (i.checked_sub(1).and_then(|j| points.get(j)), points.get(i)) {
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0),
        (Some(p), None) | (None, Some(p)) => p.1,
        (None, None) => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(name: &str, seed: Option<u64>) -> Run {
        Run {
            dir: PathBuf::from(format!("runs/{name}-{seed:?}")),
            name: name.into(),
            seed: seed.map(|n| Seed { packing: n, strength: n }),
            scale: Some(2.0),
            d50_mm: None,
            grains: None,
            events: None,
            points: None,
            volume: None,
            least_void_ratio: 0.15,
            asked: Vec::new(),
            stages: Vec::new(),
            material: None,
            plane_strain: false,
            history: None,
        }
    }

    fn labels(runs: Vec<Run>) -> Vec<String> {
        group(runs).into_iter().map(|g| g.label).collect()
    }

    #[test]
    fn seeds_of_one_scene_are_one_group() {
        let runs = [3, 1, 2].map(|s| run("H-C-2", Some(s))).to_vec();
        assert_eq!(labels(runs), ["H-C-2, seeds 1–3"]);
        let runs = [1, 5].map(|s| run("H-C-2", Some(s)));
        let mut runs = runs.to_vec();
        runs.insert(1, run("H-V-2", Some(1)));
        assert_eq!(labels(runs), ["H-C-2, seeds 1, 5", "H-V-2, seed 1"]);
    }

    #[test]
    fn the_same_seed_twice_is_no_band() {
        let runs = vec![run("a", Some(1)), run("a", Some(1)), run("b", None)];
        let labels = labels(runs);
        assert_eq!(labels.len(), 3);
        assert_eq!(labels[0], "a, seed 1 [a-Some(1)]");
    }

    #[test]
    fn runs_of_two_folders_are_two_groups_with_the_folders_names() {
        let at = |folder: &str, seed: u64| Run { dir: format!("runs/{folder}/seed-{seed}").into(), ..run("a", Some(seed)) };
        let runs = vec![at("loose", 1), at("loose", 2), at("dense", 1), at("dense", 2)];
        assert_eq!(labels(runs), ["a, seeds 1–2 [loose]", "a, seeds 1–2 [dense]"]);
        let runs = vec![at("loose", 1), at("loose", 2), at("dense", 2), at("dense", 3)];
        assert_eq!(labels(runs), ["a, seeds 1–2 [loose]", "a, seeds 2–3 [dense]"]);
        assert_eq!(labels(vec![at("loose", 1), at("dense", 1)]), ["a, seed 1 [loose/seed-1]", "a, seed 1 [dense/seed-1]"]);
    }

    #[test]
    fn different_scales_stand_in_the_label() {
        let mut other = run("H-C", Some(1));
        other.scale = Some(1.0);
        let labels = labels(vec![run("H-C", Some(1)), other]);
        assert_eq!(labels, ["H-C, seed 1 (grain scale 2)", "H-C, seed 1 (grain scale 1)"]);
    }

    #[test]
    fn a_band_holds_every_curve_and_its_median() {
        let curves: Vec<Vec<Point>> =
            [1.0, 2.0, 6.0].iter().map(|k| (1..=10).map(|i| (f64::from(i), k * f64::from(i))).collect()).collect();
        let views: Vec<&[Point]> = curves.iter().map(|c| &c[..]).collect();
        let b = band(&views, false).expect("band");
        assert_eq!((b.x[0], b.x[GRID - 1]), (1.0, 10.0));
        assert!((b.median[GRID - 1] - 20.0).abs() < 1e-9);
        assert!((b.low[GRID - 1] - 10.0).abs() < 1e-9 && (b.high[GRID - 1] - 60.0).abs() < 1e-9);
        let many: Vec<&[Point]> = (0..11).map(|i| &curves[usize::from(i == 10) * 2][..]).collect();
        let b = band(&many, true).expect("band");
        assert!(b.high[40] < b.x[40] * 1.05, "one outlier of eleven is outside 10-90 %");
    }

    #[test]
    fn curves_without_a_common_range_have_no_band() {
        let (a, b) = ([(1.0, 1.0), (2.0, 1.0)], [(3.0, 1.0), (4.0, 1.0)]);
        assert_eq!(band(&[&a, &b], false), None);
        assert_eq!(band(&[&a, &[]], false), None);
        assert_eq!(band(&[], true), None);
    }

    #[test]
    fn a_curve_is_read_between_its_points() {
        let p = [(0.0, 0.0), (1.0, 10.0)];
        assert_eq!(interpolate(&p, 0.25), 2.5);
        assert_eq!(interpolate(&p, 7.0), 10.0);
        assert!(interpolate(&[], 1.0).is_nan());
    }

    #[test]
    fn seeds_with_different_branches_share_what_they_have() {
        let g = Group { label: "g".into(), runs: vec![run("a", Some(1)), run("a", Some(2))] };
        let branch = |stage: &str| Branch { stage: stage.into(), points: vec![(1.0, 1.0), (2.0, 2.0)] };
        let series = g.series("g", Colour(0, 0, 0), &[], true, |r| {
            let mut b = vec![branch("load")];
            if r.seed.map(|s| s.packing) == Some(2) {
                b.push(branch("unload"));
            }
            Ok(b)
        });
        assert_eq!(series.expect("series").len(), 1);
    }
}
