//! Elastic joints between two bodies, or a body and the world: glue, hinges and ball joints.
//!
//! A joint is a short piece of cement around a point, as the parallel bond of Potyondy & Cundall (2004, Int. J. Rock Mech. Min. Sci. 41, 1329): a disc of radius R and thickness t (in plane strain a
//! strip of half width R, per metre of depth) of Young's modulus E and shear modulus G resists stretching with E A/t, shear with G A/t, bending with E I/t and twist with G J/t. A hinge leaves the
//! turn about its axis free, a ball joint all turns; their pin resists with E A/t in every direction.
//!
//! The bond of the paper adds up increments. Here the energy is a function of the present places, so that nothing drifts and a joint that is not damped gives back all that it took: with the point of
//! the joint on the second body at u in the frame that the first body carries, and q = (w, v) the rotation of the second body against the first since the start,
//!
//! U = ½ Σ k_i u_i² + ½ Σ κ_i (2 v_i)²,
//!
//! where 2 |v| = 2 sin(θ/2) is the angle θ where that is small. 2 |v_⊥| = 2 sin(β/2) holds the tilt β of the axis alone, whatever the turn about it, so a hinge may go round and round. The gradient of U is a
//! force on the second body at its point, the opposite force on the first body at the same point, and opposite torques: momentum and angular momentum stay to rounding.
//!
//! Glue breaks, for good, when the largest stress at its rim reaches a strength: tension N/A + M R/I or shear V/A + T R/J. What it had stored is gone then
//! ([`Joint::released`]).

use super::motion::{Pose, axes, product};
use super::{Block, Blocks};
use crate::check::{self, Checked, ensure};
use crate::math::vector::{cross, dot, less, plus, scaled};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Which turns a joint leaves free.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// None.
    Glue,
    /// That about its axis.
    Hinge,
    /// All.
    Ball,
}

impl Kind {
    /// What a reader says of what it joins.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Glue => "glued",
            Kind::Hinge => "hinged",
            Kind::Ball => "joined by a ball",
        }
    }
}

/// The cement of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cement {
    /// Radius of the disc, in plane strain half width of the strip, m.
    pub radius: f64,
    /// Thickness, m.
    pub thickness: f64,
    /// Young's modulus, Pa.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Damping over critical damping of the joint's own vibrations.
    pub damping: f64,
    /// Strengths in tension and in shear, Pa; infinite where it does not break.
    pub strength: [f64; 2],
}

impl Cement {
    /// Area, m², and section moduli I/R and J/R, m³. A strip has no twist.
    fn section(&self, flat: bool) -> [f64; 3] {
        let r = self.radius;
        if flat { [2.0 * r, 2.0 / 3.0 * r * r, f64::INFINITY] } else { [PI * r * r, 0.25 * PI * r * r * r, 0.5 * PI * r * r * r] }
    }

    /// Stiffness of a joint of this kind: N/m along its axis and across it, N m in bending and in twist.
    fn stiffness(&self, kind: Kind, flat: bool) -> [f64; 4] {
        let ([area, bending, twist], r) = (self.section(flat), self.radius);
        let (e, g) = (self.young / self.thickness, 0.5 * self.young / (1.0 + self.poisson) / self.thickness);
        let twist = if flat { 0.0 } else { g * twist * r };
        match kind {
            Kind::Glue => [e * area, g * area, e * bending * r, twist],
            Kind::Hinge => [e * area, e * area, e * bending * r, 0.0],
            Kind::Ball => [e * area, e * area, 0.0, 0.0],
        }
    }
}

/// What a joint is made of and where it sits; it does not change.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bond {
    /// Index of the first body, which carries the joint's axes.
    pub first: u32,
    /// Index of the second body; `None`: the world.
    pub second: Option<u32>,
    /// Which turns it leaves free.
    pub kind: Kind,
    /// Where the joint sits in the frames of the first and the second, m.
    anchors: [[f64; 3]; 2],
    /// Its axis and two directions across, in the frame of the first.
    directions: [[f64; 3]; 3],
    /// Rotation that takes the orientation of the second against the first back to that of the start.
    aligned: [f64; 4],
    /// Stiffness: N/m along the axis and across it, N m in bending and in twist.
    stiffness: [f64; 4],
    /// Damping in the same order, N s/m and N m s.
    damping: [f64; 4],
    /// Area, m², and section moduli in bending and twist, m³.
    section: [f64; 3],
    /// Strengths in tension and in shear, Pa.
    strength: [f64; 2],
}

impl Bond {
    /// What it joins body `body` to: another one, or the world (`Some(None)`); `None` if the body is not at its ends.
    pub fn partner(&self, body: u32) -> Option<Option<u32>> {
        match (self.first == body, self.second == Some(body)) {
            (true, _) => Some(self.second),
            (false, true) => Some(Some(self.first)),
            (false, false) => None,
        }
    }
}

/// What a joint does at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pull {
    /// Where the forces act, m.
    pub at: [f64; 3],
    /// Force, N, and torque, N m, on the second.
    pub on_second: [[f64; 3]; 2],
    /// The part of damping in them.
    drag: [[f64; 3]; 2],
    /// Velocity, m/s, and spin, rad/s, of the second against the first.
    rate: [[f64; 3]; 2],
    /// Force along the axis (tension positive) and across it, N; moments of bending and twist, N m: without damping.
    pub load: [f64; 4],
    /// Largest stresses over the strengths, -.
    pub utilisation: f64,
    /// Elastic energy, J.
    pub stored: f64,
}

/// A joint and its state.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Joint {
    /// What it is made of.
    pub bond: Bond,
    /// Time at which it broke, s; `None`: it holds.
    pub broken: Option<f64>,
    /// Work of its damping, J.
    pub viscous: f64,
    /// Elastic energy that went with it when it broke, J.
    pub released: f64,
    /// What it does now.
    #[serde(skip)]
    pub now: Pull,
}

/// The conjugate of a quaternion.
fn conjugate([w, x, y, z]: [f64; 4]) -> [f64; 4] {
    [w, -x, -y, -z]
}

/// The world as a body at rest in the origin.
const WORLD: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

/// Place, orientation and motion of one end of a joint.
struct End {
    pose: Pose,
    turn: [f64; 4],
    velocity: [f64; 3],
    spin: [f64; 3],
}

impl End {
    fn of(block: Option<&Block>) -> End {
        let none = [0.0; 3];
        match block {
            Some(b) => End { pose: b.pose(0.0), turn: b.turn, velocity: b.velocity, spin: b.spin() },
            None => End { pose: Pose { centre: none, axes: axes(WORLD) }, turn: WORLD, velocity: none, spin: none },
        }
    }

    /// Velocity of the matter at a place in space, m/s.
    fn velocity_at(&self, place: [f64; 3]) -> [f64; 3] {
        plus(self.velocity, cross(self.spin, less(place, self.pose.centre)))
    }
}

impl Joint {
    /// A joint of body `first` and `second` of `blocks` (`None`: the world) at a place in space, m, with an axis of any length but zero. `flat`: plane strain. The axis is turned such that it points from the first body
    /// to the second; with the world, from the centre of the body to the place.
    pub fn new(
        blocks: &[Block],
        [first, second]: [Option<u32>; 2],
        kind: Kind,
        place: [f64; 3],
        axis: [f64; 3],
        cement: &Cement,
        flat: bool,
    ) -> Joint {
        let first = first.unwrap_or_default();
        let (a, b) = (&blocks[first as usize], second.map(|k| &blocks[k as usize]));
        let ends = [End::of(Some(a)), End::of(b)];
        let towards = less(b.map_or(place, |b| b.centre), a.centre);
        let sign = if dot(axis, towards) < 0.0 { -1.0 } else { 1.0 };
        let axis = scaled(axis, sign / dot(axis, axis).sqrt());
        // across: of the three axes of space that which is furthest from the axis
        let least = (0..3).fold(0, |k, i| if axis[i].abs() < axis[k].abs() { i } else { k });
        let unit: [f64; 3] = std::array::from_fn(|i| if i == least { 1.0 } else { 0.0 });
        let across = cross(axis, unit);
        let across = scaled(across, 1.0 / dot(across, across).sqrt());
        let directions = [axis, across, cross(axis, across)].map(|d| ends[0].pose.inwards(d));
        let stiffness = cement.stiffness(kind, flat);
        let yields = |of: &dyn Fn(&Block) -> f64| [Some(a), b].into_iter().flatten().map(of).sum::<f64>();
        let mass = yields(&|b| b.yields().inverse_mass);
        let turn = yields(&|b| b.yields().inverse_moments.into_iter().fold(0.0, f64::max));
        let critical = |k: f64, inverse: f64| if inverse > 0.0 { 2.0 * cement.damping * (k / inverse).sqrt() } else { 0.0 };
        let [n, s, m, t] = stiffness;
        let bond = Bond {
            first,
            second,
            kind,
            anchors: [ends[0].pose.within(place), ends[1].pose.within(place)],
            directions,
            aligned: conjugate(product(conjugate(ends[0].turn), ends[1].turn)),
            stiffness,
            damping: [critical(n, mass), critical(s, mass), critical(m, turn), critical(t, turn)],
            section: cement.section(flat),
            strength: if kind == Kind::Glue { cement.strength } else { [f64::INFINITY; 2] },
        };
        Joint { bond, broken: None, viscous: 0.0, released: 0.0, now: Pull::default() }
    }

    /// Checks what a checkpoint says of it against what the same run `made`.
    pub(super) fn check(&self, made: &Joint) -> Checked {
        ensure(self.bond == made.bond, || "a joint is not that of the scene".into())?;
        check::not_negative("times at which joints broke", self.broken)?;
        check::numbers("works of joints", [self.viscous, self.released])
    }

    /// Bodies at its ends.
    fn ends(&self, blocks: &[Block]) -> [End; 2] {
        [Some(self.bond.first), self.bond.second].map(|k| End::of(k.map(|k| &blocks[k as usize])))
    }

    /// Computes what it does at this instant; true: it breaks.
    fn pull(&mut self, blocks: &[Block], time: f64) -> bool {
        if self.broken.is_some() {
            return false;
        }
        let (bond, [a, b]) = (&self.bond, self.ends(blocks));
        let [stretch, shear, bend, twist] = bond.stiffness;
        let at = b.pose.place(bond.anchors[1]);
        let u = less(a.pose.within(at), bond.anchors[0]);
        let rate = [less(b.velocity_at(at), a.velocity_at(at)), less(b.spin, a.spin)];
        // components along the joint's own directions
        let own = |v: [f64; 3]| bond.directions.map(|d| dot(d, v));
        let whole = |[x, y, z]: [f64; 3]| {
            let [d, e, f] = bond.directions;
            a.pose.outwards(plus(scaled(d, x), plus(scaled(e, y), scaled(f, z))))
        };
        let [k, c] = [&bond.stiffness, &bond.damping].map(|of| [[of[0], of[1], of[1]], [of[3], of[2], of[2]]]);
        let times = |k: [f64; 3], v: [f64; 3]| std::array::from_fn::<f64, 3, _>(|i| k[i] * v[i]);
        let u = own(u);
        let [w, x, y, z] = product(product(conjugate(a.turn), b.turn), bond.aligned);
        let v = own([x, y, z]);
        let (force, moment) = (times(k[0], u), scaled(times(k[1], v), 2.0));
        // the directions are right-handed, so the cross product may be taken in their components
        let torque = plus(scaled(moment, w), cross(v, moment));
        let drag = [0, 1].map(|i| whole(scaled(times(c[i], own(a.pose.inwards(rate[i]))), -1.0)));
        let on_second = [less(drag[0], whole(force)), less(drag[1], whole(torque))];
        let across = |v: [f64; 3]| (v[1] * v[1] + v[2] * v[2]).sqrt();
        let load = [force[0], across(force), across(torque), torque[0].abs()];
        let [area, bending, twisting] = bond.section;
        let (tension, slide) = (load[0] / area + load[2] / bending, load[1] / area + load[3] / twisting);
        let utilisation = (tension / bond.strength[0]).max(slide / bond.strength[1]);
        let square = |v: [f64; 3]| v[1] * v[1] + v[2] * v[2];
        let stored = 0.5 * (stretch * u[0] * u[0] + shear * square(u)) + 2.0 * (twist * v[0] * v[0] + bend * square(v));
        if utilisation >= 1.0 {
            (self.broken, self.released, self.now) = (Some(time), stored, Pull::default());
            return true;
        }
        self.now = Pull { at, on_second, drag, rate, load, utilisation, stored };
        false
    }

    /// Adds the work of damping over the last `kick` seconds, after the bodies have got their new velocities.
    fn add_viscous_work(&mut self, blocks: &[Block], kick: f64) {
        let Pull { drag, rate, at, .. } = self.now;
        if drag == [[0.0; 3]; 2] {
            return;
        }
        let [a, b] = self.ends(blocks);
        let after = [less(b.velocity_at(at), a.velocity_at(at)), less(b.spin, a.spin)];
        for k in 0..2 {
            self.viscous -= 0.5 * kick * dot(drag[k], plus(rate[k], after[k]));
        }
    }

    /// Bound on the square of the angular frequency, 1/s², that it gives its bodies.
    fn rate(&self, blocks: &[Block]) -> f64 {
        if self.broken.is_some() {
            return 0.0;
        }
        let bond = &self.bond;
        let ends = [Some(bond.first), bond.second].map(|k| k.map(|k| &blocks[k as usize]));
        let mut sums = [0.0; 2];
        for (block, anchor) in ends.into_iter().zip(bond.anchors) {
            let Some(block) = block else { continue };
            sums[0] += block.yields().most_at(anchor);
            sums[1] += block.yields().inverse_moments.into_iter().fold(0.0, f64::max);
        }
        let of = |values: &[f64; 4]| [0, 2].iter().zip(sums).map(|(&k, sum)| values[k].max(values[k + 1]) * sum).sum::<f64>();
        let (elastic, viscous) = (of(&bond.stiffness), of(&bond.damping));
        // ω² Δt² + 2 c Δt ≤ 4 where damping goes by the velocities of the last half step
        if viscous == 0.0 { elastic } else { (viscous + (viscous * viscous + elastic).sqrt()).powi(2) }
    }
}

impl Joint {
    /// Torque of what it does to its second body, about the centre of mass of a body, N m.
    fn torque_about(&self, block: &Block) -> [f64; 3] {
        let [force, torque] = self.now.on_second;
        plus(torque, cross(less(self.now.at, block.centre), force))
    }
}

impl Blocks {
    /// Computes what the joints do at this instant, time `time`, s, and breaks those that are at their strength.
    pub fn pull(&mut self, time: f64) {
        let Some(drives) = &mut self.drives else { return };
        for joint in &mut drives.joints {
            if joint.pull(&self.blocks, time) {
                let Bond { first, second, .. } = joint.bond;
                if let Some(b) = second {
                    drives.parted.push([first.min(b), first.max(b)]);
                }
                self.age.forget();
            }
        }
    }

    /// Adds what the joints do to the forces on the bodies.
    pub(super) fn add_joints(&mut self) {
        let Blocks { blocks, applied, drives: Some(drives), .. } = self else { return };
        for joint in &drives.joints {
            let (bond, force) = (&joint.bond, joint.now.on_second[0]);
            let mut add = |k: u32, sign: f64| {
                let about = joint.torque_about(&blocks[k as usize]);
                let sum = &mut applied[k as usize];
                *sum = [plus(sum[0], scaled(force, sign)), plus(sum[1], scaled(about, sign))];
            };
            add(bond.first, -1.0);
            bond.second.into_iter().for_each(|k| add(k, 1.0));
        }
    }

    /// Adds the work of damping of the joints over the last `kick` seconds.
    pub(super) fn add_viscous_work(&mut self, kick: f64) {
        let Blocks { blocks, drives: Some(drives), .. } = self else { return };
        drives.joints.iter_mut().for_each(|joint| joint.add_viscous_work(blocks, kick));
    }

    /// Adds the rates of the joints, 1/s², to those of the bodies.
    pub(super) fn add_joint_rates(&self, of_blocks: &mut [f64]) {
        for joint in self.drives.iter().flat_map(|drives| &drives.joints) {
            let rate = joint.rate(&self.blocks);
            for k in [Some(joint.bond.first), joint.bond.second].into_iter().flatten() {
                of_blocks[k as usize] += rate;
            }
        }
    }

    /// Force of all joints on body `block`, N.
    pub fn joint_force(&self, block: usize) -> [f64; 3] {
        self.of_joints(block, |joint| joint.now.on_second[0])
    }

    /// Torque of all joints on body `block` about its centre of mass, N m.
    pub(super) fn joint_torque(&self, block: usize) -> [f64; 3] {
        self.of_joints(block, |joint| joint.torque_about(&self.blocks[block]))
    }

    /// Sum over the joints of body `block` of what they do to their second body; to their first they do the opposite.
    fn of_joints(&self, block: usize, on_second: impl Fn(&Joint) -> [f64; 3]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for joint in self.drives.iter().flat_map(|drives| &drives.joints) {
            for (k, sign) in [(Some(joint.bond.first), -1.0), (joint.bond.second, 1.0)] {
                if k == Some(block as u32) {
                    sum = plus(sum, scaled(on_second(joint), sign));
                }
            }
        }
        sum
    }

    /// Elastic energy of all joints, J.
    pub(super) fn stored_in_joints(&self) -> f64 {
        self.drives.iter().flat_map(|drives| &drives.joints).map(|joint| joint.now.stored).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rigid::motion::about;
    use crate::shape::{Cuboid, Shape};

    fn cement(damping: f64) -> Cement {
        Cement { radius: 0.03, thickness: 0.01, young: 1e7, poisson: 0.25, damping, strength: [f64::INFINITY; 2] }
    }

    /// Two bricks, turned, and a joint between them.
    fn pair(kind: Kind, damping: f64) -> Blocks {
        let mut a = Block::new(Shape::Box(Cuboid { half: [0.06, 0.05, 0.04] }), 2000.0, 0);
        let mut b = Block::new(Shape::Box(Cuboid { half: [0.05, 0.04, 0.07] }), 2500.0, 0);
        (a.turn, b.turn) = (about([1.0, 2.0, 3.0], 0.4), about([-1.0, 0.5, 0.0], 1.1));
        b.centre = [0.02, 0.01, 0.12];
        let blocks = vec![a, b];
        let joint = Joint::new(&blocks, [Some(0), Some(1)], kind, [0.01, 0.0, 0.05], [0.1, -0.2, 1.0], &cement(damping), false);
        let programmes = vec![Default::default(); 2];
        Blocks::new(blocks).with_drives(programmes, vec![joint])
    }

    fn stored(blocks: &mut Blocks) -> f64 {
        blocks.pull(0.0);
        blocks.stored_in_joints()
    }

    /// Force and torque on each body are the gradient of the energy, by central differences, after any displacement and turn; together they make no force and no torque.
    #[test]
    fn forces_are_the_gradient_of_the_energy_and_balance() {
        for kind in [Kind::Glue, Kind::Hinge, Kind::Ball] {
            let mut all = pair(kind, 0.0);
            assert!(stored(&mut all) < 1e-20, "{:e}", stored(&mut all));
            all.blocks[1].shift([2e-3, -1e-3, 3e-3], [0.3, 0.8, -0.5]);
            all.blocks[0].shift([1e-3, 1e-3, 0.0], [-0.2, 0.1, 0.4]);
            all.pull(0.0);
            all.applied = vec![[[0.0; 3]; 2]; 2];
            all.add_joints();
            let applied = all.applied.clone();
            let about_origin = |k: usize| plus(applied[k][1], cross(all.blocks[k].centre, applied[k][0]));
            let (sum, turn) = (plus(applied[0][0], applied[1][0]), plus(about_origin(0), about_origin(1)));
            assert!(
                dot(sum, sum) == 0.0 && dot(turn, turn).sqrt() < 1e-14 * dot(applied[1][0], applied[1][0]).sqrt(),
                "{sum:?} {turn:?}"
            );
            let size = dot(applied[1][0], applied[1][0]).sqrt();
            for (k, of) in applied.iter().enumerate() {
                for a in 0..6 {
                    let step = 1e-6;
                    let energy = |by: f64| {
                        let mut moved = all.clone();
                        let unit = |at: usize| std::array::from_fn(|i| if i + at == a { by } else { 0.0 });
                        moved.blocks[k].shift(unit(0), unit(3));
                        stored(&mut moved)
                    };
                    let slope = (energy(step) - energy(-step)) / (2.0 * step);
                    let force = of.as_flattened()[a];
                    assert!((force + slope).abs() < 1e-6 * size, "{kind:?} {k} {a}: {force} {slope}");
                }
            }
        }
    }

    /// A hinge holds nothing against any turn about its axis, and the same tilt costs the same whatever the turn.
    #[test]
    fn a_hinge_turns_freely_all_the_way_round() {
        let tilt = |turn: f64| {
            let mut all = pair(Kind::Hinge, 0.0);
            let Bond { directions, anchors, .. } = all.drives.as_ref().unwrap().joints[0].bond.clone();
            let frame = all.blocks[0].pose(0.0);
            let (axis, across) = (frame.outwards(directions[0]), frame.outwards(directions[1]));
            let pivot = frame.place(anchors[0]);
            // about the pivot: the turn, then a tilt of 0.02
            for (direction, angle) in [(axis, turn), (across, 0.02)] {
                let rotation = Pose { centre: [0.0; 3], axes: axes(about(direction, angle)) };
                let b = &mut all.blocks[1];
                b.centre = plus(pivot, rotation.outwards(less(b.centre, pivot)));
                b.turn = product(about(direction, angle), b.turn);
            }
            stored(&mut all)
        };
        let expected = 2.0 * cement(0.0).stiffness(Kind::Hinge, false)[2] * 0.01_f64.sin().powi(2);
        for turn in [0.0, 0.7, 2.0, 3.1] {
            assert!((tilt(turn) / expected - 1.0).abs() < 1e-9, "{turn}: {} {expected}", tilt(turn));
        }
    }

    /// Bodies that swing on glue without damping keep momentum, angular momentum and energy; with damping what they lose is the work of the damping.
    #[test]
    fn glued_bodies_keep_momenta_and_energy() {
        for damping in [0.0, 0.2] {
            let mut all = pair(Kind::Glue, damping);
            all.blocks[0].velocity = [0.0, 0.3, 0.1];
            all.blocks[1].set_spin([1.0, -2.0, 0.5]);
            let momenta = |all: &Blocks| {
                all.blocks.iter().fold([[0.0; 3]; 2], |[p, l], b| {
                    let own = scaled(b.velocity, b.mass);
                    [plus(p, own), plus(l, plus(b.momentum, cross(b.centre, own)))]
                })
            };
            let mut rates = vec![0.0; 2];
            all.add_joint_rates(&mut rates);
            let dt = 0.02 * 2.0 / rates[0].sqrt();
            let (start, first) = (all.blocks.iter().map(Block::kinetic).sum::<f64>(), momenta(&all));
            let (mut most, mut given) = (0.0_f64, 0.0);
            for k in 0..20_000 {
                all.pull(0.0);
                // kinetic energy in the middle of two half steps
                let before = all.blocks.iter().map(Block::kinetic).sum::<f64>();
                let stored = all.stored_in_joints();
                all.add_joints();
                let kick = if k == 0 { 0.5 * dt } else { dt };
                let applied = std::mem::replace(&mut all.applied, vec![[[0.0; 3]; 2]; 2]);
                all.blocks.iter_mut().zip(applied).for_each(|(b, applied)| b.advance(applied, kick, dt));
                let viscous = all.drives().unwrap().joints[0].viscous;
                all.add_viscous_work(kick);
                if k > 0 {
                    let after = all.blocks.iter().map(Block::kinetic).sum::<f64>();
                    let gone = 0.5 * (viscous + all.drives().unwrap().joints[0].viscous);
                    most = most.max((0.5 * (before + after) + stored + gone - start).abs());
                    given = gone;
                }
            }
            let last = momenta(&all);
            let scale = dot(first[0], first[0]).sqrt();
            for (a, b) in first.as_flattened().iter().zip(last.as_flattened()) {
                assert!((a - b).abs() < 1e-12 * scale, "{first:?} {last:?}");
            }
            assert!(most < 2e-3 * start, "{damping}: {most:e} of {start:e} J");
            assert!(if damping > 0.0 { given > 0.2 * start } else { given == 0.0 }, "{given} of {start}");
        }
    }
}
