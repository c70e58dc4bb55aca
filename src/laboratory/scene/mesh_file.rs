//! Triangle meshes from files: STL, as text or binary, and OBJ. A file says nothing of its unit of length, so the scene does (`mesh_unit_mm`).

use super::files::read_bytes;
use super::layers::{Layer, shown};
use crate::error::{Error, Result};
use engine::shape::{MOST_TRIANGLES, Sheet, welded};
use std::path::Path;
use toml::{Table, Value};

/// Vertices, in the unit of the file, and the triangles that they make.
pub type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// Characters of a line that a message shows.
const SHOWN: usize = 60;
/// Bytes of a binary STL file before its triangles, and of each triangle.
const HEAD: usize = 84;
const TRIANGLE: usize = 50;

/// Replaces `mesh_file` and `mesh_unit_mm` of each block by what its file holds, so that a resolved scene needs no other file. What is wrong with the keys themselves is
/// left to the checks that follow.
///
/// # Errors
/// A file that cannot be read or whose triangles make no sheet; a missing unit; too many triangles in all.
pub fn meshes(layer: &mut Layer) -> Result<()> {
    let count = layer.table.get("block").and_then(Value::as_array).map_or(0, Vec::len);
    let mut all = 0;
    for i in 0..count {
        let key = |name: &str| format!("block[{i}].{name}");
        let origin = layer.origin(&key("mesh_file"));
        let Some(block) = layer.table.get_mut("block").and_then(|b| b.get_mut(i)).and_then(Value::as_table_mut) else { continue };
        let Some(Value::String(name)) = block.get("mesh_file").cloned() else { continue };
        if block.get("shape").and_then(Value::as_str) != Some("mesh") {
            continue;
        }
        let wrong = |message: String| {
            Error::input(origin.place.clone(), origin.key.clone(), Some(shown(&Value::String(name.clone()))), message)
        };
        if block.contains_key("vertices_mm") || block.contains_key("triangles") {
            return Err(wrong("must not stand beside vertices_mm and triangles".into()));
        }
        let unit = match block.get("mesh_unit_mm") {
            Some(Value::Float(unit)) => *unit,
            Some(Value::Integer(unit)) => *unit as f64,
            Some(_) => continue,
            None => {
                let message = "is missing: the length of the file's unit in mm, which the file does not say (1 where it is in mm, 1000 where it is in m)";
                return Err(Error::input(origin.place.clone(), origin.key.replace("mesh_file", "mesh_unit_mm"), None, message));
            }
        };
        if !(1e-9..=1e9).contains(&unit) {
            continue;
        }
        let (vertices, triangles) = read(Path::new(&name)).map_err(|e| match e {
            Error::Input { message, .. } => wrong(message),
            other => other,
        })?;
        let vertices: Vec<[f64; 3]> = vertices.into_iter().map(|p| p.map(|x| x * unit)).collect();
        let metres: Vec<[f64; 3]> = vertices.iter().map(|p| p.map(|x| 1e-3 * x)).collect();
        Sheet::of(&metres, &triangles, 0.0).map_err(&wrong)?;
        all += triangles.len();
        if all > MOST_TRIANGLES {
            return Err(wrong(format!("makes {all} triangles with the meshes before it, where a scene may have {MOST_TRIANGLES}")));
        }
        let (vertices, triangles) = welded(&vertices, &triangles);
        put(block, vertices, triangles);
    }
    Ok(())
}

/// Writes the triangles into the table of a block, in the place of its file.
fn put(block: &mut Table, vertices: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) {
    block.remove("mesh_file");
    block.remove("mesh_unit_mm");
    block.insert("vertices_mm".into(), Value::Array(vertices.into_iter().flatten().map(Value::Float).collect()));
    let numbers = triangles.into_iter().flatten().map(|k| Value::Integer(k.into()));
    block.insert("triangles".into(), Value::Array(numbers.collect()));
}

/// The triangles of the file `path`.
fn read(path: &Path) -> Result<Triangles> {
    let wrong = |message: String| Error::input(path.display(), "", None, message);
    let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let parse: fn(&[u8]) -> std::result::Result<Triangles, String> = match ending.as_deref() {
        Some("stl") => stl,
        Some("obj") => |bytes| obj(text(bytes)?),
        _ => return Err(wrong("must end in .stl or .obj".into())),
    };
    parse(&read_bytes(path)?).map_err(wrong)
}

fn text(bytes: &[u8]) -> std::result::Result<&str, String> {
    std::str::from_utf8(bytes).map_err(|e| format!("is not UTF-8 text (byte {})", e.valid_up_to()))
}

/// STL: binary where its length is what its number of triangles says, else text if it begins as such.
pub fn stl(bytes: &[u8]) -> std::result::Result<Triangles, String> {
    let count = bytes.get(HEAD - 4..HEAD).map(|n| u32::from_le_bytes([n[0], n[1], n[2], n[3]]) as usize);
    match count {
        Some(count) if bytes.len() == HEAD + TRIANGLE * count => binary(bytes, count),
        _ if bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) => ascii(text(bytes)?),
        Some(count) => Err(format!(
            "is no STL file, or is cut off: as a binary file it has {count} triangles, which take {} bytes, and it has {}",
            HEAD + TRIANGLE * count,
            bytes.len()
        )),
        None => Err(format!("is no STL file: it has {} bytes and does not begin with \"solid\"", bytes.len())),
    }
}

fn bounded(count: usize) -> std::result::Result<(), String> {
    if count > MOST_TRIANGLES { Err(format!("has more than {MOST_TRIANGLES} triangles")) } else { Ok(()) }
}

fn binary(bytes: &[u8], count: usize) -> std::result::Result<Triangles, String> {
    bounded(count)?;
    let (mut vertices, mut triangles) = (Vec::with_capacity(3 * count), Vec::with_capacity(count));
    for (k, triangle) in bytes[HEAD..].chunks_exact(TRIANGLE).enumerate() {
        // the normal is left out: it follows from the corners
        let numbers: Vec<f64> =
            triangle[12..48].chunks_exact(4).map(|x| f64::from(f32::from_le_bytes([x[0], x[1], x[2], x[3]]))).collect();
        if let Some(x) = numbers.iter().find(|x| !x.is_finite()) {
            return Err(format!("has a vertex of triangle {k} from 0 at {x}"));
        }
        let first = vertices.len() as u32;
        vertices.extend(numbers.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
        triangles.push([first, first + 1, first + 2]);
    }
    Ok((vertices, triangles))
}

/// What is wrong in line `number` from 0.
fn in_line(number: usize, line: &str, message: &str) -> String {
    let written: String = line.trim().chars().take(SHOWN).collect();
    format!("line {} (`{written}`): {message}", number + 1)
}

/// Three numbers.
fn place<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<[f64; 3]> {
    let mut one = || words.next()?.parse::<f64>().ok().filter(|x| x.is_finite());
    Some([one()?, one()?, one()?])
}

fn ascii(text: &str) -> std::result::Result<Triangles, String> {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    let (mut open, mut corners) = (true, 0);
    for (n, line) in text.lines().enumerate() {
        let wrong = |message: &str| in_line(n, line, message);
        let mut words = line.split_whitespace();
        let Some(word) = words.next() else { continue };
        match word.to_ascii_lowercase().as_str() {
            "solid" => open = true,
            "endsolid" => open = false,
            "facet" | "outer" | "endloop" => {}
            "vertex" => {
                let p = place(words).ok_or_else(|| wrong("must be a vertex with three finite numbers"))?;
                vertices.push(p);
                corners += 1;
            }
            "endfacet" => {
                if corners != 3 {
                    return Err(wrong(&format!("ends a facet of {corners} vertices, which must have three")));
                }
                let first = vertices.len() as u32 - 3;
                triangles.push([first, first + 1, first + 2]);
                bounded(triangles.len())?;
                corners = 0;
            }
            _ => return Err(wrong("is no line of an STL file")),
        }
    }
    if open || corners != 0 {
        return Err("is cut off: it does not end with endsolid".into());
    }
    Ok((vertices, triangles))
}

/// OBJ: vertices and faces; a face of more than three corners is taken as triangles around its first.
fn obj(text: &str) -> std::result::Result<Triangles, String> {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for (n, line) in text.lines().enumerate() {
        let wrong = |message: &str| in_line(n, line, message);
        let mut words = line.split('#').next().unwrap_or("").split_whitespace();
        match words.next() {
            None | Some("vn" | "vt" | "vp" | "o" | "g" | "s" | "l" | "p" | "mtllib" | "usemtl") => {}
            Some("v") => {
                vertices.push(place(words).ok_or_else(|| wrong("must be a vertex with three finite numbers"))?);
            }
            Some("f") => {
                let corner = |word: &str| {
                    let number: i64 = word.split('/').next()?.parse().ok()?;
                    let k = if number < 0 { vertices.len() as i64 + number } else { number - 1 };
                    u32::try_from(k).ok().filter(|k| (*k as usize) < vertices.len())
                };
                let corners: Option<Vec<u32>> = words.map(corner).collect();
                match corners.as_deref() {
                    Some([first, rest @ ..]) if rest.len() >= 2 => {
                        triangles.extend(rest.windows(2).map(|w| [*first, w[0], w[1]]));
                        bounded(triangles.len())?;
                    }
                    _ => return Err(wrong("must be a face with three or more numbers of vertices before it")),
                }
            }
            Some(_) => return Err(wrong("is no line of an OBJ file with vertices and faces")),
        }
    }
    Ok((vertices, triangles))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ASCII: &str = "solid s\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1 0\n  endloop\n endfacet\n\
                         facet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n";

    /// The same square in three ways.
    #[test]
    fn the_formats_say_the_same() {
        let text = ascii(ASCII).expect("text");
        let mut bytes = vec![b's'; 80];
        bytes.extend(2_u32.to_le_bytes());
        for t in &text.1 {
            bytes.extend([0; 12]);
            bytes.extend(t.iter().flat_map(|k| text.0[*k as usize]).flat_map(|x| (x as f32).to_le_bytes()));
            bytes.extend([0; 2]);
        }
        assert_eq!(stl(&bytes), Ok(text.clone()));
        let faces =
            obj("# square\no s\nv 0 0 0\nv 1 0 0 0.5\nv 1 1 0\nvn 0 0 1\nv 0 1 0\nf 1/1/1 2//1 -1\nf 2 3 4\n").expect("faces");
        assert_eq!(welded(&text.0, &text.1).1, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(welded(&faces.0, &faces.1).1, [[0, 1, 2], [1, 3, 2]]);
        let quad = obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").expect("a square");
        assert_eq!(quad.1, [[0, 1, 2], [0, 2, 3]]);
        assert!(stl(&bytes[..bytes.len() - 1]).expect_err("cut off").contains("cut off"));
        assert!(ascii(&ASCII[..ASCII.len() - 12]).expect_err("cut off").contains("endsolid"));
    }
}
