//! Small snapshots for ParaView: what a snapshot of a run holds, in single precision, rounded to so many binary digits and compressed
//! by LZMA (VTK's `vtkLZMADataCompressor`). Whole numbers stay what they are.

use super::snapshot::Snapshot;
use super::vtk::{Arrays, END, VtkError, head_with};
use lzma_rust2::{CheckType, LzmaOptions, XzOptions, XzReader, XzWriter};
use std::io::{Read, Write};
use std::path::Path;

/// The class of VTK that unpacks these files.
pub const COMPRESSOR: &str = "compressor=\"vtkLZMADataCompressor\"";

/// Bytes of an array that are compressed together.
const BLOCK: usize = 1 << 20;
/// Most bytes of an array after it was unpacked.
const LONGEST: usize = 1 << 32;
/// Places are kept to this share of the largest side of the box around all of them, at most: half of it is the largest error.
const PLACES: f64 = 1.0 / 65_536.0;
/// Whole numbers up to here are exact.
const WHOLE: f64 = 9_007_199_254_740_992.0;
/// Binary digits of a radius (largest relative error 2⁻¹⁰, 0.1 %), and of any other number that is not whole (2⁻⁸, 0.4 %).
const DIGITS: [i32; 2] = [10, 8];

/// Writes the snapshot `of` as a small `.vtp`, with those of its arrays that `keep` wants.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, of: &Snapshot, keep: impl Fn(&str) -> bool) -> Result<(), VtkError> {
    let facts: Vec<(&str, f64)> = of.facts.iter().map(|(name, value)| (name.as_str(), *value)).collect();
    let (n, surface) = (of.position.len(), !of.triangles.is_empty());
    let (vertices, section) = if surface { (0, "CellData") } else { (n, "PointData") };
    let mut arrays = Arrays::default();
    let mut xml = head_with(&format!(" {COMPRESSOR}"), &facts, n, vertices, of.triangles.len());
    let mut add = |kind: &str, name: &str, components: usize, bytes: &[u8]| -> std::io::Result<String> {
        let (head, blob) = pack(bytes, width(kind))?;
        Ok(arrays.put(kind, name, components, head, blob))
    };
    let mut body = || -> std::io::Result<()> {
        xml += &format!("<{section}>\n");
        for array in of.arrays.iter().filter(|array| keep(&array.name)) {
            let (kind, bytes) = numbers(&array.values, DIGITS[usize::from(!array.name.starts_with("radius"))]);
            xml += &add(kind, &array.name, array.components, &bytes)?;
        }
        xml += &format!("</{section}>\n<Points>\n");
        xml += &add("Float32", "Points", 3, &places(&of.position))?;
        let (cells, corners) = if surface { ("Polys", 3) } else { ("Verts", 1) };
        let count = if surface { of.triangles.len() } else { n };
        let whole = |values: &mut dyn Iterator<Item = u32>| values.flat_map(u32::to_le_bytes).collect::<Vec<u8>>();
        let ends = match surface {
            true => whole(&mut of.triangles.as_flattened().iter().copied()),
            false => whole(&mut (0..n as u32)),
        };
        xml += &format!("</Points>\n<{cells}>\n");
        xml += &add("Int32", "connectivity", 1, &ends)?;
        xml += &add("Int32", "offsets", 1, &whole(&mut (1..=count as u32).map(|k| corners * k)))?;
        xml += &format!("</{cells}>\n{END}");
        Ok(())
    };
    body().map_err(|source| VtkError::Io { path: path.into(), source })?;
    arrays.write(path, &xml)
}

/// Bytes of a number of an array of this kind.
fn width(kind: &str) -> u32 {
    match kind {
        "UInt8" => 1,
        "Int64" => 8,
        _ => 4,
    }
}

/// The kind of an array and its bytes: whole numbers in 8, 32 or 64 bits where they fit, others in single precision with so many binary
/// digits.
fn numbers(values: &[f64], digits: i32) -> (&'static str, Vec<u8>) {
    let all = |low: f64, high: f64| values.iter().all(|x| (low..=high).contains(x) && x.fract() == 0.0);
    if all(0.0, f64::from(u8::MAX)) {
        ("UInt8", values.iter().map(|x| *x as u8).collect())
    } else if all(0.0, f64::from(u32::MAX)) {
        ("UInt32", values.iter().flat_map(|x| (*x as u32).to_le_bytes()).collect())
    } else if all(f64::from(i32::MIN), f64::from(i32::MAX)) {
        ("Int32", values.iter().flat_map(|x| (*x as i32).to_le_bytes()).collect())
    } else if all(-WHOLE, WHOLE) {
        ("Int64", values.iter().flat_map(|x| (*x as i64).to_le_bytes()).collect())
    } else {
        ("Float32", values.iter().flat_map(|x| rounded(*x as f32, digits).to_le_bytes()).collect())
    }
}

/// The number with so many binary digits, to the nearest.
fn rounded(x: f32, digits: i32) -> f32 {
    let cut = (24 - digits) as u32;
    if !x.is_finite() {
        return x;
    }
    let half = 1_u32 << (cut - 1);
    f32::from_bits(x.to_bits().saturating_add(half) & !((1 << cut) - 1))
}

/// The bytes of places, each a multiple of a power of two that is at most [`PLACES`] of the largest side of their box.
fn places(position: &[[f64; 3]]) -> Vec<u8> {
    let side = |a: usize| {
        let low = position.iter().map(|p| p[a]).fold(f64::INFINITY, f64::min);
        position.iter().map(|p| p[a]).fold(f64::NEG_INFINITY, f64::max) - low
    };
    let size = side(0).max(side(1)).max(side(2)) * PLACES;
    // a box without a size keeps its places as they are
    let step = if size >= f64::MIN_POSITIVE { f64::from_bits(size.to_bits() & !((1 << 52) - 1)) } else { 0.0 };
    let kept = |x: f64| if step > 0.0 { (x / step).round() * step } else { x };
    position.as_flattened().iter().flat_map(|x| (kept(*x) as f32).to_le_bytes()).collect()
}

/// What VTK wants before a compressed array (number of blocks, their size, that of the last where it is smaller, the size of each when
/// compressed), and its blocks. `width`: bytes of a number.
fn pack(bytes: &[u8], width: u32) -> std::io::Result<(Vec<u8>, Vec<u8>)> {
    let part = bytes.len() % BLOCK;
    let mut head = vec![bytes.len().div_ceil(BLOCK), BLOCK, part];
    let mut packed = Vec::new();
    for block in bytes.chunks(BLOCK) {
        let before = packed.len();
        // the bytes of a number are alike to those at the same place of the next one
        let bits = width.trailing_zeros();
        let lzma_options = LzmaOptions { dict_size: BLOCK as u32, lc: 3 - bits, lp: bits, pb: bits, ..LzmaOptions::with_preset(6) };
        let mut options = XzOptions { lzma_options, ..XzOptions::default() };
        options.set_check_sum_type(CheckType::Crc32);
        let mut writer = XzWriter::new(&mut packed, options)?;
        writer.write_all(block)?;
        writer.finish()?;
        head.push(packed.len() - before);
    }
    Ok((head.into_iter().flat_map(|n| (n as u64).to_le_bytes()).collect(), packed))
}

/// The bytes of a compressed array at the begin of `file`; none where it is cut short or damaged.
pub fn unpack(file: &[u8]) -> Option<Vec<u8>> {
    let (words, _) = file.as_chunks::<8>();
    let word = |k: usize| words.get(k).and_then(|w| usize::try_from(u64::from_le_bytes(*w)).ok());
    let (count, size, part) = (word(0)?, word(1)?, word(2)?);
    if count > words.len() || count.checked_mul(size)? > LONGEST {
        return None;
    }
    let mut at = 8 * (3 + count);
    let mut bytes = Vec::new();
    for k in 0..count {
        let packed = file.get(at..at.checked_add(word(3 + k)?)?)?;
        let want = if k + 1 == count && part > 0 { part } else { size };
        let before = bytes.len();
        XzReader::new(packed, false).take(want as u64 + 1).read_to_end(&mut bytes).ok()?;
        if bytes.len() - before != want {
            return None;
        }
        at += packed.len();
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::super::vtk::tests::two_grains;
    use super::super::vtk::{Field, write_snapshot, write_surfaces};
    use super::*;

    /// What a file of a run says once it was written small.
    fn again(folder: &Path, name: &str, keep: impl Fn(&str) -> bool) -> (Snapshot, Snapshot) {
        let (from, to) = (folder.join(name), folder.join("small.vtp"));
        let whole = Snapshot::read(&from).expect("read");
        write(&to, &whole, keep).expect("written");
        (whole, Snapshot::read(&to).expect("read again"))
    }

    #[test]
    fn small_snapshots_say_the_same_within_their_rounding() {
        let folder = tempfile::tempdir().expect("a folder");
        write_snapshot(&folder.path().join("a.vtp"), &[("sigma_v_kPa", 12.5)], &two_grains()).expect("written");
        let (whole, small) = again(folder.path(), "a.vtp", |name| name != "force");
        assert_eq!((&small.facts, small.arrays.len()), (&whole.facts, whole.arrays.len() - 1));
        for (p, q) in whole.position.as_flattened().iter().zip(small.position.as_flattened()) {
            assert!((p - q).abs() <= 0.5 * 3.3 * PLACES + 1e-7, "{p} is {q}");
        }
        for array in small.arrays {
            let of = whole.array(&array.name).expect("an array");
            let exact = of.values.iter().all(|x| x.fract() == 0.0);
            for (x, y) in of.values.iter().zip(&array.values) {
                let near = x == y || !exact && (x - y).abs() <= x.abs() / 256.0;
                assert!(near, "{} is {x} and becomes {y}", array.name);
            }
        }
    }

    #[test]
    fn surfaces_keep_their_triangles() {
        let folder = tempfile::tempdir().expect("a folder");
        let field = [Field { name: "block", components: 1, values: vec![3.0] }];
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        write_surfaces(&folder.path().join("a.vtp"), &[], &corners, &[[0, 2, 1]], &field).expect("written");
        let (whole, small) = again(folder.path(), "a.vtp", |_| true);
        assert_eq!(whole, small);
    }

    #[test]
    fn long_arrays_are_unpacked_and_damaged_ones_refused() {
        let bytes: Vec<u8> = (0..BLOCK as u32 / 2).flat_map(|k| k.wrapping_mul(2_654_435_761).to_le_bytes()).collect();
        let (head, blob) = pack(&bytes, 4).expect("packed");
        let mut file = [head, blob].concat();
        assert_eq!(unpack(&file).as_deref(), Some(&bytes[..]));
        for cut in [0, 7, 30, 100, file.len() - 1] {
            assert!(unpack(&file[..cut]).is_none(), "cut at {cut}");
        }
        let middle = file.len() / 2;
        file[middle] ^= 1;
        assert!(unpack(&file).is_none(), "a changed bit");
        file[0] = 255;
        assert!(unpack(&file).is_none(), "more blocks than there are");
    }

    #[test]
    fn numbers_are_rounded_to_the_nearest() {
        assert_eq!([rounded(1.003, 8), rounded(-1.005, 8), rounded(0.0, 8)], [1.0, -1.007_812_5, 0.0]);
        assert_eq!(rounded(f32::INFINITY, 8), f32::INFINITY);
        assert_eq!(numbers(&[0.0, 255.0], 8).0, "UInt8");
        assert_eq!((numbers(&[-1.0, 3.0], 8).0, numbers(&[0.5], 8).0), ("Int32", "Float32"));
    }
}
