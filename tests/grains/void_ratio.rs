//! One void ratio, the laboratory's: the mass that breakage takes out of the grains stays solid. As a user runs it.

use crate::common::*;
use assert_cmd::Command;
use std::fs;
use std::path::Path;

fn run(scene: &Path, out: &Path, sets: &[&str]) -> String {
    let mut command = Command::cargo_bin("comminute").expect("the program");
    command.arg("run").arg(scene).arg("--out").arg(out).args(["--threads", "1"]);
    for set in sets {
        command.args(["--set", set]);
    }
    let output = command.assert().success().get_output().clone();
    String::from_utf8(output.stderr).expect("text")
}

fn column(out: &Path, name: &str) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(out.join("history.csv")).expect("history");
    let at = reader.headers().expect("header").iter().position(|h| h == name).expect(name);
    reader.records().map(|r| r.expect("row")[at].parse().unwrap_or(f64::NAN)).collect()
}

fn read_summary(out: &Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(out.join("summary.json")).expect("summary")).expect("json")
}

/// In an oedometer e follows from the height alone, 1 + e = (1 + e0)(1 - ε_a), however many grains break.
#[test]
fn void_ratio_is_that_of_all_dry_mass_and_a_run_ends_below_the_least() {
    let folder = tempfile::tempdir().expect("folder");
    let scene = folder.path().join("scene.toml");
    fs::write(&scene, oedometer_text(120, 400.0, "")).expect("scene");
    let crushing = ["crushing.enabled=true", "material.strength.fixed_angle.sigma_lim0_MPa=100", "records.snapshots=false"];
    let whole = folder.path().join("whole");
    let said = run(&scene, &whole, &[&crushing[..], &["records.least_void_ratio=0.001"]].concat());
    assert!(!said.contains("least_void_ratio"), "{said}");
    let [e, grains, strain, stress] = ["void_ratio", "void_ratio_grains", "axial_strain", "sigma_v_kPa"].map(|c| column(&whole, c));
    let events = column(&whole, "crush_events");
    assert!(events.last().is_some_and(|n| *n > 30.0));
    for k in 0..e.len() {
        near("void ratio by the height", 1.0 + e[k], (1.0 + e[0]) * (1.0 - strain[k]), 1e-7);
        assert!(if events[k] > 0.0 { grains[k] > e[k] } else { grains[k] == e[k] });
    }
    for name in ["hardin_br", "einav_br"] {
        assert!(column(&whole, name).iter().all(|b| (0.0..=1.0).contains(b)), "{name}");
    }

    let least = 0.5 * (e[0] + e[e.len() - 1]);
    let first = e.iter().position(|e| *e < least).expect("passed");
    let out = folder.path().join("ended");
    let sets = [format!("records.least_void_ratio={least}"), "records.end_below_least_void_ratio=true".into()];
    let said = run(&scene, &out, &[&crushing[..], &[sets[0].as_str(), sets[1].as_str()]].concat());
    assert_eq!(said.matches("below records.least_void_ratio").count(), 1, "{said}");
    assert_eq!(column(&out, "void_ratio"), e[..=first], "the same records up to there");
    let summary = read_summary(&out);
    near(
        "stress of the first record below",
        summary["below_least_void_ratio"]["sigma_v_kPa"].as_f64().expect("kPa"),
        stress[first],
        1e-5,
    );
    assert!(summary["ended_early"].is_string() && !out.join("checkpoint.bin").exists());
    let gsd = fs::read_to_string(out.join("gsd.csv")).expect("gradations");
    assert!(gsd.starts_with("step,stage,sigma_v_kPa,axial_strain,diameter_mm,") && gsd.contains(",load,"));
}

/// Weak grains without inner pores whose lost mass bears nothing: solids soon fill more than the whole volume.
#[test]
fn a_run_stops_itself_where_solids_fill_more_than_the_whole_volume() {
    let folder = tempfile::tempdir().expect("folder");
    let scene = folder.path().join("scene.toml");
    fs::write(&scene, oedometer_text(70, 215.0, "")).expect("scene");
    let weak = [
        "crushing.enabled=true",
        "material.strength.fixed_angle.sigma_lim0_MPa=20",
        "material.grain.internal_porosity=0",
        "records.snapshots=false",
        "specimen.diameter_mm=150",
    ];
    let out = folder.path().join("stopped");
    let mut command = Command::cargo_bin("comminute").expect("the program");
    command.arg("run").arg(&scene).arg("--out").arg(&out).args(["--threads", "1"]);
    for set in weak {
        command.args(["--set", set]);
    }
    let said = String::from_utf8(command.assert().code(3).get_output().stderr.clone()).expect("text");
    assert!(said.contains("fill more than the whole volume") && said.contains("records.stop_without_voids = false"), "{said}");
    let e = column(&out, "void_ratio");
    assert!(e[e.len() - 1] < 0.0 && e[..e.len() - 1].iter().all(|e| *e >= 0.0), "all records up to there");
    let gsd = fs::read_to_string(out.join("gsd.csv")).expect("gradations");
    assert!(gsd.lines().count() > 20, "a gradation at the start and at the stop");

    // a run that goes on says in its summary where that was
    let on = folder.path().join("on");
    run(&scene, &on, &[&weak[..], &["records.stop_without_voids=false"]].concat());
    let (e, sigma) = (column(&on, "void_ratio_star"), column(&on, "sigma_v_kPa"));
    let first = e.iter().position(|e| *e < 0.0).expect("a record without voids");
    let summary = read_summary(&on);
    let said = &summary["without_voids"];
    for (key, expected) in [
        ("last_with_voids_kPa", sigma[first - 1]),
        ("sigma_v_kPa", sigma[first]),
        ("porosity_star", column(&on, "porosity_star")[first]),
        ("axial_strain", column(&on, "axial_strain")[first]),
    ] {
        close(key, said[key].as_f64().expect("a number"), expected, 1e-6);
    }
    let warned = summary["warnings"].as_array().expect("warnings").iter().filter_map(|w| w.as_str());
    let last = format!("last above 0 at {:.0} kPa", sigma[first - 1]);
    assert_eq!(warned.filter(|w| w.contains("mass restored") && w.contains(&last)).count(), 1, "{}", summary["warnings"]);

    // stronger grains keep their voids, and nothing is said
    let strong = folder.path().join("strong");
    let of_its_own_strength: Vec<&str> = weak.into_iter().filter(|set| !set.contains("strength")).collect();
    run(&scene, &strong, &of_its_own_strength);
    assert!(column(&strong, "void_ratio_star").iter().all(|e| *e > 0.0));
    assert!(read_summary(&strong)["without_voids"].is_null());
}
