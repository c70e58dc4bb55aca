//! The paper's figures, drawn from the runs that are done.

use super::plan::{Content, Figure, Plan, StrengthSet};
use super::results::Done;
use engine::breakage::criterion::{FailureCriterion, FixedAngle, HertzArea, size_factor};
use engine::material::effective_modulus;
use laboratory::error::Result;
use plot::{self, Colouring, Drawn, Graph, Look, Quantity, Tone};
use std::path::{Path, PathBuf};

/// Draws one figure into `dir` and returns the files: none if no run of the figure is done, or if
/// the runs hold nothing that the figure shows.
///
/// # Errors
/// Records that cannot be read and files that cannot be written.
pub fn draw(figure: &Figure, plan: &Plan, done: &[Done], dir: &Path) -> Result<Vec<PathBuf>> {
    let folders = |ids: &[String]| -> Vec<PathBuf> {
        let of = |id: &String| done.iter().find(|d| d.id == *id).map(Done::folders).unwrap_or_default();
        ids.iter().flat_map(of).collect()
    };
    // a folder for each entry of the plan, drawn from its first seed
    let of_each = |ids: &[String], draw: &dyn Fn(&Path, &Path) -> plot::Result<Vec<PathBuf>>| -> Result<Vec<PathBuf>> {
        let mut files = Vec::new();
        for id in ids {
            if let Some(first) = folders(std::slice::from_ref(id)).first() {
                // no file system of Windows takes a colon in a name
                files.extend(draw(first, &dir.join(id.replace(':', "_")))?);
            }
        }
        Ok(files)
    };
    match &figure.draw {
        Content::Curves { show, runs } => {
            let folders = folders(runs);
            if folders.is_empty() { Ok(Vec::new()) } else { Ok(plot::chosen(&folders, &[], show, dir)?) }
        }
        Content::Specimen { runs } => of_each(runs, &|run, out| plot::draw_specimen(run, &Colouring::Generation, out)),
        Content::Section { runs } => of_each(runs, &plot::draw_section),
        Content::Bodies { runs } => of_each(runs, &plot::draw_bodies),
        Content::Graph(chart) => chart.draw(&figure.name, plan, done, dir),
        Content::Cost { runs } => cost(runs, done, dir),
        Content::LimitForce { diameter_mm, m, sets } => Ok(limit_force(*diameter_mm, m, sets).draw(dir)?),
    }
}

/// Draws run time against initial grains, crush events and final grains, with the numbers of the
/// paper beside (Ciantia et al. 2015, Figs 5c, 18).
fn cost(ids: &[String], done: &[Done], dir: &Path) -> Result<Vec<PathBuf>> {
    let wanted = |d: &&Done| if ids.is_empty() { !d.published.is_empty() } else { ids.contains(&d.id) };
    let mut here: Vec<[f64; 4]> = Vec::new();
    let mut paper: Vec<[f64; 4]> = Vec::new();
    for d in done.iter().filter(wanted) {
        for seed in &d.seeds {
            let numbers = ["grains_initial", "crush_events", "grains_final", "wall_seconds"].map(|key| seed.number(key));
            if let [Some(initial), Some(events), Some(last), Some(seconds)] = numbers {
                here.push([initial, events, last, seconds / 60.0]);
            }
        }
        let initial = d.seeds.first().and_then(|seed| seed.number("grains_initial"));
        for p in &d.published {
            paper.extend(p.minutes.zip(initial).map(|(minutes, initial)| [initial, p.events, p.grains, minutes]));
        }
    }
    let symbols = |label: &str, nth, tone, points| Drawn {
        label: Some(label.into()),
        name: label.into(),
        tone,
        look: Look::Symbols(nth),
        points,
    };
    let mut files = Vec::new();
    for (k, (name, label)) in
        [("initial_grains", "initial grains (–)"), ("crush_events", "crush events (–)"), ("final_grains", "final grains (–)")]
            .into_iter()
            .enumerate()
    {
        let points = |rows: &[[f64; 4]]| rows.iter().map(|r| (r[k], r[3])).collect();
        let graph = Graph {
            name: format!("run_time_{name}"),
            title: Vec::new(),
            legend_title: None,
            x: Quantity::log(label, name),
            y: Quantity::log("run time (min)", "run_time_min"),
            series: vec![
                symbols("paper, Table 4", 1, Tone::Ink, points(&paper)),
                symbols("comminute", 0, Tone::Kind(0), points(&here)),
            ],
        };
        files.extend(graph.draw(dir)?);
    }
    Ok(files)
}

/// Number of intervals of a line.
const STEPS: u32 = 60;

/// Graph of the limit force against the diameter, by eq. (16) or (17), with a curve for each set
/// and exponent m.
fn limit_force([from, to]: [f64; 2], m: &[f64], sets: &[StrengthSet]) -> Graph {
    let mut series = Vec::new();
    for (i, set) in sets.iter().enumerate() {
        for (j, &m) in m.iter().enumerate() {
            let diameters = (0..=STEPS).map(|k| from * (to / from).powf(f64::from(k) / f64::from(STEPS)));
            let label = format!("{}, m = {}", set.label, plot::significant(m, 3));
            series.push(Drawn {
                label: Some(label.clone()),
                name: label,
                tone: Tone::Kind(i),
                look: Look::Line(j),
                points: diameters.map(|d| (d, set.force(1e-3 * d, m))).collect(),
            });
        }
    }
    Graph {
        name: "limit_force".into(),
        title: Vec::new(),
        legend_title: None,
        x: Quantity::log("grain diameter d (mm)", "diameter_mm"),
        y: Quantity::log("limit contact force F_{lim} (N)", "limit_force_N"),
        series,
    }
}

impl StrengthSet {
    /// Limit force at the mean strength, N, of a grain of diameter `d`, m, between platens: eq.
    /// (16), or eq. (17) with r' = d/2.
    fn force(&self, d: f64, m: f64) -> f64 {
        let strength = 1e6 * self.sigma_lim0_MPa * size_factor(d, 1e-3 * self.d0_mm, m);
        match (self.theta0_rad, self.moduli()) {
            (Some(theta0), _) => FixedAngle { theta0 }.limit_force(strength, d, 0.5 * d, 1.0),
            (None, Some([grain, platen])) => {
                HertzArea::default().limit_force(strength, d, 0.5 * d, effective_modulus(grain, platen))
            }
            (None, None) => f64::NAN,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_forces_at_the_reference_size_do_not_depend_on_m() {
        let mut set = StrengthSet {
            label: "coke".into(),
            sigma_lim0_MPa: 300.0,
            d0_mm: 2.0,
            theta0_rad: Some(std::f64::consts::PI / 9.0),
            E_GPa: None,
            nu: None,
            platen_E_GPa: None,
            platen_nu: None,
        };
        // 300 MPa times the area pi/4 d² sin²(pi/9)
        let f = 300e6 * std::f64::consts::FRAC_PI_4 * 4e-6 * (std::f64::consts::PI / 9.0).sin().powi(2);
        assert!((set.force(2e-3, 2.0) / f - 1.0).abs() < 1e-12 && (set.force(2e-3, 5.0) / f - 1.0).abs() < 1e-12);
        assert!((set.force(4e-3, 3.0) / f - 2.0).abs() < 1e-12, "F goes with d^(2 - 3/m)");
        (set.theta0_rad, set.sigma_lim0_MPa) = (None, 200.0);
        (set.E_GPa, set.nu, set.platen_E_GPa, set.platen_nu) = (Some(0.866), Some(0.3), Some(200.0), Some(0.3));
        assert!((set.force(2e-3, 10.0) / 155.4 - 1.0).abs() < 1e-3, "Table 2, first row");
        let graph = limit_force([1.0, 10.0], &[2.0, 5.0], &[set]);
        assert_eq!(graph.series.len(), 2);
        assert!(graph.series[0].points.iter().all(|p| p.1.is_finite()));
    }
}
