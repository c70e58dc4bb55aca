//! Parity of the graphics path with f64: rungs 2 (`law.rs`) and 3 (`step.rs`, `faces.rs`, `fines.rs`, `gap.rs`); indices (`bounds.rs`) and operations (`work.rs`) of the shaders.

mod adapter;
mod band;
mod bounds;
mod faces;
mod fines;
mod gap;
mod law;
mod step;
mod work;

pub use adapter::adapter;
pub use band::band;

use crate::gpu;
use crate::mpm::law::{Clay, Dilation, Elastic, Evolution, Law, Parameters, Shear};

/// Places of the laws that jump at their peak.
const JUMPS: [usize; 2] = [12, 16];

/// Every kind of surface, flow and evolution.
fn laws() -> Vec<Law> {
    let mut laws = crate::mpm::law::tests::all_laws();
    // the first of them, which jumps, behind those whose dilation stays
    laws[..JUMPS[0]].rotate_left(1);
    let cones = laws.into_iter().map(Law::DruckerPrager);
    std::iter::once(Law::Elastic(Elastic::of_young(4.6e6, 0.3))).chain(cones).chain(clays()).chain(pyramids()).collect()
}

/// Clays: a Poisson ratio or a shear modulus that stays; soft, and stiff with a small slope of the critical state line.
fn clays() -> Vec<Law> {
    let clay = |(phi, slopes, volume, shear): (f64, [f64; 2], f64, Shear)| {
        let [virgin_slope, swelling_slope] = slopes;
        let clay = Clay { virgin_slope, swelling_slope, preconsolidation: 1e5, virgin_volume: volume, shear };
        let friction = Evolution::Constant(phi.to_radians());
        Law::named("cam_clay", &Parameters { friction, clay, ..Parameters::of_elastic(Elastic { bulk: 0.0, shear: 0.0 }) })
            .expect("a law")
    };
    let soils = [
        (30.0, [0.16, 0.03], 2.1, Shear::Poisson(0.25)),
        (30.0, [0.16, 0.03], 2.1, Shear::Modulus(4e6)),
        (22.0, [0.25, 0.06], 2.6, Shear::Poisson(0.3)),
        (35.0, [0.06, 0.02], 1.7, Shear::Poisson(0.15)),
    ];
    soils.into_iter().map(clay).collect()
}

/// Pyramids of Mohr and Coulomb: such that stay, of friction and dilation angle in degrees, cohesion in Pa, Poisson's ratio; then such that change.
fn pyramids() -> Vec<Law> {
    let pyramid = |(phi, psi, cohesion, nu): (f64, f64, f64, f64)| {
        let parameters = Parameters {
            friction: Evolution::Constant(phi.to_radians()),
            cohesion: Evolution::Constant(cohesion),
            dilation: psi.to_radians(),
            ..Parameters::of_elastic(Elastic::of_young(2e7, nu))
        };
        Law::named("mohr_coulomb", &parameters).expect("a law")
    };
    // without cohesion, associated, without dilation, without friction (Tresca), steep, nearly incompressible
    let soils = [
        (33.0, 5.0, 0.0, 0.25),
        (30.0, 30.0, 5e3, 0.2),
        (25.0, 0.0, 2e4, 0.3),
        (0.0, 0.0, 3e4, 0.3),
        (50.0, 25.0, 1e3, 0.0),
        (20.0, 10.0, 1e4, 0.49),
    ];
    soils.into_iter().map(pyramid).chain(changing_pyramids()).collect()
}

/// Pyramids that harden or soften: friction linear, cohesion linear, both smooth with dilation that stays and that ends; and without cohesion, so that the apex stays,
/// with dilation that ends.
fn changing_pyramids() -> Vec<Law> {
    let cones = crate::mpm::law::tests::all_laws();
    let loose = Parameters {
        friction: Evolution::Linear { initial: 0.6, last: 0.45, strain: 0.05 },
        dilation: 0.25,
        dilation_rule: Dilation::Mobilised,
        ..Parameters::of_elastic(Elastic::of_young(2e7, 0.2))
    };
    let of_cones = [7, 8, 9, JUMPS[0]].map(|k| *cones[k].parameters());
    of_cones.iter().chain([&loose]).map(|parameters| Law::named("mohr_coulomb", parameters).expect("a law")).collect()
}
