//! Compounds that break into their parts.

use super::breaking::CUBE;
use super::scene::Scene;
use super::typed::{refused, resumes, run, scene};
use crate::common::typed::{number, numbers, summary};
use comminute::rigid::Other;
use std::f64::consts::{FRAC_PI_4, PI};
use std::sync::LazyLock;

/// A plus sign of two bars in place of the cube between platens: the upper one comes down on the upright bar.
static PLUS: LazyLock<String> = LazyLock::new(|| {
    let plus = "shape = \"compound\"\nposition_mm = [0.0, 0.0, 10.001]\n\
        part = [{ shape = \"box\", size_mm = [6.0, 6.0, 20.0] }, { shape = \"box\", size_mm = [20.0, 6.0, 6.0] }]";
    let cube = "shape = \"box\"\nsize_mm = [20.0, 20.0, 20.0]\nposition_mm = [0.0, 0.0, 10.001]";
    assert!(CUBE.contains(cube));
    CUBE.replace(cube, plus)
});

/// Volume of a box with these edges that are round with the radius `r`, by Steiner's formula.
fn rounded(edges: [f64; 3], r: f64) -> f64 {
    let [a, b, c] = edges.map(|edge| edge - 2.0 * r);
    a * b * c + 2.0 * r * (a * b + b * c + c * a) + PI * r * r * (a + b + c) + 4.0 / 3.0 * PI * r.powi(3)
}

/// The plus sign breaks at the force of the criterion with the diameter of the sphere of its volume, into the upright bar and what the other one has on both sides of it; the bar then breaks at
/// its own force. All mass and energy are accounted for, and a stop at the breakage changes nothing.
#[test]
fn a_plus_sign_breaks_into_its_bars() {
    let folder = tempfile::tempdir().expect("folder");
    let out = run(folder.path(), &PLUS, "run", &["--threads", "1"]);
    let table = out.join("block_breakage.csv");
    let broken = numbers(&table, ["pieces", "diameter_mm", "force_N", "limit_force_N", "block_mass_g", "piece_mass_g", "step"]);
    let [pieces, d, force, limit, bar, stub, step] = broken[0];
    let whole = 2.0 * 720.0 - 216.0;
    let sphere = |volume: f64| (6.0 * volume / PI).cbrt();
    assert!(pieces == 3.0 && (d / sphere(whole) - 1.0).abs() < 1e-8, "{broken:?}");
    let exact = |d: f64| 50.0 * 20.0 / d * FRAC_PI_4 * d * d * 0.13_f64.sin().powi(2);
    assert!((limit / exact(d) - 1.0).abs() < 1e-6 && force > limit && force < 1.05 * limit, "{force} {limit}");
    // edges of a twentieth of the least half edge
    let [of_bar, of_stub] = [[6.0, 6.0, 20.0], [7.0, 6.0, 6.0]].map(|edges| rounded(edges, 0.15));
    let all = of_bar + 2.0 * of_stub;
    let mass = 2.65e-3 * whole;
    assert!((bar / (mass * of_bar / all) - 1.0).abs() < 1e-6 && (stub / (mass * of_stub / all) - 1.0).abs() < 1e-6, "{bar} {stub}");
    let [lost, stored, normal] = numbers(&table, ["lost_volume_mm3", "stored_J", "normal_x"])[0];
    assert!((lost / (whole - all) - 1.0).abs() < 1e-6 && stored > 0.0 && normal == 0.0, "{lost}");
    let [pieces, d, force, limit, ..] = broken[1];
    assert!(pieces == 2.0 && (d / sphere(of_bar) - 1.0).abs() < 1e-6, "{broken:?}");
    assert!((limit / exact(d) - 1.0).abs() < 1e-6 && force > limit, "{force} {limit}");
    let s = summary(&out);
    let bodies = 1.0 + broken.iter().map(|row| row[0] - 1.0).sum::<f64>();
    assert_eq!((number(&s, "crush_events"), number(&s, "blocks")), (broken.len() as f64, bodies));
    let last = numbers(&out.join("blocks.csv"), ["step", "mass_kg"]);
    let end = last.last().expect("rows")[0];
    let at_end: f64 = last.iter().filter(|row| row[0] == end).map(|row| row[1]).sum();
    assert!((1e3 * at_end / mass - 1.0).abs() < 1e-8, "{at_end}");
    let columns = ["dissipated_J", "platen_work_J", "contact_J", "coarse_kinetic_J"];
    let [dissipated, work, contact, kinetic] = *numbers(&out.join("history.csv"), columns).last().expect("rows");
    assert!(((dissipated + contact + kinetic) / work - 1.0).abs() < 1e-6, "{dissipated} {contact} {kinetic} {work}");
    let stored: f64 = numbers(&table, ["stored_J"]).iter().map(|[stored]| stored).sum();
    assert!(dissipated > stored && dissipated < work, "{dissipated} {stored} {work}");
    let files = ["blocks.csv", "block_breakage.csv", "block_surfaces.csv", "walls.csv", "gsd.csv", "history.csv"];
    resumes(&out, &scene(folder.path(), &PLUS), &[step as u64, step as u64 + 1], &files);
}

/// When the plus sign breaks, the energy of its contacts is gone, and nothing presses between its parts.
#[test]
fn parts_are_born_without_force() {
    let mut scene = Scene::of(&PLUS.replace("[records]\nrows = 300\nfigures = false\nsnapshots = false\n", ""));
    let events = |scene: &Scene| scene.all().breaking().expect("they break").events;
    let mut before = scene.energy();
    while events(&scene) == 0 {
        before = scene.energy();
        scene.run(1e-12).expect("a step");
    }
    assert_eq!(scene.all().blocks.len(), 3);
    assert!(scene.energy() < 1e-2 * before, "{} {before}", scene.energy());
    for step in 0..3 {
        scene.run(1e-12).expect("a step");
        let force = |c: &comminute::rigid::BlockContact| c.force().iter().map(|f| f * f).sum::<f64>().sqrt();
        let between = scene.all().touching().filter(|c| matches!(c.other, Other::Block { .. })).map(force).fold(0.0, f64::max);
        assert!(between < 1e-3, "{step}: {between} N");
        assert_eq!(events(&scene), 1);
    }
}

/// In plane strain a plus sign of two polygons with a disc at its end breaks into one of them, two ends of the other and the disc, at the force of a strip whose size does not matter with m = 3. A
/// stop there changes nothing.
#[test]
fn a_plus_sign_of_polygons_breaks_in_plane_strain() {
    let bar = |half: [f64; 2]| {
        let [x, y] = half.map(|h| h - 0.5);
        format!(
            "{{ shape = \"polygon\", rounding_mm = 0.5, points_mm = [-{x:?}, -{y:?}, {x:?}, -{y:?}, {x:?}, {y:?}, -{x:?}, {y:?}] }}"
        )
    };
    let from = PLUS.find("position_mm").expect("a block");
    let to = PLUS.find("[material]").expect("a material");
    let disc = "{ shape = \"polygon\", rounding_mm = 2.0, points_mm = [12.0, 0.0] }";
    let parts = format!("position_mm = [0.0, 10.001, 0.0]\npart = [{}, {}, {disc}]\n", bar([3.0, 10.0]), bar([10.0, 3.0]));
    let text = format!("{}{parts}{}", &PLUS[..from], &PLUS[to..])
        .replace("normal = [0.0, 0.0, 1.0]", "normal = [0.0, 1.0, 0.0]")
        .replace("normal = [0.0, 0.0, -1.0]", "normal = [0.0, -1.0, 0.0]")
        .replace("point_m = [0.0, 0.0, 0.0201]", "point_m = [0.0, 0.0201, 0.0]")
        .replace("contact.friction = 0.4", "contact.friction = 0.4\nspring = { k_n_N_m = 1e9, k_t_N_m = 5e8 }")
        .replace("[records]", "[grid]\nplane_strain = true\n[contact]\nlaw = \"spring\"\n[records]");
    let folder = tempfile::tempdir().expect("folder");
    let out = run(folder.path(), &text, "run", &["--set", "duration_s=0.004"]);
    let columns = ["pieces", "diameter_mm", "force_N", "limit_force_N", "lost_volume_mm3", "step"];
    let [pieces, d, force, limit, lost, step] = numbers(&out.join("block_breakage.csv"), columns)[0];
    let corners = (4.0 - PI) * 0.25;
    let area = 2.0 * (120.0 - corners) - 36.0 + 4.0 * PI;
    assert!(pieces == 4.0 && (d / (4.0 * area / PI).sqrt() - 1.0).abs() < 1e-8, "{pieces} {d}");
    let exact = 50e6 * 20e-3 * 0.13_f64.sin();
    assert!((limit / exact - 1.0).abs() < 1e-6 && force > limit && force < 1.1 * limit, "{force} {limit} {exact}");
    // two corners of each end are new; a metre deep
    assert!((lost / (1e3 * corners) - 1.0).abs() < 1e-6, "{lost}");
    let text = text.replace("duration_s = 0.0013", "duration_s = 0.004");
    resumes(
        &out,
        &scene(folder.path(), &text),
        &[step as u64, step as u64 + 1],
        &["blocks.csv", "block_breakage.csv", "history.csv"],
    );
}

#[test]
fn compounds_that_do_not_come_apart_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let parts = "part = [{ shape = \"box\", size_mm = [6.0, 6.0, 20.0] }, { shape = \"box\", size_mm = [20.0, 6.0, 6.0] }]";
    let refuses = |to: &str, says: &str| {
        let says = format!("crushing.enabled = true: must be false: block 0, a compound, cannot break into its parts: {says}");
        refused(folder.path(), &PLUS, parts, to, &says);
    };
    refuses(
        "part = [{ shape = \"box\", size_mm = [20.0, 20.0, 20.0] }, { shape = \"box\", size_mm = [10.0, 10.0, 10.0] }]",
        "no second body is left of its parts where they are cut free of each other",
    );
    let corner = |z: f64| format!("[-3.0, -3.0, {z:?}, 3.0, -3.0, {z:?}, -3.0, 3.0, {z:?}, -3.0, -3.0, {:?}]", z + 9.0);
    refuses(
        &format!(
            "part = [{{ shape = \"polyhedron\", points_mm = {} }}, {{ shape = \"polyhedron\", points_mm = {} }}]",
            corner(-9.0),
            corner(0.0)
        ),
        "two of its parts have sharp edges and could not touch each other: give them rounding_mm",
    );
    // bodies that are hardly more than balls cannot be cut, so that of two that overlap one is lost
    let ball =
        "shape = \"polyhedron\", rounding_mm = 6.0, points_mm = [0.1, 0.1, 0.1, -0.1, -0.1, 0.1, -0.1, 0.1, -0.1, 0.1, -0.1, -0.1]";
    let at = |x: f64| format!("{{ {ball}, position_mm = [{x:?}, 0.0, 0.0] }}");
    refuses(&format!("part = [{}, {}]", at(0.0), at(6.0)), "no second body is left");
    let beside = format!("part = [{{ shape = \"box\", size_mm = [6.0, 6.0, 20.0] }}, {}, {}]", at(8.9), at(14.9));
    refuses(&beside, "its parts, cut free of each other, would lose ");
}
