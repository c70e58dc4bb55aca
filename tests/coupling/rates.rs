//! Steps of their own for grains and continuum.

use crate::scene::{Meeting, STUFF, impact, radius};
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

/// κ = 1 is one step for both: a ball and a ball of one point, which strains nothing, go as two bodies with Hertz' force between them do in a plain leapfrog, to
/// rounding, all through the impact.
#[test]
fn one_step_for_both_is_that_of_a_plain_leapfrog() {
    let mut m = impact(None);
    let mass = [m.mixture.grains.grains.mass[0], m.continuum.points().velocity[0][3]];
    let ghost = (m.continuum.points().solid(0) * 0.75 / std::f64::consts::PI).cbrt();
    let reach = radius() + ghost;
    // E* of two equal materials, R* of two spheres
    let stiffness = 4.0 / 3.0 * (0.5 * STUFF.young / (1.0 - STUFF.poisson * STUFF.poisson)) * (radius() * ghost / reach).sqrt();
    let mut z = [m.mixture.grains.grains.pos[0][2], m.continuum.points().position[0][2]];
    let mut v = [-5.0, 0.0];
    let mut deepest = 0.0_f64;
    for step in 0..6000 {
        let overlap = (reach - (z[0] - z[1])).max(0.0);
        deepest = deepest.max(overlap);
        let force = stiffness * overlap.powf(1.5);
        v = [v[0] + TIME / mass[0] * force, v[1] - TIME / mass[1] * force];
        z = [z[0] + TIME * v[0], z[1] + TIME * v[1]];
        m.go(TIME, Rates { grains: 1, continuum: 1 }, 1);
        let (here, there) = (m.mixture.grains.grains.pos[0][2], m.continuum.points().position[0][2]);
        let off = [here - z[0], there - z[1]].map(|d| d.abs() / radius());
        assert!(off[0] < 1e-11 && off[1] < 1e-11, "{off:?} radii at step {step}");
    }
    let off = [m.velocity_of_grain()[2] - v[0], m.velocity_of_points()[2] - v[1]];
    assert!(off.iter().all(|d| d.abs() < 1e-11 * 5.0) && v[1] < -4.9, "{off:?} of {v:?}");
    assert!(deepest > 1e-3 * radius(), "{deepest} m");
}

#[test]
fn threads_and_scratch_change_no_bit() {
    let one = Rates { grains: 1, continuum: 1 };
    let mut reference = impact(Some(6));
    reference.go(TIME, one, 423);
    assert!(reference.mixture.point_contacts.touching().count() > 1);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
    let mut other = impact(Some(6));
    pool.install(|| {
        for _ in 0..9 {
            other.go(TIME, one, 47);
            // what a restart does
            let bytes = postcard::to_allocvec(&(&other.mixture, &other.continuum)).expect("written");
            (other.mixture, other.continuum) = postcard::from_bytes(&bytes).expect("read");
            other.work.restart(&other.model.physics, &mut other.mixture.grains);
        }
    });
    assert!(state(&reference) == state(&other));
}

/// A ball that comes down with a motion along the surface, too slow to slide: the tangential spring of the contact takes the way, whatever the number of steps in
/// which it is gone. At the start of a cycle that is the way of one step of the points, not of the whole cycle.
#[test]
fn a_tangential_spring_takes_the_way_once() {
    let force = |continuum: u32| {
        let mut m = impact(None);
        m.mixture.grains.grains.vel[0][0] = 0.1;
        // as many steps of the points, the last of which ends at the same instant
        m.go(1e-6 * f64::from(continuum), Rates { grains: 1, continuum }, u64::from(800 / continuum));
        let contact = m.mixture.point_contacts.candidates[0];
        let [x, _, _] = contact.touch.tangential;
        assert!(
            x.abs() > 1.0 && x.abs() < 0.5 * STUFF.friction * contact.touch.normal_force,
            "it touches, and sticks: {contact:?}"
        );
        x
    };
    let (one, eight) = (force(1), force(8));
    assert!((eight / one - 1.0).abs() < 0.03, "{eight} N instead of {one} N");
}
