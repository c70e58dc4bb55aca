//! Snapshots for ParaView: one `.vtp` file for each instant (VTK XML PolyData, one vertex for each grain or point, arrays
//! appended as raw little-endian binary, stress and strain of the instant as field data), and one `.pvd` file that lists them.

use crate::error::Error;
use std::fmt::Write as _;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Why a snapshot could not be written.
#[derive(Debug, thiserror::Error)]
pub enum VtkError {
    /// An array has a wrong number of values.
    #[error("{path}: snapshot array {array} has {have} values, {want} expected")]
    Length {
        /// The file.
        path: String,
        /// Name of the array.
        array: &'static str,
        /// Number of its values.
        have: usize,
        /// Number that the bodies of the snapshot need.
        want: usize,
    },
    /// A number is not finite.
    #[error("{path}: {array} of entry {entry} is not finite; nothing was written")]
    NotFinite {
        /// The file.
        path: String,
        /// Name of the array.
        array: &'static str,
        /// Number of the body in the file, from 0.
        entry: usize,
    },
    /// The file cannot be written.
    #[error("{}: cannot write: {source}", .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}

impl VtkError {
    /// The error of a run that met this one while it wrote a snapshot at step `step`.
    pub fn at(step: u64) -> impl Fn(VtkError) -> Error + Copy {
        move |error| match error {
            VtkError::Io { path, source } => Error::Write { path, source },
            VtkError::NotFinite { .. } => Error::Unstable { step, what: error.to_string(), grain: None },
            VtkError::Length { .. } => Error::Failed { step, what: error.to_string() },
        }
    }
}

/// Checks that all numbers of an array are finite; `components`: numbers for each entry.
fn finite(path: &Path, array: &'static str, components: usize, values: &[f64]) -> Result<(), VtkError> {
    match values.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(at) => Err(VtkError::NotFinite { path: path.display().to_string(), array, entry: at / components }),
    }
}

/// A number that is noted in a snapshot: its name, which ends in the unit, and its value. Values that are not finite are left
/// out.
pub type Fact = (&'static str, f64);

/// The grains of one snapshot; every array has one entry for each grain.
#[derive(Clone, Debug, Default)]
pub struct SnapshotData {
    /// Centres, m.
    pub position: Vec<[f64; 3]>,
    /// Radii, m.
    pub radius: Vec<f64>,
    /// 0 = initial grain, 1 = its daughters, and so on.
    pub generation: Vec<u32>,
    /// Limit strength of the grain, Pa (infinite for a grain that cannot break).
    pub strength: Vec<f64>,
    /// Largest normal contact force on the grain, N.
    pub force: Vec<f64>,
    /// Velocity of the centre, m/s.
    pub velocity: Vec<[f64; 3]>,
    /// Persistent grain number.
    pub id: Vec<u64>,
    /// Mean stress from the contact forces over the grain's volume, Pa, compression positive.
    pub mean_stress: Vec<f64>,
    /// Number of the mother; -1 for an initial grain.
    pub mother: Vec<i64>,
    /// Number of the initial grain from which the grain descends.
    pub ancestor: Vec<i64>,
}

impl SnapshotData {
    /// Number of grains.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    fn check(&self, path: &Path) -> Result<(), VtkError> {
        let want = self.len();
        for (array, have) in [
            ("radius", self.radius.len()),
            ("generation", self.generation.len()),
            ("strength", self.strength.len()),
            ("force", self.force.len()),
            ("velocity", self.velocity.len()),
            ("id", self.id.len()),
            ("mean_stress_Pa", self.mean_stress.len()),
            ("mother_id", self.mother.len()),
            ("ancestor_id", self.ancestor.len()),
        ] {
            if have != want {
                let path = path.display().to_string();
                return Err(VtkError::Length { path, array, have, want });
            }
        }
        // a grain that cannot break has an infinite strength
        finite(path, "Points", 3, self.position.as_flattened())?;
        finite(path, "velocity", 3, self.velocity.as_flattened())?;
        finite(path, "radius", 1, &self.radius)?;
        finite(path, "force", 1, &self.force)?;
        finite(path, "mean_stress_Pa", 1, &self.mean_stress)
    }
}

/// Writes one snapshot of grains as `.vtp` with the point data `radius` (m), `generation`, `strength` (Pa), `force` (N),
/// `velocity` (m/s, 3 components), `id`, `mean_stress_Pa`, `mother_id` and `ancestor_id`.
///
/// # Errors
/// Arrays of unequal length; a file that cannot be written.
pub fn write_snapshot(path: &Path, facts: &[Fact], points: &SnapshotData) -> Result<(), VtkError> {
    points.check(path)?;
    let n = points.len();
    let (xml, arrays) = document(facts, points, n);
    arrays.write(path, &xml)
}

/// A quantity of the points or triangles of a snapshot.
pub struct Field {
    /// Name, which ends in the unit.
    pub name: &'static str,
    /// Numbers for each point: 1 for a scalar, 3 for a vector, 6 for a symmetric tensor.
    pub components: usize,
    /// All numbers, point by point.
    pub values: Vec<f64>,
}

/// Checks that every field has its numbers, finite ones, for each of `n` points.
fn check_fields(path: &Path, fields: &[Field], n: usize) -> Result<(), VtkError> {
    match fields.iter().find(|field| field.values.len() != n * field.components) {
        // a grain that cannot break has an infinite strength
        None => fields
            .iter()
            .filter(|field| field.name != "strength_Pa")
            .try_for_each(|field| finite(path, field.name, field.components, &field.values)),
        Some(field) => {
            let (path, array) = (path.display().to_string(), field.name);
            Err(VtkError::Length { path, array, have: field.values.len(), want: n * field.components })
        }
    }
}

/// Writes points at `position`, m, with these fields as `.vtp`.
///
/// # Errors
/// A field of wrong length; a file that cannot be written.
pub fn write_points(path: &Path, facts: &[Fact], position: &[[f64; 3]], fields: &[Field]) -> Result<(), VtkError> {
    let n = position.len();
    check_fields(path, fields, n)?;
    finite(path, "Points", 3, position.as_flattened())?;
    let mut arrays = Arrays::default();
    let mut xml = head(facts, n, n, 0) + "<PointData>\n";
    for field in fields {
        xml += &arrays.add("Float64", field.name, field.components, bytes(&field.values));
    }
    xml += "</PointData>\n";
    xml += &arrays.tail(position);
    arrays.write(path, &xml)
}

/// Writes triangles (indices of their `corners`, m) as `.vtp`; each field has its numbers for each triangle.
///
/// # Errors
/// A field of wrong length; a file that cannot be written.
pub fn write_surfaces(
    path: &Path,
    facts: &[Fact],
    corners: &[[f64; 3]],
    triangles: &[[u32; 3]],
    fields: &[Field],
) -> Result<(), VtkError> {
    let n = triangles.len();
    check_fields(path, fields, n)?;
    finite(path, "Points", 3, corners.as_flattened())?;
    let mut arrays = Arrays::default();
    let mut xml = head(facts, corners.len(), 0, n) + "<CellData>\n";
    for field in fields {
        xml += &arrays.add("Float64", field.name, field.components, bytes(&field.values));
    }
    xml += "</CellData>\n<Points>\n";
    xml += &arrays.add("Float64", "Points", 3, bytes(corners.as_flattened()));
    xml += "</Points>\n<Polys>\n";
    let ends: Vec<u8> = triangles.as_flattened().iter().flat_map(|&k| i64::from(k).to_le_bytes()).collect();
    xml += &arrays.add("Int64", "connectivity", 1, ends);
    xml += &arrays.add("Int64", "offsets", 1, (1..=n as i64).flat_map(|k| (3 * k).to_le_bytes()).collect());
    xml += "</Polys>\n";
    xml += END;
    arrays.write(path, &xml)
}

/// Writes a `.pvd` list: for each snapshot its value on ParaView's time axis (its number from 0, or seconds; increasing) and its
/// file name relative to the list.
///
/// # Errors
/// A file that cannot be written.
pub fn write_collection(path: &Path, snapshots: &[(f64, String)]) -> Result<(), VtkError> {
    let mut xml = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<Collection>\n",
    );
    for (value, name) in snapshots {
        let _ = writeln!(xml, "<DataSet timestep=\"{value}\" group=\"\" part=\"0\" file=\"{}\"/>", escape(name));
    }
    xml.push_str("</Collection>\n</VTKFile>\n");
    table::write(path, xml).map_err(|source| VtkError::Io { path: path.into(), source })
}

/// The binary arrays of a file, in the order of their offsets.
#[derive(Default)]
pub(super) struct Arrays {
    /// What stands before each array, and its bytes.
    blobs: Vec<(Vec<u8>, Vec<u8>)>,
    offset: usize,
}

impl Arrays {
    /// Adds an array as it is and returns the line that declares it.
    fn add(&mut self, kind: &str, name: &str, components: usize, blob: Vec<u8>) -> String {
        self.put(kind, name, components, (blob.len() as u64).to_le_bytes().to_vec(), blob)
    }

    /// Adds the bytes of an array, as its file has them, behind their `head`, and returns the line that declares it.
    pub(super) fn put(&mut self, kind: &str, name: &str, components: usize, head: Vec<u8>, blob: Vec<u8>) -> String {
        let line = format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" \
             offset=\"{}\"/>\n",
            self.offset
        );
        self.offset += head.len() + blob.len();
        self.blobs.push((head, blob));
        line
    }

    /// Positions, a vertex for each, and the end of the XML.
    fn tail(&mut self, position: &[[f64; 3]]) -> String {
        let n = position.len();
        let mut xml = String::from("<Points>\n");
        xml += &self.add("Float64", "Points", 3, bytes(position.as_flattened()));
        xml += "</Points>\n<Verts>\n";
        xml += &self.add("Int64", "connectivity", 1, counting(0, n));
        xml += &self.add("Int64", "offsets", 1, counting(1, n));
        xml += "</Verts>\n";
        xml += END;
        xml
    }

    /// Writes the file with its XML before the arrays.
    pub(super) fn write(&self, path: &Path, xml: &str) -> Result<(), VtkError> {
        let write = || -> io::Result<()> {
            let mut out = BufWriter::new(table::create(path)?);
            out.write_all(xml.as_bytes())?;
            for (head, blob) in &self.blobs {
                out.write_all(head)?;
                out.write_all(blob)?;
            }
            out.write_all(b"\n</AppendedData>\n</VTKFile>\n")?;
            out.flush()
        };
        write().map_err(|source| VtkError::Io { path: path.into(), source })
    }
}

/// What stands between the last array of the XML and the bytes.
pub(super) const END: &str = "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";

fn head(facts: &[Fact], points: usize, vertices: usize, triangles: usize) -> String {
    head_with("", facts, points, vertices, triangles)
}

/// The XML up to the first array; `compressor`: the attribute that says how bytes are packed, with a blank before it.
pub(super) fn head_with(compressor: &str, facts: &[(&str, f64)], points: usize, vertices: usize, triangles: usize) -> String {
    let one = |(name, value): &(&str, f64)| {
        format!("<DataArray type=\"Float64\" Name=\"{name}\" NumberOfTuples=\"1\" format=\"ascii\">{value:?}</DataArray>\n")
    };
    let known: String = facts.iter().filter(|(_, value)| value.is_finite()).map(one).collect();
    let known = if known.is_empty() { known } else { format!("<FieldData>\n{known}</FieldData>\n") };
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\"{compressor}>\n<PolyData>\n{known}<Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"{vertices}\" NumberOfLines=\"0\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"{triangles}\">\n"
    )
}

/// The XML up to the start of the appended bytes, and the arrays.
fn document(facts: &[Fact], points: &SnapshotData, n: usize) -> (String, Arrays) {
    let mut arrays = Arrays::default();
    let mut xml = head(facts, n, n, 0) + "<PointData Scalars=\"generation\" Vectors=\"velocity\">\n";
    xml += &arrays.add("Float64", "radius", 1, bytes(&points.radius));
    xml += &arrays.add("UInt32", "generation", 1, points.generation.iter().flat_map(|v| v.to_le_bytes()).collect());
    xml += &arrays.add("Float64", "strength", 1, bytes(&points.strength));
    xml += &arrays.add("Float64", "force", 1, bytes(&points.force));
    xml += &arrays.add("Float64", "velocity", 3, bytes(points.velocity.as_flattened()));
    xml += &arrays.add("UInt64", "id", 1, points.id.iter().flat_map(|v| v.to_le_bytes()).collect());
    xml += &arrays.add("Float64", "mean_stress_Pa", 1, bytes(&points.mean_stress));
    for (name, numbers) in [("mother_id", &points.mother), ("ancestor_id", &points.ancestor)] {
        xml += &arrays.add("Int64", name, 1, numbers.iter().flat_map(|v| v.to_le_bytes()).collect());
    }
    xml += "</PointData>\n";
    xml += &arrays.tail(&points.position);
    (xml, arrays)
}

fn bytes(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn counting(first: i64, n: usize) -> Vec<u8> {
    (first..).take(n).flat_map(|v: i64| v.to_le_bytes()).collect()
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Two grains with all fields.
    pub fn two_grains() -> SnapshotData {
        SnapshotData {
            position: vec![[0.1, 0.2, 0.3], [-1.0, -2.0, -3.0]],
            radius: vec![0.5, 0.25],
            generation: vec![0, 3],
            strength: vec![2e6, f64::INFINITY],
            force: vec![10.0, 0.0],
            velocity: vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]],
            id: vec![7, u64::from(u32::MAX) + 5],
            mean_stress: vec![2e5, 0.0],
            mother: vec![-1, 7],
            ancestor: vec![7, 7],
        }
    }

    /// Finds the array by its name in the XML and reads its bytes at the stated offset.
    pub fn array(file: &[u8], name: &str) -> Vec<u8> {
        let text = String::from_utf8_lossy(file);
        let tag = text.split("<DataArray ").find(|t| t.contains(&format!("Name=\"{name}\""))).expect("array is declared");
        let offset = tag.split("offset=\"").nth(1).and_then(|t| t.split('"').next());
        let offset: usize = offset.expect("offset").parse().expect("number");
        let mark = b"encoding=\"raw\">\n_";
        let start = file.windows(mark.len()).position(|w| w == mark).expect("mark") + mark.len();
        let at = start + offset;
        let n = u64::from_le_bytes(file[at..at + 8].try_into().expect("8 bytes")) as usize;
        file[at + 8..at + 8 + n].to_vec()
    }

    pub fn numbers(bytes: &[u8]) -> Vec<f64> {
        let (chunks, rest) = bytes.as_chunks::<8>();
        assert!(rest.is_empty());
        chunks.iter().map(|c| f64::from_le_bytes(*c)).collect()
    }

    #[test]
    fn every_array_is_found_at_its_stated_offset() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("a.vtp");
        write_snapshot(&path, &[("sigma_v_kPa", 12.5), ("axial_strain", f64::NAN)], &two_grains()).expect("written");
        let file = std::fs::read(&path).expect("read");
        let text = String::from_utf8_lossy(&file);
        assert!(text.contains("Name=\"sigma_v_kPa\" NumberOfTuples=\"1\" format=\"ascii\">12.5<") && !text.contains("NaN"));
        assert_eq!(numbers(&array(&file, "mean_stress_Pa")), [2e5, 0.0]);
        assert_eq!(array(&file, "mother_id")[..8], (-1i64).to_le_bytes());
        assert_eq!(numbers(&array(&file, "radius")), [0.5, 0.25]);
        assert_eq!(numbers(&array(&file, "Points")), [0.1, 0.2, 0.3, -1.0, -2.0, -3.0]);
        assert_eq!(numbers(&array(&file, "velocity")), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(array(&file, "generation"), [0, 0, 0, 0, 3, 0, 0, 0]);
        assert_eq!(array(&file, "id")[8..], 4_294_967_300u64.to_le_bytes());
        assert_eq!(array(&file, "offsets")[..8], 1i64.to_le_bytes());
        assert!(file.ends_with(b"</AppendedData>\n</VTKFile>\n"));
    }

    #[test]
    fn unequal_arrays_are_refused_by_name() {
        let mut data = two_grains();
        data.force.pop();
        let error = write_snapshot(Path::new("unused.vtp"), &[], &data).expect_err("refused");
        assert_eq!(error.to_string(), "unused.vtp: snapshot array force has 1 values, 2 expected");
    }

    #[test]
    fn collection_names_are_escaped() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("a.pvd");
        write_collection(&path, &[(5.0, "a&b.vtp".into()), (12.5, "c.vtp".into())]).expect("ok");
        let text = std::fs::read_to_string(&path).expect("read");
        assert!(text.contains("timestep=\"12.5\""));
        assert!(text.contains("file=\"a&amp;b.vtp\""));
    }
}
