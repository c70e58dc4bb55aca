//! A continuum between platens that leaves what is possible stops with an exit code of its own and says why.

use crate::common::typed::{columns, run};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

const BARE: [&str; 2] = ["records.figures=false", "records.snapshots=false"];

/// Solids of 60 % pressed to a tenth of the height: the law knows no pores, so the run ends where none are left, with its rows.
#[test]
fn an_oedometer_stops_where_no_pores_are_left() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("o");
    let own = ["test.axial_strain=0.9", "test.strain_per_wave=0.002", "grid.cell_mm=10.0"];
    let sets: Vec<&str> = own.into_iter().chain(BARE).collect();
    run("oedometer", &out, &sets, &[])
        .assert()
        .code(3)
        .stderr(contains("the void ratio is -").and(contains("axial strain of 0.4")));
    let rows = columns(&out, ["axial_strain", "void_ratio"]);
    let [strain, e] = rows[rows.len() - 1];
    // e = 0 at the porosity of 40 %
    assert!((0.38..0.45).contains(&strain) && e < 0.0, "void ratio {e} at {strain}");
    assert!(rows[..rows.len() - 1].iter().all(|row| row[1] >= 0.0), "stopped at the first row without pores");
    assert!(out.join("points_final.csv").is_file() && !out.join("summary.json").exists());
}
