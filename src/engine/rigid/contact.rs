//! Forces of all contacts of rigid bodies, and their addition to bodies, grains, points and walls.

use super::list::Contacts;
use super::motion::Yields;
use super::near::Near;
use super::pair::{DEEPEST, Meeting, Outline, Overlap, Site, corner_on_facets, meeting};
use super::ways::gap_at;
use super::{Block, Blocks, Pose};
use crate::boundary::Wall;
use crate::contact::force::{self, ContactGeometry, ContactHistory, RelativeMotion, Rules};
use crate::contact::law::{Elastic, Law};
use crate::contact::pair::{Pair, PairTable};
use crate::contact::pairs::ContactForce;
use crate::contact::registry::with_law;
use crate::contact::{ContactLaw, TangentialUnloading};
use crate::grains::Grains;
use crate::math::vector::{cross, dot, less, plus, scaled};
use crate::mpm::Continuum;
use crate::point_contacts::{ActsOn, ContactRates, GhostFace, PointContactTable};
use crate::shape::{Meet, Nearest};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Contacts with points, grains and walls, or pairs of bodies, of one parallel task; the nearest point of a superquadric takes some microseconds.
const TASK: usize = 32;

/// The other side of a body's contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Other {
    /// A material point, by identity.
    Point(u32),
    /// A grain, by identity.
    Grain(u32),
    /// A wall.
    Wall {
        /// Index of the wall.
        wall: u32,
        /// Spot of the body that touches the wall ([`crate::shape::Solid::spot`]).
        spot: u32,
    },
    /// Another body, of higher index.
    Block {
        /// Its index.
        block: u32,
        /// Which parts of the two touch.
        site: Site,
    },
}

/// A rigid body and something that it touches or may touch soon.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct BlockContact {
    /// Index of the body.
    pub block: u32,
    /// The other side.
    pub other: Other,
    /// Facet of the sheet, or part of the compound, on which the sphere or corner lies; 0 where neither takes part.
    pub facet: u32,
    /// Present index of the point or grain.
    pub(super) place: u32,
    /// Ghost radius of the point, or radius of the grain, m; 0 for a wall.
    pub(super) radius: f64,
    /// Force of the contact; its first end is the body. All zero while they do not touch.
    pub touch: ContactForce,
    /// Tangential spring, N (viscous laws; for others the tangential force is the spring).
    pub(super) spring: [f64; 3],
    /// Vector from the body's centre of mass to the contact point, m.
    pub(super) arm: [f64; 3],
    /// Tangent stiffnesses when forces were last computed: normal and tangential, N/m.
    pub(super) stiffness: [f64; 2],
    /// Inverse mass of the other side, 1/kg; 0 for a wall.
    pub(super) inverse_mass: f64,
    /// Share of `touch` and of `stiffness` that acts: less than 1 only where an edge of another body touches beside its end, or a sphere beside the border of a facet.
    pub(super) share: f64,
    /// What else acts there, on the body of the contact and against the other: force, N, and torque about its centre of mass, N m.
    pub(super) beside: [[f64; 3]; 2],
    /// Where the body presses on a point; `None` until they first touch, and again once they have parted.
    pub(super) face: Option<GhostFace>,
    /// Overlap, m, without a force: that with which a piece of a broken body was born, less where the two have moved apart since. Infinite until it is first known.
    pub(super) reference: f64,
    /// Whether it was too deep when it was last looked at.
    #[serde(skip)]
    pub(super) too_deep: bool,
}

impl Other {
    /// The other side without the place where they touch, as a pair of numbers.
    pub(super) fn partner(&self) -> (u8, u32) {
        match *self {
            Other::Point(id) => (0, id),
            Other::Grain(id) => (1, id),
            Other::Wall { wall, .. } => (2, wall),
            Other::Block { block, .. } => (3, block),
        }
    }

    /// The other body, if it is one.
    pub(super) fn partner_body(&self) -> Option<u32> {
        if let Other::Block { block, .. } = *self { Some(block) } else { None }
    }
}

impl BlockContact {
    /// A candidate without a force and without history.
    pub(super) fn new(block: u32, other: Other, facet: u32, place: u32, radius: f64) -> BlockContact {
        let (touch, none) = (ContactForce::default(), [0.0; 3]);
        BlockContact {
            block,
            other,
            facet,
            place,
            radius,
            touch,
            spring: none,
            arm: none,
            stiffness: [0.0; 2],
            inverse_mass: 0.0,
            share: 1.0,
            beside: [none; 2],
            face: None,
            reference: 0.0,
            too_deep: false,
        }
    }

    /// Whether it is of this site and facet of two bodies.
    pub(super) fn is_at(&self, at: Site, facet: u32) -> bool {
        matches!(self.other, Other::Block { site, .. } if site == at) && self.facet == facet
    }

    /// What tells it from other contacts, and by which they are sorted.
    pub(super) fn key(&self) -> (u32, Other, u32) {
        (self.block, self.other, self.facet)
    }

    /// All its numbers.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f64> {
        let single = [self.radius, self.inverse_mass, self.share, self.reference];
        let face = self.face.iter().flat_map(GhostFace::numbers);
        let beside = self.beside.into_iter().flatten();
        let vectors = self.spring.into_iter().chain(self.arm).chain(self.stiffness).chain(single).chain(beside).chain(face);
        self.touch.first().into_iter().chain(self.touch.second()).chain(vectors)
    }

    /// Force of the contact on the body, N.
    pub fn force(&self) -> [f64; 3] {
        plus(scaled(self.touch.force(), self.share), self.beside[0])
    }

    /// Torque of the contact on the body about its centre of mass, N m.
    pub(super) fn torque(&self) -> [f64; 3] {
        plus(cross(self.arm, scaled(self.touch.force(), self.share)), self.beside[1])
    }

    /// The same torque about the centre of mass of body `second`, which feels the opposite of it.
    pub(super) fn torque_about(&self, blocks: &[Block], second: usize) -> [f64; 3] {
        let between = less(blocks[self.block as usize].centre, blocks[second].centre);
        plus(self.torque(), cross(between, self.force()))
    }

    /// Whether a body is so deep in the other that the direction of their force would be lost, or a sphere about to pass through a sheet.
    fn is_too_deep(&self, bodies: &[PosedBlock<'_>]) -> bool {
        self.reference.is_finite() && self.touch.overlap + self.reference > self.deepest(bodies)
    }

    /// Largest overlap, m, at which it can be computed.
    fn deepest(&self, bodies: &[PosedBlock<'_>]) -> f64 {
        let radius = |k: u32| bodies[k as usize].outline.map_or(f64::INFINITY, |outline| outline.body.rounding());
        match self.other {
            Other::Block { block, .. } => DEEPEST * (radius(self.block) + radius(block)),
            Other::Grain(_) | Other::Point(_) => {
                let reach = self.radius + self.face.map_or(0.0, |face| face.beyond);
                let sheet = bodies[self.block as usize].block.solid().sheet();
                sheet.map_or(f64::INFINITY, |sheet| DEEPEST * (reach + sheet.rounding()))
            }
            Other::Wall { .. } => f64::INFINITY,
        }
    }

    /// As [`gap_at`], where it is of two bodies; 0 else.
    fn gap(&self, bodies: &[PosedBlock<'_>]) -> f64 {
        let Other::Block { block, site } = self.other else { return 0.0 };
        gap_at([self.block, block].map(|k| &bodies[k as usize]), site)
    }

    pub(super) fn is_of_point(&self) -> bool {
        matches!(self.other, Other::Point(_))
    }

    /// Elastic energy of the contact, J: `energy_factor` times normal force times overlap, and the energy of the tangential spring.
    pub(super) fn energy(&self, energy_factor: f64) -> f64 {
        let t = if self.spring == [0.0; 3] { self.touch.tangential } else { self.spring };
        let k_t = self.stiffness[1];
        let stored =
            energy_factor * self.touch.normal_force * self.touch.overlap + if k_t > 0.0 { 0.5 * dot(t, t) / k_t } else { 0.0 };
        self.share * stored
    }
}

/// Everything from which the forces of bodies are computed.
pub struct BlockScene<'a> {
    /// All grains.
    pub grains: &'a Grains,
    /// All walls of the grains.
    pub walls: &'a [Wall],
    /// The material points.
    pub continuum: &'a Continuum,
    /// Parameters of contacts with points.
    pub point_table: &'a PointContactTable,
    /// Parameters of contacts with grains and walls.
    pub table: &'a PairTable,
    /// Contact law.
    pub law: ContactLaw,
    /// What a tangential spring does when the normal force falls.
    pub unloading: TangentialUnloading,
    /// Time since forces were last computed, s.
    pub dt: f64,
    /// Times, s, by which positions are extrapolated: of bodies, and of points.
    pub ahead: [f64; 2],
}

impl BlockScene<'_> {
    /// Position of point `i`, m, extrapolated in time.
    fn point_at(&self, i: usize) -> [f64; 3] {
        let points = self.continuum.points();
        let [x, y, z, _] = points.position[i];
        plus([x, y, z], scaled(points.transport_velocity[i], self.ahead[1]))
    }
}

impl Blocks {
    /// Computes the forces of this instant, after [`Self::update`]: of contacts with points (`points`), or of all others. In parallel over contacts; each task writes only its own.
    pub fn evaluate(&mut self, scene: &BlockScene<'_>, points: bool) {
        if points && scene.continuum.points().is_empty() {
            return;
        }
        let rules = Rules { dt: scene.dt, unloading: scene.unloading, weighs_radius: true, task: TASK, arch: pulp::Arch::Scalar };
        let Blocks { blocks, outlines, contacts, .. } = self;
        let bodies = posed(blocks, outlines, scene.ahead[0]);
        contacts.follow(&bodies);
        let Contacts { others, pairs, .. } = &mut *contacts;
        if bodies.iter().any(|body| body.block.solid().facets() > 1) {
            let same = |a: &BlockContact, b: &BlockContact| (a.block, a.other) == (b.block, b.other);
            let groups = others.par_chunk_by_mut(same);
            groups.filter(|group| group[0].is_of_point() == points).for_each(|group| pass_on(scene, &bodies, group));
            if !points {
                let of_pair = |pair: &mut Near| pair.contacts.chunk_by_mut(same).for_each(|group| pass_on(scene, &bodies, group));
                pairs.par_iter_mut().with_min_len(TASK).for_each(of_pair);
            }
        }
        with_law!(scene.law, L => {
            let look = |c: &mut BlockContact| {
                let gap = touch::<L>(scene, &rules, &bodies, c);
                c.too_deep = c.is_too_deep(&bodies);
                gap
            };
            let looked_at = others.par_iter_mut().with_min_len(TASK).filter(|c| c.is_of_point() == points);
            looked_at.for_each(|c| _ = look(c));
            if !points {
                let gap = |pair: [u32; 2], site| gap_at(pair.map(|k| &bodies[k as usize]), site);
                pairs.par_iter_mut().with_min_len(TASK).for_each(|pair| pair.look(gap, look));
            }
        });
        contacts.list();
    }

    /// Moves the faces of points with the nodes, after a step of the continuum of `dt` seconds.
    pub fn follow_faces(&mut self, grains: &Grains, continuum: &Continuum, dt: f64) {
        if continuum.points().is_empty() {
            return;
        }
        self.locate(grains, continuum);
        for c in &mut self.contacts.others {
            if let Some(face) = &mut c.face {
                face.follow(continuum, c.place as usize, [c.radius, c.touch.overlap], dt);
            }
        }
    }

    /// Contacts that touch, in the order of the list.
    pub fn touching(&self) -> impl Iterator<Item = &BlockContact> {
        self.contacts.touching()
    }

    /// Adds `of_blocks` times the force of each contact with a point to its body, and `of_points` times the opposite force, with `stiff` times the larger
    /// tangent stiffness, to the face of the point.
    pub fn apply_point_reactions(
        &mut self,
        of_blocks: f64,
        (continuum, acts_on): (&mut Continuum, ActsOn),
        [of_points, stiff]: [f64; 2],
    ) {
        if continuum.points().is_empty() {
            return;
        }
        for c in self.contacts.touching().filter(|c| c.is_of_point()) {
            let (force, [k_n, k_t]) = (c.force(), c.stiffness);
            let (push, stiffness) = (force.map(|f| -(of_points * f)), stiff * k_n.max(k_t));
            GhostFace::push((acts_on, c.face), [c.radius, c.touch.overlap], continuum, c.place as usize, push, stiffness);
            add_force_and_torque(&mut self.applied[c.block as usize], c, of_blocks);
        }
    }

    /// Adds the forces of contacts with grains, walls and other bodies to bodies and to `external_forces` (force, N, and torque, N m, by index of the grain).
    pub fn apply_grain_and_wall_reactions(&mut self, grains: &Grains, external_forces: &mut Vec<[[f64; 4]; 2]>) {
        external_forces.resize(grains.len(), [[0.0; 4]; 2]);
        for c in self.contacts.touching().filter(|c| !c.is_of_point()) {
            add_force_and_torque(&mut self.applied[c.block as usize], c, 1.0);
            match c.other {
                Other::Grain(_) => {
                    let i = c.place as usize;
                    let arm = c.share * (grains.radius(i) - 0.5 * c.touch.overlap);
                    // what acts beside goes through the centre of the grain
                    let (force, torque) = (c.force(), scaled(cross(c.touch.normal, c.touch.tangential), arm));
                    for a in 0..3 {
                        external_forces[i][0][a] -= force[a];
                        external_forces[i][1][a] += torque[a];
                    }
                }
                Other::Block { block, .. } => {
                    // equal and opposite, about the centre of the second
                    let (second, force) = (block as usize, c.force());
                    let torque = c.torque_about(&self.blocks, second);
                    let applied = &mut self.applied[second];
                    *applied = [less(applied[0], force), less(applied[1], torque)];
                }
                Other::Point(_) | Other::Wall { .. } => {}
            }
        }
    }

    /// Adds the normal forces of the bodies on the walls, N, and the stiffnesses of these contacts, N/m, to `sums`, one for each wall.
    pub fn add_wall_forces(&self, sums: &mut [[f64; 2]]) {
        for c in self.touching() {
            if let Other::Wall { wall, .. } = c.other {
                let [force, stiffness] = &mut sums[wall as usize];
                (*force, *stiffness) = (*force + c.touch.normal_force, *stiffness + c.stiffness[0]);
            }
        }
    }

    /// Largest sums of stiffness over mass of a point, and of a body or grain, over the present contacts of bodies. `points`: number of points. A contact of two
    /// bodies counts once at each, as if the other stood still; of two alike the square of the frequency is up to twice as large. Free steps of bodies are far
    /// below what that asks: a tower of ten cubes stands with six times its step.
    pub fn rates(&mut self, grains: &Grains, points: usize) -> ContactRates {
        self.outline();
        let mut of_blocks = vec![0.0; self.blocks.len()];
        self.add_joint_rates(&mut of_blocks);
        let by_joints = of_blocks.iter().copied().fold(0.0, f64::max);
        let [of_points, of_grains] = &mut self.sums;
        of_points.resize(points, 0.0);
        of_grains.resize(grains.len(), 0.0);
        let mut most = ContactRates { grains: by_joints, ..ContactRates::default() };
        if self.first_touch > 0.0 && self.contacts.others.iter().any(BlockContact::is_of_point) {
            most.points = self.first_touch;
        }
        let touching = self.contacts.touching();
        // side by side in memory
        let yields: Vec<Yields> = self.outlines.iter().map(|outline| outline.yields).collect();
        for c in touching.clone() {
            let ([k_n, k_t], i) = (c.stiffness.map(|k| c.share * k), c.place as usize);
            let k = k_n.max(k_t);
            let mut add = |body: u32, arm: [f64; 3]| {
                let sum = &mut of_blocks[body as usize];
                *sum += k * yields[body as usize].most_at(arm);
                most.grains = most.grains.max(*sum);
            };
            add(c.block, c.arm);
            match c.other {
                Other::Block { block, .. } => {
                    let at = plus(self.blocks[c.block as usize].centre, c.arm);
                    add(block, less(at, self.blocks[block as usize].centre));
                }
                Other::Point(_) => {
                    of_points[i] += k * c.inverse_mass;
                    most.points = most.points.max(of_points[i]);
                }
                Other::Grain(_) => {
                    of_grains[i] += k_n.max(3.5 * k_t) * c.inverse_mass;
                    most.grains = most.grains.max(of_grains[i]);
                }
                Other::Wall { .. } => {}
            }
        }
        // zeros again, where the sums were changed
        for c in touching {
            match c.other {
                Other::Point(_) => of_points[c.place as usize] = 0.0,
                Other::Grain(_) => of_grains[c.place as usize] = 0.0,
                Other::Wall { .. } | Other::Block { .. } => {}
            }
        }
        most
    }
}

/// Adds `share` times the force of a contact, and its torque about the body's centre of mass.
fn add_force_and_torque(applied: &mut [[f64; 3]; 2], c: &BlockContact, share: f64) {
    applied[0] = plus(applied[0], scaled(c.force(), share));
    applied[1] = plus(applied[1], scaled(c.torque(), share));
}

/// A body with its present position, orientation and angular velocity.
pub(super) struct PosedBlock<'a> {
    pub block: &'a Block,
    pub pose: Pose,
    pub spin: [f64; 3],
    /// How it yields to forces.
    pub yields: Yields,
    /// What other bodies touch of it.
    pub outline: Option<&'a Outline>,
}

/// All bodies, `ahead` seconds from now.
pub(super) fn posed<'a>(blocks: &'a [Block], outlines: &'a [Outline], ahead: f64) -> Vec<PosedBlock<'a>> {
    blocks.iter().zip(outlines).map(|(block, outline)| PosedBlock::new(block, Some(outline), ahead)).collect()
}

/// The other side of a contact that touches, as the contact law needs it.
struct Across {
    /// Unit normal out of the body.
    normal: [f64; 3],
    /// Overlap, m.
    overlap: f64,
    /// Reduced radius R*, m.
    r_eff: f64,
    /// Contact point, m.
    at: [f64; 3],
    /// Velocity of the other surface at the contact point, m/s.
    velocity: [f64; 3],
    /// Angular velocity of the other side, rad/s.
    spin: [f64; 3],
    /// Inverse mass of the other side, 1/kg.
    inverse_mass: f64,
    pair: Pair,
    /// Of two edges: the overlaps of the ends of each with the other. On a sheet: those with the borders of the facet beside which it counts less.
    ends: Option<[Overlap; 4]>,
    /// The facets beyond those borders.
    borders: Vec<u32>,
}

/// How a sphere meets a body.
struct Met {
    /// Their overlap; the normal points out of the body.
    on: Overlap,
    /// Borders beside which it counts less, with the facet beyond each.
    borders: Vec<(u32, Overlap)>,
}

/// Borders of a facet as the ends of [`Across`], and the facets beyond them.
fn ends_at(borders: &[(u32, Overlap)]) -> (Option<[Overlap; 4]>, Vec<u32>) {
    let ends = (!borders.is_empty()).then(|| std::array::from_fn(|k| borders.get(k).map_or(Overlap::NONE, |border| border.1)));
    (ends, borders.iter().map(|border| border.0).collect())
}

impl<'a> PosedBlock<'a> {
    /// The body `ahead` seconds from now.
    pub fn new(block: &'a Block, outline: Option<&'a Outline>, ahead: f64) -> PosedBlock<'a> {
        let yields = outline.map_or_else(|| block.yields(), |outline| outline.yields);
        PosedBlock { block, pose: block.pose(ahead), spin: block.spin(), yields, outline }
    }

    /// Contact of facet `facet` with a sphere, if they overlap.
    fn meets(&self, facet: u32, centre: [f64; 3], radius: f64) -> Option<Met> {
        let Meet { nearest, borders } = self.block.solid().meet(facet, self.pose.within(centre), radius)?;
        let overlap = |nearest: &Nearest| {
            let (normal, depth) = (self.pose.outwards(nearest.normal), radius - nearest.distance);
            Overlap { normal, depth, at: less(centre, scaled(normal, radius - 0.5 * depth)) }
        };
        let on = overlap(&nearest);
        let borders = borders.iter().map(|(other, border)| (*other, overlap(border))).collect();
        (on.depth > 0.0).then_some(Met { on, borders })
    }

    /// Inverse of the effective mass of the body, 1/kg, for an impulse along `normal` at the end of `arm`.
    pub fn inverse_mass(&self, arm: [f64; 3], normal: [f64; 3]) -> f64 {
        let (yields, turn) = (&self.yields, self.pose.inwards(cross(arm, normal)));
        (0..3).fold(yields.inverse_mass, |sum, a| sum + turn[a] * turn[a] * yields.inverse_moments[a])
    }
}

/// The other side of contact `c`, if they touch.
fn across(scene: &BlockScene<'_>, bodies: &[PosedBlock<'_>], c: &BlockContact) -> Option<Across> {
    let (body, i) = (&bodies[c.block as usize], c.place as usize);
    Some(match c.other {
        Other::Point(_) => {
            let points = scene.continuum.points();
            let (centre, transport) = (scene.point_at(i), points.transport_velocity[i]);
            let (beyond, velocity) = c.face.map_or((0.0, transport), |face| (face.beyond, face.velocity));
            let Met { on: Overlap { normal, depth: overlap, at }, borders } = body.meets(c.facet, centre, c.radius + beyond)?;
            let (ends, borders) = ends_at(&borders);
            let pair = scene.point_table.at_plastic_strain(points.law[i], body.block.material, points.memory[i].plastic);
            let inverse_mass = 1.0 / points.velocity[i][3];
            Across { normal, overlap, r_eff: c.radius, at, velocity, spin: [0.0; 3], inverse_mass, pair, ends, borders }
        }
        Other::Grain(_) => {
            let g = scene.grains;
            let ([x, y, z, radius], [u, v, w, inverse_mass], [p, q, r, _]) = (g.pos[i], g.vel[i], g.spin[i]);
            let Met { on: Overlap { normal, depth: overlap, at }, borders } = body.meets(c.facet, [x, y, z], radius)?;
            let (ends, borders) = ends_at(&borders);
            let spin = [p, q, r];
            let velocity = plus([u, v, w], cross(spin, less(at, [x, y, z])));
            let pair = *scene.table.grains(body.block.material, g.material[i]);
            Across { normal, overlap, r_eff: radius, at, velocity, spin, inverse_mass, pair, ends, borders }
        }
        Other::Wall { wall: k, spot } => {
            let (wall, k) = (&scene.walls[k as usize], k as usize);
            let (towards, gap, spot) = spot_at(wall, body.block, &body.pose, spot as usize);
            if gap >= 0.0 {
                return None;
            }
            // the wall moves against `towards`
            let velocity = scaled(towards, -wall.speed);
            let at = less(spot, scaled(towards, -gap));
            let pair = *scene.table.wall(k, body.block.material);
            let (r_eff, overlap, normal) = (body.block.radius, -gap, towards);
            let (spin, inverse_mass, borders) = ([0.0; 3], 0.0, Vec::new());
            Across { normal, overlap, r_eff, at, velocity, spin, inverse_mass, pair, ends: None, borders }
        }
        Other::Block { block, site } => {
            let other = &bodies[block as usize];
            let was = (c.touch.overlap > 0.0).then_some(c.touch.normal);
            let Meeting { overlap: Overlap { normal, depth: overlap, at }, ends, borders } =
                meeting(body, other, (site, c.facet), was, 0.0)?;
            if overlap <= 0.0 {
                return None;
            }
            let (beside, borders) = ends_at(&borders);
            let ends = ends.or(beside);
            let arm = less(at, other.pose.centre);
            let velocity = plus(other.block.velocity, cross(other.spin, arm));
            let inverse_mass = other.inverse_mass(arm, normal);
            let pair = *scene.table.grains(body.block.material, other.block.material);
            let r_eff = reduced(body.block.radius, other.block.radius);
            Across { normal, overlap, r_eff, at, velocity, spin: other.spin, inverse_mass, pair, ends, borders }
        }
    })
}

/// R* of two bodies, m, by the radii of the spheres of their volumes. A sheet, whose radius is infinite, is as a plane.
pub(super) fn reduced(r: f64, s: f64) -> f64 {
    if r.is_infinite() || s.is_infinite() { r.min(s) } else { r * s / (r + s) }
}

impl Across {
    /// The contact less the overlap with which it was born, which is set to the present one where that is smaller; `None`: nothing is left.
    fn less_born(mut self, reference: &mut f64) -> Option<Across> {
        if *reference == 0.0 {
            return Some(self);
        }
        *reference = reference.min(self.overlap);
        self.overlap -= *reference;
        for end in self.ends.iter_mut().flatten() {
            end.depth -= *reference;
        }
        (self.overlap > 0.0).then_some(self)
    }
}

/// Of spot `spot` of a body: unit normal towards the wall, gap to the wall, m, and position of the spot, m.
pub(super) fn spot_at(wall: &Wall, block: &Block, pose: &Pose, spot: usize) -> ([f64; 3], f64, [f64; 3]) {
    let [x, y, z] = pose.centre;
    let (towards, _) = wall.shape.towards([x, y, z, 0.0]);
    let at = plus(pose.centre, pose.outwards(block.solid().spot(spot, pose.inwards(towards))));
    let (towards, gap) = wall.shape.towards([at[0], at[1], at[2], 0.0]);
    (towards, gap, at)
}

/// Computes the force of contact `c` and stores it there. Of one that does not touch a bound below on the gap, m; 0 where it is to be looked at again next time.
fn touch<L: Law>(scene: &BlockScene<'_>, rules: &Rules, bodies: &[PosedBlock<'_>], c: &mut BlockContact) -> f64 {
    let body = &bodies[c.block as usize];
    let spring = L::VISCOUS.then_some(c.spring);
    let old = ContactHistory { touch: c.touch, spring, rolling: None, load: None, largest: None, work: None };
    let met = across(scene, bodies, c);
    let mut gap = 0.0;
    if met.is_none() {
        (c.reference, gap) = (0.0, c.gap(bodies));
    }
    let Some(o) = met.and_then(|o| o.less_born(&mut c.reference)) else {
        if c.touch.overlap > 0.0 {
            (c.touch, c.spring, c.stiffness) = (ContactForce::default(), [0.0; 3], [0.0; 2]);
        }
        if c.face.is_some() && body.meets(c.facet, scene.point_at(c.place as usize), c.radius).is_none() {
            c.face = None;
        }
        return gap;
    };
    if scene.point_table.acts_on == ActsOn::Face && c.is_of_point() {
        match &mut c.face {
            Some(face) => face.normal = o.normal,
            face => *face = Some(GhostFace::at_first_touch(o.normal, o.velocity)),
        }
    }
    let arm = less(o.at, body.pose.centre);
    let here = plus(body.block.velocity, cross(body.spin, arm));
    // with walls the spin of the body alone counts, as for grains on walls
    let wall = matches!(c.other, Other::Wall { .. });
    let mean_spin = if wall { body.spin } else { scaled(plus(body.spin, o.spin), 0.5) };
    // velocities at the contact point are known, so the part that the law adds for the rotation about the centres must vanish
    let turning = scaled(mean_spin, o.overlap);
    let motion = RelativeMotion { centres: less(here, o.velocity), turning, mean_spin, spin_difference: less(body.spin, o.spin) };
    let yields = body.inverse_mass(arm, o.normal) + o.inverse_mass;
    // a driven body on a wall: neither gives way
    let m_eff = if L::VISCOUS && yields > 0.0 { 1.0 / yields } else { 0.0 };
    let geometry = ContactGeometry { normal: o.normal, overlap: o.overlap, r_eff: o.r_eff, m_eff, motion };
    let new = force::touching::<f64, L, false, true>(&geometry, &o.pair, rules, &old);
    let e = L::elastic(o.overlap, o.overlap, o.r_eff, &o.pair);
    (c.touch, c.spring) = (new.touch, new.spring.unwrap_or_default());
    (c.arm, c.stiffness, c.inverse_mass) = (arm, [e.k_n, e.k_t], o.inverse_mass);
    (c.share, c.beside) = match &o.ends {
        Some(ends) => beside_ends(&o, ends, |overlap| L::elastic(overlap, overlap, o.r_eff, &o.pair), body.pose.centre),
        None => (1.0, [[0.0; 3]; 2]),
    };
    0.0
}

/// Hands on histories among the contacts of one sphere or corner with the facets of one sheet, or the parts of one compound: a contact that begins beside another one takes over what that has. It is
/// moved where the sphere has passed over the border between their facets, and copied where it touches both and their common border is in reach. What slides over
/// a curved sheet so keeps its friction.
fn pass_on(scene: &BlockScene<'_>, bodies: &[PosedBlock<'_>], group: &mut [BlockContact]) {
    let touched: Vec<bool> = group.iter().map(|c| c.touch.overlap > 0.0).collect();
    if group.len() < 2 || !touched.contains(&true) {
        return;
    }
    let now: Vec<Option<Across>> = group.iter().map(|c| across(scene, bodies, c)).collect();
    let mut handed = vec![false; group.len()];
    for new in 0..group.len() {
        let Some(begins) = now[new].as_ref().filter(|_| !touched[new]) else { continue };
        let beside = |old: usize| match now[old] {
            Some(_) => begins.borders.contains(&group[old].facet),
            None => !handed[old] && has_passed(scene, bodies, &group[old], group[new].facet),
        };
        let Some(old) = (0..group.len()).find(|&old| touched[old] && beside(old)) else { continue };
        let BlockContact { touch, spring, face, reference, .. } = group[old];
        (group[new].touch, group[new].spring, group[new].face, group[new].reference) = (touch, spring, face, reference);
        if now[old].is_none() {
            handed[old] = true;
            group[old].face = None;
        }
    }
}

/// Whether the sphere or corner of contact `c` has passed from its facet to facet `to`.
fn has_passed(scene: &BlockScene<'_>, bodies: &[PosedBlock<'_>], c: &BlockContact, to: u32) -> bool {
    let body = &bodies[c.block as usize];
    // a contact may end some way beyond its reach
    let passes = |on: &PosedBlock<'_>, at: [f64; 3], radius: f64| on.block.solid().passes(c.facet, to, at, 2.0 * radius);
    match c.other {
        Other::Point(_) => {
            let radius = c.radius + c.face.map_or(0.0, |face| face.beyond);
            passes(body, body.pose.within(scene.point_at(c.place as usize)), radius)
        }
        Other::Grain(_) => {
            let [x, y, z, radius] = scene.grains.pos[c.place as usize];
            passes(body, body.pose.within([x, y, z]), radius)
        }
        Other::Block { block, site } => {
            let corner = corner_on_facets(body, &bodies[block as usize], (site, c.facet));
            let passes = |on: &Outline, at, radius: f64| on.body.passes(c.facet, to, at, 2.0 * radius);
            corner.is_some_and(|(on, at, radius)| on.outline.is_some_and(|outline| passes(outline, at, radius)))
        }
        Other::Wall { .. } => false,
    }
}

/// Of two edges that touch beside ends of theirs, or of a sphere on a facet beside its borders: the share Π (1 − φ_i) of their contact that acts, φ_i = Φ(δ_i)/Φ(δ), and what the energy U = Φ(δ) Π (1 − φ_i)
/// gives besides, as force, N, on the first body and torque about its `centre`, N m (`pair.rs`):
///
/// −∇U = F(δ) [Π (1 − φ_j) + Σ φ_i Π_{j≠i} (1 − φ_j)] − Σ F(δ_i) Π_{j≠i} (1 − φ_j), each force along its own normal, at its own place.
fn beside_ends(o: &Across, ends: &[Overlap; 4], elastic: impl Fn(f64) -> Elastic, centre: [f64; 3]) -> (f64, [[f64; 3]; 2]) {
    let whole = elastic(o.overlap);
    let of = ends.map(|end| (end.depth > 0.0).then(|| elastic(end.depth)));
    let left: [f64; 4] = std::array::from_fn(|i| 1.0 - of[i].map_or(0.0, |e| (e.energy / whole.energy).min(1.0)));
    let mut sum = [[0.0; 3]; 2];
    let mut add = |force: f64, normal: [f64; 3], at: [f64; 3]| {
        // a force on the first body acts against the normal out of it
        let push = scaled(normal, -force);
        sum = [plus(sum[0], push), plus(sum[1], cross(less(at, centre), push))];
    };
    for (i, end) in ends.iter().enumerate() {
        let Some(e) = of[i] else { continue };
        let others = (0..4).filter(|&j| j != i).map(|j| left[j]).product::<f64>();
        add((1.0 - left[i]) * others * whole.force, o.normal, o.at);
        add(-(others * e.force), end.normal, end.at);
    }
    (left.into_iter().product(), sum)
}
