//! Rows of `breakage.csv`, and statistics of all breakages of a run for its summary: age of the broken grains, force over limit
//! force, and difference of the stress from its target.

use engine::dem::event::{Breakage, collided};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use table::Row;

/// Age in steps up to which a daughter that breaks counts as young.
pub const YOUNG: u64 = 20;
/// Force over limit force above which a breakage needs an explanation: a grain that was within its limit one step before has been
/// hit by another grain or a wall.
pub const HARD: f64 = 1.1;
/// Relative difference of the stress from its target above which a breakage counts as off the target.
pub const OFF: f64 = 0.05;
/// Share of breakages of young daughters above which the summary warns.
const MANY_YOUNG: f64 = 0.05;
/// Share of breakages far above the limit without a collision above which the summary warns.
const MANY_OVER: f64 = 0.01;

/// One breakage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Broken {
    generation: u8,
    young: bool,
    /// Force over limit force.
    utilisation: f64,
    /// The same one step before.
    before: f64,
    /// Whether the stress was off its target; false in a test without a target.
    off: bool,
}

/// Statistics of all breakages of a run; part of the checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Breakages(Vec<Broken>);

impl Breakages {
    /// Number of breakages.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Adds a breakage; `off`: the stress was off its target.
    pub fn add(&mut self, b: &Breakage, off: bool) {
        let young = b.generation > 0 && b.age <= YOUNG;
        self.0.push(Broken { generation: b.generation, young, utilisation: b.utilisation(), before: b.before, off });
    }

    fn share(&self, of: impl Fn(&Broken) -> bool) -> f64 {
        self.0.iter().filter(|b| of(b)).count() as f64 / self.0.len().max(1) as f64
    }

    /// Share of breakages of young daughters: these break because of the overlaps that they are born with, not because of the
    /// load.
    fn young(&self) -> f64 {
        self.share(|b| b.young)
    }

    /// Share of breakages above [`HARD`] without a collision.
    fn unexplained(&self) -> f64 {
        self.share(|b| b.utilisation > HARD && !collided(b.utilisation, b.before))
    }

    /// The entry `breakages` of `summary.json`.
    pub fn summary(&self) -> Value {
        let last = self.0.iter().map(|b| b.generation).max().unwrap_or(0);
        let generations: Vec<Value> = (0..=last)
            .map(|k| {
                let mut u: Vec<f64> = self.0.iter().filter(|b| b.generation == k).map(|b| b.utilisation).collect();
                u.sort_by(f64::total_cmp);
                let of = |p: f64| quantile(&u, p);
                json!({"generation": k, "breakages": u.len(), "utilisation_median": of(0.5), "utilisation_90": of(0.9), "utilisation_largest": of(1.0)})
            })
            .collect();
        json!({
            "young_steps": YOUNG,
            "young_share": self.young(),
            "above_1_1_share": self.share(|b| b.utilisation > HARD),
            "above_1_1_without_collision_share": self.unexplained(),
            "off_stress_share": self.share(|b| b.off),
            "by_generation": generations,
        })
    }

    /// Warnings for the reader of the results. The texts stand in `summary.json`, whose bytes the golden runs compare.
    pub fn warnings(&self) -> Vec<String> {
        let percent = |x: f64| format!("{:.1} %", 100.0 * x);
        let mut warnings = Vec::new();
        if self.young() > MANY_YOUNG {
            warnings.push(format!(
                "{} of the breakages are daughters at most {YOUNG} steps old: they break by the way they are born, not by load; crushing.birth = \"gradual\" avoids it",
                percent(self.young())
            ));
        }
        if self.unexplained() > MANY_OVER {
            warnings.push(format!(
                "{} of the breakages were above {HARD} times the grain's limit though nothing had hit it; more crushing.release_steps make breakage gentler",
                percent(self.unexplained())
            ));
        }
        let off = self.share(|b| b.off);
        if off > 0.0 {
            warnings.push(format!(
                "{} of the breakages happened while the stress was more than {} off the target: their place on the curve is that of the measured stress",
                percent(off),
                percent(OFF)
            ));
        }
        warnings
    }
}

/// Row of `breakage.csv` for the breakage `b` at step `step` and vertical stress `sigma_v`, Pa.
pub fn row(b: &Breakage, step: u64, sigma_v: f64) -> Row {
    vec![
        ("event", b.event.into()),
        ("step", step.into()),
        ("sigma_v_kPa", (sigma_v * 1e-3).into()),
        ("mother", u64::from(b.mother).into()),
        ("generation", u64::from(b.generation).into()),
        ("lineage", format!("{:016x}", b.lineage).as_str().into()),
        ("age_steps", b.age.into()),
        ("diameter_mm", (b.diameter * 1e3).into()),
        ("force_N", b.force.into()),
        ("limit_force_N", b.limit_force.into()),
        ("utilisation", b.utilisation().into()),
        ("utilisation_before", b.before.into()),
        ("area_mm2", (b.area * 1e6).into()),
        ("strength_MPa", (b.strength * 1e-6).into()),
        ("axis_x", b.axis[0].into()),
        ("axis_y", b.axis[1].into()),
        ("axis_z", b.axis[2].into()),
        ("x_mm", (b.position[0] * 1e3).into()),
        ("y_mm", (b.position[1] * 1e3).into()),
        ("z_mm", (b.position[2] * 1e3).into()),
        ("lost_mass_g", (b.lost_mass * 1e3).into()),
        ("smallest_daughter_mm", (b.smallest * 1e3).into()),
        ("stored_before_J", b.stored_before.into()),
        ("stored_after_J", b.stored_after.into()),
    ]
}

/// Quantile `p`, 0 to 1, of sorted numbers, without interpolation; 0 where there are none.
fn quantile(sorted: &[f64], p: f64) -> f64 {
    sorted.get(((sorted.len() as f64 * p) as usize).min(sorted.len().saturating_sub(1))).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn broken(generation: u8, young: bool, utilisation: f64, before: f64) -> Broken {
        Broken { generation, young, utilisation, before, off: false }
    }

    #[test]
    fn births_and_collisions_are_told_apart() {
        let mut all = Breakages((0..90).map(|_| broken(0, false, 1.001, 0.999)).collect());
        assert!(all.warnings().is_empty());
        all.0.extend((0..5).map(|_| broken(1, true, 4.0, 4.0)));
        all.0.extend((0..4).map(|_| broken(1, false, 1.5, 0.2)));
        // the way of two bodies in a step is known to some per cent of the excess
        all.0.push(broken(1, false, 1.5, 1.003));
        let s = all.summary();
        assert_eq!((s["young_share"].as_f64(), s["above_1_1_share"].as_f64()), (Some(0.05), Some(0.1)));
        assert_eq!(s["above_1_1_without_collision_share"].as_f64(), Some(0.05));
        assert_eq!(s["by_generation"][1]["utilisation_largest"].as_f64(), Some(4.0));
        assert!(all.warnings().iter().any(|w| w.contains("nothing had hit it")), "{:?}", all.warnings());
    }

    #[test]
    fn nothing_broken_is_nothing_said() {
        let none = Breakages::default();
        assert!(none.warnings().is_empty());
        assert_eq!(none.summary()["young_share"].as_f64(), Some(0.0));
    }
}
