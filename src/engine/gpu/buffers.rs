//! The buffers of a continuum on the device, and how many workgroups each pass has.

/// Buffers on the device; `passes.rs` binds them to the shaders.
pub(super) struct Buffers {
    pub params: wgpu::Buffer,
    pub laws: wgpu::Buffer,
    pub state: wgpu::Buffer,
    pub nodes: wgpu::Buffer,
    pub starts: wgpu::Buffer,
    pub counts: wgpu::Buffer,
    pub order: wgpu::Buffer,
    pub status: wgpu::Buffer,
    pub touching: wgpu::Buffer,
    pub batch: wgpu::Buffer,
    pub dispatches: wgpu::Buffer,
}

/// Numbers of workgroups of the passes along x and y, and which passes a step has.
pub(super) struct Groups {
    pub points: [u32; 2],
    pub nodes: [u32; 2],
    pub walls: bool,
    pub plates: bool,
    pub grains: Option<GrainGroups>,
}

/// Numbers of workgroups of the passes of grains: of one thread per row ([`grains`]), of one thread per grain, and of one workgroup per grain; number of steps of the
/// grains in a step of the continuum.
pub(super) struct GrainGroups {
    pub rows: [u32; 2],
    pub grains: [u32; 2],
    pub each: [u32; 2],
    pub rates: u32,
}
