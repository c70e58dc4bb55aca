//! Loading plates on the device: their state to the device and back, and what the device refuses. The shader is `loading_plates.wgsl`.

use super::bounds::PLATES;
use super::device::refused;
use super::exact::{place, placed, split};
use super::layout::LoadingPlate32;
use super::state::ghost_radius;
use crate::error::Error;
use crate::mpm::{LoadingPlate, Points, Settings};

/// The value of a compensated sum.
pub fn both([high, low]: [f32; 2]) -> f64 {
    f64::from(high) + f64::from(low)
}

/// State of a loading plate on the device; `drift`: its mean speed under servo control, m/s.
pub fn to_device(p: &LoadingPlate, drift: f64, settings: &Settings) -> LoadingPlate32 {
    let axis = p.axis();
    let (cell, units, rest) = place((p.point[axis] - settings.lower[axis]) / settings.cell);
    LoadingPlate32 {
        axis: axis as u32,
        normal: p.normal[axis] as f32,
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
        ..LoadingPlate32::default()
    }
}

/// Writes the state on the device into a loading plate.
pub fn take(plate: &mut LoadingPlate, p: &LoadingPlate32, settings: &Settings) {
    let axis = plate.axis();
    plate.point[axis] = settings.lower[axis] + settings.cell * placed(p.cell, p.units, p.rest);
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
        if !(along && p.point[p.axis()].is_finite() && p.modulus > 0.0 && p.modulus.is_finite()) {
            let what = format!("point {:?}, normal {:?}, modulus {:?}", p.point, p.normal, p.modulus);
            errors.push(refused("platen", what, "needs a unit normal along an axis, a finite place and a modulus above 0"));
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
