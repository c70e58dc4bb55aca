//! Plane strain: polygons and discs among themselves, and with points.

use crate::scene::Scene;
use comminute::rigid::Other;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A material whose contacts are springs, N/m per metre of depth, without friction or loss.
fn spring(k: f64, restitution: f64, friction: f64) -> String {
    format!(
        "[contact]\nlaw = \"spring\"\n[material]\nname = \"stuff\"\ngrain.density_kg_m3 = 2500.0\nelastic.E_GPa = 1.0\nelastic.nu = 0.2\ncontact.friction = {friction:?}\n\
         contact.restitution = {restitution:?}\nspring.k_n_N_m = {k:?}\nspring.k_t_N_m = {:?}\n",
        0.5 * k
    )
}

/// Pentagons, rods and discs hit each other, turned and aside at random: momentum and angular momentum stay to rounding, nothing leaves the plane, energy comes
/// back but for the leapfrog's error where a spring begins and ends within a step.
#[test]
fn polygons_that_meet_keep_momenta_and_energy() {
    let shapes = [
        "points_mm = [0.0, 0.0, 40.0, -5.0, 60.0, 30.0, 25.0, 50.0, -5.0, 30.0]\nrounding_mm = 4.0",
        "points_mm = [-30.0, 0.0, 30.0, 0.0]\nrounding_mm = 8.0",
        "points_mm = [0.0, 0.0]\nrounding_mm = 25.0",
    ];
    let mut changes = Vec::new();
    for (k, (first, second)) in (0..3).flat_map(|i| (i..3).map(move |j| (i, j))).enumerate() {
        for seed in 0..5 {
            let mut random = ChaCha8Rng::seed_from_u64(17 * k as u64 + seed);
            let mut one = |x: f64| random.random_range(-x..x);
            let block = |shape: usize, at: [f64; 2], angle: f64, v: f64, spin: f64| {
                format!(
                    "[[block]]\nshape = \"polygon\"\n{}\nposition_mm = [{:?}, {:?}, 0.0]\nangle_deg = {angle:?}\nvelocity_m_s = [{v:?}, 0.0, 0.0]\nspin_rad_s = [0.0, 0.0, {spin:?}]\n",
                    shapes[shape], at[0], at[1]
                )
            };
            let bodies =
                block(first, [0.0; 2], one(180.0), 0.0, one(9.0)) + &block(second, [120.0, one(15.0)], one(180.0), -1.5, one(9.0));
            let mut scene = Scene::of(&format!(
                "kind = \"mixture\"\nduration_s = 9.0\ngrid.plane_strain = true\n{bodies}\n{}",
                spring(3e8, 1.0, 0.0)
            ));
            let before = (scene.momenta(), scene.energy());
            scene.run(0.12).unwrap_or_else(|e| panic!("{k} {seed}: {e}"));
            let after = (scene.momenta(), scene.energy());
            assert!((scene.block(1).velocity[0] + 1.5).abs() > 1e-3, "{k} {seed}: they missed");
            for (one, other) in before.0.as_flattened().iter().zip(after.0.as_flattened()) {
                assert!((one - other).abs() < 1e-12, "{k} {seed}: {before:?} {after:?}");
            }
            for b in &scene.all().blocks {
                assert!(b.centre[2] == 0.0 && b.velocity[2] == 0.0 && b.spin()[..2] == [0.0; 2], "{b:?}");
            }
            changes.push(after.1 / before.1 - 1.0);
        }
    }
    let mean = changes.iter().sum::<f64>() / changes.len() as f64;
    assert!(mean.abs() < 5e-4 && changes.iter().all(|change| change.abs() < 3e-3), "mean {mean:e}: {changes:?}");
}

/// An elastic square of 51 × 51 points that weighs 25 N on a fixed rod (Jiang et al. 2020, section 5.2 and Figs 11 to 14): its lowest points bear 25/51 = 0.4902 N each, and
/// while it slides with friction 0.3 the rod is drawn along with 7.5 N.
#[test]
fn a_square_presses_on_a_rod_with_its_weight_and_its_friction() {
    let square = |speed: f64, friction: f64, damping: f64| {
        let cell = 200.0 / 51.0;
        format!(
            "kind = \"mixture\"\nduration_s = 9.0\ngravity_m_s2 = [0.0, -1.0, 0.0]\n\
             [[body]]\nshape = \"box\"\nmin_mm = [0.0, 0.0, 0.0]\nmax_mm = [100.0, 100.0, 0.0]\nvelocity_m_s = [{speed:?}, 0.0, 0.0]\n\
             [[block]]\nshape = \"polygon\"\npoints_mm = [-60.0, 0.0, 760.0, 0.0]\nrounding_mm = 5.0\nposition_mm = [410.0, -5.0, 0.0]\ndriven = true\n\
             [grid]\nplane_strain = true\ncell_mm = {cell:?}\npoints_per_edge = 2\nmin_mm = [{:?}, {:?}, 0.0]\nmax_mm = [{:?}, {:?}, 1.0]\npic = 0.02\n{}\n\
             [damping]\nlocal = {damping:?}\n[material.continuum]\nlaw = \"elastic\"\nE_MPa = 8.8\nnu = 0.2558\n",
            -10.0 * cell,
            -10.0 * cell,
            190.0 * cell,
            35.0 * cell,
            spring(6e6, 0.1, friction)
        )
        .replace("law = \"spring\"", &format!("law = \"spring\"\npoint_radius_mm = {:?}", 0.25 * cell))
    };
    let mut rest = Scene::of(&square(0.0, 0.1, 0.3));
    rest.run(0.6).expect("a run");
    let total = rest.all().forces(0)[0];
    assert!((total[1] + 25.0).abs() < 0.05 && total[0].abs() < 0.01, "{total:?}");
    let each: Vec<f64> = rest.all().touching().filter(|c| matches!(c.other, Other::Point(_))).map(|c| c.force()[1]).collect();
    assert_eq!(each.len(), 51);
    // the corners of an elastic square that friction holds bear more
    let share = -25.0 / 51.0;
    assert!(each.iter().all(|f| (f / share - 1.0).abs() < 0.17), "{each:?}");
    assert!(each[3..48].iter().all(|f| (f / share - 1.0).abs() < 0.08), "{each:?}");
    let mut slides = Scene::of(&square(1.0, 0.3, 0.0));
    slides.run(0.4).expect("a run");
    let total = slides.all().forces(0)[0];
    assert!((total[0] / total[1] + 0.3).abs() < 1e-6, "{total:?}");
    // as it still bounces, the mean: what it has lost of its speed
    let lost = slides.state.continuum.totals();
    let lost = 1.0 - lost.momentum[0] / lost.mass;
    let mean = 25.0 * lost / slides.state.time;
    assert!((mean / 7.5 - 1.0).abs() < 0.03, "{mean} N");
}
