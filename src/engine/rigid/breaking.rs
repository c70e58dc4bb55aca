//! Breakage of rigid bodies that are no spheres.
//!
//! A body is judged by the criteria of grains ([`crate::breakage::criterion`]). All places at which it touches one partner (a wall, another body) count as one contact: a face that lies
//! on a face touches at its corners, and the sum of their normal forces is what the criterion judges. Its strength follows from the diameter of the sphere of its
//! volume (in plane strain of the disc of its area), with size hardening and spread as for grains. Contacts with points and grains do not break it.
//!
//! It breaks in two along a plane ([`crate::shape::Fragment`]) that goes through its two largest contacts and its centre of mass. Where these three are nearly on a line, as between two
//! platens, the plane contains that line and the cut crosses the body's longest axis. In plane strain the line through the two contacts is the cut. A cut that would
//! chip off less than [`LEAST`] of the volume goes through the centre of mass instead.
//!
//! A compound falls into its parts, cut free of each other ([`Compound::fragments`], [`parts_of`]), and these break as other bodies do.
//!
//! Where [`CrushModel::cells`] gives seeds, a body breaks into the cells around them instead ([`Shape::cells`]), those with less than [`LEAST_CELL`] of its volume left out; a body of
//! which the cells would lose more than [`MOST_LOST`] breaks in two.
//!
//! The pieces have all of the mass, the momentum and the angular momentum of the body. The largest keeps the body's number, the others follow by size. What the round edges at the cuts
//! leave to none ([`Breakage::lost_volume`]) makes the pieces denser by as much; a cut that would lose more than [`MOST_LOST`] of the volume is not made. The contacts of the body end with it. Those
//! of the pieces begin without force however deep they are born ([`super::BlockContact::reference`]), so that no energy is made.

use super::pair::Outline;
use super::{Block, Blocks, Other, motion};
use crate::breakage::CrushModel;
use crate::breakage::criterion::{Judges, MeanStress};
use crate::check::{self, Checked, ensure};
use crate::contact::pair::PairTable;
use crate::math::random::{lineage_child, lineage_root};
use crate::math::vector::{cross, dot, less, plus, scaled};
use crate::shape::{Compound, Fragment, Shape, Solid};
use serde::{Deserialize, Serialize};

/// Smallest share of a body's volume that a piece may have where the cut does not go through the centre of mass.
pub const LEAST: f64 = 0.1;
/// Smallest share of a body's volume that a piece around a seed may have: a smaller one would shorten the time step of all.
pub const LEAST_CELL: f64 = 0.005;
/// Largest share of a body's volume that a breakage may lose at the new edges.
pub const MOST_LOST: f64 = 0.1;
/// Sine of the angle between the arms of the two largest contacts below which they count as on a line with the centre.
const ON_A_LINE: f64 = 0.1;

/// How the bodies of a run break: what a restart needs.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Breaking {
    /// Of each body, by its index.
    pub bodies: Vec<Fate>,
    /// Breakages so far.
    pub events: u64,
    /// Bodies that came of them, beside those that keep their numbers.
    added: u64,
    /// Bodies that were over their limit and could not be cut.
    pub held: u64,
    /// Bodies whose contacts begin without force at the next search.
    pub(super) newborn: Vec<u32>,
    /// Breakages since the caller last took them out.
    #[serde(skip)]
    pub broken: Vec<Breakage>,
    /// Buffer: what bears on each body.
    #[serde(skip)]
    borne: Vec<Borne>,
}

/// Strength and descent of one body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fate {
    /// Limit strength, Pa.
    pub strength: f64,
    /// Load at which it breaks ([`crate::breakage::criterion::FailureCriterion::threshold`]); infinite where it does not break.
    threshold: f64,
    /// Key of its random numbers.
    lineage: u64,
    /// Number of breakages between it and the body of the start.
    pub generation: u8,
    /// Step of the grains in which it was born.
    born: u64,
    /// Edge of the square hole through which it passes ([`Shape::sieve`]), m.
    pub sieve: f64,
}

/// One breakage of a body, as it is recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Breakage {
    /// Number of the breakage, from 1.
    pub event: u64,
    /// Step of the grains.
    pub step: u64,
    /// Numbers of the pieces, the largest first, which keeps that of the body.
    pub pieces: Vec<u32>,
    /// Generation of the body that broke.
    pub generation: u8,
    /// Steps since its birth.
    pub age: u64,
    /// Diameter of the sphere of its volume, m.
    pub diameter: f64,
    /// Decisive normal force, N.
    pub force: f64,
    /// Normal force at which it fails, N.
    pub limit_force: f64,
    /// Area, m², over which the decisive force makes the stress that is compared with the strength.
    pub area: f64,
    /// Limit strength, Pa.
    pub strength: f64,
    /// Its centre of mass, m.
    pub position: [f64; 3],
    /// Unit normal of the cut; 0 where there were several.
    pub normal: [f64; 3],
    /// Masses of the pieces, kg, in their order.
    pub masses: Vec<f64>,
    /// Volume that the round edges at the cuts leave to no piece, m³.
    pub lost_volume: f64,
    /// Elastic energy of its contacts, J, which ends with it.
    pub stored: f64,
    /// Kinetic energy before less that after, J.
    pub lost_kinetic: f64,
}

/// What one partner of a body presses on it.
#[derive(Clone, Copy, Debug)]
struct Push {
    /// Normal force, N.
    force: f64,
    /// The same with the criterion's weight.
    load: f64,
    /// Where it acts, in the frame of the body, m.
    at: [f64; 3],
    /// R* of the contact, m, and its E', Pa.
    stiff: [f64; 2],
}

/// What bears on a body.
#[derive(Clone, Copy, Debug, Default)]
struct Borne {
    /// The two largest pushes, the largest first.
    largest: [Option<Push>; 2],
    /// Sum over contacts of −force × arm, N m: its mean stress times its volume.
    moment: [f64; 6],
}

impl Borne {
    fn add(&mut self, push: Push) {
        let above = |other: Option<Push>| other.is_none_or(|other| push.load > other.load);
        if above(self.largest[0]) {
            self.largest = [Some(push), self.largest[0]];
        } else if above(self.largest[1]) {
            self.largest[1] = Some(push);
        }
    }
}

/// A body over its limit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Verdict {
    block: usize,
    at: [Option<[f64; 3]>; 2],
    force: f64,
    limit_force: f64,
    area: f64,
}

impl Fate {
    /// Of a body of this descent; `generation`: of the body, `born`: step.
    fn of(crush: &CrushModel, block: &Block, lineage: u64, generation: u8, born: u64) -> Fate {
        let d = 2.0 * block.radius;
        let breaks = !block.driven && d > crush.d_limit;
        let strength = if breaks { crush.strength.draw(crush.seed, lineage, d) } else { 0.0 };
        let threshold = match plane_area(crush, block) {
            _ if !breaks => f64::INFINITY,
            Some(area) => strength * area,
            None => crush.criterion.threshold(strength, d),
        };
        Fate { strength, threshold, lineage, generation, born, sieve: block.shape.sieve() }
    }
}

impl Breaking {
    /// Of bodies that have just been placed.
    pub(super) fn of(crush: &CrushModel, blocks: &[Block]) -> Breaking {
        let fate = |(k, block)| Fate::of(crush, block, lineage_root(k as u32), 0, 0);
        Breaking { bodies: blocks.iter().enumerate().map(fate).collect(), ..Breaking::default() }
    }

    /// Checks what a checkpoint says of so many bodies, of which there were `first` at the start.
    pub(super) fn check(&self, bodies: usize, first: usize) -> Checked {
        check::lengths("strengths of rigid bodies", bodies, [self.bodies.len()])?;
        check::counters("breakages of rigid bodies", &[self.events, self.held, self.added])?;
        ensure(bodies as u64 == first as u64 + self.added && self.added >= self.events, || {
            format!("{first} rigid bodies and {} more of {} breakages do not make {bodies}", self.added, self.events)
        })?;
        self.newborn.iter().try_for_each(|&k| check::below("new rigid body", k, bodies))?;
        check::not_negative("strengths of rigid bodies", self.bodies.iter().map(|fate| fate.strength))?;
        ensure(self.bodies.iter().all(|fate| fate.sieve > 0.0), || "a rigid body passes no sieve".into())?;
        let threshold = |fate: &Fate| fate.threshold > 0.0;
        ensure(self.bodies.iter().all(threshold), || "a rigid body breaks under no load".into())
    }
}

impl Blocks {
    /// Lets the bodies break.
    pub fn with_breakage(self, crush: &CrushModel) -> Blocks {
        Blocks { breaking: Some(Box::new(Breaking::of(crush, &self.blocks))), ..self }
    }

    /// How the bodies break; `None`: they do not.
    pub fn breaking(&self) -> Option<&Breaking> {
        self.breaking.as_deref()
    }

    /// Takes out the breakages since the last call.
    pub fn take_breakages(&mut self) -> Vec<Breakage> {
        self.breaking.as_mut().map_or(Vec::new(), |breaking| std::mem::take(&mut breaking.broken))
    }

    /// The bodies that are over their limit under the present forces, in their order.
    pub(crate) fn failing(&mut self, crush: &CrushModel, table: &PairTable) -> Vec<Verdict> {
        let Some(mut breaking) = self.breaking.take() else { return Vec::new() };
        self.sum_loads(crush, table, &mut breaking.borne);
        let over = |(k, (borne, fate)): (usize, (&Borne, &Fate))| self.judge(crush, k, borne, fate);
        let verdicts = breaking.borne.iter().zip(&breaking.bodies).enumerate().filter_map(over).collect();
        self.breaking = Some(breaking);
        verdicts
    }

    /// Sums what bears on each body: the contacts with one partner follow each other in the list.
    fn sum_loads(&self, crush: &CrushModel, table: &PairTable, borne: &mut Vec<Borne>) {
        borne.clear();
        borne.resize(self.blocks.len(), Borne::default());
        let same = |a: &super::BlockContact, b: &super::BlockContact| a.block == b.block && a.other.partner() == b.other.partner();
        let stress = crush.criterion.judges() == Judges::MeanStress;
        let of_spheres = |c: &super::BlockContact| matches!(c.other, Other::Point(_) | Other::Grain(_));
        let touching: Vec<&super::BlockContact> = self.touching().filter(|c| !of_spheres(c)).collect();
        for contacts in touching.chunk_by(|a, b| same(a, b)) {
            let (mut normal, mut weight, mut place) = ([0.0; 3], 0.0, [0.0; 3]);
            let (first, other) = (contacts[0].block, contacts[0].other);
            for c in contacts {
                let f = c.share * c.touch.normal_force;
                normal = plus(normal, less(scaled(c.touch.normal, f), c.beside[0]));
                (weight, place) = (weight + f, plus(place, scaled(c.arm, f)));
                if stress {
                    add_moment(&mut borne[first as usize].moment, c.force(), c.arm);
                    if let Other::Block { block, .. } = other {
                        let arm = plus(c.arm, less(self.blocks[first as usize].centre, self.blocks[block as usize].centre));
                        add_moment(&mut borne[block as usize].moment, scaled(c.force(), -1.0), arm);
                    }
                }
            }
            if weight <= 0.0 {
                continue;
            }
            let (block, force) = (&self.blocks[first as usize], dot(normal, normal).sqrt());
            let at = plus(block.centre, scaled(place, 1.0 / weight));
            let (r, e_eff) = match other {
                Other::Wall { wall, .. } => (f64::INFINITY, table.wall(wall as usize, block.material).e_eff),
                Other::Block { block: second, .. } => {
                    let second = &self.blocks[second as usize];
                    (second.radius, table.grains(block.material, second.material).e_eff)
                }
                Other::Point(_) | Other::Grain(_) => continue,
            };
            let r_eff = super::contact::reduced(block.radius, r);
            let load = force * crush.criterion.load_weight(r_eff, e_eff);
            let push = |on: &Block| Push { force, load, at: on.pose(0.0).within(at), stiff: [r_eff, e_eff] };
            borne[first as usize].add(push(block));
            if let Other::Block { block, .. } = other {
                borne[block as usize].add(push(&self.blocks[block as usize]));
            }
        }
    }

    /// Whether body `k` is over its limit.
    fn judge(&self, crush: &CrushModel, k: usize, borne: &Borne, fate: &Fate) -> Option<Verdict> {
        let first = borne.largest[0].filter(|_| fate.threshold.is_finite())?;
        let (block, [r_eff, e_eff]) = (&self.blocks[k], first.stiff);
        let d = 2.0 * block.radius;
        let (load, limit_force, area) = match crush.criterion.judges() {
            Judges::Contacts => match plane_area(crush, block) {
                Some(area) => (first.load, fate.threshold, area),
                None => {
                    let limit = crush.criterion.limit_force(fate.strength, d, r_eff, e_eff);
                    (first.load, limit, crush.criterion.area(first.force, d, r_eff, e_eff))
                }
            },
            Judges::MeanStress => {
                let volume = block.solid().bulk().volume;
                let stress = crush.criterion.equivalent_stress(&MeanStress(borne.moment.map(|m| m / volume)));
                // the force at which it would fail if all of its forces grew alike
                (stress, first.force * fate.threshold / stress, first.force / stress)
            }
        };
        let at = borne.largest.map(|push| push.map(|push| push.at));
        (load > fate.threshold).then_some(Verdict { block: k, at, force: first.force, limit_force, area })
    }

    /// Breaks the bodies `failing`, which have moved since they were judged, in step `step` of the grains. `energy_factor`: elastic energy of a contact over normal force
    /// times overlap.
    pub(crate) fn break_bodies(&mut self, crush: &CrushModel, failing: &[Verdict], step: u64, energy_factor: f64) {
        let Some(mut breaking) = self.breaking.take() else { return };
        for verdict in failing {
            match self.divide(crush, &mut breaking, verdict, step, energy_factor) {
                Some(event) => breaking.broken.push(event),
                None => {
                    breaking.held += 1;
                    breaking.bodies[verdict.block].threshold = f64::INFINITY;
                }
            }
        }
        self.breaking = Some(breaking);
    }

    /// Replaces a body by its pieces; `None`, with nothing changed, where it cannot be cut.
    fn divide(
        &mut self,
        crush: &CrushModel,
        breaking: &mut Breaking,
        verdict: &Verdict,
        step: u64,
        energy_factor: f64,
    ) -> Option<Breakage> {
        let k = verdict.block;
        let Parting { mut pieces, normal, lost } = parting(&self.blocks[k], &crush.cells, verdict.at)?;
        let body = self.blocks[k].clone();
        pieces.sort_by(|p, q| q.volume().total_cmp(&p.volume()));
        let made = divided(&body, &pieces);
        let fate = breaking.bodies[k];
        let touches = |c: &super::BlockContact| c.block as usize == k || c.other.partner_body() == Some(k as u32);
        let stored = self.touching().filter(|c| touches(c)).map(|c| c.energy(energy_factor)).sum();
        self.contacts.retain(|c| !touches(c));
        self.forget_list();
        let (new, generation) = (self.blocks.len() as u32, fate.generation.saturating_add(1));
        let numbers: Vec<u32> = std::iter::once(k as u32).chain(new..).take(made.len()).collect();
        let event = Breakage {
            event: breaking.events + 1,
            step,
            pieces: numbers.clone(),
            generation: fate.generation,
            age: step.saturating_sub(fate.born),
            diameter: 2.0 * body.radius,
            force: verdict.force,
            limit_force: verdict.limit_force,
            area: verdict.area,
            strength: fate.strength,
            position: body.centre,
            normal: body.pose(0.0).outwards(normal),
            masses: made.iter().map(|b| b.mass).collect(),
            lost_volume: lost,
            stored,
            lost_kinetic: body.kinetic() - made.iter().map(Block::kinetic).sum::<f64>(),
        };
        breaking.newborn.extend(&numbers);
        breaking.events += 1;
        breaking.added += made.len() as u64 - 1;
        let outlined = self.outlines.len() == self.blocks.len();
        for (i, piece) in made.into_iter().enumerate() {
            let mut of = Fate::of(crush, &piece, lineage_child(fate.lineage, i as u32), generation, step);
            // it lies inside of the body, though the hole of either is sought in steps of a degree
            of.sieve = of.sieve.min(fate.sieve);
            let outline = outlined.then(|| Outline::of(&piece));
            if i == 0 {
                breaking.bodies[k] = of;
                outline.into_iter().for_each(|outline| self.outlines[k] = outline);
                (self.blocks[k], self.applied[k]) = (piece, [[0.0; 3]; 2]);
            } else {
                breaking.bodies.push(of);
                self.outlines.extend(outline);
                self.blocks.push(piece);
                self.applied.push([[0.0; 3]; 2]);
            }
        }
        Some(event)
    }
}

/// In plane strain the area per metre of depth over which the force of a contact makes the stress.
fn plane_area(crush: &CrushModel, block: &Block) -> Option<f64> {
    block.shape.is_flat().then(|| crush.criterion.plane_area(2.0 * block.radius)).flatten()
}

/// Adds −(f a + a f)/2 of a force f, N, at the end of an arm a, m, to a moment xx, yy, zz, xy, yz, zx, N m.
fn add_moment(moment: &mut [f64; 6], f: [f64; 3], arm: [f64; 3]) {
    for (k, (a, b)) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)].into_iter().enumerate() {
        moment[k] -= 0.5 * (f[a] * arm[b] + f[b] * arm[a]);
    }
}

/// The pieces of a body that breaks.
struct Parting {
    pieces: Vec<Fragment>,
    /// Unit normal of the plane, in the frame of the body; 0 where there are several.
    normal: [f64; 3],
    /// Volume that is left to no piece, m³.
    lost: f64,
}

/// The parts of a compound, cut free of each other, as it falls into them; those with less than half a per cent of its volume are left out.
///
/// # Errors
/// Why it does not fall into its parts: fewer than two are left, more than [`MOST_LOST`] of its volume would be, or two have edges so sharp that contacts between them are not computed.
pub fn parts_of(compound: &Compound) -> Result<Vec<Fragment>, String> {
    let whole = compound.bulk().volume;
    let mut parts = compound.fragments();
    parts.retain(|part| part.volume() >= LEAST_CELL * whole);
    if parts.len() < 2 {
        return Err("no second body is left of its parts where they are cut free of each other".into());
    }
    let lost = parts.iter().fold(whole, |left, part| left - part.volume()) / whole;
    if lost > MOST_LOST {
        let [lost, most] = [lost, MOST_LOST].map(|share| 100.0 * share);
        return Err(format!("its parts, cut free of each other, would lose {lost:.1} % of its volume, where {most} % may be lost"));
    }
    if parts.iter().filter(|part| part.shape.rounded().rounding() == 0.0).count() > 1 {
        return Err("two of its parts have sharp edges and could not touch each other: give them rounding_mm".into());
    }
    Ok(parts)
}

/// How a body breaks whose largest contacts are `at`, in its frame: a compound into its parts, others into the cells around `seeds`, or where these are none or would lose too much, in
/// two.
fn parting(body: &Block, seeds: &[[f64; 3]], at: [Option<[f64; 3]>; 2]) -> Option<Parting> {
    let whole = body.solid().bulk().volume;
    let of = |pieces: Vec<Fragment>, normal, least: f64| {
        let lost = pieces.iter().fold(whole, |left, piece| left - piece.volume());
        let enough = pieces.len() > 1 && pieces.iter().all(|piece| piece.volume() >= least * whole);
        (enough && lost <= MOST_LOST * whole).then_some(Parting { pieces, normal, lost })
    };
    if let Shape::Compound(compound) = &body.shape {
        return of(parts_of(compound).ok()?, [0.0; 3], 0.0);
    }
    if !seeds.is_empty() {
        let mut pieces = body.shape.cells(seeds);
        pieces.retain(|piece| piece.volume() >= LEAST_CELL * whole);
        if let Some(parting) = of(pieces, [0.0; 3], 0.0) {
            return Some(parting);
        }
    }
    // through its largest contacts; in the same direction through its centre of mass; across its longest axis
    let cut = |normal, offset, least| of(body.shape.cut(normal, offset)?.into(), normal, least);
    let (normal, offset) = plane(body, at);
    cut(normal, offset, LEAST).or_else(|| cut(normal, 0.0, 0.0)).or_else(|| cut(longest(body, [0.0; 3]), 0.0, 0.0))
}

/// Unit normal and offset, m, of the plane through two contacts and the centre of mass, in the frame of the body.
fn plane(body: &Block, [first, second]: [Option<[f64; 3]>; 2]) -> ([f64; 3], f64) {
    let p = first.unwrap_or_default();
    let q = second.unwrap_or_else(|| scaled(p, -1.0));
    if matches!(body.shape, Shape::Polygon(_)) {
        let [x, y, _] = less(q, p);
        let length = (x * x + y * y).sqrt();
        let normal = if length > 0.0 { [-y / length, x / length, 0.0] } else { longest(body, [0.0; 3]) };
        return (normal, dot(normal, p));
    }
    let across = cross(p, q);
    let (sine, sizes) = (dot(across, across).sqrt(), (dot(p, p) * dot(q, q)).sqrt());
    if sine > ON_A_LINE * sizes {
        return (scaled(across, 1.0 / sine), 0.0);
    }
    let normal = longest(body, less(q, p));
    (normal, 0.5 * dot(normal, plus(p, q)))
}

/// Unit vector across a direction (of any length; zero: across nothing), as far as possible along the axis of the least moment of inertia, along which a body is longest; in the
/// plane along the longest distance from the centre.
fn longest(body: &Block, along: [f64; 3]) -> [f64; 3] {
    let square = dot(along, along);
    let across = |axis: [f64; 3]| less(axis, scaled(along, if square > 0.0 { dot(axis, along) / square } else { 0.0 }));
    let mut axes: Vec<[f64; 3]> = match &body.shape {
        Shape::Polygon(polygon) => {
            let far = |p: &&[f64; 3]| dot(**p, **p);
            polygon.rounded_ring().corners.iter().max_by(|p, q| far(p).total_cmp(&far(q))).into_iter().copied().collect()
        }
        _ => {
            let mut order = [0, 1, 2];
            order.sort_by(|&a, &b| body.moments[a].total_cmp(&body.moments[b]));
            order.map(|a| std::array::from_fn(|b| f64::from(u8::from(a == b)))).to_vec()
        }
    };
    axes.push([1.0, 0.0, 0.0]);
    let size = |v: [f64; 3]| dot(v, v).sqrt();
    // an axis that is nearly along it says little
    let found = axes.into_iter().map(|axis| (size(across(axis)) / size(axis), across(axis))).find(|(share, _)| *share > 0.5);
    let (_, normal) = found.unwrap_or((1.0, [0.0, 1.0, 0.0]));
    scaled(normal, 1.0 / size(normal))
}

/// The pieces as bodies: with all of the mass, momentum and angular momentum of `body`, and its velocity field but for what exactness takes.
fn divided(body: &Block, pieces: &[Fragment]) -> Vec<Block> {
    let (pose, spin) = (body.pose(0.0), body.spin());
    let volumes: Vec<f64> = pieces.iter().map(Fragment::volume).collect();
    let all: f64 = volumes.iter().sum();
    let mut masses: Vec<f64> = volumes.iter().map(|v| body.mass * (v / all)).collect();
    masses[0] = masses[1..].iter().fold(body.mass, |left, m| left - m);
    let of = |(i, Fragment { shape, centre, axes }): (usize, &Fragment)| {
        let density = masses[i] / volumes[i];
        let turn = motion::product(body.turn, motion::quaternion(*axes));
        let mut block = Block::new(shape.clone(), density, body.material);
        (block.mass, block.centre, block.turn) = (masses[i], pose.place(*centre), turn);
        block.velocity = plus(body.velocity, cross(spin, less(block.centre, body.centre)));
        block.set_spin(spin);
        block
    };
    let mut made: Vec<Block> = pieces.iter().enumerate().map(of).collect();
    // the centre of mass of the pieces is not quite that of the body, and some of the moment of inertia is gone
    let sum = made.iter().fold([0.0; 3], |sum, b| plus(sum, scaled(b.velocity, b.mass)));
    let missing = scaled(less(scaled(body.velocity, body.mass), sum), 1.0 / body.mass);
    made.iter_mut().for_each(|b| b.velocity = plus(b.velocity, missing));
    let about = |b: &Block| plus(b.momentum, cross(less(b.centre, body.centre), scaled(b.velocity, b.mass)));
    let turning = made.iter().fold([0.0; 3], |sum, b| plus(sum, about(b)));
    let missing = less(body.momentum, turning);
    for b in &mut made {
        b.momentum = plus(b.momentum, scaled(missing, b.mass / body.mass));
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{Cuboid, Frame, Piece, Polyhedron};

    /// A rock of unequal axes that turns and flies.
    fn rock() -> Block {
        let corners: Vec<[f64; 3]> = (0..8)
            .map(|k: u32| {
                let [x, y, z]: [f64; 3] = std::array::from_fn(|a| if k >> a & 1 == 1 { 1.0 } else { -1.0 });
                [1.3 * x + 0.2 * y, 1.0 * y - 0.1 * z * x, 0.7 * z + 0.1 * x]
            })
            .collect();
        let placed = Polyhedron::hull(&corners, 0.05).unwrap();
        let mut block = Block::new(Shape::Polyhedron(placed.polyhedron), 2600.0, 0);
        block.turn = motion::about([1.0, -2.0, 0.5], 1.1);
        (block.centre, block.velocity) = ([3.0, -1.0, 2.0], [4.0, 5.0, -6.0]);
        block.set_spin([10.0, -7.0, 3.0]);
        block
    }

    /// Asserts that mass, momentum and angular momentum about the origin of pieces are those of the body, to rounding, and that the field of velocities hardly changes.
    fn have_all(body: &Block, made: &[Block]) {
        let about = |b: &Block| plus(b.momentum, cross(b.centre, scaled(b.velocity, b.mass)));
        let mass = made.iter().fold(0.0, |sum, b| sum + b.mass);
        assert!(mass == body.mass || made.len() > 2 && (mass / body.mass - 1.0).abs() < 1e-15, "{mass}");
        let sum = made.iter().fold([[0.0; 3]; 2], |[p, l], b| [plus(p, scaled(b.velocity, b.mass)), plus(l, about(b))]);
        let was = [scaled(body.velocity, body.mass), about(body)];
        for (now, was) in sum.into_iter().zip(was) {
            let off = less(now, was);
            assert!(dot(off, off).sqrt() < 1e-12 * dot(was, was).sqrt(), "{now:?} {was:?}");
        }
        let kinetic = made.iter().map(Block::kinetic).sum::<f64>();
        assert!((kinetic / body.kinetic() - 1.0).abs() < 1e-2, "{kinetic} {}", body.kinetic());
        for (k, piece) in made.iter().enumerate() {
            assert!(made[..k].iter().all(|other| piece.overlap(other) < 1e-12));
        }
    }

    /// Pieces have all that the body had, in any cut, lie beside each other and inside of the body.
    #[test]
    fn pieces_have_all_that_the_body_had() {
        let body = rock();
        let six: Vec<[f64; 3]> = (0..5).map(|k| [0.4, -0.3, 0.1].map(|x| f64::from(k - 2) * x)).chain([[-0.6, 0.9, 0.5]]).collect();
        for (seeds, at) in [
            (&[][..], [Some([1.2, 0.1, 0.2]), Some([-0.3, 0.9, -0.1])]),
            (&[], [Some([0.0, 0.1, 0.7]), Some([0.05, 0.05, -0.7])]),
            (&[], [Some([1.2, 0.1, 0.2]), None]),
            // beside each other near an edge: that plane would chip
            (&[], [Some([1.3, 0.9, 0.0]), Some([1.25, 1.0, 0.1])]),
            (&six, [None, None]),
        ] {
            let Parting { pieces, normal, lost } = parting(&body, seeds, at).unwrap();
            let made = divided(&body, &pieces);
            let volumes: Vec<f64> = pieces.iter().map(Fragment::volume).collect();
            let whole = body.solid().bulk().volume;
            let (most_lost, least) = if seeds.is_empty() { (0.02, LEAST) } else { (MOST_LOST, LEAST_CELL) };
            assert!(lost > 0.0 && lost < most_lost * whole && volumes.iter().all(|v| *v > least * whole), "{lost} {volumes:?}");
            assert!((dot(normal, normal) - f64::from(u8::from(seeds.is_empty()))).abs() < 1e-12);
            assert_eq!(made.len(), seeds.len().max(2));
            have_all(&body, &made);
            for piece in &made {
                let pose = piece.pose(0.0);
                let solid = piece.solid();
                for k in 0..solid.spots() {
                    let corner = body.pose(0.0).within(pose.place(solid.spot(k, [0.0; 3])));
                    assert!(body.solid().nearest(corner).distance < -0.05 + 1e-9, "{corner:?}");
                }
            }
        }
    }

    /// A compound that turns and flies has all in its parts: an L of two boxes that overlap, a plus sign whose second bar comes out in two, an arrow head in plane strain.
    #[test]
    fn parts_have_all_that_the_compound_had() {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let cuboid = |half: [f64; 3], origin: [f64; 3]| Piece::cuboid(Cuboid { half }, Frame { origin, axes });
        let polygon = |corners: [[f64; 2]; 3]| Piece::polygon(&corners, 0.05, Frame { origin: [0.0; 3], axes }).unwrap();
        for (pieces, count) in [
            ([cuboid([2.0, 0.5, 0.6], [0.0; 3]), cuboid([0.4, 0.5, 1.5], [1.6, 0.0, 0.9])], 2),
            ([cuboid([2.0, 0.5, 0.5], [0.0; 3]), cuboid([0.5, 0.5, 1.5], [0.2, 0.0, 0.1])], 3),
            ([polygon([[0.0, 0.0], [3.0, -1.5], [1.0, 0.0]]), polygon([[0.0, 0.0], [1.0, 0.0], [3.0, 1.5]])], 2),
        ] {
            let shape = Shape::Compound(Box::new(Compound::of(&pieces).unwrap().compound));
            let flat = shape.is_flat();
            let mut body = Block::new(shape, 2600.0, 0);
            (body.centre, body.velocity) = ([3.0, -1.0, 2.0], [4.0, 5.0, -6.0]);
            if flat {
                (body.centre[2], body.velocity[2]) = (0.0, 0.0);
                body.turn = motion::about([0.0, 0.0, 1.0], 0.7);
                body.set_spin([0.0, 0.0, 3.0]);
            } else {
                body.turn = motion::about([1.0, -2.0, 0.5], 1.1);
                body.set_spin([10.0, -7.0, 3.0]);
            }
            // seeds are for what is convex
            let Parting { pieces, normal, lost } = parting(&body, &[[0.5; 3], [-0.5; 3]], [None, None]).unwrap();
            assert!(pieces.len() == count && normal == [0.0; 3], "{}", pieces.len());
            let whole = body.solid().bulk().volume;
            assert!(lost > 0.0 && lost < 0.02 * whole, "{lost} of {whole}");
            let made = divided(&body, &pieces);
            have_all(&body, &made);
            // each breaks as other bodies do
            assert!(made.iter().all(|piece| parting(piece, &[], [None, None]).is_some()));
        }
    }

    /// Between two platens a column breaks across the longer of its two other sides, and a body with three arms breaks in the plane of two contacts and its centre.
    #[test]
    fn the_cut_goes_through_the_contacts() {
        let brick = Block::new(Shape::Box(Cuboid { half: [0.3, 0.5, 1.0] }), 1.0, 0);
        let (normal, offset) = plane(&brick, [Some([0.0, 0.0, 1.0]), Some([0.0, 0.0, -1.0])]);
        assert_eq!((normal, offset), ([0.0, 1.0, 0.0], 0.0));
        let (normal, offset) = plane(&brick, [Some([0.0, 0.2, 1.0]), Some([0.0, 0.2, -1.0])]);
        assert!(normal[0].abs() > 1.0 - 1e-12 && offset == 0.0, "{normal:?}");
        let (normal, _) = plane(&brick, [Some([0.3, 0.0, 0.0]), Some([0.0, 0.5, 0.0])]);
        assert_eq!(normal, [0.0, 0.0, 1.0]);
        // one contact, as in a fall: across the body from there
        let (normal, offset) = plane(&brick, [Some([0.3, 0.0, 0.0]), None]);
        assert_eq!((normal, offset), ([0.0, 0.0, 1.0], 0.0));
    }
}
