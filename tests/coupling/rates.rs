//! Steps of their own for grains and continuum.

use crate::scene::{Meeting, impact};
use comminute::coupling::Rates;

fn state(m: &Meeting) -> String {
    let points = m.continuum.points();
    let order = points.by_id();
    let of = |i: &u32| (points.position[*i as usize], points.velocity[*i as usize], points.stress[*i as usize]);
    let all: Vec<_> = order.iter().map(of).collect();
    let g = &m.mixture.grains.grains;
    format!("{:?} {:?} {:?} {all:?}", g.pos, g.vel, g.spin)
}

const TIME: f64 = 2e-6;

#[test]
fn momentum_is_kept_to_rounding_whatever_the_rates() {
    let mut speeds = Vec::new();
    for rates in [[1, 1], [4, 1], [1, 4]].map(|[grains, continuum]| Rates { grains, continuum }) {
        let mut m = impact(Some(4));
        let before = m.mixture.mass_and_momentum(&m.continuum).1;
        m.go(TIME, rates, 1500);
        let after = m.mixture.mass_and_momentum(&m.continuum).1;
        assert!((after[2] / before[2] - 1.0).abs() < 1e-13, "{rates:?}: {before:?} {after:?}");
        speeds.push(m.velocity_of_grain()[2]);
    }
    for v in &speeds {
        assert!((v - speeds[0]).abs() < 0.01 * 5.0, "{speeds:?}");
    }
}

#[test]
fn threads_and_scratch_change_no_bit() {
    let one = Rates { grains: 1, continuum: 1 };
    let mut reference = impact(Some(6));
    reference.go(TIME, one, 423);
    assert!(reference.mixture.ghosts.touching().count() > 1);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
    let mut other = impact(Some(6));
    pool.install(|| {
        for _ in 0..9 {
            other.go(TIME, one, 47);
            // what a restart does
            let bytes = postcard::to_allocvec(&(&other.mixture, &other.continuum)).expect("written");
            (other.mixture, other.continuum) = postcard::from_bytes(&bytes).expect("read");
            other.work.restart(&other.model, &mut other.mixture.grains);
        }
    });
    assert!(state(&reference) == state(&other));
}
