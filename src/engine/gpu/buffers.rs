//! The buffers of a continuum on the device.

/// Buffers on the device; `passes.rs` binds them to the shaders.
pub(super) struct Buffers {
    pub params: wgpu::Buffer,
    pub laws: wgpu::Buffer,
    pub state: wgpu::Buffer,
    pub nodes: wgpu::Buffer,
    pub starts: wgpu::Buffer,
    pub counts: wgpu::Buffer,
    pub blocks: wgpu::Buffer,
    pub status: wgpu::Buffer,
    pub touching: wgpu::Buffer,
    pub batch: wgpu::Buffer,
}
