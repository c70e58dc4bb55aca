//! Grains that collide with each other and with walls.

use crate::change::{ACCELERATION, Change, ENERGY, FORCE, LENGTH, SPIN, TIME, VELOCITY, Within, same};
use comminute::boundary::{Drive, Wall, WallShape, WallSpec};
use comminute::contact::TangentialUnloading;
use comminute::parameter::Parameter;
use comminute::{ContactLaw, Grains, Material, Physics, State, Workspace, step};
use std::convert::Infallible;

/// A grain at the start.
#[derive(Clone, Copy)]
pub struct Ball {
    pub at: [f64; 3],
    pub radius: f64,
    pub velocity: [f64; 3],
    pub spin: [f64; 3],
    pub material: u8,
}

/// Grains and walls, and the laws of their contacts.
#[derive(Clone)]
pub struct Scene {
    pub physics: Physics,
    pub balls: Vec<Ball>,
    pub walls: Vec<WallSpec>,
}

/// What a scene has come to; grains in the order in which the scene names them.
#[derive(Default)]
pub struct Outcome {
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    spins: Vec<[f64; 3]>,
    /// Work of contacts, slip, dashpots or yielding and local damping.
    works: Vec<[f64; 4]>,
    /// Sum of the force of all grains on each wall over the steps.
    pushed: Vec<[f64; 1]>,
    time: f64,
}

/// Values of a law's parameters, SI.
fn values(parameters: &[Parameter], stiffness: f64) -> [f64; 4] {
    std::array::from_fn(|k| match parameters.get(k).map(|p| p.key) {
        Some("linear.K_eff_MPa") => 0.01 * stiffness,
        Some("contact.yield_pressure_MPa") => 0.02 * stiffness,
        Some("contact.restitution") => 0.7,
        Some("linear.alpha_s") => 0.4,
        // that of Hertz's law at an overlap of some thousandths of grains of centimetres
        Some("spring.k_n_N_m") => 1e-3 * stiffness,
        Some("spring.k_t_N_m") => 5e-4 * stiffness,
        Some(other) => panic!("a value for {other}"),
        None => 0.0,
    })
}

pub fn materials(law: ContactLaw, young: f64) -> Vec<Material> {
    let of = |name: &str, density, young, poisson, friction, rolling_friction| Material {
        name: name.into(),
        density,
        internal_porosity: 0.0,
        young,
        poisson,
        friction,
        contact: values(law.table().parameters, young),
        rolling_friction,
        interface_friction: None,
    };
    vec![of("hard", 2500.0, young, 0.2, 0.4, 0.05), of("soft", 1100.0, 0.4 * young, 0.35, 0.7, 0.1)]
}

impl Scene {
    /// Nine grains of two materials that fly into the corner of three walls, one of them oblique and one moving.
    fn thrown(law: ContactLaw, unloading: TangentialUnloading, damping: f64) -> Scene {
        let mut physics = Physics::of(materials(law, 1e8), law);
        (physics.contact.unloading, physics.damping, physics.gravity) = (unloading, damping, [0.3, -0.7, -9.81]);
        let mut balls = Vec::new();
        for k in 0..9usize {
            let (i, j) = ((k % 3) as f64, (k / 3) as f64);
            let wobble = |seed: f64| (seed * (k as f64 + 1.0)).sin();
            balls.push(Ball {
                at: [
                    0.011 + 0.017 * i + 0.001 * wobble(1.3),
                    0.012 + 0.017 * j + 0.001 * wobble(2.9),
                    0.011 + 0.004 * wobble(4.7).abs(),
                ],
                radius: 0.0065 + 0.001 * wobble(7.1),
                velocity: [-1.2 + 0.3 * wobble(0.7), -1.5 + 0.3 * wobble(1.9), -1.0 + 0.2 * wobble(3.1)],
                spin: [60.0 * wobble(5.3), 60.0 * wobble(6.7), 60.0 * wobble(8.9)],
                material: u8::from(k % 4 == 1),
            });
        }
        let plane = |point, normal: [f64; 3], friction, drive, material| {
            let size = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            WallSpec { shape: WallShape::Plane { point, normal: normal.map(|x| x / size) }, friction, drive, material }
        };
        let walls = vec![
            plane([0.0; 3], [0.0, 0.0, 1.0], 0.3, Drive::Fixed, None),
            plane([0.0, 0.002, 0.0], [0.1, 1.0, -0.2], 0.5, Drive::Fixed, Some(1)),
            plane([0.001, 0.0, 0.0], [1.0, 0.0, 0.0], 0.2, Drive::Velocity(0.4), None),
        ];
        Scene { physics, balls, walls }
    }

    /// The same grains inside of an upright cylinder that becomes narrower.
    fn in_a_cylinder(law: ContactLaw) -> Scene {
        let mut scene = Scene::thrown(law, TangentialUnloading::Keep, 0.1);
        for ball in &mut scene.balls {
            ball.at[0] -= 0.028;
            ball.at[1] -= 0.029;
        }
        scene.walls.truncate(1);
        let shape = WallShape::Cylinder { centre: [0.0; 2], radius: 0.034 };
        scene.walls.push(WallSpec { shape, friction: 0.6, drive: Drive::Velocity(0.3), material: None });
        scene
    }

    pub fn changed(&self, change: &Change) -> Scene {
        let mut scene = self.clone();
        let physics = &mut scene.physics;
        let parameters = physics.contact.law.table().parameters;
        physics.materials = physics.materials.iter().map(|m| change.material(m, parameters)).collect();
        physics.gravity = change.vector(physics.gravity, ACCELERATION);
        for ball in &mut scene.balls {
            ball.at = change.vector(ball.at, LENGTH);
            ball.radius = change.scalar(ball.radius, LENGTH);
            ball.velocity = change.vector(ball.velocity, VELOCITY);
            ball.spin = change.axial(ball.spin, SPIN);
        }
        for wall in &mut scene.walls {
            wall.shape = match wall.shape {
                WallShape::Plane { point, normal } => {
                    WallShape::Plane { point: change.vector(point, LENGTH), normal: change.vector(normal, [0; 3]) }
                }
                WallShape::Cylinder { centre: [x, y], radius } => {
                    let [x, y, _] = change.vector([x, y, 0.0], LENGTH);
                    WallShape::Cylinder { centre: [x, y], radius: change.scalar(radius, LENGTH) }
                }
            };
            if let Drive::Velocity(v) = &mut wall.drive {
                *v = change.scalar(*v, VELOCITY);
            }
        }
        scene
    }

    /// A state at its start whose grains are entered in this order.
    pub fn start(&self, order: &[usize]) -> State {
        let mut grains = Grains::default();
        for &k in order {
            let ball = &self.balls[k];
            let i = grains.add(ball.at, ball.radius, ball.material, &self.physics.materials);
            grains.vel[i][..3].copy_from_slice(&ball.velocity);
            grains.spin[i][..3].copy_from_slice(&ball.spin);
        }
        State::new(&self.physics, grains, self.walls.iter().map(Wall::new).collect(), true)
    }

    fn run(&self, steps: usize) -> Outcome {
        self.run_in(&(0..self.balls.len()).collect::<Vec<_>>(), steps)
    }

    fn run_in(&self, order: &[usize], steps: usize) -> Outcome {
        let mut state = self.start(order);
        let mut work = Workspace::new(&self.physics, &mut state);
        let mut pushed = vec![[0.0]; self.walls.len()];
        for _ in 0..steps {
            let Ok(()) = step(&self.physics, &mut state, &mut work, |state, _| -> Result<(), Infallible> {
                pushed.iter_mut().zip(&state.walls).for_each(|(sum, w)| sum[0] += w.reaction);
                Ok(())
            });
        }
        let (g, by_id) = (&state.grains, state.grains.by_id());
        let mut place = vec![0; order.len()];
        order.iter().zip(by_id).for_each(|(&k, i)| place[k] = i as usize);
        let lead = |v: &[[f64; 4]]| place.iter().map(|&i| [v[i][0], v[i][1], v[i][2]]).collect::<Vec<_>>();
        let works = place.iter().map(|&i| g.work[i]).collect();
        Outcome { positions: lead(&g.pos), velocities: lead(&g.vel), spins: lead(&g.spin), works, pushed, time: state.time }
    }
}

impl Outcome {
    fn changed(&self, change: &Change) -> Outcome {
        Outcome {
            positions: self.positions.iter().map(|v| change.vector(*v, LENGTH)).collect(),
            velocities: self.velocities.iter().map(|v| change.vector(*v, VELOCITY)).collect(),
            spins: self.spins.iter().map(|v| change.axial(*v, SPIN)).collect(),
            works: self.works.iter().map(|w| w.map(|x| change.scalar(x, ENERGY))).collect(),
            pushed: self.pushed.iter().map(|w| w.map(|x| change.scalar(x, FORCE))).collect(),
            time: change.scalar(self.time, TIME),
        }
    }
}

/// Checks two results; `works` only where each contact is counted at the same grain.
#[track_caller]
fn check(what: &str, found: &Outcome, expected: &Outcome, within: Within, works: bool) {
    same(&format!("{what}: position"), &found.positions, &expected.positions, within);
    same(&format!("{what}: velocity"), &found.velocities, &expected.velocities, within);
    same(&format!("{what}: spin"), &found.spins, &expected.spins, within);
    same(&format!("{what}: force on a wall"), &found.pushed, &expected.pushed, within);
    same(&format!("{what}: time"), &[[found.time]], &[[expected.time]], within);
    if works {
        same(&format!("{what}: work"), &found.works, &expected.works, within);
    }
}

/// Steps in which all grains meet others or walls, some of them several times.
const STEPS: usize = 1500;
/// Rounding, a unit in the 16th digit, grows in every impact by the change of the direction of its normal: by up to ten thousand times here.
const ROUNDING: Within = Within::Share(1e-10);

const UNLOADINGS: [TangentialUnloading; 2] = [TangentialUnloading::Keep, TangentialUnloading::Rescale];

fn scenes(damping: f64) -> impl Iterator<Item = (String, Scene)> {
    let of = move |law: ContactLaw| UNLOADINGS.map(|u| (format!("{} {u:?}", law.word()), Scene::thrown(law, u, damping)));
    ContactLaw::ALL.iter().copied().flat_map(of)
}

fn cylinders() -> impl Iterator<Item = (String, Scene)> {
    ContactLaw::ALL.iter().map(|&law| (format!("{} in a cylinder", law.word()), Scene::in_a_cylinder(law)))
}

/// Checks that the scenes of this file are worth it: every grain has met something, slid and lost energy.
#[test]
fn every_grain_meets_something() {
    for (what, scene) in scenes(0.1).chain(cylinders()) {
        let end = scene.run(STEPS);
        let free: Vec<_> = scene.balls.iter().map(|b| b.velocity).collect();
        let met = end.velocities.iter().zip(free).filter(|(v, free)| (0..3).any(|a| (v[a] - free[a]).abs() > 0.3)).count();
        assert!(met == scene.balls.len(), "{what}: {met}");
        assert!(end.pushed.iter().all(|w| w[0] > 0.0), "{what}: {:?}", end.pushed);
        let slip: f64 = end.works.iter().map(|w| w[1]).sum();
        assert!(slip > 1e-5, "{what}: {slip}");
    }
}

/// Mirrors a scene: the motion is mirrored, to the bit, as only signs of numbers change.
#[test]
fn a_mirrored_scene_has_the_mirrored_motion() {
    for (what, scene) in scenes(0.1) {
        let here = scene.run(STEPS);
        for axis in 0..3 {
            let mirror = Change::mirror(axis);
            check(&format!("{what}, {axis}"), &scene.changed(&mirror).run(STEPS), &here.changed(&mirror), Within::Nothing, true);
        }
    }
    for (what, scene) in cylinders() {
        let mirror = Change::mirror(0);
        check(&what, &scene.changed(&mirror).run(STEPS), &scene.run(STEPS).changed(&mirror), Within::Nothing, true);
    }
}

/// Turns a scene by a quarter about an axis. Local damping acts along the axes, so that this is the only turn that it allows.
#[test]
fn a_scene_turned_by_a_quarter_has_the_turned_motion() {
    for (what, scene) in scenes(0.1) {
        let here = scene.run(STEPS);
        for axis in 0..3 {
            let turn = Change::quarter(axis);
            check(&format!("{what}, {axis}"), &scene.changed(&turn).run(STEPS), &here.changed(&turn), ROUNDING, true);
        }
    }
    for (what, scene) in cylinders() {
        let turn = Change::quarter(2);
        check(&what, &scene.changed(&turn).run(STEPS), &scene.run(STEPS).changed(&turn), ROUNDING, true);
    }
}

/// Turns a scene without local damping by any angle.
#[test]
fn a_turned_scene_has_the_turned_motion() {
    let turn = Change::turned([0.6, -0.3, 0.5, 0.2]);
    for (what, scene) in scenes(0.0) {
        check(&what, &scene.changed(&turn).run(STEPS), &scene.run(STEPS).changed(&turn), ROUNDING, true);
    }
}

/// Changes the units of length, time and mass: only the exponents of numbers change, so the results are the same to the bit, and no constant of the
/// program has a hidden unit.
#[test]
fn other_units_change_the_units_of_the_motion() {
    for (what, scene) in scenes(0.1).chain(cylinders()) {
        let units = Change::UNITS;
        check(&what, &scene.changed(&units).run(STEPS), &scene.run(STEPS).changed(&units), Within::Nothing, true);
    }
}

/// Enters the grains in another order: each moves as before. Sums over contacts are then made in another order; which end a contact's work is counted
/// at changes.
#[test]
fn the_order_of_grains_does_not_matter() {
    let order = [4, 7, 1, 0, 8, 2, 6, 5, 3];
    for (what, scene) in scenes(0.1).chain(cylinders()) {
        check(&what, &scene.run_in(&order, STEPS), &scene.run(STEPS), ROUNDING, false);
    }
}
