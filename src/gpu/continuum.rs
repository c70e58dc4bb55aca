//! A continuum on the device: batches of steps without a look at what happens between.

use super::device::{Device, refused};
use super::layout::{Law32, Params, Platen32, Status, groups};
use super::memory::Sizes;
use super::passes::Passes;
use super::platen::{self, Drive, Platen};
use super::{shader, state};
use crate::error::{Error, Result};
use crate::mpm::{self, Dimension, Settings, ShapeFunctions, Transfer};
use std::collections::{HashMap, VecDeque};
use wgpu::BufferUsages as Usage;

/// Steps of one submission.
const BATCH: u64 = 200;
/// Submissions on their way.
const AHEAD: usize = 2;

/// The material points of an [`mpm::Continuum`] on the graphics device, with the same settings and laws.
///
/// The device computes in f32, with compensated sums where small steps add up. The same input gives the same bytes on the same device and driver.
pub struct Continuum {
    device: Device,
    passes: Passes,
    buffers: Buffers,
    params: Params,
    settings: Settings,
    sizes: Sizes,
    /// Id of the point in each place of the device.
    ids: Vec<u32>,
    /// Steps and stress work, J, of the CPU before.
    before: (u64, f64),
    status: Status,
    platens: Vec<Platen>,
}

/// Memory on the device.
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
    pub outside: wgpu::Buffer,
    pub dispatches: wgpu::Buffer,
}

impl Continuum {
    /// Takes over the state of `cpu`. Forces that wait there for its next step are not taken.
    ///
    /// # Errors
    /// No adapter; a setting that the GPU path lacks, by name; a state that does not fit into the device's memory.
    pub fn new(cpu: &mpm::Continuum) -> Result<Continuum> {
        Continuum::with_platens(cpu, &[])
    }

    /// The same, between platens. They press at the start of each step, as the rigs of the CPU have it, and then move.
    ///
    /// # Errors
    /// As [`Self::new`]; a platen that is not allowed.
    pub fn with_platens(cpu: &mpm::Continuum, platens: &[Platen]) -> Result<Continuum> {
        let settings = cpu.settings().clone();
        let mut errors = lacking(&settings, cpu.points());
        errors.extend(platen::wrong(platens, &settings, cpu.points()));
        Error::all(errors)?;
        let sizes = Sizes::of(&settings, cpu.points().len() as u64, !platens.is_empty());
        let device = Device::open()?;
        sizes.check(&device.device.limits())?;
        let lightest = cpu.points().velocity.iter().map(|v| v[3]).fold(f64::INFINITY, f64::min);
        let mut params = Params::of(&settings, cpu.points().len(), lightest);
        params.platens = platens.len() as u32;
        let passes = Passes::new(&device, shader::STEP);
        let state = state::to_device(&settings, cpu.points());
        let laws: Vec<Law32> = cpu.laws().iter().map(Law32::from).collect();
        let status = Status { crossed: 1, ..Status::default() };
        let storage = Usage::STORAGE | Usage::COPY_SRC;
        let buffers = device.allocate(sizes.sum(), || Buffers {
            params: device.buffer("params", bytemuck::bytes_of(&params), Usage::UNIFORM | Usage::COPY_DST),
            laws: device.buffer("laws", bytemuck::cast_slice(&laws), storage),
            state: device.buffer("state", bytemuck::cast_slice(&state), storage),
            nodes: device.empty("nodes", sizes.nodes, storage),
            starts: device.empty("starts", sizes.starts, storage),
            counts: device.empty("counts", sizes.counts, storage),
            order: device.empty("order", sizes.order, storage),
            status: device.buffer("status", bytemuck::bytes_of(&status), storage),
            touching: device.empty("touching", sizes.touching, storage),
            outside: device.empty("outside", sizes.outside, storage | Usage::COPY_DST),
            dispatches: device.empty("dispatches", 48, Usage::STORAGE | Usage::INDIRECT),
        })?;
        let planes: Vec<Platen32> = platens.iter().map(|p| p.to_device(&settings)).collect();
        device.queue.write_buffer(&buffers.outside, 0, bytemuck::cast_slice(&planes));
        let passes = passes.bind(&device, &buffers);
        let before = (cpu.steps(), cpu.stress_work());
        let ids = cpu.points().id.clone();
        let mut gpu =
            Continuum { device, passes, buffers, params, settings, sizes, ids, before, status, platens: platens.to_vec() };
        gpu.submit(|passes, pass, sizes| passes.prepare(pass, sizes));
        gpu.look()?;
        Ok(gpu)
    }

    /// `n` steps of `dt` seconds.
    ///
    /// # Errors
    /// A point that is lost, with its step, as on the CPU; a device that is lost or out of memory. [`Self::read_back`] then has nothing of use.
    pub fn steps(&mut self, n: u64, dt: f64) -> Result<()> {
        self.params.dt = dt as f32;
        for (drive, platen) in self.params.drives.iter_mut().zip(&self.platens) {
            *drive = platen.drive.to_device();
        }
        self.device.queue.write_buffer(&self.buffers.params, 0, bytemuck::bytes_of(&self.params));
        let mut flying = VecDeque::new();
        let mut left = n;
        while left > 0 {
            let now = left.min(BATCH);
            left -= now;
            flying.push_back(self.submit(|passes, pass, sizes| (0..now).for_each(|_| passes.step(pass, sizes))));
            if flying.len() > AHEAD {
                self.device.wait(flying.pop_front(), self.steps_done())?;
            }
        }
        self.look()
    }

    /// Writes the state into `cpu`, which must have the same points (by their ids), and its counters. Nothing changes on the device; a state that is taken up
    /// again from `cpu` differs from it by the rounding of f64.
    ///
    /// # Errors
    /// Other points; a device that was lost. `cpu` is then as it was.
    pub fn read_back(&self, cpu: &mut mpm::Continuum) -> Result<()> {
        let bytes = self.device.read(&self.buffers.state, self.steps_done())?;
        let planes: &[[u32; 4]] = bytemuck::cast_slice(&bytes);
        let places: HashMap<u32, usize> = cpu.points().id.iter().enumerate().map(|(i, &id)| (id, i)).collect();
        if places.len() != self.ids.len() || self.ids.iter().any(|id| !places.contains_key(id)) {
            return Err(refused("points", places.len(), "are others than those that went to the device"));
        }
        let points = cpu.points_mut();
        let mut work: Vec<(u32, f64)> = (self.ids.iter().enumerate())
            .map(|(i, id)| (*id, state::to_point(&self.settings, planes, i, points, places[id])))
            .collect();
        work.sort_unstable_by_key(|(id, _)| *id);
        let work: f64 = work.iter().map(|(_, work)| work).sum();
        cpu.set_counters(self.steps_done(), self.before.1 + work, self.wall_force());
        Ok(())
    }

    /// Steps done, those of the CPU before included.
    pub fn steps_done(&self) -> u64 {
        self.before.0 + u64::from(self.status.steps)
    }

    /// Force of each side on the material in the last step, N (order as [`Settings::walls`]).
    pub fn wall_force(&self) -> [[f64; 3]; 6] {
        self.status.reaction.map(|[x, y, z, _]| [x, y, z].map(f64::from))
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        self.sizes.sum()
    }

    /// The platens after the last batch.
    pub fn platens(&self) -> &[Platen] {
        &self.platens
    }

    /// Another drive for the platen `k` from the next batch on.
    ///
    /// # Errors
    /// There is no such platen.
    pub fn drive(&mut self, k: usize, drive: Drive) -> Result<()> {
        let count = self.platens.len();
        let platen = self.platens.get_mut(k).ok_or_else(|| refused("platen", k, format!("there are {count}, counted from 0")))?;
        platen.drive = drive;
        Ok(())
    }

    fn submit(&self, encode: impl FnOnce(&Passes, &mut wgpu::ComputePass<'_>, &Groups)) -> wgpu::SubmissionIndex {
        let mut encoder = self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            let groups = Groups {
                points: self.params.point_groups,
                nodes: groups(self.params.nodes),
                walls: self.walls(),
                platens: !self.platens.is_empty(),
            };
            encode(&self.passes, &mut pass, &groups);
        }
        self.device.queue.submit([encoder.finish()])
    }

    fn walls(&self) -> bool {
        self.params.walls.iter().any(|wall| wall[0] != 0)
    }

    /// Waits, and reads what the batches have left.
    fn look(&mut self) -> Result<()> {
        let bytes = self.device.read(&self.buffers.status, self.steps_done())?;
        self.status = bytemuck::pod_read_unaligned(&bytes);
        if !self.platens.is_empty() {
            let bytes = self.device.read(&self.buffers.outside, self.steps_done())?;
            for (platen, words) in self.platens.iter_mut().zip(bytes.chunks_exact(size_of::<Platen32>())) {
                platen.take(&bytemuck::pod_read_unaligned(words), &self.settings);
            }
        }
        let Status { fault, .. } = self.status;
        if fault == u32::MAX {
            return Ok(());
        }
        let (id, what) = (fault / 8, fault % 8);
        let what = match what {
            0 => "has no finite position, velocity or stress: use a smaller time step and look at the law's parameters",
            1 => "has left the grid: enlarge the domain, put a wall there, or use a smaller time step",
            2 => "has passed more than one cell in a step: use a smaller time step",
            3 => "is turned inside out (volume not positive): use a smaller time step, a finer grid, or a stiffer law",
            5 => "has been passed by a platen: its speed or the time step is too large, or the material too soft for it",
            _ => "lies in a cell with more than 256 points, which the GPU path does not sort: use larger spacings or the CPU",
        };
        Err(Error::Unstable { step: self.steps_done() + 1, what: format!("point {id} {what}"), grain: None })
    }

    /// What happens when a device goes away.
    #[cfg(test)]
    pub(super) fn lose(&self) {
        self.device.device.destroy();
    }

    /// Planes of momentum and mass, velocity, and change of velocity.
    #[cfg(test)]
    pub(super) fn nodes(&self) -> Vec<[f32; 4]> {
        bytemuck::pod_collect_to_vec(&self.device.read(&self.buffers.nodes, 0).expect("nodes"))
    }
}

/// Workgroups of the passes, and whether there are walls and platens.
pub(super) struct Groups {
    pub points: [u32; 2],
    pub nodes: [u32; 2],
    pub walls: bool,
    pub platens: bool,
}

/// What the GPU path does not have.
fn lacking(settings: &Settings, points: &mpm::Points) -> Vec<Error> {
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
