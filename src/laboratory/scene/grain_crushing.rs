//! Makes [`GrainCrushing`] from the keys of a crushing test of single grains.

use super::material::Named;
use super::schema::unit;
use super::view::View;
use crate::gradation::stratified_diameters;
use crate::model::{GrainCrushing, Model, Rig};
use crate::rig::grain_crushing::{hertz_displacement, pair};
use engine::breakage::CrushModel;
use engine::breakage::criterion::size_factor;
use engine::math::random::lineage_root;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::collections::HashSet;
use toml::Value;

/// Curves that are written of a gradation.
const OF_GRADATION: usize = 4;
const MOST: usize = 1_000_000;

impl View<'_> {
    pub fn is_grain_crushing(&self) -> bool {
        self.text("kind") == "platen"
    }

    pub fn grain_crushing(&self, named: &[Named]) -> Option<GrainCrushing> {
        let (grain, platen) = self.roles(named)?;
        let (diameters, graded) = self.batch(&named[usize::from(grain)])?;
        Some(GrainCrushing {
            curves: self.curves(diameters.len()),
            diameters,
            graded,
            grain,
            platen,
            step: self.si("loading.step"),
            max_displacement: self.si("loading.max_displacement_over_d"),
            max_force: self.number("loading.max_force_N"),
        })
    }

    /// The material of the grains and that of the platens; a single one is that of grains between rigid platens.
    fn roles(&self, named: &[Named]) -> Option<(u8, Option<u8>)> {
        if self.has("material") {
            return Some((0, None));
        }
        let at = |name: &str| named.iter().position(|n| n.name == name).and_then(|i| u8::try_from(i).ok());
        let (grain, platen) = (at("grain"), at("platen"));
        if let Some(other) = named.iter().find(|n| n.name != "grain" && n.name != "platen") {
            self.refuse(&other.at, "has no part in a platen test: its materials are materials.grain and materials.platen");
            return None;
        }
        if grain.is_none() {
            self.refuse("materials.grain", "is missing: a platen test needs the material of its grains");
        }
        Some((grain?, platen))
    }

    /// Diameters, m, in the order of the grains' numbers, and whether they come from a gradation.
    fn batch(&self, of: &Named) -> Option<(Vec<f64>, bool)> {
        let count = usize::try_from(self.whole("batch.grains")?).ok()?;
        if !self.has("batch.diameters_mm") {
            let points = self.gradation(of)?;
            let mut rng = ChaCha8Rng::seed_from_u64(self.whole("seed.packing")?);
            return Some((stratified_diameters(&points, count, &mut rng), true));
        }
        let key = "batch.diameters_mm";
        let list = self.get(key).and_then(Value::as_array);
        let sizes: Vec<f64> = list.into_iter().flatten().filter_map(Value::as_float).map(|d| d * unit(key)).collect();
        if sizes.is_empty() {
            self.refuse(key, "must hold a diameter, or be left out for a gradation");
            return None;
        }
        let mut seen = HashSet::with_capacity(sizes.len());
        if let Some(i) = sizes.iter().position(|d| !seen.insert(d.to_bits())) {
            self.refuse(key, format!("must differ from each other; entry {} stands there already", i + 1));
            return None;
        }
        let tests = sizes.len().saturating_mul(count);
        if tests > MOST {
            self.refuse("batch.grains", format!("would make {tests} tests; at most {MOST} are made"));
            return None;
        }
        Some((sizes.iter().flat_map(|d| std::iter::repeat_n(*d, count)).collect(), false))
    }

    /// The grains that are listed; none where they are to be typical ones.
    fn curves(&self, count: usize) -> Vec<u32> {
        let list = self.get("records.curves").and_then(Value::as_array);
        let mut curves: Vec<u32> =
            list.into_iter().flatten().filter_map(Value::as_integer).filter_map(|i| u32::try_from(i).ok()).collect();
        if let Some(bad) = curves.iter().find(|i| **i as usize >= count) {
            let last = count.saturating_sub(1);
            self.refuse("records.curves", format!("there is no grain {bad}; they go from 0 to {last}"));
        }
        curves.sort_unstable();
        curves.dedup();
        curves
    }

    /// Chooses typical curves where none are listed: the median strength of each diameter, or sizes spread over a gradation.
    pub fn typical(&self, rig: &mut Rig, crush: Option<&CrushModel>) {
        let Rig::GrainCrushing(rig) = rig else { return };
        if !self.text("records.curves").is_empty() {
            rig.curves = typical(rig, crush);
        }
    }
}

fn typical(rig: &GrainCrushing, crush: Option<&CrushModel>) -> Vec<u32> {
    let d = |i: u32| rig.diameters[i as usize];
    let mut order: Vec<u32> = (0..rig.diameters.len() as u32).collect();
    let mut chosen: Vec<u32> = if rig.graded {
        order.sort_by(|&a, &b| d(a).total_cmp(&d(b)).then(a.cmp(&b)));
        let parts = OF_GRADATION.min(order.len());
        (0..parts).map(|k| order[(2 * k + 1) * order.len() / (2 * parts)]).collect()
    } else {
        let strength = |i: u32| crush.map_or(0.0, |c| c.strength.draw(c.seed, lineage_root(i), d(i)));
        let middle = |same: &mut [u32]| {
            same.sort_by(|&a, &b| strength(a).total_cmp(&strength(b)).then(a.cmp(&b)));
            same[same.len() / 2]
        };
        order.chunk_by_mut(|&a, &b| d(a) == d(b)).map(middle).collect()
    };
    chosen.sort_unstable();
    chosen
}

/// Largest share by which a force may pass its limit before it is pointed out.
const OVERSHOOT: f64 = 1e-3;

/// Warnings for a batch of crushing tests.
pub fn warnings(model: &Model, rig: &GrainCrushing, out: &mut Vec<String>) {
    let Some(crush) = &model.physics.crush else {
        out.push("crushing.enabled = false: every grain is pressed to the end of its test".into());
        return;
    };
    let mut sizes = rig.diameters.clone();
    sizes.sort_by(f64::total_cmp);
    sizes.dedup();
    let below = rig.diameters.iter().filter(|d| **d <= crush.d_limit).count();
    if below > 0 && below < rig.diameters.len() {
        out.push(format!("{below} grains are not above the comminution limit, {:.4} mm, and cannot break", 1e3 * crush.d_limit));
    }
    let e_eff = pair(model, rig).e_eff;
    let far = |d: &&f64| {
        let strength = crush.strength.sigma_lim0 * size_factor(**d, crush.strength.d0, crush.strength.m);
        let force = crush.criterion.limit_force(strength, **d, 0.5 * **d, e_eff);
        let unmoved = hertz_displacement(e_eff, 0.5 * **d, force) < rig.max_displacement * **d;
        **d > crush.d_limit && !(unmoved && rig.max_force.is_none_or(|most| force < most))
    };
    if let Some(d) = sizes.iter().rfind(far) {
        out.push(format!(
            "a grain of {:.4} mm and of the mean strength of its size does not break before its test ends (loading.max_displacement_over_d, loading.max_force_N)",
            1e3 * d
        ));
    }
    let overshoot = (1.0 + rig.step).powf(1.5) - 1.0;
    if overshoot > OVERSHOOT {
        out.push(format!("loading.step = {}: the force of a breakage may pass its limit by {:.2} %", rig.step, 100.0 * overshoot));
    }
}
