//! What settings are judged by: numbers and curves that runs leave.

use crate::reproduce::rows;
use laboratory::error::Result;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;

/// A measure of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Porosity along the logarithm of the vertical stress, from a hundredth of the largest stress on.
    Compression,
    /// Principal stress ratio (of grains q/p) along axial strain, over the largest of the reference.
    StressStrain,
    /// Share of mass that passes, along the logarithm of size, at the end.
    Gradation,
    /// Breakages, over those of the reference.
    CrushEvents,
    /// Stress ratio σ_h/σ_v at the end.
    K0,
    /// Void ratio at the end.
    VoidRatio,
    /// Largest axial stress, over that of the reference.
    LargestStress,
    /// Largest principal stress ratio, over that of the reference.
    PeakStrength,
    /// Principal stress ratio at the end (of grains, whose forces rise and fall, the mean of q/p over the last half of the strain), over that of the reference.
    ResidualStrength,
    /// Error of the energy ledger, over the work of the walls.
    EnergyError,
}

/// Values at which curves are compared.
const ALONG: usize = 40;
/// A curve counts if it reaches this share of the reference's last abscissa.
const REACHES: f64 = 0.98;

/// What a run left, as far as measures need it.
#[derive(Clone, Debug, Default)]
pub struct RunData {
    /// Content of `summary.json`.
    pub summary: Value,
    /// Vertical stress, kPa, and porosity, in first loading.
    compression: Vec<(f64, f64)>,
    /// Axial strain and principal stress ratio or q/p.
    test: Vec<(f64, f64)>,
    /// Size, mm, and share of mass that passes, at the end.
    gradation: Vec<(f64, f64)>,
}

impl RunData {
    /// Reads what the run in `folder` left.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn read(folder: &Path, summary: Value) -> Result<RunData> {
        let history = folder.join("history.csv");
        let rising = |rows: Vec<[f64; 2]>| {
            let mut kept: Vec<(f64, f64)> = Vec::new();
            for [x, y] in rows {
                if kept.last().is_none_or(|last| x > last.0) && x > 0.0 {
                    kept.push((x, y));
                }
            }
            kept
        };
        // "load" of oedometers and continua, "shear" of triaxial tests of grains
        let tested = |names| rows(&history, |stage| ["load", "shear"].contains(&stage), names);
        let mut test = tested(["axial_strain", "principal_ratio"])?;
        if test.is_empty() {
            test = tested(["axial_strain", "stress_ratio"])?;
        }
        Ok(RunData {
            compression: rising(tested(["sigma_v_kPa", "porosity"])?),
            test: rising(test),
            gradation: last_gradation(&folder.join("gsd.csv"))?,
            summary,
        })
    }

    /// Time of the test, s: without the preparation of a specimen of grains; of the processor where a run tells it, else by the clock.
    pub fn seconds(&self) -> Option<f64> {
        ["/loading_seconds", "/user_seconds", "/wall_seconds"].iter().find_map(|at| self.number(at))
    }

    /// A number of the summary, by its JSON pointer.
    fn number(&self, at: &str) -> Option<f64> {
        self.summary.pointer(at).and_then(Value::as_f64)
    }
}

/// Sizes, mm, and shares that pass, of the last gradation of a file; none if there is no such file.
///
/// # Errors
/// A file that cannot be read.
fn last_gradation(path: &Path) -> Result<Vec<(f64, f64)>> {
    if !path.is_file() {
        return Ok(Vec::new());
    }
    let all = rows(path, |_| true, ["step", "diameter_mm", "passing_percent"])?;
    let last = all.last().map_or(f64::NAN, |row| row[0]);
    Ok(all.into_iter().filter(|row| row[0] == last).map(|[_, size, percent]| (size, 0.01 * percent)).collect())
}

/// The value of a curve at `x`, linear between its points; its first and last value beyond them.
fn at(curve: &[(f64, f64)], x: f64) -> f64 {
    let after = curve.partition_point(|p| p.0 < x);
    match (after.checked_sub(1).map(|k| curve[k]), curve.get(after)) {
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0),
        (Some(end), None) | (None, Some(&end)) => end.1,
        (None, None) => f64::NAN,
    }
}

impl Measure {
    /// All measures.
    pub const ALL: [Measure; 10] = [
        Measure::Compression,
        Measure::StressStrain,
        Measure::Gradation,
        Measure::CrushEvents,
        Measure::K0,
        Measure::VoidRatio,
        Measure::LargestStress,
        Measure::PeakStrength,
        Measure::ResidualStrength,
        Measure::EnergyError,
    ];

    /// Its name in plans and tables.
    pub fn name(self) -> &'static str {
        match self {
            Measure::Compression => "compression",
            Measure::StressStrain => "stress_strain",
            Measure::Gradation => "gradation",
            Measure::CrushEvents => "crush_events",
            Measure::K0 => "k0",
            Measure::VoidRatio => "void_ratio",
            Measure::LargestStress => "largest_stress",
            Measure::PeakStrength => "peak_strength",
            Measure::ResidualStrength => "residual_strength",
            Measure::EnergyError => "energy_error",
        }
    }

    /// What a difference of it is, with its unit.
    pub fn difference(self) -> &'static str {
        match self {
            Measure::Compression => "difference of porosity along log σ_{v}, rms (–)",
            Measure::StressStrain => "difference of the stress ratio, rms over its peak (–)",
            Measure::Gradation => "difference of the mass that passes, rms (–)",
            Measure::CrushEvents => "difference of breakages over their number (–)",
            Measure::K0 => "difference of k_{0} at the end (–)",
            Measure::VoidRatio => "difference of the void ratio at the end (–)",
            Measure::LargestStress => "difference of the largest axial stress over it (–)",
            Measure::PeakStrength => "difference of the peak stress ratio over it (–)",
            Measure::ResidualStrength => "difference of the residual stress ratio over it (–)",
            Measure::EnergyError => "difference of the energy error (–)",
        }
    }

    /// Whether it is a share of the reference's mean.
    fn is_relative(self) -> bool {
        use Measure::{CrushEvents, LargestStress, PeakStrength, ResidualStrength, StressStrain};
        [StressStrain, CrushEvents, LargestStress, PeakStrength, ResidualStrength].contains(&self)
    }

    /// The components of the measure for each run, all at the same abscissae; `None` for a run that does not have it. `runs` holds the runs of each setting,
    /// those of the reference first.
    pub fn of(self, runs: &[Vec<Option<RunData>>]) -> Vec<Vec<Option<Vec<f64>>>> {
        let number = |place: &'static str| move |run: &RunData| run.number(place).map(|x| vec![x]);
        let mut found = match self {
            Measure::Compression => along(runs, |r| &r.compression, true, 0.01),
            Measure::StressStrain => along(runs, |r| &r.test, false, 0.0),
            Measure::Gradation => along(runs, |r| &r.gradation, true, 0.0),
            Measure::CrushEvents => each(runs, number("/crush_events")),
            Measure::K0 => each(runs, number("/k0_final")),
            Measure::VoidRatio => each(runs, number("/void_ratio_final")),
            Measure::LargestStress => each(runs, number("/max_measured_stress_kPa")),
            Measure::PeakStrength => each(runs, number("/peak_stress_ratio")),
            Measure::ResidualStrength => {
                each(runs, |run| run.number("/residual_stress_ratio").or_else(|| late(&run.test)).map(|x| vec![x]))
            }
            Measure::EnergyError => each(runs, number("/energy_error")),
        };
        if self.is_relative() {
            let most = |v: &Vec<f64>| v.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let of_reference: Vec<f64> = found.first().into_iter().flatten().flatten().map(most).collect();
            let mean = of_reference.iter().sum::<f64>() / of_reference.len() as f64;
            if mean == 0.0 || mean.is_nan() {
                return each(runs, |_| None);
            }
            found.iter_mut().flatten().flatten().flatten().for_each(|x| *x /= mean);
        }
        found
    }
}

/// Mean ordinate of a curve over the last half of its abscissae; `None` for an empty curve.
fn late(curve: &[(f64, f64)]) -> Option<f64> {
    let from = 0.5 * curve.last()?.0;
    let kept: Vec<f64> = curve.iter().filter(|p| p.0 > from).map(|p| p.1).collect();
    Some(kept.iter().sum::<f64>() / kept.len() as f64)
}

/// What `of` finds in each run.
fn each(runs: &[Vec<Option<RunData>>], of: impl Fn(&RunData) -> Option<Vec<f64>>) -> Vec<Vec<Option<Vec<f64>>>> {
    runs.iter().map(|seeds| seeds.iter().map(|run| run.as_ref().and_then(&of)).collect()).collect()
}

/// Curves at the same abscissae, those that all runs of the reference have; on a logarithmic scale from the share `least` of the largest abscissa on. A run that ends
/// before has no curve.
fn along(runs: &[Vec<Option<RunData>>], of: fn(&RunData) -> &Vec<(f64, f64)>, log: bool, least: f64) -> Vec<Vec<Option<Vec<f64>>>> {
    let ends = |run: &RunData| Some((of(run).first()?.0, of(run).last()?.0));
    let reference = runs.first().into_iter().flatten().flatten().filter_map(ends);
    let (low, high) = reference.fold((0.0, f64::INFINITY), |(low, high): (f64, f64), (a, b)| (low.max(a), high.min(b)));
    let low = low.max(least * high);
    if !(low < high && high.is_finite()) {
        return each(runs, |_| None);
    }
    let abscissa = |k: usize| {
        let share = k as f64 / (ALONG - 1) as f64;
        if log { low * (high / low).powf(share) } else { low + (high - low) * share }
    };
    let reaches = |run: &RunData| of(run).last().is_some_and(|end| end.0 > REACHES * high);
    each(runs, |run| reaches(run).then(|| (0..ALONG).map(|k| at(of(run), abscissa(k))).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of shearing count where grains are sheared, and the last gradation whatever its stage.
    #[test]
    fn a_triaxial_test_of_grains_has_its_curve_and_gradation() {
        let dir = tempfile::tempdir().expect("folder");
        let write = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).expect("written");
        write("history.csv", "stage,axial_strain,stress_ratio\nsettle,0.0,0.5\nshear,0.01,0.8\nshear,0.02,1.1\n");
        write("gsd.csv", "step,stage,diameter_mm,passing_percent\n0,settle,1,0\n0,settle,2,100\n9,shear,1,20\n9,shear,2,100\n");
        let run = RunData::read(dir.path(), Value::Null).expect("read");
        assert_eq!((run.test, run.gradation), (vec![(0.01, 0.8), (0.02, 1.1)], vec![(1.0, 0.2), (2.0, 1.0)]));
        assert!(run.compression.is_empty());
    }

    /// Of grains the residual strength is the mean of the last half of the curve; a summary that has one goes before.
    #[test]
    fn grains_have_a_residual_strength() {
        let run = |summary| {
            let test = vec![(0.02, 9.0), (0.04, 7.0), (0.06, 1.0), (0.08, 3.0)];
            Some(RunData { test, summary, ..RunData::default() })
        };
        let known = serde_json::json!({ "residual_stress_ratio": 3.0 });
        let found = Measure::ResidualStrength.of(&[vec![run(Value::Null)], vec![run(known), Some(RunData::default())]]);
        assert_eq!(found, [vec![Some(vec![1.0])], vec![Some(vec![1.5]), None]]);
    }

    #[test]
    fn curves_are_compared_where_the_reference_has_them() {
        let run = |shift: f64, end: f64| {
            let stresses = (0..200).map(|k| 10f64.powf(0.02 * f64::from(k))).filter(|s| *s <= end);
            let compression = stresses.map(|s| (s, shift - 0.1 * s.log10())).collect();
            Some(RunData { compression, ..RunData::default() })
        };
        let found = Measure::Compression.of(&[vec![run(0.5, 400.0)], vec![run(0.52, 1e3), run(0.5, 300.0), None]]);
        let (a, b) = (found[0][0].as_ref().expect("a curve"), found[1][0].as_ref().expect("a curve"));
        assert!(found[1][1..] == [None, None] && a.len() == ALONG);
        // the second is higher by 0.02 everywhere, from a hundredth of the reference's end on
        assert!(a.iter().zip(b).all(|(a, b)| (b - a - 0.02).abs() < 1e-6), "{a:?} {b:?}");
        assert!((a[0] - (0.5 - 0.1 * 3.981_f64.log10())).abs() < 1e-3, "{}", a[0]);
    }

    #[test]
    fn numbers_are_relative_where_they_grow_with_the_scene() {
        let run = |events: f64| Some(RunData { summary: serde_json::json!({ "crush_events": events }), ..RunData::default() });
        let found = Measure::CrushEvents.of(&[vec![run(90.0), run(110.0)], vec![run(120.0), run(130.0)]]);
        assert_eq!(found[1], [Some(vec![1.2]), Some(vec![1.3])]);
        // nothing breaks in the reference
        assert_eq!(Measure::CrushEvents.of(&[vec![run(0.0)], vec![run(1.0)]])[1], [None]);
    }
}
