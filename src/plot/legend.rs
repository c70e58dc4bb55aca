//! The legend: its size, a free place for it in the frame, and its drawing.

use super::canvas::{Canvas, Point};
use super::colour::{Colour, INK, WHITE};
use super::plot::{CURVE, Mark, Plot, symbol};
use super::text::{self, Anchor, Line};

/// Opacity of a band.
pub const BAND_ALPHA: f64 = 0.25;
const SIZE: f64 = 42.0;
const ROW: f64 = 54.0;
const SAMPLE: f64 = 128.0;
const GAP: f64 = 20.0;
/// Distance kept between the legend and the curves or the frame, page units.
const AIR: f64 = 20.0;

/// A rectangle on the page.
#[derive(Clone, Copy, Debug)]
pub struct Box2 {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Box2 {
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }

    fn holds(&self, p: &Point) -> bool {
        p.0 >= self.left && p.0 <= self.right && p.1 >= self.top && p.1 <= self.bottom
    }
}

struct Entry {
    label: String,
    colour: Colour,
    mark: Mark,
}

/// The labelled series of a plot.
#[derive(Default)]
pub struct Legend {
    title: Option<String>,
    entries: Vec<Entry>,
    size: f64,
    columns: usize,
}

impl Legend {
    pub fn of(plot: &Plot) -> Self {
        let entries: Vec<Entry> = plot
            .series
            .iter()
            .filter(|s| !s.x.is_empty())
            .filter_map(|s| Some(Entry { label: s.label.clone()?, colour: s.colour, mark: s.mark.clone() }))
            .collect();
        let title = plot.legend_title.clone().filter(|_| !entries.is_empty());
        Self { title, entries, size: SIZE, columns: 1 }
    }

    fn column_width(&self) -> f64 {
        let widest = self.entries.iter().map(|e| text::room(&e.label, self.size)).fold(0.0, f64::max);
        SAMPLE + GAP + widest
    }

    /// Width and height on the page.
    pub fn extent(&self) -> (f64, f64) {
        if self.entries.is_empty() {
            return (0.0, 0.0);
        }
        let title = self.title.as_ref().map_or(0.0, |t| text::room(t, self.size));
        let rows = self.entries.len().div_ceil(self.columns) + usize::from(self.title.is_some());
        let width = self.columns as f64 * self.column_width() + (self.columns - 1) as f64 * 2.0 * GAP;
        (width.max(title), rows as f64 * ROW)
    }

    /// Finds a place inside the frame where the legend covers no point of `ink`, and returns the
    /// legend's upper left corner there. The four corners of the frame are tried first, then a grid
    /// of places; `None` if every place covers some ink.
    pub fn place_inside(&self, inner: Box2, ink: &[Point]) -> Option<Point> {
        let (w, h) = self.extent();
        let b = inner;
        let margin = AIR + 14.0;
        let (x0, x1) = (b.left + margin, b.right - margin - w);
        let (y0, y1) = (b.top + margin, b.bottom - margin - h);
        if w == 0.0 {
            return Some((x0, y0));
        }
        if x1 < x0 || y1 < y0 {
            return None;
        }
        let free = |p: &Point| {
            let cover = Box2 { left: p.0 - AIR, top: p.1 - AIR, right: p.0 + w + AIR, bottom: p.1 + h + AIR };
            !ink.iter().any(|i| cover.holds(i))
        };
        let corners = [(x1, y0), (x0, y0), (x0, y1), (x1, y1)];
        let steps = |i: i32| f64::from(i) / 12.0;
        let grid = (0..=12).flat_map(|i| (0..=12).map(move |j| (x0 + (x1 - x0) * steps(j), y0 + (y1 - y0) * steps(i))));
        corners.into_iter().chain(grid).find(free)
    }

    /// Arranges the legend for the space above the frame, which is `room` wide: as many columns as
    /// fit, and smaller text if one column is too wide.
    pub fn outside(mut self, room: f64) -> Self {
        let width = self.column_width();
        if width > room {
            self.size *= (room - SAMPLE - GAP) / (width - SAMPLE - GAP);
        }
        let each = self.column_width() + 2.0 * GAP;
        self.columns = ((room + 2.0 * GAP) / each).floor().max(1.0) as usize;
        self
    }

    /// Draws the legend with its upper left corner at the given place.
    pub fn draw(&self, canvas: &mut Canvas, at: Point) {
        let text = |at, text: &String| Line {
            at,
            text: text.clone(),
            size: self.size,
            colour: INK,
            anchor: Anchor::Start,
            upwards: false,
        };
        let (w, h) = self.extent();
        canvas.rect((at.0 - 8.0, at.1), (at.0 + w + 8.0, at.1 + h), WHITE, 0.85);
        let mut top = at.1 + ROW / 2.0;
        if let Some(title) = &self.title {
            canvas.text(text((at.0, top), title));
            top += ROW;
        }
        let rows = self.entries.len().div_ceil(self.columns).max(1);
        for (i, entry) in self.entries.iter().enumerate() {
            let x = at.0 + (i / rows) as f64 * (self.column_width() + 2.0 * GAP);
            let y = top + (i % rows) as f64 * ROW;
            sample(canvas, entry, x, y);
            canvas.text(text((x + SAMPLE + GAP, y), &entry.label));
        }
    }
}

/// Drawn parts of a legend sample with a dash pattern, as distances from the sample's left end. A
/// curve's dashes are fixed to the page; a sample always starts with the start of the pattern.
fn drawn(dash: &[f64]) -> Vec<(f64, f64)> {
    let (mut parts, mut at) = (Vec::new(), 0.0);
    for pair in dash.chunks(2).cycle().take_while(|pair| pair.len() == 2 && pair[0] + pair[1] > 0.0) {
        if at >= SAMPLE {
            break;
        }
        parts.push((at, (at + pair[0]).min(SAMPLE)));
        at += pair[0] + pair[1];
    }
    if dash.is_empty() { vec![(0.0, SAMPLE)] } else { parts }
}

fn sample(canvas: &mut Canvas, entry: &Entry, x: f64, y: f64) {
    let line = |canvas: &mut Canvas, width: f64, dash: &[f64]| {
        for (from, to) in drawn(dash) {
            canvas.line(&[(x + from, y), (x + to, y)], entry.colour, width, &[]);
        }
    };
    match &entry.mark {
        Mark::Line(dash) => line(canvas, CURVE, dash),
        Mark::Band { dash, .. } => {
            let (a, b) = ((x, y - 17.0), (x + SAMPLE, y + 17.0));
            canvas.rect(a, b, entry.colour, BAND_ALPHA);
            line(canvas, CURVE, dash);
        }
        Mark::Guide(dash) => line(canvas, 3.0, dash),
        Mark::Symbols(shape) => symbol(canvas, *shape, (x + SAMPLE / 2.0, y), entry.colour),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn legend(labels: &[&str]) -> Legend {
        let entry = |l: &&str| Entry { label: l.to_string(), colour: INK, mark: Mark::Line(&[]) };
        Legend { title: None, entries: labels.iter().map(entry).collect(), size: SIZE, columns: 1 }
    }

    const INNER: Box2 = Box2 { left: 200.0, top: 100.0, right: 1550.0, bottom: 1050.0 };

    fn covers(l: &Legend, at: Point, p: Point) -> bool {
        let (w, h) = l.extent();
        p.0 >= at.0 && p.0 <= at.0 + w && p.1 >= at.1 && p.1 <= at.1 + h
    }

    #[test]
    fn a_sample_begins_with_its_dash_and_ends_in_time() {
        assert_eq!(drawn(&[]), [(0.0, SAMPLE)]);
        assert_eq!(drawn(&[50.0, 30.0]), [(0.0, 50.0), (80.0, SAMPLE)]);
        assert!(drawn(&[0.0, 0.0]).is_empty());
    }

    #[test]
    fn the_free_corner_is_found() {
        let l = legend(&["H-C-2, seed 1", "H-C-2, seed 2"]);
        let falling: Vec<Point> =
            (0..=200).map(|i| f64::from(i) / 200.0).map(|t| (200.0 + 1350.0 * t, 100.0 + 950.0 * t)).collect();
        let at = l.place_inside(INNER, &falling).expect("free");
        assert!(at.0 > 600.0 && at.1 < 300.0, "upper right: {at:?}");
        let rising: Vec<Point> = falling.iter().map(|p| (p.0, 1150.0 - p.1)).collect();
        let at = l.place_inside(INNER, &rising).expect("free");
        assert!(at.0 < 300.0 && at.1 < 300.0, "upper left: {at:?}");
    }

    #[test]
    fn a_full_frame_sends_it_outside() {
        let l = legend(&["a long enough label", "b"]);
        let full: Vec<Point> =
            (0..60).flat_map(|i| (0..60).map(move |j| (200.0 + 23.0 * f64::from(i), 100.0 + 16.0 * f64::from(j)))).collect();
        assert!(l.place_inside(INNER, &full).is_none());
        let all_but_a_hole: Vec<Point> =
            full.iter().copied().filter(|p| !(500.0..1200.0).contains(&p.0) || !(400.0..700.0).contains(&p.1)).collect();
        let at = l.place_inside(INNER, &all_but_a_hole).expect("the hole");
        assert!(!all_but_a_hole.iter().any(|p| covers(&l, at, *p)));
    }

    #[test]
    fn outside_it_is_never_wider_than_the_frame() {
        let long = "a very long name of a scene, with many seeds, and notes that go on and on and on";
        let l = legend(&[long, long, "c"]).outside(1350.0);
        assert!(l.extent().0 <= 1351.0 && l.columns == 1);
        let l = legend(&["a", "b", "c", "d", "e"]).outside(1350.0);
        assert!(l.columns >= 4 && l.extent().0 <= 1351.0);
    }
}
