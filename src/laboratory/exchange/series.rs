//! All snapshots of a run once more, small: single precision, rounded, compressed.

use crate::error::{Error, Result};
use crate::record::compact;
use crate::record::snapshot::{Snapshot, list};
use crate::record::vtk::{VtkError, write_collection};
use crate::run::{BLOCKS, COLLECTION, FINES, GRAINS, SNAPSHOTS, WALLS};
use crate::scene::RESOLVED;
use std::path::{Path, PathBuf};

/// Quantities of grains that are kept where none are named.
const OF_GRAINS: [&str; 7] = ["radius", "radius_m", "generation", "material", "force", "mean_stress_Pa", "id"];

/// Writes all snapshots of the run in `dir` small into the folder `out`, which then has the lists and files that the run has. `fields`: quantities
/// to keep; none: of grains radius, generation, material, largest force, mean stress and number, of all else everything. Gives the lists.
///
/// # Errors
/// A folder `out` that is a run's; a run without snapshots, or without one of the fields; damaged snapshots; files that cannot be written.
pub fn write(dir: &Path, out: &Path, fields: &[String]) -> Result<Vec<PathBuf>> {
    if out.join(RESOLVED).exists() {
        return Err(Error::input(out.display(), "", None, "is the folder of a run; the small series needs one of its own"));
    }
    let lists = [COLLECTION, GRAINS, BLOCKS, FINES, WALLS].map(|name| list(&dir.join(name)).map(|snapshots| (name, snapshots)));
    let mut lists: Vec<(&str, Vec<(f64, PathBuf)>)> = lists.into_iter().collect::<Result<_>>()?;
    lists.retain(|(_, snapshots)| !snapshots.is_empty());
    if lists.is_empty() {
        return Err(Error::input(dir.display(), "", None, "has left no snapshots"));
    }
    known(&lists, fields)?;
    let folder = out.join(SNAPSHOTS);
    table::folder(&folder).map_err(Error::write(&folder))?;
    let mut written = Vec::new();
    for (name, snapshots) in &lists {
        let mut listed = Vec::new();
        for (at, path) in snapshots {
            let snapshot = Snapshot::read(path)?;
            let grains = snapshot.array("radius").or(snapshot.array("radius_m")).is_some();
            let keep = |field: &str| match fields {
                [] => !grains || OF_GRAINS.contains(&field),
                named => named.iter().any(|name| name == field),
            };
            let file = Path::new(SNAPSHOTS).join(path.file_name().unwrap_or_default());
            compact::write(&out.join(&file), &snapshot, keep).map_err(VtkError::at(0))?;
            listed.push((*at, file.display().to_string()));
        }
        let path = out.join(name);
        write_collection(&path, &listed).map_err(VtkError::at(0))?;
        written.push(path);
    }
    Ok(written)
}

/// Checks that each of the fields is in the first snapshot of a list: the others of the list have the same.
fn known(lists: &[(&str, Vec<(f64, PathBuf)>)], fields: &[String]) -> Result<()> {
    if fields.is_empty() {
        return Ok(());
    }
    let mut known = std::collections::BTreeSet::new();
    for (_, path) in lists.iter().filter_map(|(_, snapshots)| snapshots.first()) {
        known.extend(Snapshot::read(path)?.arrays.into_iter().map(|array| array.name));
    }
    match fields.iter().find(|name| !known.contains(*name)) {
        Some(name) => {
            let there = known.into_iter().collect::<Vec<_>>().join(", ");
            Err(Error::input("fields", name.clone(), None, format!("no snapshot has it; there are {there}")))
        }
        None => Ok(()),
    }
}
