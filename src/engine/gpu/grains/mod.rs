//! Grains in a continuum on the device: their contacts with each other, with walls and with points, and their motion. The f64 twins are in `coupling`.
//!
//! A point close to a grain or a wall has a row, which has room for [`RowShape::places`] contacts. A grain has slots for [`PARTNERS`] contacts with grains and
//! one for each wall. Every contact keeps its tangential spring. Rows and slots list all candidates closer than a margin, the skin; the device makes the lists anew
//! before anything can have crossed the skin.
//!
//! A contact of a point also has a face ([`crate::point_contacts::GhostFace`]), which moves with the nodes; its force acts there (`faces.wgsl`).
//!
//! Results do not depend on the order in which threads run: sums of floating-point numbers are never made with atomic additions. A contact between two grains is
//! computed twice, by each of them, from the same numbers in the same order; and a grain sums up its contacts with points itself, over the cells around it.

pub(super) mod layout;
mod support;
mod words;

#[cfg(test)]
pub use layout::Side;
pub use layout::{Coupling, Mix, NONE, RowShape};
pub use support::{GrainBufferSizes, near_points, sizes};

use super::bounds::{PARTNERS, SIDES, SLOTS};
use super::device::{Device, refused};
use super::loading_plate::both;
use crate::contact::pair::Pair;
use crate::coupling::exchange::ExchangedContacts;
use crate::coupling::{Body, Mixture};
use crate::dem::physics::Physics;
use crate::dem::stability::rayleigh;
use crate::error::{Error, Result};
use crate::mpm::{Continuum as Cpu, LoadingPlate};
use crate::point_contacts::{ContactRates, GhostFace, PointContactTable};
use serde::{Deserialize, Serialize};
use wgpu::BufferUsages as Usage;
use words::{ContactWords, PointContactWords};

/// Width of the skin, cells: by how much further than contacts the lists of candidates reach.
pub const SKIN: f64 = 0.25;
/// [`GhostFace::FURTHEST`].
pub const FURTHEST: f32 = GhostFace::FURTHEST as f32;
/// Lengths in overlaps are below this many quanta ([`support::split`]), so that their squares can be summed exactly in 32-bit integers.
const WHOLE: f64 = 1000.0;

/// The grains that go to the device with a continuum, in a state in which the forces at their present positions have been computed.
#[derive(Clone, Copy)]
pub struct CoarseGrains<'a> {
    /// Materials, laws and options of the grains.
    pub physics: &'a Physics,
    /// State of the grains, and their contacts with points.
    pub mixture: &'a Mixture,
    /// Parameters of the contacts of points with grains and walls.
    pub table: &'a PointContactTable,
}

/// Buffers on the device; `contact.wgsl` says what they hold.
pub struct GrainBuffers {
    pub coupling: wgpu::Buffer,
    pub tables: wgpu::Buffer,
    pub grains: wgpu::Buffer,
    pub slots: wgpu::Buffer,
    pub rows: wgpu::Buffer,
    pub mix: wgpu::Buffer,
    pub lists: wgpu::Buffer,
    pub transport: wgpu::Buffer,
}

/// The grains on the device.
pub struct Bodies {
    pub buffers: GrainBuffers,
    pub coupling: Coupling,
    /// State as a whole after the last batch.
    pub mix: Mix,
    sizes: GrainBufferSizes,
    /// Shape of the rows of points.
    pub row: RowShape,
    points: usize,
    /// Work of each wall at the time the state was copied to the device, J.
    work: Vec<f64>,
    safety: f64,
}

/// The state of grains and of contacts in touch as the device holds it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SavedGrains {
    grains: Vec<u32>,
    mix: Vec<u32>,
    slots: Vec<u32>,
    rows: Vec<u32>,
    transport: Vec<u32>,
    work: Vec<u64>,
    /// Number of rows in use.
    rows_in_use: u32,
}

/// Grains, contacts of grains, contacts of points, and transport velocities of points, as words of 32 bits.
struct Words {
    grains: Vec<[u32; 4]>,
    slots: Vec<ContactWords>,
    rows: Vec<PointContactWords>,
    transport: Vec<[u32; 4]>,
}

impl Words {
    fn of(coarse: &CoarseGrains<'_>, cpu: &Cpu, split_at: u32) -> Words {
        let CoarseGrains { physics, mixture, .. } = coarse;
        let state = &mixture.grains;
        let table = physics.contact.law.pairs(&physics.materials, &state.walls, state.friction);
        let ExchangedContacts { grains, walls, points } = mixture.contacts(physics, &table);
        // a contact between two grains is kept by both
        let twice = grains
            .iter()
            .flat_map(|c| [words::contact_words(c.ends[0], c.ends[1], c), words::contact_words(c.ends[1], c.ends[0], c)]);
        let on_walls = walls.iter().map(|c| words::contact_words(c.ends[0], words::body(Body::Wall(c.ends[1])), c));
        let mut slots: Vec<ContactWords> = twice.chain(on_walls).collect();
        let cell = cpu.settings().cell;
        let mut rows: Vec<PointContactWords> =
            points.iter().map(|(body, c)| words::point_contact_words(c.ends[1], words::body(*body), c, cell)).collect();
        slots.sort_unstable_by_key(|words| (words[0], words[4]));
        rows.sort_unstable_by_key(|words| (words[0], words[4]));
        let bits = |v: [f64; 3]| {
            let [x, y, z] = v.map(|x| (x as f32).to_bits());
            [x, y, z, 0]
        };
        let transport = cpu.points().transport_velocity.iter().map(|v| bits(*v)).collect();
        Words { grains: words::grains(cpu.settings(), &state.grains, split_at), slots, rows, transport }
    }

    fn of_saved(saved: &SavedGrains, grains: usize, points: usize) -> Result<Words> {
        let fours = |words: &[u32]| words.chunks_exact(4).map(|w| [w[0], w[1], w[2], w[3]]).collect::<Vec<_>>();
        fn kept<const WORDS: usize>(words: &[u32], owners: usize) -> Option<Vec<[u32; WORDS]>> {
            let (all, rest) = words.as_chunks();
            (rest.is_empty() && all.iter().all(|w: &[u32; WORDS]| (w[0] as usize) < owners)).then(|| all.to_vec())
        }
        let own = (fours(&saved.grains), kept(&saved.slots, grains), kept(&saved.rows, points), fours(&saved.transport));
        match own {
            (g, Some(slots), Some(rows), transport) if g.len() == layout::GRAIN * grains && transport.len() == points => {
                Ok(Words { grains: g, slots, rows, transport })
            }
            _ => Err(refused(
                "state",
                saved.grains.len(),
                format!(
                    "words: this is the saved state of other grains or points than the {grains} grains and {points} points given"
                ),
            )),
        }
    }
}

impl Bodies {
    /// Copies the grains to the device, from `saved` where it is given. Contacts are copied with their forces, not computed anew.
    ///
    /// # Errors
    /// `saved` is the state of other grains; a grain or point has more contacts than there is room for; the memory is too small.
    pub fn new(
        device: &Device,
        cpu: &Cpu,
        coarse: &CoarseGrains<'_>,
        plates: usize,
        saved: Option<&SavedGrains>,
    ) -> Result<Bodies> {
        let CoarseGrains { physics, mixture, table } = coarse;
        let (settings, points, state) = (cpu.settings(), cpu.points(), &mixture.grains);
        let n = state.grains.len();
        let split_at = support::split(settings, &state.grains);
        let own = match saved {
            Some(saved) => Words::of_saved(saved, n, points.len())?,
            None => Words::of(coarse, cpu, split_at),
        };
        let near_points = {
            let mut all: Vec<u32> = mixture.point_contacts.candidates.iter().map(|g| g.point).collect();
            all.sort_unstable();
            all.dedup();
            all.len().max(saved.map_or(0, |saved| saved.rows_in_use as usize))
        };
        let row = RowShape::of(coarse);
        let sizes = GrainBufferSizes::of(settings, points, &state.grains, support::room(near_points, points.len()), row);
        sizes.check(&device.device.limits())?;
        let rows = sizes.room;
        let grid = support::grid(settings, points, &state.grains);
        let materials = physics.materials.len();
        let pairs = physics.contact.law.pairs(&physics.materials, &state.walls, state.friction);
        let laws = cpu.laws().len();
        let point_walls = table.touched_walls();
        let mut all: Vec<[f32; 4]> = Vec::new();
        let release = mixture.fines.as_ref().map_or(1.0, |fines| fines.rule.release_strain);
        let mut put = |p: &Pair, [residual, decay]: [f64; 2]| {
            all.push([p.normal_stiffness, p.tangential_stiffness, p.friction, p.viscous].map(|x| x as f32));
            all.push([p.e_eff, residual, decay, release].map(|x| x as f32));
        };
        let of = |n: usize| (0..n).map(|k| k as u8);
        of(materials).for_each(|a| of(materials).for_each(|b| put(pairs.grains(a, b), [0.0; 2])));
        let softening = |law| table.softening(law).map_or([0.0; 2], |s| [s.residual, s.decay]);
        of(laws).for_each(|law| of(materials).for_each(|m| put(table.of_grain(law, m), softening(law))));
        (0..state.walls.len()).for_each(|k| of(materials).for_each(|m| put(pairs.wall(k, m), [0.0; 2])));
        (0..point_walls).for_each(|k| of(laws).for_each(|law| put(table.of_wall(law, k), [0.0; 2])));
        let first = [materials * materials, laws * materials, state.walls.len() * materials];
        let starts = [first[0], first[0] + first[1], first[0] + first[1] + first[2], 0].map(|k| 2 * k as u32);
        let most = (0..points.len()).map(|i| super::state::ghost_radius(points, i)).fold(0.0, f64::max);
        let coupling = Coupling {
            grains: n as u32,
            rows: rows as u32,
            walls: state.walls.len() as u32,
            point_walls: point_walls as u32,
            materials: materials as u32,
            laws: laws as u32,
            split: split_at,
            law: physics.contact.law.on_gpu().expect("other laws are refused before"),
            rates: 1,
            turning: physics.contact.turning.into(),
            hertz_area: physics.crush.as_ref().is_some_and(|c| c.criterion.is_weighted()).into(),
            crushing: state.crushing.into(),
            skin: SKIN as f32,
            reach: (most / settings.cell) as f32,
            least: rayleigh(physics, &state.grains) as f32,
            damping: state.damping as f32,
            grid: grid.along,
            grid_cells: grid.along.iter().product::<i32>() as u32,
            grid_size: grid.size as f32,
            quantum: (settings.cell / f64::from(1_u32 << split_at)) as f32,
            fine: (1.0 / f64::from(1_u32 << (30 - split_at))) as f32,
            far: (1 << 10 >> split_at) + 2,
            tables: starts,
        };
        let mut mix = Mix {
            fresh: state.fresh.into(),
            bound_ratio: mixture.bound_ratio as f32,
            slow: physics.stepping.slow.into(),
            ..Mix::default()
        };
        let linked = state.walls.len() - plates.min(state.walls.len());
        for (k, (side, wall)) in mix.sides.iter_mut().zip(&state.walls).enumerate() {
            let plate = if k >= linked { (k - linked) as u32 } else { NONE };
            *side = words::side(settings, wall, plate);
        }
        let mut work: Vec<f64> = state.walls.iter().map(|w| w.work).collect();
        if let Some(saved) = saved {
            let words: &mut [u32] = bytemuck::cast_slice_mut(std::slice::from_mut(&mut mix));
            if words.len() != saved.mix.len() || work.len() != saved.work.len() {
                return Err(refused("state", saved.mix.len(), "words: this is not the saved state of a continuum with grains"));
            }
            words.copy_from_slice(&saved.mix);
            work = saved.work.iter().map(|w| f64::from_bits(*w)).collect();
        }
        // a row for each point with contacts
        let mut owners: Vec<[u32; 4]> = Vec::new();
        let mut transport = own.transport;
        for words in &mut transport {
            words[3] = NONE;
        }
        let mut in_rows = own.rows;
        for words in &mut in_rows {
            let point = words[0];
            if owners.last().is_none_or(|last| last[0] != point) {
                transport[point as usize][3] = owners.len() as u32;
                owners.push([point, 0, 0, 0]);
            }
            words[0] = owners.len() as u32 - 1;
        }
        (mix.rows, mix.crowded, mix.broken, mix.lost) = (owners.len() as u32, NONE, NONE, NONE);
        let furthest = in_rows.iter().map(words::beyond).fold(f32::from_bits(mix.furthest), f32::max);
        mix.furthest = furthest.to_bits();
        (mix.search, mix.contacts_known, mix.sub, mix.ahead) = (1, 1, 0, 0.0);
        let full = |most: Option<usize>, room, of| {
            most.map(|many| refused(of, many, format!("is above {room}, for which the GPU has room: use the processor")))
        };
        let on_grains: Vec<ContactWords> = own.slots.iter().filter(|words| words[4] < layout::WALLS).copied().collect();
        if let Some(error) = full(most_of(&in_rows, row.places), row.places, "contacts of a point with grains and walls")
            .or_else(|| full(most_of(&on_grains, PARTNERS), PARTNERS, "contacts of a grain with grains"))
        {
            return Err(error);
        }
        let mut row_words = words::spread(&in_rows, [row.planes, row.places, rows], |_, next| next);
        owners.resize(rows, [0; 4]);
        row_words.resize(row_words.len() + layout::NODES * rows, [0; 4]);
        row_words.extend(owners);
        let mut slot_words = words::spread(&own.slots, [layout::CONTACT, SLOTS, n], words::slot);
        slot_words.resize(layout::CONTACT * SLOTS * n.max(1), [0; 4]);
        let storage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        let mut grain_words = own.grains;
        grain_words.resize(layout::GRAIN * n.max(1), [0; 4]);
        let tables: &[u8] = bytemuck::cast_slice(&all);
        let buffers = device.allocate(sizes.sum(), || GrainBuffers {
            coupling: device.buffer("coupling", bytemuck::bytes_of(&coupling), Usage::UNIFORM | Usage::COPY_DST),
            tables: device.buffer("tables", if tables.is_empty() { &[0; 16] } else { tables }, Usage::STORAGE),
            grains: device.buffer("grains", bytemuck::cast_slice(&grain_words), storage),
            slots: device.buffer("slots", bytemuck::cast_slice(&slot_words), storage),
            rows: device.buffer("rows", bytemuck::cast_slice(&row_words), storage),
            mix: device.buffer("mix", bytemuck::bytes_of(&mix), storage),
            lists: device.empty("lists", sizes.lists, Usage::STORAGE),
            transport: device.buffer("transport", bytemuck::cast_slice(&transport), storage),
        })?;
        let (points, safety) = (points.len(), physics.stepping.safety);
        Ok(Bodies { buffers, coupling, mix, sizes, row, points, work, safety })
    }

    /// Memory on the device, bytes.
    pub fn bytes(&self) -> u64 {
        self.sizes.sum()
    }

    /// Writes the parameters of the next batch, and sets its sums to zero.
    pub fn prepare(&self, queue: &wgpu::Queue) {
        queue.write_buffer(&self.buffers.coupling, 0, bytemuck::bytes_of(&self.coupling));
        queue.write_buffer(&self.buffers.mix, std::mem::offset_of!(Mix, reactions) as u64, &[0; size_of::<[[f32; 2]; SIDES]>()]);
    }

    /// Whether a grain fails, to the accuracy of the device.
    pub fn broken(&self) -> bool {
        self.mix.broken != NONE
    }

    /// Whether so many rows are in use that they may not suffice for the next batch.
    pub fn crowded(&self) -> bool {
        2 * u64::from(self.mix.rows) > u64::from(self.coupling.rows) && (self.coupling.rows as usize) < self.points
    }

    /// Mean reaction of each wall over a batch of `steps` steps, N.
    pub fn reactions(&self, steps: u64) -> Vec<f64> {
        self.mix.reactions[..self.coupling.walls as usize].iter().map(|sum| both(*sum) / steps.max(1) as f64).collect()
    }

    /// See [`super::DeviceContinuum::bounds`].
    pub fn bounds(&self, plates: &[LoadingPlate]) -> (f64, f64) {
        let rates = ContactRates { points: f32::from_bits(self.mix.point_rate).into(), grains: self.mix.grain_rate_points.into() };
        let plates = plates.iter().map(|p| p.rate).fold(0.0, f64::max);
        let contacts = rates.frequency2(plates, (self.mix.slow != 0).then_some(self.mix.bound_ratio.into()));
        if self.coupling.grains == 0 {
            return (f64::INFINITY, contacts);
        }
        let own = if self.mix.grain_rate > 0.0 { 2.0 * self.safety / f64::from(self.mix.grain_rate).sqrt() } else { f64::INFINITY };
        (own.min(self.coupling.least.into()), contacts)
    }

    /// Checks that nothing has gone wrong with a grain.
    ///
    /// # Errors
    /// A grain has no finite velocity, passes a cell in a step, or has more grains close to it than there is room for; the device is lost.
    pub fn check_grains(&self, step: u64, device: &Device) -> Result<()> {
        let unstable = |place: u32, what: String| -> Result<Error> {
            let words = device.read(&[(&self.buffers.grains, self.sizes.grains)], step)?;
            let words: Vec<[u32; 4]> = bytemuck::pod_collect_to_vec(&words);
            let id = words[6 * self.coupling.grains as usize + place as usize][3];
            Ok(Error::Unstable { step, what, grain: Some(id.into()) })
        };
        if self.mix.lost != NONE {
            let what = "a grain has no finite velocity or passes a cell in a step: use a smaller time step".into();
            return Err(unstable(self.mix.lost, what)?);
        }
        if self.mix.crowded != NONE {
            let what =
                format!("a grain has more than {} grains close to it, for which the GPU has no room: use the processor", PARTNERS);
            return Err(Error::Device(Box::new(unstable(self.mix.crowded, what)?)));
        }
        Ok(())
    }

    /// Copies grains, contacts and transport velocities from the device; of the rows only those in use.
    fn read(&self, device: &Device, step: u64) -> Result<Words> {
        let (b, s, used) = (&self.buffers, &self.sizes, self.rows_in_use());
        let of_rows = self.parts_of_rows(0..self.row.planes * self.row.places);
        let mut parts = vec![(&b.grains, 0, s.grains), (&b.slots, 0, s.slots), (&b.transport, 0, s.transport)];
        let sizes = [s.grains, s.slots, s.transport].map(|size| size as usize / 16);
        parts.extend(of_rows);
        let n = self.coupling.grains as usize;
        device.with_parts(&parts, step, |bytes| {
            let mut rest: &[[u32; 4]] = bytemuck::cast_slice(bytes);
            let [grains, slots, transport] = sizes.map(|size| rest.split_off(..size).unwrap_or_default());
            let (of_contacts, owners) = rest.split_at(rest.len() - used);
            Words {
                grains: grains[..layout::GRAIN * n].to_vec(),
                slots: words::collect(slots, [layout::CONTACT, SLOTS, n], words::touches),
                rows: self.contacts_of_points(of_contacts, owners, words::is_kept),
                // threads took rows in no order
                transport: transport.iter().map(|[x, y, z, _]| [*x, *y, *z, 0]).collect(),
            }
        })
    }

    /// Number of rows in use.
    fn rows_in_use(&self) -> usize {
        self.mix.rows.min(self.coupling.rows) as usize
    }

    /// Parts of the buffer of rows, as [`Device::with_parts`] takes them: these arrays, each with a word for each row, and the owners; of each the rows in use.
    fn parts_of_rows(&self, arrays: std::ops::Range<usize>) -> impl Iterator<Item = (&wgpu::Buffer, u64, u64)> {
        let (room, size) = (16 * u64::from(self.coupling.rows), 16 * self.rows_in_use() as u64);
        arrays.chain([self.row.planes * self.row.places + layout::NODES]).map(move |k| (&self.buffers.rows, k as u64 * room, size))
    }

    /// The contacts of points that are to be kept, by point, then by body, of the words of the rows in use and their owners.
    fn contacts_of_points(
        &self,
        rows: &[[u32; 4]],
        owners: &[[u32; 4]],
        keeps: impl Fn(&PointContactWords) -> bool,
    ) -> Vec<PointContactWords> {
        let mut of_points = words::collect(rows, [self.row.planes, self.row.places, owners.len()], keeps);
        for words in &mut of_points {
            words[0] = owners[words[0] as usize][0];
        }
        // rows are in the order in which threads took them
        of_points.sort_unstable_by_key(|words| (words[0], words[4]));
        of_points
    }

    /// Copies the state as the device holds it.
    ///
    /// # Errors
    /// The device is lost.
    pub fn save(&self, device: &Device, step: u64) -> Result<SavedGrains> {
        let (words, mut mix) = (self.read(device, step)?, self.mix);
        let rows_in_use = mix.rows;
        // these are determined anew when the run is resumed
        (mix.rows, mix.travelled, mix.fastest_point, mix.fastest_grain, mix.point_speed) = (0, 0.0, 0, 0, 0.0);
        mix.largest_bound = 0;
        Ok(SavedGrains {
            grains: words.grains.concat(),
            mix: bytemuck::cast_slice(&[mix]).to_vec(),
            slots: words.slots.concat(),
            rows: words.rows.concat(),
            transport: words.transport.concat(),
            work: self.work.iter().map(|w| w.to_bits()).collect(),
            rows_in_use,
        })
    }

    /// Writes grains, walls and contacts into a mixture, and the transport velocities of points into `cpu`. `point`: for each point on the device its index in `cpu`;
    /// `dt`: last step of the grains, s.
    ///
    /// # Errors
    /// The device is lost.
    pub fn read_back(
        &self,
        (device, step): (&Device, u64),
        (physics, table): (&Physics, &PointContactTable),
        mixture: &mut Mixture,
        cpu: &mut Cpu,
        point: &[u32],
        dt: f64,
    ) -> Result<()> {
        let (words, mix) = (self.read(device, step)?, &self.mix);
        let viscous = physics.contact.law.is_viscous();
        let settings = cpu.settings().clone();
        for (k, i) in mixture.grains.grains.by_id().into_iter().enumerate() {
            words::to_grain(&settings, &words.grains, k, &mut mixture.grains.grains, i as usize);
        }
        for (k, wall) in mixture.grains.walls.iter_mut().enumerate() {
            words::to_wall(&settings, &mix.sides[k], self.work[k], wall);
        }
        let transport = &mut cpu.points_mut().transport_velocity;
        for (words, to) in words.transport.iter().zip(point) {
            transport[*to as usize] = [0, 1, 2].map(|a| f64::from(f32::from_bits(words[a])));
        }
        let mut contacts = ExchangedContacts::default();
        for words in &words.slots {
            let mut contact = words::contact(words, viscous);
            contact.ends = [words[0], words[4]];
            if words[4] >= layout::WALLS {
                contact.ends[1] -= layout::WALLS;
                contacts.walls.push(contact);
            } else if words[0] < words[4] {
                contacts.grains.push(contact);
            }
        }
        for words in &words.rows {
            let mut contact = words::point_contact(words, viscous, settings.cell);
            let body = words[4];
            contact.ends = [body, point[words[0] as usize]];
            let body = if body >= layout::WALLS { Body::Wall(body - layout::WALLS) } else { Body::Grain(body) };
            contacts.points.push((body, contact));
        }
        mixture.grains.fresh = mix.fresh != 0;
        (mixture.bound_ratio, mixture.isolated_bound) = (mix.bound_ratio.into(), Some(mix.isolated_bound.into()));
        mixture.take_contacts(physics, table, cpu, &contacts, dt);
        Ok(())
    }

    /// What contacts have pressed on the nodes of points so far in the step of the continuum that has begun, by point, then by node; the forces are divided by the
    /// number of steps of the grains in a full step.
    ///
    /// # Errors
    /// The device is lost.
    pub fn pushes(&self, device: &Device, step: u64) -> Result<Vec<words::Push>> {
        let first = self.row.planes * self.row.places;
        let parts: Vec<_> = self.parts_of_rows(first..first + layout::NODES).collect();
        let mut all = device.with_parts(&parts, step, |bytes| words::pushes(bytemuck::cast_slice(bytes), self.rows_in_use()))?;
        // rows are in the order in which threads took them
        all.sort_by_key(|push| push.point);
        let share = 1.0 / f64::from(self.coupling.rates);
        for push in &mut all {
            push.force = push.force.map(|f| share * f);
        }
        Ok(all)
    }

    /// Energy that contacts of points have gained as their overlaps without force shrank, J, since the last call.
    ///
    /// # Errors
    /// The device is lost.
    pub fn take_released(&self, device: &Device, step: u64) -> Result<f64> {
        if !self.row.has_fines() {
            return Ok(0.0);
        }
        let of_owners: Vec<_> = self.parts_of_rows(0..0).collect();
        let mut owners: Vec<[u32; 4]> = device.with_parts(&of_owners, step, |bytes| bytemuck::cast_slice(bytes).to_vec())?;
        let mut gains: Vec<(u32, f64)> = owners
            .iter()
            .map(|[point, _, high, low]| (*point, both([*high, *low].map(f32::from_bits))))
            .filter(|(_, x)| *x != 0.0)
            .collect();
        if gains.is_empty() {
            return Ok(0.0);
        }
        for [_, _, high, low] in &mut owners {
            (*high, *low) = (0, 0);
        }
        device.queue.write_buffer(&self.buffers.rows, of_owners[0].1, bytemuck::cast_slice(&owners));
        // rows are in the order in which threads took them
        gains.sort_unstable_by_key(|(point, _)| *point);
        Ok(gains.iter().map(|(_, x)| x).sum())
    }

    /// Writes the state of the walls alone into a mixture.
    pub fn walls(&self, cpu: &Cpu, mixture: &mut Mixture) {
        for (k, wall) in mixture.grains.walls.iter_mut().enumerate() {
            words::to_wall(cpu.settings(), &self.mix.sides[k], self.work[k], wall);
        }
    }
}

/// The largest number of contacts of one owner, where it is above `room`.
fn most_of<const WORDS: usize>(kept: &[[u32; WORDS]], room: usize) -> Option<usize> {
    kept.chunk_by(|a, b| a[0] == b[0]).map(<[_]>::len).max().filter(|many| *many > room)
}
