//! A graph: a frame with axes, the series in the frame, and a legend that covers no series. A graph
//! is written as SVG and PNG, and the numbers drawn as CSV.

use super::axis::{Axis, Range};
use super::canvas::{Canvas, HEIGHT, Point, WIDTH};
use super::colour::{Colour, GREY, GRID, INK, WHITE};
use super::error::{FigureError, Result};
use super::legend::{self, Box2, Legend};
use super::text::{self, Anchor, Line};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Sizes in page units (19 units = 1 mm in print): text of ticks, axes and title, width of curves
/// and of the frame.
pub const TICK_SIZE: f64 = 46.0;
pub const LABEL_SIZE: f64 = 52.0;
pub const TITLE_SIZE: f64 = 37.0;
pub const CURVE: f64 = 7.0;
const FRAME: f64 = 3.0;

/// Outline of a data symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    Circle,
    Square,
    Triangle,
    Diamond,
}

impl Shape {
    pub fn nth(i: usize) -> Self {
        [Self::Circle, Self::Square, Self::Triangle, Self::Diamond][i % 4]
    }
}

/// How a series is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// A line in the order of its points, with a dash pattern.
    Line(&'static [f64]),
    /// A median line over the filled area between `low` and `high`.
    Band { low: Vec<f64>, high: Vec<f64>, dash: &'static [f64] },
    /// A thin construction line (no simulation result), with a dash pattern.
    Guide(&'static [f64]),
    /// Symbols (measurements, published numbers), never joined.
    Symbols(Shape),
}

/// One entry of the legend and its points.
#[derive(Clone, Debug)]
pub struct Series {
    /// Legend entry; `None` for a series without one, such as a later branch of a series above.
    pub label: Option<String>,
    /// Name in the CSV.
    pub name: String,
    pub colour: Colour,
    pub mark: Mark,
    pub x: Vec<f64>,
    pub y: Vec<f64>,
}

impl Series {
    pub fn line(name: &str, colour: Colour, dash: &'static [f64], points: Vec<Point>) -> Self {
        let (x, y) = points.into_iter().unzip();
        Self { label: Some(name.into()), name: name.into(), colour, mark: Mark::Line(dash), x, y }
    }
}

/// A graph that is ready to be drawn.
pub struct Plot {
    /// File name without extension.
    pub name: String,
    /// Parts of the title above the frame (scene, N, d50 ...).
    pub title: Vec<String>,
    pub legend_title: Option<String>,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
    /// Whether one unit is equally long on both axes.
    pub equal: bool,
}

/// The frame on the page and the ranges in it.
pub struct Frame {
    pub inner: Box2,
    x: Range,
    y: Range,
    downwards: bool,
}

impl Frame {
    /// Page position of a value.
    pub fn at(&self, x: f64, y: f64) -> Point {
        let v = self.y.place(y);
        let v = if self.downwards { v } else { 1.0 - v };
        (self.inner.left + self.x.place(x) * self.inner.width(), self.inner.top + v * self.inner.height())
    }
}

impl Plot {
    /// Writes `dir/name.{svg,png,csv}` and returns their paths; writes and returns nothing if no
    /// series has a point to show.
    pub fn draw(&self, dir: &Path) -> Result<Vec<PathBuf>> {
        let Some(canvas) = self.canvas() else {
            return Ok(Vec::new());
        };
        table::folder(dir).map_err(|e| FigureError::io(dir, e))?;
        let mut out = canvas.write(dir, &self.name)?.to_vec();
        let csv = dir.join(format!("{}.csv", self.name));
        table::write(&csv, self.csv()).map_err(|e| FigureError::io(&csv, e))?;
        out.push(csv);
        Ok(out)
    }

    fn canvas(&self) -> Option<Canvas> {
        let (x, y) = self.ranges()?;
        let mut canvas = Canvas::new(HEIGHT);
        let titles = self.title_lines();
        let mut frame = self.frame(x, y, 28.0 + 50.0 * titles.len() as f64);
        let mut entries = Legend::of(self);
        let inside = entries.place_inside(frame.inner, &self.ink(&frame));
        let at = inside.unwrap_or_else(|| {
            entries = std::mem::take(&mut entries).outside(frame.inner.width());
            let (w, h) = entries.extent();
            frame = self.frame(x, y, frame.inner.top + h + 14.0);
            let left = frame.inner.left + (frame.inner.width() - w).max(0.0) / 2.0;
            (left, frame.inner.top - h - 12.0)
        });
        self.draw_grid(&mut canvas, &frame);
        for series in &self.series {
            self.draw_series(&mut canvas, &frame, series);
        }
        self.draw_axes(&mut canvas, &frame);
        for (i, title) in titles.iter().enumerate() {
            canvas.text(Line {
                at: (frame.inner.left, 34.0 + 50.0 * i as f64),
                text: title.clone(),
                size: fit(title, TITLE_SIZE, WIDTH - frame.inner.left - 20.0),
                colour: INK,
                anchor: Anchor::Start,
                upwards: false,
            });
        }
        entries.draw(&mut canvas, at);
        Some(canvas)
    }

    /// The ranges of both axes; `None` if no series has a point to show.
    pub fn ranges(&self) -> Option<(Range, Range)> {
        let shown = |s: &Series, i: usize| self.x.shows(s.x[i]) && self.y.shows(s.y[i]);
        let points =
            || self.series.iter().flat_map(|s| (0..s.x.len().min(s.y.len())).map(move |i| (s, i))).filter(|(s, i)| shown(s, *i));
        points().next()?;
        let x = self.x.range(points().map(|(s, i)| s.x[i]))?;
        let y = self.y.range(points().flat_map(|(s, i)| {
            let (low, high) = match &s.mark {
                Mark::Band { low, high, .. } => (low.get(i), high.get(i)),
                _ => (None, None),
            };
            [s.y[i], low.copied().unwrap_or(s.y[i]), high.copied().unwrap_or(s.y[i])]
        }))?;
        Some((x, y))
    }

    fn frame(&self, x: Range, y: Range, top: f64) -> Frame {
        let ticks = y.ticks();
        let widest = ticks.iter().filter_map(|t| t.label.as_ref()).map(|l| text::room(l, TICK_SIZE)).fold(0.0, f64::max);
        // right of the frame: room for the half of the last x label that extends beyond the frame
        let last = x.ticks().into_iter().rev().find_map(|t| Some((x.place(t.value), t.label?)));
        let beyond = last.filter(|(place, _)| *place > 0.98).map_or(0.0, |(_, label)| text::room(&label, TICK_SIZE) / 2.0);
        let inner = Box2 {
            left: 18.0 + 1.3 * LABEL_SIZE + 18.0 + widest + 16.0,
            top: top.max(40.0),
            right: WIDTH - beyond.max(46.0),
            bottom: HEIGHT - 150.0,
        };
        let (mut x, mut y) = (x, y);
        if self.equal {
            let unit = ((x.hi - x.lo) / inner.width()).max((y.hi - y.lo) / inner.height());
            x.hi = x.lo + unit * inner.width();
            y.hi = y.lo + unit * inner.height();
        }
        Frame { inner, x, y, downwards: self.y.downwards }
    }

    /// Breaks the title into as few lines as its parts need, of about equal length.
    fn title_lines(&self) -> Vec<String> {
        const ROOM: f64 = WIDTH - 215.0;
        let parts: Vec<&str> = self.title.iter().map(String::as_str).filter(|p| !p.is_empty()).collect();
        let most = wrapped(&parts, ROOM).len();
        let narrower = (1..=12).map(|i| ROOM * f64::from(i) / 12.0);
        narrower.map(|room| wrapped(&parts, room)).find(|l| l.len() <= most).unwrap_or_default()
    }

    /// Page points that the legend must not cover, dense along lines and over bands.
    fn ink(&self, frame: &Frame) -> Vec<Point> {
        let mut out = Vec::new();
        for s in &self.series {
            let points = self.points(frame, s);
            if let Mark::Symbols(_) = s.mark {
                out.extend(points.iter().flatten());
                continue;
            }
            for part in points.split(Option::is_none) {
                let part: Vec<Point> = part.iter().copied().flatten().collect();
                out.extend(part.first());
                for w in part.windows(2) {
                    dense(w[0], w[1], &mut out);
                }
            }
            if let Mark::Band { low, high, .. } = &s.mark {
                for i in 0..s.x.len().min(low.len()).min(high.len()) {
                    if self.x.shows(s.x[i]) && self.y.shows(low[i]) && self.y.shows(high[i]) {
                        dense(frame.at(s.x[i], low[i]), frame.at(s.x[i], high[i]), &mut out);
                    }
                }
            }
        }
        out
    }

    /// Page points of a series; `None` for a point that an axis cannot show.
    fn points(&self, frame: &Frame, s: &Series) -> Vec<Option<Point>> {
        s.x.iter().zip(&s.y).map(|(x, y)| (self.x.shows(*x) && self.y.shows(*y)).then(|| frame.at(*x, *y))).collect()
    }

    fn draw_series(&self, canvas: &mut Canvas, frame: &Frame, s: &Series) {
        if let Mark::Band { low, high, .. } = &s.mark {
            let edge = |values: &[f64]| -> Vec<Point> {
                s.x.iter()
                    .zip(values)
                    .filter(|(x, y)| self.x.shows(**x) && self.y.shows(**y))
                    .map(|(x, y)| frame.at(*x, *y))
                    .collect()
            };
            let mut outline = edge(low);
            outline.extend(edge(high).into_iter().rev());
            canvas.area(outline, s.colour, legend::BAND_ALPHA);
        }
        let points = self.points(frame, s);
        for part in points.split(Option::is_none) {
            let part: Vec<Point> = part.iter().copied().flatten().collect();
            match &s.mark {
                Mark::Line(dash) | Mark::Band { dash, .. } => {
                    canvas.line(&part, s.colour, CURVE, dash);
                }
                Mark::Guide(dash) => canvas.line(&part, s.colour, FRAME, dash),
                Mark::Symbols(shape) => {
                    for p in part {
                        symbol(canvas, *shape, p, s.colour);
                    }
                }
            }
        }
    }

    fn draw_grid(&self, canvas: &mut Canvas, frame: &Frame) {
        let b = frame.inner;
        for t in frame.x.ticks().iter().filter(|t| t.label.is_some()) {
            let x = b.left + frame.x.place(t.value) * b.width();
            canvas.line(&[(x, b.top), (x, b.bottom)], GRID, 2.0, &[]);
        }
        for t in frame.y.ticks().iter().filter(|t| t.label.is_some()) {
            let y = frame.at(frame.x.lo, t.value).1;
            canvas.line(&[(b.left, y), (b.right, y)], GRID, 2.0, &[]);
        }
    }

    fn draw_axes(&self, canvas: &mut Canvas, frame: &Frame) {
        let b = frame.inner;
        let text = |at, text: String, size, anchor, upwards| Line { at, text, size, colour: INK, anchor, upwards };
        for t in frame.x.ticks() {
            let x = b.left + frame.x.place(t.value) * b.width();
            let length = if t.label.is_some() { 20.0 } else { 11.0 };
            canvas.line(&[(x, b.bottom), (x, b.bottom - length)], INK, FRAME, &[]);
            if let Some(label) = t.label {
                // the last label stays on the page
                let at = (x.min(WIDTH - 4.0 - text::room(&label, TICK_SIZE) / 2.0), b.bottom + 42.0);
                canvas.text(text(at, label, TICK_SIZE, Anchor::Middle, false));
            }
        }
        for t in frame.y.ticks() {
            let y = frame.at(frame.x.lo, t.value).1;
            let length = if t.label.is_some() { 20.0 } else { 11.0 };
            canvas.line(&[(b.left, y), (b.left + length, y)], INK, FRAME, &[]);
            if let Some(label) = t.label {
                let at = (b.left - 14.0, y);
                canvas.text(text(at, label, TICK_SIZE, Anchor::End, false));
            }
        }
        let corners =
            [(b.left, b.top), (b.right, b.top), (b.right, b.bottom), (b.left, b.bottom), (b.left, b.top), (b.left + 1.0, b.top)];
        canvas.line(&corners, INK, FRAME, &[]);
        let middle = (b.left + b.right) / 2.0;
        let size = fit(&self.x.label, LABEL_SIZE, WIDTH - 40.0);
        let at = (middle, HEIGHT - 44.0);
        canvas.text(text(at, self.x.label.clone(), size, Anchor::Middle, false));
        let size = fit(&self.y.label, LABEL_SIZE, HEIGHT - 40.0);
        let half = text::room(&self.y.label, size) / 2.0;
        let y = ((b.top + b.bottom) / 2.0).clamp(half + 10.0, (HEIGHT - half - 10.0).max(half + 10.0));
        let at = (18.0 + 0.65 * LABEL_SIZE, y);
        canvas.text(text(at, self.y.label.clone(), size, Anchor::Middle, true));
    }

    /// The numbers drawn, as CSV with a row for each point.
    fn csv(&self) -> String {
        let banded = self.series.iter().any(|s| matches!(s.mark, Mark::Band { .. }));
        let mut out = format!("series,kind,{},{}", self.x.column, self.y.column);
        if banded {
            let _ = write!(out, ",low_{0},high_{0}", self.y.column);
        }
        out.push('\n');
        for s in &self.series {
            let kind = match s.mark {
                Mark::Line(_) => "line",
                Mark::Band { .. } => "band",
                Mark::Guide(_) => "guide",
                Mark::Symbols(_) => "data",
            };
            let name = quoted(&s.name);
            for (i, (x, y)) in s.x.iter().zip(&s.y).enumerate() {
                if !(self.x.shows(*x) && self.y.shows(*y)) {
                    continue;
                }
                let _ = write!(out, "{name},{kind},{x},{y}");
                if let Mark::Band { low, high, .. } = &s.mark {
                    let value = |v: &[f64]| v.get(i).copied().unwrap_or(f64::NAN);
                    let _ = write!(out, ",{},{}", value(low), value(high));
                } else if banded {
                    out.push_str(",,");
                }
                out.push('\n');
            }
        }
        out
    }
}

/// Joins parts into lines that fit the width `room`; a part is never cut, even if it is wider.
fn wrapped(parts: &[&str], room: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for part in parts {
        match lines.last_mut() {
            Some(last) if text::room(&format!("{last} · {part}"), TITLE_SIZE) <= room => {
                *last += &format!(" · {part}");
            }
            _ => lines.push((*part).to_string()),
        }
    }
    lines
}

/// A CSV field, quoted where its text needs it.
pub fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

/// The given size, or a smaller one with which the text fits into the room.
pub fn fit(text: &str, size: f64, room: f64) -> f64 {
    let width = text::room(text, size);
    if width > room && width > 0.0 { size * room / width } else { size }
}

fn dense(a: Point, b: Point, out: &mut Vec<Point>) {
    let length = ((b.0 - a.0).powi(2) + (b.1 - a.1).powi(2)).sqrt();
    let n = (length / 8.0).ceil().clamp(1.0, 1000.0) as usize;
    for i in 1..=n {
        let t = i as f64 / n as f64;
        out.push((a.0 + (b.0 - a.0) * t, a.1 + (b.1 - a.1) * t));
    }
}

/// A white-filled data symbol with a coloured outline.
pub fn symbol(canvas: &mut Canvas, shape: Shape, at: Point, colour: Colour) {
    const R: f64 = 15.0;
    let corners: Vec<Point> = match shape {
        Shape::Circle => (0..24).map(|i| f64::from(i) * std::f64::consts::TAU / 24.0).map(|a| (R * a.cos(), R * a.sin())).collect(),
        Shape::Square => {
            vec![(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)].into_iter().map(|(x, y)| (R * x, R * y)).collect()
        }
        Shape::Triangle => vec![(0.0, -1.25 * R), (1.15 * R, 0.8 * R), (-1.15 * R, 0.8 * R)],
        Shape::Diamond => vec![(0.0, -1.3 * R), (1.3 * R, 0.0), (0.0, 1.3 * R), (-1.3 * R, 0.0)],
    };
    let mut corners: Vec<Point> = corners.into_iter().map(|(x, y)| (at.0 + x, at.1 + y)).collect();
    canvas.area(corners.clone(), WHITE, 1.0);
    corners.extend_from_within(..2);
    canvas.line(&corners, colour, 5.0, &[]);
}

/// A straight line from the origin to the abscissa `to`, for ratios such as K0 in the q-p plane.
pub fn ray(name: &str, slope: f64, to: f64) -> Series {
    Series {
        label: Some(name.into()),
        name: name.into(),
        colour: GREY,
        mark: Mark::Guide(&[]),
        x: vec![0.0, to],
        y: vec![0.0, slope * to],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(series: Vec<Series>) -> Plot {
        Plot {
            name: "a".into(),
            title: vec!["H-C-2".into()],
            legend_title: None,
            x: Axis::log("σ_{v} (MPa)", "sigma_v_MPa"),
            y: Axis::linear("n", "porosity"),
            series,
            equal: false,
        }
    }

    fn line(points: &[Point]) -> Series {
        Series::line("H-C-2, seed 1", INK, &[], points.to_vec())
    }

    #[test]
    fn every_point_lies_inside_the_frame() {
        let p = plot(vec![line(&[(0.005, 0.42), (5.0, 0.27), (0.1, 0.29)])]);
        let (x, y) = p.ranges().expect("ranges");
        let frame = p.frame(x, y, 100.0);
        for (x, y) in [(0.005, 0.42), (5.0, 0.27), (0.1, 0.29)] {
            let at = frame.at(x, y);
            assert!(at.0 > frame.inner.left && at.0 < frame.inner.right);
            assert!(at.1 > frame.inner.top && at.1 < frame.inner.bottom);
        }
        assert!(frame.at(0.1, 0.3).1 > frame.at(0.1, 0.4).1);
    }

    #[test]
    fn strains_run_downwards() {
        let mut p = plot(vec![line(&[(0.005, 0.0), (5.0, 20.0)])]);
        p.y = p.y.downwards();
        let (x, y) = p.ranges().expect("ranges");
        let frame = p.frame(x, y, 100.0);
        assert!(frame.at(1.0, 10.0).1 > frame.at(1.0, 5.0).1);
    }

    #[test]
    fn equal_scales_are_equal() {
        let mut p = plot(vec![line(&[(0.1, 0.0), (3.7, 2.0)])]);
        p.x = Axis::linear("p", "p");
        p.equal = true;
        let (x, y) = p.ranges().expect("ranges");
        let frame = p.frame(x, y, 100.0);
        let (o, e) = (frame.at(0.0, 0.0), frame.at(1.0, 1.0));
        assert!(((e.0 - o.0) - (o.1 - e.1)).abs() < 1e-9);
        assert!(frame.at(3.7, 2.0).0 < frame.inner.right);
    }

    #[test]
    fn titles_are_broken_into_even_lines() {
        let parts = ["H-C-2, seed 1", "N = 2", "d = 7.07 mm", "680 → 18 984 grains", "1408 events and more"];
        let mut p = plot(Vec::new());
        p.title = parts.iter().map(|t| t.to_string()).collect();
        let lines = p.title_lines();
        assert_eq!(lines.len(), 2);
        assert!(lines.iter().all(|l| l.contains(" · ")), "{lines:?}");
        p.title.truncate(2);
        assert_eq!(p.title_lines(), ["H-C-2, seed 1 · N = 2"]);
    }

    #[test]
    fn odd_series_draw_nothing_or_what_they_can() {
        let dir = tempfile::tempdir().expect("folder");
        assert!(plot(Vec::new()).draw(dir.path()).expect("ok").is_empty());
        let empty = plot(vec![line(&[]), line(&[(0.0, 1.0), (f64::NAN, 2.0)])]);
        assert!(empty.draw(dir.path()).expect("ok").is_empty());
        let one = plot(vec![line(&[(1.0, 0.4)])]);
        assert_eq!(one.draw(dir.path()).expect("ok").len(), 3);
        let csv = std::fs::read_to_string(dir.path().join("a.csv")).expect("csv");
        assert_eq!(csv, "series,kind,sigma_v_MPa,porosity\n\"H-C-2, seed 1\",line,1,0.4\n");
    }
}
