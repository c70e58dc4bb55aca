//! The measures of a test for its records. Stresses on the loading plates and strains are means over the steps since the last
//! row; the shares of points and grains in the stress are means of the instants of both rows; energies are those of the present
//! instant.

use super::{MpmTest, Phase, State, dimensions};
use crate::model::continuum::Gate;
use ::engine::check::{self, Checked};
use ::engine::coupling::{Shares, Touching};
use ::engine::mpm::Totals;
use serde::{Deserialize, Serialize};

/// Sums over the steps since the last row.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Means {
    /// Number of steps.
    count: u64,
    /// Sums of the stresses on the sides, Pa.
    sides: [f64; 6],
    /// Sums of the extents, m.
    extents: [f64; 3],
    /// Stress in the material at the last row.
    borne: Option<Borne>,
}

/// Stress in the material at an instant. Computing it at every step would take too long.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Borne {
    /// As [`Moment::along_z`], Pa.
    along_z: f64,
    /// Parts of points, grains, and contacts between both.
    shares: Shares,
}

impl Means {
    /// Checks sums from a checkpoint.
    pub(super) fn check(&self) -> Checked {
        check::counters("steps", &[self.count])?;
        check::numbers("sums of stresses and extents", self.sides.iter().chain(&self.extents))?;
        let borne = self.borne.unwrap_or_default();
        let shares = [borne.shares.matrix, borne.shares.skeleton, borne.shares.interface];
        check::numbers("shares of the stress", shares.iter().flatten().chain([&borne.along_z]))
    }

    /// Adds `count` instants whose means are `sides` and `extents`.
    fn add(&mut self, count: u64, sides: [f64; 6], extents: [f64; 3]) {
        let times = count as f64;
        self.count += count;
        self.sides.iter_mut().zip(sides).for_each(|(sum, x)| *sum += times * x);
        self.extents.iter_mut().zip(extents).for_each(|(sum, x)| *sum += times * x);
    }
}

/// The measures of a test at an instant. Stresses Pa, compression positive; energies J; strains since the start of loading,
/// compression positive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    /// Axial strain.
    pub axial_strain: f64,
    /// Volumetric strain of the space between loading plates and walls.
    pub volumetric_strain: f64,
    /// Axial stress.
    pub axial: f64,
    /// Mean of the lateral stresses.
    pub lateral: f64,
    /// Largest difference of the stresses on opposite sides over their mean, -. The resultant accelerates the specimen; small is
    /// quasi-static.
    pub difference: f64,
    /// Mass, momentum, energies and volume of all points.
    pub totals: Totals,
    /// Mean stress of the points along z, weighted by volume (in plane strain the stress out of the plane).
    pub along_z: f64,
    /// Volume of pores over volume of solids, -: of a mixture all of it ([`GrainMeasures::void_ratio`]), else by the volumes of the points.
    pub void_ratio: f64,
    /// Mean and largest accumulated plastic strain of the points.
    pub plastic: [f64; 2],
    /// Work of the stresses in the points.
    pub stress_work: f64,
    /// Work of loading plates and walls.
    pub plate_work: f64,
    /// Work of what drives, holds and pushes rigid bodies; `None`: nothing does, or only holds some where they are.
    pub driven_work: Option<f64>,
    /// Change since the start of the elastic energy in the contacts of loading plates and grains.
    pub stored: f64,
    /// Energy given by loading plates, gravity, motion at the start and released overlaps, less the present kinetic energy,
    /// stress work and contact energy: taken by local damping, the transfer between points and nodes, wall friction, and errors.
    pub dissipated: f64,
    /// Sum of the magnitudes of the energies given: the scale for `dissipated`.
    pub scale: f64,
    /// Measures of the grains; `None`: there are none.
    pub grains: Option<GrainMeasures>,
}

/// Measures of the grains in a continuum at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GrainMeasures {
    /// Stress borne by points, by contacts between grains, and by contacts between grains and points.
    pub shares: Shares,
    /// Numbers of contacts and fabric.
    pub touching: Touching,
    /// Kinetic energy, J.
    pub kinetic: f64,
    /// Potential energy in gravity, J.
    pub potential: f64,
    /// Height of the lowest point of a grain, m.
    pub lowest: f64,
    /// Number of grains.
    pub count: usize,
    /// Number of rigid bodies that are no spheres.
    pub bodies: usize,
    /// Their mass, kg.
    pub body_mass: f64,
    /// Volume of the grains, m³.
    pub volume: f64,
    /// Mass of the grains, kg.
    pub mass: f64,
    /// Void ratio with all solids, grains, rigid bodies, points and what breakages have lost besides, -: of the space between the loading plates, in a
    /// free scene of the volume of points, grains and bodies.
    pub void_ratio: f64,
    /// Volume of pores over volume of solids by the volumes of the points, -; not a number without points.
    pub void_ratio_points: f64,
    /// Breakages so far.
    pub crush_events: u64,
    /// Steps of grains and of the continuum in one cycle.
    pub rates: [u32; 2],
    /// Points from breakages, where the lost mass becomes points.
    pub fines: Option<FromCrushing>,
}

/// Points from breakages at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FromCrushing {
    /// Number of points.
    pub points: u64,
    /// Mass that has become points, kg.
    pub entered: f64,
    /// Mass that waits for room, kg.
    pub reserve: f64,
    /// Mass of all points and grains, with `reserve`, kg.
    pub total: f64,
    /// Elastic energy of overlaps that were released when points were inserted, J.
    pub released: f64,
}

impl Moment {
    /// Share of all energy given that was dissipated, -; negative: energy came from nothing. 0 as long as none was given.
    pub fn dissipated_share(&self) -> f64 {
        if self.scale > 0.0 { self.dissipated / self.scale } else { 0.0 }
    }

    /// Deviatoric stress q = σ1 − σ3, Pa: axial less lateral stress.
    pub fn q(&self) -> f64 {
        self.axial - self.lateral
    }

    /// Mean stress (σ1 + 2 σ3)/3, Pa; in plane strain (`plane`) with the stress along z as the third one, and without points, where nothing has a stress across the plane,
    /// (σ1 + σ3)/2.
    pub fn p(&self, plane: bool) -> f64 {
        if plane && self.totals.mass == 0.0 {
            return 0.5 * (self.axial + self.lateral);
        }
        (self.axial + self.lateral + if plane { self.along_z } else { self.lateral }) / 3.0
    }
}

impl State {
    /// Adds the present instant to the means, and at the first call notes the energies at the start.
    pub(super) fn collect(&mut self, rig: &MpmTest) {
        let (sides, extents) = (self.sides(rig), self.extents_now(rig));
        self.means.add(1, sides, extents);
        if self.energy.is_none() {
            let (totals, [kinetic, potential, stored]) = (self.continuum.totals(), self.of_grains(rig));
            self.energy = Some([totals.kinetic + kinetic, totals.potential + potential, self.stored() + stored]);
        }
    }

    /// Adds the instants of a batch of steps on a graphics device; `extents` are those that [`State::material`] gave before the
    /// batch.
    #[cfg(feature = "gpu")]
    pub(super) fn add(&mut self, rig: &MpmTest, batch: &::engine::gpu::Means, mut extents: [f64; 3]) {
        for (plate, [way, overlap, _]) in self.plates.iter().zip(&batch.plates) {
            let overlap = if super::specimen::has_overlaps(rig) { *overlap } else { 0.0 };
            super::specimen::widen(&mut extents, plate, overlap - way);
        }
        // the last walls of the grains are the loading plates
        let first = batch.grains.len().saturating_sub(batch.plates.len());
        let of_grains = |wall: usize| batch.grains.get(wall).copied().unwrap_or(0.0);
        let on_plate = |k: usize| batch.plates[k][2] + of_grains(first + k);
        let sides = self.stresses(rig, extents, on_plate, |k| batch.sides[k] + of_grains(k));
        self.means.add(batch.steps, sides, extents);
    }

    /// Kinetic energy, potential energy and elastic contact energy of the grains, J.
    fn of_grains(&self, rig: &MpmTest) -> [f64; 3] {
        self.mixture.as_ref().map_or([0.0; 3], |m| m.energies(rig.settings.gravity))
    }

    /// Elastic energy of the loading plates' contacts, J.
    fn stored(&self) -> f64 {
        self.plates.iter().map(|p| p.stored).sum()
    }

    /// The measures for a row: means since the last call, and the present instant. Stresses in the material are the mean of the
    /// instants of both calls: else they would be half a row ahead of the mean stresses on the loading plates.
    pub fn moment(&mut self, rig: &MpmTest) -> Moment {
        let d = dimensions(rig);
        let means = std::mem::take(&mut self.means);
        let n = means.count.max(1) as f64;
        let mut moment = self.instant(rig);
        if rig.specimen().is_none() {
            return moment;
        }
        let now = Borne { along_z: moment.along_z, shares: moment.grains.map(|g| g.shares).unwrap_or_default() };
        let before = means.borne.unwrap_or(now);
        self.means.borne = Some(now);
        moment.along_z = 0.5 * (before.along_z + now.along_z);
        if let Some(grains) = &mut moment.grains {
            grains.shares = before.shares.midway(now.shares);
        }
        let axis = d - 1;
        let pair = |a: usize| [means.sides[2 * a] / n, means.sides[2 * a + 1] / n];
        let mean = |a: usize| 0.5 * (pair(a)[0] + pair(a)[1]);
        moment.axial = mean(axis);
        moment.lateral = (0..axis).map(mean).sum::<f64>() / axis as f64;
        let apart = |a: usize| if mean(a) == 0.0 { 0.0 } else { (pair(a)[1] - pair(a)[0]).abs() / mean(a).abs() };
        moment.difference = (0..d).map(apart).fold(0.0, f64::max);
        if self.phase != Phase::Settle {
            let left = |a: usize| means.extents[a] / n / self.extents[a];
            moment.axial_strain = 1.0 - left(axis);
            moment.volumetric_strain = 1.0 - (0..d).map(left).product::<f64>();
        }
        moment
    }

    /// Lets `read` take the measures for a row ([`Self::moment`]), and goes on as if it had not.
    pub fn aside<T>(&mut self, read: impl FnOnce(&mut State) -> T) -> T {
        let means = self.means.clone();
        let found = read(self);
        self.means = means;
        found
    }

    /// The measures of the present instant.
    fn instant(&self, rig: &MpmTest) -> Moment {
        let (c, points) = (&self.continuum, self.continuum.points());
        let totals = c.totals();
        let [mut solid, mut plastic, mut most, mut along_z] = [0.0; 4];
        for i in points.by_id().into_iter().map(|i| i as usize) {
            let volume = points.position[i][3];
            solid += (1.0 - points.initial_porosity[i]) * points.initial_volume[i];
            plastic += volume * points.memory[i].plastic;
            most = points.memory[i].plastic.max(most);
            along_z -= volume * points.stress[i][2];
        }
        let coarse = self.of_grains(rig);
        let now = [totals.kinetic + coarse[0], totals.potential + coarse[1], self.stored() + coarse[2]];
        let [kinetic, potential, stored] = self.energy.unwrap_or(now);
        // work of walls and loading plates on grains
        let on_grains: f64 = self.mixture.iter().flat_map(|m| &m.grains.walls).map(|w| w.work).sum();
        let plate_work = self.plates.iter().map(|plate| plate.work).sum::<f64>() + on_grains;
        let (fallen, stored) = (potential - now[1], now[2] - stored);
        let by_points = if points.is_empty() { f64::NAN } else { totals.volume / solid - 1.0 };
        let grains = self.mixture.as_ref().map(|m| {
            let g = &m.grains.grains;
            let (mass, volume) = g.mass_and_volume();
            // lost in breakages, and not in points since
            let lost = m.grains.lost.iter().map(|l| l.0).sum::<f64>() - m.fines.as_ref().map_or(0.0, |f| f.entered.mass);
            let lost_volume = if mass > 0.0 { lost * volume / mass } else { 0.0 };
            // pieces keep the mass of their body, and so its volume of solids
            let bodies = m.blocks.as_ref().map_or(0, |b| b.blocks.len());
            let body_mass = m.blocks.as_ref().map_or(0.0, |b| b.mass_and_momentum().0);
            let of_bodies = rig.coarse.as_ref().map_or(0.0, |c| c.block_volume);
            let box_volume = match rig.specimen() {
                Some(s) => s.fullness() * self.extents_now(rig).iter().product::<f64>(),
                None => totals.volume + volume + of_bodies,
            };
            GrainMeasures {
                shares: m.shares(c, box_volume),
                touching: m.touching(),
                kinetic: coarse[0],
                potential: coarse[1],
                lowest: g.pos.iter().map(|p| p[2] - p[3]).fold(f64::INFINITY, f64::min),
                count: g.len(),
                bodies,
                body_mass,
                volume,
                mass,
                void_ratio: box_volume / (solid + volume + lost_volume + of_bodies) - 1.0,
                void_ratio_points: by_points,
                crush_events: m.crush_events(),
                rates: [m.cycle.rates.grains, m.cycle.rates.continuum],
                fines: m.fines.as_ref().map(|f| FromCrushing {
                    points: f.points,
                    entered: f.entered.mass,
                    reserve: f.reserve.mass,
                    total: totals.mass + mass + f.reserve.mass,
                    released: f.released,
                }),
            }
        });
        let released = grains.and_then(|g| g.fines).map_or(0.0, |f| f.released);
        let driven_work = self.driven_work();
        let driven = driven_work.unwrap_or(0.0);
        let given = plate_work + fallen + kinetic + released + driven;
        let volume = totals.volume.max(f64::MIN_POSITIVE);
        Moment {
            grains,
            void_ratio: grains.map_or(by_points, |g| g.void_ratio),
            plastic: [plastic / volume, most],
            along_z: along_z / volume,
            stress_work: c.stress_work(),
            plate_work,
            driven_work,
            stored,
            dissipated: given - now[0] - c.stress_work() - stored,
            scale: plate_work.abs() + fallen.abs() + kinetic + released + c.stress_work().abs() + driven.abs(),
            totals,
            ..Moment::default()
        }
    }

    /// Work of what drives, holds and pushes rigid bodies, J.
    fn driven_work(&self) -> Option<f64> {
        self.mixture.as_ref()?.blocks.as_ref()?.given()
    }

    /// Kinetic energy of points and grains, the largest that it can be, and the sum of the magnitudes from which that follows, J. It can be all energy that
    /// points and grains had at the start (motion and elastic energy) and were given since by gravity, walls, loading plates and released overlaps.
    /// `None` before the first step.
    pub(crate) fn kinetic(&self, rig: &MpmTest) -> Option<[f64; 3]> {
        let [kinetic, potential, stored] = self.energy?;
        let (totals, coarse) = (self.continuum.totals(), self.of_grains(rig));
        let points = &rig.points;
        let elastic: f64 = (0..points.len())
            .map(|i| {
                let law = &rig.laws[usize::from(points.law[i])];
                points.position[i][3] * law.elastic_energy(&points.stress[i], points.memory[i])
            })
            .sum();
        let walls = self.mixture.iter().flat_map(|m| &m.grains.walls).map(|w| w.work);
        let ledger = self.mixture.iter().map(|m| &m.grains.ledger).flat_map(|l| [l.growth, l.inertia, l.release]);
        let released = self.mixture.iter().filter_map(|m| m.fines.as_ref()).map(|f| f.released);
        let given = self
            .plates
            .iter()
            .map(|p| p.work)
            .chain(walls)
            .chain(ledger)
            .chain(released)
            .chain(self.driven_work())
            .map(|w| w.max(0.0))
            .sum::<f64>();
        let fallen = potential - totals.potential - coarse[1];
        let own = kinetic + stored.max(0.0) + elastic + given;
        Some([totals.kinetic + coarse[0], own + fallen, own + fallen.abs()])
    }

    /// Largest horizontal distance from the axis of the first body, and largest height above the grid's floor, m.
    pub fn reach(&self, rig: &MpmTest) -> [f64; 2] {
        let (d, axis, lower) = (dimensions(rig), rig.axis, rig.settings.lower);
        self.continuum.points().position.iter().fold([0.0, f64::NEG_INFINITY], |[far, high], p| {
            let square: f64 = (0..d - 1).map(|a| (p[a] - axis[a]) * (p[a] - axis[a])).sum();
            [square.sqrt().max(far), (p[d - 1] - lower[d - 1]).max(high)]
        })
    }

    /// Mass of points, grains and rigid bodies beyond a plane, kg, in the order of their ids.
    pub fn passed(&self, gate: &Gate) -> f64 {
        let mass = |centre: [f64; 3], mass: f64| if gate.has_passed(centre) { mass } else { 0.0 };
        let points = self.continuum.points();
        let of_points = points.by_id().into_iter().map(|i| i as usize).map(|i| {
            let [x, y, z, _] = points.position[i];
            mass([x, y, z], points.velocity[i][3])
        });
        let of_others = self.mixture.iter().map(|mixture| {
            let g = &mixture.grains.grains;
            let grains = g.by_id().into_iter().map(|i| i as usize).map(|i| {
                let [x, y, z, _] = g.pos[i];
                mass([x, y, z], g.mass[i])
            });
            let blocks = mixture.blocks.iter().flat_map(|b| &b.blocks).map(|b| mass(b.centre, b.mass));
            grains.chain(blocks).sum::<f64>()
        });
        of_points.sum::<f64>() + of_others.sum::<f64>()
    }
}
