//! Specimens as CSV files: `specimen.csv` (prepared, at rest) and `grains_final.csv` (at the end of a run). Reading a file gives
//! the same bits as were written. A checksum in the file detects later edits.

use crate::error::{Error, Result};
use crate::model::Model;
use crate::model::continuum::{Fraction, Growth};
use crate::rig::continuum::Grown;
use crate::rig::cylinder::space;
use crate::scene::read_text_up_to;
use engine::boundary::CylinderSpace;
use engine::dem::State;
use engine::grains::{Grains, sphere_volume};
use engine::material::Material;
use std::borrow::Cow;
use std::fmt::Write as _;
use std::path::Path;

/// Writes grains at rest, with the cylinder around them: no velocities, no contact history.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, grains: &Grains, materials: &[Material], walls: Option<CylinderSpace>) -> Result<()> {
    save(path, grains, materials, &walls.map_or(String::new(), notes), false)
}

/// Writes a specimen of a mixture that has grown as `growth` says: its grains, the coarse ones first, the box around them, and the stress that it bears.
///
/// # Errors
/// A file that cannot be written.
pub fn write_grown(path: &Path, grown: &Grown, growth: &Growth, materials: &[Material]) -> Result<()> {
    let of = [growth.coarse.unwrap_or(growth.fines), growth.fines].map(|fraction| fraction.material);
    let mut grains = Grains::default();
    for (k, [x, y, z, r]) in grown.grains.iter().enumerate() {
        grains.add([*x, *y, *z], *r, of[usize::from(k >= grown.coarse)], materials);
    }
    let [[x, y, z], [a, b, c]] = [grown.lower, grown.size];
    let notes =
        format!("{LOWER}{x:?}, {y:?}, {z:?}\n{SIZE}{a:?}, {b:?}, {c:?}\n{COARSE}{}\n{STRESS}{:?}\n", grown.coarse, growth.stress);
    save(path, &grains, materials, &notes, false)
}

/// Beginnings of the lines that say which box is around a grown specimen, how many of its grains are coarse, and which stress it bears.
const LOWER: &str = "# lower_m = ";
const SIZE: &str = "# size_m = ";
const COARSE: &str = "# coarse_grains = ";
const STRESS: &str = "# stress_Pa = ";

/// The lines that say which cylinder is around a specimen.
fn notes(w: CylinderSpace) -> String {
    format!("# cylinder_radius_m = {:?}\n# height_m = {:?}\n# bottom_m = {:?}\n", w.radius, w.height, w.bottom)
}

/// Writes the grains of `state` with velocities and spins.
///
/// # Errors
/// A file that cannot be written.
pub fn write_final(path: &Path, state: &State, model: &Model, walls: Option<CylinderSpace>) -> Result<()> {
    save(path, &state.grains, &model.physics.materials, &walls.map_or(String::new(), notes), true)
}

fn save(path: &Path, g: &Grains, materials: &[Material], notes: &str, moving: bool) -> Result<()> {
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
    let mut text = notes.to_string();
    let _ = writeln!(text, "# hash = {:016x}", checksum(&(text.clone() + &rows)));
    text += &rows;
    table::write(path, text).map_err(Error::write(path))
}

/// A text as a field of a CSV row: in quotes where it holds a comma, a quote or a line break.
pub fn quoted(text: &str) -> Cow<'_, str> {
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
    let file = Sheet { path, text: read_text_up_to(path, LONGEST)? };
    let note = |key: &str| -> Result<f64> {
        let [x] = file.note(&format!("# {key} = "), "a specimen of an oedometer begins with `# cylinder_radius_m = …`")?;
        Ok(x)
    };
    let walls = CylinderSpace { radius: note("cylinder_radius_m")?, height: note("height_m")?, bottom: note("bottom_m")? };
    if walls.radius <= 0.0 || walls.height <= 0.0 {
        return Err(file.wrong("height_m", None, "radius and height must be > 0"));
    }
    Ok((file.grains(materials)?, walls))
}

/// Reads a grown specimen of a mixture ([`write_grown`]) for a scene whose specimen grows as `growth` says: from the same bits as the run that grew it.
///
/// # Errors
/// Those of [`read`]; another stress, or grains of other materials, sizes or shares than the scene's.
pub fn read_grown(path: &Path, growth: &Growth, materials: &[Material]) -> Result<Grown> {
    let file = Sheet { path, text: read_text_up_to(path, LONGEST)? };
    let needed = "the specimen of a mixture that has grown begins with `# lower_m = …`";
    let (lower, size, [coarse]) = (file.note(LOWER, needed)?, file.note(SIZE, needed)?, file.note(COARSE, needed)?);
    let [stress] = file.note(STRESS, needed)?;
    if (stress / growth.stress - 1.0).abs() > 1e-9 {
        let message = format!("the specimen of the scene bears {:.6} kPa before its test", 1e-3 * growth.stress);
        return Err(file.wrong("stress_Pa", Some(stress.to_string()), &message));
    }
    let grains = file.grains(materials)?;
    let grown = Grown { lower, size, grains: grains.pos.clone(), coarse: coarse as usize, steps: 0 };
    grown.check().map_err(|what| file.wrong("", None, &what))?;
    let of_coarse = growth.coarse.map(|of| (0..grown.coarse, of, "coarse"));
    if of_coarse.is_none() && grown.coarse > 0 {
        return Err(file.wrong("coarse_grains", Some(grown.coarse.to_string()), "must be 0: the scene has no coarse grains"));
    }
    for (range, of, name) in of_coarse.into_iter().chain([(grown.coarse..grains.len(), growth.fines, "fine")]) {
        let (pos, own) = (&grains.pos[range.clone()], &grains.material[range]);
        let Fraction { material, radii: [low, high], volume } = of;
        if own.iter().any(|m| *m != material) {
            let message = format!("the {name} grains must all be of {}", materials[usize::from(material)].name);
            return Err(file.wrong("material", None, &message));
        }
        if let Some(p) = pos.iter().find(|p| !(low..=high).contains(&p[3])) {
            let message = format!("the {name} grains of the scene have radii of {low:?} to {high:?} m");
            return Err(file.wrong("r_m", Some(format!("{:?}", p[3])), &message));
        }
        // sizes are drawn until the next one would be too much
        let all: f64 = pos.iter().map(|p| sphere_volume(p[3])).sum();
        if (all - volume).abs() > sphere_volume(high) {
            let message =
                format!("the {name} grains have a volume of {all:.4e} m3 in the file and of {volume:.4e} m3 in the scene");
            return Err(file.wrong("r_m", None, &message));
        }
    }
    Ok(grown)
}

/// A specimen file while it is read.
struct Sheet<'a> {
    path: &'a Path,
    text: String,
}

impl Sheet<'_> {
    fn wrong(&self, key: &str, value: Option<String>, message: &str) -> Error {
        Error::input(self.path.display(), key, value, message)
    }

    /// The finite numbers in the line that begins with `start`; `needed` says which lines such a file begins with.
    fn note<const COUNT: usize>(&self, start: &str, needed: &str) -> Result<[f64; COUNT]> {
        let key = start.trim_start_matches("# ").trim_end_matches(" = ");
        let line = self.text.lines().find_map(|l| l.strip_prefix(start));
        let line = line.ok_or_else(|| self.wrong(key, None, &format!("missing: {needed}")))?;
        let numbers = line.split(',').map(|x| x.trim().parse::<f64>().ok().filter(|x| x.is_finite()));
        let numbers: Option<Vec<f64>> = numbers.collect();
        let message = if COUNT == 1 { "must be a finite number" } else { "must be finite numbers with commas between" };
        numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| self.wrong(key, Some(line.into()), message))
    }

    /// The grains, with the materials of their names.
    fn grains(&self, materials: &[Material]) -> Result<Grains> {
        let text = &self.text;
        let wrong = |key: &str, value: Option<String>, message: &str| self.wrong(key, value, message);
        if let Some(line) = text.lines().find(|l| l.starts_with("# hash = ")) {
            let rest = text.replacen(&format!("{line}\n"), "", 1);
            let hash = line.trim_start_matches("# hash = ");
            if hash != format!("{:016x}", checksum(&rest)) {
                let message =
                    "does not fit the file: it was changed after it was written (delete this line to use it all the same)";
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
                *x = field.parse().ok().filter(|x: &f64| x.is_finite() && (name != "r_m" || *x > 0.0)).ok_or_else(|| {
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
        Ok(grains)
    }
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
