//! Bodies that are moved, pushed or held from outside.
//!
//! A body may follow a *path*, a table of times, places and angles about one axis, with straight lines between the rows. Its velocity in a step is the way of that step over its time, so the body is
//! where the table says after every step, however long. A body may be *pushed* by a force and a torque that act on its centre of mass, in shares that follow a table of times. It may be *held*: in
//! single directions, and in its rotation, it keeps the velocity that it started with.
//!
//! The works are kept: that of a push by the path, ½ (F(t) + F(t + Δt)) Δx, and that of what drives or holds a body by what its kinetic energy gains less the work of all other forces on it,
//! each at the mean of the velocities before and after.

use super::motion::{about, product};
use super::{Block, Blocks, Joint};
use crate::check::{self, Checked, ensure};
use crate::math::vector::{dot, less, plus, scaled};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The two rows of a table between which a time lies. Before the first row both are the first, after the last both are the last.
struct Rows {
    from: usize,
    to: usize,
    /// Share of the time from the one to the other that has passed.
    share: f64,
}

impl Rows {
    /// Of a table with rising times, s.
    fn at(times: &[f64], time: f64) -> Rows {
        let next = times.partition_point(|t| *t <= time);
        if next == 0 || next == times.len() {
            let k = next.saturating_sub(1);
            return Rows { from: k, to: k, share: 0.0 };
        }
        Rows { from: next - 1, to: next, share: (time - times[next - 1]) / (times[next] - times[next - 1]) }
    }

    fn between(&self, a: f64, b: f64) -> f64 {
        a + self.share * (b - a)
    }

    /// The value there of a column.
    fn value(&self, column: &[f64]) -> f64 {
        self.between(column[self.from], column[self.to])
    }
}

/// Places and angles of a body against time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Path {
    /// Times, s, each later than the one before. Before the first and after the last the body stands.
    pub times: Vec<f64>,
    /// Place of the centre of mass at each time, m.
    pub places: Vec<[f64; 3]>,
    /// Angle by which the body is turned about `axis` at each time, rad.
    pub angles: Vec<f64>,
    /// Unit vector through the centre of mass about which it turns.
    pub axis: [f64; 3],
    /// Orientation at the angle zero.
    pub turn: [f64; 4],
}

impl Path {
    /// Place, m, and angle, rad, at time `time`, s.
    pub fn at(&self, time: f64) -> ([f64; 3], f64) {
        let rows = Rows::at(&self.times, time);
        let (from, to) = (self.places[rows.from], self.places[rows.to]);
        (std::array::from_fn(|a| rows.between(from[a], to[a])), rows.value(&self.angles))
    }

    /// Velocity, m/s, and spin, rad/s, with which it begins.
    pub fn first_motion(&self) -> [[f64; 3]; 2] {
        if self.times.len() < 2 || self.times[0] > 0.0 {
            return [[0.0; 3]; 2];
        }
        let rate = 1.0 / (self.times[1] - self.times[0]);
        [scaled(less(self.places[1], self.places[0]), rate), scaled(self.axis, (self.angles[1] - self.angles[0]) * rate)]
    }

    /// Orientation at an angle, rad.
    fn orientation(&self, angle: f64) -> [f64; 4] {
        product(about(self.axis, angle - TAU * (angle / TAU).round()), self.turn)
    }
}

/// A force and a torque on a body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Push {
    /// Force on the centre of mass, N; in plane strain per metre of depth.
    pub force: [f64; 3],
    /// Torque, N m.
    pub torque: [f64; 3],
    /// Times of the rows of a table, s, each later than the one before; none: both act fully at all times.
    pub times: Vec<f64>,
    /// Share of both that acts at each time, with straight lines between; before the first and after the last row it stays.
    pub shares: Vec<f64>,
}

impl Push {
    /// Force, N, and torque, N m, at time `time`, s.
    pub fn at(&self, time: f64) -> [[f64; 3]; 2] {
        let share = if self.times.is_empty() { 1.0 } else { Rows::at(&self.times, time).value(&self.shares) };
        [self.force, self.torque].map(|v| scaled(v, share))
    }
}

/// What is done to a body from outside; by default nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Programme {
    /// Path that a driven body follows.
    pub path: Option<Path>,
    /// What pushes it.
    pub push: Push,
    /// Directions in which it keeps its velocity.
    pub held: [bool; 3],
    /// Whether it keeps its angular momentum.
    pub held_turn: bool,
}

impl Programme {
    /// Whether it leaves a body alone.
    pub fn is_none(&self) -> bool {
        *self == Programme::default()
    }

    /// What it does to a body, for a reader, as the end of a line; empty where it leaves the body alone.
    pub fn in_words(&self) -> String {
        let mut text = String::new();
        if let Some(path) = &self.path {
            text += &format!(", on a path of {} rows until {} s", path.times.len(), path.times[path.times.len() - 1]);
        }
        let Push { force, torque, .. } = &self.push;
        for (of, unit) in [(force, "N"), (torque, "N m")] {
            if *of != [0.0; 3] {
                text += &format!(", pushed by {of:?} {unit}");
            }
        }
        let held = [(self.held[0], "x"), (self.held[1], "y"), (self.held[2], "z"), (self.held_turn, "rotation")];
        let held: Vec<&str> = held.into_iter().filter(|(held, _)| *held).map(|(_, word)| word).collect();
        if !held.is_empty() {
            text += &format!(", held in {}", held.join(", "));
        }
        text
    }
}

/// A programme and the work done by it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Drive {
    /// What is done to the body.
    pub programme: Programme,
    /// Work of the push, J.
    pub of_push: f64,
    /// Work of what drives or holds the body, J.
    pub of_hold: f64,
}

impl Drive {
    /// Moves a body by one step, as [`Block::advance`]. `force` and `torque` hold what pushes it; `time`: at the beginning of the step, s.
    pub(super) fn advance(&mut self, block: &mut Block, [force, torque]: [[f64; 3]; 2], time: f64, kick: f64, dt: f64) {
        let Programme { path, push, held, held_turn } = &self.programme;
        let (kinetic, velocity, spin, centre) = (block.kinetic(), block.velocity, block.spin(), block.centre);
        let (mut gained, mut kicked_spin) = (0.0, spin);
        if let Some(path) = path {
            let ((_, before), (place, angle)) = (path.at(time), path.at(time + dt));
            block.velocity = scaled(less(place, block.centre), 1.0 / dt);
            (block.centre, block.turn) = (place, path.orientation(angle));
            kicked_spin = scaled(path.axis, (angle - before) / dt);
            block.set_spin(kicked_spin);
            gained = block.kinetic() - kinetic;
        } else {
            if !block.driven {
                for a in (0..3).filter(|&a| !held[a]) {
                    block.velocity[a] += force[a] * (kick / block.mass);
                }
                if !held_turn {
                    block.momentum = plus(block.momentum, scaled(torque, kick));
                }
                kicked_spin = block.spin();
                gained = block.kinetic() - kinetic;
            }
            block.drift(dt);
        }
        if block.driven || *held_turn || held.contains(&true) {
            let [mean, mean_spin] =
                [plus(velocity, block.velocity), plus(spin, kicked_spin)].map(|twice| scaled(twice, 0.5 * kick));
            self.of_hold += gained - dot(force, mean) - dot(torque, mean_spin);
        }
        if push.force != [0.0; 3] || push.torque != [0.0; 3] {
            let [start, end] = [push.at(time), push.at(time + dt)];
            let [f, m] = [0, 1].map(|k| scaled(plus(start[k], end[k]), 0.5));
            self.of_push += dot(f, less(block.centre, centre)) + dot(m, kicked_spin) * dt;
        }
    }
}

/// What is done to bodies from outside, and the joints between them: what a restart needs.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Drives {
    /// Of each body, by its index.
    pub bodies: Vec<Drive>,
    /// The joints.
    pub joints: Vec<Joint>,
    /// Pairs of bodies whose joint has broken and whose contacts begin without force at the next search.
    pub(super) parted: Vec<[u32; 2]>,
}

impl Drives {
    /// Checks what a checkpoint says of them against what the same run `made`.
    pub(super) fn check(&self, made: &Drives) -> Checked {
        check::lengths("driven bodies", made.bodies.len(), [self.bodies.len()])?;
        check::lengths("joints", made.joints.len(), [self.joints.len()])?;
        let same = self.bodies.iter().zip(&made.bodies).all(|(a, b)| a.programme == b.programme);
        ensure(same, || "rigid bodies are driven in another way than in the scene".into())?;
        check::numbers("works on rigid bodies", self.bodies.iter().flat_map(|drive| [drive.of_push, drive.of_hold]))?;
        self.parted.iter().flatten().try_for_each(|&k| check::below("body of a broken joint", k, made.bodies.len()))?;
        self.joints.iter().zip(&made.joints).try_for_each(|(joint, made)| joint.check(made))
    }

    /// Pairs of bodies that a joint holds, the lower index first, sorted.
    pub(super) fn joined(&self) -> Vec<[u32; 2]> {
        let pair = |joint: &Joint| joint.bond.second.map(|b| [joint.bond.first.min(b), joint.bond.first.max(b)]);
        let mut pairs: Vec<[u32; 2]> = self.joints.iter().filter(|joint| joint.broken.is_none()).filter_map(pair).collect();
        pairs.sort_unstable();
        pairs
    }
}

impl Blocks {
    /// Lets bodies be driven, pushed, held and joined: a programme for each body by its index, and the joints. The works are kept where there are such programmes or joints, and where
    /// bodies are driven that move; of those that stand nobody asks.
    pub fn with_drives(self, programmes: Vec<Programme>, joints: Vec<Joint>) -> Blocks {
        let moves = |b: &Block| b.driven && (b.velocity != [0.0; 3] || b.momentum != [0.0; 3]);
        if joints.is_empty() && programmes.iter().all(Programme::is_none) && !self.blocks.iter().any(moves) {
            return self;
        }
        let bodies = programmes.into_iter().map(|programme| Drive { programme, ..Drive::default() }).collect();
        Blocks { drives: Some(Box::new(Drives { bodies, joints, parted: Vec::new() })), ..self }
    }

    /// What is done to the bodies from outside, and their joints; `None`: nothing, and none.
    pub fn drives(&self) -> Option<&Drives> {
        self.drives.as_deref()
    }

    /// What is done to body `block` from outside; `None`: nothing, as to all pieces of bodies that broke.
    pub fn drive(&self, block: usize) -> Option<&Drive> {
        self.drives.as_ref()?.bodies.get(block)
    }

    /// Lets the driven body `block` move at a velocity, m/s, and a spin, rad/s, from the next step on; a path that it followed ends. What the body gains is work of what drives it, which is kept
    /// from now on. A body that is not driven goes its way.
    pub fn drive_at(&mut self, block: usize, velocity: [f64; 3], spin: [f64; 3]) {
        let Blocks { blocks, drives, .. } = self;
        let count = blocks.len();
        let body = &mut blocks[block];
        if !body.driven {
            return;
        }
        let before = body.kinetic();
        body.velocity = velocity;
        body.set_spin(spin);
        let drives = drives.get_or_insert_with(|| Box::new(Drives { bodies: vec![Drive::default(); count], ..Drives::default() }));
        if let Some(drive) = drives.bodies.get_mut(block) {
            drive.programme.path = None;
            drive.of_hold += body.kinetic() - before;
        }
    }

    /// Work of all that drives, holds and pushes bodies, J; `None`: nothing does.
    pub fn given(&self) -> Option<f64> {
        self.drives.as_ref().map(|drives| drives.bodies.iter().map(|drive| drive.of_push + drive.of_hold).sum())
    }

    /// Force, N, at time `time`, s, of what pushes body `block`, and in the directions in which it is driven or held of what does so: the opposite of all other forces on it. What changes the velocity
    /// of a body on a path comes on top of that.
    pub fn outer_force(&self, block: usize, gravity: [f64; 3], time: f64) -> [f64; 3] {
        let Some(drive) = self.drive(block) else { return [0.0; 3] };
        let (body, [push, _]) = (&self.blocks[block], drive.programme.push.at(time));
        let weight = scaled(gravity, body.mass);
        let others = self.forces(block).into_iter().fold(plus(weight, self.joint_force(block)), plus);
        std::array::from_fn(|a| if body.driven || drive.programme.held[a] { -others[a] } else { push[a] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rigid::motion::axes;
    use crate::shape::{Cuboid, Shape};

    fn cube() -> Block {
        Block::new(Shape::Box(Cuboid { half: [0.05; 3] }), 2000.0, 0)
    }

    fn path() -> Path {
        let places = vec![[0.0; 3], [0.1, 0.0, -0.02], [0.1, 0.3, -0.02], [0.0, 0.3, 0.0]];
        Path {
            times: vec![0.0, 0.5, 0.7, 2.0],
            places,
            angles: vec![0.0, 1.0, -9.0, 4.0],
            axis: [0.0, 0.6, 0.8],
            turn: [1.0, 0.0, 0.0, 0.0],
        }
    }

    /// Steps of any lengths: places are those of the table to the bit, velocities the way over the time, the orientation is that of the angle.
    #[test]
    fn a_path_is_followed_to_rounding_at_any_step() {
        let path = path();
        for dt in [1e-4, 0.013, 0.31] {
            let mut block = cube();
            block.driven = true;
            let mut drive = Drive { programme: Programme { path: Some(path.clone()), ..Programme::default() }, ..Drive::default() };
            let mut time = 0.0;
            while time < 2.5 {
                let before = block.centre;
                drive.advance(&mut block, [[1.0, 2.0, 3.0], [0.0; 3]], time, dt, dt);
                time += dt;
                let (place, angle) = path.at(time);
                assert_eq!(block.centre, place);
                assert!((0..3).all(|a| (block.velocity[a] * dt - (place[a] - before[a])).abs() < 1e-16));
                let [_, y, _] = axes(block.turn);
                // y turned about (0, 0.6, 0.8): cos + (1 − cos) 0.36
                assert!((y[1] - (angle.cos() + 0.36 * (1.0 - angle.cos()))).abs() < 1e-14, "{angle}");
            }
            assert_eq!(block.centre, [0.0, 0.3, 0.0]);
        }
    }

    /// A path with a corner takes and gives kinetic energy and the work against the force on the body, and nothing else.
    #[test]
    fn what_drives_a_body_gives_its_motion_and_the_work_against_other_forces() {
        let mut block = cube();
        block.driven = true;
        let path = Path { angles: vec![0.0; 4], ..path() };
        [block.velocity, _] = path.first_motion();
        let start = block.kinetic();
        let mut drive = Drive { programme: Programme { path: Some(path), ..Programme::default() }, ..Drive::default() };
        let (force, dt) = ([3.0, -2.0, 5.0], 1e-3);
        for k in 0..1900 {
            drive.advance(&mut block, [force, [0.0; 3]], f64::from(k) * dt, dt, dt);
        }
        // the force acts on the mean of two steps, so half a step is missing at the end
        let expected = block.kinetic() - start - dot(force, block.centre);
        assert!((drive.of_hold / expected - 1.0).abs() < 1e-3, "{} {expected}", drive.of_hold);
    }

    /// A body that is held along x and in its turn falls along z alone; the push has done its force times its way.
    #[test]
    fn a_held_body_moves_where_it_may() {
        let mut block = cube();
        block.velocity = [0.5, 0.0, 0.0];
        let push = Push { force: [10.0, 0.0, -20.0], torque: [1.0; 3], times: vec![0.0, 0.5], shares: vec![0.0, 1.0] };
        let programme = Programme { push: push.clone(), held: [true, true, false], held_turn: true, path: None };
        let mut drive = Drive { programme, ..Drive::default() };
        let (dt, steps) = (1e-4, 10_000);
        for k in 0..steps {
            let time = f64::from(k) * dt;
            drive.advance(&mut block, push.at(time), time, if k == 0 { 0.5 * dt } else { dt }, dt);
        }
        // a = 20 N/m: t³/6 over the ramp, then with what it has
        let (a, t1, t2) = (20.0 / (block.mass * 0.5), 0.5_f64, 0.5);
        let way = -(a * t1.powi(3) / 6.0 + a * t1 * t1 / 2.0 * t2 + 0.5 * a * t1 * t2 * t2);
        assert!((block.centre[2] / way - 1.0).abs() < 1e-6, "{} {way}", block.centre[2]);
        assert!((block.centre[0] - 0.5).abs() < 1e-12 && block.centre[1] == 0.0 && block.momentum == [0.0; 3]);
        // along z it has become motion, along x what holds the body takes what the push gives
        let along_x = 10.0 * 0.5 * (0.75 * 1.0);
        let given = drive.of_push;
        assert!((given - along_x - 0.5 * block.mass * block.velocity[2].powi(2)).abs() < 2e-3 * given, "{given}");
        assert!((drive.of_hold + along_x).abs() < 2e-3 * given, "{} {along_x}", drive.of_hold);
    }

    /// A driven body leaves its path for the velocity that it is told, and the work that is kept is its kinetic energy; one that is free does not obey.
    #[test]
    fn a_driven_body_obeys_from_the_next_step_on() {
        let mut driven = cube();
        driven.driven = true;
        let programme = Programme { path: Some(Path { angles: vec![0.0; 4], ..path() }), ..Programme::default() };
        let on_a_path = Blocks::new(vec![driven.clone(), cube()]).with_drives(vec![programme, Programme::default()], Vec::new());
        for mut blocks in [on_a_path, Blocks::new(vec![driven, cube()])] {
            for k in 0..2 {
                blocks.drive_at(k, [0.2, 0.0, -0.4], [0.0, 0.0, 3.0]);
            }
            let Blocks { blocks: bodies, drives, .. } = &mut blocks;
            for (body, drive) in bodies.iter_mut().zip(&mut drives.as_mut().expect("works are kept").bodies) {
                drive.advance(body, [[0.0; 3]; 2], 0.0, 0.25, 0.5);
            }
            assert_eq!([blocks.blocks[0].centre, blocks.blocks[1].centre], [[0.1, 0.0, -0.2], [0.0; 3]]);
            let (spin, kinetic) = (blocks.blocks[0].spin(), blocks.blocks[0].kinetic());
            assert!((spin[2] - 3.0).abs() < 1e-14 && kinetic > 0.0);
            assert_eq!(blocks.given(), Some(kinetic));
        }
    }
}
