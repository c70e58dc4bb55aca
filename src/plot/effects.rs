//! Effects of choices: a point with its interval for each, one below the other by name.

use super::axis::Axis;
use super::canvas::{Canvas, WIDTH};
use super::colour::{self, GREY, GRID, INK};
use super::error::{FigureError, Result};
use super::plot::{fit, quoted};
use super::text::{Anchor, Line, room};
use std::path::{Path, PathBuf};

/// A value with its name and interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// Name at the left.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Half the width of its interval; not a number where it is not known.
    pub half_width: f64,
}

/// Draws `out/name.{svg,png,csv}`: a row for each value, with zero and, as a grey region, the values within `tolerance`. `label`: quantity and unit.
///
/// # Errors
/// Files that cannot be written.
pub fn draw_effects(name: &str, label: &str, bars: &[Bar], tolerance: f64, out: &Path) -> Result<Vec<PathBuf>> {
    const ROW: f64 = 84.0;
    const SIZE: f64 = 42.0;
    let half = |bar: &Bar| if bar.half_width.is_finite() { bar.half_width } else { 0.0 };
    let ends = bars.iter().flat_map(|b| [b.value - half(b), b.value + half(b)]);
    let axis = Axis::linear(label, "value").including(&[0.0, -tolerance, tolerance]);
    let Some(range) = axis.range(ends) else { return Ok(Vec::new()) };
    let widest = bars.iter().map(|b| room(&b.name, SIZE)).fold(0.0, f64::max).min(0.55 * WIDTH);
    let (left, top) = (40.0 + widest, 110.0);
    let width = WIDTH - left - 60.0;
    let bottom = top + ROW * bars.len() as f64;
    let mut canvas = Canvas::new(bottom + 150.0);
    let text = |at, text: &str, size, anchor| Line { at, text: text.into(), size, colour: INK, anchor, upwards: false };
    let x = |v: f64| left + range.place(v) * width;
    canvas.rect((x(-tolerance), top), (x(tolerance), bottom), GRID, 0.6);
    for tick in range.ticks() {
        canvas.line(&[(x(tick.value), top), (x(tick.value), bottom)], GRID, 2.0, &[]);
        if let Some(label) = &tick.label {
            canvas.text(text((x(tick.value), bottom + 38.0), label, SIZE, Anchor::Middle));
        }
    }
    canvas.line(&[(x(0.0), top), (x(0.0), bottom)], GREY, 3.0, &[]);
    for (i, bar) in bars.iter().enumerate() {
        let y = top + ROW * (i as f64 + 0.5);
        canvas.line(&[(x(bar.value - half(bar)), y), (x(bar.value + half(bar)), y)], colour::kind(0), 6.0, &[]);
        canvas.rect((x(bar.value) - 11.0, y - 11.0), (x(bar.value) + 11.0, y + 11.0), colour::kind(0), 1.0);
        canvas.text(text((left - 18.0, y), &bar.name, fit(&bar.name, SIZE, widest), Anchor::End));
    }
    let frame = [(left, top), (left + width, top), (left + width, bottom), (left, bottom), (left, top), (left + 1.0, top)];
    canvas.line(&frame, INK, 3.0, &[]);
    canvas.text(text((left + 0.5 * width, bottom + 108.0), label, fit(label, 48.0, width), Anchor::Middle));
    canvas.rect((left, 34.0), (left + 60.0, 72.0), GRID, 0.6);
    canvas.text(text((left + 76.0, 53.0), "tolerance", SIZE, Anchor::Start));
    table::folder(out).map_err(|e| FigureError::io(out, e))?;
    let mut files = canvas.write(out, name)?.to_vec();
    let rows = bars.iter().map(|b| format!("{},{},{}\n", quoted(&b.name), table::number(b.value), table::number(b.half_width)));
    let path = out.join(format!("{name}.csv"));
    table::write(&path, format!("effect,value,half_width\n{}", rows.collect::<String>())).map_err(|e| FigureError::io(&path, e))?;
    files.push(path);
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_are_drawn_with_their_numbers_beside() {
        let dir = tempfile::tempdir().expect("folder");
        let bar = |name: &str, value, half_width| Bar { name: name.into(), value, half_width };
        let bars = [bar("law: hertz → linear", -0.3, 0.1), bar("step: 0.2 → 0.4 × law: hertz → linear", 0.02, f64::NAN)];
        let files = draw_effects("effects_k0", "difference of k_{0} (–)", &bars, 0.05, dir.path()).expect("drawn");
        assert_eq!(files.len(), 3);
        let csv = std::fs::read_to_string(&files[2]).expect("csv");
        assert!(csv.starts_with("effect,value,half_width\nlaw: hertz → linear,-0.3,0.1\n"), "{csv}");
    }
}
