//! Grains that fall onto a bed of points.

use crate::change::{Change, LENGTH, SPIN, VELOCITY, Within, same};
use crate::continuum::{self, Block, check, outcome, thrown};
use crate::grains::{Ball, Scene, materials};
use crate::laws::laws;
use comminute::boundary::{Drive, WallShape, WallSpec};
use comminute::coupling::{Cycle, Mixture, Parts, Rates};
use comminute::mpm::{Dimension, ShapeFunctions, Transfer};
use comminute::point_contacts::PointContactTable;
use comminute::{ContactLaw, Physics, Workspace};

/// Grains, points, and how many steps each makes in a cycle.
struct Mixed {
    grains: Scene,
    block: Block,
    rates: Rates,
}

/// What a mixture has come to.
struct Outcome {
    /// Position, velocity and spin of each grain.
    grains: [Vec<[f64; 3]>; 3],
    points: continuum::Outcome,
}

/// Three grains on and beside a block of points, with a wall that grains and points touch.
fn mixed(law: ContactLaw, continuum_law: usize, rates: [u32; 2]) -> Mixed {
    let mut physics = Physics::of(materials(law, 1e6), law);
    physics.gravity = [0.5, -9.81, -2.0];
    let method = (ShapeFunctions::BSpline, if continuum_law == 1 { Transfer::Affine } else { Transfer::Blend { pic: 0.0 } });
    let block = thrown(Dimension::Space, laws().swap_remove(continuum_law), method);
    let ball = |at, radius, velocity, spin, material| Ball { at, radius, velocity, spin, material };
    let balls = vec![
        ball([-0.7, -0.13, -0.3], 0.15, [0.3, -3.0, 0.4], [4.0, -2.0, 9.0], 0),
        ball([-0.44, -0.15, -0.25], 0.1, [-0.5, -2.5, 0.1], [0.0, 5.0, -3.0], 1),
        ball([-0.24, -0.58, -0.31], 0.12, [-3.5, 0.2, 0.3], [1.0, 0.0, 2.0], 0),
    ];
    let shape = WallShape::Plane { point: [0.0, -0.72, 0.0], normal: [0.0, 1.0, 0.0] };
    let walls = vec![WallSpec { shape, friction: 0.4, drive: Drive::Fixed, material: None }];
    let [grains, continuum] = rates;
    Mixed { grains: Scene { physics, balls, walls }, block, rates: Rates { grains, continuum } }
}

impl Mixed {
    fn changed(&self, change: &Change) -> Mixed {
        Mixed { grains: self.grains.changed(change), block: self.block.changed(change), rates: self.rates }
    }

    fn orders(&self) -> [Vec<usize>; 2] {
        [self.grains.balls.len(), self.block.points.len()].map(|n| (0..n).collect())
    }

    fn run(&self, cycles: u64) -> Outcome {
        self.run_in(&self.orders(), cycles)
    }

    fn run_in(&self, [grains, points]: &[Vec<usize>; 2], cycles: u64) -> Outcome {
        let physics = &self.grains.physics;
        let mut state = self.grains.start(grains);
        let mut work = Workspace::new(physics, &mut state);
        let mut continuum = self.block.continuum(points);
        // points are small grains of the second material
        let table = PointContactTable::new(physics.contact.law, &[1], &physics.materials, &state.walls);
        let mut mixture = Mixture::new(physics, state, &mut continuum, None);
        let cycle = Cycle { time: continuum.stable_step(0.25), rates: self.rates };
        for _ in 0..cycles {
            let mut parts = Parts { physics, table: &table, work: &mut work, continuum: &mut continuum, plates: &mut [] };
            mixture.compute_forces(&mut parts).unwrap_or_else(|e| panic!("{e}"));
            mixture.make_cycle(&mut parts, cycle).unwrap_or_else(|e| panic!("{e}"));
        }
        let g = &mixture.grains.grains;
        let mut place = vec![0; grains.len()];
        grains.iter().zip(g.by_id()).for_each(|(&k, i)| place[k] = i as usize);
        let of = |v: &[[f64; 4]]| place.iter().map(|&i| [v[i][0], v[i][1], v[i][2]]).collect::<Vec<_>>();
        Outcome { grains: [of(&g.pos), of(&g.vel), of(&g.spin)], points: outcome(&continuum, points) }
    }
}

#[track_caller]
fn compare(what: &str, found: &Outcome, expected: &Outcome, change: &Change, within: Within) {
    let [positions, velocities, spins] = &expected.grains;
    let of = |v: &[[f64; 3]], unit| v.iter().map(|v| change.vector(*v, unit)).collect::<Vec<_>>();
    same(&format!("{what}: grains"), &found.grains[0], &of(positions, LENGTH), within);
    same(&format!("{what}: velocity of grains"), &found.grains[1], &of(velocities, VELOCITY), within);
    let spins: Vec<_> = spins.iter().map(|w| change.axial(*w, SPIN)).collect();
    same(&format!("{what}: spin of grains"), &found.grains[2], &spins, within);
    check(what, &found.points, &expected.points.changed(change, crate::change::VOLUME), within);
}

const CYCLES: u64 = 100;
/// Shape functions are rounded differently in a mirrored grid, and contacts carry that from points to grains and back.
const ROUNDING: Within = Within::Share(1e-9);

/// One contact law after the other, with a law of the continuum and numbers of steps that differ.
fn mixtures() -> impl Iterator<Item = (String, Mixed)> {
    ContactLaw::ALL.iter().enumerate().map(|(k, &law)| {
        let (continuum_law, rates) = (k % 3, [[1, 1], [4, 1], [1, 3]][(k + k / 3) % 3]);
        (format!("{} {continuum_law} {rates:?}", law.word()), mixed(law, continuum_law, rates))
    })
}

/// Checks that the mixtures are worth it: points slow all grains down and turn them.
#[test]
fn grains_meet_points() {
    for (what, mixed) in mixtures() {
        let [_, velocities, spins] = mixed.run(CYCLES).grains;
        for (k, ball) in mixed.grains.balls.iter().enumerate() {
            let change = (0..3).map(|a| (velocities[k][a] - ball.velocity[a]).abs()).fold(0.0, f64::max);
            let turn = (0..3).map(|a| (spins[k][a] - ball.spin[a]).abs()).fold(0.0, f64::max);
            assert!(change > 0.1 && turn > 0.02, "{what}: {k} {change} {turn}");
        }
    }
}

/// Mirrors a mixture.
#[test]
fn a_mirrored_mixture_has_the_mirrored_motion() {
    for (what, mixed) in mixtures() {
        let here = mixed.run(CYCLES);
        for axis in 0..3 {
            let mirror = Change::mirror(axis);
            compare(&format!("{what}, {axis}"), &mixed.changed(&mirror).run(CYCLES), &here, &mirror, ROUNDING);
        }
    }
}

/// Turns a mixture by a quarter.
#[test]
fn a_mixture_turned_by_a_quarter_has_the_turned_motion() {
    for (what, mixed) in mixtures() {
        let turn = Change::quarter(1);
        compare(&what, &mixed.changed(&turn).run(CYCLES), &mixed.run(CYCLES), &turn, ROUNDING);
    }
}

/// Enters grains and points in another order.
#[test]
fn the_order_of_grains_and_points_does_not_matter() {
    for (what, mixed) in mixtures() {
        let n = mixed.block.points.len();
        let orders = [vec![2, 0, 1], (0..n).map(|i| i * 7919 % n).collect()];
        compare(&what, &mixed.run_in(&orders, CYCLES), &mixed.run(CYCLES), &Change::NOTHING, ROUNDING);
    }
}

/// Changes units, to the bit.
#[test]
fn other_units_change_the_units_of_a_mixture() {
    for (what, mixed) in mixtures() {
        compare(&what, &mixed.changed(&Change::UNITS).run(CYCLES), &mixed.run(CYCLES), &Change::UNITS, Within::Nothing);
    }
}
