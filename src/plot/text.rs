//! Text with subscripts and superscripts (`σ_{v}`, `10^{-3}`), measured and rasterised with an embedded typeface so
//! that a machine without fonts draws the same picture.

use super::colour::Colour;
use ab_glyph::{Font, FontRef, Glyph, OutlinedGlyph, PxScale, point};
use std::sync::LazyLock;

static TYPEFACE: LazyLock<Option<FontRef<'static>>> = LazyLock::new(|| FontRef::try_from_slice(notosans::REGULAR_TTF).ok());

/// Size of sub- and superscripts over the size of the line.
const SCRIPT: f64 = 0.72;
/// Shift of the baseline of a subscript and of a superscript, in sizes of the line, positive
/// downwards.
const SUB: f64 = 0.17;
const SUPER: f64 = -0.34;
/// Distance of the baseline below the point on which a line is centred, in sizes of the line: about
/// half the height of capitals and digits.
const MIDDLE: f64 = 0.35;

/// Which point of a line of text stands at [`Line::at`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// One line of text centred in height on `at`; `upwards` turns it to read from bottom to top.
#[derive(Clone, Debug)]
pub struct Line {
    pub at: (f64, f64),
    pub text: String,
    pub size: f64,
    pub colour: Colour,
    pub anchor: Anchor,
    pub upwards: bool,
}

/// A piece of a line with one size and one baseline. `shift` is the baseline's shift, in sizes of
/// the line, positive downwards; `scale` is the size over that of the line.
#[derive(Debug, PartialEq)]
struct Piece<'a> {
    text: &'a str,
    shift: f64,
    scale: f64,
}

fn pieces(text: &str) -> Vec<Piece<'_>> {
    let mut out = Vec::new();
    let mut push = |text, shift, scale| {
        let piece = Piece { text, shift, scale };
        if !piece.text.is_empty() {
            out.push(piece);
        }
    };
    let mut rest = text;
    while let Some((start, end)) = first_script(rest) {
        push(&rest[..start], 0.0, 1.0);
        let below = rest[start..].starts_with('_');
        push(&rest[start + 2..end], if below { SUB } else { SUPER }, SCRIPT);
        rest = &rest[end + 1..];
    }
    push(rest, 0.0, 1.0);
    out
}

/// Where the first `_{…}` or `^{…}` starts and where its brace closes.
fn first_script(text: &str) -> Option<(usize, usize)> {
    let start = [text.find("_{"), text.find("^{")].into_iter().flatten().min()?;
    Some((start, start + text[start..].find('}')?))
}

/// Width of a line at a size (em), in the same units.
pub fn width(text: &str, size: f64) -> f64 {
    pieces(text).iter().map(|p| run(p.text, size * p.scale, |_, _| ())).sum()
}

/// Width that a layout reserves for a line: 1.15 times the width in the embedded typeface, because
/// an SVG may be shown in a wider sans-serif typeface.
pub fn room(text: &str, size: f64) -> f64 {
    1.15 * width(text, size)
}

/// Calls `each` with every character and its pen position; returns the width of the text. Without a
/// typeface the width is an estimate, and `each` is not called.
fn run(text: &str, size: f64, mut each: impl FnMut(char, f64)) -> f64 {
    let Some(font) = TYPEFACE.as_ref() else {
        return 0.55 * size * text.chars().count() as f64;
    };
    let unit = size / f64::from(font.units_per_em().unwrap_or(1000.0));
    let mut pen = 0.0;
    let mut last = None;
    for c in text.chars() {
        let id = font.glyph_id(c);
        if let Some(last) = last {
            pen += f64::from(font.kern_unscaled(last, id)) * unit;
        }
        each(c, pen);
        pen += f64::from(font.h_advance_unscaled(id)) * unit;
        last = Some(id);
    }
    pen
}

impl Line {
    /// The line as an SVG element in generic sans-serif.
    pub fn svg(&self) -> String {
        let anchor = match self.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (x, y) = self.at;
        let Colour(r, g, b) = self.colour;
        let turn = if self.upwards { format!(" transform=\"rotate(-90 {x:.1} {y:.1})\"") } else { String::new() };
        let base = y + MIDDLE * self.size;
        let mut body = String::new();
        let mut shift = 0.0;
        for p in pieces(&self.text) {
            let move_by = (p.shift - shift) / p.scale;
            shift = p.shift;
            let text = escape(p.text);
            if move_by == 0.0 && p.scale == 1.0 {
                body += &text;
            } else if p.scale == 1.0 {
                body += &format!("<tspan dy=\"{move_by:.3}em\">{text}</tspan>");
            } else {
                body += &format!("<tspan dy=\"{move_by:.3}em\" font-size=\"{:.1}\">{text}</tspan>", self.size * p.scale);
            }
        }
        format!(
            "<text x=\"{x:.1}\" y=\"{base:.1}\" text-anchor=\"{anchor}\" font-size=\"{:.1}\" \
             fill=\"#{r:02X}{g:02X}{b:02X}\"{turn} xml:space=\"preserve\">{body}</text>\n",
            self.size
        )
    }

    /// Draws the line at `zoom` pixels a unit by calling `pixel(x, y, coverage)`.
    pub fn raster(&self, zoom: f64, mut pixel: impl FnMut(i64, i64, f64)) {
        let size = self.size * zoom;
        let along = match self.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -0.5,
            Anchor::End => -1.0,
        } * width(&self.text, size);
        let (x, y) = (self.at.0 * zoom, self.at.1 * zoom);
        let mut pen = along;
        for p in pieces(&self.text) {
            let base = MIDDLE * size + p.shift * size;
            let mut glyphs = Vec::new();
            let advance = run(p.text, size * p.scale, |c, at| glyphs.push((c, pen + at)));
            for (c, at) in glyphs {
                let Some(glyph) = outline(c, size * p.scale) else {
                    continue;
                };
                // The glyph is rasterised at the origin of an unturned line; its pixels are then
                // moved to the pen position, turned for an upward line, and rounded to whole
                // pixels.
                let (whole, bounds) = (at, glyph.px_bounds());
                glyph.draw(|gx, gy, cover| {
                    let u = whole + f64::from(bounds.min.x) + f64::from(gx);
                    let v = base + f64::from(bounds.min.y) + f64::from(gy);
                    let (px, py) = if self.upwards { (x + v, y - u - 1.0) } else { (x + u, y + v) };
                    pixel(px.round() as i64, py.round() as i64, f64::from(cover));
                });
            }
            pen += advance;
        }
    }
}

fn outline(c: char, size: f64) -> Option<OutlinedGlyph> {
    let font = TYPEFACE.as_ref()?;
    let em = font.units_per_em().unwrap_or(1000.0);
    let scale = PxScale::from(size as f32 * font.height_unscaled() / em);
    let glyph: Glyph = font.glyph_id(c).with_scale_and_position(scale, point(0.0, 0.0));
    font.outline_glyph(glyph)
}

/// Escapes text for XML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(text: &str) -> Vec<(String, f64)> {
        pieces(text).iter().map(|p| (p.text.to_string(), p.shift)).collect()
    }

    #[test]
    fn scripts_are_split_in_order() {
        let want = [("σ", 0.0), ("v", SUB), (" (m", 0.0), ("2", SUPER), (")", 0.0)];
        let want: Vec<(String, f64)> = want.iter().map(|(t, s)| (t.to_string(), *s)).collect();
        assert_eq!(plain("σ_{v} (m^{2})"), want);
    }

    #[test]
    fn underscores_in_names_and_open_braces_stay_text() {
        assert_eq!(plain("run_a_{"), vec![("run_a_{".to_string(), 0.0)]);
        assert_eq!(plain(""), vec![]);
    }

    /// PNG files show a box where the typeface lacks a sign that a reader of the SVG still sees.
    #[test]
    fn the_typeface_has_every_sign_of_the_committed_figures() {
        let font = TYPEFACE.as_ref().expect("a typeface");
        let mut folders = vec![std::path::PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../figures"))];
        let mut seen = 0;
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(&folder).expect("a folder") {
                let path = entry.expect("an entry").path();
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|e| e == "svg") {
                    seen += 1;
                    let text = std::fs::read_to_string(&path).expect("text");
                    let missing: Vec<char> = text.chars().filter(|c| !c.is_ascii() && font.glyph_id(*c).0 == 0).collect();
                    assert!(missing.is_empty(), "{}: {missing:?}", path.display());
                }
            }
        }
        assert!(seen > 50, "{seen} figures");
    }

    #[test]
    fn width_scales_and_scripts_are_narrower() {
        let w = width("porosity", 10.0);
        assert!((width("porosity", 20.0) - 2.0 * w).abs() < 1e-9);
        assert!(width("σ_{v}", 10.0) < width("σv", 10.0));
        assert!((20.0..70.0).contains(&w), "{w}");
    }

    #[test]
    fn raster_puts_ink_where_the_anchor_says() {
        let line = Line {
            at: (100.0, 50.0),
            text: "100".into(),
            size: 20.0,
            colour: super::super::colour::BLACK,
            anchor: Anchor::End,
            upwards: false,
        };
        let (mut lo, mut hi, mut top, mut low) = (i64::MAX, i64::MIN, i64::MAX, i64::MIN);
        line.raster(1.0, |x, y, cover| {
            if cover > 0.3 {
                (lo, hi) = (lo.min(x), hi.max(x));
                (top, low) = (top.min(y), low.max(y));
            }
        });
        assert!(hi <= 101 && hi > 94, "{hi}");
        assert!(lo < 75, "{lo}");
        assert!((top + low - 100).abs() <= 3, "centred in height: {top} {low}");
    }
}
