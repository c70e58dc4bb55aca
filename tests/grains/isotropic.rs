//! Isotropic compression of a small specimen with unloading and reloading, as a user types it.

use assert_cmd::Command;
use std::fs;
use std::path::Path;

const SCENE: &str = "experiments/isotropic/petroleum_coke.toml";
const SMALL: [&str; 9] = [
    "specimen.grains=120",
    "specimen.diameter_mm=110",
    "specimen.porosity=0.45",
    "preparation.porosity_tolerance=0.02",
    "loading.max_stress_kPa=600",
    "loading.stages_kPa=[60, 700]",
    "records.at_kPa=[]",
    "records.figures=false",
    "records.snapshots=false",
];

fn comminute(verb: &str) -> Command {
    let mut command = Command::cargo_bin("comminute").expect("the program");
    command.current_dir(env!("CARGO_MANIFEST_DIR")).arg(verb);
    command
}

fn run(out: &Path, threads: &str, more: &[&str]) -> Command {
    let mut command = comminute("run");
    command.args([SCENE, "--quiet", "--threads", threads, "--out"]).arg(out);
    for set in SMALL {
        command.args(["--set", set]);
    }
    command.args(more);
    command
}

fn text(out: &Path, name: &str) -> Vec<String> {
    let mut reader = csv::Reader::from_path(out.join("history.csv")).expect("history");
    let at = reader.headers().expect("header").iter().position(|h| h == name).expect(name);
    reader.records().map(|r| r.expect("row")[at].to_string()).collect()
}

fn column(out: &Path, name: &str) -> Vec<f64> {
    text(out, name).iter().map(|x| x.parse().expect("number")).collect()
}

/// Platens and shell hold one stress through loading, unloading and reloading; strains are those of the walls; unloading and reloading are stiffer than first loading; a run
/// that is stopped and continued, on other threads, leaves the same bytes.
#[test]
fn one_stress_on_all_sides_through_every_stage() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("whole");
    run(&out, "1", &[]).assert().success();
    let [target, v, h, axial, radial, volume, void_ratio] =
        ["target_kPa", "sigma_v_kPa", "sigma_h_kPa", "axial_strain", "radial_strain", "volumetric_strain", "void_ratio"]
            .map(|name| column(&out, name));
    let stages = text(&out, "stage");
    let mut off: Vec<f64> = Vec::new();
    for k in 0..target.len() {
        off.extend([v[k], h[k]].map(|stress| (stress / target[k] - 1.0).abs()));
        let by_walls = 1.0 - (1.0 - axial[k]) * (1.0 - radial[k]).powi(2);
        let by_voids = 1.0 - (1.0 + void_ratio[k]) / (1.0 + void_ratio[0]);
        assert!((volume[k] - by_walls).abs() < 1e-7 && (volume[k] - by_voids).abs() < 1e-7);
    }
    // the programme waits where platens or shell are 1.5 % off; a breakage takes them further for a while
    off.sort_by(f64::total_cmp);
    assert!(off[off.len() * 9 / 10] < 0.02 && off[off.len() - 1] < 0.3, "{off:?}");
    // compression index of a stage: fall of the void ratio per decade of stress
    let index = |stage: &str| {
        let rows: Vec<usize> =
            (0..stages.len()).filter(|&k| stages[k] == stage && target[k] > 200.0 && target[k] < 590.0).collect();
        let (first, last) = (rows[0], rows[rows.len() - 1]);
        (void_ratio[first] - void_ratio[last]) / (target[last] / target[first]).log10()
    };
    let (load, unload, reload) = (index("load"), index("unload"), index("reload"));
    assert!(load > 1.5 * unload && load > 1.5 * reload && unload > 0.0 && reload > 0.0, "{load} {unload} {reload}");
    let summary: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.join("summary.json")).expect("summary")).expect("JSON");
    assert!(summary["energy_error"].as_f64().expect("ledger").abs() < 1e-4, "{summary}");
    assert!(summary["held_every_step"]["largest_inertial_number"].as_f64().expect("held") < 1e-3, "{summary}");

    let parts = folder.path().join("parts");
    let steps = summary["steps"].as_u64().expect("steps") + summary["preparation_steps"].as_u64().expect("steps");
    run(&parts, "1", &["--stop-after", &(steps - 3000).to_string()]).assert().failure();
    comminute("resume").args(["--quiet", "--threads", "3"]).arg(&parts).assert().success();
    for file in ["history.csv", "gsd.csv", "specimen.csv", "grains_final.csv"] {
        assert!(fs::read(out.join(file)).expect(file) == fs::read(parts.join(file)).expect(file), "{file} differs");
    }
}

/// Void ratio against stress with its branches, as for an oedometer, and volumetric strain; nothing that belongs to shear.
#[test]
fn figures_are_those_of_compression() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("run");
    run(&out, "2", &["--set", "loading.stages_kPa=[150]"]).assert().success();
    comminute("plot").arg(&out).assert().success();
    let drawn = |name: &str| out.join("figures").join(name).exists();
    for name in ["void_ratio.svg", "void_ratio_mean_stress.svg", "volumetric_strain.svg", "gradation.svg"] {
        assert!(drawn(name), "{name}");
    }
    assert!(!drawn("deviatoric_stress.svg") && !drawn("k0.svg"));
}

#[test]
fn what_does_not_agree_is_refused_before_anything_starts() {
    for (set, says) in [
        ("loading.max_stress_kPa=4", "must be > 5"),
        ("loading.stages_kPa=[600]", "must each differ from the stress before it"),
        ("walls.friction.cylinder=0.2", "would carry a part of the platens"),
        ("loading.rate=0.1", "has no meaning in isotropic compression"),
        ("loading.axial_strain=0.1", "has no meaning in isotropic compression"),
    ] {
        let folder = tempfile::tempdir().expect("folder");
        let output = run(&folder.path().join("x"), "1", &["--set", set]).assert().code(2);
        let text = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
        assert!(text.contains(says), "{set}: {text}");
    }
}
