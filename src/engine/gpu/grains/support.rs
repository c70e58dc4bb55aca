//! Which grains the graphics device can compute, and the memory that they need; answered without opening the device.

use super::layout::{CONTACT, GRAIN, Mix, NODES, RowShape};
use super::{CoarseGrains, FURTHEST, SKIN, WHOLE};
use crate::boundary::WallShape;
use crate::breakage::Birth;
use crate::contact::TangentialUnloading;
use crate::error::{Error, Result};
use crate::gpu::bounds::{SIDES, SLOTS};
use crate::gpu::device::refused;
use crate::gpu::loading_plate::is_shell;
use crate::gpu::state::ghost_radius;
use crate::grains::Grains;
use crate::mpm::{Points, Settings};
use crate::point_contacts::ActsOn;
use std::f64::consts::PI;

/// Largest number of grid cells for the search of grains along an axis.
const MOST_CELLS: f64 = 32.0;

/// Size of each buffer, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GrainBufferSizes {
    pub grains: u64,
    pub slots: u64,
    pub rows: u64,
    pub transport: u64,
    pub lists: u64,
    /// Number of rows: of points close to grains or walls that there is room for.
    pub room: usize,
}

/// The grid for the search of grains.
pub struct GrainGrid {
    /// Number of grid cells along each axis.
    pub along: [i32; 3],
    /// Edge of a grid cell, in cells of the continuum.
    pub size: f64,
}

/// Number of rows to allocate where `near_points` points of `points` are close to grains or walls now.
pub fn room(near_points: usize, points: usize) -> usize {
    (2 * near_points + 1024).min(points).max(1)
}

/// Distances between spheres are computed in quanta of 2^-split cells, as a whole number and a rest; this is the number split, with which the largest distance in a
/// contact stays below [`WHOLE`] quanta.
pub fn split(settings: &Settings, g: &Grains) -> u32 {
    let widest = 2.0 * largest(g) / settings.cell + 2.0;
    ((WHOLE / widest).log2().floor()).clamp(0.0, 12.0) as u32
}

/// Largest radius, m.
fn largest(g: &Grains) -> f64 {
    g.pos.iter().map(|p| p[3]).fold(0.0, f64::max)
}

/// The grid for the search: its cells are so large that two bodies in touch, at the face of a point that is [`FURTHEST`] beyond its ghost too, or within the skin, lie
/// in the same cell or in neighbouring ones.
pub fn grid(settings: &Settings, points: &Points, g: &Grains) -> GrainGrid {
    let largest_ghost = (0..points.len()).map(|i| ghost_radius(points, i)).fold(0.0, f64::max);
    let radius = largest(g);
    let reach = (radius + radius.max(largest_ghost + f64::from(FURTHEST) * settings.cell)) / settings.cell + 1.01 * SKIN;
    let wide = settings.cells.map(|n| f64::from(n) + 2.0);
    let size = wide.iter().fold(reach, |size, wide| size.max(wide / MOST_CELLS));
    GrainGrid { along: wide.map(|wide| (wide / size).ceil().max(1.0) as i32), size }
}

impl GrainBufferSizes {
    /// For these points and grains, with `room` rows of this shape.
    pub fn of(settings: &Settings, points: &Points, g: &Grains, room: usize, row: RowShape) -> GrainBufferSizes {
        let n = g.len().max(1) as u64;
        let grid_cells: u64 = grid(settings, points, g).along.iter().map(|n| *n as u64).product();
        GrainBufferSizes {
            grains: 16 * GRAIN as u64 * n,
            slots: 16 * (CONTACT * SLOTS) as u64 * n,
            rows: 16 * (row.planes * row.places + NODES + 1) as u64 * room as u64,
            transport: 16 * points.len() as u64,
            lists: 4 * (2 * grid_cells + 1 + n),
            room,
        }
    }

    /// Size of all buffers, bytes.
    pub fn sum(&self) -> u64 {
        self.grains + self.slots + self.rows + self.transport + self.lists + size_of::<Mix>() as u64
    }

    /// Compares the sizes with the limits of the device.
    ///
    /// # Errors
    /// A buffer is larger than the device allows.
    pub fn check(&self, limits: &wgpu::Limits) -> Result<()> {
        let most = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        for (what, bytes) in [("memory of the grains' contacts", self.slots), ("memory of the points' contacts", self.rows)] {
            if bytes > most {
                let mib = |bytes: u64| format!("{:.1} MiB", bytes as f64 / 1_048_576.0);
                return Err(refused(what, mib(bytes), format!("is above the device's {}: use the processor", mib(most))));
            }
        }
        Ok(())
    }
}

/// Sizes of the buffers of the grains, with an estimate of the number of points close to them.
///
/// # Errors
/// The device lacks something that the grains have.
pub fn sizes(settings: &Settings, points: &Points, coarse: &CoarseGrains<'_>) -> Result<GrainBufferSizes> {
    Error::all(lacking(settings, points, coarse))?;
    let near = near_points(settings, points, coarse);
    let room = room(near, points.len());
    Ok(GrainBufferSizes::of(settings, points, &coarse.mixture.grains.grains, room, RowShape::of(coarse)))
}

/// Estimate of the number of points close to grains or walls: those of the shells around the grains where points lie evenly.
pub fn near_points(settings: &Settings, points: &Points, coarse: &CoarseGrains<'_>) -> usize {
    let count = points.len();
    if coarse.table.touched_walls() > 0 {
        return count;
    }
    let volume = points.initial_volume.iter().sum::<f64>();
    let largest_ghost = (0..count).map(|i| ghost_radius(points, i)).fold(0.0, f64::max);
    let shell = |p: &[f64; 4]| {
        let outer = p[3] + largest_ghost + SKIN * settings.cell;
        4.0 / 3.0 * PI * (outer * outer * outer - p[3] * p[3] * p[3])
    };
    let around: f64 = coarse.mixture.grains.grains.pos.iter().map(shell).sum();
    (around / volume * count as f64).min(count as f64) as usize
}

/// Refusals of what the device lacks.
fn lacking(settings: &Settings, points: &Points, coarse: &CoarseGrains<'_>) -> Vec<Error> {
    let CoarseGrains { physics, mixture, .. } = coarse;
    let mut errors = Vec::new();
    let mut lacks = |key: &str, value: String, what: &str| {
        errors.push(refused(key, value, format!("is not available on the GPU: {what}, or the processor")));
    };
    if physics.contact.rolling {
        lacks("material.contact.rolling_friction", "above 0".into(), "use none");
    }
    if let Err(instead) = physics.contact.law.on_gpu() {
        lacks("contact.law", physics.contact.law.word().into(), instead);
    }
    if let Some(Err(instead)) = physics.crush.as_ref().map(|c| c.criterion.on_gpu()) {
        let word = physics.crush.as_ref().map_or("", |c| c.criterion.word());
        lacks("crushing.criterion", word.into(), instead);
    }
    if physics.crush.as_ref().is_some_and(|c| !c.criterion.weighs_radius()) {
        lacks("crushing.area_radius", "own".into(), "use pair");
    }
    match coarse.table.acts_on {
        ActsOn::Node => lacks("contact.on_points", "node".into(), "use face or centre"),
        ActsOn::MutualNodes => lacks("contact.on_points", "mutual_nodes".into(), "use face or centre"),
        ActsOn::Face | ActsOn::Centre => {}
    }
    if physics.contact.unloading == TangentialUnloading::Rescale {
        lacks("contact.unloading", "rescale".into(), "use keep");
    }
    if physics.crush.as_ref().is_some_and(|c| c.birth != Birth::Overlapping) {
        lacks("crushing.birth", "gradual".into(), "use overlapping");
    }
    let walls = &mixture.grains.walls;
    if walls.len() > SIDES {
        lacks("wall", walls.len().to_string(), &format!("use at most {SIDES}"));
    }
    for wall in walls {
        match wall.shape {
            WallShape::Plane { normal, .. } if normal.iter().filter(|n| n.abs() == 1.0).count() == 1 => {}
            WallShape::Plane { normal, .. } => lacks("wall.normal", format!("{normal:?}"), "use planes along the axes"),
            WallShape::Cylinder { radius, .. } if is_shell(radius / settings.cell) => {}
            WallShape::Cylinder { radius, .. } => lacks("wall.radius", radius.to_string(), "use larger cells"),
        }
    }
    let g = &mixture.grains.grains;
    let most = 0.5 * (WHOLE - 2.0) * settings.cell;
    if largest(g) > most {
        lacks("grain radius", largest(g).to_string(), &format!("use at most {most:.4} m"));
    }
    if g.len() >= 1 << 20 {
        lacks("grains", g.len().to_string(), "use fewer");
    }
    let largest_ghost = (0..points.len()).map(|i| ghost_radius(points, i)).fold(0.0, f64::max);
    if largest_ghost > 0.9 * settings.cell {
        lacks("ghost radius", largest_ghost.to_string(), "use larger cells");
    }
    errors
}
