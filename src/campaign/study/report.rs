//! The report of a study: tables, figures of error against time and of effects, and what to choose.

use super::compare::{Difference, Sample, Verdict};
use super::effects::{self, Effect};
use super::measure::{Measure, RunData};
use super::plan::{Design, Plan, Setting};
use crate::Job;
use crate::reproduce::cell;
use laboratory::error::{Error, Result};
use laboratory::run::Found;
use laboratory::scene::resolved;
use plot::{Drawn, Graph, Look, Quantity, Tone, significant};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use table::number;

/// Differences below this share of the tolerance are drawn there: so many decades are enough.
const LEAST: f64 = 1e-3;
/// Most effects that a figure and the page show.
const MOST_EFFECTS: usize = 14;

/// A measure with its tolerance, and what each setting shows of it.
struct Judged {
    measure: Measure,
    tolerance: f64,
    /// For each setting; the reference first.
    differences: Vec<Option<Difference>>,
    effects: Vec<Effect>,
}

/// A setting with its runs.
struct Row {
    setting: Setting,
    done: usize,
    /// Whether it is the scene of the reference, as that of which a study takes its specimens may be: nothing to choose.
    is_reference: bool,
    /// Mean time of a run ([`RunData::seconds`]).
    seconds: Option<f64>,
}

/// Writes tables, figures and the page of a study, from the runs in `out` that are done, into `dir`; returns the files.
///
/// # Errors
/// No run of the reference is done; a measure without tolerance where seeds give none; files that cannot be read or written.
pub fn write(plan: &Plan, out: &Path, dir: &Path) -> Result<Vec<PathBuf>> {
    let (mut rows, mut runs) = (Vec::new(), Vec::new());
    let mut reference: Option<Vec<String>> = None;
    for setting in plan.settings() {
        let mut seeds = Vec::new();
        let jobs = plan.jobs(&setting, out)?;
        let own = jobs.first().map(scene_without_specimen).transpose()?;
        let is_reference = own.is_some() && reference == own;
        reference = reference.or(own);
        for job in jobs {
            // the run that was to lend its specimen may have failed
            let lacks = job.specimen.as_ref().is_some_and(|file| !file.is_file());
            seeds.push(match if lacks { Found::Nothing } else { job.found()? } {
                Found::Finished(summary) => Some(RunData::read(&job.out, summary)?),
                _ => None,
            });
        }
        let times: Vec<f64> = seeds.iter().flatten().filter_map(RunData::seconds).collect();
        let seconds = (!times.is_empty()).then(|| times.iter().sum::<f64>() / times.len() as f64);
        rows.push(Row { setting, done: seeds.iter().flatten().count(), is_reference, seconds });
        runs.push(seeds);
    }
    if rows[0].done == 0 {
        let message = "no run of it is done, so nothing can be compared with it";
        return Err(Error::input("study", "reference", Some(rows[0].setting.name.clone()), message));
    }
    let judged = judge(plan, &rows, &runs)?;
    std::fs::create_dir_all(dir).map_err(Error::write(dir))?;
    let mut files = vec![dir.join("README.md"), dir.join("study.csv")];
    std::fs::write(&files[1], table(&rows, &judged)).map_err(Error::write(&files[1]))?;
    if plan.design != Design::OneAtATime {
        let path = dir.join("effects.csv");
        std::fs::write(&path, effects_table(&judged)).map_err(Error::write(&path))?;
        files.push(path);
    }
    let mut drawn = Vec::new();
    for of in &judged {
        if let Some(graph) = graph(plan, &rows, of) {
            drawn.extend(graph.draw(dir)?);
        }
        let shown = strongest(&of.effects);
        if !shown.is_empty() {
            let bars: Vec<plot::Bar> = shown
                .iter()
                .map(|e| plot::Bar { name: e.name.clone(), value: e.difference.mean, half_width: e.difference.half_width })
                .collect();
            drawn.extend(plot::draw_effects(
                &format!("effects_{}", of.measure.name()),
                of.measure.difference(),
                &bars,
                of.tolerance,
                dir,
            )?);
        }
    }
    std::fs::write(&files[0], page(plan, &rows, &judged, &drawn)).map_err(Error::write(&files[0]))?;
    files.extend(drawn);
    Ok(files)
}

/// Every key of the scene of a job with everything that it changes, but for the specimen that it begins with and where values are from.
fn scene_without_specimen(job: &Job) -> Result<Vec<String>> {
    let (scene, _) = Job { specimen: None, ..job.clone() }.load()?;
    Ok(resolved(&scene).lines().filter(|line| !line.starts_with("source")).map(str::to_string).collect())
}

/// Compares all settings by all measures that the reference has.
fn judge(plan: &Plan, rows: &[Row], runs: &[Vec<Option<RunData>>]) -> Result<Vec<Judged>> {
    let seeded = plan.numbers()?.is_some();
    let wanted = if plan.measures.is_empty() { &Measure::ALL[..] } else { &plan.measures };
    let settings: Vec<Setting> = rows.iter().map(|row| row.setting.clone()).collect();
    let mut judged = Vec::new();
    for &measure in wanted {
        let Some(sample) = Sample::of(measure, runs, seeded) else {
            if plan.measures.is_empty() {
                continue;
            }
            let message = "is not measured by the runs of the reference";
            return Err(Error::input("study", "measures", Some(measure.name().into()), message));
        };
        let Some(tolerance) = plan.tolerance.get(&measure).copied().or_else(|| sample.deviation()) else {
            let message = "is needed: a single run of the reference has no standard deviation that could stand for it";
            return Err(Error::input("study", format!("tolerance.{}", measure.name()), None, message));
        };
        judged.push(Judged {
            measure,
            tolerance,
            differences: (0..rows.len()).map(|k| sample.difference(k)).collect(),
            effects: effects::of(plan, &settings, &sample),
        });
    }
    Ok(judged)
}

/// `study.csv`: a row for each setting and measure.
fn table(rows: &[Row], judged: &[Judged]) -> String {
    let mut text = String::from("setting,measure,seeds,difference,half_width,tolerance,verdict,run_s\n");
    for (k, row) in rows.iter().enumerate() {
        let seconds = row.seconds.map_or(String::new(), number);
        for of in judged {
            let found = match of.differences[k] {
                Some(d) => format!("{},{},{}", d.seeds, number(d.mean), number(d.half_width)),
                None => "0,,".into(),
            };
            let verdict = of.differences[k].map_or("", |d| d.verdict(of.tolerance).word());
            let _ =
                writeln!(text, "{:?},{},{found},{},{verdict},{seconds}", row.setting.name, of.measure.name(), number(of.tolerance));
        }
    }
    text
}

/// `effects.csv`: a row for each effect and measure.
fn effects_table(judged: &[Judged]) -> String {
    let mut text = String::from("effect,measure,seeds,difference,half_width,tolerance,verdict\n");
    for (of, effect) in judged.iter().flat_map(|of| of.effects.iter().map(move |e| (of, e))) {
        let d = effect.difference;
        let numbers = format!("{},{},{},{}", d.seeds, number(d.mean), number(d.half_width), number(of.tolerance));
        let _ = writeln!(text, "{:?},{},{numbers},{}", effect.name, of.measure.name(), d.verdict(of.tolerance).word());
    }
    text
}

/// The largest effects, the largest first.
fn strongest(effects: &[Effect]) -> Vec<&Effect> {
    let mut all: Vec<&Effect> = effects.iter().collect();
    all.sort_by(|a, b| b.difference.mean.abs().total_cmp(&a.difference.mean.abs()));
    all.truncate(MOST_EFFECTS);
    all
}

/// Error against time of one measure.
fn graph(plan: &Plan, rows: &[Row], of: &Judged) -> Option<Graph> {
    let reference = rows[0].seconds?;
    let point = |k: usize| {
        let difference = of.differences[k].filter(|_| !rows[k].is_reference)?;
        Some((rows[k].seconds? / reference, difference.mean.abs().max(LEAST * of.tolerance)))
    };
    let all: Vec<(f64, f64)> = (1..rows.len()).filter_map(point).collect();
    let (low, high) = all.iter().fold((1.0_f64, 1.0_f64), |(low, high), (x, _)| (low.min(*x), high.max(*x)));
    if all.is_empty() {
        return None;
    }
    let across = |y: f64| vec![(low, y), (high.max(1.001 * low), y)];
    let line = |label: &str, dash: usize, y: f64| Drawn {
        label: Some(label.into()),
        name: label.into(),
        tone: Tone::Grey,
        look: Look::Line(dash),
        points: across(y),
    };
    let mut series = vec![line("tolerance", 0, of.tolerance)];
    let mut widths: Vec<f64> = of.differences[1..].iter().flatten().map(|d| d.half_width).filter(|w| *w > 0.0).collect();
    widths.sort_by(f64::total_cmp);
    if let Some(median) = widths.get(widths.len() / 2) {
        series.push(line("half an interval of 95 %", 1, *median));
    }
    let symbols = |label: Option<String>, n: usize, points: Vec<(f64, f64)>| Drawn {
        name: label.clone().unwrap_or_else(|| "settings".into()),
        label,
        tone: Tone::Kind(n),
        look: Look::Symbols(n),
        points,
    };
    if plan.design == Design::OneAtATime {
        for (f, factor) in plan.factors.iter().enumerate() {
            let points: Vec<(f64, f64)> =
                (1..rows.len()).filter(|k| rows[*k].setting.levels[f].is_some()).filter_map(point).collect();
            // between words there is nothing
            if points.len() > 1 && factor.is_numeric() {
                series.push(Drawn { label: None, look: Look::Line(0), ..symbols(Some(factor.name.clone()), f, points.clone()) });
            }
            series.push(symbols(Some(factor.name.clone()), f, points));
        }
    } else {
        series.push(symbols(None, 0, all));
    }
    series.retain(|s| !s.points.is_empty());
    Some(Graph {
        name: format!("time_error_{}", of.measure.name()),
        title: vec![plan.title.clone()],
        legend_title: None,
        x: Quantity::log("run time over that of the reference (–)", "time_ratio"),
        y: Quantity::log(of.measure.difference(), "difference"),
        series,
    })
}

/// A number with its interval, as on the page.
fn shown(d: Difference) -> String {
    let digits = |x: f64| significant(x, 2).replace('-', "−");
    if d.half_width.is_nan() {
        format!("{} (one seed)", digits(d.mean))
    } else if d.half_width == 0.0 {
        // a scene that draws nothing
        digits(d.mean)
    } else {
        format!("{} ± {}", digits(d.mean), digits(d.half_width))
    }
}

fn page(plan: &Plan, rows: &[Row], judged: &[Judged], drawn: &[PathBuf]) -> String {
    let mut text = format!("# {}\n\n", plan.title);
    if !plan.question.is_empty() {
        let _ = writeln!(text, "{}\n", plan.question.trim());
    }
    let seeds = rows[0].done;
    if rows.iter().any(|row| row.done < seeds) {
        text += "Some runs failed or are not done: settings with fewer runs than the reference are compared by the seeds that they have, effects by the seeds that all settings have.\n\n";
    }
    let _ = writeln!(
        text,
        "Reference: {} ({seeds} run{}). Differences from it are taken seed by seed; ± is half the interval of 95 % of their mean. *Within* the tolerance is a setting whose whole interval is, *outside* one whose \
         interval lies beyond it, *open* what needs more seeds. A tolerance that the plan does not give is the standard deviation of the reference over its seeds.\n",
        rows[0].setting.name,
        if seeds == 1 { "" } else { "s" }
    );
    let heads: Vec<String> = judged
        .iter()
        .map(|of| format!("{} (tolerance {})", of.measure.name().replace('_', " "), significant(of.tolerance, 2)))
        .collect();
    let _ = writeln!(text, "| setting | runs | run time, s | over the reference's | {} |", heads.join(" | "));
    let _ = writeln!(text, "|---|---|---|---|{}", "---|".repeat(judged.len()));
    for (k, row) in rows.iter().enumerate() {
        let time = row.seconds.map_or("–".into(), |s| significant(s, 3));
        let ratio = row.seconds.zip(rows[0].seconds).map_or("–".into(), |(s, r)| significant(s / r, 2));
        let cells = judged.iter().map(|of| match of.differences[k] {
            _ if k == 0 || row.is_reference => String::new(),
            Some(d) => format!("{} *{}*", shown(d), d.verdict(of.tolerance).word()),
            None => "–".into(),
        });
        let same = if row.is_reference { " (that of the reference)" } else { "" };
        let _ = writeln!(
            text,
            "| {}{same} | {} | {time} | {ratio} | {} |",
            cell(&row.setting.name),
            row.done,
            cells.collect::<Vec<_>>().join(" | ")
        );
    }
    let _ = writeln!(text, "\n**{}**", recommendation(rows, judged));
    for of in judged.iter().filter(|of| !of.effects.is_empty()) {
        let _ = writeln!(
            text,
            "\n## Effects: {}\n\n| effect | {} | |\n|---|---|---|",
            of.measure.name().replace('_', " "),
            cell(&plain(of.measure.difference()))
        );
        for effect in strongest(&of.effects) {
            let d = effect.difference;
            let _ = writeln!(text, "| {} | {} | {} |", cell(&effect.name), shown(d), d.verdict(of.tolerance).word());
        }
    }
    text.push('\n');
    for image in drawn.iter().filter(|f| f.extension().is_some_and(|e| e == "svg")) {
        let name = image.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let _ = writeln!(text, "<img src=\"{name}.svg\" alt=\"{}\" width=\"430\">", name.replace('_', " "));
    }
    text += "\nIn figures of error against time a difference below a thousandth of the tolerance stands at that thousandth; the dashed line is the median over the settings of half an interval.\n";
    for note in &plan.notes {
        let _ = writeln!(text, "\n- {note}");
    }
    text
}

/// A label of a figure without the marks of its subscripts.
fn plain(label: &str) -> String {
    label.replace(['{', '}'], "")
}

/// What to choose: the fastest setting that is shown to be within all tolerances.
fn recommendation(rows: &[Row], judged: &[Judged]) -> String {
    let verdicts = |k: usize| judged.iter().map(move |of| of.differences[k].map(|d| d.verdict(of.tolerance)));
    let fastest = |fits: &dyn Fn(usize) -> bool| {
        let timed = (1..rows.len()).filter(|k| !rows[*k].is_reference && fits(*k)).filter_map(|k| Some((k, rows[k].seconds?)));
        timed.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
    };
    let time = |k: usize| {
        rows[k]
            .seconds
            .zip(rows[0].seconds)
            .map_or(String::new(), |(s, r)| format!(" in {} of the reference's time", significant(s / r, 2)))
    };
    let within = fastest(&|k| verdicts(k).all(|v| v == Some(Verdict::Within)));
    let possible = fastest(&|k| verdicts(k).all(|v| matches!(v, Some(Verdict::Within | Verdict::Open))));
    let slower = |k: usize| rows[k].seconds.zip(rows[0].seconds).is_some_and(|(s, r)| s >= r);
    match (within, possible) {
        (Some(k), _) if slower(k) => "No setting within all tolerances is faster than the reference.".into(),
        (Some(k), _) => format!("Choose {}: the fastest setting within all tolerances,{}.", rows[k].setting.name, time(k)),
        (None, Some(k)) => format!(
            "No setting is shown to be within all tolerances. {} may be,{}: more seeds would tell.",
            rows[k].setting.name,
            time(k)
        ),
        (None, None) if rows[1..].iter().all(|row| row.done == 0 || row.is_reference) => {
            "No run of another setting is done.".into()
        }
        (None, None) => "Every setting that is done is outside of a tolerance: stay with the reference.".into(),
    }
}
