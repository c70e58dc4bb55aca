//! Which continua the graphics device can compute, and whether one fits into its memory; answered without opening the device.

use super::blocks::{Blocks, too_wide};
use super::device::{Adapter, adapter, refused};
use super::grains::{self, CoarseGrains};
use super::layout::wall_kinds;
use super::loading_plate;
use super::memory::BufferSizes;
use super::plan::{Extent, GrainExtent};
use super::rounds;
use super::state::cell_of;
use super::work::StepWork;
use crate::error::{Error, Result};
use crate::mpm::law::Law;
use crate::mpm::{Dimension, LoadingPlate, Points, Settings, ShapeFunctions, Transfer};

/// What a continuum needs on the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs {
    /// Memory, bytes.
    pub bytes: u64,
    /// What one step takes, with one step of the grains.
    pub step: StepWork,
}

/// What a continuum needs on the device if it has `counts` points and grains, of which those given are some; with grains an estimate.
///
/// # Errors
/// The device lacks something that the continuum has.
pub fn needs(
    settings: &Settings,
    points: &Points,
    plates: &[LoadingPlate],
    coarse: Option<&CoarseGrains<'_>>,
    counts: [usize; 2],
) -> Result<Needs> {
    let (_, grains) = sizes(settings, points, plates, coarse)?;
    let [points_there, grains_there] = counts.map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    let blocks = blocks(settings, points).for_more(f64::from(points_there) / points.len() as f64);
    let of_points = BufferSizes::of(settings, &blocks, points_there.into(), !plates.is_empty());
    let of_grains = grains.map(|sizes| GrainExtent { grains: grains_there, rows: sizes.room as u32, rates: 1 });
    let extent = Extent {
        points: points_there,
        several_laws: points.law.iter().any(|law| *law != 0),
        blocks: [blocks.used, blocks.slots],
        size: settings.cells,
        walls: wall_kinds(settings),
        plates: plates.len() as u32,
        grains: of_grains,
    };
    let near = coarse.map_or(0, |coarse| grains::near_points(settings, points, coarse));
    Ok(Needs { bytes: of_points.sum() + grains.map_or(0, |g| g.sum()), step: StepWork::of(&extent, near as u32) })
}

/// The adapter, where the continuum fits into its memory.
///
/// # Errors
/// The device lacks something that the continuum has; there is no adapter; its memory is too small; a loop would be too long for a software adapter.
pub fn fits(settings: &Settings, points: &Points, plates: &[LoadingPlate], coarse: Option<&CoarseGrains<'_>>) -> Result<Adapter> {
    let (sizes, grains) = sizes(settings, points, plates, coarse)?;
    let adapter = holding(&sizes, grains.as_ref())?;
    if adapter.software {
        rounds::few_enough(settings, points, coarse)?;
    }
    Ok(adapter)
}

/// Sizes of the buffers, those of points and nodes and those of grains.
///
/// # Errors
/// The device lacks something that the continuum has.
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
    Ok((BufferSizes::of(settings, &blocks(settings, points), points.len() as u64, !plates.is_empty()), grains))
}

/// Blocks of the grid for these points.
fn blocks(settings: &Settings, points: &Points) -> Blocks {
    Blocks::of(settings, points.position.iter().map(|p| cell_of(settings, p).0))
}

/// Checks that shaders have these laws.
///
/// # Errors
/// The first law that they lack.
pub fn takes(laws: &[Law]) -> Result<()> {
    let refusal = |law: &Law| {
        let instead = law.on_gpu().err()?;
        Some(refused("material.continuum.law", law.word(), format!("is not available on the GPU: {instead}, or the processor")))
    };
    Error::all(laws.iter().find_map(refusal).into_iter().collect())
}

/// Refusals of what the device lacks.
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
    if let Some(most) = too_wide(settings) {
        let most = most.map(|n| n.to_string()).join(" x ");
        errors.push(refused(
            "cells of the domain",
            settings.cells.map(|n| n.to_string()).join(" x "),
            format!("are at most {most} on the GPU: use larger cells, or the processor"),
        ));
    }
    if points.is_empty() {
        errors.push(refused("points", 0, "must be at least one"));
    }
    if let Some(id) = points.id.iter().find(|id| **id >= 1 << 29) {
        errors.push(refused("id", id, "must be below 2^29 on the GPU"));
    }
    errors
}

/// The adapter, where it can have buffers of these sizes.
///
/// # Errors
/// There is no adapter; a buffer is larger than it allows.
fn holding(sizes: &BufferSizes, of_grains: Option<&grains::GrainBufferSizes>) -> Result<Adapter> {
    let adapter = adapter()?;
    sizes.check(&adapter.limits())?;
    if let Some(sizes) = of_grains {
        sizes.check(&adapter.limits())?;
    }
    Ok(Adapter::of(&adapter))
}
