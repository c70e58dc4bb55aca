//! A ball meets a ball of one point, and of many (Li et al. 2023, section 3.1).

use crate::scene::{MASS, impact};
use comminute::coupling::Rates;

const ONE: Rates = Rates { grains: 1, continuum: 1 };

#[test]
fn a_ball_gives_its_momentum_to_one_point() {
    let mut m = impact(None);
    m.go(1e-6, ONE, 6000);
    let (grain, point) = (m.velocity_of_grain(), m.velocity_of_points());
    // Hertz without loss: they change velocities; the leapfrog's own error in an impact of so many steps
    assert!(grain[2].abs() < 5e-4 * 5.0, "the ball stops: {grain:?}");
    assert!((point[2] / -5.0 - 1.0).abs() < 5e-4, "the point leaves: {point:?}");
    assert_eq!([grain[0], grain[1]], [0.0; 2]);
    let (mass, momentum) = m.mixture.mass_and_momentum(&m.continuum);
    assert!((mass / (2.0 * MASS) - 1.0).abs() < 1e-9);
    assert!((momentum[2] / (-5.0 * m.mixture.grains.grains.mass[0]) - 1.0).abs() < 1e-12, "{momentum:?}");
}

#[test]
fn a_ball_gives_its_momentum_to_many_points() {
    let mut m = impact(Some(6));
    let before = m.mixture.mass_and_momentum(&m.continuum);
    m.run(6e-3, 0.4, None);
    let after = m.mixture.mass_and_momentum(&m.continuum);
    assert_eq!(before.0, after.0);
    for a in 0..3 {
        assert!((after.1[a] - before.1[a]).abs() < 1e-12 * before.1[2].abs(), "{before:?} {after:?}");
    }
    let (grain, points) = (m.velocity_of_grain(), m.velocity_of_points());
    // the ball of points keeps swinging: it leaves with less than all of the speed
    assert!(grain[2] > -1.5 && grain[2] < 0.1, "{grain:?}");
    assert!(points[2] < -3.5, "{points:?}");
}
