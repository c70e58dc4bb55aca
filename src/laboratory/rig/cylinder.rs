//! A cylindrical specimen between its walls: two platens and a shell.

use crate::model::{Model, Specimen};
use engine::boundary::{CylinderSpace, Drive, Wall, WallShape, WallSpec};
use engine::dem::State;
use engine::grains::Grains;

/// Indices of the walls.
pub const BOTTOM: usize = 0;
pub const TOP: usize = 1;
pub const CYLINDER: usize = 2;

/// The three walls, with the material's or the scene's friction.
pub fn walls(specimen: &Specimen, radius: f64, bottom: f64, height: f64) -> Vec<Wall> {
    let wall = |shape, friction| Wall::new(&WallSpec { shape, friction, drive: Drive::Fixed, material: None });
    vec![
        wall(WallShape::Plane { point: [0.0, 0.0, bottom], normal: [0.0, 0.0, 1.0] }, specimen.wall_friction.bottom),
        wall(WallShape::Plane { point: [0.0, 0.0, bottom + height], normal: [0.0, 0.0, -1.0] }, specimen.wall_friction.top),
        wall(WallShape::Cylinder { centre: [0.0, 0.0], radius }, specimen.wall_friction.cylinder),
    ]
}

/// The space between the walls.
pub fn space(state: &State) -> CylinderSpace {
    let z = |k: usize| match state.walls[k].shape {
        WallShape::Plane { point, .. } => point[2],
        WallShape::Cylinder { radius, .. } => radius,
    };
    CylinderSpace { bottom: z(BOTTOM), height: z(TOP) - z(BOTTOM), radius: z(CYLINDER) }
}

/// Stresses at the walls, Pa, compression positive (NOTES.md: decisions).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stresses {
    pub top: f64,
    pub bottom: f64,
    /// Radial force over the shell's current area.
    pub horizontal: f64,
}

impl Stresses {
    pub fn of(state: &State) -> Stresses {
        let size = space(state);
        Stresses {
            top: state.walls[TOP].reaction / size.platen_area(),
            bottom: state.walls[BOTTOM].reaction / size.platen_area(),
            horizontal: state.walls[CYLINDER].reaction / size.shell_area(),
        }
    }

    /// Mean platen force over area.
    pub fn vertical(&self) -> f64 {
        0.5 * (self.top + self.bottom)
    }

    /// Difference of the platens over their mean.
    pub fn platen_difference(&self) -> f64 {
        let v = self.vertical();
        if v > 0.0 { (self.top - self.bottom).abs() / v } else { 0.0 }
    }
}

/// Time scale of grain rearrangement d √(ρ/p) with the inertia actually used: I = strain rate × this. `d` is the mass-weighted mean
/// diameter and ρ the inertial mass over the grains' volume.
pub fn inertial_time(state: &State, pressure: f64) -> f64 {
    let g = &state.grains;
    let (mut inertia, mut volume, mut weighted) = (0.0, 0.0, 0.0);
    for &i in &g.by_id() {
        let i = i as usize;
        let v = engine::grains::sphere_volume(g.pos[i][3]);
        inertia += g.inertia(i);
        volume += v;
        weighted += 2.0 * g.pos[i][3] * v;
    }
    weighted / volume * (inertia / volume / pressure).sqrt()
}

/// The state from which a specimen is tested: no history, at rest, strengths drawn, the damping of its preparation.
pub fn start(model: &Model, specimen: &Specimen, grains: Grains, size: CylinderSpace) -> State {
    let walls = walls(specimen, size.radius, size.bottom, size.height);
    let mut state = State::new(&model.physics, grains, walls, model.records.energy);
    state.reference_stress = specimen.isotropic_stress;
    state.damping = specimen.preparation.damping;
    if let Some(crush) = &model.physics.crush {
        for i in 0..state.grains.len() {
            engine::dem::event::arm_grain(crush, &mut state, i);
        }
    }
    state
}

/// The test begins: damping and crushing as the scene asks, ledger open.
pub fn begin(model: &Model, state: &mut State, work: &engine::dem::Workspace) {
    state.damping = model.physics.damping;
    state.crushing = model.physics.crush.is_some();
    let State { ledger, grains, walls, .. } = state;
    ledger.open(grains, walls);
    let sums = engine::dem::observables::sums(&model.physics, state, work);
    state.ledger.start = [sums.stored, sums.kinetic, sums.potential];
    // the sweep of this instant belongs to what was before
    for w in state.pairs.work.iter_mut().chain(state.wall_pairs.work.iter_mut()) {
        *w = [0.0; 4];
    }
}
