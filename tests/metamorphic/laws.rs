//! Each constitutive law at one point, along a path of strains.

use crate::change::{Change, STRESS, Within, same};
use comminute::mpm::law::{Clay, Cone, Dilation, Elastic, Evolution, InternalVariables, Law, Parameters, Shear, Sym};
use comminute::mpm::rotate_jaumann;

/// Every law, with its cones and with strengths that stay, rise and fall; the tension cut-off counts in one of them.
pub fn laws() -> Vec<Law> {
    let constant = Parameters {
        cone: Cone::Outer,
        friction: Evolution::Constant(0.6),
        cohesion: Evolution::Constant(2e3),
        dilation: 0.2,
        tension: 1e3,
        clay: Clay {
            virgin_slope: 0.1,
            swelling_slope: 0.02,
            preconsolidation: 7e4,
            virgin_volume: 1.8,
            shear: Shear::Poisson(0.3),
        },
        ..Parameters::of_elastic(Elastic::of_young(20e6, 0.3))
    };
    let rising = Parameters {
        friction: Evolution::Linear { initial: 0.3, last: 0.6, strain: 0.02 },
        cone: Cone::Inner,
        tension: f64::INFINITY,
        ..constant
    };
    let falling = Parameters {
        friction: Evolution::CubicExponential {
            initial: 0.4,
            cubic: [0.0, -800.0, 16.0, 0.4],
            peak_strain: 0.01,
            peak: 0.48,
            residual: 0.35,
            decay: 60.0,
        },
        cohesion: Evolution::Linear { initial: 4e3, last: 1e3, strain: 0.03 },
        cone: Cone::PlaneStrain,
        ..rising
    };
    let named = |word: &str, p: &Parameters| Law::named(word, p).expect("a law of this name");
    let mut all: Vec<Law> = Law::WORDS.iter().map(|word| named(word, &constant)).collect();
    let ending = Parameters { dilation: 0.4, dilation_rule: Dilation::Mobilised, ..falling };
    let modulus = Clay { shear: Shear::Modulus(5e6), ..constant.clay };
    all.extend([&rising, &falling, &ending].map(|p| named("drucker_prager", p)));
    all.push(named("cam_clay", &Parameters { clay: modulus, ..constant }));
    all
}

/// The law with the constants of other units.
pub fn changed(law: &Law, change: &Change) -> Law {
    let stress = |x: f64| change.scalar(x, STRESS);
    let of = |e: Evolution, f: &dyn Fn(f64) -> f64| match e {
        Evolution::Constant(x) => Evolution::Constant(f(x)),
        Evolution::Linear { initial, last, strain } => Evolution::Linear { initial: f(initial), last: f(last), strain },
        other => other,
    };
    let elastic = |e: Elastic| Elastic { bulk: stress(e.bulk), shear: stress(e.shear) };
    let clay = |c: Clay| Clay {
        preconsolidation: stress(c.preconsolidation),
        shear: match c.shear {
            Shear::Modulus(g) => Shear::Modulus(stress(g)),
            ratio => ratio,
        },
        ..c
    };
    let plastic = |p: Parameters| Parameters {
        elastic: elastic(p.elastic),
        cohesion: of(p.cohesion, &stress),
        tension: stress(p.tension),
        clay: clay(p.clay),
        ..p
    };
    match law {
        Law::Elastic(e) => Law::Elastic(elastic(*e)),
        Law::DruckerPrager(law) => Law::DruckerPrager(plastic(law.clone().into()).into()),
        Law::MohrCoulomb(law) => Law::MohrCoulomb(plastic(law.clone().into()).into()),
        Law::CamClay(law) => Law::CamClay(plastic(law.clone().into()).into()),
    }
}

/// Strain and spin increments of the path: compression with shear in changing directions, then partly back, then apart.
fn path() -> Vec<(Sym, [f64; 3])> {
    let of = |k: usize| {
        let t = k as f64;
        let wave = |speed: f64| (speed * t).sin();
        let press = if k < 200 { -1e-4 } else { 1.2e-4 };
        let shear = 1.5e-4 + 1e-4 * wave(0.05);
        let strain =
            [press + shear * wave(0.013), 0.4 * press - shear, 0.7 * press + shear, shear, -shear * wave(0.021), 0.5 * shear];
        (strain, [2e-3 * wave(0.031), 1e-3, -2e-3 * wave(0.017)])
    };
    (0..400).map(of).collect()
}

/// Stresses along the path and the accumulated plastic strain at its end; the spin of the material turns the stress before each step, as on a grid.
fn walk(law: &Law, change: &Change) -> (Vec<Sym>, f64) {
    let mut stress = change.tensor([-5e4, -4e4, -6e4, 1e3, 0.0, 0.0], STRESS);
    let mut internal = InternalVariables::default();
    let mut stresses = Vec::new();
    for (strain, [xy, yz, zx]) in path() {
        // W_xy = ½ (∂u_x/∂y − ∂u_y/∂x): the axial vector of the spin is −(W_yz, W_zx, W_xy)
        let [yz, zx, xy] = change.axial([yz, zx, xy], [0; 3]);
        (stress, internal) = law.update(rotate_jaumann(stress, [xy, yz, zx]), change.tensor(strain, [0; 3]), internal);
        stresses.push(stress);
    }
    (stresses, internal.plastic)
}

#[track_caller]
fn check(law: &Law, found: &(Vec<Sym>, f64), change: &Change, within: Within) {
    let (stresses, plastic) = walk(law, &Change::NOTHING);
    let expected: Vec<Sym> = stresses.iter().map(|s| change.tensor(*s, STRESS)).collect();
    let what = format!("{} {change:?}", law.word());
    same(&format!("{what}: stress"), &found.0, &expected, within);
    same(&format!("{what}: plastic strain"), &[[found.1]], &[[plastic]], within);
}

/// Rounding of four hundred steps, each of which turns the stress and may return it to the surface of yield.
const ROUNDING: Within = Within::Share(1e-11);

/// Checks that the path is worth it: every law but elasticity yields.
#[test]
fn laws_yield_on_the_path() {
    for law in laws() {
        let plastic = walk(&law, &Change::NOTHING).1;
        // what falls again where the soil is pulled apart is smaller
        let least = if law.plastic_falls() { 0.005 } else { 0.02 };
        assert!((plastic.abs() > least) == (law.word() != "elastic"), "{}: {plastic}", law.word());
    }
}

/// Turns a path of strains by any angle: the stresses are turned.
#[test]
fn turned_strains_make_turned_stresses() {
    for law in laws() {
        for q in [[0.6, -0.3, 0.5, 0.2], [0.1, 0.9, -0.4, 0.3], [-0.2, 0.1, 0.0, 1.0]] {
            let turn = Change::turned(q);
            check(&law, &walk(&law, &turn), &turn, ROUNDING);
        }
        for axis in 0..3 {
            let turn = Change::quarter(axis);
            check(&law, &walk(&law, &turn), &turn, ROUNDING);
        }
    }
}

/// Mirrors a path of strains: the stresses are mirrored.
#[test]
fn mirrored_strains_make_mirrored_stresses() {
    for law in laws() {
        for axis in 0..3 {
            let mirror = Change::mirror(axis);
            check(&law, &walk(&law, &mirror), &mirror, ROUNDING);
        }
    }
}

/// Changes the units of stress: the stresses are the same numbers to the bit with another exponent, and the plastic strain does not change.
#[test]
fn other_units_change_the_units_of_stress() {
    for law in laws() {
        check(&law, &walk(&changed(&law, &Change::UNITS), &Change::UNITS), &Change::UNITS, Within::Nothing);
    }
}
