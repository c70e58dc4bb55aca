//! Grains in a continuum under test: the walls that they meet, and their cycles.

use super::{Rig, State};
use crate::boundary::Wall;
use crate::coupling::{Allowed, Cycle, GhostTable, Mixture, Parts, Rates};
use crate::error::{Error, Result};
use crate::model::continuum::{Coarse, Specimen, Test};
use crate::model::{Assembly, Drive, Model, WallShape, WallSpec};
use crate::mpm::{Continuum, Platen};
use crate::rig::assembly;
use crate::rigid::Blocks;
use crate::step::Work;

/// The grains of a scene between the walls of its test: platens, or the sides of an oedometer, in the order x low, x high, …; or its own.
pub fn mixture(model: &Model, rig: &Rig, coarse: &Coarse, continuum: &mut Continuum, platens: &[Platen]) -> Mixture {
    let plane =
        |point, normal| WallSpec { shape: WallShape::Plane { point, normal }, friction: 0.0, drive: Drive::Fixed, material: None };
    let side = |s: &Specimen, k: usize| {
        let (axis, high) = (k / 2, k % 2 == 1);
        let (mut point, mut normal) = (s.lower, [0.0; 3]);
        point[axis] += if high { s.size[axis] } else { 0.0 };
        normal[axis] = if high { -1.0 } else { 1.0 };
        plane(point, normal)
    };
    let of = |p: &Platen| plane(p.point, p.normal);
    let walls = match &rig.test {
        Test::Free { .. } => coarse.walls.clone(),
        Test::Oedometer(s) => (0..5).map(|k| side(s, k)).chain(platens.iter().map(of)).collect(),
        Test::Triaxial { .. } => platens.iter().map(of).collect(),
    };
    let scene = Assembly { grains: coarse.grains.clone(), walls, steps: None, duration: None, tracks: Vec::new(), record_every: 1 };
    let mut mixture = Mixture::new(model, assembly::start(model, &scene), continuum, coarse.fines);
    if !coarse.blocks.is_empty() {
        mixture.blocks = Some(Box::new(Blocks::new(coarse.blocks.clone())));
    }
    mixture
}

/// What a mixture needs besides its state; may be dropped and made anew between any two cycles.
pub struct Coupled {
    table: GhostTable,
    work: Work,
}

impl Coupled {
    pub fn new(model: &Model, rig: &Rig, mixture: &mut Mixture) -> Coupled {
        let ghosts = rig.coarse.as_ref().map_or(&[][..], |c| &c.ghosts);
        // points meet platens and sides of the grid by themselves
        let walls: &[Wall] = if rig.specimen().is_some() { &[] } else { &mixture.grains.walls };
        let table = GhostTable::new(model.contact.law, ghosts, &model.materials, walls);
        Coupled { table, work: Work::new(model, &mut mixture.grains) }
    }

    /// Forces between grains, and between grains and points; what platens feel of the grains.
    ///
    /// # Errors
    /// Rigid bodies that come within reach of each other.
    pub(super) fn feel(&mut self, state: &mut State, model: &Model) -> Result<()> {
        let State { continuum, mixture, platens, .. } = state;
        let Some(mixture) = mixture else { return Ok(()) };
        mixture.feel(&mut Parts { model, table: &self.table, work: &mut self.work, continuum, platens: &mut [] })?;
        for (platen, wall) in platens.iter_mut().rev().zip(mixture.grains.walls.iter().rev()) {
            platen.others = [wall.reaction, wall.stiffness];
        }
        Ok(())
    }

    /// A cycle with the drives that the programme has set.
    pub(super) fn cycle(&mut self, state: &mut State, model: &Model, rig: &Rig) -> Result<()> {
        state.set_speeds(rig);
        let State { continuum, mixture, platens, .. } = state;
        let Some(mixture) = mixture else { return Ok(()) };
        // the last walls are the platens
        for (platen, wall) in platens.iter().rev().zip(mixture.grains.walls.iter_mut().rev()) {
            wall.speed = platen.speed;
        }
        let cycle = mixture.cycle;
        mixture.go(&mut Parts { model, table: &self.table, work: &mut self.work, continuum, platens }, cycle)?;
        state.time += cycle.time;
        state.phase_time += cycle.time;
        Ok(())
    }

    /// Bytes held for grains and their contacts.
    pub(super) fn bytes(&self, state: &State) -> usize {
        state
            .mixture
            .as_ref()
            .map_or(0, |m| self.work.bytes(&m.grains) + m.ghosts.bytes() + m.blocks.as_ref().map_or(0, |b| b.bytes()))
    }
}

impl State {
    /// Rigid bodies that are no spheres, where there are some.
    pub fn blocks(&self) -> Option<&Blocks> {
        self.mixture.as_ref()?.blocks.as_deref()
    }

    /// The next cycle; `continuum` is what waves and platens allow, s.
    pub(super) fn find_cycle(&mut self, model: &Model, rig: &Rig, continuum: f64) -> Result<()> {
        let Some(mixture) = &mut self.mixture else { return Ok(()) };
        let safety = model.stepping.safety;
        let (grains, contacts) = mixture.bounds(&self.continuum);
        let rates = rig.coarse.as_ref().and_then(|c| c.rates);
        let cycle = Cycle::longest(&Allowed { grains, continuum: safety * continuum, contacts, safety, rates });
        mixture.cycle = match model.stepping.dt {
            None => cycle,
            Some(time) if safety * time <= cycle.time => Cycle { time, rates: rates.unwrap_or(Rates { grains: 1, continuum: 1 }) },
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
