//! Search for what is near rigid bodies: points, grains, walls and other bodies.

use super::contact::{posed, spot_at};
use super::near::{Moment, Near};
use super::pair::DEEPEST;
use super::{BlockContact, Blocks, Breaking, Other};
use crate::boundary::Wall;
use crate::error::{Error, Result};
use crate::grains::Grains;
use crate::math::vector::{dot, less};
use crate::mpm::Continuum;
use crate::mpm::loading_plate::ghost_radius;
use crate::point_contacts::{NOWHERE, by_id, remember};
use rayon::prelude::*;

/// Pairs of bodies whose sites one parallel task seeks.
const PAIRS: usize = 8;

impl Blocks {
    /// Lists anew what is near if something outside of the list may touch; else only brings indices up to date. Seeks the sites of pairs of bodies that have moved. `way`: distance by which a body and anything
    /// else may have come closer since the last call, m; `ahead`: time, s, by which positions of bodies will be extrapolated.
    ///
    /// # Errors
    /// Bodies that are deep in each other.
    pub fn update(&mut self, grains: &Grains, walls: &[Wall], continuum: &Continuum, way: f64, ahead: f64) -> Result<()> {
        let alive = [grains.len(), continuum.points().len()];
        self.outline();
        self.passable(continuum)?;
        self.looks += 1;
        if let Some(skin) = self.age.due(way, alive, continuum.settings().cell) {
            self.search(grains, walls, continuum, skin);
        } else {
            self.locate(grains, continuum);
        }
        self.seek(ahead);
        Ok(())
    }

    /// Makes the next update search anew, and forgets how far bodies have moved: some are others now.
    pub(super) fn forget_list(&mut self) {
        self.contacts.forget();
        self.age.forget();
    }

    /// Pairs of bodies whose spheres of reach are nearer than `skin`, m, and that no joint holds; the lower index first. Bodies are sorted by where they begin along x.
    pub(super) fn near(&self, skin: f64) -> Vec<[usize; 2]> {
        struct Ball {
            begin: f64,
            centre: [f64; 3],
            reach: f64,
            block: usize,
            driven: bool,
        }
        let ball = |(block, b): (usize, &super::Block)| {
            let reach = b.solid().reach();
            Ball { begin: b.centre[0] - reach, centre: b.centre, reach, block, driven: b.driven }
        };
        let mut balls: Vec<Ball> = self.blocks.iter().enumerate().map(ball).collect();
        balls.sort_by(|a, b| a.begin.total_cmp(&b.begin));
        let joined = self.drives.as_ref().map_or(Vec::new(), |drives| drives.joined());
        let mut pairs = Vec::new();
        for (n, a) in balls.iter().enumerate() {
            let end = a.centre[0] + a.reach + skin;
            for b in balls[n + 1..].iter().take_while(|b| b.begin < end) {
                let (away, far) = (less(a.centre, b.centre), a.reach + b.reach + skin);
                // what driven bodies press on each other moves neither
                if dot(away, away) >= far * far || a.driven && b.driven {
                    continue;
                }
                let pair = [a.block.min(b.block), a.block.max(b.block)];
                if joined.is_empty() || joined.binary_search(&pair.map(|k| k as u32)).is_err() {
                    pairs.push(pair);
                }
            }
        }
        pairs
    }

    /// Checks that no body is so deep in another that the direction of their force would be lost, and that nothing is about to pass through a sheet.
    fn passable(&self, continuum: &Continuum) -> Result<()> {
        let (step, Some(c)) = (continuum.steps(), self.contacts.deep()) else { return Ok(()) };
        let (by, cure) =
            (format!("{:.4} mm", 1e3 * (c.touch.overlap + c.reference)), "stiffer materials, or lower stepping.safety");
        let through = |what: &str, id: u32| {
            format!(
                "{what} {id} overlaps by {by}, {DEEPEST} of its radius, with the sheet of block {}, and would pass through it: give the mesh a larger rounding_mm or {cure}",
                c.block
            )
        };
        let (what, grain) = match c.other {
            Other::Block { block, .. } => {
                let of = c.block;
                (
                    format!(
                        "blocks {of} and {block} overlap by {by}, {DEEPEST} of the radii of their edges: give them a larger rounding_mm or {cure}"
                    ),
                    None,
                )
            }
            Other::Grain(id) => (through("grain", id), Some(u64::from(id))),
            Other::Point(id) => (through("point", id), None),
            Other::Wall { .. } => return Ok(()),
        };
        Err(Error::Unstable { step, what, grain })
    }

    /// Makes the list anew: pairs of bodies, and points, grains and walls with a gap to a body, that may be below `skin`, m. Contacts keep their history.
    fn search(&mut self, grains: &Grains, walls: &[Wall], continuum: &Continuum, skin: f64) {
        let mut near = self.near(skin);
        near.sort_unstable();
        self.contacts.list_pairs(&near);
        let mut others = self.others(grains, walls, continuum, skin);
        others.sort_unstable_by_key(BlockContact::key);
        if let Some(Breaking { newborn, .. }) = self.breaking.as_deref() {
            others.iter_mut().filter(|c| newborn.contains(&c.block)).for_each(|c| c.reference = f64::INFINITY);
        }
        let known = self.contacts.others.iter().filter(|c| c.touch.overlap > 0.0 || c.face.is_some() || c.reference > 0.0);
        // reactions may be added again before forces are computed: all but the other side's place and size stays
        let keep =
            |old: &BlockContact, new: &mut BlockContact| *new = BlockContact { place: new.place, radius: new.radius, ..*old };
        remember(known, &mut others, BlockContact::key, keep);
        self.contacts.replace_others(others);
    }

    /// Points, grains and walls with a gap to a body below `skin`, m.
    fn others(&self, grains: &Grains, walls: &[Wall], continuum: &Continuum, skin: f64) -> Vec<BlockContact> {
        let (points, dimension) = (continuum.points(), continuum.settings().dimension);
        let most = (0..points.len()).map(|i| points.solid(i)).fold(0.0, f64::max);
        // a face may lie further from its point than the ghost radius
        let beyond = self.contacts.others.iter().filter_map(|c| c.face).map(|face| face.beyond).fold(0.0, f64::max);
        let radius_of = |solid: f64| self.point_radius.unwrap_or_else(|| ghost_radius(dimension, solid));
        let widest = radius_of(most) + beyond + skin;
        let mut found: Vec<BlockContact> = Vec::new();
        for (k, block) in self.blocks.iter().enumerate() {
            let (solid, pose, block_index) = (block.solid(), block.pose(0.0), k as u32);
            let mut facets = Vec::new();
            let mut near = |p: &[f64; 4], far: f64, found: &mut Vec<BlockContact>, other: Other, place: usize, radius: f64| {
                let local = pose.inwards(std::array::from_fn(|a| p[a] - pose.centre[a]));
                solid.facets_near(local, far, &mut facets);
                found.extend(facets.drain(..).map(|facet| BlockContact::new(block_index, other, facet, place as u32, radius)));
            };
            let far = solid.reach() + widest;
            let corners = [-far, far].map(|by| std::array::from_fn(|a| pose.centre[a] + by));
            if self.at_nodes.is_none() {
                continuum.visit(corners, |i| {
                    let radius = radius_of(points.solid(i));
                    near(&points.position[i], radius + beyond + skin, &mut found, Other::Point(points.id[i]), i, radius);
                });
            }
            for (i, p) in grains.pos.iter().enumerate() {
                near(p, p[3] + skin, &mut found, Other::Grain(grains.id[i]), i, p[3]);
            }
            for (w, wall) in walls.iter().enumerate() {
                for spot in (0..solid.spots()).filter(|&spot| spot_at(wall, block, &pose, spot).1 < skin) {
                    found.push(BlockContact::new(block_index, Other::Wall { wall: w as u32, spot: spot as u32 }, 0, 0, 0.0));
                }
            }
        }
        found
    }

    /// Seeks the sites of the listed pairs of bodies that have moved enough. Contacts of bodies that have just been born, or were joined until now, begin without force.
    fn seek(&mut self, ahead: f64) {
        let Blocks { contacts, blocks, outlines, age, looks, breaking, drives, .. } = self;
        let newborn = breaking.as_mut().map_or(Vec::new(), |breaking| std::mem::take(&mut breaking.newborn));
        let parted = drives.as_mut().map_or(Vec::new(), |drives| std::mem::take(&mut drives.parted));
        let (bodies, now) = (posed(blocks, outlines, ahead), Moment { look: *looks, skin: age.skin() });
        contacts.follow(&bodies);
        let mut due: Vec<&mut Near> = contacts.pairs.iter_mut().filter(|pair| pair.is_due()).collect();
        if due.is_empty() {
            return;
        }
        due.par_iter_mut().with_min_len(PAIRS).for_each(|pair| {
            let born = parted.contains(&pair.bodies) || pair.bodies.iter().any(|body| newborn.contains(body));
            pair.seek(&bodies, now, born);
        });
        contacts.unlist();
    }

    /// Brings the indices of grains and points up to date, whose arrays may have been sorted.
    pub(super) fn locate(&mut self, grains: &Grains, continuum: &Continuum) {
        let (points, place) = (continuum.points(), |c: &BlockContact| c.place as usize);
        if grains.is_empty() && points.is_empty() && self.age.may_stand([0; 2]) {
            return;
        }
        let [of_grains, of_points] = &mut self.index;
        let grain_at = |c: &BlockContact| matches!(c.other, Other::Grain(id) if grains.id.get(place(c)) != Some(&id));
        if self.contacts.others.iter().any(grain_at) {
            by_id(of_grains, &grains.id, grains.next_id);
        }
        let point_at = |c: &BlockContact| matches!(c.other, Other::Point(id) if points.id.get(place(c)) != Some(&id));
        if self.contacts.others.iter().any(point_at) {
            by_id(of_points, &points.id, points.next_id);
        }
        for c in &mut self.contacts.others {
            match c.other {
                Other::Grain(id) if grains.id.get(c.place as usize) != Some(&id) => c.place = of_grains[id as usize],
                Other::Point(id) if points.id.get(c.place as usize) != Some(&id) => c.place = of_points[id as usize],
                _ => {}
            }
        }
        // grains that have broken
        if self.contacts.others.iter().any(|c| c.place == NOWHERE) {
            self.contacts.retain(|c| c.place != NOWHERE);
        }
    }
}

impl super::Block {
    /// Largest distance by which the body reaches behind a wall, m; negative if the body is in front of it.
    pub fn deepest(&self, wall: &Wall) -> f64 {
        let pose = self.pose(0.0);
        (0..self.solid().spots()).map(|spot| -spot_at(wall, self, &pose, spot).1).fold(f64::NEG_INFINITY, f64::max)
    }
}
