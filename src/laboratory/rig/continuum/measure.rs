//! What a test shows: stresses and strains as means since the last row, who bears them as mean of the instants of both rows, energies at this instant.

use super::{Phase, Rig, State, dimensions};
use ::engine::coupling::{Shares, Touching};
use ::engine::mpm::Totals;
use serde::{Deserialize, Serialize};

/// Sums over the steps since the last row.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Means {
    count: u64,
    sides: [f64; 6],
    extents: [f64; 3],
    /// What the material bore in that row's instant.
    borne: Option<Borne>,
}

/// What the material bears at an instant: too dear to be summed at each step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Borne {
    /// Pa, as [`Moment::along_z`].
    along_z: f64,
    shares: Shares,
}

impl Means {
    /// `count` instants with these means.
    fn add(&mut self, count: u64, sides: [f64; 6], extents: [f64; 3]) {
        let times = count as f64;
        self.count += count;
        self.sides.iter_mut().zip(sides).for_each(|(sum, x)| *sum += times * x);
        self.extents.iter_mut().zip(extents).for_each(|(sum, x)| *sum += times * x);
    }
}

/// An instant of a test. Stresses Pa, compression positive; energies J; strains since the start of loading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    pub axial_strain: f64,
    /// Of the space between loading plates and walls.
    pub volumetric_strain: f64,
    /// Axial stress, and mean of the lateral ones.
    pub axial: f64,
    pub lateral: f64,
    /// Largest difference of two opposite sides over their mean: the force that is left over accelerates the specimen.
    pub difference: f64,
    pub totals: Totals,
    /// Volume-weighted mean of the points' stress along z, Pa (the third principal stress in plane strain).
    pub along_z: f64,
    /// Pores over solids by the points' volumes.
    pub void_ratio: f64,
    /// Mean and largest accumulated plastic strain.
    pub plastic: [f64; 2],
    pub stress_work: f64,
    pub plate_work: f64,
    /// In the loading plates' contacts, since the start.
    pub stored: f64,
    /// What loading plates, gravity, motion and released overlaps gave and neither motion, stresses nor contacts have: taken by local damping, by the
    /// transfer between points and nodes, by wall friction, and by errors.
    pub dissipated: f64,
    /// Scale of all these.
    pub scale: f64,
    /// With grains: who bears the stress, how they touch, their kinetic energy, J, their lowest point, m, volume, m³, and what broke.
    pub grains: Option<Coarse>,
}

/// Of the grains in a continuum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coarse {
    pub shares: Shares,
    pub touching: Touching,
    pub kinetic: f64,
    pub lowest: f64,
    pub count: usize,
    pub volume: f64,
    pub mass: f64,
    /// Of all solids, grains and points, in the space between the loading plates, or in that of points and grains.
    pub void_ratio: f64,
    pub crush_events: u64,
    pub rates: [u32; 2],
    /// Where the mass that breakages lose becomes points.
    pub fines: Option<FromCrushing>,
}

/// Fines from crushing: how many points, masses that have entered, that wait, and of all there is, kg; energy from released overlaps, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FromCrushing {
    pub points: u64,
    pub entered: f64,
    pub reserve: f64,
    pub total: f64,
    pub released: f64,
}

impl Moment {
    /// Of all energy given.
    pub fn dissipated_share(&self) -> f64 {
        self.dissipated / self.scale.max(f64::MIN_POSITIVE)
    }

    /// q = σ1 − σ3 with the axial stress as σ1.
    pub fn q(&self) -> f64 {
        self.axial - self.lateral
    }

    /// (σ1 + 2 σ3)/3, or with the stress along z in plane strain.
    pub fn p(&self, plane: bool) -> f64 {
        (self.axial + self.lateral + if plane { self.along_z } else { self.lateral }) / 3.0
    }
}

impl State {
    /// Adds this instant to the means.
    pub(super) fn collect(&mut self, rig: &Rig) {
        let (sides, extents) = (self.sides(rig), self.extents_now(rig));
        self.means.add(1, sides, extents);
        if self.energy.is_none() {
            let (totals, [kinetic, potential, stored]) = (self.continuum.totals(), self.of_grains(rig));
            self.energy = Some([totals.kinetic + kinetic, totals.potential + potential, self.stored() + stored]);
        }
    }

    /// Adds the instants of a batch of steps on a device, which began with the extents that [`State::material`] gave.
    #[cfg(feature = "gpu")]
    pub(super) fn add(&mut self, rig: &Rig, batch: &::engine::gpu::Means, mut extents: [f64; 3]) {
        for (plate, [way, overlap, _]) in self.plates.iter().zip(&batch.plates) {
            extents[plate.axis()] += overlap - way;
        }
        // the last walls of the grains are the loading plates
        let first = batch.grains.len().saturating_sub(batch.plates.len());
        let of_grains = |wall: usize| batch.grains.get(wall).copied().unwrap_or(0.0);
        let on_plate = |k: usize| batch.plates[k][2] + of_grains(first + k);
        let sides = self.stresses(rig, extents, on_plate, |k| batch.sides[k] + of_grains(k));
        self.means.add(batch.steps, sides, extents);
    }

    /// Kinetic and potential energy of grains, and what their contacts hold, J.
    fn of_grains(&self, rig: &Rig) -> [f64; 3] {
        self.mixture.as_ref().map_or([0.0; 3], |m| m.energies(rig.settings.gravity))
    }

    fn stored(&self) -> f64 {
        self.plates.iter().map(|p| p.stored).sum()
    }

    /// Means since the last call, and this instant. What the material bears is the mean of the instants of both calls: else it would be half a row ahead of
    /// the stresses on the loading plates.
    pub fn moment(&mut self, rig: &Rig) -> Moment {
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

    /// What needs no mean.
    fn instant(&self, rig: &Rig) -> Moment {
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
        // walls of free scenes, and what loading plates do to grains
        let on_grains: f64 = self.mixture.iter().flat_map(|m| &m.grains.walls).map(|w| w.work).sum();
        let plate_work = self.plates.iter().map(|plate| plate.work).sum::<f64>() + on_grains;
        let (fallen, stored) = (potential - now[1], now[2] - stored);
        let grains = self.mixture.as_ref().map(|m| {
            let g = &m.grains.grains;
            let (mass, volume) = g.mass_and_volume();
            let box_volume = match rig.specimen() {
                Some(s) => s.fullness() * self.extents_now(rig).iter().product::<f64>(),
                None => totals.volume + volume,
            };
            Coarse {
                shares: m.shares(c, box_volume),
                touching: m.touching(),
                kinetic: coarse[0],
                lowest: g.pos.iter().map(|p| p[2] - p[3]).fold(f64::INFINITY, f64::min),
                count: g.len(),
                volume,
                mass,
                void_ratio: box_volume / (solid + volume) - 1.0,
                crush_events: m.grains.crush_events,
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
        let given = plate_work + fallen + kinetic + released;
        let volume = totals.volume.max(f64::MIN_POSITIVE);
        let overall = grains.map_or(0.0, |g| g.void_ratio);
        Moment {
            grains,
            void_ratio: if points.is_empty() { overall } else { totals.volume / solid - 1.0 },
            plastic: [plastic / volume, most],
            along_z: along_z / volume,
            stress_work: c.stress_work(),
            plate_work,
            stored,
            dissipated: given - now[0] - c.stress_work() - stored,
            scale: plate_work.abs() + fallen.abs() + kinetic + released + c.stress_work().abs(),
            totals,
            ..Moment::default()
        }
    }

    /// Largest horizontal distance from the axis of the first body, and largest height above the grid's floor, m.
    pub fn reach(&self, rig: &Rig) -> [f64; 2] {
        let (d, axis, lower) = (dimensions(rig), rig.axis, rig.settings.lower);
        self.continuum.points().position.iter().fold([0.0, f64::NEG_INFINITY], |[far, high], p| {
            let square: f64 = (0..d - 1).map(|a| (p[a] - axis[a]) * (p[a] - axis[a])).sum();
            [square.sqrt().max(far), (p[d - 1] - lower[d - 1]).max(high)]
        })
    }
}
