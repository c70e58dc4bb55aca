//! Hard cases: grains that points turn, hold and lose.

use crate::common::Ball;
use crate::common::typed::{columns, comminute, number, run, same_files, summary};
use crate::points::{continuum, elastic};
use crate::scene::{MASS, Meeting, STUFF, free_scene, impact, meeting, radius};
use comminute::coupling::Rates;
use comminute::mpm::{Continuum, LoadingPlate};

const ONE: Rates = Rates { grains: 1, continuum: 1 };
const QUIET: [&str; 2] = ["records.figures=false", "records.snapshots=false"];

/// One point of a ball's mass at rest, in the middle of the grid of [`impact`], at six radii; with friction, grains alone can be anywhere.
fn one_point() -> Continuum {
    let c = impact(None).continuum;
    continuum(c.settings().clone(), elastic(STUFF.young, STUFF.poisson), c.points().clone())
}

fn ball(height: f64, speed: f64) -> Ball {
    let r = radius();
    Ball { at: [6.0 * r, 6.0 * r, height * r], radius: r, velocity: [0.0, 0.0, speed], ..Ball::default() }
}

fn kinetic(m: &Meeting) -> f64 {
    m.mixture.energies([0.0; 3])[0] + m.continuum.totals().kinetic
}

/// A ball so fast in spin that it slides as long as it touches: the point gets μ times the impulse along the surface, and the spin falls by
/// 5/2 of that speed over the radius, less half of the overlap in the arm (eqs 25–27).
#[test]
fn a_point_turns_a_spinning_ball() {
    let mut m = impact(None);
    let (r, spin) = (radius(), 60.0 / radius());
    m.mixture.grains.grains.spin[0][1] = spin;
    m.go(1e-6, ONE, 6000);
    let (grain, point) = (m.velocity_of_grain(), m.velocity_of_points());
    // while they touch they go 2 mm past each other, and the normal turns with them
    assert!((grain[0] / (STUFF.friction * 5.0) - 1.0).abs() < 0.01, "{grain:?}");
    assert!((grain[0] + point[0]).abs() < 1e-12 * 5.0 && grain[2].abs() < 0.02 * 5.0, "{grain:?} {point:?}");
    let lost = (spin - m.mixture.grains.grains.spin[0][1]) * r / (2.5 * grain[0]);
    assert!(lost > 0.97 && lost < 1.0, "{lost}");
    let [x, _, z, _] = m.mixture.grains.grains.spin[0];
    assert_eq!([x, z], [0.0; 2]);
}

/// Fully outside of the points, then of the grid.
#[test]
fn a_grain_outside_of_the_points_flies_on() {
    let mut m = impact(Some(4));
    let grains = &mut m.mixture.grains.grains;
    (grains.pos[0][2], grains.vel[0][2]) = (11.0 * radius(), 500.0);
    m.go(2e-6, ONE, 300);
    let settings = m.continuum.settings();
    let top = settings.lower[2] + settings.cell * f64::from(settings.cells[2]);
    assert!(m.mixture.grains.grains.pos[0][2] > top, "it has left the grid");
    assert_eq!((m.velocity_of_grain(), m.continuum.totals().kinetic), ([0.0, 0.0, 500.0], 0.0));
    assert!(m.mixture.point_contacts.candidates.is_empty());
}

#[test]
fn a_point_between_two_grains_lets_them_bounce() {
    let mut m = meeting(&free_scene(&[ball(8.1, -5.0), ball(3.9, 5.0)]), one_point());
    m.go(1e-6, ONE, 6000);
    let speed = |k: usize| m.mixture.grains.grains.vel[k][2];
    assert!((speed(0) / 5.0 - 1.0).abs() < 1e-3 && (speed(0) + speed(1)).abs() < 1e-9, "{} {}", speed(0), speed(1));
    let at = m.continuum.points().position[0];
    assert!((0..3).all(|a| (at[a] - 6.0 * radius()).abs() < 1e-9), "{at:?}");
}

/// The ball stays above the point and the point above what is below it, the ball goes up in the end, and energy is that of the start; answers the largest force on platens, N.
fn comes_back(m: &mut Meeting, floor: f64) -> f64 {
    let (before, mut most) = (kinetic(m), 0.0_f64);
    for _ in 0..6000 {
        m.go(1e-6, ONE, 1);
        let (point, grain) = (m.continuum.points().position[0][2], m.mixture.grains.grains.pos[0][2]);
        assert!(point > floor && grain > point, "{point} {grain} over {floor}");
        most = m.plates.iter().map(|p| p.reaction).fold(most, f64::max);
    }
    let after = kinetic(m);
    assert!(m.velocity_of_grain()[2] > 0.0 && (after / before - 1.0).abs() < 0.01, "{after} of {before} J");
    most
}

/// A ball comes down on a point that lies on a wall: neither goes through, and no energy comes of it.
#[test]
fn a_point_between_a_grain_and_a_wall_holds() {
    let floor = 5.0 * radius();
    let wall = format!("[[wall]]\nkind = \"plane\"\npoint_m = [0.0, 0.0, {floor:?}]\nnormal = [0.0, 0.0, 1.0]\nfriction = 0.5\n");
    let mut m = meeting(&(free_scene(&[ball(8.1, -5.0)]) + "\n" + &wall), one_point());
    assert!((kinetic(&m) / (0.5 * MASS * 25.0) - 1.0).abs() < 1e-6);
    comes_back(&mut m, floor);
}

/// The same on a platen of a rig, which pushes the point beside its middle.
#[test]
fn a_point_between_a_grain_and_a_platen_holds() {
    let floor = 5.0 * radius();
    let mut m = meeting(&free_scene(&[ball(8.1, -5.0)]), one_point());
    m.plates = vec![LoadingPlate::new(
        &m.continuum,
        [0.0, 0.0, floor],
        [0.0, 0.0, 1.0],
        STUFF.young / (1.0 - STUFF.poisson * STUFF.poisson),
    )];
    let most = comes_back(&mut m, floor);
    assert!(most > 0.0, "{most} N");
}

/// A grain that is too soft to be held goes through a wall: the run says so and keeps its data.
#[test]
fn a_grain_that_has_left_through_a_wall_stops_the_run() {
    let folder = tempfile::tempdir().expect("folder");
    let (scene, out) = (folder.path().join("scene.toml"), folder.path().join("out"));
    let text =
        std::fs::read_to_string(format!("{}/experiments/mixture/ball_impact.toml", env!("CARGO_MANIFEST_DIR"))).expect("scene");
    let text = text.replace("velocity_m_s = [0.0, 0.0, -5.0]", "velocity_m_s = [0.0, 0.0, 50.0]")
        + "\n[[wall]]\nkind = \"plane\"\npoint_m = [0.0, 0.0, 0.108]\nnormal = [0.0, 0.0, -1.0]\n";
    std::fs::write(&scene, text).expect("written");
    let mut command = comminute("run");
    command.arg(&scene).arg("--out").arg(&out).arg("--quiet");
    for set in QUIET.into_iter().chain(["materials.ball.elastic.E_GPa=1e-5", "duration_s=0.01", "grid.cell_mm=13.6798076"]) {
        command.args(["--set", set]);
    }
    command.assert().failure().stderr(predicates::str::contains("has left through wall 0"));
    for file in ["history.csv", "points_final.csv", "grains_final.csv"] {
        assert!(out.join(file).is_file(), "{file}");
    }
}

/// Rocks of 50 GPa on soil of 3 MPa: nothing has to be said about steps, and next to no energy is lost.
#[test]
fn stiff_rock_falls_on_soft_soil() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    run("mixture/stiff_rock", &out, &[&["duration_s=0.03", "grid.pic=0.0"][..], &QUIET].concat(), &[]).assert().success();
    let [momentum, speed] = ["momentum_z_kg_m_s", "coarse_kinetic_J"].map(|name| columns(&out, [name]));
    assert!(momentum.len() > 10 && speed.iter().all(|s| s[0].is_finite() && s[0] >= 0.0));
    let (steps, cycles) = (number(&summary(&out), "steps"), number(&summary(&out), "cycles"));
    assert!(steps < 100.0 && cycles <= steps, "{steps} steps, {cycles} cycles");
    let lost = columns(&out, ["dissipated_share"]).last().expect("rows")[0];
    assert!(lost > -0.01 && lost < 0.1, "{lost}");
}

/// No grains at all: the specimen is that of its fines.
#[test]
fn a_mixture_of_fines_alone_is_sheared() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let own = ["coarse.mass_fraction=0", "test.axial_strain=0.002", "records.rows=10"];
    run("../tests/gpu/mixture", &out, &[&own[..], &QUIET].concat(), &[]).assert().success();
    let s = summary(&out);
    assert_eq!((number(&s, "coarse_mass_fraction"), number(&s, "points")), (0.0, 1000.0), "{s}");
    let rows = columns(&out, ["sigma_3_kPa", "q_kPa", "q_matrix_kPa"]);
    let [lateral, q, matrix] = rows[rows.len() - 1];
    assert!((lateral / 50.0 - 1.0).abs() < 0.02 && q > 5.0 && (matrix / q - 1.0).abs() < 0.1, "{lateral} {q} {matrix}");
}

/// A cylinder of grains and fines in its shell: the cell pressure held, the same bytes when stopped and resumed.
#[test]
fn a_cylinder_of_a_mixture_is_sheared_in_its_shell() {
    let folder = tempfile::tempdir().expect("folder");
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));
    let own = ["grid.grains_per_point=64", "body[0].height_mm=60.0", "test.axial_strain=0.001", "records.rows=10"];
    let sets = [&own[..], &QUIET].concat();
    run("mixture/triaxial_cylinder", &whole, &sets, &[]).assert().success();
    let s = summary(&whole);
    assert!((number(&s, "coarse_mass_fraction") - 0.2).abs() < 0.02 && number(&s, "point_contacts") > 50.0, "{s}");
    let rows = columns(&whole, ["sigma_3_kPa", "q_kPa", "platen_difference"]);
    let [lateral, q, difference] = rows[rows.len() - 1];
    assert!((lateral / 50.0 - 1.0).abs() < 0.03 && q > 3.0 && difference < 0.1, "{lateral} {q} {difference}");
    let half = (number(&s, "steps") as u64 / 2).to_string();
    run("mixture/triaxial_cylinder", &parts, &sets, &["--stop-after", &half]).assert().code(130);
    comminute("resume").arg(&parts).args(["--threads", "2", "--quiet"]).assert().success();
    same_files(&whole, &parts);
}
