//! The energy account of mixtures: it closes, and it does not when any one term is left out.

use crate::common::typed::{number, run, summary, table};
use std::path::Path;

/// What was given; all other terms are what it has become.
const GIVEN: [&str; 5] = ["platen_work_J", "gravity_work_J", "released_J", "broken_grains_J", "born_contacts_J"];
/// Largest error over what was given.
const BOUND: f64 = 1e-3;

/// Terms of the last row of the account, signed so that they add up to zero, and their scale, J.
fn terms(out: &Path) -> (Vec<(String, f64)>, f64) {
    let (header, rows) = table(&out.join("account.csv"));
    let last = rows.last().expect("rows");
    let value = |name: &str| -> f64 {
        let at = header.iter().position(|h| h == name).expect("a column");
        last[at].parse().expect("a number")
    };
    let names = header.iter().filter(|name| name.ends_with("_J") && *name != "account_scale_J");
    let signed = |name: &str| if GIVEN.contains(&name) { value(name) } else { -value(name) };
    (names.map(|name| (name.to_string(), signed(name))).collect(), value("account_scale_J"))
}

/// Runs a scene with the account: it closes, and without any of the terms `of` it is open by more than three times the bound.
fn closes(scene: &str, sets: &[&str], of: &[&str]) {
    let out = tempfile::tempdir().expect("a folder");
    let account = ["records.account=true", "records.figures=false", "records.snapshots=false"];
    run(scene, out.path(), &[&account[..], sets].concat(), &[]).assert().success();
    let (terms, scale) = terms(out.path());
    let open = terms.iter().map(|(_, x)| x).sum::<f64>() / scale;
    println!("{scene}: open by {open:.1e}");
    assert!(open.abs() < BOUND, "{scene}: open by {open:.1e}: {terms:?}");
    let told = number(&summary(out.path()), "account_error");
    // tables have nine digits
    assert!((told - open).abs() < 1e-7, "{told} {open}");
    for name in of {
        let (_, term) = terms.iter().find(|(of, _)| of == name).unwrap_or_else(|| panic!("{name}"));
        let without = open - term / scale;
        println!("    without {name}: {without:.1e}");
        assert!(without.abs() > 3.0 * BOUND, "{scene} closes without {name}: {without:.1e}");
    }
}

/// A grain hits a ball of points; eight steps of the points for one of the grain.
#[test]
fn an_impact_closes() {
    closes("mixture/ball_impact", &[], &["elastic_points_J", "transfer_J", "strain_lag_J", "contact_lag_J", "nonconservative_J"]);
}

/// A block of points slides on a wall.
#[test]
fn a_sliding_block_closes() {
    closes("mixture/sliding_block", &["duration_s=0.05"], &["gravity_work_J", "kinetic_J", "slip_points_J"]);
}

/// Points and grains between platens.
#[test]
fn a_triaxial_test_closes() {
    let of = [
        "platen_work_J",
        "elastic_points_J",
        "elastic_contacts_J",
        "plastic_work_J",
        "slip_points_J",
        "damping_nodes_J",
        "transfer_J",
        "strain_lag_J",
        "contact_lag_J",
    ];
    closes("mixture/triaxial_small", &["test.axial_strain=0.012"], &of);
}

/// A grain breaks in the middle of points.
#[test]
fn a_breakage_among_points_closes() {
    let of = ["born_contacts_J", "ended_contacts_J", "slip_grains_J", "damping_grains_J", "volume_J"];
    closes("mixture/oedometer_crushing", &["test.axial_strain=0.02"], &of);
}

/// A ball falls into sand: plastic work, friction of points, gravity.
#[test]
fn a_crater_closes() {
    let of = ["gravity_work_J", "kinetic_J", "plastic_work_J", "slip_points_J", "transfer_J", "nonconservative_J"];
    closes("mixture/crater", &["duration_s=0.004"], &of);
}

/// Rigid bodies keep no account of their contacts' work: the scene is refused by name.
#[test]
fn rigid_bodies_are_refused() {
    let out = tempfile::tempdir().expect("a folder");
    let told = run("mixture/sliding_box", out.path(), &["records.account=true"], &[]).assert().failure();
    let text = String::from_utf8_lossy(&told.get_output().stderr).into_owned();
    assert!(text.contains("records.account") && text.contains("[[block]]"), "{text}");
}
