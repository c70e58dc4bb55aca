//! The grains of a mixture under test: their walls, and the cycles of grains and points on the CPU.

use super::{Broken, Engine, MpmTest, State, dimensions};
use crate::error::{Error, Result};
use crate::model::continuum::{CoarseGrains, MpmSpecimen, Test};
use crate::model::{Assembly, Model};
use crate::rig::assembly;
use ::engine::boundary::{Drive, Wall, WallShape, WallSpec, servo_speed};
use ::engine::coupling::{Allowed, Cycle, Mixture, Parts, Rates};
use ::engine::dem::{Workspace, observables, stability};
#[cfg(feature = "gpu")]
use ::engine::gpu;
use ::engine::mpm::loading_plate::ghost_radius;
use ::engine::mpm::{Continuum, Dimension, LoadingPlate};
#[cfg(feature = "gpu")]
use ::engine::mpm::{Points, Settings};
use ::engine::point_contacts::{ActsOn, PointContactTable};
use ::engine::rigid::{Block, Blocks};

/// A fixed rigid plane without friction.
pub(super) fn smooth(point: [f64; 3], normal: [f64; 3]) -> WallSpec {
    WallSpec { shape: WallShape::Plane { point, normal }, friction: 0.0, drive: Drive::Fixed, material: None }
}

/// Side `k` of a specimen's box, in the order x low, x high, …
pub(super) fn side(s: &MpmSpecimen, k: usize) -> WallSpec {
    let (axis, high) = (k / 2, k % 2 == 1);
    let (mut point, mut normal) = (s.lower, [0.0; 3]);
    point[axis] += if high { s.size[axis] } else { 0.0 };
    normal[axis] = if high { -1.0 } else { 1.0 };
    smooth(point, normal)
}

/// The sides of a specimen at the start, as walls without friction: four, six, or of a cylinder its bottom, top and shell.
pub fn platens(s: &MpmSpecimen, dimension: Dimension) -> Vec<WallSpec> {
    if s.round {
        let ([x, y, _], radius) = (s.base(), 0.5 * s.size[0]);
        let shell = WallSpec { shape: WallShape::Cylinder { centre: [x, y], radius }, ..side(s, 4) };
        return vec![side(s, 4), side(s, 5), shell];
    }
    let sides = if dimension == Dimension::Space { 6 } else { 4 };
    (0..sides).map(|k| side(s, k)).collect()
}

/// The grains of the scene with the walls of its test: the listed walls of a free scene; else fixed sides and loading plates in
/// the order x low, x high, y low, …, so that the loading plates are the last walls.
pub fn mixture(model: &Model, rig: &MpmTest, coarse: &CoarseGrains, continuum: &mut Continuum, plates: &[LoadingPlate]) -> Mixture {
    let of = |p: &LoadingPlate| {
        let plane = smooth(p.point, p.normal);
        let Some(radius) = p.radius else { return plane };
        WallSpec { shape: WallShape::Cylinder { centre: [p.point[0], p.point[1]], radius }, ..plane }
    };
    let walls = match &rig.test {
        Test::Free { .. } => coarse.walls.clone(),
        Test::Oedometer(s) if s.round => std::iter::once(side(s, 4)).chain(plates.iter().map(of)).collect(),
        Test::Oedometer(s) => (0..2 * dimensions(rig) - 1).map(|k| side(s, k)).chain(plates.iter().map(of)).collect(),
        Test::Triaxial { .. } => plates.iter().map(of).collect(),
    };
    let scene = Assembly {
        grains: coarse.grains.clone(),
        walls,
        steps: None,
        duration: None,
        tracks: Vec::new(),
        above_bound: false,
        record_every: 1,
    };
    let mut mixture = Mixture::new(&model.physics, assembly::start(model, &scene), continuum, coarse.fines);
    if !coarse.blocks.is_empty() {
        let blocks = Blocks::new(coarse.blocks.clone())
            .with_points(coarse.point_radius, first_touch(model, rig, coarse))
            .with_drives(coarse.programmes.clone(), coarse.joints.clone());
        let blocks = match coarse.acts_on {
            ActsOn::MutualNodes => blocks.at_nodes(friction_at_nodes(model, coarse)),
            ActsOn::Face | ActsOn::Centre | ActsOn::Node => blocks,
        };
        mixture.blocks = Some(Box::new(match &model.physics.crush {
            Some(crush) => blocks.with_breakage(crush),
            None => blocks,
        }));
        // what bodies press with counts where a wall moves
        mixture.grains.walls.iter_mut().rev().zip(plates).for_each(|(wall, _)| wall.drive = Drive::Programme);
    }
    mixture
}

/// Coefficient of friction of each rigid body with the only constitutive law of the continuum.
fn friction_at_nodes(model: &Model, coarse: &CoarseGrains) -> Vec<f64> {
    let table = PointContactTable::new(model.physics.contact.law, &coarse.point_materials, &model.physics.materials, &[]);
    coarse.blocks.iter().map(|block| table.of_grain(0, block.material).friction).collect()
}

/// Square of the angular frequency, 1/s², of the lightest point at its first touch of a rigid body, by a law whose stiffness does not begin at zero.
fn first_touch(model: &Model, rig: &MpmTest, coarse: &CoarseGrains) -> f64 {
    if model.physics.contact.law.is_hertzian() {
        return 0.0;
    }
    let p = &rig.points;
    let radius = |i| coarse.point_radius.unwrap_or_else(|| ghost_radius(rig.settings.dimension, p.solid(i)));
    let free = |i: usize| {
        let material = &model.physics.materials[usize::from(coarse.point_materials[usize::from(p.law[i])])];
        (model.physics.contact.law.table().free_step)(material, p.velocity[i][3], radius(i), radius(i))
    };
    (0..p.len()).map(free).fold(f64::INFINITY, f64::min).powi(-2)
}

/// In a quasi-static test a cycle may end at this share of the largest step of the slower side, if this saves a step of the
/// faster side.
const NEARLY: f64 = 0.8;

/// Largest step of rigid bodies without points, s, before anything touches them: that of spheres of their volumes. Beside points waves through a cell bound the
/// step.
pub fn free_step(model: &Model, rig: &MpmTest, blocks: &[Block]) -> f64 {
    if blocks.is_empty() || !rig.points.is_empty() {
        return f64::INFINITY;
    }
    // a sheet has no mass
    let bodies = blocks.iter().filter(|b| b.mass > 0.0);
    stability::free_of(&model.physics, bodies.map(|b| (b.mass, b.radius, b.material)))
}

/// Sets the speeds of the walls of a free scene that hold a stress, for the next `dt` seconds. Faster than a plane wave of that stress would move the material, stress over
/// √(E ρ), none goes, unless the scene says how fast it may.
fn hold(model: &Model, walls: &mut [Wall], dt: f64) {
    for wall in walls {
        if let Drive::Stress { stress, area, gain, fastest } = wall.drive {
            let impedance = model.physics.materials.iter().map(|m| (m.young * m.density).sqrt()).fold(0.0, f64::max);
            let limit = fastest.unwrap_or(stress / impedance);
            wall.speed = servo_speed(stress * area, wall.reaction, wall.stiffness, gain, dt, limit);
        }
    }
}

/// Contact parameters of points with grains and walls.
fn point_table(model: &Model, rig: &MpmTest, mixture: &Mixture) -> PointContactTable {
    let point_materials = rig.coarse.as_ref().map_or(&[][..], |c| &c.point_materials);
    // in a test the loading plates and the walls of the grid act on the points themselves
    let walls: &[Wall] = if rig.specimen().is_some() { &[] } else { &mixture.grains.walls };
    PointContactTable::new(model.physics.contact.law, point_materials, &model.physics.materials, walls)
        .acting_on(rig.coarse.as_ref().map_or_else(ActsOn::default, |c| c.acts_on))
}

/// Working memory and contact parameters of a mixture on the CPU. It can be made anew from the state between any two cycles.
pub struct Coupled {
    table: PointContactTable,
    work: Workspace,
}

impl Coupled {
    /// Working memory for `mixture`.
    pub fn new(model: &Model, rig: &MpmTest, mixture: &mut Mixture) -> Coupled {
        Coupled { table: point_table(model, rig, mixture), work: Workspace::sorted(&model.physics, &mut mixture.grains) }
    }

    /// Contact parameters of points with grains and walls.
    #[cfg(feature = "gpu")]
    pub fn table(&self) -> &PointContactTable {
        &self.table
    }

    /// Makes the neighbour lists anew, after a graphics device has moved the grains.
    #[cfg(feature = "gpu")]
    pub(super) fn renew(&mut self, state: &mut State, model: &Model) {
        if let Some(mixture) = &mut state.mixture {
            self.work.restart(&model.physics, &mut mixture.grains);
        }
    }

    /// Computes the forces between grains and between grains and points, and passes the forces of grains on the loading plates'
    /// walls to the loading plates.
    ///
    /// # Errors
    /// Rigid bodies that come within reach of each other: their contacts are not computed.
    pub(super) fn compute_forces(&mut self, state: &mut State, model: &Model) -> Result<()> {
        let State { continuum, mixture, plates, .. } = state;
        let Some(mixture) = mixture else { return Ok(()) };
        mixture.compute_forces(&mut Parts {
            physics: &model.physics,
            table: &self.table,
            work: &mut self.work,
            continuum,
            plates: &mut [],
        })?;
        for (plate, wall) in plates.iter_mut().rev().zip(mixture.grains.walls.iter().rev()) {
            plate.others = [wall.reaction, wall.stiffness];
        }
        Ok(())
    }

    /// One cycle of grains and points, with the loading plates' motion that the programme has set.
    pub(super) fn cycle(&mut self, state: &mut State, model: &Model, rig: &MpmTest) -> Result<()> {
        state.set_speeds(rig);
        let State { continuum, mixture, plates, .. } = state;
        let Some(mixture) = mixture else { return Ok(()) };
        // the last walls are the loading plates
        for (plate, wall) in plates.iter().rev().zip(mixture.grains.walls.iter_mut().rev()) {
            wall.speed = plate.speed;
        }
        if plates.is_empty() {
            hold(model, &mut mixture.grains.walls, mixture.cycle.time);
        }
        let (cycle, step) = (mixture.cycle, continuum.steps());
        let done = mixture
            .make_cycle(&mut Parts { physics: &model.physics, table: &self.table, work: &mut self.work, continuum, plates }, cycle);
        state.take_breakages(rig, step);
        done?;
        state.time += cycle.time;
        state.phase_time += cycle.time;
        Ok(())
    }

    /// The rest of a cycle of which a graphics device has made the first `done` steps of the grains.
    #[cfg(feature = "gpu")]
    pub(super) fn finish_cycle(&mut self, state: &mut State, model: &Model, rig: &MpmTest, cycle: Cycle, done: u32) -> Result<()> {
        let State { continuum, mixture, plates, .. } = state;
        let Some(mixture) = mixture else { return Ok(()) };
        mixture.cycle = cycle;
        let step = continuum.steps();
        let done = mixture.finish_cycle(
            &mut Parts { physics: &model.physics, table: &self.table, work: &mut self.work, continuum, plates },
            done,
        );
        state.take_breakages(rig, step);
        done?;
        state.time += cycle.time;
        state.phase_time += cycle.time;
        Ok(())
    }

    /// Force, N, on the grain at index `grain`, from contacts with grains, walls, points and bodies and from gravity, before damping.
    pub fn force(&self, model: &Model, mixture: &Mixture, grain: usize) -> [f64; 3] {
        observables::force_and_torque(grain, &model.physics, &mixture.grains, &self.work).0
    }

    /// Memory for grains and contacts, bytes.
    pub(super) fn bytes(&self, state: &State) -> usize {
        state
            .mixture
            .as_ref()
            .map_or(0, |m| self.work.bytes(&m.grains) + m.point_contacts.bytes() + m.blocks.as_ref().map_or(0, |b| b.bytes()))
    }
}

impl State {
    /// The rigid bodies that are no spheres; `None`: there are none.
    pub fn blocks(&self) -> Option<&Blocks> {
        self.mixture.as_ref()?.blocks.as_deref()
    }

    /// Moves the breakages of a cycle that began at step `step` to those that wait to be recorded.
    fn take_breakages(&mut self, rig: &MpmTest, step: u64) {
        let Some(mixture) = self.mixture.as_mut().filter(|m| !m.breakages.is_empty()) else { return };
        let events = std::mem::take(&mut mixture.breakages);
        let axial = if rig.specimen().is_some() { self.axial_stress(rig) } else { f64::NAN };
        let time = self.time;
        self.broken.extend(events.into_iter().map(|event| Broken { event, step, time, axial }));
    }

    /// Asks `what` of a graphics device about this state: whether it can compute the state ([`gpu::fits`]), or how much memory
    /// it needs ([`gpu::needs`]).
    ///
    /// # Errors
    /// [`Error::Device`] with the key of the scene that a graphics device cannot compute.
    #[cfg(feature = "gpu")]
    pub fn on_device<T>(
        &self,
        model: &Model,
        rig: &MpmTest,
        what: impl FnOnce(&Settings, &Points, &[LoadingPlate], Option<&gpu::CoarseGrains<'_>>) -> ::engine::error::Result<T>,
    ) -> Result<T> {
        if model.records.account {
            let message = "the energy account is not kept on the GPU: use the processor";
            return Err(Error::input("gpu", "records.account", Some("true".into()), message).on_device());
        }
        gpu::takes(&rig.laws)?;
        let Some(mixture) = self.mixture.as_deref() else { return Ok(what(&rig.settings, &rig.points, &self.plates, None)?) };
        if let Some(k) = mixture.grains.walls.iter().position(|wall| matches!(wall.drive, Drive::Stress { .. })) {
            let message = "a wall that holds a stress is not available on the GPU: use the processor";
            return Err(Error::input("gpu", format!("wall[{k}].stress_kPa"), None, message).on_device());
        }
        if rig.growth.is_some_and(|growth| !growth.as_points) {
            let message = "grains alone are not available on the GPU: use points, or the processor";
            return Err(Error::input("gpu", "growth.fines", Some("grains".into()), message).on_device());
        }
        if let Some(Rates { continuum: steps @ 2.., .. }) = rig.coarse.as_ref().and_then(|c| c.rates) {
            let message = "must be 1 on the GPU: leave the key out, or use the processor";
            return Err(Error::input("gpu", "stepping.continuum_steps", Some(steps.to_string()), message).on_device());
        }
        let table = point_table(model, rig, mixture);
        Ok(what(
            &rig.settings,
            &rig.points,
            &self.plates,
            Some(&gpu::CoarseGrains { physics: &model.physics, mixture, table: &table }),
        )?)
    }

    /// Sets time and rates of the next cycle; `continuum` is the largest step by compression waves, s.
    pub(super) fn find_cycle(&mut self, model: &Model, rig: &MpmTest, continuum: f64, engine: &Engine) -> Result<()> {
        let Some(mixture) = &mut self.mixture else { return Ok(()) };
        let safety = model.physics.stepping.safety;
        let (grains, contacts) = engine.bounds(mixture, &self.continuum, &self.plates, model.physics.stepping.slow);
        let rates = rig.coarse.as_ref().and_then(|c| c.rates);
        let mut allowed = Allowed {
            grains: grains.min(free_step(model, rig, mixture.blocks.as_ref().map_or(&[], |blocks| &blocks.blocks))),
            continuum: safety * continuum,
            contacts,
            safety,
            nearly: if model.physics.stepping.slow { NEARLY } else { 1.0 },
            rates,
        };
        let mut cycle = Cycle::longest(&allowed);
        if rates.is_none() {
            allowed.rates = engine.rates(cycle.rates);
            cycle = Cycle::longest(&allowed);
        }
        mixture.cycle = match model.physics.stepping.dt {
            None => cycle,
            Some(time) if rig.above_bound || safety * time <= cycle.time => {
                Cycle { time, rates: rates.unwrap_or(Rates { grains: 1, continuum: 1 }) }
            }
            Some(time) => {
                let what = format!(
                    "stepping.dt_s = {time:e} is above what waves and contacts allow, {:.4e} s: use a smaller one, or \"auto\"",
                    cycle.time / safety
                );
                return Err(Error::Unstable { step: self.continuum.steps(), what, grain: None });
            }
        };
        self.dt = mixture.cycle.time;
        Ok(())
    }
}
