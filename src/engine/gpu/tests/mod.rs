//! Parity of the graphics path with f64: rungs 2 (`law.rs`) and 3 (`step.rs`, `faces.rs`).

mod adapter;
mod bounds;
mod faces;
mod law;
mod step;

pub use adapter::adapter;

use crate::gpu;
use crate::mpm::law::{Elastic, Evolution, Law, Parameters};

/// Places of the laws that jump at their peak.
const JUMPS: [usize; 2] = [12, 16];

/// Every kind of surface, flow and evolution.
fn laws() -> Vec<Law> {
    let mut laws = crate::mpm::law::tests::all_laws();
    // the first of them, which jumps, behind those whose dilation stays
    laws[..JUMPS[0]].rotate_left(1);
    let cones = laws.into_iter().map(Law::DruckerPrager);
    std::iter::once(Law::Elastic(Elastic::of_young(4.6e6, 0.3))).chain(cones).chain(pyramids()).collect()
}

/// Pyramids of Mohr and Coulomb: friction and dilation angle in degrees, cohesion in Pa, Poisson's ratio.
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
    soils.into_iter().map(pyramid).collect()
}
