//! The loading plates of a specimen: their places at the start, the stresses on them, and their motion.

use super::{MpmTest, Phase, State, dimensions};
use crate::error::{Error, Result};
use crate::model::continuum::{Drainage, MpmSpecimen, Test};
use ::engine::mpm::loading_plate::{LoadingPlate, ghost_radius, overlap};
use ::engine::mpm::{Continuum, Dimension, PlateDrive, Ramp, area, face_share};

/// Largest lateral strain rate of loading plates under servo over the axial strain rate. A wave time below is the time of a
/// compression wave through the height of the specimen.
pub(super) const LATERAL: f64 = 4.0;
/// Largest inertial number with which loading plates close on rigid bodies that settle, by the stress that they will bear.
const CLOSING: f64 = 0.01;
/// Wave times over which the mean speed of a lateral loading plate is taken.
pub(super) const DRIFT: f64 = 4.0;
/// Wave times in which the axial loading plates take up their speed.
const RAMP: f64 = 5.0;
/// Largest difference of the stress on a side from the cell pressure, over the cell pressure, at rest.
const AT_REST: f64 = 0.005;
/// Mean resultant on a rigid body over the mean force of a contact at rest.
const UNBALANCED: f64 = 0.01;
/// Wave times after which rest is first looked for.
const REST: f64 = 5.0;
/// Wave times after which a specimen that does not come to rest is given up.
const PATIENCE: f64 = 500.0;

/// Distance of a loading plate that just touches the points from the face of the material, m, outwards positive: the points stand
/// half their spacing inside the face and reach outwards by the radius of their contact spheres.
fn offset(rig: &MpmTest, s: &MpmSpecimen) -> f64 {
    radius(rig, s) - 0.5 * s.spacing
}

/// Radius of the points' contact spheres at the start, m: the sphere of the solid volume of a point (Li et al. 2023, eq. 22).
fn radius(rig: &MpmTest, s: &MpmSpecimen) -> f64 {
    let volume = s.roominess() * s.spacing.powi(dimensions(rig) as i32);
    ghost_radius(rig.settings.dimension, (1.0 - s.porosity) * volume)
}

/// Strain rate, 1/s, with which loading plates close on rigid bodies that settle; `None` for points.
fn closing(s: &MpmSpecimen) -> Option<f64> {
    Some(CLOSING / s.inertial_number(1.0, s.bed?.stress)?)
}

/// Mean overlap δ of a loading plate's contacts, m, from their force F and their elastic energy 2/5 F δ (Hertz).
fn mean_overlap(p: &LoadingPlate) -> f64 {
    if p.reaction > 0.0 { p.stored / (0.4 * p.reaction) } else { 0.0 }
}

/// Whether the extents of the material are without the overlaps of the loading plates: points that do not stand on a lattice are in touch at the faces themselves.
#[cfg(feature = "gpu")]
pub(super) fn has_overlaps(rig: &MpmTest) -> bool {
    rig.specimen().is_some_and(|s| s.lattice)
}

/// Adds to the extents of the material what they grow by where a loading plate stands `by`, m, further out: of a shell both widths grow by twice as much.
#[cfg(feature = "gpu")]
pub(super) fn widen(extents: &mut [f64; 3], plate: &LoadingPlate, by: f64) {
    match plate.radius {
        None => extents[plate.axis()] += by,
        Some(_) => extents[..2].iter_mut().for_each(|width| *width += 2.0 * by),
    }
}

/// The loading plates of a test at the start, pressed in so far that their contacts balance the stress of the points.
pub fn plates(rig: &MpmTest, continuum: &Continuum) -> Vec<LoadingPlate> {
    let Some(s) = rig.specimen() else { return Vec::new() };
    let d = dimensions(rig);
    let depth = match s.stress * s.roominess() * s.spacing.powi(d as i32 - 1) {
        force if force > 0.0 => overlap(rig.settings.dimension, s.modulus, radius(rig, s), force),
        _ => 0.0,
    };
    let out = if s.lattice { offset(rig, s) - depth } else { 0.0 };
    let plate = |axis: usize, high: bool| {
        let mut point: [f64; 3] = std::array::from_fn(|a| s.lower[a] + 0.5 * s.size[a]);
        let mut normal = [0.0; 3];
        normal[axis] = if high { -1.0 } else { 1.0 };
        point[axis] = if high { s.lower[axis] + s.size[axis] + out } else { s.lower[axis] - out };
        LoadingPlate::new(continuum, point, normal, s.modulus)
    };
    let shell = || LoadingPlate::shell(continuum, s.base(), 0.5 * s.size[0] + out, s.modulus);
    match rig.test {
        Test::Oedometer(_) if s.round => vec![shell(), plate(d - 1, true)],
        Test::Oedometer(_) => vec![plate(d - 1, true)],
        _ if s.round => vec![shell(), plate(d - 1, false), plate(d - 1, true)],
        _ => (0..d).flat_map(|axis| [plate(axis, false), plate(axis, true)]).collect(),
    }
}

/// Index of the loading plate at side `k` (x low, x high, y low, …); `None` where the side is a wall of the grid.
pub(super) fn at_side(rig: &MpmTest, k: usize) -> Option<usize> {
    let d = dimensions(rig);
    match &rig.test {
        Test::Free { .. } => None,
        Test::Oedometer(s) if s.round && k < 4 => Some(0),
        Test::Oedometer(s) => (k == 2 * d - 1).then_some(usize::from(s.round)),
        Test::Triaxial { specimen, .. } if specimen.round => Some(k.max(3) - 3),
        Test::Triaxial { .. } => Some(k),
    }
}

/// Area of the specimen's face normal to `axis`, m² (m in plane strain). For the lateral axes of a cylinder this is the whole
/// area of the shell, for its force is the sum of all radial forces.
pub(super) fn face(rig: &MpmTest, extents: [f64; 3], axis: usize) -> f64 {
    face_share(rig.specimen().is_some_and(|s| s.round), axis) * area(extents, axis)
}

impl State {
    /// Extents of the material, m (in plane strain 1 along z): the distances of its opposite faces, from the places of the
    /// loading plates and the overlaps of their contacts.
    pub(super) fn extents_now(&self, rig: &MpmTest) -> [f64; 3] {
        let Some(s) = rig.specimen() else { return [0.0; 3] };
        let (d, radius) = (dimensions(rig), radius(rig, s));
        // the face is inside the loading plate: contact spheres reach beyond the face, less the mean overlap
        let inside = |p: &LoadingPlate| if s.lattice { radius - 0.5 * s.spacing - mean_overlap(p) } else { 0.0 };
        let mut extents = s.size;
        if d == 2 {
            extents[2] = 1.0;
        }
        for (axis, extent) in extents.iter_mut().enumerate().take(d) {
            let facing = |sign: f64| self.plates.iter().find(|p| p.normal[axis] == sign);
            *extent = match (facing(1.0), facing(-1.0), &self.plates[0]) {
                (Some(low), Some(high), _) => (high.point[axis] - inside(high)) - (low.point[axis] + inside(low)),
                (None, Some(high), _) => high.point[axis] - inside(high) - s.lower[axis],
                (_, _, shell @ LoadingPlate { radius: Some(radius), .. }) if axis < 2 => 2.0 * (radius - inside(shell)),
                _ => continue,
            };
        }
        extents
    }

    /// Extents without the present overlaps, m: a graphics device adds the overlaps of each step itself.
    #[cfg(feature = "gpu")]
    pub(super) fn material(&self, rig: &MpmTest) -> [f64; 3] {
        let mut extents = self.extents_now(rig);
        for plate in self.plates.iter().filter(|_| has_overlaps(rig)) {
            widen(&mut extents, plate, -mean_overlap(plate));
        }
        extents
    }

    /// Stress on each side, Pa, compression positive, in the order x low, x high, y low, …; 0 in a free scene.
    pub(super) fn sides(&self, rig: &MpmTest) -> [f64; 6] {
        self.stresses(rig, self.extents_now(rig), |k| self.plates[k].force(), |k| self.on_side(rig, k))
    }

    /// Force of points and grains on a fixed side `k` of the specimen, N, compression positive.
    pub(super) fn on_side(&self, rig: &MpmTest, k: usize) -> f64 {
        // with a cylinder only the bottom is a side of the grid, and it is the first wall of the grains
        let own = if rig.specimen().is_some_and(|s| s.round) { 0 } else { k };
        self.on_grid_side(k) + self.mixture.as_ref().map_or(0.0, |m| m.grains.walls[own].reaction)
    }

    /// Force of the points on side `k` of the grid in the last step, N, compression positive.
    pub(super) fn on_grid_side(&self, k: usize) -> f64 {
        self.continuum.wall_force()[k][k / 2] * if k % 2 == 1 { -1.0 } else { 1.0 }
    }

    /// Mean stress on both axial sides at the present instant, Pa.
    pub(super) fn axial_stress(&self, rig: &MpmTest) -> f64 {
        let (sides, axis) = (self.sides(rig), dimensions(rig) - 1);
        0.5 * (sides[2 * axis] + sides[2 * axis + 1])
    }

    /// Stress on each side as [`State::sides`], from the force on each loading plate and on each side of the grid, N, along the
    /// inward normals.
    pub(super) fn stresses(
        &self,
        rig: &MpmTest,
        extents: [f64; 3],
        plate: impl Fn(usize) -> f64,
        wall: impl Fn(usize) -> f64,
    ) -> [f64; 6] {
        let d = dimensions(rig);
        let mut sides = [0.0; 6];
        for (k, side) in sides.iter_mut().enumerate().take(2 * d) {
            let force = match at_side(rig, k) {
                Some(p) => plate(p),
                None if rig.specimen().is_some() => wall(k),
                None => return sides,
            };
            *side = force / face(rig, extents, k / 2);
        }
        sides
    }

    /// Axial strain since the start of loading, compression positive.
    pub fn axial_strain(&self, rig: &MpmTest) -> f64 {
        let axis = dimensions(rig) - 1;
        if rig.specimen().is_none() { 0.0 } else { 1.0 - self.extents_now(rig)[axis] / self.extents[axis] }
    }

    /// Strain rate, 1/s, that the axial loading plates give the present height.
    pub fn strain_rate(&self, rig: &MpmTest) -> f64 {
        let axis = dimensions(rig) - 1;
        let whole = self.rate * self.extents[axis] / self.extents_now(rig)[axis];
        if self.phase == Phase::Settle { 0.0 } else { whole * (self.phase_time / (RAMP * self.wave)).min(1.0) }
    }

    /// Motion of an axial loading plate that takes the share `part` of the whole axial speed, which is strain rate times height.
    fn axial(&self, rig: &MpmTest, part: f64) -> PlateDrive {
        let (end, rise) = (self.rate * self.extents[dimensions(rig) - 1], RAMP * self.wave);
        let value = part * (end * (self.phase_time / rise).min(1.0));
        PlateDrive::Speed(Ramp { value, slope: part * (end / rise), end: part * end })
    }

    /// Sets the motion for an oedometer: the top loading plate comes down, in [`Phase::Settle`] under servo. A shell moves inwards by the growth of its contacts'
    /// overlap, so that the material keeps its width.
    ///
    /// # Errors
    /// Rigid bodies that do not come to rest.
    pub(super) fn compress(&mut self, rig: &MpmTest, s: &MpmSpecimen) -> Result<()> {
        let axial = match s.bed.filter(|_| self.phase == Phase::Settle) {
            Some(bed) => {
                let target = self.settle(rig, s, bed.stress)?;
                // at rest it begins to come down at once
                if self.phase == Phase::Settle { self.servo(s, target) } else { self.axial(rig, 1.0) }
            }
            None => self.axial(rig, 1.0),
        };
        if self.phase == Phase::Load && self.axial_strain(rig) >= s.axial_strain {
            self.phase = Phase::Done;
        }
        let wider = self.extents_now(rig)[0] - self.extents[0];
        let keeps = PlateDrive::Speed(Ramp::constant(0.5 * wider / (DRIFT * self.wave)));
        for (drive, plate) in self.drives.iter_mut().zip(&self.plates) {
            *drive = if plate.radius.is_some() { keeps } else { axial };
        }
        Ok(())
    }

    /// Motion of a loading plate that holds `target`, Pa. Rigid bodies that are packed without contact have a long way to go while they settle; their inertial number sets its speed.
    fn servo(&self, s: &MpmSpecimen, target: Ramp) -> PlateDrive {
        let settling = self.phase == Phase::Settle;
        let fastest = closing(s).filter(|_| settling).unwrap_or(LATERAL * self.rate);
        PlateDrive::Stress { target, gain: s.gain, reach: 0.5 * fastest, memory: DRIFT * self.wave }
    }

    /// The stress to be held while the specimen settles: it rises to `stress`, Pa. Where the loading plates bear it and nothing moves any more, loading begins; where the friction of
    /// the preparation holds, that of the materials takes its place first.
    ///
    /// # Errors
    /// A specimen that does not come to rest.
    fn settle(&mut self, rig: &MpmTest, s: &MpmSpecimen, stress: f64) -> Result<Ramp> {
        let d = dimensions(rig);
        let rise = (stress - s.stress).abs() / (rig.oedometric(s) * self.rate);
        let target = match self.phase {
            Phase::Settle if self.phase_time < rise => {
                let slope = (stress - s.stress) / rise;
                Ramp { value: s.stress + slope * self.phase_time, slope, end: stress }
            }
            _ => Ramp::constant(stress),
        };
        if self.phase != Phase::Settle || self.phase_time <= rise + REST * self.wave {
            return Ok(target);
        }
        let all = self.sides(rig);
        let sides = if matches!(rig.test, Test::Oedometer(_)) { &all[2 * d - 2..2 * d] } else { &all[..2 * d] };
        let unbalanced = self.blocks().filter(|_| s.bed.is_some()).map_or(0.0, |blocks| blocks.unbalanced_ratio());
        if sides.iter().all(|side| (side / stress - 1.0).abs() < AT_REST) && unbalanced < UNBALANCED {
            let prepared = self.mixture.as_mut().and_then(|m| m.grains.friction.take()).is_some();
            if prepared {
                self.phase_time = rise;
            } else {
                (self.phase, self.phase_time, self.extents) = (Phase::Load, 0.0, self.extents_now(rig));
            }
        } else if self.phase_time > rise + PATIENCE * self.wave + closing(s).map_or(0.0, |rate| 1.0 / rate) {
            let stresses: Vec<String> = sides.iter().map(|s| format!("{:.2}", 1e-3 * s)).collect();
            let of_bodies = if s.bed.is_some() {
                format!(", and the mean resultant on a body is {unbalanced:.4} of a contact's force, where {UNBALANCED} is rest")
            } else {
                String::new()
            };
            let what = format!(
                "the specimen did not come to rest at {} of {:.2} kPa: its sides bear {} kPa{of_bodies}; raise damping.local",
                if matches!(rig.test, Test::Oedometer(_)) { "the seating stress" } else { "the cell pressure" },
                1e-3 * stress,
                stresses.join(", ")
            );
            return Err(Error::Stalled { step: self.continuum.steps(), what });
        }
        Ok(target)
    }

    /// Sets the motion for a triaxial test. In [`Phase::Settle`] all loading plates hold the cell pressure, which rises to its
    /// value; then the axial ones come together, and the lateral ones hold the cell pressure or the volume.
    ///
    /// # Errors
    /// A specimen that does not come to rest at the cell pressure.
    pub(super) fn shear(&mut self, rig: &MpmTest, s: &MpmSpecimen, cell: f64, drainage: Drainage) -> Result<()> {
        let (d, extents) = (dimensions(rig), self.extents_now(rig));
        let target = self.settle(rig, s, cell)?;
        if self.phase == Phase::Load && self.axial_strain(rig) >= s.axial_strain {
            self.phase = Phase::Done;
        }
        let servo = self.servo(s, target);
        let axial = if self.phase == Phase::Settle { servo } else { self.axial(rig, 0.5) };
        let keeps = self.phase != Phase::Settle && drainage == Drainage::ConstantVolume;
        for k in 0..self.drives.len() {
            self.drives[k] = match self.plates[k].axis() {
                a if a == d - 1 => axial,
                a if keeps => self.apart(rig, extents, a),
                _ => servo,
            };
        }
        Ok(())
    }

    /// Motion of a lateral loading plate that keeps the volume constant: the width is w = w₀ (L₀/L)^(1/(d−1)) with the height L
    /// and d dimensions. The difference of the present width from this, which comes from the overlaps of contacts, is corrected
    /// within [`DRIFT`] wave times. Each loading plate takes half of the speed; positive inwards, m/s.
    fn apart(&self, rig: &MpmTest, extents: [f64; 3], axis: usize) -> PlateDrive {
        let d = dimensions(rig);
        let [width, length] = [axis, d - 1].map(|a| extents[a]);
        let [width_0, length_0] = [axis, d - 1].map(|a| self.extents[a]);
        let wider = length_0 / length;
        let target = width_0 * if d == 3 { wider.sqrt() } else { wider };
        let closing = self.rate * length_0 * (self.phase_time / (RAMP * self.wave)).min(1.0);
        let opening = width / (length * (d - 1) as f64) * closing;
        PlateDrive::Speed(Ramp::constant(0.5 * ((width - target) / (DRIFT * self.wave) - opening)))
    }
}

/// Stiffness of a contact between a loading plate and a point under `stress`, Pa, over the inertia `mass` of the point, kg: the
/// square of an angular frequency, 1/s².
pub fn contact_rate(dimension: Dimension, s: &MpmSpecimen, mass: f64, stress: f64) -> f64 {
    let d = if dimension == Dimension::Space { 3 } else { 2 };
    let radius = ghost_radius(dimension, (1.0 - s.porosity) * s.roominess() * s.spacing.powi(d));
    let force = stress * s.roominess() * s.spacing.powi(d - 1);
    let depth = overlap(dimension, s.modulus, radius, force);
    if depth > 0.0 { 1.5 * force / depth / mass } else { 0.0 }
}
