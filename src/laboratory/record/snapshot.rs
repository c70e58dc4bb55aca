//! Snapshots read back: the numbers of the `.vtp` files and the entries of the `.pvd` lists that runs leave for ParaView.

use super::compact;
use crate::error::{Error, Result};
use crate::run::SNAPSHOTS;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Component, Path};

/// Longest file, bytes.
const LONGEST: u64 = 1 << 32;

/// The numbers of an array of a snapshot.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Name.
    pub name: String,
    /// Numbers for each point or triangle: 1 for a scalar, 3 for a vector, 6 for a symmetric tensor.
    pub components: usize,
    /// All numbers, point by point or triangle by triangle.
    pub values: Vec<f64>,
}

/// What one `.vtp` file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// What is noted of the instant, such as `sigma_v_kPa`: name and value.
    pub facts: Vec<(String, f64)>,
    /// Centres of grains, places of points or corners of triangles, m.
    pub position: Vec<[f64; 3]>,
    /// Corners of each triangle as indices of `position`; empty for grains and points.
    pub triangles: Vec<[u32; 3]>,
    /// Arrays with numbers for each triangle, or for each grain or point where there are no triangles.
    pub arrays: Vec<Array>,
}

impl Snapshot {
    /// The array `name`, if the snapshot has it.
    pub fn array(&self, name: &str) -> Option<&Array> {
        self.arrays.iter().find(|array| array.name == name)
    }

    /// What is noted as `name`.
    pub fn fact(&self, name: &str) -> Option<f64> {
        self.facts.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }

    /// Reads a `.vtp` file that a run has left.
    ///
    /// # Errors
    /// A file that cannot be read; one that is cut short or is not what a run writes, by name.
    pub fn read(path: &Path) -> Result<Snapshot> {
        let bytes = table::read_up_to(path, LONGEST).map_err(Error::read(path))?;
        let damaged = |what: String| Error::input(path.display(), "", None, format!("is no whole snapshot: {what}"));
        let bytes = bytes.ok_or_else(|| damaged(format!("it is longer than {} GiB", LONGEST >> 30)))?;
        parse(&bytes).map_err(damaged)
    }
}

/// The text up to the appended bytes, and these.
fn halves(file: &[u8]) -> std::result::Result<(&str, &[u8]), String> {
    const MARK: &[u8] = b"<AppendedData encoding=\"raw\">\n_";
    let at = file.windows(MARK.len()).position(|w| w == MARK).ok_or("its numbers are missing")?;
    let text = std::str::from_utf8(&file[..at]).map_err(|_| "its head is no text")?;
    Ok((text, &file[at + MARK.len()..]))
}

fn parse(file: &[u8]) -> std::result::Result<Snapshot, String> {
    let (head, numbers) = halves(file)?;
    let packed = head.contains(compact::COMPRESSOR);
    let mut found = Snapshot::default();
    let mut ends = Vec::new();
    let mut section = "";
    for tag in head.split('<').skip(1) {
        let (tag, text) = tag.split_once('>').ok_or("a tag has no end")?;
        let kind = tag.split_whitespace().next().unwrap_or_default();
        if ["FieldData", "PointData", "CellData", "Points", "Verts", "Polys"].contains(&kind) {
            section = kind;
        }
        if kind != "DataArray" {
            continue;
        }
        let of = attributes(tag);
        let word = |key: &str| of.get(key).copied().ok_or_else(|| format!("an array has no {key}"));
        let name = word("Name")?;
        if section == "FieldData" {
            let value = text.trim().parse().map_err(|_| format!("{name} = {text} is no number"))?;
            found.facts.push((name.into(), value));
            continue;
        }
        let whole = |key: &str| word(key)?.parse::<usize>().map_err(|_| format!("{key} of {name} is no number"));
        let (offset, cut) = (whole("offset")?, || format!("{name} is cut short"));
        let bytes = match packed {
            true => Cow::Owned(compact::unpack(numbers.get(offset..).ok_or_else(cut)?).ok_or_else(cut)?),
            false => Cow::Borrowed(blob(numbers, offset).ok_or_else(cut)?),
        };
        let values = decode(word("type")?, &bytes).ok_or_else(|| format!("{name} is of another kind"))?;
        match (section, name) {
            ("Points", _) => found.position = values.as_chunks::<3>().0.to_vec(),
            ("Polys", "connectivity") => ends = values,
            ("PointData" | "CellData", _) => {
                found.arrays.push(Array { name: name.into(), components: whole("NumberOfComponents")?.max(1), values });
            }
            _ => {}
        }
    }
    let corners = found.position.len();
    let corner = |x: &f64| (0.0..corners as f64).contains(x).then_some(*x as u32);
    let ends: Option<Vec<u32>> = ends.iter().map(corner).collect();
    found.triangles = ends.ok_or("a triangle has a corner that is not there")?.as_chunks::<3>().0.to_vec();
    let n = if found.triangles.is_empty() { corners } else { found.triangles.len() };
    match found.arrays.iter().find(|a| n.checked_mul(a.components) != Some(a.values.len())) {
        Some(a) => Err(format!("{} has {} values, {n} times {} expected", a.name, a.values.len(), a.components)),
        None => Ok(found),
    }
}

/// The bytes of the array whose length stands at `offset`.
fn blob(numbers: &[u8], offset: usize) -> Option<&[u8]> {
    let (length, rest) = numbers.get(offset..)?.split_first_chunk::<8>()?;
    rest.get(..usize::try_from(u64::from_le_bytes(*length)).ok()?)
}

/// The numbers of an array of a type that snapshots have.
fn decode(kind: &str, bytes: &[u8]) -> Option<Vec<f64>> {
    let eight = |of: fn([u8; 8]) -> f64| {
        let (chunks, rest) = bytes.as_chunks::<8>();
        rest.is_empty().then(|| chunks.iter().map(|c| of(*c)).collect())
    };
    let four = |of: fn([u8; 4]) -> f64| {
        let (chunks, rest) = bytes.as_chunks::<4>();
        rest.is_empty().then(|| chunks.iter().map(|c| of(*c)).collect())
    };
    match kind {
        "Float64" => eight(f64::from_le_bytes),
        "Int64" => eight(|b| i64::from_le_bytes(b) as f64),
        "UInt64" => eight(|b| u64::from_le_bytes(b) as f64),
        "UInt32" => four(|b| f64::from(u32::from_le_bytes(b))),
        "Int32" => four(|b| f64::from(i32::from_le_bytes(b))),
        "Float32" => four(|b| f64::from(f32::from_le_bytes(b))),
        "UInt8" => Some(bytes.iter().map(|b| f64::from(*b)).collect()),
        _ => None,
    }
}

/// The attributes of a tag, `name="value"`.
fn attributes(tag: &str) -> BTreeMap<&str, &str> {
    let mut pieces = tag.split('"');
    let mut found = BTreeMap::new();
    while let (Some(before), Some(value)) = (pieces.next(), pieces.next()) {
        let name = before.trim().trim_end_matches('=');
        found.insert(name.rsplit(' ').next().unwrap_or(name), value);
    }
    found
}

/// The snapshots that a `.pvd` list names, each with its value on ParaView's time axis and its file; empty where there is no such
/// list.
///
/// # Errors
/// A list that cannot be read; one that names a file outside of the run's folder.
pub fn list(path: &Path) -> Result<Vec<(f64, std::path::PathBuf)>> {
    if !path.is_file() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(path).map_err(Error::read(path))?;
    let folder = path.parent().unwrap_or(Path::new("."));
    text.split("<DataSet ")
        .skip(1)
        .map(|tag| {
            let of = attributes(tag.split('>').next().unwrap_or_default());
            let file = Path::new(of.get("file").copied().unwrap_or_default());
            let value = of.get("timestep").and_then(|value| value.parse::<f64>().ok());
            let inside = file.starts_with(SNAPSHOTS) && file.components().all(|part| matches!(part, Component::Normal(_)));
            match value.filter(|value| value.is_finite() && inside) {
                Some(value) => Ok((value, folder.join(file))),
                None => Err(Error::input(path.display(), "", None, format!("is no list of snapshots in {SNAPSHOTS}/"))),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::vtk::tests::two_grains;
    use super::super::vtk::{Field, SnapshotData, write_collection, write_snapshot, write_surfaces};
    use super::*;

    fn grains() -> SnapshotData {
        SnapshotData { id: vec![7, 8], ..two_grains() }
    }

    #[test]
    fn what_was_written_is_read_back() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("a.vtp");
        write_snapshot(&path, &[("sigma_v_kPa", 12.5)], &grains()).expect("written");
        let read = Snapshot::read(&path).expect("read");
        assert_eq!(read.position, grains().position);
        assert_eq!(read.array("radius").expect("radius").values, grains().radius);
        assert_eq!(read.array("strength").expect("strength").values, grains().strength);
        assert_eq!(read.array("generation").expect("generation").values, [0.0, 3.0]);
        assert_eq!(read.array("velocity").map(|a| (a.components, a.values[5])), Some((3, 6.0)));
        assert_eq!(read.array("mother_id").expect("mother").values, [-1.0, 7.0]);
        assert_eq!((read.fact("sigma_v_kPa"), read.fact("step")), (Some(12.5), None));
        assert!(read.triangles.is_empty());
        let field = [Field { name: "speed", components: 1, values: vec![4.0] }];
        write_surfaces(&path, &[], &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]], &field).expect("written");
        let read = Snapshot::read(&path).expect("read");
        assert_eq!((read.triangles.as_slice(), read.arrays[0].values.as_slice()), (&[[0, 1, 2]][..], &[4.0][..]));
    }

    #[test]
    fn damaged_files_are_named_and_do_not_panic() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("a.vtp");
        write_snapshot(&path, &[], &grains()).expect("written");
        let whole = std::fs::read(&path).expect("read");
        let end = whole.windows(9).position(|w| w == b"\n</Append").expect("end");
        for cut in 0..end {
            std::fs::write(&path, &whole[..cut]).expect("cut");
            let error = Snapshot::read(&path).expect_err("cut short").to_string();
            assert!(error.contains("a.vtp") && error.contains("is no whole snapshot"), "{error}");
        }
        let mut other = whole.clone();
        let kind = b"UInt64\" Name=\"id\"";
        let at = whole.windows(kind.len()).position(|w| w == kind).expect("array");
        other[at..at + 6].copy_from_slice(b"UInt16");
        std::fs::write(&path, other).expect("changed");
        assert!(Snapshot::read(&path).expect_err("kind").to_string().contains("id is of another kind"));
    }

    #[test]
    fn lists_name_files_below_their_folder_only() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("a.pvd");
        assert!(list(&path).expect("none").is_empty());
        write_collection(&path, &[(0.0, "snapshots/step_1.vtp".into()), (2.5, "snapshots/step_2.vtp".into())]).expect("ok");
        let read = list(&path).expect("read");
        assert_eq!((read[1].0, read[1].1.as_path()), (2.5, dir.path().join("snapshots/step_2.vtp").as_path()));
        for bad in ["/etc/passwd", "snapshots/../../x.vtp", "x.vtp"] {
            write_collection(&path, &[(0.0, bad.into())]).expect("ok");
            assert!(list(&path).expect_err(bad).to_string().contains("a.pvd"));
        }
    }
}
