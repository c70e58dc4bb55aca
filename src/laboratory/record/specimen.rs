//! Specimens as CSV files: `specimen.csv` (prepared, at rest) and `grains_final.csv` (at the end of a run). Reading a file gives
//! the same bits as were written. A checksum in the file detects later edits.

use crate::error::{Error, Result};
use crate::model::Model;
use crate::rig::cylinder::space;
use crate::scene::read_text_up_to;
use engine::boundary::CylinderSpace;
use engine::dem::State;
use engine::grains::Grains;
use engine::material::Material;
use std::borrow::Cow;
use std::fmt::Write as _;
use std::path::Path;

/// Writes grains at rest, with the cylinder around them: no velocities, no contact history.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, grains: &Grains, materials: &[Material], walls: Option<CylinderSpace>) -> Result<()> {
    save(path, grains, materials, walls, false)
}

/// Writes the grains of `state` with velocities and spins.
///
/// # Errors
/// A file that cannot be written.
pub fn write_final(path: &Path, state: &State, model: &Model, walls: Option<CylinderSpace>) -> Result<()> {
    save(path, &state.grains, &model.physics.materials, walls, true)
}

fn save(path: &Path, g: &Grains, materials: &[Material], walls: Option<CylinderSpace>, moving: bool) -> Result<()> {
    let whole =
        |i: &u32| g.pos[*i as usize].iter().chain(&g.vel[*i as usize][..3]).chain(&g.spin[*i as usize][..3]).all(|x| x.is_finite());
    if let Some(i) = g.by_id().iter().find(|i| !whole(i)) {
        let what = format!("{}: place, radius or velocity of a grain is not finite; nothing was written", path.display());
        return Err(Error::Unstable { step: 0, what, grain: Some(u64::from(g.id[*i as usize])) });
    }
    let mut rows = String::from("x_m,y_m,z_m,r_m,generation,material");
    rows += if moving { ",vx_m_s,vy_m_s,vz_m_s,wx_rad_s,wy_rad_s,wz_rad_s\n" } else { "\n" };
    for &i in &g.by_id() {
        let i = i as usize;
        let p = g.pos[i];
        let name = quoted(&materials[g.material[i] as usize].name);
        let _ = write!(rows, "{:?},{:?},{:?},{:?},{},{name}", p[0], p[1], p[2], p[3], g.generation[i]);
        if moving {
            let (v, w) = (g.vel[i], g.spin[i]);
            let _ = write!(rows, ",{:?},{:?},{:?},{:?},{:?},{:?}", v[0], v[1], v[2], w[0], w[1], w[2]);
        }
        rows.push('\n');
    }
    let mut text = String::new();
    if let Some(w) = walls {
        let _ = writeln!(text, "# cylinder_radius_m = {:?}\n# height_m = {:?}\n# bottom_m = {:?}", w.radius, w.height, w.bottom);
    }
    let _ = writeln!(text, "# hash = {:016x}", checksum(&(text.clone() + &rows)));
    text += &rows;
    table::write(path, text).map_err(Error::write(path))
}

/// A text as a field of a CSV row: in quotes where it holds a comma, a quote or a line break.
fn quoted(text: &str) -> Cow<'_, str> {
    if text.contains([',', '"', '\n', '\r']) {
        Cow::Owned(format!("\"{}\"", text.replace('"', "\"\"")))
    } else {
        Cow::Borrowed(text)
    }
}

/// The specimen that a state holds: what [`read`] makes of the file that [`write()`] leaves, without the file. Grains are at
/// rest, in the order of ids, with their real mass as inertia and without strengths; velocities, contacts and history are left
/// behind.
pub fn at_rest(state: &State, materials: &[Material]) -> (Grains, CylinderSpace) {
    let g = &state.grains;
    let mut grains = Grains::default();
    for &i in &g.by_id() {
        let i = i as usize;
        let [x, y, z, r] = g.pos[i];
        let k = grains.add([x, y, z], r, g.material[i], materials);
        grains.generation[k] = g.generation[i];
    }
    (grains, space(state))
}

/// Checksum of a text: FNV-1a with 64 bits.
pub fn checksum(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}

/// Longest file of a specimen, bytes: some five million grains.
const LONGEST: u64 = 512 << 20;

/// Reads a prepared specimen: the grains, and the cylinder around them. Grains get the material of the scene with the name in the
/// file.
///
/// # Errors
/// A file that is not a specimen, was edited after it was written, or names a material that the scene does not have.
pub fn read(path: &Path, materials: &[Material]) -> Result<(Grains, CylinderSpace)> {
    let text = read_text_up_to(path, LONGEST)?;
    let wrong = |key: &str, value: Option<String>, message: &str| Error::input(path.display(), key, value, message);
    let note = |key: &str| -> Result<f64> {
        let start = format!("# {key} = ");
        let line = text.lines().find_map(|l| l.strip_prefix(&start));
        let line =
            line.ok_or_else(|| wrong(key, None, "missing: a specimen of an oedometer begins with `# cylinder_radius_m = …`"))?;
        line.parse::<f64>()
            .ok()
            .filter(|x| x.is_finite())
            .ok_or_else(|| wrong(key, Some(line.into()), "must be a finite number, m"))
    };
    let walls = CylinderSpace { radius: note("cylinder_radius_m")?, height: note("height_m")?, bottom: note("bottom_m")? };
    if walls.radius <= 0.0 || walls.height <= 0.0 {
        return Err(wrong("height_m", None, "radius and height must be > 0"));
    }
    if let Some(line) = text.lines().find(|l| l.starts_with("# hash = ")) {
        let rest = text.replacen(&format!("{line}\n"), "", 1);
        let hash = line.trim_start_matches("# hash = ");
        if hash != format!("{:016x}", checksum(&rest)) {
            let message = "does not fit the file: it was changed after it was written (delete this line to use it all the same)";
            return Err(wrong("hash", Some(hash.into()), message));
        }
    }
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
    let header = reader.headers().map_err(|e| wrong("", None, &e.to_string()))?.clone();
    let column = |name: &str| {
        header.iter().position(|h| h == name).ok_or_else(|| wrong(name, None, "missing column; needed: x_m, y_m, z_m, r_m"))
    };
    let places = [column("x_m")?, column("y_m")?, column("z_m")?, column("r_m")?];
    let (generation, material) = (column("generation").ok(), column("material").ok());
    let mut grains = Grains::default();
    for record in reader.records() {
        let record = record.map_err(|e| wrong("", None, &e.to_string()))?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut p = [0.0; 4];
        for (x, (&c, name)) in p.iter_mut().zip(places.iter().zip(["x_m", "y_m", "z_m", "r_m"])) {
            let field = record.get(c).unwrap_or("");
            *x =
                field.parse().ok().filter(|x: &f64| x.is_finite() && (name != "r_m" || *x > 0.0)).ok_or_else(|| {
                    wrong(name, Some(field.into()), &format!("line {line}: must be a finite number, a radius > 0"))
                })?;
        }
        let name = material.and_then(|c| record.get(c)).unwrap_or("");
        let m = if name.is_empty() { Some(0) } else { materials.iter().position(|m| m.name == name) };
        let m = m.ok_or_else(|| {
            let known: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
            wrong("material", Some(name.into()), &format!("line {line}: not a material of the scene ({})", known.join(", ")))
        })?;
        let i = grains.add([p[0], p[1], p[2]], p[3], m as u8, materials);
        let born = generation.and_then(|c| record.get(c)).unwrap_or("0");
        grains.generation[i] = born
            .parse()
            .map_err(|_| wrong("generation", Some(born.into()), &format!("line {line}: must be a whole number 0..255")))?;
    }
    if grains.is_empty() {
        return Err(wrong("", None, "holds no grains"));
    }
    Ok((grains, walls))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_material_may_have_any_name() {
        let material = |name: &str| Material {
            name: name.into(),
            density: 2650.0,
            internal_porosity: 0.0,
            young: 70e9,
            poisson: 0.2,
            friction: 0.3,
            rolling_friction: 0.0,
            interface_friction: None,
            contact: Default::default(),
        };
        let materials = [material("sand, \"fine\"\nwashed"), material("glass")];
        let mut grains = Grains::default();
        grains.add([1e-3, 0.0, 0.0], 1e-3, 0, &materials);
        grains.add([-1e-3, 0.0, 0.0], 1e-3, 1, &materials);
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("specimen.csv");
        write(&path, &grains, &materials, Some(CylinderSpace { radius: 0.01, height: 0.02, bottom: 0.0 })).expect("written");
        let (read, _) = read(&path, &materials).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((read.pos, read.material), (grains.pos, grains.material));
    }
}
