//! Single grains between platens: what the engine gives back of what it was given.

use crate::common::{ROOT, close, near};
use assert_cmd::Command;
use comminute::model::{GrainCrushing, Model, Rig};
use comminute::rig::grain_crushing::{Test, press};
use comminute::scene;
use predicates::prelude::*;
use predicates::str::contains;
use rayon::prelude::*;
use statrs::distribution::{Continuous, ContinuousCDF, Normal};
use std::f64::consts::PI;
use std::fs;

/// A scene of `experiments/platen` with overrides.
fn model(name: &str, sets: &[&str]) -> Result<Model, String> {
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    let scene = scene::load(format!("{ROOT}/experiments/platen/{name}.toml"), &sets).map_err(|e| e.to_string())?;
    scene::model(&scene).map_err(|e| e.to_string())
}

fn rig(model: &Model) -> &GrainCrushing {
    let Rig::GrainCrushing(rig) = &model.rig else { panic!("platens") };
    rig
}

/// Every grain of a scene pressed.
fn pressed(name: &str, sets: &[&str]) -> Vec<Test> {
    let model = model(name, sets).unwrap_or_else(|e| panic!("{e}"));
    let rig = rig(&model);
    let one = |k: u32| press(&model, rig, k, || false).unwrap_or_else(|e| panic!("{e}")).expect("not stopped");
    (0..rig.diameters.len() as u32).into_par_iter().map(one).collect()
}

fn plane(e: f64, nu: f64) -> f64 {
    e / (1.0 - nu * nu)
}

/// E* of two materials (Li et al. 2023, eq. 20).
fn star(a: f64, b: f64) -> f64 {
    1.0 / (1.0 / a + 1.0 / b)
}

const COKE: f64 = 0.858e9;
const SILICA: f64 = 46.8e9;
const STEEL: f64 = 200e9;

/// Hertz at every recorded point of both platens, of moduli 1 : 233, 1 : 4 and of rigid platens: F = 4/3 E* √r (δ/2)^{3/2}.
#[test]
fn force_and_displacement_are_hertz() {
    let steel = plane(STEEL, 0.3);
    for (name, more, e_star) in [
        ("petroleum_coke", "", star(plane(COKE, 0.3), steel)),
        ("silica", "", star(plane(SILICA, 0.3), steel)),
        ("silica", "materials.platen.elastic.E_GPa=20.0", star(plane(SILICA, 0.3), plane(20e9, 0.3))),
    ] {
        let sets = ["batch.grains=2", "records.curves=[0, 3, 5, 6]", more];
        let tests = pressed(name, if more.is_empty() { &sets[..2] } else { &sets });
        let curves: Vec<&Test> = tests.iter().filter(|t| !t.curve.is_empty()).collect();
        assert_eq!(curves.len(), 4);
        for t in curves {
            assert!(t.curve.len() > 250, "{}", t.curve.len());
            for p in &t.curve {
                let expected = 4.0 / 3.0 * e_star * (0.5 * t.diameter).sqrt() * (0.5 * p.displacement).powf(1.5);
                for force in [p.bottom, p.top] {
                    let off = (force / expected - 1.0).abs();
                    assert!(off < 1e-5, "{name}, {} m at {} m: {force} N, off by {off:.1e}", t.diameter, p.displacement);
                }
            }
            let last = t.curve.last().expect("points");
            close("the last point is the peak", last.displacement, t.displacement, 1e-12);
            close("its force too", last.top.max(last.bottom), t.force, 1e-9);
        }
        // what the run reports of itself is no smaller
        assert!(tests.iter().all(|t| t.deviation < 1e-5 && t.difference < 2e-5 && t.deviation > 0.0));
    }
}

/// A single material is that of grains between rigid platens, E* = E/(1 − ν²).
#[test]
fn without_a_material_platens_are_rigid() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rigid.toml");
    let text = format!(
        "kind = \"platen\"\nmaterial = \"{ROOT}/materials/petroleum_coke.toml\"\nbatch.grains = 1\nbatch.diameters_mm = [5.0]\n"
    );
    fs::write(&path, text).expect("written");
    let model = scene::model(&scene::load(&path, &[]).expect("a scene")).expect("a model");
    let test = press(&model, rig(&model), 0, || false).expect("pressed").expect("not stopped");
    for p in &test.curve {
        close("rigid", p.top, 4.0 / 3.0 * plane(COKE, 0.3) * 2.5e-3f64.sqrt() * (0.5 * p.displacement).powf(1.5), 1e-5);
    }
}

/// Tables 1 and 2: limit forces of a 2 mm grain between steel platens, in the engine, and the exponents of eqs (16), (17).
#[test]
fn limit_forces_are_those_of_tables_1_and_2() {
    let fixed =
        |theta: f64, sigma: f64| (format!("materials.grain.strength.fixed_angle.theta0_rad={theta:?}"), sigma, "fixed_angle");
    let hertz = |young: f64, sigma: f64| (format!("materials.grain.elastic.E_GPa={young:?}"), sigma, "hertz_area");
    for ((key, sigma, table), force) in [
        (fixed(PI / 9.0, 300.0), 110.25),
        (fixed(PI / 18.0, 1200.0), 113.68),
        (fixed(PI / 24.0, 2060.0), 110.26),
        (hertz(0.866, 200.0), 155.4),
        (hertz(7.8, 800.0), 131.21),
        (hertz(46.8, 2200.0), 106.92),
    ] {
        let area = if table == "hertz_area" { "crushing.area=hertz" } else { "crushing.area=fixed_angle" };
        let strength = format!("materials.grain.strength.{table}.sigma_lim0_MPa={sigma:?}");
        let spread = format!("materials.grain.strength.{table}.var=0.0");
        let sets = [key.as_str(), area, &strength, &spread, "batch.grains=1", "batch.diameters_mm=[2.0, 4.0]"];
        let tests = pressed("petroleum_coke", &sets);
        for t in &tests {
            let over = t.force / t.limit_force.expect("it can break") - 1.0;
            assert!(t.broken && (-1e-12..1e-3).contains(&over), "{key}: broke {over:.1e} over its limit");
        }
        close(&key, tests[0].limit_force.expect("it can break"), force, 1e-4);
        close("peak", tests[0].force, force, 1e-3);
        let (area, m) = if table == "hertz_area" { (9.0, 10.0) } else { (3.0, 2.0) };
        close("exponent", (tests[1].force / tests[0].force).log2(), 2.0 - area / m, 2e-3);
    }
}

/// Criteria that judge a grain's mean stress: between platens it is uniaxial, 6 F/(π d²), so that all of them break it at the same force.
#[test]
fn criteria_of_the_mean_stress_agree_between_platens() {
    for (word, own) in [("von_mises", None), ("mohr_coulomb", Some("friction_angle_deg=35")), ("christensen", Some("chi=12"))] {
        let table = format!("materials.grain.strength.{word}");
        let mut sets = vec![format!("crushing.criterion={word}"), "batch.grains=1".into(), "batch.diameters_mm=[2.0, 4.0]".into()];
        sets.extend(["sigma_lim0_MPa=60.0", "m=2.0", "var=0.0"].iter().chain(&own).map(|set| format!("{table}.{set}")));
        let tests = pressed("petroleum_coke", &sets.iter().map(String::as_str).collect::<Vec<_>>());
        for t in &tests {
            let (limit, hardening) = (t.limit_force.expect("it can break"), (t.diameter / 2e-3).powf(-1.5));
            close(word, limit, 60e6 * hardening * PI / 6.0 * t.diameter * t.diameter, 1e-12);
            assert!(t.broken && (-1e-12..1e-3).contains(&(t.force / limit - 1.0)), "{word}: {} of {limit}", t.force);
        }
    }
}

/// With crushing_stress_MPa every criterion breaks the grain of mean strength at that F/d², whatever its own area or equivalent stress.
#[test]
fn one_crushing_stress_calibrates_every_criterion() {
    for (word, own) in [
        ("fixed_angle", Some("theta0_rad=0.3")),
        ("hertz_area", None),
        ("von_mises", None),
        ("mohr_coulomb", Some("friction_angle_deg=35")),
        ("christensen", Some("chi=12")),
    ] {
        let table = format!("materials.grain.strength.{word}");
        let mut sets = vec![
            format!("crushing.criterion={word}"),
            "batch.grains=1".into(),
            "batch.diameters_mm=[2.0]".into(),
            "materials.grain.strength.d0_mm=2.0".into(),
        ];
        let stress = ["crushing_stress_MPa=30.0", "crushing_stress_is=mean", "m=3.0", "var=0.0"];
        sets.extend(stress.iter().chain(&own).map(|set| format!("{table}.{set}")));
        let tests = pressed("petroleum_coke", &sets.iter().map(String::as_str).collect::<Vec<_>>());
        // platens of the scene are elastic: Hertz's area against rigid ones is another one
        let allowed = if word == "hertz_area" { 0.05 } else { 1e-12 };
        close(word, tests[0].limit_force.expect("it can break"), 30e6 * 4e-6, allowed);
    }
}

/// Weibull's distribution of modulus m: the share exp(−1) of all grains bears the force of the scale, 1/Γ(1 + 1/m) of the mean.
#[test]
fn weibull_strengths_survive_as_weibull_says() {
    let table = "materials.grain.strength.von_mises";
    let sets = [
        "crushing.criterion=von_mises".to_string(),
        "materials.grain.strength.distribution=weibull".into(),
        "batch.grains=400".into(),
        "batch.diameters_mm=[2.0]".into(),
        format!("{table}.sigma_lim0_MPa=60.0"),
        format!("{table}.m=3.0"),
    ];
    let tests = pressed("petroleum_coke", &sets.iter().map(String::as_str).collect::<Vec<_>>());
    let scale = 60e6 * PI / 6.0 * 4e-6 / 0.892_979_511_569_249; // Γ(4/3)
    let survived = tests.iter().filter(|t| t.force > scale).count() as f64 / tests.len() as f64;
    near("share that survives the scale", survived, (-1.0f64).exp(), 0.07);
    let mean = tests.iter().map(|t| t.force).sum::<f64>() / tests.len() as f64;
    close("mean", mean, 60e6 * PI / 6.0 * 4e-6, 0.06);
}

/// Mean and coefficient of variation of the ratio when draws below zero are redrawn.
fn truncated(var: f64) -> (f64, f64) {
    let unit = Normal::new(0.0, 1.0).expect("unit normal");
    let a = -1.0 / var;
    let hazard = unit.pdf(a) / (1.0 - unit.cdf(a));
    let mean = 1.0 + var * hazard;
    (mean, var * (1.0 + a * hazard - hazard * hazard).sqrt() / mean)
}

/// 500 grains of four sizes give back sigma_lim0, m and var: strengths from peak forces by eqs (16), (17), their means per size in a line of
/// log against log, their spread about it, with the moments of the truncated normal. Bounds are three standard errors.
#[test]
fn a_batch_gives_back_the_parameters_it_was_given() {
    let e_star = star(plane(SILICA, 0.3), plane(STEEL, 0.3));
    for (name, sigma0, m, var) in [("silica", 2060e6, 3.0, 0.48), ("silica_hertz", 2200e6, 10.0, 0.48)] {
        let tests = pressed(name, &[]);
        assert_eq!(tests.len(), 500);
        assert!(tests.iter().all(|t| t.broken));
        let strength = |t: &Test| {
            if name == "silica" {
                t.force / (PI / 4.0 * t.diameter * t.diameter * (PI / 24.0).sin().powi(2))
            } else {
                t.force.cbrt() / (PI * (3.0 * 0.5 * t.diameter / (4.0 * e_star)).powf(2.0 / 3.0))
            }
        };
        // mean strength of each size
        let mut means = Vec::new();
        for size in tests.chunk_by(|a, b| a.diameter == b.diameter) {
            let mean = size.iter().map(strength).sum::<f64>() / size.len() as f64;
            means.push((size[0].diameter, mean, size));
        }
        assert_eq!(means.len(), 4);
        let n = 500.0f64;
        let squares = means.iter().map(|(_, mean, size)| size.iter().map(|t| (strength(t) / mean - 1.0).powi(2)).sum::<f64>());
        let spread = (squares.sum::<f64>() / (n - 4.0)).sqrt();
        // a line through (ln d, ln mean)
        let x: Vec<f64> = means.iter().map(|(d, ..)| (d / 2e-3).ln()).collect();
        let y: Vec<f64> = means.iter().map(|(_, mean, _)| mean.ln()).collect();
        let (mx, my) = (x.iter().sum::<f64>() / 4.0, y.iter().sum::<f64>() / 4.0);
        let sxx: f64 = x.iter().map(|x| (x - mx).powi(2)).sum();
        let slope = x.iter().zip(&y).map(|(x, y)| (x - mx) * (y - my)).sum::<f64>() / sxx;
        let at_d0 = (my - slope * mx).exp();

        let (factor, cv) = truncated(var);
        let error = cv / (n * sxx / 4.0).sqrt();
        println!("{name}: slope {slope:.4} of {:.4} ± {error:.4}, spread {spread:.4} of {cv:.4}", -3.0 / m);
        assert!((slope + 3.0 / m).abs() < 3.0 * error);
        let error = cv * (1.0 / n + mx * mx / (n * sxx / 4.0)).sqrt();
        println!("{name}: strength {:.4} of 1 ± {error:.4}", at_d0 / factor / sigma0);
        assert!((at_d0 / factor / sigma0 - 1.0).abs() < 3.0 * error);
        // var by bisection of its realised coefficient of variation
        let (mut low, mut high) = (0.01, 3.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if truncated(middle).1 < spread { low = middle } else { high = middle }
        }
        let gain = (truncated(1.01 * var).1 - truncated(0.99 * var).1) / (0.02 * var);
        let error = cv * (1.0 / (2.0 * n)).sqrt() / gain;
        println!("{name}: var {low:.4} of {var} ± {error:.4}");
        assert!((low - var).abs() < 3.0 * error);
    }
}

#[test]
fn every_grain_has_a_strength_of_its_own() {
    let ratios = |name: &str, seed: &str| -> Vec<f64> {
        let m = if name == "silica" { 3.0 } else { 10.0 };
        let mut ratios: Vec<f64> = pressed(name, &["batch.grains=20", seed])
            .iter()
            .map(|t| t.strength * (t.diameter / 2e-3).powf(3.0 / m) / if name == "silica" { 2060e6 } else { 2200e6 })
            .collect();
        for (i, r) in ratios.iter().enumerate() {
            assert!(ratios[..i].iter().all(|s| (s / r - 1.0).abs() > 1e-9));
        }
        ratios.truncate(5);
        ratios
    };
    let one = ratios("silica", "seed.strength=1");
    let same = ratios("silica_hertz", "seed.strength=1");
    let other = ratios("silica", "seed.strength=2");
    for k in 0..5 {
        close("the same draw", same[k], one[k], 1e-9);
        assert!((other[k] / one[k] - 1.0).abs() > 1e-6);
    }
}

#[test]
fn grains_that_do_not_break_are_censored() {
    // the comminution limit of silica sand is 0.825 mm
    let tests = pressed("silica", &["batch.grains=3", "batch.diameters_mm=[0.8, 0.9]", "loading.max_displacement_over_d=0.2"]);
    for t in &tests {
        assert_eq!((t.broken, t.limit_force.is_some()), (t.diameter > 0.825e-3, t.diameter > 0.825e-3));
        if !t.broken {
            close("pressed to the end", t.displacement, 0.2 * t.diameter, 1e-3);
        }
    }
    let tests = pressed("silica", &["batch.grains=20", "batch.diameters_mm=[2.0]", "loading.max_force_N=110.0"]);
    assert!(tests.iter().any(|t| t.broken) && tests.iter().any(|t| !t.broken));
    for t in tests {
        assert_eq!(t.broken, t.limit_force.expect("it can break") < 110.0);
        assert!(t.broken || (110.0..110.1).contains(&t.force), "{}", t.force);
    }
    let elastic = pressed("silica", &["crushing.enabled=false", "batch.grains=1", "loading.max_force_N=50.0"]);
    assert!(elastic.iter().all(|t| !t.broken && t.strength == f64::INFINITY));
}

#[test]
fn sizes_may_come_from_the_gradation() {
    let scene = format!("{ROOT}/experiments/platen/petroleum_coke.toml");
    let folder = tempfile::tempdir().expect("a folder");
    let text = fs::read_to_string(scene).expect("scene").replace("diameters_mm = [2.0, 4.0, 8.0, 16.0]", "");
    let path = folder.path().join("graded.toml");
    fs::write(&path, text.replace("../../", &format!("{ROOT}/"))).expect("written");
    let model = scene::model(&scene::load(&path, &[]).expect("a scene")).expect("a model");
    let rig = rig(&model);
    assert!(rig.graded && rig.diameters.len() == 125 && rig.curves.len() == 4);
    assert!(rig.diameters.iter().all(|d| (5e-3..=10e-3).contains(d)));
    assert!(rig.diameters.windows(2).all(|w| w[0] != w[1]));
}

#[test]
fn disagreements_name_the_key() {
    for (set, says) in [
        ("specimen.scale=2", "specimen: has no meaning in a platen test"),
        ("damping.local=0.1", "damping: has no meaning in a platen test"),
        ("loading.max_stress_kPa=5", "loading.max_stress_kPa=5: has no meaning in a platen test"),
        ("contact.law=linear", "contact: has no meaning in a platen test"),
        ("batch.diameters_mm=[]", "must hold a diameter"),
        ("batch.diameters_mm=[1, 2, 1]", "entry 3 stands there already"),
        ("batch.diameters_mm=[1, -2]", "entry 2 must be > 0"),
        ("batch.grains=0", "must be >= 1"),
        ("batch.grains=400000", "would make 1600000 tests"),
        ("loading.step=0.1", "must be >= 0.000001 and <= 0.01"),
        ("loading.max_displacement_over_d=1", "must be > 0.001 and < 1"),
        ("records.curves=[500]", "there is no grain 500; they go from 0 to 499"),
        ("records.curves=all", "must be a list of grain numbers from 0, or \"typical\""),
        ("materials.lid=materials/steel.toml", "has no part in a platen test"),
        ("materials.grain=materials/steel.toml", "steel.toml: strength.fixed_angle: is missing"),
        ("batch.size=3", "unknown key"),
    ] {
        let error = model("petroleum_coke", &[set]).map(|_| ()).expect_err(set);
        let says = says.replace("specimen:", "specimen.scale=2:").replace("damping:", "damping.local=0.1:");
        let says = says.replace("contact:", "contact.law=linear:");
        assert!(error.contains(&says), "{set}: {error}");
    }
}

fn comminute(args: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("comminute").expect("the binary").current_dir(ROOT).args(args).assert()
}

const SCENE: &str = "experiments/platen/silica.toml";
const FILES: [&str; 5] = ["platen.csv", "force_displacement.csv", "survival.csv", "limit_force.csv", "scene.resolved.toml"];

/// A run as typed: its files do not depend on threads, are those of its resolved scene and of a resumed run.
#[test]
fn a_batch_is_run_from_the_command_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let small = ["--set", "batch.grains=5", "--seed", "3"];
    let run = |scene: &str, out: &str, more: &[&str]| comminute(&[&["run", scene, "--out", out], more].concat());
    run(SCENE, &at("a"), &small).success().stdout("").stderr(contains("20 grains pressed, 20 broke"));
    run(SCENE, &at("b"), &[&small[..], &["--threads", "1", "--quiet", "--json"]].concat())
        .success()
        .stderr("")
        .stdout(contains("\"largest_hertz_deviation\"").and(contains("\"tests\": 20")));
    run(&at("a/scene.resolved.toml"), &at("c"), &["--quiet"]).success();
    // killed before its end, a batch has no summary yet
    comminute(&["resume", &at("b")]).code(2).stderr(contains("finished"));
    fs::remove_file(folder.path().join("b/summary.json")).expect("removed");
    fs::write(folder.path().join("b/platen.csv"), "grain,dia").expect("written");
    comminute(&["resume", &at("b"), "--stop-after", "5"]).code(2).stderr(contains("has no meaning in a platen test"));
    comminute(&["resume", &at("b"), "--quiet"]).success();
    let read = |run: &str, file: &str| fs::read_to_string(folder.path().join(run).join(file)).expect(file);
    for file in FILES {
        assert_eq!(read("a", file), read("b", file), "{file}");
        assert_eq!(read("a", file), read("c", file), "{file}");
    }
    for name in ["force_displacement", "peak_force", "survival"] {
        for kind in ["svg", "png", "csv"] {
            assert!(folder.path().join(format!("a/figures/{name}.{kind}")).is_file(), "{name}.{kind}");
        }
    }
    let tests = read("a", "platen.csv");
    assert!(tests.starts_with("grain,diameter_mm,force_N,censored,"), "{tests}");
    assert_eq!(tests.lines().count(), 21);
    let summary: serde_json::Value = serde_json::from_str(&read("a", "summary.json")).expect("json");
    assert!(summary["largest_overshoot"].as_f64().is_some_and(|x| x < 1e-3));
    assert!(summary["largest_hertz_deviation"].as_f64().is_some_and(|x| x < 1e-3));
    assert!((summary["E_star_GPa"].as_f64().expect("E*") - 41.676).abs() < 1e-3);

    // another seed is another batch; an old run is not overwritten; a batch cannot be stopped half way
    run(SCENE, &at("a"), &small).code(2).stderr(contains("--force"));
    run(SCENE, &at("d"), &["--stop-after", "10"]).code(2).stderr(contains("has no meaning in a platen test"));
    assert!(!folder.path().join("d").exists());
    run(SCENE, &at("a"), &["--force", "--quiet", "--set", "batch.grains=5", "--seed", "4"]).success();
    assert_ne!(read("a", "platen.csv"), tests);
    comminute(&["plot", &at("a"), &at("b"), "--out", &at("both"), "--quiet"]).success();
    assert!(folder.path().join("both/peak_force.svg").is_file());
}

#[test]
fn check_says_what_a_batch_would_be() {
    comminute(&["check", SCENE]).success().stderr(
        contains("grains          500")
            .and(contains("eq. 8"))
            .and(contains("silica sand, steel"))
            .and(contains("approach of the platens")),
    );
    let warned = |set: &str, says: &str| comminute(&["check", SCENE, "--set", set]).success().stderr(contains(says.to_string()));
    warned("batch.diameters_mm=[0.5, 1.0]", "125 grains are not above the comminution limit, 0.8250 mm");
    warned("batch.diameters_mm=[0.5]", "nothing can break");
    warned("loading.max_force_N=100", "does not break before its test ends");
    warned("loading.step=0.01", "may pass its limit by 1.50 %");
    warned("crushing.enabled=false", "every grain is pressed to the end");
}
