//! Figures of a calibration: force against diameter (as Figs 7, 8 of Ciantia et al. 2015), survival of each size, and
//! measured against fitted quantiles.

use super::Calibration;
use super::area::Model;
use super::classes::survival;
use super::data::Grain;
use super::fit::Fit;
use super::spread::Law;
use laboratory::error::Result;
use plot::{Drawn, Graph, Look, Quantity, Tone, significant};
use std::path::{Path, PathBuf};

/// Names of the figures.
pub const NAMES: [&str; 3] = ["force_vs_diameter", "survival", "quantiles"];
/// Largest number of sizes in the survival figure.
const SIZES: usize = 6;
const POINTS: u32 = 80;

/// Draws all figures into `out`.
pub fn draw(c: &Calibration, out: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for graph in [forces(c), survivals(c), quantiles(c)] {
        files.extend(graph.draw(out)?);
    }
    Ok(files)
}

fn title(c: &Calibration) -> Vec<String> {
    let file = c.data.path.file_name().unwrap_or_default().to_string_lossy();
    let censored = c.data.grains.len() - c.data.broken();
    let mut out = vec![file.into_owned(), format!("{} grains", c.data.grains.len())];
    if censored > 0 {
        out.push(format!("{censored} did not break"));
    }
    out
}

fn name(fit: &Fit) -> String {
    let area = match fit.area.model {
        Model::FixedAngle => "fixed angle",
        Model::Hertz => "Hertz",
    };
    let m = match fit.m().estimate {
        Some(m) => format!(", m = {}", significant(m, 3)),
        None => String::new(),
    };
    format!("{area}, {}{m}", fit.spread.name())
}

/// Size of a grain of diameter `d`, m, as the likelihood takes it: ln(d/d0) less the mean of the
/// data.
fn x(c: &Calibration, fit: &Fit, d: f64) -> f64 {
    (d / c.inputs.d0).ln() - fit.sample.x_mean
}

fn forces(c: &Calibration) -> Graph {
    let mut series = Vec::new();
    let (low, high) = c.data.extent();
    let (low, high) = (low / 1.15, high * 1.15);
    let sizes: Vec<f64> = (0..=POINTS).map(|i| low * (high / low).powf(f64::from(i) / f64::from(POINTS))).collect();
    let curve = |fit: &Fit, share: f64| -> Vec<f64> {
        let y = fit.law().quantile(share);
        sizes.iter().map(|d| fit.area.force(y * fit.size_law(x(c, fit, *d)), *d)).collect()
    };
    let line = |values: Vec<f64>| sizes.iter().map(|d| 1e3 * d).zip(values).collect();
    let best = c.best();
    series.push(Drawn {
        label: Some(format!("{}: median, 5–95 %", name(best))),
        name: name(best),
        tone: Tone::Kind(0),
        look: Look::Band { low: curve(best, 0.05), high: curve(best, 0.95) },
        points: line(curve(best, 0.5)),
    });
    let others: Vec<Fit> = c.fits.iter().filter(|f| f.area.model != best.area.model).cloned().collect();
    if let Some((i, _)) = super::fit::preferred(&others) {
        series.push(Drawn {
            label: Some(format!("{}: median", name(&others[i]))),
            name: name(&others[i]),
            tone: Tone::Kind(1),
            look: Look::Line(1),
            points: line(curve(&others[i], 0.5)),
        });
    }
    let several = c.data.series.len() > 1;
    for (n, name) in c.data.series.iter().enumerate() {
        let label = if several { name.clone() } else { "broke".into() };
        series.extend(tests(c, &label, Tone::Grey, [0, 1, 3][n % 3], |g| g.series == n && !g.censored));
    }
    series.extend(tests(c, "did not break", Tone::Kind(4), 2, |g| g.censored));
    let means: Vec<(f64, f64)> = c.classes.iter().filter_map(|k| Some((k.diameter_mm, k.mean_force_n?))).collect();
    series.push(Drawn {
        label: Some("mean of the broken".into()),
        name: "mean".into(),
        tone: Tone::Kind(1),
        look: Look::Symbols(3),
        points: means,
    });
    Graph {
        name: NAMES[0].into(),
        title: title(c),
        legend_title: None,
        x: Quantity::log("grain diameter d (mm)", "diameter_mm"),
        y: Quantity::log("crushing force F (N)", "force_N"),
        series,
    }
}

/// Single grains as symbols.
fn tests(c: &Calibration, label: &str, tone: Tone, symbol: usize, which: impl Fn(&Grain) -> bool) -> Option<Drawn> {
    let points: Vec<(f64, f64)> = c.data.grains.iter().filter(|g| which(g)).map(|g| (1e3 * g.diameter, g.force)).collect();
    let label = label.to_string();
    (!points.is_empty()).then(|| Drawn { label: Some(label.clone()), name: label, tone, look: Look::Symbols(symbol), points })
}

/// Indices of at most `SIZES` classes, those with most broken grains; a class needs three.
fn shown(c: &Calibration) -> Vec<usize> {
    let broken = |i: usize| c.classes[i].grains - c.classes[i].censored;
    let mut all: Vec<usize> = (0..c.classes.len()).filter(|&i| broken(i) >= 3).collect();
    all.sort_by_key(|&i| std::cmp::Reverse(broken(i)));
    all.truncate(SIZES);
    all.sort_unstable();
    all
}

fn survivals(c: &Calibration) -> Graph {
    let fit = c.best();
    let shown = shown(c);
    let mut series = Vec::new();
    for (k, &n) in shown.iter().enumerate() {
        let class = &c.classes[n];
        let tests: Vec<(f64, bool)> = class.members.iter().map(|&i| (c.data.grains[i].force, c.data.grains[i].censored)).collect();
        let tone = Tone::Ordered(k as f64 / (shown.len().max(2) - 1) as f64);
        let label = format!("{} ({})", significant(class.diameter_mm, 3), class.grains);
        let measured = survival(&tests);
        let (low, high) = measured.iter().fold((f64::INFINITY, 0.0), |(a, b), p| (f64::min(a, p.0), f64::max(b, p.0)));
        let (low, high) = (low / 1.3, high * 1.3);
        let law = fit.law();
        let forces = (0..=POINTS).map(|i| low * (high / low).powf(f64::from(i) / f64::from(POINTS)));
        let line = forces.map(|force| {
            let survives = |&i: &usize| {
                let d = c.data.grains[i].diameter;
                law.ln_survival(fit.area.ln_strength(d, force) - fit.size_law(x(c, fit, d)).ln()).exp()
            };
            (force, class.members.iter().map(survives).sum::<f64>() / class.grains as f64)
        });
        series.push(Drawn { label: None, name: format!("{label}: measured"), tone, look: Look::Symbols(k), points: measured });
        series.push(Drawn {
            label: Some(label.clone()),
            name: format!("{label}: fitted"),
            tone,
            look: Look::Line(k),
            points: line.collect(),
        });
    }
    let mut title = title(c);
    title.push(format!("symbols: mean rank; lines: {}", name(fit)));
    Graph {
        name: NAMES[1].into(),
        title,
        legend_title: Some("d (mm), grains".into()),
        x: Quantity::log("crushing force F (N)", "force_N"),
        y: Quantity::linear("probability of survival P_{s} (–)", "survival", &[0.0, 1.0]),
        series,
    }
}

fn quantiles(c: &Calibration) -> Graph {
    let fit = c.best();
    let law: Law = fit.law();
    let tests: Vec<(f64, bool)> =
        (0..fit.sample.len()).map(|i| (fit.sample.ratio(i, &fit.at).exp(), fit.sample.censored[i])).collect();
    let points: Vec<(f64, f64)> = survival(&tests).iter().map(|(y, p)| (law.quantile(1.0 - p), *y)).collect();
    let end = points.iter().fold(0.0, |a, p| f64::max(a, p.0.max(p.1)));
    let mut title = title(c);
    title.push(name(fit));
    Graph {
        name: NAMES[2].into(),
        title,
        legend_title: None,
        x: Quantity::linear("strength over σ_{lim}(d), fitted law (–)", "fitted_ratio", &[0.0]),
        y: Quantity::linear("strength over σ_{lim}(d), measured (–)", "measured_ratio", &[0.0]),
        series: vec![
            Drawn {
                label: Some("equal".into()),
                name: "equal".into(),
                tone: Tone::Grey,
                look: Look::Guide,
                points: vec![(0.0, 0.0), (end, end)],
            },
            Drawn {
                label: Some("broken grains".into()),
                name: "broken grains".into(),
                tone: Tone::Kind(0),
                look: Look::Symbols(0),
                points,
            },
        ],
    }
}
