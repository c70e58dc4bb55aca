//! Structs that the shaders of grains read and write, with the same fields at the same offsets. What the fields are is said with the structs of the same names in
//! `contact.wgsl`; a test compares the offsets.

use super::CoarseGrains;
use crate::gpu::bounds::{MANY_PLACES, PLACES, SIDES};
use bytemuck::{Pod, Zeroable};

/// Number of planes of a contact: arrays with four words of 32 bits for each contact.
pub const CONTACT: usize = 4;
/// Number of planes of a contact of a point, and where points come from breakages.
pub const POINT_CONTACT: usize = 6;
pub const WITH_FINES: usize = POINT_CONTACT + 1;
/// Number of nodes that a point reaches.
pub const NODES: usize = 27;
/// Number of planes of a grain.
pub const GRAIN: usize = 9;
/// In place of the overlap of a contact of a point: it has no face.
pub const NO_FACE: f32 = -1.0;
/// In place of an index: none.
pub const NONE: u32 = u32::MAX;
/// Bodies in contact are named by one number: grains by their index, walls by this plus their index.
pub const WALLS: u32 = 0x4000_0000;

/// Shape of a row: room for so many contacts of a point, each of so many planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowShape {
    pub planes: usize,
    pub places: usize,
}

impl RowShape {
    /// That of a scene, as the shaders have it.
    pub fn of(coarse: &CoarseGrains<'_>) -> RowShape {
        RowShape {
            planes: if coarse.mixture.fines.is_some() { WITH_FINES } else { POINT_CONTACT },
            places: if coarse.physics.crush.is_some() { MANY_PLACES } else { PLACES },
        }
    }

    /// Whether points come from breakages.
    pub fn has_fines(self) -> bool {
        self.planes == WITH_FINES
    }
}

/// What stays the same during one batch of steps with grains.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Coupling {
    pub grains: u32,
    pub rows: u32,
    pub walls: u32,
    pub point_walls: u32,
    pub materials: u32,
    pub laws: u32,
    pub split: u32,
    pub law: u32,
    pub rates: u32,
    pub turning: u32,
    pub hertz_area: u32,
    pub crushing: u32,
    pub skin: f32,
    pub reach: f32,
    pub least: f32,
    pub damping: f32,
    pub grid: [i32; 3],
    pub grid_cells: u32,
    pub grid_size: f32,
    pub quantum: f32,
    pub fine: f32,
    pub far: i32,
    pub tables: [u32; 4],
}

/// A wall of the grains.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Side {
    pub axis: u32,
    pub normal: f32,
    pub cell: i32,
    pub units: i32,
    pub rest: f32,
    pub speed: f32,
    pub plate: u32,
    pub reaction: f32,
    pub stiffness: f32,
    pub shell: u32,
    pub work: [f32; 2],
    pub centre_cell: [i32; 2],
    pub centre_units: [i32; 2],
    pub centre_rest: [f32; 2],
    pub split: u32,
    pub unused: u32,
}

/// State of the grains as a whole, which changes from step to step.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Mix {
    pub rows: u32,
    pub crowded: u32,
    pub broken: u32,
    pub lost: u32,
    pub fastest_point: u32,
    pub fastest_grain: u32,
    pub point_rate: u32,
    pub search: u32,
    pub travelled: f32,
    pub point_speed: f32,
    pub ahead: f32,
    pub sub: u32,
    pub grain_rate: f32,
    pub grain_rate_points: f32,
    pub fresh: u32,
    pub contacts_known: u32,
    pub bound_ratio: f32,
    pub isolated_bound: f32,
    pub largest_bound: u32,
    pub slow: u32,
    pub furthest: u32,
    pub wanted: u32,
    pub sides: [Side; SIDES],
    pub reactions: [[f32; 2]; SIDES],
}
