//! A continuum on the graphics device, which computes steps in batches; the processor reads the state only between batches.

use super::blocks::Blocks;
use super::bounds::CROWD;
use super::buffers::Buffers;
use super::clock::{Clock, PassTime};
use super::device::{Adapter, Device, refused};
use super::grains::{self, Bodies, CoarseGrains};
use super::layout::{self, BatchState, Law32, Params, Status};
use super::loading_plate::{self, both};
use super::memory::BufferSizes;
use super::passes::Passes;
use super::plan::{Dispatch, Extent, GrainExtent};
use super::rounds;
use super::state;
use super::support::{sizes, takes};
use super::work::StepWork;
use crate::boundary::{Wall, WallShape};
use crate::coupling::Mixture;
use crate::dem::physics::Physics;
use crate::error::{Error, Result};
use crate::mpm::{self, LoadingPlate, PlateDrive, Ramp, Settings};
use crate::point_contacts::PointContactTable;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::time::Instant;
use wgpu::BufferUsages as Usage;

/// Steps of the grains, or of the continuum alone, in the first submission to the device, and at most in each.
const FIRST: u64 = 16;
const MOST: u64 = 1000;
/// How long the device shall work on one submission, s: a driver of a display ends one that takes two seconds.
const LONG: f64 = 0.2;
/// Number of the layout of a saved state: another one cannot be read.
const LAYOUT: u32 = 5;
/// Fault of a point that a loading plate has passed.
const PASSED: u32 = 5;
/// Largest number of submissions that wait on the device.
const AHEAD: usize = 2;

/// The material points of an [`mpm::Continuum`] on the graphics device, with the same settings and laws, its loading plates, and its grains where it has some.
///
/// The device computes in f32, with compensated sums where many small increments add up. The same input gives the same bits on the same device and driver.
pub struct DeviceContinuum {
    device: Device,
    passes: Passes,
    buffers: Buffers,
    params: Params,
    settings: Settings,
    sizes: BufferSizes,
    /// Identities of the points and their indices on the device, in the order of identities.
    by_id: Vec<(u32, u32)>,
    /// Number of steps and stress work, J, at the time the state was copied to the device.
    before: (u64, f64),
    status: Status,
    batch: BatchState,
    plates: Vec<LoadingPlate>,
    drives: Vec<PlateDrive>,
    bodies: Option<Bodies>,
    /// Energy that contacts have gained in the last batch as their overlaps without force shrank, J.
    released: f64,
    /// Steps in one submission, from the time that the last ones took.
    at_once: u64,
    /// Times the passes, where somebody asked for it.
    clock: Option<Clock>,
}

/// The state as the device holds it, so that a run that is resumed from it continues with the same bits.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Saved {
    /// Number of the layout, [`LAYOUT`].
    pub(super) layout: u32,
    state: Vec<u32>,
    plates: Vec<u32>,
    /// Stress work at the time the state was copied to the device, J, as the bits of an f64.
    work: u64,
    grains: Option<grains::SavedGrains>,
}

/// Means over a batch, taken at the ends of its steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Means {
    /// Number of steps.
    pub steps: u64,
    /// Duration of the batch, s.
    pub time: f64,
    /// For each loading plate: displacement along its normal since the batch began, m; overlap with the points, m; reaction, N.
    pub plates: Vec<[f64; 3]>,
    /// Force along the inward normal of each side of the domain, N.
    pub sides: [f64; 6],
    /// Normal force of the grains on each of their walls, N.
    pub grains: Vec<f64>,
}

impl DeviceContinuum {
    /// Copies the state of `cpu` to the device. External forces that have been added there for the next step are not copied.
    ///
    /// # Errors
    /// There is no adapter; the device lacks a setting; its memory is too small.
    pub fn new(cpu: &mpm::Continuum) -> Result<DeviceContinuum> {
        DeviceContinuum::with_plates(cpu, &[])
    }

    /// The same with loading plates, which keep their speeds until [`Self::drive`] is called.
    ///
    /// # Errors
    /// As [`Self::new`]; a loading plate that the device lacks, or that lies in the points.
    pub fn with_plates(cpu: &mpm::Continuum, plates: &[LoadingPlate]) -> Result<DeviceContinuum> {
        DeviceContinuum::begin(cpu, plates, &vec![0.0; plates.len()], None, None)
    }

    /// The same with the mean speeds of the loading plates under servo control, m/s, with grains, and, where `saved` is given, with the state that [`Self::save`] has
    /// returned for these points and grains in place of that of `cpu`.
    ///
    /// # Errors
    /// As [`Self::with_plates`]; the device lacks something of the grains; `saved` is the state of other points or grains.
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
        let round = |wall: &Wall| matches!(wall.shape, WallShape::Cylinder { .. });
        let shells = plates.iter().any(|p| p.radius.is_some()) || coarse.is_some_and(|c| c.mixture.grains.walls.iter().any(round));
        let laws: Vec<Law32> = cpu.laws().iter().map(Law32::from).collect();
        let passes = Passes::new(&device, coarse, shells, &layout::wall_kinds(cpu.settings()), &laws, plates);
        DeviceContinuum::load(device, passes, cpu, plates, drifts, coarse, saved)
    }

    /// Replaces everything by another state, as [`Self::begin`] does, on the device and with the pipelines that are open already.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn reload(
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
        sizes(&settings, cpu.points(), plates, coarse)?;
        if device.adapter.software {
            rounds::few_enough(&settings, cpu.points(), coarse)?;
        }
        let mut state = state::to_device(&settings, cpu.points(), !plates.is_empty());
        let mut batch = BatchState::default();
        let round = plates.iter().any(|p| p.radius.is_some());
        for ((there, plate), drift) in batch.plates.iter_mut().zip(plates).zip(drifts) {
            *there = loading_plate::to_device(plate, *drift, round, &settings);
        }
        let mut before = (cpu.steps(), cpu.stress_work());
        if let Some(saved) = saved {
            let words: &[[u32; 4]] = bytemuck::try_cast_slice(&saved.state).unwrap_or(&[]);
            let own: &mut [u32] = bytemuck::cast_slice_mut(&mut batch.plates);
            if saved.layout != LAYOUT || words.len() != state.len() || saved.plates.len() != own.len() {
                return Err(refused(
                    "state",
                    saved.state.len(),
                    format!(
                        "words: this is the saved state of other points than the {} given, or of another version",
                        cpu.points().len()
                    ),
                ));
            }
            state.copy_from_slice(words);
            own.copy_from_slice(&saved.plates);
            before.1 = f64::from_bits(saved.work);
        }
        let by_id = state::by_id(&state, cpu.points().len(), !plates.is_empty());
        let cells = || state[..cpu.points().len()].iter().map(|[.., cell]| *cell);
        let blocks = Blocks::of(&settings, cells());
        let sizes = BufferSizes::of(&settings, &blocks, cpu.points().len() as u64, !plates.is_empty());
        sizes.check(&device.device.limits())?;
        let lightest = cpu.points().velocity.iter().map(|v| v[3]).fold(f64::INFINITY, f64::min);
        let mut params = Params::of(&settings, &blocks, cpu.points().len(), lightest);
        params.plates = plates.len() as u32;
        if device.adapter.software {
            params.stride = blocks.stride();
        }
        params.extents = [1.0; 3];
        let laws: Vec<Law32> = cpu.laws().iter().map(Law32::from).collect();
        let status = Status { crossed: 1, slots: blocks.used, ..Status::default() };
        let storage = Usage::STORAGE | Usage::COPY_SRC;
        let buffers = device.allocate(sizes.sum(), || Buffers {
            params: device.buffer("params", bytemuck::bytes_of(&params), Usage::UNIFORM | Usage::COPY_DST),
            laws: device.buffer("laws", bytemuck::cast_slice(&laws), storage),
            state: device.buffer("state", bytemuck::cast_slice(&state), storage),
            nodes: device.empty("nodes", sizes.nodes, storage),
            starts: device.empty("starts", sizes.starts, storage),
            counts: device.buffer("counts", bytemuck::cast_slice(&blocks.counts(&settings, cells())), storage),
            blocks: device.buffer("blocks", bytemuck::cast_slice(&blocks.words()), storage),
            status: device.buffer("status", bytemuck::bytes_of(&status), storage | Usage::COPY_DST),
            touching: device.empty("touching", sizes.touching, storage),
            batch: device.empty("batch", sizes.batch, storage | Usage::COPY_DST),
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
            released: 0.0,
            at_once: FIRST,
            clock: None,
        };
        gpu.submit(&gpu.extent().prepare(), 1)?;
        gpu.read_results()?;
        Ok(gpu)
    }

    /// Computes `n` steps of `dt`, s.
    ///
    /// # Errors
    /// A point that has become unstable, with its step, as on the processor; a device that is lost or out of memory. The state on the device is then of no use.
    pub fn steps(&mut self, n: u64, dt: f64) -> Result<()> {
        self.batch(n, dt, 0.0)
    }

    /// Computes `n` steps, each of at most `dt`, s, and at most `safety` times the stable step for waves and the contacts of loading plates and grains together.
    /// With `safety` 0 each step is `dt`.
    ///
    /// # Errors
    /// As [`Self::steps`].
    pub fn batch(&mut self, n: u64, dt: f64, safety: f64) -> Result<()> {
        (self.params.dt, self.params.safety) = (dt as f32, safety as f32);
        self.params.steps = u32::try_from(n).unwrap_or(u32::MAX);
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
        let extent = self.extent();
        let step = extent.step();
        self.submit(&extent.begin(), 1)?;
        let rates = self.bodies.as_ref().map_or(1, |b| u64::from(b.coupling.rates));
        let mut flying = VecDeque::new();
        let mut since = Instant::now();
        let mut left = n;
        while left > 0 {
            let now = left.min((self.at_once / rates).max(1));
            left -= now;
            flying.push_back((self.submit(&step, now)?, now * rates));
            if flying.len() > AHEAD {
                let (oldest, steps) = flying.pop_front().expect("one");
                self.device.wait(Some(oldest), self.steps_done())?;
                let each = since.elapsed().as_secs_f64() / steps as f64;
                since = Instant::now();
                self.at_once = ((LONG / each) as u64).clamp(1, 2 * self.at_once).min(MOST);
            }
        }
        self.submit(&extent.survey(), 1)?;
        self.read_results()?;
        self.released = match &self.bodies {
            Some(bodies) => bodies.take_released(&self.device, self.steps_done())?,
            None => 0.0,
        };
        Ok(())
    }

    /// Writes the state and the counters into `cpu`, which must have the same points (by identity). The device keeps its state; a run resumed from `cpu` differs from
    /// it by rounding.
    ///
    /// # Errors
    /// `cpu` has other points; the device is lost. `cpu` is then unchanged.
    pub fn read_back(&self, cpu: &mut mpm::Continuum) -> Result<()> {
        let there = cpu.points().by_id();
        let same = |(&(id, _), &i): (&(u32, u32), &u32)| id == cpu.points().id[i as usize];
        if there.len() != self.by_id.len() || !self.by_id.iter().zip(&there).all(same) {
            return Err(refused("points", there.len(), "are not those that were copied to the device"));
        }
        let mut from = vec![0; there.len()];
        for ((_, i), to) in self.by_id.iter().zip(&there) {
            from[*to as usize] = *i;
        }
        let points = cpu.points_mut();
        let works = self.with_words(|bytes| state::to_points(&self.settings, bytemuck::cast_slice(bytes), &from, points))?;
        let work: f64 = there.iter().map(|to| works[*to as usize]).sum();
        cpu.set_counters(self.steps_done(), self.before.1 + work, self.wall_force());
        Ok(())
    }

    /// Copies the state as the device holds it.
    ///
    /// # Errors
    /// The device is lost.
    pub fn save(&self) -> Result<Saved> {
        let state = self.with_words(bytemuck::pod_collect_to_vec)?;
        let plates: &[u32] = bytemuck::cast_slice(&self.batch.plates);
        let grains = self.bodies.as_ref().map(|b| b.save(&self.device, self.steps_done())).transpose()?;
        Ok(Saved { layout: LAYOUT, state, plates: plates.to_vec(), work: self.before.1.to_bits(), grains })
    }

    /// What `take` makes of the planes of the points.
    fn with_words<T>(&self, take: impl FnOnce(&[u8]) -> T) -> Result<T> {
        self.device.with_parts(&[(&self.buffers.state, 0, self.sizes.state)], self.steps_done(), take)
    }

    /// Number of steps since the start of the run, those on the processor included.
    pub fn steps_done(&self) -> u64 {
        self.before.0 + u64::from(self.status.steps)
    }

    /// Force of each side of the domain on the material in the last step, N, in the order of [`Settings::walls`].
    pub fn wall_force(&self) -> [[f64; 3]; 6] {
        self.status.reaction.map(|[x, y, z, _]| [x, y, z].map(f64::from))
    }

    /// Memory on the device, bytes.
    pub fn bytes(&self) -> u64 {
        self.sizes.sum() + self.bodies.as_ref().map_or(0, Bodies::bytes)
    }

    /// What one step takes.
    pub fn step_work(&self) -> StepWork {
        StepWork::of(&self.extent(), self.bodies.as_ref().map_or(0, |b| b.mix.rows))
    }

    /// The adapter in use.
    pub fn adapter(&self) -> &Adapter {
        &self.device.adapter
    }

    /// The loading plates after the last batch, with the forces of the points on them.
    pub fn plates(&self) -> &[LoadingPlate] {
        &self.plates
    }

    /// Mean speed of the loading plate `k` under servo control, m/s.
    pub fn drift(&self, k: usize) -> f64 {
        self.batch.plates[k].drift.into()
    }

    /// Means over the last batch.
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

    /// Writes grains, their walls and all contacts into `mixture`, and the transport velocities of the points into `cpu`.
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

    /// For each point on the device its index in `cpu`.
    fn places(&self, cpu: &mpm::Continuum) -> Vec<u32> {
        let mut point = vec![0; self.by_id.len()];
        for ((_, i), to) in self.by_id.iter().zip(cpu.points().by_id()) {
            point[*i as usize] = to;
        }
        point
    }

    /// Where the last batch has ended within a step of the continuum, because a grain breaks: number of steps of the grains done in that step, and its length, s.
    pub fn within(&self) -> Option<(u32, f64)> {
        let bodies = self.bodies.as_ref().filter(|b| b.mix.sub > 0)?;
        Some((bodies.mix.sub, self.batch.dt.into()))
    }

    /// Adds to `cpu` the external forces that contacts with grains and walls have exerted on the points so far in the step that has begun.
    ///
    /// # Errors
    /// The device is lost.
    pub fn apply_point_forces(&self, cpu: &mut mpm::Continuum) -> Result<()> {
        let Some(bodies) = &self.bodies else { return Ok(()) };
        let point = self.places(cpu);
        for push in bodies.pushes(&self.device, self.steps_done())? {
            let (i, Settings { lower, cell, .. }) = (point[push.point as usize] as usize, &self.settings);
            let at = cpu.points().position[i];
            let beside = |a: usize| {
                let middle = ((at[a] - lower[a]) / cell + 0.5).floor();
                lower[a] + cell * (middle - 1.0 + push.node[a] as f64) - at[a]
            };
            cpu.add_force_beside(i, push.force, 0.0, [0, 1, 2].map(beside));
        }
        Ok(())
    }

    /// Writes position, speed, reaction, stiffness and work of the grains' walls at the end of the last batch into `mixture`.
    pub fn walls_of(&self, cpu: &mpm::Continuum, mixture: &mut Mixture) {
        if let Some(bodies) = &self.bodies {
            bodies.walls(cpu, mixture);
        }
    }

    /// Sets the number of steps of the grains in one step of the continuum, from the next batch on.
    pub fn rates(&mut self, grains: u32) {
        if let Some(bodies) = &mut self.bodies {
            bodies.coupling.rates = grains.max(1);
        }
    }

    /// At the end of the last batch: the stable step for the contacts between grains and with walls, s, and what the contacts of points with grains and loading plates
    /// add to the square of the frequency, 1/s² ([`ContactRates::frequency2`](crate::point_contacts::ContactRates::frequency2)).
    pub fn bounds(&self, plates: &[LoadingPlate]) -> (f64, f64) {
        self.bodies.as_ref().map_or((f64::INFINITY, 0.0), |bodies| bodies.bounds(plates))
    }

    /// Energy that contacts of points from breakages have gained in the last batch as their overlaps without force shrank, J.
    pub fn released(&self) -> f64 {
        self.released
    }

    /// Whether the last batch has ended early because a loading plate has passed a point, where points from breakages are taken out then. Further batches do nothing until
    /// [`Self::reload`] has been called.
    pub fn passed(&self) -> bool {
        self.bodies.as_ref().is_some_and(|b| b.row.has_fines()) && self.status.fault % 8 == PASSED && self.status.fault != u32::MAX
    }

    /// Whether the last batch has ended early because a grain fails. Further batches do nothing until [`Self::reload`] has been called.
    pub fn broken(&self) -> bool {
        self.bodies.as_ref().is_some_and(Bodies::broken)
    }

    /// Whether so many points are close to grains now, or so many blocks of the grid have come to points, that [`Self::reload`] should be called, which makes more room.
    pub fn crowded(&self) -> bool {
        let Params { slots, block_count, .. } = self.params;
        // only between batches, whose ends may not depend on what memory there is
        let few_slots = self.status.slots > slots / 4 * 3 && slots <= block_count;
        few_slots || self.bodies.as_ref().is_some_and(Bodies::crowded)
    }

    /// Smallest h/(c + |v|) over the points after the last batch, s, as [`mpm::Continuum::stable_step`].
    pub fn stable_step(&self) -> f64 {
        self.settings.cell / f64::from(f32::from_bits(self.status.fastest))
    }

    /// Sets how the loading plate `k` moves from the next batch on.
    ///
    /// # Errors
    /// There is no loading plate `k`.
    pub fn drive(&mut self, k: usize, drive: PlateDrive) -> Result<()> {
        let count = self.drives.len();
        let own = self.drives.get_mut(k).ok_or_else(|| refused("platen", k, format!("there are {count}, counted from 0")))?;
        *own = drive;
        Ok(())
    }

    /// Sets the extents of the material along each axis, m, from which loading plates that hold a stress compute their areas in the next batch. `plates`: along the
    /// axis of a loading plate its displacement since the batch began is subtracted, and its overlap added. Before the first call extents are 1 m, and fixed.
    pub fn material(&mut self, extents: [f64; 3], plates: [bool; 2]) {
        self.params.extents = extents.map(|x| x as f32);
        [self.params.follows, self.params.overlaps] = plates.map(f32::from);
    }

    /// Numbers of what the passes go through.
    fn extent(&self) -> Extent {
        let Params { points, slots, size, walls, .. } = self.params;
        let grains =
            self.bodies.as_ref().map(|b| GrainExtent { grains: b.coupling.grains, rows: b.coupling.rows, rates: b.coupling.rates });
        let size = size.map(|n| n as u32);
        let blocks = [self.status.slots, slots];
        let (walls, plates) = (walls.map(|wall| wall[0]), self.plates.len() as u32);
        let several_laws = self.buffers.laws.size() > size_of::<Law32>() as u64;
        Extent { points, several_laws, blocks, size, walls, plates, grains }
    }

    /// From now on times the passes, which makes steps slower.
    ///
    /// # Errors
    /// The adapter has no timestamps.
    pub fn time_passes(&mut self) -> Result<()> {
        self.clock = Some(Clock::new(&self.device)?);
        Ok(())
    }

    /// What the passes have taken since [`Self::time_passes`] was called, in the order in which they first came.
    pub fn pass_times(&self) -> &[PassTime] {
        self.clock.as_ref().map_or(&[], |clock| &clock.taken)
    }

    /// Submits `times` times these dispatches to the device.
    fn submit(&mut self, dispatches: &[Dispatch], times: u64) -> Result<wgpu::SubmissionIndex> {
        let step = self.steps_done();
        if let Some(clock) = &mut self.clock {
            (0..times).try_for_each(|_| clock.run(&self.device, &self.passes, dispatches, step))?;
            return Ok(self.device.queue.submit([]));
        }
        let mut encoder = self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.passes.encode(&mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()), dispatches, times);
        Ok(self.device.queue.submit([encoder.finish()]))
    }

    /// Waits for the device and reads the results of the batch: status, loading plates, and grains. A fault of a point becomes an error.
    fn read_results(&mut self) -> Result<()> {
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
        if fault == u32::MAX || self.passed() {
            return match &self.bodies {
                Some(bodies) => bodies.check_grains(self.steps_done(), &self.device),
                None => Ok(()),
            };
        }
        let (id, fault) = (fault / 8, fault % 8);
        let crowded = format!(
            "has more than {} grains and walls close to it, for which the GPU has no room: use smaller cells, or continue on the processor",
            self.bodies.as_ref().map_or(0, |b| b.row.places)
        );
        let sort = format!(
            "lies in a cell with more than {CROWD} points, which the GPU cannot sort: use larger spacings, or the processor"
        );
        let what = match fault {
            0 => "has no finite position, velocity or stress: use a smaller time step and look at the law's parameters",
            1 => "has left the grid: enlarge the domain, put a wall there, or use a smaller time step",
            2 => "has passed more than one cell in a step: use a smaller time step",
            3 => "is turned inside out (volume not positive): use a smaller time step, a finer grid, or a stiffer law",
            // found after the step was counted
            PASSED => return Err(mpm::loading_plate::passed(self.steps_done(), id)),
            6 => &crowded,
            7 => {
                "has come close to a grain, or far from where it was, as more points have than the GPU has room for: continue on the processor"
            }
            _ => &sort,
        };
        let error = Error::Unstable { step: self.steps_done() + 1, what: format!("point {id} {what}"), grain: None };
        // from 6 on the run could go on on the processor: the device has no room
        Err(if fault < 6 { error } else { Error::Device(Box::new(error)) })
    }

    /// Destroys the device, as a driver does that resets it: every later call fails. For tests.
    pub fn lose(&self) {
        self.device.device.destroy();
    }

    /// The nodes of the domain: momentum and mass, velocity, and change of velocity. Some of the points must lie in their cells since the state was copied to the device.
    #[cfg(test)]
    pub(super) fn nodes(&self) -> [Vec<[f32; 4]>; 3] {
        let bytes = self
            .device
            .read(&[(&self.buffers.nodes, self.sizes.nodes), (&self.buffers.blocks, self.sizes.blocks)], 0)
            .expect("nodes");
        let (nodes, table) = bytes.split_at(self.sizes.nodes as usize);
        let (nodes, table): (Vec<[f32; 4]>, Vec<u32>) = (bytemuck::pod_collect_to_vec(nodes), bytemuck::pod_collect_to_vec(table));
        let [x, y, z] = self.settings.cells.map(|n| n + 3);
        [0, 1, 2].map(|plane| {
            (0..x * y * z)
                .map(|k| {
                    nodes[(plane * self.params.cells
                        + super::blocks::index(&self.settings, &table, [k % x, k / x % y, k / (x * y)]))
                        as usize]
                })
                .collect()
        })
    }
}
