//! Rigid bodies that break in two or into given pieces, and walls that move, as a user types them.

use super::typed::{refused, resumes, run, scene};
use crate::common::typed::{number, numbers, summary};

/// A cube between two platens, of which the upper one comes down; its strength has no spread.
pub const CUBE: &str = r#"
kind = "mixture"
duration_s = 0.0013
crushing.enabled = true
[[wall]]
kind = "plane"
point_m = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
[[wall]]
kind = "plane"
point_m = [0.0, 0.0, 0.0201]
normal = [0.0, 0.0, -1.0]
velocity_m_s = 0.1
[[block]]
shape = "box"
size_mm = [20.0, 20.0, 20.0]
position_mm = [0.0, 0.0, 10.001]
[material]
name = "stone"
grain.density_kg_m3 = 2650.0
elastic.E_GPa = 47.0
elastic.nu = 0.3
contact.friction = 0.4
strength.d0_mm = 20.0
strength.fixed_angle = { sigma_lim0_MPa = 50.0, theta0_rad = 0.13, m = 3.0, var = 0.0 }
comminution.d50_mm = 10.0
comminution.d_limit_over_d50 = 0.5
[records]
rows = 300
figures = false
snapshots = false
"#;

/// It breaks at the force of the criterion with the diameter of the sphere of its volume, its halves at theirs by the power of size, and so on. All mass stays; what the
/// platen gives is stored, moves, or has gone with the contacts of what broke and with friction.
#[test]
fn a_cube_breaks_at_the_force_of_its_size_and_so_do_its_pieces() {
    let folder = tempfile::tempdir().expect("folder");
    let out = run(folder.path(), CUBE, "run", &[]);
    let broken = numbers(
        &out.join("block_breakage.csv"),
        ["diameter_mm", "force_N", "limit_force_N", "block_mass_g", "piece_mass_g", "stored_J"],
    );
    assert!(broken.len() >= 7, "{}", broken.len());
    let sine = 0.13_f64.sin();
    for [d, force, limit, ..] in &broken {
        let strength = 50.0 * 20.0 / d;
        let exact = strength * std::f64::consts::FRAC_PI_4 * d * d * sine * sine;
        assert!((limit / exact - 1.0).abs() < 1e-6, "{limit} {exact}");
        // the platen goes on for a step
        assert!(*force > *limit && *force < 1.05 * limit, "{force} {limit}");
    }
    // the sphere of the cube's volume, but for the round of its edges; halves, but for what the edges at the cut lose
    let sphere = (6.0 / std::f64::consts::PI).cbrt() * 20.0;
    assert!((broken[0][0] / sphere - 1.0).abs() < 1e-3, "{}", broken[0][0]);
    assert!((broken[1][0] / (sphere / 2.0_f64.cbrt()) - 1.0).abs() < 2e-3, "{}", broken[1][0]);
    let s = summary(&out);
    assert_eq!((number(&s, "crush_events"), number(&s, "blocks")), (broken.len() as f64, broken.len() as f64 + 1.0));
    let last = numbers(&out.join("blocks.csv"), ["step", "mass_kg", "generation"]);
    let end = last.last().expect("rows")[0];
    let at_end: Vec<_> = last.iter().filter(|row| row[0] == end).collect();
    let mass: f64 = at_end.iter().map(|row| row[1]).sum();
    assert!(at_end.len() == broken.len() + 1 && (mass / 0.0212 - 1.0).abs() < 1e-8, "{mass}");
    // energy: nothing is made, and little but the broken contacts' is lost
    let stored: f64 = broken.iter().map(|row| row[5]).sum();
    let history = numbers(&out.join("history.csv"), ["dissipated_J", "platen_work_J"]);
    let [dissipated, work] = history[history.len() - 1];
    assert!(dissipated > stored && dissipated < stored + 0.05 * work, "{dissipated} {stored} {work}");
    // a sieve that the cube just passes is none that holds its pieces
    let sieves = numbers(&out.join("gsd.csv"), ["time_s", "diameter_mm", "passing_percent"]);
    let time = sieves.last().expect("rows")[0];
    let passing = |at: f64| {
        let rows = sieves.iter().filter(|row| row[0] == at && row[1] < 19.0);
        rows.map(|row| row[2]).fold(0.0, f64::max)
    };
    assert!(passing(0.0) == 0.0 && passing(time) > 90.0, "{} {}", passing(0.0), passing(time));
}

/// The same bytes on one and two threads and after a stop in the midst of the breakages, whose files were cut back to it.
#[test]
fn breakages_go_on_to_the_byte() {
    let folder = tempfile::tempdir().expect("folder");
    let whole = run(folder.path(), CUBE, "whole", &["--threads", "1"]);
    let steps = numbers(&whole.join("block_breakage.csv"), ["step"]);
    let stops = [steps[0][0], steps[0][0] + 1.0, steps[4][0] + 1.0].map(|step| step as u64);
    let files = ["blocks.csv", "block_breakage.csv", "block_surfaces.csv", "walls.csv", "gsd.csv", "history.csv"];
    resumes(&whole, &scene(folder.path(), CUBE), &stops, &files);
}

/// A piece passes where its body passes, though the hole of each is sought in steps of a degree: halves of a cube of points once were 6·10⁻⁵ coarser than the cube, and the run ended.
#[test]
fn pieces_are_no_coarser_than_their_body() {
    let corners = (0..8).flat_map(|k| (0..3).map(move |a| if k >> a & 1 == 1 { 10.0 } else { -10.0 })).collect::<Vec<f64>>();
    let cube = format!("shape = \"polyhedron\"\npoints_mm = {corners:?}");
    let text = CUBE.replace("shape = \"box\"\nsize_mm = [20.0, 20.0, 20.0]", &cube);
    let folder = tempfile::tempdir().expect("folder");
    let out = run(folder.path(), &text, "run", &["--set", "duration_s=0.0011"]);
    assert_eq!(number(&summary(&out), "blocks"), 2.0);
}

const ENABLED: &str = "crushing.enabled = true";

/// Seeds of the octants.
const OCTANTS: &str = "[-0.5, -0.5, -0.5, 0.5, -0.5, -0.5, -0.5, 0.5, -0.5, 0.5, 0.5, -0.5, -0.5, -0.5, 0.5, 0.5, -0.5, 0.5, -0.5, 0.5, 0.5, 0.5, 0.5, 0.5]";

/// A cube breaks into its octants at the force at which it would break in two, and these into theirs; all mass and energy are accounted for, and a stop in the midst changes nothing.
#[test]
fn a_cube_breaks_into_its_octants() {
    let folder = tempfile::tempdir().expect("folder");
    let text = CUBE.replace(ENABLED, &format!("{ENABLED}\ncrushing.block_pieces = {OCTANTS}"));
    let out = run(folder.path(), &text, "run", &[]);
    let broken = numbers(
        &out.join("block_breakage.csv"),
        ["block", "piece", "pieces", "block_mass_g", "piece_mass_g", "lost_volume_mm3", "stored_J", "step"],
    );
    let [block, piece, pieces, mass, second, lost, ..] = broken[0];
    assert_eq!([block, piece, pieces], [0.0, 1.0, 8.0]);
    assert!((mass / 2.65 - 1.0).abs() < 1e-9 && (second / mass - 1.0).abs() < 1e-9, "{mass} {second}");
    // eight cubes of 10 mm with edges of 0.5 mm, by Steiner's formula
    let (inner, r, pi) = (9.0_f64, 0.5_f64, std::f64::consts::PI);
    let rounded = inner.powi(3) + 6.0 * inner.powi(2) * r + 3.0 * pi * inner * r.powi(2) + 4.0 / 3.0 * pi * r.powi(3);
    assert!((lost / (8000.0 - 8.0 * rounded) - 1.0).abs() < 1e-6, "{lost}");
    assert!(broken.len() > 1 && broken.iter().all(|row| row[2] > 1.0), "{}", broken.len());
    let bodies = 1.0 + broken.iter().map(|row| row[2] - 1.0).sum::<f64>();
    let s = summary(&out);
    assert_eq!((number(&s, "crush_events"), number(&s, "blocks")), (broken.len() as f64, bodies));
    let last = numbers(&out.join("blocks.csv"), ["step", "mass_kg"]);
    let end = last.last().expect("rows")[0];
    let mass: f64 = last.iter().filter(|row| row[0] == end).map(|row| row[1]).sum();
    assert!((mass / 0.0212 - 1.0).abs() < 1e-8, "{mass}");
    let stored: f64 = broken.iter().map(|row| row[6]).sum();
    let columns = ["dissipated_J", "platen_work_J", "contact_J", "coarse_kinetic_J"];
    let [dissipated, work, contact, kinetic] = *numbers(&out.join("history.csv"), columns).last().expect("rows");
    assert!(((dissipated + contact + kinetic) / work - 1.0).abs() < 1e-6, "{dissipated} {contact} {kinetic} {work}");
    assert!(dissipated > stored && dissipated < work, "{dissipated} {stored} {work}");
    let files = ["blocks.csv", "block_breakage.csv", "block_surfaces.csv", "history.csv"];
    resumes(&out, &scene(folder.path(), &text), &[broken[0][7] as u64, broken[0][7] as u64 + 1], &files);
}

/// In plane strain the cut goes through the two contacts: a square under a strip of its width breaks into halves, which stand beside each other.
#[test]
fn a_square_breaks_along_the_line_of_its_contacts() {
    let square = r#"shape = "polygon"
points_mm = [-9.0, -9.0, 9.0, -9.0, 9.0, 9.0, -9.0, 9.0]
rounding_mm = 1.0
position_mm = [0.0, 10.001, 0.0]"#;
    let text = CUBE
        .replace("shape = \"box\"\nsize_mm = [20.0, 20.0, 20.0]\nposition_mm = [0.0, 0.0, 10.001]", square)
        .replace("normal = [0.0, 0.0, 1.0]", "normal = [0.0, 1.0, 0.0]")
        .replace("normal = [0.0, 0.0, -1.0]", "normal = [0.0, -1.0, 0.0]")
        .replace("point_m = [0.0, 0.0, 0.0201]", "point_m = [0.0, 0.0201, 0.0]")
        .replace("contact.friction = 0.4", "contact.friction = 0.4\nspring = { k_n_N_m = 1e9, k_t_N_m = 5e8 }")
        .replace("[records]", "[grid]\nplane_strain = true\n[contact]\nlaw = \"spring\"\n[records]");
    let folder = tempfile::tempdir().expect("folder");
    let out = run(folder.path(), &text, "run", &["--set", "duration_s=0.004"]);
    let broken = numbers(&out.join("block_breakage.csv"), ["normal_x", "normal_y", "block_mass_g", "piece_mass_g", "diameter_mm"]);
    let [x, y, one, other, d] = broken[0];
    assert!(x.abs() > 1.0 - 1e-9 && y.abs() < 1e-9 && (one / other - 1.0).abs() < 1e-9, "{broken:?}");
    let [force, limit] = numbers(&out.join("block_breakage.csv"), ["force_N", "limit_force_N"])[0];
    let exact = 50e6 * 20e-3 * 0.13_f64.sin();
    assert!((limit / exact - 1.0).abs() < 1e-6 && force < 1.1 * limit, "{force} {limit} {exact}");
    // the disc of the area 20² − (4 − π) 1² mm²
    let area = 400.0 - (4.0 - std::f64::consts::PI);
    assert!((d / (4.0 * area / std::f64::consts::PI).sqrt() - 1.0).abs() < 1e-9, "{d}");
}

/// A wall with a stress comes to its body no faster than a wave of that stress would move it, and then holds the force of the stress on its area. It once stood still.
#[test]
fn a_wall_holds_its_stress_on_a_body() {
    let held = CUBE.replace("crushing.enabled = true\n", "").replace("velocity_m_s = 0.1", "stress_kPa = 500.0\narea_m2 = 4e-4");
    let folder = tempfile::tempdir().expect("folder");
    let out = run(folder.path(), &held, "run", &["--set", "duration_s=0.01"]);
    let rows = numbers(&out.join("walls.csv"), ["wall", "force_N", "speed_m_s", "displacement_mm"]);
    let fastest = rows.iter().map(|row| row[2].abs()).fold(0.0, f64::max);
    let limit = 500e3 / (47e9_f64 * 2650.0).sqrt();
    assert!(fastest <= limit * (1.0 + 1e-8) && fastest > 0.9 * limit, "{fastest} {limit}");
    for (k, force) in [(0.0, 200.0), (1.0, 200.0)] {
        let last = rows.iter().rfind(|row| row[0] == k).expect("rows");
        assert!((last[1] / force - 1.0).abs() < 1e-3, "{last:?}");
    }
    let slow = held.replace("area_m2 = 4e-4", "area_m2 = 4e-4\nmax_velocity_m_s = 0.02");
    let out = run(folder.path(), &slow, "slow", &["--set", "duration_s=0.01"]);
    let rows = numbers(&out.join("walls.csv"), ["speed_m_s"]);
    assert!(rows.iter().all(|[v]| v.abs() <= 0.02) && rows.iter().any(|[v]| *v == 0.02));
}

#[test]
fn what_cannot_break_or_be_held_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let refused = |from: &str, to: &str, says: &str| refused(folder.path(), CUBE, from, to, says);
    let block = "shape = \"box\"\nsize_mm = [20.0, 20.0, 20.0]";
    refused(
        block,
        "shape = \"superquadric\"\nsize_mm = [20.0, 20.0, 20.0]\nblockiness = [2.0, 2.0]",
        "crushing.enabled = true: must be false: block 0, a superquadric, cannot be cut, for it has no corners",
    );
    refused(
        "[[block]]",
        "[[grain]]\nposition_m = [0.05, 0.0, 0.01]\nradius_m = 0.01\n[[block]]",
        "must be false where [[grain]] stands beside [[block]]",
    );
    for (seeds, says) in [
        ("0.0, 0.0, 0.1, 0.5", "must be x, y, z of 2 to 100 seeds, but has 4 numbers"),
        ("0.0, 0.0, 0.1", "must be x, y, z of 2 to 100 seeds, but has 3 numbers"),
        ("0.0, 0.0, 0.1, 0.0, 0.0, 0.1", "has seed 2 twice"),
        ("0.0, 0.0, 0.1, 0.0, 0.0, 1.5", "must be"),
    ] {
        refused(
            ENABLED,
            &format!("{ENABLED}\ncrushing.block_pieces = [{seeds}]"),
            &format!("crushing.block_pieces = [{seeds}]: {says}"),
        );
    }
    refused("velocity_m_s = 0.1", "max_velocity_m_s = 0.1", "wall[1].max_velocity_m_s = 0.1: has no meaning without stress_kPa");
    refused(
        "kind = \"plane\"\npoint_m = [0.0, 0.0, 0.0201]\nnormal = [0.0, 0.0, -1.0]\nvelocity_m_s = 0.1",
        "kind = \"cylinder\"\ncentre_m = [0.0, 0.0]\nradius_m = 0.05\nstress_kPa = 10.0",
        "wall[1].stress_kPa = 10: must stand at a plane in a mixture",
    );
}
