//! Laws taken through paths whose end has a closed form.

use super::{Path, Settings, Test, drive};
use engine::mpm::law::{Cone, DruckerPrager, Elastic, Evolution, Law, Parameters};
use laboratory::scene;

const DEGREE: f64 = std::f64::consts::PI / 180.0;
const E: f64 = 2e7;
const NU: f64 = 0.3;

fn soil(cone: Cone, phi: f64, cohesion: f64, psi: f64) -> Law {
    Law::DruckerPrager(DruckerPrager::new(Parameters {
        cone,
        friction: Evolution::Constant(phi * DEGREE),
        cohesion: Evolution::Constant(cohesion),
        dilation: psi * DEGREE,
        ..Parameters::of_elastic(Elastic::of_young(E, NU))
    }))
}

fn run(law: &Law, path: Path, confining: f64, strain: f64, steps: u32) -> Test {
    let settings = Settings { path, confining: vec![confining], strain, steps };
    drive(law, &settings).unwrap_or_else(|e| panic!("{e}")).remove(0)
}

/// Friction angle φ, degrees; for the outer, inner and plane-strain cone: α and k, the factors A
/// and B of q = A σ₃ + B c in compression, and A in extension. Mohr–Coulomb matched by
/// Drucker–Prager, derived independently of this program; the plane-strain constants are those of
/// Zhang et al., eq. 6, and Jiang et al. (2020), eq. 35.
#[rustfmt::skip]
const CLOSED_FORMS: [(f64, [[f64; 5]; 3]); 5] = [
    (10.0, [[0.07094363, 1.207024, 0.4202766, 2.383507, 0.3282938],
            [0.06318017, 1.074938, 0.3686339, 2.090627, 0.2959118],
            [0.057594, 0.9798955, 0.3324289, 1.885298, 0.2721215]]),
    (20.0, [[0.1485831, 1.224686, 1.039607, 2.856296, 0.6140361],
            [0.1181713, 0.9740189, 0.7720604, 2.121218, 0.5097094],
            [0.111847, 0.921891, 0.7208131, 1.980418, 0.4868576]]),
    (28.6, [[0.2192297, 1.206287, 1.836503, 3.368384, 0.8256412],
            [0.1588947, 0.8743006, 1.139151, 2.089351, 0.6474532],
            [0.1537983, 0.8462582, 1.089347, 1.998003, 0.631055]]),
    (33.0, [[0.2561314, 1.183223, 2.39212, 3.683542, 0.9219089],
            [0.1774214, 0.8196152, 1.330898, 2.049403, 0.7051991],
            [0.1731861, 0.8000494, 1.285513, 1.979516, 0.6922492]]),
    (40.0, [[0.314875, 1.12576, 3.59891, 4.289014, 1.058729],
            [0.2037525, 0.7284684, 1.636138, 1.949874, 0.7825572],
            [0.2008758, 0.7181832, 1.600712, 1.907654, 0.7743602]]),
];
const CONES: [Cone; 3] = [Cone::Outer, Cone::Inner, Cone::PlaneStrain];

#[test]
fn triaxial_strength_is_the_closed_form() {
    for (phi, cones) in CLOSED_FORMS {
        for (cone, [alpha, k, a, b, a_extension]) in CONES.into_iter().zip(cones) {
            let constants = cone.at(phi * DEGREE);
            assert!((constants.alpha / alpha - 1.0).abs() < 1e-6 && (constants.k / k - 1.0).abs() < 1e-6, "{cone:?} {phi}");
            for cell in [50e3, 100e3, 200e3] {
                for c in [0.0, 10e3] {
                    let law = soil(cone, phi, c, 0.5 * phi);
                    let test = run(&law, Path::Triaxial, cell, 0.15, 300);
                    let last = test.rows[300];
                    let expected = a * cell + b * c;
                    assert!((last.q / expected - 1.0).abs() < 1e-6, "{cone:?} {phi} {cell} {c}: {} for {expected}", last.q);
                    assert!((last.lateral / cell - 1.0).abs() < 1e-9 && test.cell_pressure_error < 1e-6 * cell);
                    // before yield the slope is E
                    let first = test.rows[1];
                    assert!((first.q / (E * first.axial_strain) - 1.0).abs() < 1e-6);
                    assert!((first.volumetric_strain / (first.axial_strain * (1.0 - 2.0 * NU)) - 1.0).abs() < 1e-6);
                    // at failure the volume follows the dilation angle: 3 sqrt3 alpha_psi / (1 - sqrt3 alpha_psi)
                    let psi = 3f64.sqrt() * cone.at(0.5 * phi * DEGREE).alpha;
                    let before = test.rows[299];
                    let rate = (before.volumetric_strain - last.volumetric_strain) / (last.axial_strain - before.axial_strain);
                    assert!((rate / (3.0 * psi / (1.0 - psi)) - 1.0).abs() < 1e-5, "{cone:?} {phi}: {rate}");
                }
                let extension = run(&soil(cone, phi, 0.0, 0.0), Path::Triaxial, cell, -0.15, 300).rows[300];
                assert!((-extension.q / (a_extension * cell) - 1.0).abs() < 1e-6, "{cone:?} {phi} {cell}: {}", extension.q);
            }
        }
    }
}

#[test]
fn li_reaches_the_ratio_of_the_largest_angle_and_then_of_the_residual_one() {
    let fines =
        scene::continuum(std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../materials/li2023_fines.toml")), &[]);
    let law = fines.expect("the material").law;
    let ratio = |angle: f64| (1.0 + (angle * DEGREE).sin()) / (1.0 - (angle * DEGREE).sin());
    assert!((ratio(28.6) - 2.836).abs() < 1e-3);
    for cell in [50e3, 100e3, 150e3] {
        let rows = run(&law, Path::Triaxial, cell, 0.3, 3000).rows;
        let peak = rows.iter().filter_map(|r| r.stress_ratio).fold(0.0, f64::max);
        assert!((peak / ratio(28.6) - 1.0).abs() < 0.003 && peak <= ratio(28.6) + 1e-9, "{cell}: {peak}");
        let last = rows[3000].stress_ratio.expect("pressure");
        assert!((last / ratio(18.6) - 1.0).abs() < 1e-3 && last >= ratio(18.6) - 1e-9, "{cell}: {last}");
    }
    // at 50 kPa the law yields near 1 % and has its peak near 3.7 % (elastic strain q/E and the
    // plastic strain of the peak)
    let rows = run(&law, Path::Triaxial, 50e3, 0.15, 1500).rows;
    let at = rows.iter().max_by(|a, b| a.q.total_cmp(&b.q)).expect("rows");
    assert!((0.035..0.039).contains(&at.axial_strain), "{}", at.axial_strain);
    assert!((at.plastic_strain - 0.022).abs() < 1e-3, "{}", at.plastic_strain);
}

#[test]
fn an_elastic_oedometer_has_its_modulus_and_k0() {
    for nu in [0.0, 0.12, 0.3, 0.49] {
        let law = Law::Elastic(Elastic::of_young(E, nu));
        let last = run(&law, Path::Oedometer, 0.0, 0.01, 10).rows[10];
        let modulus = E * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
        assert!((last.axial / (0.01 * modulus) - 1.0).abs() < 1e-12);
        assert!((last.lateral / last.axial - nu / (1.0 - nu)).abs() < 1e-12, "{nu}");
    }
}

#[test]
fn a_plastic_oedometer_stays_on_its_k0_line() {
    // without cohesion and dilation, loaded from zero stress: each step yields where nu/(1-nu) is
    // below the k0 of failure
    let (phi, nu) = (40.0, 0.05);
    let elastic = Elastic::of_young(E, nu);
    let Law::DruckerPrager(law) = soil(Cone::Outer, phi, 0.0, 0.0) else { panic!("the law") };
    let law = Law::DruckerPrager(DruckerPrager::new(Parameters { elastic, ..*law.parameters() }));
    let last = run(&law, Path::Oedometer, 0.0, 0.02, 50).rows[50];
    let active = (1.0 - (phi * DEGREE).sin()) / (1.0 + (phi * DEGREE).sin());
    assert!(active > nu / (1.0 - nu));
    assert!((last.lateral / last.axial - active).abs() < 1e-9, "{}", last.lateral / last.axial);
}

#[test]
fn simple_shear_begins_with_g_and_ends_on_the_surface() {
    let law = soil(Cone::PlaneStrain, 30.0, 5e3, 0.0);
    let rows = run(&law, Path::SimpleShear, 100e3, 0.1, 1000).rows;
    let g = E / (2.0 * (1.0 + NU));
    assert!((rows[1].shear / (g * rows[1].shear_strain) - 1.0).abs() < 1e-6);
    let last = rows[1000];
    // without dilation the mean stress stays
    assert!((last.p / 100e3 - 1.0).abs() < 1e-9 && last.volumetric_strain == 0.0);
    let surface = last.strength.expect("a surface").q_at(last.p);
    assert!((last.q / surface - 1.0).abs() < 1e-9);
    let back = run(&law, Path::SimpleShear, 100e3, -0.1, 1000).rows[1000];
    assert!((back.shear + last.shear).abs() < 1e-6 && (back.q - last.q).abs() < 1e-6);
}

fn material(name: &str, sets: &[&str]) -> Law {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../materials")).join(name);
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    scene::continuum(&path, &sets).unwrap_or_else(|e| panic!("{e}")).law
}

/// Modified Cam-clay through the paths of the laboratory: slopes of its lines, undrained end, critical state, k₀.
#[test]
fn cam_clay_has_its_lines_and_ends_at_the_critical_state() {
    let (lambda, kappa, p_c) = (0.161, 0.062, 200e3);
    let sine = (22.75 * DEGREE).sin();
    let m = 6.0 * sine / (3.0 - sine);
    let n = 2.8276;
    let clay = material("london_clay.toml", &[]);
    let v_c = n - lambda * f64::ln(200.0);
    // isotropic compression over the preconsolidation pressure and back; the strains of rows are sums of increments, so that v = v0 Π (1 − dε)
    let start = 50e3;
    let rows = run(&clay, Path::Isotropic, start, 0.08, 4000).rows;
    let mut v = v_c + kappa * (p_c / start).ln();
    for w in rows.windows(2) {
        v *= 1.0 - (w[1].volumetric_strain - w[0].volumetric_strain);
        let p = w[1].p;
        let line = if p < p_c { v_c - kappa * (p / p_c).ln() } else { n - lambda * (1e-3 * p).ln() };
        assert!((v - line).abs() < 1e-9, "{v} for {line} at {p}");
    }
    assert!(rows[4000].p > 3.0 * p_c, "{}", rows[4000].p);
    // undrained, from normally consolidated to dry
    for ratio in [1.0, 2.5, 8.0] {
        let rows = run(&clay, Path::Undrained, p_c / ratio, 0.6, 3000).rows;
        let last = rows[3000];
        let end = p_c / ratio * f64::powf(ratio / 2.0, 1.0 - kappa / lambda);
        assert!((last.p / end - 1.0).abs() < 1e-6 && (last.q / (m * end) - 1.0).abs() < 1e-6, "{ratio}: {} for {end}", last.p);
        assert!(last.volumetric_strain.abs() < 1e-12);
    }
    // drained: q = M p, then volume stays
    for ratio in [1.0, 5.0] {
        let cell = p_c / ratio;
        let rows = run(&clay, Path::Triaxial, cell, 1.0, 4000).rows;
        let last = rows[4000];
        assert!((last.q / last.p - m).abs() < 2e-3 * m, "{ratio}: {}", last.q / last.p);
        let late = (rows[3900].volumetric_strain - last.volumetric_strain).abs();
        assert!(late < 1e-3 * last.volumetric_strain.abs().max(0.01), "{ratio}: {late}");
        assert!((last.volumetric_strain > 0.0) == (ratio < 2.0), "wet soil contracts, dry soil dilates");
    }
    // one-dimensional compression: the k0 of Modified Cam-clay
    let (big_lambda, nu) = (1.0 - kappa / lambda, 0.3);
    let rest = |eta: f64| {
        eta * (1.0 + nu) * (1.0 - big_lambda) / (3.0 * (1.0 - 2.0 * nu)) + 3.0 * eta * big_lambda / (m * m - eta * eta) - 1.0
    };
    let (mut low, mut high) = (0.0, m);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if rest(middle) < 0.0 { low = middle } else { high = middle }
    }
    let last = run(&clay, Path::Oedometer, p_c, 0.4, 20_000).rows[20_000];
    let k0 = (3.0 - low) / (3.0 + 2.0 * low);
    assert!((last.lateral / last.axial - k0).abs() < 2e-3, "{} for {k0}", last.lateral / last.axial);
}

/// Dilation that ends: in drained compression of Li's fines volume grows at the stated angle at the peak, and at the residual strength it stays, where the law of the paper goes on.
#[test]
fn mobilised_dilation_ends_at_the_residual_strength() {
    let late = |sets: &[&str]| {
        let rows = run(&material("li2023_fines.toml", sets), Path::Triaxial, 50e3, 0.5, 5000).rows;
        assert!((rows[5000].stress_ratio.expect("pressure") / 1.9368 - 1.0).abs() < 1e-3);
        let rate = |a: usize, b: usize| {
            (rows[a].volumetric_strain - rows[b].volumetric_strain) / (rows[b].axial_strain - rows[a].axial_strain)
        };
        // the last steps before the peak, whose elastic strain hardly changes
        let peak = rows.iter().position(|r| r.plastic_strain > 0.0219).expect("a peak");
        (rate(peak - 5, peak - 1), rate(4000, 5000))
    };
    let psi = 3f64.sqrt() * Cone::Outer.at(16.0 * DEGREE).alpha;
    let stated = 3.0 * psi / (1.0 - psi);
    let (_, constant) = late(&[]);
    let (most, mobilised) = late(&["continuum.dilation=mobilised"]);
    assert!((constant / stated - 1.0).abs() < 0.01, "{constant} {stated}");
    assert!(mobilised.abs() < 1e-4 * stated, "{mobilised}");
    assert!((most / stated - 1.0).abs() < 0.1, "{most} {stated}");
}

#[test]
fn a_test_without_stress_stays_without() {
    let rows = run(&soil(Cone::Outer, 30.0, 0.0, 10.0), Path::Triaxial, 0.0, 0.05, 50).rows;
    assert!(rows.iter().all(|r| r.q.abs() < 1.0 && r.axial.is_finite()), "{:?}", rows[50]);
}

#[test]
fn settings_that_make_no_test_are_refused() {
    let good = Settings { path: Path::Triaxial, confining: vec![1e5], strain: 0.1, steps: 10 };
    assert!(good.check().is_ok());
    for (bad, says) in [
        (Settings { confining: vec![-1.0], ..good.clone() }, "confining_kPa = -0.001: must be >= 0"),
        (Settings { confining: vec![f64::NAN], ..good.clone() }, "confining_kPa = NaN"),
        (Settings { confining: vec![1e5, 1e5], ..good.clone() }, "stands there twice"),
        (Settings { strain: 0.0, ..good.clone() }, "strain = 0: must be between -1 and 1, and not 0"),
        (Settings { strain: f64::INFINITY, ..good.clone() }, "strain = inf"),
        (Settings { strain: 1.5, ..good.clone() }, "between -1 and 1"),
        (Settings { steps: 0, ..good.clone() }, "steps = 0: must be at least 1"),
    ] {
        let message = bad.check().expect_err("refused").to_string();
        assert!(message.contains(says), "{message}");
    }
}
