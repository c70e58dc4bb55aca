//! Fines from crushing as material points between the grains of a test with inertia scaling (an oedometer). Grains and points make the same steps.
//!
//! There are no points before the first breakage. From then on each step computes the contacts of points with grains and walls, adds their forces to both
//! sides, and the continuum makes one step for each step of the grains.
//!
//! With inertia scaling time counts steps, and a point, like a grain, gets the inertial mass that makes the step stable. The bound of the leapfrog
//! is 1/dt² ≥ (c/h)² + k/(2m): that of [`crate::mpm::with_plates`] with APIC, and a contact's stiffness shared between its two ends as in
//! [`crate::dem::stability`]. So m = (1 + α) dt²/s² (M V/h² + k/2) with the law's modulus of compression M, the point's volume V, the edge of a cell h, the
//! sum k of the stiffnesses of the point's contacts, the safety factor s and the coefficient of local damping α. The inertial masses of grains in
//! contact with points are raised for these contacts as well.

use super::evaluate::PointContactScene;
use super::{Body, FinesAsPoints, PointContacts, Rule};
use crate::boundary::CylinderSpace;
use crate::check::{self, Checked};
use crate::dem;
use crate::dem::physics::Physics;
use crate::dem::{State, Workspace, stability};
use crate::error::Result;
use crate::math::vector::{cross, dot, scaled};
use crate::mpm::law::Law;
use crate::mpm::{Continuum, Dimension, GridWall as Side, Points, Settings, ShapeFunctions, Transfer};
use crate::point_contacts::PointContactTable;
use serde::{Deserialize, Serialize};

/// Number of cells by which the grid extends beyond the specimen on each side.
const MARGIN: f64 = 3.0;
/// Factor by which a raised inertial mass exceeds what is needed, so that it need not be raised again soon.
const MORE: f64 = 1.2;
/// Steps between two updates of the inertial masses of grains in contact with points.
const LOOK: u64 = 8;

/// How fines from crushing become material points between the grains of a test.
#[derive(Clone, Debug)]
pub struct Embedding {
    /// Constitutive law of the fines.
    pub law: Law,
    /// Porosity of the fines when they become points, without stress.
    pub porosity: f64,
    /// Edge of a cell, m.
    pub cell: f64,
    /// As [`Rule::release_strain`].
    pub release_strain: f64,
}

impl Embedding {
    /// Number of points along the edge of a cell that is full of points.
    const PER_EDGE: f64 = 2.0;

    /// Largest volume of solids of one point, m³.
    pub fn solid(&self) -> f64 {
        (1.0 - self.porosity) * (self.cell / Self::PER_EDGE).powi(3)
    }
}

/// The fines of a test as material points, with their contacts: what a restart needs of them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Embedded {
    /// The points and their grid.
    continuum: Continuum,
    /// Contacts of points with grains and walls.
    point_contacts: PointContacts,
    /// The mass of breakages as points: what became points, and what waits for room.
    pub fines: FinesAsPoints,
    /// Modulus of compression K + 4/3 G of the fines' law, Pa.
    modulus: f64,
    /// Normal force of the points on each wall, N.
    pressed: Vec<f64>,
    /// Work of grains and walls on the points so far, J.
    pub work: f64,
    /// Contact parameters; made when they are first needed.
    #[serde(skip)]
    table: Option<PointContactTable>,
    /// Buffer: sum of the stiffnesses of each point's contacts, N/m.
    #[serde(skip)]
    contact_stiffness: Vec<f64>,
}

impl Embedded {
    /// Without points, on a grid around a specimen that fills the space `size`.
    ///
    /// # Errors
    /// A grid that is not allowed, such as one with too many cells.
    pub fn new(physics: &Physics, embedding: &Embedding, size: CylinderSpace) -> Result<Embedded> {
        let cell = embedding.cell;
        let wide = ((2.0 * size.radius / cell).ceil() + 2.0 * MARGIN) as u32;
        let high = ((size.height / cell).ceil() + 2.0 * MARGIN) as u32;
        let middle = 0.5 * f64::from(wide) * cell;
        Embedded::on_grid(physics, embedding, [-middle, -middle, size.bottom - MARGIN * cell], [wide, wide, high])
    }

    /// Without points, on a grid with the lower corner `lower`, m, and so many cells.
    ///
    /// # Errors
    /// As [`Self::new`].
    fn on_grid(physics: &Physics, embedding: &Embedding, lower: [f64; 3], cells: [u32; 3]) -> Result<Embedded> {
        let settings = Settings {
            dimension: Dimension::Space,
            cell: embedding.cell,
            lower,
            cells,
            walls: [Side::Open; 6],
            gravity: [0.0; 3],
            shape: ShapeFunctions::BSpline,
            transfer: Transfer::Affine,
            damping: physics.damping,
        };
        let mut continuum = Continuum::new(settings, vec![embedding.law.clone()], Points::default())?;
        continuum.keep_transport_velocity();
        let density = physics.materials[0].density;
        let solid = embedding.solid();
        let rule =
            Rule { release_strain: embedding.release_strain, law: 0, porosity: embedding.porosity, solid, density, at_rest: true };
        // c² ρ of the law, for any density
        let modulus = embedding.law.wave_speed(1.0).powi(2);
        Ok(Embedded {
            continuum,
            point_contacts: PointContacts::default(),
            fines: FinesAsPoints::new(rule),
            modulus,
            pressed: vec![0.0; 3],
            work: 0.0,
            table: None,
            contact_stiffness: Vec::new(),
        })
    }

    /// Checks points that come from outside with the grains of their run, `state`.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, physics: &Physics, embedding: &Embedding, state: &State) -> Checked {
        let Settings { lower, cells, .. } = *self.continuum.settings();
        let made = Embedded::on_grid(physics, embedding, lower, cells).map_err(|e| e.to_string())?;
        self.continuum.check(&made.continuum, FinesAsPoints::most(state.crush_events))?;
        self.point_contacts.check(&state.grains, state.walls.len(), &self.continuum)?;
        self.fines.check(&made.fines.rule, self.continuum.points().len())?;
        check::lengths("walls at points", state.walls.len(), [self.pressed.len()])?;
        check::numbers("points at walls", self.pressed.iter().chain([&self.work]))?;
        check::ensure(self.modulus == made.modulus, || "the law of the fines is not that of the scene".into())
    }

    /// The points and their grid.
    pub fn continuum(&self) -> &Continuum {
        &self.continuum
    }

    /// Normal force of the points on wall `k`, N, positive in compression.
    pub fn pressed(&self, k: usize) -> f64 {
        self.pressed[k]
    }

    /// Computes the forces of this instant between points and grains or walls. The walls' reactions, which have been those of grains, are then of both.
    pub fn compute_forces(&mut self, physics: &Physics, state: &mut State, work: &mut Workspace) {
        if self.continuum.points().is_empty() {
            self.point_contacts.clear();
            self.pressed.fill(0.0);
            state.ledger.points = self.work;
            return;
        }
        let Embedded { continuum, point_contacts, fines, table, contact_stiffness, .. } = self;
        let State { grains, walls, dt, aftermath, .. } = &*state;
        let table = table.get_or_insert_with(|| PointContactTable::new(physics.contact.law, &[0], &physics.materials, walls));
        let fastest = |v: f64, [x, y, z]: [f64; 3]| v.max(x * x + y * y + z * z);
        let points = continuum.points().transport_velocity.iter().fold(0.0, |v, c| fastest(v, *c)).sqrt();
        let bodies = grains.vel.iter().fold(0.0, |v, c| fastest(v, [c[0], c[1], c[2]])).sqrt();
        let wall = walls.iter().map(|w| w.speed.abs()).fold(0.0, f64::max);
        let way = dt * (points + bodies.max(wall)) + aftermath.fastest_growth();
        point_contacts.update(grains, walls, continuum, way);
        let scene =
            PointContactScene { grains, walls, continuum, table, unloading: physics.contact.unloading, dt: *dt, ahead: [0.0; 2] };
        point_contacts.evaluate(&scene);
        fines.released += point_contacts.release(&scene, fines.rule.release_strain);
        point_contacts.apply_reactions(grains, &mut work.external_forces, 1.0, continuum, [1.0, 0.0]);
        contact_stiffness.clear();
        contact_stiffness.resize(continuum.points().len(), 0.0);
        for contact in point_contacts.touching() {
            contact_stiffness[contact.place[1] as usize] += contact.stiffness[0].max(contact.stiffness[1]);
        }
        self.press(state);
        // work up to this instant: the half step before the instant is not in `work` yet
        state.ledger.points = self.work + 0.5 * state.dt * self.power(state);
        if state.step.is_multiple_of(LOOK) {
            self.raise_grain_inertia(physics, state, work);
        }
    }

    /// Adds the forces of points to the walls' reactions and work, which have been those of grains so far.
    fn press(&mut self, state: &mut State) {
        let Embedded { point_contacts, pressed, work, .. } = self;
        for (k, (wall, before)) in state.walls.iter_mut().zip(pressed.iter_mut()).enumerate() {
            let (mut now, mut stiffness) = (0.0, 0.0);
            for contact in point_contacts.touching().filter(|g| g.body == Body::Wall(k as u32)) {
                now += contact.touch.normal_force;
                stiffness += contact.stiffness[0];
            }
            // trapezium rule: the last reaction, with points, has been counted by the grains' step as if grains alone had pressed
            let way = wall.speed * state.dt;
            wall.work += 0.5 * now * way;
            *work += 0.5 * (*before + now) * way;
            wall.reaction += now;
            wall.stiffness += stiffness;
            *before = now;
        }
    }

    /// Raises the inertial masses of grains in contact with points, where needed.
    fn raise_grain_inertia(&self, physics: &Physics, state: &mut State, work: &Workspace) {
        let mut touching = self.point_contacts.touching().filter(|g| matches!(g.body, Body::Grain(_))).peekable();
        while let Some(first) = touching.next() {
            let mut sum = first.inertia_stiffness();
            while let Some(next) = touching.next_if(|next| next.body == first.body) {
                sum += next.inertia_stiffness();
            }
            stability::raise_inertia(first.place[0] as usize, sum, physics, state, work);
        }
    }

    /// Moves grains and points by one step, breaks grains, and turns the mass that they lose into points.
    ///
    /// # Errors
    /// A point that is lost.
    pub fn advance(&mut self, physics: &Physics, state: &mut State, work: &mut Workspace) -> Result<()> {
        let half = 0.5 * state.dt;
        let mut given = half * self.power(state);
        dem::move_grains(physics, state, work);
        given += half * self.power(state);
        self.work += given;
        dem::breakage(physics, state, work);
        if !self.continuum.points().is_empty() {
            self.raise_point_inertia(physics, state.dt);
            self.continuum.step(state.dt)?;
        }
        self.fines.queue(&work.breakages);
        self.fines.insert_points(state, &mut self.continuum, &mut self.point_contacts);
        let walls = &state.walls;
        let beyond_wall = |[x, y, z, _]: [f64; 4]| walls.iter().any(|w| w.shape.towards([x, y, z, 0.0]).1 < 0.0);
        self.fines.remove_points(beyond_wall, &mut self.continuum, &mut self.point_contacts);
        Ok(())
    }

    /// Power of the grains on the points, W, at the present velocities.
    fn power(&self, state: &State) -> f64 {
        let g = &state.grains;
        let of = |(grain, _, _, touch): (usize, usize, f64, crate::contact::pairs::ContactForce)| {
            let [u, v, w, _] = g.vel[grain];
            let [a, b, c, _] = g.spin[grain];
            let torque = scaled(cross(touch.normal, touch.tangential), g.radius(grain) - 0.5 * touch.overlap);
            -dot(touch.force(), [u, v, w]) - dot(torque, [a, b, c])
        };
        self.point_contacts.on_grains().map(of).sum()
    }

    /// Raises the inertial masses of points, where needed.
    fn raise_point_inertia(&mut self, physics: &Physics, dt: f64) {
        let Embedded { continuum, contact_stiffness, modulus, .. } = self;
        contact_stiffness.resize(continuum.points().len(), 0.0);
        let (cell, damping, safety) = (continuum.settings().cell, continuum.settings().damping, physics.stepping.safety);
        // local damping acts as if contacts were stiffer by 1 + α, as for grains
        let step = (1.0 + damping) * dt * dt / (safety * safety);
        let of = |(p, k): (&[f64; 4], &f64)| step * (*modulus * p[3] / (cell * cell) + 0.5 * k);
        let points = continuum.points();
        let needed = points.position.iter().zip(contact_stiffness.iter()).map(of);
        if !needed.zip(&points.velocity).any(|(needed, v)| v[3] < needed) {
            return;
        }
        let points = continuum.points_mut();
        for ((p, k), v) in points.position.iter().zip(contact_stiffness.iter()).zip(&mut points.velocity) {
            let needed = of((p, k));
            if v[3] < needed {
                v[3] = MORE * needed;
            }
        }
    }
}
