//! The graphics adapter: its choice, its set-up, buffers, and errors that it reports.

use super::bounds::WIDE;
use crate::error::{Error, Result};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use wgpu::util::DeviceExt;

/// A graphics adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adapter {
    /// Name, with the interface in use (Vulkan, Metal, Dx12).
    pub name: String,
    /// Whether it is a software adapter, which computes on the processor: good for tests, but slower than the code for the processor.
    pub software: bool,
}

impl Adapter {
    pub(super) fn of(adapter: &wgpu::Adapter) -> Adapter {
        let info = adapter.get_info();
        Adapter { name: format!("{} ({})", info.name, info.backend), software: info.device_type == wgpu::DeviceType::Cpu }
    }
}

/// The adapter that [`super::DeviceContinuum::new`] would use; `None` where there is none.
pub fn available() -> Option<Adapter> {
    adapter().ok().map(|adapter| Adapter::of(&adapter))
}

/// The entry to the graphics drivers, one for the whole process: some drivers do not stand being loaded and unloaded many times, nor by
/// several threads at once (measured with NVIDIA's, version 580: no adapter any more after some twenty times, and crashes).
fn instance() -> &'static wgpu::Instance {
    static INSTANCE: OnceLock<wgpu::Instance> = OnceLock::new();
    INSTANCE.get_or_init(|| {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::PRIMARY;
        // no validation layers, in builds with and without debug information alike
        descriptor.flags = wgpu::InstanceFlags::empty();
        descriptor.memory_budget_thresholds =
            wgpu::MemoryBudgetThresholds { for_resource_creation: Some(95), for_device_loss: None };
        wgpu::Instance::new(descriptor)
    })
}

/// The adapter that suits best.
///
/// # Errors
/// There is none.
pub(super) fn adapter() -> Result<wgpu::Adapter> {
    let options = wgpu::RequestAdapterOptions { power_preference: wgpu::PowerPreference::HighPerformance, ..Default::default() };
    pollster::block_on(instance().request_adapter(&options)).map_err(|_| {
        let message = "found no graphics adapter (Vulkan, Metal or Direct3D 12): install a driver (Debian's mesa-vulkan-drivers has one that \
                       computes on the processor) or use the processor";
        Error::Device(Box::new(Error::refused("gpu", "", None, message)))
    })
}

/// The error for something that the graphics device cannot do: the key, its value, and what to do instead.
pub fn refused(key: &str, value: impl ToString, message: impl Into<String>) -> Error {
    Error::Device(Box::new(Error::refused("gpu", key, Some(value.to_string()), message)))
}

/// The error for a failure of the device itself at the step `step`; the run can go on on the processor.
fn failed(step: u64, what: String) -> Error {
    Error::Device(Box::new(Error::Failed { step, what }))
}

/// The first error that the device has reported since it was opened.
#[derive(Clone, Default)]
struct Complaints(Arc<Mutex<Option<String>>>);

impl Complaints {
    fn note(&self, what: String) {
        // the first is the cause
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(what);
    }

    fn first(&self) -> Option<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// An open graphics device.
#[derive(Clone)]
pub struct Device {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub adapter: Adapter,
    complaints: Complaints,
    /// The buffer through which the last bytes were read: memory that both sides reach is slow to get.
    staging: Arc<Mutex<Option<wgpu::Buffer>>>,
}

impl Device {
    /// Opens the device.
    ///
    /// # Errors
    /// There is no adapter, or its limits are too small for the shaders.
    pub fn open(with_grains: bool) -> Result<Device> {
        let adapter = adapter()?;
        let known = Adapter::of(&adapter);
        let name = &known.name;
        let limits = adapter.limits();
        for (what, has, needs) in [
            ("storage buffers per stage", limits.max_storage_buffers_per_shader_stage, if with_grains { 17 } else { 10 }),
            ("threads per workgroup", limits.max_compute_invocations_per_workgroup, WIDE as u32),
        ] {
            if has < needs {
                return Err(refused("adapter", name, format!("has {has} {what}, {needs} are needed: use the processor")));
            }
        }
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("comminute"),
            // to time passes, where it can
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: limits,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| refused("adapter", name, format!("cannot be used: {e}; use the processor")))?;
        let complaints = Complaints::default();
        let (lost, other) = (complaints.clone(), complaints.clone());
        device.set_device_lost_callback(move |reason, what| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                lost.note(format!("the graphics device was lost: {what}"));
            }
        });
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| other.note(format!("the graphics device failed: {e}"))));
        Ok(Device { device, queue, adapter: known, complaints, staging: Arc::default() })
    }

    /// Checks that nothing has gone wrong on the device since it was opened.
    ///
    /// # Errors
    /// The first error of the device.
    pub fn healthy(&self, step: u64) -> Result<()> {
        match self.complaints.first() {
            None => Ok(()),
            Some(what) => Err(failed(step, format!("{what}; the state of the last record is kept"))),
        }
    }

    /// Runs `make`, which allocates buffers of `bytes` in all.
    ///
    /// # Errors
    /// The device is out of memory.
    pub fn allocate<T>(&self, bytes: u64, make: impl FnOnce() -> T) -> Result<T> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let made = make();
        if pollster::block_on(memory.pop()).is_some() {
            let message = "is more than the graphics device has left: use fewer points, a smaller domain or the processor";
            return Err(refused("memory", format!("{:.1} MiB", bytes as f64 / 1_048_576.0), message));
        }
        Ok(made)
    }

    /// A buffer with these contents.
    pub fn buffer(&self, label: &str, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
    }

    /// A buffer of `size` bytes, all zero.
    pub fn empty(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
    }

    /// Waits for the device and copies the first bytes of some buffers: for each a buffer and a number of bytes. The copies follow each other in the result.
    ///
    /// # Errors
    /// The device is lost.
    pub fn read(&self, parts: &[(&wgpu::Buffer, u64)], step: u64) -> Result<Vec<u8>> {
        let from_start: Vec<_> = parts.iter().map(|(buffer, size)| (*buffer, 0, *size)).collect();
        self.with_parts(&from_start, step, <[u8]>::to_vec)
    }

    /// As [`Self::read`], each part from a byte of its buffer on (buffer, first byte, number of bytes), and without a copy of its own: gives what `take` makes of
    /// the bytes, which begin at a multiple of eight in memory.
    ///
    /// # Errors
    /// The device is lost.
    pub fn with_parts<T>(&self, parts: &[(&wgpu::Buffer, u64, u64)], step: u64, take: impl FnOnce(&[u8]) -> T) -> Result<T> {
        let size = parts.iter().map(|(.., size)| size).sum();
        if size == 0 {
            self.wait(None, step)?;
            return Ok(take(&[]));
        }
        let lost =
            |what: &str| failed(step, format!("the graphics device cannot be read: {what}; the state of the last record is kept"));
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let mut kept = self.staging.lock().unwrap_or_else(PoisonError::into_inner);
        let staging = match kept.take().filter(|buffer| buffer.size() >= size) {
            Some(buffer) => buffer,
            None => self.allocate(size, || self.empty("staging", size, usage))?,
        };
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut at = 0;
        for (buffer, first, size) in parts.iter().filter(|(.., size)| *size > 0) {
            encoder.copy_buffer_to_buffer(buffer, *first, &staging, at, *size);
            at += size;
        }
        self.queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, ..size, move |result| {
            let _ = sender.send(result);
        });
        self.wait(None, step)?;
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(lost(&e.to_string())),
            Err(e) => return Err(lost(&e.to_string())),
        }
        let taken = take(&staging.get_mapped_range(..size).map_err(|e| lost(&e.to_string()))?);
        staging.unmap();
        self.healthy(step)?;
        *kept = Some(staging);
        Ok(taken)
    }

    /// Waits for a submission, or, with `None`, for all of them.
    ///
    /// # Errors
    /// The device is lost.
    pub fn wait(&self, submission: Option<wgpu::SubmissionIndex>, step: u64) -> Result<()> {
        let done = self.device.poll(wgpu::PollType::Wait { submission_index: submission, timeout: None });
        self.healthy(step)?;
        done.map(|_| ()).map_err(|e| failed(step, format!("the graphics device does not answer: {e}")))
    }
}
