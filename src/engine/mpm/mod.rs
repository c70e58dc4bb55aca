//! The continuum: a material point method with quadratic B-splines or generalised interpolation, in space or in plane strain.
//!
//! A rig owns a [`Continuum`] and calls [`Continuum::step`]; everything that a restart needs is serialised with it, the grid and the order of
//! points are scratch. Tension is positive inside; compression is in records.
//!
//! Papers: Li et al. 2023 (Comput. Geotech. 160), Jiang et al. 2020 (IJNME), Zhang et al. (SPH of binary mixtures).

mod blocks;
mod check;
mod external_forces;
mod grid;
pub mod law;
pub mod loading_plate;
mod measure;
mod pass;
mod plate_drive;
mod points;
mod spline;
mod step;
mod stress;
mod transfer;
mod walls;

pub use check::with_plates;
pub use loading_plate::LoadingPlate;
pub use measure::Totals;
pub use plate_drive::{PlateDrive, Ramp, area};
pub use points::{Face, Point, Points};
pub use spline::{BSpline, Gimp, ShapeFunction, ShapeFunctions};
pub use stress::rotate_jaumann;
pub use walls::GridWall;

use crate::error::Result;
use law::Law;
use serde::{Deserialize, Serialize};

/// Two dimensions or three.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Dimension {
    /// Plane strain in x, y; masses, volumes and forces are per metre of thickness.
    PlaneStrain,
    Space,
}

/// How velocities go to the points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Transfer {
    /// Li et al. 2023, eq. 30: α = 1 is PIC, 0 is FLIP.
    Blend { pic: f64 },
    /// Affine particle-in-cell; with B-splines only.
    Affine,
}

/// The grid, its sides and the choices of the method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    pub dimension: Dimension,
    /// Edge of a cell, m.
    pub cell: f64,
    /// Lower corner of the domain, m, and its size in cells (in plane strain the third entries mean nothing).
    pub lower: [f64; 3],
    pub cells: [u32; 3],
    /// Sides of the domain: x low, x high, y low, y high, z low, z high.
    pub walls: [GridWall; 6],
    /// Acceleration, m/s².
    pub gravity: [f64; 3],
    pub shape: ShapeFunctions,
    pub transfer: Transfer,
    /// Local damping at nodes, −α |f| sign(v); 0 for none, below 1.
    pub damping: f64,
}

impl Settings {
    /// Size in cells, for signed arithmetic.
    fn size(&self) -> [i32; 3] {
        self.cells.map(|n| n as i32)
    }
}

/// Material points on a grid: state, choices and scratch.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Continuum {
    settings: Settings,
    laws: Vec<Law>,
    points: Points,
    /// Whether [`Points::transport_velocity`] is kept.
    keeps_transport_velocity: bool,
    /// Steps done.
    step: u64,
    /// Work of the stresses since the start, J.
    stress_work: f64,
    /// Force of each wall on the material in the last step, N.
    wall_force: [[f64; 3]; 6],
    #[serde(skip)]
    work: step::GridWorkspace,
}

impl Continuum {
    /// # Errors
    /// A setting, law or point that is not allowed, a point outside of the domain: by name.
    pub fn new(settings: Settings, laws: Vec<Law>, mut points: Points) -> Result<Continuum> {
        check::all(&settings, &laws, &points)?;
        if settings.transfer == Transfer::Affine {
            points.affine.resize(points.len(), [[0.0; 3]; 3]);
        } else {
            points.affine = Vec::new();
        }
        let work = step::GridWorkspace::default();
        Ok(Continuum {
            settings,
            laws,
            points,
            keeps_transport_velocity: false,
            step: 0,
            stress_work: 0.0,
            wall_force: [[0.0; 3]; 6],
            work,
        })
    }

    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    pub fn laws(&self) -> &[Law] {
        &self.laws
    }

    pub fn points(&self) -> &Points {
        &self.points
    }

    /// The points, to be changed; what the grid knows of them is then found anew in the next step.
    pub fn points_mut(&mut self) -> &mut Points {
        self.work.forget();
        &mut self.points
    }

    /// Adds points between two steps; the first one's identity.
    pub fn insert(&mut self, new: &[Point]) -> u32 {
        let Continuum { points, work, settings, keeps_transport_velocity, .. } = self;
        work.forget();
        let first = points.next_id;
        for point in new {
            points.add(point);
            if *keeps_transport_velocity {
                points.transport_velocity.push(point.velocity);
            }
            if settings.transfer == Transfer::Affine {
                points.affine.push([[0.0; 3]; 3]);
            }
            if !points.faces.is_empty() {
                points.faces.push(Face::default());
            }
        }
        first
    }

    /// Steps done.
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// Work of the stresses on the strains since the start, J: trapezium rule over every step. What of it is elastic energy is the law's affair.
    pub fn stress_work(&self) -> f64 {
        self.stress_work
    }

    /// Force of each side on the material in the last step, N (order as [`Settings::walls`]).
    pub fn wall_force(&self) -> &[[f64; 3]; 6] {
        &self.wall_force
    }

    /// Steps, stress work and wall forces of steps that were done elsewhere.
    #[cfg(feature = "gpu")]
    pub fn set_counters(&mut self, step: u64, stress_work: f64, wall_force: [[f64; 3]; 6]) {
        (self.step, self.stress_work, self.wall_force) = (step, stress_work, wall_force);
    }

    /// From now on [`Points::transport_velocity`] is kept.
    pub fn keep_transport_velocity(&mut self) {
        self.keeps_transport_velocity = true;
        let Points { transport_velocity, velocity, .. } = &mut self.points;
        if transport_velocity.is_empty() {
            transport_velocity.extend(velocity.iter().map(|v| [v[0], v[1], v[2]]));
        }
    }

    /// Calls `visit` with the indices of all points in the box between two corners, m, and of some around it.
    pub fn visit(&self, corners: [[f64; 3]; 2], visit: impl FnMut(usize)) {
        match self.settings.dimension {
            Dimension::PlaneStrain => self.work.visit::<2>(&self.settings, &self.points, corners, visit),
            Dimension::Space => self.work.visit::<3>(&self.settings, &self.points, corners, visit),
        }
    }

    /// Adds a force, N, of something so stiff, N/m, on the point at index `i` of [`Self::points`] for the next step; points change places in a step.
    pub fn add_external_force(&mut self, i: usize, [x, y, z]: [f64; 3], stiffness: f64) {
        let external = self.work.external_forces.of_mut(i, self.points.len());
        for (sum, f) in external.force.iter_mut().zip([x, y, z, stiffness]) {
            *sum += f;
        }
    }

    /// As [`Self::add_external_force`], of a force along `normal`, into the material, on the face of the point that stands against it: each component acts as far beside the point
    /// along its own axis as the face does. From then on the face is followed, [`Points::faces`], until [`Self::release_face`].
    pub fn add_face_force(&mut self, i: usize, force: f64, normal: [f64; 3], stiffness: f64) {
        let Continuum { points, work, settings, .. } = self;
        points.faces.resize(points.len(), Face::default());
        let external = work.external_forces.of_mut(i, points.len());
        for a in (0..3).filter(|&a| normal[a] != 0.0) {
            if points.faces[i][0][a] == 0.0 {
                points.faces[i][1][a] = points.position[i][a] - normal[a] * points.half_edge(i, settings.dimension);
            }
            let [beside, face] = &mut points.faces[i];
            beside[a] = face[a] - points.position[i][a];
            external.beside[a] += normal[a] * force;
        }
        external.beside[3] += stiffness;
    }

    /// What pushed along `normal` does not touch the point at index `i` any more.
    pub fn release_face(&mut self, i: usize, normal: [f64; 3]) {
        let [beside, _] = &mut self.points.faces[i];
        for (beside, normal) in beside.iter_mut().zip(normal) {
            if *beside * normal < 0.0 {
                *beside = 0.0;
            }
        }
    }

    /// What the stiffness of all that pushed in the last step adds at most to the square of a frequency of the points' motion, 1/s²; found where
    /// [`Points::transport_velocity`] is kept.
    ///
    /// Σ_q k_q N_q u(x_q) at the nodes over their masses is what contacts of the points q make of nodes' displacements. Its eigenvalues are those of the same
    /// between points, u_p ← Σ_I N_pI (Σ_q k_q N_qI / m_I) u_q, and none is larger than the largest sum over a row, Σ_I N_pI R_I with R_I = Σ_q k_q N_qI / m_I. Neighbours share
    /// their masses: where one point of many is pushed this is much less than k/m of the point, which it never exceeds for forces at points.
    pub fn contact_frequency_bound(&self) -> f64 {
        self.work.contact_frequency
    }

    /// Takes back what was pushed since the last step.
    pub fn clear_external_forces(&mut self) {
        self.work.external_forces.clear();
    }

    /// One step of `dt` seconds.
    ///
    /// # Errors
    /// A point that is lost (not finite, outside, faster than a cell per step, turned inside out): the step, the lowest such id and what to do.
    /// The state is then of no further use.
    pub fn step(&mut self, dt: f64) -> Result<()> {
        step::step(self, dt)
    }

    /// `safety` times the least h/(c + |v|) over the points, s: c is the law's wave speed at the point's density. The method is stable to about
    /// `safety` = 1; infinite without points.
    pub fn stable_step(&self, safety: f64) -> f64 {
        check::stable_step(self, safety)
    }

    /// # Errors
    /// A step that is not positive or above `stable_step(1.0)`, with that bound.
    pub fn check_step(&self, dt: f64) -> Result<()> {
        check::step(self, dt)
    }

    /// Mass, momentum and energies, summed in the order of ids.
    pub fn totals(&self) -> Totals {
        measure::totals(self)
    }

    /// Drops all scratch but forces that wait; changes no bit of what follows.
    pub fn drop_scratch(&mut self) {
        self.work = self.work.clone();
    }

    /// Uses other instructions than the machine's best; changes no bit.
    pub fn use_instructions(&mut self, arch: pulp::Arch) {
        self.work.arch = Some(arch);
    }

    /// Bytes held, scratch included.
    pub fn bytes(&self) -> usize {
        self.points.bytes() + self.work.bytes()
    }
}
