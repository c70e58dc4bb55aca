//! Estimates of a run before it is started: size, time step, duration, memory, and warnings. They are rough: orders of magnitude
//! for a person to judge.

use super::crushing::extremes;
use super::duration::strained_steps;
use super::specimen::height;
use crate::machine::Pace;
use crate::model::{self, Assembly, Compression, Model, Rig, Subject, Triaxial};
use crate::rig::grain_crushing::most_steps;
use engine::boundary::Drive;
use engine::breakage::CrushModel;
use engine::breakage::criterion::size_factor;
use engine::contact::{ContactLaw, TangentialUnloading};
use engine::dem::stability;
use serde::Serialize;
use std::f64::consts::PI;

/// Expected size, time step and duration of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    /// Grains at the start.
    pub grains: usize,
    /// Grains at the end, with those that breakages are expected to add; equal to `grains` without crushing, 0 for a continuum.
    pub grains_final: f64,
    /// Time of preparation, test and figures on one thread, s.
    pub seconds: f64,
    /// Time of the preparation on one thread, s.
    pub preparation_seconds: f64,
    /// Time of the figures on one thread, s.
    pub figure_seconds: f64,
    /// Memory, MB.
    #[serde(rename = "memory_MB")]
    pub memory_mb: f64,
    /// Files that the run leaves.
    pub output: super::Output,
    /// Geometry of the cylindrical specimen, where there is one.
    pub specimen: Option<SpecimenEstimate>,
    /// Void ratios that the specimen can have; set by the caller where they are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub void_ratio_range: Option<super::Reach>,
    /// Size of the continuum, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub continuum: Option<super::continuum_estimate::Points>,
    /// Time step, s; `None` with scaled inertia, where time counts steps.
    #[serde(rename = "time_step_s")]
    pub time_step: Option<f64>,
    /// Crushing strength of a single grain as laboratories state it, where grains break.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crushing_stress: Option<super::crushing_estimate::CrushingStress>,
    /// What bounds the time step, in words.
    pub time_step_limit: String,
    /// Steps of the test; of a compression those of its programme alone.
    pub steps: f64,
    /// Steps of the test with those in which a programme is expected to wait.
    pub steps_expected: f64,
    /// Pace of the machine that the times follow; `None`: that of a fast one.
    pub pace: Option<Pace>,
    /// What the user should know before the run is started.
    pub warnings: Vec<String>,
}

/// Geometry of a cylindrical specimen, and its ratios to grain sizes.
#[derive(Clone, Debug, Serialize)]
pub struct SpecimenEstimate {
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Height, mm, at the target porosity.
    pub height_mm: f64,
    /// Target void ratio at the isotropic stress.
    pub void_ratio: f64,
    /// Diameter over the median grain size.
    pub diameter_over_d50: f64,
    /// Diameter over the largest grain size.
    pub diameter_over_largest: f64,
    /// Height over the largest grain size.
    pub height_over_largest: f64,
}

/// Estimates the run of `model` on a machine of this pace, on a fast one where it is not known.
pub fn estimate(model: &Model, pace: Option<Pace>) -> Estimate {
    let mut estimate = without_strength(model, pace);
    estimate.crushing_stress = super::crushing_estimate::crushing_stress(model);
    estimate.warnings.extend(estimate.crushing_stress.as_ref().and_then(|s| s.warning()));
    estimate.warnings.extend(super::breakable::none_breaks(model));
    estimate
}

/// What `check` says of the run of `model`, for its summary: steps, time on one thread of this machine without the figures, s, and memory,
/// MB; no time where nobody has measured the machine. `prepared`: the run begins with a specimen that is made already.
pub fn predicted(model: &Model, prepared: bool) -> [(&'static str, Option<f64>); 3] {
    let pace = Pace::known();
    let estimate = without_strength(model, pace);
    let without = estimate.figure_seconds + if prepared { estimate.preparation_seconds } else { 0.0 };
    [
        ("predicted_steps", Some(estimate.steps_expected)),
        ("predicted_seconds", pace.map(|_| estimate.seconds - without)),
        ("predicted_memory_MB", Some(estimate.memory_mb)),
    ]
}

/// The estimate without the crushing strength of single grains.
fn without_strength(model: &Model, pace: Option<Pace>) -> Estimate {
    let (smallest, largest) = extremes(&model.rig);
    let grains = match model.rig.subject() {
        Subject::Specimen(specimen) => specimen.grains,
        Subject::Assembly(a) => a.grains.len(),
        Subject::GrainCrushing(p) => p.diameters.len(),
        Subject::Continuum(rig) => return super::continuum_estimate::estimate(model, rig, pace),
    };
    let finest = match &model.physics.crush {
        Some(c) if c.d_limit < largest => smallest.min(c.pattern.smallest() * c.d_limit),
        _ => smallest,
    };
    let (time_step, time_step_limit) = time_step(model, finest);
    let stages = model.rig.compression().map_or_else(Vec::new, |rig| stage_steps(model, rig, time_step));
    let steps = match &model.rig {
        _ if !stages.is_empty() => stages.iter().sum::<f64>().ceil(),
        Rig::Triaxial(t) => shear_steps(model, t, time_step),
        Rig::Assembly(a) => match (a.steps, a.duration, time_step) {
            (Some(steps), ..) => steps as f64,
            (None, Some(t), Some(dt)) => (t / dt).ceil(),
            _ => 0.0,
        },
        Rig::GrainCrushing(p) => most_steps(p) * grains as f64,
        _ => 0.0,
    };
    let expected = super::duration::duration(model, grains, steps, &stages, time_step, pace);
    let mut estimate = Estimate {
        grains,
        grains_final: expected.grains,
        seconds: expected.seconds,
        preparation_seconds: expected.preparation,
        figure_seconds: expected.figures,
        memory_mb: 1e-6 * super::memory::needed(model, [expected.grains - grains as f64, expected.points]),
        output: super::output::output(model, steps, grains as f64, expected.grains),
        specimen: None,
        void_ratio_range: None,
        continuum: None,
        crushing_stress: None,
        time_step,
        time_step_limit,
        steps,
        steps_expected: expected.steps,
        pace,
        warnings: Vec::new(),
    };
    if let Some(s) = model.rig.specimen() {
        let specimen = specimen(s);
        size_warnings(&specimen, &mut estimate.warnings);
        if model.physics.damping == 0.0 && !model.physics.contact.law.is_viscous() {
            estimate.warnings.push("damping.local = 0: only sliding takes energy out of the specimen".into());
        }
        estimate.specimen = Some(specimen);
    }
    if let Rig::Triaxial(t) = &model.rig {
        inertial_warning("loading.inertial_number", t.shear.inertial_number, &mut estimate.warnings);
    }
    if let Some(o) = model.rig.compression() {
        quasi_static_warnings(model, o, &mut estimate);
        let never = unreached(o, &model.records.at);
        if !never.is_empty() {
            let more = if never.len() > NAMED { format!(" and {} more", never.len() - NAMED) } else { String::new() };
            let list = never[..never.len().min(NAMED)].join(", ") + &more;
            estimate.warnings.push(format!("records.at_kPa: {list} will not be reached"));
        }
        if !o.loading.stages.is_sorted() && model.physics.contact.unloading == TangentialUnloading::Keep {
            estimate.warnings.push(UNLOADING.into());
        }
    }
    if let Rig::GrainCrushing(p) = &model.rig {
        super::grain_crushing::warnings(model, p, &mut estimate.warnings);
    }
    if let Some(crush) = &model.physics.crush
        && crush.d_limit >= largest
    {
        estimate.warnings.push(format!(
            "nothing can break: the comminution limit is {:.4} mm and the largest grain {:.4} mm",
            1e3 * crush.d_limit,
            1e3 * largest
        ));
    }
    if let (Some(crush), Some(specimen)) = (&model.physics.crush, model.rig.specimen()) {
        estimate.warnings.extend(weak_from_the_start(model, crush, specimen));
    }
    estimate
}

/// Share of grains too weak for the isotropic stress from which on a scene is warned.
const TOO_WEAK: f64 = 1e-3;

/// A warning with the share of grains of median size that are weaker than the force on them in the prepared specimen, stress
/// times d².
fn weak_from_the_start(model: &Model, crush: &CrushModel, specimen: &model::Specimen) -> Option<String> {
    let d = median(&specimen.gradation);
    let pair = model.physics.contact.law.between(&model.physics.materials[0], &model.physics.materials[0]);
    let mean = crush.strength.sigma_lim0 * size_factor(d, crush.strength.d0, crush.strength.m);
    let share = specimen.isotropic_stress * d * d / crush.criterion.limit_force(mean, d, 0.25 * d, pair.e_eff);
    // force goes with strength, or with its cube
    let ratio = if crush.criterion.power() == 3 { share.cbrt() } else { share };
    let weak = crush.strength.share_weaker(ratio);
    (weak > TOO_WEAK).then(|| {
        let enough = crush.strength.min_ratio_for(ratio);
        format!(
            "{:.1} % of the grains are drawn weaker than the prepared specimen's own stress of {} kPa (below {ratio:.2} of the mean at their size): they break at the first \
             step of loading, far above their limit; raise material.strength.min_ratio to {enough:.2} or more, or lower var",
            100.0 * weak,
            1e-3 * specimen.isotropic_stress
        )
    })
}

/// Stresses that a warning names.
const NAMED: usize = 10;

const UNLOADING: &str = "loading.stages_kPa unload the specimen, and a tangential force that is kept on unloading creates energy; \
                         contact.unloading = \"rescale\" does not";

/// Stresses, kPa, of `at` that the loading does not pass.
fn unreached(o: &Compression, at: &[f64]) -> Vec<String> {
    let stages = o.loading.stages.iter().copied();
    let low = stages.clone().fold(o.specimen.isotropic_stress, f64::min);
    let high = stages.fold(0.0, f64::max);
    let outside = at.iter().filter(|s| !(low..=high).contains(*s));
    outside.map(|s| format!("{}", 1e-3 * s)).collect()
}

fn specimen(o: &model::Specimen) -> SpecimenEstimate {
    let height = height(o);
    let largest = o.gradation.last().map_or(f64::NAN, |p| p.0);
    SpecimenEstimate {
        diameter_mm: 1e3 * o.diameter,
        height_mm: 1e3 * height,
        void_ratio: o.porosity / (1.0 - o.porosity),
        diameter_over_d50: o.diameter / median(&o.gradation),
        diameter_over_largest: o.diameter / largest,
        height_over_largest: height / largest,
    }
}

pub(crate) fn median(points: &[(f64, f64)]) -> f64 {
    let half = points.windows(2).find(|w| w[1].1 >= 0.5);
    half.map_or(f64::NAN, |w| w[0].0 + (0.5 - w[0].1) / (w[1].1 - w[0].1) * (w[1].0 - w[0].0))
}

fn size_warnings(s: &SpecimenEstimate, warnings: &mut Vec<String>) {
    let small = 10.0 * (1.0 - 1e-9);
    if s.diameter_over_largest < small {
        warnings.push(format!(
            "the specimen is {:.1} largest grains wide (d50: {:.1}); below 10 it may no longer be representative (the paper keeps one order of magnitude)",
            s.diameter_over_largest, s.diameter_over_d50
        ));
    }
    if s.height_over_largest < 5.0 {
        warnings.push(format!(
            "the specimen is {:.1} largest grains high; below 5 the platens order the grains",
            s.height_over_largest
        ));
    }
}

fn quasi_static_warnings(model: &Model, o: &Compression, estimate: &mut Estimate) {
    let l = &o.loading;
    // increment at 50 kPa over the stress; the thresholds of quasi-static loading hold above that
    let s = 50e3 / l.sigma_ref;
    let (key, value, jump) = match l.load_increment {
        Some(load_increment) => ("loading.pace", load_increment, load_increment),
        None => ("loading.rate", l.rate, l.rate * (1.0 + s.ln()) / s),
    };
    let warnings = &mut estimate.warnings;
    if jump > 0.02 {
        warnings.push(format!(
            "{key} = {value}: at 50 kPa one increment is {:.1} % of the stress; quasi-static loading keeps within 2 %",
            100.0 * jump
        ));
    } else if l.load_increment.is_none() && l.rate > 0.1 {
        warnings.push(format!("loading.rate = {} is above 0.1, the largest that the paper uses", l.rate));
    }
    inertial_warning("loading.max_inertial_number", l.max_inertial_number, warnings);
    if let Some(dt) = estimate.time_step {
        // a strain of 0.3 over the whole loading
        let duration = estimate.steps * dt;
        let size = o.specimen.gradation.last().map_or(0.0, |p| p.0);
        let density = model.physics.materials.first().map_or(0.0, |m| m.density);
        let inertial = 0.3 / duration * size * (density / 50e3).sqrt();
        if inertial > 1e-3 {
            warnings.push(format!(
                "not quasi-static: {:.3} s of loading give an inertial number near {inertial:.1e} at 50 kPa, above 0.001; set stepping.inertia_scaling = true, or lower loading.rate",
                duration
            ));
        }
    }
}

/// Steps of each loading stage by eq. (18): the increment is L_C (sigma_ref + sigma_ref ln(sigma/sigma_ref)); of an adaptive
/// programme, if nothing held it back; where first loading is by strain, those in which the platen goes so far.
fn stage_steps(model: &Model, o: &Compression, time_step: Option<f64>) -> Vec<f64> {
    let l = &o.loading;
    let of = |from: f64, to: f64| {
        if let Some(load_increment) = l.load_increment {
            // isotropic compression has no reference stress
            return (to / from).ln().abs() / load_increment;
        }
        let (a, b) = ((from / l.sigma_ref).ln(), (to / l.sigma_ref).ln());
        simpson(|u: f64| u.exp() / (l.rate * (1.0 + u)), a.min(b), a.max(b))
    };
    let stage = |(k, &to): (usize, &f64)| {
        let from = if k == 0 { o.specimen.isotropic_stress } else { l.stages[k - 1] };
        let before = l.before(k).max(o.specimen.isotropic_stress);
        match l.strain_controlled {
            Some(inertial) if to > before => {
                of(from, before) + strained_steps(model, o, inertial, [before, to], time_step.unwrap_or(1.0))
            }
            _ => of(from, to),
        }
    };
    l.stages.iter().enumerate().map(stage).collect()
}

/// Steps of shear at the inertial number asked for.
fn shear_steps(model: &Model, t: &Triaxial, time_step: Option<f64>) -> f64 {
    let strain_time =
        t.shear.axial_strain / t.shear.inertial_number * rearrangement(model, &t.specimen, t.specimen.isotropic_stress);
    (strain_time / time_step.unwrap_or(1.0)).ceil()
}

/// Time scale d √(ρ/p) in which grains of a specimen are rearranged under a stress, s. With scaled inertia it is counted in
/// steps, and follows from the inertia for which a step is stable under contact forces of p d².
pub(super) fn rearrangement(model: &Model, specimen: &model::Specimen, p: f64) -> f64 {
    let d = median(&specimen.gradation);
    let Some(material) = model.physics.materials.first() else { return 0.0 };
    if model.physics.stepping.inertia_scaling {
        // m = Σ k dt²/ω² with some six contacts
        let stiffness = 3.0 * share(model.physics.contact.law, material, 0.5 * d, p * d * d);
        (stiffness / (p * d)).sqrt()
    } else {
        d * (material.density / p).sqrt()
    }
}

/// Warns of an inertial number beyond that of quasi-static loading (Li et al. 2023, eq. 42).
pub(super) fn inertial_warning(key: &str, value: f64, warnings: &mut Vec<String>) {
    if value > 1e-3 {
        let rounded = (1e6 * value).round() / 1e6;
        warnings.push(format!("{key} = {rounded}: quasi-static loading keeps below 0.001"));
    }
}

fn simpson(f: impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    const N: usize = 2000;
    let h = (b - a) / N as f64;
    let inner = (1..N).map(|i| f(a + i as f64 * h) * if i % 2 == 1 { 4.0 } else { 2.0 });
    (f(a) + inner.sum::<f64>() + f(b)) * h / 3.0
}

/// Time step, s, and what limits it.
fn time_step(model: &Model, finest: f64) -> (Option<f64>, String) {
    if model.physics.stepping.inertia_scaling {
        let text = "inertia scaled: every grain has the same stable step, and time counts steps";
        return (None, text.into());
    }
    if let Some(dt) = model.physics.stepping.dt {
        return (Some(dt), "stepping.dt_s".into());
    }
    let r = 0.5 * finest;
    let (load, why) = load(model, r);
    let m = model.physics.materials.iter().map(|m| m.density).fold(f64::INFINITY, f64::min) * 4.0 / 3.0 * PI * r * r * r;
    let share =
        model.physics.materials.iter().map(|material| share(model.physics.contact.law, material, r, load)).fold(0.0, f64::max);
    // two contacts bear the load
    let dt = model.physics.stepping.safety * 2.0 / (2.0 * share / m).sqrt();
    let resolved = stability::rayleigh_of(&model.physics, listed(model, finest));
    if resolved < dt {
        return (
            Some(resolved),
            format!("a share of the Rayleigh step of the smallest grain ({:.4} mm) or of the stiffest", 1e3 * finest),
        );
    }
    let text = format!("stiffness of contacts of the smallest grain ({:.4} mm), {why}", 1e3 * finest);
    (Some(dt), text)
}

/// Diameters and materials of the grains that bound a step: those that a scene lists, and the finest that there can be.
fn listed(model: &Model, finest: f64) -> Vec<(f64, u8)> {
    let own = match &model.rig {
        Rig::Assembly(a) => a.grains.iter().map(|g| (2.0 * g.radius, g.material)).collect(),
        _ => Vec::new(),
    };
    let broken = model.physics.crush.is_some() || own.is_empty();
    own.into_iter().chain(broken.then_some((finest, 0))).collect()
}

/// max(2 k_n, 7 k_t), N/m, of a contact of two grains of radius `r` under `force`: what bounds the step.
pub(super) fn share(law: ContactLaw, material: &engine::material::Material, r: f64, force: f64) -> f64 {
    let (r_eff, pair) = (0.5 * r, law.between(material, material));
    let overlap = law.overlap_under(force, r_eff, &pair);
    let elastic = law.elastic(overlap, overlap, r_eff, &pair);
    (2.0 * elastic.k_n).max(7.0 * elastic.k_t)
}

/// Force, N, that a contact of a grain of radius `r` may bear.
fn load(model: &Model, r: f64) -> (f64, String) {
    let section = PI * r * r;
    if let Some(stress) = model.rig.largest_stress() {
        return (stress * section, format!("its section under {} kPa", 1e-3 * stress));
    }
    match model.rig.subject() {
        Subject::GrainCrushing(_) | Subject::Continuum(_) | Subject::Specimen(_) => (0.0, "the force on a platen".into()),
        Subject::Assembly(a) => {
            let pressed = a.walls.iter().filter_map(|w| match w.drive {
                Drive::Stress { stress, .. } => Some(stress),
                _ => None,
            });
            let pressed = pressed.fold(0.0, f64::max) * section;
            let speed = speed(model, a);
            let struck = impact(model, r, speed);
            if struck >= pressed {
                (struck, format!("impact at {speed:.3} m/s"))
            } else {
                (pressed, "its section under the stress of a wall".into())
            }
        }
    }
}

/// Peak force, N, of two grains of radius `r` that meet at `speed` (Hertz), as a scale for every law.
fn impact(model: &Model, r: f64, speed: f64) -> f64 {
    let Some(material) = model.physics.materials.iter().max_by(|a, b| a.young.total_cmp(&b.young)) else {
        return 0.0;
    };
    let (r_eff, m_eff) = (0.5 * r, 0.5 * material.density * 4.0 / 3.0 * PI * r * r * r);
    let e_eff = material.young / (2.0 * (1.0 - material.poisson * material.poisson));
    if e_eff == 0.0 {
        return 0.0;
    }
    let k = e_eff * r_eff.sqrt();
    let overlap = (15.0 * m_eff * speed * speed / (16.0 * k)).powf(0.4);
    4.0 / 3.0 * k * overlap.powf(1.5)
}

/// Largest speed of approach that the scene can have, m/s; never zero.
fn speed(model: &Model, a: &Assembly) -> f64 {
    let norm = |v: [f64; 3]| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    let grains = a.grains.iter().map(|g| norm(g.velocity) + g.radius * norm(g.spin));
    let walls = a.walls.iter().map(|w| match w.drive {
        Drive::Velocity(v) => v.abs(),
        _ => 0.0,
    });
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for g in &a.grains {
        for k in 0..3 {
            low[k] = low[k].min(g.position[k] - g.radius);
            high[k] = high[k].max(g.position[k] + g.radius);
        }
    }
    let extent = norm([high[0] - low[0], high[1] - low[1], high[2] - low[2]]);
    let fall = (2.0 * norm(model.physics.gravity) * extent).sqrt();
    let moving = 2.0 * grains.fold(0.0, f64::max) + walls.fold(0.0, f64::max);
    (moving + fall).max(1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eq_18_takes_sixty_thousand_steps_to_5_mpa() {
        let mut sigma = 5.0_f64;
        let mut steps = 0.0;
        while sigma < 5000.0 {
            sigma += 0.01 * (1.0 + sigma.ln());
            steps += 1.0;
        }
        let f = |u: f64| u.exp() / (0.01 * (1.0 + u));
        let estimate = simpson(f, 5.0_f64.ln(), 5000.0_f64.ln());
        assert!((estimate / steps - 1.0).abs() < 1e-3, "{estimate} {steps}");
        assert!((5e4..7e4).contains(&steps));
    }
}
