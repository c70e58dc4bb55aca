//! `--backend` as a user types it: the same scenes on both backends within stated bands, bits after a stop, refusals, and what is kept when it goes wrong.

use crate::adapter::adapter;
use crate::common::ROOT;
use crate::common::typed::{columns, comminute, number, run, same_files, summary};
use comminute::gpu;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use std::path::Path;

const PLAIN: [&str; 2] = ["records.figures=false", "records.snapshots=false"];

/// A scene on the processor and on the device, in folders of these names.
pub fn both(folder: &Path, scene: &str, sets: &[&str]) -> [std::path::PathBuf; 2] {
    ["cpu", "gpu"].map(|backend| {
        let out = folder.join(backend);
        run(scene, &out, &[&PLAIN[..], sets].concat(), &["--backend", backend]).assert().success();
        assert_eq!(summary(&out)["backend"], backend);
        out
    })
}

/// Largest distance of the device's rows from the processor's curve of a column over another, as a share of the column's largest value.
pub fn apart([cpu, gpu]: &[std::path::PathBuf; 2], over: &str, column: &str) -> f64 {
    let (here, there) = (columns(cpu, [over, column]), columns(gpu, [over, column]));
    assert!(here.len() > 50 && here.len().abs_diff(there.len()) < 3, "{} and {} rows", here.len(), there.len());
    let largest = here.iter().map(|[_, y]| y.abs()).fold(0.0, f64::max);
    let off = |[x, y]: &[f64; 2]| {
        let around = here.windows(2).find(|w| w[0][0] <= *x && *x <= w[1][0])?;
        let ([x0, y0], [x1, y1]) = (around[0], around[1]);
        Some((y - (y0 + (y1 - y0) * (x - x0) / (x1 - x0).max(f64::MIN_POSITIVE))).abs())
    };
    let off: Vec<f64> = there.iter().filter_map(off).collect();
    assert!(off.len() + 5 > there.len(), "the rows lie on the same stretch");
    off.into_iter().fold(0.0, f64::max) / largest
}

/// Relative distance of a number of the summaries.
fn of(outs: &[std::path::PathBuf; 2], key: &str) -> f64 {
    let [cpu, gpu] = outs.each_ref().map(|out| number(&summary(out), key));
    (gpu / cpu - 1.0).abs()
}

/// Rung 4: 512 points, most of the first percent of strain of Li's fine soil at 50 kPa. Measured: q 1.0e-5 of the largest, volumetric strain 2e-7, largest
/// σ1/σ3 1e-7.
#[test]
fn the_first_percent_of_a_triaxial_test_is_that_of_the_cpu() {
    if !adapter("the_first_percent_of_a_triaxial_test_is_that_of_the_cpu") {
        return;
    }
    let folder = tempfile::tempdir().expect("folder");
    let outs = both(folder.path(), "triaxial_fine_small", &["test.axial_strain=0.006"]);
    let q = apart(&outs, "axial_strain", "q_kPa");
    let volume = apart(&outs, "axial_strain", "volumetric_strain");
    let (peak, end) = (of(&outs, "peak_stress_ratio"), of(&outs, "peak_axial_strain"));
    println!("rung 4, triaxial, 0.6 %: q {q:e}, volumetric strain {volume:e}, largest ratio {peak:e} at {end:e}");
    assert!(q < 1e-4 && volume < 1e-4 && peak < 1e-3 && end < 3e-3);
    let s = summary(&outs[1]);
    assert_eq!(s["points"], 512);
    let adapter = gpu::available().expect("an adapter");
    assert_eq!((s["adapter"].as_str(), s["adapter_is_software"].as_bool()), (Some(adapter.name.as_str()), Some(adapter.software)));
    assert!(number(&s, "bytes_per_point") > 180.0);
}

/// 216 points through yield, peak and softening.
const TO_5_PERCENT: [&str; 3] = ["grid.cell_mm=25.0", "test.axial_strain=0.05", "test.strain_per_wave=0.0008"];

/// Rung 4 through yield, peak and softening, a row for each step so that no means are compared with others. Measured: q 1.5e-5 of the largest, volumetric strain
/// 2e-6, peak ratio 4e-7.
#[test]
fn a_triaxial_test_peaks_as_on_the_cpu() {
    if !adapter("a_triaxial_test_peaks_as_on_the_cpu") {
        return;
    }
    let folder = tempfile::tempdir().expect("folder");
    let outs = both(folder.path(), "triaxial_fine_50kPa", &[&TO_5_PERCENT[..], &["records.rows=5000"]].concat());
    let q = apart(&outs, "axial_strain", "q_kPa");
    let volume = apart(&outs, "axial_strain", "volumetric_strain");
    let (peak, residual) = (of(&outs, "peak_stress_ratio"), of(&outs, "residual_stress_ratio"));
    println!("rung 4, triaxial, 5 %: q {q:e}, volumetric strain {volume:e}, peak ratio {peak:e}, residual ratio {residual:e}");
    assert!(q < 5e-4 && volume < 3e-5 && peak < 1e-5 && residual < 1e-4);
    let s = summary(&outs[1]);
    assert!(number(&s, "peak_stress_ratio") > 2.7 && number(&s, "peak_axial_strain") < 0.045, "{s}");
}

/// Rung 4 of the pyramid of Mohr and Coulomb: 512 points that deform evenly, to failure and beyond, a row for each step. Without local damping, which goes by the sign
/// of velocities and makes rounding visible (q 2e-4 then). Measured: q 1.1e-5 of the largest, volumetric strain 3e-6, peak ratio 9e-8.
#[test]
fn a_mohr_coulomb_specimen_fails_as_on_the_cpu() {
    if !adapter("a_mohr_coulomb_specimen_fails_as_on_the_cpu") {
        return;
    }
    let folder = tempfile::tempdir().expect("folder");
    let sets = [
        "records.rows=5000",
        "test.strain_per_wave=0.0004",
        "test.axial_strain=0.02",
        "material.continuum.dilation_angle_deg=25",
        "damping.local=0.0",
    ];
    let outs = both(folder.path(), "../tests/golden/mohr_coulomb", &sets);
    let q = apart(&outs, "axial_strain", "q_kPa");
    let volume = apart(&outs, "axial_strain", "volumetric_strain");
    let peak = of(&outs, "peak_stress_ratio");
    println!("rung 4, Mohr-Coulomb, triaxial, 2 %: q {q:e}, volumetric strain {volume:e}, peak ratio {peak:e}");
    assert!(q < 1e-4 && volume < 3e-5 && peak < 1e-5);
    let s = summary(&outs[1]);
    let reached = number(&s, "peak_stress_ratio") / number(&s, "peak_stress_ratio_of_the_law");
    assert!((reached - 1.0).abs() < 0.02, "{reached}");
}

/// Rung 4 of cylinders in a shell that holds the cell pressure (from the state after 300 steps of the processor, in which it has come to rest) or the width, without
/// local damping, a row for each step; and the same bytes after a stop. Measured: triaxial q 4.7e-5 of the largest, volumetric strain 5e-6; oedometer, whose ring the
/// device drives anew at looks, stresses 1.5e-5.
#[test]
fn cylinders_are_those_of_the_cpu() {
    if !adapter("cylinders_are_those_of_the_cpu") {
        return;
    }
    let folder = tempfile::tempdir().expect("folder");
    let small = ["grid.cell_mm=18.75", "body[0].height_mm=75.0", "test.strain_per_wave=0.0004"];
    let finely = ["damping.local=0.0", "records.rows=5000"];
    let outs = crate::mixture::both(
        folder.path(),
        "triaxial_cylinder",
        &[&small[..], &finely, &["test.axial_strain=0.0045"]].concat(),
        "300",
    );
    let q = apart(&outs, "axial_strain", "q_kPa");
    let volume = apart(&outs, "axial_strain", "volumetric_strain");
    println!("rung 4, triaxial test of a cylinder: q {q:e}, volumetric strain {volume:e}");
    assert!(q < 1e-4 && volume < 3e-5);

    let disc = folder.path().join("disc");
    std::fs::create_dir(&disc).expect("folder");
    let sets = [&finely[..], &["test.axial_strain=0.002", "test.strain_per_wave=0.0004"]].concat();
    let outs = both(&disc, "oedometer_cylinder", &sets);
    let [axial, lateral] = ["sigma_v_kPa", "sigma_h_kPa"].map(|stress| apart(&outs, "axial_strain", stress));
    println!("rung 4, oedometer of a disc: σv {axial:e}, σh {lateral:e}");
    assert!(axial < 1e-4 && lateral < 1e-4);

    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
    let sets = [&PLAIN[..], &small, &["test.axial_strain=0.001"]].concat();
    run("triaxial_cylinder", &whole, &sets, &["--backend", "gpu"]).assert().success();
    run("triaxial_cylinder", &parts, &sets, &["--backend", "gpu", "--stop-after", "201"]).assert().code(130);
    comminute("resume").arg(&parts).arg("--quiet").assert().success();
    same_files(&whole, &parts);
}

/// A run that was stopped and goes on leaves the same bytes; one that began on the processor goes on on the device, and back.
#[test]
fn a_triaxial_test_resumes_to_the_byte() {
    if !adapter("a_triaxial_test_resumes_to_the_byte") {
        return;
    }
    let folder = tempfile::tempdir().expect("folder");
    let sets = [&TO_5_PERCENT[..], &PLAIN, &["records.rows=50", "test.axial_strain=0.010"]].concat();
    let [whole, parts, mixed] = ["whole", "parts", "mixed"].map(|name| folder.path().join(name));
    run("triaxial_fine_50kPa", &whole, &sets, &["--backend", "gpu"]).assert().success();
    // in the settling, on a multiple of 64, between looks
    run("triaxial_fine_50kPa", &parts, &sets, &["--backend", "gpu", "--stop-after", "30"]).assert().code(130);
    for steps in ["320", "401"] {
        comminute("resume").arg(&parts).args(["--quiet", "--stop-after", steps]).assert().code(130);
    }
    comminute("resume").arg(&parts).arg("--quiet").assert().success();
    same_files(&whole, &parts);
    assert_eq!(summary(&parts)["backend"], "gpu");

    run("triaxial_fine_50kPa", &mixed, &sets, &["--stop-after", "250"]).assert().code(130);
    comminute("resume").arg(&mixed).args(["--quiet", "--backend", "gpu", "--stop-after", "400"]).assert().code(130);
    comminute("resume").arg(&mixed).args(["--quiet", "--backend", "cpu"]).assert().success();
    assert_eq!(summary(&mixed)["backend"], "cpu, then gpu, then cpu");
    let apart = of(&[whole, mixed], "peak_stress_ratio");
    println!("cpu, then gpu, then cpu: peak ratio {apart:e}");
    assert!(apart < 1e-3);
}

/// Rung 4: 768 points of an elastic soil under a platen, whose step follows the platen's contacts. Measured: stresses 1.5e-6 of the largest, modulus 7e-7.
#[test]
fn an_oedometer_is_that_of_the_cpu() {
    if !adapter("an_oedometer_is_that_of_the_cpu") {
        return;
    }
    let sets = ["grid.cell_mm=10.0", "test.axial_strain=0.02", "test.strain_per_wave=0.0004"];
    let folder = tempfile::tempdir().expect("folder");
    let outs = both(folder.path(), "oedometer", &sets);
    let [axial, lateral] = ["sigma_v_kPa", "sigma_h_kPa"].map(|stress| apart(&outs, "axial_strain", stress));
    let (modulus, k0) = (of(&outs, "oedometric_modulus_MPa"), of(&outs, "k0_final"));
    println!("rung 4, oedometer: σv {axial:e}, σh {lateral:e}, modulus {modulus:e}, k0 {k0:e}");
    assert!(axial < 2e-5 && lateral < 2e-5 && modulus < 1e-5 && k0 < 1e-5);
}

/// Rung 4: a quarter of a column collapses on a rough floor, 208 points. Measured over 0.15 s: front 3e-8 of its place, kinetic energy 1e-6 of the largest, plastic
/// strain 4e-7. Stopped between two looks it resumes to the byte.
#[test]
fn a_column_collapses_as_on_the_cpu() {
    if !adapter("a_column_collapses_as_on_the_cpu") {
        return;
    }
    let sets = ["grid.cell_mm=25.0", "grid.max_mm=[300.0, 300.0, 75.0]", "duration_s=0.15"];
    let folder = tempfile::tempdir().expect("folder");
    let outs = both(folder.path(), "column_collapse_a055", &sets);
    let [front, kinetic, plastic] = ["front_mm", "kinetic_J", "plastic_strain_mean"].map(|c| apart(&outs, "time_s", c));
    println!("rung 4, collapse: front {front:e}, kinetic {kinetic:e}, plastic strain {plastic:e}");
    assert!(front < 1e-6 && kinetic < 2e-5 && plastic < 1e-5);
    assert_eq!(summary(&outs[0])["steps"], summary(&outs[1])["steps"]);
    assert!(number(&summary(&outs[1]), "front_mm") > 105.0, "it has collapsed");
    let parts = folder.path().join("parts");
    let sets = [&PLAIN[..], &sets].concat();
    run("column_collapse_a055", &parts, &sets, &["--backend", "gpu", "--stop-after", "301"]).assert().code(130);
    comminute("resume").arg(&parts).arg("--quiet").assert().success();
    same_files(&outs[1], &parts);
}

/// Refused before anything is written: exit code 2, these words, no folder.
fn refused(scene: &str, sets: &[&str], says: &[&str]) {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let mut assert = run(scene, &out, sets, &["--backend", "gpu"]).assert().code(2);
    for text in says {
        assert = assert.stderr(contains(*text));
    }
    assert!(!out.exists());
}

#[test]
fn what_the_device_lacks_is_refused_by_name_before_it_starts() {
    refused("column_collapse_2d", &[], &["gpu: grid.plane_strain = true: is not available on the GPU"]);
    refused("column_collapse_a055", &["grid.transfer=apic", "grid.pic=0.0"], &["gpu: grid.transfer = apic: is not available"]);
    refused("triaxial_fine_small", &["grid.shape_functions=gimp"], &["gpu: grid.shape_functions = gimp: is not available"]);
    refused(
        "petroleum_coke/h-c-2",
        &[],
        &["gpu: computes continuum and mixture scenes only: grains alone are computed on the CPU"],
    );
    refused("platen/silica", &[], &["gpu: computes continuum and mixture scenes only", "--backend cpu"]);
    if adapter("what_the_device_lacks_is_refused_by_name_before_it_starts") {
        let wide = "grid.max_mm=[100000.0, 100000.0, 100000.0]";
        refused(
            "column_collapse_a055",
            &[wide],
            &["gpu: cells of the domain = 10000 x 10000 x 10000: are at most 2045 x 2045 x 1021", "use larger cells"],
        );
    }
}

#[test]
fn check_says_what_the_device_would_need_or_lacks() {
    let told = |scene: &str| {
        let mut command = comminute("check");
        command.arg(format!("experiments/mpm/{scene}.toml"));
        command.assert().success()
    };
    told("triaxial_fine_small")
        .stderr(contains("graphics device").and(contains("MB (estimate)")).and(contains("a step: 10 dispatches")));
    told("column_collapse_2d").stderr(contains("graphics device").and(contains("grid.plane_strain = true: is not available")));
}

/// The count of a step's work is that of `check`, and goes with the points.
#[test]
fn bench_says_what_a_step_takes() {
    if !adapter("bench_says_what_a_step_takes") {
        return;
    }
    let mut command = comminute("bench");
    command.args("mpm --points 512,4096 --threads 1 --steps 2 --warm-up 1 --repeats 1 --gpu --json --quiet".split(' '));
    let told = command.assert().success();
    let told: serde_json::Value = serde_json::from_slice(&told.get_output().stdout).expect("JSON");
    let [small, large] = [0, 1].map(|k| &told["gpu"][k]["step"]);
    assert_eq!([&small["dispatches"], &large["dispatches"]], [9, 9]);
    for count in ["bytes", "flops"] {
        let ratio = number(large, count) / number(small, count);
        assert!((2.0..8.1).contains(&ratio), "{count}: {ratio}");
    }
}

/// The time of a mixture's step by the device's clock is that of its passes.
#[test]
fn bench_tells_what_each_pass_takes() {
    if !adapter("bench_tells_what_each_pass_takes") {
        return;
    }
    let mut command = comminute("bench");
    command.args("mixture tests/gpu/mixture.toml --steps 2 --warm-up 1 --repeats 1 --gpu --json --quiet".split(' '));
    let told = command.assert().success();
    let told: serde_json::Value = serde_json::from_slice(&told.get_output().stdout).expect("JSON");
    let passes = told["pass_ms_per_step"].as_object().expect("an adapter with timestamps");
    for pass in ["press_nodes", "strain", "grain_forces", "plate_forces"] {
        assert!(passes[pass].as_f64().is_some_and(|ms| ms > 0.0), "{pass}: {passes:?}");
    }
}

/// A case of verification has on the device the error that it has on the processor; its tests here end at half their strain and are four times as fast.
#[test]
fn verification_runs_on_the_device() {
    if !adapter("verification_runs_on_the_device") {
        return;
    }
    let folder = tempfile::tempdir().expect("folder");
    let scene = format!(
        "base = \"{ROOT}/experiments/verification/triaxial_cones.toml\"\ntest.axial_strain = 0.01\ntest.strain_per_wave = 8e-4\n"
    );
    std::fs::write(folder.path().join("triaxial_cones.toml"), scene).expect("scene");
    let [here, there] = ["cpu", "gpu"].map(|backend| {
        let out = folder.path().join(backend);
        let mut command = comminute("verify");
        command.args(["--only", "cones", "--levels", "1", "--quiet", "--backend", backend]);
        command.arg("--scenes").arg(folder.path()).arg("--out").arg(&out);
        command.assert().success();
        let table = std::fs::read_to_string(out.join("verification.csv")).expect("a table");
        let error = |row: &str| row.rsplit(',').next().and_then(|last| last.parse::<f64>().ok());
        table.lines().skip(1).map(|row| error(row).expect("an error")).collect::<Vec<_>>()
    });
    assert_eq!(here.len(), 3);
    assert!(here.iter().zip(&there).all(|(a, b)| (a - b).abs() < 1e-4), "{here:?} and {there:?}");
}

/// Without a driver `gpu` is an error and `auto` the processor, with the reason.
#[test]
#[cfg(target_os = "linux")]
fn without_an_adapter_gpu_is_refused_and_auto_goes_on() {
    let folder = tempfile::tempdir().expect("folder");
    let sets = [&PLAIN[..], &["test.axial_strain=0.0002"]].concat();
    let without = |backend: &str| {
        let mut command = run("triaxial_fine_small", &folder.path().join(backend), &sets, &["--backend", backend]);
        command.envs([("VK_DRIVER_FILES", "/nowhere.json"), ("VK_ICD_FILENAMES", "/nowhere.json")]);
        command.assert()
    };
    without("gpu")
        .code(2)
        .stderr(contains("gpu: found no graphics adapter").and(contains("use the processor").and(contains("--backend cpu"))));
    assert!(!folder.path().join("gpu").exists());
    without("auto").success();
    let s = summary(&folder.path().join("auto"));
    assert_eq!(s["backend"], "cpu");
    assert!(s["backend_reason"].as_str().is_some_and(|why| why.contains("no graphics adapter")), "{s}");
}

/// An adapter that computes on the processor is no reason to leave the processor's own way.
#[test]
fn auto_takes_hardware_alone() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let sets = [&PLAIN[..], &["test.axial_strain=0.0002"]].concat();
    run("triaxial_fine_small", &out, &sets, &["--backend", "auto"]).assert().success();
    let hardware = gpu::available().is_some_and(|adapter| !adapter.software);
    let s = summary(&out);
    assert_eq!(s["backend"], if hardware { "gpu" } else { "cpu" });
    assert!(s["backend_reason"].is_string());
    let out = folder.path().join("plane");
    run("column_collapse_2d", &out, &[&PLAIN[..], &["duration_s=0.001"]].concat(), &["--backend", "auto"]).assert().success();
    assert_eq!(summary(&out)["backend"], "cpu");
}

/// Points that leave the grid end the run as on the processor: the same words, step and point, records and points kept.
#[test]
fn a_lost_point_ends_the_run_with_its_records_kept() {
    if !adapter("a_lost_point_ends_the_run_with_its_records_kept") {
        return;
    }
    let folder = tempfile::tempdir().expect("folder");
    let sets = ["grid.cell_mm=25.0", "grid.max_mm=[100.0, 100.0, 75.0]", "grid.pic=0.0005", "duration_s=0.3"];
    let told = ["cpu", "gpu"].map(|backend| {
        let out = folder.path().join(backend);
        let run = run("column_collapse_a055", &out, &[&PLAIN[..], &sets].concat(), &["--backend", backend]).assert().code(3);
        let text = String::from_utf8(run.get_output().stderr.clone()).expect("text");
        let line = text.lines().find(|line| line.contains("has left the grid")).unwrap_or_else(|| panic!("{text}"));
        (
            line.to_string(),
            std::fs::read_to_string(out.join("points_final.csv")).expect("points").lines().count(),
            columns(&out, ["time_s"]),
        )
    });
    assert_eq!((&told[0].0, told[0].1), (&told[1].0, told[1].1));
    assert!(told[1].2.len() > 20 && told[0].2.len() == told[1].2.len());
}
