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
    /// Buffer: force, N, and stiffness, N/m, on each wall.
    #[serde(skip)]
    on_walls: Vec<[f64; 2]>,
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
            on_walls: Vec::new(),
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
        point_contacts.apply_reactions(grains, &mut work.external_forces, 1.0, (continuum, table.acts_on), [1.0, 0.0]);
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
        let Embedded { point_contacts, pressed, on_walls, work, .. } = self;
        on_walls.clear();
        on_walls.resize(state.walls.len(), [0.0; 2]);
        point_contacts.add_wall_forces(on_walls);
        for ((wall, before), &mut [now, stiffness]) in state.walls.iter_mut().zip(pressed.iter_mut()).zip(on_walls) {
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
        // of a law whose stiffness depends on the stress, the stiffest point's
        let stiffest = continuum.laws().iter().find(|law| law.stiffens()).map_or(0.0, |law| {
            let points = continuum.points();
            let of = |k: usize| law.stiffness(&points.stress[k], points.memory[k]).oedometric();
            (0..points.len()).map(of).fold(0.0, f64::max)
        });
        let modulus = modulus.max(stiffest);
        let of = |(p, k): (&[f64; 4], &f64)| step * (modulus * p[3] / (cell * cell) + 0.5 * k);
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

#[cfg(test)]
mod tests {
    use super::super::tests::{floor, grain, physics, point};
    use super::*;
    use crate::contact::ContactLaw;
    use crate::grains::Grains;
    use crate::mpm::law::Elastic;

    const DAMPING: f64 = 0.25;

    fn embedding() -> Embedding {
        Embedding { law: Law::Elastic(Elastic::of_young(1e6, 0.3)), porosity: 0.4, cell: 0.05, release_strain: 0.1 }
    }

    /// A test at one second a step, with a grain on the floor and a point that overlaps both by a millimetre.
    fn scene(speed: f64) -> (Physics, State, Workspace, Embedded) {
        let mut physics = physics(ContactLaw::Hertz);
        (physics.damping, physics.stepping.inertia_scaling) = (DAMPING, true);
        let grains = grain([0.0, 0.0, 0.1], [0.01, 0.0, 0.0], [0.0, 0.02, 0.0], &physics);
        let mut state = State::new(&physics, grains, vec![floor(speed)], false);
        state.dt = 1.0;
        let work = Workspace::new(&physics, &mut state);
        let size = CylinderSpace { bottom: 0.0, height: 0.3, radius: 0.12 };
        let mut embedded = Embedded::new(&physics, &embedding(), size).expect("a grid");
        // radius 0.1 and ghost 0.02: beside the grain and in the floor
        let height: f64 = 0.019;
        let across = (0.119f64 * 0.119 - (0.1 - height).powi(2)).max(0.0).sqrt();
        embedded.continuum.insert(&[point([across, 0.0, height], [0.0; 3]), point([0.1, 0.1, 0.25], [0.0; 3])]);
        (physics, state, work, embedded)
    }

    /// Points of the scene itself are accepted, those of a scene with a stiffer law are not.
    #[test]
    fn points_of_another_scene_are_refused() {
        let physics = physics(ContactLaw::Hertz);
        // bottom, top and side
        let state = State::new(&physics, Grains::default(), [(); 3].map(|()| floor(0.0)).to_vec(), false);
        let embedded =
            Embedded::new(&physics, &embedding(), CylinderSpace { bottom: 0.0, height: 0.3, radius: 0.12 }).expect("a grid");
        assert_eq!(embedded.check(&physics, &embedding(), &state), Ok(()));
        let stiffer = Embedding { law: Law::Elastic(Elastic::of_young(2e6, 0.3)), ..embedding() };
        assert!(embedded.check(&physics, &stiffer, &state).is_err());
    }

    /// The grid reaches three cells beyond the specimen, and a point of a full cell is an eighth of its solids.
    #[test]
    fn the_grid_surrounds_the_specimen() {
        let (_, _, _, embedded) = scene(0.0);
        let settings = embedded.continuum().settings();
        assert_eq!(settings.cells, [11, 11, 12]);
        for (low, expected) in settings.lower.into_iter().zip([-0.275, -0.275, -0.15]) {
            assert!((low - expected).abs() < 1e-12, "{:?}", settings.lower);
        }
        assert_eq!(settings.damping, DAMPING);
        assert!((embedding().solid() / (0.6 * 0.05f64.powi(3) / 8.0) - 1.0).abs() < 1e-12);
        assert_eq!(
            (embedded.fines.rule.density, embedded.fines.rule.at_rest, embedded.fines.rule.release_strain),
            (2500.0, true, 0.1)
        );
        let modulus = Elastic::of_young(1e6, 0.3).oedometric();
        assert!((embedded.modulus / modulus - 1.0).abs() < 1e-12);
    }

    /// Points press on walls beside the grains: reaction, stiffness, and work by the trapezium rule.
    #[test]
    fn points_press_on_walls() {
        let (physics, mut state, mut work, mut embedded) = scene(1e-5);
        let dt = 0.5;
        state.dt = dt;
        let pair = physics.contact.law.on_wall(&physics.materials[0], 0.3);
        let force = |overlap: f64| pair.normal_stiffness * (0.02 * overlap).sqrt() * overlap;
        embedded.compute_forces(&physics, &mut state, &mut work);
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-9, "{a} instead of {b}");
        let first = force(1e-3);
        close(embedded.pressed(0), first);
        close(state.walls[0].reaction, first);
        close(state.walls[0].stiffness, 1.5 * pair.normal_stiffness * (0.02f64 * 1e-3).sqrt());
        close(state.walls[0].work, 0.5 * first * 1e-5 * dt);
        close(embedded.work, 0.5 * first * 1e-5 * dt);
        // the wall moves up by a hundredth of a millimetre
        state.walls[0].advance(1.0);
        state.walls[0].reaction = 7.0;
        embedded.compute_forces(&physics, &mut state, &mut work);
        let second = force(1.01e-3);
        close(state.walls[0].reaction, 7.0 + second);
        close(embedded.pressed(0), second);
        // ½ (F_old + F_new) of the way since, on top of the first half
        close(embedded.work, (0.5 * first + 0.5 * (first + second)) * 1e-5 * dt);
        // half a step of the grain's power on the points is ahead of it
        let touch = embedded.point_contacts.on_grains().next().expect("a contact").3;
        let [x, y, z] = touch.force();
        let torque = scaled(cross(touch.normal, touch.tangential), 0.1 - 0.5 * touch.overlap);
        let power = -dot([x, y, z], [0.01, 0.0, 0.0]) - dot(torque, [0.0, 0.02, 0.0]);
        close(state.ledger.points, embedded.work + 0.5 * dt * power);
        assert!((power / (embedded.work + 1e-30)).abs() > 1e-3);
        // none where there are no points
        embedded.continuum.points_mut().remove(&[true, true]);
        embedded.compute_forces(&physics, &mut state, &mut work);
        assert_eq!((embedded.pressed(0), embedded.point_contacts.candidates.len()), (0.0, 0));
        assert_eq!(state.ledger.points, embedded.work);
    }

    /// The work of grains on points in a step is half a step at the power before, and half a step at the power after the grain has moved.
    #[test]
    fn work_on_points_is_that_of_both_half_steps() {
        let (physics, mut state, mut work, mut embedded) = scene(0.0);
        state.dt = 0.5;
        embedded.compute_forces(&physics, &mut state, &mut work);
        let before = embedded.power(&state);
        embedded.advance(&physics, &mut state, &mut work).expect("a step");
        let after = embedded.power(&state);
        assert!(before != 0.0 && after != before);
        assert!((embedded.work / (0.25 * (before + after)) - 1.0).abs() < 1e-12, "{} {before} {after}", embedded.work);
        assert_eq!(embedded.continuum.steps(), 1);
    }

    /// A grain and a point that come towards each other, or a wall and a point, touch as soon as they meet.
    #[test]
    fn what_moves_meets_the_points_in_its_way() {
        for (of_grain, of_point, of_wall) in [(4e-3, 0.0, 0.0), (0.0, 4e-3, 0.0), (2e-3, 2e-3, 0.0), (0.0, 0.0, 4e-3)] {
            let (physics, mut state, mut work, mut embedded) = scene(of_wall);
            let gap = 0.03;
            state.grains.vel[0][..3].copy_from_slice(&[of_grain, 0.0, 0.0]);
            state.grains.pos[0][2] = 0.2;
            let p = embedded.continuum.points_mut();
            p.position[0][..3].copy_from_slice(&[0.12 + gap, 0.0, 0.2]);
            p.position[1][..3].copy_from_slice(&[0.1, 0.1, 0.02 + gap]);
            p.transport_velocity[0] = [-of_point, 0.0, 0.0];
            let body = if of_wall > 0.0 { Body::Wall(0) } else { Body::Grain(0) };
            for step in 0..9 {
                embedded.compute_forces(&physics, &mut state, &mut work);
                let touches = embedded.point_contacts.touching().any(|c| c.body == body);
                assert_eq!(touches, 4e-3 * f64::from(step) > gap, "{of_grain} {of_point} {of_wall}: {step}");
                state.grains.pos[0][0] += of_grain;
                embedded.continuum.points_mut().position[0][0] -= of_point;
                state.walls[0].advance(1.0);
            }
        }
    }

    /// Counts the energy that a contact gains while sliding releases the overlap that its point was born with.
    #[test]
    fn released_overlaps_are_accounted_for() {
        let (physics, mut state, mut work, mut embedded) = scene(0.0);
        (state.grains.vel[0][0], state.grains.spin[0]) = (0.0, [0.0; 4]);
        embedded.point_contacts.note_newborn(0, 1);
        embedded.compute_forces(&physics, &mut state, &mut work);
        assert_eq!((embedded.pressed(0), embedded.fines.released), (0.0, 0.0));
        // the floor rises by a tenth of a millimetre, and the point slides by as much: a fortieth of a ghost's diameter times the strain
        state.walls[0].speed = 1e-4;
        state.walls[0].advance(1.0);
        state.walls[0].speed = 0.0;
        embedded.continuum.points_mut().transport_velocity[0] = [1e-4, 0.0, 0.0];
        embedded.compute_forces(&physics, &mut state, &mut work);
        let pair = physics.contact.law.on_wall(&physics.materials[0], 0.3);
        let force = pair.normal_stiffness * (0.02f64 * 1e-4).sqrt() * 1e-4;
        assert!((embedded.pressed(0) / force - 1.0).abs() < 1e-9);
        assert!((embedded.fines.released / (force * 1e-3 / 40.0) - 1.0).abs() < 1e-9, "{}", embedded.fines.released);
    }

    /// A point gets the inertial mass (1 + α) dt²/s² (M V/h² + k/2), and a fifth more, where it has less; else it keeps what it has.
    #[test]
    fn points_get_the_inertia_that_makes_the_step_stable() {
        let (physics, mut state, mut work, mut embedded) = scene(0.0);
        embedded.compute_forces(&physics, &mut state, &mut work);
        let safety = physics.stepping.safety;
        let stiffness = |i: usize| {
            let id = embedded.continuum.points().id[i];
            embedded.point_contacts.touching().filter(|c| c.point == id).map(|c| c.stiffness[0].max(c.stiffness[1])).sum::<f64>()
        };
        let needed: Vec<f64> = (0..2)
            .map(|i| {
                let volume = embedded.continuum.points().position[i][3];
                (1.0 + DAMPING) / (safety * safety) * (embedded.modulus * volume / (0.05 * 0.05) + 0.5 * stiffness(i))
            })
            .collect();
        assert!(stiffness(0) > 0.0 && stiffness(1) == 0.0);
        let mass = |e: &Embedded, i: usize| e.continuum.points().velocity[i][3];
        embedded.raise_point_inertia(&physics, 1.0);
        for (i, needed) in needed.iter().enumerate() {
            assert!((mass(&embedded, i) / (1.2 * needed) - 1.0).abs() < 1e-12, "{i}");
        }
        // enough for a step of 1.05 s, not of 1.2 s
        let before = [0, 1].map(|i| mass(&embedded, i));
        embedded.raise_point_inertia(&physics, 1.05);
        assert_eq!([0, 1].map(|i| mass(&embedded, i)), before);
        embedded.raise_point_inertia(&physics, 1.2);
        assert!((mass(&embedded, 0) / (1.44 * before[0]) - 1.0).abs() < 1e-12);
    }

    /// The grain's inertial mass takes the contacts with points into account, at every eighth step.
    #[test]
    fn grains_get_inertia_for_contacts_with_points() {
        let (physics, mut state, mut work, mut embedded) = scene(0.0);
        state.grains.set_inertia(0, 1e-3);
        state.step = 3;
        embedded.compute_forces(&physics, &mut state, &mut work);
        assert!((state.grains.inertia(0) / 1e-3 - 1.0).abs() < 1e-12, "not yet");
        state.step = 8;
        embedded.compute_forces(&physics, &mut state, &mut work);
        let sum: f64 = embedded.point_contacts.touching().filter(|c| c.body == Body::Grain(0)).map(|c| c.inertia_stiffness()).sum();
        let least = (1.0 + DAMPING) * sum / (4.0 * physics.stepping.safety * physics.stepping.safety);
        assert!(sum > 0.0 && state.grains.inertia(0) >= least * (1.0 - 1e-12), "{} {least}", state.grains.inertia(0));
    }
}
