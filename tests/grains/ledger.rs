//! The energy ledger: every run closes, and none closes when any one term is left out.

use crate::common::*;
use comminute::dem::ledger::Balance;

const STUFF: Stuff = Stuff { young: 1e8, poisson: 0.25, density: 2000.0, friction: 0.4, restitution: 1.0 };
const CRUSHING: &str = "crushing.enabled = true\nmaterial.strength.fixed_angle.theta0_rad = 0.35\n\
    material.strength.fixed_angle.sigma_lim0_MPa = 1.0\nmaterial.strength.fixed_angle.m = 3.0\nmaterial.strength.fixed_angle.var = 0.0\n\
    material.strength.d0_mm = 20.0\nmaterial.comminution.d_limit_over_d50 = 0.5\nmaterial.comminution.d50_mm = 20.0\n\
    material.fines.d_min_mm = 0.01\n";

/// The balance without one of its terms.
fn without(b: &Balance, term: &str) -> Balance {
    let mut b = *b;
    let gone = match term {
        "wall" => &mut b.wall,
        "inertia" => &mut b.inertia,
        "path" => &mut b.path,
        "damping" => &mut b.damping,
        "kinetic" => &mut b.kinetic,
        "kinetic at the start" => &mut b.start[1],
        "potential" => &mut b.potential,
        "potential at the start" => &mut b.start[2],
        "lost kinetic" => &mut b.lost_kinetic,
        "lost potential" => &mut b.lost_potential,
        "stored" => &mut b.stored,
        "stored at the start" => &mut b.start[0],
        "removed" => &mut b.removed,
        "made" => &mut b.made,
        "slip" => &mut b.slip,
        "viscous" => &mut b.viscous,
        "growth" => &mut b.growth,
        "release" => &mut b.release,
        _ => unreachable!("{term}"),
    };
    assert!(*gone != 0.0, "{term} is exercised");
    *gone = 0.0;
    b
}

/// `sum` is within `bound` of the energy gone through, and no longer so without any of the terms.
#[track_caller]
fn closes(what: &str, b: &Balance, sum: impl Fn(&Balance) -> f64, bound: f64, terms: &[&str]) {
    println!("{what}: open by {:.1e}", sum(b) / b.scale());
    assert!(sum(b).abs() < bound * b.scale(), "{what}: open by {:.1e} of {b:?}", sum(b) / b.scale());
    for term in terms {
        let open = sum(&without(b, term)).abs() / b.scale();
        println!("    without {term}: {open:.1e}");
        assert!(open > 3.0 * bound, "{what} closes without {term} ({open:.1e})");
    }
}

fn lab(head: &str, stuff: &Stuff, balls: &[Ball], planes: &[Plane]) -> Lab {
    Lab::new(&assembly_text(head, stuff, balls, planes))
}

/// Grains thrown over a floor, rubbing and damped, high above the zero of potential energy.
#[test]
fn grains_on_a_floor_close() {
    let balls: Vec<Ball> = (0..8)
        .map(|k| {
            let (x, y, z) = (f64::from(k % 2), f64::from(k / 2 % 2), f64::from(k / 4));
            Ball {
                at: [0.021 * x, 0.021 * y, 0.011 + 0.0201 * z + 0.05],
                radius: 0.01,
                velocity: [1.0 - x, 0.5 * y, -0.5],
                spin: [20.0 * z, 0.0, 30.0],
                ..Ball::default()
            }
        })
        .collect();
    let floor = Plane { point: [0.0, 0.0, 0.05], normal: [0.0, 0.0, 1.0], friction: 0.3, velocity: 0.0 };
    let head = "gravity_m_s2 = [0.0, 0.0, -9.81]\ndamping.local = 0.02\nstepping.dt_s = 2e-6";
    let mut lab = lab(head, &STUFF, &balls, &[floor]);
    lab.steps(20_000);
    let b = lab.balance();
    let terms = ["path", "damping", "kinetic", "kinetic at the start", "potential", "potential at the start"];
    closes("balance", &b, Balance::residual, 1e-3, &terms);
}

/// A platen strikes grains at rest.
#[test]
fn a_moving_wall_closes() {
    let balls: Vec<Ball> =
        (0..3).map(|k| Ball { at: [0.0, 0.001 * f64::from(k), 0.02 * f64::from(k)], radius: 0.01, ..Ball::default() }).collect();
    let floor = Plane { point: [0.0, 0.0, -0.01], normal: [0.0, 0.0, 1.0], friction: 0.3, velocity: 0.0 };
    let lid = Plane { point: [0.0, 0.0, 0.0501], normal: [0.0, 0.0, -1.0], friction: 0.3, velocity: 0.5 };
    let mut lab = lab("damping.local = 0.1\nstepping.dt_s = 2e-6", &STUFF, &balls, &[floor, lid]);
    lab.steps(3000);
    closes("balance", &lab.balance(), Balance::residual, 1e-3, &["wall", "path", "damping", "kinetic"]);
}

/// A flying, turning grain breaks on the floor, far above the zero of potential energy.
#[test]
fn a_breakage_closes() {
    let ball = Ball { at: [0.0, 0.0, 0.5101], radius: 0.01, velocity: [0.5, 0.0, -1.0], spin: [0.0, 50.0, 0.0], ..Ball::default() };
    let floor = Plane { point: [0.0, 0.0, 0.5], normal: [0.0, 0.0, 1.0], friction: 0.3, velocity: 0.0 };
    let head = format!("{CRUSHING}gravity_m_s2 = [0.0, 0.0, -9.81]\nstepping.dt_s = 5e-7");
    let mut lab = lab(&head, &STUFF, &[ball], &[floor]);
    lab.steps(20_000);
    assert!(lab.state.crush_events >= 1);
    let b = lab.balance();
    closes(
        "balance",
        &b,
        Balance::residual,
        1e-3,
        &["kinetic", "kinetic at the start", "potential", "potential at the start", "lost kinetic", "lost potential"],
    );
}

/// A grain swings between platens that close in: its contacts stiffen and its scaled inertia follows while it moves.
#[test]
fn rescaled_inertia_closes() {
    let ball = Ball { radius: 0.01, velocity: [0.0, 0.0, 2e-6], spin: [1e-4, 0.0, 0.0], ..Ball::default() };
    let lid = |sign: f64| Plane { point: [0.0, 0.0, -sign * 0.00999], normal: [0.0, 0.0, sign], friction: 0.0, velocity: 1e-8 };
    let mut lab = lab("stepping.inertia_scaling = true\nstepping.safety = 0.1", &STUFF, &[ball], &[lid(1.0), lid(-1.0)]);
    lab.steps(5000);
    let b = lab.balance();
    closes("balance", &b, Balance::residual, 1e-3, &["inertia", "kinetic", "kinetic at the start", "wall", "path"]);
}

/// Path work becomes stored energy, slip under a constant normal force, viscous loss, and energy removed and made by a breakage.
#[test]
fn path_work_is_accounted_for() {
    // a sphere slides under its own weight
    let weight = STUFF.mass(0.01) * 9.81;
    let overlap = (3.0 * weight / (4.0 * STUFF.plane_modulus() * 0.1)).powf(2.0 / 3.0);
    let ball = Ball { at: [0.0, 0.0, 0.01 - overlap], radius: 0.01, velocity: [1.0, 0.0, 0.0], ..Ball::default() };
    let floor = Plane { normal: [0.0, 0.0, 1.0], friction: 0.3, ..Plane::default() };
    let head = "gravity_m_s2 = [0.0, 0.0, -9.81]\nstepping.dt_s = 4e-6";
    let mut slider = lab(head, &STUFF, &[ball], &[floor]);
    slider.steps(5000);
    closes("sliding", &slider.balance(), Balance::nonconservative, 1e-3, &["path", "slip"]);

    // two spheres meet and lose by viscosity; at the height of the impact some of it is stored
    let ball = |x: f64| Ball { at: [x, 0.0, 0.0], radius: 0.01, velocity: [-x * 100.0, 0.0, 0.0], ..Ball::default() };
    let soft = Stuff { restitution: 0.5, ..STUFF };
    let mut impact = lab("contact.law = \"hertz_viscous\"\nstepping.dt_s = 2e-8", &soft, &[ball(-0.010001), ball(0.010001)], &[]);
    impact.steps(4000);
    closes("viscous impact", &impact.balance(), Balance::nonconservative, 1e-3, &["path", "viscous", "stored"]);

    // a pressed grain breaks; its daughters are born into the contacts it had
    let ball = Ball { radius: 0.01, ..Ball::default() };
    let lid = |sign: f64| Plane { point: [0.0, 0.0, -sign * 0.0099], normal: [0.0, 0.0, sign], friction: 0.0, velocity: 0.1 };
    let plain = Stuff { friction: 0.0, ..STUFF };
    let broken = |birth: &str, more: usize| {
        let head =
            format!("{CRUSHING}crushing.birth = \"{birth}\"\ncrushing.growth_steps = 20000\nsteps = 100000\nstepping.dt_s = 2e-7");
        let mut pressed = lab(&head, &plain, &[ball], &[lid(1.0), lid(-1.0)]);
        while pressed.state.crush_events == 0 {
            pressed.step();
            assert!(pressed.state.step < 100_000);
        }
        pressed.steps(more);
        pressed.balance()
    };
    // daughters that grow against the platens
    let b = broken("gradual", 25_000);
    closes("growth", &b, Balance::nonconservative, 1e-3, &["path", "removed", "growth"]);
    closes("growth", &b, Balance::residual, 1e-3, &["wall", "path"]);
    let b = broken("overlapping", 20);
    closes("breakage", &b, Balance::nonconservative, 1e-3, &["path", "stored", "stored at the start", "removed", "made"]);
    closes("breakage", &b, Balance::residual, 1e-3, &["wall", "path"]);
}

/// A contact that ends by a jump far beyond the skin still closes its path work: the list's age must not show.
#[test]
fn a_contact_that_ends_in_one_step_keeps_its_work() {
    let open = |skin: &str| {
        let ball = Ball { at: [0.0, 0.0, 0.0099], radius: 0.01, velocity: [0.0, 0.0, 100.0], ..Ball::default() };
        let floor = Plane { normal: [0.0, 0.0, 1.0], ..Plane::default() };
        let mut lab = lab(&format!("{skin}\nstepping.dt_s = 5e-6"), &STUFF, &[ball], &[floor]);
        lab.steps(10);
        lab.balance()
    };
    let (narrow, wide) = (open("stepping.skin = 0.005"), open("stepping.skin = 0.5"));
    assert_eq!(narrow, wide);
    closes("balance", &wide, Balance::residual, 1e-6, &["path", "kinetic", "kinetic at the start"]);
}

/// A crushing oedometer: friction, breakages and scaled inertia in one ledger that closes at every look.
#[test]
fn a_crushing_oedometer_closes() {
    let sets = ["crushing.enabled=true", "contact.unloading=\"keep\"", "material.strength.fixed_angle.sigma_lim0_MPa=100"]
        .map(String::from);
    let model = model(&oedometer_text(150, 300.0, ""), &sets);
    let (prepared, _) = prepare(&model, |_, _| ());
    let mut press = Press::new(model, &prepared);
    let mut last = Balance::default();
    let mut worst = 0.0f64;
    while !press.done() {
        let look = press.state.step > 2000 && press.state.step.is_multiple_of(250);
        press.see(|model, _, state, work| {
            if look {
                last = state.ledger.balance(&state.walls, &comminute::dem::observables::sums(&model.physics, state, work));
                worst = worst.max(last.error().abs());
            }
        });
    }
    println!(
        "{} events, worst error {worst:.1e}, not conserved {:.1e}: {last:?}",
        press.state.crush_events,
        last.nonconservative() / last.scale()
    );
    assert!(press.state.crush_events > 20);
    assert!(worst < 1e-3);
    closes("balance", &last, Balance::residual, 1e-3, &["wall", "path", "damping", "inertia", "release"]);
    // the incremental tangential law does not conserve: its share is what it is, and no large term may hide in it
    closes("path", &last, Balance::nonconservative, 0.02, &["path", "slip", "stored"]);
}
