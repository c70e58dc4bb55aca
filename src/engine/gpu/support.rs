//! What the GPU path takes, and where it fits; nothing is started for it.

use super::device::{Adapter, holding, refused};
use super::grains::{self, CoarseGrains};
use super::loading_plate;
use super::memory::BufferSizes;
use crate::error::{Error, Result};
use crate::mpm::law::Law;
use crate::mpm::{Dimension, LoadingPlate, Points, Settings, ShapeFunctions, Transfer};

/// What a continuum needs on a device, in bytes, with grains a guess.
///
/// # Errors
/// What the GPU path lacks, by name.
pub fn needs(settings: &Settings, points: &Points, plates: &[LoadingPlate], coarse: Option<&CoarseGrains<'_>>) -> Result<u64> {
    sizes(settings, points, plates, coarse).map(|(sizes, grains)| sizes.sum() + grains.map_or(0, |g| g.sum()))
}

/// The adapter on which a continuum fits.
///
/// # Errors
/// What the GPU path lacks, by name; no adapter; one without room.
pub fn fits(settings: &Settings, points: &Points, plates: &[LoadingPlate], coarse: Option<&CoarseGrains<'_>>) -> Result<Adapter> {
    let (sizes, grains) = sizes(settings, points, plates, coarse)?;
    holding(&sizes, grains.as_ref())
}

/// Bytes of each buffer, those of grains apart.
///
/// # Errors
/// What the GPU path lacks, by name.
pub fn sizes(
    settings: &Settings,
    points: &Points,
    plates: &[LoadingPlate],
    coarse: Option<&CoarseGrains<'_>>,
) -> Result<(BufferSizes, Option<grains::GrainBufferSizes>)> {
    let mut errors = lacking(settings, points);
    errors.extend(loading_plate::wrong(plates, settings, points));
    Error::all(errors)?;
    let grains = coarse.map(|coarse| grains::sizes(settings, points, coarse)).transpose()?;
    Ok((BufferSizes::of(settings, points.len() as u64, !plates.is_empty()), grains))
}

/// Refuses laws that shaders do not have.
///
/// # Errors
/// The first such law.
pub fn takes(laws: &[Law]) -> Result<()> {
    let refusal = |law: &Law| {
        let instead = law.on_gpu().err()?;
        Some(refused("material.continuum.law", law.word(), format!("is not available on the GPU: {instead}, or the processor")))
    };
    Error::all(laws.iter().find_map(refusal).into_iter().collect())
}

/// What the GPU path does not have.
fn lacking(settings: &Settings, points: &Points) -> Vec<Error> {
    let mut errors = Vec::new();
    if settings.dimension == Dimension::PlaneStrain {
        errors.push(refused("grid.plane_strain", true, "is not available on the GPU: use the processor"));
    }
    if let ShapeFunctions::Gimp { .. } = settings.shape {
        errors.push(refused("grid.shape_functions", "gimp", "is not available on the GPU: use b_spline, or the processor"));
    }
    if settings.transfer == Transfer::Affine {
        errors.push(refused("grid.transfer", "apic", "is not available on the GPU: use flip_pic, or the processor"));
    }
    if points.is_empty() {
        errors.push(refused("points", 0, "must be at least one"));
    }
    if let Some(id) = points.id.iter().find(|id| **id >= 1 << 29) {
        errors.push(refused("id", id, "must be below 2^29 on the GPU"));
    }
    errors
}
