//! Blocks of points that are thrown against the walls of a grid.

use crate::change::{ACCELERATION, Change, DENSITY, FORCE, LENGTH, STRESS, VELOCITY, VOLUME, Within, same};
use crate::laws::{changed as changed_law, laws};
use comminute::math::vector::plus;
use comminute::mpm::law::{Law, Sym};
use comminute::mpm::{Continuum, Dimension, GridWall, Point, Points, Settings, ShapeFunctions, Transfer};

/// A grid with its points.
#[derive(Clone)]
pub struct Block {
    pub settings: Settings,
    pub law: Law,
    pub points: Vec<Point>,
}

/// What a block has come to, points in the order in which they were given.
#[derive(Default)]
pub struct Outcome {
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    stresses: Vec<Sym>,
    volumes: Vec<[f64; 1]>,
    plastic: Vec<[f64; 1]>,
    walls: Vec<[f64; 3]>,
}

const METHODS: [(ShapeFunctions, Transfer); 3] = [
    (ShapeFunctions::BSpline, Transfer::Blend { pic: 0.05 }),
    (ShapeFunctions::BSpline, Transfer::Affine),
    (ShapeFunctions::Gimp { half_width: 0.25 }, Transfer::Blend { pic: 0.0 }),
];

/// A block without symmetry that flies into the low corner of a grid around the origin.
pub fn thrown(dimension: Dimension, law: Law, (shape, transfer): (ShapeFunctions, Transfer)) -> Block {
    let cell = 0.125;
    let settings = Settings {
        dimension,
        cell,
        lower: [-1.0, -0.75, -0.5],
        cells: [16, 12, 8],
        walls: [
            GridWall::Stick,
            GridWall::Open,
            GridWall::Friction { friction: 0.3 },
            GridWall::Symmetry,
            GridWall::Symmetry,
            GridWall::Open,
        ],
        gravity: [0.5, -9.81, if dimension == Dimension::Space { -2.0 } else { 0.0 }],
        shape,
        transfer,
        damping: 0.05,
    };
    let space = dimension == Dimension::Space;
    let (h, volume) = if space { (0.0625, 0.0625f64.powi(3)) } else { (0.0625, 0.0625f64.powi(2)) };
    let mut points = Vec::new();
    for n in 0..(10 * 8 * if space { 6 } else { 1 }) {
        let (i, j, k) = (n % 10, n / 10 % 8, n / 80);
        if 2 * i + 3 * j + k > 30 {
            continue;
        }
        let at = |a: usize, i: i32| settings.lower[a] + (f64::from(i) + 0.5) * h;
        points.push(Point {
            position: [at(0, i), at(1, j), if space { at(2, k) } else { 0.0 }],
            velocity: [-1.5 + 0.2 * f64::from(j), -2.0 + 0.1 * f64::from(k), if space { -0.6 + 0.1 * f64::from(i) } else { 0.0 }],
            mass: 1800.0 * volume,
            volume,
            stress: [-500.0, -700.0, -600.0, 50.0, 0.0, 0.0],
            porosity: 0.4,
            law: 0,
        });
    }
    Block { settings, law, points }
}

impl Block {
    /// The block in a corner of three walls with friction.
    pub fn among_friction(mut self) -> Block {
        for (k, friction) in [0.3, 0.2, 0.1].into_iter().enumerate() {
            self.settings.walls[2 * k] = GridWall::Friction { friction };
        }
        self
    }

    /// The block in another frame, whose axes are those of the grid up to order and sign, or in other units.
    pub fn changed(&self, change: &Change) -> Block {
        let old = &self.settings;
        let mut settings = old.clone();
        settings.cell = change.scalar(old.cell, LENGTH);
        settings.gravity = change.vector(old.gravity, ACCELERATION);
        for (a, row) in change.turn.iter().enumerate() {
            let b = row.iter().position(|x| *x != 0.0).expect("an axis");
            let upper = old.lower[b] + old.cell * f64::from(old.cells[b]);
            let turned = row[b] < 0.0;
            settings.cells[a] = old.cells[b];
            settings.lower[a] = change.scalar(if turned { -upper } else { old.lower[b] }, LENGTH);
            for high in 0..2 {
                settings.walls[2 * a + high] = old.walls[2 * b + if turned { 1 - high } else { high }];
            }
        }
        let point = |p: &Point| Point {
            position: change.vector(p.position, LENGTH),
            velocity: change.vector(p.velocity, VELOCITY),
            mass: self.mass_of(p, change),
            volume: change.scalar(p.volume, self.volume_unit()),
            stress: change.tensor(p.stress, STRESS),
            ..*p
        };
        Block { settings, law: changed_law(&self.law, change), points: self.points.iter().map(point).collect() }
    }

    /// In plane strain volumes and masses are those of a metre.
    fn volume_unit(&self) -> [i32; 3] {
        if self.settings.dimension == Dimension::Space { VOLUME } else { [2, 0, 0] }
    }

    fn mass_of(&self, p: &Point, change: &Change) -> f64 {
        change.scalar(p.mass / p.volume, DENSITY) * change.scalar(p.volume, self.volume_unit())
    }

    pub fn continuum(&self, order: &[usize]) -> Continuum {
        let mut points = Points::default();
        for &k in order {
            points.add(&self.points[k]);
        }
        Continuum::new(self.settings.clone(), vec![self.law.clone()], points).unwrap_or_else(|e| panic!("{e}"))
    }

    fn run(&self, steps: u64) -> Outcome {
        self.run_in(&(0..self.points.len()).collect::<Vec<_>>(), steps)
    }

    fn run_in(&self, order: &[usize], steps: u64) -> Outcome {
        let mut continuum = self.continuum(order);
        // a law that stiffens as it is pressed is soft at the start
        let density = self.points[0].mass / self.points[0].volume;
        let dt = continuum.stable_step(0.4).min(0.4 * self.settings.cell / self.law.wave_speed(density));
        let mut walls = vec![[0.0; 3]; 6];
        for _ in 0..steps {
            continuum.step(dt).unwrap_or_else(|e| panic!("{e}"));
            for (sum, force) in walls.iter_mut().zip(continuum.wall_force()) {
                sum.iter_mut().zip(force).for_each(|(s, f)| *s += f);
            }
        }
        Outcome { walls, ..outcome(&continuum, order) }
    }
}

/// The points of a continuum whose points were given in this order.
pub fn outcome(continuum: &Continuum, order: &[usize]) -> Outcome {
    let p = continuum.points();
    let mut place = vec![0; order.len()];
    order.iter().zip(p.by_id()).for_each(|(&k, i)| place[k] = i as usize);
    let lead = |v: &[[f64; 4]]| place.iter().map(|&i| [v[i][0], v[i][1], v[i][2]]).collect::<Vec<_>>();
    Outcome {
        positions: lead(&p.position),
        velocities: lead(&p.velocity),
        stresses: place.iter().map(|&i| p.stress[i]).collect(),
        volumes: place.iter().map(|&i| [p.position[i][3]]).collect(),
        plastic: place.iter().map(|&i| [p.memory[i].plastic]).collect(),
        walls: Vec::new(),
    }
}

impl Outcome {
    /// With the force of all walls together: a node on an edge is held by both walls, and counts at the one that comes first along x, y and z.
    fn of_all_walls(mut self) -> Outcome {
        let sum = self.walls.iter().fold([0.0; 3], |sum, force| plus(sum, *force));
        self.walls = vec![sum];
        self
    }

    /// `volume`: unit of volumes.
    pub fn changed(&self, change: &Change, volume: [i32; 3]) -> Outcome {
        let mut walls = self.walls.clone();
        for (side, force) in walls.iter_mut().enumerate().filter(|_| !self.walls.is_empty()) {
            let row = change.turn[side / 2];
            let b = row.iter().position(|x| *x != 0.0).expect("an axis");
            let from = 2 * b + if row[b] < 0.0 { 1 - side % 2 } else { side % 2 };
            let unit = if volume == VOLUME { FORCE } else { [0, -2, 1] };
            *force = change.vector(self.walls[from], unit);
        }
        Outcome {
            positions: self.positions.iter().map(|v| change.vector(*v, LENGTH)).collect(),
            velocities: self.velocities.iter().map(|v| change.vector(*v, VELOCITY)).collect(),
            stresses: self.stresses.iter().map(|s| change.tensor(*s, STRESS)).collect(),
            volumes: self.volumes.iter().map(|v| [change.scalar(v[0], volume)]).collect(),
            plastic: self.plastic.clone(),
            walls,
        }
    }
}

#[track_caller]
pub fn check(what: &str, found: &Outcome, expected: &Outcome, within: Within) {
    same(&format!("{what}: position"), &found.positions, &expected.positions, within);
    same(&format!("{what}: velocity"), &found.velocities, &expected.velocities, within);
    same(&format!("{what}: stress"), &found.stresses, &expected.stresses, within);
    same(&format!("{what}: volume"), &found.volumes, &expected.volumes, within);
    same(&format!("{what}: plastic strain"), &found.plastic, &expected.plastic, within);
    same(&format!("{what}: force of a wall"), &found.walls, &expected.walls, within);
}

const STEPS: u64 = 80;
/// A point's place in its cell counts from the lower node, which a mirror or a turn makes another one: shape functions are rounded differently in every step.
const ROUNDING: Within = Within::Share(1e-10);

fn blocks() -> Vec<(String, Block)> {
    let mut all = Vec::new();
    for (k, law) in laws().into_iter().enumerate() {
        for (dimension, method) in [(Dimension::Space, METHODS[k % 3]), (Dimension::PlaneStrain, METHODS[(k + 1) % 3])] {
            all.push((format!("{} {k} {dimension:?} {method:?}", law.word()), thrown(dimension, law.clone(), method)));
        }
    }
    all
}

/// Checks that the blocks are worth it: all walls but the open ones are pressed, and points of laws that yield have yielded.
#[test]
fn blocks_press_and_yield() {
    for (what, block) in blocks() {
        let end = block.run(STEPS);
        assert!(end.walls[0][0] > 0.0 && end.walls[2][1] > 0.0, "{what}: {:?}", end.walls);
        let yielded = end.plastic.iter().filter(|p| p[0].abs() > 1e-4).count();
        assert!((yielded > 20) == (block.law.word() != "elastic"), "{what}: {yielded}");
    }
}

/// Mirrors grid and points.
#[test]
fn a_mirrored_block_has_the_mirrored_motion() {
    for (what, block) in blocks() {
        let here = block.run(STEPS);
        for axis in 0..if block.settings.dimension == Dimension::Space { 3 } else { 2 } {
            let mirror = Change::mirror(axis);
            let there = block.changed(&mirror).run(STEPS);
            check(&format!("{what}, {axis}"), &there, &here.changed(&mirror, block.volume_unit()), ROUNDING);
        }
    }
}

/// Turns grid and points by a quarter about an axis. A wall with friction meets walls that hold, then others with friction: no edge knows the axes' names.
#[test]
fn a_block_turned_by_a_quarter_has_the_turned_motion() {
    for (what, block) in blocks() {
        for (block, rubs) in [(block.clone(), false), (block.among_friction(), true)] {
            let here = block.run(STEPS);
            assert!(here.walls[2][1] > 0.0 && (!rubs || here.walls[2][0] != 0.0), "{what}");
            // a node on an edge of walls that hold counts at one of them; friction is shared
            let walls = |outcome: Outcome| if rubs { outcome } else { outcome.of_all_walls() };
            for axis in if block.settings.dimension == Dimension::Space { 0..3 } else { 2..3 } {
                let turn = Change::quarter(axis);
                let there = walls(block.changed(&turn).run(STEPS));
                let expected = walls(here.changed(&turn, block.volume_unit()));
                check(&format!("{what}, {axis}, {rubs}"), &there, &expected, ROUNDING);
            }
        }
    }
}

/// Changes units, to the bit.
#[test]
fn other_units_change_the_units_of_a_block() {
    for (what, block) in blocks() {
        let there = block.changed(&Change::UNITS).run(STEPS);
        check(&what, &there, &block.run(STEPS).changed(&Change::UNITS, block.volume_unit()), Within::Nothing);
    }
}

/// Enters the points in another order: sums at nodes are then made in another order.
#[test]
fn the_order_of_points_does_not_matter() {
    for (what, block) in blocks() {
        let n = block.points.len();
        // a prime that does not divide the number of points
        let order: Vec<usize> = (0..n).map(|i| i * 7919 % n).collect();
        check(&what, &block.run_in(&order, STEPS), &block.run(STEPS), ROUNDING);
    }
}
