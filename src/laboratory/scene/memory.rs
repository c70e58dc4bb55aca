//! How much memory a run takes, from its numbers of points and grains, before any of them is made.

use super::Scene;
use super::view::View;
use crate::error::{Error, Result};
use crate::machine::size;
use crate::model::continuum::MpmTest;
use crate::model::{Model, Rig, Subject};
use engine::mpm::Dimension;
use std::f64::consts::FRAC_PI_2;

/// Words of the refusal of a run for which there is not enough memory now: what was refused with them says nothing about a scene.
pub const OF_MEMORY: &str = "of memory;";

/// The program itself with its threads, bytes; measured 11 to 14 MB.
const PROGRAM: f64 = 14e6;
/// Drawing the figures at the end, bytes: with a view of the specimen, measured 60 to 115 MB, and with sections through grains and points,
/// 230 to 275 MB.
const FIGURES: f64 = 85e6;
const SECTIONS: f64 = 240e6;
/// The same for platen tests, which have no such view; measured 32 MB.
const PLATEN_FIGURES: f64 = 45e6;
/// A grain with its contacts and neighbours while a checkpoint is written, bytes; measured 2200 to 2500, and 720 before grains touch.
const GRAIN: f64 = 2800.0;
/// A point of a continuum while a checkpoint is written, bytes, and one among grains, with its contacts; measured with their nodes 740
/// and 810 for many points under one platen, 960 between six, 1100 and 1200 among grains.
const POINT: f64 = 900.0;
const MIXED_POINT: f64 = 1150.0;
/// A block of cells with points, its tile and its nodes, in the plane and in space, bytes: 36 or 216 nodes of a tile and 16 or 64 of
/// its own, of some 64 bytes.
const BLOCK: [f64; 2] = [4000.0, 20_000.0];
/// A row of the table of platen tests, bytes.
const TEST: f64 = 400.0;

/// Memory that the run of a model takes, bytes, with this many more grains and points than at the start.
pub fn needed(model: &Model, more: [f64; 2]) -> f64 {
    let [grains, points] = more;
    let drawn = match model.rig {
        _ if !model.records.figures => 0.0,
        Rig::GrainCrushing(_) => PLATEN_FIGURES,
        Rig::Continuum(ref rig) if rig.counts()[1] > 0 => SECTIONS,
        _ => FIGURES,
    };
    // figures are drawn when all else is gone
    PROGRAM
        + drawn.max(match model.rig.subject() {
            Subject::Specimen(specimen) => GRAIN * (specimen.grains as f64 + grains) + MIXED_POINT * points,
            Subject::Assembly(a) => GRAIN * (a.grains.len() as f64 + grains),
            Subject::GrainCrushing(p) => TEST * p.diameters.len() as f64,
            Subject::Continuum(rig) => {
                let [listed, coarse] = rig.counts().map(|n| n as f64);
                let point = if rig.coarse.is_some() { MIXED_POINT } else { POINT };
                point * (listed + points) + GRAIN * (coarse + grains) + blocks(rig, listed)
            }
        })
}

/// Memory of the grid, bytes: blocks of four cells along each edge where there are points.
fn blocks(rig: &MpmTest, points: f64) -> f64 {
    let solid = rig.settings.dimension == Dimension::Space;
    let of_block = f64::from(4 * rig.per_edge).powi(if solid { 3 } else { 2 });
    // those at the surface are not full
    let full = points / of_block;
    let surface = if solid { 6.0 * full.powf(2.0 / 3.0) } else { 4.0 * full.sqrt() };
    BLOCK[usize::from(solid)] * (full + FRAC_PI_2 * surface + 8.0)
}

/// Refuses a scene whose run takes more memory than there is `free`, bytes; `None` where that is not known. Grains and points that
/// breakages may add are not counted here.
///
/// # Errors
/// The key that decides over the number of points or grains, with the memory that they take and what would fit.
pub fn fits(scene: &Scene, model: &Model, free: Option<u64>) -> Result<()> {
    let (needed, Some(free)) = (needed(model, [0.0; 2]), free.map(|free| free as f64)) else { return Ok(()) };
    if needed <= free {
        return Ok(());
    }
    let view = View::of(&scene.layer);
    // what is left for points and grains over what they take
    let share = ((free - PROGRAM) / (needed - PROGRAM)).max(0.0);
    let counts = match model.rig.subject() {
        Subject::Specimen(specimen) => [0, specimen.grains],
        Subject::Assembly(a) => [0, a.grains.len()],
        Subject::GrainCrushing(p) => [0, p.diameters.len()],
        Subject::Continuum(rig) => rig.counts(),
    };
    let key = key(&view, counts);
    let what = match counts {
        [points, 0] => format!("{} points", many(points)),
        [0, grains] => format!("{} grains", many(grains)),
        [points, grains] => format!("{} points and {} grains", many(points), many(grains)),
    };
    let advice = match (key, view.number(key)) {
        (_, _) if share == 0.0 => String::new(),
        ("grid.cell_mm", Some(cell)) => {
            let d = if view.flag("grid.plane_strain") { 2.0 } else { 3.0 };
            format!(": a cell of at least {} mm fits", up(1e3 * cell * (1.0 / share).powf(1.0 / d)))
        }
        _ => format!(": {} of them fit", many((share * (counts[0] + counts[1]) as f64) as usize)),
    };
    let message = format!("makes {what} that need {} {OF_MEMORY} {} are free{advice}", size(needed), size(free));
    view.refuse(key, message);
    Error::all(view.into_errors())
}

/// The key that decides over the numbers of points and grains.
fn key(view: &View, [points, grains]: [usize; 2]) -> &'static str {
    let there = |keys: &[&'static str]| keys.iter().copied().find(|key| view.has(key));
    let of_points = || there(&["growth.fines_diameter_mm", "grid.cell_mm", "grid.grains_per_point"]);
    let of_grains = || there(&["specimen.grains", "specimen.dry_mass_g", "batch.grains", "coarse.diameter_mm", "grain"]);
    let found = if points > grains { of_points().or_else(of_grains) } else { of_grains().or_else(of_points) };
    found.unwrap_or("kind")
}

/// A number of points or grains in words.
fn many(count: usize) -> String {
    match count as f64 {
        n if n >= 1e6 => format!("{:.1} million", 1e-6 * n),
        n if n >= 1e4 => format!("{:.0} thousand", 1e-3 * n),
        _ => count.to_string(),
    }
}

/// A number rounded upwards to three digits.
fn up(x: f64) -> String {
    let digit = 10_f64.powf(x.log10().floor() - 2.0);
    table::number((x / digit).ceil() * digit)
}

#[cfg(test)]
mod tests {
    use crate::scene;

    /// What is said of a scene of the repository on a machine with so many bytes free.
    fn told(name: &str, sets: &[&str], free: u64) -> String {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/").to_string() + name;
        let sets: Vec<String> = sets.iter().map(|s| (*s).into()).collect();
        let scene = scene::load(path, &sets).expect("a scene");
        let outline = scene::outline(&scene).expect("a model");
        scene::fits(&scene, &outline, None).expect("nothing is known of the machine");
        scene::fits(&scene, &outline, Some(free)).map_or_else(|e| e.to_string(), |()| String::new())
    }

    /// Points make room for coarse grains also where an outline makes only some of them: 441 790 are made for a run.
    #[test]
    fn an_outline_knows_how_many_points_there_will_be() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/mixture/triaxial_20_ratio_10.toml");
        let outline = scene::outline(&scene::load(path, &[]).expect("a scene")).expect("a model");
        let crate::model::Rig::Continuum(rig) = &outline.rig else { panic!("a mixture") };
        assert!(rig.left_out[0] > 0, "the outline is not one");
        let points = rig.counts()[0] as f64;
        assert!((points / 441_790.0 - 1.0).abs() < 0.01, "{points}");
    }

    #[test]
    fn what_does_not_fit_is_told_with_what_would() {
        let (scene, gigabyte) = ("mpm/oedometer.toml", 1_000_000_000);
        let refused = told(scene, &["grid.cell_mm=0.5"], gigabyte);
        assert!(refused.contains("makes 6.1 million points") && refused.contains("1.00 GB are free"), "{refused}");
        assert!(refused.contains("a cell of at least 0."), "{refused}");
        assert_eq!(told(scene, &["grid.cell_mm=1"], gigabyte), "");
        let refused = told("petroleum_coke/h-c-2.toml", &["specimen.grains=1000000"], gigabyte);
        assert!(refused.contains("makes 1.0 million grains") && refused.contains("thousand of them fit"), "{refused}");
        assert_eq!(told("free/box_settling.toml", &[], gigabyte), "");
    }
}
