//! Loading plates on the device: their state to the device and back, and what the device refuses. The shader is `loading_plates.wgsl`.

use super::bounds::PLATES;
use super::device::refused;
use super::exact::{place, placed, split};
use super::layout::LoadingPlate32;
use super::state::ghost_radius;
use crate::error::Error;
use crate::mpm::{LoadingPlate, Points, Settings, face_share};

/// The value of a compensated sum.
pub fn both([high, low]: [f32; 2]) -> f64 {
    f64::from(high) + f64::from(low)
}

/// Distances from the axis of a shell are computed in quanta of 2^-split cells and are below this many.
const WHOLE: f64 = 16_384.0;

/// Distances from the axis of a shell of this radius, cells, are computed in quanta of 2^-split cells; this is the number split.
pub fn shell_split(radius: f64) -> u32 {
    (WHOLE / (radius + 3.0)).log2().floor().clamp(0.0, 12.0) as u32
}

/// Whether a shell of this radius, cells, is not too wide for them.
pub fn is_shell(radius: f64) -> bool {
    radius > 0.0 && radius < WHOLE - 3.0
}

/// State of a loading plate on the device; `drift`: its mean speed under servo control, m/s; `round`: whether the material is a cylinder in a shell.
pub fn to_device(p: &LoadingPlate, drift: f64, round: bool, settings: &Settings) -> LoadingPlate32 {
    let axis = p.axis();
    let at = |axis: usize| place((p.point[axis] - settings.lower[axis]) / settings.cell);
    let own = LoadingPlate32 { face: face_share(round, axis) as f32, ..LoadingPlate32::default() };
    let (own, normal, (cell, units, rest)) = match p.radius {
        None => (own, p.normal[axis], at(axis)),
        Some(radius) => {
            let [x, y] = [at(0), at(1)];
            let split = shell_split(radius / settings.cell);
            let (centre_cell, centre_units, centre_rest) = ([x.0, y.0], [x.1, y.1], [x.2, y.2]);
            (LoadingPlate32 { centre_cell, centre_units, centre_rest, shell: 1, split, ..own }, -1.0, place(radius / settings.cell))
        }
    };
    LoadingPlate32 {
        axis: axis as u32,
        normal: normal as f32,
        cell,
        units,
        rest,
        modulus: p.modulus as f32,
        speed: p.speed as f32,
        moved: p.moved as f32,
        reaction: p.reaction as f32,
        stiffness: p.stiffness as f32,
        stored: p.stored as f32,
        rate: p.rate as f32,
        work: split(p.work),
        drift: drift as f32,
        ..own
    }
}

/// Writes the state on the device into a loading plate.
pub fn take(plate: &mut LoadingPlate, p: &LoadingPlate32, settings: &Settings) {
    let (axis, at) = (plate.axis(), settings.cell * placed(p.cell, p.units, p.rest));
    match &mut plate.radius {
        None => plate.point[axis] = settings.lower[axis] + at,
        Some(radius) => *radius = at,
    }
    (plate.reaction, plate.stiffness, plate.rate) = (p.reaction.into(), p.stiffness.into(), p.rate.into());
    (plate.stored, plate.work) = (p.stored.into(), both(p.work));
    (plate.speed, plate.moved) = (p.speed.into(), p.moved.into());
}

/// Refusals of loading plates that the device cannot have.
pub fn wrong(plates: &[LoadingPlate], settings: &Settings, points: &Points) -> Vec<Error> {
    let mut errors = Vec::new();
    if plates.len() > PLATES {
        errors.push(refused("platens", plates.len(), format!("at most {PLATES} on the GPU")));
    }
    for p in plates {
        let along = p.normal.iter().filter(|n| **n != 0.0).count() == 1 && p.normal[p.axis()].abs() == 1.0;
        let stands = match p.radius {
            None => along,
            Some(radius) => is_shell(radius / settings.cell) && p.point[1].is_finite(),
        };
        if !(stands && p.point[p.axis()].is_finite() && p.modulus > 0.0 && p.modulus.is_finite()) {
            let what = format!("point {:?}, normal {:?}, radius {:?}, modulus {:?}", p.point, p.normal, p.radius, p.modulus);
            errors.push(refused(
                "platen",
                what,
                "needs a unit normal along an axis or the radius of a shell, a finite place and a modulus above 0",
            ));
        }
    }
    let largest = (0..points.len()).map(|i| ghost_radius(points, i)).fold(0.0, f64::max);
    if !plates.is_empty() && largest > 0.9 * settings.cell {
        errors.push(refused(
            "ghost radius",
            largest,
            format!("m is above 0.9 cells of {} m: use larger cells, or the processor", settings.cell),
        ));
    }
    errors
}
