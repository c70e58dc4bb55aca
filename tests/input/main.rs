//! What a user with a sand of their own types: strengths as laboratories give them, templates, the dictionary of columns, specimens for
//! many runs, and a run that failed before it began.

mod scenes;

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use comminute::record::dictionary::SHEETS;
use comminute::scene;
use predicates::prelude::*;
use predicates::str::contains;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

const COKE: &str = "experiments/petroleum_coke/h-c-2.toml";

fn comminute(args: &[&str]) -> Assert {
    Command::cargo_bin("comminute").expect("the binary").current_dir(env!("CARGO_MANIFEST_DIR")).args(args).assert()
}

/// A program that has the text of a scene gets the same run from it as from the file, and the same messages with another name.
#[test]
fn the_text_of_a_scene_is_as_good_as_its_file() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(COKE);
    let text = fs::read_to_string(&file).expect("scene");
    let sets = ["loading.max_stress_kPa=300".to_string()];
    let loaded = scene::load(&file, &sets).expect("a scene");
    let read = scene::from_text(&text, file.parent().expect("a folder"), &sets).expect("a scene");
    assert_eq!(scene::resolved(&read), scene::resolved(&loaded));
    let refused = |text: &str| scene::from_text(text, "", &[]).expect_err("refused").to_string();
    assert_eq!(refused("kind = \"assembly\"\nstep = 3"), "scene: step: unknown key; did you mean steps?");
    assert!(refused("kind = ").starts_with("scene: line 1 (`kind =`): not TOML"), "{}", refused("kind = "));
}

/// The coke scene with a strength law of its own, checked as JSON.
fn coke_with(area: &str, strength: &str) -> Assert {
    let folder = tempfile::tempdir().expect("a folder");
    let root = env!("CARGO_MANIFEST_DIR");
    let scene = fs::read_to_string(format!("{root}/{COKE}")).expect("scene");
    fs::write(folder.path().join("scene.toml"), scene.replace("../../materials/petroleum_coke.toml", "material.toml"))
        .expect("written");
    let material = format!(
        "name = \"own\"\ngrain.density_kg_m3 = 2650\nelastic = {{ E_GPa = 70, nu = 0.17 }}\ncontact.friction = 0.4\n\
         gradation.points = [[0.25, 0], [0.75, 1]]\ncomminution.d_limit_over_d50 = 0.4\nfines.d_min_mm = 0.005\n[strength]\nd0_mm = 0.5\n\
         [strength.{}]\nm = 3\nvar = 0.4\n{strength}\n",
        if area == "hertz" { "hertz_area" } else { "fixed_angle" }
    );
    fs::write(folder.path().join("material.toml"), material).expect("written");
    let path = folder.path().join("scene.toml").display().to_string();
    comminute(&["check", &path, "--json", "--set", &format!("crushing.area={area}"), "--set", "specimen.diameter_mm=12"])
}

fn mean_mpa(assert: Assert) -> f64 {
    let out = assert.success().get_output().stdout.clone();
    let value: serde_json::Value = serde_json::from_slice(&out).expect("json");
    value["estimate"]["crushing_stress"]["mean_MPa"].as_f64().expect("a crushing stress")
}

/// A layer may replace the older key for the criterion by the newer one; a file with both is refused.
#[test]
fn the_criterion_is_named_once() {
    let sets = ["--set", "crushing.area=hertz", "--set", "crushing.criterion=fixed_angle"];
    comminute(&[&["check", COKE][..], &sets].concat()).success();
    let folder = tempfile::tempdir().expect("a folder");
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join(COKE);
    let path = folder.path().join("both.toml");
    let text = format!("base = {base:?}\n[crushing]\narea = \"hertz\"\ncriterion = \"fixed_angle\"\n");
    fs::write(&path, text).expect("written");
    comminute(&["check", &path.display().to_string()])
        .code(2)
        .stderr(contains("both.toml: crushing.area = \"hertz\": is the older name of crushing.criterion"));
}

/// A long chain of base files and a file without an end are refused by a number, neither read on for ever nor until the memory is full.
#[test]
fn bases_and_files_without_an_end_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for k in 0..40 {
        let text = format!("base = \"{}.toml\"\n", k + 1);
        fs::write(folder.path().join(format!("{k}.toml")), text).expect("written");
    }
    let first = folder.path().join("0.toml").display().to_string();
    comminute(&["check", &first]).code(2).stderr(contains("32.toml: is at the end of a chain of more than 32 files"));
    #[cfg(unix)]
    {
        comminute(&["check", "/dev/zero"]).code(2).stderr(contains("/dev/zero: must be at most 64 MiB long"));
        let out = folder.path().join("run").display().to_string();
        let specimen = ["run", COKE, "--set", "specimen.file=/dev/zero", "--quiet", "--out", &out];
        comminute(&specimen).code(2).stderr(contains("/dev/zero: must be at most 512 MiB long"));
    }
}

#[test]
fn a_strength_from_single_grain_tests_is_their_mean_crushing_stress() {
    for (area, theta0) in [("fixed_angle", "theta0_rad = 0.35"), ("hertz", "")] {
        let given = format!("{theta0}\ncrushing_stress_MPa = 100\ncrushing_stress_is = \"mean\"");
        assert!((mean_mpa(coke_with(area, &given)) - 100.0).abs() < 1e-9, "{area}");
        // 37 % of a normal spread of 0.4 lie above 1.137 times the mean; its cube is on the average 1.48, and 1.137^3 is 1.47
        let survived = mean_mpa(coke_with(area, &given.replace("mean", "survival_37")));
        let expected = if area == "hertz" { 100.7 } else { 88.5 };
        assert!((survived - expected).abs() < 2.0, "{area}: {survived}");
    }
    let as_limit = mean_mpa(coke_with("fixed_angle", "theta0_rad = 0.35\nsigma_lim0_MPa = 100"));
    assert!((as_limit - 9.3).abs() < 0.2, "eq. 16: {as_limit}");
}

#[test]
fn half_a_crushing_stress_is_refused() {
    let alone = coke_with("fixed_angle", "theta0_rad = 0.35\ncrushing_stress_MPa = 100");
    alone.code(2).stderr(contains("crushing_stress_is").and(contains("survival_37")));
    let orphan = coke_with("fixed_angle", "theta0_rad = 0.35\nsigma_lim0_MPa = 100\ncrushing_stress_is = \"mean\"");
    orphan.code(2).stderr(contains("belongs to crushing_stress_MPa"));
    let two = coke_with("hertz", "crushing_stress_MPa = 100\ncrushing_stress_is = \"mean\"\nsigma_lim0_MPa = 100");
    two.code(2).stderr(contains("one of them"));
}

#[test]
fn pascals_in_a_key_of_megapascals_are_pointed_out() {
    let strength = ["check", COKE, "--set", "material.strength.fixed_angle.sigma_lim0_MPa=100e6"];
    comminute(&strength).success().stderr(contains("warning: a single grain").and(contains("0.5 to 5000 MPa")));
    comminute(&["check", COKE]).success().stderr(contains("mean F/d²").and(contains("warning: a single").not()));
    comminute(&["check", "--keys"]).success().stdout(contains("crushing_stress_MPa").and(contains("11 times at theta0 = 0.35")));
}

/// Templates, and what shortens their runs.
const TEMPLATES: [(&str, &[&str]); 6] = [
    (
        "oedometer",
        &[
            "specimen.grains=200",
            "specimen.diameter_mm=3",
            "specimen.porosity=0.45",
            "preparation.growth_friction=0.3",
            "preparation.growth_steps=1500",
            "loading.settle_steps=100",
            "loading.max_stress_kPa=1400",
            "loading.stages_kPa=[1000.0]",
            "loading.pace=0.02",
            "loading.max_inertial_number=0.01",
            "records.at_kPa=[]",
            "crushing.lost_mass=grow",
            // so weak that some break, and so that daughters do not: small ones make many steps
            "material.strength.fixed_angle.crushing_stress_MPa=8",
            "material.comminution.d_limit_over_d50=1.0",
        ],
    ),
    (
        "triaxial",
        &[
            "specimen.grains=150",
            "specimen.diameter_mm=2.5",
            "specimen.porosity=0.43",
            "preparation.growth_friction=0.3",
            "preparation.growth_steps=1500",
            "loading.settle_steps=100",
            "loading.axial_strain=0.004",
            "records.at_strain=[]",
        ],
    ),
    ("rocks", &["test.axial_strain=0.001"]),
    ("grains", &["duration_s=0.0002", "records.every=50"]),
    ("continuum", &["test.axial_strain=0.001"]),
    (
        "mixture",
        // so weak that one breaks
        &["test.axial_strain=0.001", "records.contacts=true", "materials.coarse.strength.fixed_angle.crushing_stress_MPa=0.1"],
    ),
];

/// Kind of the scene of a template.
fn kind_of(template: &str) -> &str {
    match template {
        "grains" => "assembly",
        "rocks" => "mixture",
        kind => kind,
    }
}

/// Runs a scene without figures into `out`.
fn run(scene: &str, sets: &[&str], out: &Path) {
    let out = out.display().to_string();
    let mut args = vec!["run", scene, "--quiet", "--out", &out, "--set", "records.figures=false"];
    args.extend(sets.iter().flat_map(|set| ["--set", set]));
    comminute(&args).success();
}

#[test]
fn what_new_writes_is_valid_and_runs_and_the_dictionary_has_every_column() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut columns = Seen::default();
    TEMPLATES.par_iter().for_each(|(kind, sets)| {
        let dir = folder.path().join(kind);
        let path = dir.display().to_string();
        comminute(&["new", kind, &path]).success().stderr(contains("scene.toml"));
        comminute(&["new", kind, &path]).code(2).stderr(contains("is not empty"));
        let scene = dir.join("scene.toml").display().to_string();
        comminute(&["check", &scene]).success();
        run(&scene, sets, &dir.join("run"));
    });
    TEMPLATES.iter().for_each(|(kind, _)| columns.look(&folder.path().join(kind).join("run"), kind_of(kind)));
    // fines from crushing in the oedometer, which must have had some
    let (_, weak) = TEMPLATES[0];
    let points = folder.path().join("points");
    run(
        &folder.path().join("oedometer/scene.toml").display().to_string(),
        &[weak, &["crushing.lost_mass=points", "loading.max_stress_kPa=1000", "loading.stages_kPa=[]"]].concat(),
        &points,
    );
    columns.look(&points, "oedometer");
    // what no template has: platens, rigid bodies, broken and joined ones, fines from crushing, undrained, one-dimensional and free continua
    let more: [(&str, &str, &[&str]); 9] = [
        ("platen", "experiments/platen/silica.toml", &["batch.grains=3", "batch.diameters_mm=[2.0]"]),
        ("mixture", "experiments/mixture/sliding_box.toml", &["duration_s=0.002"]),
        ("mixture", "experiments/blocks/crushed_cube.toml", &[]),
        ("mixture", "experiments/blocks/glued_wall.toml", &["duration_s=0.001"]),
        ("mixture", "mixture/scene.toml", &["test.axial_strain=0.001", "crushing.lost_mass=points", "records.account=true"]),
        (
            "mixture",
            "experiments/blocks/biaxial.toml",
            &[
                "test.axial_strain=0.0005",
                "test.strain_per_wave=0.002",
                "block_set[0].count=12",
                "block_set[0].max_mm=[35.0, 40.0, 0.0]",
            ],
        ),
        ("continuum", "continuum/scene.toml", &["test.axial_strain=0.001", "test.drainage=constant_volume"]),
        ("continuum", "experiments/mpm/oedometer.toml", &["test.axial_strain=0.001"]),
        (
            "continuum",
            "experiments/mpm/column_collapse_2d.toml",
            &["duration_s=0.002", "records.gate_mm=[0.1, 0.0, 0.0]", "records.gate_direction=[1.0, 0.0, 0.0]"],
        ),
    ];
    more.par_iter().enumerate().for_each(|(k, (_, scene, sets))| {
        let own = folder.path().join(scene);
        let scene = if own.exists() { own.display().to_string() } else { scene.to_string() };
        run(&scene, sets, &folder.path().join(k.to_string()));
    });
    more.iter().enumerate().for_each(|(k, (kind, ..))| columns.look(&folder.path().join(k.to_string()), kind));
    columns.complete();
    comminute(&["check", "--columns"]).success().stdout(contains("void_ratio_grains").and(contains("breakage.csv")));
}

/// Columns that have been met, by sheet of the dictionary.
#[derive(Default)]
struct Seen(BTreeSet<(usize, String)>);

impl Seen {
    /// Every table that lies in a run's folder.
    fn look(&mut self, run: &Path, kind: &str) {
        for entry in fs::read_dir(run).expect("run").flatten() {
            let file = entry.file_name().to_string_lossy().into_owned();
            if file.ends_with(".csv") {
                self.table(&entry.path(), &file, kind);
            }
        }
        let contacts = |path: &Path| path.file_name().is_some_and(|n| n.to_string_lossy().starts_with("contacts_"));
        let snapshots = fs::read_dir(run.join("snapshots")).into_iter().flatten().flatten().map(|entry| entry.path());
        for path in snapshots.filter(|path| contacts(path)) {
            self.table(&path, "contacts_*.csv", kind);
        }
    }

    fn table(&mut self, path: &Path, file: &str, kind: &str) {
        let sheet = SHEETS.iter().position(|s| s.describes(file, kind));
        let sheet =
            sheet.unwrap_or_else(|| panic!("the dictionary (src/laboratory/record/dictionary.rs) lacks {file} of kind {kind}"));
        let text = fs::read_to_string(path).expect("table");
        let header = text.lines().find(|line| !line.starts_with('#')).expect("header");
        for name in header.split(',') {
            let known = SHEETS[sheet].columns.iter().any(|c| c.name == name);
            assert!(known, "the dictionary (src/laboratory/record/dictionary.rs) lacks the column {name} of {file}, kind {kind}");
            self.0.insert((sheet, name.to_string()));
        }
    }

    /// No table of runs has a column in the dictionary that none of them has.
    fn complete(&self) {
        for (k, sheet) in SHEETS.iter().enumerate().filter(|(_, s)| !s.of.starts_with("comminute")) {
            for column in sheet.columns {
                let met = self.0.contains(&(k, column.name.to_string()));
                assert!(met, "no run leaves {} in {} ({})", column.name, sheet.files, sheet.of);
            }
        }
    }
}

#[test]
fn a_template_needs_a_folder_of_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    comminute(&["new", "grains", &folder.path().display().to_string(), "--quiet"]).success().stderr("");
    let file = folder.path().join("scene.toml").display().to_string();
    comminute(&["new", "grains", &file]).code(2).stderr(contains("is a file"));
}

#[test]
fn a_run_that_fails_while_it_is_prepared_does_not_take_its_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("run");
    let path = out.display().to_string();
    let sets = ["--set", "specimen.grains=150", "--set", "specimen.diameter_mm=100", "--set", "specimen.porosity=0.45"];
    let base = [&["run", COKE, "--quiet", "--out", &path][..], &sets].concat();
    let never = [&base[..], &["--set", "preparation.growth_steps=40", "--set", "preparation.max_steps=60"]].concat();
    let names = || {
        let mut names: Vec<String> =
            fs::read_dir(&out).expect("folder").flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    };
    for _ in 0..2 {
        comminute(&never).failure().stderr(contains("holds a run").not());
        assert_eq!(names(), ["failed.scene.toml"]);
    }
    let text = fs::read_to_string(out.join("failed.scene.toml")).expect("text");
    assert!(text.starts_with("# This run failed") && text.contains("max_steps = 60"), "{text}");
    comminute(&["check", &out.join("failed.scene.toml").display().to_string()]).success();
    // what is the user's stays, and keeps the folder taken
    fs::write(out.join("notes.txt"), "mine").expect("written");
    comminute(&never).code(2).stderr(contains("holds a run"));
    comminute(&[&never[..], &["--force"]].concat()).failure();
    assert_eq!(names(), ["failed.scene.toml", "notes.txt"]);
    // a run that gets further, or is stopped, keeps what it has
    fs::remove_file(out.join("notes.txt")).expect("removed");
    comminute(&[&base[..], &["--stop-after", "20"]].concat()).failure();
    assert!(
        names().contains(&"scene.resolved.toml".to_string()) && !names().contains(&"failed.scene.toml".to_string()),
        "{:?}",
        names()
    );
    comminute(&base).code(2).stderr(contains("holds a run"));
}

#[test]
fn a_sweep_and_an_ensemble_begin_with_the_specimen_they_are_given() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let small = [
        "specimen.grains=150",
        "specimen.diameter_mm=100",
        "specimen.porosity=0.45",
        "preparation.growth_friction=0.3",
        "loading.max_stress_kPa=10",
        "loading.rate=0.5",
        "records.figures=false",
        "loading.settle_steps=50",
    ];
    let sets: Vec<&str> = small.iter().flat_map(|set| ["--set", set]).collect();
    let made = at("made");
    comminute(&[&["run", COKE, "--quiet", "--out", &made][..], &sets].concat()).success();
    let specimen = format!("{made}/specimen.csv");
    let given = ["--quiet", "--threads", "1", "--specimen", &specimen];
    let (sweep, ensemble) = (at("sweep"), at("ensemble"));
    comminute(&[&["sweep", COKE, "--grid", "damping.local=0.05,0.2", "--out", &sweep][..], &sets, &given].concat()).success();
    comminute(&[&["ensemble", COKE, "--seeds", "1,2", "--out", &ensemble][..], &sets, &given].concat()).success();
    let wanted = fs::read_to_string(&specimen).expect("specimen");
    for run in ["sweep/local-0.05", "sweep/local-0.2", "ensemble/seed-1", "ensemble/seed-2"] {
        let own = folder.path().join(run).join("specimen.csv");
        let own = fs::read_to_string(&own).unwrap_or_else(|e| panic!("{run}: {e}"));
        assert!(own == wanted, "{run}");
    }
    let listed = comminute(&[&["ensemble", COKE, "--list", "--seeds", "1"][..], &given].concat());
    listed.success().stdout(contains("--specimen"));
    let packing = [&["ensemble", COKE, "--vary", "packing", "--out", &ensemble][..], &given].concat();
    comminute(&packing).code(2).stderr(contains("--vary strength"));
    let missing = at("nowhere.csv");
    comminute(&["sweep", COKE, "--grid", "damping.local=0.05", "--specimen", &missing]).code(2).stderr(contains("nowhere.csv"));
}
