//! The contacts that were recorded beside a snapshot, as lines for the view in three dimensions.

use super::blob::Blob;
use laboratory::error::{Error, Result};
use plot::Table;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::path::Path;

/// Share of the contacts whose force is at most that of the widest line, as in the figure of force chains.
const MOST: f64 = 0.995;

/// A contact of a grain.
struct Contact {
    /// Place of the grain in its snapshot.
    grain: u32,
    /// Place of the second grain in the snapshot, or number of the wall or point.
    other: u32,
    /// Where the line ends, m; `None`: in the second grain.
    end: Option<[f64; 3]>,
    /// Normal force, N.
    force: f64,
}

/// The contacts of one kind, as a layer of the view.
struct Lines {
    kind: &'static str,
    contacts: Vec<Contact>,
    /// Names of the walls that [`Contact::other`] counts.
    walls: Vec<String>,
}

/// The layers of the contacts that were recorded at the instant of the snapshot at `path`, whose grains have these numbers: contacts of grains with each
/// other and with walls, and contacts of grains with points of the continuum. None where contacts were not recorded. Numbers are added to `blobs`.
///
/// # Errors
/// A table that is damaged, or that names a grain which the snapshot does not have.
pub fn layers(path: &Path, numbers: &[u32], blobs: &mut Vec<String>) -> Result<Vec<Value>> {
    let Some(step) = path.file_stem().and_then(|name| name.to_str()?.rsplit('_').next()) else { return Ok(Vec::new()) };
    let path = path.with_file_name(format!("contacts_{step}.csv"));
    let Some(table) = Table::read_if_there(&path)? else { return Ok(Vec::new()) };
    let lines = read(&path, &table, numbers)?;
    Ok(lines.into_iter().filter(|lines| !lines.contacts.is_empty()).map(|lines| layer(lines, blobs)).collect())
}

fn read(path: &Path, table: &Table, numbers: &[u32]) -> Result<[Lines; 2]> {
    let places: HashMap<u32, u32> = numbers.iter().zip(0..).map(|(&number, place)| (number, place)).collect();
    let place = |number: &str| {
        let known = number.parse().ok().and_then(|number: u32| places.get(&number).copied());
        let unknown = || Error::input(path.display(), "", None, format!("grain {number} is not in the snapshot beside it"));
        known.ok_or_else(unknown)
    };
    let [grain, kinds, others] = [table.texts("a")?, table.texts("kind_b")?, table.texts("b")?];
    let [x, y, z] = [table.numbers("b_x_m")?, table.numbers("b_y_m")?, table.numbers("b_z_m")?];
    let [fx, fy, fz] = [table.numbers("normal_x_N")?, table.numbers("normal_y_N")?, table.numbers("normal_z_N")?];
    let [mut grains, mut points] =
        ["contacts", "point_contacts"].map(|kind| Lines { kind, contacts: Vec::new(), walls: Vec::new() });
    for i in 0..table.len() {
        let force = (fx[i] * fx[i] + fy[i] * fy[i] + fz[i] * fz[i]).sqrt();
        if !(force > 0.0 && force.is_finite()) {
            continue;
        }
        let grain = place(grain[i])?;
        let end = Some([x[i], y[i], z[i]]);
        match kinds[i] {
            "grain" => grains.contacts.push(Contact { grain, other: place(others[i])?, end: None, force }),
            "point" => points.contacts.push(Contact { grain, other: others[i].parse().unwrap_or(u32::MAX), end, force }),
            _ => {
                let at = grains.walls.iter().position(|name| name == others[i]).unwrap_or_else(|| {
                    grains.walls.push(others[i].to_string());
                    grains.walls.len() - 1
                });
                grains.contacts.push(Contact { grain, other: at as u32, end, force });
            }
        }
    }
    // those that end in a grain come first
    grains.contacts.sort_by_key(|contact| contact.end.is_some());
    Ok([grains, points])
}

fn layer(lines: Lines, blobs: &mut Vec<String>) -> Value {
    let Lines { kind, contacts, walls } = lines;
    let mut blob = Blob::default();
    let grain = blob.whole(contacts.iter().map(|contact| contact.grain));
    let other = blob.whole(contacts.iter().map(|contact| contact.other));
    let force = blob.real(contacts.iter().map(|contact| contact.force));
    let end = blob.real(contacts.iter().filter_map(|contact| contact.end).flatten());
    let mut forces: Vec<f64> = contacts.iter().map(|contact| contact.force).collect();
    forces.sort_by(f64::total_cmp);
    let value = json!({
        "kind": kind,
        "count": contacts.len(),
        "between": contacts.iter().filter(|contact| contact.end.is_none()).count(),
        "blob": blobs.len(),
        "places": { "grain": grain, "other": other, "force": force, "end": end },
        "fields": {},
        "walls": walls,
        "large": forces[(MOST * (forces.len() - 1) as f64).round() as usize],
    });
    blobs.push(blob.text());
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "a,kind_b,b,b_x_m,b_y_m,b_z_m,normal_x_N,normal_y_N,normal_z_N\n";

    fn of(rows: &str) -> (Result<Vec<Value>>, Vec<String>) {
        let dir = tempfile::tempdir().expect("folder");
        std::fs::write(dir.path().join("contacts_00000007.csv"), format!("# time_s = 1\n{HEAD}{rows}")).expect("written");
        let mut blobs = vec![String::new()];
        let layers = layers(&dir.path().join("step_00000007.vtp"), &[4, 9], &mut blobs);
        (layers, blobs)
    }

    #[test]
    fn contacts_name_the_grains_of_the_snapshot_and_where_they_end() {
        let rows = "9,wall,top,1,2,3,0,0,-5\n4,grain,9,0,0,0,3,0,4\n4,point,77,6,7,8,0,2,0\n4,grain,9,0,0,0,0,0,0\n";
        let (layers, blobs) = of(rows);
        let layers = layers.expect("read");
        let kinds: Vec<_> = layers.iter().map(|layer| (layer["kind"].as_str(), layer["count"].as_u64())).collect();
        assert_eq!(kinds, [(Some("contacts"), Some(2)), (Some("point_contacts"), Some(1))]);
        assert_eq!((layers[0]["between"].as_u64(), &layers[0]["walls"]), (Some(1), &json!(["top"])));
        let words = |layer: &Value| super::super::blob::tests::words(&blobs[layer["blob"].as_u64().expect("blob") as usize]);
        let real = |values: &[f32]| values.iter().map(|x| x.to_bits()).collect::<Vec<u32>>();
        // grains, the others, forces, ends
        assert_eq!(words(&layers[0]), [&[0, 1, 1, 0][..], &real(&[5.0, 5.0, 1.0, 2.0, 3.0])].concat());
        assert_eq!(words(&layers[1]), [&[0, 77][..], &real(&[2.0, 6.0, 7.0, 8.0])].concat());
    }

    #[test]
    fn a_grain_that_the_snapshot_does_not_have_is_named() {
        let error = of("5,grain,9,0,0,0,1,0,0\n").0.expect_err("refused").to_string();
        assert!(error.contains("contacts_00000007.csv") && error.contains("grain 5 is not in the snapshot"), "{error}");
        assert!(of("").0.expect("none").is_empty());
    }
}
