//! Fines from crushing that become points.

use crate::common::model;
use crate::common::typed::{columns, comminute, keeps_its_solids, numbers, run, same_files, summary};
use comminute::model::{Model, Rig};
use comminute::rig::continuum::{Coupled, Engine, State};

const QUIET: [&str; 2] = ["records.figures=false", "records.snapshots=false"];

/// Two grains of silica sand fly at each other inside a loose cloud of soft points, without gravity and far from any side.
fn crash(lost_mass: &str, speed: f64, cell_mm: f64) -> Model {
    let root = env!("CARGO_MANIFEST_DIR");
    let grain = |x: f64, v: f64| {
        format!(
            "[[grain]]\nposition_m = [{x:?}, 0.0, 0.0]\nradius_m = 0.0025\nvelocity_m_s = [{v:?}, 0.3, -0.2]\nspin_rad_s = [20.0, -5.0, 40.0]\nmaterial = \"coarse\"\n"
        )
    };
    let text = format!(
        "kind = \"mixture\"\nsteps = 1\n\
         [materials]\nfines = \"{root}/materials/li2023_fines.toml\"\ncoarse = \"{root}/materials/silica_sand.toml\"\n\
         {}{}\
         [[body]]\nshape = \"box\"\nmaterial = \"fines\"\nmin_mm = [-12.0, -12.0, 6.0]\nmax_mm = [12.0, 12.0, 12.0]\nporosity = 0.5\n\
         [grid]\ncell_mm = {cell_mm:?}\nmin_mm = [-30.0, -30.0, -30.0]\nmax_mm = [30.0, 30.0, 30.0]\n\
         [crushing]\nenabled = true\nlost_mass = \"{lost_mass}\"\nd_limit_over_d50 = 2.0\n[stepping]\nsafety = 0.4\n",
        grain(-0.00251, speed),
        grain(0.00251, -0.5 * speed),
    );
    model(&text, &[])
}

struct Crash {
    model: Model,
    state: State,
    engine: Engine,
}

impl Crash {
    fn new(lost_mass: &str, speed: f64, cell_mm: f64) -> Crash {
        let model = crash(lost_mass, speed, cell_mm);
        let Rig::Continuum(rig) = &model.rig else { panic!("a continuum") };
        let mut state = State::start(&model, rig).expect("a start");
        let coupled = Coupled::new(&model, rig, state.mixture.as_mut().expect("grains"));
        let engine = Engine::Mixture(Box::new(coupled));
        Crash { model, state, engine }
    }

    fn go(&mut self) {
        let Rig::Continuum(rig) = &self.model.rig else { panic!("a continuum") };
        self.state.advance(&self.model, rig, &mut self.engine, |_, _| Ok(1.0)).unwrap_or_else(|e| panic!("{e}"));
        // the scene has one step; the test goes on
        self.state.phase = comminute::rig::continuum::Phase::Load;
    }

    fn mass_and_momentum(&self) -> (f64, [f64; 3]) {
        self.state.mixture.as_ref().expect("grains").mass_and_momentum(&self.state.continuum)
    }

    /// Of grains, points and their contacts, J, elastic and plastic work of the points included.
    fn energy(&self) -> f64 {
        let (mixture, c) = (self.state.mixture.as_ref().expect("grains"), &self.state.continuum);
        mixture.energies([0.0; 3]).iter().sum::<f64>() + c.totals().kinetic + c.stress_work()
    }

    fn events(&self) -> u64 {
        self.state.mixture.as_ref().expect("grains").grains.crush_events
    }
}

/// Grains, points and reserve keep mass and momentum to rounding through breakages, and insertion brings no energy.
#[test]
fn a_crash_keeps_mass_and_momentum_and_gains_no_energy() {
    let mut crash = Crash::new("points", 60.0, 1.5);
    let (mass, momentum) = crash.mass_and_momentum();
    let size = mass * 60.0;
    let mut points = crash.state.continuum.points().len();
    for _ in 0..400 {
        let (before, energy) = (crash.events(), crash.energy());
        crash.go();
        // a breakage and the points that come of it give no energy
        assert!(crash.events() == before || crash.energy() < energy, "{} J after {energy} J", crash.energy());
        let (m, p) = crash.mass_and_momentum();
        assert!((m / mass - 1.0).abs() < 1e-13, "{m} of {mass}");
        assert!((0..3).all(|a| (p[a] - momentum[a]).abs() < 1e-12 * size), "{p:?} of {momentum:?}");
        let now = crash.state.continuum.points().len();
        assert!(now == points || crash.events() > before);
        points = now;
    }
    let fines = crash.state.mixture.as_ref().and_then(|m| m.fines.as_ref()).expect("fines");
    assert!(crash.events() >= 2 && fines.points > 10, "{} events, {fines:?}", crash.events());
    assert!(fines.entered.mass > 0.0 && fines.reserve.mass > 0.0);
    // at most what fills the daughters' gaps at the porosity of the soil
    let lost = fines.entered.mass + fines.reserve.mass;
    assert!(fines.entered.mass <= 0.5 * lost * (1.0 + 1e-12), "{fines:?}");
    // of the points' kinetic energy none is from nowhere
    let of_pair = 0.5 * (mass / 2.0) * (60.0f64.powi(2) + 30.0f64.powi(2));
    assert!(fines.entered.kinetic >= 0.0 && fines.entered.kinetic < of_pair, "{fines:?}");
}

/// Where fines enter they are no denser than the soil: with the daughters and what was there before they fill no more than their mother's sphere, and at least two points are
/// in each of their cells.
#[test]
fn newborn_fines_are_as_loose_as_the_soil() {
    let mut crash = Crash::new("points", 60.0, 1.5);
    let before = crash.state.continuum.points().clone();
    while crash.state.mixture.as_ref().and_then(|m| m.fines.as_ref()).is_none_or(|f| f.points == 0) {
        crash.go();
    }
    let (mixture, points) = (crash.state.mixture.as_ref().expect("grains"), crash.state.continuum.points());
    let (g, settings) = (&mixture.grains.grains, crash.state.continuum.settings());
    let born: Vec<usize> = (0..points.len()).filter(|&i| points.id[i] >= before.next_id).collect();
    assert!(born.len() > 10, "{}", born.len());
    let sphere = |r: f64| 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
    // equal mothers
    let (mother, events) = (sphere(0.0025), crash.events() as f64);
    let daughters: f64 = (0..g.len()).filter(|&i| g.generation[i] > 0).map(|i| sphere(g.pos[i][3])).sum();
    let fines: f64 = born.iter().map(|&i| points.position[i][3]).sum();
    let solids: f64 = born.iter().map(|&i| points.solid(i)).sum();
    assert!(daughters + fines <= events * mother * (1.0 + 1e-12), "{daughters} and {fines} of {events} times {mother}");
    assert!((1.0 - solids / fines - 0.5).abs() < 1e-12, "porosity of the soil");
    let cell = |i: usize| -> [i64; 3] {
        std::array::from_fn(|a| ((points.position[i][a] - settings.lower[a]) / settings.cell).floor() as i64)
    };
    for &i in &born {
        assert!((0..points.len()).filter(|&j| cell(j) == cell(i)).count() >= 2, "point {} is alone", points.id[i]);
    }
}

/// Where fines enter, no force is there at the first look: the daughters go on as if there were none.
#[test]
fn newborn_contacts_bear_no_force() {
    let mut crash = Crash::new("points", 60.0, 1.5);
    while crash.events() == 0 {
        crash.go();
    }
    let mixture = crash.state.mixture.as_mut().expect("grains");
    let first = crash.state.continuum.points().next_id - mixture.fines.as_ref().expect("fines").points as u32;
    let mut looked = 0;
    crash.go();
    let mixture = crash.state.mixture.as_ref().expect("grains");
    // the look at the start of that cycle was their first; in one step they cannot have gone deep
    for contact in mixture.point_contacts.candidates.iter().filter(|g| g.point >= first) {
        looked += 1;
        assert!(contact.touch.overlap < 1e-6, "{contact:?}");
    }
    assert!(looked > 20, "{looked}");
}

/// A grid so coarse that what a breakage loses is less than a point, or would be alone in its cell: all of it is kept in reserve.
#[test]
fn fines_with_nowhere_to_go_stay_in_reserve() {
    let mut crash = Crash::new("points", 60.0, 12.0);
    let (mass, points) = (crash.mass_and_momentum().0, crash.state.continuum.points().len());
    for _ in 0..400 {
        crash.go();
        assert!((crash.mass_and_momentum().0 / mass - 1.0).abs() < 1e-13);
    }
    let fines = crash.state.mixture.as_ref().and_then(|m| m.fines.as_ref()).expect("fines");
    assert!(crash.events() >= 2 && fines.reserve.mass > 0.0, "{fines:?}");
    assert_eq!((fines.points, fines.entered.mass, crash.state.continuum.points().len()), (0, 0.0, points));
}

/// In an oedometer: all mass is accounted for in every row, and the run stops and resumes to the byte.
#[test]
fn fines_enter_an_oedometer_and_resume_to_the_byte() {
    let folder = tempfile::tempdir().expect("folder");
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));
    let own = ["test.axial_strain=0.012", "records.rows=60", "crushing.lost_mass=points"];
    let sets: Vec<&str> = own.into_iter().chain(QUIET).collect();
    run("mixture/oedometer_crushing", &whole, &sets, &[]).assert().success();
    let rows = columns(&whole, ["crush_events", "fines_points", "fines_mass_kg", "reserve_mass_kg", "total_mass_kg", "grains"]);
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    assert!(rows.iter().all(|r| (r[4] / first[4] - 1.0).abs() < 1e-12), "{rows:?}");
    assert!(last[0] == 1.0 && last[1] > 10.0 && last[2] > 0.0 && last[3] > 0.0, "{last:?}");
    keeps_its_solids(&whole);
    let s = summary(&whole);
    // just before the breakage and just after it; what a run had written since its checkpoint when it was killed goes
    let at = numbers(&whole.join("breakage.csv"), ["step"])[0][0] as u64;
    let later = || {
        for file in ["breakage.csv", "gsd.csv", "history.csv"] {
            let written = std::fs::read_to_string(parts.join(file)).unwrap_or_default();
            std::fs::write(parts.join(file), format!("{written}2,9999,later\n")).expect(file);
        }
    };
    let [before, after] = [at - 3, at + 3].map(|step| step.to_string());
    run("mixture/oedometer_crushing", &parts, &sets, &["--stop-after", &before]).assert().code(130);
    later();
    comminute("resume").arg(&parts).args(["--threads", "2", "--quiet", "--stop-after", &after]).assert().code(130);
    later();
    comminute("resume").arg(&parts).args(["--threads", "2", "--quiet"]).assert().success();
    same_files(&whole, &parts);
    assert_eq!(summary(&parts)["breakages"], s["breakages"]);
}

/// Grains alone at the start: the first points there are come from crushing. Without a soil around them some are pushed through the platen by grains: they are
/// in the reserve then.
#[test]
fn fines_enter_where_there_was_no_point() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let own = ["coarse.mass_fraction=1.0", "test.axial_strain=0.01", "records.rows=10", "seed.packing=2", "seed.strength=2"];
    let sets: Vec<&str> = own.into_iter().chain(QUIET).collect();
    run("mixture/coke_in_fines", &out, &sets, &[]).assert().success();
    let rows = columns(&out, ["crush_events", "fines_points", "total_mass_kg"]);
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    assert!(last[0] > 0.0 && last[1] > 0.0, "{last:?}");
    assert!((last[2] / first[2] - 1.0).abs() < 1e-12);
}

#[test]
fn fines_that_cannot_be_points_are_refused() {
    let check = |sets: &[&str], says: &str| {
        let mut command = comminute("check");
        command.arg("experiments/mixture/oedometer_crushing.toml");
        for set in sets {
            command.args(["--set", set]);
        }
        command.assert().code(2).stderr(predicates::str::contains(says));
    };
    check(&["crushing.lost_mass=points", "crushing.enabled=false"], "needs crushing.enabled = true");
    check(&["crushing.lost_mass=sand"], "crushing.lost_mass");
    check(&["crushing.lost_mass=points", "crushing.release_strain=0"], "crushing.release_strain");
}
