//! What a run holds at one instant: grains from `grains_final.csv` or a snapshot, surfaces of bodies from a snapshot.

use super::text_file::LONGEST;
use crate::error::{Error, Result};
use crate::record::snapshot::{Snapshot, list};
use crate::run::{BLOCKS, COLLECTION, GRAINS, GRAINS_FINAL};
use crate::scene::number_file::Format;
use crate::scene::{self, RESOLVED, read_text_up_to};
use std::path::Path;

/// A grain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grain {
    /// Centre, m.
    pub position: [f64; 3],
    /// Radius, m.
    pub radius: f64,
    /// Velocity, m/s.
    pub velocity: [f64; 3],
    /// Spin, rad/s; 0 where a snapshot does not say it.
    pub spin: [f64; 3],
    /// Number of breakages between the grain and a grain of the start.
    pub generation: u32,
    /// Number of its material, from 0.
    pub kind: usize,
}

/// A material of grains.
#[derive(Clone, Debug, PartialEq)]
pub struct Kind {
    /// Its name in the scene.
    pub name: String,
    /// Density of a grain with its internal pores, kg/m³.
    pub density: f64,
}

/// What a run holds at one instant.
#[derive(Clone, Debug, Default)]
pub struct Contents {
    /// The grains, in the order of their numbers.
    pub grains: Vec<Grain>,
    /// The materials of the scene.
    pub kinds: Vec<Kind>,
    /// Surfaces of the bodies that are no spheres, with the array `block`: the body of each triangle.
    pub bodies: Snapshot,
}

/// Columns of `grains_final.csv`.
const COLUMNS: [(&str, usize, f64); 11] = [
    ("x_m", 0, 1.0),
    ("y_m", 1, 1.0),
    ("z_m", 2, 1.0),
    ("r_m", 3, 1.0),
    ("generation", 4, 1.0),
    ("vx_m_s", 5, 1.0),
    ("vy_m_s", 6, 1.0),
    ("vz_m_s", 7, 1.0),
    ("wx_rad_s", 8, 1.0),
    ("wy_rad_s", 9, 1.0),
    ("wz_rad_s", 10, 1.0),
];

impl Contents {
    /// What the run in `dir` holds in its snapshot `number`, from 0; at its end, or in its last snapshot, where none is given.
    ///
    /// # Errors
    /// A folder that is no run; a snapshot that there is not; a run that has neither grains nor bodies; damaged files.
    pub fn of_run(dir: &Path, number: Option<usize>) -> Result<Contents> {
        let scene = scene::load(dir.join(RESOLVED), &[])?;
        let materials = scene::outline(&scene)?.physics.materials;
        let kinds: Vec<Kind> = materials.iter().map(|m| Kind { name: m.name.clone(), density: m.density }).collect();
        let last = dir.join(GRAINS_FINAL);
        let grains = match number {
            None if last.is_file() => final_grains(&last, &kinds)?,
            _ => chosen(dir, number)?.map_or(Ok(Vec::new()), |snapshot| grains(&snapshot, dir, &kinds))?,
        };
        let bodies = pick(dir, &list(&dir.join(BLOCKS))?, number)?.unwrap_or_default();
        if grains.is_empty() && bodies.triangles.is_empty() {
            return Err(Error::input(
                dir.display(),
                "",
                None,
                "holds neither grains nor bodies: no grains_final.csv, no snapshots of them",
            ));
        }
        Ok(Contents { grains, kinds, bodies })
    }
}

/// The snapshot of grains (of points, where there are no grains) with this number, else the last one.
fn chosen(dir: &Path, number: Option<usize>) -> Result<Option<Snapshot>> {
    let mut all = list(&dir.join(GRAINS))?;
    if all.is_empty() {
        all = list(&dir.join(COLLECTION))?;
    }
    pick(dir, &all, number)
}

/// The snapshot with this number of a list, else the last one; none of an empty list.
fn pick(dir: &Path, all: &[(f64, std::path::PathBuf)], number: Option<usize>) -> Result<Option<Snapshot>> {
    let Some(last) = all.len().checked_sub(1) else { return Ok(None) };
    match all.get(number.unwrap_or(last)) {
        Some((_, path)) => Snapshot::read(path).map(Some),
        None => {
            let value = number.map(|n| n.to_string());
            Err(Error::input(
                dir.display(),
                "snapshot",
                value,
                format!("must be 0 to {last}: the run has left {} snapshots", all.len()),
            ))
        }
    }
}

/// The grains of a snapshot; none where it has points.
fn grains(snapshot: &Snapshot, dir: &Path, kinds: &[Kind]) -> Result<Vec<Grain>> {
    let array = |names: [&str; 2], components: usize| {
        names.iter().find_map(|name| snapshot.array(name)).filter(|array| array.components == components).map(|array| &array.values)
    };
    let Some(radii) = array(["radius", "radius_m"], 1) else { return Ok(Vec::new()) };
    let [velocity, spin] = [["velocity", "velocity_m_s"], ["spin", "spin_rad_s"]].map(|names| array(names, 3));
    let [generation, material] = ["generation", "material"].map(|name| array([name; 2], 1));
    if material.is_none() && kinds.len() > 1 {
        let message =
            format!("its snapshots do not say which of the {} materials a grain has; take the end of the run", kinds.len());
        return Err(Error::input(dir.display(), "", None, message));
    }
    let three = |of: Option<&Vec<f64>>, i: usize| of.map_or([0.0; 3], |v| [v[3 * i], v[3 * i + 1], v[3 * i + 2]]);
    let whole = |of: Option<&Vec<f64>>, i: usize| of.map_or(0, |v| v[i] as u32);
    let grain = |(i, position): (usize, &[f64; 3])| Grain {
        position: *position,
        radius: radii[i],
        velocity: three(velocity, i),
        spin: three(spin, i),
        generation: whole(generation, i),
        kind: (whole(material, i) as usize).min(kinds.len().saturating_sub(1)),
    };
    Ok(snapshot.position.iter().enumerate().map(grain).collect())
}

/// The grains at the end of a run.
fn final_grains(path: &Path, kinds: &[Kind]) -> Result<Vec<Grain>> {
    let text = read_text_up_to(path, LONGEST)?;
    let words = "x_m, y_m, z_m, r_m, material, and may be generation, vx_m_s, … , wz_rad_s";
    let format =
        Format::<11> { columns: &COLUMNS, needed: 4, positive: 11, label: "material", rows: "grains", words, most: usize::MAX };
    let grain = |row: &crate::scene::number_file::Row<11>| {
        let [x, y, z, radius, generation, a, b, c, d, e, f] = row.numbers;
        let kind = kinds.iter().position(|kind| kind.name == row.label).ok_or_else(|| {
            let place = format!("{} line {}", path.display(), row.line);
            Error::input(place, "material", Some(row.label.clone()), "is no material of the run's scene")
        })?;
        let (velocity, spin, generation) = ([a, b, c], [d, e, f], generation as u32);
        Ok(Grain { position: [x, y, z], radius, velocity, spin, generation, kind })
    };
    format.of_text(path, &text)?.rows.iter().map(grain).collect()
}
