//! Files that a calibration writes: `calibration.json`, `posterior.csv`, `report.md` and figures.

use super::findings::Findings;
use super::parameter::Parameter;
use super::posterior::Measured;
use super::search::{Search, Settings};
use super::target::{Kind, Target};
use super::{Outcome, Request, block_name, failures, log};
use laboratory::error::{Error, Result};
use laboratory::scene::Prior;
use plot::{self, FittedLine, PosteriorInput};
use serde_json::{Map, Value, json};
use std::fmt::Write as _;
use std::path::Path;
use table::number;

/// Everything from which the report is made.
pub struct Parts<'a> {
    pub request: &'a Request,
    pub parameters: &'a [Parameter],
    pub target: &'a Target,
    pub curve: &'a Measured,
    pub settings: &'a Settings,
    pub search: &'a Search<'a>,
    pub findings: &'a Findings,
    /// Curves of the check runs, made with the parameters found.
    pub checks: &'a [Vec<f64>],
}

/// Draws in the corner figure.
const CORNER: usize = 2000;

/// Writes all files into the folder `out`.
///
/// # Errors
/// Files that cannot be written.
pub fn write(out: &Path, parts: &Parts<'_>) -> Result<Outcome> {
    let json = json(parts);
    let text = crate::json_text(&json);
    let mut files = Vec::new();
    let table = table(parts);
    let warnings = warnings(parts);
    let save = |name: &str, text: &str| log::replace(&out.join(name), text.as_bytes()).map(|()| out.join(name));
    files.push(save("calibration.json", &text)?);
    files.push(save("posterior.csv", &draws(parts))?);
    files.push(save("report.md", &report(parts, &table, &warnings))?);
    files.push(out.join(log::FILE));
    files.extend(figures(&out.join("figures"), parts).map_err(Error::from)?);
    Ok(Outcome { json, table, warnings, files })
}

fn prior_text(p: &Parameter) -> String {
    match p.prior {
        Prior::Uniform => "uniform".into(),
        Prior::LogUniform => "log-uniform".into(),
        Prior::Normal { mean, sd } => format!("normal ({mean}, {sd})"),
    }
}

fn json(parts: &Parts<'_>) -> Value {
    let f = parts.findings;
    let mut parameters = Map::new();
    for ((p, e), share) in parts.parameters.iter().zip(&f.estimates).zip(&f.shares) {
        parameters.insert(
            p.key.clone(),
            json!({
                "estimate": e.estimate, "lower": e.lower, "upper": e.upper, "mean": e.mean, "sd": e.sd, "mode": e.mode,
                "prior": { "kind": prior_text(p), "lower": p.lower, "upper": p.upper },
                "finished_runs": { "lower": e.finished[0], "upper": e.finished[1] }, "extrapolated": e.extrapolated,
                "interval_over_prior": e.width_over_prior,
                "variance_share_alone": share.first, "variance_share_with_others": share.total,
                "remark": e.remark,
            }),
        );
    }
    let scatter: Map<String, Value> =
        parts.target.blocks.iter().zip(&f.scatter).map(|(b, s)| (block_name(&b.kind), json!(s))).collect();
    json!({
        "scene": parts.request.scene.display().to_string(),
        "curve": parts.request.files.curve.display().to_string(),
        "parameters": parameters,
        "rank_correlations": f.correlations,
        "runs": { "done": parts.search.done().count(), "failed": parts.search.failed(), "budget": parts.settings.budget },
        "misfit": { "mean_square": f.misfit.ratio, "probability": f.misfit.probability, "inflation": f.inflation },
        "scatter_between_seeds": scatter,
        "variance_share_seeds": f.seeds_share,
        "left_out": left_out(parts),
        "check_rms": check_rms(parts),
        "seed": parts.settings.seed,
        "version": env!("CARGO_PKG_VERSION"),
    })
}

/// Results of the test with runs that were left out; null if there was none.
fn left_out(parts: &Parts<'_>) -> Value {
    let Some(l) = &parts.findings.left_out else { return Value::Null };
    let keys = parts.parameters.iter().map(|p| p.key.clone());
    let held: Map<String, Value> = keys.clone().zip(l.held.iter().map(|h| json!(h))).collect();
    let width: Map<String, Value> = keys.zip(l.width.iter().map(|w| json!(w))).collect();
    json!({ "curves": l.curves, "held": held, "mean_interval_over_bounds": width })
}

/// Root mean square difference between the mean curve of the check runs and the measured curve, for
/// each block; null without check runs.
fn check_rms(parts: &Parts<'_>) -> Value {
    if parts.checks.is_empty() {
        return Value::Null;
    }
    let mut first = 0;
    let blocks = parts.target.blocks.iter().map(|b| {
        let own = first..first + b.at.len();
        first = own.end;
        let square = |j: usize| {
            let mean = parts.checks.iter().map(|c| c[j]).sum::<f64>() / parts.checks.len() as f64;
            (mean - parts.curve.values[j]).powi(2)
        };
        (block_name(&b.kind), json!((own.clone().map(square).sum::<f64>() / own.len() as f64).sqrt()))
    });
    Value::Object(blocks.collect())
}

fn draws(parts: &Parts<'_>) -> String {
    let keys: Vec<&str> = parts.parameters.iter().map(|p| p.key.as_str()).collect();
    let mut text = keys.join(",") + "\n";
    for draw in &parts.findings.draws {
        text += &draw.iter().map(|v| number(*v)).collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}

/// Number with four significant digits: no interval is known more exactly.
fn short(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    number(rounded)
}

fn table(parts: &Parts<'_>) -> String {
    let mut text = String::from("| parameter | estimate | 95 % interval | prior | |\n|---|---|---|---|---|\n");
    for (p, e) in parts.parameters.iter().zip(&parts.findings.estimates) {
        let (low, high) = (short(p.lower), short(p.upper));
        let _ = writeln!(
            text,
            "| `{}` | {} | {} – {} | {low} – {high}, {} | {} |",
            p.key,
            short(e.estimate),
            short(e.lower),
            short(e.upper),
            prior_text(p),
            e.remark
        );
    }
    text
}

/// Sentences for the user about reasons to doubt the result.
fn warnings(parts: &Parts<'_>) -> Vec<String> {
    let f = parts.findings;
    let mut all = Vec::new();
    let mut first = 0;
    for block in &parts.target.blocks {
        let outside = (first..first + block.at.len()).filter(|&j| {
            let at = parts.search.done().map(|(_, y)| y[j]);
            let (low, high) = at.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
            let (value, may) = (parts.curve.values[j], 2.0 * parts.curve.sd[j]);
            value < low - may || value > high + may
        });
        let count = outside.count();
        first += block.at.len();
        if 2 * count > block.at.len() {
            let (name, of, runs) = (block_name(&block.kind), block.at.len(), parts.search.done().count());
            all.push(format!("{name} lies outside of all {runs} runs at {count} of {of} points"));
        }
    }
    let ended = parts.search.ended();
    let tied = failures::tied(parts.parameters.len(), &ended);
    all.extend(tied.iter().map(|t| failures::sentence(t, parts.parameters, &ended)));
    for (p, e) in parts.parameters.iter().zip(&f.estimates) {
        let (low, high) = (short(e.finished[0]), short(e.finished[1]));
        if e.estimate < e.finished[0] || e.estimate > e.finished[1] {
            all.push(format!("{} is an extrapolation: no run finished outside of {low} to {high}", p.short()));
        }
    }
    if parts.settings.check > 0 && parts.checks.is_empty() {
        all.push(format!(
            "none of the {} runs with the likeliest parameters finished: the result is not checked",
            parts.settings.check
        ));
    }
    if f.inflation > 1.0 {
        all.push("the scene cannot give this curve with any of these parameters within its scatter".into());
    }
    if let Some(l) = &f.left_out {
        for (k, p) in parts.parameters.iter().enumerate().filter(|(k, _)| l.doubtful(*k)) {
            let (held, of) = (l.held[k], l.curves);
            all.push(format!(
                "intervals of {} held only {held} of {of} known values: they are too narrow; more runs may help",
                p.short()
            ));
        }
    }
    all
}

/// Sentence on whether the scene agrees with the curve: no conclusion without a finished check run,
/// and no approval if there are warnings.
fn conclusion(inflation: f64, checks: usize, warnings: &[String]) -> &'static str {
    if inflation > 1.0 {
        "The covariance was multiplied by that ratio, so the intervals are wider, but they hold for the best of a wrong model."
    } else if checks == 0 {
        "No run with the parameters found was made to its end, so nothing can be concluded about the scene."
    } else if !warnings.is_empty() {
        "The warnings above speak against the result."
    } else {
        "Nothing speaks against the scene."
    }
}

fn report(parts: &Parts<'_>, table: &str, warnings: &[String]) -> String {
    let (f, s) = (parts.findings, parts.settings);
    let mut text = format!(
        "# Calibration of `{}` against `{}`\n\n{table}\n",
        parts.request.scene.display(),
        parts.request.files.curve.display()
    );
    for warning in warnings {
        let _ = writeln!(text, "**Warning: {warning}.**\n");
    }
    let _ = writeln!(
        text,
        "Estimates are medians of the posterior; `posterior.csv` holds {} draws. {} runs were made and {} of them failed: {} fill the space between the \
         bounds, {} repeat its middle with other seeds, the others lie where they told most. Each has seeds of its own.\n",
        f.draws.len(),
        s.budget,
        parts.search.failed(),
        s.design,
        s.centre,
    );
    let _ = writeln!(
        text,
        "The curve is taken as the mean of {} specimen{} that scatter{} like the runs' seeds. Scatter between seeds (root mean square): {}. The seeds \
         make {:.0} % of the variance of a single run over the prior.\n",
        s.specimens,
        if s.specimens == 1.0 { "" } else { "s" },
        if s.specimens == 1.0 { "s" } else { "" },
        parts
            .target
            .blocks
            .iter()
            .zip(&f.scatter)
            .map(|(b, s)| format!("{} {}", block_name(&b.kind), short(*s)))
            .collect::<Vec<_>>()
            .join(", "),
        100.0 * f.seeds_share,
    );
    let _ = writeln!(
        text,
        "Differences from the curve are {:.2} times as large (mean square) as seeds, measurement and emulator let expect; a true model would \
         exceed that with probability {:.3}. {}\n",
        f.misfit.ratio,
        f.misfit.probability,
        conclusion(f.inflation, parts.checks.len(), warnings)
    );
    let _ =
        writeln!(text, "The emulator has {} components, which hold {:.1} % of the runs' variance.\n", f.components, 100.0 * f.held);
    if let Some(l) = &f.left_out {
        let each = |text: &dyn Fn(usize) -> String| (0..l.held.len()).map(text).collect::<Vec<_>>().join(", ");
        let _ = writeln!(
            text,
            "A test: each run of the design was left out (a sixth of them at a time) and its curve taken for the measured one. The 95 % intervals held \
             what it was made with in {} of {} cases ({}).\n",
            each(&|k| l.held[k].to_string()),
            l.curves,
            each(&|k| parts.parameters[k].short()),
        );
    }
    if let Value::Object(rms) = check_rms(parts) {
        let parts_text: Vec<String> = rms.iter().map(|(k, v)| format!("{k} {}", short(v.as_f64().unwrap_or(f64::NAN)))).collect();
        let _ = writeln!(
            text,
            "{} runs with the likeliest parameters, which the emulator never saw, are on the average off the curve by (root mean square): {}.\n",
            parts.checks.len(),
            parts_text.join(", ")
        );
    }
    text += "Figures: `curve` (bands), `corner` (draws two by two), `sensitivity`, `convergence`.\n";
    text
}

fn figures(out: &Path, parts: &Parts<'_>) -> plot::Result<Vec<std::path::PathBuf>> {
    let f = parts.findings;
    let inputs: Vec<PosteriorInput> = parts
        .parameters
        .iter()
        .map(|p| PosteriorInput { name: p.short(), log: p.prior == Prior::LogUniform, lower: p.lower, upper: p.upper })
        .collect();
    let mut files = Vec::new();
    let mut first = 0;
    for (i, block) in parts.target.blocks.iter().enumerate() {
        let own = first..first + block.at.len();
        first = own.end;
        let cut = |v: &Vec<f64>| v[own.clone()].to_vec();
        let (quantity, name, fact) = match block.kind {
            Kind::History(column) => (column.to_string(), if i == 0 { "curve".into() } else { column.to_string() }, None),
            Kind::Gradation(s) => {
                ("gradation".into(), format!("gradation_{s}_kPa"), Some(format!("σ_{{v}} = {} MPa", short(s * 1e-3))))
            }
        };
        let mut title = vec![format!("{} runs", parts.search.done().count())];
        title.extend(fact);
        let line = FittedLine {
            quantity,
            name,
            x: block.at.clone(),
            measured: block.values.clone(),
            median: cut(&f.bands.median),
            mean: [cut(&f.bands.mean[0]), cut(&f.bands.mean[1])],
            specimen: [cut(&f.bands.specimen[0]), cut(&f.bands.specimen[1])],
            checks: parts.checks.iter().map(cut).collect(),
            title,
        };
        files.extend(plot::draw_fitted(&line, out)?);
    }
    let every = (f.draws.len() / CORNER).max(1);
    let draws: Vec<Vec<f64>> = f.draws.iter().step_by(every).cloned().collect();
    files.extend(plot::draw_corner(&inputs, &draws, out)?);
    let mut names: Vec<String> = inputs.iter().map(|p| p.name.clone()).collect();
    names.push("seeds (of a single run)".into());
    let mut alone: Vec<f64> = f.shares.iter().map(|s| s.first).collect();
    let mut total: Vec<f64> = f.shares.iter().map(|s| s.total).collect();
    alone.push(f.seeds_share);
    total.push(f.seeds_share);
    files.extend(plot::draw_sensitivity(&names, &alone, &total, out)?);
    let runs: Vec<f64> = parts.search.trace.iter().map(|t| t.evaluations as f64).collect();
    let quantiles: Vec<Vec<[f64; 3]>> = parts.search.trace.iter().map(|t| t.quantiles.clone()).collect();
    files.extend(plot::draw_convergence(&inputs, &runs, &quantiles, out)?);
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::conclusion;

    #[test]
    fn without_a_check_nothing_is_concluded() {
        let (none, one) = (Vec::new(), vec!["failures go with stiffness".to_string()]);
        assert!(conclusion(1.0, 4, &none).starts_with("Nothing speaks against"));
        assert!(conclusion(1.0, 0, &none).contains("nothing can be concluded"));
        assert!(conclusion(1.0, 4, &one).contains("warnings above"));
        assert!(conclusion(2.0, 4, &none).contains("wrong model"));
    }
}
