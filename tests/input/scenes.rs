//! Every scene of the repository is valid, and its resolved form is the same scene.

use comminute::boundary::{Drive, WallShape};
use comminute::model::{Model, Rig};
use comminute::scene::{self, Scene};
use std::fs;
use std::path::{Path, PathBuf};

fn scenes() -> Vec<PathBuf> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|e| e == "toml") {
                found.push(path);
            }
        }
    }
    let mut found = Vec::new();
    walk(&Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments"), &mut found);
    // what lies in no folder, or among the studies, is a plan of many runs (tests/reproduce.rs, tests/study.rs)
    found.retain(|path| path.parent().is_some_and(|folder| !folder.ends_with("experiments") && !folder.ends_with("studies")));
    found.sort();
    assert!(found.len() > 15);
    found
}

fn scene(name: &str, sets: &[&str]) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments").join(name);
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    scene::load(path, &sets).unwrap_or_else(|e| panic!("{e}"))
}

fn model(name: &str, sets: &[&str]) -> Model {
    scene::model(&scene(name, sets)).unwrap_or_else(|e| panic!("{e}"))
}

/// A scene from text, in a folder of its own.
fn written(text: &str, sets: &[&str]) -> Result<Model, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.toml");
    fs::write(&path, text).expect("written");
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    let scene = scene::load(&path, &sets).map_err(|e| e.to_string())?;
    scene::model(&scene).map_err(|e| e.to_string())
}

#[test]
fn every_scene_is_valid_and_its_resolved_form_repeats_it() {
    let folder = tempfile::tempdir().expect("a folder");
    for path in scenes() {
        let first = scene::load(&path, &[]).unwrap_or_else(|e| panic!("{e}"));
        let model = scene::model(&first).unwrap_or_else(|e| panic!("{e}"));
        let text = scene::resolved(&first);
        let copy = folder.path().join(scene::RESOLVED);
        fs::write(&copy, &text).expect("written");
        let second = scene::load(&copy, &[]).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let again = scene::model(&second).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(format!("{model:?}"), format!("{again:?}"), "{}", path.display());
        assert_eq!(text, scene::resolved(&second), "{}", path.display());
        assert!(!text.contains(env!("CARGO_MANIFEST_DIR")), "no path of this machine");
        assert_eq!(scene::assumptions(&first), scene::assumptions(&second));
    }
}

#[test]
fn table_3_is_what_the_coke_scenes_say() {
    let table = [
        ("h-c-1", 5388, 51.32, false),
        ("h-c-2", 680, 51.83, false),
        ("h-v-1", 5388, 51.32, false),
        ("h-v-2", 680, 51.83, false),
        ("l-c-1", 5388, 51.58, true),
        ("l-c-2", 791, 59.77, true),
    ];
    for (name, grains, height, linear) in table {
        let m = model(&format!("petroleum_coke/{name}.toml"), &[]);
        let e = scene::estimate(&m, None);
        let s = e.specimen.expect("an oedometer");
        assert_eq!(e.grains, grains);
        assert!((s.height_mm / height - 1.0).abs() < 2e-3, "{name}: {}", s.height_mm);
        assert_eq!(m.physics.contact.law == comminute::contact::ContactLaw::Linear, linear);
        let material = &m.physics.materials[0];
        assert!((material.young - 0.858e9).abs() < 1.0);
        assert!((material.friction - 0.4228).abs() < 1e-4);
        let crush = m.physics.crush.expect("it crushes");
        assert!((crush.d_limit - 1.875e-3 * m.scale).abs() < 1e-12);
        assert!((crush.strength.d0 - 2e-3 * m.scale).abs() < 1e-12);
        assert!((5e4..1.3e5).contains(&e.steps));
        let twin = model(&format!("petroleum_coke/{name}-nc.toml"), &[]);
        assert!(twin.physics.crush.is_none());
        assert_eq!(format!("{:?}", twin.rig), format!("{:?}", m.rig));
    }
}

#[test]
fn a_base_gives_everything_that_is_not_written_beside_it() {
    let m = model("petroleum_coke/h-v-1.toml", &[]);
    assert_eq!(m.name, "H-V-1");
    assert_eq!(m.scale, 1.0);
    let Rig::Oedometer(o) = &m.rig else { panic!() };
    assert_eq!(o.loading.stages, [1e7]);
    assert_eq!(o.specimen.gradation, [(5.0 * 1e-3, 0.0), (10.0 * 1e-3, 1.0)]);
}

#[test]
fn a_scene_based_on_itself_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, base) in [("a.toml", "b.toml"), ("b.toml", "a.toml")] {
        fs::write(folder.path().join(name), format!("base = \"{base}\"")).expect("written");
    }
    let error = scene::load(folder.path().join("a.toml"), &[]).expect_err("a cycle");
    assert!(error.to_string().contains("based on itself"), "{error}");
}

#[test]
fn overrides_reach_every_table_and_mark_the_source() {
    let sets =
        ["material.strength.fixed_angle.m=3", "material.elastic.E_GPa=1", "loading.stages_kPa=[100, 2000]", "contact.law=linear"];
    let m = model("petroleum_coke/h-c-2.toml", &sets);
    assert_eq!(m.physics.crush.expect("it crushes").strength.m, 3.0);
    assert_eq!(m.physics.materials[0].young, 1e9);
    let Rig::Oedometer(o) = &m.rig else { panic!() };
    assert_eq!(o.loading.stages, [5e6, 1e5, 2e6]);
    let text = scene::resolved(&scene("petroleum_coke/h-c-2.toml", &sets));
    assert!(text.contains("source.m = \"replaced by --set\""), "{text}");
    assert!(!text.contains("G_GPa = 0.33"));
}

#[test]
fn the_other_contact_area_takes_its_own_strength() {
    let m = model("petroleum_coke/h-c-2.toml", &["crushing.area=hertz"]);
    let strength = m.physics.crush.expect("it crushes").strength;
    assert_eq!((strength.sigma_lim0, strength.m), (2e8, 10.0));
}

#[test]
fn limit_strength_may_come_from_uniaxial_strengths() {
    let sets = ["material.strength.fixed_angle.sigma_c_MPa=1100", "material.strength.fixed_angle.sigma_t_MPa=48"];
    let m = model("petroleum_coke/h-c-2.toml", &sets);
    let sigma = m.physics.crush.expect("it crushes").strength.sigma_lim0;
    assert!((sigma - 2309.95e6).abs() < 0.01e6, "{sigma}");
}

const SPHERE: &str = r#"
kind = "assembly"
steps = 10
[materials.glass]
name = "glass"
grain = { density_kg_m3 = 2500 }
elastic = { E_GPa = 50, nu = 0.2 }
contact = { friction = 0.3 }
[materials.steel]
name = "steel"
grain = { density_kg_m3 = 7800 }
elastic = { E_GPa = 200, nu = 0.3 }
contact = { friction = 0.2 }
[[grain]]
position_m = [0, 0, 0.1]
radius_m = 0.01
material = "steel"
"#;

#[test]
fn a_box_is_six_planes_that_face_its_inside() {
    let text = format!(
        "{SPHERE}\n[[wall]]\nkind = \"box\"\nmin_m = [-1, -1, 0]\nmax_m = [1, 1, 2]\nfriction = 0.4\nmaterial = \"glass\"\n\
         [[wall]]\nkind = \"cylinder\"\ncentre_m = [0, 0]\nradius_m = 0.5\nstress_kPa = 10\n"
    );
    let m = written(&text, &[]).expect("valid");
    let Rig::Assembly(a) = &m.rig else { panic!() };
    assert_eq!(a.walls.len(), 7);
    assert_eq!(m.physics.materials[usize::from(a.grains[0].material)].name, "steel");
    for wall in &a.walls[..6] {
        let WallShape::Plane { point, normal } = wall.shape else { panic!() };
        let inward: f64 = (0..3).map(|k| ([0.0, 0.0, 1.0][k] - point[k]) * normal[k]).sum();
        assert!(inward > 0.0);
        assert_eq!(wall.material, Some(0));
    }
    assert!(matches!(a.walls[6].drive, Drive::Stress { stress, .. } if stress == 1e4));
}

#[test]
fn disagreements_name_the_key() {
    let plane = "[[wall]]\nkind = \"plane\"\npoint_m = [0, 0, 0]\nnormal = [0, 0, 1]\n";
    for (extra, sets, says) in [
        ("", vec!["grain[0].material=stel"], "\"stel\" is no material of the scene; there are glass, steel"),
        ("", vec!["steps=0"], "must be >= 1"),
        ("", vec!["duration_s=1", "steps=5"], ""),
        ("", vec!["records.tracks=[1]"], "there is no grain 1"),
        ("", vec!["stepping.inertia_scaling=true", "gravity_m_s2=[0,0,-9.81]"], "weight has no meaning"),
        ("", vec!["stepping.inertia_scaling=true", "duration_s=1"], "must be given as `steps`"),
        ("", vec!["crushing.enabled=true"], "materials.steel.comminution: is missing"),
        ("", vec!["contact.law=linear"], "materials.glass.linear: is missing"),
        ("", vec!["specimen.grains=5"], "has no meaning in an assembly"),
        ("", vec!["grain[3].radius_m=1"], "there is no entry 3"),
        (plane, vec!["wall[0].normal=[0,0,0]"], "must not be zero"),
        (plane, vec!["wall[0].normal=[0,0,-1]"], "lies behind a wall"),
        (plane, vec!["wall[0].normal=[0,-1]"], "list of 3 numbers"),
        (plane, vec!["wall[0].radius_m=1"], "has no meaning for a plane"),
        (plane, vec!["wall[0].stress_kPa=5"], "area_m2: is missing"),
        (plane, vec!["wall[0].kind=sphere"], "must be \"plane\" or \"cylinder\" or \"box\""),
    ] {
        let found = written(&format!("{SPHERE}{extra}"), &sets);
        match found {
            // a later choice replaces an earlier one
            Ok(_) => assert_eq!(says, "", "{sets:?} should be refused"),
            Err(e) => {
                let place = if sets.len() == 1 { sets[0] } else { "" };
                assert!(!says.is_empty() && e.contains(says), "{sets:?}: {e}");
                assert!(e.contains(place) || e.contains("scene.toml"), "{e}");
            }
        }
    }
}

/// A scene that imports `csv`.
fn imported(csv: &str) -> Result<Model, String> {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("grains.csv"), csv).expect("written");
    let text = SPHERE.split("[[grain]]").next().expect("a head");
    let text = text.replace("steps = 10", "steps = 10\ngrains_csv = \"grains.csv\"");
    let path = folder.path().join("scene.toml");
    fs::write(&path, text).expect("written");
    let scene = scene::load(&path, &[]).map_err(|e| e.to_string())?;
    scene::model(&scene).map_err(|e| e.to_string())
}

#[test]
fn grains_come_from_csv() {
    let csv =
        "# a comment\nx_mm,y_mm,z_mm,r_mm,generation,material,vz_m_s\n1,2,3,0.5,0,glass,-1\n\n# another\n4, 5, 6, 0.25, 1, 1, 0\n";
    let m = imported(csv).expect("valid");
    let Rig::Assembly(a) = &m.rig else { panic!() };
    assert_eq!(a.grains.len(), 2);
    assert_eq!(a.grains[0].position, [1.0 * 1e-3, 2.0 * 1e-3, 3.0 * 1e-3]);
    assert_eq!(a.grains[0].velocity, [0.0, 0.0, -1.0]);
    assert_eq!((a.grains[1].radius, a.grains[1].material), (0.25 * 1e-3, 1));
}

#[test]
fn csv_mistakes_name_line_and_column() {
    for (csv, says) in [
        ("x,y,z,r\n", "holds no grains"),
        ("", "has no column"),
        ("x,y,z\n1,2,3\n", "has no column r_m"),
        ("x,y,z,r,materiel\n1,2,3,4,glass\n", "materiel: unknown column; did you mean material?"),
        ("x;y;z;r\n1;2;3;4\n", "separated by commas"),
        ("x,x_mm,y,z,r\n1,1,2,3,4\n", "x_mm: this quantity has two columns"),
        ("x,y,z,r,material\n1,2,3,one,glass\n", "grains.csv line 2: r = one: must be a finite number"),
        ("x,y,z,r,material\n1,2,nan,1,glass\n", "grains.csv line 2: z = nan: must be a finite number"),
        ("# c\nx,y,z,r,material\n\n1,2,3,-1,glass\n", "grains.csv line 4: r = -1: must be > 0"),
        ("x,y,z,r,material\n1,2,3\n", "line 2: has 3 values; the header has 5"),
        ("x,y,z,r,material\n1,2,3,1,iron\n", "\"iron\" is no material"),
        ("x,y,z,r,material\n1,2,3,1,glass\n1,2,3,2,steel\n", "is also that of grain 0"),
    ] {
        let e = imported(csv).expect_err(csv);
        assert!(e.contains(says), "{csv:?}: {e}");
    }
}

#[test]
fn a_material_may_be_named_beside_changes_of_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).expect("written");
    };
    write(
        "glass.toml",
        "name = \"glass\"\nsource = \"a book\"\ngrain.density_kg_m3 = 2500\n[elastic]\nE_GPa = 50\nnu = 0.2\n[contact]\nfriction = 0.3\n",
    );
    write(
        "a.toml",
        "kind = \"assembly\"\nsteps = 1\n[material]\nbase = \"glass.toml\"\nelastic.nu = 0.3\n[[grain]]\nposition_m = [0, 0, 0]\nradius_m = 1\n",
    );
    write("b.toml", "base = \"a.toml\"\n[material.elastic]\nE_GPa = 60\n");
    let scene = scene::load(folder.path().join("b.toml"), &[]).expect("valid");
    let m = scene::model(&scene).expect("valid");
    assert_eq!((m.physics.materials[0].young, m.physics.materials[0].poisson), (60e9, 0.3));
    let text = scene::resolved(&scene);
    for line in ["source.density_kg_m3 = \"a book\"", "source.nu = \"replaced in a.toml\"", "source.E_GPa = \"replaced in b.toml\""]
    {
        assert!(text.contains(line), "{line}\n{text}");
    }
    write("c.toml", "base = \"a.toml\"\n[material.elastic]\nnu = 0.7\n");
    let error = scene::load(folder.path().join("c.toml"), &[]).expect_err("nu");
    let error = error.to_string();
    assert!(error.contains("c.toml: material.elastic.nu = 0.7: must be > -1 and < 0.5"), "{error}");
    write("glass.toml", "name = \"glass\"\nelastic.nu = 0.1\ncontact.friction = 0.3");
    let error = scene::load(folder.path().join("a.toml"), &[]).expect_err("density");
    assert!(error.to_string().contains("a.toml: material.grain.density_kg_m3: is missing"), "{error}");
}
