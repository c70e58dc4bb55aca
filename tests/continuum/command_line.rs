//! Continuum scenes as a user types them.

use crate::common::typed::{columns, comminute, number, run, same_files, summary};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use std::fs;

/// A few hundred points, fast.
const SMALL: [&str; 6] = [
    "grid.cell_mm=25.0",
    "test.axial_strain=0.05",
    "test.strain_per_wave=0.0004",
    "records.rows=100",
    "records.figures=false",
    "records.snapshots=false",
];

/// Refused before any work: exit code 2, and this on standard error.
fn refused(scene: &str, sets: &[&str], says: &[&str]) {
    let mut command = comminute("check");
    command.arg(format!("experiments/mpm/{scene}.toml"));
    for set in sets {
        command.args(["--set", set]);
    }
    let mut assert = command.assert().code(2);
    for text in says {
        assert = assert.stderr(contains(*text));
    }
}

/// 216 points: the peak of the law within 5 %, the same bytes for any number of threads and when stopped and resumed.
#[test]
fn a_small_triaxial_test_finds_its_peak_and_resumes_to_the_byte() {
    let folder = tempfile::tempdir().expect("folder");
    let whole = folder.path().join("whole");
    run("triaxial_fine_50kPa", &whole, &SMALL, &[]).assert().success();
    let s = summary(&whole);
    let (peak, law) = (number(&s, "peak_stress_ratio"), number(&s, "peak_stress_ratio_of_the_law"));
    assert!((law / 2.836 - 1.0).abs() < 0.01, "{law}");
    assert!((peak / law - 1.0).abs() < 0.05, "{peak} against {law}");
    assert!((0.01..0.05).contains(&number(&s, "peak_axial_strain")), "{s}");
    assert!(number(&s, "residual_stress_ratio") < peak, "{s}");

    let parts = folder.path().join("parts");
    let half = (number(&s, "steps") as u64 / 2).to_string();
    run("triaxial_fine_50kPa", &parts, &SMALL, &["--stop-after", &half]).assert().code(130);
    comminute("resume").arg(&parts).args(["--threads", "2", "--quiet"]).assert().success();
    same_files(&whole, &parts);
    assert_eq!(number(&summary(&parts), "peak_stress_ratio").to_bits(), peak.to_bits());
}

/// A level of accuracy says whether the platens have been as close to balance as it asks for: at a strain of 10⁻⁴ in the time of a wave, not at fifty times that, where the run
/// is warned of it.
#[test]
fn a_level_of_accuracy_is_held_to_the_balance_of_the_platens() {
    let folder = tempfile::tempdir().expect("folder");
    for (rate, kept) in [("0.0001", true), ("0.005", false)] {
        let out = folder.path().join(rate);
        let rate = format!("test.strain_per_wave={rate}");
        let mut command = comminute("run");
        command.args(["experiments/levels/continuum_oedometer.toml", "--accuracy", "draft", "--quiet", "--out"]).arg(&out);
        for set in [&rate, "test.axial_strain=0.01", "grid.cell_mm=7.5", "records.figures=false", "records.snapshots=false"] {
            command.args(["--set", set]);
        }
        command.assert().success();
        let s = summary(&out);
        assert_eq!((s["accuracy"]["level"].as_str(), s["accuracy"]["kept"].as_bool()), (Some("draft"), Some(kept)), "{s}");
        let warned = s["warnings"].as_array().is_some_and(|all| all.iter().any(|w| w.to_string().contains("accuracy")));
        assert_eq!(warned, !kept, "{s}");
    }
}

/// Where a specimen of the Mohr-Coulomb law deforms evenly it ends at N + 2 c √N / σ3, N = (1 + sin φ)/(1 − sin φ), and dilates at −2 sin ψ/(1 − sin ψ) of
/// logarithmic strains: with ψ near φ on 4 cells, and with the scene's ψ of 8° on 2 cells. On 4 cells such a ψ lets planes slide past each other, as it may where
/// ψ < φ, and the specimen ends below N, but above the strength of planes that can only slide, tan φ* = sin φ cos ψ/(1 − sin φ sin ψ) (Davis 1968).
#[test]
fn a_mohr_coulomb_specimen_fails_at_its_friction_and_dilates_at_its_angle() {
    let stress_ratio_and_dilation = |dilation_angle: f64, cell_mm: f64| {
        let folder = tempfile::tempdir().expect("folder");
        let out = folder.path().join("o");
        let mut command = comminute("run");
        command.args(["tests/golden/mohr_coulomb.toml", "--quiet"]);
        let sets = ["records.figures=false", "records.snapshots=false", "test.strain_per_wave=1e-4", "test.axial_strain=0.04"];
        let own = [format!("material.continuum.dilation_angle_deg={dilation_angle}"), format!("grid.cell_mm={cell_mm}")];
        for set in sets.into_iter().chain(own.iter().map(String::as_str)) {
            command.args(["--set", set]);
        }
        command.arg("--out").arg(&out).assert().success();
        let law = number(&summary(&out), "peak_stress_ratio_of_the_law");
        let (sine, psi) = (33f64.to_radians().sin(), dilation_angle.to_radians());
        let n = (1.0 + sine) / (1.0 - sine);
        assert!((law / (n + 2.0 * n.sqrt() / 50.0) - 1.0).abs() < 1e-12, "{law}");
        // over the second half of the test all strain is plastic
        let rows = columns(&out, ["axial_strain", "volumetric_strain", "principal_ratio"]);
        let second_half = &rows[rows.len() / 2..];
        let ([a0, v0, _], [a1, v1, _]) = (second_half[0], second_half[second_half.len() - 1]);
        let dilation = ((1.0 - v1) / (1.0 - v0)).ln() / ((1.0 - a1) / (1.0 - a0)).ln();
        let ratio = second_half.iter().map(|row| row[2]).sum::<f64>() / second_half.len() as f64;
        (ratio / law, dilation / (-2.0 * psi.sin() / (1.0 - psi.sin())))
    };
    for (dilation_angle, cell_mm) in [(25.0, 18.75), (8.0, 37.5)] {
        let (ratio, dilation) = stress_ratio_and_dilation(dilation_angle, cell_mm);
        assert!((ratio - 1.0).abs() < 2e-3 && (dilation - 1.0).abs() < 5e-3, "psi {dilation_angle}: {ratio} {dilation}");
    }
    let (ratio, dilation) = stress_ratio_and_dilation(8.0, 18.75);
    let (friction, psi) = (33f64.to_radians(), 8f64.to_radians());
    let sliding = (friction.sin() * psi.cos() / (1.0 - friction.sin() * psi.sin())).atan().sin();
    let n = |sine: f64| (1.0 + sine) / (1.0 - sine);
    assert!(ratio < 0.99 && ratio > n(sliding) / n(friction.sin()), "{ratio}");
    assert!((dilation - 1.0).abs() < 0.02, "{dilation}");
}

/// At constant volume an elastic specimen has q = 3 G ε_a and keeps its mean stress: G = E/(2 (1 + ν)), before the first yield; the equivalent pore pressure is
/// a third of q.
#[test]
fn a_triaxial_test_at_constant_volume_keeps_volume_and_mean_stress() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("o");
    // little PIC, which takes from the moduli
    let own = ["test.drainage=constant_volume", "test.axial_strain=0.004", "test.strain_per_wave=0.0002", "grid.pic=0.03"];
    let sets: Vec<&str> = own.into_iter().chain(SMALL.into_iter().filter(|s| !s.starts_with("test."))).collect();
    run("triaxial_fine_50kPa", &out, &sets, &[]).assert().success();
    let rows = columns(&out, ["axial_strain", "volumetric_strain", "q_kPa", "p_kPa", "pore_pressure_kPa"]);
    let [strain, _, q, p, pore] = rows[rows.len() - 1];
    assert!(rows.iter().all(|r| r[1].abs() < 2e-5), "{rows:?}");
    let shear = 4.6e3 / (2.0 * 1.12);
    assert!((q / (3.0 * shear * strain) - 1.0).abs() < 0.04, "{q} kPa at {strain}");
    assert!((p / 50.0 - 1.0).abs() < 0.01 && (pore / (q / 3.0) - 1.0).abs() < 0.05, "p {p} kPa, u {pore} kPa, q {q} kPa");
}

/// The modulus (1 − ν) E/((1 + ν)(1 − 2 ν)) and k0 = ν/(1 − ν) within 1 %.
#[test]
fn an_oedometer_finds_its_modulus() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("o");
    run(
        "oedometer",
        &out,
        &["records.figures=false", "records.snapshots=false", "test.axial_strain=0.02", "test.strain_per_wave=0.0004"],
        &[],
    )
    .assert()
    .success();
    let s = summary(&out);
    let (modulus, law) = (number(&s, "oedometric_modulus_MPa"), number(&s, "oedometric_modulus_of_the_law_MPa"));
    assert!((law - 13.4615).abs() < 1e-3, "{law}");
    assert!((modulus / law - 1.0).abs() < 0.01, "{modulus} against {law}");
    assert!((number(&s, "k0_final") / (0.3 / 0.7) - 1.0).abs() < 0.01, "{s}");
}

/// In a ring as in a box: the modulus within 2 %, k0 within 1 %, at a fiftieth of strain.
#[test]
fn an_oedometer_of_a_disc_finds_its_modulus() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("o");
    let sets = ["records.figures=false", "records.snapshots=false", "test.axial_strain=0.02", "test.strain_per_wave=0.0002"];
    run("oedometer_cylinder", &out, &sets, &[]).assert().success();
    let s = summary(&out);
    let (modulus, law) = (number(&s, "oedometric_modulus_MPa"), number(&s, "oedometric_modulus_of_the_law_MPa"));
    assert!((modulus / law - 1.0).abs() < 0.02, "{modulus} against {law}");
    assert!((number(&s, "k0_final") / (0.3 / 0.7) - 1.0).abs() < 0.01, "{s}");
    let rows = columns(&out, ["void_ratio", "axial_strain"]);
    let [e, strain] = rows[rows.len() - 1];
    // pores alone give way: the ring holds the width
    let whole = (1.0 + e) / (1.0 + rows[0][0]);
    assert!((whole - (1.0 - strain)).abs() < 5e-4, "{whole} of the volume at {strain}");
}

/// A cylinder in a shell: the peak of the law within 5 %, the cell pressure held, the same bytes when stopped and resumed.
#[test]
fn a_cylinder_is_sheared_in_its_shell() {
    let folder = tempfile::tempdir().expect("folder");
    let whole = folder.path().join("whole");
    let own = ["grid.cell_mm=18.75", "body[0].height_mm=75.0", "test.axial_strain=0.045", "test.strain_per_wave=0.0002"];
    let sets: Vec<&str> = own.into_iter().chain(["records.figures=false", "records.snapshots=false"]).collect();
    run("triaxial_cylinder", &whole, &sets, &[]).assert().success();
    let s = summary(&whole);
    let (peak, law) = (number(&s, "peak_stress_ratio"), number(&s, "peak_stress_ratio_of_the_law"));
    assert!((peak / law - 1.0).abs() < 0.05, "{peak} against {law}");
    let rows = columns(&whole, ["axial_strain", "sigma_3_kPa", "platen_difference"]);
    assert!(rows.iter().filter(|r| r[0] > 0.005).all(|r| (r[1] / 50.0 - 1.0).abs() < 0.03 && r[2] < 0.05), "{:?}", rows.last());

    let parts = folder.path().join("parts");
    let half = (number(&s, "steps") as u64 / 2).to_string();
    run("triaxial_cylinder", &parts, &sets, &["--stop-after", &half]).assert().code(130);
    comminute("resume").arg(&parts).args(["--threads", "2", "--quiet"]).assert().success();
    same_files(&whole, &parts);
}

/// A free scene leaves its records, figures and snapshots.
#[test]
fn a_plane_collapse_runs_out_and_leaves_its_records() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("c");
    run("column_collapse_2d", &out, &["grid.cell_mm=25.0", "duration_s=0.2", "records.frames=2"], &[]).assert().success();
    let s = summary(&out);
    assert!(number(&s, "front_mm") > 110.0 && number(&s, "height_mm") < 95.0, "{s}");
    for file in
        ["scene.resolved.toml", "history.csv", "points_final.csv", "snapshots.pvd", "figures/points.svg", "figures/run_out.svg"]
    {
        assert!(out.join(file).is_file(), "{file}");
    }
    let snapshots = fs::read_dir(out.join("snapshots")).expect("snapshots").count();
    assert_eq!(snapshots, 3);
    // the resolved scene repeats the run
    let again = folder.path().join("again");
    comminute("run").arg(out.join("scene.resolved.toml")).args(["--quiet", "--out"]).arg(&again).assert().success();
    assert_eq!(fs::read(out.join("history.csv")).expect("rows"), fs::read(again.join("history.csv")).expect("rows"));
}

#[test]
fn points_come_from_a_file() {
    let folder = tempfile::tempdir().expect("folder");
    let scene = |csv: &str| {
        fs::write(folder.path().join("p.csv"), csv).expect("points");
        let text = "kind = \"continuum\"\nsteps = 10\n[material]\nname = \"m\"\n[material.grain]\ndensity_kg_m3 = 2000.0\n\
                    [material.continuum]\nlaw = \"elastic\"\nE_MPa = 1.0\nnu = 0.2\n[[body]]\nshape = \"points\"\npoints_csv = \"p.csv\"\n\
                    [grid]\ncell_mm = 10.0\nmin_mm = [0.0, 0.0, 0.0]\nmax_mm = [100.0, 100.0, 100.0]\n";
        let path = folder.path().join("s.toml");
        fs::write(&path, text).expect("scene");
        let mut command = comminute("check");
        command.arg(path);
        command
    };
    scene("x_mm,y_mm,z_mm\n50,50,50\n60,50,50\n").assert().success().stderr(contains("points          2"));
    scene("x_mm,y_mm,z_mm\n50,50,500\n")
        .assert()
        .code(2)
        .stderr(contains("body[0]").and(contains("z = 500 mm, outside of the grid")));
    scene("x_mm,y_mm,z_mm\n50,abc,50\n").assert().code(2).stderr(contains("line 2").and(contains("y_mm = abc")));
    scene("x_mm,y_mm\n50,50\n").assert().code(2).stderr(contains("has no column z_m"));
    scene("x_mm,y_mm,z_mm\n").assert().code(2).stderr(contains("holds no points"));
}

#[test]
fn what_does_not_agree_is_refused_by_key_and_value() {
    let (t, c, o) = ("triaxial_fine_50kPa", "column_collapse_a055", "oedometer");
    refused(t, &["stepping.dt_s=0.01"], &["stepping.dt_s=0.01", "must be at most", "compression wave"]);
    refused(t, &["grid.x_low=stick"], &["grid.x_low", "sets its own sides"]);
    refused(t, &["gravity_m_s2=[0, 0, -9.81]"], &["gravity_m_s2", "must be [0, 0, 0]"]);
    refused(t, &["grid.cell_mm=11.0"], &["body[0].max_mm", "whole number of distances of two points", "along x it is 13.636364"]);
    refused(t, &["duration_s=1.0"], &["duration_s", "has no meaning with test.rig"]);
    refused(t, &["contact.law=hertz"], &["contact.law", "has no meaning in a continuum"]);
    refused(t, &["body[0].shape=sphere"], &["must be one [[body]] with shape = \"box\" or \"cylinder\""]);
    refused(t, &["test.rig=squeeze"], &["test.rig", "\"free\" or \"oedometer\" or \"triaxial\""]);
    let round = "triaxial_cylinder";
    refused(round, &["body[0].radius_mm=40.0"], &["body[0].radius_mm", "rings of a cylinder"]);
    refused(round, &["body[0].height_mm=100.0"], &["body[0].height_mm", "whole number of distances"]);
    refused(round, &["grid.plane_strain=true"], &["body[0].shape"]);
    refused(o, &["grid.cell_mm=8.0"], &["body[0].max_mm", "whole number of cells"]);
    refused(c, &["body[0].height_mm=900.0"], &["body[0]", "outside of the grid", "enlarge grid.min_mm"]);
    refused(c, &["body[0].radius_mm=0.5", "body[0].height_mm=0.5"], &["body[0]", "holds no point"]);
    refused(c, &["grid.max_mm=[305.0, 300.0, 80.0]"], &["grid.max_mm", "whole number of cells", "30.5"]);
    refused(c, &["grid.transfer=apic"], &["grid.pic", "has no meaning"]);
    refused(c, &["body[0].radius_m=1.0"], &["unknown key"]);
}
