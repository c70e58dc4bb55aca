//! The results of a run in words, and its warnings: what the command prints when a run ends and what reports show.

use serde_json::Value;

/// Results of a run of any kind in one line; empty if the summary has none.
pub fn results(summary: &Value) -> String {
    if !has_points(summary) {
        return specimen(summary);
    }
    let ratio = summary["peak_stress_ratio"].as_f64().map(|r| format!("peak σ1/σ3 {r:.4}"));
    ratio.into_iter().chain(Some(breakage(summary)).filter(|b| !b.is_empty())).collect::<Vec<String>>().join(", ")
}

/// The lines in which a run of any kind says what it has done and found.
pub fn closing(summary: &Value) -> Vec<String> {
    let number = |key: &str| summary.get(key).and_then(Value::as_f64);
    let count = |key: &str| number(key).map_or("?".into(), |x| format!("{x}"));
    let seconds = number("wall_seconds").map_or("?".into(), |s| format!("{s:.1}"));
    if summary.get("tests").is_some() {
        let worst = |key: &str| number(key).map_or("?".into(), |x| format!("{:.2e}", x));
        return vec![format!(
            "{} grains pressed, {} broke; forces within {} of Hertz and {} of their limits, {seconds} s",
            count("tests"),
            count("crush_events"),
            worst("largest_hertz_deviation"),
            worst("largest_overshoot"),
        )];
    }
    let (found, done) = if has_points(summary) {
        let ratio = number("peak_stress_ratio").map_or(String::new(), |r| format!(", peak σ1/σ3 {r:.4}"));
        let present = |key: &&str| number(key).is_some_and(|n| n > 0.0);
        let parts = ["points", "grains", "blocks"].into_iter().filter(present).map(|key| format!("{} {key}", count(key)));
        let parts = parts.collect::<Vec<String>>().join(" and ");
        (breakage(summary), format!("{} steps of {parts}{ratio}, {seconds} s", count("steps")))
    } else {
        let done = format!(
            "{} steps, {} crush events, {} grains from {}, {seconds} s",
            count("steps"),
            count("crush_events"),
            count("grains_final"),
            count("grains_initial"),
        );
        (specimen(summary), done)
    };
    Some(found).filter(|found| !found.is_empty()).into_iter().chain([done]).collect()
}

/// What a reader of the results must know: the warnings that the run has noted, and those that follow from its numbers.
pub fn warnings(summary: &Value) -> Vec<String> {
    let number = |key: &str| summary.get(key).and_then(Value::as_f64);
    let mut warnings: Vec<String> = texts(&summary["warnings"]);
    if has_points(summary) {
        if let Some(share) = number("dissipated_share").filter(|share| *share < 0.0) {
            warnings.push(format!("dissipated_share = {share:.3}: more energy came out of the specimen than went in"));
        }
        return warnings;
    }
    if let Some(kpa) = summary.pointer("/below_least_void_ratio/sigma_v_kPa").and_then(Value::as_f64) {
        let ended = if summary.get("ended_early").is_some() { "; the run ended there" } else { "" };
        let least = number("least_void_ratio").unwrap_or(f64::NAN);
        warnings.push(format!("from {kpa:.0} kPa on the void ratio is below {least}, which fines cannot fill{ended}"));
    }
    if let Some(beyond) = number("einav_beyond").filter(|b| *b > 0.01) {
        warnings.push(format!(
            "the gradation is finer than Einav's ultimate one by {beyond:.2} of the area that B_r is counted over (einav_beyond)"
        ));
    }
    if let Some(rises) = number("energy_rises").filter(|&n| n > 0.0) {
        warnings.push(format!("after {rises} breakages more elastic energy was stored around the event than before"));
    }
    warnings
}

/// Where a continuum or mixture is outside of what its method is known to do, as the command says before the run.
pub fn doubts(summary: &Value) -> Vec<String> {
    [&summary["outside_of_the_method"], &summary["viscous"]].into_iter().flat_map(texts).collect()
}

/// A text, or those of a list.
fn texts(value: &Value) -> Vec<String> {
    let all = value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice);
    all.iter().filter_map(|text| text.as_str().map(str::to_string)).collect()
}

/// Whether a summary is that of a continuum or a mixture.
fn has_points(summary: &Value) -> bool {
    summary["kind"] == "continuum" || summary["kind"] == "mixture"
}

/// Results of an oedometer or triaxial test in one line, as `up to 1000 kPa, e = 0.461, k0 = 0.550`; empty if the summary has none.
fn specimen(summary: &Value) -> String {
    let number = |key: &str| summary.get(key).and_then(Value::as_f64);
    let parts = [
        number("max_measured_stress_kPa").map(|s| format!("up to {s:.0} kPa")),
        number("void_ratio_final").map(|e| format!("e = {e:.3}")),
        number("k0_final").map(|k| format!("k0 = {k:.3}")),
        number("axial_strain_final").map(|s| format!("axial strain {:.2} %", 100.0 * s)),
        number("hardin_br").map(|b| format!("B_r {b:.3} (Hardin)")),
        number("einav_br").map(|b| format!("{b:.3} (Einav)")),
    ];
    parts.into_iter().flatten().collect::<Vec<String>>().join(", ")
}

/// Breakages of a mixture in one line, as `3 breakages, 0.120 g lost`, with B_r; empty if nothing can break.
fn breakage(summary: &Value) -> String {
    let number = |key: &str| summary.get(key).and_then(Value::as_f64);
    let parts = [
        number("crush_events").map(|n| format!("{n} breakage{}", if n == 1.0 { "" } else { "s" })),
        number("mass_lost_kg").map(|m| format!("{:.3} g lost", 1e3 * m)),
        number("hardin_br").map(|b| format!("B_r {b:.3} (Hardin)")),
        number("einav_br").map(|b| format!("{b:.3} (Einav)")),
    ];
    parts.into_iter().flatten().collect::<Vec<String>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_run_tells_what_it_has_moved() {
        let told = |points: u32, grains: u32, blocks: Option<u32>| {
            let mut summary = json!({ "kind": "mixture", "steps": 7, "points": points, "grains": grains, "wall_seconds": 2.0 });
            if let Some(blocks) = blocks {
                summary["blocks"] = json!(blocks);
            }
            closing(&summary)
        };
        assert_eq!(told(5, 2, None), ["7 steps of 5 points and 2 grains, 2.0 s"]);
        assert_eq!(told(0, 0, Some(3)), ["7 steps of 3 blocks, 2.0 s"]);
    }
}
