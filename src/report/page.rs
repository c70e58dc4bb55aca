//! The page: its frame, the scripts that draw it, and the data.

use super::run::shown;
use super::{Options, links};
use laboratory::error::{Error, Result};
use plot::{Chart, ChartAxis, ChartMark, ChartSeries};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// How every report begins.
pub const HEAD: &str = "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"generator\" content=\"comminute report\">\n";

const FRAME: &str = include_str!("assets/page.html");
const STYLE: &str = include_str!("assets/page.css");
/// Scripts that run as they stand, in this order.
const SCRIPTS: [&str; 10] = [
    include_str!("assets/vendor/chart.umd.min.js"),
    include_str!("assets/vendor/chartjs-plugin-zoom.min.js"),
    include_str!("assets/words.js"),
    include_str!("assets/charts.js"),
    include_str!("assets/tables.js"),
    include_str!("assets/shaders.js"),
    include_str!("assets/layers.js"),
    include_str!("assets/pick.js"),
    include_str!("assets/view.js"),
    include_str!("assets/page.js"),
];
/// Modules that `view.js` loads, by the ids under which it finds them.
const MODULES: [(&str, &str); 3] = [
    ("module-three-core", include_str!("assets/vendor/three.core.min.js")),
    ("module-three", include_str!("assets/vendor/three.module.min.js")),
    ("module-orbit", include_str!("assets/vendor/OrbitControls.js")),
];

/// The page at `out` of the runs in `dirs`, and what a reader must know of those that are not finished.
///
/// # Errors
/// Records that are damaged.
pub fn page(dirs: &[PathBuf], out: &Path, options: &Options) -> Result<(String, Vec<String>)> {
    let palette = plot::palette(dirs).map_err(Error::from)?;
    let charts = plot::charts(dirs).map_err(Error::from)?;
    let (mut runs, mut blobs, mut notes) = (Vec::new(), Vec::new(), Vec::new());
    for (dir, name) in dirs.iter().zip(&palette.names) {
        let run = shown(dir, name, out, options.snapshots)?;
        let mut value = run.value;
        value["firstBlob"] = json!(blobs.len());
        runs.push(value);
        blobs.extend(run.blobs);
        notes.extend(run.note.map(|note| format!("{}: {note}", dir.display())));
    }
    let charts: Vec<Value> = charts.iter().map(|chart| in_json(chart, dirs, out)).collect();
    let data = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "palette": { "runs": palette.runs, "generations": palette.generations, "sequence": palette.sequence },
        "runs": runs,
        "charts": charts,
    });
    let mut text = String::from(HEAD);
    let (before, after) = FRAME.split_once("<!-- scripts -->").unwrap_or((FRAME, ""));
    let title = palette.names.join(", ");
    text += &before.replace("<!-- title -->", &escaped(&title)).replace("/* style */", STYLE);
    // `<` never stands in the data: no text of a scene ends the script
    text += &format!("<script type=\"application/json\" id=\"data\">{}</script>\n", data.to_string().replace('<', "\\u003c"));
    for (i, blob) in blobs.iter().enumerate() {
        text += &format!("<script type=\"text/plain\" id=\"blob-{i}\">{blob}</script>\n");
    }
    for (id, module) in MODULES {
        text += &format!("<script type=\"text/plain\" id=\"{id}\">{module}</script>\n");
    }
    for script in SCRIPTS {
        text += &format!("<script>{script}</script>\n");
    }
    text += after;
    Ok((text, notes))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn in_json(chart: &Chart, dirs: &[PathBuf], out: &Path) -> Value {
    let axis = |axis: &ChartAxis| json!({ "label": axis.label, "column": axis.column, "log": axis.log, "downwards": axis.downwards, "range": axis.range });
    // the table beside the figure of each run that has drawn it
    let csv = |dir: &PathBuf| {
        let file = dir.join(laboratory::run::FIGURES).join(format!("{}.csv", chart.name));
        file.is_file().then(|| links::link(out, &file))
    };
    json!({
        "name": chart.name,
        "title": chart.title,
        "legend": chart.legend_title,
        "x": axis(&chart.x),
        "y": axis(&chart.y),
        "equal": chart.equal,
        "csv": dirs.iter().map(csv).collect::<Vec<Option<String>>>(),
        "series": chart.series.iter().map(series).collect::<Vec<Value>>(),
    })
}

fn series(series: &ChartSeries) -> Value {
    let (kind, low, high) = match &series.mark {
        ChartMark::Line => ("line", None, None),
        ChartMark::Band { low, high } => ("band", Some(low), Some(high)),
        ChartMark::Guide => ("guide", None, None),
        ChartMark::Symbols => ("data", None, None),
    };
    json!({
        "run": series.run,
        "label": series.label,
        "name": series.name,
        "colour": series.colour,
        "dash": series.dash,
        "kind": kind,
        "x": series.x,
        "y": series.y,
        "low": low,
        "high": high,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_is_embedded_ends_its_script() {
        for (i, script) in SCRIPTS.iter().chain(MODULES.iter().map(|(_, text)| text)).enumerate() {
            let lower = script.to_lowercase();
            assert!(!lower.contains("</script") && !lower.contains("<!--"), "script {i}");
            assert!(script.len() < 1_000_000, "script {i}");
        }
        let all: usize = SCRIPTS.iter().chain(MODULES.iter().map(|(_, text)| text)).map(|text| text.len()).sum();
        assert!(all < 5_000_000, "{all}");
    }
}
