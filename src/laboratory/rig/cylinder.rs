//! The walls of a cylindrical specimen (bottom platen, top platen, cylinder), the stresses on them, and the start of its test.

use crate::model::{Model, Specimen};
use engine::boundary::{CylinderSpace, Drive, Wall, WallShape, WallSpec};
use engine::check::{self, Checked};
use engine::dem::State;
use engine::dem::physics::Physics;
use engine::grains::Grains;

/// Index of the bottom platen among the walls of the state.
pub const BOTTOM: usize = 0;
/// Index of the top platen.
pub const TOP: usize = 1;
/// Index of the cylinder.
pub const CYLINDER: usize = 2;

/// The three walls with the friction of the scene, at rest. `radius`, `bottom` (height of the bottom platen) and `height` in m.
pub fn walls(specimen: &Specimen, radius: f64, bottom: f64, height: f64) -> Vec<Wall> {
    let wall = |shape, friction| Wall::new(&WallSpec { shape, friction, drive: Drive::Fixed, material: None });
    vec![
        wall(WallShape::Plane { point: [0.0, 0.0, bottom], normal: [0.0, 0.0, 1.0] }, specimen.wall_friction.bottom),
        wall(WallShape::Plane { point: [0.0, 0.0, bottom + height], normal: [0.0, 0.0, -1.0] }, specimen.wall_friction.top),
        wall(WallShape::Cylinder { centre: [0.0, 0.0], radius }, specimen.wall_friction.cylinder),
    ]
}

/// The space between the walls of `state`.
pub fn space(state: &State) -> CylinderSpace {
    let z = |k: usize| match state.walls[k].shape {
        WallShape::Plane { point, .. } => point[2],
        WallShape::Cylinder { radius, .. } => radius,
    };
    CylinderSpace { bottom: z(BOTTOM), height: z(TOP) - z(BOTTOM), radius: z(CYLINDER) }
}

/// Stresses on the walls, Pa, compression positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stresses {
    /// Force on the top platen over its area.
    pub top: f64,
    /// Force on the bottom platen over its area.
    pub bottom: f64,
    /// Sum of the radial forces on the cylinder over its area between the platens.
    pub horizontal: f64,
}

impl Stresses {
    /// The stresses on the walls of `state`, from the forces of its last step and the present areas.
    pub fn of(state: &State) -> Stresses {
        let size = space(state);
        Stresses {
            top: state.walls[TOP].reaction / size.platen_area(),
            bottom: state.walls[BOTTOM].reaction / size.platen_area(),
            horizontal: state.walls[CYLINDER].reaction / size.shell_area(),
        }
    }

    /// Vertical stress: mean of both platens, Pa.
    pub fn vertical(&self) -> f64 {
        0.5 * (self.top + self.bottom)
    }

    /// Difference of the stresses on the platens over their mean, -; 0 where the mean is not positive.
    pub fn platen_difference(&self) -> f64 {
        let v = self.vertical();
        if v > 0.0 { (self.top - self.bottom).abs() / v } else { 0.0 }
    }
}

/// Time scale of grain rearrangement d √(ρ/p), s: the strain rate times this is the inertial number. d is the mean diameter
/// weighted by volume, ρ the inertial mass (scaled, where inertia is scaled) over the volume of the grains, p the `pressure`, Pa.
pub fn inertial_time(state: &State, pressure: f64) -> f64 {
    let g = &state.grains;
    let (mut inertia, mut volume, mut weighted) = (0.0, 0.0, 0.0);
    for &i in &g.by_id() {
        let i = i as usize;
        let v = engine::grains::sphere_volume(g.radius(i));
        inertia += g.inertia(i);
        volume += v;
        weighted += 2.0 * g.radius(i) * v;
    }
    weighted / volume * (inertia / volume / pressure).sqrt()
}

/// The first state of a specimen's test: at rest, contacts without history, strengths drawn, the damping of the preparation.
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

/// Checks grains and walls of a specimen that come from a checkpoint. `physics` are those with which the grains move, `energy`: whether
/// contacts keep their works.
///
/// # Errors
/// What is wrong, in words.
pub fn check(physics: &Physics, specimen: &Specimen, state: &State, energy: bool) -> Checked {
    state.check(physics, &State::new(physics, Grains::default(), walls(specimen, 1.0, 0.0, 1.0), energy))?;
    let size = space(state);
    check::positive("sizes of the specimen", [size.height, size.radius])
}

/// Begins the test of a specimen that is at rest: from now on damping and crushing are those of the scene, and the energy ledger
/// counts.
pub fn begin(model: &Model, state: &mut State, work: &engine::dem::Workspace) {
    state.damping = model.physics.damping;
    state.crushing = model.physics.crush.is_some();
    let State { ledger, grains, walls, .. } = state;
    ledger.open(grains, walls);
    let sums = engine::dem::observables::sums(&model.physics, state, work);
    state.ledger.start = [sums.stored, sums.kinetic, sums.potential];
    // the contacts' work of the step before the test is not counted
    for w in state.pairs.work.iter_mut().chain(state.wall_pairs.work.iter_mut()) {
        *w = [0.0; 4];
    }
}
