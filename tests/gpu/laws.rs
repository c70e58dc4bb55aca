//! Rung 4 of the laws that follow their plastic strain: cubes between platens on both backends, a row for each step, without local damping.

use crate::adapter::adapter;
use crate::common::typed::columns;
use crate::run::{apart, both};

/// The oedometer's scene as a cube of 64 points that deform evenly.
const CUBE: [&str; 5] = [
    "body[0].max_mm=[40.0, 40.0, 40.0]",
    "grid.cell_mm=20.0",
    "material.continuum.nu=0.25",
    "damping.local=0.0",
    "records.rows=5000",
];

/// Triaxial compression at 50 kPa through a peak at 38° to the end of the softening, with dilation that ends.
const SOFTENING: [&str; 10] = [
    "test.strain_per_wave=0.0005",
    "test.rig=triaxial",
    "test.cell_pressure_kPa=50.0",
    "test.axial_strain=0.08",
    "material.continuum.dilation=mobilised",
    "material.continuum.dilation_angle_deg=12.0",
    "material.continuum.cohesion_kPa=0.0",
    "material.continuum.friction_angle_deg=30.0",
    "material.continuum.friction_evolution.law=cubic_exponential",
    "material.continuum.friction_evolution.decay=60.0",
];

/// Its friction angle: 30° at first yield, 38° at a plastic strain of 2 %, 31° in the end.
const EVOLUTION: [&str; 4] = [
    "material.continuum.friction_evolution.cubic_rad=[0.0, -349.0659, 13.962634, 0.5235988]",
    "material.continuum.friction_evolution.peak_plastic_strain=0.02",
    "material.continuum.friction_evolution.peak_deg=38.0",
    "material.continuum.friction_evolution.residual_deg=31.0",
];

const CLAY: [&str; 7] = [
    "test.strain_per_wave=0.0003",
    "material.continuum.law=cam_clay",
    "material.continuum.lambda=0.1",
    "material.continuum.kappa=0.02",
    "material.continuum.friction_angle_deg=30.0",
    "material.continuum.virgin_specific_volume=2.2",
    "material.continuum.preconsolidation_kPa=200.0",
];

/// Largest distances of the device's rows from the processor's curves of these columns over the axial strain, as shares of the largest values; and the processor's rows.
fn distances<const N: usize>(name: &str, sets: &[&str], names: [&str; N]) -> ([f64; N], Vec<[f64; N]>) {
    let folder = tempfile::tempdir().expect("folder");
    let outs = both(folder.path(), "oedometer", &[&CUBE[..], sets].concat());
    let found = names.map(|column| apart(&outs, "axial_strain", column));
    println!("rung 4, {name}: {names:?} {found:?}");
    (found, columns(&outs[0], names))
}

/// Cones and pyramids that harden and soften, with dilation that ends. Measured: q 6e-6 of its
/// largest, volumetric strain 3e-6.
#[test]
fn dilation_ends_with_softening_as_on_the_cpu() {
    if !adapter("dilation_ends_with_softening_as_on_the_cpu") {
        return;
    }
    for (law, cone) in [("drucker_prager", &["material.continuum.cone=outer"][..]), ("mohr_coulomb", &[])] {
        let word = format!("material.continuum.law={law}");
        let sets = [&SOFTENING[..], &EVOLUTION, &[word.as_str()], cone].concat();
        let ([q, volume], rows) = distances(law, &sets, ["q_kPa", "volumetric_strain"]);
        assert!(q < 3e-5 && volume < 3e-5);
        let peak = rows.iter().map(|[q, _]| *q).fold(0.0, f64::max);
        let [end, grown] = rows[rows.len() - 1];
        let most = rows.iter().map(|[_, v]| -*v).fold(0.0, f64::max);
        assert!(
            end < 0.8 * peak && grown < 0.0 && most + grown < 0.1 * most,
            "it has softened: {end} of {peak}, volume {grown} of {most}"
        );
    }
}

/// Modified Cam-clay in an oedometer from below its preconsolidation pressure, and in triaxial compression: drained and undrained from the virgin line, and drained where it
/// dilates. Measured, of the largest value: stresses in the oedometer 1.2e-6; q 2.8e-5, p 9e-6 drained; q 1.3e-4, p 2.6e-5 undrained, in the vibrations of the start, which differ
/// in phase and die away; q 4.4e-5, p 3e-5 where it dilates.
#[test]
fn clays_are_those_of_the_cpu() {
    if !adapter("clays_are_those_of_the_cpu") {
        return;
    }
    let ([axial, lateral], rows) = distances(
        "clay, oedometer",
        &[&CLAY[..], &["body[0].stress_kPa=50.0", "test.axial_strain=0.034"]].concat(),
        ["sigma_v_kPa", "sigma_h_kPa"],
    );
    assert!(axial < 2e-5 && lateral < 2e-5);
    assert!(rows[rows.len() - 1][0] > 250.0, "it is on its virgin line");
    // the undrained one without PIC vibrates until the processor ends it
    for (name, cell, drainage, pic, [in_q, in_p]) in [
        ("clay, drained", "200.0", "drained", "0.0", [1e-4, 1e-4]),
        ("clay, undrained", "200.0", "constant_volume", "0.1", [6e-4, 1e-4]),
        ("clay, dry", "30.0", "drained", "0.0", [2e-4, 2e-4]),
    ] {
        let own = [
            format!("test.cell_pressure_kPa={cell}"),
            format!("test.drainage={drainage}"),
            format!("grid.pic={pic}"),
            "test.rig=triaxial".into(),
            "test.axial_strain=0.034".into(),
        ];
        let sets = [&CLAY[..], &own.each_ref().map(String::as_str)].concat();
        let ([q, p], rows) = distances(name, &sets, ["q_kPa", "p_kPa"]);
        assert!(q < in_q && p < in_p, "{name}: {q:e} {p:e}");
        let [q, p] = rows[rows.len() - 1];
        let peak = rows.iter().map(|[q, _]| *q).fold(0.0, f64::max);
        let yielded = match name {
            "clay, undrained" => p < 130.0,
            "clay, dry" => q < 0.9 * peak,
            _ => p > 250.0,
        };
        assert!(yielded, "{name}: {q} {p} {peak}");
    }
}
