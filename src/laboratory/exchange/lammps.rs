//! Data files of LAMMPS and LIGGGHTS with `atom_style sphere` (`granular` in old LIGGGHTS): `Atoms` with id, type, diameter, density and
//! place, `Velocities` with velocity and spin. In SI units (`units si`).

use super::text_file::{LONGEST, Line};
use super::{Contents, Grain, Packing};
use crate::error::{Error, Result};
use crate::scene::read_text_up_to;
use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::Path;

/// Most types of a file.
const MOST_TYPES: usize = 255;

/// The text of a data file with the grains; a type for each material, in the order of the scene. The box is that around all grains.
pub fn write(contents: &Contents) -> String {
    let names: Vec<String> =
        contents.kinds.iter().enumerate().map(|(k, kind)| format!("{} = {}", k + 1, line(&kind.name))).collect();
    let mut text = format!("comminute, units si, atom_style sphere, types {}\n\n", names.join(", "));
    let _ = writeln!(text, "{} atoms\n{} atom types\n", contents.grains.len(), contents.kinds.len());
    for (a, axis) in ["x", "y", "z"].iter().enumerate() {
        let ends = |side: f64| contents.grains.iter().map(move |g| g.position[a] + side * g.radius);
        let (low, high) = (ends(-1.0).fold(f64::INFINITY, f64::min), ends(1.0).fold(f64::NEG_INFINITY, f64::max));
        let _ = writeln!(text, "{low:?} {high:?} {axis}lo {axis}hi");
    }
    text += "\nAtoms\n\n";
    for (k, g) in contents.grains.iter().enumerate() {
        let ([x, y, z], density) = (g.position, contents.kinds.get(g.kind).map_or(0.0, |kind| kind.density));
        let _ = writeln!(text, "{} {} {:?} {density:?} {x:?} {y:?} {z:?}", k + 1, g.kind + 1, 2.0 * g.radius);
    }
    text += "\nVelocities\n\n";
    for (k, g) in contents.grains.iter().enumerate() {
        let ([u, v, w], [p, q, r]) = (g.velocity, g.spin);
        let _ = writeln!(text, "{} {u:?} {v:?} {w:?} {p:?} {q:?} {r:?}", k + 1);
    }
    text
}

/// A text without line breaks.
fn line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The grains of a data file, in the order of their numbers, lengths times `unit`, m. Sections other than `Atoms` and `Velocities` are
/// passed over; densities are left to the materials of a scene.
///
/// # Errors
/// A file that cannot be read; atoms of another style, by line; numbers that are not what they must be; a file without atoms, or with
/// another number of them than it says.
pub fn read(path: &Path, unit: f64) -> Result<Packing> {
    parse(path, &read_text_up_to(path, LONGEST)?, unit)
}

fn parse(path: &Path, text: &str, unit: f64) -> Result<Packing> {
    let wrong = |message: String| Error::input(path.display(), "", None, message);
    let mut section = String::new();
    let (mut stated, mut types) = (None, 1);
    let mut grains: Vec<(usize, Grain)> = Vec::new();
    let mut places: HashMap<usize, usize> = HashMap::new();
    // the first line is a title whatever it says
    let body = text.find('\n').map_or("", |end| &text[end..]);
    for line in Line::all(path, body) {
        if line.text.starts_with(|c: char| c.is_ascii_uppercase()) {
            section = line.text.to_string();
            continue;
        }
        match section.as_str() {
            "" => {
                let mut words = line.text.split_whitespace();
                let count = words.next().and_then(|n| n.parse::<usize>().ok());
                match (count, words.collect::<Vec<_>>().as_slice()) {
                    (Some(n), ["atoms"]) => stated = Some(n),
                    (Some(n), ["atom", "types"]) if n > MOST_TYPES => {
                        return Err(line.wrong(format!("there may be at most {MOST_TYPES} types")));
                    }
                    (Some(n), ["atom", "types"]) => types = n,
                    _ => {}
                }
            }
            "Atoms" => {
                let allowed = "id, type, diameter, density, x, y, z of atom_style sphere, and may be three image flags";
                let n = line.numbers(&[7, 10], allowed)?;
                let (id, kind) = (line.whole(n[0], "the id")?, line.whole(n[1], "the type")?);
                if kind > types {
                    return Err(line.wrong(format!("the type must be 1 to {types}")));
                }
                if n[2] <= 0.0 {
                    return Err(line.wrong("the diameter must be > 0"));
                }
                if places.insert(id, grains.len()).is_some() {
                    return Err(line.wrong("this id was there before"));
                }
                let position = [n[4], n[5], n[6]].map(|x| x * unit);
                grains.push((id, Grain { position, radius: 0.5 * n[2] * unit, kind: kind - 1, ..Grain::default() }));
            }
            "Velocities" => {
                let n = line.numbers(&[4, 7], "id, vx, vy, vz, and may be wx, wy, wz")?;
                let id = line.whole(n[0], "the id")?;
                let Some((_, grain)) = places.get(&id).and_then(|k| grains.get_mut(*k)) else {
                    return Err(line.wrong("there is no atom of this id before"));
                };
                grain.velocity = [n[1], n[2], n[3]].map(|x| x * unit);
                if let [.., p, q, r] = n[4..] {
                    grain.spin = [p, q, r];
                }
            }
            _ => {}
        }
    }
    if grains.is_empty() {
        return Err(wrong("has no section Atoms with lines: id, type, diameter, density, x, y, z (atom_style sphere)".into()));
    }
    if let Some(stated) = stated.filter(|n| *n != grains.len()) {
        return Err(wrong(format!("says that it has {stated} atoms, and has {}", grains.len())));
    }
    grains.sort_by_key(|(id, _)| *id);
    Ok(Packing { grains: grains.into_iter().map(|(_, grain)| grain).collect(), types })
}

#[cfg(test)]
mod tests {
    use super::super::surfaces::tests::two;
    use super::*;

    fn read_text(text: &str) -> Result<Packing> {
        parse(Path::new("a.data"), text, 1.0)
    }

    #[test]
    fn what_is_written_is_read_back_to_the_last_bit() {
        let of = two();
        let read = read_text(&write(&of)).expect("a data file");
        let grains: Vec<Grain> = of.grains.iter().map(|g| Grain { generation: 0, ..*g }).collect();
        assert_eq!(read, Packing { grains, types: 2 });
    }

    #[test]
    fn a_file_of_another_program_is_read_in_the_order_of_its_ids() {
        let text = "LAMMPS data file\n\n2 atoms\n1 atom types\n\n0 1 xlo xhi\n\nMasses\n\n1 1\n\nAtoms # sphere\n\n\
                    7 1 0.5 2500 1 2 3 0 0 -1\n3 1 1 2500 4 5 6 0 0 0\n\nVelocities\n\n3 0 0 1\n";
        let read = parse(Path::new("a.data"), text, 1e-3).expect("a data file");
        assert_eq!(read.grains.iter().map(|g| g.radius).collect::<Vec<_>>(), [0.5e-3, 0.25e-3]);
        assert_eq!((read.grains[0].velocity, read.grains[1].position), ([0.0, 0.0, 1e-3], [1e-3, 2e-3, 3e-3]));
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        let with = |atoms: &str| format!("title\n1 atoms\n1 atom types\n\nAtoms\n\n{atoms}\n");
        for (text, needed) in [
            (with("1 1 1.0 2500 0 0"), "a.data line 7 (`1 1 1.0 2500 0 0`): must be id, type, diameter"),
            (with("1 2 1.0 2500 0 0 0"), "the type must be 1 to 1"),
            (with("1 1 0 2500 0 0 0"), "the diameter must be > 0"),
            (with("1 1 1 2500 0 0 nan"), "must be id, type, diameter"),
            (with("1.5 1 1 2500 0 0 0"), "the id must be a whole number"),
            (with("1 1 1 2500 0 0 0\n1 1 1 2500 0 0 0"), "line 8"),
            (with("1 1 1 2500 0 0 0\n2 1 1 2500 0 0 0"), "says that it has 1 atoms, and has 2"),
            (with("1 1 1 2500 0 0 0\nVelocities\n\n2 0 0 0"), "no atom of this id"),
            (String::new(), "has no section Atoms"),
        ] {
            let error = read_text(&text).expect_err(needed).to_string();
            assert!(error.contains(needed), "{error}");
        }
    }
}
