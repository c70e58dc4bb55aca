//! What the GPU path takes, and where it fits; nothing is started for it.

use super::device::{Adapter, holding, refused};
use super::memory::Sizes;
use super::platen;
use crate::error::{Error, Result};
use crate::mpm::{Dimension, Platen, Points, Settings, ShapeFunctions, Transfer};

/// What a continuum needs on a device, in bytes.
///
/// # Errors
/// What the GPU path lacks, by name.
pub fn needs(settings: &Settings, points: &Points, platens: &[Platen]) -> Result<u64> {
    sizes(settings, points, platens).map(|sizes| sizes.sum())
}

/// The adapter on which a continuum fits.
///
/// # Errors
/// What the GPU path lacks, by name; no adapter; one without room.
pub fn fits(settings: &Settings, points: &Points, platens: &[Platen]) -> Result<Adapter> {
    holding(&sizes(settings, points, platens)?)
}

/// Bytes of each buffer.
///
/// # Errors
/// What the GPU path lacks, by name.
pub fn sizes(settings: &Settings, points: &Points, platens: &[Platen]) -> Result<Sizes> {
    let mut errors = lacking(settings, points);
    errors.extend(platen::wrong(platens, settings, points));
    Error::all(errors)?;
    Ok(Sizes::of(settings, points.len() as u64, !platens.is_empty()))
}

/// What the GPU path does not have.
fn lacking(settings: &Settings, points: &Points) -> Vec<Error> {
    let mut errors = Vec::new();
    if settings.dimension == Dimension::PlaneStrain {
        errors.push(refused("dimension", "plane_strain", "is not available on the GPU: use space, or the CPU"));
    }
    if let ShapeFunctions::Gimp { .. } = settings.shape {
        errors.push(refused("shape", "gimp", "is not available on the GPU: use b_spline, or the CPU"));
    }
    if settings.transfer == Transfer::Affine {
        errors.push(refused("transfer", "affine", "is not available on the GPU: use a FLIP/PIC blend, or the CPU"));
    }
    if points.is_empty() {
        errors.push(refused("points", 0, "must be at least one"));
    }
    if let Some(id) = points.id.iter().find(|id| **id >= 1 << 29) {
        errors.push(refused("id", id, "must be below 2^29 on the GPU"));
    }
    errors
}
