//! Parity of the graphics path with f64: rungs 2 (`law.rs`) and 3 (`step.rs`).

mod law;
mod step;

use super::device;
use crate::mpm::law::{Cone, DruckerPrager, Elastic, Evolution, Law, Parameters};

const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// Stands for no cut-off.
const FREE: f64 = f64::INFINITY;

/// Whether there is an adapter; without one the test is skipped, loudly, or fails where one is required.
fn adapter(test: &str) -> bool {
    let Some(adapter) = device::available() else {
        assert!(
            std::env::var_os("COMMINUTE_REQUIRE_GPU").is_none(),
            "COMMINUTE_REQUIRE_GPU is set and there is no graphics adapter"
        );
        eprintln!("SKIPPED {test}: no graphics adapter; set COMMINUTE_REQUIRE_GPU=1 to make this a failure");
        return false;
    };
    eprintln!("{test}: on {}", adapter.name);
    true
}

fn drucker_prager(cone: Cone, friction: Evolution, cohesion: Evolution, dilation: f64, tension: f64, poisson: f64) -> Law {
    let elastic = Elastic::of_young(4.6e6, poisson);
    let parameters = Parameters { elastic, cone, friction, cohesion, dilation: dilation * DEGREE, tension };
    Law::DruckerPrager(DruckerPrager::new(parameters))
}

/// Every kind of surface, flow and evolution; the last one jumps at its peak.
fn laws() -> Vec<Law> {
    let c = Evolution::Constant;
    let angle = |a: f64| Evolution::Constant(a * DEGREE);
    let smooth = Evolution::CubicExponential {
        initial: 0.35,
        cubic: [0.0, -200.0, 16.0, 0.35],
        peak_strain: 0.04,
        peak: 0.67,
        residual: 0.5,
        decay: 30.0,
    };
    let softer = Evolution::Linear { initial: 8e3, last: 2e3, strain: 0.05 };
    // Li et al. 2023, eq. 43
    let li = Evolution::CubicExponential {
        initial: 18.6 * DEGREE,
        cubic: [1075.64, -407.93, 16.39, 0.32],
        peak_strain: 0.022,
        peak: 28.6 * DEGREE,
        residual: 18.6 * DEGREE,
        decay: 50.0,
    };
    vec![
        Law::Elastic(Elastic::of_young(4.6e6, 0.3)),
        drucker_prager(Cone::Outer, angle(30.0), c(0.0), 0.0, FREE, 0.3),
        drucker_prager(Cone::Outer, angle(30.0), c(0.0), 30.0, FREE, 0.49),
        drucker_prager(Cone::Inner, angle(40.0), c(2e4), 10.0, 5e3, 0.2),
        drucker_prager(Cone::PlaneStrain, angle(25.0), c(1e4), 5.0, 0.0, 0.0),
        drucker_prager(Cone::Outer, angle(0.0), c(3e4), 0.0, FREE, 0.49),
        drucker_prager(Cone::Inner, angle(0.0), c(3e4), 0.0, 1e4, 0.3),
        drucker_prager(Cone::Outer, Evolution::Linear { initial: 0.5, last: 0.7, strain: 0.1 }, c(20.5e3), 5.0, FREE, 0.3),
        drucker_prager(Cone::Outer, angle(20.0), Evolution::Linear { initial: 3e4, last: 0.0, strain: 0.02 }, 5.0, FREE, 0.3),
        drucker_prager(Cone::Outer, smooth, softer, 10.0, 1e3, 0.3),
        drucker_prager(Cone::Inner, smooth, softer, 10.0, 1e3, 0.3),
        drucker_prager(Cone::PlaneStrain, smooth, softer, 10.0, 1e3, 0.3),
        drucker_prager(Cone::Outer, li, c(0.0), 16.0, FREE, 0.12),
    ]
}
