//! How long a run takes on one thread: the steps it is expected to make, times what a step of a grain and of a point takes, which
//! follows the machine's [`Pace`]. Meant to be within a factor of two; what a run waits for, and how many grains break, is known only
//! when it has been made.

use super::crushing::rigid_platens;
use super::estimate::{median, rearrangement};
use crate::machine::Pace;
use crate::model::continuum::{MpmTest, Test};
use crate::model::{Compression, Model, Rig, Specimen, Subject};
use crate::packing;
use engine::boundary::Drive;
use engine::breakage::CrushModel;
use engine::breakage::criterion::size_factor;
use engine::coupling::Embedding;
use engine::grains::sphere_volume;
use engine::math::random::lineage_root;
use engine::mpm::Dimension;

/// What parts of a run take on one thread, s: those of the yardstick times what such parts took beside it.
#[derive(Clone, Copy, Debug)]
pub struct Costs {
    /// Start of the program.
    pub start: f64,
    /// The figures.
    pub figures: f64,
    /// A step by itself.
    step: f64,
    /// A step of a grain with its contacts, of up to [`FEW`] grains.
    grain: f64,
    /// A step of a point.
    pub point: f64,
    /// A step of a grain that points touch: measured 2 to 8 times a step of a grain among grains, and 40 times for fragments smaller than
    /// points.
    pub grain_among_points: f64,
    /// A step of a rigid body that other bodies touch: a tower, an arch and rocks of `experiments/blocks` took 26 to 48 times a grain's
    /// yardstick.
    pub body: f64,
    /// A step in the test of a single grain between platens.
    platen: f64,
}

/// Grains whose steps all take the same time; that of more grows with their number to the power [`SLOWER_BY`], as they leave the
/// caches: 38, 68 and 125 ns with 5000, 50 000 and 500 000 grains on a quiet machine.
const FEW: f64 = 4000.0;
const SLOWER_BY: f64 = 0.25;

/// A step of a point over that of the yardstick: 1.1 to 1.4 in columns and boxes.
const POINT: f64 = 1.1;
/// What a step of a point takes more that a platen may touch, over the yardstick's: cubes of 16 and of 40 points along an edge took 0.7 and
/// 0.3 more for each of all their points.
const AT_PLATEN: f64 = 2.0;
/// A step of a point in plane strain, with 9 nodes about it, over that of one in space, with 27.
const PLANE: f64 = 0.5;
/// A step of a point among coarse grains over that of one in a soil of its own.
const MIXED: f64 = 1.2;

/// What a step of a point takes, over that of the yardstick.
fn point(rig: &MpmTest) -> f64 {
    let [points, grains] = rig.counts();
    let platens = match rig.test {
        Test::Free { .. } => 0.0,
        Test::Oedometer(_) => 2.0,
        Test::Triaxial { .. } => 6.0,
    };
    let touched = platens / (points as f64).cbrt().max(1.0);
    let plane = if rig.settings.dimension == Dimension::PlaneStrain { PLANE } else { 1.0 };
    plane * (POINT + AT_PLATEN * touched.min(1.0)) * if grains > 0 { MIXED } else { 1.0 }
}

impl Costs {
    /// Of a run of `model` on a machine of this pace, on a fast one where it is not known.
    pub fn new(model: &Model, pace: Option<Pace>) -> Costs {
        let pace = pace.unwrap_or(Pace::FAST);
        // features by `comminute bench features`; a grain took 1.2 to 2 times the yardstick's, the more the more contacts it has
        let without_ledger = if model.records.energy { 1.0 } else { 0.8 };
        let rolling = if model.physics.contact.rolling { 1.6 } else { 1.0 };
        let viscous = if model.physics.contact.law.is_viscous() { 1.2 } else { 1.0 };
        let figures = match model.rig.subject() {
            Subject::GrainCrushing(_) => 4e6,
            Subject::Assembly(_) => 7e6,
            Subject::Continuum(rig) if rig.counts()[1] > 0 => 3e7,
            Subject::Continuum(_) => 1.2e7,
            Subject::Specimen(_) => 2e7,
        };
        let point = if let Subject::Continuum(rig) = model.rig.subject() { point(rig) } else { POINT };
        Costs {
            start: 1e6 * pace.grain,
            figures: if model.records.figures { figures * pace.grain } else { 0.0 },
            step: 5.0 * pace.grain,
            grain: 1.7 * without_ledger * rolling * viscous * pace.grain,
            point: point * pace.point,
            grain_among_points: 20.0 * pace.grain,
            body: 40.0 * pace.grain,
            platen: 4.0 * pace.grain,
        }
    }

    /// A step of `n` grains, s.
    pub fn grains(&self, n: f64) -> f64 {
        self.step + n * self.grain * (n / FEW).max(1.0).powf(SLOWER_BY)
    }
}

/// Share of the mass lost in breakages that has become points: the rest waits for room. Measured 0.48 to 0.49.
const ENTERED: f64 = 0.5;

/// Steps of the whole preparation over those in which radii grow: on the way from loose to dense (measured 3 to 8).
const PREPARED_ON_PATH: f64 = 4.0;
/// The same with a stated friction while they grow (measured 4 to 38).
const PREPARED_WITH_FRICTION: f64 = 8.0;
/// The same with radii that grow without friction, whose specimens hardly come to rest: 7.7 to 22 in 20 specimens of coke H-C-2, median 14.
const PREPARED_WITHOUT_FRICTION: f64 = 14.0;
/// Axial strain of first loading under stress control without breakages, and with b breakages a grain: LEAST_STRAIN + MORE_STRAIN b^0.8; within a fifth in coke with 0.15 to 2.6 breakages a
/// grain.
const LEAST_STRAIN: f64 = 0.06;
const MORE_STRAIN: f64 = 0.25;
/// What a breakage a grain adds in strain, for as long as platens wait after breakages.
const WAITS: f64 = 0.55;
/// Strain of unloading and of reloading, for each e-fold of the stress: measured 0.0055 under isotropic stress.
const SWELLING: f64 = 0.0055;
/// Steps of an isotropic compression over those of an oedometer whose platen goes as far: platens and the wall around them wait for each
/// other. Measured 1.7 to 2.3 in three runs.
const ALL_SIDES: f64 = 1.9;
/// Steps over those in which a platen would go this way at the largest inertial number.
const SLOWER: f64 = 1.35;
/// Axial strain of an oedometer at its largest stress: measured 0.04 to 0.45.
const STRAIN: f64 = 0.15;
/// Mean largest force on a grain of diameter d over stress times d². The forces on grains of one size are taken as exponentially
/// distributed; the breakages per grain are then within a factor of 2.5 of those of seven tests, 0.02 to 2 a grain.
const BEARS: f64 = 2.3;
/// Draws of strength over which the expected number of breakages is averaged.
const DRAWS: u32 = 16;
/// Grains over which it is averaged.
const GRAINS: usize = 32;
/// Grains that are drawn to choose them from.
const SAMPLED: usize = 100_000;
/// Stresses over which it is averaged.
const STRESSES: u32 = 8;
/// Generations of daughters whose breakages are counted.
const GENERATIONS: u32 = 4;

/// Expected duration of a run of grains.
#[derive(Clone, Copy, Debug, Default)]
pub struct Duration {
    /// Time of the whole run on one thread, s.
    pub seconds: f64,
    /// Time of the preparation on one thread, s.
    pub preparation: f64,
    /// Time of the figures on one thread, s.
    pub figures: f64,
    /// Steps of the test, with those in which a programme waits.
    pub steps: f64,
    /// Grains at the end.
    pub grains: f64,
    /// Points at the end, where lost mass becomes points.
    pub points: f64,
}

/// Estimates the duration of a run of `grains` grains with `steps` steps of its test; `stages` are the steps of each stage of a
/// compression by its programme alone, `dt` the time step, s, where it is known.
pub fn duration(model: &Model, grains: usize, steps: f64, stages: &[f64], dt: Option<f64>, pace: Option<Pace>) -> Duration {
    let n = grains as f64;
    let costs = Costs::new(model, pace);
    let figures = costs.figures;
    let start = costs.start + figures;
    if let Rig::GrainCrushing(_) = model.rig {
        return Duration { seconds: start + steps * costs.platen, figures, steps, grains: n, ..Duration::default() };
    }
    let sizes = model.physics.crush.as_ref().and_then(|crush| Some((crush, sizes(model)?)));
    let [mean, last] = sizes.as_ref().map_or([1.0, 1.0], |(crush, sizes)| growth(model, crush, sizes, stress(model)));
    let broken = |stress: f64| sizes.as_ref().map_or(0.0, |(crush, sizes)| breakages(model, crush, sizes, stress));
    let of = |steps: f64, n: f64| steps * costs.grains(n);
    let points = match (&model.rig, &model.physics.crush) {
        (Rig::Oedometer(o), Some(crush)) => o.fines.as_ref().map_or(0.0, |fines| points(&o.specimen, fines, crush)),
        _ => 0.0,
    };
    // fines, and grains among them, once something has broken
    let among = |steps: f64, n: f64, born: f64| {
        if points * born > 0.0 { steps * (points * born * costs.point + n * costs.grain_among_points) } else { 0.0 }
    };
    let all = |steps: f64, n: f64| of(steps, n) + among(steps, n, n - grains as f64);
    let preparation = model.rig.specimen().map_or(0.0, |s| of(preparation_steps(s), n));
    let (mut steps_of_test, mut test) = (steps, of(steps, n * mean));
    if let Some(o) = model.rig.compression() {
        let largest = o.loading.stages.iter().copied().fold(0.0, f64::max);
        // grains break on the way to the largest stress, and are there afterwards
        let peak = o.loading.stages.iter().position(|s| *s == largest).unwrap_or(0);
        (steps_of_test, test) = (0.0, 0.0);
        for (k, &programme) in stages.iter().enumerate() {
            let steps = with_waiting(model, o, k, programme, dt, &broken);
            steps_of_test += steps;
            test += all(steps, if k > peak { n * last } else { n * mean });
        }
    }
    Duration {
        seconds: start + preparation + test,
        preparation,
        figures,
        steps: steps_of_test,
        grains: n * last,
        points: points * n * (last - 1.0),
    }
}

/// Points for each grain that breakages add: mothers are of the specimen's median size.
fn points(specimen: &Specimen, fines: &Embedding, crush: &CrushModel) -> f64 {
    let lost = ENTERED * (1.0 - crush.pattern.volume_kept()) * sphere_volume(0.5 * median(&specimen.gradation));
    lost / fines.solid() / (crush.pattern.count() - 1) as f64
}

/// Steps of stage `k`, which its programme would make in `programme` steps by itself: under stress control a platen is not faster than the largest inertial number I,
/// and waits after breakages: sqrt(programme² + w²) with w = SLOWER ∫ t/I dε, t the time scale of rearrangement. Beyond the largest stress so far ε is the strain of first
/// loading, and WAITS b more for b breakages a grain (`broken`, at a stress, Pa); below it that of swelling. Of 55 runs of coke and silica sand with programmes and caps of
/// their own 0.45 to 1.55 times the steps; a quarter to a third of those of silica sand that turns.
fn with_waiting(model: &Model, o: &Compression, k: usize, programme: f64, dt: Option<f64>, broken: &impl Fn(f64) -> f64) -> f64 {
    if o.loading.strain_controlled.is_some() {
        return programme;
    }
    let isotropic = o.specimen.isotropic_stress;
    let (to, before) = (o.loading.stages[k], o.loading.before(k).max(isotropic));
    let from = if k == 0 { isotropic } else { o.loading.stages[k - 1] };
    let largest = o.loading.stages.iter().copied().fold(before, f64::max);
    let swelling = |stress: f64| SWELLING * (stress / isotropic).ln();
    let first = |stress: f64| {
        let b = broken(stress);
        LEAST_STRAIN * (stress / isotropic).ln() / (largest / isotropic).ln() + MORE_STRAIN * b.powf(0.8) + WAITS * b
    };
    let held = |strain: &dyn Fn(f64) -> f64, from: f64, to: f64| {
        let at = |j: u32| from * (to / from).powf(f64::from(j) / f64::from(STRESSES));
        let part =
            |j: u32| (strain(at(j + 1)) - strain(at(j))).abs() * rearrangement(model, &o.specimen, (at(j) * at(j + 1)).sqrt());
        (0..STRESSES).map(part).sum::<f64>()
    };
    let waits = held(&swelling, from, to.min(before)) + held(&first, before, to.max(before));
    let all_sides = if o.all_sides { ALL_SIDES } else { 1.0 };
    all_sides * programme.hypot(SLOWER * waits / o.loading.max_inertial_number / dt.unwrap_or(1.0))
}

fn preparation_steps(s: &Specimen) -> f64 {
    let whole = match s.preparation.growth_friction {
        None => PREPARED_ON_PATH,
        Some(0.0) => PREPARED_WITHOUT_FRICTION,
        Some(_) => PREPARED_WITH_FRICTION,
    };
    whole * s.preparation.growth_steps as f64
}

/// Steps of first loading by strain between two stresses, Pa, whose largest is `largest`: the strain grows with the stress, and a
/// platen at an inertial number goes the slower the longer grains take to rearrange, [`rearrangement`].
pub fn strained_steps(model: &Model, o: &Compression, inertial: f64, [from, to]: [f64; 2], dt: f64) -> f64 {
    let strain = STRAIN * (to - from) / to;
    let stress = |k: u32| from + (to - from) * (f64::from(k) + 0.5) / f64::from(STRESSES);
    let mean = (0..STRESSES).map(|k| rearrangement(model, &o.specimen, stress(k))).sum::<f64>() / f64::from(STRESSES);
    strain / inertial * mean / dt
}

/// Largest stress on the grains of a scene, Pa; 0 where none is stated.
fn stress(model: &Model) -> f64 {
    match (model.rig.largest_stress(), model.rig.subject()) {
        (Some(stress), _) => stress,
        (_, Subject::Assembly(a)) => {
            let pressed =
                a.walls.iter().filter_map(|w| if let Drive::Stress { stress, .. } = w.drive { Some(stress) } else { None });
            pressed.fold(0.0, f64::max)
        }
        _ => 0.0,
    }
}

/// Some diameters of the scene's grains, m.
fn sizes(model: &Model) -> Option<Vec<f64>> {
    let all: Vec<f64> = match model.rig.subject() {
        Subject::Specimen(s) => {
            let few = Specimen { grains: s.grains.min(SAMPLED), ..s.clone() };
            packing::radii(&few, model.seeds.packing).iter().map(|r| 2.0 * r).collect()
        }
        Subject::Assembly(a) => a.grains.iter().map(|g| 2.0 * g.radius).collect(),
        Subject::GrainCrushing(_) | Subject::Continuum(_) => return None,
    };
    let every = all.len().div_ceil(GRAINS).max(1);
    Some(all.into_iter().step_by(every).collect())
}

/// Grains over those at the start: in the mean while the stress rises to `stress`, Pa, and then.
pub fn growth(model: &Model, crush: &CrushModel, sizes: &[f64], stress: f64) -> [f64; 2] {
    let more = (crush.pattern.count() - 1) as f64;
    let at = |stress: f64| 1.0 + more * breakages(model, crush, sizes, stress);
    let part = |k: u32| stress * (f64::from(k) + 0.5) / f64::from(STRESSES);
    [(0..STRESSES).map(|k| at(part(k))).sum::<f64>() / f64::from(STRESSES), at(stress)]
}

/// Breakages, with those of daughters, for each of the grains of these diameters, m, that a rising stress, Pa, brings about.
pub fn breakages(model: &Model, crush: &CrushModel, sizes: &[f64], stress: f64) -> f64 {
    let number = super::crushing::grain_materials(&model.rig).and_then(|all| all.first().copied()).unwrap_or(0);
    let Some(material) = model.physics.materials.get(usize::from(number)) else { return 0.0 };
    let e_eff = rigid_platens((material.young, material.poisson));
    let ratios: Vec<f64> = (0..DRAWS).map(|k| crush.strength.draw(1, lineage_root(k), crush.strength.d0)).collect();
    let broken = |d: f64| {
        let survived = |strength: &f64| {
            let limit =
                crush.criterion.limit_force(strength * size_factor(d, crush.strength.d0, crush.strength.m), d, 0.5 * d, e_eff);
            (-limit / (BEARS * stress * d * d)).exp()
        };
        ratios.iter().map(survived).sum::<f64>() / f64::from(DRAWS)
    };
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    if stress <= 0.0 || largest <= crush.d_limit {
        return 0.0;
    }
    sizes.iter().map(|&d| with_daughters(crush, &broken, d, GENERATIONS)).sum::<f64>() / sizes.len() as f64
}

/// Breakages of a grain of this diameter, m, and of all that comes of it.
fn with_daughters(crush: &CrushModel, broken: &impl Fn(f64) -> f64, d: f64, generations: u32) -> f64 {
    if d <= crush.d_limit || generations == 0 {
        return 0.0;
    }
    let mut daughters = 0.0;
    // daughters of one size one after the other
    let mut last = (0.0, 0.0);
    for ball in crush.pattern.balls() {
        if ball.radius != last.0 {
            last = (ball.radius, with_daughters(crush, broken, ball.radius * d, generations - 1));
        }
        daughters += last.1;
    }
    broken(d) * (1.0 + daughters)
}

#[cfg(test)]
mod tests {
    use crate::machine::Pace;
    use crate::model::Model;
    use crate::scene;

    /// What a scene of the repository is expected to take, with these values replaced.
    fn estimate(scene: &str, sets: &[&str]) -> scene::Estimate {
        scene::estimate(&model(scene, sets), None)
    }

    fn model(scene: &str, sets: &[&str]) -> Model {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments").join(scene);
        let sets: Vec<String> = sets.iter().map(|s| (*s).into()).collect();
        let scene = scene::load(path, &sets).expect("a scene");
        scene::model(&scene).expect("a model")
    }

    /// The same without start and figures, s.
    fn seconds(scene: &str, sets: &[&str]) -> f64 {
        let (costs, e) = (super::Costs::new(&model(scene, sets), None), estimate(scene, sets));
        e.seconds - costs.start - e.figure_seconds
    }

    #[test]
    fn every_kind_of_scene_has_a_time() {
        let small =
            ["free/hertz_impact.toml", "free/imported_packing.toml", "platen/petroleum_coke.toml", "isotropic/petroleum_coke.toml"];
        let large =
            ["petroleum_coke/h-c-2.toml", "fontainebleau/triaxial-h.toml", "mpm/oedometer.toml", "mixture/oedometer_crushing.toml"];
        for scene in small.into_iter().chain(large) {
            let seconds = seconds(scene, &[]);
            assert!(seconds.is_finite() && seconds > 0.0, "{scene}: {seconds}");
        }
    }

    #[test]
    fn time_is_that_of_steps_and_of_grains() {
        let packing = "free/imported_packing.toml";
        let [one, two] = ["steps=40000", "steps=80000"].map(|steps| seconds(packing, &[steps]));
        assert!((two / one - 2.0).abs() < 1e-9, "{one} {two}");
        let oedometer = "petroleum_coke/h-c-2.toml";
        let [one, two] =
            ["specimen.grains=680", "specimen.grains=1360"].map(|grains| seconds(oedometer, &[grains, "crushing.enabled=false"]));
        assert!((1.8..2.2).contains(&(two / one)), "{one} {two}");
        let continuum = "mpm/oedometer.toml";
        let [slow, fast] = ["0.0001", "0.0002"].map(|rate| seconds(continuum, &[&format!("test.strain_per_wave={rate}")]));
        assert!((slow / fast - 2.0).abs() < 0.01, "{slow} {fast}");
    }

    /// On a machine half as fast everything takes twice as long.
    #[test]
    fn time_follows_the_pace() {
        let (fast, slow) = (Pace::FAST, Pace { grain: 2.0 * Pace::FAST.grain, point: 2.0 * Pace::FAST.point });
        for scene in ["petroleum_coke/h-c-2.toml", "mpm/oedometer.toml", "mixture/coke_in_fines.toml", "platen/silica.toml"] {
            let model = model(scene, &[]);
            let [fast, slow] = [fast, slow].map(|pace| scene::estimate(&model, Some(pace)).seconds);
            assert!((slow / fast - 2.0).abs() < 1e-9, "{scene}: {fast} {slow}");
        }
    }

    /// Grains that break are more, and take longer.
    #[test]
    fn breakages_lengthen_a_run() {
        let scene = "petroleum_coke/h-c-2.toml";
        let broken = |stress: f64| {
            let e = estimate(scene, &[&format!("loading.max_stress_kPa={stress}"), "records.at_kPa=[]"]);
            e.grains_final / e.grains as f64
        };
        // measured: 4.0 and 26.5
        assert!((2.0..8.0).contains(&broken(1000.0)), "{}", broken(1000.0));
        assert!((13.0..53.0).contains(&broken(5000.0)), "{}", broken(5000.0));
        let whole = estimate(scene, &["crushing.enabled=false"]);
        assert_eq!(whole.grains_final, whole.grains as f64);
        assert!(whole.seconds < 0.5 * estimate(scene, &[]).seconds);
        let points = |lost: &str| seconds("mixture/coke_in_fines.toml", &[&format!("crushing.lost_mass={lost}")]);
        assert!(points("points") > 1.2 * points("leave"), "{} {}", points("points"), points("leave"));
        let none = seconds("mixture/coke_in_fines.toml", &["crushing.enabled=false", "crushing.lost_mass=leave"]);
        let oedometer = |lost: &str| {
            let sets = ["crushing.birth=gradual", "loading.max_stress_kPa=100e3", &format!("crushing.lost_mass={lost}")];
            seconds("silica/h-c-2.toml", &sets)
        };
        assert!(oedometer("points") > 2.0 * oedometer("leave"), "{} {}", oedometer("points"), oedometer("leave"));
        assert!(points("leave") > 2.0 * none, "{} {none}", points("leave"));
    }

    /// Steps of first loading, with those in which platens wait, beside those of runs (seed 1).
    #[test]
    fn platens_that_wait_take_more_steps() {
        let coke = "petroleum_coke/h-c-2.toml";
        let at = |stress: &'static str| ["accuracy=standard", "records.at_kPa=[]", stress];
        for (scene, sets, steps) in [
            (coke, at("loading.max_stress_kPa=1000"), 19_800.0),
            (coke, at("loading.max_stress_kPa=5000"), 53_000.0),
            ("petroleum_coke/l-c-2.toml", at("loading.max_stress_kPa=5000"), 30_300.0),
            ("petroleum_coke/h-v-2.toml", at("loading.max_stress_kPa=5000"), 37_400.0),
            ("silica/h-v-2.toml", at("loading.max_stress_kPa=100000"), 62_900.0),
        ] {
            let e = estimate(scene, &sets);
            let ratio = e.steps_expected / steps;
            assert!(e.steps < 0.2 * steps && (0.65..1.5).contains(&ratio), "{scene} {sets:?}: {} for {steps}", e.steps_expected);
        }
    }

    /// The step of a scene whose grains come upon each other slowly is the one of an impact, a share of Rayleigh's.
    #[test]
    fn steps_of_free_scenes_resolve_an_impact() {
        // measured: 83 335 and 1735
        for (scene, steps) in [("free/box_settling.toml", 83_335.0), ("free/sliding_to_rolling.toml", 1735.0)] {
            let e = estimate(scene, &[]);
            assert!((e.steps / steps - 1.0).abs() < 0.01, "{scene}: {}", e.steps);
        }
    }
}
