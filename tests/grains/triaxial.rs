//! The drained triaxial test on a small specimen, as a user types it.

use assert_cmd::Command;
use std::fs;
use std::path::Path;

const SMALL: [&str; 9] = [
    "specimen.grains=300",
    "specimen.diameter_mm=10.5",
    "specimen.porosity=0.43",
    "preparation.porosity_tolerance=0.02",
    "preparation.growth_steps=2000",
    "loading.axial_strain=0.02",
    "loading.inertial_number=0.0005",
    "records.figures=false",
    "records.snapshots=false",
];

fn comminute(verb: &str) -> Command {
    let mut command = Command::cargo_bin("comminute").expect("the program");
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args([verb, "--threads", "1", "--quiet"]);
    command
}

fn run(out: &Path, more: &[&str]) -> Command {
    let mut command = comminute("run");
    command.arg("experiments/fontainebleau/triaxial-h.toml").arg("--out").arg(out).args(more);
    for set in SMALL {
        command.args(["--set", set]);
    }
    command
}

/// A column of the history.
fn column(out: &Path, name: &str) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(out.join("history.csv")).expect("history");
    let at = reader.headers().expect("header").iter().position(|h| h == name).expect(name);
    reader.records().map(|r| r.expect("row")[at].parse().expect("number")).collect()
}

#[test]
fn cell_pressure_is_held_strains_agree_with_the_walls_and_energy_closes() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("whole");
    let free = ["--set", "contact.rotation=free"];
    run(&out, &free).assert().success();
    let [cell, axial, radial, volume, void_ratio, q, angle] =
        ["sigma_h_kPa", "axial_strain", "radial_strain", "volumetric_strain", "void_ratio", "q_kPa", "friction_angle_deg"]
            .map(|name| column(&out, name));
    let last = axial.len() - 1;
    assert!(last >= 20 && (axial[last] - 0.02).abs() < 1e-4, "{axial:?}");
    for k in 0..=last {
        assert!((cell[k] / 100.0 - 1.0).abs() < 0.04, "cell pressure {} kPa", cell[k]);
        // two ways to the same volume: walls, and grains that keep theirs
        let by_walls = 1.0 - (1.0 - axial[k]) * (1.0 - radial[k]).powi(2);
        let by_grains = 1.0 - (1.0 + void_ratio[k]) / (1.0 + void_ratio[0]);
        assert!((volume[k] - by_walls).abs() < 1e-7 && (volume[k] - by_grains).abs() < 1e-7);
        let (v, h) = (cell[k] + q[k], cell[k]);
        assert!(((v - h) / (v + h) - angle[k].to_radians().sin()).abs() < 1e-6);
    }
    // spheres that turn, μ = 0.28
    assert!((10.0..25.0).contains(&angle[last]), "friction angle {}", angle[last]);
    let summary: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.join("summary.json")).expect("summary")).expect("JSON");
    assert!(summary["energy_error"].as_f64().expect("ledger").abs() < 1e-5, "{summary}");

    // the same, stopped in shear and continued
    let parts = folder.path().join("parts");
    let preparation = summary["preparation_steps"].as_u64().expect("steps");
    run(&parts, &[&free[..], &["--stop-after", &(preparation + 6000).to_string()]].concat()).assert().failure();
    comminute("resume").arg(&parts).assert().success();
    for file in ["history.csv", "gsd.csv", "specimen.csv", "grains_final.csv"] {
        assert!(fs::read(out.join(file)).expect(file) == fs::read(parts.join(file)).expect(file), "{file} differs");
    }
}

/// A level of accuracy sets what the scene does not have, and the summary says whether the platens were as close as it asks for: on the average of all steps.
#[test]
fn a_level_of_accuracy_is_told_and_judged() {
    let folder = tempfile::tempdir().expect("folder");
    let judged = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let mut command = comminute("run");
        command.args(["experiments/triaxial/petroleum_coke.toml", "--accuracy", "draft", "--out"]).arg(&out);
        for set in ["specimen.grains=200", "specimen.diameter_mm=110.0", "loading.axial_strain=0.01", "records.figures=false"] {
            command.args(["--set", set]);
        }
        command.args(more).assert().success();
        let text = fs::read_to_string(out.join("summary.json")).expect("summary");
        let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let warned =
            summary["warnings"].as_array().expect("warnings").iter().any(|w| w.to_string().contains("average of all steps"));
        let accuracy = summary["accuracy"].clone();
        let [found, most] = [&accuracy["mean_platen_difference"], &accuracy["promise"]["mean_platen_difference"]]
            .map(|x| x.as_f64().expect("a number"));
        assert_eq!((accuracy["kept"].as_bool(), warned), (Some(found <= most), found > most), "{accuracy}");
        found <= most
    };
    assert!(judged("draft", &[]));
    assert!(!judged("fast", &["--set", "loading.inertial_number=0.02"]), "what a scene sets itself wins, and is judged");
}

/// Energies stand against strain, since the stress falls after its peak, and no line of a k0 is drawn.
#[test]
fn figures_are_those_of_shear() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("run");
    run(&out, &[]).assert().success();
    Command::cargo_bin("comminute").expect("the program").arg("plot").arg(&out).assert().success();
    let text = |name: &str| fs::read_to_string(out.join("figures").join(name)).expect(name);
    assert!(text("energy.csv").lines().next().is_some_and(|head| head.contains("axial_strain_percent")));
    assert!(!text("stress_path.csv").contains("k_{0}"));
}

#[test]
fn keys_of_the_oedometer_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let output = run(&folder.path().join("x"), &["--set", "loading.rate=0.1"]).assert().code(2);
    let text = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(text.contains("loading.rate") && text.contains("has no meaning in a triaxial test"), "{text}");
}

/// Grains kept from turning are stronger in shear.
#[test]
fn grains_that_do_not_turn_bear_more() {
    let folder = tempfile::tempdir().expect("folder");
    let [free, fixed] = ["free", "fixed"].map(|rotation| {
        let out = folder.path().join(rotation);
        run(&out, &["--set", &format!("contact.rotation={rotation}")]).assert().success();
        column(&out, "friction_angle_deg").last().copied().expect("a row")
    });
    assert!(fixed > free + 5.0, "{fixed} against {free}");
}
