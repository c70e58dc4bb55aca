//! Estimates size, time step and duration of a run of a continuum or mixture before it is started.

use super::duration::{Costs, growth};
use super::estimate::{Estimate, inertial_warning, share};
use super::memory;
use crate::error::Result;
use crate::machine::Pace;
use crate::model::Model;
use crate::model::continuum::{CoarseGrains, Fraction, Growth, MpmSpecimen, MpmTest, Test};
use crate::model::inertial::{self, InertialNumbers};
use crate::rig::continuum::{State, contact_rate};
use engine::dem::physics::Physics;
use engine::dem::physics::Stepping;
use engine::dem::stability;
use engine::grains::sphere_volume;
use engine::material::effective_modulus;
use engine::mpm::law::Law;
use engine::mpm::{Dimension, with_plates};
use serde::Serialize;
use std::f64::consts::PI;

/// Steps of the whole preparation of a grown specimen over those in which radii grow; measured 1.7 to 3.4.
const PRESSED: f64 = 2.5;
/// The bound of the time step where points and grains touch.
const TOUCHING: &str = "contacts of points and grains";
/// Steps of a scene whose rigid bodies fall on points later, over the steps with the time step of points alone; measured 3.4.
const BLOCKS: f64 = 3.0;
/// Steps of a test in which grains break throughout, over the steps with the time step before any breakage: light fragments and
/// points need smaller steps. Measured 6.5 with 1.1 breakages a grain, and 1.5 to 2.1 with one breakage in the middle of the
/// test.
const LIGHT: f64 = 5.0;
/// Time in which rigid bodies that are packed without contact come to rest under their first stress, in times of a wave through the specimen.
const CLOSING: f64 = 100.0;
/// Stress on the grains over the stress in the points alone under the same strain: grains are stiffer and touch each other.
/// Measured 4.5 with 60 % of the mass in grains.
const STIFFER: f64 = 3.0;
/// Axial strain per wave time above which a test is no longer quasi-static.
const FAST: f64 = 5e-4;

/// Size of a continuum.
#[derive(Clone, Debug, Serialize)]
pub struct Points {
    /// Number of points.
    pub points: usize,
    /// True: the specimen grows first, and the numbers of points and grains are estimates.
    pub grows: bool,
    /// True: grains or blocks may break, and how many will is not known before the run; times are those as if none did.
    pub without_breakages: bool,
    /// Cells of the grid along x, y and z.
    pub cells: [u32; 3],
    /// Points in a cell at the start.
    pub points_per_cell: u32,
    /// Rigid bodies that are no spheres, each described in words.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub blocks: Vec<String>,
    /// Inertial numbers of points and of coarse grains at the start of a test, with the inertia used.
    pub inertial_numbers: Option<[Option<f64>; 2]>,
    /// Memory on a graphics device, MB; `None` where no device can compute the scene.
    pub device_mb: Option<f64>,
    /// What a step takes there.
    pub device_step: Option<DeviceStep>,
    /// Why no graphics device can compute the scene.
    pub device_lacks: Option<String>,
}

/// What one step takes on a graphics device, with one step of the grains (`engine::gpu::StepWork` says how it is counted).
#[derive(Clone, Copy, Debug, Serialize)]
pub struct DeviceStep {
    /// Dispatches, each of which waits for the one before it.
    pub dispatches: u64,
    /// Read and written, MB.
    pub mb: f64,
    /// Operations with floating-point numbers, in millions.
    pub mflop: f64,
}

/// Memory on a graphics device, MB, and what a step takes there.
#[cfg(feature = "gpu")]
fn on_device(model: &Model, rig: &MpmTest) -> Result<(f64, DeviceStep)> {
    let needs = State::start(model, rig)?.on_device(model, rig, |settings, points, plates, coarse| {
        engine::gpu::needs(settings, points, plates, coarse, rig.counts())
    })?;
    let engine::gpu::Needs { bytes, step } = needs;
    let [memory, mb, mflop] = [bytes, step.bytes, step.flops].map(|n| 1e-6 * n as f64);
    Ok((memory, DeviceStep { dispatches: step.dispatches, mb, mflop }))
}

#[cfg(not(feature = "gpu"))]
fn on_device(_: &Model, _: &MpmTest) -> Result<(f64, DeviceStep)> {
    Err(crate::error::Error::input("gpu", "", None, "this program was built without the feature gpu"))
}

/// Estimates the run of a continuum or mixture on a machine of this pace.
pub fn estimate(model: &Model, rig: &MpmTest, pace: Option<Pace>) -> Estimate {
    let costs = Costs::new(model, pace);
    let d = if rig.settings.dimension == Dimension::Space { 3 } else { 2 };
    let [points, grains] = rig.counts();
    let waves = wave_step(rig);
    let law = |s: &MpmSpecimen| &rig.laws[usize::from(s.law)];
    let (bound, why) = match rig.specimen() {
        None => (waves, "a compression wave through a cell"),
        Some(s) if s.bed.is_some() => (f64::INFINITY, TOUCHING),
        Some(s) if points == 0 => (fines_step(model, rig, largest_stress(rig, s, law(s))), "contacts of the smallest grains"),
        Some(s) => {
            let inertia = rig.points_inertia * rig.points.velocity[0][3];
            let rate = contact_rate(rig.settings.dimension, s, inertia, largest_stress(rig, s, law(s)));
            let why = if rate > 4.0 / (waves * waves) { "the platens' contacts" } else { "a compression wave through a cell" };
            (with_plates(waves, rate, rig.settings.transfer), why)
        }
    };
    let (bound, why) = match coupled_bound(model, rig) {
        Some(coupled) if coupled < bound * (1.0 - 1e-9) => (coupled, TOUCHING),
        _ => (bound, why),
    };
    let dt = model.physics.stepping.dt.unwrap_or(model.physics.stepping.safety * bound);
    let steps = match &rig.test {
        Test::Free { duration: Some(t), .. } => (t / dt).ceil(),
        Test::Free { steps, .. } => steps.unwrap_or(0) as f64,
        Test::Oedometer(s) | Test::Triaxial { specimen: s, .. } => {
            // a wave takes strain_per_wave/rate
            let before = if s.bed.is_some() { CLOSING * s.strain_per_wave } else { 0.0 };
            ((before + s.axial_strain) / rate(rig, s) / dt).ceil()
        }
    };
    let mut warnings = crate::model::validity::warnings(&model.physics, rig);
    if let Some(s) = rig.specimen().filter(|s| s.bed.is_none()) {
        too_fast(rig, s, &mut warnings);
    }
    if let Some((s, bed)) = rig.specimen().and_then(|s| Some((s, s.bed?))) {
        let number = s.inertial_number(rate(rig, s), bed.stress).unwrap_or(0.0);
        inertial_warning("inertial number of the bodies under their first stress", number, &mut warnings);
    }
    let inertial = rig.specimen().and_then(|s| inertial::at_the_start(model, rig, rate(rig, s), s.stress));
    if let Some(InertialNumbers { points, coarse }) = inertial {
        inertial_warning("inertial number of the points", points, &mut warnings);
        inertial_warning("inertial number of the coarse grains", coarse.unwrap_or(0.0), &mut warnings);
    }
    let rates = rig.coarse.as_ref().and_then(|c| c.rates);
    warnings.extend(crate::model::validity::viscous(rig, dt / rates.map_or(1.0, |r| f64::from(r.continuum))));
    if model.physics.stepping.dt.is_some_and(|dt| dt > bound) {
        warnings.push(format!("stepping.dt_s is above what {why} allows, {bound:.3e} s: the run will be refused or stop"));
    }
    let touching = if why == TOUCHING { 1.0 } else { touching_later(rig) };
    let broken = broken(model, rig);
    let [points_on, grains_on] = [points as f64 + broken.points, grains as f64 + broken.grains];
    let bodies = rig.coarse.as_ref().map_or(0, |c| c.blocks.len());
    let cycle = match points {
        0 => costs.grains(grains_on) + bodies as f64 * costs.body,
        _ => points_on * costs.point + grains_on * costs.grain_among_points,
    };
    let preparation = growing(rig, costs);
    let seconds = costs.start + costs.figures + preparation + steps * touching * broken.steps * cycle;
    let device = model.spheres_only().and_then(|()| on_device(model, rig));
    Estimate {
        grains,
        grains_final: 0.0,
        seconds,
        preparation_seconds: preparation,
        figure_seconds: costs.figures,
        // twice the mean over the test
        memory_mb: 1e-6 * memory::needed(model, [2.0 * broken.grains, 2.0 * broken.points]),
        output: super::output::output(
            model,
            steps,
            points as f64 + grains as f64,
            (points + grains) as f64 + 2.0 * (broken.grains + broken.points),
        ),
        specimen: None,
        void_ratio_range: None,
        continuum: Some(Points {
            points,
            grows: rig.growth.is_some(),
            without_breakages: model.physics.crush.is_some() && rig.specimen().is_none_or(|s| s.bed.is_some()),
            cells: rig.settings.cells,
            points_per_cell: rig.per_edge.pow(d as u32),
            blocks: rig.coarse.iter().flat_map(|c| (0..c.blocks.len()).map(|k| block_in_words(model, c, k))).collect(),
            inertial_numbers: inertial.map(|i| [Some(i.points), i.coarse]),
            device_mb: device.as_ref().ok().map(|(mb, _)| *mb),
            device_step: device.as_ref().ok().map(|(_, step)| *step),
            device_lacks: device.err().map(|e| e.to_string().replace('\n', "; ")),
        }),
        crushing_stress: None,
        time_step: Some(dt),
        time_step_limit: match why {
            _ if model.physics.stepping.dt.is_some() => "stepping.dt_s".into(),
            TOUCHING if points == 0 => "contacts of bodies and grains".into(),
            _ => why.into(),
        },
        steps,
        steps_expected: steps * touching * broken.steps,
        pace,
        warnings,
    }
}

/// Axial strain rate, 1/s.
fn rate(rig: &MpmTest, s: &MpmSpecimen) -> f64 {
    if let Some(bed) = s.bed {
        let height = s.size[if rig.settings.dimension == Dimension::Space { 2 } else { 1 }];
        return s.strain_per_wave / height * (bed.modulus / s.density).sqrt();
    }
    let (d, law) = (if rig.settings.dimension == Dimension::Space { 3 } else { 2 }, &rig.laws[usize::from(rig.points.law[0])]);
    s.strain_per_wave / (s.size[d - 1] / (law.under(s.stress).oedometric() / rig.points.density(0)).sqrt())
}

/// Warns of a test that strains too much in the time of a wave, which takes longer with more inertia.
fn too_fast(rig: &MpmTest, s: &MpmSpecimen, warnings: &mut Vec<String>) {
    let (per_wave, slower) = (s.strain_per_wave, rig.points_inertia.sqrt());
    if slower == 1.0 && per_wave > FAST {
        warnings.push(format!("test.strain_per_wave = {per_wave}: quasi-static loading keeps below {FAST}"));
    } else if per_wave * slower > FAST {
        warnings.push(format!(
            "test.strain_per_wave = {per_wave}: with stepping.points_inertia = {} a wave takes {slower:.1} times as long, and the strain in that time is {:.1e}; quasi-static loading keeps below {FAST}",
            rig.points_inertia,
            per_wave * slower
        ));
    }
}

/// Largest step of a grown specimen without points, s: two contacts of its smallest grain bear the stress `stress`, Pa, on its
/// section; not more than the free step of its grains.
fn fines_step(model: &Model, rig: &MpmTest, stress: f64) -> f64 {
    let Some(growth) = rig.growth else { return f64::INFINITY };
    let Fraction { material, radii: [r, _], .. } = growth.fines;
    let all = [Some(growth.fines), growth.coarse].into_iter().flatten();
    // the safety of steps is not counted in it
    let free = stability::rayleigh_of(&model.physics, all.map(|f| (2.0 * f.radii[0], f.material))) / model.physics.stepping.safety;
    let material = &model.physics.materials[usize::from(material)];
    let stiffness = 2.0 * share(model.physics.contact.law, material, r, stress * PI * r * r);
    free.min(2.0 / (stiffness / (material.density * sphere_volume(r))).sqrt())
}

/// Factor on the number of steps for rigid bodies that touch points only later in the run.
fn touching_later(rig: &MpmTest) -> f64 {
    let falls = rig.specimen().is_none() && rig.coarse.as_ref().is_some_and(|c| !c.blocks.is_empty());
    if falls { BLOCKS } else { 1.0 }
}

/// The effect of breakages on a test, as a mean over its duration.
struct Broken {
    /// Steps over those of a test without breakages.
    steps: f64,
    /// Points that are added.
    points: f64,
    /// Grains that are added.
    grains: f64,
}

/// Estimates the breakages by the stress between the platens. In a scene without platens no grain is expected to break.
fn broken(model: &Model, rig: &MpmTest) -> Broken {
    let none = Broken { steps: 1.0, points: 0.0, grains: 0.0 };
    let (Some(crush), Some(specimen)) = (&model.physics.crush, rig.specimen()) else { return none };
    // number of grains, diameter of one in the middle, volume of all
    let (count, middle, volume) = match (&rig.growth, &rig.coarse) {
        (Some(Growth { coarse: Some(coarse), .. }), _) => {
            let (count, d) = (coarse.count() as f64, coarse.mean_diameter());
            (count, d, count * sphere_volume(0.5 * d))
        }
        (None, Some(coarse)) if specimen.bed.is_none() => {
            let Some(middle) = coarse.grains.get(coarse.grains.len() / 2) else { return none };
            let (made, volume) = (coarse.grains.len() as f64, coarse.grains.iter().map(|g| sphere_volume(g.radius)).sum::<f64>());
            let count = made + rig.left_out[1] as f64;
            (count, 2.0 * middle.radius, volume * count / made)
        }
        _ => return none,
    };
    let stress = STIFFER * largest_stress(rig, specimen, &rig.laws[usize::from(specimen.law)]);
    let [mean, _] = growth(model, crush, &[middle], stress);
    let each = (mean - 1.0) / (crush.pattern.count() - 1) as f64;
    let lost = each * volume * (1.0 - crush.pattern.volume_kept());
    let rule = rig.coarse.as_ref().and_then(|c| c.fines);
    Broken {
        // with one breakage a grain at the end, half of the test has small steps on average
        steps: 1.0 + (LIGHT - 1.0) * (2.0 * each).min(1.0),
        points: rule.map_or(0.0, |rule| lost / rule.solid),
        grains: count * (mean - 1.0),
    }
}

/// Time in which a specimen grows, on one thread, s.
fn growing(rig: &MpmTest, costs: Costs) -> f64 {
    rig.growth.map_or(0.0, |g| PRESSED * g.steps as f64 * costs.grains(g.counts().iter().sum::<usize>() as f64))
}

/// Time of a compression wave through a cell, s, the speed of the points added to that of the wave: the largest step at the
/// start.
pub fn wave_step(rig: &MpmTest) -> f64 {
    let speed = |i: usize| {
        let p = &rig.points;
        rig.laws[usize::from(p.law[i])].wave_speed_at(rig.points_inertia * p.density(i), &p.stress[i], p.memory[i]) + speed(rig, i)
    };
    rig.settings.cell / (0..rig.points.len()).map(speed).fold(0.0, f64::max)
}

/// Largest step by the contacts between points and grains, s: from the contacts at the start; for a specimen that has to grow,
/// from one contact of a point with a grain under the largest stress, counted four times for the grain's other contacts.
fn coupled_bound(model: &Model, rig: &MpmTest) -> Option<f64> {
    rig.coarse.as_ref()?;
    let Some(growth) = &rig.growth else {
        let stepping = Stepping { dt: None, ..model.physics.stepping };
        let model = Model { physics: Physics { stepping, ..model.physics.clone() }, ..model.clone() };
        return State::first_step(&model, rig).ok().map(|dt| dt / model.physics.stepping.safety);
    };
    let (specimen, of) = (rig.specimen()?, growth.coarse.filter(|_| growth.as_points)?);
    let [fine, grain] = [growth.fines, of].map(|f| &model.physics.materials[usize::from(f.material)]);
    let s =
        MpmSpecimen { modulus: effective_modulus((fine.young, fine.poisson), (grain.young, grain.poisson)), ..specimen.clone() };
    let stress = largest_stress(rig, specimen, &rig.laws[usize::from(specimen.law)]);
    let inertia = rig.points_inertia * rig.points.velocity.first()?[3];
    let rate = contact_rate(rig.settings.dimension, &s, inertia, stress);
    (rate > 0.0).then(|| (1.0 / rate).sqrt())
}

fn speed(rig: &MpmTest, i: usize) -> f64 {
    let [u, v, w, _] = rig.points.velocity[i];
    (u * u + v * v + w * w).sqrt()
}

/// Estimated largest stress on the platens, Pa.
fn largest_stress(rig: &MpmTest, s: &MpmSpecimen, law: &Law) -> f64 {
    match (&rig.test, law.yield_line(0.0)) {
        (Test::Triaxial { cell_pressure, .. }, Some(_)) => 3.0 * cell_pressure,
        (Test::Triaxial { cell_pressure, .. }, None) => cell_pressure + law.young() * s.axial_strain,
        _ => s.stress + law.under(s.stress).oedometric() * s.axial_strain,
    }
}

/// A line that describes body `k` for a reader, with what is done to it from outside and what joins it.
fn block_in_words(model: &Model, coarse: &CoarseGrains, k: usize) -> String {
    let joints = coarse.joints.iter().filter_map(|joint| {
        let to = joint.bond.partner(k as u32)?.map_or("the world".to_string(), |other| format!("block {other}"));
        Some(format!(", {} to {to}", joint.bond.kind.name()))
    });
    let done = coarse.programmes[k].in_words();
    [coarse.blocks[k].in_words(&model.physics), done].into_iter().chain(joints).collect()
}
