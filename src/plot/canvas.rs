//! A drawing as a list of simple marks in units of a 1600-unit wide page, written once as SVG and once as PNG.
//! Lines and areas go through plotters' two backends; text and grains are added in the same order.

use super::balls::Balls;
use super::colour::Colour;
use super::error::{FigureError, Result};
use super::text::Line;
use plotters::backend::{BitMapBackend, DrawingBackend, SVGBackend};
use plotters::style::RGBAColor;
use std::path::Path;

/// Page width in units; 84 mm in print.
pub const WIDTH: f64 = 1600.0;
/// Page height of an 8 x 6 figure.
pub const HEIGHT: f64 = 1200.0;
/// Print width of the page, mm.
const PRINT_MM: f64 = 84.0;
/// Pixels rasterised per PNG pixel and direction; averaging them smooths the edges.
const FINE: usize = 2;

pub type Point = (f64, f64);

enum Mark {
    Line { points: Vec<Point>, colour: Colour, width: f64 },
    Area { points: Vec<Point>, colour: Colour, alpha: f64 },
    Text(Line),
    Balls(Balls),
}

/// The marks of one figure, in drawing order.
pub struct Canvas {
    height: f64,
    marks: Vec<Mark>,
}

impl Canvas {
    pub fn new(height: f64) -> Self {
        Self { height, marks: Vec::new() }
    }

    /// A line through the points, solid or with a dash pattern (drawn and skipped lengths in turn).
    pub fn line(&mut self, points: &[Point], colour: Colour, width: f64, dash: &[f64]) {
        for points in dashed(points, dash) {
            self.marks.push(Mark::Line { points, colour, width });
        }
    }

    /// A filled polygon.
    pub fn area(&mut self, points: Vec<Point>, colour: Colour, alpha: f64) {
        if points.len() > 2 {
            self.marks.push(Mark::Area { points, colour, alpha });
        }
    }

    /// A filled rectangle.
    pub fn rect(&mut self, a: Point, b: Point, colour: Colour, alpha: f64) {
        self.area(vec![a, (b.0, a.1), b, (a.0, b.1)], colour, alpha);
    }

    pub fn text(&mut self, line: Line) {
        self.marks.push(Mark::Text(line));
    }

    pub fn balls(&mut self, balls: Balls) {
        self.marks.push(Mark::Balls(balls));
    }

    /// Writes `dir/name.svg` and `dir/name.png`.
    pub fn write(&self, dir: &Path, name: &str) -> Result<[std::path::PathBuf; 2]> {
        let svg = dir.join(format!("{name}.svg"));
        table::write(&svg, self.svg(&svg)?).map_err(|e| FigureError::io(&svg, e))?;
        let png = dir.join(format!("{name}.png"));
        self.png(&png)?;
        Ok([svg, png])
    }

    fn svg(&self, path: &Path) -> Result<String> {
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{PRINT_MM}mm\" height=\"{:.2}mm\" \
             viewBox=\"0 0 {WIDTH:.0} {:.0}\" font-family=\"Noto Sans, Helvetica, Arial, sans-serif\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>\n<g stroke-linejoin=\"round\">\n",
            PRINT_MM * self.height / WIDTH,
            self.height,
        );
        for (i, mark) in self.marks.iter().enumerate() {
            match mark {
                Mark::Text(line) => out += &line.svg(),
                Mark::Balls(balls) => out += &balls.svg(i),
                shape => out += &svg_shape(shape, path)?,
            }
        }
        out += "</g>\n</svg>\n";
        Ok(out)
    }

    fn png(&self, path: &Path) -> Result<()> {
        let (w, h) = (WIDTH as usize, self.height as usize);
        let (fw, fh) = (w * FINE, h * FINE);
        let mut fine = vec![255u8; fw * fh * 3];
        for mark in &self.marks {
            match mark {
                Mark::Text(line) => {
                    let Colour(r, g, b) = line.colour;
                    line.raster(FINE as f64, |x, y, cover| {
                        if x < 0 || y < 0 || x as usize >= fw || y as usize >= fh {
                            return;
                        }
                        let at = 3 * (y as usize * fw + x as usize);
                        for (k, ink) in [r, g, b].into_iter().enumerate() {
                            let old = f64::from(fine[at + k]);
                            fine[at + k] = (old + (f64::from(ink) - old) * cover).round() as u8;
                        }
                    });
                }
                Mark::Balls(balls) => balls.raster(&mut fine, fw, fh, FINE as f64),
                shape => {
                    let mut backend = BitMapBackend::with_buffer(&mut fine, (fw as u32, fh as u32));
                    bitmap_shape(&mut backend, shape)
                        .and_then(|()| backend.present().map_err(|e| e.to_string()))
                        .map_err(|e| FigureError::draw(path, e))?;
                }
            }
        }
        let coarse = average(&fine, w, h);
        let file = table::create(path).map_err(|e| FigureError::draw(path, e))?;
        let mut encoder = png::Encoder::new(std::io::BufWriter::new(file), w as u32, h as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::Fast);
        encoder
            .write_header()
            .and_then(|mut image| image.write_image_data(&coarse).and_then(|()| image.finish()))
            .map_err(|e| FigureError::draw(path, e))
    }
}

/// Means of FINE x FINE blocks of an RGB image `w` blocks wide and `h` high.
fn average(fine: &[u8], w: usize, h: usize) -> Vec<u8> {
    const AREA: usize = FINE * FINE;
    let mut out = Vec::with_capacity(w * h * 3);
    for rows in fine.chunks_exact(3 * w * FINE * FINE) {
        for x in 0..w {
            let mut sums = [AREA / 2; 3];
            for row in rows.chunks_exact(3 * w * FINE) {
                for pixel in row[3 * x * FINE..][..3 * FINE].chunks_exact(3) {
                    sums[0] += usize::from(pixel[0]);
                    sums[1] += usize::from(pixel[1]);
                    sums[2] += usize::from(pixel[2]);
                }
            }
            out.extend(sums.map(|sum| (sum / AREA) as u8));
        }
    }
    debug_assert_eq!(out.len(), w * h * 3);
    out
}

fn rgba(colour: Colour, alpha: f64) -> RGBAColor {
    RGBAColor(colour.0, colour.1, colour.2, alpha)
}

/// A line or an area as SVG elements written by plotters, without the `<svg>` element around them.
fn svg_shape(mark: &Mark, path: &Path) -> Result<String> {
    let whole = |points: &[Point]| -> Vec<(i32, i32)> { points.iter().map(|p| (p.0.round() as i32, p.1.round() as i32)).collect() };
    let mut text = String::new();
    {
        let mut backend = SVGBackend::with_string(&mut text, (1, 1));
        match mark {
            Mark::Line { points, colour, width } => {
                let style = rgba(*colour, 1.0);
                let style =
                    plotters::style::ShapeStyle { color: style, filled: false, stroke_width: width.round().max(1.0) as u32 };
                backend.draw_path(whole(points), &style).map_err(|e| FigureError::draw(path, e))?;
            }
            Mark::Area { points, colour, alpha } => {
                backend.fill_polygon(whole(points), &rgba(*colour, *alpha)).map_err(|e| FigureError::draw(path, e))?
            }
            Mark::Text(_) | Mark::Balls(_) => {}
        }
        backend.present().map_err(|e| FigureError::draw(path, e))?;
    }
    let start = text.find('\n').map_or(0, |i| i + 1);
    let end = text.rfind("</svg>").unwrap_or(text.len());
    Ok(text.get(start..end).unwrap_or_default().to_string())
}

/// Draws a line or an area on the fine bitmap. Each segment of a line is a quadrilateral of the
/// line's width; a disc at each inner point makes the joint round.
fn bitmap_shape<B: DrawingBackend>(backend: &mut B, mark: &Mark) -> std::result::Result<(), String> {
    let zoom = FINE as f64;
    let whole = |p: Point| ((p.0 * zoom).round() as i32, (p.1 * zoom).round() as i32);
    match mark {
        Mark::Line { points, colour, width } => {
            let style = rgba(*colour, 1.0);
            for pair in points.windows(2) {
                if let Some(quad) = quadrilateral(pair[0], pair[1], *width) {
                    backend.fill_polygon(quad.map(whole), &style).map_err(|e| e.to_string())?;
                }
            }
            let radius = ((width * zoom - 1.0) / 2.0).floor().max(0.0) as u32;
            let inner = 1..points.len().saturating_sub(1);
            for p in points.get(inner).unwrap_or_default() {
                backend.draw_circle(whole(*p), radius, &style, true).map_err(|e| e.to_string())?;
            }
            Ok(())
        }
        Mark::Area { points, colour, alpha } => backend
            .fill_polygon(points.iter().map(|p| whole(*p)).collect::<Vec<_>>(), &rgba(*colour, *alpha))
            .map_err(|e| e.to_string()),
        Mark::Text(_) | Mark::Balls(_) => Ok(()),
    }
}

fn quadrilateral(a: Point, b: Point, width: f64) -> Option<[Point; 4]> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length = (dx * dx + dy * dy).sqrt();
    if length <= 0.0 || !length.is_finite() {
        return None;
    }
    let (nx, ny) = (-dy / length * width / 2.0, dx / length * width / 2.0);
    Some([(a.0 + nx, a.1 + ny), (b.0 + nx, b.1 + ny), (b.0 - nx, b.1 - ny), (a.0 - nx, a.1 - ny)])
}

/// Cuts a line into the parts that a dash pattern draws. The pattern is fixed to the page, not to
/// the line: along x in segments closer to horizontal, along y in steeper ones. So a branch that
/// runs back over an earlier one does not fill the gaps.
fn dashed(points: &[Point], dash: &[f64]) -> Vec<Vec<Point>> {
    let period: f64 = dash.iter().sum();
    if points.len() < 2 || dash.len() % 2 == 1 || dash.iter().any(|d| *d <= 0.0 || !d.is_finite()) {
        return Vec::new();
    }
    if dash.is_empty() {
        return vec![points.to_vec()];
    }
    let mut out: Vec<Vec<Point>> = Vec::new();
    for pair in points.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let flat = (b.0 - a.0).abs() >= (b.1 - a.1).abs();
        let (from, to) = if flat { (a.0, b.0) } else { (a.1, b.1) };
        let at = |t: f64| (a.0 + (b.0 - a.0) * t, a.1 + (b.1 - a.1) * t);
        for (t0, t1) in drawn(from, to, dash, period) {
            let start = at(t0);
            match out.last_mut() {
                Some(part) if t0 == 0.0 && part.last() == Some(&a) => part.push(at(t1)),
                _ => out.push(vec![start, at(t1)]),
            }
        }
    }
    out
}

/// Drawn parts of a segment whose leading page coordinate runs from `from` to `to`, as fractions
/// 0..1 along the segment.
fn drawn(from: f64, to: f64, dash: &[f64], period: f64) -> Vec<(f64, f64)> {
    let length = to - from;
    if !(length.abs() > 0.0 && length.is_finite()) {
        return Vec::new();
    }
    let mut out = Vec::new();
    let mut start = (from.min(to) / period).floor() * period;
    while start < from.max(to) {
        let mut on = start;
        for pair in dash.chunks(2) {
            let t = [on, on + pair[0]].map(|c| ((c - from) / length).clamp(0.0, 1.0));
            if t[0] != t[1] {
                out.push((t[0].min(t[1]), t[0].max(t[1])));
            }
            on += pair[0] + pair[1];
        }
        start += period;
    }
    if length < 0.0 {
        out.reverse();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::BLACK;

    fn length(parts: &[Vec<Point>]) -> f64 {
        parts.iter().flat_map(|p| p.windows(2)).map(|w| ((w[1].0 - w[0].0).powi(2) + (w[1].1 - w[0].1).powi(2)).sqrt()).sum()
    }

    #[test]
    fn dashes_run_round_corners_and_skip_their_gaps() {
        let bent = [(0.0, 0.0), (15.0, 0.0), (15.0, 75.0)];
        let parts = dashed(&bent, &[20.0, 5.0]);
        assert_eq!(parts[0], vec![(0.0, 0.0), (15.0, 0.0), (15.0, 20.0)]);
        assert_eq!(parts.len(), 3);
        assert!((length(&parts) - 75.0).abs() < 1e-9);
        assert!((length(&dashed(&bent, &[])) - 90.0).abs() < 1e-9);
        assert!(dashed(&bent[..1], &[]).is_empty());
    }

    #[test]
    fn a_retraced_line_keeps_its_gaps() {
        let there = dashed(&[(3.0, 0.0), (40.0, 10.0), (101.0, 12.0)], &[7.0, 5.0, 2.0, 5.0]);
        let back = dashed(&[(101.0, 12.0), (40.0, 10.0), (3.0, 0.0)], &[7.0, 5.0, 2.0, 5.0]);
        let ends = |parts: &[Vec<Point>]| {
            let mut x: Vec<f64> = parts.iter().flat_map(|p| [p[0].0, p[p.len() - 1].0]).map(|x| (x * 1e6).round() / 1e6).collect();
            x.sort_by(f64::total_cmp);
            x
        };
        assert_eq!(ends(&there), ends(&back));
        assert!(there.len() > 8);
    }

    #[test]
    fn both_files_show_a_line() {
        let dir = tempfile::tempdir().expect("folder");
        let mut canvas = Canvas::new(200.0);
        canvas.line(&[(100.0, 100.0), (1500.0, 100.0)], BLACK, 6.0, &[]);
        let [svg, png] = canvas.write(dir.path(), "a").expect("drawn");
        let svg = std::fs::read_to_string(svg).expect("svg");
        assert!(svg.contains("<polyline") && svg.contains("viewBox=\"0 0 1600 200\""), "{svg}");
        assert_eq!(svg.matches("<svg").count(), 1);
        assert_eq!(svg.matches("</svg>").count(), 1);
        let png = std::fs::read(png).expect("png");
        assert_eq!(&png[1..4], b"PNG");
        assert_eq!(png[16..24], [0, 0, 6, 64, 0, 0, 0, 200]);
    }
}
