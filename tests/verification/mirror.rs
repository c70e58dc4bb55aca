//! A rigid wall is a mirrored identical grain (`docs/theory/contact_normal.md`).

use crate::common::*;

const R: f64 = 0.1;
const STUFF: Stuff = Stuff { young: 70e9, poisson: 0.3, density: 2700.0, friction: 0.0, restitution: 0.7 };
/// Grain against wall at the plane z = 0, and two grains with the same contact plane.
fn both(head: &str, friction: f64, velocity: [f64; 3], spin: [f64; 3], mirrored: [[f64; 3]; 2]) -> (Lab, Lab) {
    let stuff = Stuff { friction, ..STUFF };
    let head = format!("{head}\nstepping.dt_s = 2e-7");
    let grain = Ball { at: [0.0, 0.0, R + 1e-7], radius: R, velocity, spin, ..Ball::default() };
    let image = Ball { at: [0.0, 0.0, -R - 1e-7], velocity: mirrored[0], spin: mirrored[1], ..grain };
    let wall = Plane { normal: [0.0, 0.0, 1.0], friction, ..Plane::default() };
    (Lab::new(&assembly_text(&head, &stuff, &[grain], &[wall])), Lab::new(&assembly_text(&head, &stuff, &[grain, image], &[])))
}

const LAWS: [&str; 4] = [
    "contact.law = \"hertz\"",
    "contact.law = \"hertz_viscous\"",
    "contact.law = \"linear\"\nmaterial.linear.K_eff_MPa = 3000.0",
    "contact.law = \"elasto_plastic\"\nmaterial.contact.yield_pressure_MPa = 1000.0",
];

/// Mirrored motion, tangential velocity and spin included: both see no slip but the same normal motion, all along.
#[test]
fn a_wall_is_a_mirrored_grain_in_normal_motion() {
    for law in LAWS {
        // a wall does not move with the tangential velocity of a mirror image, so that motion is along the normal and spin about it
        let (mut one, mut two) = both(law, 0.4, [0.0, 0.0, -0.2], [0.0, 0.0, 3.0], [[0.0, 0.0, 0.2], [0.0, 0.0, 3.0]]);
        let mut largest = 0.0f64;
        for _ in 0..6_000 {
            let [a] = one.watch([0]);
            let [b] = two.watch([0]);
            largest = largest.max(a.force[2]);
            assert!((a.force[2] - b.force[2]).abs() < 1e-9 * 1e4, "{law}: {a:?} {b:?}");
            assert!(length(minus(a.velocity, b.velocity)) < 1e-12 && length(minus(a.spin, b.spin)) < 1e-12);
        }
        assert!(largest > 1e3 && one.velocity(0)[2] > 0.09, "it has come back");
        near("rebound", one.velocity(0)[2], two.velocity(0)[2], 1e-11);
    }
}

/// Turned by 180° about the y axis, the partner slides the other way: twice the slip on half the stiffness. The line of centres turns by
/// the way over the diameter, which matters as overlap over radius: the impact is a gentle one.
#[test]
fn a_wall_is_a_turned_grain_in_tangential_motion() {
    for law in LAWS {
        // sticking, and slipping for good
        for friction in [0.4, 0.06] {
            let (speed, vx, wy) = (2e-3, 3e-4, -1e-3);
            let (mut one, mut two) = both(law, friction, [vx, 0.0, -speed], [0.0, wy, 0.0], [[-vx, 0.0, speed], [0.0, wy, 0.0]]);
            let (mut impulse, mut off) = (0.0f64, 0.0f64);
            while one.velocity(0)[2] < 0.0 || one.position(0)[2] < R {
                let [a] = one.watch([0]);
                let [b] = two.watch([0]);
                impulse += a.force[0].abs();
                off += (a.force[0] - b.force[0]).abs();
                assert!(one.state.step < 200_000);
            }
            near(&format!("{law}, {friction}: share of the tangential impulse"), off / impulse, 0.0, 1e-4);
            near("tangential velocity", one.velocity(0)[0], two.velocity(0)[0], 1e-4 * vx);
            near("spin", one.spin(0)[1], two.spin(0)[1], 1e-4 * vx / R);
            assert!((one.velocity(0)[0] - vx).abs() > 0.02 * vx, "friction acts");
        }
    }
}
