//! Energy and momentum that must be kept.

use crate::common::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const STUFF: Stuff = Stuff { young: 1e8, poisson: 0.2, density: 2000.0, friction: 0.0, restitution: 1.0 };

/// Grains of two sizes fly about in a box without friction: thousands of collisions, and energy neither drifts nor strays.
#[test]
fn elastic_collisions_keep_energy() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut balls = Vec::new();
    for k in 0..27 {
        let at = [k % 3, k / 3 % 3, k / 9].map(|c| 0.02 + 0.04 * f64::from(c));
        let velocity = std::array::from_fn(|_| rng.random_range(-2.0..2.0));
        balls.push(Ball { at, radius: if k % 2 == 0 { 0.018 } else { 0.012 }, velocity, ..Ball::default() });
    }
    let walls: Vec<Plane> = (0..3)
        .flat_map(|a| [(a, 1.0, 0.0), (a, -1.0, 0.12)])
        .map(|(a, sign, at)| {
            let mut plane = Plane::default();
            plane.normal[a] = sign;
            plane.point[a] = at;
            plane
        })
        .collect();
    for law in ["contact.law = \"hertz\"", "contact.law = \"linear\"\nmaterial.linear.K_eff_MPa = 3.0"] {
        let text = assembly_text(&format!("{law}\nstepping.dt_s = 2e-6\nrecords.energy = false"), &STUFF, &balls, &walls);
        let mut lab = Lab::new(&text);
        let start = lab.balance();
        let total = start.kinetic + start.stored;
        let (mut first, mut last, mut worst, mut stored, mut meetings, mut touching) = (0.0, 0.0, 0.0f64, 0.0f64, 0, 0);
        let rounds = 4000;
        for k in 0..rounds {
            lab.steps(49);
            let (sums, balance) = lab.see(|model, state, work| {
                let sums = comminute::dem::observables::sums(&model.physics, state, work);
                let balance = state.ledger.balance(&state.walls, &sums);
                (sums, balance)
            });
            let contacts = sums.contacts + sums.wall_contacts;
            meetings += usize::from(contacts != touching);
            touching = contacts;
            let error = (balance.kinetic + balance.stored) / total - 1.0;
            worst = worst.max(error.abs());
            stored = stored.max(balance.stored / total);
            if k < rounds / 10 {
                first += error / f64::from(rounds / 10);
            } else if k >= rounds - rounds / 10 {
                last += error / f64::from(rounds / 10);
            }
        }
        println!("{meetings} changes of contact, stored at most {stored:.2}, stray {worst:.1e}, drift {:.1e}", last - first);
        assert!(meetings > 1500 && stored > 0.1, "they collide");
        assert!(worst < 1e-4, "energy strays by {worst:.1e}");
        assert!((last - first).abs() < 1e-5, "energy drifts by {:.1e}", last - first);
    }
}

/// An isolated heap flies apart with friction, spin and viscosity: forces are equal and opposite, torques add up.
#[test]
fn momentum_and_angular_momentum_are_kept() {
    for law in ["hertz", "hertz_viscous", "linear", "elasto_plastic"] {
        for rolling in [0.0, 0.2] {
            let stuff = Stuff { friction: 0.5, restitution: 0.6, ..STUFF };
            let mut rng = ChaCha8Rng::seed_from_u64(9);
            let balls: Vec<Ball> = (0..64)
                .map(|k| Ball {
                    at: [k % 4, k / 4 % 4, k / 16].map(|c| 0.0195 * f64::from(c) + rng.random_range(-1e-3..1e-3)),
                    radius: rng.random_range(0.0095..0.0105),
                    velocity: std::array::from_fn(|_| rng.random_range(-1.0..1.0)),
                    spin: std::array::from_fn(|_| rng.random_range(-100.0..100.0)),
                    ..Ball::default()
                })
                .collect();
            let head = format!(
                "contact.law = \"{law}\"\nmaterial.linear.K_eff_MPa = 3.0\nmaterial.contact.yield_pressure_MPa = 3.0\nmaterial.contact.rolling_friction = {rolling:?}\nstepping.dt_s = 2e-6"
            );
            let mut lab = Lab::new(&assembly_text(&head, &stuff, &balls, &[]));
            let (p0, l0, p_scale, l_scale) = momenta(&lab);
            let mut fell = false;
            for _ in 0..100 {
                lab.steps(20);
                let (p, l, _, _) = momenta(&lab);
                assert!(length(minus(p, p0)) < 1e-12 * p_scale, "{law}: momentum changed by {:?} of {p_scale:e}", minus(p, p0));
                assert!(
                    length(minus(l, l0)) < 1e-11 * l_scale,
                    "{law}: angular momentum changed by {:?} of {l_scale:e}",
                    minus(l, l0)
                );
                let turned = lab.state.grains.spin.iter().zip(&balls).any(|(s, b)| (s[0] - b.spin[0]).abs() > 10.0);
                fell |= turned;
            }
            assert!(fell, "friction acts");
        }
    }
}

/// Momentum, angular momentum about the origin, and sums of magnitudes. With the leapfrog x(t) × v(t − ½) changes by torques only.
fn momenta(lab: &Lab) -> ([f64; 3], [f64; 3], f64, f64) {
    let g = &lab.state.grains;
    let (mut p, mut l, mut ps, mut ls) = ([0.0; 3], [0.0; 3], 0.0, 0.0);
    for i in 0..g.len() {
        let (x, v, w, m, r) = (lab_vec(g.pos[i]), lab_vec(g.vel[i]), lab_vec(g.spin[i]), g.inertia(i), g.pos[i][3]);
        let moment = cross(x, v);
        for a in 0..3 {
            p[a] += m * v[a];
            l[a] += m * moment[a] + 0.4 * m * r * r * w[a];
        }
        ps += m * length(v);
        ls += m * length(moment) + 0.4 * m * r * r * length(w);
    }
    (p, l, ps, ls)
}

fn lab_vec(v: [f64; 4]) -> [f64; 3] {
    [v[0], v[1], v[2]]
}
