//! A continuum or mixture, or rigid bodies, between two steps.

use super::super::continuum::step::{Lead, Looks, Moving, Records};
use super::{DRIVEN, GAIN, STOPPED, System, WallNow, checked, wrong};
use crate::error::Result;
use crate::interrupt::stop_asked;
use crate::model::Model;
use crate::model::continuum::MpmTest;
use crate::record::contacts::{self, Contact};
use crate::record::continuum::{self as record, Recorder};
use crate::record::crushed::Crushed;
use crate::rig::continuum::{Engine, Growing, Grown, Phase, Side, State, growing};
use engine::boundary::{Drive, WallShape};
use engine::dem;
use engine::mpm::{Dimension, Points};
use engine::rigid::Blocks;
use table::Row;

/// Points, grains, bodies and walls, with all that changes from step to step.
pub struct Continuum {
    /// The test, with the specimen that has grown.
    rig: MpmTest,
    state: State,
    engine: Engine,
    recorder: Recorder,
    crushed: Crushed,
    looks: Looks,
    lead: Lead,
    /// Whether the program drives walls or bodies.
    driven: bool,
    kept: Kept,
    /// Walls by name, with their shapes at the first instant.
    walls: Vec<(String, Side, WallShape)>,
    /// Share of the test at which it must be looked at again.
    next: f64,
}

/// The records that a program can ask for.
#[derive(Default)]
struct Kept {
    /// The last row of the history, with its step.
    row: Option<(u64, Row)>,
    /// Rows of breakages, of grains and of bodies.
    breakages: [Vec<Row>; 2],
}

impl Records for Kept {
    fn row(&mut self, at: &mut Moving<'_>, row: Row) -> Result<()> {
        self.row = Some((at.state.continuum.steps(), row));
        Ok(())
    }

    fn breakages(&mut self, at: &mut Moving<'_>) -> Result<()> {
        let found = at.crushed.take(at.state);
        self.breakages[0].extend(found.grains);
        self.breakages[1].extend(found.bodies);
        Ok(())
    }
}

impl Continuum {
    /// The first instant. The specimen is `grown`, or grows now, where the scene asks for it.
    pub fn begin(model: &Model, rig: &MpmTest, grown: Option<Grown>) -> Result<Continuum> {
        let rig = match &rig.growth {
            Some(growth) => {
                let grown = match grown {
                    Some(grown) => grown,
                    None => grow(model, rig, growth)?,
                };
                grown.rig(model, rig, growth)
            }
            None => rig.clone(),
        };
        let mut state = State::start(model, &rig)?;
        let engine = Engine::of_grains(&mut state, model, &rig);
        let mut crushed = Crushed::default();
        crushed.open(model, &rig);
        let shaped = |(name, side)| (name, side, state.wall(&rig, side).shape);
        let mut now = Continuum {
            walls: state.walls(&rig).into_iter().map(shaped).collect(),
            looks: Looks::new(model, &rig, &state),
            recorder: Recorder::default(),
            lead: Lead::default(),
            driven: false,
            kept: Kept::default(),
            next: 0.0,
            rig,
            state,
            engine,
            crushed,
        };
        now.look(model)?;
        Ok(now)
    }

    /// What a step needs, and who keeps its records.
    fn moving<'a>(&'a mut self, model: &'a Model) -> (Moving<'a>, &'a Lead, &'a mut Kept) {
        let Continuum { rig, state, engine, recorder, crushed, looks, lead, kept, .. } = self;
        (Moving { model, rig, state, engine, recorder, crushed, looks }, lead, kept)
    }

    /// Computes the forces of this instant, and what the programme makes of them.
    fn look(&mut self, model: &Model) -> Result<()> {
        let (mut moving, lead, kept) = self.moving(model);
        let next = moving.look(lead, kept)?;
        if moving.state.phase == Phase::Done {
            // nothing moves; a run looks at its last state
            moving.go(next, kept)?;
        }
        self.next = next;
        Ok(())
    }

    /// Refuses to move a wall that cannot.
    fn stands<T>(&self, wall: usize, drive: Drive, why: &str) -> Result<T> {
        let (key, value) = match drive {
            Drive::Stress { stress, .. } => ("stress", stress),
            Drive::Velocity(velocity) => ("velocity", velocity),
            Drive::Fixed | Drive::Programme => ("velocity", 0.0),
        };
        wrong(key, value.to_string(), &format!("{} is {why}", self.walls[wall].0))
    }
}

/// Grows the specimen, as a run does.
fn grow(model: &Model, rig: &MpmTest, growth: &crate::model::continuum::Growth) -> Result<Grown> {
    let mut specimen = Growing::start(model, rig, growth)?;
    let by = growing(&model.physics);
    let mut work = specimen.work(&by);
    while !specimen.advance(&by, rig, growth, &mut work)? {
        if stop_asked() {
            return Err(STOPPED);
        }
    }
    Ok(specimen.grown())
}

impl System for Continuum {
    fn step(&mut self, model: &Model) -> Result<()> {
        if self.state.phase == Phase::Done {
            (self.lead.beyond, self.state.phase) = (true, Phase::Load);
        }
        let next = self.next;
        let (mut moving, _, kept) = self.moving(model);
        moving.go(next, kept)?;
        self.look(model)
    }

    fn steps(&self) -> u64 {
        self.state.continuum.steps()
    }

    fn time(&self) -> f64 {
        self.state.time
    }

    fn dt(&self) -> f64 {
        self.state.dt
    }

    fn crush_events(&self) -> u64 {
        self.state.mixture.as_ref().map_or(0, |mixture| mixture.crush_events())
    }

    fn stage(&self, _: &Model) -> &'static str {
        if self.lead.told.is_some() { DRIVEN } else { record::stage(self.state.phase) }
    }

    fn driven(&self) -> bool {
        self.driven
    }

    fn is_over(&self, _: &Model) -> bool {
        self.lead.told.is_none() && (self.lead.beyond || self.state.phase == Phase::Done)
    }

    fn drive(&mut self, model: &Model, wall: usize, drive: Drive) -> Result<()> {
        let side = self.walls[wall].1;
        let plane = matches!(self.walls[wall].2, WallShape::Plane { .. });
        match side {
            Side::Fixed(_) => {
                self.stands(wall, drive, "a side of the specimen that stands still: the loading plates of the test move")
            }
            Side::Grid(_) => {
                self.stands(wall, drive, "a side of the grid, which stands still: a [[wall]] or a driven [[block]] can move")
            }
            Side::Plate(plate) => {
                let drive = checked(drive, self.rig.specimen().map_or(GAIN, |s| s.gain), false)?;
                if self.lead.told.is_none() {
                    self.state.take_over(&self.rig);
                    self.lead.told = Some(vec![Drive::Fixed; self.state.plates.len()]);
                }
                if let Some(told) = &mut self.lead.told {
                    told[plate] = drive;
                    self.state.obey(&self.rig, told);
                }
                self.driven = true;
                Ok(())
            }
            Side::Wall(k) => {
                let drive = checked(drive, GAIN, plane)?;
                if let Drive::Stress { stress, fastest, .. } = drive {
                    if !plane {
                        return wrong("stress", stress.to_string(), "must stand at a plane in a mixture");
                    }
                    let stiff = model.physics.materials.iter().any(|m| m.young > 0.0);
                    if fastest.is_none() && !(stiff && stress > 0.0) {
                        let message = "is missing: it follows from the stress, above 0, and the Young's modulus of a material";
                        return wrong("max_velocity", "None".into(), message);
                    }
                }
                self.state.drive_wall(k, drive);
                self.driven = true;
                Ok(())
            }
        }
    }

    fn drive_body(&mut self, model: &Model, body: usize, velocity: [f64; 3], spin: [f64; 3]) -> Result<()> {
        let bodies = self.bodies().map_or(&[][..], |blocks| &blocks.blocks);
        let Some(found) = bodies.get(body) else {
            return wrong("body", body.to_string(), &format!("there are {} rigid bodies, counted from 0", bodies.len()));
        };
        if !found.driven {
            return wrong("body", body.to_string(), "moves freely: a [[block]] with driven = true or on a path can be driven");
        }
        for (key, vector) in [("velocity", velocity), ("spin", spin)] {
            if !vector.iter().all(|x| x.is_finite()) {
                return wrong(key, format!("{vector:?}"), "must be finite");
            }
        }
        let flat = self.rig.settings.dimension == Dimension::PlaneStrain;
        if flat && velocity[2] != 0.0 {
            return wrong("velocity", format!("{velocity:?}"), "must have 0 along z in plane strain");
        }
        if flat && spin[..2] != [0.0; 2] {
            return wrong("spin", format!("{spin:?}"), "must have 0 along x and y in plane strain");
        }
        if !model.physics.contact.turning && spin != [0.0; 3] {
            return wrong("spin", format!("{spin:?}"), "must be [0, 0, 0] where contact.rotation = \"fixed\"");
        }
        self.state.drive_body(body, velocity, spin);
        self.driven = true;
        Ok(())
    }

    fn grains(&self) -> Option<&dem::State> {
        self.state.mixture.as_ref().map(|mixture| &mixture.grains)
    }

    fn points(&self) -> Option<&Points> {
        Some(self.state.continuum.points()).filter(|points| !points.is_empty())
    }

    fn bodies(&self) -> Option<&Blocks> {
        self.state.blocks()
    }

    fn wall_names(&self, _: &Model) -> Vec<String> {
        self.walls.iter().map(|(name, ..)| name.clone()).collect()
    }

    fn wall(&self, _: &Model, wall: usize) -> WallNow {
        let (_, side, start) = &self.walls[wall];
        let now = self.state.wall(&self.rig, *side);
        let told = match (side, &self.lead.told) {
            (Side::Plate(plate), Some(told)) => Some(told[*plate]),
            _ => None,
        };
        WallNow {
            shape: now.shape,
            displacement: now.shape.way_since(start),
            velocity: if let Some(Drive::Velocity(told)) = told { told } else { now.speed },
            force: now.force,
            shear_z: now.shear_z,
            work: now.work,
            area: now.area,
        }
    }

    fn force(&self, model: &Model, grain: usize) -> [f64; 3] {
        match (&self.engine, &self.state.mixture) {
            (Engine::Mixture(coupled), Some(mixture)) => coupled.force(model, mixture, grain),
            _ => [f64::NAN; 3],
        }
    }

    fn contacts(&self) -> Vec<Contact> {
        self.state.mixture.as_ref().map_or(Vec::new(), |mixture| contacts::of_mixture(mixture, &self.state.continuum))
    }

    fn volume(&self, _: &Model) -> Option<f64> {
        self.state.volume(&self.rig)
    }

    fn breakages(&self) -> Vec<Row> {
        self.kept.breakages[0].clone()
    }

    fn body_breakages(&self) -> Vec<Row> {
        self.kept.breakages[1].clone()
    }

    fn row(&mut self, model: &Model) -> Result<Row> {
        let step = self.steps();
        if let Some((at, row)) = &self.kept.row
            && *at == step
        {
            return Ok(row.clone());
        }
        let driven = self.lead.told.is_some();
        let stage = self.stage(model);
        let (mut moving, _, kept) = self.moving(model);
        if !driven {
            return moving.row_aside();
        }
        let mut row = moving.row()?;
        if let Some((_, value)) = row.iter_mut().find(|(name, _)| *name == "stage") {
            *value = stage.into();
        }
        kept.row = Some((step, row.clone()));
        Ok(row)
    }
}
