//! A contact knows no frame: the whole history of a pair, turned, is the history of the turned pair.

use crate::common::*;
use proptest::prelude::*;

fn turned(q: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let u = [q[1], q[2], q[3]];
    let t = cross(u, v).map(|x| 2.0 * x);
    let c = cross(u, t);
    std::array::from_fn(|a| v[a] + q[0] * t[a] + c[a])
}

fn unit<const N: usize>() -> impl Strategy<Value = [f64; N]> {
    proptest::array::uniform(-1.0..1.0f64).prop_filter_map("too short", |v: [f64; N]| {
        let l = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        (l > 0.1).then(|| v.map(|x| x / l))
    })
}

fn vector(size: f64) -> impl Strategy<Value = [f64; 3]> {
    proptest::array::uniform3(-size..size)
}

const STUFF: Stuff = Stuff { young: 1e8, poisson: 0.2, density: 2000.0, friction: 0.4, restitution: 0.8 };
const STEPS: usize = 600;

/// The velocity, mirrored where it would part the two.
fn towards(v: [f64; 3], line: [f64; 3]) -> [f64; 3] {
    let along = dot(v, line);
    std::array::from_fn(|a| v[a] + (along.abs().max(0.1) - along) * line[a])
}

/// Grains and a plane through the origin, each turned by `q`; positions, velocities and spins at the end, turned back.
fn history(law: &str, balls: &[Ball], wall: Option<[f64; 3]>, q: [f64; 4]) -> Vec<[[f64; 3]; 3]> {
    let balls: Vec<Ball> = balls
        .iter()
        .map(|b| Ball { at: turned(q, b.at), velocity: turned(q, b.velocity), spin: turned(q, b.spin), ..*b })
        .collect();
    let walls: Vec<Plane> = wall.iter().map(|n| Plane { normal: turned(q, *n), friction: 0.4, ..Plane::default() }).collect();
    let head = format!(
        "contact.law = \"{law}\"\nmaterial.linear.K_eff_MPa = 1.0\nmaterial.contact.yield_pressure_MPa = 1.0\nmaterial.contact.rolling_friction = 0.1\nstepping.dt_s = 2e-6"
    );
    let mut lab = Lab::new(&assembly_text(&head, &STUFF, &balls, &walls));
    lab.steps(STEPS);
    let back = [q[0], -q[1], -q[2], -q[3]];
    (0..balls.len() as u32).map(|id| [lab.position(id), lab.velocity(id), lab.spin(id)].map(|v| turned(back, v))).collect()
}

fn same(law: &str, balls: &[Ball], wall: Option<[f64; 3]>, q: [f64; 4]) -> Result<(), TestCaseError> {
    let here = history(law, balls, wall, [1.0, 0.0, 0.0, 0.0]);
    let there = history(law, balls, wall, q);
    let mut met = false;
    for ((a, b), ball) in here.iter().zip(&there).zip(balls) {
        for (k, size) in [0.1, 3.0, 300.0].into_iter().enumerate() {
            prop_assert!(length(minus(a[k], b[k])) < 1e-9 * size, "{law}: {a:?} {b:?}");
        }
        met |= length(minus(a[1], ball.velocity)) > 0.01;
    }
    prop_assert!(met, "they meet");
    Ok(())
}

const LAWS: [&str; 4] = ["hertz", "hertz_viscous", "linear", "elasto_plastic"];

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_pair_turned_has_its_history_turned(
        q in unit::<4>(), line in unit::<3>(), v in vector(1.0), w1 in vector(100.0), w2 in vector(100.0),
        r1 in 0.005..0.02f64, r2 in 0.005..0.02f64, law in 0usize..4,
    ) {
        let gap = r1 + r2 - 1e-4;
        let v = towards(v, line);
        let balls = [
            Ball { at: [0.0; 3], radius: r1, velocity: v, spin: w1, ..Ball::default() },
            Ball { at: line.map(|x| x * gap), radius: r2, velocity: line.map(|x| -0.5 * x), spin: w2, ..Ball::default() },
        ];
        same(LAWS[law], &balls, None, q)?;
    }

    #[test]
    fn a_grain_on_a_wall_turned_has_its_history_turned(
        q in unit::<4>(), normal in unit::<3>(), v in vector(1.0), w in vector(100.0), r in 0.005..0.02f64, law in 0usize..4,
    ) {
        let v = towards(v, normal.map(|x| -x));
        let ball = Ball { at: normal.map(|x| x * (r - 5e-5)), radius: r, velocity: v, spin: w, ..Ball::default() };
        same(LAWS[law], &[ball], Some(normal), q)?;
    }
}
