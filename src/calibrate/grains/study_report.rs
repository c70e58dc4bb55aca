//! Tables and figure of the recovery study.

use super::study::{Case, PARAMETERS, Recovery, Repeat};
use laboratory::error::{Error, Result};
use plot::{Drawn, Graph, Look, Quantity, Tone};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// Acceptance limits: the intervals shall hold the truth in 90 to 99 of 100 repeats and be at most
/// 1.3 times as wide as the Fisher information allows.
const HELD: (f64, f64) = (90.0, 99.0);
const WIDE: f64 = 1.3;

/// Simulated crushing tests as CSV text, as `comminute calibrate grains` reads it; a comment line
/// gives the true parameters.
pub fn simulated(case: &Case, grains: usize, seed: u64) -> String {
    let [sigma, m, var] = case.truth();
    let mut text =
        format!("# simulated crushing tests ({}, seed {seed}): sigma_lim0 = {sigma} MPa, m = {m}, var. = {var}\n", case.name);
    text += "diameter_mm,force_N\n";
    for g in case.simulate(grains, seed).grains {
        let _ = writeln!(text, "{},{:.5}", 1e3 * g.diameter, g.force);
    }
    text
}

/// Writes `recovery.csv` (a row for each case and parameter), `repeats.csv` (a row for each repeat)
/// and the figure into `out`.
pub fn write(cases: &[(Vec<Recovery>, Vec<Repeat>)], out: &Path) -> Result<Vec<PathBuf>> {
    fs::create_dir_all(out).map_err(Error::write(out))?;
    let mut table = String::from(
        "case,parameter,truth,repeats,held_percent,held_of_each_100,held_preferred_percent,open,mean_estimate,mean_width,fisher_width,\
         width_over_fisher\n",
    );
    let mut each = String::from("case,seed,preferred_spread");
    for p in PARAMETERS {
        let _ = write!(each, ",{p},{p}_lower,{p}_upper");
    }
    each.push('\n');
    for (rows, repeats) in cases {
        for (k, r) in rows.iter().enumerate() {
            let blocks: Vec<String> = repeats
                .chunks_exact(100)
                .map(|b| {
                    b.iter().filter(|r2| r2.estimates[k].estimate.is_some() && r2.estimates[k].holds(r.truth)).count().to_string()
                })
                .collect();
            let percent = |n: usize| 100.0 * n as f64 / r.repeats as f64;
            let _ = writeln!(
                table,
                "\"{}\",{},{},{},{:.1},{},{:.1},{},{:.5},{:.5},{:.5},{:.4}",
                r.case,
                r.parameter,
                r.truth,
                r.repeats,
                percent(r.held),
                blocks.join(" "),
                percent(r.held_preferred),
                r.open,
                r.mean,
                r.width,
                r.fisher_width,
                r.width / r.fisher_width
            );
        }
        for repeat in repeats {
            let case = rows.first().map_or("", |r| r.case);
            let _ = write!(each, "\"{case}\",{},{}", repeat.seed, repeat.preferred_spread.name());
            for e in &repeat.estimates {
                for v in [e.estimate, e.lower, e.upper] {
                    let _ = write!(each, ",{}", v.map_or(String::new(), |v| format!("{v:.5}")));
                }
            }
            each.push('\n');
        }
    }
    let mut files = Vec::new();
    for (name, text) in [("recovery.csv", table), ("repeats.csv", each)] {
        let path = out.join(name);
        fs::write(&path, text).map_err(Error::write(&path))?;
        files.push(path);
    }
    let all: Vec<&Recovery> = cases.iter().flat_map(|(rows, _)| rows).collect();
    files.extend(graph(&all).draw(out)?);
    Ok(files)
}

fn graph(all: &[&Recovery]) -> Graph {
    let mut series = vec![Drawn {
        label: Some("limits of the acceptance".into()),
        name: "acceptance".into(),
        tone: Tone::Grey,
        look: Look::Line(1),
        points: vec![(HELD.0, 0.9), (HELD.0, WIDE), (HELD.1, WIDE), (HELD.1, 0.9)],
    }];
    for (k, (parameter, label)) in PARAMETERS.iter().zip(["σ_{lim,0}", "m", "var."]).enumerate() {
        let of = all.iter().filter(|r| r.parameter == *parameter);
        let points = of.map(|r| (100.0 * r.held as f64 / r.repeats as f64, r.width / r.fisher_width)).collect();
        series.push(Drawn {
            label: Some(label.into()),
            name: (*parameter).into(),
            tone: Tone::Kind(k),
            look: Look::Symbols(k),
            points,
        });
    }
    let repeats = all.first().map_or(0, |r| r.repeats);
    Graph {
        name: "coverage".into(),
        title: vec!["coke and silica, fixed angle and Hertz".into(), format!("{repeats} repeats each")],
        legend_title: None,
        x: Quantity::linear("95 % intervals that hold the truth (%)", "held_percent", &[88.0, 100.0]),
        y: Quantity::linear("mean width over Fisher's (–)", "width_over_fisher", &[0.9, 1.4]),
        series,
    }
}
