//! Makes the model of a mixture from its keys: the continuum, and the grains in it.

use super::bed::solid_volume;
use super::block_sets::make_room;
use super::material::Named;
use super::view::View;
use crate::model::GrainSpec;
use crate::model::continuum::{CoarseGrains, Fraction, MpmSpecimen, MpmTest};
use crate::model::validity::refusal;
use crate::packing::dispersed;
use engine::boundary::{Drive, WallSpec};
use engine::contact::ContactLaw;
use engine::coupling::{Rates, Rule};
use engine::grains::sphere_volume;
use engine::material::Material;
use engine::mpm::loading_plate::ghost_radius;
use engine::mpm::{Dimension, Points};
use engine::point_contacts::ActsOn;
use engine::rigid::Programme;
use engine::shape::Shape;

/// Keys that make spheres in a specimen.
const SPHERES: [&str; 2] = ["coarse.mass_fraction", "growth.fines_diameter_mm"];
/// Gap between coarse grains, and between them and platens, when they are placed at random, over the distance of two points.
const ROOM: f64 = 0.5;
/// Coarse grains that an outline places ([`super::outline`]).
const FEW: usize = 500;
/// Pairs of a body and a point that an outline compares.
const COMPARED: usize = 50_000_000;
/// Largest overlap of a grain with a platen at the start, over the radius of the grain.
const DEEP: f64 = 0.01;

impl View<'_> {
    /// The continuum with its grains; `None`, with the reasons noted, where the scene is refused.
    pub fn mixture(&self, named: &[Named], materials: &[Material]) -> Option<MpmTest> {
        self.plane_of_blocks();
        let unscaled = !self.flag("stepping.inertia_scaling");
        self.check(unscaled, "stepping.inertia_scaling", "must be false in a mixture: a continuum moves in time");
        let plain = self.si("specimen.scale") == 1.0;
        self.check(plain, "specimen.scale", "must be 1 in a mixture");
        let (fines, point_materials): (Vec<Named>, Vec<u8>) = named
            .iter()
            .enumerate()
            .filter(|(_, n)| self.has(&n.key("continuum")))
            .map(|(i, n)| (Named { name: n.name.clone(), at: n.at.clone() }, i as u8))
            .unzip();
        if fines.is_empty() && !self.is_without_points() {
            self.refuse("materials", "must have one with [continuum], for the points");
            return None;
        }
        let test = self.text("test.rig") != "free";
        let mut grains = if self.list("grain").is_empty() { Vec::new() } else { self.grains(named)? };
        let walls = self.walls(named, &grains);
        let mut blocks = self.blocks(named, materials)?;
        let programmes = self.programmes(&mut blocks)?;
        let joints = self.joints(&blocks)?;
        self.check(!test || joints.is_empty(), "joint", "has no meaning in a test: joints are for test.rig = \"free\"");
        if test {
            self.blocks_are_left_alone(&blocks, &programmes);
        }
        let mut growth = None;
        let mut unplaced = 0;
        let sizes = grains.iter().map(|g| 2.0 * g.radius).chain(blocks.iter().map(|b| 2.0 * b.radius));
        // a mesh by itself has no size
        let smallest = Some(sizes.fold(f64::INFINITY, f64::min)).filter(|size| size.is_finite()).unwrap_or(1.0);
        let point_radius = self.number("contact.point_radius_mm");
        let mut rig = self.continuum_rig(&fines, smallest, |points, settings, test| {
            let radius =
                |points: &Points, i: usize| point_radius.unwrap_or_else(|| ghost_radius(settings.dimension, points.solid(i)));
            // points make room for those that a set has placed, in a test for all
            let placed = if test.specimen().is_some() { 0 } else { self.list("block").len() };
            make_room(points, &blocks[placed..], radius);
            growth = self.growth(named, materials, &point_materials, test.specimen())?;
            // the points and grains of a specimen that grows only serve to estimate the run
            if growth.is_some() {
                return Some(());
            }
            if let Some(specimen) = test.specimen() {
                self.grains_inside(&grains, specimen);
                if specimen.bed.is_some() {
                    return Some(());
                }
                let density = materials[usize::from(point_materials[usize::from(points.law[0])])].density;
                let (placed, others) = self.coarse(named, materials, specimen, density, points.len())?;
                grains.extend(placed);
                unplaced = others;
                let law = self.law();
                let ghost = |law: u8| &materials[usize::from(point_materials[usize::from(law)])];
                displace(points, settings.dimension, specimen, &grains, |fine, g, r_eff| {
                    let pair = law.between(&materials[usize::from(g.material)], ghost(fine));
                    law.overlap_under(specimen.stress * specimen.spacing * specimen.spacing, r_eff, &pair)
                });
            }
            Some(())
        })?;
        self.check(!test || walls.is_empty(), "wall", "has no meaning in a test, which sets its own");
        self.walls_hold(&walls, materials);
        let asked = |key: &str| self.whole(key).map(|n| n as u32);
        let rates = match (asked("stepping.grain_steps"), asked("stepping.continuum_steps")) {
            (None, None) if self.number("stepping.dt_s").is_none() => None,
            (grains, continuum) => {
                let rates = Rates { grains: grains.unwrap_or(1), continuum: continuum.unwrap_or(1) };
                let one = rates.grains == 1 || rates.continuum == 1;
                self.check(one, "stepping.continuum_steps", "must be 1 where stepping.grain_steps is more: one side is the slower");
                Some(rates)
            }
        };
        rig.growth = growth;
        rig.left_out[1] = unplaced;
        let dimension = rig.settings.dimension;
        if let Some(specimen) = rig.test.specimen_mut() {
            self.bodies_fill(specimen, dimension, &blocks, materials)?;
        }
        if let (Some(specimen), None) = (rig.specimen(), &rig.growth) {
            // points that an outline leaves out make room for the grains as well
            let placed: f64 = grains.iter().map(|g| sphere_volume(g.radius)).sum();
            let all = placed * (1.0 + unplaced as f64 / grains.len().max(1) as f64);
            let room = specimen.fullness() * specimen.size.iter().product::<f64>();
            let taken = if room > 0.0 { (all / room).min(1.0) } else { 0.0 };
            rig.left_out[0] = (rig.left_out[0] as f64 * (1.0 - taken)).round() as usize;
        }
        let fines = self.fines_as_points(materials, &rig, &grains)?;
        let acts_on = match self.text("contact.on_points") {
            "face" => ActsOn::Face,
            "centre" => ActsOn::Centre,
            "node" => ActsOn::Node,
            "mutual_nodes" => ActsOn::MutualNodes,
            _ if test => ActsOn::Face,
            _ => ActsOn::Centre,
        };
        self.check(
            point_radius.is_none() || !(blocks.is_empty() || self.is_without_points()),
            "contact.point_radius_mm",
            "has no meaning without both points and a [[block]]",
        );
        let block_volume = blocks.iter().map(|b| solid_volume(b, materials)).sum();
        let coarse = CoarseGrains {
            grains,
            blocks,
            block_volume,
            programmes,
            joints,
            walls,
            point_materials,
            rates,
            fines,
            acts_on,
            point_radius,
        };
        if acts_on == ActsOn::MutualNodes {
            self.touches_at_nodes(&coarse, materials);
        }
        self.blocks_have_room(&rig, &coarse);
        self.grains_have_room(&rig, &coarse.grains);
        rig.coarse = Some(coarse);
        if let Some(why) = refusal(materials, &rig, self.flag("crushing.enabled")) {
            self.refuse("grid.cell_mm", why);
        }
        Some(rig)
    }

    /// Refuses what contacts at mutual nodes are not made for: only polygons of a free scene, which do not break and are not held, pushed or joined, without grains, in a continuum of one material.
    fn touches_at_nodes(&self, coarse: &CoarseGrains, materials: &[Material]) {
        let CoarseGrains { blocks, programmes, joints, .. } = coarse;
        let polygons = !blocks.is_empty() && blocks.iter().all(|block| matches!(block.shape, Shape::Polygon(_)));
        let free = joints.is_empty() && programmes.iter().all(Programme::is_none) && !self.flag("crushing.enabled");
        let alone = coarse.grains.is_empty() && self.text("test.rig") == "free";
        let softens = |m: &u8| materials[usize::from(*m)].interface_friction.is_some_and(|friction| friction.decay > 0.0);
        let one = coarse.point_materials.len() == 1 && !coarse.point_materials.iter().any(softens);
        let key = "contact.on_points";
        let bodies = "may be mutual_nodes only where points touch polygons that do not break and are not held, pushed or joined, in a free scene without grains";
        self.check(polygons && free && alone, key, bodies);
        self.check(
            one,
            key,
            "may be mutual_nodes only with one material of the points, whose friction does not change with plastic strain",
        );
    }

    /// Refuses walls under servo that a mixture cannot have: a cylinder, whose area would have to be that of its content, and a wall whose largest speed does not follow from the materials.
    fn walls_hold(&self, walls: &[WallSpec], materials: &[Material]) {
        let tables = self.list("wall");
        let holds = walls.iter().any(|w| matches!(w.drive, Drive::Stress { fastest: None, .. }));
        let stiff = materials.iter().any(|m| m.young > 0.0);
        for (i, wall) in tables.iter().enumerate().filter(|(_, wall)| wall.contains_key("stress_kPa")) {
            let plane = wall.get("kind").and_then(toml::Value::as_str) == Some("plane");
            self.check(plane, &format!("wall[{i}].stress_kPa"), "must stand at a plane in a mixture");
            if holds && !stiff && !wall.contains_key("max_velocity_m_s") {
                let message = "is missing: no material has a Young's modulus from which it would follow";
                self.refuse(&format!("wall[{i}].max_velocity_m_s"), message);
            }
        }
    }

    /// Refuses a mixture in plane strain that has more in it than polygons and points.
    fn plane_of_blocks(&self) {
        if !self.flag("grid.plane_strain") {
            return;
        }
        let key = "grid.plane_strain";
        for spheres in ["grain", "coarse", "growth"] {
            let there = if spheres == "grain" {
                !self.list(spheres).is_empty()
            } else {
                SPHERES.iter().any(|k| k.starts_with(spheres) && self.has(k))
            };
            self.check(
                !there,
                key,
                format!("must be false beside [{spheres}], which makes spheres: a disc is a [[block]] with shape = \"polygon\" and one corner"),
            );
        }
        let spring = self.law() == ContactLaw::Spring;
        self.check(
            spring,
            "contact.law",
            "must be \"spring\" in plane strain, where forces count per metre of depth: the other laws are those of spheres",
        );
    }

    /// Refuses listed grains that stand through a side of the specimen, where its platens begin.
    fn grains_inside(&self, grains: &[GrainSpec], specimen: &MpmSpecimen) {
        let (low, [x, y, _]) = (specimen.lower, specimen.base());
        let high: [f64; 3] = std::array::from_fn(|a| low[a] + specimen.size[a]);
        let shape = if specimen.round { "cylinder in the box" } else { "box" };
        for (i, g) in grains.iter().enumerate() {
            let (p, r) = (g.position, g.radius);
            let shell = specimen.round.then(|| (p[0] - x).hypot(p[1] - y) - 0.5 * specimen.size[0]);
            let sides = (0..3).flat_map(|a| [low[a] - p[a], p[a] - high[a]]);
            let out = r + sides.chain(shell).fold(f64::NEG_INFINITY, f64::max);
            let message = format!(
                "grain {i} of radius {r:?} m reaches {out:.3e} m out of the specimen, the {shape} from {low:?} to {high:?} m"
            );
            self.check(out <= DEEP * r, &format!("grain[{i}].position_m"), message);
        }
    }

    /// Refuses listed grains of a free scene that contain points. In a specimen the points make room for the grains.
    fn grains_have_room(&self, rig: &MpmTest, grains: &[GrainSpec]) {
        if rig.specimen().is_some() || self.leaves_out(grains.len(), rig.points.len()) {
            return;
        }
        for (i, g) in grains.iter().enumerate() {
            let holds = |q: &&[f64; 4]| (0..3).map(|a| (q[a] - g.position[a]).powi(2)).sum::<f64>() < g.radius * g.radius;
            let inside = rig.points.position.iter().filter(holds).count();
            let message =
                format!("must not put the grain over points: {inside} points lie in grain {i} of radius {:?} m", g.radius);
            self.check(inside == 0, &format!("grain[{i}].position_m"), message);
        }
    }

    /// How the mass that breakages lose becomes points, if it does; `None`, with the reason noted, where the scene is refused.
    fn fines_as_points(&self, materials: &[Material], rig: &MpmTest, grains: &[GrainSpec]) -> Option<Option<Rule>> {
        let key = "crushing.lost_mass";
        if self.text(key) != "points" {
            return Some(None);
        }
        if !self.flag("crushing.enabled") {
            self.refuse(key, "\"points\" needs crushing.enabled = true");
            return None;
        }
        let points = &rig.points;
        let Some(largest) = (0..points.len()).max_by(|&i, &j| points.solid(i).total_cmp(&points.solid(j))) else {
            self.refuse(key, "\"points\" needs a [[body]] of points that the fines join");
            return None;
        };
        let (mut solid, mut breaking) = (points.solid(largest), grains.first().map(|g| g.material));
        if let Some(growth) = &rig.growth {
            self.check(growth.as_points, key, "\"points\" needs growth.fines = \"points\"");
            (solid, breaking) = (sphere_volume(growth.fines.radii[1]), growth.coarse.map(|c| c.material));
        }
        let Some(breaking) = breaking else { return Some(None) };
        let density = materials[usize::from(breaking)].density;
        let (law, porosity) = (points.law[largest], points.initial_porosity[largest]);
        let release_strain = self.si("crushing.release_strain");
        Some(Some(Rule { release_strain, law, porosity, solid, density, at_rest: false }))
    }

    /// Whether an outline leaves out to compare each of so many bodies with each of so many points: the run itself does.
    pub fn leaves_out(&self, bodies: usize, points: usize) -> bool {
        let left = self.outlined && bodies.saturating_mul(points) > COMPARED;
        self.incomplete.set(self.incomplete.get() || left);
        left
    }

    /// Coarse grains at random places in the specimen, and the number of those that an outline leaves out. `fine_density` is the
    /// density of the fines' solids, kg/m³; `points` the number of points that were made.
    fn coarse(
        &self,
        named: &[Named],
        materials: &[Material],
        specimen: &MpmSpecimen,
        fine_density: f64,
        points: usize,
    ) -> Option<(Vec<GrainSpec>, usize)> {
        let Some((material, radii, share)) = self.coarse_grains(named)? else { return Some((Vec::new(), 0)) };
        let message = "has no meaning beside [[block]] and [[block_set]]: spheres are placed without looking at them";
        self.check(!self.has_blocks(), "coarse.mass_fraction", message);
        // of the box: coarse volume V with ρ_c V / (ρ_c V + ρ_f (1 − n) (box − V)) = share
        let (coarse, fine) = (materials[usize::from(material)].density, (1.0 - specimen.porosity) * fine_density);
        let volume = specimen.fullness() * specimen.size.iter().product::<f64>();
        let wanted = volume * share * fine / (coarse * (1.0 - share) + share * fine);
        let room = ROOM * specimen.spacing;
        let seed = self.whole("seed.packing")?;
        self.at_least_one(radii, wanted, share);
        let expected = Fraction { material, radii, volume: wanted };
        self.not_too_many("coarse.diameter_mm", &expected)?;
        let count = expected.count();
        let few = FEW.min(COMPARED / points.max(1)).max(1);
        let some = self.outlined && count > few;
        self.incomplete.set(self.incomplete.get() || some);
        let wanted = if some { wanted * few as f64 / count as f64 } else { wanted };
        match dispersed(specimen.lower, specimen.size, specimen.round, radii, wanted, room, seed) {
            Ok(spheres) => {
                let left_out = if some { count.saturating_sub(spheres.len()) } else { 0 };
                let grains = spheres
                    .into_iter()
                    .map(|([x, y, z], radius)| GrainSpec {
                        position: [x, y, z],
                        radius,
                        velocity: [0.0; 3],
                        spin: [0.0; 3],
                        material,
                    })
                    .collect();
                Some((grains, left_out))
            }
            Err(reached) => {
                let message = format!(
                    "cannot be placed at random without contact: places were found for {:.1} % of the mass; use a smaller share, let the specimen grow (growth.fines_diameter_mm), or list the grains as [[grain]]",
                    100.0 * coarse * reached / (coarse * reached + fine * (volume - reached))
                );
                self.refuse("coarse.mass_fraction", message);
                None
            }
        }
    }
}

/// Number of times that a point is moved out of grains and back into the specimen.
const ROUNDS: usize = 20;
/// Largest overlap beyond the one that bears the stress, over the radius of the contact sphere. A point with more is removed.
const TOO_DEEP: f64 = 0.02;

/// Makes room for the grains in a specimen full of points. A point whose centre lies in a grain is removed. A point whose contact
/// sphere overlaps with a grain is moved outwards until the overlap is `depth` (of the point's law, the grain and the effective
/// radius R*, m), but not out of the specimen's lattice. A point that finds no room between grains, or between a grain and a
/// platen, is removed.
fn displace(
    points: &mut Points,
    dimension: Dimension,
    specimen: &MpmSpecimen,
    grains: &[GrainSpec],
    depth: impl Fn(u8, &GrainSpec, f64) -> f64,
) {
    let from = |p: &[f64; 4], g: &GrainSpec| {
        let d: [f64; 3] = std::array::from_fn(|a| p[a] - g.position[a]);
        (d, (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt())
    };
    let within = |p: &mut [f64; 4]| {
        let half = 0.5 * specimen.spacing;
        if specimen.round {
            let ([x, y, _], most) = (specimen.base(), 0.5 * specimen.size[0] - half);
            let d = [p[0] - x, p[1] - y];
            let shorter = (most / (d[0] * d[0] + d[1] * d[1]).sqrt()).min(1.0);
            (p[0], p[1]) = (x + d[0] * shorter, y + d[1] * shorter);
        }
        for (x, (low, size)) in p.iter_mut().zip(specimen.lower.into_iter().zip(specimen.size)) {
            *x = x.clamp(low + half, low + size - half);
        }
    };
    let mut gone = vec![false; points.len()];
    for (i, gone) in gone.iter_mut().enumerate() {
        let (ghost, law) = (ghost_radius(dimension, points.solid(i)), points.law[i]);
        let mut p = points.position[i];
        let near: Vec<&GrainSpec> = grains.iter().filter(|g| from(&p, g).1 < g.radius + 4.0 * ghost).collect();
        *gone = near.iter().any(|g| from(&p, g).1 < g.radius);
        let reach = |g: &GrainSpec| g.radius + ghost - depth(law, g, g.radius * ghost / (g.radius + ghost));
        for _ in 0..if near.is_empty() { 0 } else { ROUNDS } {
            for g in &near {
                let (d, distance) = from(&p, g);
                let outwards = (reach(g) / distance - 1.0).max(0.0);
                p.iter_mut().zip(d).for_each(|(p, d)| *p += d * outwards);
            }
            within(&mut p);
        }
        *gone |= near.iter().any(|g| from(&p, g).1 < reach(g) - TOO_DEEP * ghost);
        points.position[i] = p;
    }
    points.drop_those(&gone);
}
