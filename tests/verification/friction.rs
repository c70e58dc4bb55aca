//! A sphere on a plane: sliding to rolling, rolling and slipping down an incline. Rigid-body mechanics, I = 2/5 m r²; the engine's grain
//! sinks in by 10⁻⁴ of its radius and its tangential spring swings, which sets the bounds.

use crate::common::*;

const G: f64 = 9.81;
const R: f64 = 0.01;
const STUFF: Stuff = Stuff { young: 1e9, poisson: 0.25, density: 2500.0, friction: 0.0, restitution: 1.0 };

/// A sphere at rest in the overlap that bears its weight on the plane z = 0, `slope` rad steep along x.
fn sphere(slope: f64, friction: f64, speed: f64) -> Lab {
    sphere_with("", slope, friction, speed)
}

fn sphere_with(more: &str, slope: f64, friction: f64, speed: f64) -> Lab {
    let weight = STUFF.mass(R) * G * slope.cos();
    let overlap = (3.0 * weight / (4.0 * STUFF.plane_modulus() * R.sqrt())).powf(2.0 / 3.0);
    let ball = Ball { at: [0.0, 0.0, R - overlap], radius: R, velocity: [speed, 0.0, 0.0], ..Ball::default() };
    let head = format!("gravity_m_s2 = [{:?}, 0.0, {:?}]\nstepping.dt_s = 4e-6\n{more}", G * slope.sin(), -G * slope.cos());
    Lab::new(&assembly_text(&head, &STUFF, &[ball], &[Plane { normal: [0.0, 0.0, 1.0], friction, ..Plane::default() }]))
}

#[test]
fn sliding_turns_into_rolling() {
    let (v0, mu) = (1.0, 0.3);
    let mut lab = sphere(0.0, mu, v0);
    // slip ends where the surface stands still on the plane
    let start = lab.position(0)[0];
    let (mut time, mut way) = (0.0, 0.0);
    while lab.state.time < 0.097 || time == 0.0 {
        let now = lab.watch([0])[0];
        if time == 0.0 && now.velocity[0] - R * now.spin[1] <= 0.0 {
            (time, way) = (lab.state.time - lab.state.dt, now.at[0] - start);
        }
        assert!(lab.state.time < 0.2);
    }
    close("time to rolling", time, 2.0 * v0 / (7.0 * mu * G), 3e-4);
    close("the tabulated", time, 0.097082666, 3e-4);
    close("distance", way, 0.083213714, 3e-4);
    // the spring that slid now swings about zero: the mean over many swings rolls on
    let (mut speed, mut spin) = (0.0, 0.0);
    let n = 20_000;
    for _ in 0..n {
        let now = lab.watch([0])[0];
        speed += now.velocity[0] / f64::from(n);
        spin += now.spin[1] / f64::from(n);
    }
    close("rolling velocity", speed, 0.71428571, 3e-4);
    close("rolling spin", spin * R, speed, 3e-4);
}

#[test]
fn a_sphere_rolls_down_an_incline_that_holds_it() {
    let slope = 30.0f64.to_radians();
    let mut lab = sphere(slope, 0.3, 0.0);
    while lab.state.time < 0.4 {
        lab.step();
    }
    let now = lab.watch([0])[0];
    let time = lab.state.time - lab.state.dt;
    close("acceleration", now.velocity[0] / time, 3.5035714, 5e-4);
    close("rolls", now.spin[1] * R, now.velocity[0], 5e-4);
}

#[test]
fn a_sphere_slips_down_an_incline_that_does_not() {
    let mut lab = sphere(30.0f64.to_radians(), 0.1, 0.0);
    // the spring is loaded and slides after 2e-4 s
    let mut at = |time: f64| {
        while lab.state.time < time {
            lab.step();
        }
        (lab.state.time, lab.watch([0])[0])
    };
    let ((t1, early), (t2, late)) = (at(0.05), at(0.2));
    close("acceleration", (late.velocity[0] - early.velocity[0]) / (t2 - t1), 4.0554291, 1e-7);
    // the arm is the radius less the overlap, 8e-5 of it
    close("angular acceleration", (late.spin[1] - early.spin[1]) / (t2 - t1), 212.39273, 1e-4);
}

/// The steepest slope on which a sphere rolls is tan θ = 3.5 μ: half a degree to either side tells.
#[test]
fn the_limit_of_rolling_is_where_it_should_be() {
    for (slope, rolls) in [(45.9f64, true), (46.9, false)] {
        let mut lab = sphere(slope.to_radians(), 0.3, 0.0);
        while lab.state.time < 0.3 {
            lab.step();
        }
        let now = lab.watch([0])[0];
        let slip = now.velocity[0] - R * now.spin[1];
        assert_eq!(slip / now.velocity[0] < 2e-3, rolls, "slip {slip} at {slope} degrees");
    }
}

/// A grain that does not turn is a block: it slides to rest within v²/(2 μ g), and holds on a slope up to tan θ = μ.
#[test]
fn a_sphere_that_cannot_turn_slides_like_a_block() {
    const FIXED: &str = "contact.rotation = \"fixed\"";
    let (v0, mu) = (0.2, 0.3);
    let mut lab = sphere_with(FIXED, 0.0, mu, v0);
    let start = lab.position(0)[0];
    while lab.watch([0])[0].velocity[0] > 0.0 {
        assert!(lab.state.time < 0.2);
    }
    close("sliding distance", lab.position(0)[0] - start, v0 * v0 / (2.0 * mu * G), 2e-3);
    for (slope, holds) in [(16.2f64, true), (17.2, false)] {
        let mut lab = sphere_with(FIXED, slope.to_radians(), mu, 0.0);
        let start = lab.position(0)[0];
        while lab.state.time < 0.3 {
            lab.step();
        }
        let now = lab.watch([0])[0];
        let way = lab.position(0)[0] - start;
        assert_eq!(now.spin, [0.0; 3]);
        assert_eq!(way < 1e-5, holds, "slope {slope}: slid {way:e} m");
    }
}
