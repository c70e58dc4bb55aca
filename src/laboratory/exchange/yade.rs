//! Spheres as Yade's `ymport.text` and `export.text` have them: lines of x, y, z and radius.

use super::text_file::{LONGEST, Line};
use super::{Contents, Grain, Packing};
use crate::error::{Error, Result};
use crate::scene::read_text_up_to;
use std::fmt::Write as _;
use std::path::Path;

/// The format of a file that says it, as Yade writes it.
const FORMAT: &str = "x_y_z_r";

/// The text of a file with the grains, m.
pub fn write(contents: &Contents) -> String {
    let mut text = format!("#format {FORMAT}\n");
    for g in &contents.grains {
        let [x, y, z] = g.position;
        let _ = writeln!(text, "{x:?}\t{y:?}\t{z:?}\t{:?}", g.radius);
    }
    text
}

/// The grains of a file, lengths times `unit`, m.
///
/// # Errors
/// A file that cannot be read, of another format, or without grains; a line that is not four numbers, the last one > 0.
pub fn read(path: &Path, unit: f64) -> Result<Packing> {
    parse(path, &read_text_up_to(path, LONGEST)?, unit)
}

fn parse(path: &Path, text: &str, unit: f64) -> Result<Packing> {
    let wrong = |message: String| Error::input(path.display(), "", None, message);
    let format = text.lines().find_map(|line| line.trim().strip_prefix("#format")).map(str::trim);
    if let Some(other) = format.filter(|format| *format != FORMAT) {
        return Err(wrong(format!("is of the format {other}; it must be {FORMAT}")));
    }
    let mut grains = Vec::new();
    for line in Line::all(path, text) {
        let n = line.numbers(&[4], "x, y, z and radius, with blanks between")?;
        if n[3] <= 0.0 {
            return Err(line.wrong("the radius must be > 0"));
        }
        let [x, y, z, radius] = [n[0], n[1], n[2], n[3]].map(|x| x * unit);
        grains.push(Grain { position: [x, y, z], radius, ..Grain::default() });
    }
    if grains.is_empty() {
        return Err(wrong("has no lines of x, y, z and radius".into()));
    }
    Ok(Packing { grains, types: 1 })
}

#[cfg(test)]
mod tests {
    use super::super::surfaces::tests::two;
    use super::*;

    #[test]
    fn what_is_written_is_read_back_to_the_last_bit() {
        let of = two();
        let read = parse(Path::new("a.txt"), &write(&of), 1.0).expect("a text");
        assert_eq!(read.types, 1);
        for (g, read) in of.grains.iter().zip(&read.grains) {
            assert_eq!((g.position, g.radius), (read.position, read.radius));
        }
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        for (text, needed) in [
            ("# by hand\n\n1 2 3\n", "a.txt line 3 (`1 2 3`): must be x, y, z and radius"),
            ("1 2 3 -1", "the radius must be > 0"),
            ("1 2 3 x", "must be x, y, z and radius"),
            ("#format x_y_z_r_matId\n1 2 3 4 5\n", "x_y_z_r_matId; it must be x_y_z_r"),
            ("# nothing\n", "has no lines"),
        ] {
            let error = parse(Path::new("a.txt"), text, 1.0).expect_err(needed).to_string();
            assert!(error.contains(needed), "{error}");
        }
    }
}
