//! The continuum: a material point method with quadratic B-splines or generalised interpolation, in space or in plane strain.
//!
//! A test owns a [`Continuum`] and calls [`Continuum::step`]. All that a restart needs is serialised with it; the grid and the order of the points in
//! memory are made anew. Stresses are positive in tension here, and in compression in records.
//!
//! Papers: Li et al. 2023 (Comput. Geotech. 160), Jiang et al. 2020 (IJNME), Zhang et al. (SPH of binary mixtures).

pub mod account;
mod blocks;
mod body_points;
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

pub use account::EnergyAccount;
pub use body_points::BodyPoint;
pub use check::with_plates;
pub use loading_plate::LoadingPlate;
pub use measure::Totals;
pub use plate_drive::{PlateDrive, Ramp, area, face_share};
pub use points::{Face, Point, Points};
pub use spline::{BSpline, Gimp, ShapeFunction, ShapeFunctions};
pub use stress::rotate_jaumann;
pub use walls::GridWall;

use crate::check::Checked;
use crate::error::Result;
use law::Law;
use serde::{Deserialize, Serialize};

/// Number of dimensions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Dimension {
    /// Two: plane strain in x and y. Masses, volumes and forces are per metre of thickness.
    PlaneStrain,
    /// Three.
    Space,
}

/// How velocities go from the nodes to the points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Transfer {
    /// Blend of PIC and FLIP (Li et al. 2023, eq. 30).
    Blend {
        /// Share α of PIC: 1 is PIC, 0 is FLIP.
        pic: f64,
    },
    /// Affine particle-in-cell (APIC): values with their gradients; with B-splines only.
    Affine,
}

/// The grid, the walls at its sides, and the choices of the method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Number of dimensions.
    pub dimension: Dimension,
    /// Edge of a cell, m.
    pub cell: f64,
    /// Lower corner of the domain, m (in plane strain the third entry is not used).
    pub lower: [f64; 3],
    /// Number of cells along x, y, z (in plane strain the third entry is not used).
    pub cells: [u32; 3],
    /// Walls at the sides of the domain: x low, x high, y low, y high, z low, z high.
    pub walls: [GridWall; 6],
    /// Gravity, m/s².
    pub gravity: [f64; 3],
    /// Shape functions.
    pub shape: ShapeFunctions,
    /// How velocities go from the nodes to the points.
    pub transfer: Transfer,
    /// Coefficient α of local damping at the nodes, −α |f| sign(v), from 0 (none) to below 1.
    pub damping: f64,
}

impl Settings {
    /// Number of cells along x, y, z as signed numbers.
    fn size(&self) -> [i32; 3] {
        self.cells.map(|n| n as i32)
    }
}

/// Material points and their grid.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Continuum {
    settings: Settings,
    /// Constitutive laws; each point names one by its index.
    laws: Vec<Law>,
    points: Points,
    /// Whether [`Points::transport_velocity`] is kept.
    keeps_transport_velocity: bool,
    /// Number of steps done.
    step: u64,
    /// Work of the stresses on the strains since the start, J.
    stress_work: f64,
    /// Force of each wall on the material in the last step, N.
    wall_force: [[f64; 3]; 6],
    /// The energy account, if one is kept.
    account: Option<Box<EnergyAccount>>,
    /// Grid, buffers, and external forces for the next step.
    #[serde(skip)]
    work: step::GridWorkspace,
}

impl Continuum {
    /// A continuum at its start.
    ///
    /// # Errors
    /// Settings, laws or points that are not allowed, each by name; a point outside of the domain.
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
            account: None,
            work,
        })
    }

    /// Checks a continuum that comes from outside. `made` is that of the same run as it was made; `added`: largest number of points that were added since.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, made: &Continuum, added: u64) -> Checked {
        check::of_state(self, made, added)
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The constitutive laws.
    pub fn laws(&self) -> &[Law] {
        &self.laws
    }

    /// The points.
    pub fn points(&self) -> &Points {
        &self.points
    }

    /// The points, to be changed. The next step makes the grid anew from them.
    pub fn points_mut(&mut self) -> &mut Points {
        self.work.forget();
        self.reopen();
        &mut self.points
    }

    /// Adds points between two steps; returns the identity of the first of them.
    pub fn insert(&mut self, new: &[Point]) -> u32 {
        let Continuum { points, work, settings, keeps_transport_velocity, account, .. } = self;
        work.forget();
        if let Some(account) = account {
            account.kinetic = None;
        }
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

    /// Number of steps done.
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// Work of the stresses on the strains since the start, J, by the trapezium rule over every step: elastic energy and dissipation together.
    pub fn stress_work(&self) -> f64 {
        self.stress_work
    }

    /// Force of each wall on the material in the last step, N, in the order of [`Settings::walls`].
    pub fn wall_force(&self) -> &[[f64; 3]; 6] {
        &self.wall_force
    }

    /// Takes over the number of steps, the stress work, J, and the wall forces, N, of steps that a device has made.
    #[cfg(feature = "gpu")]
    pub fn set_counters(&mut self, step: u64, stress_work: f64, wall_force: [[f64; 3]; 6]) {
        (self.step, self.stress_work, self.wall_force) = (step, stress_work, wall_force);
    }

    /// Keeps [`Points::transport_velocity`] from now on; before the first step that is the velocity of the point.
    pub fn keep_transport_velocity(&mut self) {
        self.keeps_transport_velocity = true;
        let Points { transport_velocity, velocity, .. } = &mut self.points;
        if transport_velocity.is_empty() {
            transport_velocity.extend(velocity.iter().map(|v| [v[0], v[1], v[2]]));
        }
    }

    /// Opens the energy account with sums of zero; from now on steps add to it.
    pub fn keep_account(&mut self) {
        self.account = Some(Box::default());
    }

    /// The energy account, if one is kept.
    pub fn account(&self) -> Option<&EnergyAccount> {
        self.account.as_deref()
    }

    /// Tells the energy account that points were changed from outside: their kinetic energy is summed anew.
    fn reopen(&mut self) {
        if let Some(account) = &mut self.account {
            account.kinetic = None;
        }
    }

    /// Elastic energy of the stresses of all points, J, summed in the order of identities.
    pub fn elastic_energy(&self) -> f64 {
        measure::elastic_energy(&self.laws, &self.points)
    }

    /// Calls `visit` with the index of every point in the box between two corners (lower, upper), m, and of some points around it.
    pub fn visit(&self, corners: [[f64; 3]; 2], visit: impl FnMut(usize)) {
        match self.settings.dimension {
            Dimension::PlaneStrain => self.work.visit::<2>(&self.settings, &self.points, corners, visit),
            Dimension::Space => self.work.visit::<3>(&self.settings, &self.points, corners, visit),
        }
    }

    /// Adds an external force, N, on point `i` (an index of [`Self::points`]) for the next step. `stiffness`: tangent stiffness of the contact that makes
    /// the force, N/m. Indices change in a step, so forces are added between the same two steps.
    pub fn add_external_force(&mut self, i: usize, [x, y, z]: [f64; 3], stiffness: f64) {
        let external = self.work.external_forces.of_mut(i, self.points.len());
        for (sum, f) in external.force.iter_mut().zip([x, y, z, stiffness]) {
            *sum += f;
        }
    }

    /// As [`Self::add_external_force`], for a force that acts `offset` metres beside the centre of the point, within the nodes that the point reaches. It
    /// goes to the nodes by linear weights ([`Self::velocity_beside`] takes the same), so force and moment arrive whole.
    pub fn add_force_beside(&mut self, i: usize, [x, y, z]: [f64; 3], stiffness: f64, offset: [f64; 3]) {
        self.work.external_forces.add_beside(i, self.points.len(), [x, y, z, stiffness], offset);
    }

    /// From the centre of point `i` to the nearest node, m.
    pub fn nearest_node(&self, i: usize) -> [f64; 3] {
        let Settings { cell, lower, dimension, .. } = &self.settings;
        let axes = if *dimension == Dimension::Space { 3 } else { 2 };
        std::array::from_fn(|a| {
            let at = self.points.position[i][a] - lower[a];
            if a < axes { (at / cell).round() * cell - at } else { 0.0 }
        })
    }

    /// Velocity of the nodes, m/s, `offset` metres beside the centre of point `i`, by linear weights. To be called between a step and the next change of
    /// the points from outside.
    pub fn velocity_beside(&self, i: usize, offset: [f64; 3]) -> [f64; 3] {
        match self.settings.dimension {
            Dimension::PlaneStrain => step::velocity_beside::<2>(self, i, offset),
            Dimension::Space => step::velocity_beside::<3>(self, i, offset),
        }
    }

    /// As [`Self::add_external_force`], for a force of magnitude `force` along `normal` (into the material) that acts on a face of the point instead of its
    /// centre: each component acts on the face across its own axis. The face is followed with the material from then on ([`Points::faces`]), until
    /// [`Self::release_face`] is called.
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

    /// Stops following the faces of point `i` on which forces along `normal` acted.
    pub fn release_face(&mut self, i: usize, normal: [f64; 3]) {
        let [beside, _] = &mut self.points.faces[i];
        for (beside, normal) in beside.iter_mut().zip(normal) {
            if *beside * normal < 0.0 {
                *beside = 0.0;
            }
        }
    }

    /// Upper bound on what the stiffnesses of external forces of the last step add to the square of a frequency of the points' motion, 1/s². It is
    /// computed only if [`Points::transport_velocity`] is kept.
    ///
    /// Contacts of stiffness k_q at the points q accelerate node I by Σ_q k_q N_qI u_q / m_I when the points move by u_q. The nodes move point p by Σ_I N_pI times
    /// that. No eigenvalue of this map from displacements of points to accelerations of points exceeds its largest row sum, Σ_I N_pI R_I with
    /// R_I = Σ_q k_q N_qI / m_I, which is the bound. As neighbours share the masses of nodes, the bound is far below k/m of a point if few points are
    /// pushed; for forces at points it never exceeds the largest k/m.
    pub fn contact_frequency_bound(&self) -> f64 {
        self.work.contact_frequency
    }

    /// Removes all external forces added since the last step.
    pub fn clear_external_forces(&mut self) {
        self.work.external_forces.clear();
    }

    /// Makes one step of `dt` seconds.
    ///
    /// # Errors
    /// A point that is lost: it has no finite position or velocity, has left the domain, has moved by more than a cell, or its volume is not positive. The
    /// error names the lowest identity of such points and what to do; the state is then useless.
    pub fn step(&mut self, dt: f64) -> Result<()> {
        self.step_beside(dt, &mut [])
    }

    /// As [`Self::step`], with contacts of the material with these points of rigid bodies at the nodes that both reach; sets the impulses on these.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn step_beside(&mut self, dt: f64, bodies: &mut [BodyPoint]) -> Result<()> {
        step::step(self, dt, bodies)
    }

    /// Stable time step, s: `safety` times the smallest h/(c + |v|) of all points, with the edge of a cell h, the velocity v of the point and the speed c of
    /// compression waves in its law at its density. The method is stable up to `safety` of about 1. Infinite without points.
    pub fn stable_step(&self, safety: f64) -> f64 {
        check::stable_step(self, safety)
    }

    /// Checks a time step, s, that is given.
    ///
    /// # Errors
    /// A step that is not positive, or larger than `stable_step(1.0)`.
    pub fn check_step(&self, dt: f64) -> Result<()> {
        check::step(self, dt)
    }

    /// Mass, volume, momenta and energies of all points, summed in the order of identities.
    pub fn totals(&self) -> Totals {
        measure::totals(self)
    }

    /// Drops grid and buffers but keeps external forces; changes no bit of what follows. For tests.
    pub fn drop_scratch(&mut self) {
        self.work = self.work.clone();
    }

    /// Uses the given instruction set instead of the machine's best; changes no bit of the results.
    pub fn use_instructions(&mut self, arch: pulp::Arch) {
        self.work.arch = Some(arch);
    }

    /// Memory in use, bytes, with grid and buffers.
    pub fn bytes(&self) -> usize {
        self.points.bytes() + self.work.bytes()
    }
}
