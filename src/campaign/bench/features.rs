//! What the features of grains cost: time and memory of a step with a feature over those of the same step without it.

use super::speed::run;
use super::{Packing, STRESS, breakable, model, pool, start};
use engine::breakage::Criterion;
use engine::contact::{ContactLaw, TangentialUnloading};
use engine::dem::{State, Workspace, observables};
use laboratory::error::{Error, Result};
use laboratory::model::Model;
use std::time::Instant;
use table::median;

/// Cost of a feature, beside the same packing without it: grains that turn, with Hertz-Mindlin contacts and sliding friction.
#[derive(Clone, Debug)]
pub struct FeatureCost {
    /// What it is, in a few words.
    pub feature: String,
    /// Time of a step with it over that without it, in each pair of blocks.
    pub ratios: Vec<f64>,
    /// Memory for each grain with its contacts, bytes.
    pub bytes_per_grain: f64,
    /// Touching pairs of grains, per grain, at the end.
    pub touching: f64,
}

impl FeatureCost {
    /// Median of the ratios.
    pub fn median(&self) -> f64 {
        median(&self.ratios)
    }

    /// Lower and upper quartile of the ratios: medians of those up to the median and from it on.
    pub fn quartiles(&self) -> [f64; 2] {
        let middle = self.median();
        let side = |keep: &dyn Fn(f64) -> bool| median(&self.ratios.iter().copied().filter(|r| keep(*r)).collect::<Vec<f64>>());
        [side(&|r| r <= middle), side(&|r| r >= middle)]
    }
}

/// A feature: the model that has it, and whether contacts keep account of their work.
struct Feature {
    name: String,
    model: Model,
    energy: bool,
}

/// Measures each feature on one thread: blocks of `steps` steps without and with it, in turn, `repeats` of each after `warm_up` steps. Many short blocks are better than
/// few long ones: what else the machine does then falls on both of a pair. `each` is called with every result.
///
/// # Errors
/// A packing that becomes unstable with a feature.
pub fn feature_costs(
    packing: &Packing,
    skin: f64,
    [warm_up, steps]: [u64; 2],
    repeats: usize,
    mut each: impl FnMut(&FeatureCost) + Send,
) -> Result<Vec<FeatureCost>> {
    let plain = model(packing.case, packing.grains.len(), ContactLaw::Hertz, skin);
    let mut all = Vec::new();
    pool(1)?.install(|| {
        for feature in features(packing, &plain)? {
            let cost = cost(&plain, &feature, packing, [warm_up, steps], repeats)?;
            each(&cost);
            all.push(cost);
        }
        Ok(all)
    })
}

fn cost(plain: &Model, feature: &Feature, packing: &Packing, [warm_up, steps]: [u64; 2], repeats: usize) -> Result<FeatureCost> {
    let mut without = begun(plain, packing, false);
    let mut with = begun(&feature.model, packing, feature.energy);
    let block = |model: &Model, (state, work): &mut (State, Workspace), steps| {
        let since = Instant::now();
        run(model, state, work, steps);
        since.elapsed().as_secs_f64()
    };
    block(plain, &mut without, warm_up);
    block(&feature.model, &mut with, warm_up);
    let mut ratios = Vec::new();
    for _ in 0..repeats {
        let base = block(plain, &mut without, steps);
        ratios.push(block(&feature.model, &mut with, steps) / base);
    }
    let (state, work) = &with;
    let n = state.grains.len() as f64;
    let sums = observables::sums(&feature.model.physics, state, work);
    if !sums.contact_force.is_finite() {
        let what = format!("the packing of the bench has become unstable with {}", feature.name);
        return Err(Error::Unstable { step: state.step, what, grain: None });
    }
    Ok(FeatureCost {
        feature: feature.name.clone(),
        ratios,
        bytes_per_grain: work.bytes(state) as f64 / n,
        touching: sums.contacts as f64 / n,
    })
}

/// The packing at rest, with walls that move as fast in a step whatever a step means.
fn begun(model: &Model, packing: &Packing, energy: bool) -> (State, Workspace) {
    let (mut state, work) = start(model, packing, energy);
    state.crushing = model.physics.crush.is_some();
    if model.physics.stepping.inertia_scaling {
        state.reference_stress = STRESS;
        let slower = packing.case.time_step();
        state.walls.iter_mut().for_each(|wall| wall.speed *= slower);
    }
    (state, work)
}

/// The features, in the order of the table.
fn features(packing: &Packing, plain: &Model) -> Result<Vec<Feature>> {
    let with = |name: &str, change: &dyn Fn(&mut Model)| {
        let mut model = plain.clone();
        change(&mut model);
        Feature { name: name.into(), model, energy: false }
    };
    let mut all = vec![
        with("nothing more (how far two equal runs are apart)", &|_| {}),
        with("grains that do not turn", &|m| m.physics.contact.turning = false),
        with("rolling friction", &|m| {
            m.physics.materials[0].rolling_friction = 0.1;
            m.physics.contact.rolling = true;
        }),
        with("tangential force that falls with the overlap", &|m| m.physics.contact.unloading = TangentialUnloading::Rescale),
        with("local damping", &|m| m.physics.damping = 0.1),
        with("gravity", &|m| m.physics.gravity = [0.0, 0.0, -9.81]),
        with("time step found from stiffnesses", &|m| m.physics.stepping.dt = None),
        with("scaled inertia", &|m| {
            m.physics.stepping.dt = None;
            m.physics.stepping.inertia_scaling = true;
        }),
        Feature { energy: true, ..with("account of the contacts' work", &|_| {}) },
    ];
    for law in [ContactLaw::HertzViscous, ContactLaw::Linear] {
        all.push(Feature {
            name: format!("contact law {}", law.word()),
            model: model(packing.case, packing.grains.len(), law, plain.physics.stepping.skin),
            energy: false,
        });
    }
    let judged = |word: &str, interval| -> Result<Model> {
        let mut model = breakable(plain)?;
        if let (Some(crush), Some(criterion)) = (&mut model.physics.crush, Criterion::named(word, &[0.35, 0.0, 0.0, 0.0])) {
            (crush.criterion, crush.interval) = (criterion, interval);
        }
        Ok(model)
    };
    for word in Criterion::WORDS {
        all.push(Feature { name: format!("grains judged by {word}"), model: judged(word, 1)?, energy: false });
    }
    let name = "grains judged by fixed_angle, every 20th step".to_string();
    all.push(Feature { name, model: judged("fixed_angle", 20)?, energy: false });
    Ok(all)
}
