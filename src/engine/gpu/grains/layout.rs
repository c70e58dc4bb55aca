//! What the shaders of grains read, with the same offsets (`contact.wgsl`), in f32.

use bytemuck::{Pod, Zeroable};

/// Contacts of a grain with grains and with walls, and of a point with bodies, that there is room for.
pub const PARTNERS: usize = 32;
pub const SIDES: usize = 8;
pub const SLOTS: usize = PARTNERS + SIDES;
pub const PLACES: usize = 16;
/// Planes of four words of a contact, and of a grain.
pub const CONTACT: usize = 4;
pub const GRAIN: usize = 9;
/// Stands for nobody; bodies from here on are walls.
pub const NONE: u32 = u32::MAX;
pub const WALLS: u32 = 0x4000_0000;

/// The numbers of a mixture.
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
    pub unused: f32,
    pub work: [f32; 2],
}

/// What changes from step to step.
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
    pub sides: [Side; SIDES],
    pub reactions: [[f32; 2]; SIDES],
}
