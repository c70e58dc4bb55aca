//! A continuum on the device: batches of steps without a look at what happens between.

use super::device::{Adapter, Device, refused};
use super::grains::{self, Bodies, CoarseGrains};
use super::layout::{BatchState, Law32, Params, Status, groups};
use super::loading_plate::{self, both};
use super::memory::BufferSizes;
use super::passes::Passes;
use super::state;
use super::support::{sizes, takes};
use crate::coupling::Mixture;
use crate::dem::physics::Physics;
use crate::error::{Error, Result};
use crate::mpm::{self, LoadingPlate, PlateDrive, Ramp, Settings};
use crate::point_contacts::PointContactTable;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use wgpu::BufferUsages as Usage;

/// Steps of one submission.
const BATCH: u64 = 200;
/// Submissions on their way.
const AHEAD: usize = 2;

/// The material points of an [`mpm::Continuum`] on the graphics device, with the same settings and laws.
///
/// The device computes in f32, with compensated sums where small steps add up. The same input gives the same bytes on the same device and driver.
pub struct DeviceContinuum {
    device: Device,
    passes: Passes,
    buffers: Buffers,
    params: Params,
    settings: Settings,
    sizes: BufferSizes,
    /// Ids of the points and their places on the device, in the order of ids.
    by_id: Vec<(u32, u32)>,
    /// Steps and stress work, J, before the state went to the device.
    before: (u64, f64),
    status: Status,
    batch: BatchState,
    plates: Vec<LoadingPlate>,
    drives: Vec<PlateDrive>,
    bodies: Option<Bodies>,
}

/// The device's own words, from which it goes on with the same bits.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Saved {
    state: Vec<u32>,
    plates: Vec<u32>,
    /// Bits of the stress work before the state went to the device, J.
    work: u64,
    grains: Option<grains::SavedGrains>,
}

/// What a batch left of each of its steps: means over the instants at their ends.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Means {
    pub steps: u64,
    /// Length of the batch, s.
    pub time: f64,
    /// Way since the batch began and overlap, m, and reaction, N, of each loading plate.
    pub plates: Vec<[f64; 3]>,
    /// Force along the inward normal of each side of the domain, N.
    pub sides: [f64; 6],
    /// Force of the grains on each of their walls, N.
    pub grains: Vec<f64>,
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
    pub batch: wgpu::Buffer,
    pub dispatches: wgpu::Buffer,
}

impl DeviceContinuum {
    /// Takes over the state of `cpu`. Forces that wait there for its next step are not taken.
    ///
    /// # Errors
    /// No adapter; a setting that the GPU path lacks, by name; a state that does not fit into the device's memory.
    pub fn new(cpu: &mpm::Continuum) -> Result<DeviceContinuum> {
        DeviceContinuum::with_plates(cpu, &[])
    }

    /// The same, between loading plates, which stand still until they are driven.
    ///
    /// # Errors
    /// As [`Self::new`]; a loading plate that is not allowed; one through the points.
    pub fn with_plates(cpu: &mpm::Continuum, plates: &[LoadingPlate]) -> Result<DeviceContinuum> {
        DeviceContinuum::begin(cpu, plates, &vec![0.0; plates.len()], None, None)
    }

    /// The same with the mean speeds of the loading plates under servo, m/s, and with grains, or from what [`Self::save`] gave of a continuum with these points and grains.
    ///
    /// # Errors
    /// As [`Self::with_plates`]; what the GPU path lacks of grains, by name; a state of other points.
    pub fn begin(
        cpu: &mpm::Continuum,
        plates: &[LoadingPlate],
        drifts: &[f64],
        coarse: Option<&CoarseGrains<'_>>,
        saved: Option<&Saved>,
    ) -> Result<DeviceContinuum> {
        takes(cpu.laws())?;
        sizes(cpu.settings(), cpu.points(), plates, coarse)?;
        let device = Device::open(coarse.is_some())?;
        let passes = Passes::new(&device, coarse.is_some());
        DeviceContinuum::load(device, passes, cpu, plates, drifts, coarse, saved)
    }

    /// Takes another state over, of as many points and grains as there are now.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn again(
        &mut self,
        cpu: &mpm::Continuum,
        plates: &[LoadingPlate],
        drifts: &[f64],
        coarse: Option<&CoarseGrains<'_>>,
        saved: Option<&Saved>,
    ) -> Result<()> {
        *self = DeviceContinuum::load(self.device.clone(), self.passes.clone(), cpu, plates, drifts, coarse, saved)?;
        Ok(())
    }

    fn load(
        device: Device,
        passes: Passes,
        cpu: &mpm::Continuum,
        plates: &[LoadingPlate],
        drifts: &[f64],
        coarse: Option<&CoarseGrains<'_>>,
        saved: Option<&Saved>,
    ) -> Result<DeviceContinuum> {
        let settings = cpu.settings().clone();
        takes(cpu.laws())?;
        let (sizes, _) = sizes(&settings, cpu.points(), plates, coarse)?;
        sizes.check(&device.device.limits())?;
        let lightest = cpu.points().velocity.iter().map(|v| v[3]).fold(f64::INFINITY, f64::min);
        let mut params = Params::of(&settings, cpu.points().len(), lightest);
        params.plates = plates.len() as u32;
        params.extents = [1.0; 3];
        let mut state = state::to_device(&settings, cpu.points(), !plates.is_empty());
        let mut batch = BatchState::default();
        for ((there, plate), drift) in batch.plates.iter_mut().zip(plates).zip(drifts) {
            *there = loading_plate::to_device(plate, *drift, &settings);
        }
        let mut before = (cpu.steps(), cpu.stress_work());
        if let Some(saved) = saved {
            let words: &[[u32; 4]] = bytemuck::try_cast_slice(&saved.state).unwrap_or(&[]);
            let own: &mut [u32] = bytemuck::cast_slice_mut(&mut batch.plates);
            if words.len() != state.len() || saved.plates.len() != own.len() {
                return Err(refused("state", saved.state.len(), format!("words are not those of {} points", cpu.points().len())));
            }
            state.copy_from_slice(words);
            own.copy_from_slice(&saved.plates);
            before.1 = f64::from_bits(saved.work);
        }
        let by_id = state::by_id(&state, cpu.points().len());
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
            status: device.buffer("status", bytemuck::bytes_of(&status), storage | Usage::COPY_DST),
            touching: device.empty("touching", sizes.touching, storage),
            batch: device.empty("batch", sizes.batch, storage | Usage::COPY_DST),
            dispatches: device.empty("dispatches", 48, Usage::STORAGE | Usage::INDIRECT),
        })?;
        device.queue.write_buffer(&buffers.batch, 0, bytemuck::bytes_of(&batch));
        let of_grains = saved.and_then(|saved| saved.grains.as_ref());
        let bodies = coarse.map(|coarse| Bodies::new(&device, cpu, coarse, plates.len(), of_grains)).transpose()?;
        let passes = passes.bind(&device, &buffers, bodies.as_ref().map(|b| &b.buffers));
        let drives = plates.iter().map(|p| PlateDrive::Speed(Ramp::constant(p.speed))).collect();
        let plates = plates.to_vec();
        let mut gpu = DeviceContinuum {
            device,
            passes,
            buffers,
            params,
            settings,
            sizes,
            by_id,
            before,
            status,
            batch,
            plates,
            drives,
            bodies,
        };
        gpu.submit(|passes, pass, sizes| passes.prepare(pass, sizes));
        gpu.look()?;
        Ok(gpu)
    }

    /// `n` steps of `dt` seconds.
    ///
    /// # Errors
    /// A point that is lost, with its step, as on the CPU; a device that is lost or out of memory. [`Self::read_back`] then has nothing of use.
    pub fn steps(&mut self, n: u64, dt: f64) -> Result<()> {
        self.batch(n, dt, 0.0)
    }

    /// `n` steps of at most `dt` seconds, and at most the share `safety` of what waves and the loading plates' contacts allow together at each.
    ///
    /// # Errors
    /// As [`Self::steps`].
    pub fn batch(&mut self, n: u64, dt: f64, safety: f64) -> Result<()> {
        (self.params.dt, self.params.safety) = (dt as f32, safety as f32);
        for (there, drive) in self.params.drives.iter_mut().zip(&self.drives) {
            *there = (*drive).into();
        }
        let mut batch = BatchState { dt: self.params.dt, plates: self.batch.plates, ..BatchState::default() };
        for p in &mut batch.plates {
            (p.way, p.ways, p.overlaps, p.reactions) = Default::default();
        }
        let queue = &self.device.queue;
        queue.write_buffer(&self.buffers.params, 0, bytemuck::bytes_of(&self.params));
        queue.write_buffer(&self.buffers.batch, 0, bytemuck::bytes_of(&batch));
        queue.write_buffer(&self.buffers.status, std::mem::offset_of!(Status, fastest) as u64, &[0; 4]);
        if let Some(bodies) = &self.bodies {
            bodies.prepare(queue);
        }
        let mut flying = VecDeque::new();
        let mut left = n;
        while left > 0 {
            let now = left.min((BATCH / self.bodies.as_ref().map_or(1, |b| u64::from(b.coupling.rates))).max(1));
            left -= now;
            flying.push_back(self.submit(|passes, pass, sizes| (0..now).for_each(|_| passes.step(pass, sizes))));
            if flying.len() > AHEAD {
                self.device.wait(flying.pop_front(), self.steps_done())?;
            }
        }
        self.submit(|passes, pass, sizes| passes.survey(pass, sizes));
        self.look()
    }

    /// Writes the state into `cpu`, which must have the same points (by their ids), and its counters. Nothing changes on the device; a state that is taken up
    /// again from `cpu` differs from it by the rounding of f64.
    ///
    /// # Errors
    /// Other points; a device that was lost. `cpu` is then as it was.
    pub fn read_back(&self, cpu: &mut mpm::Continuum) -> Result<()> {
        let bytes = self.words()?;
        let planes: &[[u32; 4]] = bytemuck::cast_slice(&bytes);
        let there = cpu.points().by_id();
        let same = |(&(id, _), &i): (&(u32, u32), &u32)| id == cpu.points().id[i as usize];
        if there.len() != self.by_id.len() || !self.by_id.iter().zip(&there).all(same) {
            return Err(refused("points", there.len(), "are others than those that went to the device"));
        }
        let points = cpu.points_mut();
        let point = |(&(_, i), &to): (&(u32, u32), &u32)| state::to_point(&self.settings, planes, i as usize, points, to as usize);
        let work: f64 = self.by_id.iter().zip(&there).map(point).sum();
        cpu.set_counters(self.steps_done(), self.before.1 + work, self.wall_force());
        Ok(())
    }

    /// The words of the state as they are.
    ///
    /// # Errors
    /// A device that was lost.
    pub fn save(&self) -> Result<Saved> {
        let bytes = self.words()?;
        let plates: &[u32] = bytemuck::cast_slice(&self.batch.plates);
        let grains = self.bodies.as_ref().map(|b| b.save(&self.device, self.steps_done())).transpose()?;
        Ok(Saved { state: bytemuck::pod_collect_to_vec(&bytes), plates: plates.to_vec(), work: self.before.1.to_bits(), grains })
    }

    fn words(&self) -> Result<Vec<u8>> {
        self.device.read(&[(&self.buffers.state, self.sizes.state)], self.steps_done())
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
        self.sizes.sum() + self.bodies.as_ref().map_or(0, Bodies::bytes)
    }

    /// The adapter.
    pub fn adapter(&self) -> &Adapter {
        &self.device.adapter
    }

    /// The loading plates as they feel the points after the last batch.
    pub fn plates(&self) -> &[LoadingPlate] {
        &self.plates
    }

    /// Mean speed of the loading plate `k` under servo, m/s.
    pub fn drift(&self, k: usize) -> f64 {
        self.batch.plates[k].drift.into()
    }

    /// What the last batch left.
    pub fn means(&self) -> Means {
        let BatchState { time, count, sides, plates, .. } = self.batch;
        let n = f64::from(count.max(1));
        let mean = |sum: [f32; 2]| both(sum) / n;
        Means {
            steps: count.into(),
            time: both(time),
            plates: plates[..self.plates.len()].iter().map(|p| [p.ways, p.overlaps, p.reactions].map(mean)).collect(),
            sides: sides.map(mean),
            grains: self.bodies.as_ref().map(|b| b.reactions(count.into())).unwrap_or_default(),
        }
    }

    /// Writes grains, their walls and all contacts into `mixture`, and points into `cpu` as [`Self::read_back`].
    ///
    /// # Errors
    /// As [`Self::read_back`].
    pub fn read_grains(
        &self,
        coarse: (&Physics, &PointContactTable),
        mixture: &mut Mixture,
        cpu: &mut mpm::Continuum,
    ) -> Result<()> {
        let Some(bodies) = &self.bodies else { return Ok(()) };
        let point = self.places(cpu);
        let dt = f64::from(self.batch.dt) / f64::from(bodies.coupling.rates);
        bodies.read_back((&self.device, self.steps_done()), coarse, mixture, cpu, &point, dt)
    }

    /// Index there of each point of the device.
    fn places(&self, cpu: &mpm::Continuum) -> Vec<u32> {
        let mut point = vec![0; self.by_id.len()];
        for ((_, i), to) in self.by_id.iter().zip(cpu.points().by_id()) {
            point[*i as usize] = to;
        }
        point
    }

    /// Where the last batch has ended between two steps of the grains: those done in the step that was begun, and the length of that, s.
    pub fn within(&self) -> Option<(u32, f64)> {
        let bodies = self.bodies.as_ref().filter(|b| b.mix.sub > 0)?;
        Some((bodies.mix.sub, self.batch.dt.into()))
    }

    /// Pushes the points of `cpu` as contacts have pushed them in the step that was begun.
    ///
    /// # Errors
    /// A device that was lost.
    pub fn apply_point_forces(&self, cpu: &mut mpm::Continuum) -> Result<()> {
        let Some(bodies) = &self.bodies else { return Ok(()) };
        let point = self.places(cpu);
        for ((force, stiffness), i) in bodies.pushes(&self.device, self.steps_done())?.into_iter().zip(point) {
            cpu.add_external_force(i as usize, force, stiffness);
        }
        Ok(())
    }

    /// Writes what the grains' walls felt at the end of the last batch into `mixture`.
    pub fn walls_of(&self, cpu: &mpm::Continuum, mixture: &mut Mixture) {
        if let Some(bodies) = &self.bodies {
            bodies.walls(cpu, mixture);
        }
    }

    /// Steps of the grains in a step of the continuum, from the next batch on.
    pub fn rates(&mut self, grains: u32) {
        if let Some(bodies) = &mut self.bodies {
            bodies.coupling.rates = grains.max(1);
        }
    }

    /// What the grains' own contacts allow, s, and what those of points with grains and loading plates add to the square of a frequency, 1/s², at the end of the last batch.
    pub fn bounds(&self, plates: &[LoadingPlate]) -> (f64, f64) {
        self.bodies.as_ref().map_or((f64::INFINITY, 0.0), |bodies| bodies.bounds(plates))
    }

    /// Whether the last batch has ended because a grain is over its limit. The next one does nothing until a state has been taken over.
    pub fn broken(&self) -> bool {
        self.bodies.as_ref().is_some_and(Bodies::broken)
    }

    /// Whether so many points are near grains now that the state should be taken over again, with more room.
    pub fn crowded(&self) -> bool {
        self.bodies.as_ref().is_some_and(Bodies::crowded)
    }

    /// The least h/(c + |v|) over the points after the last batch, s, as [`mpm::Continuum::stable_step`].
    pub fn stable_step(&self) -> f64 {
        self.settings.cell / f64::from(f32::from_bits(self.status.fastest))
    }

    /// Another drive for the loading plate `k` from the next batch on.
    ///
    /// # Errors
    /// There is no such loading plate.
    pub fn drive(&mut self, k: usize, drive: PlateDrive) -> Result<()> {
        let count = self.drives.len();
        let own = self.drives.get_mut(k).ok_or_else(|| refused("platen", k, format!("there are {count}, counted from 0")))?;
        *own = drive;
        Ok(())
    }

    /// What the material extends over along each axis, m, for loading plates that hold a stress in the next batch: `extents` and, where it follows
    /// them, each loading plate's mean overlap less its way since the batch began. Until it is told, extents are 1 m and stay so.
    pub fn material(&mut self, extents: [f64; 3], follows: bool) {
        (self.params.extents, self.params.follows) = (extents.map(|x| x as f32), f32::from(follows));
    }

    fn submit(&self, encode: impl FnOnce(&Passes, &mut wgpu::ComputePass<'_>, &Groups)) -> wgpu::SubmissionIndex {
        let mut encoder = self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            let groups = Groups {
                points: self.params.point_groups,
                nodes: groups(self.params.nodes),
                walls: self.walls(),
                plates: !self.plates.is_empty(),
                grains: self.bodies.as_ref().map(|b| GrainGroups {
                    rows: groups(b.coupling.rows),
                    grains: groups(b.coupling.grains),
                    each: groups(64 * b.coupling.grains),
                    rates: b.coupling.rates,
                }),
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
        let mut parts =
            vec![(&self.buffers.status, size_of::<Status>() as u64), (&self.buffers.batch, size_of::<BatchState>() as u64)];
        parts.extend(self.bodies.as_ref().map(|b| (&b.buffers.mix, size_of::<grains::Mix>() as u64)));
        let bytes = self.device.read(&parts, self.steps_done())?;
        let (status, rest) = bytes.split_at(size_of::<Status>());
        let (batch, mix) = rest.split_at(size_of::<BatchState>());
        if let Some(bodies) = &mut self.bodies {
            bodies.mix = bytemuck::pod_read_unaligned(mix);
        }
        (self.status, self.batch) = (bytemuck::pod_read_unaligned(status), bytemuck::pod_read_unaligned(batch));
        for (plate, there) in self.plates.iter_mut().zip(&self.batch.plates) {
            loading_plate::take(plate, there, &self.settings);
        }
        let Status { fault, .. } = self.status;
        if fault == u32::MAX {
            return match &self.bodies {
                Some(bodies) => bodies.sound(self.steps_done(), &self.device),
                None => Ok(()),
            };
        }
        let (id, fault) = (fault / 8, fault % 8);
        let crowded = format!(
            "has more than {} grains and walls near it, which the GPU path does not keep: use smaller cells, or go on on the processor",
            grains::PLACES
        );
        let what = match fault {
            0 => "has no finite position, velocity or stress: use a smaller time step and look at the law's parameters",
            1 => "has left the grid: enlarge the domain, put a wall there, or use a smaller time step",
            2 => "has passed more than one cell in a step: use a smaller time step",
            3 => "is turned inside out (volume not positive): use a smaller time step, a finer grid, or a stiffer law",
            // found by what comes after a step
            5 => return Err(mpm::loading_plate::passed(self.steps_done(), id)),
            6 => &crowded,
            7 => "came near a grain as one of more than there is room for: go on on the processor",
            _ => {
                "lies in a cell with more than 256 points, which the GPU path does not sort: use larger spacings, or the processor"
            }
        };
        let error = Error::Unstable { step: self.steps_done() + 1, what: format!("point {id} {what}"), grain: None };
        // from 6 on it is the device that has no room
        Err(if fault < 6 { error } else { Error::Device(Box::new(error)) })
    }

    /// Gives the device up, as a driver does that resets it: whatever is asked of it afterwards fails.
    pub fn lose(&self) {
        self.device.device.destroy();
    }

    /// Planes of momentum and mass, velocity, and change of velocity.
    #[cfg(test)]
    pub(super) fn nodes(&self) -> Vec<[f32; 4]> {
        bytemuck::pod_collect_to_vec(&self.device.read(&[(&self.buffers.nodes, self.sizes.nodes)], 0).expect("nodes"))
    }
}

/// Workgroups of the passes, and whether there are walls and loading plates.
pub(super) struct Groups {
    pub points: [u32; 2],
    pub nodes: [u32; 2],
    pub walls: bool,
    pub plates: bool,
    pub grains: Option<GrainGroups>,
}

/// Of points near something, of grains, of one group for each grain; steps of the grains in a step.
pub(super) struct GrainGroups {
    pub rows: [u32; 2],
    pub grains: [u32; 2],
    pub each: [u32; 2],
    pub rates: u32,
}
